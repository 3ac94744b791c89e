"""The file of a virtual rig: what it means, and what is wrong with it, each at its line."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.measurements.writing import signal_name
from multilayer.rig.file import load_rig
from tests.rig.virtual import DATA, LAW, rig_file

TEXT = """\
version: 1
rig: two-plate
seed: 7
sampling_rate: 25600 Hz
specimen:
  density: 80 kg/m^3
  poisson_ratio: 0.3
  young_modulus: {law: loss_factor, young_modulus: 200 kPa, loss_factor: 0.2}
burst: {cycles: 10, window: hann, level_rms: 5 m/s^2}
frequencies: {from: 100 Hz, to: 1500 Hz, step: 100 Hz}
configurations:
  thicknesses: [12.5 mm, 25 mm]
  top_plates: [1 mm, 3 mm]
  radii: [22.5 mm, 12 mm]
repeats: 3
noise: {white: 0.004, pink: 0, hum: {frequency: 50 Hz, level: 0.01 m/s^2}, base: 0.004, bits: 24, full_scale: 500}
uncertainty: {channel_gain: 0.003, channel_delay: 1 us, thickness: 0.05 mm}
effects:
  - {effect: sensor_mass, mass: 1 g, radius: 0 mm}
  - {effect: channel_gain, gain: 0.02}
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(TEXT)
    return path


def line_of(text, part):
    before, found, _ = text.partition(part)
    assert found, part
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


class TestMeaning:
    def test_units_and_order(self, file):
        settings = load_rig(file)
        assert [m.name for m in settings.mountings] == [
            "h12.5mm-t1mm",
            "h12.5mm-t3mm",
            "h25mm-t1mm",
            "h25mm-t3mm",
            "h12.5mm-t1mm-r12mm",
            "h12.5mm-t3mm-r12mm",
            "h25mm-t1mm-r12mm",
            "h25mm-t3mm-r12mm",
        ]
        assert settings.burst_frequencies == tuple(100.0 * i for i in range(1, 16))
        mass, gain = settings.effects
        assert (mass.effect, mass.mass, gain.gain) == ("sensor_mass", 0.001, 0.02)
        assert settings.uncertainty.channel_delay == pytest.approx(1e-6)
        assert (settings.top_plate.density, settings.base_plate.thickness) == (7850, 0.01)

    def test_a_list_of_configurations(self):
        listed = [{"thickness": "20 mm", "top_plate": "1 mm"}, {"thickness": 0.02, "top_plate": 1e-3, "name": "again"}]
        assert [m.name for m in rig_file(configurations=listed).mountings] == ["h20mm-t1mm", "again"]

    def test_steps_end_at_or_below_the_last(self):
        found = rig_file(frequencies={"from": 100, "to": 399, "step": 100}).burst_frequencies
        assert found == (100, 200, 300)
        assert rig_file(frequencies={"from": 0.1, "to": 0.3, "step": 0.1}).burst_frequencies == (0.1, 0.2, 0.3)

    def test_poisson_ratio_is_that_of_a_rod_without_finite_size(self):
        assert rig_file().poisson_ratio == 0
        assert rig_file("finite_size").poisson_ratio == 0.3

    def test_a_table_is_held_beyond_its_ends(self):
        table = {"law": "table", "frequency": [100, 1000], "storage_modulus": [1e5, 2e5], "loss_modulus": [2e4, 5e4]}
        specimen = rig_file(specimen={"density": 80, "young_modulus": table}).specimen
        assert np.allclose(specimen.modulus([10, 100, 1000, 5000]), [1e5 + 2e4j] * 2 + [2e5 + 5e4j] * 2)

    def test_a_file_survives_a_round_trip(self, file):
        settings = load_rig(file)
        again = type(settings).model_validate(settings.model_dump(mode="json", by_alias=True, exclude_none=True))
        assert again == settings

    @pytest.mark.parametrize(
        ("frequency", "digits"), [(100, "0100"), (1500, "1500"), (62.5, "0062.5"), (12000, "12000")]
    )
    def test_file_names(self, frequency, digits):
        assert signal_name("h25mm-t1mm", float(frequency)) == f"signals/h25mm-t1mm_{digits}Hz.npz"


# what is replaced in the file by what, where it is told, and how
MISTAKES = {
    "unknown effect": (
        "effect: channel_gain",
        "effect: chanel_gain",
        "chanel_gain",
        "effects.1.effect: there is no effect 'chanel_gain'; did you mean 'channel_gain'?",
    ),
    "an effect as text": (
        "{effect: channel_gain, gain: 0.02}",
        "channel_gain # alone",
        "channel_gain # alone",
        "effects.1: must be a mapping of fields, not 'channel_gain'; write {effect: channel_gain}",
    ),
    "an effect without a name": ("effect: channel_gain, gain", "gain", "{gain", "effects.1: has no 'effect'; allowed:"),
    "unknown field of an effect": (
        "mass: 1 g",
        "mas: 1 g",
        "mas:",
        "effects.0.mas: there is no such field; did you mean 'mass'?",
    ),
    "an effect twice": (
        "{effect: channel_gain, gain: 0.02}",
        "{effect: sensor_mass}",
        "sensor_mass}",
        "effects.1.effect: 'sensor_mass' is listed twice; keep one of the two",
    ),
    "unphysical effect": ("mass: 1 g", "mass: -1 g", "-1 g", "effects.0.mass: -0.001 is not allowed: it must be at"),
    "too large a perturbation": (
        "gain: 0.02",
        "perturbation: 2.0",
        "2.0}",
        "effects.1.perturbation: 2.0 is not allowed: it must be at most 0.5",
    ),
    "sensor off the plate": (
        "radius: 0 mm}",
        "radius: 10 mm}",
        "10 mm}",
        "effects.0.radius: 10 mm puts the accelerometer off the plate of radius 12 mm; with its footprint of 3 mm it "
        "must be at most 9 mm",
    ),
    "glue thicker than the sample": (
        "channel_gain, gain: 0.02",
        "adhesive, thickness: 7 mm",
        "7 mm",
        "effects.1.thickness: 7 mm of glue at both faces are not thinner than the thinnest sample, 12.5 mm",
    ),
    "skin without a core": (
        "channel_gain, gain: 0.02",
        "skin, thickness: 7 mm",
        "7 mm",
        "effects.1.thickness: 7 mm of skin at both faces leave no core in 12.5 mm; make it thinner",
    ),
    "delamination elsewhere": (
        "channel_gain, gain: 0.02",
        "delamination, configurations: [h25mm-t2mm]",
        "h25mm-t2mm",
        "effects.1.configurations.0: there is no configuration 'h25mm-t2mm'; did you mean 'h25mm-t",
    ),
    "drift twice": (
        "channel_gain, gain: 0.02",
        "temperature_drift, total: 0.1, rate: 0.01",
        "0.01}",
        "effects.1.rate: rate stands beside total; give one of the two",
    ),
    "too much drift": (
        "channel_gain, gain: 0.02",
        "temperature_drift, rate: -0.01",
        "-0.01",
        "effects.1.rate: -0.01 per burst is a change by -1.2 over 120 bursts; make it smaller",
    ),
    "dispersion of a constant": (
        "channel_gain, gain: 0.02",
        "dispersion",
        "{effect: dispersion",
        "effects.1: dispersion needs a young_modulus that varies with frequency",
    ),
    "anisotropy of a rod": (
        "channel_gain, gain: 0.02",
        "anisotropy",
        "anisotropy",
        "effects.1.effect: anisotropy shows through Poisson's ratio only; list {effect: finite_size} too",
    ),
    "a field that no effect takes": (
        "poisson_ratio: 0.3",
        "flow_resistivity: 20 kN s/m^4",
        "20 kN",
        "specimen.flow_resistivity: does nothing without the effect that takes it; list {effect: saturating_air}",
    ),
    "above half the sampling rate": (
        "to: 1500 Hz",
        "to: 12.8 kHz",
        "12.8 kHz",
        "frequencies.to: 12800 Hz is not below half of the sampling_rate of 25600 Hz",
    ),
    "one frequency above it": (
        "{from: 100 Hz, to: 1500 Hz, step: 100 Hz}",
        "[100 Hz, 13 kHz]",
        "13 kHz",
        "frequencies.1: 13000 Hz is not below half of the sampling_rate of 25600 Hz",
    ),
    "a frequency twice": (
        "{from: 100 Hz, to: 1500 Hz, step: 100 Hz}",
        "[100 Hz, 100]",
        "100]",
        "frequencies.1: 100 Hz is there twice; each burst must have another frequency",
    ),
    "frequencies downwards": (
        "to: 1500 Hz",
        "to: 50 Hz",
        "50 Hz",
        "frequencies.to: 50 Hz is not allowed: it must be at least 'from', 100 Hz",
    ),
    "too many frequencies": ("step: 100 Hz", "step: 1 Hz", "1 Hz}", "frequencies.step: 1 Hz would make more than 200"),
    "an unknown step": (
        "step: 100 Hz",
        "stepp: 100 Hz",
        "stepp",
        "frequencies.stepp: there is no such field; did you mean 'step'?",
    ),
    "negative noise": ("white: 0.004", "white: -0.004", "-0.004", "noise.white: -0.004 is not allowed: it must be"),
    "a converter of one bit": ("bits: 24", "bits: 1", "1, full", "noise.bits: 1 is not allowed: it must be at least 4"),
    "careless laboratory": (
        "thickness: 0.05 mm",
        "thickness: 2 mm",
        "2 mm}",
        "uncertainty.thickness: 0.002 is not allowed: errors are drawn with this standard deviation, at most 0.00125",
    ),
    "half a cycle": ("cycles: 10", "cycles: 0.5", "0.5", "burst.cycles: 0.5 is not allowed: a burst of less than 3"),
    "no repeats": ("repeats: 3", "repeats: 0", "0\nnoise", "repeats: 0 is not allowed: it must be at least 1"),
    "no loss": (
        "loss_factor: 0.2",
        "loss_factor: 0",
        "{law",
        "specimen.young_modulus: a sample of so little loss rings for inf s after a burst, more than 3 s; give it a",
    ),
    "a configuration twice": (
        "[12.5 mm, 25 mm]",
        "[25 mm, 25 mm]",
        "thicknesses",
        "configurations: two configurations are called 'h25mm-t1mm'; list them one by one, each with its own 'name'",
    ),
    "another rig": ("rig: two-plate", "rig: tube", "tube", "rig: 'tube' is not allowed; allowed: 'two-plate'"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistake(file, case):
    old, new, at, words = MISTAKES[case]
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_rig(file)
    told = [str(problem) for problem in caught.value.problems]
    assert any(one.startswith(f"{file}:{line_of(text, at)}: {words}") for one in told), told


def test_mistakes_of_several_effects_at_once():
    effects = [
        {"effect": "adhesive", "thickness": 0.01},
        {"effect": "finite_size"},
        {"effect": "sensor_mass", "radius": 1},
    ]
    specimen = {**DATA["specimen"], "poisson_ratio": 0, "young_modulus": LAW}
    with pytest.raises(ValueError, match="3 validation errors") as caught:
        rig_file(*effects, specimen=specimen, configurations={"thicknesses": [0.01], "top_plates": [1e-3]})
    text = str(caught.value)
    assert all(words in text for words in ("not thinner than", "needs a specimen.poisson_ratio", "off the plate"))

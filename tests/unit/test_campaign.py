"""Campaigns: the format, its mistakes with file and line, and recordings checked before anything is computed."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from multilayer.errors import InputError, PlausibilityWarning
from multilayer.measurements.campaign import (
    load_calibration,
    load_campaign,
    load_recordings,
    read_burst,
)
from multilayer.rig.noise import pink_noise
from multilayer.signals.bursts import hann_burst
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum

RATE = 25600.0
CAMPAIGNS = Path(__file__).parents[2] / ".." / "shared" / "campaigns"
FOLDERS = sorted(file.parent for file in CAMPAIGNS.rglob("campaign.yaml"))

HEAD = """\
version: 1
rig: shaker-two-plate
sampling_rate: 25600
specimen:
  density: 94 kg/m^3
  poisson_ratio: 0.1
top_plate: {density: 7850, young_modulus: 210 GPa, poisson_ratio: 0.3}
base_plate: {density: 2700, young_modulus: 7.0e+10, poisson_ratio: 0.33, thickness: 10 mm}
uncertainty:
  channel_delay: 1 us
burst: {cycles: 10, window: hann, level_rms: 5.0}
configurations:
"""
CONFIGURATION = """\
  - name: NAME
    specimen_thickness: 25 mm
    top_plate_thickness: 0.001
    specimen_radius: 0.0225
    bursts:
      - {frequency: 300, file: signals/NAME_300.npz}
      - {frequency: 500 Hz, file: signals/NAME_500.csv}
      - {frequency: 700, file: signals/NAME_700.npz}
"""
TEXT = HEAD + CONFIGURATION.replace("NAME", "thin") + CONFIGURATION.replace("NAME", "thick")
CALIBRATION = """\
version: 1
rig: calibration
sampling_rate: 25.6 kHz
burst: {cycles: 10, level_rms: 5.0}
bursts:
  - {frequency: 300, file: 300.npz}
  - {frequency: 700, file: 700.npz}
"""


def signals(frequency, resonance=450.0, seed=0):
    """Return base and top, (2, samples), of a damped mass on a spring, with a little noise."""
    rng = np.random.default_rng([int(frequency), seed])
    base = hann_burst(frequency, 10, RATE, n_samples=4000, start=0.002)
    n_fft = padded_length(4000, 4)
    ratio = frequencies(n_fft, RATE) / resonance
    top = to_signal(to_spectrum(base, n_fft) / (1 - ratio**2 + 0.2j * ratio), n_fft, 4000)
    return tuple(signal + 0.01 * rng.normal(size=(2, 4000)) for signal in (base, top))


def write_csv(path, base, top, rate=RATE):
    columns = np.column_stack([np.arange(base.shape[1]) / rate, base[0], top[0], base[1], top[1]])
    np.savetxt(path, columns, delimiter=",", header="time,base_1,top_1,base_2,top_2", comments="", fmt="%.9g")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "signals").mkdir()
    (tmp_path / "campaign.yaml").write_text(TEXT)
    for seed, name in enumerate(("thin", "thick")):
        for frequency in (300, 700):
            base, top = signals(frequency, seed=seed)
            np.savez(tmp_path / f"signals/{name}_{frequency}.npz", base=base, top=top)
        write_csv(tmp_path / f"signals/{name}_500.csv", *signals(500, seed=seed))
    return tmp_path


def rewrite(folder, old, new, file="campaign.yaml", count=-1):
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, count))


def problems_of(call, *arguments):
    with pytest.raises(InputError) as caught:
        call(*arguments)
    return caught.value.problems


class TestDescription:
    def test_what_is_written_is_read(self, folder):
        campaign = load_campaign(folder)
        assert campaign.folder == folder
        assert campaign.file == folder / "campaign.yaml"
        assert campaign.sampling_rate == RATE
        assert campaign.specimen.density == 94.0
        assert campaign.top_plate.young_modulus == pytest.approx(210e9)
        assert campaign.base_plate.thickness == pytest.approx(0.01)
        assert campaign.uncertainty.channel_delay == pytest.approx(1e-6)
        assert campaign.uncertainty.channel_gain == 0.0
        assert [mounting.name for mounting in campaign.configurations] == ["thin", "thick"]
        assert [burst.frequency for burst in campaign.configuration("thin").bursts] == [300.0, 500.0, 700.0]
        assert load_campaign(folder / "campaign.yaml") == campaign

    def test_the_uncertainty_is_optional(self, folder):
        rewrite(folder, "uncertainty:\n  channel_delay: 1 us\n", "")
        assert load_campaign(folder).uncertainty.thickness == 0.0

    def test_a_configuration_nobody_wrote(self, folder):
        with pytest.raises(InputError, match="no configuration 'thinn'; there are: thin, thick"):
            load_campaign(folder).configuration("thinn")

    @pytest.mark.parametrize(
        ("old", "new", "line", "message"),
        [
            ("specimen_thickness: 25 mm", "specimen_thickness: -0.025", 14, "must be above 0"),
            ("poisson_ratio: 0.1", "poisson_ratio: 0.5", 6, "0.5 is not allowed: it must be below 0.5"),
            ("density: 94 kg/m^3", "density: 0", 5, "must be above 0"),
            ("thickness: 10 mm", "thickness: 10 kg", 8, "wrong unit"),
            ("channel_delay: 1 us", "channel_delay: -1 us", 10, "must be at least 0"),
            ("channel_delay: 1 us", "gain: 0.01", 10, "no such field"),
            ("window: hann", "window: flat", 11, "allowed: 'hann'"),
            ("cycles: 10", "cycles: 0", 11, "must be above 0"),
            ("version: 1", "version: 2", 1, "allowed: 1"),
            ("rig: shaker-two-plate", "rig: tube", 2, "allowed: 'shaker-two-plate'"),
            ("name: thick", "name: thin", 21, "'thin' is there twice"),
            ("name: thick", "name: ''", 21, "must not be empty"),
            ("frequency: 500 Hz", "frequency: 300", 19, "300 Hz is there twice"),
            ("frequency: 500 Hz", "frequency: 12.8 kHz", 19, "not below half of the sampling_rate"),
            ("signals/thin_500.csv", "signals/thin_300.npz", 19, "the recording of configurations.0.bursts.0 as well"),
            (
                "signals/thick_300.npz",
                "signals/./thin_300.npz",
                26,
                "the recording of configurations.0.bursts.0 as well",
            ),
            ("signals/thin_300.npz", "/data/thin_300.npz", 18, "leads out of the campaign's folder"),
            ("signals/thin_300.npz", "../thin_300.npz", 18, "leads out of the campaign's folder"),
            ("signals/thin_300.npz", "signals/../../thin_300.npz", 18, "leads out of the campaign's folder"),
            ("signals/thin_300.npz", "'C:\\data\\thin_300.npz'", 18, "leads out of the campaign's folder"),
            ("signals/thin_300.npz", "signals\\..\\..\\x.npz", 18, "leads out of the campaign's folder"),
            ("signals/thin_300.npz", "''", 18, "name of a file is missing"),
        ],
    )
    def test_mistakes_at_their_line(self, folder, old, new, line, message):
        rewrite(folder, old, new, count=1)
        (problem,) = problems_of(load_campaign, folder)
        assert (problem.file, problem.line) == (folder / "campaign.yaml", line)
        assert message in problem.message

    def test_all_mistakes_at_once(self, folder):
        rewrite(folder, "poisson_ratio: 0.1", "poisson_ratio: 0.5")
        rewrite(folder, "specimen_radius: 0.0225", "specimen_radius: 0")
        assert [problem.line for problem in problems_of(load_campaign, folder)] == [6, 16, 24]

    def test_no_configurations(self, folder):
        (folder / "campaign.yaml").write_text(HEAD.replace("configurations:", "configurations: []"))
        (problem,) = problems_of(load_campaign, folder)
        assert (problem.path, problem.message) == ("configurations", "must not be empty")

    def test_no_bursts(self, folder):
        lines = (HEAD + CONFIGURATION).splitlines()[:17]
        (folder / "campaign.yaml").write_text("\n".join([*lines[:-1], "    bursts: []"]))
        (problem,) = problems_of(load_campaign, folder)
        assert (problem.path, problem.message) == ("configurations.0.bursts", "must not be empty")

    def test_nothing_there(self, tmp_path):
        assert "holds no campaign.yaml; name a folder that does" in problems_of(load_campaign, tmp_path)[0].message
        assert "no such file" in problems_of(load_campaign, tmp_path / "other.yaml")[0].message

    def test_scipy_is_not_loaded_for_a_description(self):
        code = (
            "import sys, multilayer.measurements.campaign\n"
            "print([name for name in ('scipy', 'pint', 'matplotlib') if name in sys.modules])"
        )
        printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        assert printed.strip() == "[]"


class TestRecordings:
    def test_all_are_read(self, folder):
        recordings = load_recordings(load_campaign(folder))
        assert list(recordings) == [(name, f) for name in ("thin", "thick") for f in (300.0, 500.0, 700.0)]
        for (name, frequency), recording in recordings.items():
            base, top = signals(frequency, seed=int(name == "thick"))
            np.testing.assert_allclose(recording.base, base, atol=1e-7)
            np.testing.assert_allclose(recording.top, top, atol=1e-7)
            assert recording.sampling_rate == RATE

    def test_one_burst(self, folder):
        campaign = load_campaign(folder)
        mounting = campaign.configuration("thick")
        assert read_burst(campaign, mounting, mounting.bursts[1]).base.shape == (2, 4000)

    def test_a_missing_file_stands_at_its_line(self, folder):
        (folder / "signals/thick_500.csv").unlink()
        campaign = load_campaign(folder)
        mounting = campaign.configuration("thick")
        (problem,) = problems_of(read_burst, campaign, mounting, mounting.bursts[1])
        assert (problem.file, problem.line, problem.column) == (folder / "campaign.yaml", 27, 35)
        assert problem.path == "configurations.1.bursts.1.file"
        assert str(folder / "signals/thick_500.csv") in problem.message
        assert problems_of(load_recordings, campaign) == [problem]

    def test_every_problem_of_every_file_in_one_error(self, folder):
        names = [folder / "signals" / name for name in ("thin_300.npz", "thin_700.npz", "thick_300.npz")]
        names[0].write_bytes(names[0].read_bytes()[:1000])
        base, top = signals(700)
        base[1, 17] = np.nan
        np.savez(names[1], base=base, top=np.clip(top, -1.0, 1.0))
        np.savez(names[2], base=signals(300)[0])
        rewrite(folder, "\n0.0009765625,", "\noops,", "signals/thick_500.csv")
        found = problems_of(load_recordings, load_campaign(folder))
        assert [(problem.file, problem.line) for problem in found] == [
            (names[0], None),
            (names[1], None),
            (names[2], None),
            (folder / "signals/thick_500.csv", 27),
        ]
        assert [str(problem).count(str(folder)) for problem in found] == [1, 1, 1, 1]
        for word, problem in zip(["cut short", "not finite", "no array 'top'", "no number"], found, strict=True):
            assert word in problem.message

    def test_clipped_and_silent_channels(self, folder):
        base, top = signals(300)
        np.savez(folder / "signals/thin_300.npz", base=np.clip(base, -9.0, 9.0), top=top)
        np.savez(folder / "signals/thick_300.npz", base=base, top=0.0 * top)
        clipped, silent = problems_of(load_recordings, load_campaign(folder))
        assert (clipped.file, silent.file) == tuple(folder / f"signals/{n}_300.npz" for n in ("thin", "thick"))
        assert "base channel is clipped in 2 of 2" in clipped.message
        assert "top channel is silent" in silent.message

    def test_clipping_is_seen_beneath_hum(self, folder):
        """Hum taken off before would round the flat tops."""
        for frequency in (300, 500, 700):
            hum = 0.5 * np.sin(2 * np.pi * 50 * np.arange(4000) / RATE)
            base, top = (one + hum for one in signals(frequency))
            np.savez(
                folder / f"signals/thin_{frequency}.npz", base=base, top=np.clip(top, -0.6 * top.max(), 0.6 * top.max())
            )
        rewrite(folder, "thin_500.csv", "thin_500.npz")
        found = problems_of(load_recordings, load_campaign(folder))
        assert [problem.file.name for problem in found] == [f"thin_{f}.npz" for f in (300, 500, 700)]
        assert all("top channel is clipped in 2 of 2" in problem.message for problem in found)

    def test_a_repeat_in_which_a_channel_failed(self, folder):
        base, top = (np.concatenate([one, one[:1]]) for one in signals(300))
        top[1] = 0.01 * np.random.default_rng(1).normal(size=4000)
        np.savez(folder / "signals/thin_300.npz", base=base, top=top)
        (problem,) = problems_of(load_recordings, load_campaign(folder))
        assert problem.file == folder / "signals/thin_300.npz"
        assert problem.message.startswith("repeat 2 of 3 differs from the others in top over base")

    def test_repeats_that_differ_a_little_are_told_once(self, folder):
        for frequency in (300, 700):
            base, top = signals(frequency)
            np.savez(folder / f"signals/thin_{frequency}.npz", base=base, top=top * [[1.0], [0.9]])
        with pytest.warns(
            PlausibilityWarning, match=r"differ in top over base in 2 of 6 .* up to 10 % \(repeat 2, "
        ) as told:
            load_recordings(load_campaign(folder))
        assert len(told) == 1

    def test_noise_that_is_not_white_is_told_once(self, folder):
        for seed, name in enumerate(("thin", "thick")):
            for frequency in (300, 700):
                rng = np.random.default_rng([frequency, seed])
                clean = (one.mean(axis=0) for one in signals(frequency))
                base, top = (one + 0.1 * pink_noise((3, 4000), rng) for one in clean)
                np.savez(folder / f"signals/{name}_{frequency}.npz", base=base, top=top)
        with pytest.warns(PlausibilityWarning, match=r"campaign.yaml: noise is not white: .* in 4 of 6 ") as told:
            load_recordings(load_campaign(folder))
        assert len(told) == 1

    def test_a_clock_that_is_off_in_one_configuration_is_told_once(self, folder):
        for frequency in (300, 700):
            base, top = signals(1.01 * frequency)
            np.savez(folder / f"signals/thick_{frequency}.npz", base=base, top=top)
        write_csv(folder / "signals/thick_500.csv", *signals(505))
        with pytest.warns(PlausibilityWarning, match="campaign.yaml: the bursts of thick appear at 1.01") as told:
            load_recordings(load_campaign(folder))
        assert len(told) == 1
        assert "25600 Hz right? 2534" in str(told[0].message)

    def test_copies_and_files_of_another_configuration_are_told(self, folder):
        data = np.load(folder / "signals/thin_300.npz")
        np.savez(folder / "signals/thick_300.npz", **data)
        with pytest.warns(PlausibilityWarning, match=r"hold the same samples: signals/thin_300.npz and signals/thick_"):
            load_recordings(load_campaign(folder))
        bursts = "".join(f"      - {{frequency: {f}, file: signals/{f}.npz}}\n" for f in (400, 450, 500, 550, 600))
        (folder / "campaign.yaml").write_text(
            HEAD + CONFIGURATION.split("      -", maxsplit=1)[0].replace("NAME", "thin") + bursts
        )
        for f in (400, 450, 500, 550, 600):
            base, top = signals(f, 520.0 if f == 550 else 450.0)
            np.savez(folder / f"signals/{f}.npz", base=base, top=top)
        with pytest.warns(
            PlausibilityWarning, match=r"in configuration 'thin', top over base of signals/550.npz \(by "
        ):
            load_recordings(load_campaign(folder))

    def test_a_channel_that_limits_softly_is_told_once(self, folder):
        for seed, name in enumerate(("thin", "thick")):
            base, top = signals(300, seed=seed)
            np.savez(folder / f"signals/{name}_300.npz", base=base, top=top - 0.1 * top**3 / np.abs(top).max() ** 2)
        with pytest.warns(
            PlausibilityWarning, match="the top channel limits softly in 2 of 6 recordings: .* lower the level"
        ) as told:
            load_recordings(load_campaign(folder))
        assert len(told) == 1

    def test_swapped_channels_stand_at_their_configuration(self, folder):
        for frequency in (300, 700):
            base, top = signals(frequency)
            np.savez(folder / f"signals/thick_{frequency}.npz", base=top, top=base)
        write_csv(folder / "signals/thick_500.csv", *signals(500)[::-1])
        (problem,) = problems_of(load_recordings, load_campaign(folder))
        assert (problem.file, problem.line, problem.path) == (folder / "campaign.yaml", 21, "configurations.1")
        assert "base and top look exchanged" in problem.message

    def test_a_wrong_frequency(self, folder):
        rewrite(folder, "frequency: 300, file: signals/thin", "frequency: 400, file: signals/thin")
        (problem,) = problems_of(load_recordings, load_campaign(folder))
        assert problem.file == folder / "signals/thin_300.npz"
        assert "stated at 400 Hz but found at 300 Hz" in problem.message

    def test_a_wrong_sampling_rate_is_told_once_at_its_line(self, folder):
        for name in ("thin", "thick"):
            np.savez(folder / f"signals/{name}_500.npz", **dict(zip(("base", "top"), signals(500), strict=True)))
        rewrite(folder, "500.csv", "500.npz")
        rewrite(folder, "sampling_rate: 25600", "sampling_rate: 23552")
        (problem,) = problems_of(load_recordings, load_campaign(folder))
        assert (problem.file, problem.line, problem.path) == (folder / "campaign.yaml", 3, "sampling_rate")
        assert "at 0.92 times their stated frequency" in problem.message
        assert "25600 Hz would fit" in problem.message

    @pytest.mark.parametrize(("rate", "fits"), [(25600.0, True), (25610.0, True), (25650.0, False)])
    def test_a_files_own_rate_must_be_the_campaigns(self, folder, rate, fits):
        write_csv(folder / "signals/thin_500.csv", *signals(500), rate=rate)
        campaign = load_campaign(folder)
        if fits:
            assert len(load_recordings(campaign)) == 6
        else:
            (problem,) = problems_of(load_recordings, campaign)
            assert problem.file == folder / "signals/thin_500.csv"
            assert "is sampled at 25650 Hz, but the campaign's sampling_rate is 25600 Hz" in problem.message

    def test_a_format_nobody_reads(self, folder):
        (folder / "signals/thin_300.doc").write_bytes(b"")
        rewrite(folder, "thin_300.npz", "thin_300.doc")
        (problem,) = problems_of(load_recordings, load_campaign(folder))
        assert problem.file == folder / "signals/thin_300.doc"
        assert "nothing reads '.doc' files" in problem.message


class TestCalibration:
    @pytest.fixture
    def at_one_spot(self, tmp_path):
        (tmp_path / "campaign.yaml").write_text(CALIBRATION)
        for frequency, ratio, shift in ((300, 1.02, 4e-6), (700, 0.98, -2e-6)):
            rng = np.random.default_rng(frequency)
            base = hann_burst(frequency, 10, RATE, n_samples=4000, start=0.002)
            top = ratio * hann_burst(frequency, 10, RATE, n_samples=4000, start=0.002 + shift)
            noisy = {name: x + 0.005 * rng.normal(size=(3, 4000)) for name, x in (("base", base), ("top", top))}
            np.savez(tmp_path / f"{frequency}.npz", **noisy)
        return tmp_path

    def test_ratio_and_shift(self, at_one_spot):
        calibration = load_calibration(at_one_spot)
        np.testing.assert_array_equal(calibration.frequencies, [300.0, 700.0])
        np.testing.assert_allclose(calibration.amplitude_ratio, [1.02, 0.98], atol=2e-4)
        np.testing.assert_allclose(calibration.time_shift, [4e-6, -2e-6], atol=1e-7)

    def test_a_campaign_is_no_calibration(self, folder, at_one_spot):
        (folder / "campaign.yaml").write_text(TEXT)
        assert any("'calibration'" in problem.message for problem in problems_of(load_calibration, folder))
        (at_one_spot / "campaign.yaml").write_text(CALIBRATION)
        assert any("'shaker-two-plate'" in problem.message for problem in problems_of(load_campaign, at_one_spot))

    def test_problems_of_its_files(self, at_one_spot):
        (at_one_spot / "300.npz").unlink()
        np.savez(at_one_spot / "700.npz", base=np.ones((1, 4000)), top=np.zeros((1, 4000)))
        missing, *silent = problems_of(load_calibration, at_one_spot)
        assert (missing.file, missing.line, missing.path) == (at_one_spot / "campaign.yaml", 6, "bursts.0.file")
        assert [problem.file for problem in silent] == [at_one_spot / "700.npz"] * 2

    def test_a_channel_of_the_wrong_sign(self, at_one_spot):
        base = hann_burst(700.0, 10, RATE, n_samples=4000, start=0.002)
        np.savez(at_one_spot / "700.npz", base=base, top=-base)
        (problem,) = problems_of(load_calibration, at_one_spot)
        assert problem.file == at_one_spot / "campaign.yaml"
        assert "700 Hz shows no motion common to both channels" in problem.message

    def test_no_frequency_twice(self, at_one_spot):
        rewrite(at_one_spot, "frequency: 700", "frequency: 300")
        (problem,) = problems_of(load_calibration, at_one_spot)
        assert (problem.line, problem.path) == (7, "bursts.1.frequency")


@pytest.mark.reference
@pytest.mark.skipif(not FOLDERS, reason="../shared is absent")
@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.relative_to(CAMPAIGNS).as_posix())
def test_the_shared_campaigns_load_without_a_problem(folder):
    campaign = load_campaign(folder)
    recordings = load_recordings(campaign)
    assert len(recordings) == sum(len(mounting.bursts) for mounting in campaign.configurations)
    for recording in recordings.values():
        # the level the campaign states, whatever the burst: rms of the base over the burst's own duration
        assert recording.base.shape[0] in (2, 3)
    for name, frequency in recordings:
        base, _ = recordings[name, frequency].mean()
        duration = campaign.burst.cycles / frequency * campaign.sampling_rate
        assert np.sqrt(np.sum(base**2) / duration) == pytest.approx(campaign.burst.level_rms, rel=2e-3)

"""A law at another temperature."""

from pathlib import Path

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.errors import InputError
from multilayer.fits.law_fit import fit_law
from multilayer.media.laws import FractionalZener
from multilayer.media.laws.shifted import Shifted
from multilayer.simulation import SimulationFile, simulate
from tests.cli.command import run

F = np.geomspace(1, 1e4, 9)
WITHIN = FractionalZener(relaxed_modulus=1e5, unrelaxed_modulus=3e6, relaxation_time=1e-4, order=0.4)
RUBBER = """\
version: 1
layers:
  - type: elastic_solid
    name: rubber
    thickness: 10 mm
    density: 1100
    poisson_ratio: 0.48
    young_modulus:
      law: shifted
      modulus: {law: fractional_zener, relaxed_modulus: 100 kPa, unrelaxed_modulus: 3 MPa, relaxation_time: 100 us,
                order: 0.4}
      temperature: 35 degC
      reference_temperature: 20 degC
      c1: 8.86
      c2: 101.6 K
termination: ambient
frequency: [100, 1000]
"""


def test_wlf_takes_frequencies_down_where_it_is_warm() -> None:
    warm = Shifted(modulus=WITHIN, temperature=308.15, reference_temperature=293.15, c1=8.86, c2=101.6)
    factor = 10 ** (-8.86 * 15 / (101.6 + 15))
    np.testing.assert_allclose(warm(F), WITHIN(factor * F), rtol=1e-12)
    assert np.all(warm(F).real < WITHIN(F).real)
    same = Shifted(modulus=WITHIN, temperature=293.15, reference_temperature=293.15, c1=8.86, c2=101.6)
    np.testing.assert_array_equal(same(F), WITHIN(F))


def test_arrhenius_and_the_modulus_of_entropy() -> None:
    cold = Shifted(
        modulus=WITHIN, temperature=273.15, reference_temperature=293.15, activation_energy=8e4, vertical="entropic"
    )
    factor = np.exp(8e4 / 8.314462618 * (1 / 273.15 - 1 / 293.15))
    np.testing.assert_allclose(cold(F), WITHIN(factor * F) * 273.15 / 293.15, rtol=1e-9)
    number = cold.model_copy(update={"modulus": 1e5 + 1e4j})
    np.testing.assert_allclose(number(-F), (1e5 - 1e4j) * 273.15 / 293.15 * np.ones(9))
    assert cold.causal
    assert not number.causal


def test_shifts_add_up() -> None:
    once = Shifted(modulus=WITHIN, temperature=300.0, reference_temperature=293.0, activation_energy=8e4)
    back = Shifted(modulus=once, temperature=293.0, reference_temperature=300.0, activation_energy=8e4)
    np.testing.assert_allclose(back(F), WITHIN(F), rtol=1e-12)


def test_in_a_file_with_a_sweep_of_the_temperature() -> None:
    data = parse_yaml(RUBBER, Path("rubber.yaml")).data
    path = "layers.rubber.young_modulus"
    simulation = SimulationFile.model_validate(
        {**data, "sweep": {f"{path}.temperature": ["20 degC", "35 degC"]}, "tolerances": {f"{path}.c1": "5 %"}}
        | {"samples": 3}
    )
    cold, warm = simulate(simulation).cases
    assert cold.label == "rubber.young_modulus.temperature = 20 degC"
    assert np.all(np.abs(cold.quantities["transmission_loss"] - warm.quantities["transmission_loss"]) > 1e-3)
    plain = SimulationFile.model_validate({**data, "layers": [{**data["layers"][0], "young_modulus": WITHIN}]})
    (expected,) = simulate(plain).cases
    np.testing.assert_allclose(cold.quantities["transmission_loss"], expected.quantities["transmission_loss"])
    low, _, high = warm.percentiles["transmission_loss_db"]
    assert np.all(high > low)


@pytest.mark.parametrize(
    ("written", "instead", "told"),
    [
        ("      c2: 101.6 K\n", "", "c2 is missing"),
        ("      c1: 8.86\n      c2: 101.6 K\n", "", "either c1 and c2"),
        ("      c1: 8.86\n", "      c1: 8.86\n      activation_energy: 80 kJ/mol\n", "either c1 and c2"),
        ("35 degC", "-90 degC", "pole at 191.55 K"),
        ("101.6 K", "101.6 degC", "no unit"),
    ],
)
def test_mistakes(tmp_path: Path, written: str, instead: str, told: str) -> None:
    file = tmp_path / "rubber.yaml"
    file.write_text(RUBBER.replace(written, instead))
    done = run("check", str(file))
    assert done.status == 2
    assert told in done.out + done.err
    assert "rubber.yaml:" in done.out + done.err


def test_a_fit_takes_the_law_within() -> None:
    with pytest.raises(InputError, match="fit that law"):
        fit_law("shifted", F, WITHIN(F))

"""Impedance-tube measurements and curves that others digitised."""

import csv

import numpy as np
import pytest

from multilayer.media.gas import dry_air
from multilayer.media.porous import johnson_density, limp_density
from multilayer.response import plane_wave
from multilayer.stack import Stack

pytestmark = pytest.mark.reference

# sample: temperature (degC), pressure (bar), and of both thicknesses: mm, rms |d Zs/Z0|, rms d(absorption) for a
# rigid frame with the published parameters, with the digits that the description of the data prints
SAMPLES = {
    "foam1": (21.5, 0.992, (49.92, "0.033", "0.02"), (98.7, "0.067", "0.007")),
    "foam2": (24.6, 0.997, (34.35, "0.049", "0.028"), (68.77, "0.195", "0.016")),
    "fibrous1": (22.6, 1.002, (23.37, "0.065", "0.030"), (46.83, "0.122", "0.039")),
    "fibrous2": (24.6, 0.977, (37.38, "0.058", "0.012"), (18.98, "0.111", "0.013")),
}
CURVES = [
    pytest.param(name, suffix, temperature, pressure, *values, id=name + suffix)
    for name, (temperature, pressure, *both) in SAMPLES.items()
    for suffix, values in zip(("", "thick"), both, strict=True)
]


def measured(folder, name):
    """Return frequency (Hz, from 500) and the surface impedance over that of the air."""
    with (folder / f"ap2005_{name}.CSV").open() as file:
        rows = [[float(cell) for cell in row[:3]] for row in list(csv.reader(file))[1:] if all(row[:3])]
    frequency, real, imaginary = np.array([row for row in rows if row[0] >= 500]).T
    return frequency, real + 1j * imaginary


def misfit(shared, name, suffix, millimetres, ambient):
    frequency, impedance = measured(shared / "measured", name + suffix)
    assert len(frequency) == 56
    layer = {"material": f"AP2005/{name}", "type": "equivalent_fluid", "thickness": millimetres / 1e3}
    stack = Stack.model_validate({"ambient": ambient, "layers": [layer]})
    result = plane_wave(stack, frequency)
    absorption = 1 - np.abs((impedance - 1) / (impedance + 1)) ** 2
    differences = result.surface_impedance / stack.ambient.gas.impedance - impedance, result.absorption - absorption
    return [float(np.sqrt(np.mean(np.abs(difference) ** 2))) for difference in differences]


def excess(value, printed):
    """Return how far a value, rounded as the printed one, lies above it."""
    return round(value, len(printed.partition(".")[2])) - float(printed)


@pytest.mark.parametrize(("name", "suffix", "temperature", "pressure", "thickness", "of_z", "of_alpha"), CURVES)
class TestAtallaPanneton:
    """Y. Atalla & R. Panneton, Canadian Acoustics 33(1), 2005."""

    def test_no_worse_than_stated(self, shared, name, suffix, temperature, pressure, thickness, of_z, of_alpha):
        """To every printed digit, in an air that gives them all; the statement does not say which air it took."""
        ambient = {
            "temperature": temperature + 273.15, "pressure": pressure * 1e5, "viscosity": 1.85e-5,
            "heat_capacity_ratio": 1.402,
        }  # fmt: skip
        ours = misfit(shared, name, suffix, thickness, ambient)
        assert excess(ours[0], of_z) <= 0
        assert excess(ours[1], of_alpha) <= 0

    def test_in_dry_air(self, shared, name, suffix, temperature, pressure, thickness, of_z, of_alpha):
        ambient = {"temperature": temperature + 273.15, "pressure": pressure * 1e5}
        ours = misfit(shared, name, suffix, thickness, ambient)
        assert excess(ours[0], of_z) <= 0.0011
        assert excess(ours[1], of_alpha) <= 0


class TestPanneton:
    """R. Panneton, J. Acoust. Soc. Am. 122 (2007) EL217: effective densities over that of air.

    The file calls them impedances; with the parameters given for it they are the densities of the rigid and of the
    limp frame per volume of material.
    """

    PORES = (0.98, 25e3, 1.02, 90e-6)

    @pytest.fixture
    def curves(self, shared):
        with (shared / "measured" / "panneton2007_rigid_limp.csv").open() as file:
            rows = [[float(cell or "nan") for cell in row] for row in list(csv.reader(file))[1:]]
        frequency, *columns = np.array(rows).T
        return 2 * np.pi * frequency, columns[0] + 1j * columns[1], columns[2] + 1j * columns[3]

    def test_rigid(self, curves):
        omega, rigid, _ = curves
        ours = johnson_density(omega, *self.PORES, dry_air()) / dry_air().density
        there = np.isfinite(rigid)
        assert np.count_nonzero(there) == 45
        assert np.max(np.abs(ours - rigid)[there] / np.abs(rigid)[there]) < 0.08

    def test_limp(self, curves):
        omega, _, limp = curves
        rigid = johnson_density(omega, *self.PORES, dry_air())
        ours = limp_density(rigid, 0.98, 30.0, dry_air()) / dry_air().density
        assert np.max(np.abs(ours - limp) / np.abs(limp)) < 0.05

"""Fine patterns of stacks side by side: what they are made of, admittances, what they refuse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.fluid import Fluid
from multilayer.layers.patches import Patches
from multilayer.matrix.faces import mirrored
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.paths import locate
from multilayer.response import plane_wave, power_balance
from multilayer.stack import Stack
from tests.cli.command import run
from tests.simulation.files import FOAM_BESIDE_CHAMBER

FREQUENCY, ANGLE = np.array([50.0, 500.0, 2000.0]), np.array([0.0, 50.0, 80.0])
WOOL = {
    "type": "equivalent_fluid", "thickness": 0.05, "porosity": 0.98, "flow_resistivity": 1e4, "tortuosity": 1.02,
    "viscous_length": 1e-4, "thermal_length": 2e-4,
}  # fmt: skip
PLATE = {"type": "elastic_plate", "thickness": 1e-3, "density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.3}
FOAM = {
    "type": "poroelastic", "thickness": 0.03, "porosity": 0.98, "flow_resistivity": 15e3, "tortuosity": 1.05,
    "viscous_length": 1e-4, "thermal_length": 2.5e-4, "frame_density": 25, "young_modulus": 1.4e5, "poisson_ratio": 0.3,
    "loss_factor": 0.1,
}  # fmt: skip
SOLID = {"type": "elastic_solid", "thickness": 2e-3, "density": 1200, "young_modulus": 3e9, "poisson_ratio": 0.35}


def pattern(*patches, **fields):
    return Patches(**{"period": 1e-3, "patches": patches, **fields})


def admittance(*layers, angle=0.0):
    return 1 / plane_wave(Stack(layers=layers), FREQUENCY, angle).surface_impedance


@pytest.mark.parametrize("layers", [[WOOL], [FOAM], [PLATE, FOAM, SOLID], [{"type": "fluid", "thickness": 0.02}]])
@pytest.mark.parametrize("termination", ["ambient", "rigid"])
def test_one_patch_is_its_layers(layers, termination):
    """From air to air, and before more layers; a fluid face is what they all show to air."""
    behind = [Fluid(thickness=0.01), {**WOOL, "thickness": 0.02}]
    alone = plane_wave(Stack(layers=[*layers, *behind], termination=termination), FREQUENCY, ANGLE)
    half = {"share": 0.5, "layers": layers}
    found = plane_wave(Stack(layers=[pattern(half, half), *behind], termination=termination), FREQUENCY, ANGLE)
    assert_allclose(found.reflection, alone.reflection, rtol=1e-8, atol=1e-9)
    if termination == "ambient":
        assert_allclose(found.transmission_loss, alone.transmission_loss, atol=1e-6)


def test_patches_before_walls_add_their_admittances():
    """One has a wall of its own, the other that of the stack: 1/Z = sum share/Z_i."""
    shallow, deep = Fluid(thickness=0.05), Fluid(thickness=0.2)
    cells = ({"share": 0.3, "layers": [shallow], "closed": True}, {"share": 0.7, "layers": [deep]})
    for angle in (0.0, 60.0):
        expected = 0.3 * admittance(shallow, angle=angle) + 0.7 * admittance(deep, angle=angle)
        assert_allclose(admittance(pattern(*cells), angle=angle), expected, rtol=1e-10)


@pytest.mark.parametrize("also_open", [False, True])
def test_between_side_walls_sound_runs_along_the_depth(also_open):
    """A chamber is i tan(k d)/Z0 at any angle; beside it a patch without walls stays as it is."""
    deep, wool = Fluid(thickness=0.2), {**WOOL, "thickness": 0.05}
    chamber = {"share": 0.3 if also_open else 1.0, "layers": [deep], "closed": also_open, "side_walls": True}
    cells = [chamber, *([{"share": 0.7, "layers": [wool]}] if also_open else [])]
    gas = dry_air()
    upright = 1j * np.tan(2 * np.pi * FREQUENCY * 0.2 / gas.sound_speed) / gas.impedance
    for angle in (0.0, 60.0):
        expected = 0.3 * upright + 0.7 * admittance(wool, angle=angle) if also_open else upright
        assert_allclose(admittance(pattern(*cells), angle=angle), expected, rtol=1e-6)


def test_air_beside_wool_shares_the_pressure_behind():
    """Thin parts before a cavity: the air, free to pass, shorts the wool out, (1/Z1 + 1/Z2) of sheets."""
    weak, strong = ({"type": "screen", "flow_resistance": r} for r in (100.0, 5000.0))
    cavity = Fluid(thickness=0.1)
    made = pattern({"share": 0.5, "layers": [weak]}, {"share": 0.5, "layers": [strong]})
    expected = 1 / (0.5 / 100 + 0.5 / 5000) + 1 / admittance(cavity)
    assert_allclose(1 / admittance(made, cavity), expected, rtol=1e-9)


@pytest.mark.parametrize(
    "varied",
    [("patches.0.layers.0.thickness",), ("patches.1.layers.1.thickness",), ("patches.0.share", "patches.1.share")],
)
def test_arrays_in_place_of_fields_are_each_value_by_itself(varied):
    closed = {"share": 0.3, "layers": [{"type": "screen", "flow_resistance": 400.0}, Fluid(thickness=0.2)]}
    stack = Stack(layers=(pattern({"share": 0.7, "layers": [WOOL]}, {**closed, "closed": True}), Fluid(thickness=0.02)))
    factors = np.array([0.9, 1.0, 1.2])
    nominal = [locate(stack, f"layers.0.{path}").value for path in varied]
    each = [np.array(factors * value if i == 0 else 1 - factors * nominal[0]) for i, value in enumerate(nominal)]

    def reflection(values):
        changed = {f"layers.0.{path}": value for path, value in zip(varied, values, strict=True)}
        return plane_wave(stack.replaced(changed), FREQUENCY, 30.0).reflection

    together = reflection([values[:, None] for values in each])
    alone = [reflection([float(values[i]) for values in each]) for i in range(len(factors))]
    assert_allclose(together, alone, rtol=1e-12)


@pytest.mark.parametrize("path", ["foam.layers.0.thickness", "chamber.layers.0.thickness"])
def test_tolerances_inside(tmp_path, path):
    (tmp_path / "mix.yaml").write_text(
        f"{FOAM_BESIDE_CHAMBER}tolerances: {{layers.mix.patches.{path}: 5 %}}\nsamples: 20\n"
    )
    done = run("simulate", tmp_path / "mix.yaml", "--out", tmp_path / "out", "--no-figures")
    assert (done.status, done.err) == (0, "")
    assert f"mix.patches.{path}" in done.out


def test_power_is_kept():
    made = pattern(
        {"share": 0.2, "layers": [WOOL]}, {"share": 0.8, "layers": [PLATE, {"type": "fluid", "thickness": 0.05}]}
    )
    balance = power_balance(Stack(layers=(made,), termination="ambient"), FREQUENCY, ANGLE)
    assert np.all(balance.dissipated > 0)
    assert_allclose(balance.residual, 0, atol=1e-12)


@pytest.mark.parametrize("kind", [FOAM, SOLID, WOOL])
def test_turned_round_twice_and_symmetric(kind):
    """A homogeneous layer turned round spans the same states."""
    layer = Stack(layers=(kind,)).layers[0]
    faces = layer.faces(Wave.incident(FREQUENCY, 40.0, dry_air()))
    transfers = []
    for one in (faces, mirrored(faces), mirrored(mirrored(faces))):
        front, back = (np.moveaxis(matrix, (0, 1), (-2, -1)) for matrix in (one.front, one.back))
        transfers.append(back @ np.linalg.inv(front))
    assert_allclose(transfers[2], transfers[0], rtol=1e-12)
    scale = np.abs(transfers[0]).max()
    assert_allclose(transfers[1] / scale, transfers[0] / scale, atol=1e-9)


def test_coarse_pattern_warns():
    made = pattern({"share": 1.0, "layers": [WOOL]}, period=0.5)
    with pytest.warns(ValidityWarning, match="period / wavelength up to 0.5"):
        plane_wave(Stack(layers=(made,)), FREQUENCY)


@pytest.mark.parametrize(
    ("patches", "text"),
    [
        ([{"share": 0.5, "layers": [WOOL]}], "sum up to 0.5"),
        ([{"share": 1.0, "layers": [WOOL], "closed": True}], "termination: rigid"),
        ([{"share": 1.0, "layers": []}], "must not be empty"),
        ([{"share": 1.0, "layers": [{"type": "wool"}]}], "no layer type"),
    ],
)
def test_refused(patches, text):
    with pytest.raises(InputError, match=text):
        Stack(layers=[{"type": "patches", "period": 0.01, "patches": patches}])

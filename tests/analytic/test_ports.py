"""Surface impedance, admittance, impedance and transfer matrices, against closed forms and against other responses."""

from typing import Any

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.matrix.faces import mirrored
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import base_motion, plane_wave
from multilayer.response.ports import (
    FACE_KINDS,
    admittance_matrix,
    impedance_matrix,
    surface_admittance,
    surface_impedance,
    transfer_matrix,
)
from multilayer.stack import Stack
from tests.analytic.materials import AIR, ALUMINIUM, FOAM, FOAM2, SHEET, stack
from tests.contract.samples import LAYER_SAMPLES

pytestmark = pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
FREQUENCY, ANGLE = np.geomspace(50, 5000, 12), np.array([0.0, 40.0, 75.0])
GAS = dry_air()
RESONATORS = {
    "type": "helmholtz_resonators", "neck_radius": 2e-3, "neck_length": 2e-3, "pitch": 0.02, "cavity_depth": 0.03,
}  # fmt: skip
PAIRS = [(front, back) for front in FACE_KINDS for back in FACE_KINDS]


def panels() -> dict[str, Stack]:
    resonators = Stack.model_validate({"layers": [{**AIR, "thickness": 0.01}, RESONATORS], "termination": "ambient"})
    return {
        "foam": stack((FOAM2, 0.03)),
        "plate and foam": stack((SHEET, 1e-3), (FOAM2, 0.03)),
        "double wall": stack((SHEET, 1e-3), (FOAM2, 0.05), (AIR, 0.01), (ALUMINIUM, 2e-3)),
        "slipping": stack((FOAM2, 0.02), (ALUMINIUM, 2e-3), (FOAM, 0.01), slip=((0, 1),)),
        "two-sided": resonators,
    }


PANELS = panels()
panel = pytest.mark.parametrize("name", PANELS)


def hermitian(matrix: Any) -> Any:
    return (matrix + np.conj(np.swapaxes(matrix, -1, -2))) / 2


@panel
def test_with_half_spaces_on_both_sides_it_is_the_response_to_a_plane_wave(name: str) -> None:
    y, wave = admittance_matrix(PANELS[name], FREQUENCY, ANGLE), plane_wave(PANELS[name], FREQUENCY, ANGLE)
    space = np.cos(np.deg2rad(ANGLE)) / GAS.impedance
    behind = -y[..., 1, 0] / (y[..., 1, 1] + space)  # p2 for p1 = 1: the half-space takes what leaves, -v2
    surface = y[..., 0, 0] + y[..., 0, 1] * behind
    reflection = (space - surface) / (space + surface)
    assert reflection == pytest.approx(wave.reflection, rel=1e-10)
    assert (1 + reflection) * behind == pytest.approx(wave.transmission, rel=1e-10)


@panel
@pytest.mark.parametrize("faces", PAIRS)
def test_reciprocity_passivity_and_one_matrix_from_another(name: str, faces: Any) -> None:
    if name == "two-sided" and "plate" in faces:
        faces = ("plate", "fluid")  # resonators have no floor of their own
    y, z, t = (
        matrix(PANELS[name], FREQUENCY, ANGLE, faces=faces)
        for matrix in (admittance_matrix, impedance_matrix, transfer_matrix)
    )
    for matrix in (y, z):
        assert matrix[..., 0, 1] == pytest.approx(matrix[..., 1, 0], rel=1e-10)
        assert np.all(np.linalg.eigvalsh(hermitian(matrix)) >= -1e-12 * np.abs(matrix).max(axis=(-2, -1))[..., None])
    assert y @ z == pytest.approx(np.broadcast_to(np.eye(2), y.shape), abs=1e-8)
    rows = [[-y[..., 1, 1], -np.ones_like(y[..., 0, 0])], [y[..., 0, 1] * y[..., 1, 0], -y[..., 0, 0]]]
    rows[1][0] = rows[1][0] - y[..., 0, 0] * y[..., 1, 1]
    of_admittance = np.moveaxis(np.array(rows), (0, 1), (-2, -1)) / y[..., 1, 0, None, None]
    assert t == pytest.approx(of_admittance, rel=1e-6)
    assert t[..., 0, 0] * t[..., 1, 1] - t[..., 0, 1] * t[..., 1, 0] == pytest.approx(1, rel=1e-6)


def test_a_layer_of_air_in_closed_form() -> None:
    k3 = 2 * np.pi * FREQUENCY[:, None] / GAS.sound_speed * np.cos(np.deg2rad(ANGLE))
    wave, phase = GAS.impedance / np.cos(np.deg2rad(ANGLE)), k3 * 0.05
    t = transfer_matrix(stack((AIR, 0.05)), FREQUENCY, ANGLE)
    assert t[..., 0, 0] == pytest.approx(np.cos(phase), rel=1e-9)
    assert t[..., 1, 1] == pytest.approx(np.cos(phase), rel=1e-9)
    assert t[..., 0, 1] == pytest.approx(1j * wave * np.sin(phase), rel=1e-9)
    assert t[..., 1, 0] == pytest.approx(1j * np.sin(phase) / wave, rel=1e-9)


def test_beyond_grazing_fields_of_air_decay() -> None:
    kx = np.array([20.0, 200.0])
    decay = np.sqrt(kx**2 - (2 * np.pi * 500 / GAS.sound_speed) ** 2)
    t = transfer_matrix(stack((AIR, 0.01)), 500.0, trace_wavenumber=kx)
    assert t[..., 0, 0] == pytest.approx(np.cosh(0.01 * decay), rel=1e-9)
    assert t[..., 0, 1] == pytest.approx(1j * 1000 * np.pi * GAS.density / decay * np.sinh(0.01 * decay), rel=1e-9)


def test_a_light_plate_is_a_mass_between_its_faces() -> None:
    y = admittance_matrix(stack((SHEET, 1e-3)), FREQUENCY)
    moved = 1 / (2j * np.pi * FREQUENCY * 2.7)
    assert y == pytest.approx(moved[:, None, None] * np.array([[1, -1], [-1, 1]]), rel=1e-6)


def test_a_plate_that_keeps_its_thickness_has_no_impedance_matrix() -> None:
    for layers in (((SHEET, 1e-3),), ((SHEET, 1e-3), (SHEET, 2e-3))):
        with pytest.raises(InputError, match="keep their thickness have no impedance matrix, but an admittance"):
            impedance_matrix(stack(*layers), FREQUENCY)


@panel
@pytest.mark.parametrize("termination", ["rigid", "ambient", "free"])
def test_surface_impedance_is_that_of_the_plane_wave(name: str, termination: Any) -> None:
    panel = PANELS[name].model_copy(update={"termination": termination})
    impedance = surface_impedance(panel, FREQUENCY, ANGLE)
    assert impedance == pytest.approx(plane_wave(panel, FREQUENCY, ANGLE).surface_impedance, rel=1e-8)
    kx = 2 * np.pi * FREQUENCY[3] / GAS.sound_speed * np.sin(np.deg2rad(ANGLE))
    assert surface_admittance(panel, FREQUENCY, ANGLE) * impedance == pytest.approx(1, rel=1e-8)
    assert surface_impedance(panel, FREQUENCY[3], trace_wavenumber=kx) == pytest.approx(impedance[3], rel=1e-9)


def test_a_face_that_cannot_move_has_an_admittance_of_nothing() -> None:
    held = stack((SHEET, 1e-3), termination="rigid")
    assert surface_admittance(held, FREQUENCY) == pytest.approx(0, abs=1e-15)
    with pytest.raises(InputError, match="no finite response"):
        surface_impedance(held, 100.0)


@pytest.mark.parametrize("layers", [((FOAM2, 0.03), (SHEET, 1e-3)), ((ALUMINIUM, 0.1),)])
def test_on_a_shaken_plate_the_free_face_moves_as_on_a_base(layers: Any) -> None:
    moved = stack(*layers, termination="free")
    t = transfer_matrix(moved, FREQUENCY, faces=("plate", "fluid"))
    assert 1 / t[..., 1, 1] == pytest.approx(base_motion(moved, FREQUENCY).transmissibility, rel=1e-9)


def test_under_a_plate_foam_is_stiffer_than_in_air() -> None:
    foam = stack((FOAM2, 0.03), termination="rigid")
    stiffness = surface_impedance(foam, 1.0, face="plate") * 2j * np.pi
    nu, phi = 0.3, 0.98
    frame = FOAM2["young_modulus"] * (1 + 0.1j) * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    air = GAS.pressure / phi  # isothermal
    assert stiffness * 0.03 == pytest.approx(frame + air, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "fields"), [(kind, each[1]) for kind in LAYER_SAMPLES for each in LAYER_SAMPLES[kind]]
)
def test_every_layer_type_turned_round(kind: str, fields: dict[str, Any]) -> None:
    layer = Stack.model_validate({"layers": [{"type": kind, **fields}]}).layers[0]
    faces = layer.faces(Wave.incident(FREQUENCY, ANGLE, GAS))
    again = mirrored(mirrored(faces))
    assert np.array_equal(again.front, faces.front)
    assert np.array_equal(again.back, faces.back)
    y = admittance_matrix(Stack(layers=(layer,)), FREQUENCY, ANGLE)
    assert y[..., 0, 1] == pytest.approx(y[..., 1, 0], rel=1e-8)
    assert np.all(np.linalg.eigvalsh(hermitian(y)) >= -1e-9 * np.abs(y).max(axis=(-2, -1))[..., None])


@pytest.mark.parametrize("name", ["foam", "plate and foam"])
def test_pieces_of_the_frequency_axis_make_no_difference(name: str) -> None:
    frequency = np.linspace(100, 2000, 3000)  # more points than are solved at once
    whole = admittance_matrix(PANELS[name], frequency, ANGLE)
    assert whole.shape == (3000, 3, 2, 2)
    assert whole[::700] == pytest.approx(admittance_matrix(PANELS[name], frequency[::700], ANGLE), rel=1e-12)


def test_fields_may_hold_samples() -> None:
    foam, thickness = PANELS["foam"], np.array([0.01, 0.03, 0.05])
    sampled = foam.replaced({"layers.0.thickness": thickness[:, None, None]})
    y = admittance_matrix(sampled, FREQUENCY, ANGLE)
    assert y.shape == (3, 12, 3, 2, 2)
    assert y[1] == pytest.approx(admittance_matrix(foam, FREQUENCY, ANGLE), rel=1e-9)


def test_mistakes() -> None:
    foam = PANELS["foam"]
    with pytest.raises(InputError, match="allowed: fluid, plate"):
        surface_impedance(foam, 100.0, face="wall")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="trace wavenumber is negative"):
        surface_impedance(foam, 100.0, trace_wavenumber=[-1.0])
    with pytest.raises(InputError, match="below 90"):
        surface_impedance(foam, 100.0, 90.0)

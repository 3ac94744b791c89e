"""Derivatives of responses by fields: every quantity, diffuse fields, samples, layers of others, and mistakes."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.layers import Layer
from multilayer.layers.elastic_solid import ElasticSolid, solid_faces
from multilayer.layers.fluid import Fluid, FluidSlab
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import FLUID
from multilayer.media.elastic import lame
from multilayer.paths import locate
from multilayer.response import (
    Window,
    base_motion,
    base_motion_derivatives,
    diffuse_field,
    diffuse_field_derivatives,
    plane_wave,
    plane_wave_derivatives,
)
from multilayer.response.linearised import real_fields
from multilayer.stack import Stack

FREQUENCY = np.array([120.0, 800.0, 3000.0])
ANGLE = np.array([0.0, 40.0, 75.0])
PLATE = {"type": "elastic_plate", "name": "plate", "thickness": 1e-3, "density": 2700.0, "young_modulus": 7e10,
         "poisson_ratio": 0.33, "loss_factor": 0.01}  # fmt: skip
WOOL = {"type": "equivalent_fluid", "name": "wool", "thickness": 0.05, "porosity": 0.95, "flow_resistivity": 1e4,
        "tortuosity": 1.1, "viscous_length": 1e-4, "thermal_length": 2e-4}  # fmt: skip
RUBBER = {"type": "elastic_solid", "name": "rubber", "thickness": 0.02, "density": 1100.0, "poisson_ratio": 0.48,
          "young_modulus": {"law": "fractional_zener", "relaxed_modulus": 2e6, "unrelaxed_modulus": 1e8,
                            "relaxation_time": 1e-5, "order": 0.6}}  # fmt: skip


def stack(*layers: dict[str, Any] | Layer, termination: Any = "ambient") -> Stack:
    return Stack.model_validate({"layers": list(layers), "termination": termination})


def differences(response, panel: Stack, path: str, step: float = 1e-3):
    """Return the derivative of a response by a field, by differences of sixth order."""
    value = locate(panel, path).value
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    ends = {n: response(panel.replaced({path: value * (1 + n * step)})) for n in (1, -1, 2, -2, 3, -3)}
    return sum(weight * (ends[n] - ends[-n]) for n, weight in weights.items()) / (value * step)


def assert_same(found, expected, rtol=1e-7):
    assert np.shape(found) == np.shape(expected)
    assert np.max(np.abs(found - expected)) <= rtol * np.max(np.abs(expected))


def test_layers_called_by_numbers() -> None:
    named = plane_wave_derivatives(stack(PLATE, WOOL, RUBBER), None, FREQUENCY, ANGLE)
    layers = [{**layer, "name": name} for name, layer in zip("123", (PLATE, WOOL, RUBBER), strict=True)]
    found = plane_wave_derivatives(stack(*layers), None, FREQUENCY, ANGLE)
    assert found.fields[0].startswith("layers.1.")
    np.testing.assert_array_equal(found.reflection, named.reflection)


@pytest.mark.parametrize("termination", ["ambient", "rigid"])
def test_every_quantity_of_a_plane_wave(termination: str) -> None:
    panel = stack(PLATE, WOOL, RUBBER, termination=termination)
    found = plane_wave_derivatives(panel, None, FREQUENCY, ANGLE)
    expected = plane_wave(panel, FREQUENCY, ANGLE)
    np.testing.assert_array_equal(found.response.reflection, expected.reflection)
    quantities = ["reflection", "surface_impedance", "absorption"]
    if termination == "ambient":
        quantities += ["transmission", "transmission_loss"]
    else:
        assert found.transmission is None
        assert found.transmission_loss is None
    for path in ("layers.plate.thickness", "layers.wool.flow_resistivity", "layers.rubber.young_modulus.order"):
        assert set(found.by(path)) == set(quantities)
        for name in quantities:
            expected = differences(lambda s, name=name: getattr(plane_wave(s, FREQUENCY, ANGLE), name), panel, path)
            assert_same(found.by(path)[name], expected)


def test_all_fields_are_those_with_a_quantity() -> None:
    paths = real_fields(stack({"type": "fluid", "thickness": 0.1}, RUBBER), None)
    assert paths == (
        "layers.0.thickness", "layers.rubber.young_modulus.relaxed_modulus",
        "layers.rubber.young_modulus.unrelaxed_modulus", "layers.rubber.young_modulus.relaxation_time",
        "layers.rubber.young_modulus.order", "layers.rubber.poisson_ratio", "layers.rubber.loss_factor",
        "layers.rubber.thickness", "layers.rubber.density",
    )  # fmt: skip


def test_a_name_that_no_path_can_hold_stands_as_an_index() -> None:
    named = Stack.model_validate({"layers": [{"type": "fluid", "name": "gap 1.5", "thickness": 0.1}]})
    assert real_fields(named, None) == ("layers.0.thickness",)


def test_a_shaken_base() -> None:
    panel = stack({**PLATE, "type": "elastic_solid", "name": "base"}, RUBBER, termination="free")
    found = base_motion_derivatives(panel, ["layers.rubber.thickness", "layers.rubber.density"], FREQUENCY)
    np.testing.assert_array_equal(found.response.transmissibility, base_motion(panel, FREQUENCY).transmissibility)
    for path in found.fields:
        expected = differences(lambda s: base_motion(s, FREQUENCY).transmissibility, panel, path)
        assert_same(found.by(path)["transmissibility"], expected)


def test_pieces_of_a_long_frequency_axis_are_joined() -> None:
    panel, f = stack(PLATE, WOOL), np.geomspace(50.0, 5000.0, 5000)
    whole = plane_wave_derivatives(panel, ["layers.wool.thickness"], f)
    shared = plane_wave_derivatives(panel, ["layers.wool.thickness"], f, workers=2)
    some = plane_wave_derivatives(panel, ["layers.wool.thickness"], f[::500])
    assert whole.absorption.shape == (1, 5000)
    np.testing.assert_allclose(whole.transmission_loss[:, ::500], some.transmission_loss, rtol=1e-9)
    np.testing.assert_allclose(shared.absorption, whole.absorption, rtol=1e-9)


def test_samples_in_fields() -> None:
    panel = stack(PLATE, WOOL)
    thickness = np.array([0.02, 0.05, 0.2])
    several = panel.replaced({"layers.wool.thickness": thickness[:, None, None]})
    paths = ["layers.wool.thickness", "layers.plate.density"]
    found = plane_wave_derivatives(several, paths, FREQUENCY, ANGLE)
    assert found.reflection.shape == (2, 3, 3, 3)
    for i, value in enumerate(thickness):
        one = panel.replaced({"layers.wool.thickness": float(value)})
        np.testing.assert_allclose(
            found.reflection[:, i], plane_wave_derivatives(one, paths, FREQUENCY, ANGLE).reflection, rtol=1e-9
        )
    every = plane_wave_derivatives(several, None, FREQUENCY, ANGLE)  # of the same layer, too
    np.testing.assert_array_equal(every.by(paths[0])["reflection"], found.reflection[0])
    table = found.to_pandas()
    assert len(table) == 2 * 27
    assert set(table["field"]) == set(paths)


TIGHT: dict[str, Any] = {"tolerance_db": 1e-5, "tolerance": 1e-7, "max_panels": 300}


@pytest.mark.parametrize("options", [{}, {"window": Window(1.2, 0.8), "weighting": "gaussian"}])
def test_a_diffuse_field(options: dict[str, Any]) -> None:
    panel, f = stack(PLATE, WOOL), np.array([200.0, 1000.0])
    found = diffuse_field_derivatives(panel, ["layers.wool.flow_resistivity"], f, **options, **TIGHT)
    expected = diffuse_field(panel, f, **options, **TIGHT)
    np.testing.assert_array_equal(found.response.transmission_loss, expected.transmission_loss)
    for path in found.fields:
        for name in ("absorption", "transmission_coefficient", "transmission_loss"):
            expected = differences(
                lambda s, name=name: getattr(diffuse_field(s, f, **options, **TIGHT), name), panel, path
            )
            assert_same(found.by(path)[name], expected, rtol=1e-5)


def test_a_diffuse_field_on_a_wall() -> None:
    found = diffuse_field_derivatives(stack(WOOL, termination="rigid"), ["layers.wool.thickness"], 300.0)
    assert found.transmission_loss is None
    assert found.absorption.shape == (1,)
    assert found.absorption[0] > 0  # thicker wool absorbs more, below its first resonance


def test_a_diffuse_field_of_a_board_that_has_a_grain() -> None:
    board = {"type": "orthotropic_plate", "name": "board", "thickness": 0.01, "density": 500.0,
             "young_modulus_x": 1e10, "young_modulus_y": 5e8, "poisson_ratio_xy": 0.3, "shear_modulus_xy": 6e8,
             "loss_factor": 0.05}  # fmt: skip
    panel, f = stack(board), np.array([150.0, 500.0])
    options = {"tolerance_db": 1e-3, "tolerance": 1e-6}
    found = diffuse_field_derivatives(panel, ["layers.board.thickness"], f, **options)
    assert found.response.angles[0] > 200
    expected = differences(
        lambda s: diffuse_field(s, f, **options).transmission_loss, panel, "layers.board.thickness", step=3e-3
    )
    assert_same(found.transmission_loss[0], expected, rtol=1e-3)


class _Bare(Fluid):
    """A fluid that does not say what it was made from."""

    type: Literal["bare"] = "bare"  # type: ignore[assignment]

    def faces(self, wave):
        slab = FluidSlab(wave, self.thickness, *self._medium(wave))
        return Faces(FLUID, *slab.matrices())


class _Pressed(ElasticSolid):
    """A solid that stiffens with the thickness of what lies on it."""

    type: Literal["pressed"] = "pressed"  # type: ignore[assignment]
    above: float = 0.0

    def under(self, above: Sequence[Layer]) -> Layer:
        return self.model_copy(update={"above": sum(layer.thickness for layer in above)})

    def faces(self, wave):
        modulus = self.complex_modulus(wave) * (1 + 10 * self.above)
        return solid_faces(wave, self.thickness, self.density, *lame(modulus, self.poisson_ratio))


def test_layers_of_unknown_media_fall_back_to_differences() -> None:
    panel = Stack(layers=(_Bare(name="gap", thickness=0.1, density=1.3, sound_speed=330.0), Fluid(thickness=0.05)))
    known = Stack(layers=(Fluid(name="gap", thickness=0.1, density=1.3, sound_speed=330.0), Fluid(thickness=0.05)))
    found = plane_wave_derivatives(panel, None, FREQUENCY, ANGLE)
    expected = plane_wave_derivatives(known, None, FREQUENCY, ANGLE)
    assert found.by_differences == ("layers.gap.thickness", "layers.gap.density", "layers.gap.sound_speed")
    assert expected.by_differences == ()
    assert_same(found.reflection[-1], expected.reflection[-1], 1e-12)
    for i in range(3):
        assert_same(found.reflection[i], expected.reflection[i], 1e-8)


def test_a_layer_that_depends_on_those_above() -> None:
    solid = {"density": 500.0, "young_modulus": 1e7, "poisson_ratio": 0.3, "loss_factor": 0.2}
    panel = Stack(
        layers=(ElasticSolid(name="top", thickness=0.01, **solid), _Pressed(name="low", thickness=0.03, **solid))
    )
    found = plane_wave_derivatives(panel, ["layers.top.thickness"], FREQUENCY, ANGLE)
    expected = differences(lambda s: plane_wave(s, FREQUENCY, ANGLE).reflection, panel, "layers.top.thickness")
    assert_same(found.reflection[0], expected)


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("layers.wol.thickness", "'layers.wol.thickness' leads nowhere: there is no 'wol' in layers; did you mean"),
        ("ambient.temperature", "'ambient.temperature' is no field of a layer"),
        ("layers.wool.model", "'layers.wool.model' holds 'jca'"),
        ("layers.wool.cell_size", "'layers.wool.cell_size' holds None"),
        ("layers.wool", "'layers.wool' leads to no single value"),
    ],
)
def test_what_has_no_derivative(path: str, text: str) -> None:
    for derive in (plane_wave_derivatives, diffuse_field_derivatives, base_motion_derivatives):
        with pytest.raises(InputError, match=text.replace(".", r"\.")):
            derive(stack(PLATE, WOOL), [path], FREQUENCY)


def test_what_was_not_asked_for() -> None:
    found = plane_wave_derivatives(stack(WOOL), ["layers.wool.thickness"], FREQUENCY)
    with pytest.raises(InputError, match=r"there is no derivative by 'layers\.wool\.porosity'"):
        found.by("layers.wool.porosity")

"""`check_layer` catches layers that are wrong, one law at a time."""

import re
import warnings
from typing import Annotated, ClassVar, Literal

import numpy as np
import pytest
from pydantic import Field

from multilayer.errors import ValidityWarning
from multilayer.layers import LAYERS, Layer
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.elastic_solid import ElasticSolid, solid_faces
from multilayer.layers.fluid import Fluid, FluidSlab, fluid_faces
from multilayer.layers.orthotropic_plate import OrthotropicPlate
from multilayer.matrix.faces import Faces, FacesOf, from_propagator, stack_entries
from multilayer.matrix.families import FLUID
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import lame
from multilayer.testing import check_layer
from multilayer.units import Length, Unit

BOARD = {"thickness": 0.01, "density": 450.0, "young_modulus_x": 11e9, "young_modulus_y": 5e8, "poisson_ratio_xy": 0.4,
         "shear_modulus_xy": 7e8, "loss_factor": 0.02}  # fmt: skip
SOLID = {"thickness": 0.01, "density": 300.0, "young_modulus": 1e6, "poisson_ratio": 0.3}


def sheet(wave, lower_left=0.0, upper_right=0.0, determinant=1.0):
    """Return the faces of a fluid-like sheet with the propagator [[1, -upper_right], [lower_left, ...]]."""
    one = np.ones_like(wave.omega * wave.kx + 0j)
    lower_right = (determinant - upper_right * lower_left) * one
    propagator = stack_entries([[one, -upper_right * one], [lower_left * one, lower_right]])
    return Faces(FLUID, *from_propagator(FLUID, propagator, wave.ambient.impedance))


class CreatesPower(Fluid):
    """A fluid of the wrong sign of loss."""

    def faces(self, wave):
        return fluid_faces(wave, self.thickness, 1.2, 1.4e5 * (1 - 0.01j))


class LosesPower(Fluid):
    def faces(self, wave):
        return fluid_faces(wave, self.thickness, 1.2, 1.4e5 * (1 + 0.01j))


class NegativeLoss(ElasticSolid):
    def faces(self, wave):
        lam, mu = lame(self.young_modulus * (1 - 0.001j), self.poisson_ratio)
        return solid_faces(wave, self.thickness, self.density, lam, mu)


class OneWay(Fluid):
    """What comes out is a tenth more than what went in, in one direction."""

    composes: ClassVar[bool] = False

    def faces(self, wave):
        return sheet(wave, determinant=0.9)


class BendsAsAPlate(ElasticPlate):
    composes: ClassVar[bool] = True


class ForgetsTheAngle(Fluid):
    """Takes one incidence only."""

    def faces(self, wave):
        if np.size(wave.kx) > np.size(wave.frequency):
            kx = wave.kx[..., 0]
            raise ValueError(f"operands could not be broadcast together with shapes {kx.shape}")
        return super().faces(wave)


class MixesFrequencies(Fluid):
    """Uses the first frequency for all."""

    def faces(self, wave):
        resistance = 100.0 * np.ravel(wave.frequency)[0]
        return sheet(wave, upper_right=resistance)


class TakesOneThickness(Fluid):
    def faces(self, wave):
        return fluid_faces(wave, float(np.mean(self.thickness)), 1.2, 1.4e5)


class NeverThin(Fluid):
    """Keeps a resistance however thin it is."""

    composes: ClassVar[bool] = False

    def faces(self, wave):
        return sheet(wave, upper_right=100.0)


class SpecialAtNormalIncidence(Fluid):
    def faces(self, wave):
        density = np.where(wave.kx == 0, 1.2, 1.3)
        return fluid_faces(wave, self.thickness, density, 1.4e5)


class JumpsNearGrazing(Fluid):
    def faces(self, wave):
        sine = wave.kx / (wave.omega / wave.ambient.sound_speed)
        density = np.where(sine < np.sin(np.radians(89.9)) * (1 + 1e-12), 1.2, 2.4)
        return fluid_faces(wave, self.thickness, density, 1.4e5)


class NotANumber(Fluid):
    def faces(self, wave):
        return sheet(wave, upper_right=np.nan)


class WrongShape(Fluid):
    def faces(self, wave):
        faces = super().faces(wave)
        return Faces(FLUID, faces.front[:1], faces.back[:1])


class ForgetsItsFile(Fluid):
    """A field that is not written to files."""

    colour: Annotated[str, Field(exclude=True)] = "red"
    width: Length = 1.0


class ClaimsToBeIsotropic(OrthotropicPlate):
    isotropic_in_plane: ClassVar[bool] = True


class KnowsItsAzimuthOnly(OrthotropicPlate):
    """Turns with its field, not with the wave: written before waves had azimuths."""

    def faces(self, wave):
        return super().faces(Wave(wave.frequency, wave.kx, wave.ambient))


class HasTwoEnds(Fluid):
    """Half a turn makes another layer of it."""

    composes: ClassVar[bool] = False
    isotropic_in_plane: ClassVar[bool] = False

    def faces(self, wave):
        return sheet(wave, upper_right=100.0 * (2 + np.cos(np.deg2rad(wave.azimuth))))


class TakesOneAzimuth(OrthotropicPlate):
    def faces(self, wave):
        first = np.ravel(wave.azimuth)[0]
        return super().faces(Wave(wave.frequency, wave.kx, wave.ambient, np.asarray(first)))


class TakesTheModulus(Fluid):
    """Right for the waves of rooms, whose wavenumbers along the layer are real."""

    def faces(self, wave):
        return super().faces(Wave(wave.frequency, np.abs(wave.kx), wave.ambient))


class Misled(FluidSlab):
    def by_medium(self, x, y):
        return tuple(1.001 * slope for slope in super().by_medium(x, y))


class OfNoUnit(Fluid):
    """A field whose unit nobody knows."""

    width: Annotated[float, Unit("smoot per fortnight")] = 1.0


class InMillimetres(Fluid):
    """A field whose unit is not SI."""

    width: Annotated[float, Unit("mm")] = 1.0


class WrongDerivative(Fluid):
    """The right matrices, with wrong derivatives by the medium."""

    def faces(self, wave):
        return FacesOf(Misled(wave, self.thickness, *self._medium(wave)))


WRONG = [
    (CreatesPower, {"thickness": 0.1}, "passivity: some fields leave with more power than they bring"),
    (CreatesPower, {"thickness": 0.1}, "passivity: termination rigid: power is created"),
    (CreatesPower, {"thickness": 0.1}, "passivity: termination ambient: power is created"),
    (NegativeLoss, SOLID, "passivity: some fields leave with more power than they bring"),
    (LosesPower, {"thickness": 0.1}, "energy balance: termination ambient: power is lost"),
    (OneWay, {"thickness": 0.1}, "reciprocity: the two faces differ by 0.0"),
    (BendsAsAPlate, {**SOLID, "young_modulus": 1e9}, "composition: .* is not 0.3 and 0.7 of it"),
    (ForgetsTheAngle, {"thickness": 0.1}, "broadcasting: ValueError: operands could not be broadcast"),
    (MixesFrequencies, {"thickness": 0.1}, "broadcasting: arrays and single numbers differ by .* Hz, .* degrees"),
    (TakesOneThickness, {"thickness": 0.1}, "broadcasting: an array and single numbers of thickness differ by"),
    (NeverThin, {"thickness": 0.1}, "vanishing thickness: .* stays 0.2"),
    (SpecialAtNormalIncidence, {"thickness": 0.1}, "normal incidence: .*: 0 and 1e-6 degrees differ by"),
    (JumpsNearGrazing, {"thickness": 0.1}, "grazing incidence: .*: the reflection jumps near 89.9 degrees"),
    (ClaimsToBeIsotropic, BOARD, "azimuth: .*: isotropic_in_plane is true, yet the azimuth changes the response by"),
    (KnowsItsAzimuthOnly, BOARD, "azimuth: .*: the same turn of the wave and of the field azimuth differ by"),
    (HasTwoEnds, {"thickness": 0.1}, "azimuth: .*: half a turn of the azimuth changes the response by"),
    (TakesOneAzimuth, BOARD, "azimuth: .*: an array and single numbers of the azimuth differ by"),
    (TakesTheModulus, {"thickness": 0.1}, "decaying waves: .*: at complex kx the response is not analytic in kx, by"),
    (NotANumber, {"thickness": 0.1}, "well formed faces: the back matrix holds numbers that are not finite"),
    (WrongShape, {"thickness": 0.1}, "well formed faces: the front matrix is 1 x 2, not 2 x 2"),
    (OfNoUnit, {"thickness": 0.1}, "units: the unit 'smoot per fortnight' of field 'width' is unknown"),
    (InMillimetres, {"thickness": 0.1}, "units: the unit 'mm' of field 'width' is not SI: 1 mm is 0.001 meter"),
    (WrongDerivative, {"thickness": 0.1, "density": 1.3}, "derivatives: the derivative by density and differences"),
    (ForgetsItsFile, {"thickness": 0.1, "colour": "blue"}, "yaml round trip: .* comes back as"),
]


def registered(wrong: type[Layer], fields):
    """Return a layer of a subclass with a `type` of its own, registered under it."""
    name = wrong.__name__.lower()
    kind = type(wrong.__name__, (wrong,), {"__annotations__": {"type": Literal[name]}, "type": name})
    LAYERS.register(name, kind)
    return name, kind.model_validate(fields)


@pytest.mark.parametrize(("wrong", "fields", "words"), WRONG, ids=lambda value: getattr(value, "__name__", None))
def test_wrong_layers_are_caught(wrong, fields, words):
    name, layer = registered(wrong, fields)
    try:
        with pytest.raises(AssertionError) as caught:
            check_layer(layer, lossless=wrong is LosesPower)
    finally:
        LAYERS.unregister(name)
    message = str(caught.value)
    assert message.startswith(f"a layer of type '{name}' breaks these laws:")
    assert re.search(f"^- {words}", message, re.MULTILINE), message


def test_only_the_law_that_is_broken_is_told():
    name, layer = registered(BendsAsAPlate, {**SOLID, "young_modulus": 1e9})
    try:
        with pytest.raises(AssertionError) as caught:
            check_layer(layer)
    finally:
        LAYERS.unregister(name)
    assert all(line.startswith("- composition: ") for line in str(caught.value).splitlines()[1:])


def test_a_layer_that_no_file_can_name():
    class Unregistered(Fluid):
        type: Literal["unheard_of"] = "unheard_of"

    with pytest.raises(AssertionError, match=r"no entry point 'multilayer\.layers' is called 'unheard_of'"):
        check_layer(Unregistered(thickness=0.1))


def test_a_formula_outside_its_range_keeps_the_laws():
    class Warns(Fluid):
        def faces(self, wave):
            warnings.warn("beyond its range", ValidityWarning, stacklevel=2)
            return super().faces(wave)

    name, layer = registered(Warns, {"thickness": 0.1})
    try:
        check_layer(layer)
    finally:
        LAYERS.unregister(name)


def test_a_band_may_be_given():
    check_layer(Fluid(thickness=0.1), frequency=[100.0, 200.0])

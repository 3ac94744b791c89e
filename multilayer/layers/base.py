"""Base classes of layers, and the registry of layer types."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import PlainSerializer, PlainValidator, ValidationError, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from multilayer.arrays import ArrayLike, ComplexArray, Numeric
from multilayer.errors import InputError, show, suggest
from multilayer.frames import html_table
from multilayer.json_schema import Written, by_name
from multilayer.matrix.equations import FieldEquations
from multilayer.matrix.faces import Faces
from multilayer.matrix.wave import Wave
from multilayer.media.gas import Gas, dry_air
from multilayer.media.laws import Modulus, ModulusLaw, Table, complex_modulus
from multilayer.models import InWords, Model, misspelt
from multilayer.registry import Registry, RegistryError, subclass_fault
from multilayer.units import PoissonRatio, Ratio, asked_back

# least and largest value of fields that are hardly ever beyond: there a number in another unit was meant
_HARDLY = {
    "thickness": (0.0, 5.0, "a layer", "m", "mm"),
    "density": (10.0, np.inf, "a density", "kg/m3", "g/cm3"),  # of what has a stiffness: gases are lighter
    "frame_density": (0.5, np.inf, "a frame density", "kg/m3", "g/cm3"),
    "young_modulus": (500.0, np.inf, "a Young's modulus", "Pa", "GPa"),
    "flow_resistivity": (50.0, np.inf, "a flow resistivity", "N s/m4", "kN s/m4"),
    "viscous_length": (0.0, 0.01, "pores", "m", "um"),
    "thermal_length": (0.0, 0.01, "pores", "m", "um"),
}
_LEAST_POROSITY, _MOST_LOSS = 0.1, 2.0  # beyond, '%' was written twice or forgotten
_ASKED_AT = 1000.0  # Hz, of laws


class Layer(Model, metaclass=InWords):
    """A homogeneous slab of one kind of medium.

    A layer type is a subclass with a `Literal` field ``type``, fields typed from `multilayer.units`, and `faces`. It
    becomes known under the entry point ``multilayer.layers`` of the same name. See ``docs/design.md``.

    A type whose response depends on `Wave.azimuth` sets ``isotropic_in_plane = False``; a diffuse field is averaged
    over the azimuth then. Its field ``azimuth``, if it has one, is its orientation and added to that of the wave. Half
    a turn changes nothing, as is true of every layer that is its own mirror image along axis 3.

    Fields hold plain numbers when read from a file; code may put arrays there (`Stack.replaced`), which then broadcast
    against frequency and angle.
    """

    type: str
    name: str | None = None

    also_written: ClassVar[tuple[str, ...]] = ("material",)
    summary: ClassVar[str] = ""
    examples: ClassVar[tuple[Mapping[str, Any], ...]] = ()  # fields of typical layers, for tests of a plugin's type
    composes: ClassVar[bool] = True  # a homogeneous slab: two bonded layers equal one of their joint thickness
    vanishes: ClassVar[bool] = True  # an infinitely thin layer has no effect
    stands_still: ClassVar[bool] = False  # nothing but gas moves in it, unless its fields tell a mass
    lies_on_frames: ClassVar[bool] = False  # a sheet without pores of state (p, v3), which a contact puts on a frame
    isotropic_in_plane: ClassVar[bool] = True  # the azimuth of a wave makes no difference

    def _repr_html_(self) -> str:
        rows = [(str(name), str(text)) for name, text in self.__repr_args__()]
        return html_table(("field", "value"), rows, f"{self.type}: {self.summary}")

    @classmethod
    def fields_taken(cls, data: Mapping[str, Any]) -> frozenset[str]:
        """Return the fields that a layer of such data may have; further fields of a library's material are left out.

        Parameters
        ----------
        data : mapping
            The layer's fields in an input, not validated.
        """
        del data
        return frozenset(cls.model_fields)

    def implausible(self) -> Iterator[tuple[str, str]]:
        """Give field and text of values that are allowed, and hardly ever meant."""
        modulus = getattr(self, "young_modulus", None)
        for field, (least, most, what, unit, other) in _HARDLY.items():
            value = _storage_modulus(modulus) if field == "young_modulus" else getattr(self, field, None)
            if not isinstance(value, float) or least <= value <= most or value == 0:
                continue
            if field != "density" or hasattr(self, "young_modulus"):
                yield field, asked_back(what, value, unit, other)
        porosity = getattr(self, "porosity", None)
        if isinstance(porosity, float) and porosity < _LEAST_POROSITY:
            meant = 100 * porosity if porosity < 0.01 else 1 - porosity  # '0.98 %', or the share of the solid
            yield "porosity", f"a porosity of {porosity:g}, which is {100 * porosity:g} %: is {meant:g} meant?"
        for owner, field in ((self, "loss_factor"), (modulus, "young_modulus")):  # a law may have a loss factor, too
            loss = getattr(owner, "loss_factor", None)
            if isinstance(loss, float) and loss > _MOST_LOSS:
                yield field, f"a loss factor of {loss:g}, which is {100 * loss:g} %: is '{loss:g} %' meant?"

    @property
    def depth(self) -> Numeric:
        """How much room the layer takes along axis 3, m: its `thickness`, none for a sheet without."""
        thickness: Numeric | None = getattr(self, "thickness", None)
        return 0.0 if thickness is None else thickness

    @property
    def volume_per_area(self) -> Numeric:
        """Volume of the layer's material over area, m: its `depth`, but for sheets that are bent or have ribs."""
        return self.depth

    @property
    def mass_per_area(self) -> Numeric | None:
        """Mass over area, kg/m2, the gas in the layer left out; None where the fields do not tell it."""
        for name in ("density", "frame_density"):
            density: Numeric | None = getattr(self, name, None)
            if density is not None:
                return density * self.volume_per_area
        sheet: Numeric | None = getattr(self, "surface_density", None)
        return sheet

    @abstractmethod
    def faces(self, wave: Wave) -> Faces:
        """Return the face matrices for a plane harmonic field.

        Parameters
        ----------
        wave : Wave
            Frequency, trace wavenumber, azimuth and ambient gas.
        """
        raise NotImplementedError

    def field_equations(self, wave: Wave) -> FieldEquations | None:
        """Return the field equations of the layer's medium, from which other layers are built; None where it has none.

        Parameters
        ----------
        wave : Wave
        """
        del wave
        return None

    def under(self, above: Sequence[Layer]) -> Layer:
        """Return the layer as it is under the layers that lie on it; itself unless its properties depend on them.

        Parameters
        ----------
        above : sequence of Layer
            The nearest first.
        """
        del above
        return self

    def sliced(self, n: int) -> tuple[Layer, ...]:
        """Return `n` slices that are the layer when bonded; the layer alone where it has no inside to look at.

        Parameters
        ----------
        n : int
        """
        thickness = getattr(self, "thickness", None)
        if not self.composes or thickness is None:
            return (self,)
        return (self.model_copy(update={"thickness": thickness / n}),) * n

    def transfer_matrix(
        self, frequency: ArrayLike, angle: ArrayLike = 0.0, gas: Gas | None = None, *, azimuth: ArrayLike = 0.0
    ) -> ComplexArray:
        """Return the transfer matrix T of Allard & Atalla, V(front) = T V(back).

        Parameters
        ----------
        frequency : array
            Hz.
        angle : array
            Degrees from the normal in `gas`.
        gas : Gas, optional
            Incident and saturating gas; dry air at 20 degC when left out.
        azimuth : array
            Degrees about the normal.

        Returns
        -------
        complex array, shape (..., n_state, n_state)
            ``...`` is the shape of `frequency` followed by those of `angle` and `azimuth`.

        Notes
        -----
        For reading and for thin layers: T of a layer much thicker than its waves' decay lengths holds numbers of
        the size exp(abs(Im k) h), and no arithmetic can use it. The solver works from the face matrices instead.
        """
        faces = self.faces(Wave.incident(frequency, angle, gas or dry_air(), azimuth))
        shape = np.shape(frequency) + np.shape(angle) + np.shape(azimuth)
        front, back = (
            np.broadcast_to(m, m.shape[:2] + shape).transpose(*range(2, 2 + len(shape)), 1, 0)
            for m in (faces.front, faces.back)
        )
        # T B = A, transposed: B^T T^T = A^T
        return np.asarray(np.swapaxes(np.linalg.solve(back, front), -1, -2))


class ElasticLayer(Layer):
    """A layer with an isotropic elastic skeleton, damped once: by its modulus or by `loss_factor`."""

    young_modulus: Modulus
    poisson_ratio: PoissonRatio
    loss_factor: Ratio = 0.0

    @model_validator(mode="after")
    def _damped_once(self) -> Self:
        if self.loss_factor and not isinstance(self.young_modulus, float | int):
            text = "loss_factor stands beside a young_modulus that has losses already; give one of the two"
            raise ValueError(f"{text}, or write 'loss_factor: 0'")
        return self

    def complex_modulus(self, wave: Wave) -> Numeric:
        """Return E1 + i E2, Pa, at the frequencies of `wave`."""
        return complex_modulus(self.young_modulus, self.loss_factor, wave.frequency)


def _storage_modulus(modulus: Any) -> Any:
    """Return E1, Pa, of a modulus; of a law at 1 kHz, of a table at the nearest of its frequencies."""
    if not isinstance(modulus, ModulusLaw):
        return modulus.real if isinstance(modulus, complex) else modulus
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of validity: they come when something is computed
            ends = (modulus.frequency[0], modulus.frequency[-1]) if isinstance(modulus, Table) else (0.0, np.inf)
            return float(modulus(np.clip(_ASKED_AT, *ends)).real)
    except Exception:  # a table within ends before, or a plugin is broken, which comes when something is computed
        return _storage_modulus(getattr(modulus, "modulus", None))


LAYERS: Registry[type[Layer]] = Registry("multilayer.layers", "layer", subclass_fault(Layer, "type"))


def _parse_layer(value: Any, info: ValidationInfo) -> Layer:
    if isinstance(value, Layer):
        return value
    if not isinstance(value, Mapping):
        raise _refused(f"must be a mapping such as {{type: fluid, thickness: 50 mm}}, not {value!r}")
    if value.get("type") is None:
        for key in get_close_matches("type", set(value) - {"type"}, n=1):
            raise ValidationError.from_exception_data("layer", [misspelt((key,), "type")])
        raise _refused(f"has no 'type'; allowed: {', '.join(LAYERS.names())}; or name a 'material'")
    try:
        layer = layer_type(value["type"])
    except InputError as error:
        raise _refused(str(error)) from None
    return layer.model_validate(dict(value), context=info.context)


def layer_type(name: Any) -> type[Layer]:
    """Return the layer type that an input names.

    Raises
    ------
    InputError
        When there is none, with the nearest, or it does not load.
    """
    if name not in LAYERS:
        raise InputError(f"there is no layer type {show(name)}; {suggest(str(name), LAYERS.names())}")
    try:
        return LAYERS[str(name)]
    except RegistryError as error:
        raise InputError(str(error)) from None


def _refused(reason: str) -> PydanticCustomError:
    return PydanticCustomError("layer", "{reason}", {"reason": reason})


def _serialise_layer(layer: Layer) -> dict[str, Any]:
    return layer.model_dump(mode="json", exclude_none=True)


LayerField = Annotated[
    Layer,
    PlainValidator(_parse_layer),
    PlainSerializer(_serialise_layer),
    Written(lambda handler: by_name(LAYERS, "type", handler)),
]

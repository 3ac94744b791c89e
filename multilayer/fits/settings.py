"""What a user may set about a fit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from multilayer.errors import suggest
from multilayer.experiments.two_plate.settings import RigSettings
from multilayer.fits.methods import LEAST_SQUARES, METHODS, NELDER_MEAD
from multilayer.json_schema import Written
from multilayer.measurements.implausible import implausible_fields
from multilayer.models import Model, refuse
from multilayer.registry import RegistryError
from multilayer.units import Duration, Frequency, Positive, Pressure, Ratio, Unit

DEFAULT_LAW = "fractional_zener"  # of joint fits
RigModel = Literal["plane_wave", "finite"]
Start = Literal["neighbour", "quasi_static"]
Level = Annotated[float, Positive, Unit("")]


def _method(name: str) -> str:
    """Return the name of a method of campaigns."""
    if name not in METHODS:
        raise ValueError(f"there is no method '{name}'; {suggest(name, METHODS.names())}")
    try:
        reads = METHODS[name].reads
    except RegistryError as error:
        raise ValueError(str(error)) from None
    if reads != "campaign":
        raise ValueError(f"'{name}' fits no campaigns, but what a {reads} file says")
    return name


MethodName = Annotated[
    str,
    AfterValidator(_method),
    Written(lambda _: {"enum": [name for name, method in METHODS.working() if method.reads == "campaign"]}),
]


class Bounds(Model):
    """Where a solution is sought."""

    storage_modulus: tuple[Pressure, Pressure] = (1e3, 1e9)
    loss_factor: tuple[Ratio, Ratio] = (0.0, 2.0)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in ("storage_modulus", "loss_factor"):
            low, high = getattr(self, name)
            if low >= high:
                raise ValueError(f"{name}: the lower bound {low:g} must lie below the upper bound {high:g}")
        return self


class Acceptance(Model):
    """Bonfiglio & Pompoli 2015, eq. (10).

    `time_of_flight` is one sampling interval when left out; `level_db` is in dB.
    """

    time_of_flight: Duration | None = None
    level_db: Level = 0.5


class QuasiStatic(Model):
    """Moduli from another, quasi-static method: a starting value for Nelder-Mead, and a line in the figures."""

    storage_modulus: Pressure
    loss_modulus: Annotated[float, Field(ge=0), Unit("Pa")]
    frequency: Frequency = 5.0


class FitSettings(RigSettings):
    """A fit file, or the defaults for a campaign given alone.

    Attributes
    ----------
    campaign : path
        Campaign folder or file, relative to the fit file.
    method : str
        One of `multilayer.fits.methods.METHODS` that reads campaigns. See ``docs/inverse.md``; ``nelder-mead`` is the
        method of the paper to the letter.
    model : {'plane_wave', 'finite'}
        Of the rig: layers of infinite extent, or finite elements of the disc with its free rim, which need
        ``method: least-squares``.
    termination : {'free', 'ambient'} or None
        What lies above the top plate: nothing, or the half-space of air of the paper, whose plane-wave radiation
        resistance a plate of a few centimetres does not have. By default what the method is meant with: ``ambient`` for
        nelder-mead, ``free`` for all others.
    dispersion : {'local', 'none'} or None
        How the modulus varies within the band of one burst: as the causal power law of its own loss factor, or not at
        all (as in the paper). By default ``none`` for nelder-mead, ``local`` for all others.
    start : {'neighbour', 'quasi_static'}
        Where ``nelder-mead`` starts: at the last accepted solution of the same configuration, by rising frequency, or
        at `quasi_static` in every burst. Both start at `quasi_static` where nothing is accepted yet, and where that is
        not given at what a search over the whole range finds.
    calibration : path, optional
        A calibration campaign: both accelerometers at one spot.
    ambient, pores, sensor_mass
        Those of `RigSettings`.
    """

    version: Literal[1] = 1
    campaign: Path = Path()
    method: MethodName = LEAST_SQUARES
    model: RigModel = "plane_wave"
    termination: Literal["free", "ambient"] | None = None
    dispersion: Literal["local", "none"] | None = None
    bounds: Bounds = Bounds()
    acceptance: Acceptance = Acceptance()
    quasi_static: QuasiStatic | None = None
    start: Start = "neighbour"
    calibration: Path | None = None

    @model_validator(mode="after")
    def _possible(self) -> Self:
        mistakes: list[tuple[tuple[str, ...], str, str]] = []
        if self.model == "plane_wave" and self.pores is not None and self.pores.rim == "open":
            text = "plane waves have no rim for air to leave by; use model: finite, or rim: sealed"
            mistakes.append((("pores", "rim"), text, "open"))
        if self.model == "finite":
            if self.method == NELDER_MEAD:
                text = (
                    f"{self.method} is the paper's method with the paper's model; use least-squares with model: finite"
                )
                mistakes.append((("method",), text, self.method))
            if self.termination == "ambient":
                mistakes.append((("termination",), "the finite model has no air above; leave it out", "ambient"))
        refuse(self, mistakes)
        return self

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        for field, text in self.ambient.implausible():
            yield ("ambient", field), text
        yield from implausible_fields(self)

    @property
    def open_rim(self) -> bool:
        """Whether air leaves the sample's pores through its rim."""
        return self.pores is not None and self.model == "finite" and self.pores.rim != "sealed"

    @property
    def air_above(self) -> Literal["free", "ambient"]:
        """The termination in force."""
        return self.termination or ("ambient" if self.method == NELDER_MEAD else "free")

    @property
    def dispersive(self) -> bool:
        """Whether the modulus varies within a burst's band."""
        return (self.dispersion or ("none" if self.method == NELDER_MEAD else "local")) == "local"

    def changed(self, **changes: Any) -> FitSettings:
        """Return the settings with others in place of some.

        Raises
        ------
        ValidationError
            When they do not go together.
        """
        return FitSettings.model_validate({**self.model_dump(), **changes})

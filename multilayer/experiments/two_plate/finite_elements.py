"""The two-plate rig with its free rim, in place of the plane-wave model: the reduced finite elements of `rig`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, Numeric, RealArray
from multilayer.experiments.two_plate.plane_waves import Uncertain
from multilayer.experiments.two_plate.settings import RigSettings
from multilayer.measurements.description import Campaign, Configuration
from multilayer.media.elastic import p_wave_modulus
from multilayer.rig.reduced import Ranges, ReducedRig
from multilayer.rig.two_plate import TwoPlateRig

REACH = (0.5, 1.5)  # of a burst's frequency: where its spectrum is above 2e-3 of its largest value
_WIDER = 2.0  # factor by which a range is widened whose end holds the solution
_SPREAD = 1.5  # factor by which the modulus may vary within that band, by dispersion
_ROOM = 1.5  # factor around the solutions of the plane-wave model
_ROOM_WITH_AIR = 2.0  # the same with pores, whose air the plane-wave model takes into account only roughly
_TOLERANCE_WITH_AIR = 1e-4  # of the reduced basis: with air in it, it has to be much larger
_PARTS = 0.05  # relative range of density, thickness and mass


@dataclass(frozen=True)
class FiniteRig:
    """One configuration of a campaign with its free rim.

    Attributes
    ----------
    reduced : ReducedRig
    density, thickness, plate_mass : float
        Relative to the nominal ones.
    extrapolate : bool
        Whether moduli beyond the range of the reduced model are allowed.
    stiffening : float
        Moduli are given times this: of a disc's static stiffness over that of the stated one.
    solids : SolidSteps, optional
        Samples of another Poisson's ratio and stiffness along the radius, for a rig that has these as unknowns.
    """

    reduced: ReducedRig
    density: float = 1.0
    thickness: float = 1.0
    plate_mass: float = 1.0
    extrapolate: bool = False
    stiffening: float = 1.0
    solids: SolidSteps | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """Frequency range of the model, relative to a burst's frequency."""
        return REACH

    @property
    def scales(self) -> bool:
        """Without air and accelerometer, masses and moduli times one factor leave the motion unchanged."""
        return self.reduced.rig.porosity is None and not self.reduced.rig.sensor_mass

    def transmissibility(self, frequency: ArrayLike, modulus: ArrayLike) -> ComplexArray:
        """Return top over base motion; see `PlaneWaveRig.transmissibility`."""
        shift = (self.density, self.thickness, self.plate_mass)
        moduli = np.asarray(modulus) / self.stiffening
        return self.reduced.transmissibility(frequency, moduli, *shift, extrapolate=self.extrapolate)

    def holds(self, modulus: ComplexArray) -> bool:
        """Tell whether moduli lie within the range of the reduced model."""
        low, high = self.reduced.ranges.modulus
        return bool(low <= modulus.real.min() and modulus.real.max() <= high)

    @property
    def is_chain(self) -> bool:
        """False: a disc with a free rim is no rod."""
        return False

    @property
    def sensor_mass(self) -> float:
        """Mass of the accelerometer, kg; part of the finite elements."""
        return self.reduced.rig.sensor_mass

    @property
    def takes_arrays(self) -> bool:
        """False: the reduced model takes many moduli, but one rig at a time."""
        return False

    def shifted(self, quantity: Uncertain, amount: Numeric, *, relative: bool) -> FiniteRig:
        """Return the rig with an uncertain quantity changed by `amount`."""
        factor = 1 + (amount if relative else amount / self.reduced.rig.thickness)
        name = "plate_mass" if quantity == "top_plate_mass" else quantity
        return replace(self, **{name: getattr(self, name) * factor})


@dataclass(frozen=True)
class SolidSteps:
    """Rigs with samples near a given one, for the change of ln(transmissibility) to second order.

    Attributes
    ----------
    centre : (float, float)
        Relative error of Poisson's ratio, and ln(E_r/E_z), of the rig that holds these steps.
    steps : (float, float)
    rigs : mapping
        By steps taken in each: (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1).
    """

    centre: tuple[float, float]
    steps: tuple[float, float]
    rigs: Mapping[tuple[int, int], FiniteRig]

    def log_change(
        self, change: Mapping[tuple[int, int], ComplexArray], error: Numeric, log_stiffness: Numeric
    ) -> ComplexArray:
        """Return the change of ln(top/base), shape (..., n), by another sample.

        Parameters
        ----------
        change : mapping
            The same of each of `rigs`, at moduli that are times the sample's static stiffness over the stated one's.
        error, log_stiffness : array, shape (..., 1)
        """
        coordinates = zip((error, log_stiffness), self.centre, self.steps, strict=True)
        x, y = ((value - centre) / step for value, centre, step in coordinates)
        return paraboloid(change, x, y)


def parabola(ahead: ComplexArray, behind: ComplexArray, x: Numeric) -> ComplexArray:
    """Return the parabola through 0 at 0, and the values at steps of 1 and -1, at x."""
    return np.asarray(0.5 * (ahead - behind) * x + 0.5 * (ahead + behind) * x**2)


def paraboloid(at: Mapping[tuple[int, int], ComplexArray], x: Numeric, y: Numeric) -> ComplexArray:
    """Return the paraboloid through 0 at (0, 0), and the values at steps (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1)."""
    mixed = at[1, 1] - at[1, 0] - at[0, 1]
    return np.asarray(parabola(at[1, 0], at[-1, 0], x) + parabola(at[0, 1], at[0, -1], y) + mixed * x * y)


def with_solids(
    rig: FiniteRig,
    stiffening: Callable[[float, float], float],
    centre: tuple[float, float],
    steps: tuple[float, float],
) -> FiniteRig:
    """Return a rig whose sample has another Poisson's ratio and stiffness along the radius, with `FiniteRig.solids`.

    Parameters
    ----------
    rig : FiniteRig
        As the campaign describes it, its reduced model made for several samples (`ReducedRig.of_solids`).
    stiffening : callable
        Gives the static stiffness of a disc over that of the stated one, from the relative error of Poisson's ratio and
        E_r/E_z.
    centre, steps : (float, float)
        Of that error and of ln(E_r/E_z).
    """
    stated = rig.reduced.rig.poisson_ratio

    def stepped(i: int, j: int) -> FiniteRig:
        error, radial = centre[0] + i * steps[0], float(np.exp(centre[1] + j * steps[1]))
        reduced = rig.reduced.with_solid((stated * (1 + error), radial))
        return replace(rig, reduced=reduced, stiffening=stiffening(error, radial), solids=None)

    around = {(i, j): stepped(i, j) for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1))}
    return replace(stepped(0, 0), solids=SolidSteps(centre, steps, around))


@dataclass(frozen=True)
class ModulusRange:
    """Range in which the modulus of a configuration is sought with finite elements, Pa and loss factor."""

    low: float
    high: float
    loss: float

    @classmethod
    def around(
        cls, plane_wave: Sequence[RealArray], poisson_ratio: float, highest_loss: float, *, air: bool = False
    ) -> ModulusRange:
        """Return the range that holds the moduli whose plane-wave values are (ln E1, loss factor).

        The plane-wave model constrains the sample laterally: its modulus is at least E (1 + nu)(1 - 2 nu)/(1 - nu), and
        at most E, where inertia constrains the sample as well. With `air` in the pores the range is wider.
        """
        room = _ROOM_WITH_AIR if air else _ROOM
        moduli = np.exp([x[0] for x in plane_wave])
        ratio = float(np.real(np.asarray(p_wave_modulus(1.0, poisson_ratio))))
        return cls(float(moduli.min() / room), float(moduli.max() * ratio * room), highest_loss)

    def widened(self) -> ModulusRange:
        """Return a range for a solution that was found at an end of this one."""
        return replace(self, low=self.low / _WIDER, high=self.high * _WIDER)

    @cached_property
    def of_model(self) -> tuple[float, float]:
        """The range that the reduced model needs, as a burst's modulus varies over its band."""
        return self.low / _SPREAD, self.high * _SPREAD


@dataclass(frozen=True)
class Fineness:
    """Accuracy and frequency ranges of reduced finite elements.

    Attributes
    ----------
    resolution : float
        Of the mesh; see `TwoPlateRig`.
    tolerance : float
        Relative error of the reduced basis.
    bands : mapping, optional
        Lowest and highest frequency, Hz, by configuration; `REACH` of the bursts' when left out.
    """

    resolution: float = 1.0
    tolerance: float = 1e-5
    bands: Mapping[str, tuple[float, float]] | None = None

    def band(self, configuration: Configuration) -> tuple[float, float]:
        """Return the lowest and the highest frequency of a configuration, Hz."""
        if self.bands is not None:
            return self.bands[configuration.name]
        frequencies = [burst.frequency for burst in configuration.bursts]
        return REACH[0] * min(frequencies), REACH[1] * max(frequencies)


def two_plate_rig(campaign: Campaign, configuration: Configuration, settings: RigSettings | None = None) -> TwoPlateRig:
    """Return the finite-element rig of a configuration as the campaign describes it, with a fit's pores and sensor."""
    top, settings = campaign.top_plate, settings or RigSettings()
    pores: dict[str, Any] = {}
    if settings.pores is not None:
        gas = settings.ambient.gas
        pores = {**settings.pores.fields(gas), "air": gas, "pore_rim": settings.pores.rim or "open"}
    return TwoPlateRig(
        **pores,
        sensor_mass=settings.sensor_mass,
        radius=configuration.specimen_radius,
        thickness=configuration.specimen_thickness,
        density=campaign.specimen.density,
        poisson_ratio=campaign.specimen.poisson_ratio,
        plate_thickness=configuration.top_plate_thickness,
        plate_density=top.density,
        plate_modulus=top.young_modulus,
        plate_poisson_ratio=top.poisson_ratio,
    )


def finite_rigs(
    campaign: Campaign,
    ranges: Mapping[str, ModulusRange],
    tell: Callable[[str], None],
    settings: RigSettings | None = None,
    fineness: Fineness | None = None,
) -> dict[str, FiniteRig]:
    """Return the reduced rig of every configuration that has a range, by its name."""
    rigs, fine = {}, fineness or Fineness()
    air = settings is not None and settings.pores is not None
    tolerance = max(fine.tolerance, _TOLERANCE_WITH_AIR) if air else fine.tolerance
    for configuration in campaign.configurations:
        if (moduli := ranges.get(configuration.name)) is None:
            continue
        around = (1 - _PARTS, 1 + _PARTS)
        box = Ranges(fine.band(configuration), moduli.of_model, (0.0, moduli.loss), around, around, around)
        rig = two_plate_rig(campaign, configuration, settings).replaced(resolution=fine.resolution)
        rigs[configuration.name] = FiniteRig(ReducedRig.build(rig, box, tolerance))
        tell(f"{configuration.name}: finite elements")
    return rigs

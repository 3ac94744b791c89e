"""Motion of the top plate over the base: rods and masses in closed form, or any rig near its description.

The equations of rods stand in `media.rod`, those of air in `media.pumped_disc`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray, distinct_rows, logarithm
from multilayer.experiments.two_plate.effects import Chain, Setting
from multilayer.experiments.two_plate.finite_elements import FiniteRig, parabola, paraboloid
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.pumped_disc import pumped_disc_factor
from multilayer.media.rod import chain_transmissibility
from multilayer.rig.partly_bonded import CENTRE_DEFLECTION, partly_bonded_disc
from multilayer.rig.shape_factor import static_shape_factor
from multilayer.rig.worn_rim import worn_change

Rod: TypeAlias = tuple[Numeric, Numeric, Numeric]  # modulus (Pa), density (kg/m3), length (m)
_GLUE = 1e-6  # thickness by which a layer of given stiffness and mass per area is written as a rod, m
_LIGHT = 1e-9  # kg/m2: the mass of a layer that has none
_RIGID = 1e-18  # m/Pa, added to the compliance of a layer, which may have none
_RESOLUTION = 0.5  # of the mesh of a planned disc: its stiffness is right to 2e-4


@dataclass(frozen=True)
class Neighbourhood:
    """ln(transmissibility) of rigs near a given one.

    Exact where the rig takes arrays of densities, heights and masses; else to second order in density and thickness,
    and in the plate's mass.

    Attributes
    ----------
    rig : Rig
    density_step, thickness_step : float
        Relative, and m; about as large as the changes to come. 0 for a thickness that is known.
    mass_step : float
        Relative; 0 where the plate's mass is known, or equivalent to density and modulus (`Rig.scales`).
    """

    rig: Rig
    density_step: float
    thickness_step: float
    mass_step: float = 0.0

    @cached_property
    def _around(self) -> dict[tuple[int, int], Rig]:
        """The rigs at the steps, by those taken in density and in thickness."""
        steps = [(1, 0), (-1, 0)] + ([(0, 1), (0, -1), (1, 1)] if self.thickness_step else [])
        return {(i, j): self._stepped(i, j) for i, j in steps}

    def _stepped(self, i: int, j: int) -> Rig:
        rig = self.rig.shifted("density", i * self.density_step, relative=True) if i else self.rig
        return rig.shifted("thickness", j * self.thickness_step, relative=False) if j else rig

    @cached_property
    def _plates(self) -> list[Rig]:
        return [self.rig.shifted("top_plate_mass", sign * self.mass_step, relative=True) for sign in (1, -1)]

    def log_motion(
        self,
        frequency: RealArray,
        modulus: ComplexArray,
        density: Numeric,
        thickness: Numeric,
        plate_mass: Numeric | None = None,
        solid: tuple[RealArray, RealArray] | None = None,
    ) -> ComplexArray:
        """Return ln(top/base), shape (..., n); `density`, `thickness`, `plate_mass` and `solid` of shape (..., 1).

        `solid` is `Chain.solid`, that of the rig itself where left out; another acts where the rig has others around it
        (`FiniteRig.solids`).
        """
        if self.rig.takes_arrays:
            moved = self.rig.shifted("density", density, relative=True).shifted("thickness", thickness, relative=False)
            if plate_mass is not None:
                moved = moved.shifted("top_plate_mass", plate_mass, relative=True)
            return logarithm(moved.transmissibility(frequency, modulus))
        # most points of a derivative have the modulus of another: fractions of these are summed once
        kept, place = distinct_rows(modulus.real, modulus.imag) if modulus.ndim == 2 else (..., ...)
        distinct = modulus[kept]
        here = self.rig.transmissibility(frequency, distinct)

        def change(rig: Rig) -> ComplexArray:
            return np.asarray(logarithm(rig.transmissibility(frequency, distinct) / here)[place])

        def changes(rigs: Mapping[tuple[int, int], Rig]) -> dict[tuple[int, int], ComplexArray]:
            return {steps: change(rig) for steps, rig in rigs.items()}

        total = logarithm(here)[place]
        if solid is not None and isinstance(self.rig, FiniteRig) and self.rig.solids is not None:
            total = total + self.rig.solids.log_change(changes(self.rig.solids.rigs), solid[0], np.log(solid[1]))
        if self.mass_step and plate_mass is not None and np.any(plate_mass):
            # uncertain by so few thousandths that its products with the other changes are negligible
            ahead, behind = map(change, self._plates)
            total = total + parabola(ahead, behind, plate_mass / self.mass_step)
        if not (np.any(density) or np.any(thickness)):
            return np.asarray(total)
        around, x = changes(self._around), density / self.density_step
        if self.thickness_step:
            return np.asarray(total + paraboloid(around, x, thickness / self.thickness_step))
        return np.asarray(total + parabola(around[1, 0], around[-1, 0], x))


def top_over_base(near: Neighbourhood, setting: Setting, frequency: RealArray, chain: Chain) -> ComplexArray:
    """Return the motion of the top plate over that of the base, shape (..., n).

    Exact for rods and masses. Other rigs take glue, skin and a spring beside the sample as a change of its modulus by
    their compliance, and the glue's mass as the plate's.

    Parameters
    ----------
    near : Neighbourhood
        Of the rig as it is described.
    setting : Setting
    frequency : array, shape (n,)
        Hz.
    chain : Chain
        What stands on the base, effects included.
    """
    ratio, sensor = setting.campaign.specimen.poisson_ratio, near.rig.sensor_mass
    if near.rig.is_chain:
        held = constrained_modulus_ratio(ratio)
        moved = _chain_motion(setting, frequency, chain, held, sensor)
        rim = _open_rim_factor(setting, frequency, chain, sensor, (0.0, held))
        return moved * rim * _air_factor(setting, frequency, chain, ratio, held)
    if setting.is_described:
        moved = np.exp(_perturbed(near, setting, frequency, chain))
        rim = _open_rim_factor(setting, frequency, chain, sensor, (ratio, 1.0))
        return np.asarray(moved * rim * _air_factor(setting, frequency, chain, ratio, 1.0))
    # another geometry, for a planned experiment: a rod of the static stiffness of the disc
    held = _shape_factor(setting)
    moved = _chain_motion(setting, frequency, chain, held, sensor)
    rim = _open_rim_factor(setting, frequency, chain, sensor, (0.0, held))
    return moved * rim * _air_factor(setting, frequency, chain, ratio, 1.0)


def _chain_motion(
    setting: Setting, frequency: RealArray, chain: Chain, stiffening: float, sensor_mass: float
) -> ComplexArray:
    """Return the motion of rods and masses in one dimension, exact; `stiffening` is the rods' modulus over E."""
    plate = setting.campaign.top_plate
    held = stiffening * chain.modulus
    rods: list[Rod] = [(held, chain.density, chain.thickness)]
    if chain.skin is not None:
        thickness, ratio = chain.skin
        skin: Rod = (held * ratio, chain.density, thickness)
        rods = [skin, (held, chain.density, chain.thickness - 2 * thickness), skin]
    if chain.compliances is not None:
        heavy = np.maximum(chain.glue_mass, _LIGHT) / _GLUE
        lower, upper = ((_GLUE / (compliance + _RIGID), heavy, _GLUE) for compliance in chain.compliances)
        rods = [lower, *rods, upper]
    thickness = setting.configuration.top_plate_thickness
    dense = (chain.plate_mass + sensor_mass) / (setting.area * thickness)
    top: Rod = (p_wave_modulus(plate.young_modulus, plate.poisson_ratio), dense, thickness)
    base = setting.campaign.base_plate
    below: Rod = (p_wave_modulus(base.young_modulus, base.poisson_ratio), base.density, base.thickness)
    alone = np.asarray(chain_transmissibility(frequency, [below, *rods, top]))
    if chain.spring is None:
        return alone
    return alone * _parallel_spring_factor(setting, frequency, rods, chain.plate_mass + sensor_mass, chain.spring)


def _perturbed(near: Neighbourhood, setting: Setting, frequency: RealArray, chain: Chain) -> ComplexArray:
    """Return ln(top/base) of a rig that is no chain, with the changes that the chain describes."""
    modulus, height = chain.modulus, setting.configuration.specimen_thickness
    if chain.skin is not None:
        share = 2 * chain.skin[0] / height
        modulus = modulus / (1 - share + share / chain.skin[1])
    # in series or in parallel with the disc, whose apparent modulus is g(nu, S) times its own
    if chain.compliances is not None:
        modulus = modulus / (1 + sum(chain.compliances) * _shape_factor(setting) * modulus / height)
    if chain.spring is not None:
        modulus = modulus + chain.spring * height / (_shape_factor(setting) * setting.area)
    heavier = (chain.plate_mass + chain.glue_mass * setting.area) / setting.plate_mass - 1
    denser = chain.density / setting.campaign.specimen.density - 1
    density, thicker, mass = map(np.asarray, (denser, chain.thickness - height, heavier))  # complex by laws of places
    if near.rig.scales:
        # stiffness and all masses times one factor leave the motion unchanged: the plate's mass is exact
        modulus, density, mass = modulus / (1 + mass), (1 + density) / (1 + mass) - 1, np.zeros(())
    return near.log_motion(frequency, modulus, density, thicker, mass, chain.solid)


def _shape_factor(setting: Setting) -> float:
    """Return g(nu, S) of the sample in slow compression: its apparent modulus over its own."""
    ratio = max(setting.campaign.specimen.poisson_ratio, 0.0)  # g is known from 0 on, where it is 1
    return static_shape_factor(ratio, setting.shape, resolution=_RESOLUTION)


def constrained_modulus_ratio(poisson_ratio: float) -> float:
    """Return the modulus of laterally constrained compression over Young's."""
    return float(np.real(np.asarray(p_wave_modulus(1.0, poisson_ratio))))


def _air_factor(setting: Setting, frequency: RealArray, chain: Chain, poisson_ratio: float, held: float) -> Numeric:
    """Return the factor on the motion by air in the sample's pores; 1 without."""
    if chain.resistivity is None:
        return 1.0
    return pumped_disc_factor(
        2 * np.pi * frequency,
        chain.modulus,
        chain.resistivity,
        radius=setting.configuration.specimen_radius,
        thickness=chain.thickness,
        density=chain.density,
        mass_per_area=chain.plate_mass / setting.area,
        poisson_ratio=poisson_ratio,
        held=held,
    )


def _open_rim_factor(
    setting: Setting, frequency: RealArray, chain: Chain, sensor_mass: float, solid: tuple[float, float]
) -> Numeric:
    """Return the factor on the reading in the plate's centre by rims of the faces that are not bonded; 1 without.

    Parameters
    ----------
    solid : tuple of float
        Poisson's ratio of a disc with a free rim, and its modulus over E: those that move as the rig does.

    Notes
    -----
    From finite elements (`rig.partly_bonded`) with and without open rims, glue and springs beside the sample included.
    The plate bends by the same forces and yields to them (Galerkin's method): as its static deflection under a force in
    the centre, which is exact for the reading at low frequencies, with its first mode's resonance.
    """
    if chain.open_rim is None:
        return 1.0
    disc = partly_bonded_disc(solid[0], setting.shape)
    omega2 = (2 * np.pi * frequency) ** 2
    modulus = solid[1] * chain.modulus
    unit = modulus * setting.area / chain.thickness
    mass = chain.plate_mass + sensor_mass + chain.glue_mass * setting.area
    x = chain.density * omega2 * chain.thickness**2 / modulus
    spring = 0.0 if chain.spring is None else chain.spring

    def held(force: Sequence[ComplexArray]) -> tuple[ComplexArray, ComplexArray]:
        on_top, on_base = (unit * part for part in force)
        if chain.compliances is None:
            return on_top, on_base
        lower, upper = (compliance / setting.area for compliance in chain.compliances)
        return _between_layers(on_top, on_base, lower, upper)

    def moved(on_top: ComplexArray, on_base: ComplexArray) -> ComplexArray:
        return np.asarray((spring - on_base) / (on_top + spring - omega2 * mass))

    rim = chain.open_rim
    turned = setting.configuration.top_plate_thickness / (2 * setting.configuration.specimen_radius)
    forces: Sequence[ComplexArray] = disc.stiffness(x, rim.width, rim.at_base, turned)
    if rim.depth is not None:
        worn = worn_change(solid[0], setting.shape, x, rim.width, rim.depth, turned)
        at_top = np.minimum(2 - rim.at_base, 1)
        forces = [force + at_top * change for force, change in zip(forces, worn, strict=True)]
    if rim.gain is not None:
        closed = disc.stiffness(x, np.zeros_like(rim.width), rim.at_base, turned)
        forces = [bonded + rim.gain * (force - bonded) for force, bonded in zip(forces, closed, strict=True)]
    top, base, by_top, by_base, by_bending = forces
    on_top, on_base = held((top, base))
    # glue passes on as much of the forces that bend the plate as of those that move it
    by_top, by_base, by_bending = (by_top * on_top / top, by_base * on_base / base, by_bending * on_top / top)
    yielding = 1 / (CENTRE_DEFLECTION / setting.bending_compliance(frequency) + by_bending)
    mean = moved(on_top - yielding * by_top**2, on_base - yielding * by_top * by_base)
    reading = mean - CENTRE_DEFLECTION * yielding * (by_top * mean + by_base)
    return np.asarray(reading / moved(*held(disc.bonded(x))))


def _between_layers(
    on_top: ComplexArray, on_base: ComplexArray, lower: Numeric, upper: Numeric
) -> tuple[ComplexArray, ComplexArray]:
    """Return the forces on the upper plate of something symmetric between layers of some compliances, m/N.

    With its faces' motions t and b, the plates' T and B: ``F = a t + c b = (T - t)/upper``, and ``a b + c t = (B -
    b)/lower`` below, a being `on_top` and c `on_base`.
    """
    alone = (on_top + on_base) * (on_top - on_base)
    whole = 1 + on_top * (lower + upper) + alone * lower * upper
    return (on_top + alone * lower) / whole, on_base / whole


def _parallel_spring_factor(
    setting: Setting, frequency: RealArray, rods: Sequence[Rod], mass: Numeric, spring: Numeric
) -> ComplexArray:
    """Return the factor on the motion of a rigid plate on rods by a spring beside them.

    The rods push a plate with the force ``b u0 - c u1``, so that ``1/T = p - w^2 M q`` with ``p = c/b``, ``q = 1/b``,
    which follow from the motions of two masses. A spring k then makes ``T (1 + k q)/(1 + k q T)``. That the plates give
    a little changes this factor by next to nothing.
    """
    omega2, whole = (2 * np.pi * frequency) ** 2, np.asarray(mass)
    light, heavy = (_with_mass(setting, frequency, rods, m) for m in (0.5 * whole, whole))
    q = (1 / light - 1 / heavy) / (omega2 * 0.5 * whole)
    return np.asarray((1 + spring * q) / (1 + spring * q * heavy))


def _with_mass(setting: Setting, frequency: RealArray, rods: Sequence[Rod], mass: RealArray) -> ComplexArray:
    """Return the motion of a rigid mass on rods."""
    thin = 1e-6
    plate: Rod = (1e14, mass / (setting.area * thin), thin)
    return chain_transmissibility(frequency, [*rods, plate])

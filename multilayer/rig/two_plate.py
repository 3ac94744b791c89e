"""The virtual two-plate rig: sample and top plate on a base of imposed motion, axisymmetric finite elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray, frequencies
from multilayer.errors import InputError
from multilayer.media.gas import Gas
from multilayer.rig.assembly import (
    Parameters,
    assemble,
    coefficients,
    isotropic,
    pore_fluid,
    transversely_isotropic,
)
from multilayer.rig.mesh import Section, Slab, Slit, build_section
from multilayer.rig.solve import full_solution
from multilayer.stack import Ambient

ModulusLike: TypeAlias = Callable[[Any], Any] | ArrayLike
_PER_WAVELENGTH = 8.0  # elements of second order: an error of phase of 1e-5 per wavelength
_ACROSS, _ALONG = 8, 8  # least elements over radius and thickness
_CORNER = 128  # intervals of this part of the thickness at the singular corners
_FEW = 24  # frequencies that are solved one by one


@dataclass(frozen=True)
class TwoPlateRig:
    """A disc glued between a moving base and a top plate, with its free rim.

    All in SI units; every field but the first five has a default.

    Parameters
    ----------
    radius, thickness : float
        Of the sample, m; the top plate has the sample's radius.
    density, poisson_ratio : float
        Of the sample, kg/m3 (of a poroelastic sample: of its frame per volume of material); -1 < nu < 0.5.
    plate_thickness, plate_density, plate_modulus, plate_poisson_ratio : float
        Of the elastic top plate; steel by default.
    sensor_mass : float
        kg of the accelerometer on the top plate, spread over its footprint.
    sensor_radius, sensor_footprint : float
        Distance of its centre from the axis and half its width, m. Away from the axis its mass is a ring.
    reading_radius : float, optional
        Where the top plate's motion is read, m; the accelerometer's place when left out.
    adhesive_thickness : float
        Of a layer of glue at each face of the sample, m; on top of the sample's thickness.
    adhesive_modulus : complex, law or callable of Hz, optional
        Pa; required with a thickness above 0.
    adhesive_density, adhesive_poisson_ratio : float
    bonded_fraction : float
        Share of a face's area, about the axis, that is bonded.
    open_faces : {'both', 'top', 'base'}
        Which faces are bonded in part.
    skin_thickness, skin_ratio : float
        Layers at both faces whose modulus is `skin_ratio` times that of the core, m.
    modulus_profile : callable or sequence, optional
        Factor on the modulus as a function of z/h, or its values evenly spaced from base to top (linear between).
    transverse_ratio, shear_ratio : float
        E_r/E_z of a transversely isotropic sample, and its shear modulus over that in
        `assembly.transversely_isotropic`.
    base_thickness, base_density, base_modulus, base_poisson_ratio : float
        Elastic base plate of the sample's radius, moved at its lower face; rigid with a thickness of 0.
    rim : {'free', 'held'}
        Whether the sample's rim may move sideways.
    flanking_stiffness : complex, or callable of Hz
        N/m of a parallel path from the base to the edge of the top plate.
    attached_mass : complex, or callable of Hz, optional
        Dynamic mass on the top plate, force over acceleration, spread over the accelerometer's footprint, kg.
    porosity, flow_resistivity, tortuosity, viscous_length, thermal_length : float, optional
        With a porosity the sample is poroelastic (Biot, Johnson-Champoux-Allard), its pores sealed by the plates.
    pore_rim : {'open', 'sealed'}
        Whether air passes through the rim; outside of it the pressure is zero.
    air : Gas
        In the pores.
    resolution : float
        Above 1 for a finer mesh: every interval shorter by this factor.

    Raises
    ------
    InputError
        For values that make no rig.

    Notes
    -----
    Second-order elements of the displacement (u_r, u_z) and, in pores, of the pressure. Bonfiglio & Pompoli, Polymer
    Testing 48 (2015) 89-96, section 3.2, have the elastic case. Only the moduli of the sample and of the glue are
    complex; Poisson's ratios are real.
    """

    radius: float
    thickness: float
    density: float
    poisson_ratio: float
    plate_thickness: float
    plate_density: float = 7850.0
    plate_modulus: float = 2.1e11
    plate_poisson_ratio: float = 0.3
    sensor_mass: float = 0.0
    sensor_radius: float = 0.0
    sensor_footprint: float = 3e-3
    reading_radius: float | None = None
    adhesive_thickness: float = 0.0
    adhesive_modulus: ModulusLike | None = None
    adhesive_density: float = 1000.0
    adhesive_poisson_ratio: float = 0.4
    bonded_fraction: float = 1.0
    open_faces: Literal["both", "top", "base"] = "both"
    skin_thickness: float = 0.0
    skin_ratio: float = 1.0
    modulus_profile: Callable[[RealArray], RealArray] | Sequence[float] | None = None
    transverse_ratio: float = 1.0
    shear_ratio: float = 1.0
    base_thickness: float = 0.0
    base_density: float = 2700.0
    base_modulus: float = 7.0e10
    base_poisson_ratio: float = 0.33
    rim: Literal["free", "held"] = "free"
    flanking_stiffness: ModulusLike = 0.0
    attached_mass: ModulusLike | None = None
    porosity: float | None = None
    flow_resistivity: float | None = None
    tortuosity: float = 1.0
    viscous_length: float | None = None
    thermal_length: float | None = None
    pore_rim: Literal["open", "sealed"] = "open"
    air: Gas = field(default_factory=lambda: Ambient().gas)
    resolution: float = 1.0

    def __post_init__(self) -> None:
        if problems := list(_problems(self)):
            raise InputError(problems)

    @property
    def reading(self) -> float:
        """Where the top plate's motion is read, m from the axis."""
        return self.sensor_radius if self.reading_radius is None else self.reading_radius

    @property
    def bonded_radius(self) -> float:
        """Radius of the bonded part of the faces, m."""
        return float(self.radius * self.bonded_fraction**0.5)

    @property
    def footprint(self) -> tuple[float, float]:
        """Inner and outer radius of the ring that carries the accelerometer's mass, m."""
        return max(0.0, self.sensor_radius - self.sensor_footprint), min(
            self.radius, self.sensor_radius + self.sensor_footprint
        )

    @property
    def elastic_constants(self) -> RealArray:
        """Stiffness coefficients of the sample over its axial modulus; see `assembly.transversely_isotropic`."""
        if self.transverse_ratio == self.shear_ratio == 1:
            return isotropic(self.poisson_ratio)
        return transversely_isotropic(self.poisson_ratio, self.transverse_ratio, self.shear_ratio)

    def glue(self, frequency: ArrayLike) -> ComplexArray:
        """Return the modulus of the adhesive, Pa, at `frequency`, Hz."""
        assert self.adhesive_modulus is not None  # checked with the other fields
        return _modulus_at(self.adhesive_modulus, frequency)

    def flanking(self, frequency: ArrayLike) -> ComplexArray:
        """Return the stiffness of the parallel path, N/m, at `frequency`, Hz."""
        return _modulus_at(self.flanking_stiffness, frequency)

    def attached(self, frequency: ArrayLike) -> ComplexArray:
        """Return the dynamic mass on the top plate, kg, at `frequency`, Hz."""
        return _modulus_at(0.0 if self.attached_mass is None else self.attached_mass, frequency)

    @property
    def has_flank(self) -> bool:
        """Whether there is a parallel path."""
        return callable(self.flanking_stiffness) or bool(np.any(np.asarray(self.flanking_stiffness)))

    def stiffness_profile(self, height: RealArray) -> RealArray:
        """Return the factor on the modulus at a height above the sample's lower face, m."""
        x = height / self.thickness
        factor = np.ones_like(x)
        if callable(self.modulus_profile):
            factor = np.asarray(self.modulus_profile(x), dtype=float)
        elif self.modulus_profile is not None:
            values = np.asarray(self.modulus_profile, dtype=float)
            factor = np.interp(x, np.linspace(0, 1, len(values)), values)
        if self.skin_thickness:
            edge = self.skin_thickness / self.thickness
            factor = np.where((x < edge) | (x > 1 - edge), self.skin_ratio * factor, factor)
        return factor

    def section(self, frequency: float, modulus: float) -> Section:
        """Return the mesh for waves up to `frequency`, Hz, in a sample of a modulus of this magnitude, Pa.

        Raises
        ------
        InputError
            When the shortest wavelength asks for more elements than the limit.
        """
        wave = self.shortest_wavelength(frequency, modulus) / _PER_WAVELENGTH
        h, radius = self.thickness, self.radius
        size = min(wave, h / _ALONG, radius / 4) / self.resolution
        finest = min(h, radius) / _CORNER / self.resolution
        across = min(wave, radius / _ACROSS) / self.resolution
        loaded = self.sensor_mass or self.attached_mass is not None
        stops = [*self.footprint, self.reading] if loaded else [self.reading]
        tips = [self.bonded_radius] if self.bonded_fraction < 1 else []
        return build_section(self._slabs(size, finest), radius, across, finest, stops, self._slits(), tips)

    def shortest_wavelength(self, frequency: float, modulus: float) -> float:
        """Return the shortest wavelength in the sample, m: that of shear, or of sound in its pores."""
        shear = np.sqrt(self.elastic_constants[-1] * modulus / self.density) / frequency
        if self.porosity is None:
            return float(shear)
        rho, bulk = pore_fluid(self, np.array(2 * np.pi * frequency))
        sound = float(np.abs(np.sqrt(bulk / rho))) / frequency
        return float(min(shear, 2 * sound))

    def _slabs(self, size: float, finest: float) -> list[Slab]:
        h, glue, skin = self.thickness, self.adhesive_thickness, self.skin_thickness
        cuts = [0.0, skin, h - skin, h] if skin else [0.0, h]
        slabs = [Slab("sample", a, b, size, min(finest, b - a)) for a, b in pairwise(cuts)]
        if glue:
            below, above = (Slab("adhesive", a, a + glue, glue / 2, glue / 2) for a in (-glue, h))
            slabs = [below, *slabs, above]
        top, bottom = h + glue, -glue
        slabs.append(Slab("plate", top, top + self.plate_thickness, self.plate_thickness, self.plate_thickness))
        if self.base_thickness:
            half = 0.5 * self.base_thickness
            slabs.insert(0, Slab("base", bottom - self.base_thickness, bottom, half, half))
        return slabs

    def _slits(self) -> list[Slit]:
        if self.bonded_fraction == 1:
            return []
        # without glue or an elastic base the sample's lower face is the boundary: it is held where it is bonded
        on_boundary = not self.adhesive_thickness and not self.base_thickness
        heights = {0.0: "top", self.thickness: "base"}  # and which open face leaves them closed
        if on_boundary:
            del heights[0.0]
        return [Slit(height, self.bonded_radius) for height, other in heights.items() if self.open_faces != other]

    def transmissibility(self, frequency: ArrayLike, modulus: ModulusLike) -> ComplexArray:
        """Return top over base motion.

        Parameters
        ----------
        frequency : array
            Hz, above 0.
        modulus : law, callable of Hz, or array that broadcasts against `frequency`
            Young's modulus E1 + i E2 of the sample (along the axis), Pa.

        Returns
        -------
        complex array
            Of the common shape. Up to 24 values come from the full system each, more from a reduced basis whose
            error, estimated against full solutions, is below 1e-5 of the largest.

        Raises
        ------
        InputError
            For frequencies or moduli out of range, or wavelengths too short for the finest mesh.
        """
        f, e = self._checked(frequency, modulus)
        assembly = assemble(self, self.section(float(f.max()), float(np.abs(e).min())))
        at = Parameters(f.ravel(), e.ravel())
        if f.size <= _FEW:
            return full_solution(assembly, coefficients(self, assembly.names, at)).reshape(f.shape)
        from multilayer.rig.reduced import reduce_along

        return reduce_along(self, assembly, at).reshape(f.shape)

    def error_estimate(self, frequency: ArrayLike, modulus: ModulusLike) -> RealArray:
        """Return the estimated error of the transmissibility, relative to its modulus, by halving every interval.

        The difference between the two meshes is the error of the coarser one, less the much smaller one of the finer.
        """
        f, e = self._checked(frequency, modulus)
        section = self.section(float(f.max()), float(np.abs(e).min()))
        coarse, fine = (self._full(s, f.ravel(), e.ravel()) for s in (section, section.halved()))
        return np.asarray(np.abs(fine - coarse) / np.abs(fine)).reshape(f.shape)

    def _full(self, section: Section, frequency: RealArray, modulus: ComplexArray) -> ComplexArray:
        assembly = assemble(self, section)
        return full_solution(assembly, coefficients(self, assembly.names, Parameters(frequency, modulus)))

    def _checked(self, frequency: ArrayLike, modulus: ModulusLike) -> tuple[RealArray, ComplexArray]:
        f = frequencies(frequency)
        f, e = np.broadcast_arrays(f, _modulus_at(modulus, f))
        if not np.all(np.isfinite(e)) or np.any(e.real <= 0) or np.any(e.imag < 0):
            raise InputError("a modulus must have a real part above 0 and an imaginary part of at least 0")
        return f, e

    @cached_property
    def static_plate_mass(self) -> float:
        """Mass of the top plate, kg."""
        return float(np.pi * self.radius**2 * self.plate_thickness * self.plate_density)

    def replaced(self, **changes: Any) -> TwoPlateRig:
        """Return a rig with other values in some fields."""
        return replace(self, **changes)


def _modulus_at(modulus: ModulusLike, frequency: ArrayLike) -> ComplexArray:
    f = np.asarray(frequency, dtype=float)
    value = modulus(f) if callable(modulus) else modulus
    return np.asarray(value, dtype=complex)


_POSITIVE = (
    "radius", "thickness", "density", "plate_thickness", "plate_density", "plate_modulus", "sensor_footprint",
    "adhesive_density", "skin_ratio", "transverse_ratio", "shear_ratio", "base_density", "base_modulus", "resolution",
)  # fmt: skip
_NOT_NEGATIVE = ("sensor_mass", "sensor_radius", "adhesive_thickness", "skin_thickness", "base_thickness")
_RATIOS = ("poisson_ratio", "plate_poisson_ratio", "adhesive_poisson_ratio", "base_poisson_ratio")


def _problems(rig: TwoPlateRig) -> list[str]:
    problems = [_must(name, getattr(rig, name), "above 0") for name in _POSITIVE if not getattr(rig, name) > 0]
    problems += [_must(name, getattr(rig, name), "at least 0") for name in _NOT_NEGATIVE if not getattr(rig, name) >= 0]
    for name in _RATIOS:
        if not -1 < getattr(rig, name) < 0.5:
            text = "above -1 and below 0.5: at 0.5 a solid is incompressible, which these elements cannot do"
            problems.append(_must(name, getattr(rig, name), text))
    return problems + _geometry_problems(rig) + _pore_problems(rig)


def _must(name: str, value: object, what: str) -> str:
    return f"{name}: {value} is not allowed; it must be {what}"


def _geometry_problems(rig: TwoPlateRig) -> list[str]:
    problems = []
    if rig.sensor_radius + (rig.sensor_footprint if rig.sensor_mass else 0) > rig.radius:
        limit = f"with its footprint it must stay on the plate of radius {rig.radius:g} m"
        problems.append(f"sensor_radius: {rig.sensor_radius:g} m puts the accelerometer off the plate; {limit}")
    if rig.reading_radius is not None and not 0 <= rig.reading_radius <= rig.radius:
        problems.append(_must("reading_radius", rig.reading_radius, f"from 0 to the plate's radius, {rig.radius:g} m"))
    if rig.adhesive_thickness > rig.thickness:
        problems.append(
            f"adhesive_thickness: {rig.adhesive_thickness:g} m is more than the sample's thickness of "
            f"{rig.thickness:g} m; give the thickness of one layer of glue"
        )
    if rig.adhesive_thickness > 0 and rig.adhesive_modulus is None:
        problems.append("adhesive_modulus: is missing; an adhesive of some thickness needs a modulus, Pa")
    if not 0 < rig.bonded_fraction <= 1:
        problems.append(_must("bonded_fraction", rig.bonded_fraction, "above 0 and at most 1"))
    if 2 * rig.skin_thickness >= rig.thickness:
        problems.append(
            f"skin_thickness: {rig.skin_thickness:g} m leaves no core in {rig.thickness:g} m; make it thinner"
        )
    return problems


def _pore_problems(rig: TwoPlateRig) -> list[str]:
    if rig.porosity is None:
        return []
    if not 0 < rig.porosity < 1:
        return [_must("porosity", rig.porosity, "above 0 and below 1")]
    names = ("flow_resistivity", "viscous_length", "thermal_length")
    problems = [
        f"{name}: must be given and above 0 for a poroelastic sample"
        for name in names
        if not (getattr(rig, name) or 0) > 0
    ]
    return problems + ([] if rig.tortuosity >= 1 else [_must("tortuosity", rig.tortuosity, "at least 1")])

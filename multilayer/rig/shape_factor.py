"""How much stiffer a bonded disc is than a free rod: the shape factor g(nu, S), static and dynamic."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.bounds import refuse_shape
from multilayer.errors import InputError
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.assembly import blocks, isotropic, solid_parts
from multilayer.rig.mesh import Section, Slab, build_section
from multilayer.rig.operators import Operators, basis_of, operators
from multilayer.rig.two_plate import ModulusLike, TwoPlateRig

_HALF = 1.0  # thickness of the upper half of the disc, which is a mirror image of the lower
_ACROSS, _CORNER = 12, 512
_LOWEST, _STEPS = 1.0, 60  # Hz, and points on the way up from there
_ITERATIONS, _PROBE = 40, 1e-7
_REACH, _HIGHEST = 0.6, 0.49  # of Poisson's ratio: range relative to the stated one, and upper end of the table
_DEGREE, _SHAPE_DEGREE, _STIFFEST = 6, 3, 2.5
_COARSE = 0.5  # resolution of the mesh of that table: exact to 2e-4 up to nu = 0.48 and S = 1.8


@lru_cache(maxsize=256)
def static_shape_factor(
    poisson_ratio: float, shape: float, *, resolution: float = 1.0, radial_stiffness: float = 1.0
) -> float:
    """Return g = E_apparent / E of a disc glued between rigid plates, in slow compression.

    Parameters
    ----------
    poisson_ratio : float
        0 <= nu < 0.5.
    shape : float
        S = radius / (2 thickness): loaded area over free area.
    resolution : float
        Above 1 for a finer mesh.
    radial_stiffness : float
        E_r / E_z, Young's modulus along the radius over that along the axis, of a disc that is transversely isotropic
        as `assembly.transversely_isotropic` has it; E is E_z.

    Returns
    -------
    float
        Force times thickness over (E, area and shortening); 1 for nu = 0, for S to infinity
        (1 - nu)/((1 + nu)(1 - 2 nu)).

    Raises
    ------
    InputError
        For values out of range.

    Notes
    -----
    Axisymmetric finite elements of the upper half, after C. Langlois, R. Panneton & N. Atalla, J. Acoust. Soc. Am. 110
    (2001) 3032-3040. The energy is an upper bound, so g comes from above.

    With t = E_r / E_z the stiffness is C_rr = t c_rr, C_rz = t^(1/2) c_rz, C_zz = c_zz, G = t^(1/2) g, the small
    letters being the isotropic ones. In the coordinates r = t^(1/4) r', u_r = t^(-1/4) u_r' the energy is that of an
    isotropic disc, but for the factor of the area: g(nu, S, t) = g(nu, t^(-1/4) S). Coordinates stretched likewise: S.
    G. Lekhnitskii, Theory of Elasticity of an Anisotropic Elastic Body, Holden-Day 1963.
    """
    if not 0 <= poisson_ratio < 0.5:
        raise InputError(
            f"poisson_ratio: {poisson_ratio:g} is not allowed; it must be at least 0 and below 0.5, where a solid is "
            "incompressible"
        )
    refuse_shape(shape)
    radius = 4 * shape * radial_stiffness**-0.25 * _HALF
    return float(_axial_stiffness(*_assembled(radius, resolution), poisson_ratio) * _HALF / (np.pi * radius**2))


@lru_cache(maxsize=64)
def interpolated_shape_factor(
    shape: float, lowest: float = 0.0, highest: float = 0.499, *, degree: int = 14, resolution: float = 1.0
) -> Callable[[ArrayLike], RealArray]:
    """Return g as a function of (arrays of) Poisson's ratio, for one shape S; constant beyond the given range.

    ln g is a polynomial of ln(1 - 2 nu), as g grows without bound towards one half. Over the whole range it is right to
    2e-6 of g for S up to 1.8; with degree 6 and half the resolution, to 2e-4 over the range of a stated ratio's
    uncertainty.

    Parameters
    ----------
    shape : float
        S = radius / (2 thickness).
    lowest, highest : float
        Poisson's ratios between which g is computed.
    degree : int
        Of the polynomial; it takes one finite-element solution more than that.
    resolution : float
        Of their mesh, see `static_shape_factor`.
    """

    def logarithms(x: RealArray) -> RealArray:
        ratios = np.clip((1 - np.exp(x)) / 2, 0.0, highest)
        return np.log([static_shape_factor(float(ratio), shape, resolution=resolution) for ratio in ratios])

    polynomial = Chebyshev.interpolate(logarithms, degree, domain=[np.log(1 - 2 * highest), np.log(1 - 2 * lowest)])
    return lambda ratio: np.asarray(
        np.exp(polynomial(np.log(1 - 2 * np.clip(np.asarray(ratio, dtype=float), lowest, highest))))
    )


def relative_shape_factor(stated: float, shape: float, error: RealArray, radial_stiffness: RealArray) -> RealArray:
    """Return g(nu (1 + error), t^(-1/4) S)/g(nu, S): the static stiffness of a disc over that of the stated one.

    Parameters
    ----------
    stated : float
        Poisson's ratio nu; 1 is returned where that is not above 0.
    shape : float
        S = radius / (2 thickness).
    error : array
        Relative, of nu.
    radial_stiffness : array
        t = E_r / E_z.

    Notes
    -----
    g lies between 1, a free rod, and M/E, a disc without a rim. How far on that way it moves by t is that of the stated
    ratio: right to 0.1 % for nu up to 0.3, or S up to 0.5, where t is a half or two and the error 15 %; to 1 % of flat
    discs with nu = 0.4.
    """
    if stated <= 0:  # g is known from 0 on, where it is 1
        return np.ones_like(error)
    lowest, highest = stated * (1 - _REACH), max(stated, min(stated * (1 + _REACH), _HIGHEST))
    factor = interpolated_shape_factor(shape, lowest, highest, degree=_DEGREE, resolution=_COARSE)
    ratio = np.clip(stated * (1 + error), lowest, highest)
    held = _held(ratio)
    odds = _odds(factor(ratio), held) * np.exp(_by_shape(stated, shape)(radial_stiffness))
    return np.asarray((1 + odds * held) / (1 + odds) / factor(stated))


def _held(poisson_ratio: RealArray) -> RealArray:
    """Return M/E, the factor of a disc without a rim."""
    return np.real(p_wave_modulus(1.0, poisson_ratio))


def _odds(factor: RealArray, held: RealArray) -> RealArray:
    """Return the way from a free rod, over that to a disc without a rim."""
    return (factor - 1) / (held - factor)


@lru_cache(maxsize=64)
def _by_shape(poisson_ratio: float, shape: float) -> Callable[[RealArray], RealArray]:
    """Return the change of ln of the odds by t, constant beyond `_STIFFEST`."""
    held = _held(np.asarray(poisson_ratio))

    def logarithms(x: RealArray) -> RealArray:
        factors = [static_shape_factor(poisson_ratio, shape, resolution=_COARSE, radial_stiffness=t) for t in np.exp(x)]
        return np.log(_odds(np.array(factors), held))

    ends = np.log(_STIFFEST)
    polynomial = Chebyshev.interpolate(logarithms, _SHAPE_DEGREE, domain=[-ends, ends])
    return lambda t: np.asarray(polynomial(np.clip(np.log(t), -ends, ends)) - polynomial(0.0))


@lru_cache(maxsize=4)  # Poisson's ratio varies more often than the shape
def _assembled(radius: float, resolution: float) -> tuple[RealArray, Operators]:
    """Return the places of the nodes of half a disc, and the integrals over it."""
    basis = basis_of(_disc(radius, resolution).mesh)
    return basis.doflocs, operators(basis)


def _disc(radius: float, resolution: float) -> Section:
    size = min(_HALF, radius) / _ACROSS / resolution
    finest = min(_HALF, radius) / _CORNER / resolution
    # the middle plane is no corner, but fine intervals there cost little
    slab = Slab("sample", 0.0, _HALF, max(size, _HALF / 40), finest)
    return build_section([slab], radius, max(size, radius / 60), finest, [])


def _axial_stiffness(nodes: RealArray, parts: Operators, poisson_ratio: float) -> float:
    """Return force over shortening of half a disc of E = 1, its upper face bonded, its lower one on a smooth plane."""
    radial, shear, axial = solid_parts(parts, isotropic(poisson_ratio))
    stiffness = blocks(2, radial) + blocks(2, shear) + blocks(2, axial)
    r, z = nodes
    n, top, bottom = r.size, np.isclose(z, _HALF), np.isclose(z, 0.0)
    free = np.flatnonzero(np.concatenate([~top & (r > 1e-9), ~top & ~bottom]))
    moved = np.zeros(2 * n)
    moved[n:][top] = 1.0
    load = -(stiffness @ moved)
    moved[free] = splu(csc_matrix(stiffness[free][:, free]), permc_spec="MMD_AT_PLUS_A").solve(load[free])
    return float(moved @ (stiffness @ moved))


def dynamic_shape_factor(rig: TwoPlateRig, frequency: ArrayLike, modulus: ModulusLike) -> ComplexArray:
    """Return the apparent over the true modulus of a sample on the rig, frequency by frequency.

    With the apparent modulus a rod of the same length and density under a rigid mass (of top plate and accelerometer)
    moves as the finite-element rig does: eq. (11) of Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96. The ratio
    tends to `static_shape_factor` for low frequencies, and shows waves across the sample where these are no longer than
    its radius.

    Parameters
    ----------
    rig : TwoPlateRig
    frequency : array, shape (n,)
        Hz.
    modulus : law, callable of Hz, or array
        Young's modulus of the sample, Pa.

    Returns
    -------
    complex array, shape (n,)
        NaN where no modulus gives a rod the motion of the rig.
    """
    f = np.atleast_1d(np.asarray(frequency, dtype=float))
    value = modulus(f) if callable(modulus) else modulus
    true = np.broadcast_to(np.asarray(value, dtype=complex), f.shape)
    # from the static limit upwards: at high frequencies several moduli give the same motion
    steps = np.unique(np.concatenate([np.geomspace(min(f.min(), _LOWEST), f.max(), _STEPS), f]))
    order = np.argsort(f)
    along = np.interp(steps, f[order], true[order])
    factors = _follow(rig, steps, along, rig.transmissibility(steps, along))
    return np.asarray(factors[np.searchsorted(steps, f)])


def _follow(rig: TwoPlateRig, frequency: RealArray, modulus: ComplexArray, motion: ComplexArray) -> ComplexArray:
    """Return the factor at every frequency; the search starts from the factor at the frequency below."""
    load = (rig.static_plate_mass + rig.sensor_mass) / (np.pi * rig.radius**2)
    factors = np.full(len(frequency), np.nan + 0j)
    start = complex(static_shape_factor(rig.poisson_ratio, rig.radius / (2 * rig.thickness)))
    for i, (f, e, t) in enumerate(zip(frequency, modulus, motion, strict=True)):

        def off(g: ArrayLike, f: float = f, e: complex = e, t: complex = t) -> ComplexArray:
            rod = rod_transmissibility(f, np.asarray(g) * e, rig.density, rig.thickness, load)
            return np.asarray(rod / t - 1)

        factors[i] = _newton(off, start)
        if np.isfinite(factors[i]):
            start = factors[i]
    return factors


def _newton(function: Callable[[ArrayLike], ComplexArray], start: complex) -> complex:
    """Return the zero of an analytic function near `start`; NaN when there is none."""
    g = start
    for _ in range(_ITERATIONS):
        here, ahead = function([g, g * (1 + _PROBE)])
        change = here * g * _PROBE / (ahead - here)
        g -= change
        if not np.isfinite(g):
            break
        if abs(change) < 1e-10 * abs(g):
            return complex(g)
    return complex(np.nan)

"""Walls with studs against one solved as a periodic whole, and slits: ``docs/validation/walls.md``.

Run it as ``OMP_NUM_THREADS=1 python -m validation.walls > docs/validation/walls.md``; five minutes of computing.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import ValidityWarning
from multilayer.media.empirical import miki
from multilayer.media.gas import dry_air
from multilayer.media.openings import slit_passage
from multilayer.response.bands import band_centres, band_points
from multilayer.response.beside import Sound
from multilayer.response.construction import Construction, paths
from multilayer.simulation import simulate
from multilayer.simulation.file import SimulationFile
from validation.timing import least_seconds

GAS = dry_air()
DEPTH, RESISTIVITY, MAX_ANGLE = 0.07, 8e3, 78.0
BOARD = {"thickness": 0.0125, "density": 720.0, "young_modulus": 2.5e9, "poisson_ratio": 0.3}
_THETAS, _AZIMUTHS = 128, 64
_FROM = 100.0  # Hz; below lies the resonance of the cavity

HEADING = f"""# Walls with studs and slits

Made by `OMP_NUM_THREADS=1 python -m validation.walls`. `docs/walls.md` says what is computed. What stands here are
independent computations; [measured walls](measured_walls.md) have a page of their own.

## Studs: a periodic wall

Two gypsum boards of {1e3 * BOARD["thickness"]:g} mm ({BOARD["thickness"] * BOARD["density"]:g} kg/m2,
{1e-9 * BOARD["young_modulus"]:g} GPa), {1e3 * DEPTH:g} mm of wool between them (Miki, {1e-3 * RESISTIVITY:g} kN s/m4),
line links at every spacing; diffuse field up to {MAX_ANGLE:g} degrees, third octaves from {_FROM:g} Hz to 4 kHz. The
reference is the same endless wall solved as a whole, by space harmonics of these two plates, cavity, air and lines. It
shares nothing with `response` but the formulae of the wool. "periodic" are links with `periodic: true`, "single" those
without it. "Davy" is airborne sound and, beside it, the closed form of Sharp and Davy (T. E. Vigran, Building Acoustics
(2008), eq. 8.27), which holds below the critical frequency, {{critical:.0f}} Hz. Differences are losses less the
reference, in dB; spacings are in m, compliances in m2/N, "to 2 kHz" is a rms.

| spacing | compliance | loss factor | periodic: largest | single: rms | mean | largest | to 2 kHz | Davy: rms | mean |
|---|---|---|---|---|---|---|---|---|---|"""
ENDING = """
Of studs that give way, as those of steel, the force follows from the free leaves: it is small, and what it adds to the
airborne wave is of first order. Rigid ones, as those of wood, let bending waves run from stud to stud, which single
links lose, and Sharp's and Davy's formulae too; the less the boards damp them, the more they radiate, and all studs
alike make stop and pass bands. Around the resonance of the cavity, near 100 Hz, both leaves move with all links
together. What periodic links differ by is left by the numbers of angles, here and there.

## Slits

Lossless slits in a thick wall, diffuse field, against M. C. Gomperts & T. Kihlman, Acustica 18 (1967) 144-150, up to a
fifth of the first resonance of the depth. At an edge ours mirrors the air outside; their formula has the same mass of
it there as elsewhere.

| width / mm | depth / mm | at an edge | largest difference / dB |
|---|---|---|---|"""


TIMES = """
## Time

Seconds of processor time, one thread, the least of 10, of `simulate`: boards of the first table with a loss factor of
0.05 and 75 mm of wool between each two, links every 0.6 m between neighbours, 4 m by 2.5 m; diffuse field, 16 third
octaves from 100 Hz to 3150 Hz (336 frequencies).

| layers | links | s |
|---|---|---|"""


@dataclass(frozen=True)
class Studs:
    """Studs, and the loss factor of the boards that they hold."""

    spacing: float
    compliance: float
    loss_factor: float
    fasteners: float | None = None  # along a stud; None where the boards are held all along


CASES = [
    Studs(spacing, compliance, loss)
    for spacing, compliance, loss in (
        (0.6, 5e-6, 0.03), (0.6, 1e-6, 0.03), (0.4, 1e-6, 0.03), (0.6, 1e-6, 0.1),
        (1.2, 0.0, 0.1), (0.6, 0.0, 0.1), (0.6, 0.0, 0.03), (0.4, 0.0, 0.03),
    )
]  # fmt: skip


def plate(loss_factor: float, board: Mapping[str, Any] = BOARD) -> tuple[float, complex]:
    """Return mass per area and bending stiffness of a board."""
    stiffness = board["young_modulus"] * board["thickness"] ** 3 / (12 * (1 - board["poisson_ratio"] ** 2))
    return board["density"] * board["thickness"], stiffness * (1 + 1j * loss_factor)


def periodic(frequency: RealArray, studs: Studs) -> RealArray:
    """Return tau of an endless wall with studs in a diffuse field, by space harmonics.

    Each stud pulls with F exp(-i kx n b): pressure F/b in every harmonic q = kx + 2 pi n/b of both plates, whose
    motions follow from two equations, with the air outside and the wool between; F from the difference of both motions
    at a stud, i w C F. With fasteners, in every harmonic along the studs, too.
    """
    mass, stiffness = plate(studs.loss_factor)
    omega = 2 * np.pi * frequency[:, None, None]
    k0 = omega / GAS.sound_speed
    nodes, weights = np.polynomial.legendre.leggauss(_THETAS)
    square = np.sin(np.deg2rad(MAX_ANGLE)) ** 2 * (nodes + 1) / 2
    azimuth = (np.arange(_AZIMUTHS) + 0.5) / _AZIMUTHS * np.pi / 2
    kx = k0 * np.sqrt(square)[:, None] * np.cos(azimuth)
    ky = k0 * np.sqrt(square)[:, None] * np.sin(azimuth)
    density, bulk = miki(omega, GAS, flow_resistivity=RESISTIVITY)
    bending = float(np.max((mass * omega**2 / abs(stiffness)) ** 0.25))
    reach = bending * (4 if studs.fasteners is None else 8)
    across = _harmonics(reach, studs.spacing)
    along = [0.0] if studs.fasteners is None else _harmonics(reach, studs.fasteners)
    orders = list(product(across, along))

    def harmonic(n: float, m: float) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
        """Return diagonal and other entry of the symmetric matrix, its determinant, and the air's impedance."""
        q = (kx + n) ** 2 + (ky + m) ** 2
        air = omega * GAS.density / _downwards(k0**2 - q)
        inside = _downwards(omega**2 * density / bulk - q)
        decay = np.exp(-1j * inside * DEPTH)
        wave = omega * density / inside
        own = air + wave * (1 + decay**2) / (1 - decay**2) + 1j * omega * mass + stiffness * q**2 / (1j * omega)
        other = -2 * wave * decay / (1 - decay**2)
        return own, other, own**2 - other**2, air

    own, other, determinant, _ = harmonic(0, 0)
    hindering = 1j * omega * studs.compliance + 0 * kx
    for n, m in orders:
        one, two, det, _ = harmonic(n, m)
        hindering = hindering + 2 * (one + two) / det / studs.spacing
    force = 2 * (own + other) / determinant / hindering
    power = np.zeros(kx.shape)
    for n, m in orders:
        one, two, det, air = harmonic(n, m)
        motion = (one + two) / det * force / studs.spacing
        if n == m == 0:
            motion = motion - 2 * other / determinant
        power += np.abs(motion) ** 2 * air.real
    tau = power.mean(axis=-1) * GAS.impedance / np.sqrt(1 - square)
    return np.asarray(tau @ weights / 2)


def _harmonics(reach: float, step: float) -> list[float]:
    """Return the wavenumbers by which harmonics of supports at equal steps differ from the wave that arrives."""
    most = int(np.ceil(reach * step / (2 * np.pi))) + 3
    return [2 * np.pi * n / step for n in range(-most, most + 1)]


def _downwards(square: ComplexArray) -> ComplexArray:
    root = np.sqrt(np.asarray(square, dtype=complex))
    return np.asarray(np.where(root.imag > 0, -root, root))


def ours(bands: RealArray, studs: Studs, *, alike: bool = False) -> tuple[RealArray, RealArray]:
    """Return tau of the wall, with single links or periodic ones, and of its layers without links.

    Frequencies of bands are those of `band_points`; both results have their shape.
    """
    board = {"type": "elastic_plate", "loss_factor": studs.loss_factor, **BOARD}
    wool = {"type": "equivalent_fluid", "model": "miki", "thickness": DEPTH, "flow_resistivity": RESISTIVITY}
    links = {"kind": "line", "between": ("front", "back"), "spacing": studs.spacing, "compliance": studs.compliance}
    links |= {"periodic": alike, "fasteners": studs.fasteners if alike else None}
    layers = [{"name": "front", **board}, wool, {"name": "back", **board}]
    wall = Construction(layers=layers, termination="ambient", links=[links])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # Miki's formulae below their range, in both
        parts = paths(wall, bands.ravel(), Sound(max_angle=MAX_ANGLE), together=bands.shape[-1])
    airborne = np.asarray(parts["stack"].transmission).reshape(bands.shape)
    return airborne + np.asarray(parts["links"].transmission).reshape(bands.shape), airborne


def sharp_davy(frequency: RealArray, studs: Studs) -> RealArray:
    """Return the structure-borne tau of T. E. Vigran, Building Acoustics (2008), eq. (8.27), of two like leaves."""
    mass, _ = plate(studs.loss_factor)
    omega, c = 2 * np.pi * frequency, GAS.sound_speed
    g = 2 * mass * np.sqrt(2 * np.pi * critical())
    hindered = g**2 + (4 * omega**1.5 * mass**2 * c * studs.compliance - g) ** 2
    return np.asarray(64 * GAS.density**2 * c**3 / (hindered * studs.spacing * omega**2))


def critical(board: Mapping[str, Any] = BOARD) -> float:
    """Return the critical frequency of a board, Hz."""
    mass, stiffness = plate(0.0, board)
    return float(GAS.sound_speed**2 / (2 * np.pi) * np.sqrt(mass / stiffness.real))


def loss(tau: RealArray) -> RealArray:
    """Return transmission losses of bands."""
    return np.asarray(-10 * np.log10(tau.mean(axis=-1)))


def row(studs: Studs) -> str:
    """Return the row of one wall."""
    centres = band_centres(_FROM, 4000, "third octaves")
    points = band_points(centres, "third octaves")
    reference = loss(np.array([periodic(band, studs) for band in points]))
    whole, airborne = ours(points, studs)
    gap = loss(whole) - reference
    alike = loss(ours(points, studs, alike=True)[0]) - reference
    low = centres <= 2000
    simple = (loss(airborne + sharp_davy(points, studs)) - reference)[low]
    worst = int(np.argmax(np.abs(gap)))
    return (
        f"| {studs.spacing:g} | {studs.compliance:g} | {studs.loss_factor:g} | {_largest(alike):+.2f} | "
        f"{rms(gap):.1f} | {gap.mean():+.1f} | "
        f"{gap[worst]:+.1f}, {centres[worst]:g} Hz | {rms(gap[low]):.1f} | {rms(simple):.1f} | {simple.mean():+.1f} |"
    )


def _largest(values: RealArray) -> float:
    return float(values[np.argmax(np.abs(values))])


def rms(values: RealArray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def gomperts_kihlman(frequency: RealArray, width: float, depth: float, n: float) -> RealArray:
    """Return tau of an endless lossless slit in a diffuse field; n is 1 within a wall and 1/2 at its edge."""
    k = 2 * np.pi * frequency / GAS.sound_speed * width
    end, x = (np.log(8 / k) - np.euler_gamma) / np.pi, depth / width
    resonance = np.sin(k * (x + 2 * end)) ** 2 / np.cos(k * end) ** 2
    damping = k**2 / (2 * n**2) * (1 + np.cos(k * (x + 2 * end)) * np.cos(k * x))
    return np.asarray(8 * k * np.cos(k * end) ** 2 / (2 * n**2 * (resonance + damping)))


def slit_row(width: float, depth: float, *, at_edge: bool) -> str:
    """Return the row of one slit."""
    thin = type(GAS)(**{**vars(GAS), "viscosity": 1e-14})
    frequency = np.geomspace(50, GAS.sound_speed / 10 / depth, 50)
    found = slit_passage(frequency, width, 1e5, depth, thin, at_edge=at_edge).transmission
    gap = 10 * np.log10(found / gomperts_kihlman(frequency, width, depth, 0.5 if at_edge else 1.0))
    return f"| {1e3 * width:g} | {1e3 * depth:g} | {'yes' if at_edge else 'no'} | {gap[np.argmax(np.abs(gap))]:+.2f} |"


def time_row(boards: int, compliance: float, alike: bool) -> str:
    """Return the row of a wall with so many boards: how long its simulation takes."""
    wool = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.075, "flow_resistivity": RESISTIVITY}
    names = [f"board {i + 1}" for i in range(boards)]
    layers = [{"type": "elastic_plate", "name": name, "loss_factor": 0.05, **BOARD} for name in names]
    held = {"kind": "line", "spacing": 0.6, "compliance": compliance, "periodic": alike}
    file = SimulationFile.model_validate({
        "version": 1, "layers": [part for layer in layers for part in (layer, wool)][:-1], "termination": "ambient",
        "links": [held | {"name": "-".join(pair), "between": pair} for pair in pairwise(names)],
        "finite_size": {"height": 2.5, "width": 4.0}, "incidence": "diffuse",
        "frequency": {"third_octaves": [100, 3150]},
    })  # fmt: skip
    least, _ = least_seconds(partial(simulate, file), 10)
    kind = f"{'periodic' if alike else 'single'}, {f'{compliance:g} m2/N' if compliance else 'rigid'}"
    return f"| {2 * boards - 1} | {kind} | {least:.2f} |"


def main() -> None:
    """Write the page."""
    lines = [HEADING.format(critical=critical()), *map(row, CASES), ENDING]
    lines += [
        slit_row(width, depth, at_edge=at_edge)
        for width, depth in ((1e-3, 0.1), (2e-3, 0.04), (1e-2, 0.1))
        for at_edge in (False, True)
    ]
    kinds = ((1e-6, True), (0.0, True), (0.0, False))
    lines += [TIMES, *(time_row(boards, *kind) for boards, kind in product((2, 3), kinds))]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

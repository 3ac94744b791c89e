"""All methods against the truth of the paper's three materials, and how far a glued disc moves as a rod.

Part of ``docs/validation/methods.md``; see `validation.methods`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from multilayer.fits.classical.compare import compare_methods
from multilayer.fits.classical.comparison import MethodComparison, MethodPoint
from multilayer.fits.classical.rod_limit import longest_rod, rim_inertia, rod_error
from multilayer.fits.settings import FitSettings, QuasiStatic
from multilayer.fits.sources import read_fit
from multilayer.rig.shape_factor import dynamic_shape_factor, static_shape_factor
from multilayer.rig.two_plate import TwoPlateRig
from validation.scoring import true_modulus

CAMPAIGNS = Path(__file__).parents[1] / ".." / "shared" / "campaigns"
# Bonfiglio & Pompoli 2015, Table 1: E1 and E2 by their quasi-static method, Pa
TABLE_1 = {"paper-a": (806919.0, 363114.0), "paper-b": (121447.0, 27933.0), "paper-c": (54967.0, 4947.0)}
HELD = ("plane-wave", "eq-10", "nelder-mead")
SHARES = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35)
SHAPES = ((22.5, 50.0), (22.5, 25.0), (22.5, 12.5))
RATIOS = (0.0, 0.2, 0.3, 0.4, 0.45)

TRUTH = """
## All methods against the truth

Signals of an independent finite-element rig (nu = 0.3) for the paper's materials A, B and C, 100 to 1500 Hz. Errors
against the material's law at each point's frequency, over the points that a method calls reliable: median of their
size, median with sign (bias), largest size; "within 2 s" is the share whose error is at most two of its own standard
deviations. `eq-10` is the optimum's region by eq. (10); `constant` are the quasi-static values of Table 1, taken for
every burst. The last columns are the checks of causality: mean relative error of eq. (12), and the verdict of the full
Kramers-Kronig relation.

| campaign | method | reliable | median error E1 | E2 | bias E1 | E2 | largest E1 | within 2 s, E1 | E2 | (12) | full |
|---|---|---|---|---|---|---|---|---|---|---|---|"""

READING = """
The three methods that hold the sample sideways (`plane-wave`, `eq-10`, `nelder-mead`) share the free rim's bias in E1,
{bias} here, and none of their standard deviations knows of it, unless eq. (10) makes them so wide that they hold
anything. `finite` and `transfer-function` do not have it; the second up to {limits} only (A, B and C),
where the samples are a quarter of the wavelength thick; the paper says "around 500 Hz" of its own. A value at 5 Hz says
little of 100 Hz and above. In E2 of `paper-c`, whose loss factor is a few per cent, the delay of the channels counts
more than the method."""

ROD = """
## How far a glued disc moves as a rod

Finite elements of a disc glued at both faces, loss factor 0.2, under 1 mm of steel: apparent modulus over
static one, less one, for the sample's thickness over the wavelength of a rod of the apparent modulus. In brackets what
`transfer-function` takes for one standard deviation, c (h/lambda)^2 with c from the disc's finite elements at a tenth.
The limit is where it stops being called reliable: a quarter, or where that makes 10 %.

| nu | radius, thickness / mm | limit | {shares} |
|---|---|---|{rules}|"""


def against_truth() -> str:
    """Return the section on the shared campaigns; a note where they are absent."""
    if not CAMPAIGNS.is_dir():
        return "\n## All methods against the truth\n\nLeft out: the folder ../shared is not here."
    lines, limits, held = [TRUTH], [], []
    for name, values in TABLE_1.items():
        print(name, file=sys.stderr)  # noqa: T201
        folder = CAMPAIGNS / name
        given = QuasiStatic(storage_modulus=values[0], loss_modulus=values[1])
        job = read_fit(folder)
        settings = FitSettings(quasi_static=given)
        found = compare_methods(job.campaign, job.recordings, settings, job.calibration, slow=True)
        lines += _rows(name, found, folder)
        limits += [f"{limit:.0f}" for limit in found.limits.values()]
        held += [np.median(_errors(_reliable(found, method), folder)[:, 0]) for method in HELD]
    bias = f"{100 * min(held):.0f} to {100 * max(held):.0f} %"
    said = READING.format(limits=f"{', '.join(limits[:-1])} and {limits[-1]} Hz", bias=bias)
    return "\n".join([*lines, said])


def _reliable(found: MethodComparison, method: str) -> list[MethodPoint]:
    return [p for p in found.points if p.method == method and p.reliable]


def _errors(points: Sequence[MethodPoint], folder: Path) -> np.ndarray:
    """Return the relative errors of E1 and E2, shape (n, 2)."""
    truth = true_modulus(folder, np.array([p.frequency for p in points]))
    value = np.array([[p.storage_modulus, p.loss_modulus] for p in points])
    return value / np.stack([truth.real, truth.imag], axis=-1) - 1


def _rows(name: str, found: MethodComparison, folder: Path) -> list[str]:
    checks = {check.method: check for check in found.checks()}
    rows = []
    for method in found.names:
        points = [p for p in found.points if p.method == method]
        verdict = ["-", "-"]
        if (check := checks.get(method)) is not None:
            verdict = [f"{100 * check.gross_error:.0f} %", check.verdict]
        label = f"{method}, 5 Hz" if method == "quasi-static" else method
        rows.append(_row(name, label, points, folder, verdict))
    (static,) = (p for p in found.points if p.method == "quasi-static")
    frequencies = sorted({p.frequency for p in found.points if p.method == "plane-wave"})
    everywhere = [_moved(static, f) for f in frequencies]
    return [*rows, _row(name, "constant", everywhere, folder, ["-", "-"])]


def _moved(point: MethodPoint, frequency: float) -> MethodPoint:
    e1, e2 = point.storage_modulus, point.loss_modulus
    return MethodPoint(point.configuration, frequency, point.method, e1, point.storage_modulus_std, e2, np.nan)


def _row(name: str, label: str, points: Sequence[MethodPoint], folder: Path, verdict: list[str]) -> str:
    kept = [p for p in points if p.reliable]
    if not kept:
        return f"| `{name}` | {label} | 0 of {len(points)} | " + " | ".join(["-"] * 9) + " |"
    error = _errors(kept, folder)
    value = np.array([[p.storage_modulus, p.loss_modulus] for p in kept])
    std = np.array([[p.storage_modulus_std, p.loss_modulus_std] for p in kept])
    size = [f"{100 * v:.1f} %" for v in np.median(np.abs(error), axis=0)]
    bias = [f"{100 * v:+.1f} %" for v in np.median(error, axis=0)]
    largest = f"{100 * np.abs(error[:, 0]).max():.0f} %"
    held = ["-", "-"]
    if np.isfinite(std).all():
        in_stds = np.abs(error * value / (1 + error)) / std
        held = [f"{100 * v:.0f} %" for v in (in_stds <= 2).mean(axis=0)]
    cells = [f"`{name}`", label, f"{len(kept)} of {len(points)}", *size, *bias, largest, *held, *verdict]
    return f"| {' | '.join(cells)} |"


def reach_of_the_rod() -> str:
    """Return the section on the limit that the transfer function method states."""
    heading = ROD.format(shares=" | ".join(f"h/lambda = {s:g}" for s in SHARES), rules="|".join(["---"] * len(SHARES)))
    lines = [heading]
    for nu in RATIOS:
        for radius, thickness in SHAPES:
            off = _difference(nu, radius / 1e3, thickness / 1e3)
            inertia = rim_inertia(nu, radius / (2 * thickness))
            said = [rod_error(inertia, share) for share in SHARES]
            cells = [f"{100 * v:.1f} % ({100 * s:.1f})" for v, s in zip(off, said, strict=True)]
            lines.append(f"| {nu:g} | {radius:g}, {thickness:g} | {longest_rod(inertia):.2f} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _difference(poisson_ratio: float, radius: float, thickness: float) -> np.ndarray:
    modulus, density = 2e5 * (1 + 0.2j), 90.0
    static = static_shape_factor(poisson_ratio, radius / (2 * thickness))
    # the real part of theta is what `transfer-function` judges by
    speed = 1 / np.real(np.sqrt(density / (static * modulus)))
    rig = TwoPlateRig(radius, thickness, density, poisson_ratio, 1e-3)
    return np.abs(dynamic_shape_factor(rig, np.array(SHARES) * speed / thickness, modulus) / static - 1)

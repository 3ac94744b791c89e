"""Why the ratios are what they are, which solutions there are, and how exact all of it is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from validation.factorial_cases import RADIUS
from validation.factorial_fit import static_ratio
from validation.factorial_numbers import GAIN, LOST, WEAK, Cases, Run, bending_length, quartiles
from validation.factorial_text import bullets, join, paragraph, table

_BINS = (0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 5.0, 10.0)  # of radius / wavelength
_RANGES = (0.0, 30.0, 62.0, 90.0, 160.0, 500.0)  # of rod waves per metre: the meshes of `factorial_rig`
_SHOWN = (0.3, 0.45)


def slow(cases: Cases) -> str:
    """Return the limit of low frequencies beside what is found."""
    design, text = (
        cases.design,
        """The plane-wave model takes the sample for one whose rim is held: its stiffness is
    that of a P wave, p E with p = (1 - nu)/((1 + nu)(1 - 2 nu)). In slow compression the true stiffness is g(nu, S) E,
    g the shape factor (`multilayer.rig.static_shape_factor`) of S = radius / (2 thickness): the modulus found is too
    low by p/g. Of the stiffest two materials at the lowest frequency:""",
    )
    moduli, lowest = design.moduli[-2:], design.frequencies[0]
    head = ["Poisson's ratio"]
    for h in design.thicknesses:
        head += [f"{1e3 * h:g} mm: p/g", *(f"{modulus:.0e} Pa" for modulus in moduli)]
    rows = []
    for nu in design.poisson_ratios:
        row = [f"{nu:g}"]
        for h in design.thicknesses:
            masks = [cases.where(poisson_ratio=nu, thickness=h, modulus=e, frequency=lowest) for e in moduli]
            row += [
                f"{static_ratio(nu, h):.3f}",
                *(f"{cases.spread('storage', m & cases.solved).mean:.3f}" for m in masks),
            ]
        rows.append(row)
    return join("## Why: slow compression", paragraph(text), table(head, rows), paragraph(_plate(cases)))


def _plate(cases: Cases) -> str:
    lengths = [
        f"{1e3 * bending_length(e, h):.0f} mm with {e:.0e} Pa and {1e3 * h:g} mm"
        for e, h in (
            (cases.design.moduli[-1], cases.design.thicknesses[0]),
            (cases.design.moduli[0], cases.design.thicknesses[-1]),
        )
    ]
    return f"""The shape factor is that of rigid plates. A steel plate of 1 mm bends over (D h / E)^(1/4):
    {" and ".join(lengths)}. Where that is below the radius the plate follows the bulge of the sample, is read on its
    axis, and the ratio leaves p/g although nothing moves fast; E1 and E2 then differ, as steel has no loss."""


def waves(cases: Cases) -> str:
    """Return the ratios over radius / wavelength."""
    shown = [nu for nu in _SHOWN if nu in cases.design.poisson_ratios] or list(cases.design.poisson_ratios[-1:])
    text = """What governs the rest is the sample's radius over its wavelength, here that of a rod's waves,
    sqrt(E1/rho)/f. Short waves are those of the plane-wave model: inertia holds the material sideways and the ratio of
    E1 is 1. E2 is then found too high: part of a wave turns into others at the free rim, and the model takes that for
    loss. In between the sample resonates across its width; the ratio first rises above p/g, and then no modulus of the
    plane-wave model does what the sample does. Over all cases, median and quartiles:"""
    parts = ["## Why: waves", paragraph(text), "![ratios over radius / wavelength](factorial_waves.png)"]
    for nu in shown:
        parts += [f"Poisson's ratio {nu:g}:", _wave_table(cases, cases.solved & cases.where(poisson_ratio=nu))]
    return join(*parts)


def _wave_table(cases: Cases, mask: BoolArray) -> str:
    rows = []
    for low, high in pairwise(_BINS):
        chosen = mask & (cases.waves >= low) & (cases.waves < high)
        if chosen.any():
            ratios = [quartiles(cases[name][chosen]) for name in ("storage", "loss")]
            shares = [f"{100 * m[chosen].mean():.0f} %" for m in (cases.accepted, cases.several)]
            misfit = f"{100 * np.median(cases['misfit'][chosen]):.1f} %"
            rows.append([f"{low:g} to {high:g}", f"{chosen.sum()}", *ratios, misfit, *shares])
    head = [
        "radius / wavelength",
        "cases",
        "ratio of E1",
        "ratio of E2",
        "median misfit",
        "accepted",
        "several solutions",
    ]
    return table(head, rows)


def by_modulus(cases: Cases) -> str:
    """Return why the ratio falls with the frequency."""
    design = cases.design
    nu = design.poisson_ratios[-1]
    rows = []
    for modulus in design.moduli:
        masks = [
            cases.accepted & cases.where(poisson_ratio=nu, modulus=modulus, frequency=f) for f in design.frequencies
        ]
        rows.append([f"{modulus:.0e}", *(str(cases.spread("storage", mask)) for mask in masks)])
    text = f"""The means over Table 2 fall with the frequency because they mix such materials. Ratio of E1 by storage
    modulus, Poisson's ratio {nu:g}, accepted cases: the softest are in the regime of waves from the second frequency
    on, the stiffest never leave slow compression, and those between go through the resonances, where the ratio rises.
    Where nothing moves fast the standard deviations are those of p/g between the thicknesses."""
    head = ["E1, Pa", *(f"{f:g} Hz" for f in design.frequencies)]
    return join("## Why: the mixture", paragraph(text), table(head, rows))


def solutions(cases: Cases) -> str:
    """Return how many solutions there are."""
    rows = []
    groups = [(f"{e:.0e}", cases.where(modulus=e)) for e in cases.design.moduli]
    for label, mask in [*groups, ("all", np.ones(len(cases.table), dtype=bool))]:
        counts = (mask, mask & ~cases.solved, mask & cases.solved & ~cases.accepted, mask & cases.several)
        more = (mask & cases.several & cases.accepted, mask & cases.solved & (cases["missed"] > 0))
        rows.append([label, *(f"{m.sum()}" for m in (*counts, *more))])
    head = ["E1, Pa", "cases", f"below {LOST:.0e}", "none accepted", "several alike", "of these accepted", "missed"]
    return join("## Which solution", table(head, rows), bullets(*_about_solutions(cases)))


def _about_solutions(cases: Cases) -> list[str]:
    best = cases["misfit_best"]
    fitting = cases.solved & (best < 0.1)
    missed = cases.solved & (cases["missed"] > 0)
    other = cases.solved & (np.abs(np.log(cases["storage"] / cases["storage_best"])) > 0.01)
    weakest = cases["transmissibility"][missed].max(initial=0.0)
    return [
        f"""Several solutions fit alike (misfits within a factor of 2) in {cases.several.sum()} cases; the lowest misfit
        is then {100 * np.median(best[cases.several]) if cases.several.any() else 0:.0f} % in the median. Among the
        {fitting.sum()} cases that the model explains to 10 %, {(fitting & cases.several).sum()} have several. So what
        makes a burst ambiguous here is that the model is wrong for it, not that it holds many wavelengths; with noise
        of some 10 % it would be both.""",
        f"""Next to the accepted solution, {(cases.accepted & (cases["misfit_next"] < 0.3)).sum()} cases have another
        minimum with a misfit below 30 %, {(cases.accepted & (cases["misfit_next"] < 0.1)).sum()} one below 10 %.""",
        f"""The solution nearest to the truth is not the best one in {other.sum()} cases: the best one is a wrong
        branch there.""",
        f""""Missed": the search of `multilayer fit` alone would have ended elsewhere; only a start near the truth finds
        the best solution. Its grid has steps of 0.1 in ln E1, and a sample of many wavelengths turns the phase by more
        than that resolves. At most {weakest:.1e} of the base's motion arrives in these cases.""",
    ]


def conditioning(cases: Cases) -> str:
    """Return which cases only the absence of noise determines."""
    rows = []
    for modulus in cases.design.moduli:
        mask = cases.solved & cases.where(modulus=modulus)
        row = [f"{modulus:.0e}"]
        for name in ("gain_storage", "gain_loss"):
            middle, high = np.quantile(cases[name][mask], [0.5, 0.9])
            row += [_short(middle), _short(high), f"{100 * np.mean(cases[name][mask] > GAIN):.0f} %"]
        rows.append([*row, f"{100 * np.mean(cases['transmissibility'][mask] < WEAK):.0f} %"])
    text = f"""Standard deviation of ln E1 and ln E2 per relative noise in the burst's band, median and 9 in 10. Above
    {GAIN:g}, 1 % of noise makes more than 10 % of a modulus: a stiff sample moves as its base does, and the little that
    the top plate moves more carries all that is known of the sample. The last column has the other end: less than
    {WEAK:g} of the base's motion arrives, and an accelerometer's own noise covers it. Noise-free signals determine
    these cases, a laboratory does not."""
    names = [f"{what}{part}" for what in ("E1: ", "E2: ") for part in ("median", "9 in 10", f"above {GAIN:g}")]
    return join("## Ill conditioned", paragraph(text), table(["E1, Pa", *names, f"below {WEAK:g}"], rows))


def _short(value: float) -> str:
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"


def errors(run: Run, cases: Cases) -> str:
    """Return the errors of the transmissibilities."""
    return join(
        "## Errors of the finite elements", bullets(*_reduction(run)), _mesh(run, cases), paragraph(_rest(cases))
    )


def _reduction(run: Run) -> list[str]:
    checks: RealArray = np.array([check for outcome in run.outcomes for check in outcome.reduction]).reshape(-1, 2)
    size, error = checks.T
    strong = size > WEAK
    texts = [
        f"""Reduced bases against full solutions of the same mesh, at {len(checks)} points that they were not made from:
        at most {np.max(error[strong] / size[strong], initial=0.0):.1e} of the transmissibility where that is above
        {WEAK:g} ({strong.sum()} points)"""
    ]
    if not strong.all():
        weak = ~strong
        texts[0] += f""", at most {np.max(error[weak] / size[weak]):.1e} below ({weak.sum()} points, down to
        {size.min():.0e})"""
    texts[0] += ". The longest samples are solved without a basis."
    meshes = """Meshes: change of the transmissibility with every interval halved, at points drawn; and how far the
    moduli of samples with a Poisson's ratio of 0 are from the truth, which holds everything that is numerical:"""
    return [*texts, meshes]


def _mesh(run: Run, cases: Cases) -> str:
    checks: RealArray = np.array([check for outcome in run.outcomes for check in outcome.mesh]).reshape(-1, 3)
    flat = cases.accepted & cases.where(poisson_ratio=0)
    per_metre = cases.waves / RADIUS
    rows = []
    for low, high in pairwise(_RANGES):
        change = checks[(checks[:, 0] >= low) & (checks[:, 0] < high), 2]
        inside = flat & (per_metre >= low) & (per_metre < high)
        if len(change):
            off = [f"{100 * np.abs(cases[n][inside] - 1).max(initial=0.0):.2g} %" for n in ("storage", "loss")]
            points = [f"{len(change)}", f"{100 * np.median(change):.2g} %", f"{100 * change.max():.2g} %"]
            rows.append([f"{low:g} to {high:g}", *points, *off])
    return table(["rod waves per m", "points", "median change", "largest", "E1 off by at most", "E2"], rows)


def _rest(cases: Cases) -> str:
    return f"""An error of the transmissibility of a long sample is mostly one of phase, over dozens of wavelengths, and
    a hundred times smaller in the modulus. {(~cases.solved).sum()} of {len(cases.table)} cases lie below {LOST:.0e}."""


def times(run: Run) -> str:
    """Return the processor time by storage modulus and thickness."""
    rows = []
    for modulus in run.design.moduli:
        found = [
            [o.seconds for o in run.outcomes if np.allclose(o.key[:2], (modulus, h), rtol=1e-6, atol=0)]
            for h in run.design.thicknesses
        ]
        rows.append([f"{modulus:.0e}", *(f"{sum(seconds):.0f}" for seconds in found)])
    head = ["E1, Pa", *(f"{1e3 * h:g} mm" for h in run.design.thicknesses)]
    text = "Processor time, s, over all Poisson's ratios."
    return join("## Time", text, table(head, rows))

"""The page that `validation.factorial` prints: method, the two figures, the paper's statement."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from multilayer.arrays import BoolArray
from validation import factorial_reasons as reasons
from validation.factorial_cases import CYCLES, LINES, PERIOD
from validation.factorial_figures import TITLES, draw
from validation.factorial_numbers import LEVEL, LOST, RATE, Cases, Grid, Run, quartiles
from validation.factorial_text import bullets, join, paragraph, table

_FIGURES = {"storage": "4", "loss": "5"}
_BELOW, _SCATTER = 1.5, 0.5  # the paper's bounds of mean and standard deviation ...
_ABOVE_HZ, _BELOW_NU = 100.0, 0.4  # ... and where they are said to hold


def write_page(run: Run, folder: Path) -> str:
    """Return the page as Markdown, with its figures written into a folder."""
    cases = Cases.of(run)
    draw(cases, folder)
    parts = [_head(run, cases), _method(), *(_ratios(cases, name) for name in TITLES), _statement(cases)]
    parts += [reasons.slow(cases), reasons.waves(cases), reasons.by_modulus(cases)]
    parts += [reasons.solutions(cases), reasons.conditioning(cases), reasons.errors(run, cases), reasons.times(run)]
    return join(*parts)


def _head(run: Run, cases: Cases) -> str:
    n, seconds = len(cases.table), sum(outcome.seconds for outcome in run.outcomes)
    whole = f"in {run.seconds:.0f} s" if run.n_computed == len(run.outcomes) else "in more than one run"
    text = paragraph(
        f"""Made by `python -m validation.factorial --jobs 2` {whole}, with {seconds:.0f} s of processor time:
        {n} cases, the full factorial of Table 2 of Bonfiglio & Pompoli 2015. The finite elements make the signals that
        would be measured, the plane-wave model inverts them. The ratios are, as in the paper, the modulus given to the
        finite elements over the modulus found. Started again after an interruption the command does what is left."""
    )
    return join("# Numerical validation of the paper: Table 2 in full", text)


def _method() -> str:
    lobe = f"{len(LINES)} lines of its main lobe, {100 * LINES[-1] / PERIOD:.0f} % to either side of the tone"
    texts = bullets(
        """Rig: discs of 22.5 mm radius on a rigid base under 1 mm of steel, bonded, with a free rim; the top plate is
        elastic and read on its axis. The modulus is constant within a burst, the Poisson's ratio real.""",
        f"""Signals: {CYCLES} cycles under a Hann window, repeated every {PERIOD} cycles for so long that the response
        repeats itself as well. One period then has lines that do not leak into each other: no ring-down is cut, and
        nothing but the burst's own band matters. The base moves in the {lobe}, and so does the top; no noise.""",
        """Finite elements: `multilayer.rig`. A reduced basis per Poisson's ratio, thickness, storage modulus and range
        of wavenumbers; where the sample is dozens of wavelengths long a basis would take about as many full solutions
        as there are points, and each is solved by itself.""",
        """Inversion: sample and top plate in plane motion (`PlaneWaveRig`; the base is rigid, as above), least squares
        in the burst's band. Every case has the search of `multilayer fit` over all its bounds, and two more starts: the
        truth, and the truth over the ratio of slow compression. Of the solutions whose misfits are within a factor
        of 2 of the lowest the one nearest to the truth is taken: what somebody would take who knows the material, as
        the paper's minimisation starts from known values. What others one would have to tell it from is counted below.
        """,
        f"""Accepted: the solution meets eq. (10), with one sample at {RATE / 1e3:g} kHz and {LEVEL:g} dB, and lies
        within the bounds. Means and standard deviations are over the accepted cases: over all, a few cases without
        any solution govern them (a loss modulus of 0 found makes a ratio without bound).""",
        f"""Where less than {LOST:.0e} of the base's motion arrives the finite elements return rounding: these cases
        count nowhere but in the table of solutions.""",
    )
    return join("## How", texts)


def _ratios(cases: Cases, name: str) -> str:
    number = _FIGURES[name]
    what = "Storage" if name == "storage" else "Loss"
    said = {
        "storage": """The paper's Fig. 4: 1 at a Poisson's ratio of 0, up to about 3.5 to 4 at 0.45 and 100 Hz, falling
        as the frequency rises.""",
        "loss": "The paper's Fig. 5: the same with more scatter.",
    }[name]
    texts = [
        f"## {what} modulus: Fig. {number} of the paper",
        paragraph(f"{said} Means and standard deviations of the ratio over E1, loss factor, density and thickness:"),
        f"![{TITLES[name]}](factorial_{name}.png)",
        _grid(cases, name, cases.accepted),
        "Median and quartiles over all cases, accepted or not:",
        _medians(cases, name),
    ]
    return join(*texts)


def _grid(cases: Cases, name: str, mask: BoolArray) -> str:
    grid, design = cases.grid(name, mask), cases.design
    head = ["Poisson's ratio", *(f"{f:g} Hz" for f in design.frequencies)]
    rows = [[f"{nu:g}", *(str(grid[nu, f]) for f in design.frequencies)] for nu in design.poisson_ratios]
    return table(head, rows)


def _medians(cases: Cases, name: str) -> str:
    head = ["Poisson's ratio", *(f"{f:g} Hz" for f in cases.design.frequencies)]
    rows = []
    for nu in cases.design.poisson_ratios:
        masks = [cases.solved & cases.where(poisson_ratio=nu, frequency=f) for f in cases.design.frequencies]
        rows.append([f"{nu:g}", *(quartiles(cases[name][mask]) for mask in masks)])
    return table(head, rows)


def _statement(cases: Cases) -> str:
    """Return the paper's conclusion beside what is found."""
    texts = [
        "## The paper's statement",
        paragraph(
            f""""For a frequency higher than 100 Hz and Poisson's ratio lower than 0.4, the ratios between FEM and
            proposed transfer matrix model are lower than {_BELOW} with a maximum standard deviation lower than
            {_SCATTER}." Largest mean and largest standard deviation there, and single cases:"""
        ),
        _statement_table(cases),
        bullets(*_findings(cases)),
    ]
    return join(*texts)


def _statement_table(cases: Cases) -> str:
    region = (cases["frequency"] > _ABOVE_HZ) & (cases["poisson_ratio"] < _BELOW_NU)
    rows = []
    for name, label in (("storage", "E1"), ("loss", "E2")):
        for mask, which in ((cases.accepted, "accepted"), (cases.solved, "all")):
            found = [s for s in cases.grid(name, mask & region).values() if s.n]
            mean, std = (max((s[i] for s in found), default=float("nan")) for i in range(2))
            single = cases[name][mask & region] >= _BELOW
            verdict = "confirmed" if mean < _BELOW and std < _SCATTER else "refuted"
            share = f"{single.sum()} of {single.size}"
            shown = [f"{value:.2f}" if value < 100 else "beyond 100" for value in (mean, std)]
            rows.append([label, which, *shown, f"**{verdict}**", share])
    return table(["", "cases", "largest mean", "largest std", "statement", f"single ratios of {_BELOW} or more"], rows)


def _findings(cases: Cases) -> list[str]:
    storage, loss = (cases.grid(name, cases.accepted) for name in TITLES)
    flat = cases.accepted & cases.where(poisson_ratio=0)
    off = np.abs(cases["storage"][flat] - 1).max(initial=0.0)
    above = [key for key in storage if key[0] > 0]
    wider = sum(loss[key].std > storage[key].std for key in above)
    return [
        f"Ratio 1 at a Poisson's ratio of 0: confirmed, E1 within {100 * off:.2f} % in all {flat.sum()} cases.",
        _highest(cases, storage),
        _falls(cases, storage),
        f"E2 scatters more than E1: in {wider} of {len(above)} groups of a Poisson's ratio above 0.",
    ]


def _highest(cases: Cases, storage: Grid) -> str:
    nu, f, thickness = cases.design.poisson_ratios[-1], cases.design.frequencies[0], cases.design.thicknesses[-1]
    mask = cases.accepted & cases.where(poisson_ratio=nu, frequency=f, thickness=thickness)
    return f"""Poisson's ratio {nu:g} at {f:g} Hz: {storage[nu, f]}; the paper's 3.5 to 4 are the upper end of that
    scatter, the samples of {1e3 * thickness:g} mm: {cases.spread("storage", mask)}; or, more likely, those of samples
    whose faces slide (`examples/reproducing`)."""


def _falls(cases: Cases, storage: Grid) -> str:
    frequencies, ratios = cases.design.frequencies, [nu for nu in cases.design.poisson_ratios if nu > 0]
    first, last = frequencies[0], frequencies[-1]
    rising = ", ".join(f"{nu:g}" for nu in ratios if storage[nu, last].mean >= storage[nu, first].mean)
    peaks = [(nu, max(frequencies, key=lambda f, nu=nu: storage[nu, f].mean)) for nu in ratios]  # type: ignore[misc]
    later = ", ".join(f"{nu:g} ({f:g} Hz)" for nu, f in peaks if f != first)
    verdict = f"refuted for {rising}" if rising else "confirmed for every Poisson's ratio above 0"
    return f"""Falls from {first:g} to {last:g} Hz: {verdict}. Not at every step: the mean is largest at a higher
    frequency than the lowest for {later or "none"}, see below."""

"""The page that `validation.peers` prints."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

OURS = "multilayer"
KINDS = ("thin plate", "elastic solid")
CLOSED = "a 0 closed form"
UNIT = "us per frequency"
AGREEMENT = 1e-6  # of a reflection, or dB


@dataclass(frozen=True)
class Findings:
    """What was measured.

    Attributes
    ----------
    programs : dict
        By name: ``python``, ``versions`` and ``cases``, each with ``seconds`` per frequency and ``values``.
    absent : dict
        Why a peer is not among them.
    alone : dict
        Answers of `peer_alone` by question.
    runs, frequencies, few : int
        Timings per case, frequencies, and frequencies of a diffuse field that takes long.
    """

    programs: dict[str, Any]
    absent: dict[str, str]
    alone: dict[str, Any]
    runs: int
    frequencies: int
    few: int

    def seconds(self, program: str, case: str) -> float | None:
        """Return the time per frequency, s; None where the program cannot solve the case."""
        found = self.programs.get(program, {"cases": {}})["cases"].get(case)
        return None if found is None else float(found["seconds"])

    def values(self, program: str, case: str) -> Any:
        """Return the results of a case."""
        return np.array(self.programs[program]["cases"][case]["values"]) @ [1, 1j]

    def fastest(self, cases: Sequence[str]) -> tuple[str, float] | None:
        """Return the peer and time, s, that solve the quickest of `cases`."""
        found = [
            (seconds, name if len(cases) == 1 else f"{name} with {_label(case)}")
            for name in self.programs
            for case in cases
            if name != OURS and (seconds := self.seconds(name, case)) is not None
        ]
        return min(found)[::-1] if found else None


def write_page(findings: Findings) -> str:
    """Return the page as Markdown."""
    sections = (_head, _agreement, _absorber, _partition, _diffuse, _solve, _layers, _memory, _cores)
    return _join(*(section(findings) for section in sections))


def _head(findings: Findings) -> str:
    rows = [_program_row(name, found) for name, found in findings.programs.items()]
    rows += [[name, f"absent: {reason}", "", ""] for name, reason in findings.absent.items()]
    how = f"""Made by `python -m validation.peers`. Every program runs in an environment and processes of its
        own, on one thread (`OMP_NUM_THREADS=1`), in turns with the others; a time is the least of
        {findings.runs} after a warm-up. Unless said otherwise: {findings.frequencies} frequencies from 100 to
        5000 Hz. The times are those of one machine; the ratios, taken in one run, are what to read. pyva and
        pymls get the last numpy that they work with."""
    same = """Foam in all cases: porosity 0.98, flow resistivity 15e3 N s/m4, tortuosity 1.05, viscous and thermal
        lengths 100 and 250 um, frame density 25 kg/m3, Young's modulus 140 kPa, Poisson's ratio 0.3, loss
        factor 0.1. Aluminium: 2700 kg/m3, 70 GPa, 0.3, 0.01. The same air in all programs: 1.213 kg/m3, 101325
        Pa, ratio of specific heats 1.4, viscosity 1.839e-5 Pa s, Prandtl number 0.71. Elastic plates are taken
        as thin plates in bending, on which the foam slips, and as elastic solids, to which it is bonded; each
        program is compared with the same kind."""
    return _join("# Speed", _text(how), _table(["program", "packages", "Python", "numpy"], rows), _text(same))


def _program_row(name: str, found: dict[str, Any]) -> list[str]:
    packages = ", ".join(f"{package} {v}" for package, v in found["versions"].items() if package != "numpy")
    return [name, packages, found["python"], found["versions"]["numpy"]]


def _agreement(findings: Findings) -> str:
    rows = [
        [name, f"({case[0]}) {_label(case)}", *_difference(findings, name, case)]
        for name, found in findings.programs.items()
        for case in found["cases"]
        if name != OURS and not case.startswith("c ")
    ]
    intro = """Largest differences from multilayer over all frequencies, of the complex reflection in (a) and of the
        transmission loss in (b). The diffuse fields, integrated by each program in its own way, are compared below."""
    agree = all(float(row[2]) < AGREEMENT for row in rows)
    notes = f"""{"All" if agree else "**Not all**"} are below {AGREEMENT:.0e}. To make the problems the same, pyva 1.3.1
        is given the viscous length divided by the root of the air's density, which its formula for the viscous forces
        lacks, and is made to pass the air on to its diffuse field, which would take another. pymls 1.8.1 solves (a) at
        1e-6 degrees: at exactly 0 it meets a singular matrix. It is timed without the printing of a matrix that it does
        for every solid layer and frequency."""
    table = _table(["program", "case", "largest difference", "of"], rows)
    return _join("## Do they compute the same?", _text(intro), table, _text(notes))


def _difference(findings: Findings, name: str, case: str) -> list[str]:
    own = findings.values(OURS, "a 0" if case == CLOSED else case)
    largest = np.max(np.abs(findings.values(name, case) - own))
    return [f"{largest:.1e}", "reflection" if case.startswith("a") else "dB"]


def _absorber(findings: Findings) -> str:
    cases = ["a 0", "a 45"]
    rows = [[name, *_times(findings, name, cases)] for name in findings.programs]
    closed = _times(findings, "phonometry", [CLOSED], ["a 0"])
    rows.append(["phonometry, closed form", *closed, "-", "-"])
    titles = ["program", f"0 degrees, {UNIT}", "times multilayer", f"45 degrees, {UNIT}", "times multilayer"]
    notes = f"""{_times_faster(findings, {case: [case] for case in cases}, 2)} The closed form holds for one poroelastic
        layer on a wall at normal incidence and for nothing else; it is shown for comparison, and the target is not
        measured by it."""
    return _join("## (a) 50 mm of foam on a wall, plane wave", _table(titles, rows), _text(notes))


def _partition(findings: Findings) -> str:
    cases = [f"b {kind}" for kind in KINDS]
    rows = [[name, *_times(findings, name, cases)] for name in findings.programs if _solves(findings, name, cases)]
    notes = f"""{_times_faster(findings, dict.fromkeys(cases, cases), 20)}
        Each is measured by the fastest peer, whatever its plates. With thin plates pyva is given 20 frequencies at a
        time, which is where it is fastest."""
    title = "## (b) Aluminium 1 mm, foam 50 mm, air 20 mm, aluminium 1 mm, plane wave at 45 degrees"
    return _join(title, _plates_table(rows), _text(notes))


def _diffuse(findings: Findings) -> str:
    title, cases = "## (c) The same in a diffuse field up to 78 degrees", [f"c {kind}" for kind in KINDS]
    if not _solves(findings, OURS, cases):
        return _join(title, "multilayer has no `diffuse_field` yet.")
    names = [name for name in findings.programs if _solves(findings, name, cases)]
    rows = [[name, *_times(findings, name, cases)] for name in names]
    errors = [[name, *(_diffuse_error(findings, name, kind) for kind in KINDS)] for name in names]
    error_titles = ["program", *(f"{_label('c ' + kind)}, largest error, dB" for kind in KINDS)]
    worst = max(float(_diffuse_error(findings, OURS, kind)) for kind in KINDS)
    reference = findings.alone["reference"].values()
    notes = f"""{_times_faster(findings, dict.fromkeys(cases, cases), 100)}
        {_target("error below 0.01 dB", worst < 0.01, f"reached {worst:.1e} dB")} The peers' diffuse fields are taken at
        {findings.few} of the frequencies, pyva's at its own step of 1 degree. The error is the difference from a
        quadrature of plane waves at {max(found["angles"] for found in reference)} angles, which itself changes by
        {max(found["change"] for found in reference):.1e} dB when half of them are taken."""
    return _join(title, _plates_table(rows), _table(error_titles, errors), _text(notes))


def _diffuse_error(findings: Findings, name: str, kind: str) -> str:
    if findings.seconds(name, f"c {kind}") is None:
        return "-"
    values = findings.values(name, f"c {kind}").real
    exact = np.array(findings.alone["reference"][kind]["values"])
    # the same few frequencies as in peer_case.Grid
    places = [round(i * (len(exact) - 1) / (len(values) - 1)) for i in range(len(values))]
    return f"{np.max(np.abs(values - exact[places])):.1e}"


def _solve(findings: Findings) -> str:
    found = findings.alone["solve"]
    rows = [
        [f"{kind}s", f"{row['size']}", _number(row["bare"] * 1e6), _number(row["whole"] * 1e6), f"{_overhead(row):.2f}"]
        for kind, row in found.items()
    ]
    intro = """The bare one is `numpy.linalg.solve` on stacked random complex matrices of the size the assembled system
        would have, with one right-hand side; the whole one is `plane_wave`, from the stack to the transmission loss."""
    worst = max(_overhead(row) for row in found.values())
    table = _table(["plates", "size", f"bare, {UNIT}", f"whole, {UNIT}", "ratio"], rows)
    verdict = _target("at most 1.6 times", worst <= 1.6, f"reached {worst:.2f}")
    return _join("## The whole solution of (b) beside a bare solution of ready matrices", _text(intro), table, verdict)


def _overhead(row: dict[str, float]) -> float:
    return row["whole"] / row["bare"]


def _layers(findings: Findings) -> str:
    found = findings.alone["layers"]
    rows = [[count, _number(taken * 1e6), f"{taken / found['5']:.2f}"] for count, taken in found.items()]
    growth = max(found.values()) / found["5"]
    table = _table(["layers", f"per layer, {UNIT}", "relative to 5 layers"], rows)
    verdict = _target("no more than 30 % above that of 5 layers", growth <= 1.3, f"largest {growth:.2f}")
    intro = (
        "Foam, air and elastic aluminium in turn, thicknesses as in (b), 45 degrees. Matrices of layers that are alike "
        "are made once: of many layers each takes less."
    )
    return _join("## Time per layer", intro, table, verdict)


def _memory(findings: Findings) -> str:
    found = findings.alone["memory"]
    known = found["peak"] is not None
    peak = f"{found['peak'] / 1e9:.2f}" if known else f"above {found['limit'] / 1e9:.1f}"
    table = _table(["points", "before, GB", "peak, GB"], [[f"{found['points']}", f"{found['before'] / 1e9:.2f}", peak]])
    met = known and found["peak"] < 1e9 and found["points"] >= 1e6
    verdict = _target("1e6 points under 1 GB", met, f"reached {peak} GB")
    intro = "(b) with elastic solids, as many angles as frequencies in one call; peak resident memory of the process."
    return _join("## Memory", intro, table, verdict)


def _cores(findings: Findings) -> str:
    found = findings.alone["cores"]
    gains = {name: found[_one(name)] / taken for name, taken in found.items() if not name.startswith("one")}
    best = max(gains.values())
    table = _table(["how", "times faster than on one"], [[name, f"{gain:.2f}"] for name, gain in gains.items()])
    verdict = _target("1.7 times or better", best >= 1.7, f"reached {best:.2f}")
    intro = "(b) with elastic solids at 50 angles; each way against one thread of the same function."
    return _join("## Two cores", intro, table, verdict)


def _one(name: str) -> str:
    return "one: diffuse_field" if name.startswith("diffuse_field") else "one"


def _solves(findings: Findings, name: str, cases: Sequence[str]) -> bool:
    return any(findings.seconds(name, case) is not None for case in cases)


def _times(findings: Findings, name: str, cases: Sequence[str], own: Sequence[str] | None = None) -> list[str]:
    """Return the cells of every case: the time, and how many times multilayer's in the case `own` it is."""
    cells = []
    for case, reference in zip(cases, own or cases, strict=True):
        taken, ours = findings.seconds(name, case), findings.seconds(OURS, reference)
        cells += ["-", "-"] if taken is None or ours is None else [_number(taken * 1e6), _number(taken / ours)]
    return cells


def _times_faster(findings: Findings, rivals: dict[str, list[str]], target: float) -> str:
    """Return the verdict on being `target` times faster than the fastest peer in the `rivals` of each own case."""
    ratios = {}
    for case, others in rivals.items():
        ours, fastest = findings.seconds(OURS, case), findings.fastest(others)
        if ours is None or fastest is None:
            return "No peer is here to compare with."
        ratios[f"{_label(case)}: {_number(fastest[1] / ours)} ({fastest[0]})"] = fastest[1] / ours
    met = min(ratios.values()) >= target
    return _target(f"at least {target:g} times faster than the fastest peer", met, ", ".join(ratios))


def _label(case: str) -> str:
    what = case.split(" ", 1)[1]
    return {"0": "0 degrees", "45": "45 degrees", "0 closed form": "0 degrees, closed form"}.get(what, f"{what}s")


def _target(text: str, met: bool, reached: str) -> str:
    return f"Target: {text}; {reached}: **{'met' if met else 'not met'}**."


def _plates_table(rows: list[list[str]]) -> str:
    titles = ["program", f"thin plates, {UNIT}", "times multilayer", f"elastic solids, {UNIT}", "times multilayer"]
    return _table(titles, rows)


def _join(*blocks: str) -> str:
    return "\n\n".join(blocks)


def _text(paragraph: str) -> str:
    return textwrap.fill(" ".join(paragraph.split()), 120, break_long_words=False, break_on_hyphens=False)


def _table(titles: list[str], rows: list[list[str]]) -> str:
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _number(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"

"""Two walls of wood studs that were measured, beside what links of every kind foretell.

Run it as ``python -m validation.measured_walls > docs/validation/measured_walls.md``; ten minutes of computing.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.file import diagnosis_file
from multilayer.diagnosis.levels.diagnose import diagnose_levels
from multilayer.errors import ValidityWarning
from multilayer.response.bands import band_points
from multilayer.response.beside import Sound
from multilayer.response.construction import Construction, wall_shares
from multilayer.response.finite_size import Window
from validation.walls import critical, loss, rms

CENTRES = np.array([50, 63, 80, 100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150,
                    4000.0])  # fmt: skip
DIRECT = np.array([21.5, 19.5, 21.8, 16.3, 12.5, 11.4, 22.6, 32.7, 36.7, 42.0, 44.2, 48.4, 53.4, 56.1, 57.3, 57.4, 55.4,
                   45.5, 43.0, 47.4])  # fmt: skip
CHANNELS = np.array([18.9, 13.5, 17.7, 15.7, 20.5, 28.6, 36.4, 43.7, 48.5, 54.0, 57.2, 61.0, 64.0, 67.0, 69.4, 70.0,
                     66.8, 55.4, 52.7, 56.0])  # fmt: skip
BOARD: dict[str, Any] = {
    "type": "elastic_plate", "thickness": 0.0127, "density": 640.0, "young_modulus": 2.0e9, "poisson_ratio": 0.3,
    "loss_factor": 0.03,
}  # fmt: skip
WOOL: dict[str, Any] = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.09, "flow_resistivity": 12e3}
GAP: dict[str, Any] = {"type": "fluid", "thickness": 0.013}
LEAVES: dict[str, Any] = {"between": ("front", "back")}
SIZE = Window(3.05, 2.44)
_POINTS = slice(2, None, 4)  # of the 21 frequencies of a band
_SPREAD = 0.1  # of the boards' density and modulus, a standard deviation
_FROM = 100.0  # Hz; bands below are left out of rms and mean
_STEPS = (0.3, 0.4, 0.6)  # m, from screw to screw
_OF_STUDS = (5e-8, 1e-7, 2e-7, 5e-7)  # compliances, m2/N
_OF_CHANNELS = (1e-7, 2e-7, 5e-7, 1e-6, 2e-6, 5e-6, 1e-5)

PAGE = """# Walls that were measured

Made by `python -m validation.measured_walls`. Two walls of R. E. Halliwell, T. R. T. Nightingale, A. C. C. Warnock &
J. A. Birta, *Gypsum Board Walls: Transmission Loss Data*, IRC-IR-761, National Research Council Canada (1998):
TL-93-176 (G13_WS90(406)_CFL90_G13) and TL-93-185 (G13_WS90(406)_MFB90_RC13(610)_G13). Their names say 13 mm gypsum
boards on studs of wood of 90 mm every 406 mm, 90 mm of cellulose and of mineral fibre; the second has resilient
channels of 13 mm every 610 mm under one of its boards. **The report itself was not at hand**: losses and names are as
quoted elsewhere, and what follows is assumed, for both walls alike: boards of {mass:.1f} kg/m2, {modulus:g} GPa and a
loss factor of {losses:g}, whose critical frequency, {critical:.0f} Hz, lies by the dips measured; wool of Miki's
formulae with {resistivity:g} kN s/m4; a size of {width:g} m by {height:g} m; a diffuse field up to 78 degrees. How far
the screws are apart was not at hand either: 0.3 to 0.6 m are usual.

All losses are in dB; rms and mean are those of foretold less measured, from {first:g} Hz to {last:g} kHz.

## Boards on the studs

Lines 406 mm apart: "single" ones are taken each by itself; "all along" is `periodic: true`; "screws" are that with
`fasteners`, the distance of the screws; single points are as many as there are screws 0.4 m apart. All are rigid but
those of the last column, where the distance of the screws ({steps} m) and the compliance ({compliances} m2/N) fit best:
{step:g} m and {direct_compliance:g} m2/N.

{direct}

The dip at 125 and 160 Hz is no resonance of the boards on the cavity, which is at 80 Hz ("no links"), but of the boards
between the studs: from 100 to 250 Hz the wall that is held all along is within {low:.1f} dB, single links are off by up
to {low_single:.1f} dB. From 315 Hz to 2 kHz a wall that is held all along would lose {least:.0f} to {most:.0f} dB less
than is measured: the screws hold its boards there. What gives way, screws in gypsum or the studs' wood, was not known
beforehand; the number that fits, {give:.1g} m/N for each screw, takes the rms from {rigid:.1f} to {soft:.1f} dB. Below
100 Hz the laboratory has too few modes for a diffuse field.

## One board on resilient channels

Channels cross a stud every 406 mm: lines 610 mm apart with `fasteners` of 406 mm; that the other board is held by its
studs is left out. Their compliance is the one number
that is fitted, among {channel_compliances}: {compliance:g} m2/N, that is {stiffness:.2g} N/m at each crossing.

{channels}

From 1 kHz on the channels carry little, and what is measured stays below what the layers alone let through: other
paths, in the laboratory or in the wall, end the loss near 70 dB.

## What `multilayer diagnose` says

Of the layers without links, both walls at once, from {first:g} Hz on, density and modulus of the boards unknown to
{spread:g} %: *{sentence}* Chi-square per band is {before:.1f} before and {after:.1f} after that. Its law of structural
links is that of single ones (Sharp and Davy), which has no bays and no screws.
"""


def walls() -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the layers of both walls."""
    front, back = BOARD | {"name": "front"}, BOARD | {"name": "back"}
    return [front, WOOL, back], [front, WOOL, GAP, back]


def foretold(layers: list[dict[str, Any]], *links: dict[str, Any]) -> RealArray:
    """Return the loss of a wall with links in third octaves, dB."""
    wall = Construction(layers=layers, termination="ambient", links=[LEAVES | these for these in links])
    points = band_points(CENTRES, "third octaves")[:, _POINTS]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)  # Miki's range, and single links close to each other
        tau = wall_shares(wall, points.ravel(), Sound(), SIZE, points.shape[-1]).transmission
    assert tau is not None  # between two rooms
    return loss(tau.reshape(points.shape))


def diagnosis() -> dict[str, Any]:
    """Return what the diagnosis says of the layers without links."""
    stacks = dict(zip(("direct", "channels"), walls(), strict=True))
    measurement = {
        "kind": "transmission_loss", "incidence": {"diffuse": {"max_angle": 78.0}}, "bands": "third octaves",
        "finite_size": {"width": SIZE.width, "height": SIZE.height},
    }  # fmt: skip
    boards = [f"{wall}.layers.{leaf}" for wall in stacks for leaf in LEAVES["between"]]
    unknowns = {
        key: {"paths": [f"{board}.{field}" for board in boards], "normal": [BOARD[field], _SPREAD * BOARD[field]]}
        for key, field in (("density", "density"), ("modulus", "young_modulus"))
    }
    with TemporaryDirectory() as folder:
        for name, losses in zip(stacks, (DIRECT, CHANNELS), strict=True):
            rows = [f"{f:g},{level:g}" for f, level in zip(CENTRES, losses, strict=True) if f >= _FROM]
            text = "\n".join(["frequency_hz,transmission_loss_db", *rows, ""])
            (Path(folder) / f"{name}.csv").write_text(text, encoding="utf-8")
        file = diagnosis_file(
            Path(folder),
            stacks={
                name: {"version": 1, "layers": layers, "termination": "ambient"} for name, layers in stacks.items()
            },
            measurements=[measurement | {"name": name, "stack": name, "file": f"{name}.csv"} for name in stacks],
            unknowns=unknowns,
        )
        return diagnose_levels(file).record


def table(measured: RealArray, losses: dict[str, RealArray]) -> str:
    """Return a table of losses by bands, and of how far they are off."""
    rows = ["| Hz | measured | " + " | ".join(losses) + " |", "|---" * (2 + len(losses)) + "|"]
    for i, centre in enumerate(CENTRES):
        rows.append(f"| {centre:g} | {measured[i]:.1f} | " + " | ".join(f"{v[i]:.1f}" for v in losses.values()) + " |")
    gaps = [off(values, measured) for values in losses.values()]
    rows.append("| **rms** | | " + " | ".join(f"**{rms(gap):.1f}**" for gap in gaps) + " |")
    rows.append("| mean | | " + " | ".join(f"{gap.mean():+.1f}" for gap in gaps) + " |")
    return "\n".join(rows)


def off(losses: RealArray, measured: RealArray) -> RealArray:
    """Return what a wall is foretold too high, in the bands that count."""
    return np.asarray((losses - measured)[CENTRES >= _FROM])


def listed(values: tuple[float, ...]) -> str:
    """Return numbers in words."""
    return ", ".join(f"{value:g}" for value in values)


def page() -> str:
    """Return the page."""
    direct, channels = walls()
    line = {"kind": "line", "spacing": 0.406, "periodic": True}
    screwed = {
        (step, compliance): foretold(direct, line | {"fasteners": step, "compliance": compliance})
        for step in _STEPS
        for compliance in (0.0, *_OF_STUDS)
    }
    step, gives = min(screwed, key=lambda case: rms(off(screwed[case], DIRECT)))
    held = {
        "no links": foretold(direct),
        "single": foretold(direct, {"kind": "line", "spacing": 0.406}),
        "all along": foretold(direct, line),
        **{f"screws {step:g} m": screwed[step, 0.0] for step in _STEPS},
        "single points": foretold(direct, {"kind": "point", "spacing": 0.4}),
        f"screws {step:g} m, {gives:g} m2/N": screwed[step, gives],
    }
    studs = 0.406  # m
    crossing = line | {"spacing": 0.61, "fasteners": studs}
    tried = {compliance: foretold(channels, crossing | {"compliance": compliance}) for compliance in _OF_CHANNELS}
    best = min(tried, key=lambda compliance: rms(off(tried[compliance], CHANNELS)))
    carried = {"no links": foretold(channels), "rigid": foretold(channels, crossing), f"{best:g} m2/N": tried[best]}
    low, middle = (CENTRES >= 100) & (CENTRES <= 250), (CENTRES >= 315) & (CENTRES <= 2000)
    short = (DIRECT - held["all along"])[middle]
    found = diagnosis()
    return PAGE.format(
        mass=BOARD["density"] * BOARD["thickness"], modulus=1e-9 * BOARD["young_modulus"], losses=BOARD["loss_factor"],
        critical=critical(BOARD),
        resistivity=1e-3 * WOOL["flow_resistivity"], width=SIZE.width, height=SIZE.height, first=_FROM,
        last=1e-3 * CENTRES[-1], direct=table(DIRECT, held), channels=table(CHANNELS, carried), compliance=best,
        stiffness=studs / best, step=step, direct_compliance=gives, steps=listed(_STEPS),
        compliances=listed((0.0, *_OF_STUDS)), channel_compliances=listed(_OF_CHANNELS),
        low=np.abs(held["all along"] - DIRECT)[low].max(), low_single=np.abs(held["single"] - DIRECT)[low].max(),
        least=short.min(), most=short.max(), give=gives / step, rigid=rms(off(screwed[step, 0.0], DIRECT)),
        soft=rms(off(screwed[step, gives], DIRECT)), spread=100 * _SPREAD,
        sentence=found["sentence"], before=found["gap"]["before"], after=found["gap"]["after"],
    )  # fmt: skip


if __name__ == "__main__":
    sys.stdout.write(page())

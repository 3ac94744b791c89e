"""``multilayer export``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from multilayer.cli import completion

if TYPE_CHECKING:
    from multilayer.exchange.quantities import Wanted

_CARDS = (".bdf", ".dat", ".nas")


def export(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A stack file, or a simulation file without a sweep.")],
    kind: Annotated[
        str,
        typer.Option(
            "--as",
            metavar="KIND",
            help="surface_impedance, surface_admittance, admittance_matrix, impedance_matrix, transfer_matrix, "
            "absorption, transmission_loss, sea_trim; or nastran: cards of poroelastic layers.",
            autocompletion=completion.exports,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out", metavar="TABLE", help="File to write: .csv .mat .h5 .hdf5 .uff .unv, of cards .bdf .dat .nas."
        ),
    ],
    angle: Annotated[
        str | None, typer.Option(metavar="DEG,DEG,...", help="Angles from the normal; by default the file's incidence.")
    ] = None,
    trace_wavenumber: Annotated[
        str | None, typer.Option(metavar="K,K,...", help="Wavenumbers along the faces, rad/m, in place of angles.")
    ] = None,
    front: Annotated[
        str, typer.Option(help="What touches the front face: fluid, or plate.", autocompletion=completion.faces)
    ] = "fluid",
    back: Annotated[
        str, typer.Option(help="What touches the back face, of matrices.", autocompletion=completion.faces)
    ] = "fluid",
    frame_density: Annotated[
        str | None,
        typer.Option(
            metavar="WHICH",
            help="What RHO of a frame's MAT1 is: bulk (per volume of foam), or solid (of its material).",
            autocompletion=completion.frame_densities,
        ),
    ] = None,
    first_id: Annotated[int, typer.Option(metavar="N", help="Number of the first material of cards.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")] = False,
) -> None:
    """Write what a stack does as a table for programs of FE, BEM, SEA and room acoustics.

    Frequencies, incidence and panel size are those of FILE. Signs and units stand in the table. Of poroelastic layers
    --as nastran writes MATPE1, MAT1 and MAT10. Exit status: 0 done, 2 the input cannot be used (nothing is written).

    Example: multilayer export examples/three_layers.yaml --as admittance_matrix --angle 0,30,60 --out trim.csv
    """
    from multilayer.errors import InputError

    if kind == "nastran":
        if angle is not None or trace_wavenumber is not None or (front, back) != ("fluid", "fluid"):
            raise InputError("cards have no direction and no faces; leave out --angle, --front and the like")
        _cards(file, out, frame_density, first_id, as_json=as_json)
        return
    from multilayer.config.validate import placed_in
    from multilayer.exchange.formats import refuse_unknown_suffix
    from multilayer.exchange.quantities import export as exported
    from multilayer.simulation.file import load_simulation
    from multilayer.writing.folders import write_file

    if frame_density is not None or first_id != 1:
        raise InputError("--frame-density and --first-id belong to cards; write --as nastran, or leave them out")
    refuse_unknown_suffix(out)
    wanted = _wanted(kind, angle, trace_wavenumber, front, back)
    with placed_in(file):
        table = exported(load_simulation(file), wanted, file.stem)
    write_file(out, table.content(out))
    record = {
        "version": 1, "file": str(out), "kind": table.kind, "values": [*table.values], "units": dict(table.units),
        "frequencies": table.frequency.size, "along": table.along,
        "directions": table.directions.tolist() if table.along else [], "remarks": list(table.remarks),
    }  # fmt: skip
    _tell(record, as_json=as_json)


def _cards(file: Path, out: Path, frame_density: str | None, first_id: int, *, as_json: bool) -> None:
    from multilayer.config.validate import placed_in
    from multilayer.errors import InputError, Problem
    from multilayer.exchange.nastran import FRAME_DENSITIES, poroelastic_cards
    from multilayer.stack import load_stack
    from multilayer.writing.folders import write_file

    if out.suffix.lower() not in _CARDS:
        text = f"cards are not written as '{out.suffix}'; allowed: {', '.join(_CARDS)}"
        raise InputError(Problem(text, file=out))
    if frame_density not in FRAME_DENSITIES:
        what = "is missing" if frame_density is None else f"'{frame_density}' is not allowed"
        meant = "; or ".join(f"{name}, {text}" for name, text in FRAME_DENSITIES.items())
        raise InputError(f"--frame-density: {what}; say what your program takes as RHO of the frame's MAT1: {meant}")
    with placed_in(file):
        text = poroelastic_cards(load_stack(file), frame_density, first_id=first_id, name=file.stem)
    write_file(out, text)
    remarks = [line.removeprefix("$ ") for line in text.splitlines() if line.startswith("$")]
    names = [line.split("*")[0] for line in text.splitlines() if line[:1].isalpha()]
    record = {
        "version": 1, "file": str(out), "kind": "nastran", "values": names, "units": {}, "frequencies": 0, "along": "",
        "directions": [], "remarks": remarks,
    }  # fmt: skip
    _tell(record, as_json=as_json)


def _tell(record: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        from multilayer.json_text import json_text

        typer.echo(json_text(record), nl=False)
        return
    count = len(record["directions"])
    where = f" at {record['frequencies']} frequencies" if record["frequencies"] else ""
    where += f", {count} {record['along'].replace('_', ' ')}s" if count > 1 else ""
    typer.echo(f"{', '.join(record['values'])}{where}")
    for text in record["remarks"]:
        typer.echo(text)
    typer.echo(f"written to {record['file']}")


def _wanted(kind: str, angle: str | None, trace_wavenumber: str | None, front: str, back: str) -> Wanted:
    from multilayer.errors import InputError
    from multilayer.exchange.quantities import Wanted

    if angle is not None and trace_wavenumber is not None:
        raise InputError("--angle and --trace-wavenumber say the same; give one of them")
    sides: Any = {"front": front, "back": back}
    if angle is not None:
        return Wanted(kind, "angle", _numbers("--angle", angle, "degree"), **sides)
    if trace_wavenumber is not None:
        return Wanted(kind, "trace_wavenumber", _numbers("--trace-wavenumber", trace_wavenumber, "rad/m"), **sides)
    return Wanted(kind, **sides)


def _numbers(option: str, text: str, unit: str) -> tuple[float, ...]:
    from multilayer.errors import InputError
    from multilayer.units import parse_quantity

    try:
        return tuple(parse_quantity(part, unit) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None

"""``multilayer export``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from multilayer.cli import completion

if TYPE_CHECKING:
    from multilayer.exchange.quantities import Wanted

_LONGEST_LIST = 1000


def export(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A stack file, or a simulation file without a sweep.")],
    kind: Annotated[
        str,
        typer.Option(
            "--as",
            metavar="KIND",
            help="surface_impedance, surface_admittance, admittance_matrix, impedance_matrix, transfer_matrix, "
            "absorption, transmission_loss or sea_trim.",
            autocompletion=completion.exports,
        ),
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="TABLE", help="File to write; its suffix: .csv .mat .h5 .hdf5 .uff .unv.")
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
    as_json: Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")] = False,
) -> None:
    """Write what a stack does as a table for programs of FE, BEM, SEA and room acoustics.

    Frequencies, incidence and panel size are those of FILE. Signs and units stand in the table. Exit status: 0 done, 2
    the input cannot be used (nothing is written).

    Example: multilayer export examples/three_layers.yaml --as admittance_matrix --angle 0,30,60 --out trim.csv
    """
    from multilayer.config.validate import placed_in
    from multilayer.exchange.formats import refuse_unknown_suffix
    from multilayer.exchange.quantities import export as exported
    from multilayer.simulation.file import load_simulation
    from multilayer.writing.folders import write_file

    refuse_unknown_suffix(out)
    wanted = _wanted(kind, angle, trace_wavenumber, front, back)
    with placed_in(file):
        table = exported(load_simulation(file), wanted, file.stem)
    write_file(out, table.content(out))
    said = {
        "version": 1, "file": str(out), "kind": table.kind, "values": [*table.values], "units": dict(table.units),
        "frequencies": table.frequency.size, "along": table.along,
        "directions": table.directions.tolist() if table.along else [], "remarks": list(table.remarks),
    }  # fmt: skip
    _tell(said, as_json=as_json)


def _tell(said: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        from multilayer.json_text import json_text

        typer.echo(json_text(said), nl=False)
        return
    count = len(said["directions"])
    where = f", {count} {said['along'].replace('_', ' ')}s" if count > 1 else ""
    typer.echo(f"{', '.join(said['values'])} at {said['frequencies']} frequencies{where}")
    for text in said["remarks"]:
        typer.echo(text)
    typer.echo(f"written to {said['file']}")


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

    parts = text.split(",")
    if len(parts) > _LONGEST_LIST:
        raise InputError(f"{option}: {len(parts)} values are too many: at most {_LONGEST_LIST} are taken")
    try:
        return tuple(parse_quantity(part, unit) for part in parts)
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None

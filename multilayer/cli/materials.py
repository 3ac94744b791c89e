"""``multilayer materials``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import ListAsJson, finish
from multilayer.doors import for_terminal


def materials(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Names, or parts of names; all when left out.",
            autocompletion=completion.materials,
        ),
    ] = None,
    library: Annotated[
        Path | None,
        typer.Option("--library", metavar="FILE", help="A library of your own, in place of the built-in one."),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="TABLE", help="A table of another program, in place of a library: .csv or text."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.yaml", help="Write the materials of --from as a library.")
    ] = None,
    as_json: ListAsJson = False,
) -> None:
    """List the materials that stack files may name, with the layer type and the source of their values.

    Of those named all values are shown, as they stand in the library.

    --from reads a table with a row for each material, whose columns have common names or symbols (sigma, phi,
    alpha_inf, Lambda, Lambda', rho, E, nu, eta) and units; --out makes a library of it.

    Example: multilayer materials glass_wool

    Example: multilayer materials --from foams.csv --out our_foams.yaml
    """
    from multilayer.errors import InputError
    from multilayer.report.materials import materials_report

    if table is None:
        if out is not None:
            raise InputError("--out belongs to --from; name the table to be read there")
        finish(materials_report(names, library), as_json=as_json)
        return
    if library is not None:
        raise InputError("--library and --from are two sources of materials; give one of them")
    if names and out is not None:
        raise InputError("--out writes all materials of the table; leave out the names")
    _from_table(table, names, out, as_json=as_json)


def _from_table(table: Path, names: list[str] | None, out: Path | None, *, as_json: bool) -> None:
    from multilayer.errors import InputError
    from multilayer.exchange.materials import read_materials, refuse_library_of_others
    from multilayer.report.materials import materials_report
    from multilayer.writing.folders import write_file

    if out is not None and out.suffix.lower() not in (".yaml", ".yml"):
        raise InputError(f"{out}: a library is a YAML file; call it {out.with_suffix('.yaml').name}")
    if out is not None:
        refuse_library_of_others(out)
    imported = read_materials(table)
    if out is not None:
        write_file(out, imported.library)
    finish(materials_report(names, known=imported.materials), as_json=as_json)
    for column in imported.left_out:
        typer.echo(
            for_terminal(f"remark: column '{column}' is no field of a material here, and was left out"), err=True
        )
    if out is not None and not as_json:
        count = len(imported.materials)
        typer.echo(f"written to {out}: {count} material{'s' if count != 1 else ''}")

"""``multilayer import``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from multilayer.cli.options import quantities, quantity

if TYPE_CHECKING:
    from multilayer.measurements.cutting import Window
    from multilayer.measurements.importing import ImportedCampaign
    from multilayer.measurements.metadata import Metadata
    from multilayer.measurements.pairs import ChannelChoice, Pair

_MOST_TOLD = 10


def import_campaign(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILES...", help="Recordings: .tdms .uff .unv .wav .mat .h5 .hdf5 .csv .txt .npz, and of plugins"
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="CAMPAIGN", help="Folder of the campaign, not there yet.")],
    base: Annotated[
        str | None, typer.Option(metavar="NAME", help="Channel of the support plate; asked for on a terminal.")
    ] = None,
    top: Annotated[
        str | None, typer.Option(metavar="NAME", help="Channel of the top plate; asked for on a terminal.")
    ] = None,
    sensitivity: Annotated[
        list[str] | None, typer.Option(metavar="ROLE=VALUE", help="Of what is in volts, as base=10.2mV/g; repeatable.")
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(metavar="ROLE=UNIT", help="What 1 is where a file does not say, as 'base=10 V'; repeatable."),
    ] = None,
    rate: Annotated[str | None, typer.Option(help="Sampling rate, Hz, where a file does not say.")] = None,
    like: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What you know of specimen and plates: a campaign, or its fields in YAML."),
    ] = None,
    configuration: Annotated[
        str | None, typer.Option(metavar="NAME", help="Which mounting of --like was recorded.")
    ] = None,
    calibration: Annotated[
        bool, typer.Option("--calibration", help="Both accelerometers were at one spot: make a calibration.")
    ] = False,
    frequencies: Annotated[
        str | None, typer.Option(metavar="HZ,HZ,...", help="Bursts to take; by default those of --like, or all.")
    ] = None,
    cycles: Annotated[float | None, typer.Option(help="Periods of a burst; by default those of --like, or 10.")] = None,
    before: Annotated[str | None, typer.Option(metavar="TIME", help="Ahead of a burst, 5 ms by default.")] = None,
    after: Annotated[
        str | None, typer.Option(metavar="TIME", help="Behind a burst; until the top is at rest by default.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print what was found as JSON in place of the table.")
    ] = False,
) -> None:
    """Make a campaign of long recordings: find the tone bursts, group repeats, cut them out aligned.

    Without --like a template is written, whose fields marked FILL_IN are to be filled before a fit. Exit status: 0
    done, 2 the input cannot be used (nothing is written).

    Example: multilayer import run.tdms --out campaigns/foam --base ai0 --top ai1 --sensitivity base=10.2mV/g
    --sensitivity top=9.9mV/g --like campaigns/other/campaign.yaml
    """
    from multilayer.measurements.cutting import Window
    from multilayer.measurements.importing import read_pairs, remarks, write_imported
    from multilayer.writing.folders import claim_folder, refuse_occupied

    claim_folder(out)
    refuse_occupied(out)
    choice = _choice(sensitivity or [], unit or [], rate)
    known = _metadata(like, configuration, calibration)
    window = Window(_cycles(cycles, known), _time(before, "before"), _time(after, "after"))
    wanted = _frequencies(frequencies)
    pairs = read_pairs(files, _with_names(choice, files, base, top))
    made = _make(pairs, known, window, wanted)
    write_imported(made, out)
    _tell(made, out, as_json)
    for text in remarks(made, window.cycles):
        typer.echo(f"remark: {text}", err=True)


def _choice(sensitivity: list[str], unit: list[str], rate: str | None) -> ChannelChoice:
    from multilayer.measurements.pairs import ChannelChoice, parse_sensitivities, parse_units

    sampling_rate = None if rate is None else quantity("--rate", rate, "Hz")
    return ChannelChoice({}, parse_sensitivities(sensitivity), parse_units(unit), sampling_rate)


def _metadata(like: Path | None, configuration: str | None, calibration: bool) -> Metadata:
    from multilayer.errors import InputError
    from multilayer.measurements.metadata import Metadata, read_metadata

    if like is None and configuration is not None:
        raise InputError("--configuration names a mounting of the file given with --like; give that, too")
    known = Metadata() if like is None else read_metadata(like, configuration)
    return known.as_calibration() if calibration else known


def _cycles(given: float | None, known: Metadata) -> float:
    from multilayer.errors import InputError
    from multilayer.measurements.importing import CYCLES

    if given is not None and not given > 0:
        raise InputError(f"--cycles: {given:g} is not allowed; it must be above 0")
    if given is not None and known.cycles not in (None, given):
        raise InputError(f"--cycles says {given:g}, but {known.file} says {known.cycles:g}; leave --cycles out")
    return given or known.cycles or CYCLES


def _frequencies(text: str | None) -> tuple[float, ...]:
    return quantities("--frequencies", text, "Hz") if text else ()


def _time(text: str | None, option: str) -> float | None:
    return None if text is None else quantity(f"--{option}", text, "s")


def _with_names(choice: ChannelChoice, files: list[Path], base: str | None, top: str | None) -> ChannelChoice:
    """Return the choice with the channels' names: as given, called base and top, or as the user answers."""
    import sys
    from dataclasses import replace

    from multilayer.measurements.readers import read_channels

    if base is not None and top is not None:
        return replace(choice, names={"base": base, "top": top})
    channels = read_channels(files[0])
    there = {name.casefold(): name for name in channels.names}
    chosen = {role: name or there.get(role) for role, name in (("base", base), ("top", top))}
    found = {role: name for role, name in chosen.items() if name is not None}
    missing = [role for role in chosen if role not in found]
    if missing and sys.stdin.isatty():
        typer.echo(f"{channels.file} holds: {channels}", err=True)
        found |= {role: typer.prompt(f"Channel of the {role} plate", err=True) for role in missing}
    elif missing:
        options = " and ".join(f"--{role}" for role in missing)
        raise channels.error(f"name the channels of base and top plate with {options}; it holds: {channels}")
    return replace(choice, names=found)


def _make(pairs: list[Pair], known: Metadata, window: Window, wanted: tuple[float, ...]) -> ImportedCampaign:
    from multilayer.cli.progress import progress_bar
    from multilayer.measurements.importing import make_campaign
    from multilayer.signals.find_bursts import number_of_blocks

    with progress_bar("import", sum(number_of_blocks(pair.base.size) for pair in pairs)) as advance:
        return make_campaign(pairs, known, window, wanted, advance)


def _tell(made: ImportedCampaign, out: Path, as_json: bool) -> None:
    if as_json:
        from multilayer.json_text import json_text

        typer.echo(json_text(_said(made, out)), nl=False)
        return
    left_out = made.result.left_out
    for text in left_out[:_MOST_TOLD]:
        typer.echo(f"left out: {text}", err=True)
    if len(left_out) > _MOST_TOLD:
        typer.echo(f"left out: {len(left_out) - _MOST_TOLD} more", err=True)
    typer.echo("    f / Hz  found / Hz  repeats  samples")
    for burst in made.result.bursts:
        frequencies = f"{burst.frequency:10g}  {burst.measured_frequency:10.2f}"
        typer.echo(f"{frequencies}  {burst.recording.n_repeats:7d}  {burst.recording.n_samples:7d}")
    typer.echo(f"written to {out}: {len(made.result.bursts)} bursts")
    if not made.complete:
        typer.echo(f"fill in what {out / 'campaign.yaml'} marks as FILL_IN, then: multilayer fit {out}")


def _said(made: ImportedCampaign, out: Path) -> dict[str, Any]:
    """Return what was found as plain data."""
    bursts = [
        {
            "frequency_hz": burst.frequency,
            "found_hz": burst.measured_frequency,
            "repeats": burst.recording.n_repeats,
            "samples": burst.recording.n_samples,
        }
        for burst in made.result.bursts
    ]
    said = {"left_out": list(made.result.left_out), "to_fill_in": not made.complete}
    return {"version": 1, "campaign": str(out), "bursts": bursts, **said}

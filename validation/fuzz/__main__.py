"""Input that nobody means, by the thousand: what it must end in is a message with its place, or a sound result.

``python -m validation.fuzz [TARGET ...] [--seed N] [--count N] [--minutes M] [--jobs N]`` prints a
table in Markdown and what failed; the same seed gives the same tries, in however many processes. ``--only N`` shows one
try of one target again.

A failure is any exception but those with a message for the user, a message without a file (or without a line, of a
field in a YAML file), a warning of Python or NumPy, more than 20 s of a processor or 1 GB, a result that is no number,
or more energy than came in.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from pathlib import Path
from time import monotonic

from multilayer.kinds import kind_of
from validation.fuzz.commands import command_target
from validation.fuzz.corpus import write_corpus, write_tables
from validation.fuzz.extremes import ExtremeTarget
from validation.fuzz.flips import FORMATS, FlipTarget
from validation.fuzz.records import RecordTarget
from validation.fuzz.requests import EXAMPLES, MEASURED, ModelRequestTarget, RequestTarget
from validation.fuzz.sizes import NAMES, SizeTarget
from validation.fuzz.tables import TableTarget
from validation.fuzz.watch import HEAD, Outcome, Tally, watched
from validation.fuzz.yaml_mutants import YamlTarget

COUNTS = {
    "yaml": 2000,
    "commands": 300,
    "tables": 500,
    "requests": 500,
    "records": 500,
    "files": 200,
    "numbers": 500,
    "sizes": len(NAMES),
}  # of each target, unless --count says more
_MOST_LISTED = 100  # tries of one failure
MEMORY = Path("/dev/shm")  # a file on a disk takes as long to write as to be read and checked


def targets(
    kinds: list[str], seed: int, folder: Path, pattern: str = "*"
) -> Iterator[tuple[str, str, Callable[[int], Outcome]]]:
    """Give kind, title and target of what is asked for; of files those whose path, or whose format, fits a pattern."""
    only = "" if pattern == "*" else f"`{pattern}`: "
    if "yaml" in kinds:
        files = _fitting(write_corpus(folder / "yaml"), folder / "yaml", pattern)
        title = f"{only}YAML files through check, and what passes through its command"
        yield "yaml", title, YamlTarget(files, seed, 1.0 if only else 0.3)
    if "commands" in kinds:
        files = _fitting(write_corpus(folder / "commands"), folder / "commands", pattern)
        title = f"{only}YAML files through check, what passes through rig, diagnose, optimise or export"
        yield "commands", title, command_target(files, seed)
    if "tables" in kinds:
        yield "tables", "tables through materials --from", TableTarget(write_tables(folder / "tables"), seed)
    if "requests" in kinds:
        files = [file for file in write_corpus(folder / "requests") if kind_of(file).name in ("stack", "simulation")]
        yield "requests", "questions to the page of a stack", RequestTarget(files, seed)
        for name in MEASURED:
            yield "requests", f"questions to the page of `{name}`", ModelRequestTarget(EXAMPLES / name, seed)
    if "records" in kinds:
        yield "records", "results that were written, read again", RecordTarget(folder / "records", seed)
    if "files" in kinds:
        for number, name in enumerate(FORMATS):
            if not fnmatch(name, pattern):
                continue
            place = folder / f"flips{number}"
            place.mkdir()
            yield "files", f"{name}: bits flipped, cut short", FlipTarget(name, place, seed)
    if "numbers" in kinds:
        yield "numbers", "stacks of extreme numbers through simulate", ExtremeTarget(folder, seed)
    if "sizes" in kinds:
        yield "sizes", "sizes of texts, lists, files, claims", SizeTarget(folder)


def _fitting(files: list[Path], folder: Path, pattern: str) -> list[Path]:
    return [file for file in files if fnmatch(file.relative_to(folder).as_posix(), pattern)]


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m validation.fuzz", description=__doc__.splitlines()[0])
    parser.add_argument(
        "kinds",
        nargs="*",
        metavar="KIND",
        help=f"of {', '.join(COUNTS)}; all of them when left out",
    )
    parser.add_argument(
        "--files", default="*", metavar="PATTERN", help="YAML files to be spoiled, as 'walls/*', or formats, as 'TDMS'"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, help="tries of each target")
    parser.add_argument("--minutes", type=float, help="longest time for each target")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes; the tries are the same")
    parser.add_argument("--only", type=int, metavar="N", help="one try, with what it said")
    asked = parser.parse_args()
    if unknown := set(asked.kinds) - set(COUNTS):
        parser.error(f"there is no {', '.join(sorted(unknown))}; there are: {', '.join(COUNTS)}")
    with tempfile.TemporaryDirectory(prefix="fuzz", dir=MEMORY if MEMORY.is_dir() else None) as name:
        _run(asked, Path(name))


def _run(asked: argparse.Namespace, folder: Path) -> None:
    tallies = []
    for kind, title, target in targets(asked.kinds or [*COUNTS], asked.seed, folder, asked.files):
        if asked.only is not None:
            _show(title, target, asked.only)
            continue
        count = COUNTS[kind] if kind == "sizes" else asked.count or COUNTS[kind]
        until = monotonic() + 60 * asked.minutes if asked.minutes else float("inf")
        began, used = monotonic(), _processor_time()
        tallies.append(watched(target, range(count), Tally(title, asked.seed), until, asked.jobs))
        n, seconds, used = tallies[-1].counts["tried"], monotonic() - began, _processor_time() - used
        rate = f"{n / seconds:.0f} per second, {n / used:.0f} per second of a processor"
        print(f"{title}: {n} in {seconds:.0f} s, {rate}", file=sys.stderr, flush=True)
        head = [HEAD] if len(tallies) == 1 else []
        print("\n".join([*head, tallies[-1].row]), flush=True)  # a long run may not come to its end
    for tally in tallies:
        for kind, cases in sorted(tally.failures.items(), key=lambda item: -len(item[1])):
            _, text = min(cases)
            which = ", ".join(str(index) for index, _ in sorted(cases)[:_MOST_LISTED])
            print(f"\n- {tally.target}: **{kind}**, {len(cases)} times; `--seed {tally.seed} --only` {which}:")
            print(f"  `{text[:300]}`")


def _processor_time() -> float:
    """Return seconds that processes which have ended took."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _show(title: str, target: Callable[[int], Outcome], index: int) -> None:
    """Print what is tried, where it can be printed, and what came of it."""
    print(f"## {title}")
    if isinstance(target, YamlTarget | TableTarget):
        file, text = target.text(index)
        print(f"{file.name}:\n{text}")
    if isinstance(target, RequestTarget):
        explorer, name, text = target.text(index)
        print(f"{explorer.file.name}, {name}:\n{text}")
    if isinstance(target, ExtremeTarget):
        print(target.data(index))
    outcome = target(index)
    print(f"{outcome.kind}: {outcome.text}")


if __name__ == "__main__":
    main()

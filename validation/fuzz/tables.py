"""Tables of materials, spoiled, through `materials --from`: what is written as a library must be read as the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from multilayer.exchange.materials import read_materials
from multilayer.materials import load_library
from validation.fuzz.watch import PASSED, Outcome, UnsoundError, own, tried
from validation.fuzz.yaml_mutants import JUNK, spoilt_text


class TableTarget:
    """Mutants of tables, by their number."""

    def __init__(self, files: list[Path], seed: int) -> None:
        self.files, self.seed = files, seed
        self.texts = [file.read_text(encoding="utf-8") for file in files]

    def text(self, index: int) -> tuple[Path, str]:
        """Return the place and the text of a mutant."""
        rng = np.random.default_rng([self.seed, index])
        which = int(rng.integers(len(self.files)))
        file, text = self.files[which], self.texts[which]
        separator = {"comma": ",", "semicolon": ";", "tab": "\t"}[file.stem]
        for _ in range(int(rng.integers(1, 4))):
            text = _spoilt_cell(text, separator, rng) if rng.random() < 0.6 else spoilt_text(text, rng)
        return file.with_name(own(file.name)), text

    def __call__(self, index: int) -> Outcome:
        file, text = self.text(index)
        file.write_text(text, encoding="utf-8", errors="replace")
        outcome = self.tried(file)
        return Outcome(outcome.kind, f"{file.name}: {outcome.text}") if outcome.failed else outcome

    @staticmethod
    def tried(file: Path) -> Outcome:
        """Return how reading a table ended."""
        return tried(lambda: _read(file))


def _spoilt_cell(text: str, separator: str, rng: np.random.Generator) -> str:
    """Put something else into a cell, or another cell."""
    rows = [line.split(separator) for line in text.splitlines() or [""]]
    places = [(i, j) for i, row in enumerate(rows) for j in range(len(row))]
    (i, j), (k, m) = (places[int(rng.integers(len(places)))] for _ in range(2))
    junk = str(JUNK[int(rng.integers(len(JUNK)))])
    cell = rows[i][j]
    rows[i][j] = str(
        rng.choice([junk, rows[k][m], "", f"{cell}e{int(rng.integers(-40, 40))}", f"-{cell}", f"{cell} Pa"])
    )
    return "".join(f"{separator.join(row)}\n" for row in rows)


def _read(file: Path) -> str:
    imported = read_materials(file)
    library = file.with_suffix(".yaml")
    library.write_text(imported.library, encoding="utf-8")
    again = load_library(library)
    if {name: dict(fields) for name, fields in again.items()} != {n: dict(f) for n, f in imported.materials.items()}:
        raise UnsoundError("the library is read as something else")
    return PASSED

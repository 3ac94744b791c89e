"""Results that were written, spoiled in what their JSON holds, through what reads them again: manifests and records."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.cli.check import _checked
from multilayer.diagnosis.saved_law import RECORD, known_effects
from multilayer.errors import InputError
from multilayer.explore.diagnosed import is_diagnosis, open_diagnosis
from multilayer.fits.run import FitTask
from multilayer.writing.manifest import MANIFEST, digest_of
from validation.fuzz.watch import PASSED, Outcome, own, tried
from validation.fuzz.yaml_mutants import spoilt_data, spoilt_text

_CAMPAIGN = Path(__file__).parents[2] / "examples" / "foam_b"
_NAMES = ["..", "../../x", "/dev/zero", "/etc/passwd", "results", "files", "inputs", "effects", "law", "form", "value"]


class RecordTarget:
    """Spoiled JSON files of two folders of results, of a diagnosis and of a fit, by their number."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.seed, self.fit = seed, FitTask(_CAMPAIGN).read()
        self.folders = {command: _made(command, folder / command) for command in ("diagnose", "fit")}
        self.places: list[tuple[str, str, Callable[[Path], object]]] = [
            ("diagnose", RECORD, lambda made: known_effects(str(made / RECORD))),
            ("diagnose", RECORD, _opened),
            ("diagnose", MANIFEST, _opened),
            ("diagnose", MANIFEST, _verified),
            ("fit", MANIFEST, self._resumed),
            ("fit", self.fit.record_name, self._resumed_by_manifest),
        ]
        self.texts = [(self.folders[kind] / name).read_text(encoding="utf-8") for kind, name, _ in self.places]

    def text(self, index: int) -> tuple[int, str]:
        """Return which file is spoiled, and its text."""
        rng = np.random.default_rng([self.seed, index])
        which = index % len(self.places)
        text = self.texts[which]
        if rng.random() < 0.3:
            return which, spoilt_text(text, rng)
        data = json.loads(text)
        for _ in range(int(rng.choice([1, 1, 2, 3]))):
            data = spoilt_data(data, rng, _NAMES)
        return which, json.dumps(data)

    def __call__(self, index: int) -> Outcome:
        which, text = self.text(index)
        kind, name, read = self.places[which]
        folder = self.folders[kind].with_name(own(kind))
        if not folder.exists():
            shutil.copytree(self.folders[kind], folder)
        (folder / name).write_text(text, encoding="utf-8", errors="replace")
        outcome = tried(lambda: _passed(read, folder))
        for written in (name, MANIFEST):
            shutil.copy(self.folders[kind] / written, folder / written)
        return Outcome(outcome.kind, f"{name}: {outcome.text}") if outcome.failed else outcome

    def _resumed(self, made: Path) -> None:
        if self.fit.done_in(made):
            self.fit.summary_in(made)

    def _resumed_by_manifest(self, made: Path) -> None:
        """Do so with a manifest that says the record is as it was written."""
        manifest = json.loads((self.folders["fit"] / MANIFEST).read_text(encoding="utf-8"))
        manifest["results"]["fit"]["files"][self.fit.record_name] = digest_of(made / self.fit.record_name)
        (made / MANIFEST).write_text(json.dumps(manifest), encoding="utf-8")
        self._resumed(made)


def _made(command: str, folder: Path) -> Path:
    """Return a folder of results of our example campaign."""
    call = [sys.executable, "-m", "multilayer", command, str(_CAMPAIGN), "--out", str(folder), "--no-figures"]
    subprocess.run(call, check=True, capture_output=True)
    return folder


def _passed(read: Callable[[Path], Any], folder: Path) -> str:
    read(folder)
    return PASSED


def _opened(folder: Path) -> None:
    if is_diagnosis(folder):
        open_diagnosis(folder)


def _verified(folder: Path) -> None:
    if problems := _checked(folder).problems:
        raise InputError(problems)

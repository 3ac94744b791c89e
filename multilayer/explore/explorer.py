"""Answers to the page of a stack: plain data in, plain data out; nothing is remembered but which file was opened.

The design, its history and its frozen curves are the page's: every window has its own, and two of them show two designs
side by side. What they share is the file on the disk; who saves over it has to know it as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from multilayer.doors import for_log
from multilayer.errors import InputError, MultilayerError, show
from multilayer.explore.curves import computed, curves
from multilayer.explore.edits import edited
from multilayer.explore.fields import described_ambient, described_layers, described_termination
from multilayer.explore.file import ASIDE, Save, is_same, open_file, save
from multilayer.explore.questions import Answer, Questions, problems_of
from multilayer.layers.base import LAYERS
from multilayer.materials import load_library
from multilayer.simulation.measured import Measured
from multilayer.writing.manifest import digest_of


class Explorer(Questions):
    """What answers the page of one stack.

    Parameters
    ----------
    file : Path
        A stack or simulation file.
    measured : sequence of Measured
        Spectra to be shown beside the computed ones.

    Raises
    ------
    InputError
        When the file cannot be used.
    """

    page = "explore"

    def __init__(self, file: Path, measured: Sequence[Measured] = ()) -> None:
        super().__init__(file)
        self.measured = tuple(measured)
        open_file(file)
        self.answers = {
            "start": self.start,
            "evaluate": self.evaluate,
            "edit": self.edit,
            "save": self.save,
            "watch": self.watch,
        }

    def start(self, request: Mapping[str, Any]) -> Answer:
        """Return the file as it is on the disk, and what may be added to it.

        Of a file that cannot be read its ``problems`` stand in place of ``data`` and ``digest``: a window that is
        loaded again has a design of its own to go on with.
        """
        del request
        own: dict[str, Any] = {}
        on_disk: Answer
        try:
            opened = open_file(self.file)
            if library := opened.data.get("library"):
                own = load_library(self.file.parent / str(library))
            on_disk = {"data": opened.data, "digest": opened.digest}
        except InputError as error:
            on_disk = {"problems": problems_of(error, placed=True)}
        known = {**own, **{name: fields for name, fields in load_library().items() if name not in own}}
        return {
            **on_disk,
            "file": for_log(self.file.name),
            "version": version("multilayer"),
            "types": [{"name": name, "summary": kind.summary} for name, kind in LAYERS.working()],
            "materials": [
                {"name": name, "type": str(fields.get("type", "")), "source": for_log(fields.get("source", ""))}
                for name, fields in known.items()
            ],
            "measured": [_measured(spectra) for spectra in self.measured],
        }

    def evaluate(self, request: Mapping[str, Any]) -> Answer:
        """Return curves and ratings of ``data``; with ``describe`` also what there is to be changed.

        While a slider is ``moving``, they may be of fewer ``points`` and digits.
        """
        data = _data(request)
        described = self._described(data) if request.get("describe") else {}
        points = request.get("points")
        try:
            moving = request.get("moving") is True
            result = computed(data, self.file, points if isinstance(points, int) else None, moving=moving)
        except MultilayerError as error:
            return {**described, "problems": problems_of(error)}
        return {**described, **result, "problems": []}

    def edit(self, request: Mapping[str, Any]) -> Answer:
        """Return ``data`` after an ``edit``."""
        edit = request.get("edit")
        if not isinstance(edit, dict):
            raise InputError("no edit was asked for")
        done = edited(_data(request), edit, self.file.parent)
        return {"data": done.data, "layer": done.layer, "notices": done.notices, "problems": []}

    def save(self, request: Mapping[str, Any]) -> Answer:
        """Write ``data`` into a file of the folder; see `multilayer.explore.file.save`."""
        data = _data(request)
        if not request.get("aside", True):
            data = {key: value for key, value in data.items() if key not in ASIDE}
        words = {key: str(request.get(key, "")) for key in ("name", "kind", "known")}
        saved = save(data, self.file, Save(**words, replace=request.get("replace") is True))
        is_opened = is_same(self.file.parent / words["name"], self.file)
        return {"name": words["name"], "digest": saved.digest if is_opened else words["known"], "problems": []}

    def watch(self, request: Mapping[str, Any]) -> Answer:
        """Return the digest of the file as it is on the disk now; empty when it is gone."""
        del request
        return {"digest": digest_of(self.file) or "", "problems": []}

    def _described(self, data: Mapping[str, Any]) -> Answer:
        return {
            "layers": described_layers(data, self.file.parent),
            "ambient": described_ambient(data),
            "behind": described_termination(data),
            "aside": [key for key in ASIDE[:2] if data.get(key)],
        }


def _data(request: Mapping[str, Any]) -> dict[str, Any]:
    data = request.get("data")
    if not isinstance(data, dict):
        raise InputError(f"a stack must be a mapping of fields, not {show(data)}")
    layers = data.get("layers")
    if not isinstance(layers, list) or not layers or not all(isinstance(layer, dict) for layer in layers):
        raise InputError("a stack needs 'layers', a list of mappings")
    return data


def _measured(spectra: Measured) -> dict[str, Any]:
    return {
        "name": for_log(spectra.name),
        "frequency": spectra.frequency.tolist(),
        "curves": curves(spectra.quantities),
    }

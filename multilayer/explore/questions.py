"""Questions of a page and their answers: plain data in, plain data out, one at a time."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

from multilayer.errors import InputError, MultilayerError, MultilayerWarning, Problem
from multilayer.explore.file import NameTakenError

Answer = dict[str, Any]


class Questions:
    """What answers a page about one file; a subclass says which questions there are.

    Parameters
    ----------
    file : Path

    Attributes
    ----------
    page : str
        Name of the page's document and script.
    answers : dict
        By the name of the question, what answers it.
    """

    page: ClassVar[str]

    def __init__(self, file: Path) -> None:
        self.file = file
        self.answers: dict[str, Callable[[Mapping[str, Any]], Answer]] = {}
        self._one_at_a_time = threading.Lock()  # filters of warnings are shared by all threads, and so are two cores

    def answer(self, name: str, request: Mapping[str, Any]) -> Answer:
        """Return the answer to a request: with ``problems`` where something in it, or in the file, is wrong.

        Raises
        ------
        KeyError
            When there is no such question.
        """
        ask = self.answers[name]
        with self._one_at_a_time, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", MultilayerWarning)
            try:
                answer = ask(request)
            except NameTakenError as error:
                answer = {"problems": problems_of(error), "taken": True}
            except MultilayerError as error:
                answer = {"problems": problems_of(error, placed=name == "start")}
        texts = [str(one.message) for one in caught if issubclass(one.category, MultilayerWarning)]
        return {**answer, "warnings": [*dict.fromkeys(_without_file(text, self.file) for text in texts)]}


def problems_of(error: MultilayerError, *, placed: bool = False) -> list[dict[str, str]]:
    """Return mistakes as a page shows them; with file and line only where they stand in the file on the disk."""
    problems = error.problems if isinstance(error, InputError) else [Problem(str(error))]
    return [
        {"path": problem.path, "text": str(problem if placed else Problem(problem.message))} for problem in problems
    ]


def _without_file(text: str, file: Path) -> str:
    before, place, rest = text.partition(f"{file}:1:1: ")
    return rest if place and not before else text

"""What a command has to say, as plain data; from it come the terminal's text, CSV, JSON, HTML and figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from multilayer.executors import run_all
from multilayer.json_text import json_text
from multilayer.report.listing import Listing

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from matplotlib.figure import Figure

Draw: TypeAlias = Callable[..., "Figure"]  # without arguments
Pairs: TypeAlias = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Picture:
    """A figure on a page, drawn when the page is made.

    Attributes
    ----------
    draw : callable
    caption : str
        What it shows.
    label : str
        The same for those who have the page read aloud, where there is no caption.
    """

    draw: Draw
    caption: str
    label: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the evidence.

    A terminal shows its listings (in place of them those that are folded away), and its remarks.

    Attributes
    ----------
    title : str
    pictures : tuple of Picture
    listings : tuple of Listing
    items : tuple of (str, str)
        Names and texts, on a page.
    remarks : tuple of str
    beside : Section or None
        What a page has beside the pictures; a terminal shows its listings.
    folded : Section or None
        What can be opened on a screen, and is left out on paper.
    empty : str
        What a page says where there is nothing else.
    """

    title: str
    pictures: tuple[Picture, ...] = ()
    listings: tuple[Listing, ...] = ()
    items: Pairs = ()
    remarks: tuple[str, ...] = ()
    beside: Section | None = None
    folded: Section | None = None
    empty: str = ""

    def parts(self) -> Iterator[Section]:
        """Give the section and those in it."""
        yield self
        for part in (self.beside, self.folded):
            if part is not None:
                yield from part.parts()


@dataclass(frozen=True)
class Report:
    """What a command has to say.

    Attributes
    ----------
    name, kind : str
        Of what the report is, and of which command.
    label : str
        The verdict in a word or two.
    tone : {'good', 'mind', 'unknown', ''}
        Whether the reader can rely on it, or must mind something; empty where that is no question.
    sentence : str
    facts : tuple of (str, str)
        The numbers that matter most.
    note : str
        Below them.
    sections : tuple of Section
    inputs : mapping
        What the result was made from; a page adds versions.
    opening : tuple of str
        What a terminal shows first.
    tables : mapping
        CSV files by name.
    record : plain data
        All of it, for JSON.
    record_file : str
        Name of the JSON file; none is written if empty.
    texts : mapping
        Other files by name.
    page : str
        Name of the HTML file; none is written if empty.
    figures : mapping
        What draws PNG files, by name. What a picture of the page shows as well is drawn once, as the page has it.
    accepted : bool
        Whether the exit status is 0.
    warnings : tuple of str
        What to mind, on the page and in the record; a terminal has shown it before.
    """

    name: str = ""
    kind: str = ""
    label: str = ""
    tone: str = ""
    sentence: str = ""
    facts: Pairs = ()
    note: str = ""
    sections: tuple[Section, ...] = ()
    inputs: Mapping[str, Any] = field(default_factory=dict)
    opening: tuple[str, ...] = ()
    tables: Mapping[str, str] = field(default_factory=dict)
    record: Any = None
    record_file: str = ""
    texts: Mapping[str, str] = field(default_factory=dict)
    page: str = ""
    figures: Mapping[str, Draw] = field(default_factory=dict)
    accepted: bool = True
    warnings: tuple[str, ...] = ()

    @property
    def json(self) -> str:
        """The record as the text of a JSON file; what is written to one holds the warnings."""
        return json_text({**self.record, "warnings": list(self.warnings)} if self.record_file else self.record)

    @property
    def pictures(self) -> list[Picture]:
        """All pictures of the page."""
        return [picture for section in self.sections for part in section.parts() for picture in part.pictures]

    def files(self, *, figures: bool = True, executor: Executor | None = None) -> dict[str, bytes | str]:
        """Return the contents of all files by name.

        Parameters
        ----------
        figures : bool
            Whether to draw: figures, and the page that holds them.
        executor : Executor, optional
            Where they are drawn, by functions that can be pickled then; in this process when left out.
        """
        files: dict[str, bytes | str] = {**self.tables}
        if self.record_file:
            files[self.record_file] = self.json
        files |= self.texts
        if not figures:
            return files
        shown = {picture.draw: picture.caption or picture.label for picture in self.pictures} if self.page else {}
        keys = {draw: f"f{i}" for i, draw in enumerate(shown)}
        wanted = dict.fromkeys(self.figures.values())
        tasks = [(draw, keys.get(draw, ""), shown.get(draw, ""), draw in wanted) for draw in {**shown, **wanted}]
        drawings = map(_drawn, tasks) if executor is None else run_all(_drawn, tasks, executor)
        drawn = dict(zip((draw for draw, *_ in tasks), drawings, strict=True))
        if self.page:
            from multilayer.report.html import page_html

            files[self.page] = page_html(self, {draw: svg for draw, (_, svg) in drawn.items()})
        return files | {name: drawn[draw][0] for name, draw in self.figures.items()}


def _drawn(task: tuple[Draw, str, str, bool]) -> tuple[bytes, str]:
    """Return a figure as a PNG file where that is wanted, and as an SVG element where it has a key on the page."""
    from multilayer.report.style import figure_style, png
    from multilayer.report.svg import inline_svg

    draw, key, label, is_file = task
    with figure_style(compact=bool(key)):
        figure = draw()
        image = png(figure) if is_file else b""
        if is_file and key:
            figure.set_layout_engine("none")  # it is laid out, and that takes as long as to draw it
        return image, inline_svg(figure, key, label) if key else ""

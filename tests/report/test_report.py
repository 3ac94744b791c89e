"""One report gives the text of a terminal, files and a page."""

import json
from functools import partial

import pytest
from matplotlib.figure import Figure
from rich.console import Console

from multilayer.report.console import show
from multilayer.report.fits import fit_report
from multilayer.report.listing import Listing, Tinted, listing_of, yes_or_no
from multilayer.report.report import Picture, Report, Section
from tests.report.test_diagnosis_report import Page


def draw(calls, name):
    calls.append(name)
    figure = Figure(figsize=(2, 1))
    figure.subplots().plot([0, 1], [1, 0])
    return figure


def made(calls=None, **changes):
    calls = [] if calls is None else calls
    shared, alone = partial(draw, calls, "shared"), partial(draw, calls, "alone")
    rows = tuple((f"[red]{i}[/red]", f"{i}.5") for i in range(40))
    sections = (
        Section("Evidence", (Picture(shared, "Both."),), (
            Listing(("name", "size / m"), rows, (1,), notes=("a note",)),
        )),
        Section("On one of them", listings=(
            Listing(("seen",), (("in the terminal",),), only="console"),
            Listing(("seen", "nothing"), (("on the page", ""),), only="page"),
        ), remarks=("first", "second")),
        Section("Nothing", empty="There is nothing."),
    )  # fmt: skip
    given = {"name": "foam", "kind": "test", "sentence": "All is well.", "sections": sections, "page": "report.html"}
    files = {"tables": {"a.csv": "x\n1\n"}, "record": {"x": float("nan")}, "record_file": "a.json"}
    figures = {"shared.png": shared, "alone.png": alone}
    return Report(**{**given, **files, "texts": {"b.yaml": "x: 1\n"}, "figures": figures, **changes})


def test_files_in_their_order_and_figures_drawn_once():
    calls = []
    files = made(calls).files()
    assert list(files) == ["a.csv", "a.json", "b.yaml", "report.html", "shared.png", "alone.png"]
    assert sorted(calls) == ["alone", "shared"]
    assert json.loads(files["a.json"]) == {"x": None, "warnings": []}
    assert files["report.html"].count("<svg") == 1
    assert all(files[name].startswith(b"\x89PNG") for name in ("shared.png", "alone.png"))


def test_what_to_mind_stands_in_the_record_and_first_on_the_page():
    report = made(figures={}, warnings=("it is <odd>",))
    assert json.loads(report.json) == {"x": None, "warnings": ["it is <odd>"]}
    page = Page(str(report.files()["report.html"]))
    assert page.text.index("What to mind") < page.text.index("it is <odd>") < page.text.index("Evidence")


def test_nothing_is_drawn_where_no_figures_are_wanted():
    calls = []
    assert list(made(calls).files(figures=False)) == ["a.csv", "a.json", "b.yaml"]
    assert calls == []


def test_a_page_cuts_long_lists_and_says_what_it_lacks():
    page = Page(str(made(figures={}).files()["report.html"]))
    for expected in ("10 more, see a.csv and a.json.", "[red]29[/red]", "a note", "on the page", "There is nothing."):
        assert expected in page.text
    for absent in ("[red]30[/red]", "in the terminal", "nothing nothing"):
        assert absent not in page.text
    assert "thead" in page.tags


@pytest.mark.parametrize("width", [20, 40, 80, 200])
def test_no_number_of_a_table_is_cut_however_narrow_the_terminal(width, capsys, monkeypatch):
    monkeypatch.setattr("multilayer.report.console.console", lambda: Console(width=width))
    numbers = tuple(f"{1000 + i}.25 [{i}.125, {i}.875]" for i in range(8))
    rows = (("a case of several words", *numbers),)
    headings = ("case", *(f"{100 * 2**i} Hz" for i in range(8)))
    show(made(figures={}, sections=(Section("Table", listings=(Listing(headings, rows, tuple(range(1, 9))),)),)))
    printed = capsys.readouterr().out
    assert all(text in printed for text in (*numbers, *headings, "several"))


def test_a_terminal_shows_everything_under_headings(capsys):
    show(made(opening=("foam: fine",)))
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert lines[:4] == ["foam: fine", "", "Evidence", "name           size / m"]
    assert lines[43] == "[red]39[/red]      39.5"
    assert lines[44:] == ["a note", "", "On one of them", "seen", "in the terminal", "- first", "- second"]


def test_columns_say_what_is_flush_right():
    listing = Listing.of([1.0, 2.5], {"name": str, ">size": lambda x: f"{x:.2f}"}, caption="sizes")
    assert listing == Listing(("name", "size"), (("1.0", "1.00"), ("2.5", "2.50")), (1,), "sizes")


def test_what_is_wrong_is_red_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    show(Report(sections=(Section("", listings=(Listing.of([True, False], {"good": yes_or_no}),)),)))
    assert "\x1b[31mno " in capsys.readouterr().out
    assert (yes_or_no(False), Tinted("no", "red").colour) == ("no", "red")


class OtherFit:
    """A result of which only the least is known."""

    record_name = "other.json"
    name, method, settings, remarks = "foam", "guessing", {"seed": 1}, ["it was a guess"]
    tables = {"moduli.csv": "configuration,E1_pa\nh25mm,123456.789\n"}  # noqa: RUF012

    def __init__(self, *, accepted):
        self.all_accepted = accepted

    def to_dict(self):
        return {"version": 1, "name": self.name}


@pytest.mark.parametrize("accepted", [True, False])
def test_a_fit_of_another_kind_needs_no_report_of_its_own(accepted, capsys):
    report = fit_report(OtherFit(accepted=accepted), None, {"sha256": "0" * 64})
    assert report.accepted == accepted
    files = report.files()
    assert list(files) == ["moduli.csv", "other.json", "report.html"]
    assert json.loads(files["other.json"])["inputs"] == {"sha256": "0" * 64}
    show(report)
    texts = capsys.readouterr().out, Page(str(files["report.html"])).text
    assert all("123500" in text and "it was a guess" in text for text in texts)
    assert f"The fit of foam by guessing is {'' if accepted else 'not '}accepted." in texts[1]


def test_tables_are_rounded_where_there_are_numbers():
    table = 'name,E1_pa,note\nfoam-1,123456.789,\n2.5 mm,,"a, b"\n'
    listing = listing_of(table, "t.csv")
    assert listing.rows == (("foam-1", "123500", ""), ("2.5 mm", "", "a, b"))
    assert (listing.numeric, listing.caption) == ((1,), "t.csv")


def test_whole_numbers_and_frequencies_keep_their_digits_in_tables():
    listing = listing_of("campaign,frequency_hz,E1_pa\n20240115,1234.5,171.56789\n")
    assert listing.rows == (("20240115", "1234.5", "171.6"),)

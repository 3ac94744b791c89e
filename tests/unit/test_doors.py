"""Text of others at each door."""

import csv
import io
import logging
import re
import sys
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multilayer.csv_table import csv_table, rows_of
from multilayer.doors import (
    GuardedStream,
    cut,
    for_cell,
    for_log,
    for_page,
    for_terminal,
    from_cell,
    guarded_streams,
)
from multilayer.errors import InputError, Problem, suggest
from multilayer.log import logged
from tests.cli.hostile_names import FILE_NAMES, NAMES

CONTROLS = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u202a-\u202e\u2066-\u2069\u2028\u2029\ud800-\udfff]")
ALL = {**NAMES, **FILE_NAMES}.values()
any_text = st.text(st.characters(codec=None), max_size=30) | st.sampled_from(list(ALL))


@given(any_text)
def test_no_control_character_comes_through(text):
    assert not CONTROLS.search(for_log(text))
    assert not CONTROLS.search(for_terminal(text).replace("\n", ""))
    assert for_terminal(for_terminal(text)) == for_terminal(text)


def test_what_is_shown():
    assert for_terminal("a\x1b[31m\n\u202e\udc80\x07é🔊") == "a\\x1b[31m\n\\u202e\\udc80\\x07é🔊"
    assert for_log("a\nb") == "a\\nb"
    assert for_terminal("plain, רע, \u200d, [red]") == "plain, רע, \u200d, [red]"


@given(any_text)
def test_xml_holds_every_text(text):
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert (ElementTree.fromstring(for_page(f"<t>{escaped}</t>")).text or "") == for_page(text)


@given(any_text)
def test_cells_are_no_formulae_and_come_back(text):
    cell = for_cell(text)
    for part in (cell, *cell.split(";")):
        assert not re.match(r"\s*[=+\-@＝＋－＠]", part)
    assert from_cell(cell) == for_log(text)
    assert rows_of(csv_table([text], [[text, -1.5]])) == [[for_log(text)], [for_log(text), "-1.5"]]


def test_numbers_keep_their_sign():
    assert csv_table(["a"], [[-1, -2.5, None, True, "-1", "b"]]) == "a\n-1,-2.5,,true,'-1,b\n"
    assert list(csv.reader(io.StringIO(csv_table(["=x"], [])))) == [["'=x"]]


def test_other_peoples_apostrophes_stay():
    assert [from_cell(cell) for cell in ("'quoted'", "it's", "'", "", "5'")] == ["'quoted'", "it's", "'", "", "5'"]


def test_long_texts_lose_their_middle():
    assert cut("n" * 100, 100) == "n" * 100
    assert cut("a" * 10 + "b" * 500, 20) == "a" * 10 + "... (490 characters) ..." + "b" * 10


def test_messages_are_cut_and_harmless():
    name = "\x1b[31m" + "n" * 1_000_000
    error = InputError(Problem(f"'{name}' is not allowed; {suggest(name, [name, 'x'])}", f"layers.{name}"))
    assert len(str(error)) < 6000
    assert not CONTROLS.search(str(error))
    assert error.problems[0].path == f"layers.{name}"


def test_log_takes_a_line(caplog):
    with caplog.at_level(logging.INFO, "multilayer"):
        logged(None)("a\x1b[2J\nb")
    assert caplog.messages == ["a\\x1b[2J\\nb"]


class TestStreams:
    def test_whoever_writes(self, capsys):
        with guarded_streams():
            sys.stdout.write("a\x1b[31m\tb\r\n")
        assert capsys.readouterr().out == "a\\x1b[31m\\tb\\r\n"
        sys.stdout.write("after\x07")
        assert capsys.readouterr().out == "after\x07"

    def test_rich_has_its_colours_and_nothing_else(self):
        from rich.console import Console
        from rich.text import Text

        text = io.StringIO()
        Console(file=GuardedStream(text), force_terminal=True).print(Text("a\x1b]0;x\x07", style="red"))
        assert text.getvalue() == "\x1b[31ma\\x1b]0;x\x1b[0m\n"

    def test_progress_of_rich_moves(self):
        from rich.console import Console
        from rich.progress import Progress

        text = io.StringIO()
        with Progress(console=Console(file=GuardedStream(text), force_terminal=True), transient=True) as bar:
            bar.add_task("a", total=1)
            bar.refresh()
        assert "\x1b[2K" in text.getvalue()
        assert "\\x1b" not in text.getvalue()

    def test_bytes_have_no_way(self):
        assert not hasattr(GuardedStream(io.TextIOWrapper(io.BytesIO())), "buffer")
        with pytest.raises(TypeError):
            GuardedStream(io.StringIO()).write(b"a")

"""The report, the figures and the tables of a diagnosis."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.result import Similarity
from multilayer.number_text import percent, significant, with_interval, with_unit
from multilayer.report.console import show
from multilayer.report.diagnosis import diagnosis_report
from multilayer.report.style import blank, octave_ticks
from tests.report.diagnoses import EFFECTS, diagnosis

VOID = {"meta", "br", "hr", "img", "input", "link", "col", "source"}
HOSTILE = ['<script>alert("1")</script>', "a & b <b>", "$E_1$", "_100 %", 'x" onload="y', "H" * 60]


class Page(HTMLParser):
    """Tags, ids and texts of a page that closes everything it opens."""

    def __init__(self, html):
        super().__init__()
        self.open, self.tags, self.attributes, self.texts = [], [], [], []
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.texts))

    @property
    def figures(self):
        return [value for name, value in self.attributes if name == "aria-label"]


def files_of(made, **options):
    return diagnosis_report(made).files(**options)


def show_diagnosis(made):
    show(diagnosis_report(made))


def bare(**changes):
    """Return a diagnosis without anything that could be drawn."""
    empty = Similarity((), np.zeros((0, 0)), np.zeros(0))
    made = diagnosis("no_gap", 1)
    return replace(made, curves=(), similarity=empty, moduli={}, record={**made.record, "unknowns": {}, **changes})


CASES = {
    "one": lambda: diagnosis(n=1, effects=EFFECTS[:6]),
    "many": lambda: diagnosis(n=12),
    "unknown": lambda: diagnosis("unknown", 3),
    "no gap": lambda: diagnosis("no_gap", 2),
    "nothing": bare,
}


@pytest.fixture(scope="module")
def pages():
    return {name: str(files_of(made())["report.html"]) for name, made in CASES.items()}


@pytest.mark.parametrize("several", [False, True])
def test_sizes_in_configurations_are_told_with_their_names(several):
    made = diagnosis(n=1, effects=EFFECTS[:6])
    size = {"value": 0.1, "low": 0.05, "high": 0.15, "unit": ""}
    effects = ["open_rims", "skin"] if several else ["open_rims"]
    cause = {**made.record["causes"][0], "effects": effects, "parameters": {"open_rims.of_rim[h12.5mm_t1]": size}}
    text = Page(files_of(replace(made, record={**made.record, "causes": [cause]}))["report.html"]).text
    assert f"{'open rims ' if several else ''}of rim[h12.5mm_t1] 0.100 (0.050 to 0.150)" in text


@pytest.mark.parametrize("name", CASES)
def test_page_is_whole_and_needs_nothing_else(name, pages):
    html = pages[name]
    page = Page(html)
    assert html.startswith("<!DOCTYPE html>")
    assert not re.search(r"https?://|@import|data:", html)
    assert not {"script", "link", "iframe", "img", "image", "object", "foreignobject"} & set(page.tags)
    ids = [value for key, value in page.attributes if key == "id"]
    assert len(ids) == len(set(ids))
    links = [value for key, value in page.attributes if key in ("href", "xlink:href")]
    links += [f"#{found}" for found in re.findall(r"url\(#([^)]+)\)", html)]
    assert {link.removeprefix("#") for link in links} <= set(ids)


@pytest.mark.parametrize("name", CASES)
def test_page_is_made_for_paper_and_both_colour_schemes(name, pages):
    assert "size: A4" in pages[name]
    assert "@media print" in pages[name]
    assert "prefers-color-scheme: dark" in pages[name]
    # the text of figures takes the page's colour
    assert not re.search(r"(fill|stroke): ?#000", pages[name])


def test_verdict_comes_first(pages):
    before, sentence, _ = pages["one"].partition("The gap is caused by sensor mass (probability 61 %)")
    assert sentence
    assert before.rstrip().endswith("<h1>")
    assert "<h2>" not in before


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("one", ["The most signi", "Ranked causes", "Measured minus", "The modulus", "How alike", "What each change"]),
        ("unknown", ["The most signi", "Ranked causes", "The modulus", "How alike", "What each change"]),
        ("no gap", ["Measured minus", "The modulus", "How alike"]),
        ("nothing", []),
    ],
)
def test_figures_are_there_unless_they_would_be_empty(name, expected, pages):
    page = Page(pages[name])
    assert [start for start in expected if not any(label.startswith(start) for label in page.figures)] == []
    assert len(page.figures) == page.tags.count("svg") == page.tags.count("figure")
    drawn = re.findall(r"<svg.*?</svg>", pages[name], re.DOTALL)
    assert all(svg.count("<path") > 5 and svg.count("<text") > 3 for svg in drawn)


def test_what_is_missing_is_said(pages):
    text = Page(pages["nothing"]).text
    for sentence in ("Nowhere:", "No cause is named", "There are no residuals", "nothing can be confounded"):
        assert sentence in text
    assert "no experiment is needed" in text


def test_numbers_have_units_and_sensible_digits(pages):
    text = Page(pages["one"]).text
    for expected in (
        "mass 1.10 (1.00 to 1.20) g", "stiffening 6.3 (4.4 to 8.3) ×10⁻⁴ 1/Pa", "99.6 %", "120 kPa", "131 kPa",
        "+9.0 %", "118 to 198 Hz", "7.0 σ", "delay from 4.2 µs", "not visible at any size", "3.4 nats", "0.5 h",
        "3.2×10⁻⁴¹", "adhesive compliance 320 (10 to 4000) pm/Pa", "gap grows by 10 %",
    ):  # fmt: skip
        assert expected in text


def test_group_is_explained(pages):
    text = Page(pages["one"]).text
    assert "The data cannot tell these apart: sensor mass; preload." in text
    assert "C the yielding of the plate's centre; separated by a second top plate of another mass" in text


def test_an_unknown_cause_may_be_one_of_a_group():
    made = diagnosis("unknown")
    made = replace(made, record=made.record | {"group": [["unknown"], ["saturating_air"]]})
    text = Page(str(files_of(made)["report.html"])).text
    assert "The data cannot tell these apart: an unknown cause; saturating air." in text
    assert "Cause unknown" in text
    assert "One of several causes" not in text


def test_other_configurations_are_folded_away(pages):
    labels = Page(pages["many"]).figures
    assert len([label for label in labels if label.startswith(("Measured minus modelled", "before after"))]) == 12
    assert pages["many"].count("<details>") == 1
    assert "<details>" not in pages["one"]


def test_names_are_shown_to_the_letter():
    made = diagnosis(
        campaign="<b>foam</b>", sentence="It is <i>glue</i> & [red]nothing[/red]", configurations=HOSTILE,
        effects=("<u>plug</u>", *EFFECTS[:9]),
    )  # fmt: skip
    page = Page(str(files_of(made)["report.html"]))
    assert not {"script", "b", "i", "u"} & set(page.tags)
    assert "onload" not in {name for name, _ in page.attributes}
    for name in ("<b>foam</b>", "It is <i>glue</i> & [red]nothing[/red]", "<u>plug</u>", *HOSTILE[:4]):
        assert name in page.text


def test_files_are_complete(tmp_path):
    made = diagnosis(configurations=["A/b", "a_b"])
    files = {name: content for name, content in files_of(made).items() if name.endswith(".png")}
    assert set(files) == {
        "where.png", "causes.png", "before_after-A_b.png", "before_after-a_b-2.png", "similarity.png",
        "next_experiment.png", "moduli.png",
    }  # fmt: skip
    assert all(content.startswith(b"\x89PNG") and len(content) > 5000 for content in files.values())
    assert set(files_of(bare())) == {"diagnosis.json", "report.html"}


def test_terminal_says_the_sentence_then_short_tables(capsys):
    show_diagnosis(diagnosis(campaign="[red]foam[/red]"))
    first, *rest = capsys.readouterr().out.splitlines()
    assert first == (
        "[red]foam[/red]: The gap is caused by sensor mass (probability 61 %); the data cannot tell it from preload."
    )
    text = "\n".join(rest)
    assert len(rest) < 50
    for expected in ("shrinkage 99.6 %", "mass 1.10 (1.00 to 1.20) g", "not told apart", "channels swapped"):
        assert expected in text


def test_terminal_leaves_out_empty_tables(capsys):
    show_diagnosis(bare())
    assert len(capsys.readouterr().out.splitlines()) == 2


def test_json_holds_null_where_a_number_is_not_finite():
    made = bare(gap={"before": float("nan"), "after": np.float64(1.5), "shrinkage": None, "held_out": "nothing"})
    gap = json.loads(made.to_json())["gap"]
    assert gap == {"before": None, "after": 1.5, "shrinkage": None, "held_out": "nothing"}
    assert "–" in Page(str(files_of(made)["report.html"])).text


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (0.0011, "kg", "1.1 g"),
        (1.5, "kg", "1.5 kg"),
        (3e-5, "s", "30 µs"),
        (3e-10, "m/Pa", "300 pm/Pa"),
        (3e4, "N s/m4", "30 kN s/m⁴"),
        (5e-4, "1/Pa", "5×10⁻⁴ 1/Pa"),
        (0.05, "", "0.05"),
        (0.5, "Hz", "0.5 Hz"),
        (0.0, "kg", "0 kg"),
        (float("nan"), "kg", "– kg"),
    ],
)
def test_values_get_readable_units(value, unit, shown):
    assert with_unit(value, unit) == shown


def test_intervals_tell_the_digits():
    assert with_interval(-0.02, -0.03, -0.01, "") == "-0.020 (-0.030 to -0.010)"
    assert with_interval(1e-3, 1e-6, 1.0, "kg") == "1 (0.001 to 1000) g"
    assert with_interval(0.3, 0.3, 0.3, "s") == "300 ms"
    # next to nothing of either sign: the ends tell how it is written
    assert with_interval(-3e-18, -0.66, 0.66, "") == "0.00 (-0.66 to 0.66)"
    assert with_interval(0.0, -3e-6, 4e-6, "s") == "0.0 (-3.0 to 4.0) µs"
    assert [percent(x) for x in (0.996, 0.873, 1.0, -0.1)] == ["99.6 %", "87 %", "100 %", "-10 %"]
    assert [significant(x) for x in (1234.0, 123456.0, 1e9, 1e-7)] == ["1230", "123000", "1×10⁹", "1×10⁻⁷"]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed")
@pytest.mark.parametrize("name", CASES)
def test_page_prints_on_two_sheets(name, pages, tmp_path):
    (tmp_path / "report.html").write_text(pages[name], encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
    command = ["chromium", *options, f"--user-data-dir={tmp_path / 'profile'}", f"--print-to-pdf={tmp_path / 'r.pdf'}"]
    subprocess.run([*command, (tmp_path / "report.html").as_uri()], check=True, capture_output=True, timeout=120)
    sheets = re.findall(rb"/Type\s*/Page\b(?!s)", (tmp_path / "r.pdf").read_bytes())
    assert 1 <= len(sheets) <= 2


@pytest.mark.parametrize("verdict", ["effect", "unknown"])
def test_the_probabilities_of_the_causes_add_up(verdict):
    listings = [t for section in diagnosis_report(diagnosis(verdict)).sections for t in section.listings]
    (causes,) = [table for table in listings if table.headings[0] == "cause"]
    at = causes.headings.index("probability")
    shares = [float(row[at].removesuffix("%")) for row in causes.rows if row[at] not in ("–", "")]
    assert abs(sum(shares) - 100) < 0.6 * len(shares)
    named = [row[0] for row in causes.rows]
    assert "none of the known" in named
    assert named[-1] == "all others"


def test_two_effects_that_count_with_one_are_told_so():
    made = diagnosis()
    causes = [{**cause} for cause in made.record["causes"]]
    causes[2] |= {"effects": ["sensor_mass", "rocking"], "counted_with": ["sensor_mass"], "score": 1e4}
    report = diagnosis_report(replace(made, record={**made.record, "causes": causes}))
    (table,) = [t for section in report.sections for t in section.listings if t.headings[0] == "cause"]
    row = next(row for row in table.rows if "rocking" in row[0])
    assert row[1:3] == ("–", "–")
    assert "counts with sensor mass" in row[-1]
    assert table.rows[0][2] == "0.0"


@pytest.mark.parametrize(
    ("verdict", "command"),
    [("effect", "multilayer fit my/foam --with out/diagnosis.json "), ("no_gap", "multilayer fit my/foam --joint ")],
)
def test_it_ends_with_the_commands_to_type_next(verdict, command):
    report = diagnosis_report(diagnosis(verdict), Path("my/foam"), Path("out"))
    assert report.sections[-1].title == "What to type next"
    assert report.sections[-1].remarks[0].startswith(command)


def test_a_gain_beyond_doubt_is_no_number():
    made = diagnosis()
    plans = [{**plan, "expected_gain": 54321.0} for plan in made.record["next_experiment"]]
    page = diagnosis_report(replace(made, record={**made.record, "next_experiment": plans}))
    tables = [t for s in page.sections for part in s.parts() for t in part.listings]
    assert any("above 100 nats" in row for table in tables for row in table.rows)


def test_what_is_modelled_beneath_a_drawn_law_is_told_once():
    f, rim = np.geomspace(100, 1000, 20), "an open rim of the upper face, 16 % of the radius"
    curves = {f"{part}{end}": [0.01] * 20 for part in ("real", "imag") for end in ("", "_low", "_high")}
    beyond = "a relative change of 0.03"
    form = {"text": f"{rim}, and beyond it {beyond}", "beyond": beyond, "real": [0.01] * 20, "imag": [0.0] * 20}
    law = {"place": "faces", "modelled": rim, "quantity": "relative change", "unit": "", "frequency_hz": [*f], **curves}
    faces = {"place": "faces", "title": "at the faces of the sample", "probability": 1.0, "behind": 0.0}
    made = diagnosis("unknown", 3)
    places = [{**faces, "gap_after": 1.1, "shrinkage": 0.998}]
    record = {**made.record, "places": places, "law": {**law, "form": form, "form_is_enough": False}}
    text = Page(files_of(replace(made, record=record))["report.html"]).text
    assert "No simple form does as well as the law drawn there; the nearest is a relative change of 0.03." in text
    moved = {**law, "modelled": "", "moved": {"thin": 1.2, "thick": 0.85}, "form": form, "form_is_enough": False}
    text = Page(files_of(replace(made, record={**record, "law": moved}))["report.html"]).text
    assert "Its frequencies in the configurations: thin +20 %, thick -15 %." in text
    differing = {**moved, "moved": {}, "factors": {"thin": -0.26, "thick": 0.134}, "objection": "leaves a misfit"}
    text = Page(files_of(replace(made, record={**record, "law": differing}))["report.html"]).text
    assert "Its factors in the configurations: thin -0.26, thick 0.13." in text
    assert "It does not explain the gap: it leaves a misfit." in text
    assert "--save-law" not in text


def test_stated_quantities_that_are_off_are_told():
    made = diagnosis("unknown", 3)
    off = {"density": {"nominal": 9.1, "corrected": 0.2}, "thickness[0.025]": {"nominal": -1.0, "corrected": 0.4}}
    text = Page(files_of(replace(made, record={**made.record, "stated_deviations": off}))["report.html"]).text
    assert "+9.1 σ" in text
    assert "thickness[0.025]" not in text


def test_narrow_axes_mark_few_octaves():
    _, axes = blank(1, 2, (6, 2))
    octave_ticks(axes[0, 0], 80.0, 1800.0)
    octave_ticks(axes[0, 1], 80.0, 1800.0, most=3)
    labels = [[label.get_text() for label in axis.get_xticklabels()] for axis in axes[0]]
    assert labels == [["125", "250", "500", "1k"], ["125", "500"]]

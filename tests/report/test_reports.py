"""Reports of fits, simulations and comparisons: whole, self-contained, the verdict first, numbers with units."""

import re
from base64 import b64encode
from hashlib import sha256

import pytest

from multilayer.report.listing import Listing, flat_items
from tests.report.reports import HOSTILE, REPORTS, page
from tests.report.test_diagnosis_report import Page

MADE = [name for name in REPORTS if name != "diagnosis"]


@pytest.mark.parametrize("name", MADE)
def test_page_is_whole_and_needs_nothing_else(name):
    html = page(name)
    found = Page(html)
    assert html.startswith("<!DOCTYPE html>")
    assert not re.search(r"https?://|@import|data:", html)
    assert not {"script", "link", "iframe", "img", "image", "object", "foreignobject", "b", "i"} & set(found.tags)
    ids = [value for key, value in found.attributes if key == "id"]
    assert len(ids) == len(set(ids))
    links = [value for key, value in found.attributes if key in ("href", "xlink:href")]
    links += [f"#{target}" for target in re.findall(r"url\(#([^)]+)\)", html)]
    assert {link.removeprefix("#") for link in links} <= set(ids)
    assert "onload" not in {key for key, _ in found.attributes}


@pytest.mark.parametrize("name", MADE)
def test_style_sheets_are_those_of_the_policy_and_nothing_else_is_allowed(name):
    html = page(name)
    (policy,) = re.findall(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', html)
    assert html.index(policy) < html.index("<title>") < html.index("<style>")
    sheets = re.findall(r"<style>(.*?)</style>", html, re.DOTALL)
    hashes = {f"'sha256-{b64encode(sha256(sheet.encode()).digest()).decode()}'" for sheet in sheets}
    assert len(sheets) == 1 + html.count("<svg")
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert set(rules.pop("style-src").split()) == hashes
    assert rules == dict.fromkeys(("default-src", "base-uri", "form-action"), "'none'")
    assert "style" not in {key for key, _ in Page(html).attributes}


@pytest.mark.parametrize("name", MADE)
def test_figures_are_drawn_and_take_the_colours_of_the_page(name):
    html = page(name)
    drawn = re.findall(r"<svg.*?</svg>", html, re.DOTALL)
    assert drawn
    assert len(drawn) == Page(html).tags.count("figure")
    assert all(svg.count("<path") > 5 and svg.count("<text") > 3 for svg in drawn)
    assert not re.search(r"(fill|stroke): ?#(000|fff)", html)
    assert "prefers-color-scheme: dark" in html
    assert "@media print" in html


@pytest.mark.parametrize("name", MADE)
def test_sentence_comes_first_then_facts_evidence_inputs(name):
    html = page(name)
    places = [html.index(part) for part in ("<h1>", '<dl class="facts">', "<main>", "<svg", "<footer>")]
    assert places == sorted(places)
    sentence = re.search(r"<h1>(.*?)</h1>", html, re.DOTALL)[1]
    assert sentence[0].isupper() or sentence[0].isdigit()
    assert sentence.endswith(".")
    footer = Page(html[html.index("<footer>") : html.index("</footer>") + 9]).text
    for what in ("multilayer :", "numpy :", "scipy :", "Python :"):
        assert what in re.sub(r"(\w)\s+(\d)", r"\1 : \2", footer)


@pytest.mark.parametrize("name", MADE)
def test_numbers_are_rounded(name):
    texts = Page(re.sub(r"<svg.*?</svg>|<style>.*?</style>", "", page(name), flags=re.DOTALL)).text
    assert not re.search(r"\d\.\d{7,}", texts)
    assert not re.search(r"\bnan\b|\binf\b", texts)


def test_fit_says_what_was_found():
    text = Page(page("fit")).text
    for expected in (
        "All accepted", "All 15 bursts have an accepted solution: from 100 to 1500 Hz E1 goes from 170 to 308 kPa",
        "median std of E1 1 %", "E1 / kPa", "170.0 ± 1.7", "foam, 300 Hz: E1 = 433 kPa", "0000000000000000…",
    ):  # fmt: skip
        assert expected in text


def test_fit_of_many_bursts_sums_up_and_folds_the_rest_away():
    html = page("fit, many bursts")
    text = Page(html).text
    assert "91 of 105 bursts have an accepted solution" in text
    assert "Not all accepted" in text
    assert html.count("<details>") == 1
    assert "13 of 15" in text[: text.index("Every burst")]
    for name in HOSTILE:
        assert name in text


def test_fit_without_a_solution_says_so():
    assert "None of the 15 bursts has an accepted solution" in Page(page("fit, none accepted")).text


def test_joint_fit_says_whether_one_law_does():
    text = Page(page("joint")).text
    assert "One fractional_zener law does not explain all bursts within what is stated (p < 10⁻¹²)" in text
    for expected in ("relaxed_modulus", "68 %", "kPa", "What the data determine", "Moduli at the bursts"):
        assert expected in text


def test_stack_fit_gives_intervals_with_units():
    text = Page(page("stack fit")).text
    assert "5 of 5 unknowns are determined: the model explains the data within their noise" in text
    assert re.search(r"foam\.flow_resistivity 13\.\d+ \(13\.\d+ to 1[34]\.\d+\) kN s/m⁴", text)
    assert "µm" in text


def test_simulation_tells_its_cases_apart():
    text = Page(page("simulation")).text
    assert re.search(
        r"Of 3 cases the best is foam\.thickness = 100 mm: alpha_w 0\.\d\d.*; the worst is .* = 25 mm", text
    )
    for expected in ("25 mm", "alpha_w", "averages over third octaves", "5 to 95 % of the samples"):
        assert expected in text
    assert "10 more, see simulation.csv and simulation.json." in Page(page("simulation, many cases")).text
    ranked = r"Of \d cases the best is .*: Rw \(C; Ctr\) (\d+) \(.*; the worst is .*: Rw \(C; Ctr\) (\d+) \("
    best, worst = re.search(ranked, Page(page("transmission")).text).groups()
    assert int(best) >= int(worst)


def test_comparison_names_the_closest_case():
    text = Page(page("comparison")).text
    assert "The closest absorption coefficient of the case foam.thickness = 50 mm differs from the prediction" in text
    assert "<i>tube</i> over foam" in text


def test_inputs_in_one_level():
    data = {"a": {"b": 1.0, "c": {"d": 2, "e": None}}, "l": [{"x": 1}, {"x": 2}], "none": None, "empty": []}
    assert flat_items(data) == [("a: b", "1"), ("a: c", "d 2"), ("l 1", "x 1"), ("l 2", "x 2")]
    given = {"flow_resistivity": 12345.0, "young_modulus": 2.512e11, "thickness": 0.0123456, "length": 1.1 * 3e-5}
    assert [text for _, text in flat_items(given)] == ["12345", "2.512×10¹¹", "0.0123456", "3.3×10⁻⁵"]


def test_columns_without_anything_are_left_out():
    table = Listing(("a", "b", "c"), (("1", "", "2"), ("3", "", "")), (0, 2)).filled()
    assert table == Listing(("a", "c"), (("1", "2"), ("3", "")), (0, 1))

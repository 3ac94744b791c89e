"""Every report in headless Chromium: no complaint, all figures to be seen, nothing too wide, on two sheets at most."""

import re

import pytest

from tests.report.browser import measure, sheets
from tests.report.reports import REPORTS, page

WIDTHS = [1280, 400]
SMALLEST = 5.5  # px of the smallest text in a figure: 7 points at half a page


@pytest.fixture(scope="module", params=["light", "dark"])
def seen(request, tmp_path_factory):
    """Give the scheme, measurements of every page at every width, and complaints."""
    folder = tmp_path_factory.mktemp(request.param)
    found, complaints = measure(folder, {name: page(name) for name in REPORTS}, WIDTHS, dark=request.param == "dark")
    return request.param, found, complaints


def test_no_complaint(seen):
    _, found, complaints = seen
    assert complaints == []
    assert [(one["name"], one["width"]) for one in found] == [(name, width) for name in REPORTS for width in WIDTHS]


def test_figures_are_seen(seen):
    _, found, _ = seen
    for one in found:
        assert one["svgs"], one["name"]
        for svg in one["svgs"]:
            assert svg["size"][0] > 0.6 * min(one["width"], 400), one["name"]
            assert svg["size"][1] > 80
            assert svg["shapes"] > 5
            assert min(svg["text"]) > SMALLEST
            assert svg["spill"] < 8, (one["name"], one["width"])  # into the margin, not beyond


def test_nothing_is_too_wide(seen):
    _, found, _ = seen
    for one in found:
        assert one["scroll"] <= one["width"], one["name"]
        assert one["beyond"] == [], (one["name"], one["width"])
        assert all(one["cells"]), one["name"]


def test_scheme_is_followed_with_contrast(seen):
    scheme, found, _ = seen
    for one in found:
        assert one["dark"] == (scheme == "dark")
        ink, paper = (sum(map(float, re.findall(r"\d+", one[part])[:3])) / 765 for part in ("colour", "paper"))
        assert abs(ink - paper) > 0.7
        assert (ink > paper) == (scheme == "dark")


@pytest.mark.parametrize("name", ["fit, many bursts", "joint", "stack fit", "simulation", "transmission", "comparison"])
def test_prints_on_two_sheets(name, tmp_path):
    assert 1 <= sheets(tmp_path, page(name)) <= 2

"""The page of a model beside its measurements in headless Chromium as a person uses it."""

from pathlib import Path

import pytest

from multilayer.explore.model import ModelExplorer
from multilayer.fits.sources import open_source
from tests.explore.command import serving
from tests.explore.webdriver import beyond

CURVE = "return document.querySelector('.chart .curve.now').getAttribute('d')"
MOVED = "return document.querySelector('.chart .curve.now').getAttribute('d') !== arguments[0]"
BACK = "return document.querySelector('.chart .curve.now').getAttribute('d') === arguments[0]"
FITTED = "return document.querySelector('#status').textContent.startsWith('Fitted')"
RESISTIVITY = "#at-layers-foam-flow_resistivity"


@pytest.fixture(scope="module")
def explorer():
    """Give the foam in a tube."""
    return ModelExplorer(open_source(Path("examples/foam_tube")))


@pytest.fixture
def page(browser, explorer):
    """Give the browser at its page; nothing may complain meanwhile."""
    with serving(explorer) as server:
        browser.open(server.url)
        yield browser
        browser.size(1280, 900)
        assert browser.complaints() == []


@pytest.mark.parametrize("width", [1280, 400])
def test_all_is_to_be_seen(width, page):
    page.size(width, 900)
    page.wait("return innerWidth === arguments[0]", width)
    page.click("#effect-facing")
    page.wait("return document.querySelector('#at-facing-surface_density') !== null")
    assert beyond(page) == []
    assert page.run("return document.documentElement.scrollWidth <= innerWidth")
    assert page.text("#file") == "foam_tube"
    assert page.run("return document.querySelectorAll('.chart').length") == 2
    assert page.run("return document.querySelectorAll('.chart circle.point').length") == 2 * len(
        page.run("return result.curves.frequency")
    )
    labels = "return [...document.querySelectorAll('input, select, button')].filter(one => !one.labels?.length" + (
        " && !one.getAttribute('aria-label') && !one.textContent.trim()).map(one => one.id)"
    )
    assert page.run(labels) == []  # each has a name for who does not see it


def test_curves_follow_a_slider_and_one_undo_takes_it_back(page):
    before, misfit = page.run(CURVE), page.text("#ratings")
    page.drag(f"{RESISTIVITY}-slider", 0.9)
    page.wait(MOVED, before)
    page.wait("return document.querySelector('#ratings').textContent !== arguments[0]", misfit)
    assert 0 < float(page.run("return document.body.dataset.latency")) < 5000
    page.run("document.activeElement.blur()")
    page.press("z", hold=["Control"])
    page.wait(BACK, before)
    assert page.run("return document.querySelector('#undo').disabled")


def test_an_effect_is_added_turned_held_and_fitted(page):
    before = page.run(CURVE)
    page.click("#effect-facing")
    page.wait(MOVED, before)
    page.type("#at-facing-surface_density", "50 g/m^2")
    page.wait("return result.values['facing.surface_density']?.text === '50'")
    page.click("#at-facing-surface_density-held")
    page.click("#fit")
    page.wait(FITTED)
    assert page.run("return document.querySelector('#at-facing-surface_density').value") == "50"
    assert page.run("return result.misfit") < 1
    page.click("#gap")
    page.wait("return document.querySelector('.chart h3').textContent.includes('measured − modelled')")
    page.click("#gap")
    page.click("#nominal")
    page.wait(BACK, before)
    assert page.run("return document.querySelector('#effect-facing').checked") is False


def test_what_is_held_comes_back_with_its_effect(page):
    page.click("#effect-facing")
    page.wait("return document.querySelector('#at-facing-surface_density') !== null")
    page.click("#at-facing-surface_density-held")
    page.click("#effect-facing")
    page.wait("return document.querySelector('#at-facing-surface_density') === null")
    page.click("#undo")
    page.wait("return document.querySelector('#at-facing-surface_density-held')?.checked")


def test_a_model_is_kept_to_compare_with(page):
    nominal = page.run("return document.querySelector('.chart .curve.c0').getAttribute('d')")
    page.type(RESISTIVITY, "20")
    page.wait("return document.querySelector('#ratings dd').textContent.startsWith('0.') === false")
    page.click("#freeze")
    page.wait("return document.querySelector('.chart .curve.c0').getAttribute('d') !== arguments[0]", nominal)
    page.click("#unfreeze")
    page.wait("return document.querySelector('.chart .curve.c0').getAttribute('d') === arguments[0]", nominal)


def test_keyboard_alone(page):
    before = page.run(CURVE)
    for _ in range(60):
        page.press("Tab")
        if page.run("return document.activeElement.id") == "effect-facing":
            break
    else:
        pytest.fail("the effect is not reached")
    assert page.run("return getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.press("Space")
    page.wait(MOVED, before)
    assert page.run("return document.activeElement.id") == "effect-facing"
    page.press("Tab", "Tab", "Tab", *["Right"] * 30)
    assert page.run("return document.activeElement.id") == "at-facing-flow_resistance-slider"
    added = page.run(CURVE)
    page.press("Enter")
    page.wait(FITTED)
    page.wait(MOVED, added)
    for _ in range(3):
        page.press("z", hold=["Control"])
    page.wait(BACK, before)


def test_a_value_that_is_refused_says_why(page):
    before = page.run(CURVE)
    page.type(RESISTIVITY, "3 kg")
    page.wait("return document.body.classList.contains('stale')")
    assert "flow resistivity" in page.text("#banners")
    assert page.run(CURVE) == before
    page.type(RESISTIVITY, "12")
    page.wait("return !document.body.classList.contains('stale')")


def test_a_reload_goes_on_where_it_was(page):
    page.click("#effect-facing")
    page.wait("return document.querySelector('#at-facing-surface_density') !== null")
    page.type("#at-facing-surface_density", "70")
    page.wait("return result.values['facing.surface_density']?.text === '70'")  # the box says so before the curves
    now = page.run(CURVE)
    page.run("document.body.dataset.ready = ''")
    page.devtools("Page.reload", {})
    page.wait("return document.body.dataset.ready === 'yes'")
    page.wait(BACK, now)

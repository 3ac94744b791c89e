"""The page in headless Chromium as a person uses it: pointer, keyboard, two widths, two windows, another editor."""

import signal
import threading
from contextlib import contextmanager

import pytest

from multilayer.config.yaml12 import dump_yaml, parse_yaml
from multilayer.explore.explorer import Explorer
from multilayer.explore.server import Server
from multilayer.simulation.file import load_simulation
from multilayer.simulation.measured import read_measured
from tests.cli.command import run
from tests.explore.command import exploring, serving
from tests.explore.webdriver import beyond

STACK = """\
kind: simulation
version: 1
layers:
  - {material: Vigran2008/T8.2/plasterboard, thickness: 12.5 mm, name: board}
  - {type: limp, material: AA2009/T11.2/soft_fibrous, thickness: 50 mm, name: wool}
termination: ambient
frequency: {from: 90 Hz, to: 5.6 kHz, points: 120}
"""
TABLE = "frequency_hz,transmission_loss_db\n125,20\n500,30\n2000,40\n"
HOSTILE = "<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>\u202e&amp;"
CURVE = "return document.querySelector('.chart .curve.now').getAttribute('d')"
SETTLED = "return !document.body.classList.contains('stale') && document.querySelector('.chart .curve.now') !== null"


class Held:
    """Answers to one question, which may be held back for a while."""

    def __init__(self, explorer, question):
        self.free, self.asked = threading.Event(), threading.Event()
        self.free.set()
        answer = explorer.answers[question]

        def answered(request):
            self.asked.set()
            assert self.free.wait(20)
            return answer(request)

        explorer.answers[question] = answered

    def __enter__(self):
        self.asked.clear()
        self.free.clear()
        return self

    def __exit__(self, *_):
        self.free.set()


@contextmanager
def served(file, measured=()):
    """Give the address of a page until the block ends."""
    with serving(Explorer(file, measured)) as server:
        yield server.url


@pytest.fixture
def file(tmp_path):
    """Give a board before wool."""
    path = tmp_path / "wall.yaml"
    path.write_text(STACK)
    return path


@pytest.fixture
def page(browser, file, tmp_path):
    """Give the browser at the page of that file, with a measurement; nothing may complain meanwhile."""
    (tmp_path / "site.csv").write_text(TABLE)
    with served(file, [read_measured(tmp_path / "site.csv")]) as url:
        browser.open(url)
        yield browser
        browser.size(1280, 900)
        assert [text for text in browser.complaints() if "beforeunload" not in text] == []


@pytest.fixture
def late(browser, file):
    """Give the browser at a page whose answers may be held back, and what holds edits and curves."""
    explorer = Explorer(file)
    edits, curves = Held(explorer, "edit"), Held(explorer, "evaluate")
    with serving(explorer) as server:
        browser.open(server.url)
        yield browser, edits, curves
        assert [text for text in browser.complaints() if "beforeunload" not in text] == []


@pytest.mark.parametrize("width", [1280, 400])
def test_all_is_to_be_seen(width, page):
    page.size(width, 900)
    page.wait("return innerWidth === arguments[0]", width)
    page.run("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    assert beyond(page) == []
    assert page.run("return document.documentElement.scrollWidth <= innerWidth")
    assert page.text("#file") == "wall.yaml"
    assert page.run("return document.querySelectorAll('#drawing .slab').length") == 2
    first, second = page.run(
        "return [...document.querySelectorAll('#drawing .slab')].map(one => Number(one.getAttribute('width')))"
    )
    assert second / first == pytest.approx(50 / 12.5, rel=1e-6)  # to scale
    assert page.run("return document.querySelectorAll('.chart circle.point').length") == 3
    assert "Rw (C; Ctr), normal" in page.text("#ratings")
    sliders = "return [...document.querySelectorAll('.setting input[type=range]')].map(one => one.clientWidth)"
    assert min(page.run(sliders)) > 90
    labels = "return [...document.querySelectorAll('input, select, button')].filter(one => !one.labels?.length" + (
        " && !one.getAttribute('aria-label') && !one.textContent.trim()).map(one => one.id)"
    )
    assert page.run(labels) == []  # each has a name for who does not see it


def test_curves_stay_in_sight_of_sliders_on_a_telephone(page):
    page.size(400, 900)
    page.run("document.querySelector('#layer-0').open = false; document.querySelector('#layer-1').open = true")
    page.run("document.querySelector('#at-layers-1-flow_resistivity-slider').scrollIntoView({block: 'center'})")
    box = "const box = document.querySelector('.chart svg').getBoundingClientRect(); return [box.top, box.bottom]"
    top, bottom = page.run(box)
    assert 0 <= top < bottom < 450


def test_curves_and_drawing_follow_a_slider_and_one_undo_takes_it_back(page):
    before, rated = page.run(CURVE), page.text("#ratings")
    page.drag("#at-layers-0-thickness-slider", 0.9)
    page.wait("return document.querySelector('.chart .curve.now').getAttribute('d') !== arguments[0]", before)
    page.wait("return document.querySelector('#ratings').textContent !== arguments[0]", rated)
    thick = float(page.run("return document.querySelector('#at-layers-0-thickness').value"))
    assert thick > 50
    assert page.text("#layer-0 .thick") == f"{thick:g} mm"
    assert page.run("return document.querySelector('#unsaved').hidden") is False
    assert 0 < float(page.run("return document.body.dataset.latency")) < 5000
    page.run("document.activeElement.blur()")
    page.press("z", hold=["Control"])
    page.wait("return document.querySelector('.chart .curve.now').getAttribute('d') === arguments[0]", before)
    assert page.run("return document.querySelector('#at-layers-0-thickness').value") == "12.5"
    assert page.run("return document.querySelector('#undo').disabled")
    page.press("z", hold=["Control", "Shift"])
    page.wait("return document.querySelector('#at-layers-0-thickness').value === arguments[0]", f"{thick:g}")


def test_keyboard_alone(page, file):
    """From the top of the page to a saved file without a pointer."""
    before = page.run(CURVE)
    for _ in range(60):
        page.press("Tab")
        if page.run("return document.activeElement.id") == "at-layers-0-thickness-slider":
            break
    else:
        pytest.fail("the slider is not reached")
    assert page.run("return getComputedStyle(document.activeElement).outlineStyle") == "solid"  # where one is
    page.press(*["Right"] * 40)
    page.wait("return document.querySelector('.chart .curve.now').getAttribute('d') !== arguments[0]", before)
    assert page.run("return document.activeElement.id") == "at-layers-0-thickness-slider"
    page.press("f")
    page.wait("return document.querySelectorAll('.chart .curve').length >= 2")
    page.press("Down", hold=["Alt"])  # the layer goes to the back
    page.wait("return document.querySelector('#layer-1 .title').textContent === 'board'")
    page.press("s", hold=["Control"])
    page.wait("return document.querySelector('#saving').open")
    page.press("a", hold=["Control"])
    page.press(*"mine.yaml", "Enter")
    page.wait("return !document.querySelector('#saving').open")
    saved = load_simulation(file.with_name("mine.yaml"))
    assert [layer.name for layer in saved.layers] == ["wool", "board"]
    assert saved.layers[1].thickness > 0.0126
    assert page.run("return document.querySelector('#unsaved').hidden")
    page.press("z", hold=["Control"])
    page.press("z", hold=["Control"])
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '12.5'")


def test_a_value_that_is_refused_says_why_at_its_field(page):
    before = page.run(CURVE)
    page.type("#at-layers-0-poisson_ratio", "0.7")
    page.wait("return document.body.classList.contains('stale')")
    assert "0.7 is not allowed: it must be below 0.5" in page.text("#at-layers-0-poisson_ratio-wrong")
    assert (
        page.run("return document.querySelector('#at-layers-0-poisson_ratio').getAttribute('aria-invalid')") == "true"
    )
    assert "layers.0.poisson_ratio" in page.text("#banners")
    assert page.run(CURVE) == before
    page.click("#undo")
    page.wait(SETTLED)
    assert page.run("return document.querySelector('#banners').textContent") == ""
    page.type("#at-layers-0-thickness", "2 cm")  # any unit may be written
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '20'")
    page.type("#at-layers-0-thickness", "8")  # without one it is that beside the box
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '8 mm'")


def add(page, what, where, then):
    """Add a layer, and wait until there are so many."""
    page.choose("#new", what)
    page.choose("#where", str(where))
    page.click("#add button")
    page.wait(f"return document.querySelectorAll('#layers > li').length === {then}")


def test_layers_are_added_moved_changed_and_removed(page):
    titles = "return [...document.querySelectorAll('#layers .title')].map(one => one.textContent)"
    add(page, "type fluid", where=1, then=3)
    assert page.run(titles) == ["board", "fluid", "wool"]
    add(page, "material Vigran2008/T8.2/plasterboard", where=3, then=4)
    page.wait(SETTLED)
    page.run("document.querySelectorAll('#layers details').forEach((one, i) => { one.open = i === 1; })")
    page.click("#layer-1-up")
    page.wait("return document.querySelector('#layer-0 .title').textContent === 'fluid'")
    page.choose("#at-layers-0-material", "AA2009/T11.6/foam")
    page.wait("return document.querySelector('#layer-0 .what').textContent.includes('elastic frame')")
    assert page.run("return document.querySelector('#at-layers-0-porosity').value") == "0.98"
    page.run("document.querySelectorAll('#layers details').forEach((one, i) => { one.open = i === 0; })")
    page.click("#layer-0-remove")
    page.wait("return document.querySelectorAll('#layers > li').length === 3")
    assert page.run(titles)[:2] == ["board", "wool"]
    for _ in range(5):
        page.click("#undo")
    page.wait("return document.querySelectorAll('#layers > li').length === 2")
    assert page.run("return document.querySelector('#unsaved').hidden")


def test_the_sound_field_is_chosen(page):
    page.click("[name=incidence][value=diffuse]")
    page.wait("return document.querySelector('#ratings').textContent.includes('diffuse to 78')")
    assert page.run("return document.querySelectorAll('.chart').length") == 2  # no impedance in a diffuse field
    page.drag("#angle-slider", 1.0)
    page.wait("return document.querySelector('#ratings').textContent.includes('diffuse to 90')")
    page.click("[name=incidence][value=oblique]")
    page.wait("return document.querySelector('#ratings').textContent.includes('45°')")
    page.choose("#termination", "rigid")
    page.wait("return document.querySelector('#ratings').textContent.includes('alpha_w')")


def test_a_curve_is_frozen_and_gone_back_to(page):
    before = page.run(CURVE)
    page.click("#freeze")
    page.drag("#at-layers-0-thickness-slider", 0.9)
    page.wait("return document.querySelector('.chart .curve.now').getAttribute('d') !== arguments[0]", before)
    assert page.run("return document.querySelector('.chart .curve.c0') !== null")
    page.wait("return document.querySelector('#ratings').textContent.includes('before')")
    assert "site, measured" in page.text("#curves")
    page.click("#back-0")
    page.wait("return document.querySelector('.chart .curve.now').getAttribute('d') === arguments[0]", before)


def test_cards_of_a_design_that_is_no_more_change_nothing(late):
    page, _, curves = late
    add(page, "type fluid", where=0, then=3)
    page.wait(SETTLED)
    page.run("document.querySelector('#layer-2').open = true")
    with curves:
        page.click("#undo")
        assert curves.asked.wait(10)
        page.drag("#at-layers-2-thickness-slider", 0.9)  # of the wool, which is layer 1 again
        page.run("document.querySelector('#layer-1-remove').click()")
    page.wait("return document.querySelectorAll('#layers > li').length === 2")
    page.wait("return !document.querySelector('#controls').inert")
    assert page.run("return state.data.layers.map(one => [one.name, one.thickness])") == [
        ["board", "12.5 mm"],
        ["wool", "50 mm"],
    ]
    page.drag("#at-layers-1-thickness-slider", 0.9)
    page.wait("return state.data.layers[1].thickness !== '50 mm'")


def test_what_is_moved_during_an_edit_stays(late):
    page, edits, _ = late
    with edits:
        page.click("#layer-0-copy")
        assert edits.asked.wait(10)
        page.click("[name=incidence][value=oblique]")
    page.wait("return document.querySelectorAll('#layers > li').length === 3")
    assert page.run("return state.data.incidence") == 45
    page.click("#undo")
    page.wait("return document.querySelectorAll('#layers > li').length === 2")
    assert page.run("return state.data.incidence") == 45


def test_an_edit_of_a_design_that_is_no_more_is_not_done(late):
    page, edits, _ = late
    page.type("#at-layers-0-thickness", "9")
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '9 mm'")
    with edits:
        page.click("#layer-0-copy")
        assert edits.asked.wait(10)
        page.click("#undo")
    page.wait("return document.querySelector('#status').textContent.includes('this was not done')")
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '12.5'")
    page.wait("return !document.querySelector('#controls').inert")
    assert page.run("return state.data.layers.length") == 2


def test_the_keyboard_stays_where_it_was_while_controls_wait(page):
    page.type("#at-layers-0-name", "panel")
    page.wait("return document.querySelector('#layer-0 .title').textContent === 'panel'")
    page.wait("return document.activeElement.id === 'at-layers-0-material'")
    page.run("document.querySelector('#layer-0 summary').focus()")
    page.press("z", hold=["Control"])
    page.wait("return document.querySelector('#layer-0 .title').textContent === 'board'")
    page.wait("return !document.querySelector('#controls').inert")


def test_what_is_frozen_is_of_one_design(late):
    page, _, curves = late
    with curves:
        page.type("#at-layers-0-thickness", "30")
        assert curves.asked.wait(10)
        page.click("#freeze")
    page.wait("return state.frozen.length === 1")
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '30 mm'")
    same = "return JSON.stringify(state.frozen[0].curves) === JSON.stringify(result.curves)"
    assert page.run(same)
    assert page.run("return state.frozen[0].data.layers[0].thickness") == "30 mm"


def test_each_drag_of_the_angle_is_one_step(page):
    page.click("[name=incidence][value=diffuse]")
    page.wait("return document.querySelector('#angle-slider') !== null")
    page.drag("#angle-slider", 0.2)
    first = page.run("return state.data.incidence.diffuse.max_angle")
    page.drag("#angle-slider", 0.6)
    assert page.run("return state.data.incidence.diffuse.max_angle") > first
    page.click("#undo")
    assert page.run("return state.data.incidence.diffuse.max_angle") == first


@pytest.mark.parametrize(
    ("written", "shown"), [("{diffuse: {max_angle: 70 deg}}", "diffuse to 70°"), ("0.5 rad", "28.65°")]
)
def test_angles_may_be_written_with_their_unit(written, shown, browser, file):
    file.write_text(f"{STACK}incidence: {written}\n")
    with served(file) as url:
        browser.open(url)
        assert shown in browser.text("#ratings")


@pytest.mark.parametrize("names", [("from", "to"), ("start", "stop")])
def test_frequencies_of_files_old_and_new_stay(names, browser, file):
    low, high = names
    file.write_text(STACK.replace("from: 90 Hz, to: 5.6 kHz", f"{low}: 200.0, {high}: 2000.0"))
    with served(file) as url:
        browser.open(url)
        browser.run("document.querySelector('#around').open = true")
        assert browser.run("return document.querySelector('#at-frequency-from').value") == "200 Hz"
        browser.type("#at-frequency-points", "50")
        browser.wait("return result.frequency.length === 50")
        assert browser.run("return [result.frequency[0], result.frequency[49]]") == [200, 2000]


@pytest.mark.parametrize("spoilt", [None, "version: 1\nlayers: []\n"])
def test_a_reload_reaches_the_design_whatever_became_of_the_file(spoilt, page, file):
    page.type("#at-layers-0-thickness", "9")
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '9 mm'")
    file.unlink() if spoilt is None else file.write_text(spoilt)
    page.run("document.body.dataset.ready = ''")
    page.devtools("Page.reload", {})
    page.wait("return document.body.dataset.ready === 'yes'")
    assert page.run("return document.querySelector('#at-layers-0-thickness').value") == "9"
    assert "no such file" in page.text("#banners") or "must not be empty" in page.text("#banners")
    assert "goes on with the design that it has kept" in page.text("#banners")
    page.click("#undo")
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '12.5'")


def test_a_reload_goes_on_where_it_was(page):
    page.type("#at-layers-0-thickness", "9")
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '9 mm'")
    page.click("#freeze")
    page.run("document.body.dataset.ready = ''")
    page.devtools("Page.reload", {})
    page.wait("return document.body.dataset.ready === 'yes'")
    assert page.run("return document.querySelector('#at-layers-0-thickness').value") == "9"
    assert page.run("return document.querySelector('.chart .curve.c0') !== null")
    page.click("#undo")
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '12.5'")


def test_two_windows_are_two_designs_of_one_file(page, file):
    url = page.run("return location.href")
    first = page.new_window(url)
    page.type("#at-layers-0-thickness", "30")
    page.wait("return document.querySelector('#layer-0 .thick').textContent === '30 mm'")
    page.press("s", hold=["Control"])
    page.type("#save-name", "wall.yaml")
    page.click("#save-do")
    page.wait("return document.querySelector('#save-do').textContent === 'Replace it'")
    assert "its comments will be lost" in page.text("#save-problem")
    page.click("#save-do")
    page.wait("return !document.querySelector('#saving').open")
    assert load_simulation(file).layers[0].thickness == pytest.approx(0.03)
    page.ask("DELETE", "/window")
    page.look_at(first)
    assert page.run("return document.querySelector('#at-layers-0-thickness').value") == "12.5"
    page.wait("return document.querySelector('#banners').textContent.includes('changed on the disk')")
    page.press("s", hold=["Control"])
    page.type("#save-name", "wall.yaml")
    page.click("#save-do")
    page.wait("return document.querySelector('#save-problem').textContent.includes('since this window read it')")
    page.click("#save-cancel")
    page.click("#banners button")  # read it again
    page.wait("return document.querySelector('#at-layers-0-thickness').value === '30'")
    assert "changed on the disk" not in page.run("return document.querySelector('#banners').textContent")


def test_names_are_text_whatever_they_hold(browser, tmp_path):
    file = tmp_path / "names.yaml"
    data = parse_yaml(STACK, file).data
    data["layers"][1]["name"] = HOSTILE
    file.write_text(dump_yaml(data))
    assert load_simulation(file).layers[1].name == HOSTILE
    with served(file) as url:
        browser.open(url)
        assert browser.run("return document.querySelector('#layer-1 .title').textContent").startswith("<img src=x")
        assert browser.run("return document.querySelectorAll('img, main script').length") == 0
        assert browser.run("return document.title") == "names.yaml: multilayer explore"
        browser.click("#freeze")
        browser.choose("#layer-1-contact", "slip")
        browser.wait("return document.querySelector('#banners').textContent !== ''")  # a message that names the layer
        assert browser.run("return document.querySelectorAll('img, main script').length") == 0
        blocked = "try { document.body.innerHTML = 'x'; return false } catch (error) { return error.name }"
        assert browser.run(blocked) == "TypeError"  # the browser itself refuses to make markup of a text
        assert all("TrustedHTML" in text for text in browser.complaints())


def test_when_the_command_has_ended_nothing_is_lost(browser, file):
    with exploring(file) as (process, url):
        browser.open(url)
        browser.type("#at-layers-0-thickness", "9")
        browser.wait("return document.querySelector('#layer-0 .thick').textContent === '9 mm'")
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=10)
    assert process.returncode == 0
    browser.wait("return document.querySelector('#banners').textContent.includes('has ended')")
    browser.type("#at-layers-0-thickness", "8")
    browser.wait("return document.querySelector('#banners textarea').value.includes('8 mm')")
    leaves = "const event = new Event('beforeunload', {cancelable: true}); return window.dispatchEvent(event)"
    assert browser.run(leaves) is False  # it asks before the window is closed
    kept = file.with_name("kept.yaml")
    kept.write_text(browser.run("return document.querySelector('#banners textarea').value"))
    assert load_simulation(kept).layers[0].thickness == pytest.approx(8e-3)
    browser.complaints()  # of questions that nobody answers


def test_the_browser_is_led_to_the_page(browser, file, monkeypatch):
    told, seen, serve = [], [], Server.serve_forever

    def look(server, **_):
        thread = threading.Thread(target=serve, args=(server, 0.02), daemon=True)
        thread.start()
        try:
            browser.open(told[0])
            seen.append(browser.run("return location.href"))
        finally:
            server.shutdown()
            thread.join()

    monkeypatch.setattr("webbrowser.open", told.append)
    monkeypatch.setattr(Server, "serve_forever", look)
    done = run("explore", file, DISPLAY=":0")
    assert done.status == 0
    assert seen == [done.out.strip()]
    browser.complaints()

"""A browser as a person uses it: headless Chromium by the W3C WebDriver protocol, which is JSON over HTTP."""

import base64
import json
import re
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from contextlib import contextmanager

import pytest

from tests.report.browser import CHROMIUM, OPTIONS

DRIVER = shutil.which("chromedriver")
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
KEYS = {
    "Tab": "\ue004", "Enter": "\ue007", "Shift": "\ue008", "Control": "\ue009", "Alt": "\ue00a", "Escape": "\ue00c",
    "Space": " ", "Left": "\ue012", "Up": "\ue013", "Right": "\ue014", "Down": "\ue015", "Home": "\ue011",
}  # fmt: skip


class Browser:
    """One window of a session."""

    def __init__(self, address, session):
        self.base = f"{address}/session/{session}"

    def ask(self, method, path, body=None):
        """Send one command of the protocol, and return its value."""
        return _ask(method, f"{self.base}{path}", body)

    def open(self, url, *, width=1280, height=900):
        """Open a page in a view of this size, and wait until its first curves are there."""
        self.size(width, height)
        self.ask("POST", "/url", {"url": url})
        self.wait("return document.body.dataset.ready === 'yes'")

    def size(self, width, height):
        """Give the view, without the frame of the window, this size."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.devtools("Emulation.setDeviceMetricsOverride", metrics)

    def devtools(self, command, parameters):
        """Send a command of Chromium's own protocol."""
        return self.ask("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def run(self, script, *arguments):
        """Run a script as the page's own tools would, and return what it returns."""
        return self.ask("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, *arguments, seconds=10):
        """Wait until a script returns something true, and return that."""
        end = time.monotonic() + seconds
        while not (value := self.run(script, *arguments)):
            assert time.monotonic() < end, f"not in {seconds} s: {script}"
            time.sleep(0.03)
        return value

    def find(self, selector):
        """Return an element."""
        return self.ask("POST", "/element", {"using": "css selector", "value": selector})[_ELEMENT]

    def click(self, selector):
        """Click an element, which must be visible."""
        self.ask("POST", f"/element/{self.find(selector)}/click", {})

    def type(self, selector, text):
        """Replace the text of a box, and leave it."""
        self.click(selector)
        self.press("a", hold=["Control"])
        self.press(*text, "Tab")

    def choose(self, selector, value):
        """Choose an option of a list."""
        self.run(
            "const list = document.querySelector(arguments[0]); list.value = arguments[1];"
            "list.dispatchEvent(new Event('change', {bubbles: true}))", selector, value,
        )  # fmt: skip

    def press(self, *keys, hold=()):
        """Press keys one after the other while others are held."""
        held = [KEYS.get(key, key) for key in hold]
        steps = [{"type": "keyDown", "value": key} for key in held]
        for key in keys:
            steps += [{"type": kind, "value": KEYS.get(key, key)} for kind in ("keyDown", "keyUp")]
        steps += [{"type": "keyUp", "value": key} for key in held]
        self.ask("POST", "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": steps}]})

    def drag(self, selector, share, *, steps=10):
        """Drag the thumb of a slider to a share of its length, in small steps."""
        element = self.find(selector)
        self.run("arguments[0].scrollIntoView({block: 'center'})", {_ELEMENT: element})
        box = self.run(
            "const box = arguments[0].getBoundingClientRect(), one = arguments[0];"
            "return [box.left, box.top, box.width, box.height, (one.value - one.min) / (one.max - one.min)]",
            {_ELEMENT: element},
        )
        left, top, width, height, now = box
        places = [left + 8 + (width - 16) * (now + (share - now) * i / steps) for i in range(steps + 1)]
        moves = [
            {"type": "pointerMove", "duration": 30, "x": round(x), "y": round(top + height / 2), "origin": "viewport"}
            for x in places
        ]
        actions = [moves[0], {"type": "pointerDown", "button": 0}, *moves[1:], {"type": "pointerUp", "button": 0}]
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}
        self.ask("POST", "/actions", {"actions": [pointer]})

    def text(self, selector):
        """Return the text that is to be seen of an element."""
        return self.ask("GET", f"/element/{self.find(selector)}/text")

    def new_window(self, url):
        """Open a page in another window, and look at it; return the name of the first."""
        first = self.ask("GET", "/window")
        self.look_at(self.ask("POST", "/window/new", {"type": "window"})["handle"])
        self.open(url)
        return first

    def look_at(self, window):
        """Go to a window."""
        self.ask("POST", "/window", {"handle": window})

    def complaints(self):
        """Return what the page's console has to complain of since it was asked last."""
        lines = self.ask("POST", "/se/log", {"type": "browser"})
        return [line["message"] for line in lines if line["level"] in ("SEVERE", "WARNING")]

    def picture(self, path, *, whole=False):
        """Write a picture of the view, or of the whole page."""
        taken = self.devtools("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": whole} | (
            {"clip": self.run(
                "const root = document.documentElement;"
                "return {x: 0, y: 0, width: root.clientWidth, height: root.scrollHeight, scale: 1}")}
            if whole else {}))  # fmt: skip
        path.write_bytes(base64.b64decode(taken["data"]))


def _ask(method, url, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=60) as response:
            return json.load(response)["value"]
    except urllib.error.HTTPError as error:
        raise AssertionError(json.load(error)["value"]["message"]) from None


@contextmanager
def browsing(folder, *, dark=False):
    """Give a browser with a profile of its own; skip where there is none."""
    if CHROMIUM is None or DRIVER is None:
        pytest.skip("chromium or its driver is not installed: the page is checked by its server's answers only")
    driver = subprocess.Popen([DRIVER, "--port=0"], stdout=subprocess.PIPE, text=True)
    try:
        port = next(found[1] for line in driver.stdout if (found := re.search(r"successfully on port (\d+)", line)))
        address = f"http://127.0.0.1:{port}"
        scheme = f"--blink-settings=preferredColorScheme={0 if dark else 1}"
        options = {"binary": CHROMIUM, "args": [*OPTIONS[:-1], f"--user-data-dir={folder / 'profile'}", scheme]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        session = _ask("POST", f"{address}/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        try:
            yield Browser(address, session)
        finally:
            _ask("DELETE", f"{address}/session/{session}")
    finally:
        driver.terminate()
        driver.wait(10)
        driver.stdout.close()


def beyond(page):
    """Return what reaches beyond the right edge, beside what scrolls within a part of the page."""
    return page.run(
        "return [...document.querySelectorAll('body *')].filter(one => !one.closest('svg, #charts, optgroup')"
        " && one.getBoundingClientRect().right > document.documentElement.clientWidth + 1)"
        ".map(one => one.tagName + ' ' + one.id + ' ' + one.textContent.slice(0, 30))"
    )

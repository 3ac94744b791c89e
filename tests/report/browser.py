"""Headless Chromium: what a page looks like there, measured by a script in a page around it."""

import json
import re
import shutil
import subprocess
from html import unescape

import pytest

CHROMIUM = shutil.which("chromium")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-logging=stderr",
)  # fmt: skip

# each page stands in a frame of a given width; frames are of one origin, so the script may look into them
_MEASURE = """
<!DOCTYPE html><meta charset="utf-8"><pre id="found"></pre>
<script>
const found = [];
const visible = box => box.width > 1 && box.height > 1;
function measured(name, width, inner) {
  const root = inner.documentElement, view = inner.defaultView;
  inner.querySelectorAll("details").forEach(one => { one.open = true; });
  const boxes = selector => [...inner.querySelectorAll(selector)].map(one => one.getBoundingClientRect());
  const svgs = [...inner.querySelectorAll("svg")].map(svg => ({
    size: [svg.getBoundingClientRect().width, svg.getBoundingClientRect().height],
    shapes: [...svg.querySelectorAll("path, use")].filter(one => {
      const box = one.getBoundingClientRect(); return box.width + box.height > 1; }).length,
    text: [...svg.querySelectorAll("text")].map(one => parseFloat(view.getComputedStyle(one).fontSize)
      * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width),
    spill: Math.max(...[...svg.querySelectorAll("text")].map(one => one.getBoundingClientRect().right)) - width,
  }));
  const beyond = [...inner.querySelectorAll("body *")].filter(one => !one.closest("svg") && !one.closest("thead")
    && one.getBoundingClientRect().right > width + 1).map(one => one.tagName + " " + one.textContent.slice(0, 40));
  const style = view.getComputedStyle(inner.body);
  return {name, width: view.innerWidth, dark: view.matchMedia("(prefers-color-scheme: dark)").matches,
    scroll: root.scrollWidth, svgs, beyond, cells: boxes("td:not(.empty), tbody th").map(visible),
    colour: style.color, paper: style.backgroundColor};
}
function shown(name, width, html) {
  return new Promise(done => {
    const frame = document.createElement("iframe");
    frame.style = `width: ${width}px; height: 800px; border: 0`;
    frame.onload = () => { found.push(measured(name, width, frame.contentDocument)); frame.remove(); done(); };
    frame.srcdoc = html;
    document.body.append(frame);
  });
}
(async () => {
  for (const [name, html] of Object.entries(PAGES)) for (const width of WIDTHS) await shown(name, width, html);
  document.getElementById("found").textContent = JSON.stringify(found);
})();
</script>
"""


def chromium(folder, *arguments):
    """Run Chromium with a profile of its own, and return what it printed; skip where there is none."""
    if CHROMIUM is None:
        pytest.skip("chromium is not installed: the reports are checked for their structure only")
    command = [CHROMIUM, *OPTIONS, f"--user-data-dir={folder / 'profile'}", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=120)


def measure(folder, pages, widths, *, dark):
    """Return measurements of every page at every width, and what Chromium had to complain of."""
    held = json.dumps(pages).replace("</", "<\\/")
    file = folder / "around.html"
    file.write_text(_MEASURE.replace("PAGES", held, 1).replace("WIDTHS", json.dumps(widths), 1), encoding="utf-8")
    scheme = f"--blink-settings=preferredColorScheme={0 if dark else 1}"
    done = chromium(folder, scheme, "--virtual-time-budget=30000", "--dump-dom", file.as_uri())
    found = re.search(r'<pre id="found">(.*?)</pre>', done.stdout, re.DOTALL)[1]
    return json.loads(unescape(found)), [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def sheets(folder, html):
    """Return how many sheets of paper a page takes."""
    (folder / "page.html").write_text(html, encoding="utf-8")
    chromium(folder, f"--print-to-pdf={folder / 'page.pdf'}", (folder / "page.html").as_uri())
    return len(re.findall(rb"/Type\s*/Page\b(?!s)", (folder / "page.pdf").read_bytes()))

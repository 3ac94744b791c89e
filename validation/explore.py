"""How long curves take to follow a slider of `multilayer explore`: in the server's answers, and in Chromium.

``python -m validation.explore > docs/validation/explore.md``. The browser and its driver are Debian's packages chromium
and chromium-driver; without them, only the answers are timed. ``python -m validation.explore --pictures docs/images``
draws the pages that the manual shows.
"""

from __future__ import annotations

import http.client
import json
import os
import sys
import tempfile
import time
from argparse import ArgumentParser
from pathlib import Path

import numpy as np

from multilayer.config.yaml12 import dump_yaml
from multilayer.explore.explorer import Explorer
from multilayer.explore.model import ModelExplorer
from multilayer.fits.sources import open_source
from tests.explore.command import serving
from tests.explore.webdriver import CHROMIUM, DRIVER, browsing

EXAMPLES = Path("examples")
FOAM = {"material": "AA2009/T11.6/foam", "thickness": "40 mm"}
BOARD = {"material": "Bauakustik/T4.2.4-1/gypsum_board", "thickness": "12.5 mm"}
AIR = {"type": "fluid", "thickness": "30 mm"}
STEEL = {
    "type": "elastic_solid",
    "thickness": "1 mm",
    "density": 7850,
    "young_modulus": "210 GPa",
    "poisson_ratio": 0.3,
}
WOOD = {
    "type": "orthotropic_plate", "thickness": "19 mm", "density": 700, "young_modulus_x": "11 GPa",
    "young_modulus_y": "0.5 GPa", "poisson_ratio_xy": 0.4, "shear_modulus_xy": "0.7 GPa", "loss_factor": 0.02,
}  # fmt: skip
DESIGNS = {
    "foam on a wall": ([FOAM], "rigid"),
    "steel, foam, steel (three layers)": ([STEEL, FOAM, STEEL], "ambient"),
    "boards, foam, air, septum (five layers)": (
        [BOARD, FOAM, AIR, {"type": "membrane", "surface_density": 0.5}, BOARD],
        "ambient",
    ),
    "wood, not isotropic, before foam": ([WOOD, FOAM], "ambient"),
}
INCIDENCES = {"normal": "normal", "oblique, 45°": 45, "diffuse, to 78°": "diffuse"}
MOVES = 12
_TEXT = """\
# Curves that follow a slider

`python -m validation.explore`: how long a move of a slider of `multilayer explore` takes, at 200 frequencies:

- processor: what the computation takes of one core;
- answer: from the question to its answer, over HTTP;
- curves: from a key on the slider to curves that are drawn, in headless Chromium without a graphics card. Where all
  frequencies take longer than 60 ms, the page asks for fewer of them while a slider moves.

Medians of {moves} moves, with the 95 % percentile in brackets.{state}
"""
DRAWN = "return Number(document.body.dataset.latency)"


def answered(server, data) -> tuple[list[float], list[float]]:
    """Return the times of answers to a moved slider, ms, and of the processor within them."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port)
    times, of_processor = [], []
    for i in range(MOVES + 3):
        data["layers"][0]["thickness"] = f"{10 + 0.7 * i:.4g} mm"
        body = json.dumps({"data": data, "moving": True})
        begun, processor = time.perf_counter(), time.process_time()
        connection.request("POST", f"/{server.token}/evaluate", body, {"Content-Type": "application/json"})
        answer = json.loads(connection.getresponse().read())
        times.append(1e3 * (time.perf_counter() - begun))
        of_processor.append(1e3 * (time.process_time() - processor))
        assert not answer["problems"], answer["problems"]
    connection.close()
    return times[3:], of_processor[3:]  # the first ones load what is needed


def drawn(browser, url) -> list[float]:
    """Return the times from moves of a slider to curves that are drawn, ms, as the page tells them."""
    browser.open(url)
    slider = "at-layers-0-thickness-slider"
    browser.run("document.getElementById(arguments[0]).focus()", slider)
    times = []
    for _ in range(MOVES + 3):
        browser.run("document.body.dataset.latency = 0")
        browser.press("Right")
        browser.wait("return Number(document.body.dataset.latency) > 0", seconds=60)
        times.append(browser.run(DRAWN))
    return times[3:]


def row(name, incidence, *columns) -> str:
    """Return a row of the table."""
    cells = [f"{np.median(times):.0f} ({np.percentile(times, 95):.0f})" if times else "–" for times in columns]
    return f"| {name} | {incidence} | {' | '.join(cells)} |"


def rows(browser, *, busy) -> list[str]:
    """Return the rows of all designs."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "design.yaml"
        for name, (layers, termination) in DESIGNS.items():
            for title, incidence in INCIDENCES.items():
                data = {"version": 1, "layers": layers, "termination": termination, "incidence": incidence}
                file.write_text(dump_yaml(data), encoding="utf-8")
                with serving(Explorer(file)) as server:
                    answers, processor = answered(server, json.loads(json.dumps(data)))
                    curves = drawn(browser, server.url) if browser else []
                    found.append(row(name, title, processor, [] if busy else answers, curves))
    return found


def pictures(folder: Path) -> None:
    """Draw the pages of a stack and of a campaign with the effect that it lacks, fitted."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as profile, browsing(Path(profile)) as browser:
        with serving(Explorer(EXAMPLES / "double_wall.yaml")) as server:
            browser.open(server.url, height=800)
            browser.picture(folder / "explore_stack.png")
        with serving(ModelExplorer(open_source(EXAMPLES / "foam_b"))) as server:
            browser.open(server.url, height=800)
            browser.click("#effect-finite_size")
            browser.wait("return document.querySelector('#at-finite_size-poisson_error').value !== ''", seconds=120)
            browser.click("#fit")
            browser.wait("return document.querySelector('#status').textContent.startsWith('Fitted')", seconds=120)
            browser.picture(folder / "explore_model.png")


def main() -> None:
    """Print the page, or draw pictures."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="draw the pages that the manual shows")
    folder = parser.parse_args().pictures
    if folder is not None:
        pictures(folder)
        return
    load, cores = os.getloadavg()[0], os.cpu_count() or 1
    busy = load > cores / 2
    state = f" The machine has {cores} cores, and nothing else ran."
    if busy:
        state = (
            f"\n\nWhile this was measured, others wanted the machine's {cores} cores (load average {load:.0f}). Times "
            "by the clock would tell of\nthem, and are left out; those of the processor are longer than on a quiet "
            "machine, too."
        )
    if CHROMIUM and DRIVER and not busy:
        with tempfile.TemporaryDirectory() as folder, browsing(Path(folder)) as browser:
            table = rows(browser, busy=busy)
    else:
        table = rows(None, busy=busy)
    headings = ["| design | sound | processor / ms | answer / ms | curves / ms |", "|---|---|---|---|---|"]
    sys.stdout.write("\n".join([_TEXT.format(moves=MOVES, state=state), *headings, *table, ""]))


if __name__ == "__main__":
    main()

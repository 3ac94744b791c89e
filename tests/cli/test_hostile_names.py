"""Every door with names that act on who reads them: terminals, pages, figures, tables, files, messages."""

import csv
import io
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import multilayer
from multilayer import load_stack
from multilayer.cli.progress import progress_bar
from multilayer.csv_table import csv_table
from multilayer.doors import for_log, from_cell, guarded_streams
from multilayer.explore.explorer import Explorer
from multilayer.materials import load_library
from multilayer.measurements.readers import read_spectra
from multilayer.response import plane_wave
from tests.cli import test_diagnose_levels
from tests.cli.campaigns import with_configurations, write_campaign
from tests.cli.command import run_to_the_letter as run
from tests.cli.hostile_names import FILE_NAMES, NAMES
from tests.cli.test_fit import keep_bursts
from tests.cli.test_tube import TWO, write_table
from tests.fits import stack_fits
from tests.recorders import write_csv, write_h5, write_mat, write_tdms, write_uff
from tests.report.browser import measure

CONTROLS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u202a-\u202e\u2066-\u2069\u2028\u2029\ud800-\udfff]")
BY_RICH = re.compile(r"\x1b\[[\d;]*m|\r?\x1b\[(\d*[AK]|\?25[lh])")
FORMULA = re.compile(r"\s*[=+\-@]")
NAMED = pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
FILES = pytest.mark.parametrize("name", FILE_NAMES.values(), ids=FILE_NAMES)
FLUID = "type: fluid, thickness: 50 mm, density: 2, sound_speed: 300"


def harmless(done):
    """Hold what a command printed to what a terminal may be given, and return it."""
    text = done.out + done.err
    assert not CONTROLS.search(text), ascii(text)
    assert not re.search("Traceback|This is a bug", text), text
    assert done.status in (0, 1, 2)
    return done


def refused(done):
    """Hold a command to a message of reasonable length, and return it."""
    assert harmless(done).status == 2
    assert 0 < len(done.err) < 8000
    return done.err


class Page(HTMLParser):
    """Tags and texts of a page."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.texts, self.attributes = [], [], set()
        self.feed(html)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attributes}

    def handle_data(self, data):
        self.texts.append(data)


def page_of(folder, name="report.html"):
    """Hold a page to its markup, and return it."""
    html = (folder / name).read_text(encoding="utf-8")
    assert not CONTROLS.search(html)
    page = Page(html)
    assert not {"script", "img", "b", "a", "link"} & set(page.tags)
    assert not {"onload", "onerror", "style"} & page.attributes
    policy = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', html)[1]
    assert policy.startswith("default-src 'none'; style-src 'sha256-")
    assert "unsafe" not in policy
    drawn = re.findall(r"<svg.*?</svg>", html, re.DOTALL)
    assert drawn
    for svg in drawn:
        ElementTree.fromstring(svg)
    assert len(drawn) == page.tags.count("figure")
    return page


def cells_of(folder, name):
    """Hold a table to cells that no spreadsheet computes, and return its rows."""
    text = (folder / name).read_text(encoding="utf-8")
    assert not CONTROLS.search(text)
    header, *rows = csv.reader(io.StringIO(text, newline=""))
    for cell in [*header, *(cell for row in rows for cell in row)]:
        if FORMULA.match(cell):
            float(cell)
            assert cell[0] == "-"
    assert {len(row) for row in rows} == {len(header)}
    return header, rows


def simulation(folder, name, file="foam.yaml"):
    (folder / file).write_text(f"""\
version: 1
layers: [{{{FLUID}, name: {json.dumps(name)}}}]
termination: rigid
frequency: {{from: 200, to: 400, points: 3}}
sweep: {{layers.0.name: [plain, {json.dumps(name)}]}}
""")
    return folder / file


def shapes(page):
    return {tag: page.tags.count(tag) for tag in ("svg", "figure", "td", "section")}


@pytest.fixture(scope="module")
def plain_page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    assert run("simulate", simulation(folder, "foam"), "--out", folder / "out").status == 0
    return shapes(page_of(folder / "out"))


@pytest.mark.parametrize(
    "what",
    [
        "clear screen", "NUL", "return", "lines", "separator", "right to left", "no character", "script", "quotes",
        "formula", "minus", "semicolon", "mathematics", "long",
    ],
)  # fmt: skip
def test_layers_and_swept_text_in_simulate(what, tmp_path, plain_page):
    name = NAMES[what]
    done = harmless(run("simulate", simulation(tmp_path, name), "--out", tmp_path / "out"))
    assert done.status == 0, done
    assert shapes(page_of(tmp_path / "out")) == plain_page
    cells_of(tmp_path / "out", "simulation.csv")
    record = json.loads((tmp_path / "out" / "simulation.json").read_text())
    assert record["settings"]["layers"][0]["name"] == name
    assert name in record["cases"][1]["values"].values()


@pytest.mark.parametrize(
    "what", ["clear screen", "return", "lines", "tab", "right to left", "surrogate", "formula", "mathematics", "long"]
)
def test_files_and_folders_in_simulate(what, tmp_path, plain_page):
    name = FILE_NAMES.get(what, "_" * 200)
    folder = tmp_path / name
    folder.mkdir()
    file = simulation(folder, "foam", f"{name}.yaml")
    assert harmless(run("simulate", file, "--out", folder / "out")).status == 0
    assert shapes(page_of(folder / "out")) == plain_page


@FILES
def test_files_of_tubes_and_plugins(name, tmp_path):
    folder = tmp_path / name
    folder.mkdir()
    f = np.linspace(300, 1500, 20)
    write_table(folder / f"{name}.csv", f, transfer_function=np.exp(-1j * f / 1000))
    measurement = TWO.replace("h12.csv", json.dumps(f"{name}.csv")) if name.isprintable() else TWO
    (folder / "tube.yaml").write_text(measurement)
    harmless(run("tube", folder, "--out", folder / "out", "--no-figures"))
    refused(run("tube", folder / name))
    (folder / f"{name}.py").write_text("x = 1\n")
    assert "registers nothing" in refused(run("--plugin", folder / f"{name}.py", "layers"))
    refused(run("check", folder / f"{name}.txt"))


@NAMED
def test_mistakes_quote_names(name, tmp_path):
    quoted = json.dumps(name)
    fields = f"{{? {quoted}\n : 3, {FLUID}}}"
    for text in (
        f"layers:\n- {fields}\ntermination: rigid\n? {quoted}\n: 1\n",
        f"layers: [{{type: {quoted}}}]\ntermination: {quoted}\n",
        f"layers: [{{{FLUID.replace('50 mm', json.dumps(f'1 {name}'))}}}]\ntermination: rigid\n",
        f"layers: [{{material: {quoted}, thickness: 1 mm}}]\ntermination: rigid\n",
        f"layers: [{{{FLUID}}}]\ntermination: rigid\nsweep: {{? {quoted}\n : [1]}}\n",
    ):
        (tmp_path / "bad.yaml").write_text(f"kind: simulation\nversion: 1\n{text}")
        refused(run("check", tmp_path / "bad.yaml"))


@NAMED
def test_arguments(name, tmp_path):
    good = simulation(tmp_path, "foam")
    for arguments in (
        (name,), ("simulate", f"--{name}"), ("simulate", f"./{name}"), ("--plugin", f"./{name}", "layers"),
        ("layers", f"x{name}"),
        ("import", "x.wav", "--rate", f"1{name}Hz", "--out", tmp_path / "c"), ("simulate", good, "--jobs", f"x{name}"),
        ("compare", good, tmp_path / "x.csv", "--quantity", f"x{name}"), ("tube", f"./{name}"),
    ):  # fmt: skip
        refused(run(*arguments))


@NAMED
def test_materials(name, tmp_path):
    file = tmp_path / "library.yaml"
    quoted = json.dumps(name)
    file.write_text(f"version: 1\nmaterials:\n  ? {quoted}\n  : {{source: {quoted}, {FLUID}}}\n")
    for arguments in ((), ("--", name)):
        done = harmless(run("materials", "--library", file, *arguments))
        assert (done.status, len(done.out) < 3000) == (0, True)
        (found,) = json.loads(run("materials", "--library", file, "--json", *arguments).out)
        assert (found["name"], found["source"]) == (name, name)
    refused(run("materials", "zzz", "--library", file))


WRITERS = {"mat": write_mat, "h5": write_h5, "tdms": write_tdms, "csv": write_csv, "uff": write_uff}


@NAMED
def test_channels_and_units_in_import(name, tmp_path):
    signal = np.sin(np.arange(200.0))
    for suffix, write in WRITERS.items():
        file = tmp_path / f"run.{suffix}"
        try:
            write(file, {name[:60]: signal, "b": signal}, 12800.0, {name[:60]: name[:20], "b": "V"})
        except (ValueError, KeyError, NotImplementedError, Warning):
            continue  # this format holds no such name
        refused(run("import", file, "--out", tmp_path / "c"))
        refused(run("import", file, "--out", tmp_path / "c", "--base", name, "--top", "b"))


@NAMED
def test_what_is_no_data_is_quoted_harmlessly(name, tmp_path):
    good = simulation(tmp_path, "foam")
    for suffix in ("csv", "wav", "npz", "mat", "uff"):
        file = tmp_path / f"junk.{suffix}"
        file.write_bytes(f"{name},frequency_hz,absorption\n{name},{name},2\n".encode())
        refused(run("import", file, "--out", tmp_path / "c", "--base", "a", "--top", "b"))
    harmless(run("compare", good, tmp_path / "junk.csv", "--out", tmp_path / "out"))


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """Give a fit of a campaign in a folder with a hostile name, with configurations that have all the others."""
    folder = write_campaign(tmp_path_factory.mktemp("hostile") / FILE_NAMES["formula"])
    keep_bursts(folder, 400)
    with_configurations(folder, [json.dumps(name) for name in NAMES.values()], 400)
    return run("fit", folder, "--out", folder / "out"), folder / "out"


def test_configurations_and_campaign_in_fit(fitted):
    done, folder = fitted
    assert harmless(done).status == 0, done
    page = page_of(folder)
    _, rows = cells_of(folder, "moduli.csv")
    assert len(rows) == len(NAMES)
    written = (folder / "fit.json").read_text()
    assert {burst["configuration"] for burst in json.loads(written)["bursts"]} == {*NAMES.values()}
    assert all(path.parent == folder for path in folder.rglob("*"))
    assert page.tags.count("svg") >= 3


@pytest.mark.parametrize("what", ["formula", "surrogate"])
def test_folders_of_campaigns_in_fit(what, tmp_path):
    names = [FILE_NAMES[what], "foam"]
    folders = [write_campaign(tmp_path / name) for name in names]
    for folder in folders:
        keep_bursts(folder, 400)
    assert harmless(run("fit", *folders, "--out", tmp_path / "out")).status == 0
    pages = [page_of(tmp_path / "out" / name) for name in names]
    assert shapes(pages[0]) == shapes(pages[1])
    cells_of(tmp_path / "out", "summary.csv")
    assert harmless(run("fit", *folders, "--out", tmp_path / "out", "--resume", "--no-figures")).status == 0
    cells_of(tmp_path / "out", "summary.csv")


@pytest.mark.parametrize("what", ["clear screen", "script", "formula", "minus", "mathematics", "lines", "long"])
def test_layers_and_measurements_in_stack_fit(what, tmp_path):
    name = NAMES[what]
    stack = stack_fits.stack({**stack_fits.WOOL, "name": name})
    reflection = plane_wave(stack, stack_fits.F).reflection
    table = stack_fits.parts("frequency_hz,reflection_re,reflection_im", stack_fits.F, reflection)
    measured = {"kind": "reflection", "name": name, "file": "tube.csv", "noise": {"absolute": 0.01}}
    prior = {f"layers.{name}.flow_resistivity": {"lognormal": ["10 kN s/m^4", 0.5]}}
    file = stack_fits.write(tmp_path, stack, {"tube.csv": table}, [measured], prior)
    assert harmless(run("fit", file, "--out", tmp_path / "out")).status == 0
    page_of(tmp_path / "out")
    cells_of(tmp_path / "out", "parameters.csv")
    _, rows = cells_of(tmp_path / "out", "curves.csv")
    assert from_cell(rows[0][0]) == for_log(name)


@pytest.mark.parametrize("what", ["formula", "at", "quotes", "minus", "comment"])
def test_tables_of_ours_are_read_back(what, tmp_path):
    """A measurement chooses rows of a table by a name that stands there as `for_cell` writes it."""
    name = NAMES[what]
    stack = stack_fits.stack(stack_fits.WOOL)
    absorption = plane_wave(stack, stack_fits.F).absorption
    rows = [[name, f, a] for f, a in zip(stack_fits.F.tolist(), absorption.tolist(), strict=True)]
    measured = {"kind": "absorption", "file": "all.csv", "noise": {"absolute": 0.01}, "rows": {"case": name}}
    prior = {"layers.wool.flow_resistivity": {"lognormal": ["10 kN s/m^4", 0.5]}}
    text = csv_table(["case", "frequency_hz", "absorption"], [*rows, ["other", 100.0, 0.5]])
    file = stack_fits.write(tmp_path, stack, {"all.csv": text}, [measured], prior)
    assert harmless(run("fit", file, "--out", tmp_path / "out", "--no-figures")).status == 0


def test_a_forced_terminal_has_colours_of_ours_only(tmp_path):
    names = json.dumps("".join(NAMES[what] for what in ("red", "link", "title", "markup")))
    (tmp_path / "library.yaml").write_text(f"version: 1\nmaterials: {{? {names}\n : {{source: {names}, {FLUID}}}}}\n")
    done = run("materials", "--library", tmp_path / "library.yaml", FORCE_COLOR="1")
    assert not CONTROLS.search(BY_RICH.sub("", done.out))
    assert "\x1b[31m" not in done.out
    assert "\x1b]" not in done.out
    assert "[red]x[/red]" in re.sub(r"\s", "", BY_RICH.sub("", done.out))


def test_progress_bars_show_names_to_the_letter(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "200")
    with guarded_streams(), progress_bar("a\x1b[2J[red]", 3) as advance:
        advance("[/nothing]\x1b]0;title\x07")
    text = capsys.readouterr().err
    assert not CONTROLS.search(BY_RICH.sub("", text))
    assert "a\\x1b[2J[red]" in text


def test_plugins_that_are_broken(tmp_path):
    says = NAMES["clear screen"] + NAMES["link"] + NAMES["markup"]
    info = tmp_path / "house-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: house\x1b[2J\nVersion: 1\x1b]0;x\x07\n")
    (info / "entry_points.txt").write_text("[multilayer.layers]\nbad\x1b[31m = house_of_names:Layer\n")
    (tmp_path / "house_of_names.py").write_text(f"raise RuntimeError({says!r})\n")
    path = os.pathsep.join([str(tmp_path), str(Path(multilayer.__file__).parents[1])])
    for colour in ({}, {"FORCE_COLOR": "1", "COLUMNS": "500"}):
        command = [sys.executable, "-m", "multilayer", "plugins"]
        done = subprocess.run(
            command, env={**os.environ, "PYTHONPATH": path, **colour}, capture_output=True, text=True, check=True
        )
        text = BY_RICH.sub("", done.stdout + done.stderr)
        assert "RuntimeError" in text
        assert not CONTROLS.search(text)
        assert "[red]x[/red]" in re.sub(r"\s", "", text)


def test_a_traceback_for_who_wants_it(monkeypatch, tmp_path):
    def fail(*arguments):
        raise RuntimeError(NAMES["clear screen"] + NAMES["title"])

    monkeypatch.setattr("multilayer.fits.run.open_source", fail)
    done = run("fit", "anything", MULTILAYER_DEBUG="1")
    assert done.status == 1
    assert "Traceback" in done.err
    assert not CONTROLS.search(done.err)
    assert r"RuntimeError: a\x1b[2Jb" in done.err


def test_a_page_with_all_names_in_a_browser(tmp_path):
    names = [name for what, name in NAMES.items() if what != "long"]
    file = simulation(tmp_path, "foam")
    text = file.read_text().partition("sweep:")[0]
    file.write_text(f"{text}sweep: {{layers.0.name: [{', '.join(map(json.dumps, names))}]}}\n")
    assert harmless(run("simulate", file, "--out", tmp_path / "out")).status == 0
    html = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    (seen,), complaints = measure(tmp_path, {"names": html}, [1280], dark=False)
    assert complaints == []
    assert seen["svgs"]
    assert all(svg["shapes"] > 5 for svg in seen["svgs"])
    assert all(seen["cells"])


def test_log_and_json_of_check(tmp_path):
    name = NAMES["clear screen"] + NAMES["DEL"]
    file = simulation(tmp_path, name)
    assert harmless(run("simulate", file, "--out", tmp_path / "out", "--verbose", "--no-figures")).status == 0
    file.write_text(file.read_text().replace("type: fluid", f"? {json.dumps(name)}\n : 1, type: fluid"))
    done = run("check", file, "--json")
    assert not CONTROLS.search(done.out)
    (checked,) = json.loads(done.out)
    assert checked["problems"][0]["path"] == f"layers.0.{name}"


FOAM = (
    "type: poroelastic, model: jca, thickness: 50 mm, porosity: 0.98, flow_resistivity: 15000, tortuosity: 1.05, "
    "viscous_length: 100 um, thermal_length: 250 um, frame_density: 30, young_modulus: 100 kPa, poisson_ratio: 0.3"
)
BOARD = (
    "type: elastic_plate, thickness: 12.5 mm, density: 700, young_modulus: 3e9, poisson_ratio: 0.2, loss_factor: 0.05"
)
DOORS = pytest.mark.parametrize("what", ["clear screen", "lines", "script", "formula", "mathematics", "separator"])


def lines_of(file):
    """Hold a text for other programs to lines that are those of `multilayer` alone, and return them."""
    text = file.read_text(encoding="utf-8")
    assert not CONTROLS.search(text), ascii(text)
    return text.splitlines()


@FILES
def test_tables_and_cards_of_export(name, tmp_path):
    folder = tmp_path / name
    folder.mkdir()
    file = folder / f"{name}.yaml"
    layer = json.dumps(name if name.isprintable() else "foam")
    file.write_text(f"version: 1\nlayers: [{{{FOAM}, name: {layer}}}]\ntermination: rigid\nfrequency: [200, 400]\n")
    for suffix in ("csv", "mat", "h5", "uff"):
        pytest.importorskip({"h5": "h5py", "uff": "pyuff"}.get(suffix, "numpy"))
        out = folder / f"{name}.{suffix}"
        assert harmless(run("export", file, "--as", "surface_impedance", "--out", out)).status == 0
        assert read_spectra(out).rows
    cards = ("--as", "nastran", "--frame-density", "bulk", "--out", folder / f"{name}.bdf")
    assert harmless(run("export", file, *cards)).status == 0
    for line in lines_of(folder / f"{name}.csv"):
        assert line[0] == "#" or not FORMULA.match(line)
    for deck in (folder / f"{name}.bdf", folder / f"{name}.uff"):
        assert all(line.isascii() and len(line) <= 80 for line in lines_of(deck))
    assert {line.split("*")[0] for line in lines_of(folder / f"{name}.bdf") if line[0] not in "$*"} == {
        "MATPE1", "MAT1", "MAT10",
    }  # fmt: skip


@NAMED
def test_tables_of_materials(name, tmp_path):
    table, library = tmp_path / "foams.csv", tmp_path / "ours.yaml"
    cell = '"' + name.replace('"', '""') + '"'
    table.write_text(f"name,sigma [N s/m4],phi,{cell}\n{cell},1e4,0.9,1\n", encoding="utf-8")
    done = harmless(run("materials", "--from", table, "--out", library))
    if done.status == 0:
        (written,) = load_library(library)
        assert written in (name, name.strip())
        assert len(done.out) < 3000
    else:
        assert not library.exists()


@DOORS
def test_layers_and_materials_in_optimise(what, tmp_path):
    name, path = json.dumps(NAMES[what]), json.dumps(f"layers.{NAMES[what]}.thickness")
    (tmp_path / "best.yaml").write_text(
        f"kind: optimisation\nversion: 1\nlayers: [{{{FOAM}, name: {name}}}, {{{FLUID}, name: gap}}]\n"
        f"termination: rigid\nfrequency: [300, 600]\ndesign:\n  ? {path}\n  : [10 mm, 30 mm]\n  optional: [{name}]\n"
        f"goal: [{{highest: absorption}}, {{lowest: price}}]\ncatalogue: {{? {name}\n : {{price_per_volume: 2}}}}\n"
        "search: {starts: 1}\n"
    )
    out = tmp_path / "out"
    assert harmless(run("optimise", tmp_path / "best.yaml", "--out", out)).status == 0
    page_of(out)
    for table in ("designs.csv", "curves.csv"):
        cells_of(out, table)
    assert all(path.parent == out for path in out.rglob("*"))
    assert any(layer.name == NAMES[what] for layer in load_stack(out / "design-1.yaml").layers)


@DOORS
def test_walls_links_and_what_is_beside_them(what, tmp_path):
    name = json.dumps(NAMES[what])
    other = json.dumps(f"{NAMES[what]}!")
    paths = [json.dumps(path) for path in (f"links.{NAMES[what]}!.spacing", f"beside.{NAMES[what]}.width")]
    (tmp_path / "wall.yaml").write_text(
        f"version: 1\nlayers: [{{{BOARD}, name: {name}}}, {{{FLUID}}}, {{{BOARD}, name: back}}]\ntermination: ambient\n"
        f"links: [{{name: {other}, kind: point, between: [{name}, back], spacing: 0.6}}]\narea: 10\n"
        f"beside: [{{type: slit, name: {name}, width: 1e-3, length: 1, depth: 0.1}}]\nfrequency: [500, 1000]\n"
        f"sweep:\n  ? {paths[0]}\n  : [0.4, 0.6]\n  ? {paths[1]}\n  : [1e-3, 2e-3]\n"
    )
    out = tmp_path / "out"
    assert harmless(run("simulate", tmp_path / "wall.yaml", "--out", out)).status == 0
    page_of(out)
    cells_of(out, "simulation.csv")


@pytest.mark.parametrize("what", ["clear screen", "script", "formula"])
def test_stacks_and_measurements_in_diagnoses_of_levels(what, tmp_path):
    name = json.dumps(NAMES[what])
    text = test_diagnose_levels.FILE.replace("nominal: wall.yaml", f"stacks: {{? {name}\n : wall.yaml}}")
    text = text.replace("- {", f"- {{name: {name}, stack: {name}, ")
    text = text.replace("layers.board.density", f"? {json.dumps(f'{NAMES[what]}.layers.board.density')}\n  ")
    file = test_diagnose_levels.write(tmp_path / "wall", text)
    out = tmp_path / "out"
    assert harmless(run("diagnose", file, "--out", out)).status == 0
    page_of(out)
    for table in out.glob("*.csv"):
        cells_of(out, table.name)
    assert all(path.parent == out for path in out.rglob("*"))


@FILES
def test_what_the_page_of_explore_is_told_and_saves(name, tmp_path):
    file = simulation(tmp_path, "foam", f"{name}.yaml")
    explorer = Explorer(file)
    began = explorer.answer("start", {})
    assert not CONTROLS.search(began["file"])
    data = {**began["data"], "layers": [{**began["data"]["layers"][0], "name": name, "type": name, name: 1}]}
    for question in (
        {"data": data, "describe": True}, {"data": data, "name": f"{name}.yml/", "kind": name},
        {"data": data, "edit": {"do": name}}, {"data": data, "edit": {"do": "add", "at": 0, "material": name}},
    ):  # fmt: skip
        for asked in ("evaluate", "edit", "save"):
            texts = [problem["text"] for problem in explorer.answer(asked, question)["problems"]]
            assert texts or asked == "edit"
            assert not CONTROLS.search("".join(texts))
    wanted = {"data": began["data"], "name": "saved.yaml", "kind": "stack"}
    assert explorer.answer("save", wanted)["problems"] == []
    first, second, *_ = lines_of(tmp_path / "saved.yaml")
    assert first.startswith("# Made by")
    assert second == "kind: stack"

"""``multilayer optimise`` as a user types it."""

import csv
import json

import pytest

from tests.cli.command import python, result_names, run

FILE = """\
kind: optimisation
version: 1
layers:
  - {type: screen, name: cloth, flow_resistance: 2000}
  - {type: fluid, name: gap, thickness: 50 mm}
termination: rigid
frequency: [250 Hz, 500 Hz, 1 kHz]
design:
  layers.cloth.flow_resistance: [50, 5000]
  layers.gap.thickness: [2 cm, 30 cm]
goal: {highest: absorption, from: 500 Hz, to: 500 Hz}
search: {starts: 3}
"""


@pytest.fixture
def file(tmp_path):
    (tmp_path / "design.yaml").write_text(FILE)
    return tmp_path / "design.yaml"


def changed(file, *pairs):
    text = file.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)
    return file


def refused(file, folder):
    """Return the lines of a refusal, which writes nothing."""
    done = run("optimise", file, "--out", folder)
    assert (done.status, done.out) == (2, "")
    assert not folder.exists()
    return done.err.splitlines()


def test_what_it_writes(file, tmp_path):
    done = run("optimise", file, "--out", tmp_path / "out")
    assert (done.status, done.err) == (0, "")
    assert result_names(tmp_path / "out") == {
        "designs.csv", "curves.csv", "optimisation.json", "best.yaml", "report.html", "absorption.png",
    }  # fmt: skip
    assert "highest absorption at 500 Hz" in done.out
    assert "3 of 3 descents from anywhere" in done.out
    rows = list(csv.DictReader((tmp_path / "out" / "designs.csv").read_text().splitlines()))
    assert [row["design"] for row in rows][:2] == ["as written", "1"]
    assert float(rows[0]["gap.thickness [m]"]) == 0.05
    assert float(rows[1]["gap.thickness [m]"]) == pytest.approx(343.2 / 2000, rel=0.002)
    again = run("simulate", tmp_path / "out" / "best.yaml", "--out", tmp_path / "again", "--json")
    assert json.loads(again.out)["cases"][0]["absorption"][1] == pytest.approx(1, abs=1e-6)


def test_it_does_not_depend_on_where_it_runs(file, tmp_path):
    records = [
        run("optimise", file, "--out", tmp_path / f"out{jobs}", "--jobs", jobs, "--json", "--no-figures").out
        for jobs in (1, 2)
    ]
    assert records[0] == records[1]


def test_another_seed_ends_at_the_same_design(file, tmp_path):
    first = json.loads(run("optimise", file, "--out", tmp_path / "a", "--json", "--no-figures").out)
    changed(file, ("starts: 3", "starts: 3, seed: 7"))
    second = json.loads(run("optimise", file, "--out", tmp_path / "b", "--json", "--no-figures").out)
    for name, value in first["designs"][0]["values"].items():
        assert second["designs"][0]["values"][name] == pytest.approx(value, rel=2e-3)
    assert first["ends"] != second["ends"]


STOPPED = """
import sys
from multilayer.cli import main
from multilayer.optimisation import search

calls, call = iter(range(1000)), search.{task}.__call__

def stopping(self):
    if next(calls) == {after}:
        raise KeyboardInterrupt
    return call(self)

search.{task}.__call__ = stopping
sys.argv[0] = "multilayer"
main()
"""


@pytest.mark.parametrize("after", [0, 4])
def test_ctrl_c_keeps_the_best_so_far(file, tmp_path, after):
    stopped = STOPPED.format(task="Descent", after=after)
    done = python("-c", stopped, "optimise", file, "--out", tmp_path / "out", "--no-figures")
    assert done.status == 130
    told = done.err.splitlines()
    assert told[0] == "warning: stopped by Ctrl-C: the best so far is computed exactly"
    assert told[-1] == f"stopped by Ctrl-C after {after + 1} parts of the search: this is the best so far"
    record = json.loads((tmp_path / "out" / "optimisation.json").read_text())
    assert record["whole"] is False
    assert record["designs"][0]["goals"][0] > 0.9


def test_ctrl_c_before_anything_is_known(file, tmp_path):
    done = python("-c", STOPPED.format(task="Screen", after=0), "optimise", file, "--out", tmp_path / "out")
    assert done.status == 130
    assert "nothing was written" in done.err
    assert not (tmp_path / "out").exists()


STOPPED_WHILE_SIMULATED = """
import sys
from multilayer.cli import main
from multilayer.optimisation import run

calls, simulate = iter(range(1000)), run.simulate

def stopping(simulation):
    if next(calls) == {after}:
        raise KeyboardInterrupt
    return simulate(simulation)

run.simulate = stopping
sys.argv[0] = "multilayer"
main()
"""


@pytest.mark.parametrize(("after", "designs"), [(0, 1), (1, 1)])
def test_ctrl_c_when_the_search_is_done(file, tmp_path, after, designs):
    """In the exact figures of the only design, which are begun again, and in those of the file as written."""
    stopped = STOPPED_WHILE_SIMULATED.format(after=after)
    done = python("-c", stopped, "optimise", file, "--out", tmp_path / "out", "--no-figures")
    assert done.status == 130
    assert "this is the best so far" in done.err
    record = json.loads((tmp_path / "out" / "optimisation.json").read_text())
    assert (record["whole"], len(record["designs"])) == (False, designs)
    assert (record["written"]["goals"][0] is None) == (after == 1)


WOOL = """\
kind: optimisation
version: 1
layers:
  - {name: wool, type: equivalent_fluid, model: delany_bazley, flow_resistivity: 20 kN s/m^4, thickness: 20 mm}
termination: rigid
frequency: {third_octaves: [100, 5000]}
design: {layers.wool.thickness: [20 mm, 60 mm]}
goal: {lowest: thickness}
limits: [{of: alpha_w, at_least: 0.3}]
search: {starts: 2}
"""


def test_designs_without_a_response_cost_nothing_else(tmp_path):
    """Thin wool creates energy in this model, as it does in the file: both are told, and the best is written."""
    (tmp_path / "wool.yaml").write_text(WOOL)
    done = run("optimise", tmp_path / "wool.yaml", "--out", tmp_path / "out")
    assert done.status == 0
    assert "warning: as the file has it, the stack has no figures: the response gives back more energy" in done.err
    assert {"best.yaml", "absorption.png", "report.html"} <= result_names(tmp_path / "out")
    rows = list(csv.DictReader((tmp_path / "out" / "designs.csv").read_text().splitlines()))
    assert [row["alpha_w at least 0.3 [1]"] for row in rows][:2] == ["", "0.4"]
    (limit,) = [line for line in done.out.splitlines() if line.startswith("alpha_w at least 0.3")]
    assert limit.split() == ["alpha_w", "at", "least", "0.3", "-", "0.40", "kept"]


class TestMistakes:
    def test_of_a_design(self, file, tmp_path):
        changed(
            file,
            (
                "  layers.cloth.flow_resistance: [50, 5000]\n  layers.gap.thickness: [2 cm, 30 cm]\n",
                "  layers.cloth.flow_resistance: [5000, 50]\n"
                "  layers.gap.thickness: [-2 cm, 30 cm]\n"
                "  layers.cloth.colour: [1, 2]\n"
                "  layers.foam.thickness: [1 mm, 2 mm]\n"
                "  layers.gap.sound_speed: [1 kg, 340]\n"
                "  layers.gap.density: 3\n"
                "  order: [gap, cloth, gap]\n"
                "  optional: [wool]\n"
                "  termination: {among: [soft, rigid]}\n"
                "  incidence: {among: [diffuse]}\n",
            ),
        )
        lines = refused(file, tmp_path / "out")
        expected = [
            (9, "the lower bound, 5000, must lie below the upper one, 50"),
            (10, "-0.02 is not allowed: it must be above 0"),
            (11, "there is no 'colour'"),
            (12, "there is no 'foam' in layers"),
            (13, "'1 kg' has the wrong unit"),
            (14, "3 says not what may vary; write two bounds"),
            (15, "stands here a second time"),
            (16, "there is no 'wool' in layers"),
            (17, "'soft' is not allowed"),
            (18, "leads to nothing that can be chosen; allowed: contacts, layers, termination"),
        ]
        assert len(lines) == len(expected)
        for line, (number, text) in zip(lines, expected, strict=True):
            assert line.startswith(f"{file}:{number}:")
            assert text in line

    @pytest.mark.parametrize("other", ["[3 cm, 4 cm]", "{among: [3 cm, 4 cm]}"])
    def test_one_field_twice(self, file, tmp_path, other):
        changed(file, ("design:\n", f"design:\n  layers.1.thickness: {other}\n"))
        (line,) = refused(file, tmp_path / "out")
        assert line.startswith(f"{file}:11:")
        assert "lead to the same field; leave one of them out" in line

    def test_nothing_may_vary(self, file, tmp_path):
        changed(
            file,
            ("  layers.cloth.flow_resistance: [50, 5000]\n", ""),
            ("layers.gap.thickness: [2 cm, 30 cm]", "layers.gap.thickness: {among: [2 cm]}"),
        )
        (line,) = refused(file, tmp_path / "out")
        assert f"{file}:9:" in line
        assert "nothing may vary" in line

    @pytest.mark.parametrize(
        ("goal", "text"),
        [
            ("{highest: absorbtion}", "did you mean 'absorption'?"),
            ("{highest: alpha_w}", "lacks bands"),
            ("{highest: Rw}", "Rw goes with a half-space behind: write 'termination: ambient'"),
            ("{highest: insertion_loss}", "insertion_loss goes with a reference"),
            ("{highest: mass}", "the mass of layer cloth is not known"),
            ("{lowest: price}", "the price of layer cloth is not known"),
            ("{highest: absorption, from: 2 kHz}", "none of the file's frequencies lies there: 250 to 1000 Hz"),
            ("{lowest: thickness, from: 2 kHz}", "thickness has no band"),
            ("{highest: absorption, lowest: thickness}", "give one of highest, lowest and closest"),
            ("{closest: gone.csv}", "no such file"),
        ],
    )
    def test_of_a_goal(self, file, tmp_path, goal, text):
        changed(file, ("{highest: absorption, from: 500 Hz, to: 500 Hz}", goal))
        (line,) = refused(file, tmp_path / "out")
        assert f"{file}:11:" in line
        assert text in line

    @pytest.mark.parametrize(
        ("goal", "limit", "expected"),
        [
            ("Rw", "", [(2, "Rw goes with a half-space behind: write 'termination: ambient'")]),
            ("alpha_w", "", [(1, "alpha_w is of an absorber on a wall: write 'termination: rigid'")]),
            ("absorption", "limits: [{of: Rw, at_least: 10}]\n", [(2, "Rw goes with a half-space behind")]),
            ("alpha_w", "limits: [{of: Rw, at_least: 10}]\n", [(1, "alpha_w is of"), (2, "Rw goes with")]),
        ],
    )
    def test_of_a_goal_with_one_of_the_terminations(self, file, tmp_path, goal, limit, expected):
        changed(
            file,
            ("[250 Hz, 500 Hz, 1 kHz]", "{third_octaves: [100 Hz, 5 kHz]}"),
            ("design:\n", "design:\n  termination:\n    among:\n    - ambient\n    - rigid\n"),
            ("{highest: absorption, from: 500 Hz, to: 500 Hz}", f"{{highest: {goal}}}"),
        )
        file.write_text(file.read_text() + limit)
        lines = refused(file, tmp_path / "out")
        assert len(lines) == len(expected)
        for line, (i, text) in zip(lines, expected, strict=True):
            assert f"{file}:{10 + i}:" in line
            assert text in line

    def test_a_limit_that_excludes_all_is_named(self, file, tmp_path):
        file.write_text(
            f"{FILE}limits:\n  - {{of: thickness, at_most: 50 cm}}\n  - {{of: thickness, at_most: 1 cm}}\n"
            "  - {of: absorption, at_least: 0.95, from: 250 Hz, to: 1 kHz}\n"
        )
        lines = refused(file, tmp_path / "out")
        assert len(lines) == 2
        assert f"{file}:15:" in lines[0]
        assert (
            "thickness at most 1 cm: the search finds no design that keeps this; the least it reaches is 20 mm"
            in lines[0]
        )
        assert f"{file}:16:" in lines[1]
        text = "absorption from 250 to 1000 Hz at least 0.95: the search finds no design that keeps this; the most it"
        assert text in lines[1]

    def test_limits_that_exclude_each_other(self, file, tmp_path):
        file.write_text(
            f"{FILE}limits:\n  - {{of: thickness, at_most: 3 cm}}\n"
            "  - {of: absorption, at_least: 0.9, from: 500 Hz, to: 500 Hz}\n"
        )
        lines = refused(file, tmp_path / "out")
        assert all("kept by some designs, but by none together with the other limits" in line for line in lines)
        assert 1 <= len(lines) <= 2


def test_several_goals(file, tmp_path):
    changed(
        file,
        ("goal: {highest: absorption, from: 500 Hz, to: 500 Hz}", "goal: [{highest: absorption}, {lowest: thickness}]"),
    )
    done = run("optimise", file, "--out", tmp_path / "out")
    assert (done.status, done.err) == (0, "")
    record = json.loads((tmp_path / "out" / "optimisation.json").read_text())
    names = {f"design-{design['name']}.yaml" for design in record["designs"]}
    assert len(names) >= 5
    assert result_names(tmp_path / "out") == names | {
        "designs.csv", "curves.csv", "optimisation.json", "report.html", "absorption.png", "front.png",
    }  # fmt: skip


def test_a_curve_is_met(file, tmp_path):
    """A curve that one of the designs gives is met by the search, which finds that design again."""
    run("optimise", file, "--out", tmp_path / "out", "--no-figures")
    run("simulate", tmp_path / "out" / "best.yaml", "--out", tmp_path / "curve", "--no-figures")
    changed(
        file,
        ("{highest: absorption, from: 500 Hz, to: 500 Hz}", "{closest: curve/simulation.csv, quantity: absorption}"),
    )
    record = json.loads(run("optimise", file, "--out", tmp_path / "met", "--json", "--no-figures").out)
    assert record["designs"][0]["goals"][0] < 1e-4
    assert record["designs"][0]["values"]["gap.thickness"] == pytest.approx(343.2 / 2000, rel=0.002)


def test_price_and_mass_of_a_catalogue(file, tmp_path):
    """The cheapest is the thinnest: 10 for the cloth and 100 a cubic metre of gap."""
    file.write_text(
        changed(file, ("{highest: absorption, from: 500 Hz, to: 500 Hz}", "{lowest: price}")).read_text()
        + "catalogue: {cloth: {price: 10, mass: 0.3 kg/m^2}, gap: {price_per_volume: 100}}\n"
        "limits: [{of: mass, at_most: 0.5 kg/m^2}]\n"
    )
    record = json.loads(run("optimise", file, "--out", tmp_path / "out", "--json", "--no-figures").out)
    assert record["designs"][0]["goals"] == pytest.approx([12.0])
    assert record["designs"][0]["limits"] == pytest.approx([0.3])

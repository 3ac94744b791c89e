"""``multilayer blind-check``."""

import json

import pytest

from tests.cli.command import python, run
from validation.blind_check.draw import draw

SEED = 11  # whose first two campaigns have no effect, and are made in no time


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    out = tmp_path_factory.mktemp("blind") / "out"
    return run("blind-check", "--campaigns", 1, "--seed", SEED, "--out", out), out


@pytest.mark.slow
def test_it_draws_diagnoses_and_scores(checked):
    done, out = checked
    assert done.status == 0, done.err
    assert draw(0, SEED).kind == "none"
    record = json.loads((out / "blind_check.json").read_text())
    assert (record["seed"], record["campaigns"]) == (SEED, 1)
    alarms = record["scores"]["several configurations"][0]
    assert (alarms["name"], alarms["value"], alarms["n"]) == ("false alarms on gap-free data", 0.0, 1)
    assert "| no effect | 1 |" in (out / "blind_check.md").read_text()
    assert (out / "blind_check.png").stat().st_size > 5000
    assert "false alarms on gap-free data" in done.out


@pytest.mark.slow
def test_it_goes_on_where_it_stopped(checked):
    _, out = checked
    before = (out / "answers.jsonl").read_text()
    with (out / "answers.jsonl").open("a") as file:
        file.write('{"number": 1, "verd')  # cut short
    done = run("blind-check", "--campaigns", 2, "--seed", SEED, "--out", out, "--resume", "--no-figures", "--json")
    assert done.status == 0, done.err
    lines = (out / "answers.jsonl").read_text().splitlines()
    assert lines[:2] == before.splitlines()
    assert [json.loads(line)["number"] for line in lines[1:]] == [0, 1]
    assert json.loads(done.out)["campaigns"] == 2


def test_answers_of_another_seed_are_not_taken(checked):
    _, out = checked
    before = (out / "answers.jsonl").read_text()
    done = run("blind-check", "--campaigns", 1, "--seed", SEED + 1, "--out", out, "--resume")
    assert done.status == 2
    assert "another seed" in done.err
    assert (out / "answers.jsonl").read_text() == before


def test_answers_are_not_begun_anew_over_others(checked):
    _, out = checked
    before = (out / "answers.jsonl").read_text()
    done = run("blind-check", "--campaigns", 1, "--seed", SEED, "--out", out)
    assert done.status == 2
    assert "--resume" in done.err
    assert (out / "answers.jsonl").read_text() == before


def test_help_of_the_command_and_of_the_module():
    done = run("blind-check", "--help")
    assert (done.status, done.err) == (0, "")
    assert "Example: multilayer blind-check --campaigns 40 --seed 7" in done.out
    assert {"--json", "--plugin"} <= set(done.out.split())
    assert python("-m", "validation.blind_check", "--help").out == done.out


@pytest.mark.parametrize(("option", "value"), [("--campaigns", 0), ("--seed", -1), ("--jobs", 0)])
def test_impossible_numbers_are_refused(option, value, tmp_path):
    done = run("blind-check", option, value, "--out", tmp_path / "out")
    assert done.status == 2
    assert option in done.err

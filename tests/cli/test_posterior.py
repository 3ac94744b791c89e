"""``--posterior``: intervals, what the data determine, and bands, in files and in print."""

import json
import sys
from functools import partial

import numpy as np
import pytest

from multilayer.inference.nested_sampling import nested
from multilayer.response import plane_wave
from tests.cli.command import run
from tests.fits.stack_fits import IN_A_TUBE, F, noisy, parts, write

R = plane_wave(IN_A_TUBE, F).reflection
TUBE = {"kind": "reflection", "file": "tube.csv", "noise": {"absolute": 0.01}}
UNKNOWNS = {"layers.wool.flow_resistivity": {"lognormal": ["10 kN s/m^4", 0.5]}}
LAW = ["relaxed_modulus", "unrelaxed_modulus", "relaxation_time", "order"]


@pytest.fixture
def tube(tmp_path):
    """Give the file of a small stack fit."""
    tables = {"tube.csv": parts("frequency_hz,reflection_re,reflection_im", F, noisy(R, 0.01))}
    return write(tmp_path, IN_A_TUBE, tables, [TUBE], UNKNOWNS)


def check_intervals(record, method):
    assert record["posterior"]["method"] == method
    for parameter in record["posterior"]["parameters"]:
        (a, b), (c, d) = parameter["interval_68"], parameter["interval_90"]
        assert c < a < parameter["median"] < b < d
    found = record["determination"]
    assert [p["name"] for p in found["parameters"]] == [p["name"] for p in record["posterior"]["parameters"]]
    assert found["sentences"]
    assert 0 < found["n_determined"] <= len(found["parameters"])


@pytest.mark.parametrize("method", [None, "profile"])
def test_a_joint_fit(sound_campaign, tmp_path, method):
    options = () if method is None else ("--posterior", method)
    done = run("fit", sound_campaign, "--joint", "--out", tmp_path, "--no-figures", *options)
    assert done.status in (0, 1)
    record = json.loads((tmp_path / "joint.json").read_text())
    check_intervals(record, method or "laplace")
    assert [p["name"] for p in record["posterior"]["parameters"] if not p["nuisance"]] == LAW
    for row in record["modulus_intervals"]:
        assert row["E1_pa_interval_90"][0] < row["E1_pa_interval_68"][0]
        e1 = next(one["E1_pa"] for one in record["moduli"] if one["frequency_hz"] == row["frequency_hz"])
        assert row["E1_pa_interval_90"][0] < e1 < row["E1_pa_interval_90"][1]
    lines = done.out.splitlines()
    heading = next(i for i, line in enumerate(lines) if line.startswith("the data determine "))
    assert heading > next(i for i, line in enumerate(lines) if line.startswith("f / Hz"))
    assert [line.split()[0] for line in lines[heading + 2 :] if line.split()[0] in LAW] == LAW


def test_a_law_with_more_parameters_than_configurations(sound_campaign, tmp_path):
    """What counts is the number of data."""
    options = ("--joint", "--law", "havriliak_negami", "--no-figures", "--out", tmp_path)
    done = run("fit", sound_campaign, *options)
    assert (done.status in (0, 1), done.err) == (True, "")
    record = json.loads((tmp_path / "joint.json").read_text())
    assert [p["name"] for p in record["posterior"]["parameters"]][:5] == [*LAW, "asymmetry"]


@pytest.mark.parametrize("method", [None, "profile"])
def test_a_stack_fit(tube, tmp_path, method):
    options = () if method is None else ("--posterior", method)
    done = run("fit", tube, "--out", tmp_path / "out", "--no-figures", *options)
    assert (done.status, done.err) == (0, "")
    record = json.loads((tmp_path / "out" / "fit.json").read_text())
    check_intervals(record, method or "laplace")
    (parameter,), (found,) = record["parameters"], record["posterior"]["parameters"]
    assert [parameter["low_90"], parameter["high_90"]] == found["interval_90"]
    assert found["interval_90"][0] < 1.2e4 < found["interval_90"][1]
    (sentence,) = record["determination"]["sentences"]
    assert sentence.startswith("the data determine layers.wool.flow_resistivity: ")
    assert sentence[:30] in done.out


def test_nested_sampling_of_a_stack_fit(tube, tmp_path, monkeypatch):
    pytest.importorskip("dynesty")
    # roughly, for the sake of time
    monkeypatch.setattr("multilayer.inference.summary.nested", partial(nested, n_live=60, at_once=8, remaining=1.0))
    results = {}
    for method in ("laplace", "nested"):
        out = tmp_path / method
        assert run("fit", tube, "--out", out, "--no-figures", "--posterior", method).status == 0
        results[method] = json.loads((out / "fit.json").read_text())
    check_intervals(results["nested"], "nested")
    (laplace,), (sampled,) = (results[method]["posterior"]["parameters"] for method in results)
    width = np.ptp(laplace["interval_90"])
    assert sampled["interval_90"] == pytest.approx(laplace["interval_90"], abs=0.4 * width)
    evidence = [results[method]["posterior"]["log_evidence"] for method in results]
    assert evidence[1] == pytest.approx(evidence[0], abs=1.5)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--joint", "--posterior", "nested"), "pip install 'multilayer[bayes]'"),
        (("--joint", "--posterior", "laplase"), "did you mean 'laplace'"),
        (("--posterior", "laplace"), "add --joint, or leave it out"),
    ],
)
def test_mistakes_with_a_campaign(sound_campaign, tmp_path, monkeypatch, options, said):
    monkeypatch.setitem(sys.modules, "dynesty", None)
    done = run("fit", sound_campaign, "--out", tmp_path / "out", *options)
    assert (done.status, done.out) == (2, "")
    assert said in done.err
    assert len(done.err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("method", "said"), [("nested", "multilayer[bayes]"), ("nestd", "did you mean 'nested'")])
def test_mistakes_with_stacks(tube, tmp_path, monkeypatch, method, said):
    monkeypatch.setitem(sys.modules, "dynesty", None)
    done = run("fit", tube, "--out", tmp_path / "out", "--posterior", method)
    assert (done.status, done.out) == (2, "")
    assert said in done.err
    assert not (tmp_path / "out").exists()

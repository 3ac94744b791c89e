"""Every registered inverse method, those of plugins included, keeps what `check_method` asks; wrong ones are told."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from multilayer.fits.methods import METHODS, CampaignMethod, Method
from multilayer.fits.result import BurstFit, FitResult
from multilayer.fits.run import FitTask
from multilayer.registry import RegistryError
from multilayer.testing import check_method
from multilayer.testing.methods import method_bench
from tests.fits.half_power import HalfPower

OF_CAMPAIGNS = [name for name, kind in METHODS.working() if issubclass(kind, CampaignMethod)]


@pytest.mark.parametrize("name", METHODS.names())
def test_a_method_says_what_it_is(name):
    kind = METHODS[name]
    assert (kind.name, kind.reads in ("campaign", "stack-fit")) == (name, True)
    assert kind.title
    assert not kind.summary.endswith(".")
    options = {field.name for field in fields(FitTask)} - {"source", "method", "joint"}
    assert set(kind.options()) <= options, "the command line has no such option"


@pytest.mark.parametrize("name", OF_CAMPAIGNS)
def test_a_method_keeps_what_all_keep(name):
    check_method(METHODS[name])


def test_half_power_keeps_it_too():
    check_method(HalfPower)


class Silent(CampaignMethod):
    name, title, summary = "silent", "nothing", "gives nothing"

    def run(self, job, tell):
        for burst in job.bursts:
            tell(burst.configuration)
        return FitResult(job.name, self.name, job.plain_settings(), self.bursts(job))

    def bursts(self, job):
        return []


class Wrong(Silent):
    def bursts(self, job):
        return [BurstFit(b.configuration, b.frequency, 3e5, -1.0, 1e4, 0.0, 0.03, 0.0) for b in job.bursts]


class Unreasonable(Silent):
    def bursts(self, job):
        return [BurstFit("thin", 100.0, 3e5, 0.0, 1e4, 0.0, 0.03, 0.0, accepted=False)]


class Restless(Silent):
    runs = 0

    def bursts(self, job):
        Restless.runs += 1
        return [BurstFit("thin", 100.0 + Restless.runs, 3e5, 0.0, 1e4, 0.0, 0.03, 0.0)]


class Hasty(Silent):
    def number_of_steps(self, job):
        return 1


class Another(Silent):
    def run(self, job, tell):
        return FitResult("elsewhere", "other", {}, [])


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (Silent, "accepts no modulus of a campaign"),
        (Wrong, "are accepted; the truth is"),
        (Wrong, "E1_std_pa must not be negative"),
        (Unreasonable, "not accepted, and no reason is told"),
        (Restless, "the same input gives another result"),
        (Hasty, "1 steps are announced, 6 reported"),
        (Another, "the result is that of 'other' and 'elsewhere'"),
    ],
)
def test_wrong_methods_are_caught(wrong, words):
    with pytest.raises(AssertionError, match=words):
        check_method(wrong)


class Untold(Silent):
    name, title, summary = "untold", "", ""


class Unfinished(CampaignMethod):
    name, title, summary = "unfinished", "a start", "begins"


@pytest.mark.parametrize(
    ("name", "item", "words"),
    [
        ("number", 5, "not a subclass of multilayer.fits.methods.Method"),
        ("quiet", Silent, "its 'name' is 'silent'; it must be 'quiet'"),
        ("untold", Untold, "it says no title, summary"),
        ("unfinished", Unfinished, "it defines no run"),
    ],
)
def test_what_is_no_method_is_refused(name, item, words):
    with pytest.raises(RegistryError, match=words):
        METHODS.register(name, item)
    assert name not in METHODS


def test_options_are_fields_and_settings():
    assert METHODS["joint"].options() == ("model", "law", "elements", "posterior", "given")
    assert METHODS["transfer-function"].options() == ("lateral",)
    assert METHODS["joint"].with_options({"law": "zener", "lateral": "held", "elements": None}).law == "zener"
    assert Method.options() == ()


def test_a_method_run_by_hand_is_that_method():
    job = method_bench()
    assert job.settings.method == "least-squares"
    result = METHODS["least-squares"]().run(job, lambda text: None)
    assert result.to_csv() == METHODS["least-squares"]().run(job, lambda text: None).to_csv()
    assert result.campaign == result.name == job.name


def test_the_example_of_the_manual_works():
    text = (Path(__file__).parents[2] / "docs" / "plugins.md").read_text()
    (block,) = (block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "MassOnSpring" in block)
    names = {}
    exec(block, names)
    check_method(names["MassOnSpring"])

"""Every registered inverse method, those of plugins included, keeps what `check_method` asks; wrong ones are told."""

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.experiments.two_plate.finite_elements import two_plate_rig
from multilayer.fits.methods import METHODS, CampaignMethod, Method
from multilayer.fits.result import BurstFit, FitResult
from multilayer.fits.run import FitTask
from multilayer.registry import RegistryError
from multilayer.testing import check_method
from multilayer.testing.methods import disc_bench, method_bench, true_modulus, true_motion
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


class Exact(Silent):
    """Knows the truth, and scatters about it by a hundredth."""

    scatter, std = 0.01, 0.005

    def bursts(self, job):
        moduli = []
        for i, burst in enumerate(job.bursts):
            e = complex(true_modulus(burst.frequency)) * (1 + self.scatter * (-1) ** i)
            errors = (self.std * abs(e),) * 2
            values = e.real, errors[0], e.imag, errors[1], e.imag / e.real, np.nan
            moduli.append(BurstFit(burst.configuration, burst.frequency, *values))
        return moduli


class OfFreeRods(Exact):
    def bursts(self, job):
        held = 1.0 if job is method_bench() else 1.28
        return [replace(b, storage_modulus=held * b.storage_modulus) for b in super().bursts(job)]


class Sure(Exact):
    std = 1e-9


class Certain(Exact):
    std = 0.0


def test_an_exact_method_passes():
    check_method(Exact)


def test_a_missing_shape_factor_is_told():
    with pytest.raises(AssertionError, match=r"flat 150 Hz: .* are accepted; the truth is") as caught:
        check_method(OfFreeRods)
    assert "flat is a bonded disc with a Poisson's ratio of 0.3, 1.28 times as stiff as a free rod" in str(caught.value)
    assert "static_shape_factor" in str(caught.value)
    assert "thick" not in str(caught.value)


@pytest.mark.parametrize("wrong", [Sure, Certain])
def test_standard_deviations_far_below_the_scatter_are_told(wrong):
    with pytest.raises(AssertionError, match=r"knows_its_errors: E1 scatters by 2e\+03 Pa .*, or NaN where it is not"):
        check_method(wrong)


def test_the_truth_of_the_disc_is_that_of_finite_elements():
    campaign = disc_bench().campaign
    for configuration in campaign.configurations:
        f = np.array([burst.frequency for burst in configuration.bursts])
        expected = two_plate_rig(campaign, configuration).transmissibility(f, true_modulus(f))
        np.testing.assert_allclose(true_motion(campaign, configuration, f), expected, rtol=0.005)


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

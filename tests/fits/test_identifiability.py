"""What is said of parameters that the data determine, half determine, trade against each other, or do not see."""

import json

import numpy as np
import pytest

from multilayer.inference.identifiability import Identifiability, identifiability
from multilayer.inference.least_squares import search
from multilayer.inference.posterior import laplace
from multilayer.inference.priors import Parameter, Prior
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.profile import profile_likelihood
from multilayer.report.console import show
from multilayer.report.identifiability import determined_section
from multilayer.report.report import Report
from tests.fits.gaussian import Plain, linear, parameters

WIDE = Prior(lognormal=(2e4, 1.0))


def _named(problem: Plain, *names: str, nuisance: tuple[str, ...] = ()) -> Plain:
    known = [
        Parameter(name=n, prior=p.prior, nuisance=n in nuisance) for n, p in zip(names, problem.parameters, strict=True)
    ]
    return Plain(problem.function, tuple(known))


def _best(problem: Problem) -> Minimum:
    return search(problem, n_candidates=16, n_best=2)[0]


def _determined(problem: Problem) -> Identifiability:
    return identifiability(problem, _best(problem))


def test_shares_of_information() -> None:
    found = _determined(linear(np.diag([10.0, 1.0, 0.1]), np.zeros(3)))
    assert [f.share for f in found.findings] == pytest.approx([100 / 101, 0.5, 0.01 / 1.01])
    assert [f.verdict for f in found.findings] == ["determined", "narrowed", "not determined"]
    assert found.n_determined == pytest.approx(100 / 101 + 0.5 + 0.01 / 1.01)
    assert found.n_open == 1
    assert found.findings[0].posterior_std == pytest.approx(1 / np.sqrt(101), rel=0.01)
    assert found.findings[0].prior_std == pytest.approx(1.0)
    assert not found.groups


def test_a_parameter_the_data_do_not_see_is_said_so_with_its_prior() -> None:
    problem = _named(
        linear([[50.0, 0.0]], np.array([10.0]), WIDE, Prior(uniform=(1e-4, 3e-4))), "flow_resistivity", "thermal_length"
    )  # fmt: skip
    first, second = _determined(problem).sentences
    assert first.startswith("the data determine flow_resistivity: 2.395e+04 to 2.492e+04")
    assert second == "the data say nothing about thermal_length beyond its prior (0.000132 to 0.000268)"


def test_two_that_are_known_as_a_product_only() -> None:
    problem = linear([[50.0, 50.0]], np.array([0.0]), WIDE, Prior(lognormal=(2.0, 1.0)))
    found = _determined(_named(problem, "flow_resistivity", "tortuosity"))
    (group,) = found.groups
    assert group.names == ("flow_resistivity", "tortuosity")
    assert group.correlation == pytest.approx(-1.0, abs=1e-3)
    assert group.exponents == pytest.approx((1.0, 1.0), rel=1e-3)
    assert group.std == pytest.approx(0.02, rel=1e-3)
    assert "flow_resistivity and tortuosity are known best as a product-like combination" in found.sentences[-1]
    assert "flow_resistivity · tortuosity to within 2 %" in found.sentences[-1]


@pytest.mark.parametrize(
    ("slope", "priors", "said"),
    [
        (-50.0, (WIDE, WIDE), "ratio-like combination: a / b to within"),
        (-25.0, (WIDE, WIDE), "ratio-like combination: a / b^0.5 to within"),
        (50.0, (Prior(normal=(0, 2.0)), Prior(normal=(0, 1.0))), "sum-like combination: a + 2 b to within 0.04"),
        (-50.0, (Prior(normal=(0, 1.0)), Prior(normal=(0, 1.0))), "difference-like combination: a - b to within 0.02"),
    ],
)
def test_how_a_pair_is_named(slope: float, priors: tuple[Prior, Prior], said: str) -> None:
    (group,) = _determined(linear([[50.0, slope]], np.array([0.0]), *priors)).groups
    assert said in group.text


def test_three_of_which_one_combination_is_known_though_no_pair_is_collinear() -> None:
    problem = linear([[30.0, 30.0, 30.0, 0.0], [0.0, 0.0, 0.0, 30.0]], np.zeros(2), *[WIDE] * 4)
    found = _determined(problem)
    (group,) = found.groups
    assert group.names == ("a", "b", "c")
    assert abs(group.correlation) == pytest.approx(0.5, abs=0.01)
    assert group.combination == "a · b · c"
    assert found.n_open == 2


def test_collinear_though_both_are_determined() -> None:
    # both far better than their priors, their difference far better still
    problem = linear([[30.0, 30.0], [3000.0, -3000.0]], np.zeros(2), WIDE, WIDE)
    found = _determined(problem)
    assert [f.verdict for f in found.findings] == ["determined", "determined"]
    assert found.n_open == 0
    (group,) = found.groups
    assert group.correlation > 0.95
    assert group.combination == "a / b"


def test_only_a_profile_shows_an_end_that_is_open() -> None:
    """A modulus that is so high that it no longer shows: y = 1/x is measured as nearly 0."""
    known = parameters(Prior(loguniform=(1.0, 1e4)))
    problem = Plain(lambda z: (1 / known[0].prior.value(z) - 0.01) / 0.02, known)
    minimum = _best(problem)
    profile = profile_likelihood(problem, minimum, "a")
    assert profile.open_ends == (False, True)
    (finding,) = identifiability(problem, minimum, profiles=[profile]).findings
    assert finding.text.startswith("a is bounded from below only: above")
    assert finding.posterior == profile.interval("a", 0.68)


@pytest.mark.parametrize(
    ("prior", "wanted", "slope", "told"),
    [
        (Prior(uniform=(1.0, 3.0)), 0.5, 50.0, "a is at the lower end of its prior, 1: the data draw it there"),
        (
            Prior(normal=(2.0, 0.5), bounds=(1.0, 2.2)),
            4.0,
            50.0,
            "a is at the upper end of its prior, 2.2: the data draw it",
        ),
        (Prior(uniform=(1.0, 3.0)), 2.0, 0.1, "the data say nothing about a beyond its prior (1.3"),
    ],
)
def test_a_value_at_an_end_of_its_prior(prior: Prior, wanted: float, slope: float, told: str) -> None:
    """Beyond its end nothing changes any more: the data seem to say nothing, and say where it is."""
    known = parameters(prior)
    problem = Plain(lambda z: slope * (known[0].prior.value(z) - wanted), known)
    (text,) = _determined(problem).sentences
    assert text.startswith(told)


def test_logarithms_are_undone() -> None:
    problem = _named(linear([[50.0]], np.array([0.0]), Prior(uniform=(np.log(1e3), np.log(1e5)))), "ln relaxed_modulus")
    (text,) = _determined(problem).sentences
    assert text == "the data determine relaxed_modulus: 9641 to 1.037e+04"


def test_nuisances_the_data_do_not_see_are_not_told() -> None:
    problem = _named(
        linear(np.diag([10.0, 0.1, 5.0]), np.zeros(3)), "modulus", "gain", "delay", nuisance=("gain", "delay")
    )
    sentences = _determined(problem).sentences
    assert len(sentences) == 2
    assert not any("gain" in sentence for sentence in sentences)


def test_it_takes_any_posterior() -> None:
    problem = linear(np.diag([10.0, 1.0]), np.zeros(2))
    minimum = _best(problem)
    by_default = identifiability(problem, minimum)
    assert identifiability(problem, minimum, posterior=laplace(problem, minimum)).to_dict() == by_default.to_dict()


def test_json_and_table(capsys: pytest.CaptureFixture[str]) -> None:
    problem = linear([[50.0, 50.0]], np.array([0.0]), WIDE, Prior(lognormal=(2.0, 1.0)))
    found = _determined(_named(problem, "flow_resistivity", "layers[1].tortuosity"))
    plain = json.loads(json.dumps(found.to_dict()))
    assert [p["name"] for p in plain["parameters"]] == ["flow_resistivity", "layers[1].tortuosity"]
    assert plain["groups"][0]["times_better"] > 10
    show(Report(sections=(determined_section(found),)))
    printed = capsys.readouterr().out
    assert "the data determine 1.0 of 2 parameters" in printed
    assert "layers[1].tortuosity" in printed
    assert "product-like" in printed

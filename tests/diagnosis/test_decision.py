"""The decision between causes, and its parts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis import assessment, goodness_of_fit
from multilayer.diagnosis import decision as decision_module
from multilayer.diagnosis.assessment import rival_term
from multilayer.diagnosis.cross_validation import Part, Shrinkage, cross_validate
from multilayer.diagnosis.decision import Decision, beside_simple_term, decide, objection_to_law
from multilayer.diagnosis.diagnose import fit_nominal
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.effects.base import Chain
from multilayer.diagnosis.entries import sentence
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison
from multilayer.diagnosis.fitting import Fitted, fit, fit_effects
from multilayer.diagnosis.goodness_of_fit import size_p_value
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.places import PLACES, places_of
from multilayer.diagnosis.places.reading import Reading
from multilayer.diagnosis.thresholds import FORM_AHEAD, RIGHT_DOUBTED, RIGHT_GUARDED, RIGHT_PLACE
from multilayer.inference.low_rank import LowRank
from multilayer.testing.benches import joint_bench
from tests.fits.test_joint import campaign_and_signals


def test_a_skin_is_never_softer_and_glue_never_heavier_than_glue():
    ratio = EFFECTS["skin"].parameters[1].prior
    mass = EFFECTS["adhesive"].parameters[2].prior
    assert ratio.value(-8.0) == pytest.approx(1.0, abs=1e-6)
    assert mass.value(8.0) == pytest.approx(0.6, rel=1e-6)
    assert ratio.value(0.0) > 3.0


@pytest.mark.parametrize(("z", "p"), [((0.0, 0.0), 1.0), ((1.0, 0.0), 0.607), ((3.0, 4.0), 3.7e-6)])
def test_sizes_count_together(z, p):
    # a chi-square of two numbers: exp(-z^2/2); what belongs to the nominal model, before them, does not matter
    parameters = [SimpleNamespace(name=name) for name in ("ln modulus", "skin.thickness", "skin.ratio")]
    effects = (SimpleNamespace(name="skin", error_of=""),)
    hypothesis = SimpleNamespace(effects=effects, parameters=parameters)
    found = Fitted(hypothesis, SimpleNamespace(z=np.array([9.0, *z])))
    assert size_p_value(found) == pytest.approx(p, rel=0.01)


def test_layers_of_glue_add_up_in_series():
    both = Chain(1e5, 80.0, 0.025, 0.01).glued(2e8, 0.1).glued(6e8)
    assert [1 / each for each in both.compliances] == pytest.approx([1.5e8, 1.5e8])
    assert both.glue_mass == pytest.approx(0.1)


def test_the_cause_that_predicts_held_out_data_comes_first():
    near, ahead, far = ("near",), ("ahead",), ("far",)
    evidence = {(): -500.0, ahead: 0.0, near: -21.0, far: -400.0, UNKNOWN: -300.0}
    comparison = ModelComparison(None, dict.fromkeys((near, ahead, far)), evidence, 3)
    assert comparison.near == [ahead, near]
    log_scores = {ahead: -1500.0, near: -600.0, far: -100.0}
    checked = comparison.with_held_out({names: Shrinkage(9.0, 1.0, "", s) for names, s in log_scores.items()})
    # relative to the best of the near causes, and never more than 0
    assert checked.held_out == {ahead: -900.0, near: 0.0, far: 0.0}
    assert checked.ranked[0] == near
    assert comparison.score(near) == checked.score(near)


@pytest.mark.parametrize(("free", "first"), [(-700.0, ("known",)), (-550.0, UNKNOWN)])
def test_a_known_law_must_foretell_held_out_data_as_well_as_a_free_one(free, first):
    known = ("known",)
    evidence = {(): -500.0, known: 0.0, UNKNOWN: -40.0}
    comparison = ModelComparison(None, {known: None}, evidence, 3, free=Shrinkage(9.0, 1.0, "", free))
    checked = comparison.with_held_out({known: Shrinkage(9.0, 1.0, "", -600.0)})
    assert checked.ranked[0] == first
    # what is free is never behind by that: it knows the place only
    assert checked.score(UNKNOWN) == comparison.score(UNKNOWN)


def test_a_known_gap_of_the_nominal_model_is_not_made_again():
    joint = joint_bench()
    hypotheses = (joint, joint.with_effects(EFFECTS["channel_gain"]()))
    nominal, gain = (fit(hypothesis, np.zeros(len(joint.parameters))) for hypothesis in hypotheses)
    (made,) = cross_validate(nominal, [gain])
    (given,) = cross_validate(nominal, [gain], known=made)
    assert given == made
    # the gap of all is that of the parts, but for what is stated of the laboratory
    n = sum(part.n for part in made.parts)
    for gap, of_all in ((0, made.before), (1, made.after)):
        of_parts = sum(part[gap] * part.n for part in made.parts) / n
        assert n == made.n
        assert of_parts <= of_all < of_parts + 0.2
    (other,) = cross_validate(nominal, [gain], known=replace(made, before=2.5))
    assert (other.before, other.after, other.log_score) == (2.5, made.after, made.log_score)


@pytest.mark.parametrize(
    ("behind", "gap", "verdict"), [(30.0, 1000.0, "effect"), (10.0, 1000.0, "unknown"), (10.0, 8.0, "effect")]
)
def test_a_known_cause_must_be_well_ahead_of_a_free_law_that_is_ahead_of_none(behind, gap, verdict):
    """By odds of 20 to 1; a free law that is behind the nominal model is no rival."""
    names = ("channel_gain",)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted = fit_effects(nominal, {names[0]: EFFECTS[names[0]]()})
    evidence = {(): -10.0 - gap, names: -10.0, UNKNOWN: -10.0 - behind}
    comparison = ModelComparison(nominal, fitted, evidence, 1)
    decision = decide(comparison, {names: Shrinkage(100.0, 1.0, "all")})
    assert decision.verdict == verdict, decision.reason
    assert decision.best == names
    if verdict == "unknown":
        assert "hardly better" in decision.reason
        assert decision.probability(comparison) == RIGHT_DOUBTED
        assert decision.group == [UNKNOWN, names]


@pytest.mark.parametrize(
    ("behind", "more", "first", "verdict"),
    [(9.5, 10.0, "reading", "effect"), (8.0, 10.0, "reading", "unknown"), (9.5, 10.0, "beside", "unknown"),
     (2.0, 2.0, "reading", "unknown"), (12.0, -1.0, "reading", "effect")],
)  # fmt: skip
def test_a_small_lead_suffices_where_a_free_law_at_the_place_costs_little(behind, more, first, verdict):
    """Nearly all of what that pays more, and 3 nats, priors included; the place with the most evidence only."""
    names = ("channel_gain",)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted = fit_effects(nominal, {names[0]: EFFECTS[names[0]]()})
    free = SimpleNamespace(parameter_cost=fitted[names].parameter_cost + more)
    kinds = places_of(nominal.hypothesis.kind)
    order = dict.fromkeys([first, "reading", "beside"])
    places = {
        name: SimpleNamespace(place=kinds[name](), log_evidence=-10.0 - behind, explanation=free) for name in order
    }
    evidence = {(): -1010.0, names: -10.0, UNKNOWN: -10.0 - behind}
    comparison = ModelComparison(nominal, fitted, evidence, 1, places=places)
    decision = decide(comparison, {names: Shrinkage(100.0, 1.0, "all")})
    assert decision.verdict == verdict, decision.reason


def test_what_an_effects_parameters_cost():
    """Of a size that the data tell about: the prior's standard deviation over the posterior's."""
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    assert nominal.parameter_cost == 0
    (found,) = fit_effects(nominal, {"channel_gain": EFFECTS["channel_gain"]()}).values()
    index = [p.name for p in found.hypothesis.parameters].index("channel_gain.gain")
    assert found.parameter_cost == pytest.approx(-0.5 * np.log(found.minimum.covariance[index, index]))
    assert found.parameter_cost > 0


@pytest.mark.parametrize(("lead", "verdict"), [(-5.0, "effect"), (1.0, "effect"), (5.0, "unknown")])
def test_nothing_simple_at_its_place_is_ahead_of_the_cause(monkeypatch, lead, verdict):
    monkeypatch.setattr(decision_module, "lack_of_fit", lambda *_, **__: "")
    names, place = ("channel_gain",), Reading()
    free = {"reading": SimpleNamespace(place=place, log_evidence=-40.0)}
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2]))
    comparison = ModelComparison(nominal, {names: None}, {(): -900.0, names: -10.0, UNKNOWN: -40.0}, 1, places=free)
    named = Decision("effect", names, [names], "channel gain explains the gap")
    term = SimpleNamespace(place=place, log_evidence=-10.0 + lead)
    decision = beside_simple_term(named, comparison, {}, term)
    assert decision.verdict == verdict
    if verdict == "unknown":
        assert decision.best == UNKNOWN
        assert f"a simple law of its own {place.title} does so better" in decision.reason
        assert decision.least_probability == RIGHT_GUARDED
        assert decision.group == [UNKNOWN, names]
        # what held-out data speak against is nobody's rival
        worse = {names: Shrinkage(1.0, 9.0, "each")}
        assert beside_simple_term(named, comparison, worse, term).group == [UNKNOWN]


@pytest.mark.parametrize(
    ("second", "misfit", "verdict"),
    [((40.0, 44.0, 60), "", "unknown"), ((40.0, 44.0, 60), "leaves a misfit", "effect"),
     ((40.0, 39.0, 60), "", "effect"), ((0.4, 0.6, 60), "", "effect"), ((0.6, 0.7, 60), "", "effect")],
)  # fmt: skip
def test_a_cause_that_fits_makes_no_part_of_the_held_out_data_worse(monkeypatch, second, misfit, verdict):
    """However far it shrinks the gap of all: that of one part may be a hundred times as large as the others'."""

    def lack_of_fit(_, *, is_misfit_allowed=False):
        return "" if is_misfit_allowed else misfit

    monkeypatch.setattr(decision_module, "lack_of_fit", lack_of_fit)
    names = ("channel_gain",)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted = fit_effects(nominal, {names[0]: EFFECTS[names[0]]()})
    comparison = ModelComparison(nominal, fitted, {(): -9000.0, names: -10.0, UNKNOWN: -90.0}, 1)
    parts = (Part(11488.0, 7.6, 60), Part(*second))
    found = decide(comparison, {names: Shrinkage(5764.0, 25.8, "each", noise=0.5, parts=parts)})
    assert found.verdict == verdict, found.reason
    assert ("foretold worse than without" in found.reason) == (verdict == "unknown")


@pytest.mark.parametrize(("after", "group"), [(0.6, [UNKNOWN, ("a",)]), (1.0, [UNKNOWN])])
def test_a_gap_that_held_out_data_show_where_there_was_none(monkeypatch, after, group):
    """In units of what noise leaves: here half of what is stated."""
    monkeypatch.setattr(decision_module, "lack_of_fit", lambda *_, **__: "")
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2], held_out_decides=True))
    comparison = ModelComparison(nominal, {("a",): None}, {(): -900.0, ("a",): -10.0, UNKNOWN: -11.0}, 1)
    shrinkages = {("a",): Shrinkage(0.6, after, "each", noise=0.5)}
    term = SimpleNamespace(place=Reading(), log_evidence=0.0)
    named = Decision("effect", ("a",), [("a",)], "")
    assert beside_simple_term(named, comparison, shrinkages, term).group == group


def test_all_causes_that_are_tied_are_checked_on_held_out_data(monkeypatch):
    """Of more than are near: one that was not checked would count as if it foretold them as well as any."""
    names = [(name,) for name in "abcdefgh"]
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2], held_out_decides=True))
    evidence = {(): -900.0, UNKNOWN: -500.0} | {one: -float(i) for i, one in enumerate(names)}
    comparison = ModelComparison(nominal, {one: one for one in names}, evidence, len(names))
    monkeypatch.setattr(ModelComparison, "noise", 1.0)

    def foretold(nominal, fits, executor, before, noise):
        return [Shrinkage(9.0, 1.0, "each", 0.0 if fit in names[:2] else -20.0) for fit in fits]

    monkeypatch.setattr(assessment, "cross_validate", foretold)
    checked, shrinkages = assessment._on_held_out_data(comparison, None)
    assert comparison.near == names[:5]
    assert [*shrinkages] == names[:6]  # the others are farther behind than a tie
    assert checked.tied_with(checked.ranked[0]) == names[:2]


@pytest.mark.parametrize(
    ("name", "is_bent", "is_rival"),
    [("channel_gain", True, True), ("channel_gain", False, False), ("crosstalk", True, False)],
)
def test_a_simple_term_is_a_rival_of_a_bent_law_whose_shape_is_known(name, is_bent, is_rival):
    names = (name,)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted, places = fit_effects(nominal, {name: EFFECTS[name]()}), fit_places(nominal, names=["reading"])
    error = LowRank.of(np.zeros((nominal.minimum.residual.size, 1)))
    fitted = {names: replace(fitted[names], errors=error if is_bent else None)}
    place = {"reading": places["reading"], "added_reading": places["reading"]}
    comparison = ModelComparison(nominal, fitted, {(): -900.0, names: -10.0}, 1, places=place)
    term = rival_term(comparison, Decision("effect", names, [names], ""))
    assert (term is not None) == is_rival
    if term is not None:  # the gain, which no simple term is better than
        assert (term.form.terms[0].kind, term.form.terms[0].order) == ("power", 0)
        assert term.log_evidence < fitted[names].log_evidence + FORM_AHEAD


def gain_and_delay():
    """A nominal model of data with a wrong gain, the fit with that, and one with a delay as well; the names of both."""
    gain, delay = EFFECTS["channel_gain"](), EFFECTS["channel_delay"]()
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    single = fit_effects(nominal, {gain.name: gain})[gain.name,]
    pair = fit(nominal.hypothesis.with_effects(gain, delay), single.minimum.z)
    return nominal, single, pair, (gain.name, delay.name)


@pytest.mark.parametrize(("lead", "gap", "named"), [(100.0, 1000.0, 2), (20.0, 1000.0, 1), (100.0, 2e5, 1)])
def test_two_effects_are_named_where_the_second_adds_much(lead, gap, named):
    """More than 36 nats, and more than what a law that is a little wrong leaves of the gap."""
    nominal, single, pair, two = gain_and_delay()
    one = two[:1]
    evidence = {(): -gap, one: -10.0 - lead, two: -10.0, UNKNOWN: -500.0}
    comparison = ModelComparison(nominal, {one: single, two: pair}, evidence, 1)
    shrinkages = {one: Shrinkage(100.0, 3.0, "all"), two: Shrinkage(100.0, 1.0, "all")}
    decision = decide(comparison, shrinkages)
    assert decision.verdict == "effect", decision.reason
    assert len(decision.best) == named


def test_something_unknown_is_no_sum_of_effects():
    one = ("channel_gain",)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted = fit_effects(nominal, {one[0]: EFFECTS[one[0]]()})
    evidence = {(): -1000.0, one: -500.0, UNKNOWN: -10.0}
    decision = decide(ModelComparison(nominal, fitted, evidence, 1), {one: Shrinkage(100.0, 50.0, "all")})
    assert (decision.verdict, decision.best) == ("unknown", UNKNOWN)


@pytest.mark.parametrize(
    ("decides", "n", "verdict"), [(False, 30, "effect"), (False, 999, "unknown"), (True, 30, "unknown")]
)
def test_few_levels_leave_the_shrinkage_a_scatter(monkeypatch, decides, n, verdict):
    """86 % of a gap of ten times the noise: within 1.6 standard deviations of 90 % for 30 data, and not for many."""
    names = ("channel_gain",)
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    fitted = fit_effects(nominal, {names[0]: EFFECTS[names[0]]()})
    monkeypatch.setattr(type(nominal.hypothesis), "held_out_decides", decides)
    evidence = {(): -1000.0, names: -10.0, UNKNOWN: -500.0}
    comparison = ModelComparison(nominal, fitted, evidence, 1)
    shrinkage = Shrinkage(11.0, 2.4, "all", n=n)
    assert shrinkage.scatter == pytest.approx(np.sqrt(2 / n) / 10)
    decision = decide(comparison, {names: shrinkage})
    assert decision.verdict == verdict, decision.reason


@pytest.mark.parametrize(("behind", "share", "named"), [(3.0, 0.95, 1), (3.0, 0.5, 2), (8.0, 0.95, 2)])
def test_a_single_effect_that_is_tied_with_two_others_is_named(behind, share, named):
    """Where it explains held-out data, too."""
    nominal, other, pair, two = gain_and_delay()
    single = ("other",)
    prior = ModelComparison(nominal, {}, {single: 0.0, two: 0.0}, 4)
    ahead = prior.score(single) - prior.score(two)
    evidence = {(): -1000.0, single: -10.0 - ahead - behind, two: -10.0, UNKNOWN: -500.0}
    comparison = ModelComparison(nominal, {single: other, two: pair}, evidence, 4)
    shrinkages = {single: Shrinkage(100.0, 100.0 - 99.0 * share, "all"), two: Shrinkage(100.0, 1.0, "all")}
    decision = decide(comparison, shrinkages)
    assert decision.verdict == "effect", decision.reason
    assert len(decision.best) == named
    assert (two in decision.group) or named == 2


def test_two_effects_at_one_place_count_once_there():
    both = ("skin", "delamination")
    fitted = SimpleNamespace(hypothesis=SimpleNamespace(effects=[EFFECTS[name]() for name in both]))
    evidence = {(): -500.0, both: 0.0, UNKNOWN: -500.0}
    places = {"faces": SimpleNamespace(log_evidence=-490.0)}
    comparison = ModelComparison(
        SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2])), {both: fitted}, evidence, 2, places
    )
    assert comparison.place_probabilities(comparison.probabilities())["faces"] == pytest.approx(1.0)


def decided(monkeypatch, evidence, refuted=()):
    """Return the decision between hypotheses of which the evidence is stated."""
    fitted = {
        names: SimpleNamespace(names=names, minimum=SimpleNamespace(cost_per_datum=1.0))
        for names in evidence
        if names not in ((), UNKNOWN)
    }
    hypothesis = SimpleNamespace(data=[1, 2], held_out_decides=True)
    nominal = SimpleNamespace(hypothesis=hypothesis, minimum=SimpleNamespace(cost_per_datum=9.0))
    monkeypatch.setattr(decision_module, "lack_of_fit", lambda f, **_: "leaves a misfit" if f.names in refuted else "")
    comparison = ModelComparison(nominal, fitted, evidence, 18)
    vars(comparison)["p_value"] = 0.0
    return decide(comparison, {names: Shrinkage(100.0, 1.0, "all") for names in fitted})


def test_probabilities_of_places_are_those_of_the_verdict():
    """A refuted cause counts as little at its place as in the verdict."""
    known = ("sensor_mass",)
    fitted = SimpleNamespace(hypothesis=SimpleNamespace(effects=[EFFECTS["sensor_mass"]()]))
    free = {
        name: SimpleNamespace(place=PLACES[name](), log_evidence=evidence, explanation=None)
        for name, evidence in (("faces", -130.0), ("top_plate", -150.0))
    }
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2]))
    comparison = ModelComparison(nominal, {known: fitted}, {(): -500.0, known: -100.0, UNKNOWN: -131.0}, 2, free)
    decision = Decision("unknown", known, [UNKNOWN], "leaves a misfit", RIGHT_GUARDED)
    places = comparison.place_probabilities(decision.probabilities(comparison))
    assert list(places) == ["faces", "top_plate"]
    assert places["faces"] + places["top_plate"] == pytest.approx(1.0, abs=0.01)
    assert places["faces"] == pytest.approx(RIGHT_GUARDED, abs=0.05)


A, B, A_AND_B = ("a",), ("b",), ("a", "b")


@pytest.mark.parametrize(
    ("evidence", "refuted", "group"),
    [
        ({A: 6.0, B: -300.0, UNKNOWN: 8.0}, (), [UNKNOWN, A]),
        ({A: 2.0, B: -300.0, UNKNOWN: 90.0}, (), [UNKNOWN]),
        ({A: 40.0, B: -300.0, UNKNOWN: -9000.0}, (A,), [UNKNOWN]),  # what is refuted is not as near
        ({A: -20.0, A_AND_B: 0.0, B: -300.0, UNKNOWN: -22.0}, (), [UNKNOWN, A]),  # nor two beside one of them
        ({A: 6.0, B: 5.9, UNKNOWN: 8.0}, (), [UNKNOWN, A, B]),
        ({A: 6.0, B: 5.9, UNKNOWN: 8.0}, (B,), [UNKNOWN, A]),
    ],
)
def test_the_group_of_an_unknown_cause(monkeypatch, evidence, refuted, group):
    decision = decided(monkeypatch, {(): -500.0, **evidence}, refuted)
    assert decision.verdict == "unknown", decision.reason
    assert decision.group == group
    assert ("not certain" in sentence(decision, 0.5)) == (len(group) > 1)


@pytest.mark.parametrize(
    ("after", "misfit", "share", "causal", "objection"),
    [
        (1.0, "", 0.99, True, ""),
        (1.0, "", 0.28, True, "shrinks the gap on held-out data by 28 % only"),
        (16.0, "leaves a misfit", 0.97, True, "leaves a misfit"),
        (1.05, "leaves a misfit", 0.99, True, ""),  # of a huge gap no law is right to a thousandth
        (1.0, "", 0.99, False, "is not that of a causal response"),
        (1.0, "", 0.99, None, ""),
    ],
)
def test_a_law_that_does_not_explain_the_gap_is_told_so(monkeypatch, after, misfit, share, causal, objection):
    nominal = SimpleNamespace(
        hypothesis=SimpleNamespace(data=[1, 2], held_out_decides=True), minimum=SimpleNamespace(cost=10100.0)
    )
    # of a law ten standard deviations large, which is no misfit
    minimum = SimpleNamespace(cost=100.0 * after + 100.0, residual=np.zeros(100), z=np.array([0.0, 10.0]))
    explanation = SimpleNamespace(minimum=minimum, of_effects=lambda: np.array([False, True]))
    free = SimpleNamespace(place=PLACES["faces"](), log_evidence=0.0, explanation=explanation)
    comparison = ModelComparison(nominal, {}, {(): -500.0, UNKNOWN: 0.0}, 2, {"faces": free})
    for module in (goodness_of_fit, decision_module):
        monkeypatch.setattr(module, "lack_of_fit", lambda *_, **__: misfit)
    monkeypatch.setattr(decision_module, "is_causal", lambda _: causal)
    assert objection_to_law(comparison, free, Shrinkage(101.0, 101.0 - 100.0 * share, "one", noise=1.0)) == objection
    shares = comparison.place_probabilities(comparison.probabilities(), RIGHT_PLACE)
    assert sum(shares.values()) == pytest.approx(RIGHT_PLACE)


def test_a_law_that_no_data_ask_for_is_no_explanation():
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2], held_out_decides=True))
    comparison = ModelComparison(nominal, {}, {(): -500.0, UNKNOWN: -499.0}, 2)
    assert objection_to_law(comparison, None, Shrinkage(1.0, 1.0, "")) == "is hardly more probable than no law at all"


def test_a_pair_whose_second_effect_is_not_needed_counts_with_the_first(monkeypatch):
    """It is not told as more probable than the verdict that passed it over."""
    evidence = {A: -20.0, A_AND_B: 0.0, B: -300.0, UNKNOWN: -22.0}
    decision = decided(monkeypatch, {(): -500.0, **evidence})
    fitted = {names: None for names in evidence if names != UNKNOWN}
    nominal = SimpleNamespace(hypothesis=SimpleNamespace(data=[1, 2], held_out_decides=True))
    probabilities = decision.probabilities(ModelComparison(nominal, fitted, {(): -500.0, **evidence}, 18))
    assert decision.best == A
    assert probabilities[A_AND_B] == 0.0
    assert probabilities[UNKNOWN] >= RIGHT_DOUBTED
    assert sum(probabilities.values()) == pytest.approx(1.0)

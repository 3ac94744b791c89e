"""Where something unknown acts: the evidence of every place with a free law, and simple forms of that law."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.fitting import Fitted, begin, best_of, minimise_scaled
from multilayer.diagnosis.places import PLACES, Place
from multilayer.diagnosis.thresholds import SECOND_TERM
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.places import DrawnLaw, SimpleLaw, Term
from multilayer.inference.problem import Scaled

SIZES = (0.03, 0.3)  # standard deviations of a drawn law, in units of the place's scale
_STEPS, _COARSE = 30, 1e-3  # evaluations and relative change of the cost of descents on the way
_LAST, _FINE = 60, 1e-6  # those of the last descent
_BEST, _BEST_FINE = 200, 1e-9  # those of the form that is told
_TERMS = (
    Term("power", 0), Term("power", 1), Term("power", -1), Term("power", 2), Term("power", -2),
    Term("lossy"), Term("fractional"), Term("relaxation"), Term("resonance"),
)  # fmt: skip


@dataclass(frozen=True)
class PlaceFit:
    """A place with a free law.

    Attributes
    ----------
    place : Place
    fitted : Fitted
        With the law's size of the most evidence.
    log_evidence : float
        Averaged over sizes, with a discrepancy as large as the differences of solvers.
    """

    place: Place
    fitted: Fitted
    log_evidence: float

    @property
    def drawn(self) -> DrawnLaw:
        """The law."""
        law: DrawnLaw = self.fitted.hypothesis.effects[-1]
        return law

    @cached_property
    def grid(self) -> RealArray:
        """Frequencies at which the law is told, Hz, shape (n,)."""
        return np.exp(np.linspace(self.drawn.nodes[0], self.drawn.nodes[-1], 61))

    def law(self) -> ComplexArray:
        """Return the most probable law at `grid`, in the place's unit, shape (n,)."""
        return self.drawn.drawn(self.fitted.minimum.z[-2 * len(self.drawn.nodes) :], self.grid)

    def band(self, deviations: float = 1.645) -> tuple[ComplexArray, ComplexArray]:
        """Return ends of the central 90 % intervals of real and imaginary part, shape (n,) each."""
        k = len(self.drawn.nodes)
        covariance = self.fitted.minimum.covariance[-2 * k :, -2 * k :]
        basis = self.drawn.size * self.drawn.basis(self.grid)
        spread = [
            np.sqrt(np.einsum("ni,ij,nj->n", basis, part, basis))
            for part in (covariance[:k, :k], covariance[k:, k:])
        ]
        reach = deviations * (spread[0] + 1j * spread[1])
        return self.law() - reach, self.law() + reach


@dataclass(frozen=True)
class SimpleForm:
    """A place with a law of few parameters.

    Attributes
    ----------
    place : Place
    fitted : Fitted
    log_evidence : float
    """

    place: Place
    fitted: Fitted
    log_evidence: float

    @property
    def form(self) -> SimpleLaw:
        """The law."""
        law: SimpleLaw = self.fitted.hypothesis.effects[-1]
        return law


def fit_places(nominal: Fitted, executor: Executor | None = None) -> dict[str, PlaceFit]:
    """Return every place with a free law, by its label, the one with the most evidence first.

    Of the configurations that might depart by themselves only the one with the largest expected gain is fitted.

    Parameters
    ----------
    nominal : Fitted
        The nominal model of a campaign.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    problem = nominal.hypothesis_as(CampaignProblem)
    places = []
    for _, kind in PLACES.working():
        instances = kind.instances(problem.settings)
        if len(instances) > 1:
            instances = [max(instances, key=partial(_expected_gain, nominal))]
        places += instances
    fits = run_all(call, [partial(_fit_place, nominal, place) for place in places], executor)
    return {fit.place.label: fit for fit in sorted(fits, key=lambda fit: -fit.log_evidence)}


def simple_form(nominal: Fitted, at: PlaceFit, executor: Executor | None = None) -> SimpleForm:
    """Return the sum of at most two simple terms at a place that has the most evidence.

    Parameters
    ----------
    nominal : Fitted
    at : PlaceFit
        The place with a free law.
    executor : Executor, optional
    """
    single = run_all(call, [partial(_fit_form, nominal, at, (term,)) for term in _TERMS], executor)
    best = max(single, key=lambda form: form.log_evidence)
    others = [term for term in _TERMS if term not in best.form.terms and term.kind in ("power", "resonance")]
    double = run_all(call, [partial(_fit_form, nominal, at, (*best.form.terms, term)) for term in others], executor)
    second = max(double, key=lambda form: form.log_evidence)
    chosen = second if second.log_evidence > best.log_evidence + SECOND_TERM else best
    minimum = minimise_scaled(chosen.fitted.hypothesis, chosen.fitted.minimum.z, _BEST, _BEST_FINE)
    fitted = Fitted(chosen.fitted.hypothesis, minimum)
    return SimpleForm(at.place, fitted, tolerant_evidence(fitted))


def _scale(nominal: Fitted, place: Place) -> tuple[float, RealArray]:
    """Return the place's scale, and the frequencies of all data, Hz."""
    problem = nominal.hypothesis_as(CampaignProblem)
    frequency = np.concatenate([data.frequency for data in problem.data])
    centre = np.array([np.sqrt(frequency.min() * frequency.max())])
    return place.scale(problem.settings, abs(problem.modulus(nominal.minimum.z, centre)[0])), frequency


def _at_rest(nominal: Fitted) -> RealArray:
    """Return the nominal coordinates with all stated quantities as stated: without the effect they may be far off."""
    is_nuisance = np.array([p.nuisance for p in nominal.hypothesis.nominal_parameters], dtype=bool)
    return np.where(is_nuisance, 0.0, nominal.minimum.z)


def _expected_gain(nominal: Fitted, place: Place) -> float:
    """Return half the fall of the cost by a free law, to first order."""
    scale, frequency = _scale(nominal, place)
    law = DrawnLaw.at(place, frequency, SIZES[0] * scale)
    z = np.concatenate([nominal.minimum.z, np.zeros(len(law.parameters))])
    residual, jacobian = nominal.hypothesis.with_effects(law).linearised(z)
    gradient = jacobian.T @ residual + z
    return float(0.5 * gradient @ np.linalg.solve(jacobian.T @ jacobian + np.eye(z.size), gradient))


def _fit_place(nominal: Fitted, place: Place) -> PlaceFit:
    scale, frequency = _scale(nominal, place)
    fits: list[Fitted] = []
    for size in SIZES:
        law = DrawnLaw.at(place, frequency, size * scale)
        hypothesis = nominal.hypothesis.with_effects(law)
        starts = [np.concatenate([_at_rest(nominal), np.zeros(len(law.parameters))])]
        for before in fits:
            z = before.minimum.z.copy()
            z[-len(law.parameters) :] *= before.hypothesis.effects[-1].size / law.size
            starts.append(z)
        fits.append(best_of([_descended(hypothesis, start) for start in starts]))
    evidences = [tolerant_evidence(fit) for fit in fits]
    best = fits[int(np.argmax(evidences))]
    return PlaceFit(place, best, float(logsumexp(evidences) - np.log(len(evidences))))


def _descended(hypothesis: Hypothesis, z: RealArray) -> Fitted:
    """Return the minimum reached by continuation: with all errors of the data enlarged at first."""
    residual = hypothesis.residual(z)
    first = max(float(np.sqrt(residual @ residual / residual.size)), 1.0)
    for scale in (first, np.sqrt(first)):
        if scale > 1:
            z = minimise_scaled(Scaled(hypothesis, scale), z, _STEPS, _COARSE).z
    return Fitted(hypothesis, minimise_scaled(hypothesis, z, _LAST, _FINE))


def _fit_form(nominal: Fitted, at: PlaceFit, terms: Sequence[Term]) -> SimpleForm:
    scale, frequency = _scale(nominal, at.place)
    law = SimpleLaw.at(at.place, terms, frequency, scale)
    hypothesis = nominal.hypothesis.with_effects(law)
    count = len(nominal.minimum.z)
    start = at.fitted.minimum.z[:count]
    started = begin(hypothesis, start, others=nominal.minimum.z[None])
    fits = [_descended(hypothesis, z) for z in started.starts]
    best = best_of(fits)
    return SimpleForm(at.place, best, tolerant_evidence(best))

"""Which law a campaign's material follows, how far it departs from it, and moduli that leave both open.

Bayesian model averaging (J. A. Hoeting, D. Madigan, A. E. Raftery & C. T. Volinsky, Stat. Sci. 14, 1999, 382-417): any
law, with a causal deviation of every size, counts by its evidence. A single law is one of these by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import lgamma
from typing import Any

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.law_deviation import LawDeviation
from multilayer.fits.joint.search import settle_all
from multilayer.inference.consistency import birge_ratio
from multilayer.inference.derivative import forward
from multilayer.inference.posterior import Band, Posterior, distinct_modes, laplace, mixed_band
from multilayer.inference.problem import Minimum

AUTO = "auto"
LAWS_COMPARED = (
    ("kelvin_voigt", None),
    ("zener", None),
    ("fractional_zener", None),
    ("havriliak_negami", None),
    ("maxwell", 2),
    ("maxwell", 3),
    ("maxwell", 4),
)
SHARES = (0.0, 0.03, 0.1, 0.3)  # by which the loss factor departs from a law's; all are as probable beforehand
_LOSS = (1e-3, 1.0)  # within which it is one to depart from
_NEGLIGIBLE = 1e-6  # of all probability
_IMPROBABLE = 0.03  # a mode, of one law
_ALIKE = 1e-4  # relative, of moduli: solutions nearer than this are one with its elements exchanged
_LEAST = 1e-30  # in place of the logarithm of no loss
_MOST = 300.0  # of a logarithm


@dataclass(frozen=True, eq=False)
class Candidate:
    """A law with a deviation of one size, as the data have it.

    Attributes
    ----------
    name : str
        Of the law, with its number of elements where it has any.
    problem : CampaignProblem
    minima : sequence of Minimum
        Its solutions, the most probable first.
    """

    name: str
    problem: CampaignProblem = field(repr=False)
    minima: Sequence[Minimum] = field(repr=False)

    @property
    def share(self) -> float:
        """Size of the deviation from the law, relative to its loss factor."""
        return 0.0 if self.problem.deviation is None else self.problem.deviation.share

    @property
    def p_value(self) -> float:
        """Probability of a misfit as large as this if law and stated uncertainties are right."""
        return exceeding(self.minima[0].cost, len(self.minima[0].residual))

    @cached_property
    def modes(self) -> list[Minimum]:
        """Its solutions that are not negligible, the most probable first; one of those that make the same moduli."""
        different: list[tuple[ComplexArray, Minimum]] = []
        f = np.concatenate([data.centres for data in self.problem.data])
        for minimum in distinct_modes(self.minima):
            modulus = self.problem.modulus(minimum.z, f)
            if all(np.max(np.abs(modulus / other - 1)) > _ALIKE for other, _ in different):
                different.append((modulus, minimum))
        return [minimum for _, minimum in different]

    @cached_property
    def log_evidence(self) -> float:
        """Of all its solutions; each stands for all orders of the law's elements, whichever were found."""
        return float(logsumexp([mode.log_evidence for mode in self.modes])) + lgamma(1 + self._exchangeable)

    @property
    def _exchangeable(self) -> int:
        """Number of elements of which none comes before another."""
        if self.problem.space.template.grid:
            return 0
        return max((1 + u.index for u in self.problem.space.unknowns if u.index is not None), default=0)

    def moments_of_modes(self, frequency: RealArray) -> list[tuple[float, ComplexArray, RealArray]]:
        """Return of every mode its share of the probability, E1 + i E2 (n,) and covariance of both (n, 2, 2), Pa."""
        evidence = np.array([mode.log_evidence for mode in self.modes])
        shares = np.exp(evidence - logsumexp(evidence)).tolist()
        return [(share, *self._near(mode, frequency)) for share, mode in zip(shares, self.modes, strict=True)]

    def moments(self, frequency: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return mean of E1 + i E2 (n,) and covariance of both (n, 2, 2), Pa: within modes and between them."""
        return _mixed(self.moments_of_modes(frequency))

    def _near(self, mode: Minimum, frequency: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return E1 + i E2 (n,) and the covariance of both, shape (n, 2, 2), to first order about a solution."""

        def parts(z: RealArray) -> RealArray:
            e = self.problem.own_modulus(z, frequency)
            return np.concatenate([e.real, e.imag], axis=-1)

        # the side that the solution's own derivative was taken on: on a bound the two differ
        value, slope = forward(parts, mode.z)
        slopes = slope.reshape(2, len(frequency), mode.z.size)
        covariance = np.einsum("afi,ij,bfj->fab", slopes, mode.covariance, slopes)
        half = len(frequency)
        return value[:half] + 1j * value[half:], covariance


def with_deviations(name: str, problem: CampaignProblem, minima: Sequence[Minimum]) -> list[Candidate]:
    """Return a law by itself, then with deviations of all `SHARES`, each sought from all modes of the one before."""
    found = [Candidate(name, problem, minima)]
    n, f = len(problem.law_parameters), np.concatenate([data.frequency for data in problem.data])
    modulus = problem.modulus(minima[0].z, f)
    loss = float(np.clip(np.mean(modulus.imag / modulus.real), *_LOSS))
    starts: list[RealArray] = []
    for share in SHARES[1:]:
        deviation = LawDeviation.over(f, share, loss)
        wider = replace(problem, deviation=deviation, end_effect=None)
        if not starts:
            starts = [np.insert(mode.z, n, np.zeros(len(deviation.times))) for mode in found[0].modes]
        near, ends = settle_all(wider, starts)
        found.append(Candidate(name, near, ends))
        starts = [end.z for end in ends]
    return found


@dataclass(frozen=True)
class LawRow:
    """One law beside the others.

    Attributes
    ----------
    law : str
    n_parameters : int
        Of the law.
    chi_square, p_value : float
        Of the law by itself.
    log_evidence : float
        With all deviations; of the most probable law 0.
    probability : float
        Of the law among those compared, equal beforehand.
    deviation : float
        By which the loss factor departs from it in the mean, relative.
    """

    law: str
    n_parameters: int
    chi_square: float
    p_value: float
    log_evidence: float
    probability: float
    deviation: float


@dataclass(frozen=True, eq=False)
class LawMixture:
    """Laws and deviations from them, by their evidence.

    Attributes
    ----------
    candidates : sequence of Candidate
        Of every law first the law by itself.
    """

    candidates: Sequence[Candidate]

    @cached_property
    def weights(self) -> RealArray:
        """Probability of every candidate; all are as probable beforehand."""
        evidence = np.array([candidate.log_evidence for candidate in self.candidates])
        return np.asarray(np.exp(evidence - logsumexp(evidence)))

    @property
    def best(self) -> Candidate:
        """The most probable law, by itself."""
        name = self.rows()[0].law
        return next(candidate for candidate in self.candidates if candidate.name == name)

    @property
    def likeliest(self) -> Candidate:
        """The most probable of all, deviations included."""
        return self.candidates[int(np.argmax(self.weights))]

    @property
    def widening(self) -> float:
        """Birge's ratio of what not even a departure from a law explains, a factor on all deviations; else 1."""
        minimum = self.likeliest.minima[0]
        return birge_ratio(minimum.cost, len(minimum.residual))

    @property
    def _kept(self) -> list[tuple[float, Candidate]]:
        pairs = zip(self.weights.tolist(), self.candidates, strict=True)
        kept = [(weight, candidate) for weight, candidate in pairs if weight > _NEGLIGIBLE]
        total = sum(weight for weight, _ in kept)
        return [(weight / total, candidate) for weight, candidate in kept]

    def moments(self, frequency: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return mean of E1 + i E2 (n,) and covariance of both (n, 2, 2), Pa: within candidates and between them."""
        mean, covariance = _mixed([(weight, *candidate.moments(frequency)) for weight, candidate in self._kept])
        return mean, self.widening**2 * covariance

    def far_modes(self, frequency: RealArray) -> list[tuple[float, ComplexArray]]:
        """Return share of the probability and modulus (n,) of the likeliest candidate's modes, the improbable left out.

        Empty where E1 of none is apart from the first's by more than the standard deviation of both.
        """
        likely = [part for part in self.likeliest.moments_of_modes(frequency) if part[0] > _IMPROBABLE]
        e1 = np.array([modulus.real for _, modulus, _ in likely])
        std = np.sqrt([covariance[:, 0, 0] for _, _, covariance in likely])
        is_apart = bool(np.any(np.abs(e1 - e1[0]) > np.hypot(std, std[0])))
        return [(share, modulus) for share, modulus, _ in likely] if is_apart else []

    def band(self, frequency: RealArray, probability: float, of_best: Posterior | None = None) -> Band:
        """Return the bands of E1 and E2, Pa, and E2/E1, each array of shape (3, n), at frequencies (n,) in Hz.

        Parameters
        ----------
        frequency : array, shape (n,)
        probability : float
        of_best : Posterior, optional
            Of the most probable law by itself; Laplace's when left out.
        """
        best = self.best
        parts = []
        for weight, candidate in self._kept:
            given = of_best if candidate is best else None
            posterior = given or laplace(candidate.problem, candidate.minima, draws=1, checked=0)
            parts.append((weight, posterior, _logarithms(candidate.problem, frequency)))
        low, median, high = mixed_band(parts, probability)
        ends = (median + self.widening * (end - median) for end in (low, median, high))
        return Band(*(np.exp(np.minimum(end, _MOST)) for end in ends))

    def rows(self) -> list[LawRow]:
        """Return the table of laws, the most probable first."""
        groups: dict[str, list[tuple[float, Candidate]]] = {}
        for weight, candidate in zip(self.weights.tolist(), self.candidates, strict=True):
            groups.setdefault(candidate.name, []).append((weight, candidate))
        evidence = {
            name: float(logsumexp([candidate.log_evidence for _, candidate in group])) for name, group in groups.items()
        }
        most = max(evidence.values())
        found = []
        for name, group in groups.items():
            alone = group[0][1]
            share = np.exp([candidate.log_evidence - evidence[name] for _, candidate in group])
            found.append(
                LawRow(
                    name, len(alone.problem.law_parameters), alone.minima[0].cost, alone.p_value,
                    evidence[name] - most, sum(weight for weight, _ in group),
                    float(share @ [candidate.share for _, candidate in group]),
                )
            )  # fmt: skip
        return sorted(found, key=lambda row: -row.log_evidence)

    def departs(self) -> float:
        """Return the probability that the material departs from the most probable law at all."""
        name = self.best.name
        weights = [
            (weight, candidate.share)
            for weight, candidate in zip(self.weights, self.candidates, strict=True)
            if candidate.name == name
        ]
        total = sum(weight for weight, _ in weights)
        return float(sum(weight for weight, share in weights if share) / total)

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the table as plain data."""
        return [vars(row) for row in self.rows()]


def _mixed(parts: Sequence[tuple[float, ComplexArray, RealArray]]) -> tuple[ComplexArray, RealArray]:
    """Return mean (n,) and covariance (n, 2, 2) of complex numbers from weights, means and covariances of parts."""
    mean = np.sum([weight * value for weight, value, _ in parts], axis=0)
    total = np.zeros((*mean.shape, 2, 2))
    for weight, value, covariance in parts:
        apart = np.stack([(value - mean).real, (value - mean).imag], axis=-1)
        total += weight * (covariance + apart[:, :, None] * apart[:, None, :])
    return mean, total


def _logarithms(problem: CampaignProblem, frequency: RealArray) -> Any:
    def logarithms(z: RealArray) -> RealArray:
        e = problem.own_modulus(z, frequency)
        return np.log(np.maximum(np.stack([e.real, e.imag, e.imag / e.real], axis=-2), _LEAST))

    return logarithms

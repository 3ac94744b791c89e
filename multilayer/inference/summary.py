"""The posterior and the identifiability of a fit, by any of the three methods: joint fits and fits of stacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import IndexArray, RealArray
from multilayer.errors import InputError, suggest
from multilayer.inference.identifiability import Derived, Identifiability, identifiability
from multilayer.inference.nested_sampling import nested, require_sampler
from multilayer.inference.posterior import GaussianMixture, Posterior, distinct_modes, laplace
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.profile import Profile, profile_likelihood

LAPLACE = "laplace"
METHODS = (LAPLACE, "profile", "nested")
_DRAWS = 8000  # quantiles of samples are then exact to 0.025 standard deviations
_LEAST_SHARE = 0.3  # effective share of draws below which a reader is warned
_OUTER = 0.9
_FAINT = 1e-3  # probability of a mode below which no profile is taken of it
Tell = Callable[[str], None]


def refuse_unusable(method: str) -> None:
    """Refuse a method that does not exist, or whose package is missing, before anything is computed.

    Raises
    ------
    InputError
    """
    if method not in METHODS:
        raise InputError(f"--posterior: there is no '{method}'; {suggest(method, METHODS)}")
    if method == "nested":
        require_sampler()


@dataclass(frozen=True)
class PosteriorSummary:
    """Intervals of all parameters, and which of them the data determine.

    Attributes
    ----------
    method : str
        One of `METHODS`.
    posterior : Posterior
        For curves.
    identifiability : Identifiability
    """

    method: str
    posterior: Posterior = field(repr=False)
    identifiability: Identifiability

    @property
    def remark(self) -> str:
        """A warning to readers of the intervals; empty where none is needed."""
        share = self.posterior.effective_share if isinstance(self.posterior, GaussianMixture) else 1.0
        if not share < _LEAST_SHARE:
            return ""
        return (
            "the posterior is far from the Gaussian that these intervals suppose (effective share "
            f"{share:.2g}); see what --posterior profile or --posterior nested say"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: evidence, intervals, identifiability and its sentences."""
        entries = self.posterior.to_dict()
        of_method = {name: value for name, value in entries.items() if name not in ("parameters", "method", "profile")}
        intervals = [
            {
                "name": f.name, "unit": f.unit, "nuisance": f.nuisance, "median": f.median,
                "interval_68": list(f.posterior), "interval_90": list(f.posterior_90),
            }
            for f in self.identifiability.findings
        ]  # fmt: skip
        return {
            "posterior": {"method": self.method, **of_method, "remark": self.remark, "parameters": intervals},
            "determination": {**self.identifiability.to_dict(), "sentences": self.identifiability.sentences},
        }


def summarise(
    problem: Problem,
    minima: Sequence[Minimum],
    method: str = LAPLACE,
    *,
    derived: Sequence[Derived] = (),
    draws: int = _DRAWS,
    checked: int | None = None,
    seed: int = 0,
    tell: Tell | None = None,
) -> PosteriorSummary:
    """Return posterior and identifiability of a fit.

    Parameters
    ----------
    problem : Problem
    minima : sequence of Minimum
        The most probable first.
    method : {'laplace', 'profile', 'nested'}
        ``profile`` follows every parameter that is not a nuisance, from every mode that counts; curves then come from
        the profile that departs most from the Gaussians.
    derived : sequence of Derived
        Quantities to report in place of coordinates.
    draws : int
        Samples.
    checked : int, optional
        Points for which Laplace's approximation is checked; see `laplace`.
    seed : int
    tell : callable, optional
        Called with a short text from time to time.
    """
    refuse_unusable(method)
    if method == "nested":
        posterior = nested(problem, seed=seed, tell=tell)
        identified = identifiability(problem, minima[0], posterior=posterior, derived=derived)
        return PosteriorSummary(method, posterior, identified)
    amount = {} if checked is None else {"checked": checked}
    gaussian = laplace(problem, minima, draws=draws, seed=seed, **amount)
    if method == LAPLACE:
        identified = identifiability(problem, minima[0], posterior=gaussian, derived=derived)
        return PosteriorSummary(method, gaussian, identified)
    gaussian = replace(gaussian, marginals={})  # from which profiles depart
    chances = zip(distinct_modes(minima), gaussian.weights, strict=True)
    modes = [mode for mode, chance in chances if chance >= _FAINT]
    profiles = []
    for number, parameter in enumerate(problem.parameters):
        if not parameter.nuisance:
            found = [profile_likelihood(problem, mode, number, draws=draws, seed=seed) for mode in modes]
            profiles.append(found[0] if len(found) == 1 else _mixed(found, modes, np.random.default_rng(seed)))
            if tell is not None:
                tell(f"profile of {parameter.name}")
    chosen = max(profiles, key=lambda profile: _departure(profile, gaussian), default=gaussian)
    identified = identifiability(problem, minima[0], posterior=chosen, profiles=profiles, derived=derived)
    return PosteriorSummary(method, chosen, identified)


def _mixed(profiles: Sequence[Profile], modes: Sequence[Minimum], rng: np.random.Generator) -> Profile:
    """Return the profiles along one parameter from several modes as one, by evidence.

    Each counts where its own mode is the nearest: a profile may lead on from one mode into another, and none may count
    twice. Along the parameter the lowest of the profiles counts.
    """
    first, draws = profiles[0], len(profiles[0].samples)
    samples = np.concatenate([profile.samples for profile in profiles])
    own = np.repeat(np.arange(len(profiles)), draws) == _nearest(samples, modes)
    logs = np.where(own, np.repeat([profile.log_evidence for profile in profiles], draws), -np.inf) - np.log(draws)
    evidence = float(logsumexp(logs))
    share = np.exp(logs - evidence)
    along = samples[:, first.index(first.name)]
    order = np.argsort(along)
    marginal = np.stack([along[order], np.cumsum(share[order]) - share[order] / 2])
    z = np.unique(np.concatenate([profile.z for profile in profiles]))
    costs, misfits = (
        np.array([np.interp(z, p.z, getattr(p, name), left=np.inf, right=np.inf) for p in profiles])
        for name in ("cost", "misfit")
    )
    lowest = np.argmin(costs, axis=0), np.arange(len(z))
    drawn = samples[rng.choice(len(samples), size=draws, p=share / share.sum())]
    return replace(
        first, samples=drawn, log_evidence=evidence, z=z, cost=costs[lowest], misfit=misfits[lowest], marginal=marginal
    )


def _nearest(samples: RealArray, modes: Sequence[Minimum]) -> IndexArray:
    """Return to which mode each sample is nearest, in the standard deviations of that mode."""
    apart = [samples - mode.z for mode in modes]
    squares = [np.einsum("ki,ij,kj->k", d, mode.precision, d) for d, mode in zip(apart, modes, strict=True)]
    return np.asarray(np.argmin(squares, axis=0))


def _departure(profile: Profile, gaussian: GaussianMixture) -> float:
    """Return how far the ends of a profile's interval are from Laplace's, over the width of Laplace's interval."""
    index = profile.index(profile.name)
    quantiles = (0.5 - _OUTER / 2, 0.5 + _OUTER / 2)
    ends, laplace_ends = (np.array([p.coordinate_quantile(index, q) for q in quantiles]) for p in (profile, gaussian))
    return float(np.abs(ends - laplace_ends).max() / np.ptp(laplace_ends))

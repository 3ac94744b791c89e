"""What the data determine and what they do not, in numbers and in words.

Shares of information are the diagonal of the resolution matrix, ``1 - posterior variance / prior variance``: C. D.
Rodgers, Inverse Methods for Atmospheric Sounding, World Scientific 2000, ch. 2; its trace is the number of parameters
that the data determine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from multilayer.inverse.collinear import OPEN, PREFIX, Group, collinear_groups, shown_name
from multilayer.inverse.posterior import Posterior, laplace
from multilayer.inverse.priors import Parameter
from multilayer.inverse.problem import Minimum, Problem
from multilayer.inverse.profile import Profile

Verdict = Literal["determined", "narrowed", "not determined"]
Ends = tuple[bool, bool]
_DETERMINED, _NARROWED = 0.9, 0.2  # least shares of information
_TOGETHER = 0.68


@dataclass(frozen=True)
class Finding:
    """What the data say of one parameter.

    Attributes
    ----------
    name, unit : str
    nuisance : bool
    prior, posterior : (low, high)
        Central 68 % intervals, in the parameter's unit.
    median : float
        After the measurement.
    prior_std, posterior_std : float
        Half the widths of these intervals: standard deviations where the parameter is normal.
    share : float
        Share of information that comes from the data, 0 to 1.
    verdict : {'determined', 'narrowed', 'not determined'}
    open_ends : (below, above) or None
        Whether a profile goes on until only the prior ends it; None where there is no profile.
    text : str
        The same in words.
    """

    name: str
    unit: str
    nuisance: bool
    prior: tuple[float, float]
    posterior: tuple[float, float]
    median: float
    prior_std: float
    posterior_std: float
    share: float
    verdict: Verdict
    open_ends: Ends | None
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Determination:
    """What the data determine.

    Attributes
    ----------
    findings : list of Finding
        In the order of the parameters.
    groups : list of Group
        Combinations known better than their members, the most telling first.
    n_open : int
        Directions of parameter space of which the prior says more than the data.
    """

    findings: list[Finding]
    groups: list[Group]
    n_open: int

    @property
    def n_determined(self) -> float:
        """How many parameters the data determine: the sum of the shares."""
        return sum(finding.share for finding in self.findings)

    @property
    def sentences(self) -> list[str]:
        """All in words; of nuisances only those of which the data say something."""
        told = [f.text for f in self.findings if not f.nuisance or f.verdict != "not determined"]
        return told + [group.text for group in self.groups]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "n_determined": self.n_determined,
            "n_open": self.n_open,
            "parameters": [finding.to_dict() for finding in self.findings],
            "groups": [group.to_dict() for group in self.groups],
        }


def determination(
    problem: Problem, minimum: Minimum, *, posterior: Posterior | None = None, profiles: Sequence[Profile] = ()
) -> Determination:
    """Say what the data determine, from the neighbourhood of a minimum.

    Parameters
    ----------
    problem : Problem
    minimum : Minimum
    posterior : Posterior, optional
        For intervals and correlations; Laplace's at the minimum when left out.
    profiles : sequence of Profile
        Of parameters that the data may bound to one side only, which no curvature at a minimum shows. Their own
        intervals take the place of the posterior's.
    """
    known = posterior or laplace(problem, minimum, draws=2, checked=0)
    covariance, along = known.covariance, {profile.name: profile for profile in profiles}
    findings = [
        _finding(parameter, along.get(parameter.name, known), float(covariance[i, i]))
        for i, parameter in enumerate(problem.parameters)
    ]
    information = minimum.jacobian.T @ minimum.jacobian
    groups = collinear_groups(problem.parameters, minimum.z, information, covariance)
    return Determination(findings, groups, int(np.sum(np.linalg.eigvalsh(information) < OPEN)))


def _finding(parameter: Parameter, known: Posterior, variance: float) -> Finding:
    share = float(np.clip(1 - variance, 0.0, 1.0))
    verdict: Verdict = "determined" if share >= _DETERMINED else "narrowed" if share >= _NARROWED else "not determined"
    open_ends = known.open_ends if isinstance(known, Profile) else None
    before, after = _prior_interval(parameter), known.interval(parameter.name, _TOGETHER)
    widths = (0.5 * (before[1] - before[0]), 0.5 * (after[1] - after[0]))
    return Finding(
        parameter.name, parameter.unit, parameter.nuisance, before, after, known.median(parameter.name), *widths,
        share, verdict, open_ends, _in_words(parameter, known, verdict, open_ends),
    )  # fmt: skip


def _prior_interval(parameter: Parameter) -> tuple[float, float]:
    low, high = parameter.prior.value(np.array([-1.0, 1.0]))
    return float(low), float(high)


def _in_words(parameter: Parameter, known: Posterior, verdict: Verdict, open_ends: Ends | None) -> str:
    name = shown_name(parameter)
    before = span_text(parameter, *_prior_interval(parameter))
    after = span_text(parameter, *known.interval(parameter.name, _TOGETHER))
    low, high = (_plain(parameter, end) for end in known.interval(parameter.name, 0.9))
    if open_ends == (True, True) or (verdict == "not determined" and open_ends in (None, (False, False))):
        return f"the data say nothing about {name} beyond its prior ({before})"
    if open_ends == (False, True):
        return (
            f"{name} is bounded from below only: above {_with_unit(parameter, low)} (95 %); upwards its prior decides"
        )
    if open_ends == (True, False):
        limit = _with_unit(parameter, high)
        return f"{name} is bounded from above only: below {limit} (95 %); downwards its prior decides"
    if verdict == "narrowed":
        return f"data and prior both count for {name}: {after} (prior {before})"
    return f"the data determine {name}: {after}"


def _plain(parameter: Parameter, value: float) -> float:
    return float(np.exp(value)) if parameter.name.startswith(PREFIX) else value


def _with_unit(parameter: Parameter, value: float) -> str:
    return f"{value:.3g} {parameter.unit}".strip()


def span_text(parameter: Parameter, low: float, high: float) -> str:
    """Return the ends of an interval as text, with as many digits as tell them apart; logarithms undone."""
    a, b = _plain(parameter, low), _plain(parameter, high)
    size, apart = max(abs(a), abs(b)), abs(b - a)
    digits = int(np.clip(np.ceil(np.log10(size / apart)) + 2, 3, 8)) if apart > 0 else 3
    return f"{a:.{digits}g} to {b:.{digits}g} {parameter.unit}".strip()

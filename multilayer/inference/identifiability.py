"""What the data determine and what they do not, in numbers and in words.

Shares of information are the diagonal of the resolution matrix, ``1 - posterior variance / prior variance``: C. D.
Rodgers, Inverse Methods for Atmospheric Sounding, World Scientific 2000, ch. 2; its trace is the number of parameters
that the data determine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.collinear import OPEN, PREFIX, Group, collinear_groups, shown_name
from multilayer.inference.least_squares import draw_prior
from multilayer.inference.posterior import Posterior, laplace
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.profile import Profile

Verdict = Literal["determined", "narrowed", "not determined"]
Ends = tuple[bool, bool]
_DETERMINED, _NARROWED = 0.9, 0.2  # least shares of information
_TOGETHER, _NEARLY_ALL = 0.68, 0.9
_PRIOR_DRAWS = 2048


@dataclass(frozen=True)
class Derived:
    """A positive quantity that follows from several coordinates, and is of interest in place of one of them.

    Attributes
    ----------
    replaces : str
        Name of the parameter whose finding it takes the place of.
    name, unit : str
    nuisance : bool
    logarithm : callable
        Maps coordinates of shape (m, n) to the natural logarithm, shape (m,).
    """

    replaces: str
    name: str
    unit: str
    nuisance: bool
    logarithm: Callable[[RealArray], RealArray]


@dataclass(frozen=True)
class Finding:
    """What the data say of one parameter.

    Attributes
    ----------
    name, unit : str
    nuisance : bool
    prior, posterior : (low, high)
        Central 68 % intervals, in the parameter's unit.
    posterior_90 : (low, high)
        After the measurement, of 90 %.
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
    posterior_90: tuple[float, float]
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
class Identifiability:
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


def identifiability(
    problem: Problem,
    minimum: Minimum,
    *,
    posterior: Posterior | None = None,
    profiles: Sequence[Profile] = (),
    derived: Sequence[Derived] = (),
) -> Identifiability:
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
    derived : sequence of Derived
        Quantities to speak of in place of coordinates that mean less to a reader. Combinations (`groups`) are of the
        coordinates all the same.
    """
    known = posterior or laplace(problem, minimum, checked=0)
    covariance, along = known.covariance, {profile.name: profile for profile in profiles}
    instead = {one.replaces: one for one in derived}
    before = draw_prior(len(problem.parameters), _PRIOR_DRAWS, seed=0) if derived else np.empty((0, 0))
    findings = []
    for i, parameter in enumerate(problem.parameters):
        own = along.get(parameter.name, known)
        one = instead.get(parameter.name)
        quantity = _of_parameter(parameter, own, float(covariance[i, i])) if one is None else _of(one, own, before)
        findings.append(_finding(quantity))
    information = minimum.jacobian.T @ minimum.jacobian
    groups = collinear_groups(problem.parameters, minimum.z, information, covariance)
    return Identifiability(findings, groups, int(np.sum(np.linalg.eigvalsh(information) < OPEN)))


@dataclass(frozen=True)
class _Quantity:
    """What a finding is made from; `shown` is how its values are written in words."""

    name: str
    said: str
    unit: str
    nuisance: bool
    before: tuple[float, float]
    after: tuple[float, float]
    outer: tuple[float, float]
    median: float
    share: float
    open_ends: Ends | None
    shown: Callable[[float], float]


def _of_parameter(parameter: Parameter, known: Posterior, variance: float) -> _Quantity:
    ends = parameter.prior.value(np.array([-1.0, 1.0]))
    logarithm = parameter.name.startswith(PREFIX)
    return _Quantity(
        parameter.name, shown_name(parameter), parameter.unit, parameter.nuisance, (float(ends[0]), float(ends[1])),
        known.interval(parameter.name, _TOGETHER), known.interval(parameter.name, _NEARLY_ALL),
        known.median(parameter.name), float(np.clip(1 - variance, 0.0, 1.0)),
        known.open_ends if isinstance(known, Profile) else None, _exp if logarithm else float,
    )  # fmt: skip


def _of(one: Derived, known: Posterior, before: RealArray) -> _Quantity:
    prior, after = one.logarithm(before), one.logarithm(known.samples)
    levels = [0.5 - _TOGETHER / 2, 0.5 + _TOGETHER / 2, 0.5 - _NEARLY_ALL / 2, 0.5 + _NEARLY_ALL / 2, 0.5]
    low, high = np.exp(np.quantile(prior, levels[:2])).tolist()
    ends = np.exp(np.quantile(after, levels)).tolist()
    share = float(np.clip(1 - np.var(after) / np.var(prior), 0.0, 1.0))
    itself = one.name == one.replaces.removeprefix(PREFIX)
    return _Quantity(
        one.name, one.name, one.unit, one.nuisance, (low, high), (ends[0], ends[1]), (ends[2], ends[3]), ends[4],
        share, known.open_ends if isinstance(known, Profile) and itself else None, float,
    )  # fmt: skip


def _exp(value: float) -> float:
    return float(np.exp(value))


def _finding(q: _Quantity) -> Finding:
    verdict: Verdict = (
        "determined" if q.share >= _DETERMINED else "narrowed" if q.share >= _NARROWED else "not determined"
    )
    widths = (0.5 * (q.before[1] - q.before[0]), 0.5 * (q.after[1] - q.after[0]))
    return Finding(
        q.name, q.unit, q.nuisance, q.before, q.after, q.outer, q.median, *widths, q.share, verdict, q.open_ends,
        _in_words(q, verdict),
    )  # fmt: skip


def _in_words(q: _Quantity, verdict: Verdict) -> str:
    before, after = (_span(q, *ends) for ends in (q.before, q.after))
    low, high = (f"{q.shown(end):.3g} {q.unit}".strip() for end in q.outer)
    if q.open_ends == (True, True) or (verdict == "not determined" and q.open_ends in (None, (False, False))):
        return f"the data say nothing about {q.said} beyond its prior ({before})"
    if q.open_ends == (False, True):
        return f"{q.said} is bounded from below only: above {low} (95 %); upwards its prior decides"
    if q.open_ends == (True, False):
        return f"{q.said} is bounded from above only: below {high} (95 %); downwards its prior decides"
    if verdict == "narrowed":
        return f"data and prior both count for {q.said}: {after} (prior {before})"
    return f"the data determine {q.said}: {after}"


def _span(q: _Quantity, low: float, high: float) -> str:
    """Return the ends of an interval as text, with as many digits as tell them apart."""
    a, b = q.shown(low), q.shown(high)
    size, apart = max(abs(a), abs(b)), abs(b - a)
    digits = int(np.clip(np.ceil(np.log10(size / apart)) + 2, 3, 8)) if apart > 0 else 3
    return f"{a:.{digits}g} to {b:.{digits}g} {q.unit}".strip()

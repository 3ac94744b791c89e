"""Identifiability: which parameters the data determine and which they do not, in numbers and in words.

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
from multilayer.inference.collinearity import OPEN, PREFIX, Group, collinear_groups, shown_name
from multilayer.inference.least_squares import draw_prior
from multilayer.inference.posterior import Posterior, laplace
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.profile import Profile

Verdict = Literal["determined", "narrowed", "not determined"]
Ends = tuple[bool, bool]
_DETERMINED, _NARROWED = 0.9, 0.2  # least shares of information
_INNER, _OUTER = 0.68, 0.9  # probabilities of intervals
_PRIOR_DRAWS = 2048
_MOVED = 2.0  # standard deviations from a prior's centre, to where data that say nothing do not move a parameter


@dataclass(frozen=True)
class Derived:
    """A positive quantity derived from several coordinates, and reported in place of one of them.

    Attributes
    ----------
    replaces : str
        Name of the parameter whose finding it replaces.
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
    """What the data tell of one parameter.

    Attributes
    ----------
    name, unit : str
    nuisance : bool
    prior, posterior : (low, high)
        Central intervals of 68 % before and after the measurement, in the parameter's unit.
    posterior_90 : (low, high)
        Central interval of 90 % after the measurement.
    median : float
        After the measurement.
    prior_std, posterior_std : float
        Half the widths of the intervals of 68 %: standard deviations where the parameter is normal.
    share : float
        Share of information that comes from the data, 0 to 1.
    verdict : {'determined', 'narrowed', 'not determined'}
    open_ends : (below, above) or None
        Whether only the prior limits the parameter to either side, by its profile; None without a profile.
    text : str
        A sentence that says so.
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
    """The findings of all parameters, and collinear groups of them.

    Attributes
    ----------
    findings : list of Finding
        In the order of the parameters.
    groups : list of Group
        Combinations known better than their members, the most informative first.
    n_open : int
        Number of directions of parameter space in which the prior tells more than the data.
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
        """Sentences of all parameters and groups; of nuisances only where the data determine or narrow them."""
        texts = [f.text for f in self.findings if not f.nuisance or f.verdict != "not determined"]
        return texts + [group.text for group in self.groups]

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
    """Return what the data determine, from the neighbourhood of a minimum.

    Parameters
    ----------
    problem : Problem
    minimum : Minimum
    posterior : Posterior, optional
        For intervals and correlations; Laplace's at the minimum when left out.
    profiles : sequence of Profile
        Of parameters that the data may bound to one side only, which the curvature at a minimum does not show. Their
        intervals replace the posterior's.
    derived : sequence of Derived
        Quantities to report in place of coordinates that mean less to a reader. The combinations in `groups` are still
        those of coordinates.
    """
    main = posterior or laplace(problem, minimum, checked=0)
    covariance, by_name = main.covariance, {profile.name: profile for profile in profiles}
    replacements = {quantity.replaces: quantity for quantity in derived}
    before = draw_prior(len(problem.parameters), _PRIOR_DRAWS, seed=0) if derived else np.empty((0, 0))
    findings = []
    for i, parameter in enumerate(problem.parameters):
        best = by_name.get(parameter.name, main)
        if (replacement := replacements.get(parameter.name)) is not None:
            findings.append(_finding(_of_derived(replacement, best, before, parameter, i)))
        else:
            findings.append(_finding(_of_parameter(parameter, best, float(covariance[i, i]), i)))
    information = minimum.jacobian.T @ minimum.jacobian
    groups = collinear_groups(problem.parameters, minimum.z, information, covariance)
    return Identifiability(findings, groups, int(np.sum(np.linalg.eigvalsh(information) < OPEN)))


@dataclass(frozen=True)
class _Quantity:
    """What a finding is made from; `label` and `display` are its name and its values in sentences.

    `moved` is its median in coordinates of its prior, and `bounds` what ends that prior, if anything does.
    """

    name: str
    label: str
    unit: str
    nuisance: bool
    before: tuple[float, float]
    after: tuple[float, float]
    outer: tuple[float, float]
    median: float
    share: float
    open_ends: Ends | None
    display: Callable[[float], float]
    moved: float
    bounds: tuple[float, float] | None


def _of_parameter(parameter: Parameter, posterior: Posterior, variance: float, index: int) -> _Quantity:
    ends = parameter.prior.value(np.array([-1.0, 1.0]))
    logarithm = parameter.name.startswith(PREFIX)
    return _Quantity(
        parameter.name, shown_name(parameter), parameter.unit, parameter.nuisance, (float(ends[0]), float(ends[1])),
        posterior.interval(parameter.name, _INNER), posterior.interval(parameter.name, _OUTER),
        posterior.median(parameter.name), float(np.clip(1 - variance, 0.0, 1.0)),
        posterior.open_ends if isinstance(posterior, Profile) else None, _exp if logarithm else float,
        posterior.coordinate_quantile(index, 0.5), parameter.prior.ends,
    )  # fmt: skip


def _of_derived(
    derived: Derived, posterior: Posterior, before: RealArray, parameter: Parameter, index: int
) -> _Quantity:
    prior, after = derived.logarithm(before), derived.logarithm(posterior.samples)
    levels = [0.5 - _INNER / 2, 0.5 + _INNER / 2, 0.5 - _OUTER / 2, 0.5 + _OUTER / 2, 0.5]
    low, high = np.exp(np.quantile(prior, levels[:2])).tolist()
    ends = np.exp(np.quantile(after, levels)).tolist()
    share = float(np.clip(1 - np.var(after) / np.var(prior), 0.0, 1.0))
    is_parameter = derived.name == derived.replaces.removeprefix(PREFIX)
    bounds = parameter.prior.ends if is_parameter else None
    moved = posterior.coordinate_quantile(index, 0.5) if is_parameter else 0.0
    return _Quantity(
        derived.name, derived.name, derived.unit, derived.nuisance, (low, high),
        (ends[0], ends[1]), (ends[2], ends[3]), ends[4], share,
        posterior.open_ends if isinstance(posterior, Profile) and is_parameter else None, float,
        moved, bounds and (_exp(bounds[0]), _exp(bounds[1])),
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
    low, high = (f"{q.display(end):.3g} {q.unit}".strip() for end in q.outer)
    if q.open_ends == (True, True) or (verdict == "not determined" and q.open_ends in (None, (False, False))):
        return _open_in_words(q, before, after)
    if q.open_ends == (False, True):
        return f"{q.label} is bounded from below only: above {low} (95 %); upwards its prior decides"
    if q.open_ends == (True, False):
        return f"{q.label} is bounded from above only: below {high} (95 %); downwards its prior decides"
    if verdict == "narrowed":
        return f"data and prior both count for {q.label}: {after} (prior {before})"
    return f"the data determine {q.label}: {after}"


def _open_in_words(q: _Quantity, before: str, after: str) -> str:
    """Return what is said of a parameter that the data do not determine, but may have moved."""
    if abs(q.moved) <= _MOVED:
        return f"the data say nothing about {q.label} beyond its prior ({before})"
    if q.bounds is None:
        return f"the data contradict the prior of {q.label} ({before}) and draw it to {after}"
    end, side = (q.bounds[0], "lower") if q.moved < 0 else (q.bounds[1], "upper")
    value = f"{q.display(end):.3g} {q.unit}".strip()
    return f"{q.label} is at the {side} end of its prior, {value}: the data draw it there, and perhaps beyond"


def _span(q: _Quantity, low: float, high: float) -> str:
    """Return the ends of an interval as text, with enough digits to distinguish them."""
    a, b = q.display(low), q.display(high)
    size, width = max(abs(a), abs(b)), abs(b - a)
    digits = int(np.clip(np.ceil(np.log10(size / width)) + 2, 3, 8)) if width > 0 else 3
    return f"{a:.{digits}g} to {b:.{digits}g} {q.unit}".strip()

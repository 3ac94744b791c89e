"""The fit of stacks to measurements: search, least squares, and what the data leave of the unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.experiments.stacks.file import StackFitFile, load_stack_fit, name_of
from multilayer.experiments.stacks.problem import FARTHEST, StackProblem, at_values, own_coordinates
from multilayer.experiments.stacks.unknowns import Unknown
from multilayer.fits.methods import STACKS, Method
from multilayer.fits.stacks.posterior import curve_bands, summary_of
from multilayer.fits.stacks.result import FittedCurve, FoundMinimum, FoundQuantity, StackFitResult, Statements
from multilayer.inference.consistency import birge_ratio
from multilayer.inference.derivative import central
from multilayer.inference.least_squares import distinct, minimise, search
from multilayer.inference.posterior import Posterior
from multilayer.inference.priors import Prior
from multilayer.inference.problem import Minimum
from multilayer.inference.summary import LAPLACE, PosteriorSummary, refuse_unusable

if TYPE_CHECKING:
    from multilayer.fits.sources import StackJob

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(40)
_DRAWS = 2048
_PASSES, _SETTLED = 6, 0.02  # fits with errors of the fit before; standard deviations by which the last one may move
Tell = Callable[[str], None]
Ends = tuple[tuple[float, float], tuple[float, float]]


def fit_stacks(
    source: StackFitFile | str | Path, name: str | None = None, tell: Tell | None = None, posterior: str = LAPLACE
) -> StackFitResult:
    """Fit the unknowns of a stack-fit file.

    Parameters
    ----------
    source : StackFitFile or path
    name : str, optional
        Of the result; see `name_of` when left out.
    tell : callable, optional
        Called with a short text after each start.
    posterior : {'laplace', 'profile', 'nested'}
        Where intervals and bands come from.

    Raises
    ------
    InputError
        When the file cannot be used, or most of what the priors allow has no response.
    """
    file = source if isinstance(source, StackFitFile) else load_stack_fit(source)
    called = name or ("fit" if isinstance(source, StackFitFile) else name_of(Path(source)))
    problem = StackProblem.of_file(file)
    settings = file.model_dump(mode="json", by_alias=True)
    return describe(*reweighed(problem, find_minima(problem, file, tell)), called, settings, posterior, tell)


@dataclass(frozen=True)
class Stacks(Method["StackJob"]):
    """Fields of stacks from measurements of them.

    Attributes
    ----------
    posterior : {'laplace', 'profile', 'nested'}
        Where intervals and bands come from.
    """

    name = STACKS
    title = "fields of stacks"
    summary = "any fields of stacks from tubes, walls, shakers, presses and analysers, with a posterior"
    reads = "stack-fit"
    gives = StackFitResult

    posterior: str = LAPLACE

    def __post_init__(self) -> None:
        refuse_unusable(self.posterior)

    def number_of_steps(self, job: StackJob) -> int:
        """Return how often `run` reports progress."""
        return job.file.search.starts + 1

    def run(self, job: StackJob, tell: Tell) -> StackFitResult:
        """Return the unknowns of a stack-fit file."""
        return fit_stacks(job.file, job.name, tell, self.posterior)


def find_minima(problem: StackProblem, file: StackFitFile, tell: Tell | None = None) -> list[Minimum]:
    """Return the distinct minima, the most probable first."""
    hard = file.search
    found = search(
        problem, [problem.start], n_best=hard.starts, n_candidates=hard.candidates, seed=hard.seed, tell=tell
    )
    if not found:
        raise InputError("unknowns: over most of what the priors allow the stacks have no response; narrow the priors")
    return found


def reweighed(problem: StackProblem, minima: Sequence[Minimum]) -> tuple[StackProblem, list[Minimum]]:
    """Return problem and minima with relative noise and model errors as shares of the fitted values.

    Iteratively reweighted least squares: errors are those at the best minimum of the pass before, and do not change
    within a pass (R. J. Carroll & D. Ruppert, Transformation and Weighting in Regression, Chapman & Hall 1988, ch. 2).
    Without such errors both are returned as they are.

    Parameters
    ----------
    problem : StackProblem
    minima : sequence of Minimum
        With errors as shares of the measured values, see `Observation.weighed_at`.
    """
    ranked = _ranked(minima)
    for _ in range(_PASSES):
        best = ranked[0]
        again = problem.weighed_at(best.z)
        if again is problem:
            break
        problem, ranked = again, _ranked(distinct([minimise(again, minimum.z) for minimum in ranked]))
        moved = ranked[0].z - best.z
        if moved @ ranked[0].precision @ moved < _SETTLED**2:
            break
    return problem, ranked


def _ranked(minima: Sequence[Minimum]) -> list[Minimum]:
    """Return minima in the order of their evidence, data being as uncertain as the misfit of the lowest tells."""
    scale = _scale(minima)
    return sorted(minima, key=lambda minimum: -_widened(minimum, scale).log_evidence)


def describe(
    problem: StackProblem,
    minima: Sequence[Minimum],
    name: str = "fit",
    settings: dict[str, Any] | None = None,
    posterior: str = LAPLACE,
    tell: Tell | None = None,
) -> StackFitResult:
    """Return minima as a result: values, intervals, curves.

    Standard deviations are those of a Gaussian about the best minimum, in the coordinates in which the priors are
    standard normal; intervals and bands are the posterior's, all minima counted. What the model leaves unexplained
    widens both where it is beyond chance: errors of the data grow by the root of chi-square, of data and priors, over
    the number of data (Birge's ratio, see `birge_ratio`). With these errors the first minimum is the most probable.
    """
    scale, minima = _scale(minima), _ranked(minima)
    scaled = [_widened(minimum, scale) for minimum in minima]
    best, covariance = minima[0].z, scaled[0].covariance
    spread = np.sqrt(np.diag(covariance))
    known = summary_of(problem, scaled, scale, posterior, tell)
    return StackFitResult(
        name=name,
        method=STACKS,
        settings=settings or {},
        quantities=_quantities(problem, best, covariance, known),
        correlation=covariance / np.outer(spread, spread),
        minima=_minima(problem, minima, scaled),
        curves=_curves(problem, best, known.posterior),
        scale=scale,
        statements=_statements(problem, minima[0]),
        stacks=at_values(problem, best),
        warnings=problem.warnings(best),
        summary=known,
    )


def _scale(minima: Sequence[Minimum]) -> float:
    lowest = min(minima, key=lambda minimum: minimum.cost)
    return birge_ratio(lowest.cost, lowest.residual.size)


def _widened(minimum: Minimum, scale: float) -> Minimum:
    return replace(minimum, residual=minimum.residual / scale, jacobian=minimum.jacobian / scale)


def _statements(problem: StackProblem, minimum: Minimum) -> Statements:
    """Return what normal and lognormal priors state, and where a minimum moves it."""
    parameters = problem.nominal_parameters
    index = [i for i, parameter in enumerate(parameters) if parameter.prior.kind in ("normal", "lognormal")]
    z = problem.own_coordinates(minimum.z)
    pulls = np.array([_deviations(parameters[i].prior, float(z[i])) for i in index])
    return Statements(tuple(parameters[i] for i in index), pulls, minimum.covariance[np.ix_(index, index)])


def _deviations(prior: Prior, z: float) -> float:
    """Return how far a coordinate is from what a prior states; of a truncated prior that is no coordinate."""
    if prior.bounds is None:
        return z
    value = float(prior.value(z))
    if prior.lognormal is not None:
        return float(np.log(value / prior.lognormal[0]) / prior.lognormal[1])
    assert prior.normal is not None
    return (value - prior.normal[0]) / prior.normal[1]


def _minima(problem: StackProblem, minima: Sequence[Minimum], scaled: Sequence[Minimum]) -> list[FoundMinimum]:
    evidence = np.array([minimum.log_evidence for minimum in scaled])
    shares = np.exp(evidence - evidence.max())
    return [
        FoundMinimum(tuple(_values(problem, m.z).tolist()), m.misfit, m.cost, float(share / shares.sum()), m.converged)
        for m, share in zip(minima, shares, strict=True)
    ]


def _values(problem: StackProblem, z: RealArray) -> RealArray:
    return np.concatenate([unknown.values(own) for unknown, own in problem.parts(problem.own_coordinates(z))], axis=-1)


def _quantities(
    problem: StackProblem, z: RealArray, covariance: RealArray, known: PosteriorSummary
) -> list[FoundQuantity]:
    found: list[FoundQuantity] = []
    for unknown, own in problem.parts(problem.own_coordinates(z)):
        inside = slice(len(found), len(found) + own.size)
        of_unknown = _of_prior if unknown.space is None else _of_law
        # one finding per coordinate, and as many quantities
        ends = [(finding.posterior, finding.posterior_90) for finding in known.identifiability.findings[inside]]
        found += of_unknown(unknown, own, covariance[inside, inside], ends)
    return found


def _of_prior(unknown: Unknown, z: RealArray, covariance: RealArray, ends: list[Ends]) -> list[FoundQuantity]:
    """Return a quantity that is a function of one coordinate."""
    (parameter,), prior = unknown.parameters, unknown.parameters[0].prior
    centre, spread = float(z[0]), float(np.sqrt(covariance[0, 0]))
    left = _std(prior, centre, spread, natural=True) / _std(prior, 0.0, 1.0, natural=True)
    value, std = float(prior.value(centre)), _std(prior, centre, spread)
    intervals = ends[0]
    if abs(centre) > FARTHEST:  # there coordinates are compressed, and so are the ends of their intervals
        shown = prior.value(own_coordinates(prior.coordinate(np.ravel(intervals)), 4, None, FARTHEST)).tolist()
        intervals = ((shown[0], shown[1]), (shown[2], shown[3]))
    return [FoundQuantity(parameter.name, parameter.unit, value, std, intervals, left, parameter.nuisance)]


def _std(prior: Prior, centre: float, spread: float, *, natural: bool = False) -> float:
    """Return the standard deviation of a value whose coordinate is normal; of its logarithm if that is `natural`."""
    values = prior.value(centre + spread * np.clip(_NODES, -8, 8))
    if natural and prior.is_logarithmic:
        values = np.log(values)
    weights = _WEIGHTS / _WEIGHTS.sum()
    return float(np.sqrt(weights @ (values - weights @ values) ** 2))


def _of_law(unknown: Unknown, z: RealArray, covariance: RealArray, ends: list[Ends]) -> list[FoundQuantity]:
    """Return the parameters of a law, whose logarithms follow from several coordinates: to first order."""
    space = unknown.space
    assert space is not None
    logs, slopes = central(lambda points: np.log(unknown.values(points)), z)
    values = np.exp(logs)
    spreads = np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    before = space.logs(space.points(_DRAWS, np.random.default_rng(0))).std(axis=0)
    found = []
    for i, (name, unit) in enumerate(zip(unknown.names, unknown.units, strict=True)):
        std, left = float(values[i] * spreads[i]), float(spreads[i] / before[i])
        found.append(FoundQuantity(name, unit, float(values[i]), std, ends[i], left, unknown.parameters[i].nuisance))
    return found


def _curves(problem: StackProblem, z: RealArray, posterior: Posterior) -> list[FittedCurve]:
    return [
        FittedCurve(
            o.name, o.kind, o.stack, o.unit, o.frequency, o.measured, o.scale.shown(response), o.residual(response),
            band,
        )
        for o, response, band in zip(
            problem.observations, problem.predict(z), curve_bands(problem, z, posterior), strict=True
        )
    ]  # fmt: skip

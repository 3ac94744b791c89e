"""Most probable parameters: nonlinear least squares from many starts, and the distinct minima they end in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.executors import run_all
from multilayer.inference.derivative import FORWARD
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.reparameterisation import Reparameterisation

_CANDIDATES = 128  # points of the prior that are evaluated
_CHUNK = 32
_MOST = 200  # evaluations from a start
_ALIKE = 0.1  # standard deviations: minima nearer than this are the same
TIGHT = 1e-8
_SMALL_STEP = 1e-6  # relative size of a step at which a descent has converged, where the cost need not be more exact
_MARGIN, _ON_BOUND = 1e-9, 1e-6  # of the width between bounds: distance of a start from them, and of a point on them
_UNCOMPETITIVE = 4.0  # times the least cost
_LEVEL = 3e-3  # gradient, per standard deviation, at which a minimum is reached
_BETWEEN, _RENEWALS = 40, 4  # steps after which coordinates are preconditioned anew, and how often
_DAMPING = 1e-2  # of the diagonal, at first
_DECREASE, _INCREASE = 5.0, 5.0  # of the damping, after an accepted and after a refused step
_LEAST_DAMPING, _STUCK = 1e-8, 1e6
_STRIDE = 1.0  # longest step of a coordinate: the prior's standard deviation
_AT_ONCE = 256  # points
_REFUSED, _FREE = 5, 3  # steps refused in a row that end a descent; evaluations since the last that clear its end
_ASTRAY, _ROUGHLY = 1e3, 1e-2  # cost per datum of starts that are far away, and tolerance of their first descent
_SLOW = 2  # accepted steps that gain next to nothing, after which a descent has converged


def minimise(
    problem: Problem,
    start: RealArray,
    most: int = _MOST,
    tolerance: float = TIGHT,
    method: Literal["trf", "dogbox"] = "trf",
    *,
    scaled: bool = False,
) -> Minimum:
    """Return the minimum reached from a start by a trust-region method whose Jacobians cost a batched solve each.

    Parameters
    ----------
    problem : Problem
    start : array, shape (n,)
    most : int
        Evaluations after which it stops where it is.
    tolerance : float
        Relative change of the cost at which it has converged.
    method : {'trf', 'dogbox'}
        Of `scipy.optimize.least_squares`; the second takes fewer steps along curved valleys, and its test of
        convergence is less exact.
    scaled : bool
        Whether the trust region is measured in changes of the residuals instead of standard deviations of the prior;
        needed where residuals are a thousand times as sensitive to some coordinates as to others, as with sharp
        resonances. The steps are then taken in coordinates in which the residuals are straighter, where the problem has
        such; from far away, where the straightest way leads into the next valley, first along the axes.

    Notes
    -----
    The priors are residuals, too: z itself is added to them. Method 'trf': M. A. Branch, T. F. Coleman & Y. Li, SIAM J.
    Sci. Comput. 21 (1999) 1-23.
    """
    settings: dict[str, Any] = {
        "scale": "jac" if scaled else 1.0, "method": method,
        "ftol": tolerance, "xtol": min(_SMALL_STEP, tolerance), "gtol": 1e-6,
    }  # fmt: skip
    z, left = start, most
    if not scaled or problem.reparameterisation(z) is None:
        return _Descent(problem).minimum(z, most=left, **settings)
    if not total_cost(values := problem.residual(z), z) <= _ASTRAY * values.size:
        rough = _Descent(problem)
        z = rough.minimum(z, most=left, **settings | {"ftol": max(tolerance, _ROUGHLY)}).z
        left = max(left - rough.evaluations, 1)
    for far in (False, True):  # where the straightest coordinates end, those that hold farther lead on
        descent = _Descent(problem, problem.reparameterisation(z, far=far), far)
        minimum = descent.minimum(z, most=left, **settings)
        z, left = minimum.z, left - descent.evaluations
        if not descent.is_limited or left < 1:
            break
    return minimum


class _LimitError(Exception):
    """Coordinates end here."""


@dataclass
class _Descent:
    """A descent in the coordinates of a reparameterisation, if there is one.

    Attributes
    ----------
    problem : Problem
    other : Reparameterisation or None
    far : bool
        Whether that holds far from here: what it does not reach is a step too long, and no limit.
    evaluations : int
    refused : int
        Steps beyond the limits of these coordinates, one after the other.
    since : int
        Evaluations since the last of them.
    lowest : Minimum, optional
        The lowest point that was evaluated.
    """

    problem: Problem
    other: Reparameterisation | None = None
    far: bool = False
    evaluations: int = 0
    refused: int = 0
    since: int = 0
    lowest: Minimum | None = None

    @property
    def is_limited(self) -> bool:
        """Whether it has ended where coordinates end that hold nearby."""
        return not self.far and self.since < min(_FREE, self.evaluations)

    def minimum(self, start: RealArray, **settings: Any) -> Minimum:
        """Return the minimum that is reached, or the lowest point before a limit; settings are of `trust_region`."""
        if self.other is None or not self.other.holds(start):
            self.other = None
        try:
            found = trust_region(
                self._linearised, start if self.other is None else self.other.all_of(start), **settings
            )
        except _LimitError:
            assert self.lowest is not None  # a descent begins with finite values
            return replace(self.lowest, converged=False)
        if self.other is not None and self.lowest is None:  # its slopes do not tell z where it starts
            self.other = None
            return self.minimum(start, **settings)
        return replace(self._minimum(found), converged=found.converged and not self.is_limited)

    def _linearised(self, w: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual, the priors' row among it, and its derivative by w; NaN where w has no such."""
        z = w if self.other is None else self.other.all_back(w)
        if not np.all(np.isfinite(z)):
            return self._refused(z.size)
        values, slopes = self.problem.linearised(z)
        minimum = Minimum(z, values, slopes)
        values, slopes = np.concatenate([values, z]), np.concatenate([slopes, np.eye(z.size)])
        by_w = slopes if self.other is None else self.other.by_w(slopes, z)
        if by_w is None:
            return self._refused(z.size)
        self.refused, self.since, self.evaluations = 0, self.since + 1, self.evaluations + 1
        if np.all(np.isfinite(slopes)) and (self.lowest is None or minimum.cost < self.lowest.cost):
            self.lowest = minimum
        return values, by_w

    def _refused(self, n: int) -> tuple[RealArray, RealArray]:
        self.refused, self.since = self.refused + 1, 0
        if self.refused > _REFUSED and not self.far:
            raise _LimitError
        return np.full(1, np.nan), np.full((1, n), np.nan)

    def _minimum(self, found: Minimum) -> Minimum:
        """Return what a descent has found at z."""
        count, z, slopes = len(found.residual) - found.z.size, found.z, found.jacobian
        if self.other is not None:
            z = self.other.all_back(found.z)
            slopes = self.other.by_z(slopes, z)
        return Minimum(z, found.residual[:count], slopes[:count])


def trust_region(
    linearised: Callable[[RealArray], tuple[RealArray, RealArray]],
    start: RealArray,
    *,
    bounds: tuple[RealArray, RealArray] | None = None,
    scale: RealArray | float | Literal["jac"] = 1.0,
    method: Literal["trf", "dogbox"] = "trf",
    most: int = _MOST,
    ftol: float = TIGHT,
    xtol: float = TIGHT,
    gtol: float = TIGHT,
    before: Sequence[tuple[RealArray, float]] = (),
) -> Minimum:
    """Return the minimum of a sum of squares by `scipy.optimize.least_squares`, value and derivative from one call.

    Parameters
    ----------
    linearised : callable
        Residual, shape (m,), and derivative, shape (m, n), at coordinates of shape (n,); no priors are added.
    start : array, shape (n,)
    bounds : (array, array), optional
        Of shape (n,) each; a start on or beyond them is moved inside.
    scale, method, ftol, xtol, gtol
        Those of `least_squares`.
    most : int
        Evaluations after which it stops where it is.
    before : sequence of (array, float)
        History that led to the start, to be continued.

    Returns
    -------
    Minimum
        The start, not converged, where that has no finite residual and derivative: nothing tells which way to go.
    """
    history = list(before)
    last: dict[bytes, tuple[RealArray, RealArray]] = {}

    def both(z: RealArray) -> tuple[RealArray, RealArray]:
        key = np.asarray(z, dtype=float).tobytes()
        if key not in last:  # scipy asks for the derivative after most residuals: both come from one batch
            last.clear()
            values, slopes = linearised(z)
            if not np.all(np.isfinite(slopes)):  # at the edge of where there is a response: no step ends here
                values = np.full_like(values, np.nan)
            last[key] = values, slopes
            history.append((np.array(z), float(np.linalg.norm(last[key][0]))))
        return last[key]

    def residual(z: RealArray) -> RealArray:
        return both(z)[0]

    def derivative(z: RealArray) -> RealArray:
        return both(z)[1]

    low, high = (np.full(start.size, -np.inf), np.full(start.size, np.inf)) if bounds is None else bounds
    if bounds is not None:
        margin = _MARGIN * (high - low)
        start = np.clip(start, low + margin, high - margin)
    if not np.all(np.isfinite(residual(start))):
        return Minimum(start, *both(start), converged=False, history=tuple(history))
    result = least_squares(
        residual, start, jac=derivative, bounds=(low, high), x_scale=scale, method=method,
        max_nfev=most, ftol=ftol, xtol=xtol, gtol=gtol,
    )  # fmt: skip
    values, slopes = np.asarray(result.fun), np.asarray(result.jac)
    at_bound = bool(np.any(np.minimum(result.x - low, high - result.x) < _ON_BOUND * (high - low)))
    return Minimum(result.x, values, slopes, bool(result.success), at_bound, tuple(history))


def minimise_bfgs(problem: Problem, start: RealArray) -> Minimum:
    """Return the minimum reached from near it by quasi-Newton steps (BFGS), which learn the whole Hessian.

    The Gauss-Newton Hessian lacks the second derivatives of the residuals: where a valley is narrow and bent and the
    misfit is large, `minimise` stops on its floor before the lowest point. Steps are taken in coordinates in which the
    Gauss-Newton Hessian is the unit matrix; these are renewed as long as the steps have not converged.

    Parameters
    ----------
    problem : Problem
        Its derivatives must be exact to more digits than `derivative.forward` gives.
    start : array, shape (n,)

    Notes
    -----
    J. Nocedal & S. J. Wright, Numerical Optimization, 2nd ed., Springer 2006, sec. 6.1 and 10.3.
    """
    from scipy.optimize import minimize  # here, since most commands do not need it

    z = np.array(start)
    for _ in range(_RENEWALS):
        _, slopes = problem.linearised(z)
        factor = np.linalg.inv(np.linalg.cholesky(slopes.T @ slopes + np.eye(z.size))).T
        result = minimize(
            partial(_cost_and_slope, problem, z, factor), np.zeros(z.size), jac=True, method="BFGS",
            options={"gtol": _LEVEL, "maxiter": _BETWEEN},
        )  # fmt: skip
        z = z + factor @ result.x
        if result.success:
            break
    values, slopes = problem.linearised(z)
    return Minimum(z, values, slopes, bool(result.success))


def _cost_and_slope(problem: Problem, origin: RealArray, factor: RealArray, u: RealArray) -> tuple[float, RealArray]:
    z = origin + factor @ u
    values, slopes = problem.linearised(z)
    return 0.5 * float(values @ values + z @ z), factor.T @ (slopes.T @ values + z)


def descend(
    residual: Callable[[RealArray], RealArray],
    starts: RealArray,
    most: int,
    tolerance: float = 1e-3,
    moving: int | None = None,
) -> tuple[RealArray, RealArray]:
    """Return where many starts lead by the Levenberg-Marquardt method, all of them advancing together.

    A batch of a hundred points costs little more than a single point, so that many starts at once are cheaper than few
    one after the other. This finds valleys; `minimise` finds their lowest points.

    Parameters
    ----------
    residual : callable
        Whitened residuals, shape (k, n_data), of coordinates of shape (k, n), without the priors' row z.
    starts : array, shape (m, n)
    most : int
        Steps.
    tolerance : float
        Relative fall of the cost below which a step counts as slow; a descent ends with two of them in a row.
    moving : int, optional
        How many of the first coordinates move; the others stay. All move when left out.

    Returns
    -------
    points : array, shape (m, n)
    costs : array, shape (m,)
        Sum of squared residuals and of z squared; infinite where there is no response.

    Notes
    -----
    D. W. Marquardt, J. Soc. Ind. Appl. Math. 11 (1963) 431-441: the damping is in proportion to the diagonal.
    """
    z = np.array(starts, dtype=float)
    values = in_batches(residual, z)
    cost = total_cost(values, z)
    m, n = len(z), z.shape[1] if moving is None else moving
    short = FORWARD * np.eye(n, z.shape[1])
    damping, slow = np.full(m, _DAMPING), np.zeros(m, dtype=int)
    going, moved = np.isfinite(cost), np.ones(m, dtype=bool)
    precision, slope = np.zeros((m, n, n)), np.zeros((m, n))
    for _ in range(most):
        if (new := np.flatnonzero(going & moved)).size:
            ahead = in_batches(residual, (z[new, None] + short).reshape(-1, z.shape[1])).reshape(len(new), n, -1)
            derivative = np.nan_to_num((ahead - values[new, None]) / FORWARD)
            precision[new] = derivative @ derivative.transpose(0, 2, 1) + np.eye(n)
            slope[new] = np.einsum("mid,md->mi", derivative, values[new]) + z[new, :n]
            moved[new] = False
        if not (at := np.flatnonzero(going)).size:
            break
        diagonal = np.einsum("mii->mi", precision[at])
        damped = precision[at] + (damping[at, None] * diagonal)[:, None] * np.eye(n)
        step = -np.linalg.solve(damped, slope[at, :, None])[..., 0]
        trial = z[at]
        trial[:, :n] += step / np.maximum(np.abs(step).max(axis=-1, keepdims=True) / _STRIDE, 1.0)
        tried = in_batches(residual, trial)
        costs = total_cost(tried, trial)
        lower = costs < cost[at]
        accepted, refused = at[lower], at[~lower]
        slow[accepted] = np.where(cost[accepted] - costs[lower] < tolerance * cost[accepted], slow[accepted] + 1, 0)
        z[accepted], values[accepted], cost[accepted], moved[accepted] = trial[lower], tried[lower], costs[lower], True
        damping[accepted] = np.maximum(damping[accepted] / _DECREASE, _LEAST_DAMPING)
        damping[refused] *= _INCREASE
        going &= (slow < _SLOW) & (damping < _STUCK)
    return z, cost


def in_batches(function: Callable[[RealArray], RealArray], points: RealArray) -> RealArray:
    """Return a function's values at points, shape (m, n), computed in batches of limited size."""
    return np.concatenate([function(points[i : i + _AT_ONCE]) for i in range(0, len(points), _AT_ONCE)])


def total_cost(values: RealArray, z: RealArray) -> RealArray:
    """Return the sum of squared residuals and of z squared; infinite where there is no response."""
    cost = np.sum(values**2, axis=-1) + np.sum(z**2, axis=-1)
    return np.asarray(np.where(np.isfinite(cost), cost, np.inf))


def search(
    problem: Problem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = 6,
    n_candidates: int = _CANDIDATES,
    seed: int = 0,
    few: int = _MOST,
    tolerance: float = TIGHT,
    tell: Callable[[str], None] | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima of a problem, the most probable first.

    Parameters
    ----------
    problem : Problem
    starts : sequence of array, shape (n,)
        Points to follow besides the best of those drawn from the prior.
    n_best : int
        How many of these are followed.
    n_candidates : int
        How many are drawn; a power of two fills the prior evenly.
    seed : int
    few : int
        Evaluations after which a start is given up where it is not `is_competitive` with the best so far: most starts
        that need more creep along the floor of a wrong valley.
    tolerance : float
        See `minimise`.
    tell : callable, optional
        Called with a short text after each start.
    executor : Executor, optional
        Where the starts are followed; in this process when left out.
    """
    n = len(problem.parameters)
    points = draw_prior(n, n_candidates, seed)
    costs = np.concatenate([_cost(problem, points[i : i + _CHUNK]) for i in range(0, len(points), _CHUNK)])
    chosen = [*starts, *points[np.argsort(costs, kind="stable")[:n_best]]]
    ends = run_all(
        partial(minimise, problem, most=few, tolerance=tolerance),
        [np.asarray(start, dtype=float) for start in chosen],
        executor,
        lambda index: None if tell is None else tell(f"start {index + 1} of {len(chosen)}"),
    )
    minima: list[Minimum] = []
    for end in ends:
        is_done = end.converged or few >= _MOST or not is_competitive(end, minima)
        minima.append(end if is_done else minimise(problem, end.z, tolerance=tolerance))
    return distinct(minima)


def is_competitive(minimum: Minimum, others: Sequence[Minimum]) -> bool:
    """Tell whether a cost is within four times the least of the others, or four times what noise alone gives."""
    least = min((other.cost for other in others), default=np.inf)
    return bool(minimum.cost <= _UNCOMPETITIVE * max(least, minimum.residual.size))


def draw_prior(n: int, count: int, seed: int) -> RealArray:
    """Return quasi-random points of the prior, shape (count, n), the first of them its centre.

    I. M. Sobol, USSR Comput. Math. Math. Phys. 7 (1967) 86-112.
    """
    from scipy.stats import qmc  # here, since it takes as long to import as all the rest of scipy

    points = ndtri(np.clip(qmc.Sobol(n, rng=np.random.default_rng(seed)).random(count), 1e-9, 1 - 1e-9))
    points[0] = 0.0
    return np.asarray(points)


def _cost(problem: Problem, z: RealArray) -> RealArray:
    return total_cost(problem.residual(z), z)


def distinct(minima: Sequence[Minimum], apart: RealArray | None = None) -> list[Minimum]:
    """Return the lowest minimum of every group of near ones, the lowest first.

    Parameters
    ----------
    minima : sequence of Minimum
    apart : array, shape (n,), optional
        Differences of coordinates within which minima are near; the lowest is then that of the least misfit. When left
        out, minima are near within a tenth of a standard deviation, and the lowest is that of the least cost.
    """

    def level(minimum: Minimum) -> float:
        return minimum.cost if apart is None else minimum.misfit

    def is_near(minimum: Minimum, other: Minimum) -> bool:
        d = minimum.z - other.z
        if apart is not None:
            return bool(np.all(np.abs(d) <= apart))
        return bool(np.sqrt(d @ other.precision @ d) <= _ALIKE * np.sqrt(d.size))

    lowest: list[Minimum] = []
    for minimum in sorted((m for m in minima if np.isfinite(level(m))), key=level):
        if not any(is_near(minimum, other) for other in lowest):
            lowest.append(minimum)
    return lowest

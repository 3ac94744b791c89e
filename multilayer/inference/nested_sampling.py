"""Nested sampling: the evidence and samples of a posterior of any shape, by the package dynesty.

J. Skilling, Bayesian Anal. 1 (2006) 833-859; J. S. Speagle, Mon. Not. R. Astron. Soc. 493 (2020) 3132-3158.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.inference.posterior import Posterior
from multilayer.inference.problem import Problem

_REPORTED = 200  # iterations between two reports
_NO_RESPONSE = -1e300  # ln(likelihood) where the model has no response
_EDGE = 1e-15  # distance kept from the faces of the unit cube


def nested(
    problem: Problem,
    *,
    n_live: int = 400,
    remaining: float = 0.01,
    walks: int | None = None,
    at_once: int = 32,
    seed: int = 0,
    tell: Callable[[str], None] | None = None,
) -> Posterior:
    """Return the posterior by nested sampling over the whole prior.

    Parameters
    ----------
    problem : Problem
    n_live : int
        Live points; the error of the evidence falls with the square root of their number.
    remaining : float
        Stop when the prior volume that remains can add no more than this to ln(evidence).
    walks : int, optional
        Steps of the random walk that finds a new point; by default 20 + n.
    at_once : int
        How many walks advance together, so that one batched residual serves them all; far fewer than live points. 1
        where a residual takes less than about 0.1 ms, which is faster without batches.
    seed : int
    tell : callable, optional
        Called with a short text from time to time.

    Returns
    -------
    Posterior

    Raises
    ------
    InputError
        When dynesty is not installed.
    """
    sampler_type = require_sampler()
    n = len(problem.parameters)
    with _BatchingPool(problem, at_once) as pool:
        sampler = sampler_type(
            pool.log_likelihood, _from_cube, n, nlive=n_live, bound="multi", sample="rwalk", walks=walks or 20 + n,
            rstate=np.random.default_rng(seed), pool=pool, queue_size=at_once,
            use_pool={"prior_transform": False, "update_bound": False},
        )  # fmt: skip
        sampler.run_nested(dlogz=remaining, print_progress=tell is not None, print_func=_reporter(tell))
    results = sampler.results
    samples = results.samples_equal(rstate=np.random.default_rng(seed))
    return Posterior("nested", problem.parameters, samples, float(results.logz[-1]), float(results.logzerr[-1]))


def require_sampler() -> Any:
    """Return dynesty's sampler.

    Raises
    ------
    InputError
        When it is not installed.
    """
    try:
        from dynesty import NestedSampler
    except ImportError:
        raise InputError("nested sampling needs dynesty: pip install 'multilayer[bayes]'") from None
    return NestedSampler


def _from_cube(u: RealArray) -> RealArray:
    return np.asarray(ndtri(np.clip(u, _EDGE, 1 - _EDGE)))


def _reporter(tell: Callable[[str], None] | None) -> Callable[..., None]:
    """Return a function that dynesty calls after every iteration."""

    def report(results: Any, iteration: int, calls: int, **_: object) -> None:
        if tell is not None and iteration % _REPORTED == 0:
            evidence = f"ln(evidence) {results.logz:.2f} (+{results.delta_logz:.2f})"
            tell(f"iteration {iteration}, {calls} evaluations: {evidence}")

    return report


class _BatchingPool:
    """A pool of random walks whose likelihoods are computed in batches, as soon as all walks wait for one.

    dynesty asks for the likelihood of one point at a time, in as many walks as its pool maps; each walk is a thread
    here. Every walk has random numbers of its own, and batches are in the order of the walks, so that results repeat to
    the last bit.
    """

    def __init__(self, problem: Problem, size: int) -> None:
        self._problem, self._size = problem, size
        self._threads = ThreadPoolExecutor(size)
        self._changed = threading.Condition()
        self._walk = threading.local()
        self._waiting: dict[int, RealArray] = {}
        self._answers: dict[int, float] = {}
        self._running = 0
        self._failed = False

    def __enter__(self) -> _BatchingPool:
        return self

    def __exit__(self, *_: object) -> None:
        self._threads.shutdown(wait=True, cancel_futures=True)

    def map(self, function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        """Return the function of every item, in order; what dynesty asks of a pool."""
        if self._size == 1:
            return [function(item) for item in items]
        jobs, results = list(items), []
        for i in range(0, len(jobs), self._size):
            part = jobs[i : i + self._size]
            self._running = len(part)
            futures = [self._threads.submit(self._run, number, function, job) for number, job in enumerate(part)]
            self._serve()
            results += [future.result() for future in futures]
        return results

    def log_likelihood(self, z: RealArray) -> float:
        """Return the logarithm of the likelihood of one point; called from the walks."""
        if self._size == 1:
            return self._log_likelihoods(z[None])[0]
        number = self._walk.number
        with self._changed:
            self._waiting[number] = z
            self._changed.notify_all()
            self._changed.wait_for(lambda: number in self._answers or self._failed)
            if self._failed:
                raise RuntimeError("the residual of another walk's point failed")
            return self._answers.pop(number)

    def _run(self, number: int, function: Callable[[Any], Any], job: Any) -> Any:
        self._walk.number = number
        try:
            return function(job)
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()

    def _serve(self) -> None:
        """Answer until no walk runs any more."""
        with self._changed:
            while True:
                self._changed.wait_for(lambda: len(self._waiting) == self._running)
                if not self._running:
                    return
                walks = sorted(self._waiting)
                self._answers.update(zip(walks, self._answered(walks), strict=True))
                self._waiting.clear()
                self._changed.notify_all()

    def _answered(self, walks: list[int]) -> list[float]:
        try:
            return self._log_likelihoods(np.stack([self._waiting[walk] for walk in walks]))
        except BaseException:
            self._failed = True  # let the walks, none of which gets an answer, end before the error is raised
            self._changed.notify_all()
            raise

    def _log_likelihoods(self, z: RealArray) -> list[float]:
        misfit = np.sum(self._problem.residual(z) ** 2, axis=-1)
        return [float(v) for v in np.where(np.isfinite(misfit), -0.5 * misfit, _NO_RESPONSE)]

"""A smooth discrepancy of unknown origin: its evidence against dense matrices."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.goodness_of_fit import misfit_p_value
from multilayer.diagnosis.model_discrepancy import smooth_basis
from multilayer.diagnosis.thresholds import UNKNOWN_SIZES
from multilayer.diagnosis.unknown_cause import discrepancy_evidence
from multilayer.inference.problem import Minimum

FREQUENCY = np.geomspace(50.0, 800.0, 24)
SPREAD = 0.01  # standard deviation of ln(ratio)


def linear(offset: RealArray, slopes: RealArray) -> Fitted:
    """Return the fit of a model whose residual is ``offset + slopes z``."""
    precision = slopes.T @ slopes + np.eye(slopes.shape[1])
    z = -np.linalg.solve(precision, slopes.T @ offset)
    residual = offset + slopes @ z

    def whiten(values: Any) -> RealArray:
        return np.concatenate([values.real, values.imag], axis=-1) / SPREAD

    experiments = [SimpleNamespace(whiten=whiten)]
    hypothesis: Any = SimpleNamespace(
        data=[SimpleNamespace(frequency=FREQUENCY)], experiments=experiments, part_units=(1.0, 1j), unit=1.0
    )
    return Fitted(hypothesis, Minimum(z, residual, slopes))


def problem(strength: tuple[float, ...]) -> tuple[RealArray, RealArray]:
    """Return a residual that is smooth but for noise, and slopes of some strengths, in standard deviations."""
    rng = np.random.default_rng(4)
    smooth = np.concatenate([np.sin(np.log(FREQUENCY)), np.cos(2 * np.log(FREQUENCY))])
    shapes = np.concatenate([np.log(FREQUENCY / 200.0)[None], rng.standard_normal((2, 24))])
    slopes = np.concatenate([shapes, shapes[::-1]], axis=1).T * np.array(strength)
    return 3 * smooth + rng.standard_normal(48), slopes


@pytest.mark.parametrize("size", [1e-4, 0.01, 0.08])
@pytest.mark.parametrize("strength", [(1e3, 1.0, 0.1), (5.0, 3.0, 1e-9)])
def test_evidence_of_a_discrepancy_is_that_of_the_dense_covariance(size: float, strength: tuple[float, ...]) -> None:
    offset, slopes = problem(strength)
    fitted = linear(offset, slopes)
    nominal = np.eye(48) + slopes @ slopes.T
    left = size * np.linalg.solve(nominal, smooth_basis(fitted.hypothesis))
    covariance = nominal + left @ left.T
    exact = -0.5 * (offset @ np.linalg.solve(covariance, offset) + np.linalg.slogdet(covariance)[1])
    assert discrepancy_evidence(fitted, (size,)) == pytest.approx(exact, abs=1e-6)


def test_an_undetermined_unknown_absorbs_no_discrepancy() -> None:
    """The direction of slopes that are rounding is another one on every machine; projected off, it cost nats."""
    offset, slopes = problem((30.0, 3.0, 1e-7))
    rounded = slopes.copy()
    rounded[:, 2] = 1e-7 * np.random.default_rng(1).standard_normal(48)
    one, other = linear(offset, slopes), linear(offset, rounded)
    exact, found = (discrepancy_evidence(fitted, UNKNOWN_SIZES) for fitted in (other, one))
    assert found == pytest.approx(exact, abs=1e-6)
    assert misfit_p_value(one, 0.01) == pytest.approx(misfit_p_value(other, 0.01), rel=1e-6)

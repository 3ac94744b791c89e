"""The shared campaigns: signals of a solver that shares nothing with this project."""

from pathlib import Path

import numpy as np
import pytest

from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.result import FitResult
from multilayer.fits.sources import read_fit
from validation.scoring import score

pytestmark = pytest.mark.reference


def _fit(folder: Path) -> FitResult:
    job = read_fit(folder)
    return fit_bursts(job.campaign, job.recordings, job.settings, job.calibration)


def test_a_campaign_that_the_model_describes(shared: Path) -> None:
    folder = shared / "campaigns" / "effect-none"
    result = _fit(folder)
    found = score(result, folder)
    errors = np.abs(found.relative)
    assert len(errors) == 105
    assert np.all(np.median(errors, axis=0) < [0.012, 0.06])
    assert np.all(np.quantile(errors, 0.9, axis=0) < [0.05, 0.20])
    # honest: not too small, and not so large that they say nothing
    assert np.all((np.abs(found.in_sigmas) <= 2).mean(axis=0) >= 0.85)
    assert np.all(np.sqrt((found.in_sigmas**2).mean(axis=0)) > 0.5)
    assert result.all_accepted


@pytest.mark.parametrize("name", ["paper-a", "paper-b", "paper-c"])
def test_every_burst_is_accepted_or_says_why_not(shared: Path, name: str) -> None:
    folder = shared / "campaigns" / name
    result = _fit(folder)
    assert len(result.bursts) == 15
    assert all(burst.accepted != bool(burst.reason) for burst in result.bursts)
    assert sum(burst.accepted for burst in result.bursts) >= 11
    # the free rim of the sample is not in this model: E1 comes out low, and nothing here may hide that
    low = np.median(score(result, folder).relative[:, 0])
    assert -0.30 < low < -0.15

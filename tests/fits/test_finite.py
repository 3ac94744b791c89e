"""The inverse with finite elements of the rig: no bias from the free rim."""

from pathlib import Path

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.experiments.two_plate.finite_elements import FiniteRig, ModulusRange, finite_rigs, two_plate_rig
from multilayer.experiments.two_plate.motion import Neighbourhood
from multilayer.fits.burst.fit import fit_bursts, number_of_steps
from multilayer.fits.sources import read_fit
from multilayer.measurements.description import Campaign
from tests.fits.synthetic import campaign_dict
from validation.scoring import score

FREQUENCY = np.array([400.0, 500.0, 600.0])


@pytest.fixture(scope="module")
def rigs() -> tuple[Campaign, FiniteRig]:
    campaign = Campaign.model_validate(campaign_dict(poisson_ratio=0.3))
    found = finite_rigs(campaign, {"one": ModulusRange(1e5, 4e5, 1.0)}, lambda text: None)
    return campaign, found["one"]


def test_it_is_the_rig_of_the_campaign(rigs) -> None:
    campaign, rig = rigs
    full = two_plate_rig(campaign, campaign.configurations[0])
    modulus = 2e5 * (1 + 0.2j) * np.ones(3)
    np.testing.assert_allclose(
        rig.transmissibility(FREQUENCY, modulus), full.transmissibility(FREQUENCY, modulus), rtol=1e-3
    )


@pytest.mark.parametrize(
    ("quantity", "amount", "relative", "changes"),
    [
        ("thickness", 5e-4, False, {"thickness": 0.0255}),
        ("density", 0.02, True, {"density": 91.8}),
        ("top_plate_mass", 0.02, True, {"plate_density": 7850 * 1.02}),
    ],
)
def test_uncertain_quantities_are_shifted(rigs, quantity, amount, relative, changes) -> None:
    campaign, rig = rigs
    modulus = 2e5 * (1 + 0.2j) * np.ones(3)
    full = two_plate_rig(campaign, campaign.configurations[0])
    here, there = (r.transmissibility(FREQUENCY, modulus) for r in (full, full.replaced(**changes)))
    shifted = rig.shifted(quantity, amount, relative=relative)
    found = shifted.transmissibility(FREQUENCY, modulus) / rig.transmissibility(FREQUENCY, modulus)
    np.testing.assert_allclose(found, there / here, rtol=1e-3)
    assert np.max(np.abs(there / here - 1)) > 5e-3


def test_a_neighbourhood_is_the_rig_itself_to_third_order(rigs) -> None:
    _, nominal = rigs
    near = Neighbourhood(nominal, 0.01, 5e-5)
    modulus = 2e5 * (1 + 0.2j) * np.ones((1, 3))
    density, thickness = np.array([[0.015]]), np.array([[8e-5]])
    moved = nominal.shifted("density", 0.015, relative=True).shifted("thickness", 8e-5, relative=False)
    expected = np.log(moved.transmissibility(FREQUENCY, modulus))
    np.testing.assert_allclose(near.log_motion(FREQUENCY, modulus, density, thickness), expected, atol=2e-5)
    assert np.abs(expected - np.log(nominal.transmissibility(FREQUENCY, modulus))).max() > 5e-3


@pytest.mark.reference
@pytest.mark.parametrize("name", ["paper-a", "paper-b", "paper-c"])
def test_the_bias_of_the_free_rim_is_gone(shared: Path, name: str) -> None:
    folder = shared / "campaigns" / name
    job = read_fit(folder, model="finite")
    told: list[str] = []
    result = fit_bursts(job.campaign, job.recordings, job.settings, job.calibration, told.append)
    found = score(result, folder)
    assert np.median(np.abs(found.relative[:, 0])) < 0.02
    assert np.all((np.abs(found.in_sigmas) <= 2).mean(axis=0) >= 0.85)
    assert len(told) == number_of_steps(job.campaign, job.settings)


def test_the_papers_method_keeps_the_papers_model(shared: Path) -> None:
    with pytest.raises(InputError, match="--method: nelder-mead is the paper's method"):
        read_fit(shared / "campaigns" / "paper-a", method="nelder-mead", model="finite")


def test_an_unknown_model_is_refused(shared: Path) -> None:
    with pytest.raises(InputError, match="did you mean 'finite'"):
        read_fit(shared / "campaigns" / "paper-a", model="finit")

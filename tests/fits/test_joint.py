"""One law for a whole campaign: synthetic data with drawn errors, and the shared campaigns."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.experiments.two_plate.finite_elements import FiniteRig
from multilayer.experiments.two_plate.motion import Neighbourhood
from multilayer.fits.joint.fit import fit_joint, number_of_steps
from multilayer.fits.joint.posterior import modulus_band, motion_curves, with_posterior
from multilayer.fits.joint.search import law_space
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import read_fit
from multilayer.measurements.description import Campaign
from multilayer.media.laws import FractionalZener
from multilayer.report.joint import draw_law
from multilayer.report.style import figure_style
from multilayer.signals.bursts import hann_burst
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum
from tests.cli.command import result_names, run
from tests.fits.synthetic import FS, campaign_dict, rig
from validation.scoring import true_modulus

LAW = FractionalZener(relaxed_modulus=1.2e5, unrelaxed_modulus=1.5e6, relaxation_time=2e-5, order=0.45)
BURSTS = (200.0, 400.0, 800.0, 1200.0)
STATED = {"channel_gain": 0.003, "channel_delay": 1e-6, "thickness": 5e-5, "density": 0.01, "top_plate_mass": 0.002}


def campaign_and_signals(changes=None, gain=1.0, noise=0.02, seed=1):
    """Return a campaign of two heights, its signals made with changed rigs, which it does not say."""
    described = campaign_dict(frequencies_hz=BURSTS) | {"uncertainty": STATED}
    (one,) = described["configurations"]
    heights = {"low": 0.0125, "high": 0.025}
    described["configurations"] = [{**one, "name": n, "specimen_thickness": h} for n, h in heights.items()]
    campaign = Campaign.model_validate(described)
    rng, recordings = np.random.default_rng(seed), {}
    for configuration in campaign.configurations:
        true = rig(thickness=configuration.specimen_thickness)
        for quantity, amount in (changes or {}).items():
            true = true.shifted(quantity, amount, relative=quantity != "thickness")
        for f0 in BURSTS:
            recordings[configuration.name, f0] = _recording(true, f0, gain, noise, rng)
    return campaign, recordings


def _recording(true, f0, gain, noise, rng):
    base = hann_burst(f0, 10, FS, n_samples=round(4 * 10 / f0 * FS))
    n = padded_length(len(base), 4)
    f = frequencies(n, FS)
    ratio = np.ones(len(f), dtype=complex)
    ratio[1:] = true.transmissibility(f[1:], LAW(f[1:]))
    top = gain * to_signal(ratio * to_spectrum(base, n), n, len(base))
    shape = (3, len(base))
    return Recording(base + noise * rng.standard_normal(shape), top + noise * rng.standard_normal(shape), FS)


@pytest.fixture(scope="module")
def known(fitted):
    return with_posterior(fitted)


@pytest.fixture(scope="module")
def fitted():
    drawn = {"density": 0.008, "top_plate_mass": -0.001, "thickness": 3e-5}
    campaign, recordings = campaign_and_signals(drawn, gain=1.002)
    told = []
    result = fit_joint(campaign, recordings, progress=told.append)
    assert len(told) == number_of_steps(campaign, FitSettings())
    return result


def test_the_law_is_found_within_its_uncertainty(fitted):
    at = np.array(BURSTS)
    moduli, covariance = fitted.moduli(at)
    error = np.stack([(moduli - LAW(at)).real, (moduli - LAW(at)).imag], axis=-1)
    sigmas = error / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    assert np.all(np.abs(sigmas) < 3)
    assert np.all(np.abs(moduli / LAW(at) - 1) < 0.02)
    assert fitted.p_value > 0.01
    assert fitted.all_accepted


def test_what_cannot_be_told_apart_stays_as_uncertain_as_stated(fitted):
    # forces and masses in one proportion move alike: no data can tell the scale better than density and mass are known
    common = 1 / np.sqrt(1 / 0.01**2 + 1 / 0.002**2)
    _, covariance = fitted.moduli(np.array([400.0]))
    moduli, _ = fitted.moduli(np.array([400.0]))
    assert np.sqrt(covariance[0, 0, 0]) / moduli[0].real > 0.99 * common


def test_intervals_are_of_the_laws_own_parameters(known):
    # one of the coordinates is the ratio of the moduli
    assert known.problem.space.coordinates[1] == "relaxed_modulus/unrelaxed_modulus"
    findings = known.summary.identifiability.findings
    assert [f.name for f in findings[:4]] == known.problem.space.names
    assert [f.unit for f in findings[:4]] == ["Pa", "Pa", "s", ""]
    for finding in findings[:4]:
        value, std = known.parameters[finding.name]
        factor = np.exp(1.645 * std / value)
        assert finding.posterior_90 == pytest.approx((value / factor, value * factor), abs=0.2 * std)
        assert finding.posterior_90[0] < getattr(LAW, finding.name) < finding.posterior_90[1]
        assert finding.verdict == "determined"
    assert "the data determine unrelaxed_modulus: " in known.summary.identifiability.sentences[1]


def test_bands_of_curves(known):
    at, posterior = np.array(BURSTS), known.summary.posterior
    moduli, covariance = known.moduli(at)
    band = modulus_band(known, at, 0.9)
    assert band.high[0] - band.low[0] == pytest.approx(2 * 1.645 * np.sqrt(covariance[:, 0, 0]), rel=0.1)
    assert band.median[1] == pytest.approx(moduli.imag, rel=2e-3)
    curves = motion_curves(known, posterior)
    assert list(curves) == ["low", "high"]
    for curve in curves.values():
        assert np.all(np.diff(curve.frequency) >= 0)
        assert np.all((curve.band.low < curve.modelled) & (curve.modelled < curve.band.high))
        # noise, and not much more
        assert curve.modelled[0] == pytest.approx(curve.measured[0], rel=0.03, abs=0.04)
        assert curve.modelled[1] == pytest.approx(curve.measured[1], abs=10.0)


def test_a_law_without_losses_can_be_drawn(fitted):
    problem = replace(fitted.problem.without_ends(), space=law_space("constant", [200.0, 800.0], [2e5, 3e5]))
    z = np.zeros(len(problem.parameters))
    result = replace(fitted, problem=problem, minima=[problem.as_minimum(z)], candidates=())
    with figure_style():
        assert len(draw_law(result).axes) == 6


def test_a_wrong_gain_is_not_explained():
    campaign, recordings = campaign_and_signals(gain=1.05)
    result = fit_joint(campaign, recordings)
    assert result.p_value < 1e-6
    assert not result.all_accepted
    assert "something acts that this model lacks" in result.remark


def test_the_table_has_one_row_per_frequency(fitted):
    rows = fitted.to_csv().splitlines()
    assert rows[0].startswith("configuration,frequency_hz,E1_pa,E1_std_pa,E2_pa")
    assert [row.split(",")[:2] for row in rows[1:]] == [["joint", f"{f:g}"] for f in BURSTS]
    assert json.loads(json.dumps(fitted.to_dict()))["law"]["law"] == "fractional_zener"


def test_density_thickness_and_mass_of_plane_waves_are_exact_however_large():
    nominal = rig(poisson_ratio=0.3)
    near = Neighbourhood(nominal, 0.01, 5e-5, 0.002)
    f, modulus = np.array([150.0, 500.0, 1400.0]), 2e5 * (1 + 0.2j) * np.ones((1, 3))
    density, thickness, mass = np.array([[0.0], [0.3]]), np.array([[0.0], [2e-3]]), np.array([[0.0], [0.1]])
    moved = nominal.shifted("density", 0.3, relative=True).shifted("thickness", 2e-3, relative=False)
    moved = moved.shifted("top_plate_mass", 0.1, relative=True)
    expected = np.log([nominal.transmissibility(f, modulus[0]), moved.transmissibility(f, modulus[0])])
    np.testing.assert_allclose(near.log_motion(f, modulus, density, thickness, mass), expected, rtol=1e-12)


@pytest.mark.reference
def test_one_law_explains_a_shared_campaign_with_finite_elements(shared: Path):
    folder = shared / "campaigns" / "paper-b"
    job = read_fit(folder, model="finite")
    result = fit_joint(job.campaign, job.recordings, settings=job.settings)
    f = np.array([100.0, 500.0, 1500.0])
    moduli, _ = result.moduli(f)
    np.testing.assert_allclose(moduli, true_modulus(folder, f), rtol=5e-3)
    assert result.p_value > 0.01
    assert all(isinstance(rig, FiniteRig) for rig in result.problem.rigs.values())


@pytest.mark.reference
def test_the_free_rim_is_not_explained_by_plane_waves(shared: Path):
    job = read_fit(shared / "campaigns" / "paper-b")
    result = fit_joint(job.campaign, job.recordings)
    assert result.p_value < 1e-6


def test_as_a_user_types_it(tmp_path: Path):
    done = run("fit", "examples/foam_b", "--joint", "--out", tmp_path / "out")
    assert done.status == 1  # the foam of the example has a free rim
    assert result_names(tmp_path / "out") == {
        "moduli.csv",
        "joint.json",
        "moduli.png",
        "residuals.png",
        "transmissibility.png",
        "report.html",
    }
    assert "something acts that this model lacks" in done.out
    found = run("fit", "examples/foam_b", "--joint", "--law", "fractional_zene", "--out", tmp_path / "no")
    assert (found.status, (tmp_path / "no").exists()) == (2, False)
    assert "did you mean 'fractional_zener'" in found.err


def test_a_law_that_leaves_the_bounds_of_fits_burst_by_burst_is_told(tmp_path: Path):
    file = tmp_path / "fit.yaml"
    folder = Path("examples/foam_b").resolve()
    file.write_text(f"kind: fit\nversion: 1\ncampaign: {folder}\nbounds: {{storage_modulus: [1 kPa, 50 kPa]}}\n")
    done = run("fit", file, "--joint", "--out", tmp_path / "out", "--no-figures")
    assert "warning: bounds: storage_modulus of the law runs from" in done.err
    assert "loss_factor" not in done.err


def test_a_problem_replaced_starts_anew(fitted):
    problem = fitted.problem
    assert replace(problem, model_error=0.01).residual(fitted.best.z).shape == fitted.best.residual.shape

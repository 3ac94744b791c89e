"""Several methods on one campaign: what bursts far below the resonance say, and what two points say of each other."""

from typing import Any

import numpy as np
import pytest

from multilayer.fits.classical.compare import compare_methods, number_of_steps_of_all
from multilayer.fits.classical.comparison import MethodComparison, MethodPoint, causality_check
from multilayer.fits.classical.methods import QuasiStatic
from multilayer.fits.result import BurstFit
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import FitJob
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.shape_factor import static_shape_factor
from multilayer.signals.bursts import hann_burst
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum
from tests.fits.synthetic import FS, campaign_dict

MODULUS, NU, FREQUENCY = 4e7 * (1 + 0.2j), 0.3, 100.0


def stiff_campaign() -> tuple[Campaign, dict[tuple[str, float], Recording]]:
    """Return two glued discs of different shape, so stiff that the burst lies below a tenth of their resonance."""
    data = campaign_dict(poisson_ratio=NU, frequencies_hz=(FREQUENCY,))
    (one,) = data["configurations"]
    data["configurations"] = [
        {**one, "name": name, "specimen_thickness": h} for name, h in (("tall", 0.04), ("flat", 0.0125))
    ]
    data["uncertainty"] = {"channel_gain": 1e-6}
    campaign = Campaign.model_validate(data)
    recordings = {(c.name, FREQUENCY): _recording(c.specimen_thickness) for c in campaign.configurations}
    return campaign, recordings


def _recording(thickness: float) -> Recording:
    n = int(0.3 * FS)
    base = hann_burst(FREQUENCY, 10, FS, 5.0, n_samples=n)
    n_fft = 4 * n
    f = frequencies(n_fft, FS)
    ratio = np.ones(len(f), dtype=complex)
    apparent = MODULUS * static_shape_factor(NU, 0.0225 / (2 * thickness))
    ratio[1:] = rod_transmissibility(f[1:], apparent, 90.0, thickness, 7.85)
    top = to_signal(ratio * to_spectrum(base, n_fft), n_fft, n)
    rng = np.random.default_rng(0)
    noisy = [signal + 1e-9 * rng.standard_normal((2, n)) for signal in (base, top)]
    return Recording(noisy[0], noisy[1], FS)


def test_bursts_far_below_the_resonance_are_a_quasi_static_test() -> None:
    campaign, recordings = stiff_campaign()
    told: list[str] = []
    settings = FitSettings()
    found = compare_methods(campaign, recordings, settings, progress=told.append)
    assert len(told) == number_of_steps_of_all(campaign, settings)
    for name in ("tall", "flat"):
        (slow,) = found.of(name, "quasi-static")
        (rod,) = found.of(name, "transfer-function")
        assert complex(slow.storage_modulus, slow.loss_modulus) == pytest.approx(MODULUS, rel=5e-3)
        assert complex(rod.storage_modulus, rod.loss_modulus) == pytest.approx(MODULUS, rel=1e-3)
        assert "far below the resonance" in slow.remark
        # a gain of 1e-6 over a motion of a few thousandths
        assert 1e-6 < slow.storage_modulus_std / slow.storage_modulus < 1e-2
    (remark,) = found.remarks
    assert remark.startswith("tall and flat, quasi-static: nu = 0.3")
    nu = float(remark.split("nu = ")[1].split()[0])
    assert nu == pytest.approx(NU, abs=0.01)


def test_what_is_stated_moves_slow_moduli_as_said() -> None:
    """Every cause of its own, by evaluating the same signals with it."""
    campaign, recordings = stiff_campaign()
    known = Uncertainty(channel_gain=1e-6, thickness=1e-4, density=0.02, top_plate_mass=0.003)
    flat = campaign.configurations[1]
    campaign = campaign.model_copy(update={"configurations": [flat]})

    def slow(**update: Any) -> BurstFit:
        job = FitJob(campaign.model_copy(update=update), recordings, FitSettings(), None)
        (burst,) = QuasiStatic().run(job, lambda text: None).bursts
        return burst

    step = 0.1
    sample, plate = campaign.specimen, campaign.top_plate
    moved = [
        {"configurations": [flat.model_copy(update={"specimen_thickness": 0.0125 + step * known.thickness})]},
        {"specimen": sample.model_copy(update={"density": sample.density * (1 + step * known.density)})},
        {"top_plate": plate.model_copy(update={"density": plate.density * (1 + step * known.top_plate_mass)})},
    ]
    alone, stated = slow(), slow(uncertainty=known)
    shifts = np.array([slow(**update).storage_modulus / alone.storage_modulus - 1 for update in moved]) / step
    own = np.sqrt(stated.storage_modulus_std**2 - alone.storage_modulus_std**2) / alone.storage_modulus
    assert own == pytest.approx(np.linalg.norm(shifts), rel=0.03)
    of_loss = np.sqrt(stated.loss_modulus_std**2 - alone.loss_modulus_std**2) / alone.loss_modulus
    assert of_loss == pytest.approx(own, rel=1e-6)
    assert stated.loss_factor_std == alone.loss_factor_std


def _points(method: str, storage: complex, std: float, reliable: bool = True) -> list[MethodPoint]:
    f = np.arange(100.0, 1600.0, 100.0)
    e = storage * (f / 100) ** (2 / np.pi * np.angle(storage))
    return [
        MethodPoint("one", x, method, m.real, std * m.real, m.imag, std * m.imag, reliable=reliable)
        for x, m in zip(f, e, strict=True)
    ]


def test_agreement_counts_in_standard_deviations_of_both() -> None:
    points = _points("finite", 2e5 + 4e4j, 0.01) + _points("plane-wave", 1.6e5 + 3.2e4j, 0.01)
    near = _points("transfer-function", 1.01 * (2e5 + 4e4j), 0.01)
    apart, close = MethodComparison("c", points + near).agreements()
    assert (apart.method, apart.reference, apart.n_points) == ("plane-wave", "finite", 15)
    assert (apart.storage_difference, apart.within) == (pytest.approx(-0.2), 0.0)
    assert (close.loss_difference, close.within) == (pytest.approx(0.01), 1.0)


def test_an_unknown_standard_deviation_is_no_disagreement() -> None:
    points = _points("finite", 2e5 + 4e4j, 0.01)
    stated, half = (_points("quasi-static", 2e5 + 4e4j, std) for std in (float("nan"), 0.01))
    (none,) = MethodComparison("c", points + stated).agreements()
    assert np.isnan(none.within)
    (some,) = MethodComparison("c", [*points, *stated[:5], *half[5:]]).agreements()
    assert (some.n_points, some.within) == (15, 1.0)


def test_unreliable_points_count_nowhere() -> None:
    points = _points("finite", 2e5 + 4e4j, 0.01) + _points("plane-wave", 1e5 + 9e4j, 0.01, reliable=False)
    comparison = MethodComparison("c", points)
    assert comparison.agreements() == []
    assert [check.method for check in comparison.checks()] == ["finite"]


def test_a_causal_law_is_consistent_and_its_mirror_is_not() -> None:
    causal = causality_check(_points("finite", 2e5 + 4e4j, 0.01))
    assert causal is not None
    assert causal.verdict == "consistent"
    # of (i w)^n: n pi/2 over its tangent
    angle = np.angle(2e5 + 4e4j)
    assert causal.gross_error == pytest.approx(1 - angle / np.tan(angle), rel=0.01)
    falling = [
        MethodPoint(p.configuration, 1.6e5 / p.frequency, *p.row()[2:7])
        for p in reversed(_points("finite", 2e5 + 4e4j, 0.01))
    ]
    mirrored = causality_check(falling)
    assert mirrored is not None
    assert mirrored.verdict == "inconsistent"


def test_without_standard_deviations_nothing_is_judged() -> None:
    check = causality_check(_points("quasi-static", 2e5 + 4e4j, float("nan")))
    assert check is not None
    assert check.verdict == "cannot tell"
    assert "standard deviations must be finite" in check.reasons[0]
    assert causality_check(_points("quasi-static", 2e5 + 4e4j, 0.01)[:2]) is None

"""The transfer function method: exact data, every branch, standard deviations, and how far a rod reaches."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.experiments.two_plate.transmissibility import Transmissibility, measure
from multilayer.fits.classical.rod_branches import NOWHERE, QUARTER, Rod, Solutions, follow_branch, solve
from multilayer.fits.classical.rod_limit import longest_rod, rim_inertia, rod_error
from multilayer.fits.classical.transfer_function import frequency_limit, transfer_function
from multilayer.fits.settings import Bounds
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.rod import rod_transmissibility
from multilayer.rig import TwoPlateRig, dynamic_shape_factor, static_shape_factor
from multilayer.signals.spectra import Noise
from tests.fits.synthetic import Truth, burst, campaign_dict, rig

STORAGE, LOSS = (1e3, 1e9), (-0.1, 2.0)
ROD = Rod(density=90.0, length=0.025, mass_per_area=7.85)
LABORATORY = Uncertainty(
    channel_gain=0.003, channel_delay=1e-6, remount_gain=0.001, thickness=5e-5, density=0.01, top_plate_mass=0.002
)


def law(frequency, loss):
    """Return a causal modulus of constant loss factor."""
    order = 2 / np.pi * np.arctan(loss)
    return 2e5 * (1 + 1j * loss) * (np.asarray(frequency) / 500) ** order


def motion_of(rod: Rod, frequency, modulus):
    return rod_transmissibility(frequency, modulus, rod.density, rod.length, rod.mass_per_area)


class TestExactData:
    @pytest.mark.parametrize("loss", [0.003, 0.1, 0.4, 1.5])
    @pytest.mark.parametrize("mass", [0.5, 7.85, 40.0])
    def test_across_several_resonances(self, loss, mass):
        """From below the first resonance to where the sample holds a wavelength and more."""
        rod = replace(ROD, mass_per_area=mass)
        f = np.arange(40.0, 6000.0, 80.0)
        truth = law(f, loss)
        bounds = (1e4, 1e8), LOSS
        found = [solve(rod, x, complex(t), *bounds) for x, t in zip(f, motion_of(rod, f, truth), strict=True)]
        assert all(solutions.complete for solutions in found)
        chosen = np.array(follow_branch(rod, f, found))
        assert np.max(np.abs(chosen / truth - 1)) < 1e-9
        assert abs(rod.phase(f[-1], truth[-1])) > 2 * np.pi
        assert max(len(solutions.moduli) for solutions in found) > 10

    @pytest.mark.parametrize("seed", range(4))
    def test_no_solution_is_missed_or_made_up(self, seed):
        rng = np.random.default_rng(seed)
        for _ in range(25):
            rod = Rod(10 ** rng.uniform(0.9, 2.6), rng.uniform(0.005, 0.05), rng.uniform(1, 40))
            modulus = 10 ** rng.uniform(4, 7) * (1 + 1j * 10 ** rng.uniform(-3, 0.2))
            f = 10 ** rng.uniform(1.5, 3.3)
            motion = complex(motion_of(rod, f, modulus))
            found = solve(rod, f, motion, STORAGE, LOSS)
            assert found.complete
            assert np.min(np.abs(found.moduli / modulus - 1)) < 1e-9
            assert np.max(np.abs(motion_of(rod, f, found.moduli) / motion - 1)) < 1e-7
            assert np.all(np.diff(np.abs(found.moduli)) < 0)
            # where the branch starts there is one at most
            assert sum(rod.phase(f, e).real < 2 * np.pi * QUARTER for e in found.moduli) <= 1

    def test_bounds_hold(self):
        motion = complex(motion_of(ROD, 1500.0, law(1500.0, 0.3)))
        every = solve(ROD, 1500.0, motion, STORAGE, LOSS).moduli
        some = solve(ROD, 1500.0, motion, (1e4, 1e5), (0.0, 0.2)).moduli
        inside = (every.real >= 1e4) & (every.real <= 1e5) & (every.imag >= 0) & (every.imag <= 0.2 * every.real)
        assert 0 < len(some) < len(every)
        assert some == pytest.approx(every[inside], rel=1e-9)


class TestBranch:
    def test_a_gap_is_bridged(self):
        f = np.arange(100.0, 1600.0, 100.0)
        truth = law(f, 0.3)
        found = [solve(ROD, x, complex(t), STORAGE, LOSS) for x, t in zip(f, motion_of(ROD, f, truth), strict=True)]
        found[4] = Solutions(np.empty(0, dtype=complex), True)
        chosen = np.array(follow_branch(ROD, f, found))
        assert np.isnan(chosen[4])
        kept = np.arange(len(f)) != 4
        assert np.max(np.abs(chosen[kept] / truth[kept] - 1)) < 1e-9

    def test_nothing_is_taken_far_from_the_branch(self):
        one, other = (Solutions(np.array([e]), True) for e in (2e5 + 4e4j, 9e5 + 1e4j))
        assert follow_branch(ROD, [100.0, 200.0, 300.0], [one, other, one])[1] is NOWHERE

    def test_no_start_beyond_a_quarter_of_the_wavelength(self):
        only = Solutions(np.array([2e4 + 2e3j]), True)
        assert not np.isfinite(follow_branch(ROD, [1000.0], [only])[0])


def campaign_of(frequencies, known=None, **options):
    data = campaign_dict(frequencies_hz=tuple(frequencies), **options)
    if known is not None:
        data["uncertainty"] = known.model_dump()
    return Campaign.model_validate(data)


class TestBursts:
    FREQUENCIES = (100.0, 300.0, 600.0, 900.0)

    def test_signals_give_the_modulus(self):
        campaign = campaign_of(self.FREQUENCIES)
        model = rig()
        bursts = [burst(Truth(2e5, 0.3, f), model) for f in self.FREQUENCIES]
        points = transfer_function(campaign, bursts)
        assert [p.frequency for p in points] == list(self.FREQUENCIES)
        for point in points:
            # plates that give way and records that end: small
            assert abs(point.modulus / (2e5 * (1 + 0.3j)) - 1) < 3e-3
            assert point.found
        assert [bool(p.reason) for p in points] == [False, False, True, True]
        assert "beyond the rod's limit" in points[-1].remark
        speed = np.sqrt(2e5 / 90) * (1 + 0.3**2) ** 0.5 / np.cos(np.arctan(0.3) / 2) / (1 + 0.3**2) ** 0.25
        assert frequency_limit(points) == pytest.approx(speed * QUARTER / 0.025, rel=0.01)

    def test_order_of_the_bursts_does_not_matter(self):
        campaign, model = campaign_of(self.FREQUENCIES), rig()
        bursts = [burst(Truth(2e5, 0.3, f), model) for f in self.FREQUENCIES]
        forwards, backwards = (transfer_function(campaign, own) for own in (bursts, bursts[::-1]))
        assert [p.modulus for p in forwards] == [p.modulus for p in backwards[::-1]]

    def test_a_cut_record_is_told(self):
        campaign = campaign_of((150.0,))
        short = burst(Truth(2e5, 0.02, 150.0, record=1.05), rig())
        (point,) = transfer_function(campaign, [short])
        assert "ring-down goes on" in point.reason

    def test_no_solution_is_told(self):
        campaign = campaign_of((300.0,))
        data = burst(Truth(2e5, 0.3, 300.0), rig())
        (point,) = transfer_function(campaign, [data], bounds=Bounds(storage_modulus=(1e8, 1e9)))
        assert not point.found
        assert point.remark == "no modulus within bounds has this transmissibility"
        assert np.isnan(point.storage_modulus_std)

    @pytest.mark.parametrize(
        ("lateral", "factor"),
        [
            ("slender", 1.0),
            ("held", float(p_wave_modulus(1.0, 0.3))),
            ("bonded", static_shape_factor(0.3, 0.0225 / 0.05)),
        ],
    )
    def test_which_modulus_the_rod_shows(self, lateral, factor):
        campaign = campaign_of((200.0,), poisson_ratio=0.3)
        data = burst(Truth(2e5, 0.3, 200.0), rig(poisson_ratio=0.3))
        (point,) = transfer_function(campaign, [data], lateral)
        # the signals are those of plane waves: held
        held = p_wave_modulus(2e5 * (1 + 0.3j), 0.3)
        assert point.modulus * factor == pytest.approx(held, rel=3e-3)

    def test_unknown_lateral(self):
        with pytest.raises(InputError, match="lateral: 'bondet' is not allowed; did you mean 'bonded'"):
            transfer_function(campaign_of((200.0,)), [], "bondet")  # type: ignore[arg-type]


class TestStandardDeviations:
    @pytest.mark.parametrize("frequency", [150.0, 400.0])
    def test_each_cause_moves_the_modulus_as_said(self, frequency):
        """Every cause of its own, by solving again with it."""
        campaign = campaign_of((frequency,), LABORATORY)
        data = burst(Truth(2e5, 0.3, frequency), rig())
        data = replace(data, noise=Noise(0.0, 0.0))
        (point,) = transfer_function(campaign, [data])
        t, step = point.transmissibility, 1e-4
        turn = np.exp(-2j * np.pi * frequency * LABORATORY.channel_delay)
        gain = np.hypot(LABORATORY.channel_gain, LABORATORY.remount_gain)

        def again(rod=ROD, motion=t.value):
            moduli = solve(rod, frequency, motion, STORAGE, LOSS).moduli
            return moduli[np.argmin(np.abs(moduli - point.modulus))]

        moved = [
            again(motion=t.value * (1 + step * gain)),
            again(motion=t.value * turn**step),
            again(replace(ROD, density=ROD.density * (1 + step * LABORATORY.density))),
            again(replace(ROD, length=ROD.length + step * LABORATORY.thickness)),
            again(replace(ROD, mass_per_area=ROD.mass_per_area * (1 + step * LABORATORY.top_plate_mass))),
        ]
        shifts = (np.array(moved) - again()) / step
        assert point.storage_modulus_std == pytest.approx(np.linalg.norm(shifts.real), rel=1e-3)
        assert point.loss_modulus_std == pytest.approx(np.linalg.norm(shifts.imag), rel=1e-3)
        loss = (np.array(moved).imag / np.array(moved).real - again().imag / again().real) / step
        assert point.loss_factor_std == pytest.approx(np.linalg.norm(loss), rel=1e-3)

    def test_the_thickness_moves_a_glued_disc_by_its_shape_too(self):
        nu, frequency, known = 0.45, 150.0, Uncertainty(thickness=5e-5)
        data = replace(burst(Truth(2e5, 0.3, frequency), rig()), noise=Noise(0.0, 0.0))
        of_bonded, of_held = (
            transfer_function(campaign_of((frequency,), known, poisson_ratio=nu), [data], lateral)[0]
            for lateral in ("bonded", "held")
        )
        factors = [static_shape_factor(nu, 0.0225 / (2 * h)) for h in (0.025 - 1e-4, 0.025 + 1e-4)]
        by_thickness = -np.log(factors[1] / factors[0]) / 2e-4 * known.thickness
        model_error = rod_error(rim_inertia(nu, 0.0225 / 0.05), of_bonded.wavelengths)
        of_rod = of_held.storage_modulus_std / of_held.modulus.real
        said = np.sqrt((of_bonded.storage_modulus_std / of_bonded.modulus.real) ** 2 - model_error**2)
        assert by_thickness > 0.1 * of_rod
        assert said == pytest.approx(of_rod + by_thickness, rel=0.03)

    def test_noise_scatters_as_said(self):
        f, model = 300.0, rig()
        data = [burst(Truth(2e5, 0.3, f, noise=0.02, seed=k), model) for k in range(80)]
        measured = [measure(one) for one in data]
        values = np.array([m.value for m in measured])
        said = measured[0].noise
        assert values.real.std() == pytest.approx(said, rel=0.25)
        assert values.imag.std() == pytest.approx(said, rel=0.25)
        campaign = campaign_of((f,))
        points = [transfer_function(campaign, [one], "slender")[0] for one in data]
        assert np.std([p.modulus.real for p in points]) == pytest.approx(points[0].storage_modulus_std, rel=0.3)

    def test_amplitude_and_phase(self):
        t = Transmissibility(1000.0, 0.5j, noise=0.003, gain=0.004, delay=1e-6)
        assert t.amplitude_std == pytest.approx(np.hypot(0.006, 0.004))
        assert t.phase_std == pytest.approx(np.hypot(0.006, 2e-3 * np.pi))


@pytest.mark.parametrize("nu", [0.3, 0.4, 0.45])
@pytest.mark.parametrize(("radius", "thickness"), [(0.0225, 0.0125), (0.0225, 0.025), (0.01, 0.025)])
def test_a_glued_disc_is_a_rod_up_to_the_limit(nu, radius, thickness):
    """The limit and the error that the method states, by finite elements of another disc, with losses."""
    modulus, density, shape = 2e5 * (1 + 0.2j), 90.0, radius / (2 * thickness)
    disc = TwoPlateRig(radius, thickness, density, nu, 1e-3)
    static, inertia = static_shape_factor(nu, shape), rim_inertia(nu, shape)
    speed = 1 / np.real(np.sqrt(density / (static * modulus)))
    limit = longest_rod(inertia)
    shares = limit * np.array([0.25, 0.5, 0.75, 1.0, 1.4])
    off = np.abs(dynamic_shape_factor(disc, shares * speed / thickness, modulus) / static - 1)
    assert np.all(np.diff(off) > 0)
    assert off[3] < 0.15
    said = np.array([rod_error(inertia, share) for share in shares[:4]])
    # a standard deviation: of the right size
    assert np.all(off[:4] < 2.5 * said)
    assert np.all(off[:4] > 0.5 * said)


def test_limit_is_a_quarter_or_less():
    assert longest_rod(rim_inertia(0.0, 0.45)) == QUARTER
    assert longest_rod(rim_inertia(0.3, 0.9)) == QUARTER
    assert longest_rod(rim_inertia(0.45, 0.9)) < 0.15
    assert rim_inertia(-0.2, 0.45) == rim_inertia(0.2, 0.45)

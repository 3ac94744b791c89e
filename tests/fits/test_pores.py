"""Samples with air in their pores: what the finite elements were given comes back, and without the air it does not."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.interpolate import CubicSpline

from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.experiments.two_plate.finite_elements import two_plate_rig
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.experiments.two_plate.pores import Pores
from multilayer.fits.burst.branches import find_candidates
from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.burst.free_rim import search_bounds
from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.media.gas import dry_air
from multilayer.media.porous import champoux_allard_modulus, johnson_density
from multilayer.media.pumped_air import cylindrical_length, pumped_air_stiffness
from multilayer.rig.synthesis import make_campaign
from multilayer.rig.two_plate import TwoPlateRig
from tests.fits.synthetic import Truth, burst, campaign_dict
from tests.rig.virtual import rig_file

PORES = {"porosity": 0.97, "flow_resistivity": 6e4}
SMALL = {"frequencies": [200.0, 450.0, 800.0], "noise": {"white": 1e-4, "bits": None}}


def finite(**pores):
    return FitSettings(model="finite", pores=Pores(**PORES, **pores))


def made_with(*effects, **pores):
    """Return one configuration of a porous disc on the rig, its top plate as elastic as the fit's."""
    air = {"effect": "saturating_air", **PORES, **pores}
    return make_campaign(rig_file("plate_flexure", air, *effects, **SMALL))


def truth(made):
    return {m["frequency_hz"]: complex(m["E1_pa"], m["E2_pa"]) for m in made.truth["moduli"]}


def errors(made, options):
    """Return the relative errors of E1 and E2, shape (n_bursts, 2)."""
    bursts, there = fit_bursts(made.campaign, made.recordings, options).bursts, truth(made)
    assert all(burst.accepted for burst in bursts)
    pairs = [(burst.optimum, there[burst.frequency]) for burst in bursts]
    return np.array([[b.storage_modulus / e.real - 1, b.loss_modulus / e.imag - 1] for b, e in pairs])


@pytest.fixture(scope="module")
def porous():
    """Give a porous disc with a Poisson's ratio, air leaving by its rim."""
    return made_with("finite_size")


class TestOpenRim:
    def test_the_frame_comes_back(self, porous):
        assert np.abs(errors(porous, finite())).max() < 0.005

    def test_not_without_its_air(self, porous):
        assert errors(porous, FitSettings(model="finite"))[:, 1].max() > 0.02

    def test_one_law_for_all(self, porous):
        found, there = fit_joint(porous.campaign, porous.recordings, settings=finite()), truth(porous)
        moduli, _ = found.moduli(np.array(list(there)))
        assert moduli == pytest.approx(np.array(list(there.values())), rel=0.01)
        assert found.p_value > 0.01


def test_sealed_rim():
    """The frame may widen at its rim, the air may not leave."""
    boxed = made_with(pore_rim="sealed")
    assert np.abs(errors(boxed, finite(rim="sealed"))).max() < 0.005
    assert errors(boxed, FitSettings(model="finite"))[:, 0].min() > 0.15


@dataclass(frozen=True)
class HeldRig:
    """Finite elements of a disc held and sealed at its rim, as far as a burst at `frequency` reaches."""

    rig: TwoPlateRig
    frequency: float

    def transmissibility(self, frequency, modulus):
        """Return top over base, interpolated; `modulus` at each of the frequencies."""
        at = np.linspace(0.3, 2.5, 24) * self.frequency  # few enough to be solved one by one
        own = np.interp(at, frequency, modulus.real) + 1j * np.interp(at, frequency, modulus.imag)
        found = CubicSpline(at, self.rig.transmissibility(at, own))
        return found(np.clip(frequency, at[0], at[-1]))


class TestPlaneWaves:
    """Held and sealed at its rim a disc is the one-dimensional Biot layer."""

    nu = 0.3

    def models(self, frequency):
        campaign = Campaign.model_validate(campaign_dict(poisson_ratio=self.nu))
        configuration = campaign.configurations[0]
        settings = finite(rim="sealed")
        held = replace(two_plate_rig(campaign, configuration, settings), rim="held", plate_modulus=2e15)
        return HeldRig(held, frequency), PlaneWaveRig.of(campaign, configuration, pores=settings.pores)

    def test_both_models_agree(self):
        f, modulus = np.array([100.0, 300.0, 900.0]), 2e5 * (1 + 0.2j) * np.ones(3)
        held, plane = self.models(500.0)
        assert plane.transmissibility(f, modulus) == pytest.approx(held.rig.transmissibility(f, modulus), rel=2e-3)

    def test_the_frame_comes_back(self):
        truth = Truth(2e5, 0.3, frequency=450.0, record=2.0)
        held, plane = self.models(truth.frequency)
        found = find_candidates(BurstProblem(burst(truth, held), plane, dispersive=True), *search_bounds(FitSettings()))
        assert found.minima[0].z == pytest.approx(truth.x, abs=0.005)


class TestPumpedAir:
    omega = 2 * np.pi * np.array([1e-3, 300.0, 3e3])
    gas = dry_air()

    def parts(self):
        radius = cylindrical_length(0.97, 6e4, 1.0, self.gas)
        density = johnson_density(self.omega, 0.97, 6e4, 1.0, radius, self.gas)
        return density, champoux_allard_modulus(self.omega, 0.97, 2 * radius, self.gas)

    def test_slow_air_just_leaves(self):
        assert np.abs(pumped_air_stiffness(self.omega, 0.02, *self.parts())[0]) < 1.0

    def test_in_a_wide_disc_it_is_held(self):
        density, modulus = self.parts()
        held = pumped_air_stiffness(self.omega, 10.0, density, modulus)[1:]
        assert held == pytest.approx(modulus[1:], rel=0.05)

    def test_passive(self):
        assert (pumped_air_stiffness(self.omega, 0.02, *self.parts()).imag > 0).all()

    def test_poiseuille(self):
        """A bundle of tubes of that radius has the resistivity it was made from."""
        radius = cylindrical_length(0.9, 2e4, 1.0, self.gas)
        assert 8 * self.gas.viscosity / (0.9 * radius**2) == pytest.approx(2e4)


class TestSettings:
    def test_lengths_follow(self):
        fields = Pores(**PORES).fields(dry_air())
        assert fields["thermal_length"] == pytest.approx(2 * fields["viscous_length"])
        assert Pores(**PORES, viscous_length=1e-2).fields(dry_air())["thermal_length"] == 1e-2

    @pytest.mark.parametrize(
        "changes",
        [{"porosity": 1.2}, {"porosity": 0.0}, {"flow_resistivity": -1.0}, {"tortuosity": 0.9}, {"rim": "half"}],
    )
    def test_impossible_pores(self, changes):
        with pytest.raises(ValidationError):
            Pores(**{**PORES, **changes})

    def test_plane_waves_have_no_rim(self):
        with pytest.raises(ValidationError, match="no rim"):
            FitSettings(pores=Pores(**PORES, rim="open"))

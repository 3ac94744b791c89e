"""Finite elements as a diagnosis uses them: as exact as it needs, of campaigns of an independent solver."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.diagnose import fit_nominal
from multilayer.diagnosis.effects.finite_size import FiniteSize
from multilayer.diagnosis.fitting import fit_effects
from multilayer.diagnosis.free_rim import Fineness, elements_of_samples, fit_samples, free_rim, rigs_around
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.places.sample import SampleShape
from multilayer.diagnosis.thresholds import MODEL_ERROR
from multilayer.errors import InputError
from multilayer.experiments.places import DrawnLaw, SimpleLaw, Term
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.effects import Chain
from multilayer.experiments.two_plate.finite_elements import FiniteRig, two_plate_rig
from multilayer.experiments.two_plate.motion import Neighbourhood, top_over_base
from multilayer.fits.joint.fit import fit_joint, number_of_steps
from multilayer.fits.joint.samples import solid_of
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import read_fit
from multilayer.inference.derivative import central
from multilayer.media.laws import LAWS
from multilayer.rig.shape_factor import relative_shape_factor, static_shape_factor
from multilayer.rig.synthesis import make_campaign
from multilayer.rig.two_plate import TwoPlateRig
from multilayer.testing.benches import joint_bench, soft_sample
from tests.rig.virtual import LAW, rig_file

BURSTS = np.array([150.0, 300.0, 600.0, 900.0, 1200.0, 1500.0])


def changed(shape, stated, errors, stiffness):
    """Return the modulus over that with the stated ratio, of a disc in slow compression."""
    joint = joint_bench()
    campaign = joint.campaign
    specimen = campaign.specimen.model_copy(update={"poisson_ratio": stated})
    slender = {"specimen_radius": 2 * shape * campaign.configurations[0].specimen_thickness}
    setting = replace(
        joint.settings[0],
        campaign=campaign.model_copy(update={"specimen": specimen}),
        configuration=campaign.configurations[0].model_copy(update=slender),
    )
    values = {"poisson_error": errors, "radial_stiffness": stiffness}
    return FiniteSize().modulus(setting, np.ones(1, dtype=complex), values).real


@pytest.mark.parametrize(("shape", "tolerance"), [(0.1, 1e-4), (0.5, 3e-4), (1.0, 3e-4)])
def test_poissons_ratio_between_those_that_are_solved(shape: float, tolerance: float):
    """Of discs from slender to flat, over all that an error of Poisson's ratio may be."""
    stated, errors = 0.3, np.array([-0.55, -0.2, 0.0, 0.13, 0.42, 0.6])
    exact = [static_shape_factor(stated * (1 + error), shape) for error in errors]
    found = changed(shape, stated, errors, np.ones(1))
    np.testing.assert_allclose(found, np.array(exact) / exact[2], rtol=tolerance)


@pytest.mark.parametrize(("stated", "shape"), [(0.2, 1.8), (0.3, 0.24), (0.3, 0.9), (0.4, 0.45)])
def test_a_sample_that_is_stiffer_along_its_radius(stated: float, shape: float):
    errors, stiffness = (part.ravel() for part in np.meshgrid([-0.15, 0.0, 0.15], [0.5, 0.75, 1.0, 1.5, 2.0]))
    exact = [
        static_shape_factor(stated * (1 + error), shape, radial_stiffness=float(t))
        for error, t in zip(errors, stiffness, strict=True)
    ]
    found = changed(shape, stated, errors, stiffness)
    np.testing.assert_allclose(found, np.array(exact) / static_shape_factor(stated, shape), rtol=1.5e-3)


@pytest.mark.reference
@pytest.mark.parametrize("name", ["paper-b", pytest.param("paper-c", marks=pytest.mark.slow)])
def test_elements_of_a_diagnosis_are_right_to_a_tenth_of_what_solvers_differ_by(shared: Path, name: str):
    """Of broad and of sharp resonances, on a mesh twice as fine and without a reduced basis."""
    job = read_fit(shared / "campaigns" / name)
    nominal, minima = fit_nominal(job.campaign, job.recordings)
    joint = nominal.hypothesis
    rigs, z = free_rim(joint, minima)
    configuration, data = job.campaign.configurations[0], joint.data[0]
    few = slice(None, None, 4)
    f = data.frequency[few]
    modulus = joint.space.modulus(joint.law_coordinates(z), f)
    exact = two_plate_rig(job.campaign, configuration).replaced(resolution=2.0).transmissibility(f, modulus)
    error = np.abs(rigs[data.name].transmissibility(f, modulus) / exact - 1)
    assert np.max(error) < MODEL_ERROR / 10
    assert len(f) > 5


@pytest.mark.parametrize(("error", "stiffness"), [(0.15, 1.0), (-0.15, 1.0), (0.0, 1.3), (0.0, 1 / 1.3)])
def test_what_the_static_stiffness_of_another_sample_misses(error: float, stiffness: float):
    """Per cents below the first waves along the radius, and most of it above, as the docstring of `FiniteSize` says."""
    f, modulus, shape, stated = np.linspace(100.0, 1500.0, 40), 1.5e5 * (1 + 0.2j), 0.45, 0.4
    size = {"radius": 0.0225, "thickness": 0.025, "density": 95.0, "plate_thickness": 1e-3}
    other = TwoPlateRig(poisson_ratio=stated * (1 + error), transverse_ratio=stiffness, **size)
    factor = relative_shape_factor(stated, shape, np.array(error), np.array(stiffness))
    static = TwoPlateRig(poisson_ratio=stated, **size).transmissibility(f, modulus * factor)
    missed = np.abs(np.log(static / other.transmissibility(f, modulus)))
    assert 0.02 < np.max(missed[f < 400]) < 0.08
    assert np.max(missed) > 0.5


@pytest.fixture(scope="module")
def made():
    """Return a campaign whose sample has E_r/E_z of 0.8."""
    settings = {"frequencies": [*BURSTS], "noise": {"white": 0.002}}
    return make_campaign(rig_file({"effect": "finite_size", "perturbation": -0.2}, **settings))


@pytest.fixture(scope="module")
def stiffer_along_its_radius(made):
    """Return the fit of that campaign with the static stiffness only, the elements about its sample, and the fit."""
    nominal, minima = fit_nominal(made.campaign, made.recordings)
    problem = nominal.hypothesis_as(CampaignProblem)
    rigs, start = free_rim(problem, minima)
    effects = {"finite_size": FiniteSize()}
    with_elements = replace(nominal, hypothesis=replace(problem, finite=rigs))
    static = fit_effects(with_elements, effects, start)[("finite_size",)]
    fitted = fit_samples(static, {name: make() for name, make in elements_of_samples(static).items()})
    return static, fitted.hypothesis_as(CampaignProblem).finite, fitted


@pytest.mark.slow
def test_a_sample_that_is_stiffer_along_its_radius_is_known_by_its_waves(stiffer_along_its_radius):
    """One configuration, whose static stiffness alone does not tell the radius from the modulus."""
    static, _, fitted = stiffer_along_its_radius
    assert static.minimum.cost_per_datum > 2
    assert fitted.minimum.cost_per_datum < 1
    value, low, high = fitted.interval("finite_size.radial_stiffness")
    assert low < 0.8 < high
    assert value == pytest.approx(0.8, abs=0.02)
    assert high - low < 0.1


@pytest.mark.slow
def test_a_fit_with_such_a_rim_finds_the_modulus(made):
    """The stated sample's is 1.7 % wrong."""
    true = LAWS[LAW["law"]](**{name: value for name, value in LAW.items() if name != "law"})(BURSTS)
    settings, told, errors = FitSettings(model="finite"), [], []
    for given in ((), (FiniteSize(),)):
        told.clear()
        fit = fit_joint(made.campaign, made.recordings, settings=settings, given=given, progress=told.append)
        errors.append(np.max(np.abs(fit.moduli(BURSTS)[0] / true - 1)))
    assert errors[0] > 0.01
    assert errors[1] < 0.003
    assert fit.p_value > 0.01
    value, deviation = fit.parameters["finite_size.radial_stiffness"]
    assert abs(value - 0.8) < 3 * deviation < 0.03
    assert len(told) <= number_of_steps(made.campaign, settings, given=given)
    with pytest.raises(InputError, match="'finite_size' needs finite elements"):
        fit_joint(made.campaign, made.recordings, given=given)


def test_a_fit_with_a_law_beyond_a_rim_has_the_rim(made):
    """With one configuration nothing but its prior is known of a change of the modulus that is the same everywhere."""
    law = SimpleLaw.at(SampleShape(needs_finite_elements=True), (Term("power", 0),), BURSTS, 1.0)
    fit = fit_joint(made.campaign, made.recordings, settings=FitSettings(model="finite"), given=(law,))
    assert all(isinstance(rig, FiniteRig) for rig in fit.problem.finite.values())
    value, deviation = fit.parameters[f"{law.name}.{law.parameters[0].name}"]
    assert abs(value) < deviation < 0.31


@pytest.mark.parametrize(("place", "variant"), [("top_plate", ""), ("plate", ""), ("one_configuration", "height")])
def test_laws_act_on_finite_elements_as_on_a_chain(place: str, variant: str):
    """At a Poisson's ratio of 0, where both are the same rig; imaginary parts of masses and heights, too."""
    joint = joint_bench()
    chain = replace(joint, configurations=joint.configurations[:1])
    (data,), z = chain.data, soft_sample(chain)
    bands = {data.name: (0.5 * data.frequency.min(), 2 * data.frequency.max())}
    fineness = Fineness(2.0, 1e-3, bands)
    rigs = rigs_around(chain.campaign, chain, chain.as_minimum(z), lambda _: None, FitSettings(), fineness)
    finite = replace(chain, rigs=rigs, finite=rigs)
    at = [one for one in PLACES[place].instances(joint.settings) if one.configuration in ("", data.name)]
    law_at = next(one for one in at if one.variant == variant)
    law = DrawnLaw.at(law_at, data.frequency, 0.3 * law_at.scale(chain.settings, 2e5))
    n = len(z) + len(law.nodes)
    z0 = np.concatenate([z, np.zeros(len(law.parameters))])
    changes = []
    for problem in (chain, finite):
        hypothesis = problem.with_effects(law)
        _, jacobian = hypothesis.linearised(z0)
        by_imaginary = jacobian[:, n:]
        np.testing.assert_allclose(by_imaginary, central(hypothesis.residual, z0)[1][:, n:], rtol=1e-3, atol=0.01)
        changes.append(by_imaginary)
    assert np.abs(changes[0]).max() > 100
    np.testing.assert_allclose(changes[1], changes[0], rtol=1e-4, atol=0.02)


def test_the_change_by_another_sample_is_that_of_finite_elements_of_it(stiffer_along_its_radius):
    _, rigs, fitted = stiffer_along_its_radius
    ((name, rig),) = rigs.items()
    problem = fitted.hypothesis_as(CampaignProblem)
    error, log_radial = solid_of(problem, fitted.minimum.z) + np.array([0.01, -0.02])
    f, setting = problem.data[0].frequency[::5], problem.settings[0]
    values = {"poisson_error": np.array([[error]]), "radial_stiffness": np.array([[np.exp(log_radial)]])}
    modulus = problem.modulus(fitted.minimum.z, f)[None]
    times = modulus * changed(setting.shape, problem.campaign.specimen.poisson_ratio, *(v[0] for v in values.values()))
    found = Neighbourhood(rig, 0.0, 0.0).log_motion(
        f, times, np.zeros((1, 1)), np.zeros((1, 1)), None, tuple(values.values())
    )
    described = two_plate_rig(problem.campaign, problem.campaign.configuration(name))
    sample = {"poisson_ratio": described.poisson_ratio * (1 + error), "transverse_ratio": float(np.exp(log_radial))}
    exact = described.replaced(resolution=2.0, **sample).transmissibility(f, modulus[0])
    assert np.max(np.abs(np.exp(found[0]) / exact - 1)) < MODEL_ERROR / 3


@pytest.mark.parametrize("added", ["glue", "spring"])
def test_glue_and_a_spring_act_on_the_stiffness_of_the_disc(stiffer_along_its_radius, added):
    """Below the resonance, as finite elements with a spring to the base, or a soft layer at each face, have it.

    The layer gives in shear, too, which lets the faces slide: 12 % more, which the law does not know.
    """
    static, _, _ = stiffer_along_its_radius
    problem = static.hypothesis_as(CampaignProblem)
    (setting,), (experiment,) = problem.settings, problem.experiments
    f = problem.data[0].frequency[:4]
    modulus = problem.modulus(static.minimum.z, f)
    thickness, soft, stiffness = 2e-4, 4e4, 2e4
    density, height = problem.campaign.specimen.density, setting.configuration.specimen_thickness
    plain = Chain(modulus, density, height, setting.plate_mass)
    chain = plain.glued(np.array(soft / thickness)) if added == "glue" else plain.with_(spring=np.array(stiffness))
    found = [np.log(top_over_base(experiment.near, setting, f, one)) for one in (chain, plain)]
    rig = two_plate_rig(problem.campaign, setting.configuration)
    glue = {
        "adhesive_thickness": thickness,
        "adhesive_modulus": soft,
        "adhesive_density": 1.0,
        "adhesive_poisson_ratio": 0.0,
    }
    other = rig.replaced(**(glue if added == "glue" else {"flanking_stiffness": stiffness}))
    exact = [np.log(one.transmissibility(f, modulus)) for one in (other, rig)]
    np.testing.assert_allclose(found[0] - found[1], exact[0] - exact[1], rtol=0.15 if added == "glue" else 0.06)

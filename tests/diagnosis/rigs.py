"""Readings of a two-plate rig in which effects act, without a rig."""

from dataclasses import replace

import numpy as np

from multilayer.diagnosis.effects.rocking import Rocking
from multilayer.diagnosis.fitting import Fitted, fit, minimise_scaled
from multilayer.experiments.places import SimpleLaw
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.fits.joint.search import law_space
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.testing.benches import joint_bench, soft_sample

F = np.geomspace(90.0, 1600.0, 40)
CENTRES = F[1::4]
TRIED = ("top_plate", "faces", "beside", "reading", "added_reading", "sample_radius")


def campaign():
    """Return three heights under two plates, and a slimmer sample."""
    shapes = [(h, t, 0.0225) for h in (0.0125, 0.025, 0.04) for t in (0.001, 0.003)] + [(0.025, 0.001, 0.012)]
    bursts = [{"frequency": float(f), "file": f"{f:g}.npz"} for f in CENTRES]
    described = joint_bench().campaign.model_dump(exclude={"folder", "configurations"}, mode="json")
    configurations = [
        {"name": f"c{i}", "specimen_thickness": h, "top_plate_thickness": t, "specimen_radius": r, "bursts": bursts}
        for i, (h, t, r) in enumerate(shapes)
    ]
    return Campaign.model_validate({**described, "configurations": configurations})


def problem():
    """Return a problem of that campaign with a noise of 0.4 %, whose readings are all 1."""
    described, ones, bursts = campaign(), np.ones(F.size), np.arange(F.size) // 4
    flat = [
        ConfigurationData(c.name, c.specimen_thickness, F, bursts, ones + 0j, 1.6e-5 * ones, CENTRES)
        for c in described.configurations
    ]
    rigs = {c.name: PlaneWaveRig.of(described, c) for c in described.configurations}
    space = law_space("fractional_zener", F, np.full(F.size, 3e5 * (1 + 0.3j)))
    return CampaignProblem(described, flat, rigs, space, Uncertainty(top_plate_mass=0.002, thickness=5e-5))


def measured_with(effects, values, seed=0):
    """Return a nominal fit to readings in which effects act; the values of all their parameters in order."""
    rng, flat = np.random.default_rng(seed), problem()
    z = soft_sample(flat)
    parameters = [parameter for effect in effects for parameter in effect.parameters]
    sizes = [parameter.prior.coordinate(value) for parameter, value in zip(parameters, values, strict=True)]
    shown = flat.with_effects(*effects).differences(np.concatenate([z, sizes]))
    shape = (len(flat.data), F.size)
    noise = 0.004 * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    data = [replace(d, ratio=np.exp(s + n)) for d, s, n in zip(flat.data, shown, noise, strict=True)]
    nominal = replace(flat, configurations=data)
    return Fitted(nominal, minimise_scaled(nominal, z))


def measured(*acting, seed=0):
    """Return a nominal fit to readings in which simple laws act at places: each a place, a term, and its values."""
    settings = problem().settings
    laws = [SimpleLaw.at(place, (term,), F, place.scale(settings, 3e5)) for place, term, _ in acting]
    return measured_with(laws, [value for *_, values in acting for value in values], seed)


def rocking(configurations):
    """Return the nominal fit of so many configurations, and one with the rocking mode at 700 Hz that acts in them."""
    sizes = (0.03, 700.0, 0.1)
    whole = measured_with([Rocking()], sizes).hypothesis
    nominal = whole.with_data(whole.data[:configurations])
    z = soft_sample(whole)[: len(nominal.nominal_parameters)]
    effect = [p.prior.coordinate(value) for p, value in zip(Rocking.parameters, sizes, strict=True)]
    known = nominal.with_effects(Rocking())
    return fit(nominal, z), Fitted(known, minimise_scaled(known, np.concatenate([z, effect])))

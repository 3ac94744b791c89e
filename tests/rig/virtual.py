"""Files of virtual rigs, and a rod in place of the finite elements where these are not what is tested."""

import numpy as np

from multilayer.media.rod import rod_transmissibility
from multilayer.rig.bench import Bench
from multilayer.rig.draws import draw_errors
from multilayer.rig.file import RigFile
from multilayer.rig.synthesis import make_campaign

LAW = {
    "law": "fractional_zener",
    "relaxed_modulus": 1e5,
    "unrelaxed_modulus": 1e6,
    "relaxation_time": 1e-4,
    "order": 0.5,
}
DATA = {
    "version": 1,
    "rig": "two-plate",
    "specimen": {"density": 80.0, "poisson_ratio": 0.3, "young_modulus": LAW},
    "frequencies": [200.0, 500.0, 900.0],
    "configurations": {"thicknesses": [0.025], "top_plates": [0.001]},
    "repeats": 2,
    "noise": {"white": 0.0, "bits": None},
}


def rig_file(*effects, **changes):
    """Return the file with these effects, each by its name or as a mapping, and other values in some fields."""
    listed = [{"effect": one} if isinstance(one, str) else one for one in effects]
    return RigFile.model_validate({**DATA, **changes, "effects": listed})


def bench(*effects, index=0, seed=0, **changes):
    """Return one configuration of such a file."""
    settings = rig_file(*effects, **changes)
    return Bench(settings, draw_errors(settings, seed), settings.mountings[index])


def top_mass(geometry):
    """Return the mass per area of top plate and accelerometer, kg/m2."""
    sensor = geometry.get("sensor_mass", 0.0) / (np.pi * geometry["radius"] ** 2)
    return geometry["plate_density"] * geometry["plate_thickness"] + sensor


def rod(self, frequency, modulus):
    """Return what the finite elements give of a rod under a rigid mass; stands for `Bench._transmissibility`."""
    return rod_transmissibility(
        frequency, modulus, self.geometry["density"], self.geometry["thickness"], top_mass(self.geometry)
    )


def measured(*effects, **changes):
    """Return top over base at each burst of each configuration and repeat, as the signals have it.

    Complex array of shape (bursts of all configurations, repeats).
    """
    made = make_campaign(rig_file(*effects, **changes))
    return np.array([ratio(recording, frequency) for (_, frequency), recording in made.recordings.items()])


def ratio(recording, frequency):
    """Return top over base at one frequency, by repeats."""
    turn = np.exp(-2j * np.pi * frequency * recording.time)
    return (recording.top @ turn) / (recording.base @ turn)

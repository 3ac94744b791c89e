"""Bursts of several campaigns as a fit would report them, with errors drawn from what they state."""

import numpy as np
from multilayer_campaigns.modulus_points import ModulusPoint, covariance_of, values_of

from multilayer.fits.burst.uncertainty import ErrorParts

RADIUS = 0.0225
STATED = {
    "channel_gain": np.array([0.01, 0.002]),
    "remount_gain": np.array([0.003, 0.001]),
    "thickness": np.array([0.004, 0.0]),
    "density": np.array([0.002, 0.0]),
}


def point(campaign=0, frequency=500.0, stress=80.0, thickness=0.025, storage_modulus=2e5, loss_factor=0.3, noise=0.002):
    """Return one burst; `noise` is the standard deviation of ln E1 and of the loss factor that is its own."""
    errors = ErrorParts(noise**2 * np.eye(2), STATED, np.array([[1.0, 0.2], [0.1, 1.0]]))
    spread = np.sqrt(np.diag(errors.covariance))
    name = f"h{thickness:g}-s{stress:g}"
    return ModulusPoint(
        campaign, name, frequency, (thickness, RADIUS), stress, storage_modulus, loss_factor, tuple(spread), errors
    )


def drawn(points, seed, **options):
    """Return the points with errors drawn from `covariance_of` with these options."""
    rng = np.random.default_rng(seed)
    logs, losses = np.split(rng.multivariate_normal(values_of(points), covariance_of(points, **options)), 2)
    pairs = zip(points, np.exp(logs), losses, strict=True)
    return [ModulusPoint(**{**vars(p), "storage_modulus": float(e), "loss_factor": float(x)}) for p, e, x in pairs]

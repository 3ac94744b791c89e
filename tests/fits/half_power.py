"""An inverse method in one file, as a plugin brings it: E1 and loss factor from the width of the resonance's peak."""

from __future__ import annotations

import numpy as np

from multilayer.experiments.two_plate.burst import BurstData
from multilayer.fits.methods import CampaignMethod, Progress
from multilayer.fits.result import BurstFit, FitResult
from multilayer.fits.sources import FitJob
from multilayer.measurements.description import Campaign, Configuration
from multilayer.rig.shape_factor import static_shape_factor

_TIMES = 20  # the power of f settles by a third each time


class HalfPower(CampaignMethod):
    """A mass on a spring of complex stiffness, one modulus per configuration: that at its resonance f0.

    With ``K = K0 (1 + i eta) (f/f0)^n``, ``n = (2/pi) atan(eta)``, the causal law of constant loss factor, 1/abs(T)^2
    is proportional to ``(1 - y)^2 + eta^2``, ``y = (f/f0)^(2 - n)``: a parabola in f^(2 - n), whose lowest point is the
    resonance and whose width is eta. At ``y = 1 +- eta`` half of the power is left, hence the name of the method
    (L. Cremer, M. Heckl & B. A. T. Petersson, Structure-Borne Sound, 3rd ed., 2005). The sample adds a third of its
    mass to that of the plate (Rayleigh).
    """

    name = "half-power"
    title = "half-power width of the resonance"
    summary = "E1 and E2 at the resonance of every configuration, from frequency and width of its peak"

    def number_of_steps(self, job: FitJob) -> int:
        """Return the number of configurations."""
        return len(job.campaign.configurations)

    def run(self, job: FitJob, tell: Progress) -> FitResult:
        """Return a modulus for every configuration."""
        moduli = []
        for configuration in job.campaign.configurations:
            bursts = [burst for burst in job.bursts if burst.configuration == configuration.name]
            moduli.append(_modulus(job.campaign, configuration, bursts))
            tell(configuration.name)
        return FitResult(job.name, self.name, job.plain_settings(), moduli)


def _modulus(campaign: Campaign, configuration: Configuration, bursts: list[BurstData]) -> BurstFit:
    peak = max(bursts, key=lambda burst: abs(burst.transmissibility))
    f, base, top = peak.local
    loss = 0.0
    for _ in range(_TIMES):
        power = 2 - 2 / np.pi * np.arctan(loss)
        a, b, c = np.polyfit((f / peak.frequency) ** power, np.abs(base / top) ** 2, 2)
        lowest = -b / (2 * a)
        loss = float(np.sqrt(max(c / a - lowest**2, 0.0)) / lowest)
    resonance = float(peak.frequency * lowest ** (1 / power))
    radius, thickness = configuration.specimen_radius, configuration.specimen_thickness
    mass = campaign.top_plate.density * configuration.top_plate_thickness + campaign.specimen.density * thickness / 3
    shape = static_shape_factor(campaign.specimen.poisson_ratio, radius / (2 * thickness))
    e1 = (2 * np.pi * resonance) ** 2 * mass * thickness / shape
    reason = "" if f[0] <= resonance <= f[-1] else "no burst has the resonance in its band"
    return BurstFit(
        configuration.name, resonance, e1, np.nan, e1 * loss, np.nan, loss, np.nan, accepted=not reason, reason=reason
    )

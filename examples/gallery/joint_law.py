"""
One causal law for all bursts
=============================

The same foam with its free rim (finite elements of the disc) and one fractional Zener law for all bursts at once. The
laboratory's own uncertainties are unknowns with priors, so that their part in the bands is exact to second order.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.joint.posterior import modulus_band, with_posterior
from multilayer.fits.sources import read_fit

job = read_fit(Path("../foam_b"), model="finite")
fit = with_posterior(fit_joint(job.campaign, job.recordings, "fractional_zener", settings=job.settings))
print(fit.law)
print(f"chi-square {fit.best.cost:.0f} for {fit.n_data} data, p = {fit.p_value:.2f}")

# %%
# The 90 % band of the posterior, within the bursts' range and a decade beyond on either side. Outside of that range the
# law is all there is, and the band of E2 widens first. That the law goes on there is an assumption, of which no band
# knows.
frequency = np.geomspace(10, 15e3, 80)
modulus = fit.law(frequency)
band = modulus_band(fit, frequency, 0.9)

figure, (upper, lower) = plt.subplots(2, sharex=True, layout="constrained")
for row, (name, values) in enumerate({"E1": modulus.real, "E2": modulus.imag}.items()):
    upper.loglog(frequency, values / 1e3, label=name)
    lower.loglog(frequency, 50 * (band.high[row] - band.low[row]) / values, label=name)
for axes in (upper, lower):
    axes.axvspan(100, 1500, color="0.9", zorder=0, label="measured")
upper.set(ylabel="modulus / kPa")
lower.set(xlabel="frequency / Hz", ylabel="half width of the 90 % band / %")
upper.legend()
plt.show()

# %%
# What the data determine of the law, parameter by parameter:
for sentence in fit.summary.identifiability.sentences[:4]:
    print(sentence)

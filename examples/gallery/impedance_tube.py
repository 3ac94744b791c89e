"""
Raw data of an impedance tube
=============================

Transfer functions of two microphones in front of a foam, once as they stand and once with the microphones exchanged
(ISO 10534-2). What the two channels differ by falls out of the mean; without the exchange it would pass for absorption.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from multilayer import load_stack, plane_wave
from multilayer.signals.impedance_tube import reflection_coefficient
from multilayer.tube.evaluate import evaluate

result = evaluate(Path("../raw_tube"))
low, high = result.working_range
print(f"{len(result.frequency)} frequencies; plane waves and a useful spacing from {low:.0f} to {high:.0f} Hz")

# %%
# The measurement as it stands, without the exchange, from the same formula:
raw = np.genfromtxt("../raw_tube/h12.csv", delimiter=",", skip_header=1, names=True)
foam = load_stack("../foam_tube/truth.yaml")
spacing, distance = 0.035, 0.080
inside = (raw["frequency_hz"] >= low) & (raw["frequency_hz"] <= high)
h12 = (raw["h12_re"] + 1j * raw["h12_im"])[inside]
wavenumber = 2 * np.pi * raw["frequency_hz"][inside] / foam.ambient.gas.sound_speed
uncorrected = 1 - np.abs(reflection_coefficient(h12, wavenumber, spacing, distance + spacing)) ** 2

# %%
# Beside both stands the foam that the data were computed from.
truth = plane_wave(foam, result.frequency).absorption
corrected = result.spectra["tube"]["absorption"]

figure, axes = plt.subplots(layout="constrained")
axes.plot(result.frequency, uncorrected, "--", label="one position of the microphones")
axes.plot(result.frequency, corrected, ".", label="exchanged")
axes.plot(result.frequency, truth, "k-", linewidth=1, label="truth")
axes.set(xlabel="frequency / Hz", ylabel="absorption coefficient")
axes.legend()
plt.show()
print(f"largest error: {np.abs(uncorrected - truth).max():.3f} before, {np.abs(corrected - truth).max():.3f} after")

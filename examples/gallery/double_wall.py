"""
Double wall: plane wave, diffuse field, finite size
===================================================

Two aluminium plates with a poroelastic foam and an air gap between them. What a wave from one direction meets, what a
diffuse field meets, and what a panel of 1.4 m by 1.1 m in a baffle makes of it: at low frequencies a panel smaller than
the wavelength radiates less than an infinite one.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer import diffuse_field, load_stack, plane_wave
from multilayer.response import Window, band_levels
from multilayer.response.ratings import weighted_reduction_index

stack = load_stack("../double_wall.yaml")
print(", ".join(f"{layer.name}: {layer.type}" for layer in stack.layers))

# %%
# Angles are chosen frequency by frequency, until the transmission loss is known to 0.01 dB.
frequency = np.geomspace(80, 6000, 150)
oblique = plane_wave(stack, frequency, 45).transmission_loss
infinite = diffuse_field(stack, frequency).transmission_loss
finite = diffuse_field(stack, frequency, window=Window(1.4, 1.1)).transmission_loss

figure, axes = plt.subplots(layout="constrained")
axes.semilogx(frequency, oblique, label="plane wave, 45°")
axes.semilogx(frequency, infinite, label="diffuse field, infinite")
axes.semilogx(frequency, finite, label="diffuse field, 1.4 m × 1.1 m")
axes.set(xlabel="frequency / Hz", ylabel="transmission loss / dB")
axes.legend()
plt.show()

# %%
# Means of the transmitted power over third octaves give the single numbers of ISO 717-1.
for name, loss in {"infinite": infinite, "finite": finite}.items():
    rating = weighted_reduction_index(band_levels(frequency, loss))
    print(f"{name}: {rating}")

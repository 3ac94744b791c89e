"""
Absorption of a foam at several angles
======================================

A foam of 50 mm on a wall, its frame at rest: the model of Johnson, Champoux and Allard. Plane waves from four
directions, and the diffuse field that is their mean, weighted by the sine of twice the angle.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer import diffuse_field, load_stack, plane_wave

stack = load_stack("../foam_absorption.yaml")
print(stack.layers[0])

# %%
# All frequencies meet all angles in one call; the result has the shape (frequencies, angles).
frequency = np.geomspace(100, 5000, 300)
angles = [0, 30, 60, 80]
alpha = plane_wave(stack, frequency, angles).absorption
print(alpha.shape)

# %%
# The diffuse field goes up to 78 degrees unless ``max_angle`` says otherwise, and tells how well it was integrated.
diffuse = diffuse_field(stack, frequency)
print(f"largest estimated error: {diffuse.absorption_error.max():.1e}")

figure, axes = plt.subplots(layout="constrained")
for angle, curve in zip(angles, alpha.T, strict=True):
    axes.semilogx(frequency, curve, label=f"{angle}°")
axes.semilogx(frequency, diffuse.absorption, "k--", label="diffuse field")
axes.set(xlabel="frequency / Hz", ylabel="absorption coefficient", ylim=(0, 1))
axes.legend()
plt.show()

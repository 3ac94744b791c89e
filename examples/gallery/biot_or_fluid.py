"""
When does the frame of a foam move?
===================================

A foam glued to a wall, by three models: its frame at rest (an equivalent fluid), limp, and elastic (Biot: three waves,
six components of the field). The elastic frame resonates where its own wave has a quarter of its length in the layer.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer import Stack, plane_wave
from multilayer.media.elastic import p_wave_modulus

pores = {
    "thickness": 0.03,
    "porosity": 0.97,
    "flow_resistivity": 40e3,
    "tortuosity": 1.8,
    "viscous_length": 40e-6,
    "thermal_length": 110e-6,
}
frame = {"frame_density": 30.0}
elastic = {"young_modulus": 300e3, "poisson_ratio": 0.3, "loss_factor": 0.1}
models = {
    "at rest": {"type": "equivalent_fluid", "model": "jca", **pores},
    "limp": {"type": "limp", "model": "jca", **pores, **frame},
    "elastic (Biot)": {"type": "poroelastic", **pores, **frame, **elastic},
}
stacks = {name: Stack.model_validate({"layers": [layer], "termination": "rigid"}) for name, layer in models.items()}

# %%
# One layer type takes the place of the other; walls and neighbours are matched to what each has to say.
frequency = np.linspace(50, 3000, 600)
absorption = {name: plane_wave(stack, frequency).absorption for name, stack in stacks.items()}

quarter = np.sqrt(p_wave_modulus(300e3, 0.3) / 30) / (4 * pores["thickness"])
difference = np.abs(absorption["elastic (Biot)"] - absorption["at rest"])
print(f"quarter wave of the frame in vacuo: {quarter:.0f} Hz")
print(f"the frame changes the absorption most, by {difference.max():.2f}, at {frequency[difference.argmax()]:.0f} Hz")

figure, axes = plt.subplots(layout="constrained")
for name, curve in absorption.items():
    axes.plot(frequency, curve, label=f"frame {name}")
axes.axvline(quarter, color="0.6", linewidth=1)
axes.set(xlabel="frequency / Hz", ylabel="absorption coefficient", ylim=(0, 1))
axes.legend()
plt.show()

# %%
# The transfer matrix of the book can be had of any layer, to be read or compared; the solver itself never forms it,
# for its entries grow without bound with the thickness.
matrix = stacks["elastic (Biot)"].layers[0].transfer_matrix(500.0, 30.0)
print(np.array2string(np.abs(matrix), precision=2, suppress_small=False))

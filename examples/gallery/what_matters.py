"""
What matters: exact derivatives of the transmission loss
========================================================

Which thickness, density or resistivity of a double wall is worth changing, and at which frequency? The derivative of
every result by every field of every layer comes with the result itself, from the adjoint of the same solution: for all
fields at once it costs about as much as two further solutions, and is exact to rounding.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer import load_stack, plane_wave
from multilayer.paths import locate, with_values
from multilayer.response import plane_wave_derivatives

stack = load_stack("../double_wall.yaml")
frequency = np.geomspace(80, 5000, 200)
found = plane_wave_derivatives(stack, None, frequency, angle=45)
print(f"{len(found.fields)} fields: {', '.join(found.fields)}")

# %%
# A derivative by a thickness is in dB per metre. What one can compare is the change for 1 % more of each field.
values = np.array([locate(stack, field).value for field in found.fields])
change = 0.01 * values[:, None] * found.transmission_loss
order = np.argsort(-np.abs(change).mean(axis=1))[:6]
for place in order:
    print(f"{found.fields[place]:38} {np.abs(change[place]).mean():5.3f} dB in the mean, for 1 % more")

# %%
# The resonance of the two plates on the spring between them, at 160 Hz, moves with everything that is heavy or soft.
figure, (upper, lower) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(6.4, 6.4))
upper.semilogx(frequency, found.response.transmission_loss, "k")
upper.set(ylabel="transmission loss / dB")
for place in order:
    lower.semilogx(frequency, change[place], label=found.fields[place].removeprefix("layers."))
lower.set(xlabel="frequency / Hz", ylabel="change for 1 % more / dB", ylim=(-0.2, 0.2))
lower.legend(fontsize="small")
plt.show()

# %%
# A difference says the same, as far as it can: of one field at a time, and with the digits that a difference loses.
field = found.fields[order[0]]
more = with_values(stack, {field: 1.0001 * locate(stack, field).value})
difference = plane_wave(more, frequency, 45).transmission_loss - found.response.transmission_loss
disagreement = np.abs(1e2 * difference - change[order[0]]).max()
print(f"{field}: largest disagreement {disagreement:.1e} dB, of changes up to {np.abs(change[order[0]]).max():.2f} dB")

"""
The best absorber within a depth
================================

Which two layers of three materials, with or without a gap behind them, make the best absorber of 50 mm below 1.5 kg/m2?
`multilayer optimise` asks the computer: thicknesses by gradients from many starts, materials and layers by trying them
all. The file says what may vary, what is wanted, and the limits.
"""

import matplotlib.pyplot as plt

from multilayer.optimisation.file import load_optimisation
from multilayer.optimisation.run import optimise

file = load_optimisation("../best_absorber.yaml")
result = optimise(file, name="best_absorber")
print(f"{result.searches} searches over {result.variants} combinations of materials and layers")

# %%
# The design as written, and the best that was found; its file can be simulated, explored, and optimised again.
for design in (result.written, result.best):
    thicknesses = ", ".join(f"{name.removesuffix('.thickness')} {1e3 * t:.1f} mm" for name, t in design.values.items())
    print(f"{design.name}: alpha_w {design.goals[0]:.2f}; {thicknesses}; {', '.join(design.choices.values())}")

# %%
# alpha_w comes in steps of 0.05; the search follows the shift of the reference curve, which has none.
figure, axes = plt.subplots(layout="constrained")
for design, style in ((result.written, "k--"), (result.best, "-")):
    alpha = design.case.quantities["absorption"]
    axes.semilogx(result.simulated.frequency, alpha, style, label=f"{design.name}: alpha_w {design.goals[0]:.2f}")
axes.set(xlabel="frequency / Hz", ylabel="absorption coefficient, diffuse field", ylim=(0, 1))
axes.legend()
plt.show()

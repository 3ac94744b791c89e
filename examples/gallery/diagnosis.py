"""
Why do model and measurement disagree?
======================================

A small simulated campaign, two top plates and five bursts each, whose top channel reads 4 % too much. The diagnosis is
not told. It says whether there is a gap, which effect causes it, and how far the gap shrinks on data left out of the
fit. Here it chooses among four effects, to be quick; the command line tries all it knows.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer.diagnosis.diagnose import chosen_effects, diagnose_campaign
from multilayer.rig.file import RigFile
from multilayer.rig.synthesis import make_campaign

settings = RigFile.model_validate(
    {
        "version": 1,
        "rig": "two-plate",
        "seed": 1,
        "specimen": {
            "density": 80.0,
            "young_modulus": {
                "law": "fractional_zener",
                "relaxed_modulus": 1e5,
                "unrelaxed_modulus": 1e6,
                "relaxation_time": 1e-4,
                "order": 0.5,
            },
        },
        "frequencies": [200.0, 400.0, 600.0, 800.0, 1000.0],
        "configurations": {"thicknesses": [0.025], "top_plates": [1e-3, 3e-3]},
        "uncertainty": {"channel_gain": 0.003, "channel_delay": 1e-6, "thickness": 5e-5, "density": 0.01},
        "effects": [{"effect": "channel_gain", "gain": 0.04}],
    }
)
made = make_campaign(settings)

# %%
effects = chosen_effects(["channel_gain", "channel_delay", "sensor_mass", "adhesive"])
diagnosis = diagnose_campaign(made.campaign, made.recordings, effects)
print(diagnosis.record["sentence"])
for cause in diagnosis.record["causes"][:3]:
    name = {"": "no gap", "unknown": "none of the known"}.get(name := " + ".join(cause["effects"]), name)
    print(f"{name}: probability {cause['probability']:.2f}")
gain = diagnosis.record["causes"][0]["parameters"]["channel_gain.gain"]
print(f"size {gain['value']:.3f}, 90 % interval {gain['low']:.3f} to {gain['high']:.3f}")

# %%
# The level that the models leave of every burst, its bins weighted by their certainty. The modulus law takes up most of
# the gain; what it cannot take up shows in the lowest bursts, where the top plate moves nearly as the base does and
# stiffness hardly counts.
figure, axes = plt.subplots(layout="constrained")
for curves in diagnosis.curves:
    weight = curves.sigma_level**-2
    total = np.bincount(curves.burst, weight)
    f = np.bincount(curves.burst, weight * curves.frequency) / total
    before, after = (np.bincount(curves.burst, weight * x) / total for x in (curves.level_before, curves.level_after))
    (line,) = axes.plot(f, before, "o--", label=f"{curves.configuration}, nominal")
    axes.plot(f, after, "o-", color=line.get_color(), label=f"{curves.configuration}, with the cause")
axes.set(xlabel="frequency / Hz", ylabel="level, measured minus modelled / dB")
axes.legend()
plt.show()

# %%
# From what size on each effect would have shown in these data, at five standard deviations:
for name, size in diagnosis.record["detectable"].items():
    print(f"{name}: {size['parameter']} {size['smallest']} {size['unit']}")

"""
A campaign on the virtual rig
=============================

Finite elements take the place of the shaker. The file describes four configurations and an accelerometer of 1 g that
nobody told the experimenter of; the same file without the effect says what the accelerometer does to the moduli.
"""

import matplotlib.pyplot as plt
import numpy as np

from multilayer import fit_campaign
from multilayer.rig.file import load_rig
from multilayer.rig.synthesis import make_campaign

settings = load_rig("../virtual_rig.yaml")
made = make_campaign(settings)
clean = make_campaign(settings.model_copy(update={"effects": ()}))
print(made.truth["effect"], made.truth["parameters"])

# %%
# What a burst looks like, under and above the sample.
recording = made.recordings["h25mm-t1mm", 400.0]
base, top = recording.mean()

figure, axes = plt.subplots(layout="constrained")
axes.plot(1e3 * recording.time, base, label="base")
axes.plot(1e3 * recording.time, top, label="top plate")
axes.set(xlabel="time / ms", ylabel="acceleration / (m/s²)")
axes.legend()
plt.show()

# %%
# Both campaigns fitted by the same model, beside the truth that only the maker knows. The thinner the top plate, the
# more a gram weighs.
figure, axes = plt.subplots(layout="constrained")
found = {}
for name, campaign in {"with accelerometer": made, "without": clean}.items():
    result = fit_campaign(campaign.campaign, campaign.recordings)
    frequency, found[name] = result.columns("h25mm-t1mm", "frequency", "storage_modulus")
    axes.plot(frequency, found[name] / 1e3, "o", label=f"fitted, {name}")
truth = np.real(settings.specimen.modulus(frequency))
axes.plot(frequency, truth / 1e3, "k-", label="truth")
axes.set(xlabel="frequency / Hz", ylabel="E1 / kPa")
axes.legend()
plt.show()
print("E1 over the truth:", {name: np.round(values / truth, 3).tolist() for name, values in found.items()})

"""Air in pores, static preload and anisotropy against the truth: ``docs/validation/extensions.md``.

Run it as ``python -m validation.extensions > docs/validation/extensions.md``; ten minutes of computing.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from multilayer_campaigns.modulus_points import points_of
from multilayer_campaigns.preload import fit_preload

from multilayer.experiments.two_plate.pores import Pores
from multilayer.fits.burst.fit import fit_bursts
from multilayer.fits.joint.fit import fit_joint
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import FitJob, read_fit
from validation.extensions_rig import cube_once, in_deviations, preload_once, rods, transversely_isotropic
from validation.scoring import score, true_modulus

CAMPAIGNS = Path(__file__).parents[1] / ".." / "shared" / "campaigns"
AIR = CAMPAIGNS / "effect-saturating-air"
POROSITY, DRAWS, STIFFENING = 0.97, 16, 5e-4
STIFFER = 1.2
_SLOPE = 1e4 * STIFFENING

HEADING = """# Air in the pores, static preload, anisotropy: against the truth

Made by `python -m validation.extensions`. `docs/extensions.md` says what is done.
"""
AIR_HEADING = f"""## Air in the pores

`effect-saturating-air`: signals of an independent finite-element rig, air leaving by the rim. The campaign does not
state the pores; a laboratory would measure them. Here the flow resistivity is the true one and the porosity a guess,
{POROSITY:g} (the truth file does not tell it); tortuosity 1, lengths of cylindrical pores. `model: finite`.

Burst by burst, 105 bursts:

| pores | accepted | median error E1 | E2 | 9 in 10 within, E1 | E2 | within 2 s, E1 | E2 |
|---|---|---|---|---|---|---|---|"""
JOINT_HEADING = """
One law for all (`--joint`), at the 15 frequencies. Its standard deviations are not scored: they take the pores as
exactly known.

| pores | chi-square (1260 data) | p | largest error E1 | E2 | rms error E1 | E2 |
|---|---|---|---|---|---|---|"""
PRELOAD_HEADING = f"""
The air of this foam adds losses: E2 is what pores set right. E1 is as good without them.

## Static preload

On the virtual rig: one specimen under plates of 1, 2, 3 and 5 mm (77 to 385 Pa), four frequencies, all errors that the
laboratory states drawn anew {DRAWS} times. True slope of E1 {_SLOPE:g} % per 100 Pa or none, of the loss factor none.
"rms" is that of the errors in standard deviations: 1 where these are right, less where they are too large. They allow
0.2 % for a model error that the virtual rig does not have.

| slope | of | mean found, % per 100 Pa | stated deviation | rms | within 2 s | seen | hint | none |
|---|---|---|---|---|---|---|---|---|"""
SHARED_HEADING = """
The shared campaigns, two plates on each of three heights, none of them with a preload: whatever is *seen* here is
another effect that the model lacks and that a heavier plate changes. Further lines are fits that know the effect; plane
waves spread the accelerometer over the plate, which bends under it in truth.

| campaign | model | slope of E1, % per 100 Pa | verdict | slope of loss factor | verdict | deviations enlarged by |
|---|---|---|---|---|---|---|"""
AXES_HEADING = f"""
## Anisotropy

On the virtual rig: a cube measured along three axes, two plates, four frequencies; gain, delay, plate mass and density
drawn once per cube, the rest once per axis; {DRAWS} cubes each. Ratios to the mean of the axes, all frequencies.

| cube | of | mean ratio x, y, z | stated deviation | rms | 95 % hold the truth | isotropic by the test |
|---|---|---|---|---|---|---|"""
FREE_HEADING = """
**With a Poisson's ratio.** A material of Poisson's ratio 0.3 that is stiffer along z by a factor, without noise and
errors, its rim free; fitted with `model: finite`, which is isotropic. Across z the rig takes the mean of both
transverse moduli. The ratio that is found, z over x:

| true | found, E1 | E2 |
|---|---|---|"""


def say(line: str) -> None:
    """Print a line of the page."""
    print(line, flush=True)  # noqa: T201


def tell(line: str) -> None:
    """Say on standard error what is being done."""
    print(line, file=sys.stderr, flush=True)  # noqa: T201


def with_pores(porosity: float | None, factor: float) -> FitSettings:
    """Return settings of the finite model with the true resistivity times a factor, or without pores."""
    if porosity is None:
        return FitSettings(model="finite")
    resistivity = factor * truth_of(AIR)["sigma"]
    return FitSettings(model="finite", pores=Pores(porosity=porosity, flow_resistivity=resistivity))


def pores() -> None:
    """Print both tables of the air in the pores."""
    job = read_fit(AIR)
    say(AIR_HEADING)
    for name, porosity in (("none", None), ("stated", POROSITY)):
        tell(f"bursts, pores: {name}")
        result = fit_bursts(job.campaign, job.recordings, with_pores(porosity, 1.0))
        found = score(result, AIR)
        errors, held = np.abs(found.relative), (np.abs(found.in_sigmas) <= 2).mean(axis=0)
        cells = [f"{100 * v:.1f} %" for v in (*np.median(errors, axis=0), *np.quantile(errors, 0.9, axis=0))]
        say(
            f"| {name} | {found.accepted.sum()} | {' | '.join(cells)} | {100 * held[0]:.0f} % | {100 * held[1]:.0f} % |"
        )
    say(JOINT_HEADING)
    variants = {
        "none": (None, 1.0), "stated": (POROSITY, 1.0), "resistivity 10 % low": (POROSITY, 0.9),
        "resistivity 10 % high": (POROSITY, 1.1), "porosity 0.93": (0.93, 1.0), "porosity 0.99": (0.99, 1.0),
    }  # fmt: skip
    for name, (porosity, factor) in variants.items():
        tell(f"joint, pores: {name}")
        say(joint_row(name, job, with_pores(porosity, factor)))


def joint_row(name: str, job: FitJob, settings: FitSettings) -> str:
    """Return one line of the table of joint fits."""
    fit = fit_joint(job.campaign, job.recordings, settings=settings)
    at = np.array([row["frequency_hz"] for row in fit.rows()])
    truth, moduli = true_modulus(AIR, at), fit.moduli(at)[0]
    off = np.stack([moduli.real / truth.real - 1, moduli.imag / truth.imag - 1], axis=-1)
    cells = [f"{100 * v:.2f} %" for v in (*np.abs(off).max(axis=0), *np.sqrt(np.mean(off**2, axis=0)))]
    return f"| {name} | {fit.best.cost:.0f} | {fit.p_value:.2g} | {' | '.join(cells)} |"


def preload() -> None:
    """Print both tables of the preload."""
    say(PRELOAD_HEADING)
    for stiffening in (STIFFENING, 0.0):
        tell(f"preload: {stiffening:g}")
        found = [preload_once(stiffening, seed) for seed in range(DRAWS)]
        for name, truth in (("storage", stiffening), ("loss", 0.0)):
            slopes = [getattr(one, name) for one in found]
            values, spread = (np.array([getattr(s, part) for s in slopes]) for part in ("value", "std"))
            rms, within = in_deviations(values, np.array(truth), spread)
            counts = [sum(s.verdict == verdict for s in slopes) for verdict in ("seen", "hint", "none")]
            label = f"{1e4 * stiffening:g} % | {'E1' if name == 'storage' else 'loss factor'}"
            numbers = f"{1e4 * values.mean():+.2f} | {1e4 * np.median(spread):.2f} | {rms:.2f} | {100 * within:.0f} %"
            say(f"| {label} | {numbers} | {' | '.join(map(str, counts))} |")
    say(SHARED_HEADING)
    for folder in sorted(path for path in CAMPAIGNS.glob("effect-*") if path.is_dir()):
        tell(f"preload: {folder.name}")
        for settings in settings_of(folder):
            say(shared_row(folder, settings))


def truth_of(folder: Path) -> dict[str, float]:
    """Return the parameters of a campaign's effect."""
    return dict(json.loads(folder.with_name(f"{folder.name}.truth.json").read_text())["parameters"])


def settings_of(folder: Path) -> list[FitSettings]:
    """Return the settings a shared campaign is fitted with: the default, and what knows its effect."""
    plain = FitSettings()
    if folder.name == AIR.name:
        return [plain, with_pores(POROSITY, 1.0)]
    if folder.name == "effect-finite-size":
        return [plain, FitSettings(model="finite")]
    if folder.name == "effect-sensor-mass":
        mass = truth_of(folder)["mass"]
        return [plain, FitSettings(sensor_mass=mass), FitSettings(model="finite", sensor_mass=mass)]
    return [plain]


def shared_row(folder: Path, settings: FitSettings) -> str:
    """Return one line of the table of the shared campaigns."""
    job = read_fit(folder)
    fitted = fit_bursts(job.campaign, job.recordings, settings)
    found = fit_preload([folder.name], points_of(0, job.campaign, fitted))
    known = [name for name in ("pores", "sensor_mass") if getattr(settings, name)]
    model = ", ".join([settings.model, *known])
    cells = [f"{slope.percent()} | {slope.verdict}" for slope in (found.storage, found.loss)]
    return f"| `{folder.name}` | {model} | {' | '.join(cells)} | {found.solution.scale:.2f} |"


def axes() -> None:
    """Print both tables of the anisotropy."""
    say(AXES_HEADING)
    for factors in ((1.0, 1.0, 1.0), (1.0, 1.0, STIFFER)):
        tell(f"cube: {factors}")
        found = [cube_once(rods(*factors), seed) for seed in range(DRAWS)]
        truth = np.log(factors) - np.mean(np.log(factors))
        for name in ("storage", "loss"):
            ratios = [getattr(one, name) for one in found]
            values, spread = (np.array([getattr(r, part) for r in ratios]) for part in ("shared", "shared_std"))
            rms, _ = in_deviations(values, truth, spread)
            low, high = (np.array([[i[k] for i in r.intervals.values()] for r in ratios]) for k in (1, 2))
            held = np.mean((low < np.exp(truth)) & (np.exp(truth) < high))
            mean = ", ".join(f"{v:.3f}" for v in np.exp(values.mean(axis=0)))
            none = sum(r.verdict == "none" for r in ratios)
            label = ", ".join(f"{f:g}" for f in factors)
            numbers = f"{mean} | {100 * np.median(spread):.2f} % | {rms:.2f} | {100 * held:.0f} % | {none} of {DRAWS}"
            say(f"| {label} | {'E1' if name == 'storage' else 'E2'} | {numbers} |")
    say(FREE_HEADING)
    for ratio in (1.1, 1.2, 1.5):
        tell(f"free rim: {ratio}")
        one = cube_once(transversely_isotropic(ratio), 0, FitSettings(model="finite"))
        over = [float(np.exp(r.shared[2] - r.shared[0])) for r in (one.storage, one.loss)]
        say(f"| {ratio:g} | {over[0]:.3f} | {over[1]:.3f} |")


def main() -> None:
    """Print the page."""
    say(HEADING)
    pores()
    preload()
    axes()


if __name__ == "__main__":
    main()

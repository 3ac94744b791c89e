"""Figures of Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, from signals of a virtual rig.

``python -m examples.reproducing.bonfiglio_pompoli_2015 [FOLDER]``

Material B is in the repository (``examples/foam_b``). A and C are the campaigns ``paper-a`` and ``paper-c`` of the
folder ``../shared/campaigns``; without it the figures show B alone.
"""

from functools import cache
from pathlib import Path

import numpy as np

from examples.reproducing.drawing import axes, write
from multilayer import FitSettings, fit_campaign
from multilayer.inverse.compare_methods import compare_methods
from multilayer.inverse.comparison import MethodComparison
from multilayer.inverse.result import FitResult, GrossCheck
from multilayer.inverse.settings import QuasiStatic
from multilayer.inverse.sources import FitJob, read_fit
from multilayer.media.rod import rod_transmissibility
from multilayer.signals.envelope import envelope

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared" / "campaigns"
SOURCES = {"A": SHARED / "paper-a", "B": ROOT / "examples" / "foam_b", "C": SHARED / "paper-c"}
MATERIALS = [name for name, path in SOURCES.items() if path.is_dir()]
# Table 1: quasi-static E1 + i E2, Pa
QUASI_STATIC = {"A": 806919 + 363114j, "B": 121447 + 27933j, "C": 54967 + 4947j}
QUASI_STATIC_HZ = 5.0
PAPERS_AXES = {"A": (1e5, 1e7), "B": (1e4, 1e6), "C": (1e3, 1e6)}  # Pa, of Figs. 6 to 8
# the paper's names, and ours; the finite elements are no method of the paper
METHODS = {"eq-10": "new method", "transfer-function": "dynamic", "finite": "least squares, free rim"}


@cache
def job(material: str) -> FitJob:
    """Return the campaign of a material."""
    return read_fit(SOURCES[material])


@cache
def comparison(material: str) -> MethodComparison:
    """Return what all methods find."""
    one = job(material)
    return compare_methods(one.campaign, one.recordings, one.settings, one.calibration)


@cache
def fitted(material: str) -> FitResult:
    """Return the fit with the paper's model: air above, modulus constant within a burst."""
    settings = FitSettings(termination="ambient", dispersion="none")
    return fit_campaign(job(material).campaign, job(material).recordings, settings)


def points(material: str, method: str, quantity: str) -> tuple[np.ndarray, ...]:
    """Return frequency, value and deviation of a quantity at the points that a method calls reliable."""
    (name,) = comparison(material).configurations
    found = [p for p in comparison(material).of(name, method) if p.reliable]
    rows = [(p.frequency, getattr(p, quantity), getattr(p, f"{quantity}_std")) for p in found]
    return tuple(np.array(rows).T)


def signals():
    """Draw Fig. 1b and 1c: accelerations of a burst, and the top plate's envelope."""
    figure, grid = axes(1, 2)
    recording = next(one for (_, f), one in job("B").recordings.items() if f == 500)
    base, top = recording.mean()
    time = 1e3 * recording.time
    grid[0, 0].plot(time, base, label="support plate")
    grid[0, 0].plot(time, top, label="top plate")
    grid[0, 1].plot(time, top, label="top plate")
    grid[0, 1].plot(time, envelope(top), label="envelope")
    for axis in grid[0]:
        axis.set(xlabel="time / ms", ylabel="acceleration / (m/s²)", title="B, 500 Hz", xlim=(0, 30))
        axis.legend()
    return figure


def envelopes():
    """Draw Fig. 3: measured and modelled envelope at 100 Hz."""
    figure, grid = axes(1, 1)
    burst = next(one for one in fitted("B").bursts if one.frequency == 100)
    samples = np.arange(burst.time.size)
    grid[0, 0].plot(samples, burst.measured_envelope, label="test")
    grid[0, 0].plot(samples, burst.modelled_envelope, "--", label="model")
    grid[0, 0].set(xlabel="t / samples", ylabel="envelope / (m/s²)", title="B, 100 Hz")
    grid[0, 0].legend()
    return figure


def moduli():
    """Draw Figs. 6 to 8: storage and loss moduli by every method."""
    figure, grid = axes(2, len(MATERIALS), sharex=True)
    for column, material in zip(grid.T, MATERIALS, strict=True):
        for axis, quantity in zip(column, ("storage_modulus", "loss_modulus"), strict=True):
            for (method, label), mark in zip(METHODS.items(), "so^", strict=True):
                f, value, std = points(material, method, quantity)
                bars = [np.minimum(std, 0.9 * value), std]
                axis.errorbar(f, value, bars, fmt=mark, capsize=2, markerfacecolor="none", label=label)
            static = getattr(QUASI_STATIC[material], "real" if quantity == "storage_modulus" else "imag")
            axis.plot(QUASI_STATIC_HZ, static, "kD", label="quasi-static (Table 1)")
            label = f"{quantity.replace('_', ' ')} / Pa"
            axis.set(yscale="log", xlim=(-40, 1600), ylim=PAPERS_AXES[material], ylabel=label)
        column[0].set_title(f"material {material}")
        column[1].set_xlabel("frequency / Hz")
    grid[0, 0].legend()
    return figure


def loss_factors():
    """Draw Fig. 9: the loss factors of all materials."""
    figure, grid = axes(1, 1)
    for material in MATERIALS:
        f, value, std = points(material, "eq-10", "loss_factor")
        grid[0, 0].errorbar(f, value, std, fmt="o", capsize=2, label=f"material {material}")
    grid[0, 0].set(xlabel="frequency / Hz", ylabel="loss factor", ylim=(0, 1))
    grid[0, 0].legend()
    return figure


def convergence():
    """Draw Fig. 10: moduli and cost over the iterations of Nelder-Mead, material A (else B) at 1000 Hz."""
    figure, grid = axes(1, 2)
    material, one = MATERIALS[0], job(MATERIALS[0])
    only = {key: recording for key, recording in one.recordings.items() if key[1] == 1000}
    configuration = one.campaign.configurations[0]
    kept = tuple(burst for burst in configuration.bursts if burst.frequency == 1000)
    single = one.campaign.model_copy(update={"configurations": (configuration.model_copy(update={"bursts": kept}),)})
    start = QuasiStatic(storage_modulus=QUASI_STATIC[material].real, loss_modulus=QUASI_STATIC[material].imag)
    (burst,) = fit_campaign(single, only, FitSettings(method="nelder-mead", quasi_static=start)).bursts
    storage, loss, cost = burst.history.T
    grid[0, 0].semilogy(storage, label="E1")
    grid[0, 0].semilogy(loss, label="E2")
    grid[0, 0].legend()
    grid[0, 1].semilogy(cost)
    for axis, label in zip(grid[0], ("E1, E2 / Pa", "cost, eq. (9)"), strict=True):
        axis.set(xlabel="iteration", ylabel=label, title=f"{material}, 1000 Hz")
    return figure


def rod(material: str, frequency, modulus) -> np.ndarray:
    """Return eq. (11) with a modulus of the rod."""
    campaign = job(material).campaign
    (configuration,) = campaign.configurations
    mass = campaign.top_plate.density * configuration.top_plate_thickness
    return rod_transmissibility(frequency, modulus, campaign.specimen.density, configuration.specimen_thickness, mass)


def held(poisson_ratio: float) -> float:
    """Return (lambda + 2 mu)/E: what the plane-wave model takes a held sample's stiffness for."""
    return (1 - poisson_ratio) / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))


def transmissibilities(material: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return frequency and transmissibility as measured, and of eq. (11) with the new and the quasi-static moduli."""
    bursts = fitted(material).bursts
    f = np.array([one.frequency for one in bursts])
    found = np.array([complex(one.storage_modulus, one.loss_modulus) for one in bursts])
    stiffness = held(job(material).campaign.specimen.poisson_ratio)
    return {
        "experimental": (f, np.array([one.measured_transmissibility for one in bursts])),
        "new method": (f, rod(material, f, stiffness * found)),
        "QS values": (f, rod(material, f, np.full(f.shape, QUASI_STATIC[material]))),
    }


def transmissibility():
    """Draw Figs. 11 and 12: amplitude and angle of the transmissibility."""
    shown = [name for name in MATERIALS if name != "C"]
    figure, grid = axes(2, len(shown), sharex=True)
    for column, material in zip(grid.T, shown, strict=True):
        for (label, (f, value)), style in zip(transmissibilities(material).items(), ("ko", "-", "--"), strict=True):
            column[0].semilogx(f, np.abs(value), style, label=label)
            column[1].semilogx(f, -np.unwrap(np.angle(value)), style, label=label)
        column[0].set(title=f"material {material}", ylabel="amplitude")
        column[1].set(xlabel="frequency / Hz", ylabel="angle / rad")
    grid[0, 0].legend()
    return figure


def causality():
    """Draw Fig. 13: loss moduli found, and those that eq. (12) makes of the storage moduli where these rise."""
    figure, grid = axes(1, 1)
    for i, material in enumerate(MATERIALS):
        check = gross_check(material)
        rising = np.where(check.predicted > 0, check.predicted, np.nan)
        grid[0, 0].semilogy(check.frequency, check.measured, f"C{i}o", label=f"{material}, test")
        grid[0, 0].semilogy(check.frequency, rising, f"C{i}-", label=f"{material}, eq. (12)")
    grid[0, 0].set(xlabel="frequency / Hz", ylabel="loss modulus / Pa", ylim=(1e2, 1e8))
    grid[0, 0].legend(ncols=len(MATERIALS), fontsize=7)
    return figure


def gross_check(material: str) -> GrossCheck:
    """Return eq. (12) beside the loss moduli of the fit."""
    (configuration,) = job(material).campaign.configurations
    return fitted(material).gross_check(configuration.name)


if __name__ == "__main__":
    write(
        {
            "paper_1_signals": signals,
            "paper_3_envelopes": envelopes,
            "paper_6_to_8_moduli": moduli,
            "paper_9_loss_factors": loss_factors,
            "paper_10_convergence": convergence,
            "paper_11_12_transmissibility": transmissibility,
            "paper_13_causality": causality,
        }
    )

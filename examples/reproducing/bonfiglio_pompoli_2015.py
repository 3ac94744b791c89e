"""Figures of Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, from signals of a virtual rig.

``python -m examples.reproducing.bonfiglio_pompoli_2015 [FOLDER]``

The materials, and the numbers behind the figures, are those of `bonfiglio_pompoli_numbers`; without the folder
``../shared/campaigns`` the figures show A and B alone.
"""

import numpy as np

from examples.reproducing.bonfiglio_pompoli_numbers import (
    MATERIALS,
    MODELS,
    POISSON_RATIOS,
    QUASI_STATIC,
    QUASI_STATIC_HZ,
    SUPPORTS,
    fitted,
    gross_check,
    job,
    least_squares,
    points,
    slow_ratios,
    transmissibilities,
)
from examples.reproducing.drawing import axes, write
from multilayer import FitSettings, fit_campaign
from multilayer.fits.settings import QuasiStatic
from multilayer.signals.envelope import envelope

PAPERS_AXES = {"A": (1e5, 1e7), "B": (1e4, 1e6), "C": (1e3, 1e6)}  # Pa, of Figs. 6 to 8
PAPERS_RATIO = (3.5, 4.0)  # of Fig. 4 at a Poisson's ratio of 0.45 and 100 Hz
# the paper's names, and ours; the finite elements are no method of the paper
METHODS = {"eq-10": "new method", "transfer-function": "dynamic", "finite": "least squares, free rim"}


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


def faces():
    """Draw Fig. 4 in slow compression, with the sample's faces bonded or free to slide."""
    figure, grid = axes(1, 1)
    for support, mark in zip(SUPPORTS, "os^", strict=True):
        ratios = np.array([slow_ratios(support, nu) for nu in POISSON_RATIOS])
        mean = ratios.mean(axis=1)
        reach = np.abs([ratios.min(axis=1), ratios.max(axis=1)] - mean)
        grid[0, 0].errorbar(POISSON_RATIOS, mean, reach, fmt=f"{mark}-", capsize=2, label=support)
    grid[0, 0].plot(2 * [POISSON_RATIOS[-1] + 0.01], PAPERS_RATIO, "k", linewidth=4, label="paper, 100 Hz")
    grid[0, 0].set(xlabel="Poisson's ratio", ylabel="E1 FEM / E1 found", ylim=(0, 4.2))
    grid[0, 0].set_title("slow compression of 10, 25, 50 mm")
    grid[0, 0].legend()
    return figure


def moduli():
    """Draw Figs. 6 to 8: storage and loss moduli by every method."""
    figure, grid = axes(2, len(MATERIALS), sharex=True)
    for column, material in zip(grid.T, MATERIALS, strict=True):
        for axis, quantity in zip(column, ("storage_modulus", "loss_modulus"), strict=True):
            for (method, label), mark in zip(METHODS.items(), "so^", strict=True):
                f, value, std = points(material, method, "frequency", quantity, f"{quantity}_std")
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
        f, value, std = points(material, "eq-10", "frequency", "loss_factor", "loss_factor_std")
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
    figure, grid = axes(1, len(MODELS), sharey=True)
    titles = ("plane waves", "finite elements, free rim")
    for axis, model, title in zip(grid[0], MODELS, titles, strict=True):
        for i, material in enumerate(MATERIALS):
            check = gross_check(least_squares(material, model))
            rising = np.where(check.predicted > 0, check.predicted, np.nan)
            axis.semilogy(check.frequency, check.measured, f"C{i}o", label=f"{material}, test")
            axis.semilogy(check.frequency, rising, f"C{i}-", label=f"{material}, eq. (12)")
        axis.set(xlabel="frequency / Hz", ylim=(1e2, 1e8), title=title)
    grid[0, 0].set(ylabel="loss modulus / Pa")
    grid[0, 0].legend(ncols=len(MATERIALS), fontsize=7)
    return figure


if __name__ == "__main__":
    write(
        {
            "paper_1_signals": signals,
            "paper_3_envelopes": envelopes,
            "paper_4_faces": faces,
            "paper_6_to_8_moduli": moduli,
            "paper_9_loss_factors": loss_factors,
            "paper_10_convergence": convergence,
            "paper_11_12_transmissibility": transmissibility,
            "paper_13_causality": causality,
        }
    )

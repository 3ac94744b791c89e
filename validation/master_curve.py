"""Time-temperature superposition of a measured foam and laws fitted to it: ``docs/validation/master_curve.md``.

Run it as ``python -m validation.master_curve > docs/validation/master_curve.md``; it takes about half a minute.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from multilayer_campaigns.master_curve import MasterCurve, master_curve

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import ValidityWarning
from multilayer.fits.law_fit import LawFit, fit_law
from multilayer.media.kramers_kronig import KramersKronigCheck, check_kramers_kronig
from multilayer.media.superposition import ShiftFit

VN600 = Path(__file__).parents[1] / ".." / "shared" / "measured" / "nist_vn600_dma.csv"
ZERO = 273.15
REFERENCE = ZERO + 25.0
SCATTER = 0.02  # standard deviation of a measured modulus over its amount, for the Kramers-Kronig check
ABOVE = ZERO - 0.1  # the glass transition of this foam lies near 0 degC
LAWS = (
    ("zener", None), ("fractional_zener", None), ("havriliak_negami", None),
    ("maxwell", 3), ("maxwell", 8), ("maxwell", 15), ("free_form", 20),
)  # fmt: skip

HEADING = """# One master curve of a foam, and the laws that follow it

Made by `python -m validation.master_curve`. Data: E', E'' of closed-cell vinyl-nitrile foam VN600 at 19
temperatures and 11 frequencies each, 0.048 to 4.8 Hz (Landauer et al., Sci. Data 10:356, 2023). Reference: 25 degC.
Errors are means of |E_law - E|/|E| (amount and phase) and of ||E_law| - |E||/|E| (amount alone).

## Superposition
"""
LAW_HEADING = """
## Laws

The published fractional-Zener fit of the 25 degC curve alone misses |E| by 8.2 % in the mean (a number quoted to us; we
have not seen the fit). "Unknowns on a bound" are those that the data leave open: two decades within a broad transition
do not show where its plateaus and its relaxation time lie.

| data | law | unknowns | mean error of E | of its amount | unknowns on a bound |
|---|---|---|---|---|---|"""
SHIFT_HEADING = """
## Shifts

Without vertical shifts. WLF is for equilibrium, that is above the glass transition (the loss peak of 1 Hz lies near
0 degC); below it these data shift less than it says.

| formula | fitted to | parameters | misses by, rms |
|---|---|---|---|"""
LEVEL_HEADING = """
The last columns say whether the moduli of one temperature can be one causal passive material's, if they scatter by
{scatter:.0f} % (`check_kramers_kronig`, shifts play no part). {contradiction}.
{gap}

| degC | log10 a_T | std | WLF misses by | WLF, above 0 degC | Arrhenius | error of E | Kramers-Kronig | chi2/n |
|---|---|---|---|---|---|---|---|---|"""


def read_vn600() -> tuple[RealArray, RealArray, ComplexArray]:
    """Return temperature (K), frequency (Hz) and modulus (Pa) of each row."""
    celsius, omega, storage, loss = np.loadtxt(VN600, delimiter=",", skiprows=1).T
    return celsius + ZERO, omega / (2 * np.pi), (storage + 1j * loss) * 1e6


def vertical_table(curves: dict[str, MasterCurve]) -> list[str]:
    """Return how well the curves overlap with each kind of vertical shift."""
    lines = ["| vertical shift b_T | mean error of E | worst temperature | b_T from | to |", "|---|---|---|---|---|"]
    for name, curve in curves.items():
        worst = int(np.argmax(curve.error_by_temperature))
        where = f"{curve.temperature[worst] - ZERO:.0f} degC, {100 * curve.error_by_temperature[worst]:.1f} %"
        b = curve.vertical
        mean = 100 * np.mean(curve.relative_error)
        lines.append(f"| {name} | {mean:.2f} % | {where} | {b.min():.3f} | {b.max():.3f} |")
    return lines


def law_row(data: str, name: str, elements: int | None, fit: LawFit) -> str:
    """Return one line of the table of laws."""
    label = f"`{name}`" + (f", {elements} elements" if elements else "")
    errors = f"{100 * fit.mean_relative_error:.2f} % | {100 * fit.mean_magnitude_error:.2f} %"
    on_bound = ", ".join(fit.on_bound) if len(fit.on_bound) <= 3 else f"{len(fit.on_bound)}"
    return f"| {data} | {label} | {len(fit.parameters)} | {errors} | {on_bound or 'none'} |"


def law_table(curve: MasterCurve) -> list[str]:
    """Return the laws, fitted to the curve of 25 degC alone and to all."""
    alone = curve.index == int(np.searchsorted(curve.temperature, REFERENCE - 0.1))
    lines = []
    for data, chosen in (("25 degC", alone), ("all", np.ones_like(alone))):
        for name, elements in LAWS:
            if 2 * np.count_nonzero(chosen) < 2 * (elements or 0) + 2:
                continue
            fit = fit_law(name, curve.frequency[chosen], curve.modulus[chosen], elements=elements, starts=4)
            lines.append(law_row(data, name, elements, fit))
    return lines


def formula_row(fit: ShiftFit, fitted_to: str) -> str:
    """Return one line of the table of formulae."""
    told = ", ".join(f"{name} = {value:.4g} (std {fit.std[name]:.2g})" for name, value in fit.parameters.items())
    return f"| {fit.name} | {fitted_to} | {told} | {fit.rms:.2f} decades |"


def gaps(curve: MasterCurve) -> str:
    """Return between which temperatures the shift is a guess."""
    celsius = [f"{t - ZERO:.0f}" for t in curve.temperature]
    found = [
        f"{celsius[k]} and {celsius[k + 1]} degC ({curve.gaps[k]:.1f} decades)" for k in np.flatnonzero(curve.gaps > 0)
    ]
    return f"Data that do not overlap, so that the shift is a guess: {', '.join(found) or 'none'}."


def contradictions(curve: MasterCurve, checks: list[KramersKronigCheck]) -> str:
    """Return at which temperatures E1 and E2 contradict each other."""
    found = [curve.temperature[i] - ZERO for i, check in enumerate(checks) if check.verdict == "inconsistent"]
    where = ", ".join(f"{celsius:.0f} degC" for celsius in found)
    return f"E' and E'' contradict each other at {where or 'no temperature'}"


def shift_table(curve: MasterCurve, checks: list[KramersKronigCheck]) -> list[str]:
    """Return shifts, what formulae miss of them, and the Kramers-Kronig check, by temperature."""
    wlf, arrhenius, above = curve.wlf(), curve.arrhenius(), curve.wlf(ABOVE)
    lines = [SHIFT_HEADING]
    lines += [formula_row(fit, "all") for fit in (wlf, arrhenius)]
    lines += [formula_row(fit, "0 degC and above") for fit in (above, curve.arrhenius(ABOVE))]
    lines.append(
        LEVEL_HEADING.format(scatter=100 * SCATTER, contradiction=contradictions(curve, checks), gap=gaps(curve))
    )
    first = curve.temperature.size - above.residual.size
    for i, check in enumerate(checks):
        cells = [f"{curve.temperature[i] - ZERO:.0f}", f"{curve.log_shift[i]:.2f}", f"{curve.log_shift_std[i]:.2f}"]
        cells += [f"{wlf.residual[i]:+.2f}", f"{above.residual[i - first]:+.2f}" if i >= first else ""]
        cells += [f"{arrhenius.residual[i]:+.2f}", f"{100 * curve.error_by_temperature[i]:.1f} %"]
        lines.append(f"| {' | '.join([*cells, check.verdict, f'{check.reduced_chi_square:.2f}'])} |")
    return lines


def main() -> None:
    """Shift, fit and print the page."""
    warnings.simplefilter("ignore", ValidityWarning)  # the gap is told in the page
    t, f, e = read_vn600()
    curves = {
        name: master_curve(t, f, e, reference=REFERENCE, vertical=vertical)
        for name, vertical in (("none", "none"), ("T/T0", "entropic"), ("sought, std 5 %", "free"))
    }
    checks = []
    for level in curves["none"].temperature:
        chosen = t == level
        std = SCATTER * np.abs(e[chosen])
        checks.append(check_kramers_kronig(f[chosen], e[chosen], std, std))
    plain = curves["none"]
    lines = [HEADING, *vertical_table(curves), LAW_HEADING, *law_table(plain), *shift_table(plain, checks)]
    print("\n".join(lines))  # noqa: T201


if __name__ == "__main__":
    main()

"""Numbers behind the figures of Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, from signals of a virtual rig.

``python -m examples.reproducing.bonfiglio_pompoli_numbers`` prints what README.md beside says, in about a minute.

The measured signals were not published. Material A is ``material_a.yaml`` on this project's rig, measured anew whenever
it is wanted; B is ``examples/foam_b``; C is the campaign ``paper-c`` of the folder ``../shared/campaigns``, left out
where that is absent.
"""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from multilayer import FitSettings, fit_campaign, load_stack
from multilayer.fits.classical.compare import compare_methods
from multilayer.fits.classical.comparison import MethodComparison
from multilayer.fits.result import FitResult, GrossCheck
from multilayer.fits.settings import QuasiStatic
from multilayer.fits.sources import FitJob, read_fit
from multilayer.media.kramers_kronig import gross_loss_modulus
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.file import load_rig
from multilayer.rig.shape_factor import static_shape_factor
from multilayer.rig.synthesis import make_campaign

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared" / "campaigns"
RIG_FILE = Path(__file__).parent / "material_a.yaml"
SOURCES = {"A": RIG_FILE, "B": ROOT / "examples" / "foam_b", "C": SHARED / "paper-c", "paper-a": SHARED / "paper-a"}
MATERIALS = [name for name in "ABC" if SOURCES[name].exists()]
# Table 1: quasi-static E1 + i E2, Pa
QUASI_STATIC = {"A": 806919 + 363114j, "B": 121447 + 27933j, "C": 54967 + 4947j}
QUASI_STATIC_HZ = 5.0
PAPERS_ERROR = {"A": 0.09, "B": 0.17, "C": 0.35}  # mean relative error of eq. (12), by the text on Fig. 13
DRAWS = range(1, 11)  # of noise and laboratory errors of material A
RADIUS, THICKNESSES = 0.0225, (0.010, 0.025, 0.050)  # m, Table 2
POISSON_RATIOS = (0.0, 0.1, 0.2, 0.3, 0.35, 0.4, 0.45)
MODELS = ("plane_wave", "finite")  # of the rig
SUPPORTS = ("both faces bonded", "sliding on the base", "both faces sliding")


@cache
def job(material: str) -> FitJob:
    """Return the campaign of a material."""
    return stand_in(load_rig(RIG_FILE).seed) if material == "A" else read_fit(SOURCES[material])


@cache
def stand_in(draw: int, poisson_ratio: float = 0.3) -> FitJob:
    """Return a campaign of material A: its noise and laboratory errors drawn anew, its Poisson's ratio as given."""
    rig = load_rig(RIG_FILE)
    specimen = rig.specimen.model_copy(update={"poisson_ratio": poisson_ratio})
    made = make_campaign(rig.model_copy(update={"specimen": specimen}), seed=draw)
    static = QuasiStatic(storage_modulus=QUASI_STATIC["A"].real, loss_modulus=QUASI_STATIC["A"].imag)
    return FitJob(made.campaign, made.recordings, FitSettings(quasi_static=static), None)


@cache
def comparison(material: str) -> MethodComparison:
    """Return what all methods find."""
    campaign = job(material)
    return compare_methods(campaign.campaign, campaign.recordings, campaign.settings, campaign.calibration)


@cache
def fitted(material: str) -> FitResult:
    """Return the fit with the paper's model: air above, modulus constant within a burst."""
    settings = FitSettings(termination="ambient", dispersion="none")
    return fit_campaign(job(material).campaign, job(material).recordings, settings)


def points(material: str, method: str, *quantities: str) -> list[np.ndarray]:
    """Return quantities at the points that a method calls reliable, by rising frequency."""
    (name,) = comparison(material).configurations
    reliable = [p for p in comparison(material).of(name, method) if p.reliable]
    return [np.array([getattr(p, quantity) for p in reliable]) for quantity in quantities]


def median_difference(material: str, method: str, reference: str) -> float:
    """Return the median over the frequencies that both methods have of E1 over the reference's, less one."""
    agreed = dict(zip(*points(material, reference, "frequency", "storage_modulus"), strict=True))
    pairs = zip(*points(material, method, "frequency", "storage_modulus"), strict=True)
    return float(np.median([e1 / agreed[f] - 1 for f, e1 in pairs if f in agreed]))


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
    f = np.array([burst.frequency for burst in bursts])
    modulus = np.array([complex(burst.storage_modulus, burst.loss_modulus) for burst in bursts])
    stiffness = held(job(material).campaign.specimen.poisson_ratio)
    measured = np.array([burst.measured_transmissibility for burst in bursts])
    return {
        "experimental": (f, measured),
        "new method": (f, rod(material, f, stiffness * modulus)),
        "QS values": (f, rod(material, f, QUASI_STATIC[material])),
    }


def median_errors(material: str) -> tuple[float, float]:
    """Return how far the two transmissibilities of eq. (11) lie from the measured one, medians over the bursts."""
    (_, measured), (_, new), (_, static) = transmissibilities(material).values()
    return float(np.median(np.abs(new / measured - 1))), float(np.median(np.abs(static / measured - 1)))


def slow_ratio(support: str, poisson_ratio: float, thickness: float) -> float:
    """Return E1 of the finite elements over E1 found by plane waves, Fig. 4, in slow compression.

    Plane waves take the stiffness of the sample for that of a held one. A disc that slides on its base is the upper
    half of a bonded one of twice its thickness, whose middle plane is smooth; one that slides on both faces is a free
    rod.
    """
    if support == "both faces sliding":
        return held(poisson_ratio)
    length = thickness if support == "both faces bonded" else 2 * thickness
    return held(poisson_ratio) / static_shape_factor(poisson_ratio, RADIUS / (2 * length))


@cache
def slow_ratios(support: str, poisson_ratio: float) -> np.ndarray:
    """Return that ratio at each of the thicknesses of Table 2."""
    return np.array([slow_ratio(support, poisson_ratio, thickness) for thickness in THICKNESSES])


@cache
def least_squares(material: str, model: str, draw: int | None = None, poisson_ratio: float = 0.3) -> FitResult:
    """Return the fit by a model of the rig, ``plane_wave`` or ``finite``; with a draw of a stand-in of material A."""
    campaign = job(material) if draw is None else stand_in(draw, poisson_ratio)
    settings = campaign.settings.model_copy(update={"model": model})
    return fit_campaign(campaign.campaign, campaign.recordings, settings)


def gross_check(fit: FitResult) -> GrossCheck:
    """Return eq. (12) beside the loss moduli of a fit."""
    (configuration,) = fit.configurations
    return fit.gross_check(configuration)


def loss_factors(fit: FitResult) -> str:
    """Return the loss factors found at the lowest and the highest frequency."""
    first, *_, last = (burst.loss_factor for burst in fit.bursts if burst.accepted)
    return f"{first:.2f} to {last:.2f}"


def error_itself(material: str) -> float:
    """Return the mean relative error of eq. (12) on the law behind the signals, at their frequencies."""
    laws = {
        "A": load_rig(RIG_FILE).specimen.young_modulus,
        "B": load_stack(ROOT / "examples" / "three_layers.yaml").layers[1].young_modulus,
    }
    f = np.array([burst.frequency for burst in job(material).campaign.configurations[0].bursts])
    modulus = laws[material](f)
    return float(np.mean(np.abs(gross_loss_modulus(f, modulus.real) / modulus.imag - 1)))


def fig_4() -> list[str]:
    """Return the table on Fig. 4: mean and range of the ratio over the thicknesses of Table 2."""
    rows = []
    for nu in POISSON_RATIOS:
        ratios = [slow_ratios(support, nu) for support in SUPPORTS]
        rows.append([f"{nu:g}", *(f"{r.mean():.2f} ({r.min():.2f} to {r.max():.2f})" for r in ratios)])
    return table(["Poisson's ratio", *SUPPORTS], rows)


def fig_13(draws: Sequence[int] = DRAWS) -> list[str]:
    """Return the table on Fig. 13: mean relative errors of eq. (12), of A the median and range over draws."""
    rows = []
    for nu in (0.3, 0.1):
        fits = [[least_squares("A", model, draw, nu) for draw in draws] for model in MODELS]
        errors = [[gross_check(fit).mean_relative_error for fit in column] for column in fits]
        shown = [f"{percent(np.median(e))} ({100 * min(e):.0f} to {100 * max(e):.0f})" for e in errors]
        itself, losses = percent(error_itself("A")), loss_factors(fits[1][0])
        rows.append([f"A, Poisson's ratio {nu:g}", percent(PAPERS_ERROR["A"]), *shown, itself, losses])
    for material, name in {"paper-a": "A, `paper-a`", "B": "B", "C": "C"}.items():
        if not SOURCES[material].exists():
            continue
        plane, free = (least_squares(material, model) for model in MODELS)
        shown = [percent(gross_check(fit).mean_relative_error) for fit in (plane, free)]
        itself = percent(error_itself(material)) if material == "B" else "-"
        rows.append([name, percent(PAPERS_ERROR[name[0]]), *shown, itself, loss_factors(free)])
    return table(["material", "paper", "plane waves", "free rim", "eq. (12) itself", "loss factor"], rows)


def percent(share: float) -> str:
    """Return a share in words of the tables."""
    return f"{100 * share:.0f} %"


def table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table."""
    return [f"| {' | '.join(row)} |" for row in (heading, ["---"] * len(heading), *rows)]


def sentences(materials: Sequence[str] = MATERIALS) -> list[str]:
    """Return what README.md says of Figs. 6 to 8, 11 and 12, material by material."""
    said = []
    for material in materials:
        new, free = (median_difference(material, name, "transfer-function") for name in ("eq-10", "finite"))
        exact, static = median_errors(material)
        said += [
            f"{material}: E1 over that of the dynamic method, medians: new method {100 * new:+.0f} %, "
            f"free rim {100 * free:+.0f} %",
            f"{material}: transmissibility of eq. (11) off, medians: new method {100 * exact:.1f} %, "
            f"quasi-static values {100 * static:.0f} %",
        ]
    return said


if __name__ == "__main__":
    print(*fig_4(), "", *fig_13(), "", *sentences(), sep="\n")  # noqa: T201

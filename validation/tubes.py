"""What a fit of one thickness says of another, on impedance tubes measured elsewhere: ``docs/validation/tubes.md``.

Run it as ``python -m validation.tubes > docs/validation/tubes.md``; it takes about two minutes.
"""

from __future__ import annotations

from multilayer.fits.stacks.result import FoundQuantity
from validation.tube_fits import (
    ELASTIC,
    FRAMES,
    LOWEST,
    MODEL_ERROR,
    NOISE,
    PORES,
    SAMPLES,
    Prediction,
    atalla_panneton,
    fit,
    mineral_wool,
    of_published,
    predict,
    rms,
)

ALLOWED = 1.5  # misfit of a prediction over that of a fit
CLEAR = 5.0  # difference of ln evidence
WORDS = {"equivalent_fluid": "rigid", "limp": "limp", "poroelastic": "elastic"}

HEADING = f"""# Impedance tubes: does one thickness foretell the other?

Made by `python -m validation.tubes`. Data that nobody in this project wrote: Zs/Z0 before a rigid wall.

## Atalla & Panneton 2005

Four materials, two thicknesses each, digitised from print, {LOWEST:g} to 1600 Hz. Johnson-Champoux-Allard with a
**rigid frame**: above the frequency where viscosity ceases to drag the frame, sigma phi^2/(2 pi rho1) = 33 to 49 Hz
here, inertia holds it; the third table says what limp and elastic frames change. Priors: resistivity and porosity as
the laboratory measured them (10 %, 0.01), tortuosity anywhere from 1 to 2 (fibres: to 1.1), lengths unknown to a factor
of 2. Noise {NOISE["absolute"]:g} of Zs/Z0; error of tube, mounting and model {MODEL_ERROR["relative"]:.0%}, with a
correlation length of {MODEL_ERROR["length"]:g} in ln f. Nothing is taken from the thick sample.

Misfits are the rms of the difference in Zs/Z0. "Fit" of the thick sample has the same weights and priors; "least" is
that with white errors alone, about the least misfit this model can have.
"""
PREDICTIONS = """
| sample | thin, fit | thick, published | foretold | fit | ratio | least | ratio | white errors: foretold | ratio |
|---|---|---|---|---|---|---|---|---|---|"""
PARAMETERS = """
| sample | parameter | published | thin: found | 90 % | left of the prior | published value |
|---|---|---|---|---|---|---|"""
FRAME_HEADING = """
Which frame? ln evidence of each sample by itself. Poisson's ratio 0.3 (foams) or 0 (fibres), modulus 10 kPa to 5 MPa.

| sample | limp - rigid | elastic - rigid | rms: rigid | limp | elastic | E / kPa | loss factor |
|---|---|---|---|---|---|---|---|"""
WOOL_HEADING = """
## TU Delft mineral wool

Dry, 2.5 and 5 cm, from a two-microphone tube in steps of 2 Hz. Nothing is known of it: resistivity 5e3 to 2e5, porosity
0.9 to 0.995, density 20 to 200, the rest as above; noise 0.02. Misfits are rms of Zs/Z0 and of the reflection
coefficient. The last column is ln evidence of one material in both thicknesses over that of two: below 0 they disagree.

| from Hz | frame | cm | own fit: Z, R | joint fit: Z, R | from the other: Z, R | of R, over own fit | one material |
|---|---|---|---|---|---|---|---|"""


def prediction_rows(good: list[Prediction], white: list[Prediction]) -> list[str]:
    """Return the misfits with correlated errors and with white ones."""
    lines = []
    for one, bare in zip(good, white, strict=True):
        values = (one.own, of_published(one.sample), one.predicted, one.direct)
        cells = [f"{value:.3f}" for value in values] + [f"{one.ratio:.2f}", f"{bare.direct:.3f}"]
        cells += [f"{one.predicted / bare.direct:.2f}", f"{bare.predicted:.3f}", f"{bare.ratio:.2f}"]
        lines.append(f"| {one.sample.name} | {' | '.join(cells)} |")
    return lines


def found_and_published(one: Prediction) -> list[tuple[str, FoundQuantity, float]]:
    """Return what the thin sample says of each parameter, and what was published."""
    nominal = one.thin.problem.stacks["nominal"].layers[0]
    return [(name, one.thin.result.quantity(f"layers.sample.{name}"), getattr(nominal, name)) for name in PORES]


def verdict(found: FoundQuantity, value: float) -> str:
    """Return whether a published value is found again."""
    low, high = found.intervals[-1]
    if not found.determined:
        return "undetermined"
    return "inside" if low <= value <= high else "outside"


def parameter_rows(good: list[Prediction]) -> list[str]:
    """Return published beside found values."""
    lines = []
    for one in good:
        for name, found, value in found_and_published(one):
            low, high = found.intervals[-1]
            cells = f"{name} | {value:.4g} | {found.value:.4g} | {low:.4g} to {high:.4g} | {found.left:.0%}"
            lines.append(f"| {one.sample.name} | {cells} | {verdict(found, value)} |")
    return lines


def frame_rows() -> list[str]:
    """Return the evidence of a rigid, a limp and an elastic frame in each sample, and where it is clear."""
    lines, clear = [], []
    for sample in SAMPLES:
        for which in (sample.thin, sample.thick):
            rigid, limp, elastic = (fit(atalla_panneton(sample, which, frame)) for frame in FRAMES)
            evidence = [one.best.log_evidence - rigid.best.log_evidence for one in (limp, elastic)]
            misfits = [rms(one.problem, one.best.z)[0] for one in (rigid, limp, elastic)]
            modulus, loss = (elastic.result.quantity(f"layers.sample.{name}") for name in ELASTIC)
            cells = [f"{x:+.1f}" for x in evidence] + [f"{x:.3f}" for x in misfits]
            cells += [_found(modulus, 1e3), _found(loss, 1.0)]
            name = f"{sample.name}, {which[1]:g} mm"
            lines.append(f"| {name} | {' | '.join(cells)} |")
            clear += [name] if evidence[1] > CLEAR else []
    said = "; ".join(clear) or "none"
    return [
        *lines,
        "",
        f"A resonance of the frame, clear (above {CLEAR:g}) in: {said}. A rigid frame cannot foretell it.",
    ]


def _found(quantity: FoundQuantity, unit: float) -> str:
    return f"{quantity.value / unit:.3g} ± {quantity.std / unit:.2g}" if quantity.determined else "undetermined"


def wool_rows(frame: str, lowest: float) -> list[str]:
    """Return the misfits of the mineral wool with one frame: joint fit, and each thickness from the other."""
    both = ("2.5", "5")
    joint = fit(mineral_wool(frame, both, lowest))
    single = {cm: fit(mineral_wool(frame, (cm,), lowest)) for cm in both}
    evidence = joint.best.log_evidence - sum(one.best.log_evidence for one in single.values())
    lines = []
    for i, (cm, other) in enumerate((both, both[::-1])):
        problem = single[cm].problem
        own, foretold = (rms(problem, single[name].best.z) for name in (cm, other))
        values = (own, rms(joint.problem, joint.best.z, i), foretold)
        cells = [f"{z:.3f}, {r:.3f}" for z, r in values] + [f"{foretold[1] / own[1]:.1f}", f"{evidence:+.1f}"]
        lines.append(f"| {lowest:g} | {WORDS[frame]} | {cm} | {' | '.join(cells)} |")
    return lines


def conclusions(good: list[Prediction], white: list[Prediction]) -> list[str]:
    """Return what is met, counted."""
    least = [one.predicted / bare.direct for one, bare in zip(good, white, strict=True)]
    words = [verdict(found, value) for one in good for _, found, value in found_and_published(one)]
    counted = ", ".join(f"{words.count(word)} {word}" for word in ("inside", "outside", "undetermined"))
    weighed, bare = _met([one.ratio for one in good]), _met([one.ratio for one in white])
    return [
        "",
        f"- Foretold with at most {ALLOWED:g} times the misfit of a fit of the same weights: {weighed}.",
        f"- With at most {ALLOWED:g} times the least misfit: {_met(least)}.",
        f"- With all errors taken for white: {bare}; parameters then look far surer than they are.",
        f"- Published parameters and our 90 % intervals (the publication gives no scatter): {counted}.",
    ]


def _met(ratios: list[float]) -> str:
    named = [sample.name for sample, ratio in zip(SAMPLES, ratios, strict=True) if ratio <= ALLOWED]
    return f"{len(named)} of {len(ratios)}" + (f" ({', '.join(named)})" if named else "")


def main() -> None:
    """Print the page."""
    good, white = ([predict(sample, correlated=correlated) for sample in SAMPLES] for correlated in (True, False))
    parts = [HEADING.rstrip(), PREDICTIONS, *prediction_rows(good, white), *conclusions(good, white)]
    parts += [PARAMETERS, *parameter_rows(good), FRAME_HEADING, *frame_rows(), WOOL_HEADING]
    parts += [line for lowest in (200.0, LOWEST) for frame in FRAMES for line in wool_rows(frame, lowest)]
    print("\n".join(parts))  # noqa: T201


if __name__ == "__main__":
    main()

"""Made-up diagnoses, as the engine returns them: a mass on a lossy spring, with and without an added mass."""

from itertools import pairwise

import numpy as np

from multilayer.diagnosis.effects import EFFECTS as KINDS
from multilayer.diagnosis.effects import Effect
from multilayer.diagnosis.result import Curves, Diagnosis, Similarity

EFFECTS = tuple(name for name, kind in KINDS.working() if issubclass(kind, Effect))
SIZES = {
    "adhesive": ("compliance", 2.1e-11, "m/Pa"),
    "amplitude_softening": ("softening", 3.4, ""),
    "crosstalk": ("share", 0.0042, ""),
    "delamination": ("first", 0.008, ""),
    "dispersion": ("strength", 0.031, ""),
    "plate_flexure": ("share", 0.09, ""),
    "rocking": ("share", 0.0061, ""),
    "temperature_drift": ("total", 0.0072, ""),
    "channel_delay": ("delay", 4.2e-6, "s"),
    "channel_gain": ("gain", 0.011, ""),
    "flanking": ("stiffness", 84.0, "N/m"),
    "high_pass": ("cut_off", 1.3, "Hz"),
    "preload": ("stiffening", 8.4e-5, "1/Pa"),
    "saturating_air": ("flow_resistivity", 5.3e3, "N*s/m^4"),
    "sensor_mass": ("mass", 1.1e-4, "kg"),
    "sensor_mount": ("frequency", 4.1e12, "Hz"),
    "skin": ("thickness", 3.3e-4, "m"),
}
BURSTS = np.geomspace(120, 900, 8)


def names_of(n):
    return [f"h{h:g}mm-t{t}mm" for t in (3, 10) for h in (12.5, 25, 37.5, 50, 75, 100)][:n]


def curves(configuration, size, rng, explained=True):
    """Return residuals of a level that is off by up to `size` dB and a phase to match, and noise."""
    frequency = np.concatenate([f * (1 + np.linspace(-0.05, 0.05, 6)) for f in BURSTS])
    burst = np.repeat(np.arange(len(BURSTS)), 6)
    turn = 1.3 * np.log(frequency / 330)
    sigma = np.full(len(frequency), 0.026)
    noise = sigma * rng.standard_normal((4, len(frequency)))
    before = size * np.tanh(turn) / np.cosh(turn) + noise[0], 7 * size / np.cosh(1.4 * turn) + 6.6 * noise[1]
    after = (noise[2], 6.6 * noise[3]) if explained else before
    return Curves(configuration, frequency, burst, *before, *after, sigma, 6.6 * sigma)


def similarity(names, rng, alike=(), absorbed=()):
    vectors = rng.standard_normal((len(names), 4))
    for a, b in alike:
        vectors[names.index(a)] = vectors[names.index(b)] + 0.05 * rng.standard_normal(4)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    kept = np.array([0.04 if name in absorbed else rng.uniform(0.2, 0.9) for name in names])
    return Similarity(tuple(names), vectors @ vectors.T, kept)


def places(configurations, strength):
    edges = np.geomspace(118, 930, 5).round(1)
    found = []
    for i, name in enumerate(configurations):
        for j, quantity in enumerate(("level", "phase")):
            for k, band in enumerate(pairwise(edges)):
                size = round(strength * (0.35 + abs(np.sin(1.7 * i + 0.9 * j + 1.1 * k))), 2)
                note = f"measured {quantity} {'above' if k % 2 else 'below'} the model"
                found.append(
                    {
                        "quantity": quantity,
                        "configuration": name,
                        "band_hz": [float(f) for f in band],
                        "significance": size,
                        "note": note,
                    }
                )
    return sorted(found, key=lambda place: -place["significance"])[:12]


def cause(effects, behind, probability, parameters=None, **more):
    """Return a cause; the unknown one has no gap left to tell."""
    entry = {"effects": list(effects), "probability": probability, "log_evidence": 812.3, "score": 812.3 - behind}
    entry |= {"parameters": parameters or {}, "gap_before": 31.2}
    return entry if effects == ("unknown",) else {**entry, "gap_after": 1.1, "absorbed": False, **more}


def parameter(value, low, high, unit=""):
    return {"value": value, "low": low, "high": high, "unit": unit}


CAUSES = [
    cause(
        ("sensor_mass",), 0, 0.612, {"sensor_mass.mass": parameter(1.1e-3, 1.0e-3, 1.2e-3, "kg")}, shrinkage=0.9963
    ),
    cause(
        ("preload",), 1.7, 0.343, {"preload.stiffening": parameter(6.3e-4, 4.4e-4, 8.3e-4, "1/Pa")}, shrinkage=0.981
    ),
    cause(
        ("adhesive", "channel_gain"), 14.2, 0.03,
        {
            "adhesive.compliance": parameter(3.2e-10, 1e-11, 4e-9, "m/Pa"),
            "adhesive.loss_factor": parameter(0.2, 0.1, 0.4),
            "channel_gain.gain": parameter(-0.021, -0.028, -0.013),
        }, shrinkage=0.87, gap_after=4.93,
    ),
    cause(("unknown",), 22.5, 0.012),
    cause(
        ("saturating_air",), 84.2, 0.0,
        {"saturating_air.flow_resistivity": parameter(1.2e4, 1.1e4, 1.31e4, "N*s/m^4")}, shrinkage=0.41, gap_after=18.8,
    ),
    cause(("temperature_drift",), 333.0, 0.0, {"temperature_drift.total": parameter(0.02, 0.01, 0.03)}, shrinkage=-0.1),
    cause((), 790.8, 0.0, gap_after=31.2, shrinkage=0.0),
]  # fmt: skip
EXPERIMENTS = [
    ("channels swapped", 3.4, 0.5), ("top_plate_thickness x 3", 6.2, 1.0),
    ("sensor in the centre, or two opposite ones", 2.2, 0.5), ("specimen_thickness x 0.5", 4.1, 2.0),
    ("remounted, measured in reversed order", 0.4, 1.5), ("in vacuum", 0.02, 8.0),
]  # fmt: skip


def record(verdict, configurations, sentence):
    there = verdict != "no_gap"
    group = [["sensor_mass"], ["preload"]] if verdict == "effect" else []
    shift = 1.09 if verdict == "effect" else 1.0
    return {
        "version": 1,
        "verdict": verdict,
        "sentence": sentence,
        "where": places(configurations, 5.6) if there else [],
        "causes": (CAUSES if verdict == "effect" else CAUSES[3:]) if there else [],
        "group": group,
        "gap": {
            "before": 31.2 if there else 1.04,
            "after": {"effect": 1.1, "unknown": 18.8, "no_gap": 1.04}[verdict],
            "shrinkage": {"effect": 0.9963, "unknown": 0.41, "no_gap": 0.0}[verdict],
            "held_out": "leave one configuration out" if there else "nothing: there is no gap",
        },
        "unknowns": {
            "E(930 Hz)": {"nominal": [1.2e5, 2.1e4], "corrected": [shift * 1.2e5, shift * 2.1e4], "unit": "Pa"}
        },
        "detectable": {n: dict(zip(("parameter", "smallest", "unit"), s, strict=True)) for n, s in SIZES.items()},
        "next_experiment": [
            {"change": change, "separates": [["preload"], ["sensor_mass"]], "expected_gain": gain, "cost_hours": cost}
            for change, gain, cost in (EXPERIMENTS if there else [])
        ],
        "hypotheses_tried": 29,
        "inputs": {
            "campaign": "foam_b",
            "multilayer": "0.1.0",
            "law": "fractional_zener",
            "p_value": 3.2e-41 if there else 0.37,
            "chi_square": 2995.2,
            "n_data": 96 * len(configurations),
            "sha256": {"campaign.yaml": "9f2c4a7b1d" * 6 + "9f2c"},
        },
    }


def diagnosis(verdict="effect", n=6, campaign="foam_b", sentence=None, configurations=None, effects=EFFECTS):
    rng = np.random.default_rng(7)
    named = configurations or names_of(n)
    sentences = {
        "effect": "The gap is caused by sensor mass (probability 61 %); the data cannot tell it from preload.",
        "unknown": "There is a gap, and none of the known effects explains it: a smooth discrepancy explains the gap "
        "better than any known effect.",
        "no_gap": "No gap: a misfit as large has the probability 0.37 without any effect.",
    }
    size = 0.0 if verdict == "no_gap" else 0.9
    shift = 1.09 if verdict == "effect" else 1.0
    f = np.geomspace(118, 930, 60)
    e = 1.1e5 * (1j * f / 300) ** 0.12
    moduli = {"frequency_hz": f.tolist()}
    for name, factor in (("nominal", 1.0), ("corrected", shift)):
        ends = {"": 1.0, "_low": 0.98, "_high": 1.02}
        parts = {"E1": factor * e.real, "E2": factor * e.imag}
        moduli[name] = {f"{p}{end}": (at * v).tolist() for p, v in parts.items() for end, at in ends.items()}
    alike = [("preload", "sensor_mass"), ("channel_gain", "crosstalk")] if effects is EFFECTS else []
    return Diagnosis(
        campaign,
        record(verdict, named, sentence or sentences[verdict]),
        tuple(curves(name, size / (1 + 0.3 * i), rng, verdict == "effect") for i, name in enumerate(named)),
        similarity(list(effects), rng, alike, ("finite_size", "channel_gain")),
        moduli,
    )

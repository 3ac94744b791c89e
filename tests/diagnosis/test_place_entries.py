"""What simple laws at places are told as: words, values and units."""

import numpy as np
import pytest

from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.place_entries import form_entry
from multilayer.diagnosis.place_fits import SimpleForm
from multilayer.diagnosis.places import LEVEL_PLACES, PLACES, TUBE_PLACES
from multilayer.diagnosis.places.sample import SampleStrain
from multilayer.experiments.places import SimpleLaw, Term
from multilayer.testing.benches import joint_bench, level_bench, soft_sample, tube_bench
from tests.diagnosis.rigs import F

OMEGA = 2 * np.pi * np.sqrt(F[0] * F[-1])  # at which amplitudes are stated


def told(place, term, amplitude, *others, bench=None):
    """Return the entry of a simple law at a place, as if it had been fitted."""
    hypothesis = joint_bench() if bench is None else bench
    law = SimpleLaw.at(place, (term,), F, 1.0)
    own = [p.prior.coordinate(v) for p, v in zip(law.parameters, (amplitude, *others), strict=True)]
    z = soft_sample(hypothesis) if bench is None else np.zeros(len(hypothesis.nominal_parameters))
    acting = hypothesis.with_effects(law)
    return form_entry(SimpleForm(place, Fitted(acting, acting.as_minimum(np.append(z, own))), 0.0), F)


@pytest.mark.parametrize(
    ("place", "term", "amplitude", "words", "value", "unit"),
    [
        ("sample", Term("power"), 0.3, "change of ln E", 0.3, ""),
        ("sample_load", Term("power"), 5e-4, "change of ln E per static stress", 5e-4, "1/Pa"),
        ("sample_radius", Term("power"), 200.0, "change of ln E per squared radius", 200.0, "1/m2"),
        ("sample_radius", Term("power", 1), 200.0 * OMEGA, "change of ln E per squared radius in proportion to i w",
         200.0, "s/m2"),
        ("plate", Term("power"), 0.02, "relative change of its mass", 0.02, ""),
        # 3 g between base and top plate
        ("beside", Term("power", 2), 3e-3 * OMEGA**2, "inertia", 3e-3, "kg"),
        ("beside", Term("power", -1), 2e3 / OMEGA, "dynamic stiffness as 1/(i w)", 2e3, "N/(m s)"),
        ("faces", Term("power", -1), 2e-7 / OMEGA, "mobility", 2e-7, "m/(Pa s)"),
        ("faces", Term("power", 2), 1e-15 * OMEGA**2, "compliance per area of each face as (i w)^2", 1e-15, "m s2/Pa"),
        # a top channel high-passed at 15 Hz: T/(1 - i fc/f)
        ("reading", Term("power", -1), -15 * 2 * np.pi / OMEGA, "high pass", 15.0, "Hz"),
        ("reading", Term("power"), 0.05, "change of ln gain", 0.05, ""),
        ("added_reading", Term("power", -1), 0.03 / OMEGA, "share of the base's motion as 1/(i w)", 0.03, "1/s"),
    ],
)  # fmt: skip
def test_a_law_is_told_in_the_unit_of_what_it_is_called(place, term, amplitude, words, value, unit):
    entry = told(PLACES[place](), term, amplitude)
    (part,) = entry["terms"]
    assert (part["term"], part["unit"]) == (words, unit)
    assert part["value"] == pytest.approx(value, rel=1e-6)
    assert part["low"] < part["value"] < part["high"]
    assert words in entry["text"]


def test_a_softening_is_no_factor():
    (part,) = told(SampleStrain(), Term("lossy"), -300.0, 0.1)["terms"]
    assert part["term"] == "change of ln E per strain with losses"


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (TUBE_PLACES["layer_modulus"]("foam"), "a change of ln E of 0.3"),
        (TUBE_PLACES["layer_density"]("foam"), "a change of ln density of 0.3"),
        (TUBE_PLACES["reading"](), "a change of ln gain of 0.3"),
        (TUBE_PLACES["behind"](), "an ln of the backing's reflection of 0.3"),
    ],
)
def test_a_change_of_a_logarithm_in_a_tube_is_told_as_one(place, words):
    assert told(place, Term("power"), 0.3, bench=tube_bench(elastic=True))["text"].startswith(words)


@pytest.mark.parametrize(("quantity", "unit"), [("transmission_loss", "dB"), ("absorption", "")])
@pytest.mark.parametrize("name", ["reading", "one_measurement"])
def test_a_level_is_told_in_decibels_and_absorption_without(name, quantity, unit):
    bench = level_bench(quantity)
    place = LEVEL_PLACES[name].instances(bench.settings)[0]
    entry = told(place, Term("power"), 0.2, bench=bench)
    assert place.unit == entry["terms"][0]["unit"] == unit
    assert entry["text"].endswith(f" {unit}") == bool(unit)
    assert entry["terms"][0]["term"] == place.quantity

"""Two causes at once, of which the library knows one or none."""

from pathlib import Path

import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison
from multilayer.diagnosis.fitting import fit_effects, polish_fits
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.saved_law import saved_law
from multilayer.diagnosis.two_causes import two_causes, two_causes_entry
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.errors import InputError
from multilayer.experiments.places import Term
from tests.diagnosis.rigs import TRIED, measured

SHARE = (PLACES["added_reading"](), Term("power", 0), [0.03])
SPRING = (PLACES["beside"](), Term("lossy"), [2e3, 0.2])


@pytest.fixture(scope="module")
def both():
    """The nominal model of data with both causes, and the places with free laws."""
    nominal = measured(SHARE, SPRING)
    return nominal, fit_places(nominal, names=TRIED)


def compared(nominal, places, names):
    singles = polish_fits(fit_effects(nominal, {name: EFFECTS[name]() for name in names}))
    evidence = {(): tolerant_evidence(nominal), **{key: tolerant_evidence(fit) for key, fit in singles.items()}}
    best = next(iter(places.values())).log_evidence
    return ModelComparison(nominal, singles, {**evidence, UNKNOWN: best}, len(singles), places)


@pytest.mark.parametrize("known", ["crosstalk", pytest.param("high_pass", marks=pytest.mark.slow)])
def test_both_places_and_the_law_of_the_unknown_one(both, known):
    """Crosstalk is there, and a known effect; a high pass is not there: then both causes are laws of their own."""
    two = two_causes(compared(*both, [known]))
    entry = two_causes_entry(two)
    assert set(entry["places"]) == {"added_reading", "beside"}
    assert entry["effects"] == (["crosstalk"] if known == "crosstalk" else [])
    assert entry["shrinkage"] > 0.95
    assert two.explanation.minimum.misfit / len(two.explanation.minimum.residual) < 1.1
    record = {"verdict": "unknown", "law": entry["law"], "two_causes": entry}
    if known == "crosstalk":
        assert entry["law"]["form"]["terms"][0]["value"] == pytest.approx(2e3, rel=0.03)
        crosstalk, spring = saved_law(record, "foam").applied(Path("rig.yaml"))
        assert (crosstalk.name, spring.name) == ("crosstalk", "known_beside")
    else:
        with pytest.raises(InputError, match="two unknown laws"):
            saved_law(record, "foam")


def test_one_cause_is_not_taken_for_two():
    nominal = measured(SPRING)
    assert two_causes(compared(nominal, fit_places(nominal, names=TRIED), ["high_pass"])) is None

"""What a diagnosis tells of the gap, and what its report makes of that."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.effects.temperature_drift import TemperatureDrift
from multilayer.diagnosis.entries import gap_entry, gap_in_fit
from multilayer.diagnosis.fitting import Fitted
from multilayer.report.diagnosis import diagnosis_report
from multilayer.testing.benches import joint_bench, soft_sample
from tests.report.diagnoses import diagnosis

NOTHING = "nothing could be left out"


def fitted(drift):
    """Return a fit of a rig's data that a drift of the modulus misses by as much as it is large."""
    bench = joint_bench().with_effects(TemperatureDrift())
    (parameter,) = TemperatureDrift.parameters
    return Fitted(bench, bench.as_minimum(np.append(soft_sample(joint_bench()), parameter.prior.coordinate(drift))))


def test_the_gap_is_that_of_the_fit_where_nothing_could_be_left_out():
    nominal, best = fitted(0.2), fitted(0.02)
    unknown = Shrinkage(float("nan"), float("nan"), NOTHING)
    gap = gap_entry(nominal, unknown, best)
    assert (gap["before"], gap["after"]) == (gap_in_fit(nominal), gap_in_fit(best))
    assert gap["before"] > gap["after"] > 1
    assert gap["shrinkage"] == pytest.approx(1 - (gap["after"] - 1) / (gap["before"] - 1), abs=1e-4)
    assert gap["held_out"] == NOTHING
    assert gap_entry(nominal, unknown)["before"] == gap_in_fit(nominal)
    assert gap_entry(nominal, Shrinkage(9.0, 2.0, "blocks"), best)["after"] == 2.0


def with_record(verdict, **changes):
    made = diagnosis(verdict, 1)
    return replace(made, record=made.record | changes)


@pytest.mark.parametrize("after", [1.1, None])
def test_a_gap_in_the_fit_is_not_told_to_be_one_on_data_left_out(after):
    gap = {"before": 31.2, "after": after, "noise": 1.0, "shrinkage": after and 0.99, "held_out": NOTHING}
    report = diagnosis_report(with_record("unknown", gap=gap))
    assert "data that were not used in the fit" not in report.note
    facts = [value for name, value in report.facts if "gap" in name or name == "shrinkage"]
    assert facts == (["31.2", "1.1", "99 %"] if after else ["31.2"])
    held_out = diagnosis_report(diagnosis("unknown", 1)).note
    assert "data that were not used in the fit (leave one configuration out)" in held_out


@pytest.mark.parametrize(("effects", "is_saved"), [([], False), (["sensor_mass"], True)])
def test_two_unknown_laws_at_once_cannot_be_saved(effects, is_saved):
    law = {"place": "reading", "quantity": "change of ln(top/base)"}
    both = {"effects": effects, "places": ["reading", "top_plate"], "law": law}
    report = diagnosis_report(with_record("unknown", law=law, two_causes=both), Path("my/foam"), Path("out"))
    assert report.sections[-1].title == "What to type next"
    commands = "\n".join(report.sections[-1].remarks)
    assert ("--save-law" in commands) == ("--with" in commands) == is_saved
    assert "multilayer explore my/foam" in commands


def test_an_effect_that_vanishes_at_large_values_is_told_up_to_one():
    sizes = {
        "sensor_mount": {"parameter": "frequency", "smallest": 6.7e4, "unit": "Hz", "shows": "up to"},
        "channel_gain": {"parameter": "gain", "smallest": 0.003, "unit": "", "shows": "from"},
        "skin": {"parameter": "thickness", "smallest": None, "unit": "m", "shows": "from"},
    }
    (section,) = (s for s in diagnosis_report(with_record("effect", detectable=sizes)).sections if "size on" in s.title)
    told = dict(section.items)
    assert told["sensor mount"] == "frequency up to 67 kHz"
    assert told["channel gain"].startswith("gain from 0.003")
    assert told["skin"] == "not visible at any size"


def test_what_may_be_passive_is_not_told_to_take_power():
    f = np.geomspace(100, 1000, 20).tolist()
    curves = {f"{part}{end}": [0.01] * 20 for part in ("real", "imag") for end in ("", "_low", "_high")}
    form = {"text": "a mass of 10 g", "real": [0.01] * 20, "imag": [0.0] * 20}
    law = {"place": "top_plate", "quantity": "dynamic mass", "unit": "kg", "frequency_hz": f, **curves,
           "form": form, "form_is_enough": True, "passive": True, "causal": True}  # fmt: skip
    place = {"place": "top_plate", "title": "on the top plate", "probability": 1.0, "behind": 0.0, "gap_after": 1.1,
             "shrinkage": 0.998}  # fmt: skip
    report = diagnosis_report(with_record("unknown", places=[place], law=law))
    (section,) = (section for section in report.sections if section.title.startswith("Where on the rig"))
    assert not any("It takes power" in remark for remark in section.remarks)
    assert any("nowhere gives power" in remark for remark in section.remarks)

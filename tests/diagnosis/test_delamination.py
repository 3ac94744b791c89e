"""Partly bonded faces: the law and its finer ones."""

import numpy as np
import pytest

from multilayer.diagnosis.effects.delamination import Delamination, UnevenRims, WornRim
from multilayer.diagnosis.saved_law import named_effects
from multilayer.testing.benches import joint_bench

NAMES = [data.name for data in joint_bench().data]


def test_finer_laws_follow_one_another():
    law = Delamination()
    uneven = law.finer(NAMES)
    worn = uneven.finer(NAMES)
    assert [type(each) for each in (uneven, worn)] == [UnevenRims, WornRim]
    assert worn.finer(NAMES) is None
    assert uneven.parameters[: len(law.parameters)] == law.parameters
    assert worn.parameters[: len(uneven.parameters)] == uneven.parameters
    # the rim of a single configuration has one width, that of the law
    assert type(law.finer(NAMES[:1])) is WornRim


@pytest.mark.parametrize("index", range(len(NAMES)))
def test_a_width_of_its_own_is_that_of_one_configuration(index):
    joint = joint_bench()
    uneven = joint.with_effects(UnevenRims(NAMES))
    z = np.zeros(len(uneven.parameters))
    at = [parameter.name for parameter in uneven.parameters].index(f"delamination.width[{NAMES[index]}]")
    wider = z.copy()
    wider[at] = 1.0
    changes = [np.abs(b - a).max() for a, b in zip(uneven.differences(z), uneven.differences(wider), strict=True)]
    assert [change > 1e-3 for change in changes] == [i == index for i in range(len(NAMES))]
    # the same as all rims wider, there
    plain = joint.with_effects(Delamination())
    own = Delamination.parameters[0].prior
    all_wider = np.zeros(len(plain.parameters))
    all_wider[len(joint.parameters)] = own.coordinate(float(own.value(np.zeros(()))) * np.exp(0.2))
    found, expected = (hypothesis.differences(at)[index] for hypothesis, at in ((uneven, wider), (plain, all_wider)))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_widths_of_single_configurations_are_not_saved_for_later_campaigns():
    size = {"value": 0.1, "low": 0.09, "high": 0.11, "unit": ""}
    names = ["delamination.open_rim", f"delamination.width[{NAMES[0]}]"]
    cause = {"effects": ["delamination"], "parameters": dict.fromkeys(names, size)}
    (saved,) = named_effects({"causes": [cause], "group": [["delamination"]]})
    assert list(saved.parameters) == ["open_rim"]

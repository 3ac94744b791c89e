"""Partly bonded faces: the law and its finer ones."""

import numpy as np
import pytest

from multilayer.diagnosis.effects.delamination import Delamination, UnevenRims, WornRim
from multilayer.diagnosis.saved_law import named_effects
from multilayer.rig import TwoPlateRig
from multilayer.testing.benches import joint_bench, soft_sample

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
    assert [change > 1e-4 for change in changes] == [i == index for i in range(len(NAMES))]
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


@pytest.mark.parametrize(("rim", "modulus"), [(0.1, 2e5), (0.253, 2e5), (0.5, 2e5), (0.1, 2e6), (0.253, 2e6)])
def test_a_thin_plate_on_open_rims_moves_as_that_of_finite_elements(rim, modulus):
    """1 mm of steel that bends, and yields to the sample by that: within 1 % at every frequency, resonances of the rim
    among them."""
    joint = joint_bench()
    law = Delamination()
    hypothesis = joint.with_effects(law)
    sample = soft_sample(joint)
    sample[0] = float(joint.law_parameters[0].prior.coordinate(np.log(modulus)))
    sizes = (rim, 0.0, 1 - 1e-9)
    z = np.append(sample, [float(p.prior.coordinate(v)) for p, v in zip(law.parameters, sizes, strict=True)])
    setting = hypothesis.settings[0]
    moduli = joint.space.modulus(joint.law_coordinates(sample), setting.frequency)
    c, plate = setting.configuration, setting.campaign.top_plate
    open_, bonded = (
        TwoPlateRig(
            c.specimen_radius, c.specimen_thickness, 80.0, 0.0, c.top_plate_thickness, plate_modulus=stiffness,
            plate_poisson_ratio=plate.poisson_ratio, bonded_fraction=share, open_faces="both", resolution=3.0,
        ).transmissibility(setting.frequency, moduli)
        for stiffness, share in ((plate.young_modulus, (1 - rim) ** 2), (1e4 * plate.young_modulus, 1.0))
    )  # fmt: skip
    assert np.abs(open_ / bonded - 1).max() > 0.05
    found = hypothesis.predict(setting, z)[0] / joint.predict(setting, sample)[0]
    np.testing.assert_allclose(found, open_ / bonded, rtol=0.01)

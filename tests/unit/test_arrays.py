"""Rows that differ, and what frequencies may be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multilayer import Stack, base_motion, diffuse_field, plane_wave
from multilayer.arrays import distinct_rows
from multilayer.errors import InputError
from multilayer.response import base_motion_derivatives, diffuse_field_derivatives, plane_wave_derivatives

WOOL = Stack.model_validate(
    {
        "layers": [{"type": "equivalent_fluid", "name": "wool", "thickness": 0.05, "model": "delany_bazley",
                    "flow_resistivity": 5e3}],
        "termination": "ambient",
    }
)  # fmt: skip


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)), elements=st.sampled_from([0.0, 1.0, 1.5, -2.0])))
def test_rows_are_given_back(rows):
    kept, place = distinct_rows(rows, np.float64(3.0) + np.zeros(()))
    np.testing.assert_array_equal(rows[kept][place], rows)
    assert len(kept) == len(np.unique(rows, axis=0))


def test_columns_count_together():
    kept, place = distinct_rows(np.array([[1.0], [1.0], [1.0]]), np.array([0.0, 2.0, 0.0]), np.zeros(()))
    assert len(kept) == 2
    assert place[0] == place[2] != place[1]


@pytest.mark.parametrize(
    "respond",
    [
        plane_wave,
        diffuse_field,
        base_motion,
        lambda stack, f: plane_wave_derivatives(stack, None, f),
        lambda stack, f: diffuse_field_derivatives(stack, None, f),
        lambda stack, f: base_motion_derivatives(stack, None, f),
    ],
)
@pytest.mark.parametrize(
    ("frequency", "text"),
    [
        ([], "there is no frequency"),
        (-100.0, "must be above 0 Hz"),
        ([100.0, 0.0], "must be above 0 Hz"),
        (np.nan, "not finite"),
        ("100 Hz", "no number"),
        (100 + 1j, "no number"),
    ],
)
def test_a_frequency_that_is_none(respond, frequency, text):
    with pytest.raises(InputError, match=text):
        respond(WOOL, frequency)


def test_a_diffuse_field_keeps_the_shape_of_the_frequencies():
    f = np.array([[100.0, 200.0, 300.0], [400.0, 500.0, 600.0]])
    flat, shaped = diffuse_field(WOOL, f.ravel()), diffuse_field_derivatives(WOOL, ["layers.wool.thickness"], f)
    np.testing.assert_allclose(shaped.response.absorption, flat.absorption.reshape(f.shape), rtol=1e-9)
    assert shaped.absorption.shape == (1, *f.shape)


@pytest.mark.parametrize("angle", [[], -1.0, 90.0, np.nan])
def test_an_angle_that_is_none(angle):
    with pytest.raises(InputError, match="angle"):
        plane_wave(WOOL, 100.0, angle)


def test_texts_in_place_of_numbers_and_lists():
    with pytest.raises(InputError, match="and '50 mm' is a text; give a number in SI units"):
        WOOL.replaced({"layers.wool.thickness": "50 mm"})
    with pytest.raises(InputError, match="is a text; give a list of paths"):
        plane_wave_derivatives(WOOL, "layers.wool.thickness", 100.0)

"""Laws that no stack of any layers can break."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from multilayer.layers import LAYERS
from multilayer.matrix.families import FLUID
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import base_motion, plane_wave
from multilayer.stack import FluidHalfSpace, LayerContact, Stack
from tests.contract.samples import LAYER_SAMPLES

pytestmark = pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")  # any fields at any frequency
laws = settings(deadline=None, max_examples=50)


def between(low, high):
    """Return numbers spread evenly over the decades."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


frequencies = between(1.0, 5e4)
angles = st.one_of(st.just(0.0), st.floats(0.0, 89.0))
poisson_ratios = st.floats(-0.9, 0.499).filter(lambda ratio: ratio == 0 or abs(ratio) > 1e-20)
damping = {"poisson_ratio": poisson_ratios, "loss_factor": st.one_of(st.just(0.0), between(1e-4, 1.0))}
pores = {
    "porosity": st.floats(0.1, 0.999),
    "flow_resistivity": between(1e2, 1e7),
    "tortuosity": st.floats(1.0, 4.0),
    "viscous_length": between(1e-6, 1e-3),
    "thermal_length": between(1e-6, 1e-2),
}
# any fields for these; for all types the samples of the contract tests, in any thickness
FIELDS = {
    "fluid": {"density": between(0.05, 2e4), "sound_speed": between(100.0, 6e3)},
    "elastic_solid": {**damping, "density": between(5.0, 2e4)},
    "elastic_plate": {**damping, "density": between(5.0, 2e4)},
    "poroelastic": {**damping, **pores, "frame_density": between(2.0, 3000.0)},
}
SAMPLES = [(name, fields) for name in LAYERS.names() for _, fields, _ in LAYER_SAMPLES.get(name, [])]


ONE_SIDED = ("graded", "helmholtz_resonators", "patches")


@st.composite
def random_layers(draw, name, **given_fields):
    fields = draw(st.fixed_dictionaries({**FIELDS[name], "thickness": between(1e-6, 3.0), **given_fields}))
    if "poisson_ratio" in fields:  # no known solid carries sound faster than 12 km/s, no porous frame than 3 km/s
        density, fastest = (fields["density"], 12e3) if "density" in fields else (fields["frame_density"], 3e3)
        fields["young_modulus"] = density * draw(between(5.0, fastest)) ** 2
    return LAYERS[name].model_validate(fields)


lossless_layers = st.one_of(
    random_layers("fluid"),
    *(random_layers(name, loss_factor=st.just(0.0)) for name in ("elastic_solid", "elastic_plate")),
)


@st.composite
def layers(draw):
    if draw(st.booleans()):
        name, fields = draw(st.sampled_from(SAMPLES))
        drawn = {"thickness": draw(between(1e-6, 3.0))} if "thickness" in fields else {}
        return LAYERS[name].model_validate({**fields, **drawn})
    return draw(random_layers(draw(st.sampled_from(sorted(FIELDS)))))


def is_fluid(layer):
    return layer.faces(Wave.incident(100.0, 0.0, dry_air())).family == FLUID


@st.composite
def stacks(draw, terminations):
    chosen = tuple(draw(st.lists(layers(), min_size=1, max_size=5)))
    fluid = [is_fluid(layer) for layer in chosen]
    pairs = [(i, i + 1) for i in range(len(chosen) - 1) if not (fluid[i] or fluid[i + 1])]
    slipping = [LayerContact(between=pair, kind="slip") for pair in pairs if draw(st.booleans())]
    return Stack(layers=chosen, contacts=tuple(slipping), termination=draw(st.sampled_from(terminations)))


def reverse(stack):
    last = len(stack.layers) - 1
    contacts = tuple(
        LayerContact(between=tuple(last - end for end in contact.between), kind=contact.kind)
        for contact in stack.contacts
    )
    return stack.model_copy(update={"layers": stack.layers[::-1], "contacts": contacts})


@laws
@given(stacks(["rigid", "free"]), frequencies, angles)
def test_no_more_comes_back_than_was_sent(stack, frequency, angle):
    assert abs(plane_wave(stack, frequency, angle).reflection) <= 1 + 1e-9


@laws
@given(stacks(["ambient", FluidHalfSpace(density=1000.0, sound_speed=1480.0)]), frequencies, angles)
def test_what_comes_back_and_goes_through_is_no_more_than_was_sent(stack, frequency, angle):
    result = plane_wave(stack, frequency, angle)
    assert result.absorption - 10 ** (-result.transmission_loss / 10) >= -1e-9


@laws
@given(stacks(["ambient"]), frequencies, angles)
def test_both_ways_through_are_alike(stack, frequency, angle):
    assume(not any(layer.type in ONE_SIDED for layer in stack.layers))  # `reverse` does not turn layers round
    there, back = (plane_wave(panel, frequency, angle).transmission for panel in (stack, reverse(stack)))
    assert abs(there - back) <= 1e-7 * abs(there) + 1e-290


@laws
@given(st.lists(lossless_layers, min_size=1, max_size=5), frequencies, angles)
def test_a_stack_without_losses_loses_nothing_either_way(chosen, frequency, angle):
    stack = Stack(layers=tuple(chosen), termination="ambient")
    for panel in (stack, reverse(stack)):
        result = plane_wave(panel, frequency, angle)
        assert abs(result.absorption - abs(result.transmission) ** 2) < 1e-7


@laws
@given(stacks(["ambient", "free"]), frequencies)
def test_the_top_of_a_shaken_stack_moves(stack, frequency):
    assert np.isfinite(base_motion(stack, frequency).transmissibility)

"""Every registered modulus law, those of plugins included: passive, causal, broadcasting, read back from a file."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.config import dump_yaml, parse_yaml
from multilayer.errors import InputError
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.media.kramers_kronig import kramers_kronig_loss_modulus
from multilayer.media.laws import LAWS, Table
from multilayer.stack import Stack
from tests.contract import samples

FREQUENCIES = np.geomspace(1.0, 5e4, 40)
EVERYWHERE = np.geomspace(1e-6, 1e12, 361)
# so far out that the broadest of the samples is on its plateaus
ALL_TIME = np.geomspace(1e-45, 1e45, 90 * 30 + 1)

_PLATEAUS = {"relaxed_modulus": 1e5, "unrelaxed_modulus": 1e7, "relaxation_time": 1e-4}
LAW_SAMPLES = {
    **samples.LAW_SAMPLES,
    "zener": [_PLATEAUS, {**_PLATEAUS, "unrelaxed_modulus": 1e5}],
    "havriliak_negami": [
        {**_PLATEAUS, "order": 0.5, "asymmetry": 0.4},
        {**_PLATEAUS, "order": 0.4, "asymmetry": 2.5},
        {**_PLATEAUS, "order": 1.0, "asymmetry": 0.3},
        {**_PLATEAUS, "relaxation_time": 1e-14, "order": 0.2, "asymmetry": 1.0},
    ],
    "maxwell": [
        {"relaxed_modulus": 1e5, "branch_modulus": (1e5, 0.0, 3e6), "relaxation_time": (1e-2, 1e-3, 1e-6)},
        {"relaxed_modulus": 1e5, "branch_modulus": (1e5,), "relaxation_time": (1e-12,)},
    ],
    "free_form": [
        {"relaxed_modulus": 1e5, "frequency": (1.0, 30.0, 1e3, 1e6), "rise": (1e5, 0.0, 3e6)},
        {"relaxed_modulus": 1e5, "frequency": (1e-9, 1e15), "rise": (1e9,)},
    ],
}


VARIANTS = [
    pytest.param(LAWS[name].model_validate(fields), id=f"{name}-{i}")
    for name in LAWS.names()
    for i, fields in enumerate(LAW_SAMPLES.get(name, []))
]


@pytest.mark.parametrize("name", LAWS.names())
def test_every_registered_law_has_samples(name):
    assert samples.samples_of("modulus law", name, LAW_SAMPLES)


def within(law, frequency):
    """Return the frequencies for which a law has a value."""
    if not isinstance(law, Table):
        return frequency
    return frequency[(frequency >= law.frequency[0]) & (frequency <= law.frequency[-1])]


@pytest.mark.parametrize("law", VARIANTS)
def test_passive(law):
    modulus = law(within(law, EVERYWHERE))
    assert np.all(modulus.real > 0)
    assert np.all(modulus.imag >= 0)


@pytest.mark.parametrize("law", VARIANTS)
def test_real_strains_have_real_stresses(law):
    f = within(law, EVERYWHERE)
    assert_allclose(law(-f), law(f).conj(), rtol=1e-13)


@pytest.mark.parametrize("law", [p for p in VARIANTS if p.values[0].causal])
def test_stress_does_not_precede_strain(law):
    """Kramers and Kronig: the dispersion of E1 demands E2, but for a dashpot, which is what is left at the far end."""
    f = ALL_TIME
    modulus = law(f)
    loss = modulus.imag - f * modulus.imag[-1] / f[-1]
    demanded = kramers_kronig_loss_modulus(f, modulus.real)
    chosen = (f >= EVERYWHERE[0]) & (f <= EVERYWHERE[-1])
    assert_allclose(demanded[chosen], loss[chosen], atol=2e-3 * np.max(loss) + 1e-9 * modulus.real[0])


@pytest.mark.parametrize("law", [p for p in VARIANTS if not p.values[0].causal and not isinstance(p.values[0], Table)])
def test_a_law_that_says_it_is_not_causal_is_not(law):
    modulus = law(ALL_TIME)
    demanded = kramers_kronig_loss_modulus(ALL_TIME, modulus.real)
    assert np.max(np.abs(demanded - modulus.imag)) == pytest.approx(np.max(modulus.imag))


@pytest.mark.parametrize("law", VARIANTS)
def test_frequencies_of_any_shape(law):
    together = law(FREQUENCIES.reshape(5, 8))
    assert together.shape == (5, 8)
    assert together.dtype == complex
    assert_allclose(together.ravel(), [law(f) for f in FREQUENCIES], rtol=1e-13)
    assert np.shape(law(100.0)) == ()


def with_value(law, field, index, value):
    """Return a law with another value in a field, or in an entry of it; not validated, for it may be an array."""
    if index is None:
        return law.model_copy(update={field: value})
    entries = getattr(law, field)
    return law.model_copy(update={field: (*entries[:index], value, *entries[index + 1 :])})


def numbers(law):
    """Yield field, index and value of every parameter; the index is None where the field is no list."""
    for field, value in law:
        if isinstance(value, float):
            yield field, None, value
        elif isinstance(value, tuple):
            yield from ((field, index, entry) for index, entry in enumerate(value))


@pytest.mark.parametrize("law", [p for p in VARIANTS if not isinstance(p.values[0], Table)])
def test_parameters_of_any_shape(law):
    assert list(numbers(law))
    for field, index, value in numbers(law):
        values = value * np.array([[1.0], [0.9]])
        together = with_value(law, field, index, values)(FREQUENCIES)
        alone = [with_value(law, field, index, float(v))(FREQUENCIES) for v in values[:, 0]]
        assert_allclose(np.broadcast_to(together, (2, FREQUENCIES.size)), alone, rtol=1e-13)


@pytest.mark.parametrize("law", VARIANTS)
def test_file_round_trip(law):
    layer = ElasticSolid(thickness=0.01, density=100.0, young_modulus=law, poisson_ratio=0.3)
    stack = Stack(layers=(layer,))
    text = dump_yaml(stack.to_dict())
    assert Stack.model_validate(parse_yaml(text, Path("stack.yaml")).data) == stack


def table():
    return Table.model_validate(LAW_SAMPLES["table"][0])


def test_table_passes_through_its_points():
    assert_allclose(table()(table().frequency), np.array(table().storage_modulus) + 1j * np.array(table().loss_modulus))


def test_table_is_linear_in_the_logarithm_of_frequency():
    assert table()(10.0) == pytest.approx(1.5e5 + 2e4j)


@pytest.mark.parametrize("frequency", [0.5, 6e4, [10.0, 1e5]])
def test_table_is_not_extrapolated(frequency):
    with pytest.raises(InputError, match="the modulus table holds 1 to 50000 Hz"):
        table()(frequency)

"""Every registered modulus law, those of plugins included: passive, broadcasting, and read back from a file."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.config import dump_yaml, parse_yaml
from multilayer.errors import InputError
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.media.laws import LAWS, Table
from multilayer.stack import Stack
from tests.contract.samples import LAW_SAMPLES, samples_of

FREQUENCIES = np.geomspace(1.0, 5e4, 40)


VARIANTS = [
    pytest.param(LAWS[name].model_validate(fields), id=f"{name}-{i}")
    for name in LAWS.names()
    for i, fields in enumerate(LAW_SAMPLES.get(name, []))
]


@pytest.mark.parametrize("name", LAWS.names())
def test_every_registered_law_has_samples(name):
    assert samples_of("modulus law", name, LAW_SAMPLES)


@pytest.mark.parametrize("law", VARIANTS)
def test_passive(law):
    modulus = law(FREQUENCIES)
    assert np.all(modulus.real > 0)
    assert np.all(modulus.imag >= 0)


@pytest.mark.parametrize("law", VARIANTS)
def test_frequencies_of_any_shape(law):
    together = law(FREQUENCIES.reshape(5, 8))
    assert together.shape == (5, 8)
    assert together.dtype == complex
    assert_allclose(together.ravel(), [law(f) for f in FREQUENCIES], rtol=1e-13)
    assert np.shape(law(100.0)) == ()


@pytest.mark.parametrize("law", [p for p in VARIANTS if not isinstance(p.values[0], Table)])
def test_parameters_of_any_shape(law):
    fields = [name for name, value in law if isinstance(value, float)]
    assert fields
    for field in fields:
        values = getattr(law, field) * np.array([[1.0], [0.9]])
        together = law.model_copy(update={field: values})(FREQUENCIES)
        alone = [law.model_copy(update={field: float(value)})(FREQUENCIES) for value in values[:, 0]]
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

"""Every registered layer, those of plugins included, keeps the laws of `multilayer.testing`."""

from pathlib import Path

import pytest

from multilayer.layers import LAYERS
from multilayer.testing import check_layer
from tests.contract.samples import layer_samples

BUILT_IN = [name for name in LAYERS if [owner.package for owner in LAYERS.owners(name)] == ["multilayer"]]
MANUAL = Path(__file__).parents[2] / "docs" / "stack-files.md"
VARIANTS = [
    pytest.param(name, fields, lossless, id=f"{name}-{what}")
    for name in LAYERS.names()
    for what, fields, lossless in layer_samples(name)
]


@pytest.mark.parametrize("name", LAYERS.names())
def test_every_registered_layer_has_samples(name):
    assert LAYERS[name]
    assert layer_samples(name), f"'{name}' has none: add some to tests/contract/samples.py, a plugin to its `examples`"


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_built_in_layer_has_a_row_in_the_manual(name):
    assert MANUAL.read_text().count(f"\n| `{name}` | ") == 1, "docs/stack-files.md: a table of all layer types"


@pytest.mark.parametrize(("name", "fields", "lossless"), VARIANTS)
def test_layer_keeps_the_laws(name, fields, lossless):
    check_layer(LAYERS[name].model_validate(fields), lossless=lossless)

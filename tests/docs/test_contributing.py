"""What CONTRIBUTING.md shows is complete and true: its examples are registered as they stand, and keep their laws."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.fits.law_fit import fit_law
from multilayer.fits.methods import METHODS
from multilayer.layers import LAYERS
from multilayer.measurements.readers import READERS, read_channels
from multilayer.media.laws import LAWS
from multilayer.plugins.files import plugin_files
from multilayer.plugins.listing import KINDS, registry
from multilayer.rig.effects import EFFECTS as RIG_EFFECTS
from multilayer.testing import check_effect, check_law, check_layer, check_method, check_rig_effect
from multilayer.tube.data import read_transfer
from multilayer.tube.file import Source

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text()
FILES = dict(re.findall(r"```python\n# (\S+\.py)\n(.*?)```", TEXT, re.DOTALL))
ENTRIES = [
    (group, name, target)
    for block in re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    for group, entries in tomllib.loads(block)["project"]["entry-points"].items()
    for name, target in entries.items()
]
ROWS = re.findall(r"```\n(\| .*)\n```", TEXT)


@pytest.fixture(scope="module", autouse=True)
def registered(tmp_path_factory):
    """Register all examples, as ``--plugin`` does."""
    folder = tmp_path_factory.mktemp("examples")
    files = []
    for path, text in FILES.items():
        files.append(folder / path.replace("/", "_"))
        files[-1].write_text(text)
    with plugin_files(files):
        yield


def test_every_example_has_its_entry_point_and_every_entry_point_its_example():
    paths = {target.partition(":")[0].replace(".", "/") + ".py" for _, _, target in ENTRIES}
    assert paths == set(FILES)
    groups = {registry(kind).group: registry(kind) for kind in KINDS}
    for group, name, target in ENTRIES:
        assert groups[group][name].__name__ == target.partition(":")[2]
        assert group in (ROOT / "pyproject.toml").read_text()


def test_no_example_is_there_already():
    assert [path for path in FILES if (ROOT / path).exists()] == []
    assert [path for path in FILES if not (ROOT / path).parent.is_dir()] == []


def of(group):
    return [name for written, name, _ in ENTRIES if written == f"multilayer.{group}"]


@pytest.mark.parametrize("name", of("modulus_laws"))
def test_laws(name):
    for fields in LAWS[name].examples:
        law = LAWS[name].model_validate(fields)
        check_law(law)
        frequency = np.geomspace(10.0, 1e5, 40)
        assert fit_law(name, frequency, law(frequency), starts=2).mean_relative_error < 1e-3


@pytest.mark.parametrize("name", of("layers"))
def test_layers(name):
    for fields in LAYERS[name].examples:
        check_layer(LAYERS[name].model_validate(fields))


@pytest.mark.parametrize("name", of("effects"))
def test_effects_and_their_twins(name):
    assert of("effects") == of("rig_effects")
    check_effect(EFFECTS[name])
    check_rig_effect(RIG_EFFECTS[name])


@pytest.mark.parametrize("name", of("methods"))
def test_methods(name):
    check_method(METHODS[name])


def test_rows_of_the_manual_name_all_fields():
    for name in (*of("modulus_laws"), *of("layers")):
        assert [row for row in ROWS if row.startswith(f"| `{name}` | ")]
    for name in of("modulus_laws"):
        (row,) = (row for row in ROWS if row.startswith(f"| `{name}` | "))
        assert all(f"`{field}`" in row for field in LAWS[name].model_fields if field != "law")


def test_readers(tmp_path):
    assert set(of("readers")) == {"frd", "f32"} <= set(READERS.names())
    (tmp_path / "h12.frd").write_text("* a program\n100 0 0\n200 -6.0206 90\n")
    transfer = read_transfer(Source(file="h12.frd"), tmp_path, 2)
    np.testing.assert_allclose(transfer.functions, [[1, 1], [1, 0.5j]], atol=1e-6)
    np.arange(10, dtype="<f4").tofile(tmp_path / "run.f32")
    np.testing.assert_array_equal(read_channels(tmp_path / "run.f32")["ai1"].samples, [1, 3, 5, 7, 9])

"""The ``kind`` of a file: read where it is right, refused with its place where it is not, and not needed."""

from pathlib import Path

import pytest

from multilayer.config.kinds import OF_A_FIT, TITLES, kind_of_data
from multilayer.errors import InputError
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import open_source
from multilayer.kinds import KINDS
from multilayer.stack import load_stack

STACK = "version: 1\nlayers:\n  - {type: fluid, thickness: 0.1}\n"


@pytest.fixture
def written(tmp_path: Path):
    """Return a function that writes a file."""

    def write(text: str) -> Path:
        file = tmp_path / "file.yaml"
        file.write_text(text)
        return file

    return write


def test_all_kinds_have_titles():
    assert set(KINDS) == set(TITLES)


def test_a_stack_says_its_kind_or_not(written):
    plain = load_stack(written(STACK))
    assert load_stack(written(f"kind: stack\n{STACK}")) == plain
    assert load_stack(written(f"kind: simulation\n{STACK}frequency: [100]\n")) == plain


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (
            "campaign",
            "this file is another one ('campaign': campaign on the two-plate rig); what is read here: stack",
        ),
        ("stak", "there is no kind of file 'stak'; did you mean 'stack'"),
        ("[stack]", "there is no kind of file"),
        ("3", "there is no kind of file 3"),
    ],
)
def test_another_kind_is_refused_with_its_place(written, kind, message):
    with pytest.raises(InputError) as caught:
        load_stack(written(f"version: 1\nkind: {kind}\nlayers: []\n"))
    assert "file.yaml:2:7: kind: " in str(caught.value)
    assert message in str(caught.value)


def test_what_a_file_says_goes_before_its_keys(written):
    assert kind_of_data({"kind": "fit", "layers": []}) == "fit"
    assert kind_of_data({"layers": [], "seed": 1}) == "simulation"
    assert kind_of_data([1]) == kind_of_data({"version": 1}) == ""
    assert open_source(written("kind: diagnose\nversion: 1\n")).of_stacks


def test_keys_of_a_fit_are_those_of_its_model():
    assert set(FitSettings.model_fields) - {"version", "ambient"} == OF_A_FIT

"""What MATLAB saves is read; what it does not save so is refused with a reason."""

import numpy as np
import pytest
from scipy.io import savemat

from multilayer.errors import InputError
from multilayer.measurements.readers import read_waveforms

BASE = np.random.default_rng(1).normal(size=(3, 50))


@pytest.mark.parametrize("shape", [(3, 50), (1, 150), (150, 1)])
def test_what_was_saved_comes_back(tmp_path, shape):
    file = tmp_path / "burst.mat"
    savemat(file, {"base": BASE.reshape(shape), "top": 2 * BASE.reshape(shape), "sampling_rate": 25600.0})
    found = read_waveforms(file)
    rows = (3, 50) if shape[0] == 3 else (1, 150)
    assert np.array_equal(found.base, BASE.reshape(rows))
    assert np.array_equal(found.top, 2 * BASE.reshape(rows))
    assert found.sampling_rate == 25600.0


def test_the_rate_may_be_missing(tmp_path):
    savemat(tmp_path / "burst.mat", {"base": BASE, "top": BASE})
    assert read_waveforms(tmp_path / "burst.mat").sampling_rate is None


@pytest.mark.parametrize(
    ("held", "words"),
    [
        ({"base": BASE}, "has no variable 'top'; it holds base"),
        ({"base": BASE, "top": "text"}, "'top' holds no real numbers"),
        ({"base": BASE, "top": BASE, "sampling_rate": -1.0}, "'sampling_rate' is no single number"),
    ],
)
def test_what_is_missing_is_told(tmp_path, held, words):
    savemat(tmp_path / "burst.mat", held)
    with pytest.raises(InputError, match=words):
        read_waveforms(tmp_path / "burst.mat")


def test_another_file_is_refused(tmp_path):
    (tmp_path / "burst.mat").write_text("no such thing")
    with pytest.raises(InputError, match=r"is no \.mat file that can be read"):
        read_waveforms(tmp_path / "burst.mat")

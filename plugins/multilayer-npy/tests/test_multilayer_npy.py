"""Arrays of bursts are read; others are refused with a reason."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.measurements.readers import read_waveforms

BURSTS = np.random.default_rng(1).normal(size=(3, 2, 50))


@pytest.mark.parametrize("held", [BURSTS, BURSTS[0], BURSTS.astype(np.float32), (1000 * BURSTS).astype(np.int16)])
def test_what_was_saved_comes_back(tmp_path, held):
    np.save(tmp_path / "burst.npy", held)
    found = read_waveforms(tmp_path / "burst.npy")
    expected = held.reshape(-1, 2, 50)
    assert np.array_equal(found.base, expected[:, 0])
    assert np.array_equal(found.top, expected[:, 1])
    assert found.base.dtype == float
    assert found.sampling_rate is None


@pytest.mark.parametrize(
    ("held", "words"),
    [
        (BURSTS[:, :1], r"has the shape \(3, 1, 50\); it must be \(2, samples\)"),
        (BURSTS[0, 0], r"has the shape \(50,\)"),
        (BURSTS + 1j, "holds no array of real numbers"),
        (np.array([{}, {}]), "holds no array of numbers"),
    ],
)
def test_another_array_is_refused(tmp_path, held, words):
    np.save(tmp_path / "burst.npy", held)
    with pytest.raises(InputError, match=words):
        read_waveforms(tmp_path / "burst.npy")


@pytest.mark.parametrize("text", ["", "no such thing"])
def test_another_file_is_refused(tmp_path, text):
    (tmp_path / "burst.npy").write_text(text)
    with pytest.raises(InputError, match="holds no array of numbers"):
        read_waveforms(tmp_path / "burst.npy")

"""Which rows of a table a measurement of a stack fit takes."""

from functools import partial

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.experiments.stacks.columns import read_values
from multilayer.experiments.stacks.file import load_stack_fit
from tests.fits.stack_fits import IN_A_TUBE, PORES, write
from tests.recorders import SPECTRA_WRITERS, write_uff_spectra

FREQUENCY = np.array([250.0, 500.0, 1000.0, 250.0, 500.0, 1000.0])
ANGLE, SAMPLE = np.repeat([0.5, 45.5], 3), np.array([1.5, 2.5, 3.5, 1.5, 2.5, 4.5])
ABSORPTION = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


def measurement(folder, suffix, rows):
    spectra = {"absorption": ABSORPTION, "angle": ANGLE, "sample": SAMPLE}
    writer = partial(write_uff_spectra, even=False) if suffix in ("uff", "unv") else SPECTRA_WRITERS[suffix]
    writer(folder / f"data.{suffix}", FREQUENCY, spectra, {})
    one = {"kind": "absorption", "file": f"data.{suffix}", "noise": 0.01, "rows": rows}
    return load_stack_fit(write(folder, IN_A_TUBE, {}, [one], PORES)).measurements[0]


@pytest.mark.parametrize("suffix", SPECTRA_WRITERS)
def test_rows_are_chosen_in_every_format(tmp_path, suffix):
    found = read_values(measurement(tmp_path, suffix, {"angle": "45.5"}), tmp_path)
    np.testing.assert_array_equal(found.frequency, [250, 500, 1000])
    np.testing.assert_allclose(found.values, [0.4, 0.5, 0.6])
    found = read_values(measurement(tmp_path, suffix, {"angle": "0.5", "sample": "2.5"}), tmp_path)
    np.testing.assert_allclose((found.frequency[0], found.values[0]), [500, 0.2])


@pytest.mark.parametrize("suffix", ["csv", "mat"])
def test_rows_that_are_not_there(tmp_path, suffix):
    with pytest.raises(InputError, match=r"no row has '4\.5' as sample; did you mean '3\.5'"):
        read_values(measurement(tmp_path, suffix, {"angle": "0.5", "sample": "4.5"}), tmp_path)

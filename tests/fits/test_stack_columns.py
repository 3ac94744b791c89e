"""Which rows of a table a measurement of a stack fit takes."""

from functools import partial

import numpy as np
import pytest

from multilayer.errors import InputError, PlausibilityWarning
from multilayer.experiments.stacks.columns import read_values
from multilayer.experiments.stacks.file import load_stack_fit
from tests.fits.stack_fits import IN_A_TUBE, ON_A_SHAKER, PORES, write
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


def in_a_tube(folder, lines, **more):
    """Return a measurement of absorption that `multilayer tube` wrote with the frequencies it cannot measure."""
    (folder / "tube.csv").write_text("frequency_hz,in_range,absorption\n" + "\n".join(lines))
    one = {"kind": "absorption", "file": "tube.csv", "noise": 0.01, **more}
    return load_stack_fit(write(folder, IN_A_TUBE, {}, [one], PORES)).measurements[0]


def test_frequencies_outside_of_the_working_range_are_left_out(tmp_path):
    outside, inside = "100,false,3.6", "200,true,0.5"
    with pytest.warns(PlausibilityWarning, match="rows left out of 2: 1 outside of the working range of the tube"):
        found = read_values(in_a_tube(tmp_path, [outside, inside]), tmp_path)
    np.testing.assert_array_equal(found.values, [0.5])
    with pytest.raises(InputError, match="holds no row to fit; left out: 1 outside of the working range"):
        read_values(in_a_tube(tmp_path, [outside]), tmp_path)
    chosen = in_a_tube(tmp_path, ["100,false,0.6", inside], rows={"in_range": "false"})
    np.testing.assert_array_equal(read_values(chosen, tmp_path).values, [0.6])


def test_absorption_in_per_cent_is_asked_back(tmp_path):
    with pytest.warns(PlausibilityWarning, match=r"tube.csv: an absorption of 60; .* are these per cent\?"):
        read_values(in_a_tube(tmp_path, ["200,true,60"]), tmp_path)


MODULI = "configuration,frequency_hz,E1_pa,E1_std_pa,E2_pa,E2_std_pa,accepted\n"


def moduli(folder, *rows, **more):
    """Return a measurement of moduli as a fit of a campaign writes them."""
    (folder / "moduli.csv").write_text(MODULI + "\n".join(rows))
    one = {"kind": "modulus", "layer": "foam", "file": "moduli.csv", **more}
    unknowns = {"layers.foam.young_modulus.order": {"uniform": [0.2, 0.9]}}
    return load_stack_fit(write(folder, ON_A_SHAKER, {}, [one], unknowns)).measurements[0]


def test_noise_of_moduli_is_in_columns_of_usual_names(tmp_path):
    rows = ("a,100,200000,6000,60000,3000,true", "a,200,200000,5000,60000,4000,true")
    found = read_values(moduli(tmp_path, *rows), tmp_path)
    np.testing.assert_allclose(found.values, 2e5 + 6e4j)
    np.testing.assert_allclose(found.noise.real, [6000, 5000])
    np.testing.assert_allclose(found.noise.imaginary, [3000, 4000])


def test_moduli_that_were_not_found_or_not_accepted_are_left_out(tmp_path):
    good = ["a,100,200000,6000,60000,3000,true", "a,500,210000,6000,60000,3000,True"]
    bad = ["a,200,900000,6000,60000,3000,False", "a,300,,,,,false", "a,400,200000,,60000,,true"]
    with pytest.warns(PlausibilityWarning, match="rows left out of 5: 2 not accepted, 1 with an empty cell"):
        found = read_values(moduli(tmp_path, *good, *bad), tmp_path)
    np.testing.assert_array_equal(found.frequency, [100, 500])
    with pytest.raises(InputError, match="holds no row to fit; left out: 2 not accepted, 1 with an empty cell"):
        read_values(moduli(tmp_path, *bad), tmp_path)
    np.testing.assert_array_equal(
        read_values(moduli(tmp_path, bad[0], rows={"accepted": "False"}), tmp_path).values, [9e5 + 6e4j]
    )

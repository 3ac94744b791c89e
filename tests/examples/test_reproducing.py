"""One number of every script that reproduces published figures, and that they all draw."""

import numpy as np
import pytest

from examples.reproducing import allard_atalla_2009, bonfiglio_pompoli_2015, dazel_2013


def test_dazel_double_wall_is_the_published_one():
    """The table has one digit after the point; 200 Hz lies in the steep flank of a resonance."""
    frequency = np.array(list(dazel_2013.PUBLISHED), dtype=float)
    difference = np.abs(dazel_2013.transmission_loss(frequency) - list(dazel_2013.PUBLISHED.values()))
    assert np.max(difference) < 1.6
    assert np.median(difference) < 0.5
    assert np.max(difference[frequency < 150]) < 0.2


@pytest.mark.parametrize(("thickness", "quarter_wave"), [(0.1, 459.9), (0.056, 821.3)])
def test_frame_of_the_glass_wool_resonates_at_a_quarter_of_its_wavelength(thickness, quarter_wave):
    """sqrt(K/rho1) / 4 h of the frame alone; the air in it shifts what the impedance shows by 1 to 2 per cent."""
    assert allard_atalla_2009.frame_resonance(thickness) == pytest.approx(quarter_wave, rel=0.025)


def test_decoupling_frequency_of_the_soft_fibrous_layer():
    assert allard_atalla_2009.decoupling_frequency() == pytest.approx(127.4, abs=0.05)


def test_transmissibility_of_material_b_is_that_of_its_new_moduli_and_not_of_the_quasi_static_ones():
    found = bonfiglio_pompoli_2015.transmissibilities("B")
    (_, measured), (_, new), (_, static) = (found[name] for name in ("experimental", "new method", "QS values"))
    assert np.median(np.abs(new / measured - 1)) < 0.03
    assert np.median(np.abs(static / measured - 1)) > 0.5


@pytest.mark.parametrize("draw", [dazel_2013.double_wall, allard_atalla_2009.covered_foams])
def test_figures_are_drawn(draw):
    for axis in draw().axes:
        assert axis.lines
        assert all(np.all(np.isfinite(line.get_ydata())) for line in axis.lines)

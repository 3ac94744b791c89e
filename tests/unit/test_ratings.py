"""Single-number ratings against published examples, and laws they keep."""

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.response import ratings as rt

# ISO 717-1, annex C: the worked example of the standard, Rw (C; Ctr) = 30 (-2; -3) dB
ISO_717 = dict(zip(
    rt.THIRD_OCTAVES,
    (20.4, 16.3, 17.7, 22.6, 22.4, 22.7, 24.8, 26.6, 28.0, 30.5, 31.8, 32.5, 33.4, 33.0, 31.0, 25.5), strict=False,
))  # fmt: skip
# documented example of the package pyacoustics-stc: STC 29, limited by the 8 dB rule at 3150 Hz
STC = {
    125: 11.66, 160: 13.303, 200: 14.825, 250: 20.861, 315: 22.868, 400: 24.943, 500: 26.881, 630: 28.889, 800: 30.964,
    1000: 32.902, 1250: 34.84, 1600: 36.984, 2000: 38.923, 2500: 40.861, 3150: 27.557, 4000: 30.67,
}  # fmt: skip


def test_weighted_reduction_index_of_the_standard() -> None:
    found = rt.weighted_reduction_index(ISO_717)
    assert (found.rw, found.c, found.ctr) == (30, -2, -3)
    assert str(found) == "30 (-2; -3) dB"


def test_the_source_of_the_outdoor_indoor_class_is_that_of_the_standard() -> None:
    # without any insulation OITC is 0: all A-weighted levels add up to the 100.13 dB that the standard prints
    bands = [80, *rt.THIRD_OCTAVES[:17]]
    assert rt.outdoor_indoor_transmission_class(dict.fromkeys(bands, 0.0)) == 0
    assert rt.outdoor_indoor_transmission_class(dict.fromkeys(bands, 30.2)) == 30
    levels = np.array(rt.OITC_SOURCE) + np.array(rt.A_WEIGHTING)
    assert 10 * np.log10(np.sum(10 ** (levels / 10))) == pytest.approx(100.13, abs=0.005)


def test_terms_of_enlarged_ranges() -> None:
    bands = [50, 63, 80, *rt.THIRD_OCTAVES]
    # a spectrum is normalised to 0 dB: a flat insulation of 40 dB is 40 dB in every range
    flat = dict.fromkeys(bands, 40.0)
    rw = rt.weighted_reduction_index(flat).rw
    assert rt.enlarged_adaptation_terms(flat) == dict.fromkeys(("50-3150", "50-5000", "100-5000"), (40 - rw, 40 - rw))
    # a window that lets through the lowest bands: only ranges that begin at 50 Hz see it, the heavier the traffic
    leaky = flat | dict.fromkeys((50, 63, 80), 10.0)
    terms = rt.enlarged_adaptation_terms(leaky)
    assert terms["100-5000"] == (40 - rw, 40 - rw)
    assert terms["50-5000"][1] < terms["50-5000"][0] < 40 - rw
    assert rt.enlarged_adaptation_terms(dict.fromkeys(rt.THIRD_OCTAVES[:16], 40.0)) == {}


def test_nothing_is_rated_that_lets_no_sound_through() -> None:
    with pytest.raises(InputError, match="finite"):
        rt.weighted_reduction_index(ISO_717 | {500: np.inf})


def test_sound_transmission_class_of_a_published_example() -> None:
    assert rt.sound_transmission_class(STC) == 29


def test_a_contour_may_be_missed_by_two_decibels_everywhere() -> None:
    contour = 29 + np.array([-16, -13, -10, -7, -4, -1, 0, 1, 2, 3, 4, 4, 4, 4, 4, 4])
    exact = dict(zip(rt.THIRD_OCTAVES[1:17], contour, strict=True))
    assert rt.sound_transmission_class(exact) == 31  # 16 bands, 2 dB short each: 32 dB


@pytest.mark.parametrize("step", [-7, 1, 12])
def test_ratings_follow_a_shift(step: int) -> None:
    shifted = {band: value + step for band, value in ISO_717.items()}
    found, before = rt.weighted_reduction_index(shifted), rt.weighted_reduction_index(ISO_717)
    assert (found.rw, found.c, found.ctr) == (before.rw + step, before.c, before.ctr)
    stc = {band: round(value) + step for band, value in STC.items()}
    assert rt.sound_transmission_class(stc) == rt.sound_transmission_class(STC) + step


def test_the_eight_decibel_rule() -> None:
    flat = dict.fromkeys(rt.THIRD_OCTAVES[1:17], 60.0)
    dip = {**flat, 1000: 40.0}
    # the contour at 1000 Hz may lie 8 dB above the dip: 48 = STC + 3
    assert rt.sound_transmission_class(dip) == 45


def test_reference_curves_rate_as_themselves() -> None:
    curve = dict(zip(rt.THIRD_OCTAVES, rt.ISO717_THIRDS, strict=False))
    # 16 bands, sum 32: two decibels in each may be missing
    assert rt.weighted_reduction_index(curve).rw == 54
    assert rt.weighted_reduction_index_octaves({125: 36, 250: 45, 500: 52, 1000: 55, 2000: 56}) == 54


# ISO 11654, annex A: the two worked examples, practical coefficients from 250 to 4000 Hz
@pytest.mark.parametrize(
    ("practical", "said", "sound_class"),
    [((0.35, 0.70, 0.65, 0.60, 0.55), "0.60", "C"), ((0.35, 1.00, 0.65, 0.60, 0.55), "0.60 (M)", "C")],
)
def test_weighted_absorption_of_the_standard(practical: tuple, said: str, sound_class: str) -> None:
    found = rt.weighted_from_practical(dict(zip((250, 500, 1000, 2000, 4000), practical, strict=True)))
    assert (str(found), found.sound_class) == (said, sound_class)


def test_practical_coefficients_are_rounded_means() -> None:
    thirds = dict.fromkeys(rt.THIRD_OCTAVES, 0.62)
    thirds.update({400: 0.66, 500: 0.70, 630: 0.73, 3150: 1.1, 4000: 1.2, 5000: 1.15})
    practical = rt.practical_absorption(thirds)
    assert practical[500] == pytest.approx(0.70)
    assert practical[250] == pytest.approx(0.60)
    assert practical[4000] == 1.0
    assert rt.weighted_absorption(thirds).practical == practical


def test_weighted_absorption_from_octaves() -> None:
    # the practical coefficients of ISO 11654, annex A, before they were rounded
    means = {250: 0.37, 500: 1.02, 1000: 0.63, 2000: 0.58, 4000: 0.549}
    found = rt.weighted_absorption_octaves(means)
    assert (str(found), found.sound_class) == ("0.60 (M)", "C")
    assert found.practical == pytest.approx({250: 0.35, 500: 1.0, 1000: 0.65, 2000: 0.6, 4000: 0.55})
    assert rt.weighted_absorption_octaves({125: 0.1, **means}).practical[125] == pytest.approx(0.1)
    with pytest.raises(InputError, match="250 Hz"):
        rt.weighted_absorption_octaves({500: 1.0})


def test_full_and_no_absorption() -> None:
    full, none = (rt.weighted_absorption(dict.fromkeys(rt.THIRD_OCTAVES, value)) for value in (1.0, 0.0))
    assert (full.alpha_w, full.sound_class) == (1.0, "A")
    assert none.alpha_w <= 0.05
    assert none.sound_class == "unclassified"
    # a measurement may say that a sample gives off sound: it was rated as 1 once
    assert rt.weighted_absorption(dict.fromkeys(rt.THIRD_OCTAVES, -0.3)).alpha_w == 0.0


def test_nrc_and_saa() -> None:
    absorption = {band: 0.1 + 0.05 * i for i, band in enumerate(rt.THIRD_OCTAVES)}
    # 0.30, 0.45, 0.60, 0.75: mean 0.525, rounded up to 0.55 by C423's rule for the middle
    assert rt.noise_reduction_coefficient(absorption) == pytest.approx(0.55)
    assert rt.sound_absorption_average(absorption) == pytest.approx(0.1 + 0.05 * 8.5 + 0.005, abs=0.006)


def test_missing_bands_are_named() -> None:
    with pytest.raises(InputError, match="3150 Hz"):
        rt.weighted_reduction_index(dict.fromkeys(rt.THIRD_OCTAVES[:15], 30.0))


def test_weighted_impact_level() -> None:
    # ISO 717-2: the reference floor, whose weighted level the standard prints: 78 dB, CI -11 dB
    floor = dict(zip(
        rt.THIRD_OCTAVES, (67, 67.5, 68, 68.5, 69, 69.5, 70, 70.5, 71, 71.5, 72, 72, 72, 72, 72, 72), strict=False,
    ))  # fmt: skip
    found = rt.weighted_impact_level(floor)
    assert (found.ln_w, found.ci, found.ci_50) == (78, -11, None)
    assert str(found) == "78 (-11) dB"
    # the reference curve may be exceeded by 2 dB in each of its 16 bands
    curve = dict(zip(rt.THIRD_OCTAVES, rt._ISO717_2_THIRDS, strict=False))
    assert rt.weighted_impact_level(curve).ln_w == 58
    assert rt.weighted_impact_level({band: level + 2.1 for band, level in curve.items()}).ln_w == 61
    assert rt.weighted_impact_level_octaves(rt._ISO717_2_OCTAVES).ln_w == 58
    loud = floor | dict.fromkeys((50, 63, 80), 95.0)
    assert (rt.weighted_impact_level(loud).ci, rt.weighted_impact_level(loud).ci_50) == (-11, 7)
    with pytest.raises(InputError, match="100 Hz"):
        rt.weighted_impact_level({band: level for band, level in floor.items() if band != 100})

"""Single-number ratings of absorption and of airborne sound insulation.

All take values in third-octave (or octave) bands by nominal mid-band frequency, as a mapping ``{Hz: value}``; bands
that a rating does not use are ignored, a missing one is an error that names it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError

Bands = Mapping[float, float]

THIRD_OCTAVES = (100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150, 4000, 5000)
# ISO 717-1:2020, table 3: reference values for airborne sound, dB, from 100 and from 125 Hz
ISO717_THIRDS = (33, 36, 39, 42, 45, 48, 51, 52, 53, 54, 55, 56, 56, 56, 56, 56)
_ISO717_OCTAVES = dict(zip((125, 250, 500, 1000, 2000), (36, 45, 52, 55, 56), strict=True))
# ISO 717-1:2020, table 4: spectra for C (A-weighted pink noise) and Ctr (A-weighted urban traffic noise), dB
SPECTRA = {
    "C": (-29, -26, -23, -21, -19, -17, -15, -13, -12, -11, -10, -9, -9, -9, -9, -9),
    "Ctr": (-20, -20, -18, -16, -15, -14, -13, -12, -11, -9, -8, -9, -10, -11, -13, -15),
}
# ISO 717-1:2020, table B.1: spectra of enlarged ranges from 50 Hz, dB
_ENLARGED = (50, 63, 80, *THIRD_OCTAVES)
_C_TO_3150 = (-40, -36, -33, *SPECTRA["C"])
_C_TO_5000 = (
    -41, -37, -34, -30, -27, -24, -22, -20, -18, -16, -14, -13, -12, -11, -10, -10, -10, -10, -10, -10, -10,
)  # fmt: skip
_CTR = (-25, -23, -21, *SPECTRA["Ctr"], -16, -18)
_RANGES = {"50-3150": (_C_TO_3150, 0), "50-5000": (_C_TO_5000, 0), "100-5000": (_C_TO_5000, 3)}  # first band left out
# ISO 717-2:2020, table 3: reference values for impact sound, dB, from 100 and from 125 Hz
_ISO717_2_THIRDS = (62, 62, 62, 62, 62, 62, 61, 60, 59, 58, 57, 54, 51, 48, 45, 42)
_ISO717_2_OCTAVES = dict(zip((125, 250, 500, 1000, 2000), (67, 67, 65, 62, 49), strict=True))
# ASTM E1332: A-weighted levels of road, rail and air traffic, dB, 80 to 4000 Hz; all together 100.13 dB
OITC_BANDS = (80, *THIRD_OCTAVES[:17])
OITC_SOURCE = (103, 102, 101, 98, 97, 95, 94, 93, 93, 91, 90, 89, 89, 88, 88, 87, 85, 84)
A_WEIGHTING = (
    -22.5, -19.1, -16.1, -13.4, -10.9, -8.6, -6.6, -4.8, -3.2, -1.9, -0.8, 0.0, 0.6, 1.0, 1.2, 1.3, 1.2, 1.0,
)  # fmt: skip
# ASTM E413: the contour relative to its value at 500 Hz, from 125 to 4000 Hz
STC_CONTOUR = (-16, -13, -10, -7, -4, -1, 0, 1, 2, 3, 4, 4, 4, 4, 4, 4)
# ISO 11654:1997, table 1
PRACTICAL_OCTAVES = (125, 250, 500, 1000, 2000, 4000)
ABSORPTION_CURVE = {250: 0.80, 500: 1.00, 1000: 1.00, 2000: 1.00, 4000: 0.90}
_CURVE_TWENTIETHS = tuple(round(20 * value) for value in ABSORPTION_CURVE.values())
_THIRDS = {
    centre: THIRD_OCTAVES[first : first + 3]
    for centre in PRACTICAL_OCTAVES
    for first in (THIRD_OCTAVES.index(centre) - 1,)
}
_MARKS = {"L": (250,), "M": (500, 1000), "H": (2000, 4000)}
_CLASSES = (("A", 0.90), ("B", 0.80), ("C", 0.60), ("D", 0.30), ("E", 0.15))


@dataclass(frozen=True)
class ReductionIndex:
    """Weighted sound reduction index of ISO 717-1, dB, with its spectrum adaptation terms."""

    rw: int
    c: int
    ctr: int

    def __str__(self) -> str:
        return f"{self.rw} ({self.c}; {self.ctr}) dB"


@dataclass(frozen=True)
class ImpactLevel:
    """Weighted normalised impact sound level of ISO 717-2, dB, with its spectrum adaptation terms.

    Attributes
    ----------
    ln_w, ci : int
    ci_50 : int or None
        CI from 50 to 2500 Hz; None where bands below 100 Hz are missing.
    """

    ln_w: int
    ci: int
    ci_50: int | None = None

    def __str__(self) -> str:
        return f"{self.ln_w} ({self.ci}) dB"


@dataclass(frozen=True)
class WeightedAbsorption:
    """Weighted sound absorption coefficient of ISO 11654.

    Attributes
    ----------
    alpha_w : float
    indicators : str
        ``L``, ``M``, ``H`` where the practical coefficients exceed the shifted curve by 0.25 or more.
    sound_class : str
        ``A`` to ``E`` (annex B), or ``unclassified``.
    practical : mapping
        Practical coefficients by octave.
    """

    alpha_w: float
    indicators: str
    sound_class: str
    practical: dict[int, float]

    def __str__(self) -> str:
        return f"{self.alpha_w:.2f}" + (f" ({self.indicators})" if self.indicators else "")


def weighted_reduction_index(reduction: Bands) -> ReductionIndex:
    """Return Rw (C; Ctr) of ISO 717-1 from third-octave bands, 100 to 3150 Hz.

    Parameters
    ----------
    reduction : mapping
        Sound reduction index or transmission loss, dB, by nominal frequency, Hz; rounded to 0.1 dB first.

    Raises
    ------
    InputError
        When a band is missing.
    """
    bands = THIRD_OCTAVES[:16]
    values = np.floor(10 * _values(reduction, bands) + 0.5) / 10
    rw = 52 + _shift(values, np.array(ISO717_THIRDS), most=32.0)
    c, ctr = (_adapted(values, spectrum) - rw for spectrum in SPECTRA.values())
    return ReductionIndex(rw, c, ctr)


def _adapted(values: RealArray, spectrum: tuple[int, ...]) -> int:
    """Return the A-weighted difference of levels for a source's spectrum, in whole dB."""
    least, pairs = float(values.min()), zip(spectrum, values.tolist(), strict=True)
    transmitted = sum(10 ** ((level - (value - least)) / 10) for level, value in pairs)
    return math.floor(least - 10 * math.log10(transmitted) + 0.5)


def enlarged_adaptation_terms(reduction: Bands) -> dict[str, tuple[int, int]]:
    """Return C and Ctr of ISO 717-1 (annex B) by enlarged range, as ``50-5000``; of those that the bands allow.

    Parameters
    ----------
    reduction : mapping
        As of `weighted_reduction_index`, with the bands from 50 to 80 Hz, with 4000 and 5000 Hz, or with all of them.

    Raises
    ------
    InputError
        When a band from 100 to 3150 Hz is missing.
    """
    rw, there, terms = weighted_reduction_index(reduction).rw, set(map(float, reduction)), {}
    for name, (spectrum, first) in _RANGES.items():
        bands = _ENLARGED[first : len(spectrum)]
        if there.issuperset(bands):
            values = np.floor(10 * _values(reduction, bands) + 0.5) / 10
            c, ctr = (_adapted(values, each[first : len(spectrum)]) - rw for each in (spectrum, _CTR))
            terms[name] = c, ctr
    return terms


def outdoor_indoor_transmission_class(loss: Bands) -> int:
    """Return the OITC of ASTM E1332 from third-octave bands, 80 to 4000 Hz.

    Parameters
    ----------
    loss : mapping
        Transmission loss, dB, by nominal frequency, Hz; rounded to whole dB first.

    Raises
    ------
    InputError
        When a band is missing.
    """
    values = np.floor(_values(loss, OITC_BANDS) + 0.5)
    source = np.array(OITC_SOURCE) + np.array(A_WEIGHTING)
    return int(np.floor(100.13 - 10 * np.log10(np.sum(10 ** ((source - values) / 10))) + 0.5))


def weighted_reduction_index_octaves(reduction: Bands) -> int:
    """Return Rw of ISO 717-1 from octave bands, 125 to 2000 Hz, dB."""
    values = np.floor(10 * _values(reduction, tuple(_ISO717_OCTAVES)) + 0.5) / 10
    return 52 + _shift(values, np.array(list(_ISO717_OCTAVES.values())), most=10.0)


def weighted_impact_level(level: Bands) -> ImpactLevel:
    """Return Ln,w (CI) of ISO 717-2 from third-octave bands, 100 to 3150 Hz.

    Parameters
    ----------
    level : mapping
        Normalised impact sound level, dB, by nominal frequency, Hz; rounded to 0.1 dB first. With the bands of 50, 63
        and 80 Hz the term from 50 to 2500 Hz is given, too.

    Raises
    ------
    InputError
        When a band is missing.
    """
    values = np.floor(10 * _values(level, THIRD_OCTAVES[:16]) + 0.5) / 10
    ln_w = 60 - _shift(-values, -np.array(_ISO717_2_THIRDS), most=32.0)
    lower = _ENLARGED[:3]
    ci_50 = None
    if set(map(float, level)).issuperset(lower):
        ci_50 = _impact_term(np.append(values[:15], np.floor(10 * _values(level, lower) + 0.5) / 10), ln_w)
    return ImpactLevel(ln_w, _impact_term(values[:15], ln_w), ci_50)


def weighted_impact_level_octaves(level: Bands) -> ImpactLevel:
    """Return Ln,w (CI) of ISO 717-2 from octave bands, 125 to 2000 Hz, dB."""
    values = np.floor(10 * _values(level, tuple(_ISO717_2_OCTAVES)) + 0.5) / 10
    ln_w = 60 - _shift(-values, -np.array(list(_ISO717_2_OCTAVES.values())), most=10.0)  # 65 at 500 Hz, less 5 dB
    return ImpactLevel(ln_w, _impact_term(values, ln_w))


def _impact_term(values: RealArray, ln_w: int) -> int:
    """Return CI from the levels of all bands together."""
    return int(np.floor(10 * np.log10(np.sum(10 ** (values / 10))) - 15 - ln_w + 0.5))


def sound_transmission_class(loss: Bands) -> int:
    """Return the STC of ASTM E413 from third-octave bands, 125 to 4000 Hz.

    Parameters
    ----------
    loss : mapping
        Transmission loss, dB, by nominal frequency, Hz; rounded to whole dB first.
    """
    values = np.floor(_values(loss, THIRD_OCTAVES[1:17]) + 0.5)
    return _shift(values, np.array(STC_CONTOUR), most=32.0, most_single=8.0)


def _shift(values: RealArray, curve: RealArray, most: float, most_single: float = math.inf) -> int:
    """Return the largest whole shift of `curve` whose sum of deficiencies does not exceed `most`.

    Of the k bands whose gaps to the curve are smallest, k times the shift less these gaps: the sum is the largest of
    these numbers over k, so that each of them bounds the shift.
    """
    gaps: list[float] = sorted((values - curve).tolist())
    bounds = ((most + 1e-9 + total) / k for k, total in enumerate(accumulate(gaps), start=1))
    return math.floor(min(gaps[0] + most_single + 1e-9, *bounds))


def practical_absorption(absorption: Bands) -> dict[int, float]:
    """Return the practical coefficients of ISO 11654 by octave, 125 to 4000 Hz, from third octaves.

    Each is the mean of three third octaves, rounded to 0.05, at most 1. The octave of 125 Hz is left out where its
    bands are missing.
    """
    lowest = 0 if all(band in absorption for band in _THIRDS[125]) else 1
    octaves = PRACTICAL_OCTAVES[lowest:]
    thirds = _numbers(absorption, tuple(band for centre in octaves for band in _THIRDS[centre]))
    rounded = [math.floor(100 * value + 0.5 + 1e-9) / 100 for value in thirds]
    return {centre: _practical(sum(rounded[3 * i : 3 * i + 3]) / 3) for i, centre in enumerate(octaves)}


def _practical(mean: float) -> float:
    """Return the mean over an octave as a practical coefficient: in steps of 0.05, at most 1."""
    return min(_to_twentieths(mean), 1.0)


def _to_twentieths(value: float) -> float:
    """Round to 0.05, halves upwards; a value that is a half but for rounding errors counts as a half."""
    return math.floor(value / 0.05 + 0.5 + 1e-9) * 0.05


def weighted_absorption(absorption: Bands) -> WeightedAbsorption:
    """Return alpha_w of ISO 11654 with its shape indicators, from third-octave bands, 200 to 5000 Hz."""
    return weighted_from_practical(practical_absorption(absorption))


def weighted_absorption_octaves(absorption: Bands) -> WeightedAbsorption:
    """Return alpha_w of ISO 11654 from means over octaves, 250 to 4000 Hz, that become its practical coefficients."""
    there = [centre for centre in PRACTICAL_OCTAVES if centre != 125 or 125 in absorption]
    values = _numbers(absorption, tuple(there))
    return weighted_from_practical({centre: _practical(value) for centre, value in zip(there, values, strict=True)})


def weighted_from_practical(practical: Mapping[int, float]) -> WeightedAbsorption:
    """Return alpha_w of ISO 11654 from practical coefficients by octave, 250 to 4000 Hz."""
    # in steps of 0.05: whole numbers, no rounding
    twentieths = tuple(round(20 * value) for value in _numbers(practical, tuple(ABSORPTION_CURVE)))
    alpha, indicators, sound_class = _weighted(twentieths)
    return WeightedAbsorption(alpha, indicators, sound_class, {int(k): float(v) for k, v in practical.items()})


@lru_cache(maxsize=4096)
def _weighted(twentieths: tuple[int, ...]) -> tuple[float, str, str]:
    """Return alpha_w, shape indicators and class; thousands of cases of a sweep have the same few coefficients."""
    pairs = tuple(zip(_CURVE_TWENTIETHS, twentieths, strict=True))
    shorts = ((shift, sum(max(curve - shift - value, 0) for curve, value in pairs)) for shift in range(21))
    shift = next((shift for shift, short in shorts if short <= 2), 20)
    excess = {band: v - max(curve - shift, 0) for band, (curve, v) in zip(ABSORPTION_CURVE, pairs, strict=True)}
    indicators = "".join(mark for mark, bands in _MARKS.items() if any(excess[band] >= 5 for band in bands))
    alpha = (20 - shift) / 20
    sound_class = next((name for name, least in _CLASSES if alpha >= least - 1e-9), "unclassified")
    return alpha, indicators, sound_class


def noise_reduction_coefficient(absorption: Bands) -> float:
    """Return the NRC of ASTM C423: the mean at 250, 500, 1000 and 2000 Hz, rounded to 0.05."""
    return _to_twentieths(sum(_numbers(absorption, (250, 500, 1000, 2000))) / 4)


def sound_absorption_average(absorption: Bands) -> float:
    """Return the SAA of ASTM C423: the mean of the twelve third octaves from 200 to 2500 Hz, rounded to 0.01."""
    mean = float(np.mean(_values(absorption, THIRD_OCTAVES[3:15])))
    return float(np.floor(100 * mean + 0.5 + 1e-9) / 100)


def _values(given: Mapping[float, float] | Mapping[int, float], bands: tuple[int, ...]) -> RealArray:
    return np.array(_numbers(given, bands))


def _numbers(given: Mapping[float, float] | Mapping[int, float], bands: tuple[int, ...]) -> list[float]:
    missing = [f"{band} Hz" for band in bands if band not in given]
    if missing:
        raise InputError(f"this rating needs the bands {', '.join(missing)} as well")
    values = [float(given[band]) for band in bands]
    if not all(map(math.isfinite, values)):
        raise InputError("this rating needs finite values in all of its bands")
    return values

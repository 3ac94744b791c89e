"""Single-number ratings as real numbers: without the rounding and the whole steps that hide a slope from a search.

The standards shift a reference curve in steps of 1 dB or 0.05 until the sum of the deficiencies is as large as allowed.
Here the shift is a real number, and nothing is rounded. The sum falls with the shift and is convex in it, so that the
shift is the largest of a few linear functions of the values: continuous everywhere, with a slope that jumps where a
band begins to fall short. The ratings themselves are in `multilayer.response.ratings`.

All take values by nominal mid-band frequency, ``{Hz: array}``, the arrays over samples.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from multilayer.arrays import RealArray
from multilayer.response.ratings import (
    A_WEIGHTING,
    ABSORPTION_CURVE,
    ISO717_THIRDS,
    OITC_BANDS,
    OITC_SOURCE,
    SPECTRA,
    STC_CONTOUR,
    THIRD_OCTAVES,
)

Bands = Mapping[float, RealArray]


def _shift(gaps: RealArray, most: float) -> RealArray:
    """Return the shift s, over the samples, at which the sum of ``max(gap - s, 0)`` over the bands is `most`.

    With the gaps in falling order, the sum of the first k less k s is never above the sum, and equals it where k bands
    fall short: s is the largest of (sum of the first k - most)/k.
    """
    sums = np.cumsum(-np.sort(-gaps, axis=0), axis=0)
    counts = np.arange(1, len(gaps) + 1).reshape(-1, *(1,) * (gaps.ndim - 1))
    return np.asarray(np.max((sums - most) / counts, axis=0))


def _rows(bands: Bands, centres: tuple[float, ...]) -> RealArray:
    return np.stack([np.asarray(bands[float(centre)]) for centre in centres])


def _column(curve: tuple[float, ...], values: RealArray) -> RealArray:
    return np.reshape(curve, (-1, *(1,) * (values.ndim - 1)))


def real_reduction_index(reduction: Bands) -> RealArray:
    """Return Rw of ISO 717-1 with a real shift, dB, from third octaves, 100 to 3150 Hz: up to 1 dB above Rw."""
    values = _rows(reduction, THIRD_OCTAVES[:16])
    return np.asarray(52 - _shift(_column(ISO717_THIRDS, values) - values, 32.0))


def real_adapted_index(reduction: Bands, spectrum: str) -> RealArray:
    """Return Rw + C or Rw + Ctr of ISO 717-1 without rounding, dB: the difference of A-weighted levels.

    Parameters
    ----------
    reduction : mapping
        Third octaves, 100 to 3150 Hz, dB.
    spectrum : {'C', 'Ctr'}
    """
    values = _rows(reduction, THIRD_OCTAVES[:16])
    return np.asarray(-10 * np.log10(np.sum(10 ** ((_column(SPECTRA[spectrum], values) - values) / 10), axis=0)))


def real_transmission_class(loss: Bands) -> RealArray:
    """Return the STC of ASTM E413 with a real shift, dB, from third octaves, 125 to 4000 Hz."""
    values = _rows(loss, THIRD_OCTAVES[1:17])
    gaps = _column(STC_CONTOUR, values) - values
    return np.asarray(-np.maximum(_shift(gaps, 32.0), np.max(gaps, axis=0) - 8.0))


def real_outdoor_indoor_class(loss: Bands) -> RealArray:
    """Return the OITC of ASTM E1332 without rounding, dB, from third octaves, 80 to 4000 Hz."""
    values = _rows(loss, OITC_BANDS)
    source = _column(tuple(np.add(OITC_SOURCE, A_WEIGHTING)), values)
    return np.asarray(100.13 - 10 * np.log10(np.sum(10 ** ((source - values) / 10), axis=0)))


def real_weighted_absorption(absorption: Bands) -> RealArray:
    """Return alpha_w of ISO 11654 with a real shift, from third octaves, 200 to 5000 Hz.

    Where all bands exceed the curve by far it passes 1, so that better and best can still be told apart.
    """
    return real_weighted_absorption_octaves(octaves_of(absorption))


def real_weighted_absorption_octaves(absorption: Bands) -> RealArray:
    """Return alpha_w of ISO 11654 with a real shift, from means over octaves, 250 to 4000 Hz."""
    values = np.minimum(_rows(absorption, tuple(ABSORPTION_CURVE)), 1.0)
    return np.asarray(1 - _shift(_column(tuple(ABSORPTION_CURVE.values()), values) - values, 0.1))


def octaves_of(absorption: Bands) -> dict[float, RealArray]:
    """Return means over octaves, 250 to 4000 Hz, from third octaves, 200 to 5000 Hz."""
    means = {}
    for centre in ABSORPTION_CURVE:
        i = THIRD_OCTAVES.index(centre)
        means[float(centre)] = np.mean(_rows(absorption, THIRD_OCTAVES[i - 1 : i + 2]), axis=0)
    return means


def real_noise_reduction(absorption: Bands) -> RealArray:
    """Return the NRC of ASTM C423 without rounding: the mean at 250, 500, 1000 and 2000 Hz."""
    return np.asarray(np.mean(_rows(absorption, (250, 500, 1000, 2000)), axis=0))


def real_absorption_average(absorption: Bands) -> RealArray:
    """Return the SAA of ASTM C423 without rounding: the mean of the third octaves from 200 to 2500 Hz."""
    return np.asarray(np.mean(_rows(absorption, THIRD_OCTAVES[3:15]), axis=0))

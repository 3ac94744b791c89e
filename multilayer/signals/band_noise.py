"""Whether there is as much noise within a burst's band as if all noise of its record were white."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from multilayer.chi2 import exceeding
from multilayer.signals.recording import Recording
from multilayer.signals.repeats import lobe_spectra
from multilayer.signals.spectra import noise_level

_BAND = 0.1  # of the base's crest: what lies below in the main lobe hardly counts in a fit
_TERMS = 3  # of a polynomial in frequency: what a drift of sample or source changes between repeats
_DRIFTS = 4.0  # power of each of these terms, over that of each bin left: the repeats differ by more than noise
_FEWEST = 2  # bins left beyond these
_SIGNIFICANT = 1e-4  # of all bursts together
_FACTOR = 2.0  # in power
_SHARE = 0.25  # of the bursts


@dataclass(frozen=True)
class BandNoise:
    """Power of the noise of top over base within a burst's band, over that of white noise.

    Attributes
    ----------
    frequency : float
        Of the burst, Hz.
    factor : float
    p_value : float
        Probability that white noise departs as far to this side.
    """

    frequency: float
    factor: float
    p_value: float


def band_noise(recording: Recording, frequency: float, cycles: float) -> BandNoise | None:
    """Return how noisy a burst's band is, against `noise_level`; None where the repeats do not tell.

    In terms of spectra over the bins of the band: the scatter of ``T_i - M B_i``, M the ratio of the means, less what a
    smooth change of M from repeat to repeat makes; where that is most of it, the repeats tell nothing of noise. What
    base and top have in common, as a level that differs, drops out.

    Parameters
    ----------
    recording : Recording
    frequency : float
        Of the burst, Hz.
    cycles : float
        Of the burst, under its Hann window.
    """
    noise, n, repeats = noise_level(recording), recording.n_samples, recording.n_repeats
    if repeats < 2 or not (noise.base > 0 and noise.top > 0):
        return None
    base, top = lobe_spectra(recording, frequency, cycles)
    mean = np.abs(base.mean(axis=0))
    inside = mean > _BAND * mean.max(initial=0.0)
    base, top = base[:, inside], top[:, inside]
    left = int(inside.sum()) - _TERMS
    if left < _FEWEST:
        return None
    response = top.mean(axis=0) / base.mean(axis=0)
    scale = 1 / np.sqrt(n * (noise.top**2 + np.abs(response) ** 2 * noise.base**2))
    scatter = (top - response * base) * scale
    smooth = np.vander(np.linspace(-1, 1, inside.sum()), _TERMS) * (top.mean(axis=0) * scale)[:, None]
    basis, _ = np.linalg.qr(smooth)
    of_drift = scatter @ basis.conj()
    rest = scatter - of_drift @ basis.T
    degrees = 2 * left * (repeats - 1)
    chi_square = 2 * float(np.sum(np.abs(rest) ** 2))
    if np.sum(np.abs(of_drift) ** 2) / _TERMS > _DRIFTS * np.sum(np.abs(rest) ** 2) / left:
        return None
    above = exceeding(chi_square, degrees)
    return BandNoise(frequency, chi_square / degrees, above if chi_square > degrees else 1 - above)


def noise_in_words(recordings: Mapping[str, tuple[float, Recording]], cycles: float) -> list[str]:
    """Return `in_words` of recordings; parameters as of `repeats.repeats_in_words`."""
    return in_words({name: band_noise(recording, f, cycles) for name, (f, recording) in recordings.items()})


def in_words(noises: Mapping[str, BandNoise | None]) -> list[str]:
    """Return a sentence where noise is not white: in more than a quarter of the bursts, significantly and by a factor.

    Parameters
    ----------
    noises : mapping
        Of each recording, by a name for it.
    """
    known = [noise for noise in noises.values() if noise is not None]
    off = [
        noise
        for noise in known
        if noise.p_value < _SIGNIFICANT / len(known) and not 1 / _FACTOR <= noise.factor <= _FACTOR
    ]
    if len(off) <= _SHARE * len(noises):
        return []
    least, most = min(off, key=lambda noise: noise.factor), max(off, key=lambda noise: noise.factor)
    ends = [most, least] if least.factor < 1 < most.factor else [most if most.factor > 1 else least]
    told = " and ".join(f"{noise.factor:.2g} times (at {noise.frequency:g} Hz)" for noise in ends)
    return [
        f"noise is not white: within the bands of bursts its power is {told} what it would be if all noise of a record "
        f"were white, in {len(off)} of {len(known)} recordings; standard deviations are off by up to the root of that, "
        f"and the p-values of joint fits and diagnoses with them; {_QUIETER if most.factor > 1 else _ELSEWHERE}"
    ]


_QUIETER = (
    "use a quieter amplifier, look for vibrations and hum, or resample to a lower rate: a filter alone leaves as much "
    "noise in the bands"
)
_ELSEWHERE = "let repeats be alike in level and time, and filter off the noise beside the bursts"

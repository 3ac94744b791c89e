"""One burst as an inverse problem: unknowns (ln E1, loss factor), data in the band of the burst.

After P. Bonfiglio & F. Pompoli, Polymer Testing 48 (2015) 89-96, whose equations are cited by number. The causal law of
constant loss factor: E. Kjartansson, J. Geophys. Res. 84 (1979) 4737-4748.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ArrayLike, BoolArray, ComplexArray, RealArray
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.inference.derivative import FINE, forward
from multilayer.signals.envelope import envelope
from multilayer.signals.spectra import Noise, band, frequencies, padded_length, to_signal, to_spectrum
from multilayer.signals.time_of_flight import time_of_flight

_BAND_THRESHOLD = 0.02  # of the burst's largest bin
_WIDE_THRESHOLD = 0.002  # for signals that are transformed back to time
_CUT_SHORT = 0.02  # of the envelope's maximum: a ring-down still this strong at the end of the record is truncated
_MOVES = 0.01  # of the base's crest: by then its burst has begun,
_ABOVE_NOISE = 5.0  # and above its noise
_BURIED = 1e9  # times below that, a signal weighs nothing
_FEWEST = 16  # samples that say whether something moves
STRETCH_POWERS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)
"""Of the amplitude of the sample's stretch, whose means are kept."""
_STICKS = 0.02  # of the largest velocity
_STRETCH_REACH = (0.4, 1.8)  # of a burst's frequency: beyond it and the main lobe lie noise and harmonics
_MOST_BINS = 32  # a burst of ten cycles has about ten independent bins
_LOCAL = 0.2  # of a burst's frequency: half the main lobe of ten cycles, within which a local law holds
_PERIODS = 20  # of a burst's frequency in a transform: eight bins within reach of the local law


@dataclass(frozen=True)
class BurstData:
    """The measured signals of one burst, averaged over the repeats and calibrated.

    Attributes
    ----------
    configuration : str
    frequency : float
        Stated centre frequency, Hz.
    sampling_rate : float
        Hz.
    base, top : array, shape (n_samples,)
        Accelerations, m/s2.
    noise : Noise
        Standard deviations of the averaged channels' noise, m/s2.
    cycles : float
        Periods of the burst under its Hann window: its spectrum's main lobe is 4/cycles wide, relative to the
        frequency.
    calibration_std : float
        Standard deviation of the calibration by which the top channel was corrected: of its ratio, relative, and of its
        phase, rad.
    """

    configuration: str
    frequency: float
    sampling_rate: float
    base: RealArray
    top: RealArray
    noise: Noise
    cycles: float = 10.0
    calibration_std: float = 0.0

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return len(self.base)

    @cached_property
    def n_fft(self) -> int:
        """Transform length: twice the record, so that the ring-down does not wrap; four times a truncated record.

        At least twenty periods, for enough bins within the band of the local law.
        """
        periods = int(np.ceil(_PERIODS * self.sampling_rate / self.frequency))
        return padded_length(max((4 if self.cut_short else 2) * self.n_samples, periods), 1)

    @cached_property
    def spectra(self) -> tuple[RealArray, ComplexArray, ComplexArray]:
        """Frequencies (Hz) and spectra of base and top over all bins from 0 to half the sampling rate."""
        n = self.n_fft
        return frequencies(n, self.sampling_rate), to_spectrum(self.base, n), to_spectrum(self.top, n)

    @cached_property
    def cut_short(self) -> bool:
        """Whether the record ends before the top plate's ring-down does."""
        tail = self.envelope[-max(self.n_samples // 50, 1) :]
        return bool(tail.mean() > max(_CUT_SHORT * self.envelope.max(), 5 * self.noise.top))

    @cached_property
    def stride(self) -> int:
        """Stride between the bins that are used of the `local` band."""
        return _stride(self._within_local_law)

    @cached_property
    def _main_lobe(self) -> BoolArray:
        f, base, _ = self.spectra
        inside = np.abs(f - self.frequency) <= 2 / self.cycles * self.frequency
        return np.asarray(band(base, _BAND_THRESHOLD) & inside & (f > 0))

    @cached_property
    def _within_local_law(self) -> BoolArray:
        f, _, _ = self.spectra
        return np.asarray(self._main_lobe & (np.abs(f - self.frequency) <= _LOCAL * self.frequency))

    @cached_property
    def in_band(self) -> tuple[RealArray, ComplexArray, ComplexArray]:
        """Frequencies and spectra in the band where the burst has energy, thinned to at most 32 bins."""
        return self._thinned(self._main_lobe)

    @cached_property
    def local(self) -> tuple[RealArray, ComplexArray, ComplexArray]:
        """Frequencies and spectra in the band where one modulus with its local law holds: within 20 % of the frequency.

        The band of a burst of few cycles is wider, and a loss factor that varies with frequency would bias the fit. Of
        ten cycles and more it is the whole band.
        """
        return self._thinned(self._within_local_law)

    def _thinned(self, bins: BoolArray) -> tuple[RealArray, ComplexArray, ComplexArray]:
        f, base, top = self.spectra
        kept = np.flatnonzero(bins)[:: _stride(bins)]
        return f[kept], base[kept], top[kept]

    @cached_property
    def time_of_flight(self) -> float:
        """Measured time of flight, with sub-sample resolution, s."""
        return float(time_of_flight(self.base, self.top, self.sampling_rate))

    @cached_property
    def envelope(self) -> RealArray:
        """Measured envelope of the top plate, m/s2."""
        return envelope(self.top)

    @cached_property
    def stretch_moments(self) -> ComplexArray:
        """Means of powers of the stretch's amplitude |x|, x in m, as they act on each bin of `in_band`.

        Spectra of |x|^k x over that of x, k of `STRETCH_POWERS`, where x(t) is the analytic signal of the motion of top
        relative to base. Real and constant for a steady tone; in a burst the amplitude varies, and with it the moments
        by bin. Shape (k, n).
        """
        spectrum = self._stretch_spectrum
        stretch = np.fft.ifft(spectrum)
        signals = np.abs(stretch) ** np.array(STRETCH_POWERS)[:, np.newaxis] * stretch
        return np.asarray(np.fft.fft(signals, axis=-1)[:, self._bins] / spectrum[self._bins])

    @cached_property
    def friction(self) -> ComplexArray:
        """Dry friction of 1 N between base and top plate over the stretch, in each bin of `in_band`, 1/m.

        Against the relative velocity, whose analytic signal is v(t), to first order of its harmonics: ``4/pi v/|v|``,
        with ``sqrt(|v|^2 + m^2)`` in place of ``|v|``, m a share of its maximum: before something slides it sticks, and
        noise does not slide. In the main lobe the force is right to 2 % of what it is in its centre; towards the edges
        of the lobe what happens while it sticks matters as much. Shape (n,).
        """
        turn = 2j * np.pi * np.fft.fftfreq(self.n_fft, 1 / self.sampling_rate)
        spectrum = self._stretch_spectrum
        apart = np.fft.ifft(turn**2 * spectrum)  # acceleration of the plates from each other
        low, high = _STRETCH_REACH
        nyquist = self.sampling_rate / 2
        share = (min(high * self.frequency, nyquist) - low * self.frequency) / nyquist  # of the noise
        noise = float(np.hypot(*self.noise)) * share**0.5
        velocity = np.fft.ifft(turn * np.fft.fft(_above_noise(np.abs(apart), noise) * np.fft.ifft(spectrum)))
        amplitude = np.abs(velocity)
        force = 4 / np.pi * velocity / np.hypot(amplitude, _STICKS * amplitude.max())
        return np.asarray(np.fft.fft(force)[self._bins] / spectrum[self._bins])

    @property
    def _stretch_spectrum(self) -> ComplexArray:
        """Spectrum of the analytic signal of the motion of top relative to base, m, shape (n_fft,)."""
        f, base, top = self.spectra
        low, high = _STRETCH_REACH
        near = self._main_lobe | ((f > low * self.frequency) & (f < high * self.frequency))
        one_sided = np.zeros(self.n_fft, dtype=complex)
        one_sided[: len(f)][near] = 2 * (top - base)[near] / (2 * np.pi * f[near]) ** 2
        return one_sided

    @property
    def _bins(self) -> NDArray[np.intp]:
        """Indices of `in_band` among those of `spectra`."""
        return np.searchsorted(self.spectra[0], self.in_band[0])

    @cached_property
    def top_slopes(self) -> ComplexArray:
        """First and second derivative by ln f of ln S, S the top channel's spectrum, in each bin of `in_band`.

        From the means of t and t^2 over the energy of a bin, t the time in the record: the spectrum of t times the
        signal is ``i dS/dw``. Where all energy of a bin arrives at one time, the first is ``-i w t``. Shape (2, n).
        """
        omega = 2 * np.pi * self.in_band[0]
        time = np.arange(self.n_samples) / self.sampling_rate
        top = _above_noise(self.envelope, self.noise.top) * self.top
        whole, first, second = (to_spectrum(time**k * top, self.n_fft)[self._bins] for k in range(3))
        mean, square = first / whole, second / whole
        slope = -1j * omega * mean
        return np.stack([slope, slope - omega**2 * (square - mean**2)])

    @cached_property
    def head_start(self) -> float:
        """Amplitude of the top plate before the base moves, less noise, relative to its maximum; 0 without a lead."""
        base = envelope(self.base)
        share = min(max(_MOVES, _ABOVE_NOISE * self.noise.base / float(base.max())), 1.0)
        # a Hann window has taken this long when it reaches the share
        rise = self.cycles / self.frequency * float(np.arcsin(share**0.5)) / np.pi * self.sampling_rate
        lead = self.top[: max(int(np.argmax(base >= share * base.max()) - rise), 0)]
        if lead.size < _FEWEST:
            return 0.0
        power = float(np.mean(lead**2)) - self.noise.top**2 * (1 + _ABOVE_NOISE * (2 / lead.size) ** 0.5)
        return float(np.sqrt(2 * max(power, 0.0)) / np.abs(self.top).max())

    @cached_property
    def transmissibility(self) -> complex:
        """Measured top over base at the stated frequency, by least squares over a narrow band about it."""
        f, base, top = self.spectra
        near = np.abs(f - self.frequency) <= 0.5 * self.frequency / self.cycles
        ratio = np.vdot(base[near], top[near]) / np.vdot(base[near], base[near])
        return complex(ratio)


def _above_noise(amplitude: RealArray, noise: float) -> RealArray:
    """Return the weight of each instant: 1 where a signal is well above its noise, 1/2 at 5 standard deviations.

    What is computed of the signal alone and fitted to its ratio would otherwise carry the noise of that ratio, and take
    it up: in long records, where most is noise, a skew of the clocks did so. Noise alone weighs 0.001.
    """
    inverse = _ABOVE_NOISE * noise / np.maximum(amplitude, np.finfo(float).tiny)
    return np.asarray(1 / (1 + np.minimum(inverse, _BURIED) ** 8))


def _stride(bins: BoolArray) -> int:
    return int(-(-np.count_nonzero(bins) // _MOST_BINS))


@dataclass(frozen=True)
class BurstProblem:
    """Measured burst and model; unknowns ``x = (ln E1, E2/E1)`` at the burst's frequency.

    Attributes
    ----------
    data : BurstData
    rig : Rig
        A model of the rig.
    dispersive : bool
        Whether the modulus follows ``E (f/fc)^n``, ``n = (2/pi) atan(E2/E1)``, within the band: the causal law of
        constant loss factor, (i w)^n, which one complex number determines. Its slope is that of eq. (12) for small
        losses. Otherwise the modulus is constant within the band, as in the paper.
    bend : float
        Second derivative of ln E by ln f in the band, which one burst does not determine, see `modulus`.
    """

    data: BurstData
    rig: Rig
    dispersive: bool = True
    bend: float = 0.0

    def modulus(self, x: ArrayLike, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, shape (..., n_frequency), of unknowns of shape (..., 2).

        A causal modulus is a function of i f, real for real arguments: with ``u = ln(f/fc)``, the next term of ``ln E``
        after ``n (u + i pi/2)`` is ``g (u + i pi/2)^2 / 2``, g the bend: the loss angle has the slope g pi/2.
        """
        unknowns = np.asarray(x, dtype=float)[..., None, :]
        centre = np.exp(unknowns[..., 0]) * (1 + 1j * unknowns[..., 1])
        if not self.dispersive:
            return np.asarray(centre + 0j * frequency)
        exponent = 2 / np.pi * np.arctan(unknowns[..., 1])
        relative = frequency / self.data.frequency
        bent = np.asarray(centre * relative**exponent)
        if self.bend:
            u = np.log(relative)
            bent = bent * np.exp(self.bend * (u**2 / 2 + 0.5j * np.pi * u))
        return bent

    def predict(self, x: ArrayLike) -> ComplexArray:
        """Return the modelled spectrum of the top plate in the `local` band, shape (..., n_bins).

        Where the record ends before the ring-down, the model is truncated at the same time as the measurement.
        """
        if self.data.cut_short:
            return self._predict_cut_short(x)
        f, base, _ = self.data.local
        return self.rig.transmissibility(f, self.modulus(x, f)) * base

    def _predict_cut_short(self, x: ArrayLike) -> ComplexArray:
        data = self.data
        f, base, _ = data.spectra
        wide = np.flatnonzero(band(base, _WIDE_THRESHOLD) & self._within_reach(f))
        kept = np.searchsorted(f, data.local[0])
        ratio = self.rig.transmissibility(f[wide], self.modulus(x, f[wide]))
        spectrum = np.zeros((*ratio.shape[:-1], len(f)), dtype=complex)
        spectrum[..., wide] = ratio * base[wide]
        return to_spectrum(to_signal(spectrum, data.n_fft, data.n_samples), data.n_fft)[..., kept]

    @cached_property
    def scale(self) -> float:
        """Norm of the measured spectrum in the band: residuals are relative to it."""
        return float(np.linalg.norm(self.data.local[2]))

    def as_real(self, spectrum: ComplexArray) -> RealArray:
        """Return complex spectra over the measured norm as real vectors, shape (..., 2 n_bins)."""
        return np.concatenate([spectrum.real, spectrum.imag], axis=-1) / self.scale

    def residual(self, x: ArrayLike) -> RealArray:
        """Return modelled minus measured, relative, shape (..., 2 n_bins).

        Its norm is the distance of the two analytic signals over the burst (Parseval's theorem): it contains both the
        envelope and the time of flight, and is smooth in the unknowns, unlike eq. (9).
        """
        return self.as_real(self.predict(x) - self.data.local[2])

    def misfit(self, x: ArrayLike) -> RealArray:
        """Return the norm of the residual, shape (...)."""
        return np.asarray(np.linalg.norm(self.residual(x), axis=-1))

    def jacobian(self, x: ArrayLike) -> RealArray:
        """Return the derivative of the residual by the unknowns, shape (2 n_bins, 2), in one model evaluation."""
        return self.residual_and_jacobian(x)[1]

    def residual_and_jacobian(self, x: ArrayLike) -> tuple[RealArray, RealArray]:
        """Return the residual and its derivative, shapes (2 n_bins,) and (2 n_bins, 2)."""
        return forward(self.residual, np.asarray(x, dtype=float), FINE)

    def signal(self, x: ArrayLike) -> RealArray:
        """Return the modelled acceleration of the top plate, shape (n_samples,), from all bins up to Fs/2.

        Step 1 of the paper's inversion: spectrum of the base times transmissibility, back to time. Beyond the reach
        of the rig's model the burst has next to no energy, and the plate is taken to move as the base does.
        """
        f, base, _ = self.data.spectra
        inside = self._within_reach(f)
        ratio = np.ones(len(f), dtype=complex)  # at 0 Hz base and plate move alike
        ratio[inside] = self.rig.transmissibility(f[inside], self.modulus(x, f[inside]))
        return to_signal(ratio * base, self.data.n_fft, self.data.n_samples)

    def _within_reach(self, frequency: RealArray) -> BoolArray:
        low, high = self.rig.reach
        relative = frequency / self.data.frequency
        return np.asarray((frequency > 0) & (relative >= low) & (relative <= high))

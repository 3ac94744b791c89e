"""Impedance tubes: from pressures at microphones to reflection and transmission; ISO 10534-2 and ASTM E2611.

Time exp(+i w t). The incident wave is exp(-i k x): x rises from the source to the sample, whose front face is x = 0.
With losses along the tube k has a negative imaginary part. All arrays broadcast over frequency.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, Numeric, RealArray
from multilayer.media.gas import Gas

_ISO_ATTENUATION = 1.94e-2  # s^(-1/2) m: ISO 10534-2:1998, eq. (A.17), k0'' = 1.94e-2 sqrt(f) / (c d)
_CIRCULAR, _RECTANGULAR = 0.58, 0.50  # of c/d: ISO 10534-2, 4.2, below the first mode across
_WIDEST, _NARROWEST = 0.45, 0.05  # of a wavelength: ISO 10534-2, 4.2, spacing of the microphones
_E2611_WIDEST, _E2611_NARROWEST = 0.40, 0.01  # the same in ASTM E2611


def iso_attenuation(frequency: ArrayLike, sound_speed: float, diameter: float) -> RealArray:
    """Return the attenuation of plane waves in a tube, Np/m: ISO 10534-2, eq. (A.17).

    Parameters
    ----------
    frequency : array
        Hz.
    sound_speed : float
        m/s.
    diameter : float
        m; of a rectangular tube four times its area over its perimeter.
    """
    return np.asarray(_ISO_ATTENUATION * np.sqrt(np.asarray(frequency, dtype=float)) / (sound_speed * diameter))


def kirchhoff_attenuation(frequency: ArrayLike, gas: Gas, diameter: float) -> RealArray:
    """Return the attenuation by viscosity and heat conduction at the wall of a wide tube, Np/m.

    ``sqrt(w nu / 2) (1 + (gamma - 1) / sqrt(Pr)) / (c a)``, for boundary layers far thinner than the radius a:
    G. Kirchhoff, Ann. Phys. Chem. 134 (1868) 177-193.
    """
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)
    thermal = 1 + (gas.heat_capacity_ratio - 1) / np.sqrt(gas.prandtl)
    layer = np.sqrt(0.5 * omega * gas.viscosity / gas.density)
    return np.asarray(layer * thermal / (gas.sound_speed * 0.5 * diameter))


class Range(NamedTuple):
    """Working range of a tube, Hz."""

    low: float
    high: float


def cut_off(sound_speed: float, width: float, *, rectangular: bool = False) -> float:
    """Return up to which frequency only plane waves run in a tube, Hz: ISO 10534-2, 4.2.

    Parameters
    ----------
    sound_speed : float
        m/s.
    width : float
        Diameter, or the longer side, m.
    rectangular : bool
    """
    return (_RECTANGULAR if rectangular else _CIRCULAR) * sound_speed / width


def spacing_range(sound_speed: float, spacing: float, *, e2611: bool = False) -> Range:
    """Return between which frequencies, Hz, two microphones at a distance (m) tell incident from reflected wave.

    ISO 10534-2, 4.2: the spacing is 5 % to 45 % of a wavelength; ASTM E2611: 1 % to 40 %. At half a wavelength both
    microphones carry the same information.
    """
    narrowest, widest = (_E2611_NARROWEST, _E2611_WIDEST) if e2611 else (_NARROWEST, _WIDEST)
    return Range(narrowest * sound_speed / spacing, widest * sound_speed / spacing)


def switched_calibration(straight: ArrayLike, exchanged: ArrayLike) -> ComplexArray:
    """Return the calibration factor of two microphone channels: ISO 10534-2, 7.5.2.

    With the microphones at their places the transfer function is ``Hc H12``, exchanged ``Hc / H12``: the product is
    ``Hc^2``. Of its roots the one with a phase within 90 degrees is taken.

    Parameters
    ----------
    straight, exchanged : complex array
        Transfer functions from channel 1 to channel 2, before and after the microphones changed places.
    """
    return np.asarray(np.sqrt(np.asarray(straight, dtype=complex) * np.asarray(exchanged, dtype=complex)))


def transfer_function(reflection: Numeric, wavenumber: Numeric, near: float, far: float) -> ComplexArray:
    """Return the pressure at a distance `near` of the sample over that at `far`; ISO 10534-2, annex D.

    Parameters
    ----------
    reflection : complex array
        Of the sample's face.
    wavenumber : array
        rad/m.
    near, far : float
        Distances of the microphones from the face, m.
    """
    pressures = [np.exp(1j * wavenumber * x) + reflection * np.exp(-1j * wavenumber * x) for x in (near, far)]
    return np.asarray(pressures[0] / pressures[1])


def reflection_coefficient(h12: Numeric, wavenumber: Numeric, spacing: float, far: float) -> ComplexArray:
    """Return the reflection coefficient of a sample from two microphones: ISO 10534-2, eq. (17).

    Parameters
    ----------
    h12 : complex array
        Pressure at the nearer microphone (2) over that at the farther one (1), calibrated.
    wavenumber : array
        rad/m; complex with attenuation.
    spacing : float
        Between the microphones, m.
    far : float
        Distance of microphone 1 from the sample's face, m.
    """
    turn = np.exp(1j * wavenumber * spacing)
    return np.asarray((h12 - 1 / turn) / (turn - h12) * np.exp(2j * wavenumber * far))


def normalised_impedance(reflection: Numeric) -> ComplexArray:
    """Return Z / (rho c) of a reflection coefficient; infinite at a rigid face."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((1 + reflection) / (1 - np.asarray(reflection, dtype=complex)))


class FaceState(NamedTuple):
    """Pressure, Pa, and velocity, m/s, at both faces of a sample; all relative to one common reference."""

    p_front: ComplexArray
    v_front: ComplexArray
    p_back: ComplexArray
    v_back: ComplexArray


def face_state(
    pressures: tuple[Numeric, Numeric, Numeric, Numeric],
    positions: tuple[float, float, float, float],
    wavenumber: Numeric,
    impedance: float,
    thickness: float,
) -> FaceState:
    """Return pressure and velocity at the faces of a sample between four microphones: ASTM E2611.

    Parameters
    ----------
    pressures : tuple of complex array
        At two microphones ahead of the sample and two behind it, relative to any common reference.
    positions : tuple of float
        Of the microphones, m, from the front face, rising: those ahead of the sample are negative.
    wavenumber : array
        rad/m.
    impedance : float
        rho c of the gas, Pa s/m.
    thickness : float
        Of the sample, m.
    """
    front = _at(pressures[:2], positions[:2], wavenumber, impedance, 0.0)
    back = _at(pressures[2:], positions[2:], wavenumber, impedance, thickness)
    return FaceState(*front, *back)


def _at(
    pressures: tuple[Numeric, ...], positions: tuple[float, ...], k: Numeric, impedance: float, x: float
) -> tuple[ComplexArray, ComplexArray]:
    """Return pressure and velocity at x from two microphones, whose plane waves interpolate the field."""
    (p1, p2), (x1, x2) = pressures, positions
    sine = np.sin(k * (x2 - x1))
    pressure = (p1 * np.sin(k * (x2 - x)) + p2 * np.sin(k * (x - x1))) / sine
    velocity = 1j * (p2 * np.cos(k * (x - x1)) - p1 * np.cos(k * (x2 - x))) / (sine * impedance)
    return np.asarray(pressure), np.asarray(velocity)


class TransferMatrix(NamedTuple):
    """``[p, v] front = [[t11, t12], [t21, t22]] [p, v] back``: pure number, Pa s/m, m/(Pa s), pure number."""

    t11: ComplexArray
    t12: ComplexArray
    t21: ComplexArray
    t22: ComplexArray


def two_load_matrix(a: FaceState, b: FaceState) -> TransferMatrix:
    """Return the transfer matrix of any sample from two terminations of the tube: ASTM E2611, two-load method."""
    determinant = a.p_back * b.v_back - b.p_back * a.v_back
    return TransferMatrix(
        (a.p_front * b.v_back - b.p_front * a.v_back) / determinant,
        (b.p_front * a.p_back - a.p_front * b.p_back) / determinant,
        (a.v_front * b.v_back - b.v_front * a.v_back) / determinant,
        (a.p_back * b.v_front - b.p_back * a.v_front) / determinant,
    )


def one_load_matrix(a: FaceState) -> TransferMatrix:
    """Return the transfer matrix of a sample that is reciprocal and looks the same from both sides.

    ASTM E2611, one-load method; Song & Bolton, J. Acoust. Soc. Am. 107 (2000) 1131.
    """
    denominator = a.p_front * a.v_back + a.p_back * a.v_front
    diagonal = (a.p_back * a.v_back + a.p_front * a.v_front) / denominator
    t12 = (a.p_front**2 - a.p_back**2) / denominator
    t21 = (a.v_front**2 - a.v_back**2) / denominator
    return TransferMatrix(diagonal, t12, t21, diagonal)


def matrix_transmission(matrix: TransferMatrix, impedance: float) -> tuple[ComplexArray, ComplexArray]:
    """Return transmission and reflection coefficient with the gas on both sides: ASTM E2611.

    The transmission is pressure at the back face over incident pressure at the front face, without a phase through the
    sample's own thickness; its level is minus the transmission loss.
    """
    t12, t21 = matrix.t12 / impedance, matrix.t21 * impedance
    total = matrix.t11 + t12 + t21 + matrix.t22
    return np.asarray(2 / total), np.asarray((matrix.t11 + t12 - t21 - matrix.t22) / total)


def rigid_backed_reflection(matrix: TransferMatrix, impedance: float) -> ComplexArray:
    """Return the reflection coefficient of the sample in front of a rigid wall: ASTM E2611."""
    t21 = matrix.t21 * impedance
    return np.asarray((matrix.t11 - t21) / (matrix.t11 + t21))


def transfer_functions(
    signals: RealArray, sampling_rate: float, segment: float
) -> tuple[RealArray, ComplexArray, RealArray]:
    """Return transfer functions from the first channel to each: estimator H1 of spectra averaged over Hann windows.

    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73.

    Parameters
    ----------
    signals : array, shape (n_channels, n_samples)
    sampling_rate : float
        Hz.
    segment : float
        Length of the segments, s, overlapping by half; 1/segment is the step in frequency.

    Returns
    -------
    frequency : array, shape (n,)
        Hz, above 0.
    functions : complex array, shape (n_channels, n)
    coherence : array, shape (n_channels, n)
    """
    from scipy.signal import csd

    n = int(min(round(segment * sampling_rate), signals.shape[-1]))
    options: dict[str, Any] = {"fs": sampling_rate, "nperseg": n, "window": "hann", "detrend": "constant"}
    frequency, cross = csd(signals[:1], signals, **options)
    power = csd(signals, signals, **options)[1].real
    coherence = np.abs(cross) ** 2 / (power[:1] * power)
    return np.asarray(frequency[1:]), np.asarray(cross[:, 1:] / power[:1, 1:]), np.asarray(coherence[:, 1:])

"""The result of a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.json_text import json_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Curves:
    """Residuals of one configuration, measured minus modelled, at the data's frequencies.

    Level and phase of a ratio; of a tube real and imaginary part of the reflection coefficient instead. Of measured
    levels or absorption those alone: the arrays of the second quantity are empty.

    Attributes
    ----------
    configuration : str
    frequency : array, shape (n,)
        Hz.
    burst : array of int, shape (n,)
        Index of the burst of each datum.
    level_before, phase_before, level_after, phase_after : array
        dB and degrees; of the nominal model and of the best hypothesis.
    sigma_level, sigma_phase : array
        Standard deviation of noise and of the model's error.
    labels : (str, str)
        Labels of the two quantities, for axes.
    """

    configuration: str
    frequency: RealArray
    burst: NDArray[Any]
    level_before: RealArray
    phase_before: RealArray
    level_after: RealArray
    phase_after: RealArray
    sigma_level: RealArray
    sigma_phase: RealArray
    labels: tuple[str, str] = ("level / dB", "phase / degrees")


@dataclass(frozen=True)
class Similarity:
    """Similarity of the effects' signatures.

    Attributes
    ----------
    names : tuple of str
        Of the effects.
    cosines : array, shape (n, n)
    kept : array, shape (n,)
        Share of each signature that the unknowns do not absorb.
    """

    names: tuple[str, ...]
    cosines: RealArray
    kept: RealArray


@dataclass(frozen=True)
class Diagnosis:
    """The result of a diagnosis.

    Attributes
    ----------
    campaign : str
    record : dict
        Content of ``diagnosis.json``.
    curves : tuple of Curves
    similarity : Similarity
    moduli : dict
        ``frequency_hz``, and ``nominal`` and ``corrected`` with ``E1``, ``E1_low``, ``E1_high`` and the same of ``E2``,
        Pa: 90 % intervals. Corrected is with the cause, or with the law drawn at its place; empty of a tube.
    """

    campaign: str
    record: dict[str, Any]
    curves: tuple[Curves, ...]
    similarity: Similarity
    moduli: dict[str, Any]

    def __repr__(self) -> str:
        return f"{type(self).__name__} of {self.campaign}: {self.record['sentence']}"

    def plot(self, axes: Sequence[Axes] | None = None) -> Sequence[Axes]:
        """Draw E1 and E2 over frequency, of the nominal model and as corrected, with their 90 % intervals.

        Parameters
        ----------
        axes : two matplotlib.axes.Axes, optional
            Where to draw; new ones when left out.

        Returns
        -------
        sequence of matplotlib.axes.Axes

        Raises
        ------
        InputError
            Of a tube, whose unknowns are no modulus.
        """
        if not self.moduli:
            raise InputError("the diagnosis of a tube has no modulus to draw")
        if axes is None:
            from matplotlib import pyplot

            axes = pyplot.subplots(2, 1, sharex=True)[1]
        for axis, part in zip(axes, ("E1", "E2"), strict=True):
            for name in ("nominal", "corrected"):
                values = self.moduli[name]
                (line,) = axis.plot(self.moduli["frequency_hz"], values[part], label=name)
                ends = (values[f"{part}_low"], values[f"{part}_high"])
                axis.fill_between(self.moduli["frequency_hz"], *ends, color=line.get_color(), alpha=0.2)
            axis.set(xlabel="frequency / Hz", ylabel=f"{part} / Pa")
            axis.legend()
        return axes

    @property
    def verdict(self) -> str:
        """The verdict: effect, unknown or no_gap."""
        return str(self.record["verdict"])

    def to_json(self) -> str:
        """Return ``diagnosis.json``."""
        return json_text(self.record)

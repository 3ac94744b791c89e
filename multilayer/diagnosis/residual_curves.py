"""Residuals of the nominal model and of the best hypothesis, for tables and figures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Curves
from multilayer.experiments.hypothesis import Part

_NONE = np.empty(0)


def residual_curves(nominal: Fitted, best: Fitted) -> tuple[Curves, ...]:
    """Return measured minus modelled values of every configuration, with the nominal model and the best hypothesis."""
    hypothesis = nominal.hypothesis
    first, second = (*hypothesis.shown_as, None)[:2]
    curves = []
    for data, spreads, before, after in zip(
        hypothesis.data,
        hypothesis.spreads,
        hypothesis.differences(nominal.minimum.z),
        best.hypothesis.differences(best.minimum.z),
        strict=True,
    ):
        curves.append(
            Curves(
                data.name,
                data.frequency,
                data.burst,
                level_before=_shown(first, -before.real),
                phase_before=_shown(second, -before.imag),
                level_after=_shown(first, -after.real),
                phase_after=_shown(second, -after.imag),
                sigma_level=_shown(first, spreads[0]),
                sigma_phase=_shown(second, spreads[-1]),
                labels=(first.label if first else "", second.label if second else ""),
            )
        )
    return tuple(curves)


def _shown(part: Part | None, values: NDArray[Any]) -> RealArray:
    """Return values in the unit in which they are shown; none of a part that there is not."""
    return _NONE if part is None else np.asarray(part.factor * values)

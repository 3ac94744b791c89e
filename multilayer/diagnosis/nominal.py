"""The nominal model of measured stacks: what is stated of them, fitted without any effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from multilayer.diagnosis.file import DiagnosisFile
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.fits.stacks.fit import find_minima
from multilayer.inference.problem import GaussianPrior, Minimum


def fitted_nominal(file: DiagnosisFile) -> Fitted:
    """Return the fit of a file's nominal model, what a reference measurement tells of its unknowns being known.

    Raises
    ------
    InputError
        When the stacks have no response for most values that the priors allow.
    """
    hypothesis = file.hypothesis
    if file.reference_file is not None:
        hypothesis = replace(hypothesis, earlier=GaussianPrior.of(nominal_minimum(file.reference_file)))
    return Fitted(hypothesis, least_minimum(hypothesis, file))


def nominal_minimum(file: DiagnosisFile) -> Minimum:
    """Return the nominal model of a file at its most probable unknowns.

    Raises
    ------
    InputError
        When the stacks have no response for most values that the priors allow.
    """
    return least_minimum(file.hypothesis, file)


def least_minimum(hypothesis: StackProblem, file: DiagnosisFile) -> Minimum:
    """Return a nominal model at its most probable unknowns, searched with the effort that a file asks for.

    Raises
    ------
    InputError
        When the stacks have no response for most values that the priors allow.
    """
    return find_minima(hypothesis, file)[0]


def unknown_entries(nominal: Fitted, best: Fitted) -> dict[str, Any]:
    """Return the entries of ``unknowns``: values of the nominal model and with the cause, with their units."""
    after = _values(best)
    return {
        name: {"nominal": value, "corrected": after[name][0], "unit": unit}
        for name, (value, unit) in _values(nominal).items()
    }


def _values(fitted: Fitted) -> dict[str, tuple[float, str]]:
    """Return the nominal model's quantities and their units."""
    hypothesis = fitted.hypothesis_as(StackProblem)
    return hypothesis.field_values(hypothesis.own_coordinates(fitted.minimum.z))

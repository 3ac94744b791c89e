"""Scoring of fits against the truth files that lie beside the shared campaigns; nothing but scoring opens them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from multilayer.fits.result import FitResult
from multilayer.media.laws import FractionalZener


def true_modulus(campaign: Path, frequency: np.ndarray) -> np.ndarray:
    """Return E1 + i E2, Pa, of the material a campaign was made with."""
    material = json.loads(campaign.with_name(f"{campaign.name}.truth.json").read_text())["material"]
    law = FractionalZener(
        relaxed_modulus=material["E0"],
        unrelaxed_modulus=material["E0"] * material["ratio"],
        relaxation_time=material["tau"],
        order=material["alpha"],
    )
    return law(frequency)


@dataclass(frozen=True)
class Score:
    """Errors of a fit, one entry per burst.

    Attributes
    ----------
    relative : array, shape (n_bursts, 2)
        Of E1 and E2, signed.
    in_sigmas : array, shape (n_bursts, 2)
        Errors over the stated standard deviations.
    accepted : array of bool
    """

    relative: np.ndarray
    in_sigmas: np.ndarray
    accepted: np.ndarray


def score(result: FitResult, campaign: Path) -> Score:
    """Compare a fit with the truth."""
    truth = true_modulus(campaign, np.array([burst.frequency for burst in result.bursts]))
    true = np.stack([truth.real, truth.imag], axis=-1)
    found = np.array([[b.storage_modulus, b.loss_modulus] for b in result.bursts])
    spread = np.array([[b.storage_modulus_std, b.loss_modulus_std] for b in result.bursts])
    accepted = np.array([burst.accepted for burst in result.bursts])
    return Score((found - true) / true, (found - true) / spread, accepted)

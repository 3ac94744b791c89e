"""A pore model outside its range warns once, says where, and computes on."""

import numpy as np
import pytest

from multilayer.errors import ValidityWarning
from multilayer.media.gas import dry_air
from multilayer.media.pore_models import PORE_MODELS
from multilayer.media.validity import warn_outside

AIR = dry_air()
OMEGA = 2 * np.pi * np.array([10.0, 100.0, 1e3, 1e4, 4e4])


def given(**fields):
    known = {name: None for model in PORE_MODELS.values() for names in model.field_sets for name in names}
    return {**known, **fields}


FOAM = {
    "porosity": 0.98, "flow_resistivity": 50.0, "tortuosity": 1.05, "viscous_length": 5e-4, "thermal_length": 2e-3,
    "thermal_permeability": 1e-7, "static_viscous_tortuosity": 1.5, "static_thermal_tortuosity": 1.5,
    "median_pore_size": 2e-3, "pore_size_deviation": 0.2, "fibre_diameter": 1e-4, "cell_size": 2e-3,
    "grain_diameter": 2e-4, "perforation": 0.1, "slit_width": 3e-4,
}  # fmt: skip


@pytest.mark.parametrize("name", PORE_MODELS)
def test_one_warning_and_a_result(name):
    (fields, _), *_ = reversed(PORE_MODELS[name].variants)
    chosen = given(**{field: 2e4 if name in ("delany_bazley", "miki") else FOAM[field] for field in fields})
    with pytest.warns(ValidityWarning, match=PORE_MODELS[name].title) as caught:
        density, bulk = PORE_MODELS[name].fluid(OMEGA, AIR, chosen)
    assert len(caught) == 1
    assert np.all(np.isfinite(density))
    assert np.all(np.isfinite(bulk))


@pytest.mark.parametrize("name", PORE_MODELS)
def test_silence_inside(name):
    (fields, _), *_ = reversed(PORE_MODELS[name].variants)
    omega = 2 * np.pi * np.array([500.0, 2000.0])
    PORE_MODELS[name].fluid(omega, AIR, given(**{field: {**FOAM, "flow_resistivity": 2e4}[field] for field in fields}))


def test_wilson_by_times():
    times = given(porosity=0.9, tortuosity=1.1, vorticity_time=0.5, entropy_time=0.5)
    with pytest.warns(ValidityWarning, match=r"Wilson holds for 2 pi pore size / wavelength up to 1"):
        PORE_MODELS["wilson"].fluid(OMEGA, AIR, times)


def test_model_range_and_frequencies_are_named():
    message = (
        r"Miki holds for f / flow_resistivity \(m\^3/kg\) from 0\.01 to 1; here it is 0\.0005 to 2 \(10 to 4e\+04 Hz\)"
    )
    with pytest.warns(ValidityWarning, match=message):
        PORE_MODELS["miki"].fluid(OMEGA, AIR, given(flow_resistivity=2e4))


def test_only_the_frequencies_outside_are_named():
    with pytest.warns(ValidityWarning, match=r"here it is 0\.005 \(100 Hz\)"):
        PORE_MODELS["miki"].fluid(OMEGA[1:4], AIR, given(flow_resistivity=2e4))


def test_samples_broadcast_against_frequency():
    sigma = np.array([[2e4], [5e5]])
    with pytest.warns(ValidityWarning, match=r"here it is 0\.002 \(1000 Hz\)"):
        PORE_MODELS["miki"].fluid(OMEGA[2:4], AIR, given(flow_resistivity=sigma))


@pytest.mark.parametrize(
    ("value", "low", "high", "words"),
    [
        (3.0, 0.0, 1.0, "a thing holds for sizes from 0 to 1; here it is 3$"),
        ([0.5, -1.0, -2.0], 0.0, np.inf, "a thing holds for sizes from 0; here it is -2 to -1$"),
        ([0.5, 2.0], -np.inf, 1.0, "a thing holds for sizes up to 1; here it is 2$"),
    ],
)
def test_words(value, low, high, words):
    with pytest.warns(ValidityWarning, match=words):
        warn_outside("a thing", "sizes", np.asarray(value), low, high)

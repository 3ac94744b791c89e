"""Where the gap lies, beside unknowns that take a quantity up altogether."""

from types import SimpleNamespace

import numpy as np

from multilayer.diagnosis.locate import locate, where_entries

FREQUENCY = np.geomspace(100, 1000, 40)


def hypothesis():
    """One configuration, level and phase at 40 frequencies, noise of 1."""
    data = SimpleNamespace(name="A", frequency=FREQUENCY, centres=FREQUENCY)
    experiment = SimpleNamespace(whiten=lambda values: np.concatenate([values.real, values.imag]))
    return SimpleNamespace(part_units=(1.0, 1j), data=[data], quantities=("level", "phase"), experiments=[experiment])


def test_what_unknowns_take_up_is_left_out():
    """Unknowns that move the level of every frequency by anything, a gap in the phase of the last band."""
    n = len(FREQUENCY)
    jacobian = 1e9 * np.vstack([np.eye(n), np.zeros((n, n))])
    residual = np.concatenate([np.zeros(n), -5.0 * (FREQUENCY > 600)])
    minimum = SimpleNamespace(
        jacobian=jacobian, z=np.zeros(n), residual=residual, precision=jacobian.T @ jacobian + np.eye(n)
    )
    places, limit = locate(hypothesis(), minimum)
    assert {place.quantity for place in places} == {"phase"}
    assert np.all(np.isfinite([limit, *(place.significance for place in places)]))
    first = where_entries(places, limit)[0]
    assert first["quantity"] == "phase"
    assert first["band_hz"][1] == 1000
    assert first["note"] == "measured phase above the model"

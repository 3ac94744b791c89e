"""Every script of the gallery runs as a plain script in its folder, and one number of each is right."""

import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from multilayer import load_stack
from multilayer.media.kramers_kronig import gross_loss_modulus

GALLERY = Path(__file__).parents[2] / "examples" / "gallery"


def foam_angles(found):
    """The diffuse field is the mean over angles, weighted by sin 2θ, up to 78 degrees."""
    angle = np.linspace(0, 78, 400)
    alpha = found["plane_wave"](found["stack"], found["frequency"][::50], angle).absorption
    weight = np.sin(2 * np.deg2rad(angle))
    assert found["diffuse"].absorption[::50] == pytest.approx(
        np.trapezoid(alpha * weight, angle) / np.trapezoid(weight, angle), abs=1e-4
    )


def double_wall(found):
    """A panel far smaller than the wavelength radiates by its area, k^2 S/(2 pi), as does any piston in a baffle."""
    stack, window, f = found["stack"], found["Window"], 30.0
    small = found["diffuse_field"](stack, f, window=window(0.1, 0.1))
    k = 2 * np.pi * f / stack.ambient.gas.sound_speed
    gained = small.transmission_loss - found["diffuse_field"](stack, f, weighting=cosine).transmission_loss
    mean_cosine = (1 - np.cos(np.deg2rad(78)) ** 3) / 3 / (np.sin(np.deg2rad(78)) ** 2 / 2)
    assert gained == pytest.approx(-10 * np.log10(k**2 * 0.01 / (2 * np.pi) * mean_cosine), abs=0.05)
    assert np.all(found["finite"] > found["infinite"])


def cosine(angle):
    return np.cos(np.deg2rad(angle))


def biot_or_fluid(found):
    """The frame resonates a little below the quarter wave in vacuo, with the air it carries along."""
    frame = found["frequency"][found["difference"].argmax()]
    assert 0.95 < frame / found["quarter"] < 1.0
    assert found["difference"].max() == pytest.approx(0.33, abs=0.01)


def fit_foam(found):
    """Gross' relation is three times as far off as it errs by itself, as README and tour say."""
    check = found["check"]
    assert check.mean_relative_error == pytest.approx(0.13, abs=0.005)
    law = load_stack(GALLERY.parent / "three_layers.yaml").layers[1].young_modulus(check.frequency)
    itself = np.mean(np.abs(gross_loss_modulus(check.frequency, law.real) / law.imag - 1))
    assert itself == pytest.approx(0.04, abs=0.005)


def joint_law(found):
    """The law is that of the foam in `three_layers.yaml`, which the signals were made of."""
    assert found["fit"].p_value > 0.05
    truth = load_stack(GALLERY.parent / "three_layers.yaml").layers[1].young_modulus
    inside = (found["frequency"] > 100) & (found["frequency"] < 1500)
    ratio = found["modulus"][inside] / truth(found["frequency"][inside])
    assert np.abs(ratio - 1).max() < 0.02


def virtual_rig(found):
    """Without the accelerometer the fit finds the truth; with it E1 is low by its mass over the plate's, about."""
    truth = found["truth"]
    assert found["found"]["without"] == pytest.approx(truth, rel=0.01)
    share = 1e-3 / (7.85 * np.pi * 0.0225**2)
    assert found["found"]["with accelerometer"][0] / truth[0] == pytest.approx(1 / (1 + share), abs=0.015)


def diagnosis(found):
    """The cause by its name, and its size."""
    assert found["diagnosis"].verdict == "effect"
    assert found["diagnosis"].record["causes"][0]["effects"] == ["channel_gain"]
    assert found["gain"]["low"] < 0.04 < found["gain"]["high"]


def impedance_tube(found):
    """Exchanged microphones find the foam; otherwise the difference of the channels, 8 %, remains."""
    assert np.abs(found["corrected"] - found["truth"]).max() < 0.005
    assert np.abs(found["uncorrected"] - found["truth"]).max() > 0.03


def what_matters(found):
    """A thin plate is known by its mass and its bending stiffness: h stands with the density once, with E cubed."""
    change = dict(zip(found["found"].fields, found["change"], strict=True))
    for plate in ("front", "back"):
        parts = [change[f"layers.{plate}.{field}"] for field in ("thickness", "density", "young_modulus")]
        assert parts[0] == pytest.approx(parts[1] + 3 * parts[2], abs=1e-9)
    assert found["disagreement"] < 1e-3 * np.abs(found["change"][found["order"][0]]).max()


def best_absorber(found):
    """The design keeps the limits, and is better than what was written."""
    best, written = found["result"].best, found["result"].written
    assert best.is_kept
    assert sum(best.values.values()) <= 0.05 * (1 + 1e-6)
    assert best.goals[0] >= written.goals[0] + 0.15


CHECKS = {
    check.__name__: check
    for check in (
        foam_angles, double_wall, biot_or_fluid, fit_foam, joint_law, virtual_rig, diagnosis, impedance_tube,
        what_matters, best_absorber,
    )
}  # fmt: skip


def test_every_script_is_checked():
    assert {path.stem for path in GALLERY.glob("*.py")} == set(CHECKS)


@pytest.mark.parametrize("name", CHECKS)
def test_number(name, monkeypatch, capsys):
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    monkeypatch.chdir(GALLERY)
    plt.switch_backend("agg")
    found = runpy.run_path(str(GALLERY / f"{name}.py"))
    assert capsys.readouterr().out
    CHECKS[name](found)

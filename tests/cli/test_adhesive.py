"""``multilayer methods --adhesive``: two plates glued together; the glue is a spring under a mass, in closed form."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from multilayer.measurements.campaign import load_calibration
from tests.cli.command import result_names, run
from tests.fits.rods import burst

RATE = 25600.0
BURSTS = (200.0, 400.0, 800.0, 1500.0)


def write(folder: Path, resonance=np.inf, gain=1.0, delay=0.0, noise=0.003, seed=0) -> Path:
    """Write bursts of a plate on a lossy spring, seen through channels that differ."""
    rng = np.random.default_rng(seed)
    folder.mkdir()
    described = {
        "version": 1, "rig": "calibration", "sampling_rate": RATE,
        "burst": {"cycles": 10.0, "window": "hann", "level_rms": 5.0},
        "bursts": [{"frequency": f, "file": f"{f:g}.npz"} for f in BURSTS],
    }  # fmt: skip
    (folder / "campaign.yaml").write_text(yaml.safe_dump(described))
    for f0 in BURSTS:
        n = round((0.1 + 10 / f0) * RATE)
        base = burst(f0, 10, n, RATE, "hann", 5.0)
        f = np.fft.rfftfreq(8 * n, 1 / RATE)
        motion = gain * np.exp(-2j * np.pi * f * delay) / (1 - (f / resonance) ** 2 / (1 + 0.1j))
        top = np.fft.irfft(motion * np.fft.rfft(base, 8 * n), 8 * n)[:n]
        shape = (5, n)
        np.savez(
            folder / f"{f0:g}.npz",
            base=base + noise * 5 * rng.standard_normal(shape),
            top=top + noise * 5 * rng.standard_normal(shape),
        )
    return folder


def test_the_deviation_is_that_of_many_calibrations(tmp_path):
    made = [load_calibration(write(tmp_path / str(seed), seed=seed, noise=0.02)) for seed in range(24)]
    ratios = np.array([each.amplitude_ratio for each in made])
    phases = 2 * np.pi * np.array(BURSTS) * [each.time_shift for each in made]
    stated = np.sqrt(np.mean([each.std**2 for each in made], axis=0))
    for scatter in (ratios.std(axis=0, ddof=1), phases.std(axis=0, ddof=1)):
        assert np.all((scatter > 0.5 * stated) & (scatter < 1.3 * stated))


def test_a_stiff_adhesive_is_unity_and_channels_are_taken_out(tmp_path):
    glued = write(tmp_path / "glued", gain=1.02, delay=3e-6, seed=1)
    spot = write(tmp_path / "spot", gain=1.02, delay=3e-6, seed=2)
    done = run("methods", glued, "--adhesive", "--calibration", spot, "--out", tmp_path / "out")
    assert done.status == 0
    assert "T = 1 within the noise from 200 to 1500 Hz" in done.out
    assert result_names(tmp_path / "out") == {"adhesive.csv", "adhesive.json", "adhesive.png"}
    found = json.loads((tmp_path / "out" / "adhesive.json").read_text())
    assert found["is_unity"]
    assert found["limit_hz"] == 1500
    for row in found["bursts"]:
        assert abs(row["amplitude"] - 1) < 4 * row["amplitude_std"] < 0.01
    alone = run("methods", glued, "--adhesive", "--json", "--no-figures", "--out", tmp_path / "alone")
    told = json.loads(alone.out)
    assert (told["is_unity"], told["calibrated"]) == (False, False)
    assert "--calibration" in told["sentence"]


def test_a_soft_adhesive_is_seen_from_where_it_acts(tmp_path):
    resonance = 25e3
    glued = write(tmp_path / "glued", resonance, seed=3)
    spot = write(tmp_path / "spot", seed=4)
    done = run("methods", glued, "--adhesive", "--calibration", spot, "--json", "--out", tmp_path / "out")
    found = json.loads(done.out)
    assert done.status == 0
    assert not found["is_unity"]
    assert found["limit_hz"] in (200.0, 400.0)
    true = np.abs(1 / (1 - (np.array(BURSTS) / resonance) ** 2 / (1 + 0.1j)))
    for row, amplitude in zip(found["bursts"], true, strict=True):
        assert row["amplitude"] == pytest.approx(amplitude, abs=4 * row["amplitude_std"])


def test_mistakes(tmp_path):
    glued = write(tmp_path / "glued")
    alone = run("methods", glued, "--calibration", glued, "--out", tmp_path / "out")
    assert (alone.status, (tmp_path / "out").exists()) == (2, False)
    assert "--adhesive" in alone.err
    sample = run("methods", "examples/foam_b", "--adhesive", "--out", tmp_path / "out")
    assert (sample.status, (tmp_path / "out").exists()) == (2, False)
    assert "calibration" in sample.err

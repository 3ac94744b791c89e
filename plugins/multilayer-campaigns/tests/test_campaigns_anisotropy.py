"""Moduli along three axes: ratios, their intervals, and the test of isotropy."""

from dataclasses import replace

import numpy as np
import pytest
from comparable import drawn, point
from multilayer_campaigns.anisotropy import compare_axes
from multilayer_campaigns.axis_ratios import AXES
from multilayer_campaigns.modulus_points import points_of
from multilayer_campaigns.multi_campaign import SAME_RIG
from test_campaigns_preload import UNCERTAINTY

from multilayer.errors import InputError
from multilayer.fits.burst.fit import fit_bursts
from multilayer.rig.draws import draw_errors
from multilayer.rig.statement import campaign_of
from multilayer.rig.synthesis import Task, measure
from multilayer.signals.recording import Recording
from tests.rig.virtual import LAW, rig_file

NAMES, FREQUENCIES = ["one", "two", "three"], (200.0, 400.0)
COMMON = frozenset({"channel_gain", "density"})


def cube(factors=(1.0, 1.0, 1.0), losses=(0.3, 0.3, 0.3)):
    """Return exact bursts along three axes, two of them at each frequency."""
    return [
        point(campaign=a, frequency=f, stress=s, storage_modulus=2e5 * factor * (f / 200) ** 0.2, loss_factor=loss)
        for a, (factor, loss) in enumerate(zip(factors, losses, strict=True))
        for f in FREQUENCIES
        for s in (80.0, 160.0)
    ]


def widths(result):
    return np.array([high - low for _, low, high in result.storage.intervals.values()])


class TestRatios:
    def test_exact_values_give_exact_ratios(self):
        found = compare_axes(NAMES, cube((1.2, 1.0, 1.0)), common=COMMON)
        expected = np.array([1.2, 1.0, 1.0]) / 1.2 ** (1 / 3)
        assert [r for r, *_ in found.storage.intervals.values()] == pytest.approx(expected)
        assert [r for r, *_ in found.loss.intervals.values()] == pytest.approx(expected)
        assert [row["E1_pa"] for row in found.rows() if row["frequency_hz"] == 200] == pytest.approx([2.4e5, 2e5, 2e5])
        assert [row["E2_pa"] for row in found.rows() if row["frequency_hz"] == 200] == pytest.approx([7.2e4, 6e4, 6e4])
        assert found.verdict.startswith("anisotropic (p < 1e-9); E1 over the mean of the axes: x 1.129 (1.12")

    def test_a_loss_factor_alone(self):
        found = compare_axes(NAMES, cube(losses=(0.3, 0.3, 0.36)), common=COMMON)
        assert found.storage.verdict == "none"
        assert found.loss.verdict == "seen"

    def test_common_errors_cancel(self):
        separate, common = (compare_axes(NAMES, cube(), common=c) for c in (frozenset(), COMMON))
        assert (widths(common) < 0.7 * widths(separate)).all()
        assert np.sqrt(np.diag(common.covariance)) == pytest.approx(np.sqrt(np.diag(separate.covariance)), rel=0.2)

    def test_pieces_that_scatter_are_no_anisotropy(self):
        points = cube((1.05, 1.0, 1.0))
        assert compare_axes(NAMES, points, common=COMMON).storage.verdict == "seen"
        assert compare_axes(NAMES, points, common=COMMON, scatter=0.05).storage.verdict == "none"

    def test_probabilities_are_what_they_say(self):
        """Of an isotropic cube p is uniform; of another the intervals hold the truth as often as they say."""
        found = [compare_axes(NAMES, drawn(cube(), seed, common=COMMON), common=COMMON) for seed in range(150)]
        assert 0.01 <= np.mean([one.storage.p_isotropic < 0.05 for one in found]) <= 0.11
        assert 0.36 <= np.mean([one.loss.p_isotropic < 0.5 for one in found]) <= 0.64
        held = [low < 1.0 < high for one in found for _, low, high in one.storage.intervals.values()]
        assert np.mean(held) == pytest.approx(0.95, abs=0.04)

    def test_only_frequencies_of_all_axes_count(self):
        points = [p for p in cube() if (p.campaign, p.frequency) != (2, 400.0)]
        found = compare_axes(NAMES, points)
        assert found.frequency.tolist() == [200.0]
        assert found.remarks == ["left out, for not all axes have them: 400 Hz"]

    def test_none_in_common(self):
        points = [p for p in cube() if (p.campaign == 2) == (p.frequency == 400.0)]
        with pytest.raises(
            InputError, match=r"no frequency is common to all three axes; in Hz, one: 200; two: 200; th"
        ):
            compare_axes(NAMES, points)

    def test_two_axes(self):
        with pytest.raises(InputError, match="2 campaigns; three are compared"):
            compare_axes(NAMES[:2], cube())


def along(axis, factor):
    """Return one axis of a cube on the virtual rig: gain, delay and plate are those of all axes, size and noise not."""
    moduli = {name: factor * LAW[name] for name in ("relaxed_modulus", "unrelaxed_modulus")}
    file = rig_file(
        specimen={"density": 80.0, "young_modulus": {**LAW, **moduli}}, uncertainty=UNCERTAINTY,
        frequencies=[200.0, 450.0], noise={"white": 0.004},
    )  # fmt: skip
    shared = {name: getattr(draw_errors(file, 0), name) for name in (*SAME_RIG, "density")}
    errors = replace(draw_errors(file, 1 + axis), **shared)
    channels = measure(Task(file, errors, file.mountings[0], 1 + axis)).channels
    name = file.mountings[0].name
    return campaign_of(file), {(name, f): Recording(*pair, file.sampling_rate) for f, pair in channels.items()}


def measured(*factors):
    points = []
    for axis, factor in enumerate(factors):
        campaign, recordings = along(axis, factor)
        points += points_of(axis, campaign, fit_bursts(campaign, recordings))
    return compare_axes(NAMES, points, common=SAME_RIG | {"density"})


class TestRig:
    def test_an_isotropic_cube_is_not_taken_for_another(self):
        found = measured(1.0, 1.0, 1.0)
        assert found.verdict.startswith("no anisotropy is seen")
        assert widths(found).max() < 0.02

    def test_twenty_percent_are_found(self):
        found = measured(1.0, 1.2, 1.0)
        assert found.storage.verdict == "seen"
        for ratios in (found.storage, found.loss):
            for axis, factor in zip(AXES, (1.0, 1.2, 1.0), strict=True):
                _, low, high = ratios.intervals[axis]
                assert low < factor / 1.2 ** (1 / 3) < high

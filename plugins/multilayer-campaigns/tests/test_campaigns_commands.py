"""``multilayer preload`` and ``multilayer anisotropy``, as a user meets them."""

import csv
import json
import shutil

import pytest
from matplotlib.image import imread
from test_campaigns_preload import STIFFENING, UNCERTAINTY

from multilayer.rig.synthesis import make_campaign
from multilayer.rig.writer import write_campaign
from tests.cli.campaigns import edit
from tests.cli.campaigns import write_campaign as write_one_plate
from tests.cli.command import result_names, run
from tests.cli.test_bad_input import assert_refused
from tests.cli.test_fit import strict_json
from tests.rig.virtual import rig_file

SERIES = {
    "configurations": {"thicknesses": [0.025], "top_plates": [0.001, 0.003]},
    "frequencies": [200.0, 400.0],
    "uncertainty": UNCERTAINTY,
}


@pytest.fixture(scope="module")
def series(tmp_path_factory):
    """Give a campaign of one specimen under two top plates, which stiffens under their weight."""
    folder = tmp_path_factory.mktemp("series") / "foam"
    write_campaign(make_campaign(rig_file({"effect": "preload", "stiffening": STIFFENING}, **SERIES)), folder)
    return folder


@pytest.fixture
def axes(series, tmp_path):
    """Give three campaigns that say the same."""
    return [shutil.copytree(series, tmp_path / name) for name in ("along-x", "along-y", "along-z")]


def rows(file):
    with file.open() as lines:
        return list(csv.DictReader(lines))


class TestPreload:
    def test_files_and_table(self, series, tmp_path):
        done = run("preload", series, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert result_names(tmp_path / "out") == {"preload.csv", "preload.json", "preload.png"}
        assert "E1 changes by +5." in done.out
        found = rows(tmp_path / "out" / "preload.csv")
        assert [float(row["frequency_hz"]) for row in found] == [200.0, 400.0]
        for row in found:
            slope, std = float(row["E1_slope_per_pa"]), float(row["E1_slope_std_per_pa"])
            assert abs(slope - STIFFENING) < 3 * std
        assert imread(tmp_path / "out" / "preload.png").ndim == 3

    def test_json(self, series, tmp_path):
        done = run("preload", series, "--json", "--no-figures", "--out", tmp_path / "out")
        found = strict_json(done.out)
        assert found == json.loads((tmp_path / "out" / "preload.json").read_text())
        assert found["E1_slope"]["verdict"] == "seen"
        assert found["campaigns"] == ["foam"]
        assert result_names(tmp_path / "out") == {"preload.csv", "preload.json"}

    def test_one_plate(self, tmp_path):
        done = run("preload", write_one_plate(tmp_path / "foam"), "--out", tmp_path / "out")
        assert_refused(done, "no specimen (height and radius) was measured", "two static stresses (77 Pa)")
        assert not (tmp_path / "out").exists()

    def test_another_material(self, axes, tmp_path):
        edit(axes[1], "density: 80.0", "density: 90.0")
        done = run("preload", *axes[:2], "--out", tmp_path / "out")
        assert_refused(done, "along-y", "a density of 90 kg/m3, not 80", "cannot be the same specimen")

    def test_another_model(self, axes, tmp_path):
        (axes[1] / "fit.yaml").write_text("campaign: .\nmodel: finite\n")
        done = run("preload", *axes[:2], "--out", tmp_path / "out")
        assert_refused(done, "along-y: another model than", "must be fitted alike")

    def test_twice(self, series, tmp_path):
        assert_refused(run("preload", series, series, "--out", tmp_path / "out"), "foam: there twice")


class TestAnisotropy:
    def test_files_and_table(self, axes, tmp_path):
        done = run("anisotropy", *axes, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert result_names(tmp_path / "out") == {"anisotropy.csv", "anisotropy.json", "anisotropy.png"}
        assert "no anisotropy is seen (p = 1)" in done.out
        found = rows(tmp_path / "out" / "anisotropy.csv")
        assert [(row["axis"], row["campaign"]) for row in found[::2]] == [
            ("x", "along-x"), ("y", "along-y"), ("z", "along-z"),
        ]  # fmt: skip
        assert [float(row["E1_ratio"]) for row in found] == pytest.approx([1.0] * 6)
        assert imread(tmp_path / "out" / "anisotropy.png").ndim == 3

    def test_what_is_not_common_does_not_cancel(self, axes, tmp_path):
        def width(*options):
            done = run("anisotropy", *axes, *options, "--json", "--no-figures", "--out", tmp_path / "out")
            interval = strict_json(done.out)["E1"]["axes"]["x"]
            return interval["high"] - interval["low"]

        together = width()
        assert width("--separate") > 1.1 * together
        assert width("--scatter", "0.05") > 5 * together

    @pytest.mark.parametrize(("count", "said"), [(1, "1 is named"), (2, "2 are named")])
    def test_too_few(self, axes, tmp_path, count, said):
        done = run("anisotropy", *axes[:count], "--out", tmp_path / "out")
        assert_refused(done, "anisotropy needs three campaigns, measured along x, y and z", said)
        assert not (tmp_path / "out").exists()

    def test_no_common_frequency(self, axes):
        file = axes[2] / "campaign.yaml"
        file.write_text(file.read_text().replace("frequency: 200.0", "frequency: 210.0").replace("400.0", "410.0"))
        done = run("anisotropy", *axes)
        assert_refused(done, "no frequency is common to all three axes; in Hz, along-x: 200, 400;", "along-z: 210, 410")

    def test_scatter_out_of_range(self, axes):
        assert_refused(run("anisotropy", *axes, "--scatter", "-0.1"), "--scatter: -0.1 is not allowed")

    def test_every_missing_campaign_is_told(self, axes, tmp_path):
        done = run("anisotropy", axes[0], tmp_path / "no", tmp_path / "none")
        assert_refused(done, "no: there is no such file", "none: there is no such file")


@pytest.mark.parametrize("command", ["preload", "anisotropy"])
def test_help(command):
    done = run(command, "--help")
    assert (done.status, done.err) == (0, "")
    assert f"Example: multilayer {command} campaigns/" in done.out
    assert {"--json", "--plugin"} <= set(done.out.split())
    assert f"│ {command} " in run("--help").out

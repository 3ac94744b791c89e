"""``multilayer methods``: every method on one small campaign, side by side."""

import csv
import io

import numpy as np
import pytest
from matplotlib.image import imread

from tests.cli.campaigns import BURSTS, NAME, edit, modulus, with_configurations
from tests.cli.command import result_names, run
from tests.cli.test_fit import ODD_NAMES, keep_bursts, strict_json

COLUMNS = "configuration,frequency_hz,method,E1_pa,E1_std_pa,E2_pa,E2_std_pa,remark"
FAST = ("plane-wave", "eq-10", "finite", "transfer-function")
FILES = {"methods.csv", "methods.json", "methods.png"}
QUASI_STATIC = "quasi_static: {storage_modulus: 150 kPa, loss_modulus: 40 kPa, frequency: 5 Hz}\n"


def rows(folder):
    return list(csv.DictReader(io.StringIO((folder / "methods.csv").read_text())))


def of(found, method):
    return [row for row in found if row["method"] == method]


@pytest.fixture(scope="module")
def compared(sound_campaign, tmp_path_factory):
    """Give what the command said of the sound campaign, and where it wrote."""
    folder = tmp_path_factory.mktemp("compared") / "out"
    return run("methods", sound_campaign, "--out", folder), folder


class TestDefaults:
    def test_ends_well(self, compared):
        done, folder = compared
        assert (done.status, done.err) == (0, "")
        assert result_names(folder) == FILES

    def test_every_method_at_every_burst(self, compared):
        text = (compared[1] / "methods.csv").read_text()
        assert text.splitlines()[0] == COLUMNS
        found = rows(compared[1])
        assert [(float(row["frequency_hz"]), row["method"]) for row in found] == [(f, m) for f in BURSTS for m in FAST]
        assert {row["configuration"] for row in found} == {NAME}
        numbers = np.array([[float(row[name]) for name in COLUMNS.split(",")[3:7]] for row in found])
        assert np.isfinite(numbers).all()

    def test_plane_waves_are_what_the_signals_are_made_of(self, compared):
        for row in of(rows(compared[1]), "plane-wave"):
            truth = modulus(float(row["frequency_hz"]))
            assert abs(float(row["E1_pa"]) - truth.real) < 3 * float(row["E1_std_pa"])
            assert abs(float(row["E2_pa"]) - truth.imag) < 3 * float(row["E2_std_pa"])

    def test_the_region_of_equation_10_is_wider(self, compared):
        found = rows(compared[1])
        for stated, accepted in zip(of(found, "plane-wave"), of(found, "eq-10"), strict=True):
            assert float(accepted["E1_std_pa"]) > float(stated["E1_std_pa"])

    def test_the_rod_agrees_with_the_finite_elements(self, compared):
        """Both read the same signals for a glued disc: a modulus 1.35/1.1 times as high as that of the held one."""
        found = rows(compared[1])
        for rod, finite in zip(of(found, "transfer-function"), of(found, "finite"), strict=True):
            if not rod["remark"]:
                assert float(rod["E1_pa"]) == pytest.approx(float(finite["E1_pa"]), rel=0.06)
                assert float(rod["E1_pa"]) > 1.1 * modulus(float(rod["frequency_hz"])).real
        assert "beyond the rod's limit" in of(found, "transfer-function")[-1]["remark"]

    def test_json_on_disk(self, compared):
        result = strict_json((compared[1] / "methods.json").read_text())
        assert result["campaign"] == "foam"
        assert tuple(result["methods"]) == FAST
        assert set(result["left_out"]) == {"nelder-mead", "quasi-static"}
        assert len(result["points"]) == len(FAST) * len(BURSTS)
        first = result["points"][0]
        assert first["loss_factor"] == pytest.approx(first["E2_pa"] / first["E1_pa"])
        assert 500 < result["transfer_function_limit_hz"][NAME] < 600
        checks = {check["method"]: check for check in result["kramers_kronig"]}
        assert set(checks) == {"plane-wave", "eq-10", "finite"}
        # the law's own n pi/2 / tan(n pi/2), and an edge
        assert checks["plane-wave"]["gross_mean_relative_error"] < 0.15
        assert checks["plane-wave"]["verdict"] in ("consistent", "cannot tell")
        apart = {agreement["method"]: agreement for agreement in result["agreement"]}
        assert set(apart) == {"plane-wave", "eq-10", "transfer-function"}
        assert {agreement["reference"] for agreement in apart.values()} == {"finite"}
        # held sideways for glued: lower
        assert -0.3 < apart["plane-wave"]["E1_median_difference"] < -0.1

    def test_prints_the_table(self, compared):
        out = compared[0].out
        assert "foam: h25mm" in out
        for text in ("E1 / kPa", "loss factor", "reliable", "Kramers-Kronig", "Gross (12)", "E1 over finite"):
            assert text in out
        for method in FAST:
            assert out.count(f" {method} ") >= len(BURSTS)
        assert "nelder-mead: left out, not asked for" in out
        assert "a rod up to 5" in out
        assert f"written to {compared[1]}" in out

    def test_figure_shows_something(self, compared):
        picture = imread(compared[1] / "methods.png")
        ink = np.mean(np.any(picture[..., :3] < 0.98, axis=-1))
        assert 0.005 < ink < 0.6


class TestOptions:
    def test_all_and_quasi_static(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        (campaign / "fit.yaml").write_text(f"version: 1\n{QUASI_STATIC}")
        done = run("methods", campaign, "--out", tmp_path / "out", "--all", "--no-figures", "--json")
        assert (done.status, done.err) == (0, "")
        assert result_names(tmp_path / "out") == FILES - {"methods.png"}
        result = strict_json(done.out)
        assert result == strict_json((tmp_path / "out" / "methods.json").read_text())
        assert list(result["methods"]) == ["plane-wave", "eq-10", "finite", "nelder-mead", *FAST[3:], "quasi-static"]
        assert result["left_out"] == {}
        slow, *others = result["points"]
        assert (slow["method"], slow["frequency_hz"], slow["E1_pa"], slow["E2_pa"]) == ("quasi-static", 5.0, 1.5e5, 4e4)
        assert slow["E1_std_pa"] is None
        assert slow["remark"] == "given in the fit file"
        (literal,) = (point for point in others if point["method"] == "nelder-mead")
        assert abs(literal["E1_pa"] - modulus(400).real) < literal["E1_std_pa"]
        # one burst has no slope
        assert result["kramers_kronig"] == []

    def test_method_of_the_fit_file_is_among_them(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        (campaign / "fit.yaml").write_text("version: 1\nmethod: nelder-mead\n")
        assert run("methods", campaign, "--out", tmp_path / "out", "--no-figures").status == 0
        assert of(rows(tmp_path / "out"), "nelder-mead")

    def test_held_is_the_plane_wave_model(self, campaign, tmp_path):
        keep_bursts(campaign, 200, 400)
        done = run("methods", campaign, "--out", tmp_path / "out", "--lateral", "held", "--no-figures")
        assert done.status == 0
        for row in of(rows(tmp_path / "out"), "transfer-function"):
            truth = modulus(float(row["frequency_hz"]))
            assert abs(float(row["E1_pa"]) - truth.real) < 3 * float(row["E1_std_pa"])
            assert abs(float(row["E2_pa"]) - truth.imag) < 3 * float(row["E2_std_pa"])

    def test_same_input_same_table(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        for out in ("one", "two"):
            assert run("methods", campaign, "--out", tmp_path / out, "--no-figures").status == 0
        assert (tmp_path / "one" / "methods.csv").read_text() == (tmp_path / "two" / "methods.csv").read_text()


class TestSpecialCampaigns:
    def test_without_stated_uncertainties(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        file = campaign / "campaign.yaml"
        lines = [line for line in file.read_text().splitlines() if not line.startswith("uncertainty:")]
        file.write_text("\n".join(lines) + "\n")
        done = run("methods", campaign, "--out", tmp_path / "out", "--no-figures")
        assert done.status == 0
        assert not of(rows(tmp_path / "out"), "eq-10")
        assert "eq-10: left out, the campaign states no uncertainties" in done.out

    def test_a_negative_poisson_ratio(self, campaign, tmp_path):
        """No shape factor is known for it: the rod is left out, with a remedy, and the others go on."""
        keep_bursts(campaign, 400)
        edit(campaign, "poisson_ratio: 0.3}\ntop_plate", "poisson_ratio: -0.2}\ntop_plate")
        done = run("methods", campaign, "--out", tmp_path / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        left_out = strict_json((tmp_path / "out" / "methods.json").read_text())["left_out"]
        assert "slender does without a shape factor" in left_out["transfer-function"]
        assert of(rows(tmp_path / "out"), "plane-wave")
        done = run("methods", campaign, "--out", tmp_path / "out", "--no-figures", "--lateral", "slender")
        assert of(rows(tmp_path / "out"), "transfer-function")

    def test_bounds_that_nothing_meets(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        (campaign / "fit.yaml").write_text("version: 1\nbounds: {storage_modulus: [100 MPa, 1 GPa]}\n")
        done = run("methods", campaign, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        (rod,) = of(rows(tmp_path / "out"), "transfer-function")
        assert (rod["E1_pa"], rod["E2_std_pa"]) == ("", "")
        assert "no modulus within bounds" in rod["remark"]
        assert result_names(tmp_path / "out") == FILES

    def test_any_name_of_a_configuration(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        with_configurations(campaign, [f"'{name}'" for name in ODD_NAMES], 600)
        done = run("methods", campaign, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert [name for name in ODD_NAMES if f"foam: {name}\n" not in done.out] == []
        assert list(dict.fromkeys(row["configuration"] for row in rows(tmp_path / "out"))) == ODD_NAMES


class TestBadInput:
    def test_unknown_lateral(self, campaign, tmp_path):
        done = run("methods", campaign, "--out", tmp_path / "out", "--lateral", "hold")
        assert (done.status, done.out) == (2, "")
        assert done.err == "--lateral: there is no 'hold'; did you mean 'held'?\n"
        assert not (tmp_path / "out").exists()

    def test_missing_signals(self, campaign, tmp_path):
        (campaign / "signals" / "0200.npz").unlink()
        done = run("methods", campaign, "--out", tmp_path / "out")
        assert done.status == 2
        assert "0200.npz" in done.err
        assert not (tmp_path / "out").exists()

    def test_help_has_an_example(self):
        done = run("methods", "--help")
        assert (done.status, done.err) == (0, "")
        assert "Example: multilayer methods examples/foam_b --out results/foam_b" in " ".join(done.out.split())

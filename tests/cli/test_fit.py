"""``multilayer fit``: what it writes, what it prints, how it ends."""

import csv
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from multilayer.writing import disk
from tests.cli.campaigns import BURSTS, LOSS_FACTOR, NAME, RATE, edit, modulus, write_calibration
from tests.cli.command import result_names, run, run_elsewhere

COLUMNS = (
    "configuration,frequency_hz,E1_pa,E1_std_pa,E2_pa,E2_std_pa,loss_factor,loss_factor_std,"
    "delta_tof_s,delta_level_db,accepted"
)
FIGURES = {"moduli.png", "transmissibility.png", "gross_check.png", "convergence.png", f"envelopes-{NAME}.png"}
DRAWN = FIGURES | {"report.html"}
TABLES = {"moduli.csv", "fit.json"}

ODD_NAMES = ["_a [/b] [red]", "_A_[/B]_[RED]", "50 $ or $ 60_{", "/:warning: {} %s \\ 泡沫", 90 * "x"]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "manifest.json"}


def strict_json(text: str):
    """Return what JSON says; NaN and Infinity are no JSON, though Python reads them."""

    def refuse(constant):
        raise ValueError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def rows(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO((folder / "moduli.csv").read_text())))


def keep_bursts(folder: Path, *kept: int) -> None:
    """Leave only some bursts in the campaign: quicker to fit."""
    file = folder / "campaign.yaml"
    lines = file.read_text().splitlines(keepends=True)
    dropped = tuple(f"{{frequency: {f}," for f in BURSTS if f not in kept)
    file.write_text("".join(line for line in lines if not any(text in line for text in dropped)))


class TestDefaults:
    def test_ends_well(self, fitted):
        assert fitted.outcome.status == 0
        assert fitted.outcome.err == ""

    def test_writes_the_files_and_no_other(self, fitted):
        assert result_names(fitted.folder) == TABLES | DRAWN

    def test_table_on_disk(self, fitted):
        text = (fitted.folder / "moduli.csv").read_text()
        assert text.splitlines()[0] == COLUMNS
        assert text.endswith("\n")
        found = rows(fitted.folder)
        assert [row["configuration"] for row in found] == [NAME] * len(BURSTS)
        assert [float(row["frequency_hz"]) for row in found] == list(BURSTS)
        assert {row["accepted"] for row in found} == {"true"}
        numbers = np.array(
            [[float(v) for k, v in row.items() if k not in ("configuration", "accepted")] for row in found]
        )
        assert np.isfinite(numbers).all()

    def test_modulus_is_that_of_the_closed_form(self, fitted):
        """The rod neglects how plates give way, below 1e-4 here; the rest is noise."""
        for row in rows(fitted.folder):
            truth = modulus(float(row["frequency_hz"]))
            # sums of independent errors: beyond three standard deviations none of so few may lie
            assert abs(float(row["E1_pa"]) - truth.real) < 3 * float(row["E1_std_pa"])
            assert abs(float(row["E2_pa"]) - truth.imag) < 3 * float(row["E2_std_pa"])
            assert float(row["E1_std_pa"]) < 0.05 * truth.real
            assert float(row["loss_factor"]) == pytest.approx(LOSS_FACTOR, rel=0.05)
            assert float(row["loss_factor"]) == pytest.approx(float(row["E2_pa"]) / float(row["E1_pa"]), rel=0.01)

    def test_json_on_disk(self, fitted):
        result = strict_json((fitted.folder / "fit.json").read_text())
        assert result["version"] == 1
        assert result["campaign"] == "foam"
        assert result["method"] == "least-squares"
        assert result["settings"]["acceptance"] == {"level_db": 0.5}
        assert result["all_accepted"] is True
        assert len(result["bursts"]) == len(BURSTS)
        for burst, row in zip(result["bursts"], rows(fitted.folder), strict=True):
            assert burst["reason"] == ""
            assert burst["notes"] == []
            assert burst["alternatives"] == []
            lengths = {len(burst["convergence"][name]) for name in ("E1_pa", "E2_pa", "cost")}
            assert len(lengths) == 1
            assert min(lengths) > 3
            assert {"E1_pa", "E2_pa", "misfit"} == set(burst["optimum"])
            assert burst["optimum"]["misfit"] < 0.01
            assert burst["E1_pa"] == pytest.approx(float(row["E1_pa"]), rel=1e-8)
            assert burst["accepted"] is True

    def test_cost_falls(self, fitted):
        for burst in strict_json((fitted.folder / "fit.json").read_text())["bursts"]:
            cost = burst["convergence"]["cost"]
            assert min(cost) < 0.1 * cost[0]
            assert burst["convergence"]["E1_pa"][int(np.argmin(cost))] == pytest.approx(
                burst["optimum"]["E1_pa"], rel=1e-3
            )

    def test_transmissibility_is_that_of_the_model(self, fitted):
        for burst in strict_json((fitted.folder / "fit.json").read_text())["bursts"]:
            measured, modelled = (complex(*burst["transmissibility"][k]) for k in ("measured", "modelled"))
            assert abs(modelled - measured) < 0.02 * abs(measured)

    @pytest.mark.parametrize("name", sorted(FIGURES))
    def test_figures_show_something(self, fitted, name):
        file = fitted.folder / name
        assert file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        picture = (255 * imread(file)[..., :3]).round().astype(int)
        packed = np.unique(picture @ [65536, 256, 1])
        colours = packed[:, np.newaxis] // [65536, 256, 1] % 256
        ink = np.mean(np.any(picture < 250, axis=-1))
        assert len(colours) > 50
        assert 0.005 < ink < 0.6
        # beside black, grey and white there are lines in colour
        assert np.sum(np.ptp(colours, axis=1) > 100) > 5

    def test_prints_a_table(self, fitted):
        out = fitted.outcome.out
        assert "foam: h25mm" in out
        heading = next(line for line in out.splitlines() if "f / Hz" in line)
        for column in ("E1 / kPa", "E2 / kPa", "loss factor", "Δtof / µs", "Δlevel / dB", "accepted", "remark"):
            assert column in heading
        for burst, row in zip(BURSTS, rows(fitted.folder), strict=True):
            (line,) = re.findall(rf"^ *{burst} .*$", out, re.MULTILINE)
            shown = float(line.split()[1])
            assert shown == pytest.approx(float(row["E1_pa"]) / 1e3, rel=0.01)
            assert " yes" in line
        assert "Gross check" in out
        assert f"written to {fitted.folder}" in out


class TestOptions:
    def test_json_alone_on_standard_output(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        done = run("fit", campaign, "--out", tmp_path / "out", "--json", "--no-figures")
        assert done.status == 0
        assert done.err == ""
        assert strict_json(done.out) == strict_json((tmp_path / "out" / "fit.json").read_text())

    def test_no_figures(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        assert run("fit", campaign, "--out", tmp_path / "out", "--no-figures").status == 0
        assert result_names(tmp_path / "out") == TABLES

    def test_results_folder_is_named_after_the_campaign(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        done = run("fit", "foam/campaign.yaml", "--no-figures", cwd=tmp_path)
        assert done.status == 0
        assert result_names(tmp_path / "results" / "foam") == TABLES

    def test_campaign_in_the_current_folder(self, campaign):
        keep_bursts(campaign, 200)
        assert run("fit", ".", "--no-figures", cwd=campaign).status == 0
        assert result_names(campaign / "results" / "foam") == TABLES

    def test_nelder_mead(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        done = run("fit", campaign, "--out", tmp_path / "out", "--method", "nelder-mead", "--no-figures")
        assert done.status == 0, done
        result = strict_json((tmp_path / "out" / "fit.json").read_text())
        assert result["method"] == result["settings"]["method"] == "nelder-mead"
        (burst,) = result["bursts"]
        truth = modulus(600)
        # to the letter: air above, no dispersion; what that changes stays within the accepted region
        assert abs(burst["E1_pa"] - truth.real) < burst["E1_std_pa"]
        # eq. (10) to the letter: whole samples
        assert burst["delta_tof_s"] * RATE == pytest.approx(round(burst["delta_tof_s"] * RATE), abs=1e-9)

    def test_same_input_same_output(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        for out in ("one", "two"):
            assert run("fit", campaign, "--out", tmp_path / out, "--no-figures").status == 0
        assert contents(tmp_path / "one") == contents(tmp_path / "two")


FIT_FILE = """\
version: 1
campaign: ../foam
method: least-squares
bounds: {storage_modulus: [10 kPa, 10 MPa], loss_factor: [0.01, 1]}
acceptance: {time_of_flight: 20 us, level_db: 0.2}
quasi_static: {storage_modulus: 150 kPa, loss_modulus: 40 kPa, frequency: 5 Hz}
"""


class TestFitFile:
    def test_settings_count(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        (tmp_path / "fits").mkdir()
        file = tmp_path / "fits" / "tight.yaml"
        file.write_text(FIT_FILE)
        done = run("fit", file, "--out", tmp_path / "out")
        assert done.status == 0
        settings = strict_json((tmp_path / "out" / "fit.json").read_text())["settings"]
        assert settings["bounds"] == {"storage_modulus": [1e4, 1e7], "loss_factor": [0.01, 1.0]}
        assert settings["acceptance"] == {"time_of_flight": pytest.approx(2e-5), "level_db": 0.2}
        assert settings["quasi_static"] == {"storage_modulus": 1.5e5, "loss_modulus": 4e4, "frequency": 5.0}
        assert result_names(tmp_path / "out") == TABLES | DRAWN

    def test_folder_with_a_fit_file(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        (campaign / "fit.yaml").write_text(FIT_FILE.replace("../foam", "."))
        assert run("fit", campaign, "--out", tmp_path / "out", "--no-figures").status == 0
        assert strict_json((tmp_path / "out" / "fit.json").read_text())["settings"]["acceptance"]["level_db"] == 0.2
        # the campaign file named itself: the fit file beside it does not count
        assert run("fit", campaign / "campaign.yaml", "--out", tmp_path / "out", "--no-figures").status == 0
        assert strict_json((tmp_path / "out" / "fit.json").read_text())["settings"]["acceptance"]["level_db"] == 0.5

    def test_option_beats_file(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        (campaign / "fit.yaml").write_text("version: 1\nmethod: nelder-mead\n")
        assert run("fit", campaign, "--out", tmp_path / "out", "--method", "least-squares", "--no-figures").status == 0
        assert strict_json((tmp_path / "out" / "fit.json").read_text())["method"] == "least-squares"

    def test_calibration_is_taken_out(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        gain, delay = 1.1, 2e-4
        write_calibration(tmp_path / "calibration", gain, delay)
        file = campaign / "signals" / "0200.npz"
        with np.load(file) as data:
            base, top = data["base"], data["top"]
        shift = np.exp(-2j * np.pi * np.fft.rfftfreq(top.shape[1]) * delay * RATE)
        np.savez(file, base=base, top=gain * np.fft.irfft(np.fft.rfft(top) * shift, top.shape[1]))
        losses = {}
        for name, text in (("with", "calibration: ../calibration\n"), ("without", "")):
            (campaign / "fit.yaml").write_text("version: 1\n" + text)
            assert run("fit", campaign, "--out", tmp_path / name, "--no-figures").status in (0, 1)
            (losses[name],) = (float(row["loss_factor"]) for row in rows(tmp_path / name))
        assert losses["with"] == pytest.approx(LOSS_FACTOR, rel=0.02)
        # a delay of 0.25 rad at the resonance is mistaken for damping
        assert abs(losses["without"] - LOSS_FACTOR) > 0.1 * LOSS_FACTOR

    def test_calibration_that_ends_too_early(self, campaign, tmp_path):
        calibration = write_calibration(tmp_path / "calibration", 1.0, 0.0)
        edit(calibration, "  - {frequency: 600, file: 0600.npz}\n", "")
        (campaign / "fit.yaml").write_text("version: 1\ncalibration: ../calibration\n")
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert done.status == 2
        assert "400 Hz lies outside of the calibrated range" in done.err
        assert not (tmp_path / "out").exists()


class TestNotAccepted:
    def fit(self, campaign, tmp_path, text, *options):
        keep_bursts(campaign, 200, 400)
        (campaign / "fit.yaml").write_text(f"version: 1\n{text}\n")
        return run("fit", campaign, "--out", tmp_path / "out", *options)

    def test_criteria_that_nothing_meets(self, campaign, tmp_path):
        done = self.fit(campaign, tmp_path, "acceptance: {level_db: 1.0e-9}")
        assert done.status == 1
        assert done.err == ""
        assert result_names(tmp_path / "out") == TABLES | DRAWN
        assert {row["accepted"] for row in rows(tmp_path / "out")} == {"false"}
        result = strict_json((tmp_path / "out" / "fit.json").read_text())
        assert result["all_accepted"] is False
        for burst in result["bursts"]:
            assert re.match(r"level off by [+-]0\.00 dB \(allowed 1e-09\)", burst["reason"])
            assert "level off" in done.out

    def test_optimum_on_a_bound(self, campaign, tmp_path):
        done = self.fit(campaign, tmp_path, "bounds: {storage_modulus: [1 kPa, 180 kPa]}", "--no-figures")
        assert done.status == 1
        # 169 kPa at 200 Hz lies within, 192 kPa at 400 Hz does not
        assert [row["accepted"] for row in rows(tmp_path / "out")] == ["true", "false"]
        _, refused = strict_json((tmp_path / "out" / "fit.json").read_text())["bursts"]
        assert refused["reason"].startswith("the best solution lies on a bound of the search (E1 = 1.8e+05 Pa")
        assert " no " in next(line for line in done.out.splitlines() if line.strip().startswith("400"))

    def test_json_all_the_same(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        (campaign / "fit.yaml").write_text("version: 1\nacceptance: {level_db: 1.0e-9}\n")
        done = run("fit", campaign, "--out", tmp_path / "out", "--no-figures", "--json")
        assert done.status == 1
        assert strict_json(done.out)["all_accepted"] is False


class TestExistingResults:
    @pytest.fixture
    def results(self, campaign, tmp_path):
        """Give a folder with results of an earlier fit, and a file of the user's own."""
        keep_bursts(campaign, 200)
        assert run("fit", campaign, "--out", tmp_path / "out", "--no-figures").status == 0
        (tmp_path / "out" / "notes.txt").write_text("mine")
        return tmp_path / "out"

    def test_are_replaced(self, campaign, results):
        before = contents(results)
        (campaign / "fit.yaml").write_text("version: 1\nbounds: {loss_factor: [0, 0.2]}\n")
        assert run("fit", campaign, "--out", results, "--no-figures").status == 1
        after = contents(results)
        assert after.keys() == before.keys()
        assert {name for name in after if after[name] != before[name]} == TABLES

    def test_stay_when_the_input_is_bad(self, campaign, results):
        before = contents(results)
        (campaign / "signals" / "0200.npz").unlink()
        assert run("fit", campaign, "--out", results).status == 2
        assert contents(results) == before

    def test_stay_when_the_disk_is_full(self, campaign, results, monkeypatch):
        before = contents(results)
        write, written = disk.write, []

        def write_once(path, data):
            written.append(path)
            if len(written) > 1:
                raise OSError(28, "No space left on device")
            return write(path, data)

        monkeypatch.setattr(disk, "write", write_once)
        done = run("fit", campaign, "--out", results, "--no-figures")
        monkeypatch.undo()
        assert done.status == 2
        assert "No space left on device" in done.err
        assert done.out == ""
        assert contents(results) == before


class TestInput:
    def test_csv_and_npz_give_the_same(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        assert run("fit", campaign, "--out", tmp_path / "npz", "--no-figures").status == 0
        with np.load(campaign / "signals" / "0400.npz") as data:
            base, top = data["base"], data["top"]
        columns = [np.arange(base.shape[1]) / RATE, base[0], top[0], base[1], top[1]]
        table = io.StringIO()
        np.savetxt(table, np.column_stack(columns), "%.17g", ",")
        (campaign / "signals" / "0400.csv").write_text("time,base_1,top_1,base_2,top_2\n" + table.getvalue())
        edit(campaign, "0400.npz", "0400.csv")
        assert run("fit", campaign, "--out", tmp_path / "csv", "--no-figures").status == 0
        assert contents(tmp_path / "csv") == contents(tmp_path / "npz")

    def test_any_name_of_a_configuration(self, campaign, tmp_path):
        """No name is taken for markup, a formula or a path, and none takes the place of another."""
        keep_bursts(campaign, 600)
        file = campaign / "campaign.yaml"
        head, _, body = file.read_text().partition("configurations:\n")
        with np.load(campaign / "signals" / "0600.npz") as data:
            base, top = data["base"], data["top"]
        parts = []
        for i, name in enumerate(ODD_NAMES):
            heard = 1e-4 * np.random.default_rng(i).normal(size=top.shape)  # noise is never twice the same
            np.savez(campaign / "signals" / f"{i}.npz", base=base, top=top + heard)
            parts.append(body.replace("h25mm", f"'{name}'").replace("0600.npz", f"{i}.npz"))
        file.write_text(f"{head}configurations:\n" + "".join(parts))
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert [name for name in ODD_NAMES if f"foam: {name}\n" not in done.out] == []
        assert [row["configuration"] for row in rows(tmp_path / "out")] == ODD_NAMES
        envelopes = [name for name in result_names(tmp_path / "out") if name.startswith("envelopes-")]
        assert len({name.casefold() for name in envelopes}) == len(ODD_NAMES)


class TestElsewhere:
    """In a process of its own, as the console script runs."""

    def test_json(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        options = ("--out", tmp_path / "out", "--json", "--no-figures")
        done = run_elsewhere("fit", campaign, *options, PYTHONWARNINGS="error")
        assert (done.status, done.err) == (0, "")
        assert strict_json(done.out)["all_accepted"] is True

    def test_a_pipe_without_greek_letters(self, campaign, tmp_path):
        keep_bursts(campaign, 600)
        done = run_elsewhere("fit", campaign, "--out", tmp_path / "out", "--no-figures", PYTHONIOENCODING="ascii")
        assert (done.status, done.err) == (0, "")
        assert "?tof / ?s" in done.out

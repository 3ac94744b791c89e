"""The sentence on top of a simulation's report: what it ranks by, ties, units."""

import pytest

from multilayer.report.simulation import simulation_report
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.run import simulate

ROOF = {"type": "elastic_plate", "name": "roof", "thickness": 1e-3, "density": 7850, "young_modulus": 210e9}
ROOF |= {"poisson_ratio": 0.3, "loss_factor": 0.01}
WOOL = {"type": "equivalent_fluid", "name": "wool", "model": "jca", "thickness": 0.05, "flow_resistivity": 1e4}
WOOL |= {"porosity": 0.98, "tortuosity": 1.02, "viscous_length": 9e-5, "thermal_length": 1.8e-4}
BANDS = {"third_octaves": [100, 5000]}


def report_of(**data):
    return simulation_report(simulate(SimulationFile.model_validate({"frequency": BANDS, **data})))


def test_rain_is_not_ranked_by_the_loss_of_sound():
    report = report_of(
        layers=[ROOF], termination="ambient", excitation={"type": "rain"},
        sweep={"layers.roof.thickness": [7e-4, 2e-3]},
    )  # fmt: skip
    assert report.sentence.startswith("Over 2 cases the sound power level, averaged from 100 to 5000 Hz, is ")
    assert "Rw" not in report.sentence
    assert dict(report.facts)["largest mean sound power level"].endswith(" dB")
    assert any("Rw" in note for section in report.sections for part in section.listings for note in part.notes)


def test_a_duct_is_told_by_its_attenuation_with_its_unit():
    data = {"layers": [WOOL], "termination": "rigid", "duct": {"height": 0.1}}
    one = report_of(**data)
    assert one.sentence.startswith("The attenuation of the lined duct is ")
    assert " dB/m on average from 100 to 5000 Hz, and " in one.sentence
    assert dict(one.facts)["largest mean attenuation of the lined duct"].endswith(" dB/m")
    swept = report_of(**data, sweep={"duct.height": [0.1, 0.2]})
    assert " dB/m (duct.height = 0.2 m) to " in swept.sentence


@pytest.mark.parametrize("incidence", ["normal", 45])
def test_nothing_is_best_where_all_are_alike(incidence):
    """Poisson's ratio hardly matters to a plate far below its coincidence."""
    report = report_of(
        layers=[ROOF], termination="ambient", incidence=incidence,
        sweep={"layers.roof.loss_factor": [0.01, 0.02, 0.03]},
    )  # fmt: skip
    assert report.sentence.startswith("All 3 cases are alike: Rw (C; Ctr) ")
    assert "best" not in report.sentence
    facts = dict(report.facts)
    assert facts["cases"] == "3"
    assert facts["Rw (C; Ctr), all 3 cases"].endswith(" dB")


def test_means_that_are_alike_have_no_ends():
    report = report_of(
        layers=[ROOF], termination="ambient", frequency=[500.0, 600.0], sweep={"layers.roof.loss_factor": [0.01, 0.02]}
    )
    assert report.sentence.endswith(" dB in all of them.")


def test_others_like_the_best_are_counted():
    report = report_of(
        layers=[ROOF], termination="ambient",
        sweep={"layers.roof.thickness": [1e-3, 3e-3], "layers.roof.loss_factor": [0.01, 0.02]},
    )  # fmt: skip
    assert "the best is roof.thickness = 0.003 m, roof.loss_factor = 0.01 (and 1 alike): Rw" in report.sentence
    assert "the worst is roof.thickness = 0.001 m, roof.loss_factor = 0.01 (and 1 alike): Rw" in report.sentence


def test_the_largest_value_is_the_one_at_its_frequency():
    """Metres of wool let nothing through at high frequencies: less than the least number there is."""
    wool = WOOL | {"thickness": 20.0}
    report = report_of(layers=[wool], termination="ambient", frequency=[100, 125, 20000])
    assert report.sentence.endswith(" dB at most, at 125 Hz.")
    assert "inf" not in report.sentence.rpartition(" and ")[2]

"""Means over bands that hold resonances between the frequencies which stand for them."""

import warnings
from typing import Any

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.simulation import tasks
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.resonances import Parts, hidden, resolved, uneven
from multilayer.simulation.run import simulate

CENTRE = 1.0037  # of the resonance on the logarithmic axis, between two frequencies


def loss_beside(width: float) -> Any:
    """Return the loss of a Lorentzian resonance over a flat background of 60 dB."""

    def respond(frequency: np.ndarray) -> dict[str, np.ndarray]:
        power = 1e-6 + 1 / (1 + ((np.log(frequency) - CENTRE) / width) ** 2)
        return {"transmission_loss": -10 * np.log10(power)}

    return respond


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5])
def test_the_mean_over_a_resonance_is_that_of_its_integral(width: float) -> None:
    edges = np.array([0.9, 1.1])
    frequency = np.exp(edges[0] + (np.arange(21) + 0.5) / 21 * 0.2)
    respond = loss_beside(width)
    (parts,) = resolved([Parts.equal(frequency, respond(frequency))], respond)
    power = np.sum(parts.weights() * 10 ** (-parts.values["transmission_loss"] / 10))
    low, high = np.arctan((edges - CENTRE) / width)
    assert power == pytest.approx(1e-6 + width * (high - low) / 0.2, rel=5e-3)
    assert parts.even
    assert np.all(np.diff(parts.place) > 0)
    assert np.sum(parts.width) == pytest.approx(0.2, rel=1e-12)
    assert len(parts.place) < 400


def test_straight_responses_are_left_alone() -> None:
    place = np.linspace(0.0, 1.0, 21)
    values = {"transmission_loss": 30 + 20 * place, "absorption": 0.5 + 0.1 * place, "other": np.sin(50 * place)}
    assert not np.any(uneven(place, values))
    values["transmission_loss"] = np.where(place == place[7], 20.0, values["transmission_loss"])
    assert np.flatnonzero(uneven(place, values)).tolist() == [6, 7, 8]


GLASS = {"type": "elastic_plate", "density": 2500, "young_modulus": 70e9, "poisson_ratio": 0.22, "loss_factor": 0.01}


def glazing(gap: float = 0.1, **other: Any) -> SimulationFile:
    """Return two panes of glass before each other."""
    layers = [
        {**GLASS, "name": "front", "thickness": 0.006},
        {"type": "fluid", "name": "gap", "thickness": gap},
        {**GLASS, "name": "back", "thickness": 0.010},
    ]
    asked = {"termination": "ambient", "incidence": 0.0, "frequency": {"third_octaves": [1600, 3150]}}
    return SimulationFile.model_validate({"layers": layers, **asked, **other})


def test_a_cavity_resonance_between_two_frequencies_counts() -> None:
    case = simulate(glazing()).cases[0]
    assert case.quantities["transmission_loss"][-1] == pytest.approx(54.26, abs=0.05)  # of 2e6 frequencies in the band


def test_cases_computed_together_are_those_computed_apart() -> None:
    together = simulate(glazing(sweep={"layers.gap.thickness": ["80 mm", "100 mm", "120 mm"]}))
    for case, gap in zip(together.cases, (0.08, 0.1, 0.12), strict=True):
        alone = simulate(glazing(gap))
        np.testing.assert_array_equal(
            case.quantities["transmission_loss"], alone.cases[0].quantities["transmission_loss"]
        )


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_lines_hide_a_resonance_narrower_than_their_spacing(width: float) -> None:
    frequency = np.exp(np.linspace(0.0, 2.0, 101))
    respond = loss_beside(width)
    of_loss = hidden(frequency, respond(frequency), respond)
    if width == 1e-2:  # half of the spacing
        assert of_loss == []
        return
    ((quantity, beyond, at),) = of_loss
    assert quantity == "transmission_loss"
    assert np.log(at) == pytest.approx(CENTRE, abs=width)
    deepest = respond(np.exp(np.array([CENTRE])))["transmission_loss"][0]
    nearest = respond(frequency)["transmission_loss"].min()
    assert beyond == pytest.approx(deepest - nearest, abs=1.0)


def test_lines_hide_nothing_of_what_rises_steeply_or_curves() -> None:
    frequency = np.exp(np.linspace(0.0, 2.0, 101))

    def respond(f: np.ndarray) -> dict[str, np.ndarray]:
        x = np.log(f)
        return {"transmission_loss": 60 * np.tanh(40 * (x - CENTRE)), "absorption": np.sin(8 * x) ** 2}

    assert hidden(frequency, respond(frequency), respond) == []
    few = frequency[:2]
    assert hidden(few, respond(few), respond) == []


def told(simulation: SimulationFile) -> list[str]:
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        simulate(simulation)
    return [str(entry.message) for entry in seen if "miss narrow resonances" in str(entry.message)]


def test_points_that_miss_a_cavity_resonance_are_told_once() -> None:
    (text,) = told(glazing(frequency={}))
    assert text.startswith(
        "200 frequencies miss narrow resonances: between two of them the transmission loss is up to "
    )
    assert " dB lower (at " in text
    assert text.endswith("ask for more points, or for third_octaves, whose means hold them")
    sweep = {"sweep": {"layers.gap.thickness": ["80 mm", "100 mm"]}, "frequency": {"points": 100}}
    (text,) = told(glazing(**sweep))
    assert text.startswith("gap.thickness = 80 mm: 100 frequencies miss narrow resonances: ")
    scatter = {"tolerances": {"layers.gap.thickness": "1 mm"}, "samples": 2, "frequency": {"points": 50}}
    assert len(told(glazing(**scatter))) == 1


@pytest.mark.parametrize(
    "asked",
    [
        {"frequency": {"third_octaves": [100, 3150]}},
        {"frequency": [100, 125, 160, 3400, 3500]},  # just these are wanted
        {"frequency": {}, "incidence": "diffuse"},
        {"frequency": {"from": 200, "to": 1000}},
    ],
)
def test_nothing_is_told_of_what_holds_resonances_or_has_none(asked: dict[str, Any]) -> None:
    assert told(glazing(**asked)) == []


def test_where_the_response_between_lines_is_refused_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> None:
        raise InputError("no response here")

    monkeypatch.setattr(tasks, "_real", refused)
    assert told(glazing(frequency={})) == []

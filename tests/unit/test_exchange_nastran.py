"""Cards of poroelastic layers: read back by the rules of large fields, they make the same stack."""

from typing import Any

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.exchange.nastran import poroelastic_cards
from multilayer.response import plane_wave
from multilayer.stack import Stack
from tests.analytic.materials import FOAM, FOAM2, SHEET

FREQUENCY = np.geomspace(100, 5000, 20)
MATPE1 = ("MID", "MAT1", "MAT10", "BIOT", *[""] * 4, "VISC", "GAMMA", "PRANDTL", "POR", "TOR", "AFR", "VLE", "TLE")
MAT1 = ("MID", "E", "G", "NU", "RHO", "A", "TREF", "GE")
MAT10 = ("MID", "BULK", "RHO", "C", "GE", "ALPHA", "", "")
NAMES = {"MATPE1": MATPE1, "MAT1": MAT1, "MAT10": MAT10}


def read(text: str) -> dict[str, list[dict[str, str]]]:
    """Return the fields that are not blank, by card: names in 8 columns, then four fields of 16 in every line."""
    result: dict[str, list[list[str]]] = {}
    card: list[str] = []
    for line in text.splitlines():
        assert len(line) <= 72
        assert line.isascii()
        if line.startswith("$"):
            continue
        head, fields = line[:8].strip(), [line[i : i + 16].strip() for i in range(8, 72, 16)]
        assert head.endswith("*")
        if head == "*":
            card += fields
        else:
            card = fields
            result.setdefault(head[:-1], []).append(card)
    assert all(len(card) % 8 == 0 for cards in result.values() for card in cards)
    return {
        name: [{key: value for key, value in zip(NAMES[name], card, strict=True) if value} for card in cards]
        for name, cards in result.items()
    }


def stack(*layers: dict[str, Any], **fields: Any) -> Stack:
    return Stack.model_validate({"layers": layers, "termination": "ambient", **fields})


def foams() -> Stack:
    return stack(
        {**FOAM2, "thickness": 0.02, "name": "Schaum ä\n$"}, {**SHEET, "thickness": 1e-3}, {**FOAM, "thickness": 0.01},
        ambient={"temperature": 300},
    )  # fmt: skip


@pytest.mark.parametrize("density", ["solid", "bulk"])
def test_read_back_the_cards_make_the_same_stack(density: Any) -> None:
    cards = read(poroelastic_cards(foams(), density, first_id=41))
    (gas,) = cards["MAT10"]
    frames = {frame["MID"]: frame for frame in cards["MAT1"]}
    layers = []
    for pores, thickness in zip(cards["MATPE1"], (0.02, 0.01), strict=True):
        frame, porosity = frames[pores["MAT1"]], float(pores["POR"])
        assert pores["MAT10"] == gas["MID"]
        layers.append({
            "type": "poroelastic", "thickness": thickness, "porosity": porosity,
            "flow_resistivity": float(pores["AFR"]), "tortuosity": float(pores["TOR"]),
            "viscous_length": float(pores["VLE"]), "thermal_length": float(pores["TLE"]),
            "frame_density": float(frame["RHO"]) * (1 - porosity if density == "solid" else 1),
            "young_modulus": float(frame["E"]), "poisson_ratio": float(frame["NU"]), "loss_factor": float(frame["GE"]),
        })  # fmt: skip
    (pores, _), air = cards["MATPE1"], {"temperature": 300}
    air |= {"density": float(gas["RHO"]), "sound_speed": float(gas["C"]), "viscosity": float(pores["VISC"])}
    air |= {"prandtl": float(pores["PRANDTL"]), "heat_capacity_ratio": float(pores["GAMMA"])}
    again = stack(layers[0], {**SHEET, "thickness": 1e-3}, layers[1], ambient=air)
    expected = plane_wave(foams(), FREQUENCY, 30.0)
    assert plane_wave(again, FREQUENCY, 30.0).reflection == pytest.approx(expected.reflection, rel=1e-7)
    assert float(gas["BULK"]) == pytest.approx(float(gas["RHO"]) * float(gas["C"]) ** 2, rel=1e-8)


def test_numbers_of_materials_are_unique() -> None:
    cards = read(poroelastic_cards(foams(), "bulk", first_id=7))
    assert sorted(int(card["MID"]) for each in cards.values() for card in each) == [7, 8, 9, 10, 11]


def test_names_stay_in_their_comment() -> None:
    text = poroelastic_cards(foams(), "bulk")
    (line,) = [line for line in text.splitlines() if "Schaum" in line]
    assert line == "$ layer Schaum \\xe4\\n$, 0.02 m thick"
    assert "$ without a card: layer 1 (elastic_plate)" in text


@pytest.mark.parametrize(
    "modulus", [1.4e5 + 1.4e4j, {"law": "loss_factor", "young_modulus": 1.4e5, "loss_factor": 0.1}]
)
def test_losses_of_a_constant_modulus(modulus: Any) -> None:
    layer = {**FOAM2, "thickness": 0.02, "young_modulus": modulus, "loss_factor": 0.0}
    (frame,) = read(poroelastic_cards(stack(layer), "bulk"))["MAT1"]
    assert (float(frame["E"]), float(frame["GE"])) == pytest.approx((1.4e5, 0.1))


LAW = {"law": "zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 2e5, "relaxation_time": 1e-4}
REFUSED = {
    "no layer is poroelastic, and MATPE1 holds no other": {**SHEET, "thickness": 1e-3},
    "layers.0.model: 'jcal' has no card": {**FOAM2, "thickness": 0.02, "model": "jcal", "thermal_permeability": 1e-9},
    "layers.0.young_modulus: depends on frequency": {
        **FOAM2,
        "thickness": 0.02,
        "young_modulus": LAW,
        "loss_factor": 0,
    },
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_a_card_cannot_hold_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=text):
        poroelastic_cards(stack(REFUSED[text]), "bulk")


def test_options_out_of_range() -> None:
    with pytest.raises(InputError, match="allowed: solid, bulk"):
        poroelastic_cards(foams(), "dense")  # type: ignore[arg-type]
    for number in (0, 99_999_999):
        with pytest.raises(InputError, match="a whole number from 1 to 99999995"):
            poroelastic_cards(foams(), "bulk", first_id=number)

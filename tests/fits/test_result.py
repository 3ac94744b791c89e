"""What a result says of itself."""

import csv
import io
import json

import numpy as np
import pytest

from multilayer.fits.result import MODULUS_COLUMNS, BurstFit, FitResult, Solution


def _burst(frequency: float, modulus: complex, accepted: bool = True) -> BurstFit:
    e1, e2 = modulus.real, modulus.imag
    solution, history = Solution(e1, e2, 0.001), np.array([[e1, e2, 0.1], [e1, e2, 0.001]])
    return BurstFit(
        "one", frequency, e1, 0.01 * e1, e2, 0.02 * e2, e2 / e1, 0.03, 1e-6, -0.01, accepted,
        reason="" if accepted else "no solution", solution=solution, history=history,
    )  # fmt: skip


def _result(order: float = 0.2, accepted: bool = True) -> FitResult:
    frequencies = np.arange(100.0, 1600.0, 100.0)
    return FitResult(
        "c", "least-squares", {}, [_burst(f, 1e5 * (1j * f / 100) ** order, accepted) for f in frequencies]
    )


@pytest.mark.parametrize("order", [0.05, 0.2, 0.4])
def test_gross_check_of_a_power_law(order: float) -> None:
    # E = (i w)^n: dlnE1/dlnw = n everywhere and E2/E1 = tan(n pi/2), so eq. (12) gives n pi/2 / tan(n pi/2) of E2
    check = _result(order).gross_check("one")
    expected = (order * np.pi / 2) / np.tan(order * np.pi / 2)
    assert check.predicted / check.measured == pytest.approx(expected, rel=1e-6)
    assert check.mean_relative_error == pytest.approx(1 - expected, rel=1e-4)


def test_no_slope_without_accepted_bursts() -> None:
    assert _result(accepted=False).gross_check("one") is None


def test_csv_has_the_promised_columns_and_digits() -> None:
    result = _result()
    rows = list(csv.DictReader(io.StringIO(result.to_csv())))
    assert tuple(rows[0]) == MODULUS_COLUMNS
    assert [float(row["E1_pa"]) for row in rows] == pytest.approx([b.storage_modulus for b in result.bursts], rel=1e-8)
    assert {row["accepted"] for row in rows} == {"true"}


def test_json_holds_reasons_and_convergence() -> None:
    data = json.loads(json.dumps(_result(accepted=False).to_dict()))
    assert data["all_accepted"] is False
    burst = data["bursts"][3]
    assert burst["reason"] == "no solution"
    assert len(burst["convergence"]["cost"]) == 2
    assert burst["optimum"]["E1_pa"] > 0

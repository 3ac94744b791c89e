"""Modulus laws that relax: limiting cases, against each other and against integrals, and what is refused."""

import re

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pydantic import ValidationError

from multilayer.media.laws import FractionalZener, FreeForm, HavriliakNegami, Maxwell, Table, Zener, read_modulus_table
from multilayer.media.laws.spectral import step_relaxation

FREQUENCIES = np.geomspace(1e-3, 1e9, 49)
PLATEAUS = {"relaxed_modulus": 1e5, "unrelaxed_modulus": 3e6, "relaxation_time": 2e-4}


HERTZ_AND_PASCAL = ([1e3, 2e3], [1e6, 2e6], [1e5, 3e5])


class TestTableInAFile:
    @pytest.mark.parametrize(
        "text",
        [
            "frequency,E1,E2\n1e3,1e6,1e5\n2e3,2e6,3e5\n",
            "frequency [kHz],E1 [MPa],E2 [kPa]\n1,1,100\n2,2,300\n",
            "f_khz,e1_mpa,e2_pa\n1,1,1e5\n2,2,3e5\n",
            "f/kHz;E1 / N/mm2;E2 (MPa)\n1;1;0,1\n2;2;0,3\n",
            "# of lot 7\nf [Hz]\tE1\tE2\n\n1e3\t1e6\t1e5  # damp\n2e3\t2e6\t3e5\n",
            "x,y [MPa],z [MPa]\n1e3,1,0.1\n2e3,2,0.3\n",
        ],
    )
    def test_units_of_its_header(self, text, tmp_path):
        (tmp_path / "rubber.csv").write_text(text)
        assert_allclose(read_modulus_table(tmp_path / "rubber.csv"), HERTZ_AND_PASCAL, rtol=1e-14)
        law = Table.model_validate({"file": "rubber.csv"}, context={"folder": tmp_path})
        assert law.storage_modulus == pytest.approx((1e6, 2e6))

    @pytest.mark.parametrize(
        ("text", "told"),
        [
            (
                "1,2,3\n2,3,4\n3,4,5\n",
                "1: begins with numbers; the first line that is no comment must name three columns",
            ),
            ("f,E1\n1,2\n2,3\n", "1: has 2 columns; the first line that is no comment must name three columns"),
            ("f [s],E1,E2\n1,2,3\n2,3,4\n", "1: column 'f [s]': '1 s' has the wrong unit"),
            ("f,E1,E2\n1,2,3\n2,x,4\n", "3: 'x' is no number"),
            ("f,E1,E2\n1,2,-3\n2,3,4\n", "2: frequency and E1 must be above 0, E2 at least 0"),
            ("f,E1,E2\n1,2,3\n", " needs two rows of values at least"),
        ],
    )
    def test_what_is_no_such_table(self, text, told, tmp_path):
        file = tmp_path / "rubber.csv"
        file.write_text(text)
        with pytest.raises(ValueError, match=f"^{re.escape(f'{file}:{told}')}"):
            read_modulus_table(file)

    @pytest.mark.parametrize(
        "text",
        [
            "f [kHz],E2 [MPa],E1 [MPa]\n1,0.1,1\n2,0.3,2\n",
            "E' (MPa);E'' (MPa);Frequency (kHz)\n1;0,1;1\n2;0,3;2\n",
            "Loss modulus E″ / MPa,Storage modulus E′ / MPa,freq / kHz\n0.1,1,1\n0.3,2,2\n",
            "frequency [kHz],E1 [MPa],tan delta\n1,1,0.1\n2,2,0.15\n",
            "Tan(δ) [%],f_khz,e1_mpa\n10,1,1\n15,2,2\n",
            "f [kHz],E [MPa],eta [-]\n1,1,0.1\n2,2,0.15\n",
            "storage modulus [MPa],loss factor,f [kHz]\n1,0.1,1\n2,0.15,2\n",
        ],
    )
    def test_columns_by_their_names(self, text, tmp_path):
        (tmp_path / "rubber.csv").write_text(text)
        assert_allclose(read_modulus_table(tmp_path / "rubber.csv"), HERTZ_AND_PASCAL, rtol=1e-14)

    @pytest.mark.parametrize(
        ("header", "told"),
        [
            ("f [Hz],G' [Pa],G'' [Pa]", "column 'G' [Pa]' holds shear moduli; write Young's moduli, E = 2 (1 + nu) G"),
            ("f [Hz],shear modulus [Pa],tan delta", "column 'shear modulus [Pa]' holds shear moduli"),
            ("f [Hz],E1 [-],E2 [Pa]", "column 'E1 [-]' holds no pure numbers; write its unit, as '[Pa]'"),
            ("f [Hz],E1 [Pa],E2 [%]", "column 'E2 [%]': '1 %' has the wrong unit"),
            ("f [Hz],E1 [Pa],tan delta [Pa]", "column 'tan delta [Pa]': '1 Pa' has the wrong unit"),
            ("f [Hz],E1 [Pa],E' [Pa]", "columns 'f [Hz]', 'E1 [Pa]', 'E' [Pa]' hold the same twice"),
            ("f [Hz],E2 [Pa],tan delta", "columns 'f [Hz]', 'E2 [Pa]', 'tan delta' hold the same twice"),
        ],
    )
    def test_columns_that_are_something_else(self, header, told, tmp_path):
        file = tmp_path / "rubber.csv"
        file.write_text(f"{header}\n100,1e6,0.1\n200,1e6,0.1\n")
        with pytest.raises(ValueError, match=f"^{re.escape(f'{file}:1: {told}')}"):
            read_modulus_table(file)

    def test_a_file_beside_columns(self):
        with pytest.raises(ValidationError, match="file stands beside frequency; give the file, or the three columns"):
            Table.model_validate({"file": "rubber.csv", "frequency": [1, 2]})


class TestSpecialCases:
    def test_zener_is_half_way_where_w_tau_is_one(self):
        law = Zener(**PLATEAUS)
        half = 2.9e6 / 2
        assert law(1 / (2 * np.pi * 2e-4)) == pytest.approx(1e5 + half + 1j * half)

    def test_fractional_zener_of_order_one_is_zener(self):
        assert_allclose(FractionalZener(**PLATEAUS, order=1.0)(FREQUENCIES), Zener(**PLATEAUS)(FREQUENCIES), rtol=1e-12)

    def test_symmetric_havriliak_negami_is_fractional_zener(self):
        skewed = HavriliakNegami(**PLATEAUS, order=0.4, asymmetry=1.0)
        assert_allclose(skewed(FREQUENCIES), FractionalZener(**PLATEAUS, order=0.4)(FREQUENCIES), rtol=1e-12)

    def test_maxwell_of_one_branch_is_zener(self):
        law = Maxwell(relaxed_modulus=1e5, branch_modulus=(2.9e6,), relaxation_time=(2e-4,))
        assert_allclose(law(FREQUENCIES), Zener(**PLATEAUS)(FREQUENCIES), rtol=1e-12)

    def test_a_narrow_step_is_a_maxwell_branch(self):
        peak = 1 / (2 * np.pi * 2e-4)
        law = FreeForm(relaxed_modulus=1e5, frequency=(peak / 1.001, peak * 1.001), rise=(2.9e6,))
        assert_allclose(law(FREQUENCIES), Zener(**PLATEAUS)(FREQUENCIES), rtol=1e-6)

    def test_cole_davidson_slopes(self):
        """E2 rises as f^alpha and falls as f^(-alpha beta)."""
        loss = HavriliakNegami(**PLATEAUS, order=0.8, asymmetry=0.5)(np.array([1e-9, 1e-8, 1e14, 1e15])).imag
        assert_allclose(np.log10(loss[[1, 3]] / loss[[0, 2]]), [0.8, -0.4], atol=1e-3)

    def test_plateaus_of_the_free_form(self):
        law = FreeForm(relaxed_modulus=1e5, frequency=(1.0, 1e2, 1e3), rise=(2e5, 3e6))
        assert_allclose(law(np.array([1e-12, 1e15])).real, [1e5, 3.3e6], rtol=1e-9)


@pytest.mark.parametrize("frequency", [1e-6, 0.3, 40.0, 2e5, 1e12])
def test_a_step_is_the_mean_of_its_relaxations(frequency):
    def element(log_frequency):
        x = mpmath.mpc(0, frequency) / mpmath.exp(log_frequency)
        return x / (1 + x)

    low, high = mpmath.log(2), mpmath.log(500)
    expected = complex(mpmath.quad(element, mpmath.linspace(low, high, 9)) / (high - low))
    found = complex(step_relaxation(frequency, 2.0, 500.0))
    assert found.real == pytest.approx(expected.real, rel=1e-12)
    assert found.imag == pytest.approx(expected.imag, rel=1e-12)


@given(
    order=st.floats(0.01, 1.0),
    product=st.floats(0.01, 1.0),
    ratio=st.floats(1.0, 1e6),
    time=st.floats(1e-15, 1e6),
)
def test_havriliak_negami_relaxes_throughout_its_range(order, product, ratio, time):
    law = HavriliakNegami(
        relaxed_modulus=1e5,
        unrelaxed_modulus=1e5 * ratio,
        relaxation_time=time,
        order=order,
        asymmetry=product / order,
    )
    modulus = law(np.geomspace(1e-6, 1e12, 200))
    assert np.all(modulus.imag >= 0)
    assert np.all(np.diff(modulus.real) >= -1e-12 * modulus.real[:-1])


class TestRefused:
    @pytest.mark.parametrize("law", [Zener, FractionalZener, HavriliakNegami])
    def test_a_modulus_that_falls(self, law):
        shape = {"order": 0.5, "asymmetry": 0.5}
        fields = {name: value for name, value in shape.items() if name in law.model_fields}
        with pytest.raises(ValidationError, match="unrelaxed_modulus must be at least relaxed_modulus"):
            law(**{**PLATEAUS, "unrelaxed_modulus": 9e4}, **fields)

    def test_a_negative_spectrum(self):
        with pytest.raises(ValidationError, match="order times asymmetry must be at most 1"):
            HavriliakNegami(**PLATEAUS, order=0.6, asymmetry=1.7)

    def test_a_product_of_one_up_to_rounding(self):
        assert HavriliakNegami(**PLATEAUS, order=0.3, asymmetry=1 / 0.3).asymmetry == 1 / 0.3

    @pytest.mark.parametrize("order", [0.0, 1.1, -0.5])
    def test_order(self, order):
        with pytest.raises(ValidationError, match="order"):
            HavriliakNegami(**PLATEAUS, order=order, asymmetry=0.5)

    def test_branches_that_do_not_pair(self):
        with pytest.raises(ValidationError, match="branch_modulus has 2 entries and relaxation_time 1"):
            Maxwell(relaxed_modulus=1e5, branch_modulus=(1e5, 1e5), relaxation_time=(1e-3,))

    def test_a_branch_that_creates_energy(self):
        with pytest.raises(ValidationError, match="at least 0"):
            Maxwell(relaxed_modulus=1e5, branch_modulus=(-1.0,), relaxation_time=(1e-3,))

    def test_steps_that_do_not_fit_between_the_nodes(self):
        with pytest.raises(ValidationError, match="3 frequencies bound 2 steps; rise has 1 entries"):
            FreeForm(relaxed_modulus=1e5, frequency=(1.0, 2.0, 3.0), rise=(1e5,))

    def test_nodes_out_of_order(self):
        with pytest.raises(ValidationError, match="must increase"):
            FreeForm(relaxed_modulus=1e5, frequency=(1.0, 3.0, 2.0), rise=(1e5, 1e5))


def test_units_may_be_written():
    law = Maxwell.model_validate(
        {"relaxed_modulus": "0.1 MPa", "branch_modulus": ["1 MPa", 2e5], "relaxation_time": ["1 ms", "20 us"]}
    )
    assert law.branch_modulus == (1e6, 2e5)
    assert law.relaxation_time == pytest.approx((1e-3, 2e-5))

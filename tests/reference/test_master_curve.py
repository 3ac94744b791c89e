"""The master curve of a measured foam; the whole study is ``python -m validation.master_curve``."""

import numpy as np
import pytest

from multilayer.errors import ValidityWarning
from multilayer.fits.law_fit import fit_law
from multilayer.media.kramers_kronig import check_kramers_kronig

master_curve = pytest.importorskip("multilayer_campaigns.master_curve").master_curve

from validation.master_curve import REFERENCE, ZERO, read_vn600  # noqa: E402


@pytest.fixture(scope="module")
def foam(shared):
    assert (shared / "measured" / "nist_vn600_dma.csv").is_file()
    return read_vn600()


@pytest.fixture(scope="module")
def foam_curve(foam):
    with pytest.warns(ValidityWarning, match="the data of 238.15 and 243.15 K do not overlap"):
        return master_curve(*foam, reference=REFERENCE)


@pytest.mark.reference
class TestFoam:
    """VN600: Landauer et al., Sci. Data 10:356 (2023)."""

    def test_one_curve_of_nineteen_temperatures(self, foam_curve):
        assert foam_curve.temperature.size == 19
        assert np.mean(foam_curve.relative_error) < 0.02
        assert np.all(np.diff(foam_curve.log_shift) < 0)
        assert np.log10(foam_curve.frequency.max() / foam_curve.frequency.min()) > 18

    @pytest.mark.parametrize(("name", "elements"), [("havriliak_negami", None), ("maxwell", 15), ("free_form", 20)])
    def test_laws_follow_the_whole_curve(self, foam_curve, name, elements):
        found = fit_law(name, foam_curve.frequency, foam_curve.modulus, elements=elements, starts=1 if elements else 4)
        assert found.mean_relative_error < 0.05
        assert found.mean_magnitude_error < 0.05

    @pytest.mark.parametrize(
        ("name", "elements"), [("fractional_zener", None), ("havriliak_negami", None), ("maxwell", 3)]
    )
    def test_laws_follow_the_curve_of_25_degrees(self, foam, name, elements):
        """The published fit of a fractional Zener law to it misses |E| by 8.2 %."""
        t, f, e = (values[foam[0] == REFERENCE] for values in foam)
        assert t.size == 11
        found = fit_law(name, f, e, elements=elements, starts=2)
        assert found.mean_relative_error < 0.03

    def test_wlf_holds_above_the_glass_transition(self, foam_curve):
        assert foam_curve.wlf(ZERO - 0.1).rms < 0.15
        assert foam_curve.wlf(ZERO - 0.1).rms < 0.5 * foam_curve.arrhenius(ZERO - 0.1).rms

    def test_one_isotherm_contradicts_itself(self, foam):
        """At 30 degC E1 rises less with frequency than E2 demands; at 25 degC all is well."""
        verdicts = {}
        for celsius in (25.0, 30.0):
            t, f, e = (values[foam[0] == ZERO + celsius] for values in foam)
            assert t.size == 11
            verdicts[celsius] = check_kramers_kronig(f, e, 0.02 * np.abs(e), 0.02 * np.abs(e)).verdict
        assert verdicts == {25.0: "consistent", 30.0: "inconsistent"}

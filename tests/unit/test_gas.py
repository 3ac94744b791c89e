"""Air, dry and humid, against published numbers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError

from multilayer.errors import InputError, ValidityWarning
from multilayer.media.gas import dry_air
from multilayer.media.humid_air import air_absorption, humid_air
from multilayer.response import plane_wave
from multilayer.stack import Ambient, Stack

ZERO = 273.15


class TestDensity:
    """CIPM-2007."""

    def test_reference_conditions(self):
        """IEC 61094-2:2009, annex F: 23 degC, 101325 Pa, 50 %, by the same equation of state."""
        assert humid_air(ZERO + 23, 101325.0, 0.5).density == pytest.approx(1.18608, abs=1e-5)

    def test_tabulated(self):
        """S. V. Gupta, Mass Metrology, p. 205: 10 degC, 730 mmHg, 40 %."""
        assert humid_air(ZERO + 10, 730 * 133.322, 0.4).density == pytest.approx(1.19569, abs=6e-6)

    def test_vapour_is_lighter_than_air(self):
        assert humid_air(relative_humidity=1.0).density < humid_air(relative_humidity=0.0).density


class TestSoundSpeed:
    # (temperature in degC, relative humidity, m/s) read off figure 1 of Cramer 1993, at 101325 Pa, 314 ppm of CO2
    FIGURE = np.array(
        [
            (0, 0.00474, 331.508), (0, 0.30174, 331.627), (0, 0.60032, 331.706), (0, 0.99526, 331.905),
            (10, 0.00632, 337.460), (10, 0.30332, 337.698), (10, 0.6019, 337.857), (10, 0.9921, 338.175),
            (20, 0.0079, 343.333), (20, 0.30174, 343.730), (20, 0.6019, 344.167), (20, 0.98736, 344.683),
            (30, 0.00474, 349.167), (30, 0.30332, 349.881), (30, 0.6019, 350.556), (30, 0.98894, 351.508),
        ]
    )  # fmt: skip

    def test_figure(self):
        ours = [humid_air(ZERO + t, 101325.0, h).sound_speed for t, h, _ in self.FIGURE]
        assert_allclose(ours, self.FIGURE[:, 2], atol=0.15)

    def test_dry_air_at_the_freezing_point(self):
        """331.45 m/s with an uncertainty of 0.05 m/s (Cramer 1993)."""
        assert humid_air(ZERO, 101325.0, 0.0).sound_speed == pytest.approx(331.45, abs=0.05)

    def test_reference_conditions(self):
        """345.866 m/s; IEC 61094-2:2009, annex F, by the same formula."""
        air = humid_air(ZERO + 23, 101325.0, 0.5)
        assert air.sound_speed == pytest.approx(345.866, abs=1e-3)
        assert air.heat_capacity_ratio == pytest.approx(1.40076, abs=1e-5)

    def test_agrees_with_density_and_heat_capacities(self):
        """The formulae are of different authors; an almost ideal gas ties them: rho c^2 = gamma P to 0.1 %."""
        for t in (0.0, 15.0, 30.0):
            for h in (0.0, 0.5, 1.0):
                air = humid_air(ZERO + t, 101325.0, h)
                ratio = air.density * air.sound_speed**2 / (air.heat_capacity_ratio * air.pressure)
                assert ratio == pytest.approx(1, abs=1e-3)


class TestTransport:
    @pytest.mark.parametrize("t", [0.0, 10.0, 20.0, 30.0])
    def test_prandtl_number_of_saturated_air(self, t):
        """Tsilingiris 2008, table 4: his fit to his own result."""
        fit = np.polyval([4.969218948e-9, -4.162785412e-7, 2.240599044e-5, -3.703124976e-4, 0.7215798365], t)
        assert humid_air(ZERO + t, 101325.0, 1.0).prandtl == pytest.approx(fit, abs=0.002)

    def test_viscosity_of_dry_air_is_sutherlands(self):
        for t in (0.0, 20.0, 30.0):
            assert humid_air(ZERO + t, 101325.0, 0.0).viscosity == pytest.approx(dry_air(ZERO + t).viscosity, rel=0.005)


class TestRange:
    @pytest.mark.parametrize(
        ("temperature", "pressure", "words"),
        [
            (ZERO - 10, 101325.0, r"temperatures \(degC\) from .* to 30; here it is -10$"),
            (ZERO + 35, 101325.0, r"temperatures .* here it is 35$"),
            (ZERO + 20, 6e4, r"pressures \(Pa\) from 75000 to 102000; here it is 6e\+04$"),
        ],
    )
    def test_outside(self, temperature, pressure, words):
        with pytest.warns(ValidityWarning, match=words):
            humid_air(temperature, pressure, 0.5)

    def test_ends_are_inside(self):
        humid_air(273.15, 101325.0, 0.5)
        humid_air(303.15, 101325.0, 0.5)


class TestAmbient:
    def test_dry_without_humidity(self):
        assert Ambient(temperature=290.0, pressure=1e5).gas == dry_air(290.0, 1e5)

    def test_humid(self):
        ambient = Ambient.model_validate({"temperature": "20 degC", "relative_humidity": "50 %"})
        assert ambient.gas == humid_air(293.15, 101325.0, 0.5)

    def test_given_properties_win(self):
        gas = Ambient(relative_humidity=0.5, prandtl=0.7).gas
        assert gas.prandtl == 0.7
        assert gas.density == humid_air(293.15, 101325.0, 0.5).density

    @pytest.mark.parametrize("value", [-0.1, 1.5, "50 Pa"])
    def test_no_fraction(self, value):
        with pytest.raises(ValidationError, match="relative_humidity"):
            Ambient.model_validate({"relative_humidity": value})


@pytest.mark.parametrize(
    ("celsius", "humidity", "expected"),
    [
        (10.0, 0.7, (0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117.0)),
        (20.0, 0.7, (0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6)),
        (30.0, 0.7, (0.1, 0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3)),
        (15.0, 0.5, (0.1, 0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129.0)),
        (15.0, 0.8, (0.1, 0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8)),
    ],
)
def test_absorption_of_air_as_tabulated(celsius, humidity, expected):
    # ISO 9613-2:1996, table 2: dB/km in octaves from 63 Hz, printed to 0.1, and to three digits
    octaves = 1000.0 * 10 ** (0.3 * np.arange(-4, 4))
    found = 8685.889638 * air_absorption(octaves, celsius + 273.15, relative_humidity=humidity)
    np.testing.assert_allclose(found, expected, rtol=4e-3, atol=0.051)


def test_absorption_of_air_broadcasts():
    found = air_absorption(np.array([[500.0], [4000.0]]), np.array([283.0, 293.0, 303.0]))
    assert found.shape == (2, 3)
    assert found[1, 2] == pytest.approx(float(air_absorption(4000.0, 303.0)), rel=1e-12)


@pytest.mark.parametrize(("humidity", "expected"), [(0.7, (2.8, 22.9)), (None, None)])
def test_a_path_through_absorbing_air(humidity, expected):
    """A kilometre between half-spaces of its air takes what the table says; 50 % of humidity where none is stated."""
    ambient = {} if humidity is None else {"relative_humidity": humidity}
    layer = {"type": "fluid", "thickness": 1000.0, "losses": "air"}
    frequency = 1000.0 * 10 ** (0.3 * np.array([-1, 2]))
    stack = Stack(ambient=ambient, layers=[layer], termination="ambient")
    loss = plane_wave(stack, frequency).transmission_loss
    if expected is None:
        expected = 8685.889638 * air_absorption(frequency)
    np.testing.assert_allclose(loss, expected, rtol=5e-3, atol=0.051)


@pytest.mark.parametrize(
    ("stated", "text"),
    [
        ({"density": 1000.0, "sound_speed": 1480.0}, "this fluid states density and sound_speed:"),
        ({"sound_speed": 340.0}, "this fluid states sound_speed:"),
    ],
)
def test_no_other_fluid_loses_what_air_does(stated, text):
    layer = {"type": "fluid", "thickness": 2.0, "losses": "air", **stated}
    with pytest.raises(InputError, match=text) as told:
        Stack(layers=[layer])
    assert "describe the air in 'ambient'" in str(told.value)

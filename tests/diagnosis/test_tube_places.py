"""Places of an impedance tube: laws drawn there, and simple forms of them."""

import numpy as np
import pytest

from multilayer.diagnosis.diagnose import chosen_effects
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.nominal import fitted_nominal
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.places import TUBE_PLACES
from multilayer.diagnosis.simple_forms import simple_form
from multilayer.diagnosis.tube.diagnose import diagnose_tube
from multilayer.experiments.places import SimpleLaw, Term
from multilayer.experiments.stacks.effects import Tube, TubeSetting, with_layers
from multilayer.experiments.stacks.observations import Observation, Scale
from multilayer.experiments.stacks.places import before_backing, with_factors
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.stacks.responses import WaveResponse
from multilayer.inference.least_squares import minimise
from multilayer.inference.whitening import CorrelatedError, ValueNoise
from multilayer.layers.fluid import Fluid
from multilayer.layers.screen import Screen
from multilayer.media.laws import complex_modulus
from multilayer.simulation.settings import PlaneIncidence
from multilayer.stack import Stack
from multilayer.testing.benches import tube_bench
from tests.diagnosis import tubes

F = np.geomspace(200.0, 1600.0, 24)
FOAM = {
    "type": "equivalent_fluid", "name": "foam", "porosity": 0.97, "flow_resistivity": 1e4, "tortuosity": 1.3,
    "viscous_length": 1e-4, "thermal_length": 2e-4,
}  # fmt: skip
FRAME = {"type": "poroelastic", "frame_density": 40.0, "young_modulus": 2e5, "poisson_ratio": 0.3, "loss_factor": 0.1}
NOISE = 0.003


@pytest.mark.parametrize("depth", [0.003, 0.03, 0.2])
def test_a_stack_before_a_backing_is_one_before_air(depth):
    setting = tube_bench().settings[0]
    plain = setting.reflection(setting.stack)[None]
    exact = setting.reflection(with_layers(setting.stack, (*setting.stack.layers, Fluid(thickness=depth))))
    seen = before_backing(setting, setting.stack, plain, np.exp(-2j * setting.wavenumber * depth)[None])
    assert np.abs(seen - exact).max() < 1e-13


def test_a_backing_that_reflects_nothing_is_open_air():
    setting = tube_bench().settings[0]
    plain = setting.reflection(setting.stack)[None]
    into_air = setting.stack.model_copy(update={"termination": "ambient"})
    seen = before_backing(setting, setting.stack, plain, np.zeros_like(plain))
    assert np.abs(seen - setting.reflection(into_air)).max() < 1e-12


@pytest.mark.parametrize("angle", [0.0, 45.0, 60.0])
def test_a_resistance_in_front_is_a_heavy_screen_at_any_angle(angle):
    bench = tube_bench().settings[0]
    setting = TubeSetting("tube", bench.frequency, angle, bench.stack, bench.tube)
    plain = setting.reflection(setting.stack)
    sheet = Screen(flow_resistance=300.0, surface_density=1e6)
    exact = setting.reflection(with_layers(setting.stack, (sheet, *setting.stack.layers)))
    seen = TUBE_PLACES["in_front"]().surface(setting, setting.stack, plain, np.full(plain.shape, 300.0 + 0j))
    np.testing.assert_allclose(seen, exact, atol=1e-7)


def measured(place, term, values, foam=FOAM):
    """Return a foam of two thicknesses in a tube, with a simple law at a place, and noise."""
    rng, n = np.random.default_rng(1), len(F)
    stacks = {
        name: Stack.model_validate({"version": 1, "layers": [{**foam, "thickness": thickness}]})
        for name, thickness in (("thin", 0.03), ("thick", 0.06))
    }

    def problem(shown):
        data = tuple(
            Observation(
                name, "reflection", name, "", F, shown[name],
                WaveResponse("reflection", F, PlaneIncidence(angle=0.0)), False, Scale(),
                ValueNoise(np.full(n, NOISE), np.full(n, NOISE)), np.ones(n, dtype=complex), CorrelatedError(0.003),
                n, np.arange(n), F,
            )
            for name in stacks
        )  # fmt: skip
        return StackProblem(stacks, (), data)

    blank = problem({name: np.zeros(n, dtype=complex) for name in stacks})
    law = SimpleLaw.at(place, (term,), F, place.scale(blank.settings, 1.0))
    z = np.array([p.prior.coordinate(v) for p, v in zip(law.parameters, values, strict=True)])
    shown = blank.with_effects(law).predict(z)
    noise = NOISE * (rng.standard_normal((2, n)) + 1j * rng.standard_normal((2, n)))
    nominal = problem({name: s + e for name, s, e in zip(stacks, shown, noise, strict=True)})
    return Fitted(nominal, minimise(nominal, nominal.start))  # nothing is unknown: the gap stays as it is


@pytest.mark.parametrize(
    ("name", "term", "values"),
    [
        ("behind", Term("power", 1), [-0.4]),
        ("in_front", Term("power", 0), [80.0]),
        ("beside", Term("power", 0), [0.1]),
        ("layer_density", Term("power", 0), [-0.3]),
        ("layer_bulk_modulus", Term("power", 0), [0.2]),
        ("layer_modulus", Term("power", 0), [-0.5]),
        ("layer_modulus", Term("fractional"), [0.6, 0.4]),  # a modulus that rises with frequency, and its losses
    ],
)
def test_the_place_and_the_simple_form_of_its_law(name, term, values):
    place = TUBE_PLACES[name]("foam") if name.startswith("layer") else TUBE_PLACES[name]()
    nominal = measured(place, term, values, FOAM | FRAME if name == "layer_modulus" else FOAM)
    first, second = [*fit_places(nominal).values()][:2]
    assert first.place.name == name
    assert first.log_evidence - second.log_evidence > 5
    form = simple_form(nominal, first)
    assert form.form.terms == (term,)
    deviations = np.sqrt(np.diag(form.fitted.minimum.covariance))[-len(values) :]
    true = [p.prior.coordinate(value) for p, value in zip(form.form.parameters, values, strict=True)]
    assert np.all(np.abs(form.fitted.minimum.z[-len(values) :] - true) < 4 * deviations)


def test_a_gap_beside_nothing_unknown_is_seen():
    nominal = measured(TUBE_PLACES["in_front"](), Term("power", 0), [80.0])
    assert nominal.minimum.cost > 10 * len(F)


def test_without_a_gap_no_place_is_better_than_none():
    nominal = measured(TUBE_PLACES["in_front"](), Term("power", 0), [0.0])
    best = next(iter(fit_places(nominal).values()))
    assert best.log_evidence < nominal.log_evidence + 3


def test_of_one_measurement_a_simple_law_tells_the_place(tmp_path):
    """Free laws explain one measurement nearly as well elsewhere; air behind the sample is a law of one parameter."""
    depth = 0.015
    file = tubes.measured(tmp_path, {"rear_air_gap": {"depth": depth}}, (0.03,), smooth=0.005)
    first, second, *_ = fit_places(fitted_nominal(file)).values()
    assert first.log_evidence - second.log_evidence < 10

    record = diagnose_tube(file, effects=chosen_effects(["microphone_gain"])).record
    assert record["verdict"] == "unknown"
    first, second, *_ = record["places"]
    assert first["place"] == "behind"
    assert second["behind"] > 30
    law = record["law"]
    true = -4 * np.pi * np.array(law["frequency_hz"]) / file.hypothesis.settings[0].gas.sound_speed * depth
    assert np.array(law["imag"]) == pytest.approx(true, rel=0.05)
    assert np.max(np.abs(law["real"])) < 0.05
    assert [(term["kind"], term["order"]) for term in law["form"]["terms"]] == [("power", 1)]


def test_effects_of_tubes_name_places():
    named = {name: effect.place for name, effect in chosen_effects().items() if effect.kind == "tube"}
    assert named["rear_air_gap"] == "behind"
    assert named["facing"] == "in_front"


RISING = {
    "law": "fractional_zener",
    "relaxed_modulus": 1.2e5,
    "unrelaxed_modulus": 9e5,
    "relaxation_time": 2e-4,
    "order": 0.7,
}


@pytest.mark.slow
def test_a_modulus_of_the_frame_that_varies_with_frequency_is_told_and_drawn(tmp_path):
    layer = tubes.with_modulus(RISING)
    record = diagnose_tube(
        tubes.measured(tmp_path, {}, seed=7, smooth=0.005, layer=layer, nominal=tubes.ELASTIC)
    ).record
    assert record["verdict"] == "unknown", record["sentence"]
    first, *others = record["places"]
    assert (first["place"], first["configuration"]) == ("layer_modulus", "foam")
    assert min(place["behind"] for place in others) > 30
    drawn = {key: np.array(value) for key, value in record["law"].items() if isinstance(value, list)}
    modulus = Stack.model_validate(tubes.foam(0.03, layer)).layers[0].young_modulus
    nominal = tubes.ELASTIC["young_modulus"] * (1 + 1j * tubes.ELASTIC["loss_factor"])
    true = np.log(complex_modulus(modulus, 0.0, drawn["frequency_hz"]) / nominal)
    assert np.ptp(true.real) > 0.5
    for part, values in (("real", true.real), ("imag", true.imag)):
        assert np.mean((drawn[f"{part}_low"] < values) & (values < drawn[f"{part}_high"])) >= 0.8
    assert np.min(drawn["real_high"] - drawn["real_low"]) < 0.3  # where the frame moves it is known well
    assert record["law"]["passive"]
    assert record["law"]["causal"]


def test_an_elastic_frame_as_stated_is_no_gap(tmp_path):
    record = diagnose_tube(tubes.measured(tmp_path, {}, smooth=0.005, layer=tubes.ELASTIC)).record
    assert record["verdict"] == "no_gap", record["sentence"]


def test_what_changes_depart_from():
    stack = Stack.model_validate({"version": 1, "layers": [{**FOAM, **FRAME, "thickness": 0.03}]})
    setting, f = TubeSetting("tube", F, 0.0, stack, Tube()), np.array([1e-3, 300.0, 2e5])
    nominal = {}
    for name in ("layer_modulus", "layer_density", "layer_bulk_modulus"):
        place = TUBE_PLACES[name]("foam")
        nominal[name] = np.exp(place.departs_from(setting, f))
        assert np.all(place.passive_sign * nominal[name].imag > 0)
        assert TUBE_PLACES[name]("other").departs_from(setting, f) is None
    gas, porosity = setting.gas, FOAM["porosity"]
    np.testing.assert_allclose(nominal["layer_modulus"], 2e5 * (1 + 0.1j))
    # friction at low frequencies, inertia at high ones
    resistivity = (2j * np.pi * f[0] * nominal["layer_density"][0]).real
    np.testing.assert_allclose(resistivity, FOAM["flow_resistivity"], rtol=1e-3)
    inertia = FOAM["tortuosity"] * gas.density / porosity
    np.testing.assert_allclose(nominal["layer_density"][-1].real, inertia, rtol=0.08)
    adiabatic = gas.heat_capacity_ratio * gas.pressure / porosity
    ends = np.array([adiabatic / gas.heat_capacity_ratio, adiabatic])
    np.testing.assert_allclose(nominal["layer_bulk_modulus"][[0, -1]].real, ends, rtol=0.03)


def test_changes_of_one_layer_add_up():
    bench = tube_bench(elastic=True)
    setting, (stack, *_) = bench.settings[0], bench.stacks.values()
    factors = {"density": 1.2 - 0.1j, "bulk_modulus": 0.9 + 0.1j, "young_modulus": 2 + 0.3j}
    at_once = setting.reflection(with_factors(stack, "foam", **factors))
    for name, factor in factors.items():
        stack = with_factors(stack, "foam", **{name: factor})
    np.testing.assert_allclose(setting.reflection(stack), at_once, rtol=1e-12)
    assert with_factors(stack, "other", density=2.0) is stack


@pytest.mark.parametrize("kind", ["poroelastic", "elastic_solid", "elastic_plate"])
def test_a_factor_on_the_modulus_is_another_modulus(kind):
    skeleton = {name: FRAME[name] for name in ("young_modulus", "poisson_ratio")}
    slab = {"type": kind, "name": "foam", "thickness": 0.02, "density": 40.0, **skeleton}
    layer = {**FOAM, **FRAME, "thickness": 0.02, "loss_factor": 0.0} if kind == "poroelastic" else slab

    def reflection(young_modulus, factor):
        before_air = [layer | {"young_modulus": young_modulus}, {"type": "fluid", "thickness": 0.05}]
        stack = Stack.model_validate({"version": 1, "layers": before_air})
        setting = TubeSetting("tube", F, 60.0, stack, Tube())
        return setting.reflection(with_factors(stack, "foam", young_modulus=factor))

    plain, changed = (reflection(2e6, factor) for factor in (1.0, 1.5 + 0.6j))
    np.testing.assert_allclose(changed, reflection(2e6 * (1.5 + 0.6j), 1.0), rtol=1e-12)
    assert np.abs(changed - plain).max() > 1e-3

"""Places with free laws: their derivative, which place is found, and which simple form the law has."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from multilayer.diagnosis import diagnose
from multilayer.diagnosis.cross_validation import folds
from multilayer.diagnosis.effects.delamination import Delamination, WornRim
from multilayer.diagnosis.fitting import Fitted, fit, minimise_scaled
from multilayer.diagnosis.further_laws import search_open_rims, with_differing_laws, with_open_rims, with_resonances
from multilayer.diagnosis.moduli import moduli
from multilayer.diagnosis.place_fits import SimpleForm, as_told, fit_places, free_to_differ, is_explained
from multilayer.diagnosis.places import PLACES
from multilayer.diagnosis.places.beside import Faces, LowerFace, OpenFaces, UpperFace
from multilayer.diagnosis.places.one_configuration import HeightOfOne, PlateOfOne, ReadingOfOne
from multilayer.diagnosis.places.sample import SampleShape
from multilayer.diagnosis.simple_forms import simple_form
from multilayer.diagnosis.thresholds import DRAWN_ERROR
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.experiments.places import SHIFT, SHORT, DrawnLaw, MovingLaw, SimpleLaw, TabulatedLaw, Term, VaryingLaw
from multilayer.experiments.two_plate.effects import Chain
from multilayer.experiments.two_plate.motion import _between_layers, top_over_base
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.fits.sources import read_fit
from multilayer.inference.derivative import central
from multilayer.inference.priors import Priors
from multilayer.media.elastic import p_wave_modulus
from multilayer.testing.benches import joint_bench, soft_sample
from tests.diagnosis.rigs import CENTRES, TRIED, F, campaign, measured, measured_with, problem
from tests.fits.rods import campaign_of_rods, fractional_zener


def checked_slopes(problem, rng):
    """Return the derivative of a problem's residual by finite differences, which its own must be."""
    z = 0.3 * rng.standard_normal(len(problem.parameters))
    residual, jacobian = problem.linearised(z)
    expected, slopes = central(problem.residual, z)
    assert residual == pytest.approx(expected)
    assert np.max(np.abs(jacobian - slopes)) < 1e-4 * np.max(np.abs(slopes))
    return slopes


def test_the_derivative_by_the_nodes_is_that_of_finite_differences():
    bench = joint_bench()
    frequency = np.concatenate([data.frequency for data in bench.data])
    registered = [place for name in PLACES.names() for place in PLACES[name].instances(bench.settings)]
    for place in (*registered, OpenFaces(0.16, 0.1)):
        problem = bench.with_effects(DrawnLaw.at(place, frequency, 0.05 * place.scale(bench.settings, 2e5)))
        checked_slopes(problem, np.random.default_rng(0))


def test_the_derivative_by_the_nodes_of_a_law_that_is_given():
    bench = joint_bench()
    frequency = np.concatenate([data.frequency for data in bench.data])
    given, law = (DrawnLaw.at(PLACES[name](), frequency, 0.05) for name in ("reading", "added_reading"))
    problem = replace(bench, given=(given,)).with_effects(law)
    checked_slopes(problem, np.random.default_rng(0))


@pytest.mark.parametrize("kind", [MovingLaw, VaryingLaw])
def test_the_derivative_by_what_differs_of_a_law_is_that_of_finite_differences(kind):
    bench = joint_bench()
    frequency = np.concatenate([data.frequency for data in bench.data])
    names = [data.name for data in bench.data]
    for name in ("reading", "top_plate", "sample"):
        place = PLACES[name]()
        law = DrawnLaw.at(place, frequency, 0.05 * place.scale(bench.settings, 2e5), SHORT)
        problem = bench.with_effects(kind.of(law, dict(zip(names, names, strict=True))))
        slopes = checked_slopes(problem, np.random.default_rng(0))
        assert np.abs(slopes[:, -len(names) :]).max(axis=0).min() > 0  # each does something


def drawn_laws(place, f, scale, rng):
    """Yield a law of each kind at a place, with coordinates that are drawn, and its values there by name."""
    table = rng.standard_normal(30) + 1j * rng.standard_normal(30)
    for law in (
        DrawnLaw.at(place, f, scale),
        SimpleLaw.at(place, (Term("resonance"),), f, scale),
        TabulatedLaw.of(place, "known", f, scale * table, np.full(30, scale * (1 + 1j))),
    ):
        own = rng.standard_normal(len(law.parameters))
        names = [parameter.name for parameter in law.parameters]
        yield law, own, dict(zip(names, Priors.of(law.parameters).values(own)[:, None, None], strict=True))


def test_a_law_that_moves_is_the_law_at_other_frequencies():
    """Every law of every place, by a factor of 1.2 in one configuration and none in the others."""
    bench = joint_bench()
    z, f = soft_sample(bench), np.geomspace(50.0, 3000.0, 30)
    shifted = replace(bench, configurations=[replace(d, frequency=d.frequency / 1.2) for d in bench.configurations])
    first, *others = [data.name for data in bench.data]
    rng = np.random.default_rng(3)
    for place in (PLACES[name]() for name in PLACES.names()):
        scale = 0.05 * place.scale(bench.settings, 2e5)
        for law, own, values in drawn_laws(place, f, scale, rng):
            moved = replace(law, at_place=place.differing({first: np.log(1.2)}))
            for here, there in zip(bench.settings, shifted.settings, strict=True):
                expected = law.values(there if here.data.name == first else here, values)
                np.testing.assert_allclose(moved.values(here, values), expected, rtol=1e-9, atol=1e-9 * scale)
            still, change = (bench.with_effects(each).differences(np.append(z, own)) for each in (law, moved))
            assert [np.allclose(a, b) for a, b in zip(still, change, strict=True)][1:] == [True] * len(others)
    assert place.moved == {}


def test_a_law_that_varies_is_the_law_times_a_factor():
    bench = joint_bench()
    f, (first, *_) = np.geomspace(50.0, 3000.0, 30), [data.name for data in bench.data]
    rng = np.random.default_rng(3)
    for place in (PLACES[name]() for name in PLACES.names()):
        scale = 0.05 * place.scale(bench.settings, 2e5)
        for law, _, values in drawn_laws(place, f, scale, rng):
            varied = replace(law, at_place=place.differing(factors={first: -0.7}))
            for here in bench.settings:
                factor = -0.7 if here.data.name == first else place.usual_factor
                expected = law.values(here, values) * factor
                np.testing.assert_allclose(varied.values(here, values), expected, rtol=1e-12, atol=1e-15 * scale)


def test_samples_and_plates_of_another_radius_are_others():
    pieces = problem().pieces
    assert [*pieces["sample"].values()] == [
        *["thickness[0.0125]"] * 2, *["thickness[0.025]"] * 2, *["thickness[0.04]"] * 2,
        "thickness[0.025, radius 0.012]",
    ]  # fmt: skip
    assert [*pieces["top plate"].values()][-3:] == [
        "top_plate_mass[0.001]", "top_plate_mass[0.003]", "top_plate_mass[0.001, radius 0.012]",
    ]  # fmt: skip
    stated = [parameter.name for parameter in problem().parameters if parameter.nuisance]
    assert {*pieces["sample"].values(), *pieces["top plate"].values()} <= {*stated}


@pytest.mark.slow
def test_samples_that_differ_much_are_told_with_whatever_law_was_there_before():
    """Alone, the place is searched to the end before, with a small law, as there is none in all samples alike."""
    factors = {f"c{i}": 1.0 + 0.5 * np.sin(3.0 * i) for i in range(7)}
    nominal = measured((PLACES["sample"]().differing(factors=factors), Term("power"), [0.3]))
    places = with_differing_laws(VaryingLaw, nominal, fit_places(nominal, names=["sample"]))
    assert places["sample"].place.factors
    moved = with_differing_laws(MovingLaw, nominal, places)["sample"]
    assert not (moved.place.factors and moved.place.moved)  # what differs twice would have to be paid for twice


@pytest.mark.slow
def test_samples_that_differ_are_told_as_such_and_no_more_than_they_do():
    """ln E differs by a factor of its own at each of seven mountings, and not beside."""
    factors = {f"c{i}": 1.0 + 0.5 * np.sin(3.0 * i) for i in range(7)}
    nominal = measured((PLACES["sample"]().differing(factors=factors), Term("power"), [0.1]))
    places = with_differing_laws(VaryingLaw, nominal, fit_places(nominal, names=["sample", "sample_order", "reading"]))
    first = next(iter(places.values()))
    assert first.place.name == "sample"
    assert first.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1
    law = first.law().real.mean()
    told = np.array([law * first.place.factors[name] for name in factors])
    true = 0.1 * np.array(list(factors.values()))
    # heights are known to 0.4 %, and so is what they do
    np.testing.assert_allclose(told - told.mean(), true - true.mean(), atol=0.005)
    plain = measured((PLACES["reading"](), Term("power"), [0.05]))
    places = fit_places(plain, names=["sample", "reading"])
    assert not with_differing_laws(VaryingLaw, plain, places)["reading"].place.factors


@pytest.mark.slow
def test_a_law_that_differs_from_plate_to_plate_is_told_so_and_the_modulus_knows():
    """The plates of 3 mm are lighter by 6 %, those of 1 mm as stated: less of the sample's modulus is known then."""
    plates = {f"c{i}": by for i, by in enumerate([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0])}
    nominal = measured((PLACES["plate"]().differing(factors=plates), Term("power"), [-0.06]))
    at = with_differing_laws(VaryingLaw, nominal, fit_places(nominal, names=["plate"]))["plate"]
    assert at.place.differs_by == "top plate"
    assert at.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1
    told = [at.law().real.mean() * at.place.factors[name] for name in ("c0", "c1")]
    assert told[1] - told[0] == pytest.approx(-0.06, abs=0.005)
    assert at.place.factors["c0"] == at.place.factors["c2"] == at.place.factors["c4"] != at.place.factors["c1"]
    true = problem().own_modulus(soft_sample(problem()), F).real
    widths = []
    for explanation in (at.fitted, free_to_differ(at)):
        (f, told) = (moduli(nominal, [(1.0, explanation)])[key] for key in ("frequency_hz", "corrected"))
        low, high = (np.interp(F, f, told[f"E1_{end}"]) for end in ("low", "high"))
        widths.append(np.mean((high - low) / true))
    assert np.mean((low < true) & (true < high)) > 0.9
    assert widths[1] > 1.1 * widths[0]


@pytest.mark.slow
def test_a_resonance_that_moves_from_mounting_to_mounting_is_found_and_drawn():
    factors = {f"c{i}": 1.15 - 0.05 * i for i in range(7)}
    place = PLACES["reading"]().differing({name: float(np.log(factor)) for name, factor in factors.items()})
    nominal = measured((place, Term("resonance"), [0.05, 500.0, 0.25]))
    n = len(nominal.minimum.residual)
    places = with_resonances(nominal, fit_places(nominal, names=["reading", "beside", "one_configuration"]))
    assert min(fit.explanation.minimum.misfit for fit in places.values()) / n > 4
    first, second, *_ = with_differing_laws(MovingLaw, nominal, places).values()
    assert first.place.name == "reading"
    assert first.log_evidence > second.log_evidence + 1000
    assert first.explanation.minimum.misfit / n < 1.1
    middle = np.mean([np.log(factor / first.place.entry["moved"][name]) for name, factor in factors.items()])
    for name, factor in factors.items():  # how the law as it is told lies to them is arbitrary
        assert first.place.entry["moved"][name] * np.exp(middle) == pytest.approx(factor, rel=0.01)
    peak = first.grid[np.argmax(np.abs(first.law()))]
    assert peak * np.exp(-middle) == pytest.approx(500.0, rel=0.04)


@pytest.mark.parametrize("picked", [(1, 4), (1, 3, 6)])
@pytest.mark.slow
def test_a_sharp_resonance_is_found_wherever_it_acts(shared, picked):
    """1.22 g on a spring on the plates of another solver: of few configurations no smooth law shows where it acts."""
    job = read_fit(shared / "campaigns" / "round-1" / "foreign-attached-resonator")
    few = tuple(job.campaign.configurations[i] for i in picked)
    nominal, _ = diagnose.fit_nominal(job.campaign.model_copy(update={"configurations": few}), job.recordings)
    first, second, *_ = with_resonances(nominal, fit_places(nominal)).values()
    assert first.place.name == "top_plate"
    assert first.log_evidence > second.log_evidence + 1e5
    assert first.explanation.minimum.cost_per_datum < 10


@pytest.mark.slow
def test_places_are_searched_farther_where_an_effect_fits_and_is_not_the_cause(monkeypatch):
    """No law at a place fits, and the verdict is "unknown": an effect that fits does not tell the place."""
    place = PLACES["reading"]().differing({f"c{i}": 0.15 - 0.05 * i for i in range(7)})
    nominal = measured((place, Term("resonance"), [0.05, 500.0, 0.25]))
    monkeypatch.setattr(diagnose, "fit_nominal", lambda *given, **others: (nominal, [nominal.minimum]))
    monkeypatch.setattr(diagnose, "lack_of_fit", lambda fitted: "")  # as of an effect that fits
    few = partial(fit_places, names=["reading", "beside", "one_configuration"])
    monkeypatch.setattr(diagnose, "fit_places", few)
    told = []
    effects = diagnose.chosen_effects(["channel_gain", "crosstalk"])
    record = diagnose.diagnose_campaign(campaign(), {}, effects, progress=told.append).record
    assert record["verdict"] == "unknown"
    assert record["places"][0]["place"] == "reading"
    assert len(record["law"]["moved"]) == 7
    assert record["gap"]["shrinkage"] > 0.98
    assert len(told) == diagnose.N_STEPS


@pytest.mark.slow
def test_shifts_cost_the_evidence_of_their_fit():
    """A law that does not move is not told to: its evidence is lower by what seven shifts cost."""
    nominal = measured((PLACES["reading"](), Term("resonance"), [0.05, 500.0, 0.25]))
    places = with_resonances(nominal, fit_places(nominal, names=["reading", "beside"]))
    found = with_differing_laws(MovingLaw, nominal, places)
    assert next(iter(found)) == "reading"
    assert not found["reading"].place.moved


@pytest.mark.slow
def test_no_law_is_told_to_move_farther_than_is_probable():
    factors = dict(zip([f"c{i}" for i in range(7)], np.geomspace(0.2, 5.0, 7), strict=True))
    place = PLACES["reading"]().differing({name: float(np.log(factor)) for name, factor in factors.items()})
    nominal = measured((place, Term("resonance"), [0.05, 500.0, 0.25]))
    places = fit_places(nominal, names=["reading", "beside", "added_reading"])
    for found in with_differing_laws(MovingLaw, nominal, places).values():
        assert sum((shift / SHIFT) ** 2 for shift in found.place.moved.values()) < 24.4  # chi-square of 7, p 0.001


def test_a_single_configuration_has_nothing_to_move_to():
    nominal = measured((PLACES["reading"](), Term("resonance"), [0.05, 500.0, 0.25]))
    one = nominal.hypothesis.with_data(nominal.hypothesis.data[:1])
    alone = fit(one, soft_sample(one))
    places = {"reading": fit_places(nominal, names=["reading"])["reading"]}
    assert with_differing_laws(MovingLaw, alone, places) == places


def test_a_drawn_law_goes_through_its_nodes_and_is_smooth():
    place = PLACES["reading"]()
    law = DrawnLaw.at(place, np.array([100.0, 1600.0]), 0.1)
    draws = np.random.default_rng(1).standard_normal((4000, 2 * len(law.nodes)))
    values = law.drawn(draws, np.geomspace(100, 1600, 40))
    assert np.std(values.real, axis=0) == pytest.approx(0.1, rel=0.1)  # between nodes as at them
    assert np.std(values.imag, axis=0) == pytest.approx(0.1, rel=0.1)
    near = np.corrcoef(values.real[:, 0], values.real[:, 1])[0, 1]
    far = np.corrcoef(values.real[:, 0], values.real[:, -1])[0, 1]
    assert near > 0.95
    assert abs(far) < 0.1


@pytest.mark.parametrize(
    ("term", "values", "law"),
    [
        (Term("power", 1), [2.0], lambda f: 2.0 * 1j * f / 400),
        (Term("lossy"), [2.0, 0.3], lambda f: 2.0 * (1 + 0.3j) + 0 * f),
        (Term("fractional"), [2.0, 0.5], lambda f: 2.0 * np.sqrt(1j * f / 400)),
        (Term("relaxation"), [2.0, 100.0], lambda f: 2.0 / (1 + 1j * f / 100)),
        (Term("resonance"), [2.0, 100.0, 0.1], lambda f: 2.0 * (1 + 0.1j) / (1 + 0.1j - (f / 100) ** 2)),
    ],
)
def test_simple_laws(term, values, law):
    f = np.array([50.0, 100.0, 800.0])
    form = SimpleLaw.at(PLACES["top_plate"](), (term,), np.array([100.0, 1600.0]), 1.0)
    assert form.centre == pytest.approx(400.0)
    shown = form.law_at(f, [np.array([value]) for value in values])
    assert shown == pytest.approx(law(f))


@pytest.mark.parametrize(
    ("name", "term", "values"),
    [
        ("top_plate", Term("power", 0), [1.5e-3]),
        pytest.param("top_plate", Term("resonance"), [1.5e-3, 600.0, 0.05], marks=pytest.mark.slow),
        pytest.param("faces", Term("lossy"), [3e-9, -0.3], marks=pytest.mark.slow),
        pytest.param("beside", Term("lossy"), [2e3, 0.2], marks=pytest.mark.slow),
        ("reading", Term("power", 1), [-0.05]),
        ("added_reading", Term("power", 0), [0.03]),
    ],
)
def test_the_place_and_the_simple_form_of_its_law(name, term, values):
    nominal = measured((PLACES[name](), term, values))
    places = fit_places(nominal, names=TRIED)
    if not is_explained(place.fitted for place in places.values()):
        places = with_resonances(nominal, places)
    first, second = [*places.values()][:2]
    assert first.place.name == name
    assert first.log_evidence - second.log_evidence > 20
    assert first.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1
    form = simple_form(nominal, first)
    assert form.form.terms == (term,)
    assert form.log_evidence > first.log_evidence - 1e-2
    fitted, deviations = form.fitted, np.sqrt(np.diag(form.fitted.minimum.covariance))[-len(values) :]
    true = [p.prior.coordinate(v) for p, v in zip(form.form.parameters, values, strict=True)]
    assert np.all(np.abs(fitted.minimum.z[-len(values) :] - true) < 4 * deviations)


WRONG = [(PlateOfOne, "top_plate_thickness"), (HeightOfOne, "specimen_thickness")]


@pytest.mark.parametrize(("kind", "field"), WRONG, ids=["plate", "height"])
@pytest.mark.parametrize("share", [pytest.param(0.1, marks=pytest.mark.slow), -0.04])
def test_a_wrong_entry_of_one_configuration_is_told_as_what_it_is(kind, field, share):
    """Of rods, of which the file says what is not so of one in four."""
    described, recordings = campaign_of_rods(
        fractional_zener(1.2e5, 12 * 1.2e5, 2e-5, 0.45), frequencies=(150.0, 300.0, 500.0, 700.0, 900.0, 1200.0),
        thicknesses=(0.0125, 0.025), top_plates=(0.001, 0.003), tail=0.4, noise=(0.002, 0.002),
    )  # fmt: skip
    configurations = list(described.configurations)
    right = configurations[2]
    configurations[2] = right.model_copy(update={field: getattr(right, field) / (1 + share)})
    nominal, _ = diagnose.fit_nominal(described.model_copy(update={"configurations": configurations}), recordings)
    first, second, *_ = fit_places(nominal).values()
    assert (type(first.place), first.place.configuration) == (kind, right.name)
    assert first.log_evidence - second.log_evidence > 10
    form = simple_form(nominal, first)
    assert form.form.terms == (Term("power", 0),)
    value, deviation = form.fitted.minimum.z[-1], np.sqrt(form.fitted.minimum.covariance[-1, -1])
    assert abs(value - form.form.parameters[0].prior.coordinate(share)) < 4 * deviation


def test_another_height_is_that_of_the_rod():
    """The place's modulus and density stand for a height; beside a chain of that height."""
    bench = joint_bench()
    configuration = bench.settings[0].configuration
    law = SimpleLaw.at(HeightOfOne(configuration.name), (Term("power", 0),), F, 1.0)
    z = soft_sample(bench)
    share = law.parameters[0].prior.coordinate(0.2)
    found = bench.with_effects(law).differences(np.append(z, share))
    campaign = bench.campaign
    higher = configuration.model_copy(update={"specimen_thickness": 1.2 * configuration.specimen_thickness})
    described = campaign.model_copy(update={"configurations": [higher, *campaign.configurations[1:]]})
    rigs = {each.name: PlaneWaveRig.of(described, each) for each in described.configurations}
    expected = replace(bench, campaign=described, rigs=rigs).differences(z)
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", PLACES["top_plate"].variants())
@pytest.mark.parametrize(
    ("term", "values"),
    [(Term("power", 0), [3e-3]), pytest.param(Term("resonance"), [5e-3, 900.0, 0.05], marks=pytest.mark.slow)],
    ids=["mass", "resonance"],
)
def test_what_bends_the_plate_is_told_from_what_does_not(kind, term, values):
    nominal = measured((kind(), term, values))
    places = fit_places(nominal, names=["top_plate", "beside"])
    if not is_explained(place.fitted for place in places.values()):
        places = with_resonances(nominal, places)
    first = next(iter(places.values()))
    assert type(first.place) is kind
    assert first.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1


def rod(modulus, density, length, omega):
    """Displacement and force per area at the driven end of a rod, by those at the other, shape (..., 2, 2)."""
    k = omega * np.sqrt(density / modulus)
    c, s = np.cos(k * length), np.sin(k * length)
    return np.moveaxis(np.array([[c, -s / (modulus * k)], [modulus * k * s, c]]), (0, 1), (-2, -1))


def spring(compliance):
    zero, one = np.zeros_like(compliance), np.ones_like(compliance)
    return np.moveaxis(np.array([[one, -compliance], [zero, one]]), (0, 1), (-2, -1))


@pytest.mark.parametrize(("lower", "upper"), [(1, 1), (1, 0), (0, 1), (0.3, 2)])
def test_layers_at_the_faces_are_springs_in_the_chain(lower, upper):
    """Beside transfer matrices of plates, springs and sample."""
    bench, f = joint_bench(), np.geomspace(20.0, 3000.0, 40)
    setting, experiment, omega = bench.settings[0], bench.experiments[0], 2 * np.pi * f + 0j
    base, plate, height = bench.campaign.base_plate, bench.campaign.top_plate, setting.configuration.specimen_thickness
    modulus, compliance = 2e5 * (1 + 0.3j) * np.ones_like(omega), 2e-8 * (1 - 0.2j) * np.sqrt(1000 / f)
    plain = Chain(modulus, bench.campaign.specimen.density, height, setting.plate_mass)
    softer = plain.softer_at(lower=lower * compliance).softer_at(upper=upper * compliance)
    found = top_over_base(experiment.near, setting, f, softer)
    thickness, ratio = setting.configuration.top_plate_thickness, bench.campaign.specimen.poisson_ratio
    held = modulus * p_wave_modulus(1.0, ratio)
    dense = setting.plate_mass / (setting.area * thickness)
    whole = (
        rod(p_wave_modulus(base.young_modulus, base.poisson_ratio), base.density, base.thickness, omega)
        @ spring(lower * compliance)
        @ rod(held, plain.density, height, omega)
        @ spring(upper * compliance)
        @ rod(p_wave_modulus(plate.young_modulus, plate.poisson_ratio), dense, thickness, omega)
    )
    np.testing.assert_allclose(found, 1 / whole[:, 0, 0], rtol=1e-5)  # a layer of the chain is a micrometre thick


def test_glue_and_layers_of_one_face_add_up():
    chain = Chain(1e5, 80.0, 0.025, 0.01).glued(2e8).softer_at(upper=1e-9)
    assert chain.compliances == pytest.approx((5e-9, 6e-9), rel=1e-12, abs=0)


def test_forces_between_layers_are_those_of_springs_in_series():
    rng = np.random.default_rng(5)
    on_top, on_base, lower, upper = (rng.standard_normal(6) + 1j * rng.standard_normal(6) for _ in range(4))
    found = _between_layers(on_top, on_base, lower, upper)
    for i in range(6):
        matrix = np.array([[on_top[i], on_base[i]], [on_base[i], on_top[i]]])
        # faces and plates: f = K (u - D f)
        of_plates = np.linalg.solve(np.eye(2) + matrix @ np.diag([upper[i], lower[i]]), matrix)
        np.testing.assert_allclose([found[0][i], found[1][i]], of_plates[0], rtol=1e-12)


@pytest.mark.parametrize("kind", Faces.variants())
def test_a_layer_at_one_face_is_told_from_layers_at_both(kind):
    nominal = measured((kind(), Term("power", 0), [3e-8]))
    first = next(iter(fit_places(nominal, names=["faces", "beside"]).values()))
    assert type(first.place) is kind
    assert first.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1


def test_of_ways_of_acting_that_hardly_differ_the_first_is_told(monkeypatch):
    """As in a rig of finite elements, where the compliances of both faces add up; the data are those of another way."""
    for kind, factor in ((LowerFace, 0.9), (UpperFace, 1.1)):
        monkeypatch.setattr(kind, "scale", Faces.scale)
        monkeypatch.setattr(kind, "chain", lambda _, s, chain, v, f=factor: chain.softer_at(lower=f * v, upper=f * v))
    nominal = measured((UpperFace(), Term("power", 0), [3e-8]))
    assert type(fit_places(nominal, names=["faces"])["faces"].place) is Faces


@pytest.mark.parametrize(("at_base", "depth"), [(0.0, 0.0), (0.6, 0.0), (0.0, 0.06), (2.0, 0.0), (1.7, 0.06)])
def test_open_faces_without_a_law_are_those_of_the_effect(at_base, depth):
    """And with a law of -1 they are bonded: what is left is that the plate bends on the sample."""
    bench = joint_bench()
    z, sizes = soft_sample(bench), (0.16, 0.1, at_base, depth)
    own = [
        p.prior.coordinate(min(max(size, 1e-9), 2 - 1e-9)) for p, size in zip(WornRim().parameters, sizes, strict=True)
    ]
    effect = WornRim() if depth else Delamination()
    expected = bench.with_effects(effect).differences(np.append(z, own[: len(effect.parameters)]))
    law = SimpleLaw.at(OpenFaces(*sizes), (Term("power", 0),), F, 1.0)
    whole = bench.with_effects(law)
    amplitude = law.parameters[0].prior
    found = whole.differences(np.append(z, amplitude.coordinate(0.0)))
    bonded = whole.differences(np.append(z, amplitude.coordinate(-1.0)))
    for a, b, c, d in zip(found, expected, bonded, bench.differences(z), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-7)
        assert np.abs(c - d).max() < 0.01
        assert np.abs(a - d).max() > 0.1


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (OpenFaces(0.16), "an open rim of the upper face, 16 % of the radius, and beyond it a law"),
        (OpenFaces(0.16, at_base=1.9), "an open rim of the lower face, 16 % of the radius, and beyond it a law"),
        (
            OpenFaces(0.16, at_base=1.0, depth=0.06),
            "an open rim of both faces, 16 % of the radius, worn away to 6 % of the height, and beyond it a law",
        ),
        (SampleShape(needs_finite_elements=True), "a free rim of the sample, and beyond it a law"),
        (SampleShape(), "a law"),
        (
            PLACES["reading"]().differing({"a": 0.182322, "b": 0.0, "c": -0.162519}),
            "a law, at frequencies that move from configuration to configuration (-15 to +20 %)",
        ),
        (
            PLACES["sample"]().differing(factors={"a": -0.331, "b": 0.1, "c": 0.144}),
            "a law, times a factor that differs from configuration to configuration (-0.33 to 0.14)",
        ),
    ],
)
def test_what_is_modelled_at_a_place_is_told_before_its_law(place, words):
    assert place.in_words("a law") == words


@pytest.mark.parametrize("change", [1.0, -2.0])
def test_a_reading_that_is_another_in_one_configuration_is_told_as_such(change):
    """A range that was doubled, and a channel that is reversed."""
    nominal = measured((ReadingOfOne("c3"), Term("power"), [change]))
    first, second = list(fit_places(nominal, names=["one_configuration", "reading", "sample"]).values())[:2]
    assert (first.place.label, first.place.variant) == ("one_configuration[c3]", "reading")
    assert first.log_evidence > second.log_evidence + 1000
    low, high = first.band(3.0)
    assert np.all((low.real < change) & (change < high.real))
    assert np.max(np.abs(high - low)) < 0.1


@pytest.mark.slow
def test_open_rims_that_no_compliance_is_are_drawn_as_such():
    nominal = measured_with([WornRim()], (0.2, 0.1, 1e-6, 0.04))
    places = fit_places(nominal, names=["faces", "sample_radius"])
    n = len(nominal.minimum.residual)
    assert places["faces"].explanation.minimum.misfit / n > 10
    hypothesis = nominal.hypothesis.with_effects(WornRim())
    start = np.append(soft_sample(nominal.hypothesis), [0.5, 0.0, -1.5, 0.0])
    found = with_open_rims(nominal, places, Fitted(hypothesis, minimise_scaled(hypothesis, start)))
    first, _ = found.values()
    assert first.place.width == pytest.approx(0.2, rel=0.02)
    assert first.place.depth == pytest.approx(0.04, rel=0.1)
    assert first.explanation.minimum.misfit / n < 1.1
    assert np.abs(first.law()).max() < 0.1


def test_open_rims_cost_the_evidence_of_their_sizes():
    """Known a thousand times as well, each of four sizes costs ln 1000 more."""
    nominal = measured_with([WornRim()], (0.2, 0.1, 1e-6, 0.04))
    places = fit_places(nominal, names=["faces"])
    hypothesis = nominal.hypothesis.with_effects(WornRim())
    own = [p.prior.coordinate(size) for p, size in zip(WornRim().parameters, (0.2, 0.1, 1e-6, 0.04), strict=True)]
    minimum = hypothesis.as_minimum(np.append(soft_sample(nominal.hypothesis), own))
    sharp = replace(minimum, jacobian=1e6 * minimum.jacobian)
    sharper = replace(minimum, jacobian=1e9 * minimum.jacobian)
    first, second = (with_open_rims(nominal, places, Fitted(hypothesis, m))["faces"] for m in (sharp, sharper))
    assert second.price - first.price == pytest.approx(4 * np.log(1000), rel=1e-3)
    assert first.log_evidence - second.log_evidence == pytest.approx(4 * np.log(1000), rel=1e-3)


@pytest.mark.slow
def test_open_rims_are_looked_for_where_no_effect_has_them():
    nominal = measured_with([WornRim()], (0.2, 0.1, 1e-6, 0.04))
    places = fit_places(nominal, names=["faces", "sample_radius"])
    found = search_open_rims(nominal, [nominal.minimum], {}, places, None)
    assert type(found["faces"].place) is OpenFaces
    assert found["faces"].explanation.minimum.misfit / len(nominal.minimum.residual) < 1.2
    known = {"delamination": Delamination()}
    assert search_open_rims(nominal, [nominal.minimum], known, places, None) is places
    law = SimpleLaw.at(OpenFaces(0.1), (Term("power", 0),), F, 1.0)
    given = replace(nominal, hypothesis=replace(nominal.hypothesis, given=(law,)))
    assert search_open_rims(given, [nominal.minimum], {}, places, None) is places


def test_a_faint_sharp_resonance_is_found_where_a_drawn_law_shows_it():
    nominal = measured((PLACES["reading"](), Term("resonance"), [0.01, 1250.0, 0.02]))
    first, *_ = with_resonances(nominal, fit_places(nominal, names=["reading", "plate"])).values()
    assert first.place.name == "reading"
    assert first.explanation.minimum.misfit / len(nominal.minimum.residual) < 1.1


def test_the_band_of_a_drawn_law_holds_the_true_one():
    nominal = measured((PLACES["beside"](), Term("lossy"), [2e3, 0.2]))
    place = fit_places(nominal, names=("beside",))["beside"]
    low, high = place.band()
    true = 2e3 * (1 + 0.2j)
    held = (low.real < true.real) & (true.real < high.real), (low.imag < true.imag) & (true.imag < high.imag)
    assert np.mean(held) > 0.75
    assert np.abs(place.law() / true - 1).max() < 0.2


@pytest.mark.parametrize(
    ("term", "values", "shares"),
    [
        (Term("power", 0), [1.5e-3], {"amplitude": (0.2, 1.0)}),
        # its width is known to half a per cent, and the phase about it
        (
            Term("resonance"),
            [1.5e-3, 600.0, 0.03],
            {"amplitude": (0.2, 1.0), "frequency": (0.03 / 20, 0.03), "loss_factor": (0.2, 2.0)},
        ),
    ],
)
def test_a_law_far_above_the_noise_is_as_exact_as_the_mechanics_of_its_place(term, values, shares):
    """Sizes beside DRAWN_ERROR: without it they would be known to 1e-9."""
    place = PLACES["top_plate"]()
    bench = joint_bench()
    law = SimpleLaw.at(place, (term,), F, place.scale(bench.settings, 3e5))
    own = [p.prior.coordinate(value) for p, value in zip(law.parameters, values, strict=True)]
    hypothesis = bench.with_effects(law)
    minimum = hypothesis.as_minimum(np.append(soft_sample(bench), own))
    exact = Fitted(hypothesis, replace(minimum, jacobian=1e9 * minimum.jacobian))
    near = values[1] * (1 + 0.15 * np.linspace(-1, 1, 61)) if len(values) > 1 else []
    spreads = SimpleForm(place, exact, 0.0).covariance(np.unique([*F, *near])).diagonal() ** 0.5
    for parameter, z, spread in zip(law.parameters, own, spreads, strict=True):
        name = parameter.name.partition(".")[2]
        relative = abs(parameter.prior.slope(z)) / (1 if parameter.prior.is_logarithmic else abs(values[0])) * spread
        low, high = shares[name]
        assert low * DRAWN_ERROR < relative < high * DRAWN_ERROR


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_faint_law_is_told_as_large_as_it_is(seed):
    """A skin at the faces, which the modulus takes up in part: the prior of the most evidence pulls it towards 0."""
    true = -1.5e-9
    nominal = measured((PLACES["faces"](), Term("power", 0), [true]), seed=seed)
    fit = fit_places(nominal, names=["faces"])["faces"]
    told = as_told(nominal, fit)
    assert fit.drawn.size < told.drawn.size
    assert as_told(nominal, told) is told
    assert (told.place, told.log_evidence) == (fit.place, fit.log_evidence)
    pulled, free = (float(np.mean(place.law().real) / true) for place in (fit, told))
    assert pulled < free
    low, high = told.band()
    assert np.mean((low.real < true) & (true < high.real)) > 0.8


def test_nothing_is_drawn_without_a_gap():
    nominal = measured((PLACES["reading"](), Term("power", 0), [0.0]))
    best = next(iter(fit_places(nominal, names=TRIED).values()))
    assert best.log_evidence < tolerant_evidence(nominal)


def test_one_recording_alone_has_no_order():
    first, *others = joint_bench().settings
    alone = replace(first, order=np.zeros(1))
    assert PLACES["sample_order"].instances((alone,)) == []
    order, in_mounting = PLACES["sample_order"].instances((alone, *others))
    assert (order.variant, in_mounting.variant) == ("", "since_mounting")


def test_time_begins_anew_with_each_mounting():
    """The overall order goes on, the time since mounting does not: of bursts in use or not, of all configurations."""
    _, in_mounting = PLACES["sample_order"].variants()
    whole = problem()
    for setting in whole.settings:
        assert in_mounting().factor(setting) == pytest.approx(np.log1p(setting.data.burst))
    alone = whole.with_data(whole.data[:1])
    _, parts = folds(alone)
    for part in (data for pair in parts for data in pair):
        (setting,) = alone.with_data(part).settings
        numbers = np.searchsorted(CENTRES, setting.data.centres * (1 - 1e-9))[setting.data.burst]
        assert in_mounting().factor(setting) == pytest.approx(np.log1p(numbers))


def test_what_a_place_costs_its_simple_forms_pay_too():
    """Else any would be ahead of the free law there, and of named effects."""
    nominal = measured((PLACES["reading"](), Term("power", 1), [-0.05]))
    at = fit_places(nominal, names=["reading"])["reading"]
    free, paid = (simple_form(nominal, replace(at, price=price)) for price in (0.0, 30.0))
    assert free.log_evidence - paid.log_evidence == pytest.approx(30)


def test_a_law_that_is_known_too_well_for_rounding_has_a_simple_form():
    """Of a gap of millions of nats the covariance of the nodes is not positive definite by rounding."""
    bench = joint_bench()
    nominal = fit(bench, np.zeros(len(bench.parameters)))
    at = fit_places(nominal, names=["reading"])["reading"]
    sharp = replace(at.fitted.minimum, jacobian=1e9 * at.fitted.minimum.jacobian)
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(sharp.covariance)
    form = simple_form(nominal, replace(at, fitted=replace(at.fitted, minimum=sharp)))
    assert np.isfinite(form.log_evidence)

"""Every registered modulus law, those of plugins included: passive, causal, broadcasting, read back from a file."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Annotated, ClassVar, Literal

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError
from multilayer.media import laws
from multilayer.media.kramers_kronig import kramers_kronig_loss_modulus
from multilayer.media.laws import LAWS, ModulusLaw, Table
from multilayer.testing import check_law
from multilayer.units import Unit
from tests.contract import samples

BUILT_IN = [name for name in LAWS if [owner.package for owner in LAWS.owners(name)] == ["multilayer"]]
MANUAL = Path(__file__).parents[2] / "docs" / "laws.md"
# so far out that the broadest of the samples is on its plateaus
ALL_TIME = np.geomspace(1e-45, 1e45, 90 * 30 + 1)

_PLATEAUS = {"relaxed_modulus": 1e5, "unrelaxed_modulus": 1e7, "relaxation_time": 1e-4}
LAW_SAMPLES = {
    **samples.LAW_SAMPLES,
    "zener": [_PLATEAUS, {**_PLATEAUS, "unrelaxed_modulus": 1e5}],
    "havriliak_negami": [
        {**_PLATEAUS, "order": 0.5, "asymmetry": 0.4},
        {**_PLATEAUS, "order": 0.4, "asymmetry": 2.5},
        {**_PLATEAUS, "order": 1.0, "asymmetry": 0.3},
        {**_PLATEAUS, "relaxation_time": 1e-14, "order": 0.2, "asymmetry": 1.0},
    ],
    "maxwell": [
        {"relaxed_modulus": 1e5, "branch_modulus": (1e5, 0.0, 3e6), "relaxation_time": (1e-2, 1e-3, 1e-6)},
        {"relaxed_modulus": 1e5, "branch_modulus": (1e5,), "relaxation_time": (1e-12,)},
    ],
    "free_form": [
        {"relaxed_modulus": 1e5, "frequency": (1.0, 30.0, 1e3, 1e6), "rise": (1e5, 0.0, 3e6)},
        {"relaxed_modulus": 1e5, "frequency": (1e-9, 1e15), "rise": (1e9,)},
    ],
}


VARIANTS = [
    pytest.param(LAWS[name].model_validate(fields), id=f"{name}-{i}")
    for name, _ in LAWS.working()
    for i, fields in enumerate(samples.law_samples(name, LAW_SAMPLES))
]


@pytest.mark.parametrize("name", LAWS.names())
def test_every_registered_law_has_samples(name):
    assert LAWS[name]
    assert samples.law_samples(name, LAW_SAMPLES), f"'{name}' has none: add some here, a plugin to its `examples`"


def test_every_law_in_a_file_is_registered():
    modules = [import_module(f"{laws.__name__}.{module.name}") for module in iter_modules(laws.__path__)]
    defined = {
        item
        for module in modules
        for item in vars(module).values()
        if isinstance(item, type) and issubclass(item, ModulusLaw) and item.__module__ == module.__name__
    }
    assert defined - {ModulusLaw} == {LAWS[name] for name in BUILT_IN}


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_built_in_law_has_a_row_in_the_manual(name):
    rows = [line for line in MANUAL.read_text().splitlines() if line.startswith(f"| `{name}` | ")]
    assert len(rows) == 1, "docs/laws.md: a table of all laws"
    assert [field for field in LAWS[name].model_fields if field != "law" and f"`{field}`" not in rows[0]] == []


@pytest.mark.parametrize("law", VARIANTS)
def test_law_keeps_the_laws(law):
    check_law(law)


@pytest.mark.parametrize("law", [p for p in VARIANTS if not p.values[0].causal and not isinstance(p.values[0], Table)])
def test_a_law_that_says_it_is_not_causal_is_not(law):
    modulus = law(ALL_TIME)
    demanded = kramers_kronig_loss_modulus(ALL_TIME, modulus.real)
    assert np.max(np.abs(demanded - modulus.imag)) == pytest.approx(np.max(modulus.imag))


class Wrong(ModulusLaw):
    law: Literal["wrong"] = "wrong"
    modulus: float = 1e5


class Active(Wrong):
    def __call__(self, frequency):
        return self.modulus * (1 - 0.1j * np.sign(frequency))


class Lopsided(Wrong):
    causal: ClassVar[bool] = False

    def __call__(self, frequency):
        return self.modulus * (1 + 0.1j) + 0 * np.asarray(frequency)


class Acausal(Wrong):
    def __call__(self, frequency):
        return self.modulus * (1 + 0.1j * np.sign(frequency))


class AcausalWithDashpot(Wrong):
    dashpot: float = 1.0

    def __call__(self, frequency):
        f = np.asarray(frequency)
        return self.modulus * (1 + 0.05j * np.sign(f)) + 2j * np.pi * f * self.dashpot


class AcausalBesideAPowerLaw(Wrong):
    def __call__(self, frequency):
        f = np.asarray(frequency)
        return self.modulus * (1 + 0.05j * np.sign(f) + (1j * f / 100) ** 0.6)


class PowerLawOfAnotherLoss(Wrong):
    def __call__(self, frequency):
        f = np.asarray(frequency)
        return self.modulus * (np.abs(f) / 100) ** 0.2 * (1 + 0.01j * np.sign(f))


class InKilopascal(Wrong):
    modulus: Annotated[float, Unit("kPa")] = 100.0

    def __call__(self, frequency):
        return np.asarray(1e3 * self.modulus + 0j * np.asarray(frequency))


class InFoo(InKilopascal):
    modulus: Annotated[float, Unit("foo")] = 100.0


class OneValue(Wrong):
    def __call__(self, frequency):
        return np.asarray(float(np.mean(self.modulus)) + 0j * np.asarray(frequency))


class OneFrequency(Wrong):
    def __call__(self, frequency):
        return np.asarray(self.modulus + 0j)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (Active, "passive: at 1e-06 Hz the modulus is .* whose imaginary part is not allowed"),
        (Lopsided, "real in time: E\\(-f\\) is not"),
        (Acausal, "causal: E2 differs by .* from what Kramers and Kronig demand"),
        (AcausalWithDashpot, "causal: E2 differs by 5e\\+03 Pa at .* Hz from what Kramers and Kronig demand"),
        (AcausalBesideAPowerLaw, "causal: E2 differs by 5e\\+03 Pa at .* Hz from what Kramers and Kronig demand"),
        (PowerLawOfAnotherLoss, "causal: E2 differs by .* from what Kramers and Kronig demand"),
        (InKilopascal, "units: the unit 'kPa' of field 'modulus' is not SI: 1 kPa is 1000 kilogram / meter / second"),
        (InFoo, "units: the unit 'foo' of field 'modulus' is unknown"),
        (OneValue, "any parameters: an array and single numbers of modulus differ"),
        (OneFrequency, "any frequencies: frequencies of shape"),
        (OneFrequency, "file round trip: no entry point 'multilayer.modulus_laws' is called 'wrong'"),
    ],
)
def test_wrong_laws_are_caught(wrong, words):
    with pytest.raises(AssertionError, match=words):
        check_law(wrong())


class SpringPot(ModulusLaw):
    law: Literal["spring_pot"] = "spring_pot"
    modulus: float = 1e5
    order: float
    dashpot: float = 0.0

    def __call__(self, frequency):
        f = np.asarray(frequency)
        return self.modulus * (1j * f / 100) ** self.order + 2j * np.pi * f * self.dashpot


class AcausalInName(SpringPot):
    law: Literal["acausal_in_name"] = "acausal_in_name"
    causal: ClassVar[bool] = False


@pytest.fixture
def spring_pots():
    for kind in (SpringPot, AcausalInName):
        LAWS.register(kind.model_fields["law"].default, kind)
    yield
    for kind in (SpringPot, AcausalInName):
        LAWS.unregister(kind.model_fields["law"].default)


@pytest.mark.usefixtures("spring_pots")
@pytest.mark.parametrize("order", [0.05, 0.2, 0.6, 0.9, 0.97])
@pytest.mark.parametrize("dashpot", [0.0, 1e-12, 100.0])
def test_what_grows_without_end_is_causal(order, dashpot):
    check_law(SpringPot(order=order, dashpot=dashpot))
    with pytest.raises(AssertionError, match="it says that it is not causal, and is"):
        check_law(AcausalInName(order=order, dashpot=dashpot))


class Resonance(ModulusLaw):
    """A mini-oscillator, as that of CONTRIBUTING.md; of the direct formula rounding makes E2 negative far above."""

    law: Literal["resonance"] = "resonance"
    damping: float
    direct: bool = False

    def __call__(self, frequency):
        w = np.asarray(frequency, dtype=float) / 500.0
        if self.direct:
            square = (1j * w) ** 2 + 2j * self.damping * w
            return np.asarray(1e6 + 2e4 * square / (square + 1))
        inertia, loss = 1 - w**2, 2 * self.damping * w
        size = inertia**2 + loss**2
        return np.asarray(1e6 + 2e4 * (1 - inertia / size + 1j * loss / size))


class WronglyAcausal(Resonance):
    law: Literal["wrongly_acausal"] = "wrongly_acausal"
    causal: ClassVar[bool] = False


@pytest.fixture
def resonances():
    for kind in (Resonance, WronglyAcausal):
        LAWS.register(kind.model_fields["law"].default, kind)
    yield
    for kind in (Resonance, WronglyAcausal):
        LAWS.unregister(kind.model_fields["law"].default)


@pytest.mark.usefixtures("resonances")
@pytest.mark.parametrize("damping", [0.02, 0.5, 0.6, 1.0])
def test_what_resonates_is_causal(damping):
    for direct in (False, True):
        check_law(Resonance(damping=damping, direct=direct))
    with pytest.raises(AssertionError, match="it says that it is not causal, and is"):
        check_law(WronglyAcausal(damping=damping))


def table():
    return Table.model_validate(LAW_SAMPLES["table"][0])


def test_table_passes_through_its_points():
    assert_allclose(table()(table().frequency), np.array(table().storage_modulus) + 1j * np.array(table().loss_modulus))


def test_table_is_linear_in_the_logarithm_of_frequency():
    assert table()(10.0) == pytest.approx(1.5e5 + 2e4j)


@pytest.mark.parametrize("frequency", [0.5, 6e4, [10.0, 1e5]])
def test_table_is_not_extrapolated(frequency):
    with pytest.raises(InputError, match="the modulus table holds 1 to 50000 Hz"):
        table()(frequency)

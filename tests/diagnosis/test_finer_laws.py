"""Finer laws of effects: of which effects they are tried, and what stays."""

import numpy as np
import pytest

from multilayer.diagnosis import diagnose
from multilayer.diagnosis.diagnose import fit_nominal
from multilayer.diagnosis.effects.adhesive import Adhesive
from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.channel_gain import ChannelGain
from multilayer.diagnosis.effects.delamination import Delamination
from multilayer.diagnosis.effects.skin import Skin
from multilayer.diagnosis.fitting import Fitted, best_of, fit_effects
from multilayer.diagnosis.goodness_of_fit import lack_of_fit
from multilayer.inference.low_rank import LowRank
from multilayer.inference.problem import Minimum
from multilayer.testing.benches import joint_bench
from tests.fits.test_joint import campaign_and_signals


class Tried(list):
    """The names of the effects whose finer laws are asked for."""

    def __call__(self, found, executor):
        self.append(*found.names)
        return found


@pytest.fixture
def tried(monkeypatch):
    names = Tried()
    monkeypatch.setattr(diagnose, "_by_finer_laws", names)
    return names


def fitted(effect, size, errors=None):
    """Return a fit that leaves `size` standard deviations of every datum."""
    joint = joint_bench()
    hypothesis = joint.with_effects(effect)
    z, count = np.zeros(len(hypothesis.parameters)), 2 * sum(len(data.frequency) for data in joint.data)
    left = size * (-1.0) ** np.arange(count)
    return Fitted(hypothesis, Minimum(z, left, np.zeros((count, z.size))), errors)


@pytest.mark.parametrize(("size", "refined"), [(0.5, []), (4.0, ["adhesive", "delamination"])])
def test_they_are_tried_of_effects_near_the_best_where_nothing_fits(size, refined, tried):
    """Which law is ahead means little where none fits: another may be so by chance."""
    sizes = {Adhesive(): size, Delamination(): 1.05 * size, Skin(): 1.5 * size}
    fits = {(effect.name,): fitted(effect, of_effect) for effect, of_effect in sizes.items()}
    assert diagnose._with_finer_law(fits, None) == fits
    assert tried == refined


def test_they_are_tried_of_the_best_whatever_misfit_an_error_takes_away_elsewhere(tried):
    """The error of another law makes its misfit small, and costs evidence."""
    best = fitted(Delamination(), 5.2)
    columns = np.zeros((len(best.minimum.residual), 12))
    np.fill_diagonal(columns, 4e5)
    other = fitted(Adhesive(), 3.6, LowRank.of(columns))
    fits = {found.names: found for found in (best, other)}
    assert best_of([best, other]) is best
    assert other.minimum.cost < 0.5 * best.minimum.cost
    diagnose._with_finer_law(fits, None)
    assert tried == ["delamination", "adhesive"]


class Weak(ChannelGain):
    """A gain of at most some 1e-4."""

    parameters = (signed("gain", 1e-4),)

    def finer(self, configurations=()):
        return Finer()


class Finer(Weak):
    """The same with a gain as it is."""

    parameters = (*Weak.parameters, signed("more", 0.05))
    starts = ((0.0, 0.0),)

    def motion(self, setting, motion, values):
        return super().motion(setting, motion, values) * (1 + values["more"])

    def finer(self, configurations=()):
        return None


class InVain(Weak):
    """The same with a finer law that changes nothing."""

    def finer(self, configurations=()):
        return WithoutUse()


class WithoutUse(Finer):
    """A gain of at most some 1e-4 with a parameter that means nothing."""

    def motion(self, setting, motion, values):
        return Weak.motion(self, setting, motion, values)


def test_a_fit_is_that_by_the_finer_law_that_fits_or_stays_as_it_is():
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    for effect, kind in ((Weak(), Finer), (InVain(), InVain)):
        (found,) = fit_effects(nominal, {effect.name: effect}).values()
        assert lack_of_fit(found)
        refined = diagnose._by_finer_laws(found, None)
        assert type(refined.hypothesis.effects[0]) is kind
        assert bool(lack_of_fit(refined)) == (refined is found)

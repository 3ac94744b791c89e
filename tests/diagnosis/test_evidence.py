"""The evidence of all hypotheses."""

import numpy as np

from multilayer.diagnosis.effects.channel_gain import ChannelGain
from multilayer.diagnosis.effects.rocking import Rocking
from multilayer.diagnosis.evidence import compare
from multilayer.diagnosis.fitting import StartedFit, fit_effects, polish_fits
from tests.diagnosis.rigs import rocking


def test_a_single_effect_whose_search_went_astray_is_found_by_its_pair():
    nominal, known = rocking(2)
    effects = {"rocking": Rocking(), "channel_gain": ChannelGain()}
    singles = polish_fits(fit_effects(nominal, effects))
    astray = known.minimum.z + np.where(known.of_effects(), 0.0, 6.0)
    lost = StartedFit.at(nominal.hypothesis.with_effects(effects["rocking"]), astray[None]).provisional
    comparison = compare(nominal, {**singles, ("rocking",): lost}, effects)
    found = comparison.fitted["rocking",].minimum
    assert lost.minimum.cost_per_datum > 100
    assert found.cost_per_datum < 1.5
    assert comparison.ranked[0] == ("rocking",)

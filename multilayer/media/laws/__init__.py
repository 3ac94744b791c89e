"""Modulus laws: Young's modulus E1 + i E2 as a function of frequency, and the field type that takes one.

Wherever a modulus stands in an input, a number, a complex number (``"1.2e5+2e4j Pa"``) or a law (``{law:
fractional_zener, ...}``) may stand. Laws come from the registry `LAWS`, fed by the entry points
``multilayer.modulus_laws``; ``docs/laws.md`` says which law suits what. A new law needs its file and its entry point,
and no line here: those below are imported by name elsewhere.
"""

from multilayer.media.laws.base import LAWS, Limit, ModulusLaw
from multilayer.media.laws.field import Modulus, complex_modulus
from multilayer.media.laws.relaxing import FractionalZener, HavriliakNegami, Zener
from multilayer.media.laws.simple import Complex, Constant, KelvinVoigt, LossFactor
from multilayer.media.laws.spectral import FreeForm, Maxwell
from multilayer.media.laws.table import Table, read_modulus_table

__all__ = [
    "LAWS",
    "Complex",
    "Constant",
    "FractionalZener",
    "FreeForm",
    "HavriliakNegami",
    "KelvinVoigt",
    "Limit",
    "LossFactor",
    "Maxwell",
    "Modulus",
    "ModulusLaw",
    "Table",
    "Zener",
    "complex_modulus",
    "read_modulus_table",
]

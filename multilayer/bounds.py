"""How much is read and computed, and how large and small numbers may be: every bound in one place, with its reason.

Sizes are refused before anything of that size is read or computed. Those that only keep a machine from drowning are
multiplied by ``MULTILAYER_BOUNDS_FACTOR`` of the environment; the others guard what the code can do at all.

Magnitudes are refused at the door (`multilayer.units`), with the field and its line. They are far wider than any
physics: within them sums of a few products of fields neither overflow nor vanish in double precision.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from multilayer.errors import InputError, Problem

FACTOR = "MULTILAYER_BOUNDS_FACTOR"


@dataclass(frozen=True)
class Bound:
    """The most of something that is taken.

    Attributes
    ----------
    usual : int
        Without a factor from the environment.
    of : str
        What is counted, in the plural, as ``bytes of a YAML file``.
    why : str
        For the table in ``docs/limits.md``.
    can_be_raised : bool
        Whether `FACTOR` multiplies it.
    """

    usual: int
    of: str
    why: str
    can_be_raised: bool = False

    @property
    def most(self) -> int:
        """The bound, times the factor of the environment where that may raise it.

        Raises
        ------
        InputError
            When the factor is no number above 0.
        """
        return int(self.usual * _factor()) if self.can_be_raised else self.usual

    def refusal(self, count: float, file: Path | None = None, remedy: str = "") -> InputError:
        """Return the error that tells of too many.

        Parameters
        ----------
        count : float
        file : Path, optional
        remedy : str
            What to do, where there is something better than to raise the bound.
        """
        option = f"{FACTOR}=10 in the environment allows ten times as many" if self.can_be_raised else ""
        advice = "; or ".join(text for text in (remedy, option) if text)
        told = f"{counted(count)} {self.of} are too many: at most {counted(self.most)} are taken"
        return InputError(Problem(f"{told}; {advice}" if advice else told, file=file))

    def check(self, count: float, file: Path | None = None, remedy: str = "") -> None:
        """Refuse too many; see `refusal`.

        Raises
        ------
        InputError
        """
        if count > self.most:
            raise self.refusal(count, file, remedy)


def _factor() -> float:
    text = os.environ.get(FACTOR, "1")
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not (isfinite(factor) and factor > 0):
        raise InputError(f"{FACTOR} in the environment must be a number above 0, not '{text[:40]}'")
    return factor


def counted(number: float) -> str:
    """Return a count as people write it: 100 000, or 2.5e+12."""
    if number >= 1e9:
        return f"{number:.3g}"
    return f"{round(number):,}".replace(",", " ")


YAML_BYTES = Bound(
    10_000_000, "bytes of a YAML file", "the largest campaigns are below 1 MB; a text is read in seconds", True
)
YAML_VALUES = Bound(
    200_000, "values and names of a YAML file, repeats by aliases counted", "0.1 ms and 1 kB each; 15 s", True
)
YAML_NAMES = Bound(10_000, "names in one mapping of a YAML file", "each is compared with those that are allowed")
NUMBER_CHARACTERS = Bound(100, "characters of a number with its unit", "17 digits are all that a number keeps")
LAYERS = Bound(10_000, "layers of a stack", "memory and time are those of the layers: 10 000 take seconds")
CONTACTS = Bound(10_001, "contacts of a stack", "one for each interface of the most layers")
FREQUENCIES = Bound(100_000, "frequencies of a simulation", "more than a curve can show; 100 000 take seconds")
CASES = Bound(10_000, "cases of a sweep", "each is validated and computed on its own")
SWEPT_VALUES = Bound(
    10_000_000, "values of all cases of a sweep together", "each case is a file of its own: 2 µs for each value", True
)
SAMPLES = Bound(1_000_000, "samples within tolerances", "percentiles are known to 0.1 % long before")
SOLVES = Bound(
    10**12, "solves of a layer at one frequency and angle", "1 µs each at best: beyond lie weeks of one core", True
)
RESULT_BYTES = Bound(4 * 10**9, "bytes of memory that a simulation needs", "what a laptop has", True)
ACROSS_PANEL = Bound(
    20_000,
    "radians of phase across a finite panel",
    "1600 wavelengths there and back; 15 s for 16 third octaves of a diffuse field",
    True,
)
FILE_BYTES = Bound(400_000_000, "bytes of a data file", "an hour of two channels at 25 kHz and 16 bits", True)
TEXT_BYTES = Bound(100_000_000, "bytes of a text table", "five times that in memory; a binary format takes less", True)
TEXT_LINES = Bound(2_000_000, "lines of a text table", "5 µs and 200 bytes each, whatever stands in them", True)
DATA_VALUES = Bound(
    50_000_000, "numbers in a data file", "400 MB; as its headers claim, for a small file may unpack to any size", True
)
CHANNELS = Bound(10_000, "channels of a data file", "recorders have some hundred", True)

SIZES = (
    YAML_BYTES,
    YAML_VALUES,
    YAML_NAMES,
    NUMBER_CHARACTERS,
    LAYERS,
    CONTACTS,
    FREQUENCIES,
    CASES,
    SWEPT_VALUES,
    SAMPLES,
    SOLVES,
    RESULT_BYTES,
    ACROSS_PANEL,
    FILE_BYTES,
    TEXT_BYTES,
    TEXT_LINES,
    DATA_VALUES,
    CHANNELS,
)
"""All bounds of sizes, in the order of the manual."""


@dataclass(frozen=True)
class Magnitudes:
    """How large and how small a quantity of some unit may be, beside 0.

    Attributes
    ----------
    least, most : float
        SI, of the absolute value.
    usual : float
        What such a quantity often is: how extreme a value is, its distance from there in decades tells.
    why : str
        What lies at the ends, for the table in ``docs/limits.md``.
    """

    least: float
    most: float
    usual: float
    why: str

    def refusal(self, value: complex, unit: str) -> str:
        """Return what is wrong with a number, or an empty text; of what is not finite the caller tells."""
        size = abs(value)
        if size == 0 or self.least <= size <= self.most or not isfinite(size):
            return ""
        return f"must be 0, or from {self.least:g} to {self.most:g} {unit}".rstrip() + " in size"


MAGNITUDES = {
    "m": Magnitudes(1e-12, 1e6, 1e-2, "less than an atom; thicker than any construction by far"),
    "m^2": Magnitudes(1e-20, 1e12, 1e-4, "permeabilities of rock are 1e-16; areas"),
    "kg": Magnitudes(1e-12, 1e9, 1e-2, "masses of sensors and plates"),
    "kg/m^3": Magnitudes(1e-6, 1e9, 1e2, "a high vacuum; more than any matter on Earth"),
    "kg/m^2": Magnitudes(1e-9, 1e9, 1.0, "sheets: a density times a thickness"),
    "Pa": Magnitudes(1e-9, 1e18, 1e6, "losses of gels; a million times the modulus of diamond"),
    "1/Pa": Magnitudes(1e-18, 1e9, 1e-6, "stiffening by a static stress"),
    "K": Magnitudes(1.0, 1e5, 293.0, "gases are none below 1 K, and no molecules above 1e5 K"),
    "m/s": Magnitudes(1e-3, 3e8, 343.0, "slower than any sound, and light"),
    "m/s^2": Magnitudes(1e-12, 1e9, 1.0, "seismometers; shocks"),
    "Pa*s": Magnitudes(1e-12, 1e18, 1e-5, "gases; dashpots of slow relaxations"),
    "Pa*s/m": Magnitudes(1e-12, 1e18, 400.0, "impedances"),
    "N*s/m^3": Magnitudes(1e-6, 1e12, 100.0, "screens: a flow resistivity times a thickness"),
    "N*s/m^4": Magnitudes(1e-3, 1e15, 1e4, "open gauze; rock"),
    "m^2/N": Magnitudes(1e-18, 1e6, 1e-6, "studs"),
    "m/N": Magnitudes(1e-18, 1e6, 1e-6, "ties"),
    "N/m": Magnitudes(1e-12, 1e18, 1e4, "tensions and stiffnesses"),
    "Hz": Magnitudes(1e-18, 1e18, 1e3, "reduced frequencies of master curves; rates of recorders"),
    "s": Magnitudes(1e-18, 1e18, 1e-3, "relaxation times"),
    "degree": Magnitudes(1e-12, 1e6, 45.0, "angles"),
    "": Magnitudes(1e-30, 1e12, 1.0, "what rounding leaves of 0; shares, ratios, numbers of cycles"),
}
"""By SI unit as `multilayer.units` writes it."""
OF_OTHER_UNITS = Magnitudes(1e-30, 1e30, 1.0, "units of plugins and of sensitivities")


def magnitudes(unit: str) -> Magnitudes:
    """Return how large and how small a quantity of an SI unit may be.

    Parameters
    ----------
    unit : str
        As pint writes it; empty for a pure number.
    """
    return MAGNITUDES.get(unit, OF_OTHER_UNITS)


_SLENDEREST, _FLATTEST = 1e-6, 1e6


def refuse_shape(shape: float) -> None:
    """Refuse discs so flat or so slender that no mesh of finite elements holds them.

    Parameters
    ----------
    shape : float
        Radius over twice the thickness.

    Raises
    ------
    InputError
    """
    if not _SLENDEREST <= shape <= _FLATTEST:
        allowed = f"it must be above 0, and from {_SLENDEREST:g} to {_FLATTEST:g}"
        raise InputError(f"shape: radius / (2 thickness) of {shape:g} is not allowed; {allowed}")

"""The input file of a campaign on the virtual two-plate rig, and the checks of its fields against each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from multilayer.config.validate import read
from multilayer.measurements.description import BurstShape, Uncertainty
from multilayer.measurements.implausible import implausible_fields
from multilayer.models import NO_BOOL, Model, refuse, refuse_unknown_keys
from multilayer.rig.effect_base import Mistake, Mounting, Surroundings
from multilayer.rig.effects import EFFECTS, EffectField
from multilayer.rig.excitation import LONGEST_TAIL, Timing, ring_down
from multilayer.rig.noise import NoiseSettings
from multilayer.rig.specimen import BasePlateSettings, SpecimenSettings, TopPlateSettings
from multilayer.units import Frequency, Length, Ratio

_MOST_BURSTS = 200
_FEWEST_CYCLES = 3.0
_LARGEST_DEVIATION = 0.1  # of a quantity: a draw of ten deviations does not happen
_MARGIN = 1.5  # on the estimated ring-down: effects may lower the resonance and its loss


class FrequencySteps(Model, populate_by_name=True):
    """Burst frequencies `from` ... `to`, Hz, in equal steps, the last one at or below `to`."""

    start: Annotated[Frequency, Field(alias="from")]
    stop: Annotated[Frequency, Field(alias="to")]
    step: Frequency

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        refuse_unknown_keys(cls, data, ("from", "to", "step"))
        return data

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.stop < self.start:
            text = f"{self.stop:g} Hz is not allowed: it must be at least 'from', {self.start:g} Hz"
            refuse(self, [(("to",), text, self.stop)])
        if (self.stop - self.start) / self.step >= _MOST_BURSTS:
            text = f"{self.step:g} Hz would make more than {_MOST_BURSTS} bursts; make it larger"
            refuse(self, [(("step",), text, self.step)])
        return self

    def values(self) -> tuple[float, ...]:
        """Return the frequencies, Hz."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-9)) + 1
        return tuple(float(f"{self.start + i * self.step:.12g}") for i in range(count))


def _kind(value: Any) -> str:
    return "mapping" if isinstance(value, Model | Mapping) else "list"


FrequencyList = Annotated[tuple[Frequency, ...], Field(min_length=1, max_length=_MOST_BURSTS)]
Frequencies = Annotated[
    Annotated[FrequencySteps, Tag("mapping")] | Annotated[FrequencyList, Tag("list")], Discriminator(_kind)
]
Lengths = Annotated[tuple[Length, ...], Field(min_length=1)]


class OneConfiguration(Model):
    """One mounting: thickness and radius of the sample, thickness of the top plate, m; a name of its own if wanted."""

    thickness: Length
    top_plate: Length
    radius: Length = 22.5e-3
    name: Annotated[str, Field(min_length=1, pattern=r"^[\w.+-]+$")] | None = None


class ConfigurationProduct(Model):
    """All combinations of some sizes, m, the top plates varying fastest and the radii slowest."""

    thicknesses: Lengths
    top_plates: Lengths
    radii: Lengths = (22.5e-3,)

    def configurations(self) -> list[OneConfiguration]:
        """Return the combinations."""
        sizes = product(self.radii, self.thicknesses, self.top_plates)
        return [OneConfiguration(thickness=h, top_plate=t, radius=r) for r, h, t in sizes]


Configurations = Annotated[
    Annotated[ConfigurationProduct, Tag("mapping")]
    | Annotated[tuple[OneConfiguration, ...], Field(min_length=1), Tag("list")],
    Discriminator(_kind),
]


class Remount(Model):
    """The sample is taken out and put back before each repeat: relative scatter of channel gain and of modulus."""

    gain: Ratio = 0.0
    stiffness: Ratio = 0.0


class RigFile(Model):
    """A campaign to be made; see ``docs/rig.md``. Read one with `load_rig`."""

    version: Literal[1]
    rig: Literal["two-plate"]
    seed: Annotated[int, Field(ge=0), NO_BOOL] = 0
    sampling_rate: Frequency = 25600.0
    specimen: SpecimenSettings
    top_plate: TopPlateSettings = TopPlateSettings()
    base_plate: BasePlateSettings = BasePlateSettings()
    burst: BurstShape = BurstShape(cycles=10.0, level_rms=5.0)
    frequencies: Frequencies
    configurations: Configurations
    repeats: Annotated[int, Field(ge=1, le=1000), NO_BOOL] = 3
    noise: NoiseSettings = NoiseSettings()
    uncertainty: Uncertainty = Uncertainty()
    remount: Remount | None = None
    resolution: Annotated[float, Field(ge=0.5, le=4)] = 1.0
    effects: tuple[EffectField, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        refuse(self, [*self._burst_mistakes(), *self._name_mistakes(), *self._careless()])
        refuse(self, [*self._idle_fields(), *self._effect_mistakes(), *self._ringing()])
        return self

    def implausible(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Give path and text of values that are allowed, and hardly ever meant."""
        yield from implausible_fields(self)

    @property
    def burst_frequencies(self) -> tuple[float, ...]:
        """Of every configuration, Hz, in the order of measurement."""
        return self.frequencies.values() if isinstance(self.frequencies, FrequencySteps) else self.frequencies

    @property
    def mountings(self) -> tuple[Mounting, ...]:
        """The configurations, in the order of measurement."""
        written = self.configurations
        items = written.configurations() if isinstance(written, ConfigurationProduct) else list(written)
        return tuple(
            Mounting(
                _name(sizes, items[0].radius), i, len(items), sizes.thickness, sizes.top_plate, sizes.radius,
                self.burst_frequencies,
            )
            for i, sizes in enumerate(items)
        )  # fmt: skip

    def has(self, effect: str) -> bool:
        """Return whether an effect is listed."""
        return any(listed.effect == effect for listed in self.effects)

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that the campaign states; 0 without ``finite_size``, as in the finite elements."""
        return self.specimen.poisson_ratio if self.has("finite_size") else 0.0

    def timing(self, mounting: Mounting) -> Timing:
        """Return how the bursts of a configuration are sampled."""
        tail = max(_MARGIN * self._ring_down(mounting), 0.1)
        return Timing(self.sampling_rate, self.burst.cycles, self.burst.level_rms, mounting.frequencies, tail)

    def _ring_down(self, mounting: Mounting) -> float:
        moving = self.top_plate.density * mounting.top_plate + self.specimen.density * mounting.thickness / 3
        per_modulus = 1 / (mounting.thickness * moving)
        return ring_down(self.specimen.modulus, per_modulus, min(mounting.frequencies))

    def _burst_mistakes(self) -> Iterator[Mistake]:
        if self.burst.cycles < _FEWEST_CYCLES:
            text = (
                f"{self.burst.cycles:g} is not allowed: a burst of less than {_FEWEST_CYCLES:g} cycles has no frequency"
            )
            yield ("burst", "cycles"), text, self.burst.cycles
        values, steps = self.burst_frequencies, isinstance(self.frequencies, FrequencySteps)
        for i, f in enumerate(values):
            path: tuple[str | int, ...] = ("frequencies", "to") if steps else ("frequencies", i)
            if f >= 0.5 * self.sampling_rate:
                yield path, f"{f:g} Hz is not below half of the sampling_rate of {self.sampling_rate:g} Hz", f
                return
            if f in values[:i]:
                yield path, f"{f:g} Hz is there twice; each burst must have another frequency", f

    def _name_mistakes(self) -> Iterator[Mistake]:
        names = [mounting.name for mounting in self.mountings]
        for i, name in enumerate(names):
            if name in names[:i]:
                text = f"two configurations are called '{name}'; list them one by one, each with its own 'name'"
                listed = not isinstance(self.configurations, ConfigurationProduct)
                yield ("configurations", i) if listed else ("configurations",), text, name

    def _careless(self) -> Iterator[Mistake]:
        limits = dict.fromkeys(("channel_gain", "remount_gain", "density", "top_plate_mass"), _LARGEST_DEVIATION)
        limits["thickness"] = _LARGEST_DEVIATION * min(mounting.thickness for mounting in self.mountings)
        for name, limit in limits.items():
            value = getattr(self.uncertainty, name)
            if value > limit:
                text = f"{value:g} is not allowed: errors are drawn with this standard deviation, at most {limit:g}"
                yield ("uncertainty", name), text, value

    def _idle_fields(self) -> Iterator[Mistake]:
        for effect, kind in EFFECTS.working():
            text = f"does nothing without the effect that takes it; list {{effect: {effect}}}, or remove the field"
            for field in kind.takes:
                if getattr(self.specimen, field) is not None and not self.has(effect):
                    yield ("specimen", field), text, None

    def _effect_mistakes(self) -> Iterator[Mistake]:
        names = tuple(effect.effect for effect in self.effects)
        around = Surroundings(self.specimen, self.mountings, self.sampling_rate, names)
        for i, effect in enumerate(self.effects):
            if effect.effect in names[:i]:
                yield ("effects", i, "effect"), f"'{effect.effect}' is listed twice; keep one of the two", effect.effect
            for path, text, value in effect.mistakes(around):
                yield ("effects", i, *path), text, value

    def _ringing(self) -> Iterator[Mistake]:
        seconds = max(self._ring_down(mounting) for mounting in self.mountings)
        if seconds <= LONGEST_TAIL:
            return
        asked = [(path, text, None) for path, text in self.implausible()]
        yield from asked
        if not asked:
            text = f"a sample of so little loss rings for {seconds:.3g} s after a burst, more than {LONGEST_TAIL:g} s"
            yield ("specimen", "young_modulus"), f"{text}; give it a larger loss factor", None


def _name(configuration: OneConfiguration, usual_radius: float) -> str:
    sizes = f"h{1e3 * configuration.thickness:.6g}mm-t{1e3 * configuration.top_plate:.6g}mm"
    slim = "" if configuration.radius == usual_radius else f"-r{1e3 * configuration.radius:.6g}mm"
    return configuration.name or sizes + slim


def load_rig(path: str | Path) -> RigFile:
    """Read the file of a virtual campaign.

    Parameters
    ----------
    path : path
        A YAML file as described in ``docs/rig.md``.

    Raises
    ------
    InputError
        With every mistake in the file, each with its line and column.
    """
    file = Path(path)
    return read(file, RigFile, "rig", context={"folder": file.parent})

"""All bursts of a campaign at once: one causal modulus law, and what the laboratory does not know of its rig.

With E1 and E2 free at every burst a model swallows almost any effect. One law for all bursts and configurations leaves
it no such freedom: what it cannot explain shows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ArrayLike, ComplexArray, IndexArray, RealArray, distinct_rows, half_turn
from multilayer.chi2 import exceeded
from multilayer.errors import InputError
from multilayer.executors import run_all
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.law_deviation import LawDeviation
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.record_end import RecordEnd, period_of, rings_at_end
from multilayer.inference.derivative import Stencil, forward
from multilayer.inference.least_squares import TIGHT, distinct, hopeful, minimise, search
from multilayer.inference.priors import Parameter, Prior, Priors
from multilayer.inference.problem import Minimum
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.media.laws.parameters import LawSpace

MODEL_ERROR = 0.002  # relative, of a solver and of the plates' idealisation: one standard deviation
SMOOTH = 0.3  # correlation length of that error in ln f
_BINS = 6  # kept of each burst: its main lobe holds about as many independent ones
_DENSITY_STEP = 0.01
_COARSE = 0.02  # model error while only the law is sought: minima are wide then, and what nuisances explain is forgiven
Tell = Callable[[str], None]
N_BEST, N_FOLLOWED = 6, 3
_IMPROBABLE = 0.01
_SETTLED = 0.3  # of whitened residuals: less moves chi-square by a tenth
_MOST_SETTLED = 4
_FEW = 60  # evaluations after which a start of the coarse search must be near the best


@dataclass(frozen=True)
class ConfigurationData:
    """Measured ratios of spectra, top over base, of one configuration.

    Attributes
    ----------
    name : str
    thickness : float
        Of the specimen, m.
    frequency : array, shape (n,)
        Hz; the bins of all bursts, one burst after the other.
    burst : array of int, shape (n,)
        Index of the burst that each belongs to.
    ratio : complex array, shape (n,)
    variance : array, shape (n,)
        Of the real and of the imaginary part of the noise in ln(ratio).
    centres : array, shape (n_bursts,)
        Stated frequencies of the bursts, Hz.
    stretch_moments : complex array, shape (2, n), optional
        Mean amplitude of the sample's stretch, m, and mean of its square, as they act on each bin; see `BurstData`.
    ends : mapping
        By index of the burst, what its record lacks of the ring-down, where that matters.
    calibration_std : array, shape (n_bursts,), optional
        Standard deviation of each part of ln(ratio), the same at all bins of a burst.
    """

    name: str
    thickness: float
    frequency: RealArray
    burst: NDArray[np.intp]
    ratio: ComplexArray
    variance: RealArray
    centres: RealArray
    stretch_moments: ComplexArray | None = None
    ends: Mapping[int, RecordEnd] = field(default_factory=dict, repr=False)
    calibration_std: RealArray | None = None

    @cached_property
    def needed(self) -> RealArray:
        """Frequencies of which the model's motion is needed, Hz: the bins, then those of the records' ends."""
        return np.concatenate([self.frequency, *(end.frequency for end in self.ends.values())])

    def cut(self, motion: ComplexArray) -> ComplexArray:
        """Return a model's ratio (..., n) as the records show it, from its motion at `needed`."""
        n = len(self.frequency)
        if not self.ends:
            return motion
        shown, first = motion[..., :n].copy(), n
        for index, end in self.ends.items():
            last = first + len(end.frequency)
            shown[..., self.burst == index] -= end.missing(motion[..., first:last])
            first = last
        return shown

    @cached_property
    def log_ratio(self) -> ComplexArray:
        """Logarithm of `ratio`."""
        return np.asarray(np.log(self.ratio))

    def covariance(self, model_error: float) -> RealArray:
        """Return the covariance of one part of ln(ratio): noise, and a model's own error, smooth in ln f."""
        distance = np.subtract.outer(np.log(self.frequency), np.log(self.frequency)) / SMOOTH
        # a hundredth of the model's error has no smoothness: windowing, and bins that are not quite independent
        rough = (0.1 * model_error) ** 2
        covariance = np.diag(self.variance + rough) + model_error**2 * np.exp(-0.5 * distance**2)
        if self.calibration_std is not None:
            together = np.equal.outer(self.burst, self.burst)
            covariance += np.where(together, self.calibration_std[self.burst] ** 2, 0.0)
        return np.asarray(covariance)

    def part(self, kept: NDArray[np.intp]) -> ConfigurationData:
        """Return the data of some bursts, by their indices, which are numbered anew."""
        inside = np.isin(self.burst, kept)
        renumbered = np.searchsorted(kept, self.burst[inside])
        moments = None if self.stretch_moments is None else self.stretch_moments[:, inside]
        ends = {new: self.ends[old] for new, old in enumerate(kept.tolist()) if old in self.ends}
        return replace(
            self, frequency=self.frequency[inside], burst=renumbered, ratio=self.ratio[inside],
            variance=self.variance[inside], centres=self.centres[kept], stretch_moments=moments, ends=ends,
            calibration_std=None if self.calibration_std is None else self.calibration_std[kept],
        )  # fmt: skip

    def thinned(self, every: int) -> ConfigurationData:
        """Return the data with one in so many of each burst's bins, the same number from either end."""
        place = np.arange(len(self.burst)) - np.searchsorted(self.burst, self.burst)
        count = np.bincount(self.burst)[self.burst]
        inside = place % every == (np.minimum(every, count) - 1) // 2
        moments = None if self.stretch_moments is None else self.stretch_moments[:, inside]
        return replace(
            self, frequency=self.frequency[inside], burst=self.burst[inside], ratio=self.ratio[inside],
            variance=self.variance[inside], stretch_moments=moments,
        )  # fmt: skip


def whitening(data: ConfigurationData, model_error: float) -> RealArray:
    """Return the matrix W that makes one part of ln(ratio) independent and of unit variance."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(data.covariance(model_error))))


def configuration_data(campaign: Campaign, bursts: Sequence[BurstData]) -> list[ConfigurationData]:
    """Return the data of every configuration from its bursts.

    A burst whose record ends before its ring-down is left out: its ratio of spectra is not the transmissibility. The
    error of a calibration is common to all configurations: its variance counts as many times as there are of them, so
    that their mean is as uncertain as the calibration, and their difference by more than that.

    Raises
    ------
    InputError
        When no burst of a configuration is left.
    """
    found = []
    for configuration in campaign.configurations:
        own = [b for b in bursts if b.configuration == configuration.name and not b.cut_short]
        if not own:
            raise InputError(
                f"{configuration.name}: every record ends before the top plate's ring-down does; record longer"
            )
        parts = [_ratios(burst) for burst in own]
        index = np.repeat(np.arange(len(own)), [len(part[0]) for part in parts])
        f, ratio, variance, moments = (np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))
        centres = np.array([burst.frequency for burst in own])
        height = configuration.specimen_thickness
        std = np.sqrt(len(campaign.configurations)) * np.array([burst.calibration_std for burst in own])
        found.append(
            ConfigurationData(
                configuration.name, height, f, index, ratio, variance, centres, moments,
                calibration_std=std if np.any(std) else None,
            )
        )  # fmt: skip
    return found


def _ratios(burst: BurstData) -> tuple[RealArray, ComplexArray, RealArray, ComplexArray]:
    f, base, top = burst.in_band
    kept = np.unique(np.linspace(0, len(f) - 1, min(_BINS, len(f))).round().astype(int))
    f, base, top = f[kept], base[kept], top[kept]
    ratio = top / base
    power = burst.n_samples * (burst.noise.top**2 + np.abs(ratio) ** 2 * burst.noise.base**2)
    return f, ratio, power / (2 * np.abs(top) ** 2), burst.stretch_moments[:, kept]


@dataclass(frozen=True)
class RigChange:
    """How a rig differs from its description: density and plate mass relative, thickness in m."""

    density: RealArray
    thickness: RealArray
    plate_mass: RealArray

    @property
    def parts(self) -> tuple[RealArray, RealArray, RealArray]:
        """Density, thickness, plate mass."""
        return self.density, self.thickness, self.plate_mass


@dataclass(frozen=True)
class Neighbourhood:
    """ln(transmissibility) of rigs near a given one.

    Exact where the rig takes arrays of densities, heights and masses; else to second order in density and thickness,
    and in the plate's mass.

    Attributes
    ----------
    rig : Rig
    density_step, thickness_step : float
        Relative, and m; about as large as the changes asked for. A step of 0 for a thickness that is known.
    mass_step : float
        Relative; 0 where the plate's mass is known, or follows from density and modulus (`Rig.scales`).
    """

    rig: Rig
    density_step: float
    thickness_step: float
    mass_step: float = 0.0

    @cached_property
    def _around(self) -> list[tuple[Rig, int, int]]:
        """The rigs at the steps, with the steps taken in density and in thickness."""
        steps = [(1, 0), (-1, 0)] + ([(0, 1), (0, -1), (1, 1)] if self.thickness_step else [])
        return [(self._stepped(i, j), i, j) for i, j in steps]

    def _stepped(self, i: int, j: int) -> Rig:
        rig = self.rig.shifted("density", i * self.density_step, relative=True) if i else self.rig
        return rig.shifted("thickness", j * self.thickness_step, relative=False) if j else rig

    @cached_property
    def _plates(self) -> list[Rig]:
        return [self.rig.shifted("top_plate_mass", sign * self.mass_step, relative=True) for sign in (1, -1)]

    def log_motion(
        self,
        frequency: RealArray,
        modulus: ComplexArray,
        density: RealArray,
        thickness: RealArray,
        plate_mass: RealArray | None = None,
    ) -> ComplexArray:
        """Return ln(top/base), shape (..., n); `density`, `thickness` and `plate_mass` of shape (..., 1)."""
        if self.rig.takes_arrays:
            moved = self.rig.shifted("density", density, relative=True).shifted("thickness", thickness, relative=False)
            if plate_mass is not None:
                moved = moved.shifted("top_plate_mass", plate_mass, relative=True)
            return np.asarray(np.log(moved.transmissibility(frequency, modulus)))
        here = self.rig.transmissibility(frequency, modulus)
        total = np.log(here)
        if self.mass_step and plate_mass is not None and np.any(plate_mass):
            # known to so few thousandths that its product with the other changes is nothing
            ahead, behind = (np.log(rig.transmissibility(frequency, modulus) / here) for rig in self._plates)
            total = total + _parabola(ahead, behind, plate_mass / self.mass_step)
        if not (np.any(density) or np.any(thickness)):
            return np.asarray(total)
        change = {(i, j): np.log(rig.transmissibility(frequency, modulus) / here) for rig, i, j in self._around}
        x = density / self.density_step
        total = total + _parabola(change[1, 0], change[-1, 0], x)
        if self.thickness_step:
            y = thickness / self.thickness_step
            mixed = change[1, 1] - change[1, 0] - change[0, 1]
            total = total + _parabola(change[0, 1], change[0, -1], y) + mixed * x * y
        return np.asarray(total)


def _parabola(ahead: ComplexArray, behind: ComplexArray, x: RealArray) -> ComplexArray:
    return np.asarray(0.5 * (ahead - behind) * x + 0.5 * (ahead + behind) * x**2)


@dataclass(frozen=True)
class Nuisances:
    """The laboratory's stated uncertainties as parameters, and what they do to ln(ratio)."""

    known: Uncertainty
    configurations: tuple[str, ...]
    thicknesses: tuple[float, ...]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """One of gain and delay of the channels, per remounting, per height, of density and of the plates' mass."""
        known = self.known
        named = {
            "channel_gain": known.channel_gain,
            "channel_delay": known.channel_delay,
            "density": known.density,
            "top_plate_mass": known.top_plate_mass,
        }
        named |= {f"thickness[{h:g}]": known.thickness for h in sorted(set(self.thicknesses))}
        named |= {f"remount_gain[{name}]": known.remount_gain for name in self.configurations}
        units = {"channel_delay": "s", "thickness": "m"}
        return tuple(
            Parameter(
                name=name, prior=Prior(normal=(0.0, spread)), unit=units.get(name.split("[")[0], ""), nuisance=True
            )
            for name, spread in named.items()
            if spread > 0
        )

    @cached_property
    def priors(self) -> Priors:
        """Theirs."""
        return Priors.of(self.parameters)

    def of_rig(self, values: Mapping[str, RealArray], data: ConfigurationData) -> RigChange:
        """Return the changes of the rig in one configuration."""
        names = ("density", f"thickness[{data.thickness:g}]", "top_plate_mass")
        return RigChange(*(values.get(name, np.zeros(())) for name in names))

    def of_channels(self, values: Mapping[str, RealArray], data: ConfigurationData) -> ComplexArray:
        """Return what the channels add to ln(ratio), shape (..., n)."""
        zero = np.zeros(())
        gain = values.get("channel_gain", zero) + values.get(f"remount_gain[{data.name}]", zero)
        delay = values.get("channel_delay", zero)
        return np.asarray(gain[..., None] - 2j * np.pi * data.frequency * delay[..., None])

    def log_ratio(
        self,
        values: Mapping[str, RealArray],
        data: ConfigurationData,
        felt: RealArray,
        log_motion: Callable[[IndexArray], ComplexArray],
    ) -> ComplexArray:
        """Return ln(model/measured) of a configuration, the phase within half a turn, shape (m, n).

        Most samples of a derivative differ only in the channels, or in another configuration: the motion that they
        share is computed once.

        Parameters
        ----------
        values : mapping
            Of the nuisances, each of shape (m,) or ().
        data : ConfigurationData
        felt : array, shape (m, k)
            What else than the nuisances the motion depends on.
        log_motion : callable
            Gives ln(top/base) without the channels' gains and delays, shape (k, n), of k of the m samples.
        """
        kept, place = distinct_rows(felt, *self.of_rig(values, data).parts)
        difference = np.asarray((log_motion(kept) - data.log_ratio)[place] + self.of_channels(values, data))
        difference.imag = half_turn(difference.imag)
        return difference


@dataclass(frozen=True, eq=False)
class EndEffect:
    """What the records' ends change in ln(ratio), to first order about a point.

    Attributes
    ----------
    z : array, shape (n_parameters,)
    change : mapping
        By configuration, shape (n,).
    slope : mapping
        Derivative of that, shape (n, n_parameters).
    """

    z: RealArray
    change: Mapping[str, ComplexArray]
    slope: Mapping[str, ComplexArray]

    def at(self, name: str, z: RealArray) -> ComplexArray:
        """Return the change at coordinates of shape (..., n_parameters)."""
        return np.asarray(self.change[name] + (z - self.z) @ self.slope[name].T)

    @property
    def is_finite(self) -> bool:
        """Whether all of it is."""
        return all(np.all(np.isfinite(values)) for part in (self.change, self.slope) for values in part.values())


@dataclass(frozen=True)
class JointProblem:
    """A campaign as one inverse problem; a `Problem`.

    Attributes
    ----------
    data : sequence of ConfigurationData
    rigs : mapping
        The model of every configuration.
    space : LawSpace
        The law's parameters; its coordinates are uniform within the space's box.
    known : Uncertainty
    model_error : float
        Standard deviation of the model's own relative error, smooth in ln f.
    deviation : LawDeviation, optional
        How far the material may depart from the law; not at all when left out.
    end_effect : EndEffect, optional
        What the ends of the records change near a solution; computed anew at every point, at many times the cost, when
        left out.
    """

    data: Sequence[ConfigurationData]
    rigs: Mapping[str, Rig]
    space: LawSpace
    known: Uncertainty = field(default_factory=Uncertainty)
    model_error: float = MODEL_ERROR
    deviation: LawDeviation | None = None
    end_effect: EndEffect | None = None
    _neighbourhoods: dict[str, Neighbourhood] = field(default_factory=dict, init=False, repr=False, compare=False)

    @cached_property
    def nuisances(self) -> Nuisances:
        """What is uncertain of the rig and the channels."""
        return Nuisances(self.known, tuple(d.name for d in self.data), tuple(d.thickness for d in self.data))

    @cached_property
    def law_parameters(self) -> tuple[Parameter, ...]:
        """Natural logarithms of the law's unknowns, or of their products; `LawSpace.coordinates`."""
        boxes = zip(self.space.coordinates, self.space.low, self.space.high, strict=True)
        return tuple(
            Parameter(name=f"ln {name}", prior=Prior(uniform=(float(low), float(high)))) for name, low, high in boxes
        )

    @cached_property
    def modulus_parameters(self) -> tuple[Parameter, ...]:
        """What the modulus depends on: law, then its deviation."""
        return self.law_parameters + (() if self.deviation is None else self.deviation.parameters)

    @cached_property
    def _law_priors(self) -> Priors:
        return Priors.of(self.law_parameters)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Law, its deviation, then nuisances."""
        return (*self.modulus_parameters, *self.nuisances.parameters)

    @cached_property
    def _whitening(self) -> list[RealArray]:
        return [whitening(data, self.model_error) for data in self.data]

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data): real, then imaginary parts of ln(model/measured)."""
        parts = [self.whitened(i, logarithm) for i, logarithm in enumerate(self.log_ratios(z))]
        return np.concatenate(parts, axis=-1)

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative, shapes (n_data,) and (n_data, n_parameters), from one batch."""
        return forward(self.residual, z)

    def whitened(self, index: int, difference: ComplexArray) -> RealArray:
        """Return a difference of ln(ratio) of one configuration as independent unit normal numbers."""
        w = self._whitening[index]
        return np.concatenate([difference.real @ w.T, difference.imag @ w.T], axis=-1)

    def log_ratios(self, z: RealArray) -> list[ComplexArray]:
        """Return ln(model/measured), the phase within half a turn, shape (..., n), of every configuration."""
        n = len(self.modulus_parameters)
        rows = z.reshape(-1, z.shape[-1])
        values = self.nuisances.priors.named(rows[:, n:])
        found = []
        for data in self.data:

            def moved(kept: IndexArray, data: ConfigurationData = data) -> ComplexArray:
                own = {name: value[kept] for name, value in values.items()}
                return self.log_shown(data, rows[kept], own)

            difference = self.nuisances.log_ratio(values, data, rows[:, :n], moved)
            found.append(difference.reshape(*z.shape[:-1], -1))
        return found

    def law_coordinates(self, z: RealArray) -> RealArray:
        """Return the point of the law's space, shape (..., n_law)."""
        return self._law_priors.values(z[..., : len(self.law_parameters)])

    def modulus(self, z: RealArray, frequency: RealArray) -> ComplexArray:
        """Return E1 + i E2, Pa, shape (..., n_frequency), the deviation from the law included."""
        modulus = self.space.modulus(self.law_coordinates(z), frequency)
        if self.deviation is None:
            return modulus
        heights = z[..., len(self.law_parameters) : len(self.modulus_parameters)]
        return np.asarray(modulus * self.deviation.factor(heights, frequency))

    def log_shown(self, data: ConfigurationData, z: RealArray, values: Mapping[str, RealArray]) -> ComplexArray:
        """Return ln(top/base) at the bins of a configuration, shape (..., n), cut where the records are."""
        if data.ends and self.end_effect is None:
            return np.asarray(np.log(data.cut(np.exp(self.log_motion(data, data.needed, z, values)))))
        motion = self.log_motion(data, data.frequency, z, values)
        return motion if self.end_effect is None or not data.ends else motion + self.end_effect.at(data.name, z)

    def without_ends(self) -> JointProblem:
        """Return the problem as if all ring-downs were over."""
        return replace(self, data=[replace(data, ends={}) for data in self.data], end_effect=None)

    def end_effect_at(self, z: RealArray) -> EndEffect:
        """Return what the ends of the records change near a point."""
        stencil = Stencil.forward(z)
        points = stencil.points
        values = self.nuisances.priors.named(points[:, len(self.modulus_parameters) :])
        change, slope = {}, {}
        for data in self.data:
            if data.ends:
                with np.errstate(all="ignore"):  # a law that is not the sample's may have none: `is_finite`
                    motion = self.log_motion(data, data.needed, points, values)
                    shown = np.log(data.cut(np.exp(motion))) - motion[:, : len(data.frequency)]
                shown.imag = half_turn(shown.imag)
                change[data.name], slope[data.name] = stencil.linearised(shown)
        return EndEffect(z, change, slope)

    def log_motion(
        self, data: ConfigurationData, frequency: RealArray, z: RealArray, values: Mapping[str, RealArray]
    ) -> ComplexArray:
        """Return ln(top/base) of a configuration as the plate moves, shape (..., n), at frequencies (n,) in Hz."""
        modulus = self.modulus(z, frequency)
        amounts = self.nuisances.of_rig(values, data)
        near = self._near(data.name)
        density, thickness, mass = (x[..., None] for x in amounts.parts)
        if near.rig.scales:
            # force, stiffness and all masses in one proportion move alike: the plate's mass is exact
            modulus, density, mass = modulus / (1 + mass), (1 + density) / (1 + mass) - 1, np.zeros(())
        return near.log_motion(frequency, modulus, density, thickness, mass)

    def _near(self, name: str) -> Neighbourhood:
        if name not in self._neighbourhoods:
            step = self.known.density or _DENSITY_STEP
            rig, known = self.rigs[name], self.known
            mass_step = 0.0 if rig.scales else known.top_plate_mass
            self._neighbourhoods[name] = Neighbourhood(rig, step, known.thickness, mass_step)
        return self._neighbourhoods[name]


def first_guess(data: Sequence[ConfigurationData], rigs: Mapping[str, Rig]) -> tuple[RealArray, ComplexArray]:
    """Return the constant modulus that fits each configuration best: the data's frequencies, Hz, and moduli, Pa.

    Where to look for a law: a coarse search over (E1, loss factor).
    """
    moduli = np.geomspace(1e3, 1e9, 139)
    losses = np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8])
    grid = (moduli[:, None] * (1 + 1j * losses)).reshape(-1, 1)
    f: list[RealArray] = []
    found: list[ComplexArray] = []
    for one in data:
        modelled = rigs[one.name].transmissibility(one.frequency, grid + 0 * one.frequency)
        misfit = np.sum(np.abs(modelled - one.ratio) ** 2 / (np.abs(one.ratio) + np.abs(modelled)) ** 2, axis=-1)
        best = complex(grid[int(np.argmin(misfit)), 0])
        f.append(one.frequency)
        found.append(np.full(one.frequency.shape, best))
    return np.concatenate(f), np.concatenate(found)


def solve_joint(
    problem: JointProblem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = N_BEST,
    n_followed: int = N_FOLLOWED,
    seed: int = 0,
    tolerance: float = TIGHT,
    tell: Tell | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima of a joint problem, the most probable first.

    The law alone is sought first, from many starts; its best minima are then followed with the nuisances, but for those
    that fit far worse than the best.

    Parameters
    ----------
    problem : JointProblem
    starts : sequence of array, shape (n_law,)
        Coordinates of laws to follow besides the `n_best` drawn from the prior.
    n_best, n_followed : int
        How many are followed for the law alone, and with the nuisances.
    seed : int
    tolerance : float
        Relative change of the cost at which a descent has arrived.
    tell : callable, optional
        Called with a short text after each start.
    executor : Executor, optional
        Where the starts are followed; in this process when left out.
    """
    coarse = search_laws(problem, starts, n_best=n_best, seed=seed, tolerance=tolerance, tell=tell, executor=executor)
    followed = [m.z for m in coarse[:n_followed] if hopeful(m, coarse)]
    descents = run_all(partial(_descents, problem, tolerance), followed, executor)
    return distinct([found for ends in descents for found in ends])


def search_laws(
    problem: JointProblem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = N_BEST,
    seed: int = 0,
    tolerance: float = TIGHT,
    tell: Tell | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima with a large model error and what is uncertain of the rig as stated, for a start.

    Parameters as of `solve_joint`; coordinates are those of the problem.
    """
    law_only = replace(problem, known=Uncertainty(), model_error=_coarse(problem))
    found = search(
        law_only, starts, n_best=n_best, seed=seed, few=_FEW, tolerance=tolerance, tell=tell, executor=executor
    )
    rest = np.zeros(len(problem.nuisances.parameters))
    return [replace(minimum, z=np.concatenate([minimum.z, rest])) for minimum in found]


def _coarse(problem: JointProblem) -> float:
    return max(problem.model_error, _COARSE)


def _descents(problem: JointProblem, tolerance: float, start: RealArray) -> list[Minimum]:
    """Return where least squares end from a start, and if chance does not explain that, by way of a coarse model error.

    Where resonances are sharp, thickness and density must move before the law can: with a large model error they can.
    """
    direct = minimise(problem, start, tolerance=tolerance)
    if direct.converged and direct.cost < exceeded(_IMPROBABLE, direct.residual.size):
        return [direct]
    eased = minimise(replace(problem, model_error=_coarse(problem)), start, tolerance=tolerance)
    return [direct, minimise(problem, eased.z, tolerance=tolerance)]


def settle(problem: JointProblem, start: RealArray, tolerance: float = TIGHT) -> tuple[JointProblem, Minimum]:
    """Return the minimum reached from a start, and the problem with the ends of its records as they act there."""
    if not any(data.ends for data in problem.data):
        return problem, minimise(problem, start, tolerance=tolerance)
    effect = problem.end_effect_at(start)
    if not effect.is_finite:  # no ring-down of that law ends: it is not the sample's, and stays as it is
        return problem.without_ends(), minimise(problem.without_ends(), start, tolerance=tolerance)
    for _ in range(_MOST_SETTLED):
        near = replace(problem, end_effect=effect)
        minimum = minimise(near, start, tolerance=tolerance)
        there = problem.end_effect_at(minimum.z)
        if not there.is_finite:
            return near, minimum
        apart = [
            problem.whitened(i, there.change[data.name] - effect.at(data.name, minimum.z))
            for i, data in enumerate(problem.data)
            if data.ends
        ]
        start, effect = minimum.z, there
        if np.linalg.norm(np.concatenate(apart)) < _SETTLED:
            break
    near = replace(problem, end_effect=effect)
    return near, minimise(near, start, tolerance=tolerance)


def with_record_ends(problem: JointProblem, found: Minimum, bursts: Sequence[BurstData]) -> JointProblem:
    """Return a problem whose model is cut where records end, wherever that changes what a solution shows.

    Of rigs in closed form: finite elements would have to be solved at thousands of frequencies.

    Parameters
    ----------
    problem : JointProblem
    found : Minimum
        Says how long the ring-down lasts.
    bursts : sequence of BurstData
        All of the campaign.
    """
    stated = problem.nuisances.priors.named(found.z[len(problem.modulus_parameters) :])
    changed = []
    for data in problem.data:
        ends = dict(data.ends)
        rig = problem.rigs[data.name]

        def motion(f: RealArray, data: ConfigurationData = data) -> ComplexArray:
            return np.asarray(np.exp(problem.log_motion(data, f, found.z, stated)))

        for burst in bursts:
            at = np.flatnonzero(data.centres == burst.frequency)
            of_this = burst.configuration == data.name and at.size > 0 and rig.takes_arrays
            if not of_this or int(at[0]) in ends or not rings_at_end(burst):
                continue
            bins, variance = (values[data.burst == at[0]] for values in (data.frequency, data.variance))
            end = RecordEnd.of(burst, bins, rig.reach, period_of(burst, motion, rig.reach))
            share = end.missing(motion(end.frequency)) / motion(bins)
            if np.linalg.norm(np.abs(share) / np.sqrt(variance + problem.model_error**2)) > _SETTLED:
                ends[int(at[0])] = end
        changed.append(replace(data, ends=dict(sorted(ends.items()))))
    return replace(problem, data=changed, end_effect=None)


def law_space(law: str, frequency: ArrayLike, modulus: ArrayLike, elements: int | None = None) -> LawSpace:
    """Return the space of a law around a guess of its moduli."""
    from multilayer.media.laws.template import law_template

    f, e = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
    return LawSpace.of(law_template(law, elements, f), {}, {}, f, e)

"""The figures of many designs of a variant at once, for a search, and what designs measure, weigh and cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from multilayer.arrays import Numeric, RealArray
from multilayer.errors import InputError, MultilayerError
from multilayer.optimisation.aims import SIZES, Aim, Catalogue, Figures
from multilayer.optimisation.design import Variant
from multilayer.paths import locate, with_values
from multilayer.response.derivatives import plane_wave_derivatives
from multilayer.response.finite_size import (
    Window,
    finite_absorption,
    finite_absorption_slope,
    finite_transmission,
    radiation_impedance,
    refuse_other_fluid,
)
from multilayer.response.plane_wave import PlaneWave, plane_wave
from multilayer.simulation.bands import Grid
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.settings import DiffuseIncidence, PlaneIncidence
from multilayer.simulation.tasks import ENERGY_ERROR, keeps_energy
from multilayer.simulation.tolerances import allowed
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack
from multilayer.units import DB_PER_NEPER

_EVERY = 4  # of the frequencies of a band: 5 in a third octave
_ANGLES, _AZIMUTHS = 16, 8
_SIZE_STEP = 1e-3  # of central differences, in coordinates from 0 to 1: sizes are linear in each field
TINY = 1e-20  # of complex steps
_AT_ONCE = 30_000  # frequencies times directions times designs of a few layers: some 10 MB for each layer


@dataclass(frozen=True)
class Directions:
    """Plane waves that stand for a sound field: angles and azimuths, degrees, and the weight of each angle."""

    angle: RealArray
    azimuth: RealArray
    weight: RealArray


def directions(incidence: PlaneIncidence | DiffuseIncidence, *, turned_alike: bool) -> Directions:
    """Return the one plane wave, or Gauss's nodes in sin^2 of the angle; midpoints of half a turn where it matters."""
    if isinstance(incidence, PlaneIncidence):
        return Directions(np.array([incidence.angle]), np.zeros(1), np.ones(1))
    field = incidence.diffuse
    nodes, weights = leggauss(_ANGLES)
    square = np.sin(np.deg2rad(field.max_angle)) ** 2 * (nodes + 1) / 2
    angle = np.rad2deg(np.arcsin(np.sqrt(square)))
    if field.weighting == "gaussian":
        weights = weights * np.exp(-2 * np.deg2rad(angle) ** 2)
    azimuth = np.zeros(1) if turned_alike else 180 * (np.arange(_AZIMUTHS) + 0.5) / _AZIMUTHS
    return Directions(angle, azimuth, weights / np.sum(weights))


class Predictor:
    """Spectra and sizes of designs, for a search: fewer frequencies in a band and fixed directions.

    Parameters
    ----------
    variant : Variant
        Of the same space as all whose figures will be asked for.
    grid : Grid
        Frequencies of the results.
    catalogue : mapping
    asked : sequence of Aim
        Only what these need is computed.
    """

    def __init__(
        self, variant: Variant, grid: Grid, catalogue: Mapping[str, Catalogue], asked: tuple[Aim, ...]
    ) -> None:
        self.grid, self.catalogue = grid, catalogue
        self.points = grid.points if grid.points.ndim == 1 else grid.points[:, _EVERY // 2 :: _EVERY]
        self.sizes = {aim.name for aim in asked if aim.name in SIZES}
        self.has_spectra = any(aim.quantity for aim in asked)
        file = variant.simulation
        self.incidence, self.gas = file.incidence, file.ambient.gas
        self.window = None if file.finite_size is None else Window(file.finite_size.width, file.finite_size.height)
        if self.window is not None:
            refuse_other_fluid(variant.stack)
        self._radiations: dict[bytes, Any] = {}
        self.reference: RealArray | None = None
        if file.reference is not None and any(aim.quantity == "insertion_loss" for aim in asked):
            same_air = file.reference.model_copy(update={"ambient": file.ambient})
            self.reference = self._spectra(same_air)["transmission_loss"]

    def figures(self, variant: Variant, x: RealArray) -> Figures:
        """Return what designs give.

        Parameters
        ----------
        variant : Variant
        x : array, shape (n, n_ranges)
            Coordinates from 0 to 1.

        Returns
        -------
        Figures
            NaN for designs that are not allowed, or have no response that a simulation accepts.
        """
        values = variant.values(x)
        good = np.ones(len(x), dtype=bool)
        if values:
            good = np.asarray(allowed({path: locate(variant.stack, path) for path in values}, values, variant.stack))
        spectra = self._designs(variant, x, good) if self.has_spectra else {}
        sizes = self.measures(variant, x)
        for size in sizes.values():
            size[~good] = np.nan
        return Figures(spectra, sizes)

    def stepped(self, variant: Variant, x: RealArray) -> Figures:
        """Return what one design gives, stepping along one field in each row: figures + i `TINY` derivatives.

        Whatever is computed of such figures by analytic functions has its derivatives, over `TINY`, as its imaginary
        part, exactly: W. Squire & G. Trapp, SIAM Rev. 40 (1998) 110-112. The figures themselves come from the adjoint
        derivatives of plane waves.

        Parameters
        ----------
        variant : Variant
        x : array, shape (n_ranges,)
            Coordinates from 0 to 1.

        Raises
        ------
        MultilayerError, ArithmeticError
            When the design has no finite response.
        """
        spectra = self._stepped_spectra(variant, x) if self.has_spectra else {}
        values, steps = np.array([*variant.values(x).values()]), np.diag(_SIZE_STEP * variant.slopes(x))
        here, above, below = (self._sizes(variant, values + side) for side in (0 * steps, steps, -steps))
        sizes = {name: here[name] + TINY * 1j * (above[name] - below[name]) / (2 * _SIZE_STEP) for name in here}
        return Figures(spectra, sizes)

    def _stepped_spectra(self, variant: Variant, x: RealArray) -> dict[str, NDArray[Any]]:
        stack = with_values(variant.stack, {path: value.item() for path, value in variant.values(x).items()})
        around = directions(self.incidence, turned_alike=stack.isotropic_in_plane)
        paths, moved = [item.path for item in variant.ranges], TINY * variant.slopes(x)[:, None, None, None]
        with collected_warnings(), np.errstate(all="ignore"):
            found = plane_wave_derivatives(stack, paths, self.points.ravel(), around.angle, azimuth=around.azimuth)
            wave = found.response
            absorption, power = self._shares(wave, around)
            absorbed, through = found.absorption, None
            if self.window is not None:
                radiation, cosine = self._radiation(self.window, around), np.cos(np.deg2rad(around.angle))[:, None]
                absorbed = finite_absorption_slope(wave.reflection, found.reflection, radiation, cosine)
            if power is not None and found.transmission_loss is not None:
                through = -2 * power / DB_PER_NEPER * found.transmission_loss
                power = power + 1j * moved * through
            return self._averaged(absorption + 1j * moved * absorbed, power, around)

    def measures(self, variant: Variant, x: RealArray) -> dict[str, RealArray]:
        """Return the sizes that are asked for, by name, shape (n,): they cost next to nothing."""
        return self._sizes(variant, np.stack([*variant.values(x).values()], axis=-1) if variant.ranges else x)

    def _sizes(self, variant: Variant, values: RealArray) -> dict[str, RealArray]:
        """Return the sizes at values of the fields, SI, shape (n, n_ranges)."""
        columns = {item.path: values[:, i, None] for i, item in enumerate(variant.ranges)}
        sized = with_values(variant.stack, columns)
        return {
            name: np.array(
                np.broadcast_to(np.ravel(size_of(name, sized, variant, self.catalogue)), len(values)), dtype=float
            )
            for name in self.sizes
        }

    def _designs(self, variant: Variant, x: RealArray, good: Any) -> dict[str, RealArray]:
        stack, names = variant.stack, _names(variant.simulation)
        spectra = {name: np.full((len(x), len(self.grid.frequency)), np.nan) for name in names}
        rows = np.flatnonzero(good)
        around = directions(self.incidence, turned_alike=stack.isotropic_in_plane)
        step = max(1, _AT_ONCE // (self.points.size * around.angle.size * around.azimuth.size))
        for first in range(0, len(rows), step):
            some = rows[first : first + step]
            for part, values in self._parts(variant, stack, x, some):
                for name in names:
                    spectra[name][part] = values[name]
        if self.window is None:  # edges add to what a sample takes in
            # half of what a simulation forgives, whose figures are finer
            kept = keeps_energy(spectra["absorption"], spectra.get("transmission_loss"), ENERGY_ERROR / 2)
            refused = ~np.all(kept, axis=1)
            for spectrum in spectra.values():
                spectrum[refused] = np.nan
        return spectra

    def _parts(self, variant: Variant, stack: Stack, x: RealArray, rows: Any) -> Any:
        """Give rows and their spectra: all of them at once, one by one where some have no finite response."""
        try:
            yield rows, self._spectra(self._with(variant, stack, x[rows]))
        except (MultilayerError, ArithmeticError):
            if len(rows) > 1:
                for row in rows:
                    yield from self._parts(variant, stack, x, np.array([row]))

    @staticmethod
    def _with(variant: Variant, stack: Stack, x: RealArray) -> Stack:
        # axes: designs, frequencies, angles, azimuths
        return with_values(stack, {path: column[:, None, None, None] for path, column in variant.values(x).items()})

    def _spectra(self, stack: Stack) -> dict[str, RealArray]:
        """Return spectra over the frequencies of the grid, shape (n_designs, n_frequency)."""
        around = directions(self.incidence, turned_alike=stack.isotropic_in_plane)
        with collected_warnings(), np.errstate(all="ignore"):  # what is not finite is no design
            wave = plane_wave(stack, self.points.ravel(), around.angle, azimuth=around.azimuth)
            return self._averaged(*self._shares(wave, around), around)

    def _shares(self, wave: PlaneWave, around: Directions) -> tuple[RealArray, RealArray | None]:
        """Return absorbed and transmitted power over that which comes in, of every wave."""
        power = None if wave.transmission_loss is None else 10 ** (-wave.transmission_loss / 10)
        if self.window is None:
            return wave.absorption, power
        radiation, cosine = self._radiation(self.window, around), np.cos(np.deg2rad(around.angle))[:, None]
        absorption = finite_absorption(wave.reflection, radiation, cosine)
        return absorption, None if power is None else finite_transmission(power, radiation.real, cosine)

    def _averaged(
        self, absorption: NDArray[Any], power: NDArray[Any] | None, around: Directions
    ) -> dict[str, NDArray[Any]]:
        """Return the spectra of a sound field from the shares of its waves."""
        spectra = {"absorption": self._mean(absorption, around)}
        if power is not None:
            with np.errstate(divide="ignore"):
                spectra["transmission_loss"] = -10 * np.log10(self._mean(power, around))
            if self.reference is not None:
                spectra["insertion_loss"] = spectra["transmission_loss"] - self.reference
        return spectra

    def _mean(self, values: NDArray[Any], around: Directions) -> NDArray[Any]:
        """Return the mean over directions and the frequencies of each band."""
        mean = np.mean(values, axis=-1) @ around.weight
        shaped = mean.reshape(-1, *self.points.shape)
        return shaped if shaped.ndim == 2 else np.asarray(np.mean(shaped, axis=-1))

    def _radiation(self, window: Window, around: Directions) -> Any:
        key = around.angle.tobytes()
        if key not in self._radiations:
            k0 = 2 * np.pi * self.points.ravel()[:, None] / self.gas.sound_speed
            self._radiations[key] = radiation_impedance(window, k0, k0 * np.sin(np.deg2rad(around.angle)))[..., None]
        return self._radiations[key]


def _names(simulation: SimulationFile) -> list[str]:
    names = ["absorption", *(["transmission_loss"] if simulation.lets_through else [])]
    return [*names, *(["insertion_loss"] if simulation.reference is not None else [])]


def size_of(name: str, stack: Stack, variant: Variant, catalogue: Mapping[str, Catalogue]) -> Numeric:
    """Return thickness (m), mass (kg/m2) or price (per m2) of a design, the fields of its stack numbers or arrays.

    Raises
    ------
    InputError
        When the mass or the price of a layer is not known.
    """
    layers = range(len(stack.layers))
    if name == "thickness":
        return sum(stack.layers[i].depth for i in layers)
    one = _mass if name == "mass" else _price
    return sum(one(stack, i, variant.materials[i], catalogue) for i in layers)


def _entry(stack: Stack, i: int, material: str | None, catalogue: Mapping[str, Catalogue]) -> Catalogue | None:
    names = (material, stack.layers[i].name)
    return next((catalogue[name] for name in names if name is not None and name in catalogue), None)


def _mass(stack: Stack, i: int, material: str | None, catalogue: Mapping[str, Catalogue]) -> Numeric:
    layer, entry = stack.layers[i], _entry(stack, i, material, catalogue)
    if entry is not None and entry.mass is not None:
        return entry.mass
    if entry is not None and entry.density is not None:
        return entry.density * layer.volume_per_area
    mass = layer.mass_per_area
    if mass is None:
        raise _unknown("mass", layer.name or str(i), material, f"{layer.type} has no density", "density: 30 kg/m^3")
    return mass


def _price(stack: Stack, i: int, material: str | None, catalogue: Mapping[str, Catalogue]) -> Numeric:
    layer, entry = stack.layers[i], _entry(stack, i, material, catalogue)
    if entry is None:
        if layer.type == "fluid":  # a cavity
            return 0.0
        raise _unknown("price", layer.name or str(i), material, "it is in no catalogue", "price_per_volume: 200")
    price = entry.price + entry.price_per_volume * layer.volume_per_area
    return price + (entry.price_per_mass * _mass(stack, i, material, catalogue) if entry.price_per_mass else 0.0)


def _unknown(what: str, layer: str, material: str | None, why: str, remedy: str) -> InputError:
    name = f"'{material}'" if material else layer
    text = f"the {what} of layer {layer} is not known, {why}; say it: catalogue: {{{name}: {{{remedy}}}}}"
    return InputError(text)

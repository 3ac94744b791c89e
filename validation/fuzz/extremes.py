"""Stacks of extreme numbers, within the bounds of `multilayer.bounds` and a little beyond, through a simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from multilayer.bounds import magnitudes
from multilayer.config.validate import placed_in
from multilayer.layers import LAYERS
from multilayer.media.laws import LAWS
from multilayer.stack import Ambient
from multilayer.units import field_unit
from validation.fuzz.watch import PASSED, Outcome, own, tried
from validation.fuzz.yaml_mutants import simulated

_PORES = {"porosity": 0.99, "flow_resistivity": 1e4, "tortuosity": 1.01, "viscous_length": 1e-4, "thermal_length": 2e-4}
_SOLID = {"thickness": 1e-2, "density": 1e3, "young_modulus": 1e7, "poisson_ratio": 0.3, "loss_factor": 0.1}
_FRAME = {"frame_density": 9.0, "young_modulus": 1.6e5, "poisson_ratio": 0.4, "loss_factor": 0.1}
_BASES: tuple[dict[str, Any], ...] = (
    {"type": "fluid", "thickness": 0.1, "density": 1.2, "sound_speed": 343.0},
    {"type": "elastic_solid", **_SOLID},
    {"type": "elastic_plate", **_SOLID},
    {"type": "poroelastic", "thickness": 0.03, **_PORES, **_FRAME},
    {"type": "poroelastic", "model": "jcal", "thermal_permeability": 6e-9, "thickness": 0.03, **_PORES, **_FRAME},
    {"type": "equivalent_fluid", "thickness": 0.05, **_PORES},
    {"type": "equivalent_fluid", "model": "miki", "thickness": 0.05, "flow_resistivity": 1e4},
    {"type": "equivalent_fluid", "model": "wilson", "thickness": 0.05, "porosity": 0.98, "tortuosity": 1.05,
     "vorticity_time": 1e-4, "entropy_time": 2e-4},
    {"type": "equivalent_fluid", "model": "horoshenkov_swift", "thickness": 0.05, "porosity": 0.4,
     "median_pore_size": 1e-4, "pore_size_deviation": 0.4},
    {"type": "limp", "thickness": 0.05, **_PORES, "frame_density": 30.0},
    {"type": "screen", "flow_resistance": 400.0, "surface_density": 0.2},
    {"type": "membrane", "surface_density": 0.3, "tension": 5000.0, "loss_factor": 0.1},
    {"type": "orthotropic_plate", "thickness": 0.01, "density": 450.0, "young_modulus_x": 11e9, "young_modulus_y": 5e8,
     "poisson_ratio_xy": 0.4, "shear_modulus_xy": 7e8, "azimuth": 30.0},
    {"type": "perforated_plate", "thickness": 1e-3, "hole_radius": 5e-4, "perforation": 0.05},
    {"type": "perforated_plate", "model": "maa", "thickness": 2e-4, "hole_radius": 1e-4, "perforation": 0.01},
    {"type": "perforated_plate", "thickness": 2e-3, "slit_width": 1e-3, "perforation": 0.1, "density": 700.0,
     "young_modulus": 2e9, "poisson_ratio": 0.3, "loss_factor": 0.01, "hole_velocity": 1.0, "grazing_mach": 0.1},
    {"type": "perforated_plate", "model": "maa", "thickness": 5e-4, "slit_width": 1e-4, "perforation": 0.02,
     "density": 1400.0, "bias_velocity": 2.0, "discharge_coefficient": 0.8},
    {"type": "helmholtz_resonators", "neck_radius": 5e-3, "neck_length": 0.02, "pitch": 0.1, "cavity_depth": 0.1,
     "cavity_radius": 0.04},
    {"type": "equivalent_fluid", "model": "double_porosity", "thickness": 0.1, "perforation": 0.1, "hole_radius": 5e-3,
     **_PORES},
    {"type": "equivalent_fluid", "model": "double_porosity", "thickness": 0.1, "perforation": 0.1, "slit_width": 5e-3,
     **_PORES},
    {"type": "equivalent_fluid", "model": "fibres", "thickness": 0.05, "porosity": 0.97, "fibre_diameter": 1e-5,
     "fibre_orientation": 0.3},
    {"type": "equivalent_fluid", "model": "open_cells", "thickness": 0.05, "porosity": 0.97, "cell_size": 1e-3},
    {"type": "limp", "model": "grains", "thickness": 0.05, "porosity": 0.4, "grain_diameter": 1e-3,
     "frame_density": 30.0},
    {"type": "corrugated_plate", **_SOLID, "period": 0.08, "height": 0.02},
    {"type": "corrugated_plate", **_SOLID, "period": 0.2, "height": 0.04, "crest_width": 0.03, "trough_width": 0.12},
    {"type": "ribbed_plate", **_SOLID, "rib_height": 0.02, "rib_width": 3e-3, "rib_spacing": 0.1, "azimuth": 30.0},
    {"type": "viscothermal_fluid", "thickness": 1e-4},
    {"type": "viscothermal_fluid", "thickness": 0.03, "tube_radius": 3e-4, "open_area": 0.8},
)  # fmt: skip
_LAWS: tuple[dict[str, Any], ...] = (
    {"law": "zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1e7, "relaxation_time": 1e-4},
    {
        "law": "fractional_zener",
        "relaxed_modulus": 1e5,
        "unrelaxed_modulus": 1e7,
        "relaxation_time": 1e-4,
        "order": 0.6,
    },
    {"law": "kelvin_voigt", "young_modulus": 1e6, "viscosity": 10.0},
    {"law": "loss_factor", "young_modulus": 1e6, "loss_factor": 0.1},
)
_AMBIENT = {"temperature": 293.0, "pressure": 101325.0, "relative_humidity": 0.5, "density": 1.2, "sound_speed": 343.0,
            "viscosity": 1.8e-5, "prandtl": 0.71, "heat_capacity_ratio": 1.4}  # fmt: skip


class ExtremeTarget:
    """Stacks by their number; each number of them is extreme with the probability `share`."""

    def __init__(self, folder: Path, seed: int, share: float = 0.3, beyond: float = 0.02) -> None:
        self.folder, self.seed, self.share, self.beyond = folder, seed, share, beyond

    def data(self, index: int) -> dict[str, Any]:
        """Return the data of a simulation file."""
        rng = np.random.default_rng([self.seed, index])
        layers = [self._layer(rng) for _ in range(int(rng.integers(1, 5)))]
        given = [name for name in _AMBIENT if rng.random() < 0.2]
        ambient = self._spoilt(Ambient, {name: _AMBIENT[name] for name in given}, rng)
        frequency = sorted({float(10 ** rng.uniform(0, np.log10(5e4))) for _ in range(4)})
        if rng.random() < 0.2:
            frequency = sorted({self._number("Hz", rng) for _ in range(3)})
        fluid = {"type": "fluid", "density": self._number("kg/m^3", rng), "sound_speed": self._number("m/s", rng)}
        termination: Any = ["rigid", "ambient", "free", fluid][int(rng.integers(4))]
        incidence: Any = ["normal", float(rng.uniform(0, 89.99)), 89.9999, "diffuse"][
            int(rng.choice(4, p=[0.4, 0.4, 0.15, 0.05]))
        ]
        return {
            "version": 1, "ambient": ambient, "layers": layers, "termination": termination, "frequency": frequency,
            "incidence": incidence,
        }  # fmt: skip

    def _layer(self, rng: np.random.Generator) -> dict[str, Any]:
        base = dict(_BASES[int(rng.integers(len(_BASES)))])
        if "young_modulus" in base and rng.random() < 0.3:
            law = dict(_LAWS[int(rng.integers(len(_LAWS)))])
            base["young_modulus"], base["loss_factor"] = self._spoilt(LAWS[law["law"]], law, rng), 0.0
        return self._spoilt(LAYERS[base["type"]], base, rng)

    def _spoilt(self, model: Any, data: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
        for name, value in data.items():
            info = model.model_fields[name]
            unit = field_unit(info)
            if unit is None or not isinstance(value, float) or rng.random() > self.share:
                continue
            data[name] = self._number(unit, rng, self._limits(info))
        return data

    @staticmethod
    def _limits(info: Any) -> tuple[float, float]:
        inner = [
            item
            for argument in getattr(info.annotation, "__args__", ())
            for item in getattr(argument, "__metadata__", ())
        ]
        low, high = -np.inf, np.inf
        for item in (*info.metadata, *inner):
            for one in getattr(item, "metadata", [item]):
                low = max([low, *(float(getattr(one, k)) for k in ("gt", "ge") if getattr(one, k, None) is not None)])
                high = min([high, *(float(getattr(one, k)) for k in ("lt", "le") if getattr(one, k, None) is not None)])
        return low, high

    def _number(self, unit: str, rng: np.random.Generator, limits: tuple[float, float] = (0.0, np.inf)) -> float:
        known = magnitudes(unit)
        low, high = np.log10(known.least), np.log10(known.most)
        if rng.random() < self.beyond:
            low, high = low - 30, high + 30
        value = float(10 ** rng.uniform(low, high))
        bottom, top = limits
        if not bottom < value < top:
            # close to an end of what the field may be
            near = 10 ** rng.uniform(-16, 0)
            value = bottom + near if np.isinf(top) else float(rng.choice([top - near * (top - bottom), bottom + near]))
        return value

    def __call__(self, index: int) -> Outcome:
        file = self.folder / own("extreme.yaml")
        file.write_text(yaml.safe_dump(self.data(index), sort_keys=False), encoding="utf-8")

        def simulate() -> str:
            with placed_in(file):
                simulated(file)
            return PASSED

        return tried(simulate, file)

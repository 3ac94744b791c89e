"""Poroelastic layers as cards of Nastran's bulk data: MATPE1 with the MAT1 and MAT10 that it refers to.

Fields of MATPE1, MAT1 and MAT10 as in Altair OptiStruct's reference guide (bulk data entries). MATPE1 has the pores of
Johnson, Champoux and Allard; its frame is a MAT1, the gas in its pores a MAT10.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, TypeAlias

import numpy as np

from multilayer.doors import ascii_line
from multilayer.errors import InputError, Problem
from multilayer.layers.poroelastic import Poroelastic
from multilayer.matrix.wave import Wave
from multilayer.media.gas import Gas
from multilayer.stack import Stack

FrameDensity: TypeAlias = Literal["solid", "bulk"]
FRAME_DENSITIES: dict[FrameDensity, str] = {
    "solid": "mass over the frame's own volume: frame_density / (1 - porosity)",
    "bulk": "mass of the frame over the whole volume: frame_density",
}
_BIOT_FACTOR = 1.0  # of a frame whose material is much stiffer than itself, as in the model of `poroelastic`
_PROBED = np.geomspace(1.0, 1e5, 6)  # Hz
_LAST_ID = 99_999_999
_LINE = 70
_Field: TypeAlias = int | float | None


def poroelastic_cards(stack: Stack, frame_density: FrameDensity, *, first_id: int = 1, name: str = "stack") -> str:
    """Return cards of all poroelastic layers of a stack, in SI units and large fields.

    Parameters
    ----------
    stack : Stack
    frame_density : {'solid', 'bulk'}
        Which density the program takes as RHO of the frame's MAT1, see `FRAME_DENSITIES`: its manual says. The two
        differ by a factor of 1/(1 - porosity), 50 for a porosity of 98 %.
    first_id : int
        Of the first material: two for each layer, one after the other, then the gas that all share.
    name : str
        Of the stack, for a comment.

    Raises
    ------
    InputError
        When there is no poroelastic layer, or one has what a card cannot hold: pores by another model, a modulus that
        depends on frequency; or for numbers out of range.
    """
    layers = [(i, layer) for i, layer in enumerate(stack.layers) if isinstance(layer, Poroelastic)]
    if not layers:
        text = "no layer is poroelastic, and MATPE1 holds no other; export a table, as --as admittance_matrix"
        raise InputError(Problem(text, "layers"))
    if frame_density not in FRAME_DENSITIES:
        allowed = ", ".join(FRAME_DENSITIES)
        raise InputError(f"a frame density of '{frame_density}' is not known; allowed: {allowed}")
    most = _LAST_ID - 2 * len(layers)
    if not 1 <= first_id <= most:
        raise InputError(f"a first id of {first_id} is not allowed; it must be a whole number from 1 to {most}")
    problems = [problem for i, layer in layers for problem in _misfits(i, layer)]
    if problems:
        raise InputError(problems)
    gas, gas_id = stack.ambient.gas, first_id + 2 * len(layers)
    lines = [
        _comment(f"{name}: poroelastic layers, SI units (kg, m, s, Pa)"),
        _comment(f"RHO of MAT1 is {frame_density}:"),
        _comment(FRAME_DENSITIES[frame_density]),
        _comment("solid elements take them by PSOLID with FCTN = PORO"),
    ]
    for n, (i, layer) in enumerate(layers):
        lines.append(_comment(f"layer {layer.name or i}, {layer.thickness:g} m thick"))
        lines += _layer_cards(layer, gas, frame_density, (first_id + 2 * n, first_id + 2 * n + 1, gas_id))
    bulk_modulus = gas.density * gas.sound_speed**2
    lines += [_comment("gas in the pores"), *_card("MAT10", gas_id, bulk_modulus, gas.density, gas.sound_speed)]
    left_out = [layer.name or f"{i} ({layer.type})" for i, layer in enumerate(stack.layers) if (i, layer) not in layers]
    lines += [_comment(f"without a card: layer {layer}") for layer in left_out]
    return "".join(f"{line}\n" for line in lines)


def _misfits(index: int, layer: Poroelastic) -> Iterator[Problem]:
    if layer.model != "jca":
        text = f"'{layer.model}' has no card: MATPE1 holds the five parameters of model jca; state or fit these"
        yield Problem(text, f"layers.{index}.model")
    modulus = _moduli(layer)
    if np.ptp(modulus.real) > 0 or np.ptp(modulus.imag) > 0:
        text = "depends on frequency, and MAT1 holds a constant; write its value at the frequencies of interest"
        yield Problem(text, f"layers.{index}.young_modulus")


def _moduli(layer: Poroelastic) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    """Return the modulus at some frequencies, Pa."""
    values = layer.complex_modulus(Wave.incident(_PROBED, 0.0, Gas(1.2, 343.0, 1.8e-5, 0.71, 1.4, 101325.0)))
    return np.broadcast_to(np.asarray(values, dtype=complex), _PROBED.shape)


def _layer_cards(layer: Poroelastic, gas: Gas, frame_density: FrameDensity, ids: tuple[int, int, int]) -> Iterator[str]:
    """Give the lines of a layer's MATPE1 and MAT1; ids of these two and of the MAT10."""
    pores, frame, fluid = ids
    modulus = complex(_moduli(layer)[0])
    density = layer.frame_density / (1 - layer.porosity) if frame_density == "solid" else layer.frame_density
    yield from _card(
        "MATPE1", pores, frame, fluid, _BIOT_FACTOR, None, None, None, None,
        gas.viscosity, gas.heat_capacity_ratio, gas.prandtl, layer.porosity,
        layer.tortuosity, layer.flow_resistivity, layer.viscous_length, layer.thermal_length,
    )  # fmt: skip
    loss = modulus.imag / modulus.real
    yield from _card("MAT1", frame, modulus.real, None, layer.poisson_ratio, density, None, None, loss)


def _card(name: str, *fields: _Field) -> Iterator[str]:
    """Give the lines of a card in large fields: 8 characters and four fields of 16, two lines for eight fields."""
    padded = (*fields, *(None,) * (-len(fields) % 8))
    for start in range(0, len(padded), 4):
        head = f"{name}*" if start == 0 else "*"
        yield f"{head:8}{''.join(map(_field, padded[start : start + 4]))}".rstrip()


def _field(value: _Field) -> str:
    if value is None:
        return " " * 16
    return f"{value:16d}" if isinstance(value, int) else f"{value:16.9E}"


def _comment(text: str) -> str:
    return f"$ {ascii_line(text, _LINE)}"

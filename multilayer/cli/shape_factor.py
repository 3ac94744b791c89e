"""``multilayer shape-factor``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from multilayer.cli.options import AsJson, finish, quantities, quantity

_SHAPES = "0.25,0.5,1,1.5,2.5"
_RATIOS = "0.1,0.2,0.3,0.4,0.45,0.49"
_SAMPLE = {"--radius": "m", "--thickness": "m", "--density": "kg/m^3", "--young-modulus": "Pa"}


def shape_factor(
    poisson_ratio: Annotated[
        str, typer.Option("--poisson-ratio", metavar="NU", help="One, or several with commas; from 0 to below 0.5.")
    ] = _RATIOS,
    shape: Annotated[
        str | None,
        typer.Option("--shape", metavar="S", help=f"Radius over twice the thickness; several with commas. [{_SHAPES}]"),
    ] = None,
    radius: Annotated[str | None, typer.Option(metavar="LENGTH", help="Of the sample, as '22.5 mm'.")] = None,
    thickness: Annotated[str | None, typer.Option(metavar="LENGTH", help="Of the sample, as '25 mm'.")] = None,
    frequency: Annotated[
        str | None,
        typer.Option(metavar="F", help="For dynamic factors: one or several with commas, as '100 Hz,1 kHz'."),
    ] = None,
    density: Annotated[str | None, typer.Option(metavar="DENSITY", help="Of the sample, as '80 kg/m^3'.")] = None,
    young_modulus: Annotated[str | None, typer.Option(metavar="E", help="Of the sample, as '200 kPa'.")] = None,
    loss_factor: Annotated[float, typer.Option(metavar="ETA", help="Of the sample.")] = 0.1,
    plate_thickness: Annotated[str, typer.Option(metavar="LENGTH", help="Of a top plate of steel.")] = "1 mm",
    as_json: AsJson = False,
) -> None:
    """Print how much stiffer a glued disc is than a free rod: g = apparent modulus / Young's modulus.

    Static factors g(nu, S) for every Poisson's ratio and shape; with frequencies, dynamic ones of a sample under a top
    plate: complex, the ratio that a rod model would find.

    Example: multilayer shape-factor --poisson-ratio 0.3 --radius "22.5 mm" --thickness "25 mm"
    --frequency "100 Hz,500 Hz,1 kHz" --density "80 kg/m^3" --young-modulus "200 kPa"
    """
    from multilayer.report.shape_factors import shape_factors_report
    from multilayer.rig.shape_factor import dynamic_shape_factor, static_shape_factor
    from multilayer.rig.two_plate import TwoPlateRig

    ratios = quantities("--poisson-ratio", poisson_ratio, "")
    given = {"--radius": radius, "--thickness": thickness, "--density": density, "--young-modulus": young_modulus}
    if frequency is None:
        shapes = _shapes(shape, radius, thickness)
        rows = {nu: [complex(static_shape_factor(nu, s)) for s in shapes] for nu in ratios}
        report = shape_factors_report("shape", shapes, rows)
    else:
        a, h, rho, modulus = (quantity(name, text, _SAMPLE[name]) for name, text in given.items())
        f, plate = quantities("--frequency", frequency, "Hz"), quantity("--plate-thickness", plate_thickness, "m")
        rigs = {nu: TwoPlateRig(a, h, rho, nu, plate) for nu in ratios}
        rows = {nu: list(dynamic_shape_factor(rig, f, modulus * (1 + 1j * loss_factor))) for nu, rig in rigs.items()}
        report = shape_factors_report("frequency_hz", f, rows)
    finish(report, as_json=as_json)


def _shapes(shape: str | None, radius: str | None, thickness: str | None) -> Sequence[float]:
    if radius is None and thickness is None:
        return quantities("--shape", shape or _SHAPES, "")
    return [quantity("--radius", radius, "m") / (2 * quantity("--thickness", thickness, "m"))]

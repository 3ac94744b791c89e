"""Examples of Allard & Atalla, Propagation of Sound in Porous Media, 2nd edition, Wiley 2009: chapters 6, 11 and 12.

``python -m examples.reproducing.allard_atalla_2009 [FOLDER]``

Materials are those of the book's tables in the material library, named below by chapter and table.
"""

import numpy as np

from examples.reproducing.drawing import axes, write
from multilayer import Stack, diffuse_field, plane_wave

GLASS_WOOL = "AA2009/T6.1/glass_wool"


def stack(*layers: tuple[str, float] | tuple[str, float, str], termination: str = "rigid") -> Stack:
    """Return layers of materials, each with its thickness in m and, where it is not the library's, its type."""
    return Stack.model_validate({"layers": [_layer(*one) for one in layers], "termination": termination})


def _layer(name: str, thickness: float | None, kind: str | None = None) -> dict:
    given = {"material": f"AA2009/{name}", "thickness": thickness, "type": kind}
    return {key: value for key, value in given.items() if value is not None}


def impedance(thickness: float, frequency, kind: str | None = None) -> np.ndarray:
    """Return the surface impedance of the glass wool of table 6.1 on a wall, in that of air."""
    wool = stack(("T6.1/glass_wool", thickness, kind))
    return plane_wave(wool, frequency).surface_impedance / wool.ambient.gas.impedance


def frame_resonance(thickness: float) -> float:
    """Return where the impedance of the wool departs most from that of a rigid frame, Hz."""
    frequency = np.arange(200.0, 1500.0, 0.5)
    moved = impedance(thickness, frequency) - impedance(thickness, frequency, "equivalent_fluid")
    return float(frequency[np.argmax(np.abs(moved))])


def glass_wool():
    """Draw chapter 6: the surface impedance of two thicknesses of wool, with its frame's quarter-wave resonance."""
    figure, grid = axes(1, 2)
    frequency = np.geomspace(200, 1500, 600)
    for axis, thickness in zip(grid[0], (0.1, 0.056), strict=True):
        for kind, style in ((None, "-"), ("equivalent_fluid", ":")):
            found = impedance(thickness, frequency, kind)
            frame = "Biot" if kind is None else "rigid frame"
            axis.plot(frequency, found.real, f"C0{style}", label=f"Re, {frame}")
            axis.plot(frequency, found.imag, f"C1{style}", label=f"Im, {frame}")
        axis.set(xlabel="frequency / Hz", ylabel="Z / Z0", title=f"glass wool, {1e3 * thickness:g} mm")
    grid[0, 0].legend()
    return figure


def limp_wool():
    """Draw table 11.2: a soft fibrous layer whose frame is moved by the air."""
    figure, grid = axes(1, 1)
    frequency = np.geomspace(50, 5000, 500)
    for kind, label in (("limp", "limp"), ("equivalent_fluid", "rigid frame")):
        found = plane_wave(stack(("T11.2/soft_fibrous", 0.05, kind)), frequency).absorption
        grid[0, 0].semilogx(frequency, found, label=label)
    grid[0, 0].axvline(decoupling_frequency(), color="0.5", linestyle=":", label="decoupling frequency")
    grid[0, 0].set(xlabel="frequency / Hz", ylabel="absorption", title="soft fibrous layer, 50 mm, on a wall")
    grid[0, 0].legend()
    return figure


def decoupling_frequency() -> float:
    """Return sigma phi^2 / (2 pi rho1) of the soft fibrous layer, Hz (Zwikker and Kosten)."""
    (wool,) = stack(("T11.2/soft_fibrous", 0.05)).layers
    return wool.flow_resistivity * wool.porosity**2 / (2 * np.pi * wool.frame_density)


COVERED = {
    "table 11.3: foam under a porous sheet": (
        [("T11.3/foam", 0.038)],
        [("T11.3/porous_sheet", 0.45e-3), ("T11.3/foam", 0.038)],
    ),
    "table 11.6: foam under a membrane": (
        [("T11.6/foam", 0.02)],
        [("T11.6/membrane", None), ("T11.6/foam", 0.02)],
    ),
}


def covered_foams():
    """Draw tables 11.3 and 11.6: absorption of a foam, bare and covered."""
    figure, grid = axes(1, 2, sharey=True)
    frequency = np.geomspace(100, 5000, 500)
    for axis, (title, cases) in zip(grid[0], COVERED.items(), strict=True):
        for layers, label in zip(cases, ("bare", "covered"), strict=True):
            axis.semilogx(frequency, plane_wave(stack(*layers), frequency).absorption, label=label)
        axis.set(xlabel="frequency / Hz", ylabel="absorption", title=title)
    grid[0, 0].legend()
    return figure


BLANKET = (("T11.4/blanket1", 4e-3), ("T11.4/screen2", 0.8e-3), ("T11.4/foam3", 5e-3), ("T11.4/foam4", 16e-3))


def multilayer_impedance():
    """Draw table 11.4: four bonded layers on a wall, at normal incidence."""
    figure, grid = axes(1, 1)
    frequency = np.linspace(50, 2000, 600)
    layers = stack(*BLANKET)
    found = plane_wave(layers, frequency).surface_impedance / layers.ambient.gas.impedance
    grid[0, 0].plot(frequency, found.real, label="Re")
    grid[0, 0].plot(frequency, found.imag, label="Im")
    grid[0, 0].set(xlabel="frequency / Hz", ylabel="Z / Z0", title="table 11.4: blanket, screen, two foams")
    grid[0, 0].legend()
    return figure


def panel_and_foam():
    """Draw table 12.1: transmission loss of an aluminium panel, bare and with foam behind a film of air; diffuse."""
    figure, grid = axes(1, 1)
    frequency = np.geomspace(100, 5000, 120)
    panel, foam = ("T12.1/panel", 1e-3), ("T12.1/foam", 0.0508)
    for layers, label in (((panel,), "panel"), ((panel, foam), "panel and foam")):
        found = diffuse_field(stack(*layers, termination="ambient"), frequency).transmission_loss
        grid[0, 0].semilogx(frequency, found, label=label)
    grid[0, 0].set(xlabel="frequency / Hz", ylabel="transmission loss, diffuse to 78° / dB", title="table 12.1")
    grid[0, 0].legend()
    return figure


if __name__ == "__main__":
    write(
        {
            "allard_atalla_glass_wool": glass_wool,
            "allard_atalla_limp_wool": limp_wool,
            "allard_atalla_covered_foams": covered_foams,
            "allard_atalla_four_layers": multilayer_impedance,
            "allard_atalla_panel_and_foam": panel_and_foam,
        }
    )

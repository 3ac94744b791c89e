"""What a shell offers for the names that options take, read without loading what they name."""

from __future__ import annotations

from collections.abc import Callable


def _of_group(group: str) -> Callable[[str], list[str]]:
    """Return the completion of names that entry points advertise: effects, laws, layers, methods, plugins included."""

    def complete(incomplete: str) -> list[str]:
        from multilayer.registry import Registry

        names = Registry[object](group, "").names()
        return [name for name in names if name.startswith(incomplete)]

    return complete


def among(*names: str) -> Callable[[str], list[str]]:
    """Return the completion of some names."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


def fitted_laws(incomplete: str) -> list[str]:
    """Complete the laws of a joint fit."""
    return [*among("auto")(incomplete), *laws(incomplete)]


def materials(incomplete: str) -> list[str]:
    """Return materials of the built-in library."""
    from multilayer.materials import load_library

    return [name for name in load_library() if name.startswith(incomplete)]


def examples(incomplete: str) -> list[str]:
    """Complete the names of examples."""
    from multilayer.examples import WHAT

    return among(*WHAT)(incomplete)


def kinds(incomplete: str) -> list[str]:
    """Complete the kinds of files."""
    from multilayer.kinds import KINDS

    return among(*KINDS)(incomplete)


effects = _of_group("multilayer.effects")
laws = _of_group("multilayer.modulus_laws")
layers = _of_group("multilayer.layers")
methods = _of_group("multilayer.methods")
models = among("plane_wave", "finite")
posteriors = among("laplace", "profile", "nested")
laterals = among("bonded", "slender", "held")
quantities = among(
    "absorption", "transmission_loss", "insertion_loss", "normalised_impedance", "reflection", "transmission",
    "radiation_efficiency", "input_mobility", "bending_stiffness", "loss_factor", "phase_speed",
    "duct_attenuation", "sound_power_level", "impact_level",
)  # fmt: skip
exports = among(
    "surface_impedance", "surface_admittance", "admittance_matrix", "impedance_matrix", "transfer_matrix", "absorption",
    "transmission_loss", "sea_trim", "nastran",
)  # fmt: skip
faces = among("fluid", "plate")
frame_densities = among("solid", "bulk")

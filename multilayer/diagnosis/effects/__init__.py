"""Unmodelled effects, one per file; registered under the entry points ``multilayer.effects``."""

from multilayer.diagnosis.effects.base import EFFECTS, Chain, Effect, Setting

__all__ = ["EFFECTS", "Chain", "Effect", "Setting"]

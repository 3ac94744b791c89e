"""Places where something unmodelled may act; registered under the entry points ``multilayer.places``."""

from multilayer.diagnosis.places.base import PLACES, Place

__all__ = ["PLACES", "Place"]

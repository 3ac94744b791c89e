"""Places where something unmodelled may act; registered under the entry points ``multilayer.places``."""

from multilayer.diagnosis.places.base import PLACES, TUBE_PLACES, BasePlace, Place, TubePlace, places_of

__all__ = ["PLACES", "TUBE_PLACES", "BasePlace", "Place", "TubePlace", "places_of"]

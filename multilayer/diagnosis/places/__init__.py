"""Places where something unmodelled may act; registered under the entry points ``multilayer.places``."""

from multilayer.diagnosis.places.base import (
    LEVEL_PLACES,
    PLACES,
    TUBE_PLACES,
    BasePlace,
    LevelPlace,
    Place,
    TubePlace,
    places_of,
)

__all__ = ["LEVEL_PLACES", "PLACES", "TUBE_PLACES", "BasePlace", "LevelPlace", "Place", "TubePlace", "places_of"]

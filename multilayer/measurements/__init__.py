"""Campaigns and recordings as they come from the laboratory; one reader per file format."""

from multilayer.measurements.campaign import load_calibration, load_campaign, load_recordings, read_burst
from multilayer.signals.recording import Recording

__all__ = ["Recording", "load_calibration", "load_campaign", "load_recordings", "read_burst"]

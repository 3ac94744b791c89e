"""Where readers of earlier plugins import `Waveforms` from; it is `multilayer.signals.recording`."""

from multilayer.signals.recording import Reader, Recording, Waveforms

__all__ = ["Reader", "Recording", "Waveforms"]

"""Where readers of earlier plugins import `Channels` from; it is `multilayer.signals.channels`."""

from multilayer.signals.channels import Channel, Channels

__all__ = ["Channel", "Channels"]

"""Lets the tests run before the package is installed, too."""

from multilayer_campaigns.anisotropy_command import anisotropy
from multilayer_campaigns.preload_command import preload

from multilayer.plugins.commands import COMMANDS

for command in (preload, anisotropy):
    if command.__name__ not in COMMANDS:
        COMMANDS.register(command.__name__, command)

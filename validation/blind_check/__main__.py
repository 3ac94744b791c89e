"""``python -m validation.blind_check``: the same as ``multilayer blind-check``, installed or not."""

import sys

from multilayer.cli import main
from multilayer.plugins.commands import COMMANDS
from validation.blind_check.command import blind_check

if "blind-check" not in COMMANDS:
    COMMANDS.register("blind-check", blind_check)
sys.argv[1:1] = ["blind-check"]
main()

"""``python -m multilayer``."""

from multilayer.cli import main

main()

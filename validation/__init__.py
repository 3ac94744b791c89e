"""Studies that hold the package against truth, measurements and other programs; see ``README.md``."""

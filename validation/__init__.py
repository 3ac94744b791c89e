"""Studies that hold the package against truth, measurements and other programs; see ``README.md``."""

from multilayer.threads import one_thread

one_thread()  # before NumPy is imported

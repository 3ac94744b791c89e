"""Search of designs: what of a stack may vary, what is wanted of it, and within which limits."""

from multilayer.optimisation.file import OptimisationFile, load_optimisation
from multilayer.optimisation.result import Design, OptimisationResult
from multilayer.optimisation.run import optimise

__all__ = ["Design", "OptimisationFile", "OptimisationResult", "load_optimisation", "optimise"]

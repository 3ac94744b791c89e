"""From a simulation file to its results: sweeps and tolerances, on this machine or on a cluster."""

from multilayer.simulation.file import SimulationFile, load_simulation
from multilayer.simulation.result import CaseResult, SimulationResult
from multilayer.simulation.run import simulate

__all__ = ["CaseResult", "SimulationFile", "SimulationResult", "load_simulation", "simulate"]

"""Inference without acoustics: unknowns with priors, residuals, minima, and what the data leave of the unknowns."""

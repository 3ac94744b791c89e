"""Every threshold of the decision, in one place; frozen before a final blind check.

Development runs (seeds below 1000 of ``multilayer blind-check``) may change them, final ones may not.
"""

from __future__ import annotations

GLOBAL_P = 0.01  # a misfit less probable than this is a gap
CERTAIN_P = 1e-6  # a misfit less probable than this is a gap, even where no hypothesis has more evidence
LEAST_EVIDENCE = 5.0  # nats above the nominal model that a cause needs
SECOND_EVIDENCE = 8.0  # nats that a second effect must add to the first
TIED = 3.0  # nats within which hypotheses are one group
ABSORBED = 0.1  # share of a signature that the unknowns leave: below, it cannot be seen
ALIKE = 0.95  # cosine above which two signatures are one
LEAST_SHRINKAGE = 0.5  # of the gap on data not used in the fit
FIT_P = 0.001  # the best effect's own misfit, the tolerance below being allowed
TOLERANCE = 0.005  # relative size of a smooth discrepancy that every hypothesis may keep: the solvers' own errors
MODEL_ERROR = 0.003  # relative standard deviation of the solvers' error in the data's covariance
TEMPERATURE = 6.0  # nats of evidence per nat of stated probability: from development runs
DETECTED = 5.0  # standard deviations of an effect that would be seen
CANDIDATES = 5  # effects that are tried in pairs

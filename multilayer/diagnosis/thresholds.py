"""Every threshold of the decision, in one place; frozen before a final blind check.

Development runs (seeds below 1000 of ``multilayer blind-check``) may change them, final ones may not.
"""

from __future__ import annotations

CERTAIN_P = 1e-6  # a misfit less probable than this is a gap, even where no hypothesis is ahead of the nominal model
LEAST_SCORE = 3.0  # nats, priors included, by which a cause must be ahead of the nominal model
LEAST_SIZE = 0.0015  # rms change of the data, relative, below which an effect is no gap: solvers differ by as much
SECOND_EVIDENCE = 5.0  # nats that a second effect must add to the first
TIED = 3.0  # nats within which hypotheses are one group
ABSORBED = 0.1  # share of a signature that the unknowns leave: below, it cannot be seen
ALIKE = 0.95  # cosine above which two signatures are one
LEAST_SHRINKAGE = 0.5  # of the gap on data not used in the fit
FIT_P = 0.001  # the best effect's own misfit, the tolerance below being allowed
TOLERANCE = 0.005  # relative size of a smooth discrepancy that every hypothesis may keep: the solvers' own errors
MODEL_ERROR = 0.003  # relative standard deviation of the solvers' error in the data's covariance
TEMPERATURE = 6.0  # nats of evidence per nat of stated probability: from development runs
DETECTED = 5.0  # standard deviations of an effect that would be seen
N_FIRST, N_SECOND = 3, 3  # effects that are tried in pairs, and how many partners each gets
# how common each kind of cause is, all of its members together
PRIOR_NONE, PRIOR_ONE, PRIOR_TWO, PRIOR_UNKNOWN = 0.25, 0.35, 0.10, 0.30
RIGHT_NO_GAP, RIGHT_GUARDED = 0.95, 0.8  # how often such verdicts were right on development runs

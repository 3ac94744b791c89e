"""Arrays only: state families, couplings, face matrices, and the solution of the global system.

Matrices are stored *entry first*: ``A[i, j]`` is an array over frequency, angle and samples (any broadcast shape), so
that every operation on an entry runs over contiguous memory.
"""

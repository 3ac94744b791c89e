"""How many threads linear algebra uses; to be set before NumPy is imported."""

from __future__ import annotations

import os

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Make linear algebra use one thread unless the environment says otherwise.

    The matrices are small: more threads gain nothing, and on a busy machine they wait for each other many times longer
    than they compute.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")


__all__ = ["THREADS", "one_thread"]

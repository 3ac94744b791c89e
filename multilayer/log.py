"""The steps of long work, logged under the name ``multilayer``, as Python's `logging` has it: silent until asked for.

``logging.basicConfig(level=logging.INFO)`` shows them.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from multilayer.doors import for_log

LOGGER = logging.getLogger("multilayer")
LOGGER.addHandler(logging.NullHandler())


def logged(progress: Callable[[str], None] | None) -> Callable[[str], None]:
    """Return a function that logs a step, and tells it to `progress`."""

    def tell(step: str) -> None:
        LOGGER.info("%s", for_log(step))
        if progress is not None:
            progress(step)

    return tell

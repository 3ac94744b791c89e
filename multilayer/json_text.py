"""Results as standard JSON, which has no infinite numbers and no NaN."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def json_text(data: Any) -> str:
    """Return plain data as the text of a JSON file: null where a number is not finite.

    Parameters
    ----------
    data : mapping, sequence, str, number, bool or None
        NumPy's scalars are numbers here.
    """
    return json.dumps(_plain(data), indent=1, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value

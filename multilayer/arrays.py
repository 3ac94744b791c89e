"""Names for the array types that signatures use."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

RealArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]
BoolArray: TypeAlias = NDArray[np.bool_]
IndexArray: TypeAlias = NDArray[np.intp]
Numeric: TypeAlias = float | complex | NDArray[Any]

__all__ = ["ArrayLike", "BoolArray", "ComplexArray", "IndexArray", "Numeric", "RealArray"]

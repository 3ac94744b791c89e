"""What a file of spectra holds: values over frequency, real or complex, with names and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.tables import Header, Table


@dataclass(frozen=True, eq=False)
class Spectra:
    """Values over frequency, as readers of files give them.

    Attributes
    ----------
    frequency : array, shape (n,)
        Hz, in any order; values at 0 Hz, as a Fourier transform has them, are left out of the table.
    values : mapping of arrays, shape (n,)
        By name, real or complex. Names are those of columns of text tables; complex values make two columns,
        ``NAME_re`` and ``NAME_im``.
    units : mapping of str
        By name, where the file states a unit.
    """

    frequency: RealArray
    values: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)

    def table(self, file: Path) -> Table:
        """Return the values as columns.

        Parameters
        ----------
        file : Path
            Where they come from, for messages.

        Raises
        ------
        InputError
            When something has not as many values as there are frequencies, or all of these are 0 Hz.
        """
        frequency = np.asarray(self.frequency, dtype=float)
        headers, columns = [Header("frequency", "frequency", "Hz")], [frequency]
        for name, values in self.values.items():
            array = np.asarray(values)
            if array.shape != frequency.shape or array.ndim != 1:
                shapes = f"'{name}' has the shape {array.shape}, and the frequencies {frequency.shape}"
                raise InputError(Problem(f"{shapes}; both must be of one axis, and alike", file=file))
            header = Header.of(name)
            unit = self.units.get(name, header.unit)
            parts = {"_re": array.real, "_im": array.imag} if np.iscomplexobj(array) else {"": array}
            headers += [Header(name + suffix, header.name + suffix, unit) for suffix in parts]
            columns += [part.astype(float) for part in parts.values()]
        kept = np.flatnonzero(frequency)
        if frequency.size and not kept.size:
            raise InputError(Problem("all frequencies are 0 Hz: it is damaged; export it again", file=file))
        rows = zip(*(column[kept].tolist() for column in columns), strict=True)
        return Table(file, tuple(headers), tuple((None, row) for row in rows))

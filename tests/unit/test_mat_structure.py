"""Damaged MATLAB files, some of which crash SciPy's reader: refused before it, and sound ones are not."""

import numpy as np
import pytest
from scipy import sparse
from scipy.io import loadmat, savemat

from multilayer.measurements.mat_structure import refuse_unsound

MATRIX = sparse.csc_matrix(np.array([[0.0, 2.0, 0.0], [1.0, 0.0, 0.0]]))


def saved(tmp_path, **arrays):
    file = tmp_path / "x.mat"
    savemat(file, arrays)
    return file


@pytest.mark.parametrize("matrix", [MATRIX, MATRIX * (1 + 2j), sparse.csc_matrix((3, 4)), sparse.eye(5, format="csc")])
@pytest.mark.parametrize("packed", [False, True])
def test_sparse_matrices(matrix, packed, tmp_path):
    savemat(tmp_path / "x.mat", {"a": matrix, "b": np.eye(2)}, do_compression=packed)
    refuse_unsound(tmp_path / "x.mat")


@pytest.mark.parametrize("kind", [*range(1, 18), 255])
def test_another_class(kind, tmp_path):
    """A text that says it is something else is refused, or SciPy reads it; a crash would end the tests."""
    file = saved(tmp_path, a="m/s^2")
    content = bytearray(file.read_bytes())
    content[128 + 16] = kind  # of the flags of the first array
    file.write_bytes(content)
    try:
        refuse_unsound(file)
    except ValueError:
        return
    loadmat(file)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"rows": [7, 0]}, "has numbers elsewhere"),
        ({"rows": [-1, 0]}, "has numbers elsewhere"),
        ({"begins": [0, 1, 9, 9]}, "do not fit"),
        ({"begins": [0, 2, 1, 2]}, "do not fit"),
        ({"begins": [1, 1, 2, 2]}, "do not fit"),
    ],
)
def test_sparse_matrices_that_do_not_fit(change, told, tmp_path):
    file = saved(tmp_path, a=MATRIX)
    content = file.read_bytes()
    parts = {"rows": MATRIX.indices, "begins": MATRIX.indptr}
    for name, wrong in change.items():
        old = np.asarray(parts[name], dtype="<i4").tobytes()
        assert content.count(old) == 1
        content = content.replace(old, np.array(wrong, dtype="<i4").tobytes())
    file.write_bytes(content)
    with pytest.raises(ValueError, match=told):
        refuse_unsound(file)

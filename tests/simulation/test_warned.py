"""Warnings of validity, collected by thread."""

import warnings
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest

from multilayer.errors import ValidityWarning
from multilayer.simulation.warned import collected_warnings


def test_each_thread_has_its_own():
    together = Barrier(4, timeout=10)

    def work(number):
        with collected_warnings() as texts:
            together.wait()  # all are inside
            for _ in range(number):
                warnings.warn(f"of {number}", ValidityWarning, stacklevel=1)
            together.wait()
        return texts

    before = (list(warnings.filters), warnings.showwarning)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(work, range(4))) == [[f"of {n}"] * n for n in range(4)]
    assert (list(warnings.filters), warnings.showwarning) == before


def test_other_warnings_pass():
    with pytest.warns(UserWarning, match="of another kind"), collected_warnings() as texts:
        warnings.warn("of another kind", UserWarning, stacklevel=1)
    assert texts == []


def test_after_a_mistake_nothing_is_collected():
    with pytest.raises(ZeroDivisionError), collected_warnings():
        raise ZeroDivisionError
    with pytest.warns(ValidityWarning, match="again"):
        warnings.warn("again", ValidityWarning, stacklevel=1)


def test_one_inside_another():
    with collected_warnings() as outer:
        with collected_warnings() as inner:
            warnings.warn("inside", ValidityWarning, stacklevel=1)
        warnings.warn("after", ValidityWarning, stacklevel=1)
    assert (outer, inner) == (["after"], ["inside"])

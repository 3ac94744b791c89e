import os

import pytest

from multilayer import shared_results
from multilayer.executors import local_pool, run_all
from multilayer.shared_results import shared, sharing


@shared
def computed_in(label):
    """The process that computes it."""
    return label, os.getpid()


def ask(label):
    return computed_in(label), os.getpid()


def test_a_process_reads_what_another_has_computed():
    with local_pool(2) as pool:
        here = computed_in("a")
        found = run_all(ask, ["a"] * 20, pool)
        assert {result for result, _ in found} == {here}
        assert os.getpid() not in {worker for _, worker in found}


def test_other_arguments_are_other_results():
    with sharing():
        assert computed_in(1) != computed_in(1.5)
        assert [computed_in(x)[0] for x in (0.1, 0.1 + 1e-16, 0.1)] == [0.1, 0.1 + 1e-16, 0.1]


def test_nothing_is_left_behind():
    with sharing() as folder:
        computed_in("a")
        assert len([*folder.iterdir()]) == 1
        assert folder.stat().st_mode & 0o077 == 0
    assert not folder.exists()
    assert shared_results._folder is None


def test_without_a_pool_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert computed_in("a") == ("a", os.getpid())
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("content", [b"", b"nonsense"])
def test_what_cannot_be_read_is_computed(content):
    with sharing() as folder:
        computed_in("a")
        (path,) = folder.iterdir()
        path.write_bytes(content)
        assert computed_in("a") == ("a", os.getpid())
        path.unlink()
        path.mkdir()
        assert computed_in("a") == ("a", os.getpid())


def test_a_full_disk_costs_time_only(monkeypatch):
    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    with sharing() as folder:
        monkeypatch.setattr(shared_results, "NamedTemporaryFile", full)
        assert computed_in("a") == ("a", os.getpid())
        assert not [*folder.iterdir()]
    monkeypatch.setattr(shared_results, "mkdtemp", full)
    with local_pool(2) as pool:
        assert run_all(ask, ["a"], pool)[0][0][0] == "a"


def test_a_process_writes_so_much_and_no_more(monkeypatch):
    monkeypatch.setattr(shared_results, "_MOST", 100)
    with sharing() as folder:
        for label in range(50):
            computed_in(label)
        assert 0 < sum(path.stat().st_size for path in folder.iterdir()) <= 100

"""Reference data that are absent are told: by a skipped test, in CI by one that fails."""

import pytest

from tests.conftest import reference_data


def test_a_folder_that_is_there(tmp_path):
    assert reference_data(tmp_path, in_ci=True) == tmp_path


def test_without_it_a_test_is_skipped(tmp_path):
    with pytest.raises(pytest.skip.Exception, match="not here"):
        reference_data(tmp_path / "absent", in_ci=False)


def test_without_it_ci_fails(tmp_path):
    with pytest.raises(pytest.fail.Exception, match="CI must have"):
        reference_data(tmp_path / "absent", in_ci=True)

"""What the tests of simulations share."""

import pytest


@pytest.fixture
def written(tmp_path):
    """Give a function that writes a file and returns its path."""

    def write(text, name="file.yaml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write

"""What several folders of tests need."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from multilayer.threads import one_thread

one_thread()

# a red run must mean a change, not a draw: CI tries the same examples every time, developers new ones
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of reference data and campaigns beside the repository; the test is skipped without it."""
    folder = Path(__file__).parents[2] / "shared"
    if not folder.is_dir():
        pytest.skip("the folder ../shared is not here")
    return folder

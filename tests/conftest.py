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
    """Return the folder of reference data and campaigns beside the repository.

    Without it a test is skipped; in CI it fails, for nobody looks at what a green run has skipped.
    """
    return reference_data(Path(__file__).parents[2] / "shared", in_ci=os.environ.get("CI") == "true")


def reference_data(folder: Path, *, in_ci: bool) -> Path:
    """Return a folder of reference data if it is there; else end the test."""
    if not folder.is_dir():
        if in_ci:
            pytest.fail("the folder ../shared is not here: CI must have the reference data beside the repository")
        pytest.skip("the folder ../shared is not here")
    return folder

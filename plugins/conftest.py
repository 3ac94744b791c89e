"""Leaves the tests of packages out that are not installed: ``make test`` installs all of them."""

from importlib.util import find_spec
from pathlib import Path

_ABSENT = [
    folder.name for folder in Path(__file__).parent.iterdir()
    if (folder / "pyproject.toml").is_file() and find_spec(folder.name.replace("-", "_")) is None
]  # fmt: skip
collect_ignore = _ABSENT


def pytest_report_header() -> str:
    """Say which packages are not tested."""
    return f"plugins that are not installed, and not tested: {', '.join(_ABSENT)}" if _ABSENT else ""

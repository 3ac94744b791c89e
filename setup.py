"""The build, beyond what pyproject.toml says: examples become part of the installed package."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

EXAMPLES = Path(__file__).parent / "examples"


class BuildWithExamples(build_py):
    """Copies the folder ``examples`` to ``multilayer/_examples``; an editable installation reads it where it is."""

    def run(self) -> None:
        """Build."""
        super().run()
        if not self.editable_mode:
            shutil.copytree(
                EXAMPLES,
                Path(self.build_lib) / "multilayer" / "_examples",
                dirs_exist_ok=True,
                ignore=shutil.ignore_patterns("__pycache__", "results"),
            )


setup(cmdclass={"build_py": BuildWithExamples})

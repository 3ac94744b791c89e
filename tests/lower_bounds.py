"""Print the lower bound of every core dependency as a constraint of pip: ``numpy>=1.26`` as ``numpy==1.26``."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]

for dependency in PROJECT["dependencies"]:
    name, bound = dependency.split(">=")
    print(f"{name}=={bound}")  # noqa: T201

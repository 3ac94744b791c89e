"""The main commands where only the core dependencies are installed: ``make core``.

Runs without pytest, in an environment of its own, away from the project's tree. It fails when a command does, when an
optional package is there after all, or when what needs one does not say how to install it.
"""

import subprocess
import sys
import tempfile
from importlib.metadata import distributions, requires
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
TUBE, WALL = EXAMPLES / "foam_tube", EXAMPLES / "double_wall.yaml"
COMMANDS = {
    "fit": [EXAMPLES / "foam_b", "--out", "fit"],
    "simulate": [EXAMPLES / "foam_absorption.yaml", "--out", "simulation"],
    "optimise": [EXAMPLES / "best_absorber.yaml", "--out", "best"],
    "diagnose": [TUBE, "--out", "diagnosis"],
    "compare": [TUBE / "truth.yaml", TUBE / "tube.csv", "--out", "comparison"],
    "tube": [EXAMPLES / "raw_tube", "--out", "tube"],
    "export": [EXAMPLES / "three_layers.yaml", "--as", "transfer_matrix", "--out", "transfer.mat"],
    "check": [EXAMPLES / "foam_b", TUBE, WALL],
    "layers": [],
    "effects": [],
    "schema": ["stack"],
    "plugins": [],
}
# what needs an extra, and which
REFUSED = {
    "bayes": ["fit", TUBE, "--posterior", "nested", "--out", "nested"],
    "cluster": ["simulate", WALL, "--cluster", "tcp://127.0.0.1:1", "--out", "cluster"],
    "formats": ["import", "recording.tdms", "--out", "imported"],
}
# what is in another package of this repository, and in which folder
ELSEWHERE = {"preload": "plugins/multilayer-campaigns", "blind-check": "validation"}
WRITTEN = ("fit/report.html", "fit/moduli.png", "simulation/report.html", "diagnosis/report.html", "tube/tube.csv")


def main() -> None:
    """Run all of them in a temporary folder."""
    told = requires("multilayer") or []
    core = {name(text) for text in told if "extra ==" not in text}
    optional = {name(text) for text in told} - core
    there = optional & {name(found.metadata["Name"]) for found in distributions()}
    expect(not there, f"optional packages are installed: {', '.join(sorted(there))}")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "recording.tdms").write_bytes(b"TDSm")
        for command, arguments in COMMANDS.items():
            done = multilayer(command, *arguments, cwd=folder)
            expect(done.returncode == 0 and not done.stderr, f"multilayer {command}: {done.returncode}\n{done.stderr}")
        missing = [path for path in WRITTEN if not (Path(folder) / path).is_file()]
        expect(not missing, f"not written: {', '.join(missing)}")
        for extra, arguments in REFUSED.items():
            done = multilayer(*arguments, cwd=folder)
            helpful = done.returncode == 2 and f"pip install 'multilayer[{extra}]'" in " ".join(done.stderr.split())
            expect(helpful, f"multilayer {arguments[0]} without [{extra}]: {done.returncode}\n{done.stderr}")
        for command, place in ELSEWHERE.items():
            done = multilayer(command, "--help", cwd=folder)
            helpful = done.returncode == 2 and f"pip install ./{place}" in done.stderr
            expect(helpful, f"multilayer {command} where it is not installed: {done.returncode}\n{done.stderr}")
    print(f"{len(COMMANDS)} commands run without extras, {len(REFUSED)} name the extra they need")  # noqa: T201


def name(requirement: str) -> str:
    """Return the package of a requirement, as ``npTDMS>=1.9; extra == 'formats'``, in lower case."""
    return requirement.split(";", maxsplit=1)[0].split(">=", maxsplit=1)[0].strip().lower()


def multilayer(*arguments: object, cwd: str) -> subprocess.CompletedProcess[str]:
    """Run the command that is installed beside this Python."""
    command = [Path(sys.executable).with_name("multilayer"), *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


def expect(holds: bool, message: str) -> None:
    """End with the message unless it holds."""
    if not holds:
        sys.exit(message)


if __name__ == "__main__":
    main()

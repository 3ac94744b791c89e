"""What the pages show of a terminal is what the commands answer."""

from pathlib import Path

import pytest

from tests.cli.command import run
from tests.docs.consoles import commands, files, missing
from tests.docs.spoiled import make_all

ROOT = Path(__file__).parents[2]
PAGES = [
    "../README.md", "messages.md", "plugins.md", "tour.md", "tasks/export.md", "tasks/fit.md", "tasks/simulate.md",
    "tasks/optimise.md",
]  # fmt: skip
# a minute, and seven seconds: tests/cli/test_diagnose.py and the gallery's test_number[joint_law] run the like
SLOW = ("diagnose examples/foam_b --out", "fit examples/foam_b --joint")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the examples, and every campaign that the page of messages speaks of."""
    made = tmp_path_factory.mktemp("pages")
    (made / "examples").symlink_to(ROOT / "examples")
    make_all(made)
    return made


@pytest.mark.parametrize("name", PAGES)
def test_page(name, folder):
    page = ROOT / "docs" / name
    for file, text in files(page).items():
        (folder / file).write_text(text)
    shown = commands(page)
    assert shown
    wrong = []
    for command in shown:
        if not " ".join(command.arguments).startswith(SLOW):
            done = run(*command.arguments, cwd=folder)
            wrong += [(command.arguments, line) for line in missing(command, done.out + done.err)]
    assert not wrong


def test_a_changed_line_is_noticed(folder):
    """The comparison itself can fail."""
    (command,) = [one for one in commands(ROOT / "docs" / "messages.md") if one.arguments == ("fit", "heavy")]
    answer = run(*command.arguments, cwd=folder).err
    assert missing(command, answer) == []
    assert missing(command, answer.replace("87 kg", "88 kg")) == list(command.shown)

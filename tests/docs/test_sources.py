"""The sources of the manual are sound: every page is reached, every link leads somewhere, every number has a page."""

import re
from importlib import import_module
from pathlib import Path

import pytest

import multilayer

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
MADE = ("_build", "gallery")  # by Sphinx
PAGES = sorted(
    path for path in DOCS.rglob("*") if path.suffix in (".md", ".rst") and path.relative_to(DOCS).parts[0] not in MADE
)
TOCTREE = re.compile(r"(?:```\{toctree\}|\.\. toctree::)\n(.*?)(?:```|\Z)", re.DOTALL)
LINK = re.compile(r"\[[^\]\n]*\]\(([^)\s]+)\)")
ROLE = re.compile(r":doc:`([^`]+)`")


def entries(page):
    """Return the pages that a page's tables of contents name."""
    found = set()
    for block in TOCTREE.findall(page.read_text()):
        for line in block.splitlines():
            entry = line.strip()
            if entry and not entry.startswith(":"):
                found |= {path for suffix in (".md", ".rst") for path in page.parent.glob(entry + suffix)}
    return found


def test_every_page_is_in_a_table_of_contents():
    reached, ahead = set(), {DOCS / "index.md"}
    while ahead:
        page = ahead.pop()
        reached.add(page)
        ahead |= (entries(page) & set(PAGES)) - reached
    assert [str(page.relative_to(DOCS)) for page in PAGES if page not in reached] == []


def targets(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    found = (LINK if page.suffix == ".md" else ROLE).findall(text)
    return [target for target in found if "://" not in target]


def anchors(page):
    """Return the anchors of a page's headings, as GitHub and MyST make them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def is_there(page, target):
    place, _, anchor = target.partition("#")
    if place.startswith("../gallery/") or place == "gallery/index":  # made of the scripts
        name = place.rpartition("/")[2]
        return name == "index" or (ROOT / "examples" / "gallery" / f"{name}.py").is_file()
    path = (page.parent / place).resolve() if place else page
    found = next((one for one in (path, Path(f"{path}.md"), Path(f"{path}.rst")) if one.is_file()), None)
    return found is not None and (not anchor or anchor in anchors(found))


@pytest.mark.parametrize(
    "page", [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda page: str(page.relative_to(ROOT))
)
def test_links_lead_somewhere(page):
    assert [target for target in targets(page) if not is_there(page, target)] == []


def test_a_wrong_link_is_noticed():
    assert not is_there(DOCS / "index.md", "nowhere.md")
    assert not is_there(DOCS / "index.md", "tour.md#nothing")
    assert is_there(DOCS / "index.md", "tour.md#diagnose")


def overview():
    """Return page, deviation and command of each row of the booklet's table."""
    rows = [line.split(" | ") for line in (DOCS / "validation" / "index.md").read_text().splitlines() if "](" in line]
    return [(LINK.search(row[3])[1], row[2], row[4]) for row in rows if len(row) == 5]


@pytest.mark.parametrize(("name", "deviation", "command"), overview())
def test_numbers_of_the_booklet_stand_on_their_pages(name, deviation, command):
    text = (DOCS / "validation" / name).read_text()
    conditions = re.sub(r"ν = [\d.]+( and \d+ Hz)?", "", deviation)
    numbers = re.findall(r"\d[\d.]*(?:e[-+]?\d+)?", conditions)
    assert numbers or "`" in deviation
    assert [number for number in numbers if not re.search(rf"(?<![\d.]){re.escape(number)}(?!\d)", text)] == []
    assert command.strip("| `").removesuffix("`") in text


def test_every_validation_page_is_in_the_booklet():
    pages = {path.name for path in (DOCS / "validation").glob("*.md")} - {"index.md"}
    assert pages == {name for name, _, _ in overview()} | {"inverse_speed.md", "sizes.md"}


def documented():
    """Return the names that the pages of the Python interface list, with their modules."""
    found = []
    for page in (DOCS / "api").glob("*.rst"):
        for module, names in re.findall(r"automodule:: (\S+)\n +:members: (.*)", page.read_text()):
            found += [(module, name) for name in names.split(", ")]
    return found


def test_documented_names_exist():
    missing = [f"{module}.{name}" for module, name in documented() if not hasattr(import_module(module), name)]
    assert missing == []


def test_public_names_are_documented():
    listed = {id(getattr(import_module(module), name)) for module, name in documented()}
    assert [name for name in multilayer.__all__ if id(getattr(multilayer, name)) not in listed] == []
    subpackages = [f"multilayer.{name}" for name in ("response", "simulation", "measurements", "rig", "testing")]
    for package in subpackages:
        module = import_module(package)
        assert [name for name in module.__all__ if id(getattr(module, name)) not in listed] == [], package

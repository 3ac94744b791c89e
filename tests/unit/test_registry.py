"""Registries: things of installed packages and things registered by hand, named with their owners."""

import sys

import pytest

from multilayer.errors import PluginWarning, suggest
from multilayer.registry import Registry, RegistryError, subclass_fault

GROUP = "multilayer.test_things"


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return a function that puts a package on the path: metadata, entry points and modules."""

    def make(name, entries, **modules):
        root = tmp_path / name
        info = root / f"{name.replace('-', '_')}-1.2.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n")
        lines = [f"{key} = {value}" for key, value in entries.items()]
        (info / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))
        for module, source in modules.items():
            (root / f"{module}.py").write_text(source)
            monkeypatch.delitem(sys.modules, module, raising=False)
        monkeypatch.syspath_prepend(str(root))

    return make


@pytest.fixture
def things():
    return Registry(GROUP, "thing")


def test_an_installed_thing_is_found_by_name(install, things):
    install("good", {"foam": "good_things:Foam"}, good_things="class Foam: pass\n")
    assert things.names() == ["foam"]
    assert list(things) == ["foam"]
    assert "foam" in things
    assert things["foam"].__name__ == "Foam"
    assert things.origins("foam") == ["good_things:Foam (package good 1.2)"]


def test_nothing_is_imported_before_it_is_asked_for(install, things):
    install("lazy", {"foam": "lazy_things:Foam"}, lazy_things="class Foam: pass\n")
    assert "foam" in things.names()
    assert "lazy_things" not in sys.modules
    assert things["foam"]
    assert "lazy_things" in sys.modules


def test_a_name_of_two_packages_names_both_and_spoils_only_itself(install, things):
    install(
        "one",
        {"foam": "one_things:Foam", "felt": "one_things:Felt"},
        one_things="class Foam: ...\nclass Felt: ...\n",
    )
    install("two", {"foam": "two_things:Foam"}, two_things="class Foam: ...\n")
    with pytest.raises(RegistryError, match="thing 'foam' is defined twice") as caught:
        things["foam"]
    assert "one_things:Foam (package one 1.2)" in str(caught.value)
    assert "two_things:Foam (package two 1.2)" in str(caught.value)
    assert things["felt"].__name__ == "Felt"


def test_the_same_entry_listed_twice_is_one(install, things):
    install("editable", {"foam": "same_things:Foam"}, same_things="class Foam: ...\n")
    install("editable-copy", {"foam": "same_things:Foam"})
    assert things["foam"].__name__ == "Foam"


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("raise RuntimeError('no licence')\n", "RuntimeError: no licence"),
        ("import no_such_module_here\n", "ModuleNotFoundError"),
        ("class Other: ...\n", "AttributeError"),
        ("class Foam\n", "SyntaxError"),
    ],
)
def test_a_broken_plugin_is_named_with_its_origin_and_stops_nothing_else(install, things, source, words):
    install("broken", {"foam": "broken_things:Foam"}, broken_things=source)
    install("good", {"felt": "fine_things:Felt"}, fine_things="class Felt: ...\n")
    with pytest.raises(RegistryError, match=words) as caught:
        things["foam"]
    assert "thing 'foam' of broken_things:Foam (package broken 1.2) does not load" in str(caught.value)
    assert caught.value.__cause__ is not None
    assert things.names() == ["felt", "foam"]
    assert things["felt"].__name__ == "Felt"


def test_an_unknown_name_comes_with_the_nearest_one(things):
    things.register("foam", object())
    with pytest.raises(RegistryError, match=r"no thing is called 'foma'; did you mean 'foam'\?"):
        things["foma"]
    with pytest.raises(RegistryError, match=r"allowed: foam$"):
        things["brick"]


def test_a_taken_name_cannot_be_registered_again(install, things):
    install("owner", {"foam": "owner_things:Foam"})
    with pytest.raises(RegistryError, match=r"owner_things:Foam \(package owner 1\.2\) and by my script"):
        things.register("foam", object(), origin="my script")
    things.register("felt", object(), origin="first script")
    with pytest.raises(RegistryError, match="first script and by second script"):
        things.register("felt", object(), origin="second script")


def test_what_is_registered_can_be_removed(things):
    item = object()
    assert things.register("foam", item) is item
    assert things["foam"] is item
    things.unregister("foam")
    things.unregister("foam")
    assert "foam" not in things
    assert things.origins("foam") == []


@pytest.mark.parametrize("name", [["foam"], {"foam": 1}, None, 5])
def test_what_is_no_name_is_in_no_registry(things, name):
    assert name not in things


def test_a_registered_class_tells_where_it_was_defined(things):
    things.register("registry", Registry)
    assert things.origins("registry") == ["multilayer.registry:Registry"]


def test_suggestions():
    assert suggest("thicknes", ["thickness", "porosity"]) == "did you mean 'thickness'?"
    assert suggest("x", ["b", "a"]) == "allowed: a, b"
    assert suggest("x", []) == "allowed: none"


def test_going_through_all_leaves_the_broken_out_with_a_warning(install, things):
    install("broken", {"foam": "worse_things:Foam"}, worse_things="raise SystemExit(1)\n")
    install("good", {"felt": "better_things:Felt"}, better_things="class Felt: ...\n")
    with pytest.warns(PluginWarning, match="left out: thing 'foam' of worse_things:Foam") as told:
        found = dict(things.working())
    assert (list(found), len(told)) == (["felt"], 1)


def test_what_failed_is_not_imported_again(install, things, tmp_path):
    source = f"with open({str(tmp_path / 'log')!r}, 'a') as f:\n    f.write('x')\nraise RuntimeError('no')\n"
    install("slow", {"foam": "slow_things:Foam"}, slow_things=source)
    for _ in range(3):
        with pytest.raises(RegistryError, match="RuntimeError: no"):
            things["foam"]
    assert (tmp_path / "log").read_text() == "x"


class Named:
    title = "foam"


@pytest.mark.parametrize(
    ("name", "item", "words"),
    [
        ("foam", 5, "it is 5, not a subclass of"),
        ("foam", Named(), "not a subclass of"),
        ("felt", Named, "its 'title' is 'foam'; it must be 'felt', the name it is found under"),
    ],
)
def test_objects_of_the_wrong_kind(name, item, words):
    strict = Registry(GROUP, "thing", subclass_fault(Named, "title"))
    with pytest.raises(RegistryError, match=words):
        strict.register(name, item, origin="my script")
    assert name not in strict
    assert strict.register("foam", Named) is Named

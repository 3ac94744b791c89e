"""Plugins in single files, without an installation: ``--plugin FILE.py``.

Such a file may become the module of a package. Its classes and functions are registered under the names that they
state: layers (`type`), laws (`law`), effects, places and inverse methods (`name`), functions ``read_SUFFIX`` returning
`Waveforms`, `Channels` or `Spectra`, and functions ``command_NAME``.
"""

from __future__ import annotations

import re
import sys
import traceback
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from hashlib import sha256
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from multilayer.errors import InputError, Problem
from multilayer.executors import prepared
from multilayer.plugins.listing import KINDS, registry
from multilayer.registry import Registry, RegistryError
from multilayer.writing.manifest import note_input

_STATED_IN = {
    "layer": "type", "law": "law", "effect": "name", "method": "name", "rig effect": "effect", "place": "name",
    "place of a tube": "name", "place of a construction": "name",
}  # fmt: skip
_UNION = re.compile(r"(?:\w+\.)?Union\[(.*)\]")
_REGISTERS_NOTHING = (
    "registers nothing: it defines no layer with a 'type', no law with a 'law', no effect, place or method with a "
    "'name', no function read_SUFFIX returning Waveforms, Channels or Spectra, no function command_NAME; see "
    "docs/plugins.md, or begin with 'multilayer plugins new'"
)
_users: Counter[str] = Counter()  # of registered files: contexts, one inside another


@contextmanager
def plugin_files(files: Sequence[Path]) -> Iterator[None]:
    """Register the definitions of plugin files, in this process and in its workers, until the context ends.

    Raises
    ------
    InputError
        For a file that is missing, fails, registers nothing, or uses a name that is taken; none of it stays registered.
    """
    with ExitStack() as stack:
        for file in dict.fromkeys(path.resolve() for path in files):
            text = _text(file)
            register_source(str(file), text)
            _users[_module_name(str(file), text)] += 1
            stack.callback(_leave, str(file), text)
            stack.enter_context(prepared(register_source, str(file), text))
        yield


def _leave(file: str, text: str) -> None:
    """Forget a file that nobody uses any more."""
    name = _module_name(file, text)
    _users[name] -= 1
    if not _users[name]:
        del _users[name]
        _forget(file, text)


def _text(file: Path) -> str:
    if not file.is_file():
        raise _error(file, "there is no such file")
    if file.suffix != ".py":
        raise _error(file, "is no Python file; --plugin takes a file that ends in .py")
    note_input(file)
    try:
        return file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise _error(file, f"is no text that can be read ({error})") from None


def _error(file: Path | str, message: str, line: int | None = None) -> InputError:
    return InputError(Problem(message, file=Path(file), line=line))


def register_source(file: str, text: str) -> None:
    """Run the text of a plugin file and register its definitions, unless that has been done in this process already.

    Parameters
    ----------
    file : str
        Its path, for messages; the file itself may be on another machine.
    text : str

    Raises
    ------
    InputError
        When the text does not run, registers nothing, or uses a name that is taken.
    """
    name = _module_name(file, text)
    if name in sys.modules:
        return
    try:
        module = _run(name, file, text)
        defined = list(definitions(module))
        if not defined:
            raise _error(file, _REGISTERS_NOTHING)
        for registry_of_kind, key, item in defined:
            registry_of_kind.register(key, item, origin=file)
    except RegistryError as error:
        _forget(file, text)
        raise _error(file, str(error)) from None
    except InputError:
        _forget(file, text)
        raise


def _module_name(file: str, text: str) -> str:
    digest = sha256(f"{file}\n{text}".encode(errors="surrogatepass")).hexdigest()
    return f"multilayer_plugin_{digest[:12]}_{Path(file).stem}"


def _run(name: str, file: str, text: str) -> ModuleType:
    module = ModuleType(name)
    module.__file__ = file
    sys.modules[name] = module  # pickle and pydantic look their classes up there
    try:
        exec(compile(text, file, "exec", dont_inherit=True), module.__dict__)
    except (Exception, SystemExit) as error:
        raise _error(file, f"does not load: {type(error).__name__}: {error}", _line(error, file)) from error
    return module


def _line(error: BaseException, file: str) -> int | None:
    """Return the line of the file at which an exception arose, or from which it was called."""
    if isinstance(error, SyntaxError):
        return error.lineno
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    return lines[-1] if lines else None


def definitions(module: ModuleType) -> Iterator[tuple[Registry[Any], str, Any]]:
    """Give registry, name and object of every plugin that a module defines; those that it imports do not count."""
    classes: set[type] = set()
    for name, item in vars(module).copy().items():
        if getattr(item, "__module__", None) != module.__name__ or name.startswith("_"):
            continue
        if isinstance(item, FunctionType) and name.startswith("read_") and _reads(item):
            yield registry("reader"), name.removeprefix("read_"), item
        elif isinstance(item, FunctionType) and name.startswith("command_"):
            yield registry("command"), name.removeprefix("command_").replace("_", "-"), item
        elif isinstance(item, type) and item not in classes:  # a further name of a class is an alias
            classes.add(item)
            yield from ((registry(kind), key, item) for kind in KINDS if (key := _stated(kind, item)))


def _reads(function: FunctionType) -> bool:
    """Tell whether a function is annotated to return what readers return, as text or not."""
    returned = str(getattr(function, "__annotations__", {}).get("return", ""))
    kinds = re.split(r"[|,]", _UNION.sub(r"\1", returned))
    names = [kind.rpartition(".")[2].strip("'> ") for kind in kinds]
    return set(names) <= {"Waveforms", "Channels", "Spectra"}


def _stated(kind: str, item: type) -> str:
    """Return the name that a class states for itself as a plugin of a kind; empty where it is none."""
    field = _STATED_IN.get(kind)
    if field is None or not issubclass(item, _base(kind)):
        return ""
    stated_here = field in vars(item) or field in vars(item).get("__annotations__", {})
    fields: dict[str, Any] = getattr(item, "model_fields", {})
    name = fields[field].default if field in fields else vars(item).get(field)
    return name if stated_here and isinstance(name, str) else ""


def _base(kind: str) -> type:
    from multilayer.diagnosis.effects.base import BaseEffect
    from multilayer.diagnosis.places import LevelPlace, Place, TubePlace
    from multilayer.fits.methods import Method
    from multilayer.layers.base import Layer
    from multilayer.media.laws.base import ModulusLaw
    from multilayer.rig.effect_base import Effect

    bases: dict[str, type] = {
        "layer": Layer, "law": ModulusLaw, "effect": BaseEffect, "method": Method, "rig effect": Effect, "place": Place,
        "place of a tube": TubePlace, "place of a construction": LevelPlace,
    }  # fmt: skip
    return bases[kind]


def _forget(file: str, text: str) -> None:
    name = _module_name(file, text)
    sys.modules.pop(name, None)
    for registry_of_kind in map(registry, KINDS):
        for key in registry_of_kind.names():
            if [owner.value for owner in registry_of_kind.owners(key)] == [file]:
                registry_of_kind.unregister(key)

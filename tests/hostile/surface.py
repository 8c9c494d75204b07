"""What a caller can call: found in the modules, never listed by hand."""

import inspect
import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from types import ModuleType

BOOK = Path(__file__).parents[2] / "book"
CHAPTERS = Path(__file__).parents[2] / "lib" / "robot_perception" / "chapters"

MADE = ("teaching", "book")
CHECKED = ("studies.intervals", "studies.sweep")
"""Modules of the tools that check what they are handed."""


def modules() -> tuple[str, ...]:
    """Return the names of the public modules: those of the library's pages, and all worlds.

    `teaching` makes the book of what `book` holds; no stranger calls them, and they check no types.
    """
    pages = "\n".join(page.read_text("utf-8") for page in sorted((BOOK / "library").glob("*.md")))
    documented = re.findall(r"automodule:: (robot_perception\S*)", pages)
    synth = import_module("data_synth")
    worlds = [found.name for found in walk_packages(synth.__path__, "data_synth.")]
    rooms = (name for name in documented if room_of(name) not in MADE)
    return (*rooms, *CHECKED, *worlds)


def room_of(module: str) -> str:
    """Return the room a module belongs to: the first word below the package."""
    package, room, *_ = module.split(".")
    return room if package == "robot_perception" else package


def public(room: str) -> dict[Callable, str]:
    """Return the public functions, constructors and methods of a room with their names.

    Of the worlds, which no stranger calls, these are what a chapter names and could get wrong.
    """
    found: dict[Callable, str] = {}
    for name in modules():
        if room_of(name) == room:
            for label, thing in _named(import_module(name)):
                if room != "data_synth" or label.split(".")[-1] in _words_of_chapters():
                    found.setdefault(thing, f"{name.removeprefix('robot_perception.')}.{label}")
    return found


@cache
def _words_of_chapters() -> frozenset[str]:
    """Return the words of the code of notebooks and of the chapters' packages."""
    cells = [cell for page in BOOK.glob("*.ipynb")
             for cell in json.loads(page.read_text("utf-8"))["cells"]]  # fmt: skip
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    code += [module.read_text("utf-8") for module in CHAPTERS.rglob("*.py")]
    return frozenset(re.findall(r"\w+", "\n".join(code)))


def made(room: str) -> set[type]:
    """Return the types that only the library makes: they check nothing, and it hands them out.

    A public function returns them or calls a caller's function with them, or a field of what it
    returns holds them.
    """
    things = public(room)
    kinds = [thing for thing in things if is_dataclass(thing)]
    signatures = [inspect.signature(thing) for thing in things if not inspect.isclass(thing)]
    taken = (str(p.annotation) for s in signatures for p in s.parameters.values())
    told = " ".join(found for text in taken for found in re.findall(r"Callable\[\[.*?\]", text))
    told += " ".join(str(signature.return_annotation) for signature in signatures)
    found: set[type] = set()
    while new := {kind for kind in kinds if re.search(rf"\b{kind.__name__}\b", told)} - found:
        found |= new
        told = " ".join(str(field.type) for kind in new for field in fields(kind))
    return {kind for kind in found if not hasattr(kind, "__post_init__")}


def calls(room: str) -> dict[Callable, Callable[[], tuple]]:
    """Return the valid calls of a room, those of its table and those that follow from them.

    A type whose objects other calls are given is made again of the fields of the first of these.
    """
    table, names = import_module(f"tests.hostile.calls.{room}"), public(room)
    given: dict[type, object] = {}
    for valid in table.CALLS.values():
        args, kwargs = valid()
        for thing in _parts([*args, *kwargs.values()]):
            given.setdefault(type(thing), thing)
    others = {
        kind: lambda thing=thing: (tuple(getattr(thing, f.name) for f in fields(thing)), {})
        for kind, thing in given.items()
        if kind in names and kind not in table.CALLS and all(f.init for f in fields(kind))
    }
    return table.CALLS | {kind: others[kind] for kind in others if kind not in made(room)}


def _parts(things: Iterable) -> Iterator[object]:
    """Yield the objects of dataclasses among some things, and those inside of these."""
    for thing in things:
        if is_dataclass(thing) and not isinstance(thing, type):
            yield thing
            yield from _parts(getattr(thing, f.name) for f in fields(thing))
        elif isinstance(thing, list | tuple):
            yield from _parts(thing)


def _named(module: ModuleType) -> Iterator[tuple[str, Callable]]:
    """Yield what a module offers: its ``__all__``, or what it defines without an underscore."""
    listed = getattr(module, "__all__", None)
    for name, thing in sorted(vars(module).items()):
        if name not in listed if listed is not None else name.startswith("_"):
            continue
        if listed is None and getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isclass(thing):
            yield from _of_class(thing)
        elif inspect.isfunction(inspect.unwrap(thing)) if callable(thing) else False:
            yield name, thing


def _of_class(kind: type) -> Iterator[tuple[str, Callable]]:
    """Yield the constructor and the public methods; none of protocols and of exceptions."""
    if getattr(kind, "_is_protocol", False) or issubclass(kind, BaseException):
        return
    if is_dataclass(kind) or "__init__" in vars(kind):
        yield kind.__name__, kind
    for name, raw in sorted(vars(kind).items()):
        method = getattr(kind, name, None)
        if not name.startswith("_") and isinstance(raw, staticmethod | classmethod | type(_named)):
            yield f"{kind.__name__}.{name}", method

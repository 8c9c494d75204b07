"""Signatures on the pages of the library: a field's range beside its type, in words.

A range is a check beside the type, ``Annotated[int, from_to(2)]`` (`robot_perception.fields`).
Sphinx shows the function with its address in memory, another one at each build.
"""

import inspect
import re
from collections.abc import Callable
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from sphinx.application import Sphinx
from sphinx.util.inspect import stringify_annotation

_MODULES = re.compile(r"\b(?:\w+\.)+(?=\w)")


def with_ranges(app: Sphinx, thing: Any, bound: bool) -> None:
    """Let the types of a function's parameters be shown with their ranges in words."""
    types = getattr(thing, "__annotations__", None)
    if inspect.isfunction(thing) and types:
        thing.__annotations__ = {name: worded(hint) for name, hint in types.items()}


def worded(hint: Any) -> Any:
    """Return a type that is shown as its own, with its ranges in words; others as they are."""
    if get_origin(hint) is Annotated:
        inner, *ranges = get_args(hint)
        words = ", ".join(filter(None, map(said, ranges)))
        shown = _MODULES.sub("", stringify_annotation(inner, "fully-qualified"))
        return _named(f"{shown} ({words})" if words else shown)
    parts = get_args(hint)
    if any(get_origin(part) is Annotated for part in parts):
        shown = ["None" if part is NoneType else _shown(worded(part)) for part in parts]
        whole = getattr(hint, "__name__", "")
        joined = " | ".join(shown)
        return _named(f"{whole}[{', '.join(shown)}]" if whole in ("tuple", "dict") else joined)
    return hint


def said(check: Callable[..., Any] | str) -> str:
    """Return what a check asks for, in words; nothing of a mark that asks for nothing."""
    if isinstance(check, str):
        return ""
    free = inspect.getclosurevars(check).nonlocals if inspect.isfunction(check) else {}
    if "words" in free:
        return " or ".join(map(repr, free["words"]))
    if "kinds" in free:
        return ""
    if "low" in free:
        return f"above {free['low']}, at most {free['most']}"
    if "least" in free:
        most = free.get("most")
        return f"{free['least']} or more" if most is None else f"{free['least']} to {most}"
    return check.__name__.strip("_<>").replace("_", " ").replace("lambda", "")


def _shown(kind: Any) -> str:
    return _MODULES.sub("", stringify_annotation(kind, "fully-qualified"))


def _named(name: str) -> type:
    """Return a type that is shown by a name."""
    return type(name, (), {"__module__": "builtins", "__qualname__": name})

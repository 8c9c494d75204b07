"""Results that take longer than a page may: computed once, kept on this computer.

What is kept lies in the folder of downloads, below ``computed``, and may be deleted at any time.
Its name is a hash of all it depends on: the code, the libraries and the arguments. So a stale
result is never read, and nothing of it is ever committed.
"""

import hashlib
import inspect
import os
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar

from robot_perception.checks import dataclass_type, instances, shown
from robot_perception.datasets.store import cache_directory
from robot_perception.teaching import storage

Result = TypeVar("Result")
LIBRARIES = ("numpy", "numba", "scipy", "opencv-python-headless")


def kept(
    compute: Callable[..., Result], kind: type[Result], *arguments: Any, code: Sequence[ModuleType]
) -> Result:
    """Return ``compute(*arguments)``, from storage if it was computed before.

    Parameters
    ----------
    compute
        A function that always returns the same for the same arguments.
    kind
        Type of the result, a dataclass that `teaching.storage` can store.
    arguments
        Numbers, texts, and tuples and dataclasses of them, whose ``repr`` says all.
    code
        Modules and packages on whose source the result depends, beside that of ``compute``.

    Raises
    ------
    TypeError
        If ``compute`` is no function of a module, ``kind`` no dataclass, ``code`` no modules, or
        one of the ``arguments`` is of another kind.
    """
    if not isinstance(compute, FunctionType):
        raise TypeError(f"compute must be a function, got {shown(compute)}")
    for value in arguments:
        if not _is_told_by_repr(value):
            raise TypeError(
                f"arguments must be numbers, texts or dataclasses of them, got {shown(value)}"
            )
    dataclass_type("kind", kind)
    file = _file(compute, arguments, instances("code", code, ModuleType))
    with suppress(OSError, ValueError, KeyError):  # not there, or damaged
        return storage.load(file, kind)
    result = compute(*arguments)
    with suppress(OSError):  # no room, or no right to write: compute it again next time
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=file.parent) as folder:
            storage.save(Path(folder) / file.name, result)
            os.replace(Path(folder) / file.name, file)
    return result


def _is_told_by_repr(value: object) -> bool:
    """Tell whether the ``repr`` of a value says all; that of a large array leaves out most."""
    if isinstance(value, tuple):
        return all(map(_is_told_by_repr, value))
    if is_dataclass(value) and not isinstance(value, type):
        return all(_is_told_by_repr(getattr(value, f.name)) for f in fields(value))
    return isinstance(value, str | int | float)


def _file(
    compute: Callable[..., Any], arguments: tuple[Any, ...], code: Sequence[ModuleType]
) -> Path:
    """Return where a result is kept."""
    own: Any = inspect.unwrap(compute)  # what checks the shapes stands in another file
    sources = {Path(own.__globals__["__file__"])}
    for module in code:
        at = Path(str(module.__file__))
        sources |= set(at.parent.rglob("*.py")) if at.name == "__init__.py" else {at}
    digest = hashlib.sha256(repr(arguments).encode())
    for library in LIBRARIES:
        digest.update(f"{library} {version(library)}\n".encode())
    for source in sorted(sources, key=lambda path: path.parts[-3:]):
        digest.update("/".join(source.parts[-3:]).encode() + source.read_bytes())
    return cache_directory() / "computed" / f"{compute.__name__}-{digest.hexdigest()[:20]}.npz"

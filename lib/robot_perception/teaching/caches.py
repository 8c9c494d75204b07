"""Results that take long, kept in the reader's cache: computed once, read ever after.

A file is named by a hash of everything that the result depends on: the code, the parameters, and
the versions of what computes it. So it is never out of date; it is merely never asked for again.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Sequence
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

from robot_perception.checks import dataclass_type, instance, instances, shown
from robot_perception.datasets.store import cache_directory
from robot_perception.teaching import storage

Result = TypeVar("Result")
FOLDER = "computed"
PEERS = ("numpy", "scipy", "opencv-python-headless")
"""Whose versions can change numbers."""


def cached(
    compute: Callable[[], Result], kind: type[Result], key: object, *, code: Sequence[str]
) -> Result:
    """Return what a function computes, from the cache if it stands there.

    Where the cache cannot be written, or what it holds cannot be read, the function is called.

    Parameters
    ----------
    compute
        The function.
    kind
        Type of its result, a dataclass of what `teaching.storage` can store.
    key
        Its parameters: two that look alike, by `repr`, are the same.
    code
        Modules and packages whose source the result depends on.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If there is no such module.
    """
    if not callable(compute):
        raise TypeError(f"compute must be a function, got {shown(compute)}")
    dataclass_type("kind", kind)
    digest = hashlib.sha256(repr((kind.__qualname__, key)).encode())
    for name in sorted(instances("code", code, str)):
        for file in _sources(name):
            digest.update(name.encode() + file.read_bytes())
    for name in PEERS:
        digest.update(version(name).encode())
    path = cache_directory() / FOLDER / f"{kind.__name__}-{digest.hexdigest()[:20]}.npz"
    try:
        return storage.load(path, kind)
    except (OSError, ValueError):
        result = instance("what compute returns", compute(), kind)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            storage.save(Path(folder) / path.name, result)
            os.replace(Path(folder) / path.name, path)  # whole or not at all
    except OSError:
        pass  # the result is here all the same
    return result


def _sources(name: str) -> list[Path]:
    try:
        found = find_spec(name)
    except ModuleNotFoundError:
        found = None
    if found is None or found.origin is None:
        raise ValueError(f"code must name modules, got {name!r}")
    file = Path(found.origin)
    return sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]

"""Results that are computed once: in this process, and on this computer.

What took longer than half a second is kept in the folder of downloads, below ``computed``, and may
be deleted at any time. Its name is a hash of all it depends on: the code of the function and all
that it imports, the libraries, and the arguments. So a stale result is never read. Two processes
that need the same at the same time compute it once: the second waits for the first.
"""

import hashlib
import inspect
import io
import logging
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import joblib
from filelock import FileLock

from robot_perception.checks import shown
from robot_perception.datasets.store import cache_directory
from robot_perception.files import DamagedFile, reading, written
from robot_perception.teaching.cells import BOOK, LIVE, code_of
from robot_perception.teaching.dependencies import PACKAGES, code_digest

P = ParamSpec("P")
Result = TypeVar("Result")

LIBRARIES = ("numpy", "numba", "scipy", "opencv-python-headless")
WORTH_KEEPING = 0.5
"""What takes less to compute is not kept on disk, s."""
IN_MEMORY = 64
"""So many results of one function stay in the memory of a process."""

log = logging.getLogger(__name__)


def kept(compute: Callable[P, Result]) -> Callable[P, Result]:
    """Let a function be computed once for the same arguments and the same code.

    One of the library's or of a notebook's cells is kept on this computer as well, another one of a
    reader's own in memory alone.

    It must always return the same for the same arguments: numbers, texts, and tuples and
    dataclasses of them. What it returns is shared, and not to be written to.

    Raises
    ------
    TypeError
        When called with an argument of another kind.
    """
    signature = inspect.signature(compute)

    @lru_cache(maxsize=IN_MEMORY)
    def once(code: str | None, *values: Any) -> Any:
        named = dict(zip(signature.parameters, values, strict=True))
        bound = inspect.BoundArguments(signature, named)
        return keep(compute, values, lambda: compute(*bound.args, **bound.kwargs))

    @wraps(compute)
    def remembered(*args: P.args, **kwargs: P.kwargs) -> Result:
        bound = signature.bind(*args, **kwargs)
        bound.apply_defaults()
        values = tuple(bound.arguments.values())
        told(values)
        live = compute.__module__ == LIVE  # where a reader edits what it reaches
        return once(_code(compute) if live else None, *values)

    remembered.cache_clear = once.cache_clear
    return remembered


def keep(
    code: Callable[..., Any], arguments: tuple[Any, ...], call: Callable[[], Result]
) -> Result:
    """Return what a call gives, from this computer if it was computed before.

    Parameters
    ----------
    code
        The function whose code, with all that its module imports, the result depends on.
    arguments
        What else it depends on.
    call
        Computes it.
    """
    own: Any = inspect.unwrap(code)  # what checks shapes stands in another file
    code_hash = _code(own)
    if code_hash is None:
        return call()  # what a reader's own function depends on is not known
    digest = hashlib.sha256(code_hash.encode())
    for library in LIBRARIES:
        digest.update(f"{library} {version(library)}\n".encode())
    digest.update(f"{own.__qualname__} {arguments!r}".encode())
    folder = cache_directory() / "computed"
    file = folder / f"{own.__name__}-{digest.hexdigest()[:20]}"
    found = _read(file)
    if found is not None:
        return found[0]
    lock: Any = nullcontext()
    with suppress(OSError):  # no room, or no right to write: compute it without
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(file.with_suffix(".lock"))
        lock.acquire()
        lock.release()
    with lock:
        found = _read(file)  # another process may have computed it while this one waited
        if found is not None:
            return found[0]
        start = time.perf_counter()
        result = call()
        if time.perf_counter() - start > WORTH_KEEPING:
            with suppress(OSError):
                _write(file, result)
    return result


def _code(function: Callable[..., Any]) -> str | None:
    """Hash what a function depends on; ``None`` if that is not known."""
    module = function.__module__
    if module == LIVE or module.startswith(BOOK):
        return code_of(function)
    return code_digest(module) if module.partition(".")[0] in PACKAGES else None


def told(value: object) -> None:
    """Refuse a value whose ``repr`` may not say all: that of a large array leaves out most."""
    if isinstance(value, tuple):
        for item in value:
            told(item)
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            told(getattr(value, field.name))
    elif not isinstance(value, str | int | float | Enum | None):
        raise TypeError(
            f"arguments must be numbers, texts or dataclasses of them, got {shown(value)}"
        )


def _read(file: Path) -> tuple[Any] | None:
    """Return what a file holds; nothing if it is not there or damaged."""
    try:
        stored = file.read_bytes()
    except OSError:
        return None
    body = stored[32:]
    if hashlib.sha256(body).digest() != stored[:32]:
        log.warning("%s is damaged and computed anew", file.name)
        return None
    try:
        with reading(file, "no result that is kept"):
            return (joblib.load(io.BytesIO(body)),)
    except DamagedFile as error:  # whole, but of other versions of what it is made of
        log.warning("%s: computed anew", error)
        return None


def _write(file: Path, result: Any) -> None:
    """Store a result behind its hash, at once or not at all."""
    body = io.BytesIO()
    joblib.dump(result, body, compress=1)
    with written(file) as beside:
        beside.write_bytes(hashlib.sha256(body.getvalue()).digest() + body.getvalue())

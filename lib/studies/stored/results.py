"""Results that are computed once: in this process, and on this computer.

What took longer than half a second is kept in the cache of the project, below ``computed``, and may
be deleted at any time. Its name is a hash of all it depends on: the code of the function and all
that it imports, the libraries, and the arguments. So a stale result is never read. Two processes
that need the same at the same time compute it once: the second waits for the first.

A file holds numbers and how they belong together (:mod:`.structures`), no code: whoever may write
there can change numbers, and run nothing. What nobody has used for a month is removed, and the
oldest where all together are too large.
"""

import hashlib
import inspect
import logging
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from studies.checks import shown
from studies.files import A_DAY, LOST, DamagedFile, clear, reading
from studies.keys.cells import LIVE, code_of, in_cells
from studies.keys.dependencies import code_digest, known_packages
from studies.keys.versions import installed
from studies.project import project
from studies.stored import storage
from studies.stored.locks import LOCKS, alone, say
from studies.stored.structures import Packed, packed, unpacked

P = ParamSpec("P")
Result = TypeVar("Result")

WORTH_KEEPING = 0.5
"""Shortest computation whose result is kept on disk, s."""
IN_MEMORY = 64
"""Results of one function that stay in the memory of a process."""
COMPUTED, TRIALS, TRIALS_ANEW = "computed", "trials", "trials-anew"
"""Folders of the cache: of results, and of trials of studies."""
UNUSED = 30 * A_DAY
"""Time without use after which a result is removed, s."""
MOST_BYTES = 4_000_000_000
"""Kept results and trials take at most so much room."""

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
        return _from_disk(compute, values, lambda: compute(*bound.args, **bound.kwargs))

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


def _from_disk(
    compute: Callable[..., Any], arguments: tuple[Any, ...], call: Callable[[], Result]
) -> Result:
    """Return what a call of a function gives, from this computer if it was computed before."""
    own: Any = inspect.unwrap(compute)  # what checks shapes stands in another file
    code_hash = _code(own)
    if code_hash is None:
        return call()  # what a reader's own function depends on is not known
    digest = hashlib.sha256(code_hash.encode())
    for library, number in installed().items():
        digest.update(f"{library} {number}\n".encode())
    digest.update(f"{own.__qualname__} {arguments!r}".encode())
    name = re.sub(r"\W", "_", own.__name__)
    file = project().cache() / COMPUTED / f"{name}-{digest.hexdigest()[:20]}.npz"
    found = _read(file)
    if found is not None:
        return found[0]
    lock = file.with_suffix(".lock")
    with alone(lock, own.__qualname__):
        found = _read(file)  # another process may have computed it while this one waited
        if found is None:
            start = time.perf_counter()
            found = (call(),)
            if time.perf_counter() - start > WORTH_KEEPING:
                _write(file, found[0])
                _prune_once()
        with suppress(OSError):  # who waits for it has it open, and then finds the result
            lock.unlink()
    return found[0]


def _code(function: Callable[..., Any]) -> str | None:
    """Hash what a function depends on; ``None`` if that is not known."""
    module = function.__module__
    if in_cells(module):
        return code_of(function)
    if module.partition(".")[0] not in known_packages():
        return None
    return code_digest(f"{module}:{function.__qualname__.partition('.')[0]}")


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
        with reading(file, "no result that is kept"):
            found = (unpacked(storage.load(file, Packed)),)
            use(file)
            return found
    except LOST:
        return None
    except DamagedFile as error:  # or whole, but of other versions of what it is made of
        log.warning("%s: computed anew", error)
        return None


def _write(file: Path, result: Any) -> None:
    """Store a result, at once or not at all; not what no file can hold."""
    try:
        storage.save(file, packed(result, pictures=False), finite=False, level=1)
    except TypeError as error:
        say("%s is not kept: %s", file.stem, error)
    except OSError as error:  # no room, or no right to write
        say("%s is not kept: %s", file.stem, error.strerror)


def use(file: Path) -> None:
    """Note that a kept file was used, so that it stays."""
    with suppress(OSError):
        os.utime(file)


@dataclass(frozen=True, slots=True)
class Pruned:
    """Numbers of files and bytes that were removed of the cache, and that were left."""

    removed: int
    removed_bytes: int
    left: int
    left_bytes: int


def prune() -> Pruned:
    """Remove kept results and trials that nobody has used for long, and the oldest of too many.

    What earlier versions have kept and locks that nobody holds go a day after their last use; so
    does what downloads that were killed have left.
    """
    for folder in project().cache().glob("*/"):
        clear(folder)
    now, kept, removed = time.time(), [], []
    for file in _cached():
        with suppress(FileNotFoundError):  # another process may remove it, too
            about = file.stat()
            entry = (about.st_mtime, about.st_size, file)
            unused = UNUSED if file.suffix in (".npz", ".json") else A_DAY
            (removed if now - about.st_mtime > unused else kept).append(entry)
    size = sum(size for _, size, _ in kept)
    kept.sort(key=lambda entry: entry[0], reverse=True)
    while size > MOST_BYTES:
        removed.append(kept.pop())
        size -= removed[-1][1]
    for _, _, file in removed:
        with suppress(OSError):
            file.unlink()
    return Pruned(len(removed), sum(size for _, size, _ in removed), len(kept), size)


@lru_cache
def _prune_once() -> None:
    """Prune once in each process that keeps anything."""
    gone = prune()
    if gone.removed:
        log.info("%d old results were removed, %.0f MB", gone.removed, gone.removed_bytes / 1e6)


def _cached() -> Iterator[Path]:
    """Yield the files of the cache that are no recordings."""
    for name in (COMPUTED, TRIALS, TRIALS_ANEW, LOCKS):
        folder = project().cache() / name
        with suppress(FileNotFoundError, NotADirectoryError):
            yield from (file for file in folder.iterdir() if file.is_file())

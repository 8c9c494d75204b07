"""Locks: one process at a time changes a record, and one computes what several need."""

import logging
import os
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from explorables.progress import PAGE_VARIABLE
from studies.keys.dependencies import hashed
from studies.project import project

LOCKS = "locks"
"""Folder of the cache."""
SOON = 2.0
"""Waiting time after which a process says that it waits, s."""

log = logging.getLogger(__name__)


def say(text: str, *parts: object) -> None:
    """Say what goes on with the files of this computer; a page of the book is no place for it."""
    log.log(logging.INFO if os.environ.get(PAGE_VARIABLE) == "1" else logging.WARNING, text, *parts)


@contextmanager
def alone(place: Path, what: str) -> Iterator[None]:
    """Let one process of this computer at a time work inside; who waits for another one says so.

    Where nothing can be written, nobody waits.

    Parameters
    ----------
    place
        The file of the lock.
    what
        What is worked on, in words.
    """
    lock = FileLock(place)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            lock.acquire(timeout=SOON)
        except Timeout:
            say("another process works on %s; waiting until it ends", what)
            lock.acquire()
    except OSError as error:
        say("no lock for %s (%s)", what, error.strerror)
    try:
        yield
    finally:
        lock.release()


def changing(file: Path) -> AbstractContextManager[None]:
    """Let one process at a time read a record and write it anew."""
    place = Path(os.path.realpath(file))
    name = f"{place.name}-{hashed(str(place))}.lock"
    return alone(project().cache() / LOCKS / name, str(place))

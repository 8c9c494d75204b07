"""Files: one error for a damaged one, and none that is written by half."""

import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from studies.checks import flag, instance, shown

UNFINISHED = ".unfinished-"
"""Prefix of the folders in which files are made before they appear in their place."""
A_DAY = 86400.0
LOST = FileNotFoundError, PermissionError, IsADirectoryError, NotADirectoryError


class DamagedFile(ValueError):  # noqa: N818 - it names the thing, not the failure
    """A file that cannot be read for what it should be; the message names it."""


@contextmanager
def reading(path: Path | str, what: str, kind: type[DamagedFile] = DamagedFile) -> Iterator[None]:
    """Raise one error that names a file for all that a damaged one makes its readers raise.

    That a file is not there, or not to be read, goes through as it is, and so does what names the
    file already. A byte that fell over makes a reader in a library raise nearly anything.

    Parameters
    ----------
    path
        The file.
    what
        What is wrong with it, in words.
    kind
        Error to raise.

    Raises
    ------
    DamagedFile
        Of that kind, for any other error inside.
    """
    try:
        yield
    except (*LOST, DamagedFile):
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise kind(f"{path}: {what} ({reason})") from error


@contextmanager
def written(path: Path | str) -> Iterator[Path]:
    """Give a place to write to, which becomes the file at the end: whole, or not at all.

    Whatever ends the writing before, an error or the key that interrupts, leaves the file as it
    was. Who may read and write it stays as it was, too.

    Parameters
    ----------
    path
        The file, in a folder that exists.

    Yields
    ------
    Path
        Of the same name, in a folder of its own beside the file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    path = Path(os.path.realpath(path))
    if path.exists() and not path.is_file():  # a terminal or a pipe has no place beside it
        yield path
        return
    with workspace(path.parent) as folder:
        beside = folder / path.name
        yield beside
        if path.exists():
            shutil.copymode(path, beside)
        os.replace(beside, path)


@contextmanager
def workspace(folder: Path) -> Iterator[Path]:
    """Give a hidden folder inside a folder, which is gone at the end.

    What a process that was killed has left there goes a day later.

    Parameters
    ----------
    folder
        On whose disk files are to be made.

    Yields
    ------
    Path
        The hidden folder.

    Raises
    ------
    OSError
        If nothing can be written there.
    """
    clear(folder)
    with TemporaryDirectory(prefix=UNFINISHED, dir=folder) as made:
        yield Path(made)


def clear(folder: Path) -> None:
    """Remove what processes that were killed have left in a folder more than a day ago."""
    for left in folder.glob(f"{UNFINISHED}*"):
        with suppress(OSError):  # others may take it away at the same time
            if time.time() - left.stat().st_mtime > A_DAY:
                shutil.rmtree(left)


def destination(path: Path | str, *, overwrite: bool) -> Path:
    """Return the path of a file to write.

    Parameters
    ----------
    path
        The file.
    overwrite
        Whether it may be there already.

    Raises
    ------
    ValueError
        If the system can have no file of that name.
    FileNotFoundError
        If it has no folder.
    FileExistsError
        If it is there and must not be.
    """
    path = Path(instance("path", path, str, os.PathLike))
    try:
        named = b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:
        named = False
    if not named:
        raise ValueError(f"path must be a name that a file can have, got {shown(str(path))}")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path.parent} is no folder: cannot write {path.name} there")
    if path.is_file() and not flag("overwrite", overwrite):
        raise FileExistsError(f"{path} is there already; overwrite=True replaces it")
    return path

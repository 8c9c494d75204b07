"""Files: one error for a damaged one, and none that is written by half."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from robot_perception.checks import flag, instance

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
    was.

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
    with tempfile.TemporaryDirectory(prefix=".", dir=path.parent) as folder:
        beside = Path(folder) / path.name
        yield beside
        os.replace(beside, path)


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
    FileNotFoundError
        If it has no folder.
    FileExistsError
        If it is there and must not be.
    """
    path = Path(instance("path", path, str, os.PathLike))
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path.parent} is no folder: cannot write {path.name} there")
    if path.is_file() and not flag("overwrite", overwrite):
        raise FileExistsError(f"{path} is there already; overwrite=True replaces it")
    return path

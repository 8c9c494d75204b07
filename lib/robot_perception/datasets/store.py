"""Store of recordings on this computer, and download of missing ones."""

import errno
import gzip
import hashlib
import logging
import lzma
import os
import tarfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from tarfile import TarError
from typing import Literal, final
from zipfile import BadZipFile, ZipFile

from robot_perception.checks import flag, instance, positive
from robot_perception.datasets.entries import (
    DATA_VARIABLE,
    DataFile,
    Dataset,
    UnknownDataset,
    data_directory,
    dataset,
    load_pooch,
    named_by,
    registry,
    some,
)
from robot_perception.extras import needing
from studies.files import UNFINISHED, workspace

CACHE_VARIABLE = "ROBOT_PERCEPTION_CACHE"
UNPACKING = BadZipFile, TarError, RuntimeError, EOFError, zlib.error, lzma.LZMAError
"""Errors of an archive that is damaged, encrypted, or packed in an unknown way."""


class DatasetMissing(FileNotFoundError):  # noqa: N818 - it names the thing, not the failure
    """A recording that is not on this computer; the message says how to get it."""


class DownloadError(OSError):
    """A recording that could not be downloaded; the message says whence, and what went wrong."""


@final
@dataclass(frozen=True, slots=True)
class FileStatus:
    """Place of a file of a data set, and whether its hash is the pinned one.

    Parameters
    ----------
    file
        The file as registered.
    state
        ``present`` with the pinned hash, ``differs`` from it, ``missing``, or ``unchecked``: it is
        there unpacked, and the pinned hash is that of the archive.
    path
        Where it is; ``None`` if it is missing.
    """

    file: DataFile
    state: Literal["present", "differs", "missing", "unchecked"]
    path: Path | None


def cache_directory() -> Path:
    """Return the directory of downloads: ``ROBOT_PERCEPTION_CACHE`` or the platform's own.

    Raises
    ------
    NotADirectoryError
        If that begins with the home of a user who is not known.
    """
    return named_by(CACHE_VARIABLE) or Path(load_pooch().os_cache("robot-perception"))


def find(name: str, file: str | None = None) -> Path | None:
    """Return where a data set, or one file of it, is on this computer; never download.

    The directory named by ``ROBOT_PERCEPTION_DATA`` comes first, then the cache of downloads. Files
    in the former are used as they are; folders and files of one's own are found there too. A file
    is found whether it is stored plain or as ``.gz``.

    Parameters
    ----------
    name
        Data set.
    file
        File in it; without it, the folder that holds all of its files is meant.

    Returns
    -------
    Path or None
        The file or folder; ``None`` if it is not there.

    Raises
    ------
    NotADirectoryError
        If ``ROBOT_PERCEPTION_DATA`` names no directory.
    UnknownDataset
        If neither the registry nor the user's directory knows the name.
    """
    _check_relative(instance("name", name, str))
    if file is not None:
        _check_relative(instance("file", file, str))
    directory = data_directory()
    own = directory / name if directory is not None and (directory / name).is_dir() else None
    if name not in registry() and own is not None:
        return own if file is None else _stored(own, file)
    known = dataset(name)
    folders = [folder for folder in (own, cache_directory() / name) if folder is not None]
    if file is None:
        return next((folder for folder in folders if _is_complete(folder, known)), None)
    if not known.members and (own is None or _stored(own, file) is None):
        file = known.file(file).name
    return next((place for folder in folders if (place := _stored(folder, file))), None)


def path(name: str, file: str | None = None, *, download: bool = False) -> Path:
    """Return where a data set, or one file of it, is on this computer.

    Parameters
    ----------
    name, file
        As for `find`.
    download
        Whether to download what is missing.

    Returns
    -------
    Path
        The file or folder.

    Raises
    ------
    DatasetMissing
        If it is not there; the message says how to get it.
    DownloadError
        If it should be downloaded and could not be.
    UnknownDataset
        If neither the registry nor the user's directory knows the name.
    """
    flag("download", download)
    found = find(name, file)
    if found is None and download:
        fetch(name, file)
        found = find(name, file)
    if found is not None:
        return found
    if name not in registry():
        raise DatasetMissing(f"{name}/{file} is not in {data_directory()}")
    known = dataset(name)
    missing = [item.file for item in status(name, file) if item.path is None]
    if not missing and known.members:
        raise DatasetMissing(f"{known.files[0].name} of {name} holds no {file}")
    if not missing:
        raise DatasetMissing(
            f"the files of {name} lie partly in {data_directory()} and partly in"
            f" {cache_directory()}: ask for them one by one"
        )
    raise DatasetMissing(_how_to_get(known, missing))


def fetch(
    name: str, file: str | None = None, *, progress: bool = False, timeout: float = 30.0
) -> tuple[Path, ...]:
    """Download what is missing of a data set, and return where its files are.

    A file appears in the cache whole and with the pinned hash, or not at all; an archive is
    unpacked. A file in the directory named by ``ROBOT_PERCEPTION_DATA`` is taken as it is; a cached
    one that has changed is replaced.

    Parameters
    ----------
    name
        Data set.
    file
        File in it; without it, all of them. An archive always comes whole.
    progress
        Whether to show a progress bar.
    timeout
        How long to wait for the server to say anything, in s.

    Returns
    -------
    tuple of Path
        The files, in the order of the registry, or of an archive by name.

    Raises
    ------
    DownloadError
        If a download fails.
    DatasetMissing
        If a file is missing that cannot be downloaded (after the others have been).
    UnknownDataset
        If the registry does not know the name.
    """
    with needing():
        from tqdm.auto import tqdm

    flag("progress", progress)
    timeout = positive("timeout", timeout)
    known = dataset(name)
    places: list[Path] = []
    missing: list[DataFile] = []
    wanted = status(name, file)
    for item in tqdm(wanted, desc=name, unit="file", disable=not progress):
        place = item.path
        if place is not None and (item.state != "differs" or not _is_cached(place)):
            places.append(place)
        elif item.file.url is None:
            missing.append(item.file)
        else:
            places.append(_download(known, item.file, item.file.url, timeout, progress))
    if missing:
        raise DatasetMissing(_how_to_get(known, missing))
    return tuple(_members(path(name), known)) if known.members else tuple(places)


def status(name: str, file: str | None = None) -> tuple[FileStatus, ...]:
    """Tell where the files of a data set are and whether they have the pinned hashes.

    Parameters
    ----------
    name
        Data set.
    file
        File of it; without it, all of them. Of an archive, the archive is meant.

    Raises
    ------
    UnknownDataset
        If the registry does not know the name.
    """
    known = dataset(name)
    if file is not None:
        instance("file", file, str)
    if known.members:
        (archive,), folder = known.files, find(name)
        place = folder and (_stored(folder, archive.name) or folder)
        return (_file_status(archive, place),)
    files = known.files if file is None else (known.file(file),)
    return tuple(_file_status(entry, find(name, entry.name)) for entry in files)


def size_text(size: int) -> str:
    """Return a number of bytes for people."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{max(size, 100) / 1e3:.1f} kB"


def _check_relative(name: str) -> None:
    parts = PurePosixPath(name).parts
    if not parts or name.startswith(("/", "~")) or "\\" in name or ".." in parts:
        raise UnknownDataset(f"{name!r} is not a name inside a data directory")


def _stored(folder: Path, name: str) -> Path | None:
    """Return the file as named, or else its plain or compressed form."""
    plain = name.removesuffix(".gz")
    for candidate in (name, plain, f"{plain}.gz"):
        if (folder / candidate).is_file():
            return folder / candidate
    return None


def _members(folder: Path, known: Dataset) -> list[Path]:
    """Return the unpacked files of an archive."""
    return sorted(
        place
        for place in folder.rglob("*")
        if place.is_file()
        and place != folder / known.files[0].name
        and not place.relative_to(folder).parts[0].startswith(UNFINISHED)
    )


def _is_complete(folder: Path, known: Dataset) -> bool:
    if known.members:
        return len(_members(folder, known)) >= known.members
    return all(_stored(folder, file.name) for file in known.files)


def _is_cached(place: Path) -> bool:
    return place.is_relative_to(cache_directory())


def _file_status(file: DataFile, place: Path | None) -> FileStatus:
    if place is None:
        return FileStatus(file, "missing", None)
    if place.is_dir() or (file.name.endswith(".gz") and place.suffix != ".gz"):
        return FileStatus(file, "unchecked", place)
    return FileStatus(file, "present" if _hash(place, file) == file.sha256 else "differs", place)


def _hash(place: Path, file: DataFile) -> str:
    """Return the hash of a file, or of its content where it is only stored as ``.gz``."""
    try:
        packed = place.suffix == ".gz" and not file.name.endswith(".gz")
        with gzip.open(place) if packed else place.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (gzip.BadGzipFile, EOFError, zlib.error):
        return ""


def _how_to_get(known: Dataset, missing: list[DataFile]) -> str:
    """Say what is missing, and the ways to get it."""
    directory = data_directory()
    place = f"into {known.name}/ in a directory of yours and set {DATA_VARIABLE} to it"
    if directory is not None:
        place = f"into {directory / known.name} ({DATA_VARIABLE} is {directory})"
    text = f"{known.name}: {_are([file.name for file in missing])} not on this computer. "
    lost = [file.name for file in missing if file.url is None]
    if len(lost) == len(missing):
        text += f"Put the recording {place}."
    else:
        text += (
            f"Either run `robot-perception datasets fetch {known.name}` (all of it:"
            f" {size_text(known.bytes)}), or put the recording {place}."
        )
    if lost:
        text += f" {_are(lost)} not downloadable: no address is pinned. {known.note}".rstrip()
    return text


def _are(names: list[str]) -> str:
    return f"{some(names)} {'is' if len(names) == 1 else 'are'}"


def _download(known: Dataset, file: DataFile, url: str, timeout: float, progress: bool) -> Path:
    pooch = load_pooch()
    place = f"{known.name}/{file.name}"
    target, folder = cache_directory() / place, cache_directory() / known.name
    # not compressed on the way, so that a short transfer is noticed as such
    downloader = pooch.HTTPDownloader(
        timeout=timeout, headers={"Accept-Encoding": "identity"}, progressbar=progress
    )
    failed = f"{place}: download from {url} failed"
    try:
        if not target.is_file() or _hash(target, file) != file.sha256:
            target.parent.mkdir(parents=True, exist_ok=True)
            with workspace(folder) as hidden, _quiet(pooch.get_logger()):
                got = pooch.retrieve(url, file.sha256, target.name, hidden, downloader=downloader)
                os.replace(got, target)
        if known.members:
            _unpack(target)
    except (*UNPACKING, OSError, ValueError) as error:
        raise DownloadError(f"{failed}: {_cause(error, timeout)}") from error
    if known.members and not _is_complete(folder, known):
        held = len(_members(folder, known))
        raise DownloadError(f"{failed}: it holds {held} files, registered are {known.members}")
    return target


def _unpack(archive: Path) -> None:
    """Put the files of an archive beside it, each of them whole."""
    with workspace(archive.parent) as folder:
        if archive.suffix == ".zip":
            with ZipFile(archive) as packed:
                packed.extractall(folder)
        else:
            with tarfile.open(archive) as packed:
                safe = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
                packed.extractall(folder, **safe)
        for place in filter(Path.is_file, sorted(folder.rglob("*"))):
            target = archive.parent / place.relative_to(folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(place, target)


@contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        yield
    finally:
        logger.setLevel(level)


def _cause(error: Exception, timeout: float) -> str:
    """Say in words why a download failed."""
    import requests  # whose exceptions are OSErrors
    from urllib3.exceptions import ReadTimeoutError

    inner = error.args[0] if error.args else None
    if isinstance(error, requests.Timeout) or isinstance(inner, ReadTimeoutError):
        return f"the server said nothing for {timeout:g} s"
    if isinstance(error, requests.HTTPError) and error.response is not None:
        return f"the server answered {error.response.status_code} {error.response.reason}"
    if isinstance(error, requests.exceptions.ChunkedEncodingError):
        return "the transfer was interrupted before the end"
    if isinstance(error, requests.ConnectionError):
        return "no connection to the server (is there a network?)"
    if isinstance(error, requests.RequestException):
        return f"the request failed ({error})"
    if isinstance(error, OSError):
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            return f"no space left in {cache_directory()}"
        return f"the file cannot be written ({error})"
    return str(error)

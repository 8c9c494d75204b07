"""Where the recordings are on this computer, and how missing ones are fetched."""

import errno
import gzip
import hashlib
import os
import secrets
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Literal, final

import pooch
import requests
import tqdm.auto
from urllib3.exceptions import ReadTimeoutError

from robot_perception.datasets.entries import (
    GITHUB,
    DataFile,
    Dataset,
    Origin,
    UnknownDataset,
    dataset,
    registry,
)

DATA_VARIABLE = "ROBOT_PERCEPTION_DATA"
CACHE_VARIABLE = "ROBOT_PERCEPTION_CACHE"
CHUNK = 65536


class DatasetMissing(FileNotFoundError):  # noqa: N818 - it names the thing, not the failure
    """A recording that is not on this computer; the message says how to get it."""


@final
class DownloadError(OSError):
    """A recording that could not be downloaded.

    Parameters
    ----------
    dataset
        Name of the data set.
    file
        Name of the file.
    address
        Where it was to come from.
    cause
        What went wrong.
    """

    def __init__(self, dataset: str, file: str, address: str, cause: str) -> None:
        super().__init__(f"{dataset}/{file}: download from {address} failed: {cause}")
        self.dataset = dataset
        self.file = file
        self.address = address
        self.cause = cause


@final
@dataclass(frozen=True, slots=True)
class FileStatus:
    """Where a file of a data set is, and whether it is the one that is meant.

    Parameters
    ----------
    file
        The file as registered.
    state
        ``present`` with the pinned hash, ``differs`` from it, or ``missing``.
    path
        Where it is; ``None`` if it is missing.
    """

    file: DataFile
    state: Literal["present", "differs", "missing"]
    path: Path | None


def data_directory() -> Path | None:
    """Return the directory named by ``ROBOT_PERCEPTION_DATA``, if that is set."""
    named = os.environ.get(DATA_VARIABLE, "")
    return Path(named).expanduser() if named else None


def cache_directory() -> Path:
    """Return the directory of downloads: ``ROBOT_PERCEPTION_CACHE`` or the platform's own."""
    named = os.environ.get(CACHE_VARIABLE, "")
    return Path(named).expanduser() if named else Path(pooch.os_cache("robot-perception"))


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
    UnknownDataset
        If neither the registry nor the user's directory knows the name.
    """
    _check_relative(name)
    if file is not None:
        _check_relative(file)
    directory = data_directory()
    own = directory / name if directory is not None and (directory / name).is_dir() else None
    if name not in registry() and own is not None:
        return own if file is None else _stored(own, file)
    known = dataset(name)
    folders = [folder for folder in (own, cache_directory() / name) if folder is not None]
    if file is None:
        complete = (
            folder
            for folder in folders
            if all(_stored(folder, entry.name) for entry in known.files)
        )
        return next(complete, None)
    if own is None or _stored(own, file) is None:
        file = known.file(file).name
    return next((place for folder in folders if (place := _stored(folder, file))), None)


def path(name: str, file: str | None = None, *, download: bool = False) -> Path:
    """Return where a data set, or one file of it, is on this computer.

    Parameters
    ----------
    name
        Data set.
    file
        File in it; without it, the folder that holds all of its files is meant.
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
    found = find(name, file)
    if found is None and download:
        fetch(name, file)
        found = find(name, file)
    if found is not None:
        return found
    if name not in registry():
        raise DatasetMissing(f"{name}/{file} is not in {data_directory()}")
    known = dataset(name)
    wanted = known.files if file is None else (known.file(file),)
    missing = [entry for entry in wanted if find(name, entry.name) is None]
    if not missing:
        raise DatasetMissing(
            f"the files of {name} lie partly in {data_directory()} and partly in"
            f" {cache_directory()}: ask for them one by one"
        )
    raise DatasetMissing(_how_to_get(known, missing))


def fetch(
    name: str,
    file: str | None = None,
    *,
    progress: bool = False,
    address: str = GITHUB,
    timeout: float = 30.0,
) -> tuple[Path, ...]:
    """Download what is missing of a data set, and return where its files are.

    A file appears in the cache whole and with the pinned hash, or not at all. A file in the
    directory named by ``ROBOT_PERCEPTION_DATA`` is taken as it is; a cached one that has changed is
    replaced.

    Parameters
    ----------
    name
        Data set.
    file
        File in it; without it, all of them.
    progress
        Whether to show a progress bar.
    address
        Server to ask, laid out like GitHub's for raw files.
    timeout
        How long to wait for the server to say anything, in s.

    Returns
    -------
    tuple of Path
        The files, in the order of the registry.

    Raises
    ------
    DownloadError
        If a download fails.
    DatasetMissing
        If a file is missing that cannot be downloaded (after the others have been).
    UnknownDataset
        If the registry does not know the name.
    """
    known = dataset(name)
    wanted = known.files if file is None else (known.file(file),)
    places: list[Path] = []
    missing: list[DataFile] = []
    for entry in wanted:
        status = file_status(name, entry)
        if status.path is not None and (status.state == "present" or not _is_cached(status.path)):
            places.append(status.path)
        elif entry.origin is None:
            missing.append(entry)
        else:
            places.append(_download(name, entry, entry.origin, address, timeout, progress=progress))
    if missing:
        raise DatasetMissing(_how_to_get(known, missing))
    return tuple(places)


def file_status(name: str, file: DataFile) -> FileStatus:
    """Tell where a file is and whether it has the pinned hash.

    Parameters
    ----------
    name
        Data set.
    file
        File of it.
    """
    place = find(name, file.name)
    if place is None:
        return FileStatus(file, "missing", None)
    return FileStatus(file, "present" if _is_the_one(place, file) else "differs", place)


def status(name: str) -> tuple[FileStatus, ...]:
    """Tell where the files of a data set are and whether they have the pinned hashes.

    Parameters
    ----------
    name
        Data set.

    Raises
    ------
    UnknownDataset
        If the registry does not know the name.
    """
    return tuple(file_status(name, file) for file in dataset(name).files)


def size_text(size: int) -> str:
    """Return a number of bytes for people.

    Parameters
    ----------
    size
        In bytes.
    """
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


def _is_cached(place: Path) -> bool:
    return place.is_relative_to(cache_directory())


def _is_the_one(place: Path, file: DataFile) -> bool:
    if pooch.file_hash(str(place)) in (file.sha256, file.content_sha256):
        return True
    if place.suffix != ".gz" or file.content_sha256 is None:
        return False
    content = hashlib.sha256()
    try:
        with gzip.open(place) as stream:
            while chunk := stream.read(CHUNK):
                content.update(chunk)
    except (OSError, EOFError, zlib.error):
        return False
    return content.hexdigest() == file.content_sha256


def _how_to_get(known: Dataset, missing: list[DataFile]) -> str:
    """Say what is missing, and the ways to get it."""
    directory = data_directory()
    if directory is None:
        place = f"into {known.name}/ in a directory of yours and set {DATA_VARIABLE} to it"
    elif directory.is_dir():
        place = f"into {directory / known.name} ({DATA_VARIABLE} is {directory})"
    else:
        place = f"into {directory / known.name} ({DATA_VARIABLE} is {directory}, not a directory)"
    names = ", ".join(file.name for file in missing)
    text = f"{known.name}: {names} {'is' if len(missing) == 1 else 'are'} not on this computer. "
    lost = [file for file in missing if file.origin is None]
    if len(lost) == len(missing):
        text += f"Put the recording {place}."
    else:
        size = size_text(sum(file.downloaded_bytes for file in missing if file.origin is not None))
        text += (
            f"Either run `robot-perception datasets fetch {known.name}` ({size} to download), or"
            f" put the recording {place}."
        )
    for file in lost:
        text += f" {file.name} has no pinned address and cannot be downloaded: it was"
        text += f" {file.made_from}."
    return text


def _download(
    name: str, file: DataFile, origin: Origin, base: str, timeout: float, *, progress: bool
) -> Path:
    address = origin.address(base)
    target = cache_directory() / name / file.name
    bar = tqdm.auto.tqdm(
        total=file.downloaded_bytes,
        desc=f"{name}/{file.name}",
        unit="B",
        unit_scale=True,
        disable=not progress,
    )
    fetcher = pooch.HTTPDownloader(
        progressbar=bar,
        chunk_size=CHUNK,
        timeout=timeout,
        headers={"Accept-Encoding": "identity"},  # so that a short transfer is noticed as such
    )
    try:
        with bar, _whole_or_nothing(target) as part:
            with part.open("xb") as stream:
                fetcher(address, stream, None)
            found = pooch.file_hash(str(part))
            if found != file.downloaded_sha256:
                cause = f"what came has sha256 {found}, pinned is {file.downloaded_sha256}"
                raise DownloadError(name, file.name, address, cause)
            if file.copy == "gzip":
                part.write_bytes(gzip.compress(part.read_bytes(), mtime=0))
    except DownloadError:
        raise
    except OSError as error:  # requests' exceptions are OSErrors too
        raise DownloadError(name, file.name, address, _cause(error, timeout)) from error
    return target


@contextmanager
def _whole_or_nothing(target: Path) -> Iterator[Path]:
    """Yield a temporary name beside the target, which takes its place only if nothing fails."""
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def _cause(error: OSError, timeout: float) -> str:
    """Say in words why a download failed."""
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
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"no space left in {cache_directory()}"
    return f"the file cannot be written ({error})"

"""Entries of the registry: files and hashes of each recording, its authors and addresses."""

import difflib
import json
import logging
import os
import re
import shlex
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePosixPath
from types import MappingProxyType, ModuleType
from typing import Any, final
from urllib.parse import quote

from robot_perception.checks import instance
from robot_perception.extras import needing
from studies.files import DamagedFile, reading, written

DATA_VARIABLE = "ROBOT_PERCEPTION_DATA"
SETS, REGISTRY = "sets.toml", "registry.txt"
ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tar.xz")
BOOK = Path(__file__).parent
NEEDED = ("title", "licence", "origin")
UNWRITABLE = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")
"""Characters that no line of a text file can hold: control characters and halves of pairs."""

log = logging.getLogger(__name__)


class UnknownDataset(LookupError):  # noqa: N818 - it names the thing, not the failure
    """A data set, or a file of one, that the registry does not list."""


@final
@dataclass(frozen=True, slots=True)
class DataFile:
    """One file of a data set.

    Parameters
    ----------
    name
        Its name in the data set's folder.
    sha256
        Its hash. A file that is stored as ``name.gz`` has that of its content.
    url
        Where it can be downloaded; ``None`` if nowhere with that hash for certain.
    """

    name: str
    sha256: str
    url: str | None = None


@final
@dataclass(frozen=True, slots=True)
class Dataset:
    """A folder of files that belong together.

    Parameters
    ----------
    name
        The folder's name.
    title
        What it is, in a line.
    licence
        In a few words.
    origin
        Who recorded it, how to cite it, and where the files were taken from.
    files
        Its files, or the one archive that holds them.
    bytes
        Size of the registered files, all together.
    note
        More on terms, and what was made from what.
    members
        Of an archive: how many files it holds; else 0.
    """

    name: str
    title: str
    licence: str
    origin: str
    files: tuple[DataFile, ...]
    bytes: int
    note: str = ""
    members: int = 0

    def file(self, name: str) -> DataFile:
        """Return the file of that name, with or without ``.gz``.

        Raises
        ------
        UnknownDataset
            If the data set has no such file.
        """
        plain = instance("name", name, str).removesuffix(".gz")
        for file in self.files:
            if file.name.removesuffix(".gz") == plain:
                return file
        names = [file.name for file in self.files]
        raise UnknownDataset(f"{self.name} has no file {name!r}; it has {some(names)}")


def some(names: list[str], most: int = 20) -> str:
    """Return names in a row, the first of many and their number."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[:3])}, … ({len(names)} files)"


def load_pooch() -> ModuleType:
    """Return pooch; the readers do without it."""
    with needing():
        import pooch
    return pooch


def data_directory() -> Path | None:
    """Return the directory named by ``ROBOT_PERCEPTION_DATA``, if that is set.

    Raises
    ------
    NotADirectoryError
        If it is set to something that is no directory.
    """
    directory = named_by(DATA_VARIABLE)
    if directory is not None and not directory.is_dir():
        raise NotADirectoryError(f"{DATA_VARIABLE} is {directory}, which is not a directory")
    return directory


def named_by(variable: str) -> Path | None:
    """Return the directory that a variable of the environment names, if that is set.

    Raises
    ------
    NotADirectoryError
        If it begins with the home of a user who is not known.
    """
    named = os.environ.get(variable, "")
    try:
        return Path(named).expanduser() if named else None
    except RuntimeError as error:
        raise NotADirectoryError(f"{variable} is {named}, whose home is not known") from error


def registry() -> Mapping[str, Dataset]:
    """Return all known data sets by name: the book's, then those of the reader's own registry.

    If the reader's own is not as it should be, a warning names its file, and only the book's are
    known.

    Raises
    ------
    ValueError
        If the book's registry is not as it should be; the message names file and data set.
    NotADirectoryError
        If ``ROBOT_PERCEPTION_DATA`` names no directory.
    """
    known = dict(_load(BOOK))
    own = data_directory()
    if own is not None:
        try:
            known |= _load(own)
        except DamagedFile as error:
            _warn(f"{error}: until that is mended only the book's data sets are known")
    return MappingProxyType(known)


@lru_cache
def _warn(text: str) -> None:
    """Say once what is wrong with a registry, which is read often."""
    log.warning(text)


def dataset(name: str) -> Dataset:
    """Return the data set of that name.

    Parameters
    ----------
    name
        As listed in the registry.

    Raises
    ------
    UnknownDataset
        If there is none; the message lists those there are.
    ValueError
        If there is none, and the reader's own registry, where it may stand, cannot be read.
    """
    known = registry()
    if instance("name", name, str) in known:
        return known[name]
    own = data_directory()
    if own is not None:
        _load(own)
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise UnknownDataset(f"no data set {name!r}{hint} (known: {', '.join(known)})")


def add_dataset(
    folder: Path,
    *,
    title: str,
    licence: str,
    origin: str,
    note: str = "",
    url: str | None = None,
    to: Path | None = None,
) -> Dataset:
    """Add a folder to a registry: a line a file with its hash, and the table that says whose it is.

    What ends the writing leaves the registry as it was, or lines without a table, which nobody
    reads and the next attempt replaces.

    Parameters
    ----------
    folder
        The folder; its name becomes the data set's. Hidden files are left out.
    title, licence, origin, note
        As of `Dataset`.
    url
        Address below which the files can be downloaded under the same names, if they can.
    to
        Directory of the registry; without it, the one that ``ROBOT_PERCEPTION_DATA`` names.

    Raises
    ------
    ValueError
        If title, licence or origin is missing, the name is taken or no name for a data set, the
        folder is empty or not in the reader's own directory, there is no registry to add to, or a
        text or the name of a file cannot be written in one.
    """
    folder = Path(os.path.abspath(instance("folder", folder, str, os.PathLike)))
    if not folder.is_dir():
        raise ValueError(f"folder must be a directory, got {folder}")
    told = {"title": title, "licence": licence, "origin": origin}
    for word, text in (told | {"note": note, "url": "" if url is None else url}).items():
        _check_writable(word, instance(word, text, str).replace("\n", " "))
        if word in told and not text.strip():
            raise ValueError(f"{folder.name} has no {word}: a recording without one is not added")
    directory = data_directory() if to is None else Path(instance("to", to, str, os.PathLike))
    if directory is not None and not directory.is_dir():
        raise ValueError(f"to must be a directory, got {directory}")
    if directory is None:
        raise ValueError(f"no registry to add to: set {DATA_VARIABLE}, or name its directory")
    if to is None and not folder.parent.samefile(directory):
        raise ValueError(
            f"{folder} is not in {directory}: it would not be found; without to it must be"
        )
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", folder.name):
        raise ValueError(
            f"{folder.name!r} is no name for a data set: letters, digits, _ and - only"
        )
    if folder.name in registry() or folder.name in _load(directory):
        raise ValueError(f"there is a data set {folder.name!r} already")
    files = [
        (place, place.relative_to(folder))
        for place in sorted(folder.rglob("*"))
        if place.is_file() and not any(p.startswith(".") for p in place.relative_to(folder).parts)
    ]
    if not files:
        raise ValueError(f"{folder} holds no files")
    for _, name in files:
        _check_writable("the name of a file", name.as_posix())
        if "\\" in name.as_posix():
            raise ValueError(f"the name of a file must be without \\, got {name.as_posix()!r}")
    lines, size = [], 0
    for place, name in files:
        words = [f"{folder.name}/{name.as_posix()}", load_pooch().file_hash(str(place))]
        words += [f"{url.rstrip('/')}/{quote(name.as_posix())}"] if url else []
        lines.append(shlex.join(words))
        size += place.stat().st_size
    fields = told | ({"note": note} if note else {}) | {"bytes": size}
    table = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in fields.items()]
    _append(directory / REGISTRY, lines, without=(f"{folder.name}/",))
    _append(directory / SETS, [f"[{folder.name}]", *table])  # from now on the lines are read
    return _load(directory)[folder.name]


def _check_writable(name: str, text: str) -> None:
    """Raise ``ValueError`` if a text cannot stand on a line of a file."""
    if UNWRITABLE.search(text):
        raise ValueError(f"{name} must be without control characters, got {text!r}")


def _append(file: Path, lines: list[str], without: tuple[str, ...] = ()) -> None:
    """Append lines to a file; those before that begin in some way go."""
    before = file.read_text(encoding="utf-8").split("\n") if file.exists() else []
    kept = "\n".join(line for line in before if not line.lstrip("'").startswith(without))
    start = f"{kept.rstrip()}\n\n" if kept.strip() else ""
    with written(file) as beside:
        beside.write_text(start + "\n".join(lines) + "\n", encoding="utf-8")


def _load(directory: Path) -> Mapping[str, Dataset]:
    """Return the data sets of one registry; none if there is none."""
    files = [file for file in (directory / SETS, directory / REGISTRY) if file.exists()]
    if not files:
        return {}
    try:
        return _parse(directory, *((f.stat().st_mtime_ns, f.stat().st_size) for f in files))
    except OSError as error:
        raise DamagedFile(f"{directory}: the registry cannot be read: {error}") from error


@lru_cache(maxsize=8)
def _parse(directory: Path, *_stamps: tuple[int, int]) -> Mapping[str, Dataset]:
    shelf = load_pooch().create(path=directory, base_url="")
    with reading(directory / REGISTRY, "cannot be read"):
        shelf.load_registry(directory / REGISTRY)
    files: dict[str, list[DataFile]] = {}
    for place, sha256 in shelf.registry.items():
        folder, _, name = place.partition("/")
        inside = name and "\\" not in place and ".." not in PurePosixPath(place).parts
        if not inside or not re.fullmatch(r"[0-9a-f]{64}", sha256):
            raise DamagedFile(f"{directory / REGISTRY}: {place} is not FOLDER/FILE with its sha256")
        files.setdefault(folder, []).append(DataFile(name, sha256, shelf.urls.get(place)))
    with reading(directory / SETS, "cannot be read"):
        there = (directory / SETS).exists()  # not when the first `add_dataset` was killed
        sets = tomllib.loads((directory / SETS).read_text(encoding="utf-8")) if there else {}
    if without := sorted(files.keys() - sets.keys()):
        _warn(f"{directory / REGISTRY}: {', '.join(without)} left out, without a table in {SETS}")
    if empty := sorted(sets.keys() - files.keys()):
        raise DamagedFile(f"{directory / SETS}: {', '.join(empty)} without files in {REGISTRY}")
    with reading(directory / SETS, "cannot be read"):
        return {name: _dataset(directory, name, sets[name], tuple(files[name])) for name in sets}


def _dataset(
    directory: Path, name: str, table: Mapping[str, Any], files: tuple[DataFile, ...]
) -> Dataset:
    where = f"{directory / SETS}: {name}"
    for word in NEEDED:
        if not str(table.get(word, "")).strip():
            raise DamagedFile(f"{where} has no {word}")
    try:
        found = Dataset(name=name, files=files, **table)
    except TypeError as error:
        raise DamagedFile(f"{where}: {error}") from error
    if found.members and (len(files) != 1 or not files[0].name.endswith(ARCHIVES)):
        raise DamagedFile(f"{where} has members, so it must be one archive ({', '.join(ARCHIVES)})")
    return found

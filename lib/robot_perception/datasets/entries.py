"""What is known of each recording: files, hashes, where they come from, whose they are."""

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Literal, final
from urllib.parse import quote

GITHUB = "https://raw.githubusercontent.com"


class UnknownDataset(LookupError):  # noqa: N818 - it names the thing, not the failure
    """A data set, or a file of one, that the registry does not list."""


@final
@dataclass(frozen=True, slots=True)
class Origin:
    """The original of a file on GitHub, at a fixed commit.

    Parameters
    ----------
    repository
        ``owner/name``.
    commit
        Full commit hash.
    path
        Path inside the repository.
    """

    repository: str
    commit: str
    path: str

    def address(self, base: str = GITHUB) -> str:
        """Return the address of the original.

        Parameters
        ----------
        base
            Address of a server laid out like GitHub's for raw files.
        """
        return f"{base.rstrip('/')}/{quote(f'{self.repository}/{self.commit}/{self.path}')}"


@final
@dataclass(frozen=True, slots=True)
class DataFile:
    """One file of a data set.

    Parameters
    ----------
    name
        Its name in the data set's folder.
    sha256, bytes
        Of the file as it is stored in a data directory.
    copy
        What it is: the original ``as is``, the original compressed (``gzip``), or ``converted``.
    origin
        Where the original is pinned; ``None`` if it is not, and cannot be downloaded.
    made_from
        Of a converted file: what it was made from.
    content_sha256, content_bytes
        Of a ``.gz``: its uncompressed content.
    """

    name: str
    sha256: str
    bytes: int
    copy: Literal["as is", "gzip", "converted"]
    origin: Origin | None = None
    made_from: str = ""
    content_sha256: str | None = None
    content_bytes: int | None = None

    @property
    def plain_name(self) -> str:
        """The name without ``.gz``."""
        return self.name.removesuffix(".gz")

    @property
    def downloaded_sha256(self) -> str:
        """The hash of the original."""
        return self.content_sha256 if self.copy == "gzip" and self.content_sha256 else self.sha256

    @property
    def downloaded_bytes(self) -> int:
        """The size of the original."""
        return self.content_bytes if self.copy == "gzip" and self.content_bytes else self.bytes


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
    terms
        In full, file by file where they differ.
    citation
        How to cite it.
    files
        Its files.
    """

    name: str
    title: str
    licence: str
    terms: str
    citation: str
    files: tuple[DataFile, ...]

    def file(self, name: str) -> DataFile:
        """Return the file of that name, with or without ``.gz``.

        Raises
        ------
        UnknownDataset
            If the data set has no such file.
        """
        for file in self.files:
            if name in (file.name, file.plain_name):
                return file
        known = ", ".join(file.name for file in self.files)
        raise UnknownDataset(f"{self.name} has no file {name!r}; it has {known}")


@cache
def registry() -> Mapping[str, Dataset]:
    """Return all known data sets by name."""
    text = resources.files(__package__).joinpath("registry.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(text)
    return MappingProxyType({name: _dataset(name, entry) for name, entry in entries.items()})


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
    """
    known = registry()
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise UnknownDataset(f"no data set {name!r}{hint} (known: {', '.join(known)})")


def _dataset(name: str, entry: Mapping) -> Dataset:
    fields = {key: value for key, value in entry.items() if key != "files"}
    return Dataset(name=name, files=tuple(map(_file, entry["files"])), **fields)


def _file(entry: Mapping) -> DataFile:
    place = {key: entry[key] for key in ("repository", "commit", "path") if key in entry}
    fields = {key: value for key, value in entry.items() if key not in place}
    return DataFile(origin=Origin(**place) if place else None, **fields)

"""What is declared of a format: a good file, what it reads as, and damages with their words."""

import gzip
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from robot_perception.datasets import CorruptLog

Content = bytes | str | None
Change = Callable[[bytes], bytes]


@dataclass(frozen=True)
class Damage:
    """A damaged file and the error that names it.

    Parameters
    ----------
    content
        Of the damaged file, or a function of the good content; ``None`` if it is missing.
    words
        A pattern for what the error says behind the name of the file, with the line if it has one.
    file
        The damaged one, if it is another than that of the format.
    error
        The type of the error, if it is another than that of the format.
    of_folder
        Whether the error names the folder, where no file alone is wrong.
    """

    content: Content | Change
    words: str
    file: str = ""
    error: type[Exception] | None = None
    of_folder: bool = False


def lines_of(found: Any) -> int:
    """Return how many lines an account of a file counts."""
    return found.report.lines


def plain(words: list[bytes]) -> tuple[list[int], list[int]]:
    """Return the places of whole numbers, of which there are none, and of numbers in a line."""
    return [], [*range(len(words))]


@dataclass(frozen=True, eq=False)
class Format:
    """A format of files.

    Parameters
    ----------
    read
        Reads the file, or its folder if `whole`.
    files
        Content by name, the first one is the file that is damaged; or a function that writes them.
    reads
        What must be read, by its place in what the reader returns, such as ``robots.3.times``.
    damages
        By name.
    form
        ``keyed`` if each line begins with its kind, ``rows`` if all lines are alike, ``named`` if
        the first names the columns, ``text`` if its lines are not accounted for, ``bytes`` if it is
        no text, ``parts`` if nothing tells how long it was.
    file
        The file that is damaged, a pattern if its name is not known before.
    opens
        What the reader is given, if it is not the file: a place in the folder.
    words
        Of a line: the places of whole numbers, and those of numbers.
    error, empty, nothing, cut
        The type of the error, what it says of an empty file, what of a comment alone, and what of
        bytes that were cut off.
    count
        How many lines were read, or rows with the line of names.
    again
        Writes what was read to a file.
    accounts
        Whether `count` counts comments and blank lines as well.
    costs
        Whether it takes long to read one.
    atol
        By how much numbers may differ from those of `reads`.
    """

    read: Callable[[Path], Any]
    files: Mapping[str, bytes | str] | Callable[[Path], Any]
    reads: Mapping[str, Any]
    damages: Mapping[str, Damage] = field(default_factory=dict)
    form: str = "rows"
    file: str = ""
    opens: str | None = None
    words: Callable[[list[bytes]], tuple[list[int], list[int]]] | None = None
    error: type[Exception] = CorruptLog
    empty: str = "the file is empty"
    nothing: str = r"no \w+ line \(.*; read none; other kinds 1 #\)"
    cut: str = ""
    count: Callable[[Any], int] = lines_of
    again: Callable[[Path, Any], Any] | None = None
    accounts: bool = True
    costs: bool = False
    atol: float = 0.0

    @property
    def is_lined(self) -> bool:
        """Whether the reader accounts for every line, packed or not."""
        return self.form in ("keyed", "rows", "named")

    @property
    def name(self) -> str:
        """The file that is damaged."""
        return self.file or next(iter(self.files))

    @property
    def good(self) -> bytes:
        """The content of a good file."""
        return as_bytes(self.files[self.name])

    @cached_property
    def as_good(self) -> str:
        """Every number of a good file, and the account of it."""
        return self.outcome(self.good)

    @property
    def lines(self) -> list[bytes]:
        """The lines of a good file."""
        return self.good.removesuffix(b"\n").split(b"\n")

    def put(self, folder: Path, content: Content | Change = b"", file: str = "") -> Path:
        """Write good files, but one with other content; return that one."""
        if callable(self.files):
            self.files(folder)
        else:
            for name, text in self.files.items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(as_bytes(text))
        (place,) = folder.glob(file or self.name)
        if content is None:
            place.unlink()
        elif content != b"":
            place.write_bytes(
                content(place.read_bytes()) if callable(content) else as_bytes(content)
            )
        return place

    def opened(self, folder: Path, place: Path) -> Any:
        """Read the file, or what it is a part of."""
        return self.read(place if self.opens is None else folder / self.opens)

    def outcome(self, content: bytes, suffix: str = "") -> str:
        """Return every number that is read of a file of this content, and the account of it."""
        with TemporaryDirectory() as name:
            folder = Path(name)
            place = self.put(folder)
            place.unlink()
            place = place.with_name(place.name + suffix)
            place.write_bytes(content)
            found = self.opened(folder, place)
            with np.printoptions(threshold=10**9, floatmode="unique"):
                return repr(found).replace(name, "").replace(".gz", "")


def as_bytes(text: bytes | str) -> bytes:
    """Return a text as UTF-8."""
    return text.encode() if isinstance(text, str) else text


def joined(*lines: bytes | str) -> bytes:
    """Return lines as the content of a file."""
    return b"".join(as_bytes(line) + b"\n" for line in lines)


def packed(content: bytes) -> bytes:
    """Return content as gzip packs it."""
    return gzip.compress(content, mtime=0)


def damages(cases: Mapping[str, tuple[Any, ...]], **more: Any) -> dict[str, Damage]:
    """Return damages by name, of their content and the words of the error."""
    return {name: Damage(*case, **more) for name, case in cases.items()}


def listed(text: str) -> dict[str, tuple[str, str]]:
    r"""Return cases of lines ``name | content | words``; ``\n`` parts the lines of a content."""
    cells = (line.split(" | ") for line in text.strip().splitlines())
    return {name: (content.replace(r"\n", "\n"), words) for name, content, words in cells}


def table(text: str, head: str = "", **more: Any) -> dict[str, Damage]:
    """Return damages that `listed` reads, of files that begin with a line."""
    return {
        name: Damage(joined(*[head] * bool(head), *[content] * bool(content)), words, **more)
        for name, (content, words) in listed(text).items()
    }


def added(lines: list[bytes], cases: Mapping[str, tuple[bytes | str, str]]) -> dict[str, Damage]:
    """Return damages that are a line behind good ones."""
    number = len(lines) + 1
    return {
        name: Damage(joined(*lines, line), f", line {number}: .*{reason}")
        for name, (line, reason) in cases.items()
    }


def byte(place: int, value: int) -> Change:
    """Return what writes one byte over."""
    return lambda content: content[:place] + bytes([value]) + content[place + 1 :]


def without(pattern: bytes, put: bytes = b"") -> Change:
    """Return what writes something in place of a pattern, which must be there."""

    def change(content: bytes) -> bytes:
        assert re.search(pattern, content)
        return re.sub(pattern, put, content, count=1)

    return change

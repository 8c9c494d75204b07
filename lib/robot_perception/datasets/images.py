"""Sequences of pictures: in the order of their numbers, each read when it is asked for."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from itertools import compress, pairwise
from operator import not_
from pathlib import Path
from typing import final
from unicodedata import category

import numpy as np
from jaxtyping import UInt8

from robot_perception.checks import flag, instance, number, whole
from robot_perception.datasets.logs import as_path
from robot_perception.datasets.names import numbering
from robot_perception.datasets.pictures import READ, UNREAD, CorruptImage, read_image
from robot_perception.datasets.stamps import times_beside
from robot_perception.fields import checked

ENDINGS = (
    ".png",
    ".jpg",
    ".jpeg",
    ".bmp",
    ".tif",
    ".tiff",
    ".webp",
    ".ppm",
    ".pgm",
    ".pbm",
    ".gif",
)
"""Endings of the names of pictures, in small or in capital letters."""


@final
@dataclass(frozen=True, eq=False, slots=True)
class ImageSequence:
    """Pictures of one size in the order of their numbers, each read when it is asked for.

    Indexing with an integer or going through it reads pictures; a slice is a sequence.

    Parameters
    ----------
    paths
        The files, one at least.
    numbers
        A number for each, rising.
    colour
        Whether to keep the colours.
    times
        When each was taken, s, rising; none if their names do not tell.
    skipped
        Files that were beside them and are none of them.
    composed
        Whether a number is put together from several, so that its steps are uneven.
    remarks
        Sentences on where the times are from.

    Raises
    ------
    CorruptImage
        If the first picture cannot be read; on reading, also if another one cannot or has another
        size.
    ValueError
        If there is no file, the numbers or times are not as many, or they do not rise.
    """

    paths: tuple[Path, ...]
    numbers: tuple[int, ...]
    colour: bool = False
    times: tuple[float, ...] | None = None
    skipped: tuple[Path, ...] = ()
    composed: bool = False
    remarks: tuple[str, ...] = ()
    size: tuple[int, int] = field(init=False)
    """Width and height, px."""

    def __post_init__(self) -> None:
        kinds = {"paths": (str, Path), "numbers": (int,), "skipped": (str, Path), "remarks": (str,)}
        for name in kinds:
            for value in instance(name, getattr(self, name), tuple):
                instance(name, value, *kinds[name])
        flag("colour", self.colour)
        flag("composed", self.composed)
        if not self.paths or len(self.paths) != len(self.numbers):
            raise ValueError(
                "paths must be one at least, and as many as numbers,"
                f" got {len(self.paths)} and {len(self.numbers)}"
            )
        _check_rising("numbers", self.numbers)
        if self.times is not None:
            times = [number("times", time) for time in instance("times", self.times, tuple)]
            if len(times) != len(self.paths):
                raise ValueError(f"times must be {len(self.paths)} for paths, got {len(times)}")
            _check_rising("times", times)
        height, width = read_image(self.paths[0]).shape
        object.__setattr__(self, "size", (width, height))

    def __len__(self) -> int:
        return len(self.paths)

    def __getitem__(self, at: int | slice) -> "UInt8[np.ndarray, '...'] | ImageSequence":
        """Read one picture, or return a part of the sequence."""
        if isinstance(at, slice):
            times = self.times and self.times[at]
            kept = self.colour, times, self.skipped, self.composed, self.remarks
            return ImageSequence(self.paths[at], self.numbers[at], *kept)
        path = self.paths[whole("at", at)]
        picture = read_image(path, colour=self.colour)
        size = picture.shape[1::-1]
        if size != self.size:
            raise CorruptImage(
                f"{path}: {size[0]} x {size[1]} px, but {Path(self.paths[0]).name} has"
                f" {self.size[0]} x {self.size[1]}"
            )
        return picture

    def __iter__(self) -> Iterator[UInt8[np.ndarray, "..."]]:
        return (self[at] for at in range(len(self)))

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers that count the pictures: their own, from 0 where these count nothing."""
        return tuple(range(len(self.numbers))) if self.composed else self.numbers

    @property
    def gaps(self) -> tuple[range, ...]:
        """Numbers that are missing, where the step from one to the next is the usual one.

        None are told of numbers that are put together from several.
        """
        pairs = list(pairwise(self.numbers))
        if not pairs or self.composed:
            return ()
        step = sorted(b - a for a, b in pairs)[(len(pairs) - 1) // 2]
        missing = (range(a + step, b - step // 2, step) for a, b in pairs)
        return tuple(gap for gap in missing if gap)


def _check_rising(name: str, values: Iterable[float]) -> None:
    """Raise ``ValueError`` unless each value is above the one before."""
    wrong = next((pair for pair in pairwise(values) if pair[0] >= pair[1]), None)
    if wrong:
        raise ValueError(f"{name} must rise, got {wrong[0]} before {wrong[1]}")


def picture_files(
    folder: str | Path, pattern: str | None = None
) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Find the pictures in a folder by their names.

    What is hidden is no picture, such as the ``._1.png`` that macOS puts beside ``1.png``.

    Parameters
    ----------
    folder
        Where they are.
    pattern
        Which files they are, such as ``left*.jpg``, in small or in capital letters; if none is
        given, all that end as pictures do.

    Returns
    -------
    pictures
        Files, in the order of the alphabet.
    skipped
        What else is there and fits the pattern.

    Raises
    ------
    NotADirectoryError
        If there is no such folder.
    """
    folder = as_path(folder, "folder")
    if pattern is not None:
        pattern = instance("pattern", pattern, str)
        if not pattern or "/" in pattern or "**" in pattern:
            raise ValueError(f"pattern must be of names in the folder, got {pattern!r}")
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder}: there is no such folder")
    there = sorted(
        path
        for path in folder.iterdir()
        if pattern is None or fnmatchcase(path.name.lower(), pattern.lower())
    )
    fits = [
        not path.name.startswith(".")
        and path.is_file()
        and (pattern is not None or path.suffix.lower() in ENDINGS)
        for path in there
    ]
    return tuple(compress(there, fits)), tuple(compress(there, map(not_, fits)))


def gallery_files(
    folder: str | Path,
) -> tuple[dict[str, tuple[Path, ...]], tuple[Path, ...]]:
    """Find the pictures of several people, a folder for each that bears the person's name.

    What is hidden is nobody's folder and no picture.

    Parameters
    ----------
    folder
        Where the folders are.

    Returns
    -------
    people
        Files by name, both in the order of the alphabet.
    skipped
        What else is there.

    Raises
    ------
    CorruptImage
        If there is nobody, a folder has no picture, or its name holds line breaks or other control
        characters.
    NotADirectoryError
        If there is no such folder.
    """
    folder = as_path(folder, "folder")
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder}: there is no such folder")
    people: dict[str, tuple[Path, ...]] = {}
    skipped: list[Path] = []
    for person in sorted(folder.iterdir()):
        if person.name.startswith(".") or not person.is_dir():
            skipped.append(person)
            continue
        if {category(letter) for letter in person.name} & {"Cc", "Cs", "Zl", "Zp"}:
            raise CorruptImage(f"{folder}: {person.name!a} is no name that can be written")
        people[person.name], others = picture_files(person)
        skipped += others
        if not people[person.name]:
            raise CorruptImage(f"{person}: no file is a picture{_unread(others)}")
    if not people:
        raise CorruptImage(f"{folder}: the gallery needs a folder for each person")
    return people, tuple(skipped)


def read_images(
    folder: str | Path,
    pattern: str | None = None,
    *,
    colour: bool = False,
    allow_gaps: bool = False,
) -> ImageSequence:
    """Find the pictures of a sequence in a folder, in the order of the numbers in their names.

    The number that counts is the one that changes from name to name: whole or decimal, such as the
    time stamp 1305031102.175304 with six decimals, which then is counted in microseconds. If
    several change, the first counts first. Where the names tell no times, or only times of day, a
    file beside the pictures or their folder may, such as KITTI's ``times.txt``: see
    `stamps.times_beside`.

    Parameters
    ----------
    folder
        Where they are.
    pattern
        Which files they are, such as ``left*.jpg``, in small or in capital letters; if none is
        given, all that end as pictures do.
    colour
        Whether to keep the colours.
    allow_gaps
        Whether numbers may be missing; `ImageSequence.gaps` has them.

    Raises
    ------
    CorruptImage
        If no file fits, a name has no number, more numbers than the others or those of another
        file, numbers are missing, or the first picture cannot be read.
    NotADirectoryError
        If there is no such folder.
    """
    files, skipped = picture_files(folder, pattern)
    allow_gaps = flag("allow_gaps", allow_gaps)
    if not files:
        fits = f"fits pattern {pattern!r}" if pattern else f"is a picture{_unread(skipped)}"
        raise CorruptImage(f"{folder}: no file {fits}")
    found = numbering(files)
    paths, numbers, times, composed, dated = found
    told = times_beside(as_path(folder, "folder"), found) if dated or not times else None
    if told and told.times:
        times, skipped = told.times, tuple(path for path in skipped if path != told.path)
    remarks = (told.remark,) if told else ()
    sequence = ImageSequence(paths, numbers, colour, times, skipped, composed, remarks)
    if sequence.gaps and not allow_gaps:
        raise CorruptImage(
            f"{folder}: pictures between {numbers[0]} and {numbers[-1]} are missing:"
            f" {name_gaps(sequence.gaps)} ({count_gaps(sequence.gaps)} in all;"
            " allow_gaps=True reads the others)"
        )
    return sequence


def _unread(files: Iterable[Path]) -> str:
    """Return which formats that are not read files are in, as the end of a sentence."""
    forms = [UNREAD[file.suffix.lower()] for file in files if file.suffix.lower() in UNREAD]
    counts = ", ".join(f"{count} in {form}" for form, count in Counter(forms).items())
    return f" that is read, but {counts}; {READ}" if forms else ""


def name_gaps(gaps: tuple[range, ...]) -> str:
    """Return missing numbers in words, the first few of many gaps."""
    return first(str(gap[0]) if gap[0] == gap[-1] else f"{gap[0]} to {gap[-1]}" for gap in gaps)


def count_gaps(gaps: tuple[range, ...]) -> int:
    """Return how many numbers are missing."""
    return sum(map(_length, gaps))


def _length(gap: range) -> int:
    """Return how many numbers are missing, which may be more than Python's own `len` can say."""
    return (gap[-1] - gap[0]) // gap.step + 1


def first(numbers: Iterable[object], most: int = 8) -> str:
    """Return numbers in words, the first few of many."""
    words = list(map(str, numbers))
    return ", ".join(words[:most]) + (", …" if len(words) > most else "")


@final
@dataclass(frozen=True, eq=False, slots=True)
class StereoSequence:
    """Pairs of pictures, each read when it is asked for.

    Parameters
    ----------
    left, right
        Sequences with the same numbers and of one size.

    Raises
    ------
    CorruptImage
        If the sizes differ, or a number has only one picture.
    """

    left: ImageSequence
    right: ImageSequence

    def __post_init__(self) -> None:
        checked(self)
        alone = {
            name: sorted(set(ours.numbers) - set(others.numbers))
            for name, ours, others in (
                ("left", self.left, self.right),
                ("right", self.right, self.left),
            )
        }
        for name, numbers in alone.items():
            if numbers:
                folder = Path(getattr(self, name).paths[0]).parent
                raise CorruptImage(
                    f"{folder}: {len(numbers)} pictures of {name} have no partner: {first(numbers)}"
                )
        if self.left.size != self.right.size:
            raise CorruptImage(
                f"{self.right.paths[0]}: left and right must be of one size,"
                f" got {self.left.size} and {self.right.size}"
            )

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of the pairs."""
        return self.left.numbers

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        return self.left.size

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(
        self, at: int | slice
    ) -> "tuple[UInt8[np.ndarray, '...'], UInt8[np.ndarray, '...']] | StereoSequence":
        """Read one pair, or return a part of the sequence."""
        if isinstance(at, slice):
            return StereoSequence(self.left[at], self.right[at])
        return self.left[at], self.right[at]

    def __iter__(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        return zip(self.left, self.right, strict=True)

"""Pictures, one by one and in sequences: read when they are asked for, and none that is damaged."""

import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import final

import numpy as np
from jaxtyping import UInt8

from robot_perception.checks import flag, instance, whole
from robot_perception.datasets.logs import as_path
from robot_perception.extras import needing
from robot_perception.files import DamagedFile, reading

NUMBER = re.compile(r"(?<!\d)(\d{1,19})\D*\Z")  # nanoseconds since 1970 have 19 digits
FORMATS = ("PNG", "JPEG", "PPM", "BMP", "TIFF", "GIF", "WEBP")  # none starts another program
BYTES = ("1", "L", "LA", "P", "RGB", "RGBA")  # kinds of pictures that eight bits can show


class Content(io.BytesIO):
    """The copy of a file in memory, as errors of Pillow name it."""

    def __repr__(self) -> str:
        return ""


class CorruptImage(DamagedFile):
    """A picture, or a sequence of them, that cannot be used; the message names the file."""


def read_image(path: str | Path, *, colour: bool = False) -> UInt8[np.ndarray, "height width ..."]:
    """Read a picture, strictly: a damaged or truncated one is refused, not patched up with grey.

    Parameters
    ----------
    path
        The file: PNG, JPEG, PPM or PGM, BMP, TIFF, GIF or WebP.
    colour
        Whether to keep its colours.

    Returns
    -------
    (height, width) or (height, width, 3)
        Grey values, or red, green and blue.

    Raises
    ------
    CorruptImage
        If the file is empty, damaged, no picture, or one of more than eight bits.
    FileNotFoundError
        If there is no such file.
    """
    path, colour = as_path(path), flag("colour", colour)
    pillow = load_pillow()
    content = path.read_bytes()
    if not content:
        raise CorruptImage(f"{path}: the file is empty")
    with reading(path, "no picture, or a damaged one", CorruptImage):
        with pillow.open(Content(content), formats=FORMATS) as picture:
            picture.verify()  # checksums, of formats that have them; then it must be opened anew
        with pillow.open(Content(content), formats=FORMATS) as picture:
            if picture.mode in BYTES:
                return np.array(picture.convert("RGB" if colour else "L"))
    raise CorruptImage(f"{path}: a picture of kind {picture.mode}, not of eight bits")


def load_pillow() -> ModuleType:
    """Return Pillow's module of pictures; the other readers do without it."""
    with needing():
        from PIL import Image
    return Image


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

    Raises
    ------
    CorruptImage
        If the first picture cannot be read; on reading, also if another one cannot or has another
        size.
    ValueError
        If there is no file, or the numbers are not as many or do not rise.
    """

    paths: tuple[Path, ...]
    numbers: tuple[int, ...]
    colour: bool = False
    size: tuple[int, int] = field(init=False)
    """Width and height, px."""

    def __post_init__(self) -> None:
        for name, kinds in {"paths": (str, Path), "numbers": (int,)}.items():
            for value in instance(name, getattr(self, name), tuple):
                instance(name, value, *kinds)
        flag("colour", self.colour)
        if not self.paths or len(self.paths) != len(self.numbers):
            raise ValueError(
                "paths must be one at least, and as many as numbers,"
                f" got {len(self.paths)} and {len(self.numbers)}"
            )
        wrong = next((pair for pair in pairwise(self.numbers) if pair[0] >= pair[1]), None)
        if wrong:
            raise ValueError(f"numbers must rise, got {wrong[0]} before {wrong[1]}")
        height, width = read_image(self.paths[0]).shape
        object.__setattr__(self, "size", (width, height))

    def __len__(self) -> int:
        return len(self.paths)

    def __getitem__(self, at: int | slice) -> "UInt8[np.ndarray, '...'] | ImageSequence":
        """Read one picture, or return a part of the sequence."""
        if isinstance(at, slice):
            return ImageSequence(self.paths[at], self.numbers[at], self.colour)
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
    def gaps(self) -> tuple[range, ...]:
        """Numbers that are missing, where the step from one to the next is the usual one."""
        pairs = list(pairwise(self.numbers))
        if not pairs:
            return ()
        step = sorted(b - a for a, b in pairs)[(len(pairs) - 1) // 2]
        missing = (range(a + step, b - step // 2, step) for a, b in pairs)
        return tuple(gap for gap in missing if gap)


def read_images(
    folder: str | Path, pattern: str = "*.png", *, colour: bool = False, allow_gaps: bool = False
) -> ImageSequence:
    """Find the pictures of a sequence in a folder, by the last number in each file's name.

    Parameters
    ----------
    folder
        Where they are.
    pattern
        Which files they are, such as ``left*.jpg``.
    colour
        Whether to keep the colours.
    allow_gaps
        Whether numbers may be missing; `ImageSequence.gaps` has them.

    Raises
    ------
    CorruptImage
        If no file fits, a name has no number or that of another file, numbers are missing, or the
        first picture cannot be read.
    NotADirectoryError
        If there is no such folder.
    """
    folder, allow_gaps = as_path(folder, "folder"), flag("allow_gaps", allow_gaps)
    pattern = instance("pattern", pattern, str)
    if not pattern or "/" in pattern or "**" in pattern:
        raise ValueError(f"pattern must be of names in the folder, got {pattern!r}")
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder}: there is no such folder")
    files: dict[int, Path] = {}
    for path in sorted(folder.glob(pattern)):
        found = NUMBER.search(path.stem)
        if not found:
            raise CorruptImage(f"{path}: the name has no number")
        if (other := files.setdefault(int(found[1]), path)) != path:
            raise CorruptImage(f"{path}: has the number of {other.name}")
    if not files:
        raise CorruptImage(f"{folder}: no file fits pattern {pattern!r}")
    numbers = tuple(sorted(files))
    sequence = ImageSequence(tuple(files[number] for number in numbers), numbers, colour)
    if sequence.gaps and not allow_gaps:
        raise CorruptImage(
            f"{folder}: pictures between {numbers[0]} and {numbers[-1]} are missing:"
            f" {name_gaps(sequence.gaps)} ({sum(map(_length, sequence.gaps))} in all;"
            " allow_gaps=True reads the others)"
        )
    return sequence


def name_gaps(gaps: tuple[range, ...]) -> str:
    """Return missing numbers in words, the first few of many gaps."""
    return _first(str(gap[0]) if gap[0] == gap[-1] else f"{gap[0]} to {gap[-1]}" for gap in gaps)


def _length(gap: range) -> int:
    """Return how many numbers are missing, which may be more than Python's own `len` can say."""
    return (gap[-1] - gap[0]) // gap.step + 1


def _first(numbers: Iterable[object], most: int = 8) -> str:
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
        for name in ("left", "right"):
            instance(name, getattr(self, name), ImageSequence)
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
                    f"{folder}: {len(numbers)} pictures of {name} have no partner:"
                    f" {_first(numbers)}"
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

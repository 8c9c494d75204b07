"""One picture: turned as it was held, in eight bits, and none that is damaged."""

import io
import re
import struct
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
from jaxtyping import UInt8

from robot_perception.checks import flag
from robot_perception.datasets.logs import as_path
from robot_perception.extras import needing
from studies.files import DamagedFile, reading

FORMATS = ("PNG", "JPEG", "PPM", "BMP", "TIFF", "GIF", "WEBP")  # none starts another program
UNREAD = {  # by the endings of their names
    ".heic": "HEIC",
    ".heif": "HEIC",
    ".avif": "AVIF",
    ".jxl": "JPEG XL",
    ".jp2": "JPEG 2000",
    ".dng": "DNG",
    ".cr2": "CR2",
    ".nef": "NEF",
    ".arw": "ARW",
}
"""Formats of pictures that are named and not read."""
MARKS = {  # of their contents, and where these stand
    (4, b"ftypavi"): "AVIF",
    (4, b"ftyphe"): "HEIC",
    (4, b"ftypmif1"): "HEIC",
    (0, b"\0\0\0\x0cJXL "): "JPEG XL",
    (0, b"\0\0\0\x0cjP  "): "JPEG 2000",
}
BYTES = ("1", "L", "LA", "P", "PA", "RGB", "RGBA", "RGBX", "CMYK", "YCbCr")  # of eight bits
DEEP = ("I;16", "I;16B", "I;16L", "I;16N", "I")  # grey values of sixteen bits
LARGEST = 2**26
"""Most pixels of a picture or a frame: 8192 × 8192, some 200 MB in colour."""
TOO_MANY = f"more than the {LARGEST} px of the largest picture that is read"
ANIMATED = ("PNG", "GIF", "WEBP")  # other formats hold previews or pages beside a picture
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}  # by the colour type of a PNG
WHOLE = ((0, 0, 1, 1),)  # first column and row, steps
INTERLACED = (
    (0, 0, 8, 8),
    (4, 0, 8, 8),
    (0, 4, 4, 8),
    (2, 0, 4, 4),
    (0, 2, 2, 4),
    (1, 0, 2, 2),
    (0, 1, 1, 2),
)
READ = f"{', '.join(FORMATS[:-1])} and {FORMATS[-1]} are"
MARKER = re.compile(rb"\xff[^\0\xff\xd0-\xd7]")  # that ends the rows of a JPEG
ROWS = b"\x5a\xa5\x3c\x69\x96\xc3\x12\xed" * 8  # compressed pixels, whatever they show
MORE_ROWS = ROWS + b"".join(b"\xff" + bytes([restart]) + ROWS for restart in range(0xD0, 0xD8))


class Content(io.BytesIO):
    """The copy of a file in memory, as errors of Pillow name it."""

    def __repr__(self) -> str:
        return ""


class CorruptImage(DamagedFile):
    """A picture, a sequence of them or a film that cannot be used; the message names the file."""


def read_image(path: str | Path, *, colour: bool = False) -> UInt8[np.ndarray, "height width ..."]:
    """Read a picture, strictly: a damaged or truncated one is refused, not patched up with grey.

    It is turned as its EXIF data say that the camera was held. CMYK and palettes become red, green
    and blue; transparency is left out. Of sixteen bits the upper eight are taken, as OpenCV does. A
    picture of depths is none of grey values: it is told by its holes, 0 where nothing was measured
    and nothing from 1 to 255.

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
        If the file is empty, damaged, lacks rows, is no picture or an animated one, has more than
        2**26 pixels or more than sixteen bits a pixel, or holds depths.
    FileNotFoundError
        If there is no such file.
    """
    path, colour = as_path(path), flag("colour", colour)
    load_pillow()
    return decode(path, path.read_bytes(), colour=colour)


def decode(
    path: Path | str, content: bytes, *, colour: bool, may_be_depths: bool = True
) -> UInt8[np.ndarray, "..."]:
    """Return the picture that the bytes of a file hold, as strictly as `read_image`.

    Parameters
    ----------
    path
        The file, or where else the bytes come from, as errors name it.
    content
        The bytes.
    colour
        Whether to keep its colours.
    may_be_depths
        Whether sixteen bits may be depths, which a file does not tell, but what holds it may.

    Raises
    ------
    CorruptImage
        As of `read_image`.
    """
    if not content:
        raise CorruptImage(f"{path}: the file is empty")
    for (at, mark), form in MARKS.items():
        if content.startswith(mark, at):
            raise CorruptImage(f"{path}: a picture in {form}, which is not read; {READ}")
    with (
        reading(path, "no picture, or a damaged one", CorruptImage),
        warnings.catch_warnings(action="ignore"),  # what is not refused is read right
    ):
        with _opened(path, content) as picture:
            _check(path, picture)
            picture.verify()  # checksums, of formats that have them; then it must be opened anew
        found = _decoded(path, content, colour, may_be_depths)
        if _lacks_rows(path, content, found, colour):
            raise CorruptImage(f"{path}: a damaged picture: rows are missing")
    return found


def load_pillow() -> ModuleType:
    """Return Pillow's module of pictures; the other readers do without it."""
    with needing():
        from PIL import Image
    return Image


def _opened(path: Path | str, content: bytes):
    """Return Pillow's picture, of which the header is read, or raise before it asks for memory."""
    pillow = load_pillow()
    try:
        picture = pillow.open(Content(content), formats=FORMATS)
    except pillow.DecompressionBombError as error:  # twice what it warns of
        raise CorruptImage(f"{path}: {TOO_MANY} ({error})") from error
    if picture.width * picture.height > LARGEST:
        raise CorruptImage(f"{path}: {picture.width} x {picture.height} px: {TOO_MANY}")
    return picture


def _check(path: Path | str, picture) -> None:
    """Raise ``CorruptImage`` for what is no picture of ours."""
    if picture.format in ANIMATED and picture.n_frames > 1:
        raise CorruptImage(f"{path}: an animation of {picture.n_frames} pictures, not one picture")
    if picture.mode not in BYTES + DEEP:
        raise CorruptImage(
            f"{path}: a picture of kind {picture.mode}, not of eight or sixteen bits"
        )


def _decoded(
    path: Path | str, content: bytes, colour: bool, may_be_depths: bool = True
) -> np.ndarray:
    """Return the pixels of a picture, upright."""
    from PIL import ImageOps

    with _opened(path, content) as stored:
        picture = ImageOps.exif_transpose(stored)
    if picture.mode not in DEEP:
        return np.array(picture.convert("RGB" if colour else "L"))
    grey = _upper_bits(path, np.asarray(picture), may_be_depths)
    return np.repeat(grey[..., None], 3, axis=2) if colour else grey


def _upper_bits(path: Path | str, deep: np.ndarray, may_be_depths: bool) -> np.ndarray:
    """Return the upper eight of sixteen bits, unless they are depths."""
    if deep.min() < 0 or deep.max() >= 2**16:
        raise CorruptImage(f"{path}: a picture of more than sixteen bits")
    there = deep[deep > 0]
    holes = may_be_depths and 0 < there.size < deep.size and 255 < there.min() < there.max()
    if holes and (there % 256).any() and (there % 257).any():  # not eight bits made longer
        raise CorruptImage(
            f"{path}: a picture of depths ({there.size} of {deep.size} px are measured,"
            f" {there.min()} to {there.max()}), not of grey values"
        )
    return (deep >> 8).astype(np.uint8)


def _lacks_rows(path: Path | str, content: bytes, found: np.ndarray, colour: bool) -> bool:
    """Return whether a picture holds fewer rows than it says; Pillow makes up the others."""
    if content.startswith(b"\x89PNG"):
        return _png_lacks_rows(content)
    corners = (
        found[y, x] for y in (slice(4), slice(-4, None)) for x in (slice(4), slice(-4, None))
    )
    if not content.startswith(b"\xff\xd8") or all(np.ptp(at, axis=(0, 1)).any() for at in corners):
        return False  # what is made up in a JPEG is of one colour
    end = _end_of_rows(content)
    longer = _decoded(path, content[:end] + MORE_ROWS + content[end:], colour)
    return not np.array_equal(longer, found)  # of a whole one nobody reads more rows


def _end_of_rows(content: bytes) -> int:
    """Return where the compressed rows of a JPEG end."""
    at = end = 2
    while at + 4 <= len(content) and content[at + 1] != 0xD9:
        scan = content[at + 1] == 0xDA
        at += 2 + int.from_bytes(content[at + 2 : at + 4])
        if scan and (marker := MARKER.search(content, at)):
            at = end = marker.start()
    return end


def _png_lacks_rows(content: bytes) -> bool:
    """Return whether the compressed data of a PNG end before its last row."""
    width, height, depth, kind, _, _, interlaced = struct.unpack(">IIBBBBB", content[16:29])
    needed = 0
    for column, row, across, down in INTERLACED if interlaced else WHOLE:
        columns, rows = -((column - width) // across), -((row - height) // down)
        if columns > 0:
            needed += max(rows, 0) * (1 + -(-columns * depth * CHANNELS[kind] // 8))
    data = b"".join(body for name, body in _png_chunks(content) if name == b"IDAT")
    return len(zlib.decompressobj().decompress(data, needed)) < needed


def _png_chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the names and bodies of the parts of a PNG."""
    at = 8
    while at + 8 <= len(content):
        (size,) = struct.unpack(">I", content[at : at + 4])
        yield content[at + 4 : at + 8], content[at + 8 : at + 8 + size]
        at += 12 + size

"""How long a film says that its file is."""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

UNKNOWN = 0, 2**32 - 1  # sizes that stand where a recorder did not know one yet
BOXES = b"ftyp", b"styp", b"wide", b"free", b"skip", b"pnot"  # that an MP4 begins with
HEAVY = b"mdat", b"moov", b"moof"  # that hold its pictures and where they are
EBML = b"\x1a\x45\xdf\xa3"
JPEG, LAST = b"\xff\xd8", b"\xff\xd9"
ASF = bytes.fromhex("3026b2758e66cf11a6d900aa0062ce6c")
ASF_PROPERTIES = bytes.fromhex("a1dcab8c47a9cf118ee400c00c205365")


def missing_bytes(path: Path) -> int:
    """Return how many bytes a film lacks at its end.

    AVI, MP4 with its relatives, Matroska with WebM, and ASF with WMV say how long their parts are,
    and the pictures of an MJPEG stream have an end. Of others, of parts whose length was not known
    when they were written, and of whole films it is 0.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(16)
        if head[:4] == b"RIFF":
            ends = _riff(file, size)
        elif head[4:8] in BOXES + HEAVY:
            ends = _boxes(file, size)
        elif head[:4] == EBML:
            ends = _ebml(file)
        elif head == ASF:
            ends = _asf(file)
        elif head.startswith(JPEG):
            ends = _pictures(file, size)
        else:
            ends = iter(())
        return max(max(ends, default=0) - size, 0)


def _riff(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield the ends of the parts of an AVI, of which there are several beyond a gigabyte."""
    at = 0
    while at + 8 <= size:
        file.seek(at)
        head = file.read(8)
        length = int.from_bytes(head[4:], "little")
        if head[:4] != b"RIFF" or length in UNKNOWN:
            return
        at += 8 + length
        yield at


def _boxes(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield the ends of the heavy boxes of an MP4; one without a length goes on to the end."""
    at = 0
    while at + 16 <= size:
        file.seek(at)
        head = file.read(16)
        length = int.from_bytes(head[:4])
        if length == 1:
            length = int.from_bytes(head[8:])
        if length < 8:
            return
        at += length
        if head[4:8] in HEAVY:
            yield at


def _ebml(file: BinaryIO) -> Iterator[int]:
    """Yield the ends of the header and of the segment of a Matroska film."""
    at = 0
    for _ in range(2):
        file.seek(at + 4)
        first = file.read(1)
        if not first or not first[0]:
            return
        width = 9 - first[0].bit_length()
        length = int.from_bytes(first + file.read(width - 1)) & (most := 2 ** (7 * width) - 1)
        if length == most:  # not known when it was written
            return
        at += 4 + width + length
        yield at


def _asf(file: BinaryIO) -> Iterator[int]:
    """Yield the length that the header of an ASF film tells, unless it was broadcast."""
    file.seek(0)
    head = file.read(2**16)
    at = head.find(ASF_PROPERTIES)
    if at >= 0 and len(head) >= at + 92 and not head[at + 88] & 1:
        yield int.from_bytes(head[at + 40 : at + 48], "little")


def _pictures(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield an end beyond that of the file if the last picture of a stream has none."""
    file.seek(max(size - 2**12, 0))
    if not file.read().rstrip(b"\0\r\n").endswith(LAST):
        yield size + len(LAST)

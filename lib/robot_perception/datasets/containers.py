"""Header of a film: the length of its file, and whether it counts its pictures."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

UNKNOWN = 0, 2**32 - 1  # sizes that stand where a recorder did not know one yet
BOXES = b"ftyp", b"styp", b"wide", b"free", b"skip", b"pnot"  # that an MP4 begins with
HEAVY = b"mdat", b"moov", b"moof"  # that hold its pictures and where they are
EBML = b"\x1a\x45\xdf\xa3"
JPEG, LAST = b"\xff\xd8", b"\xff\xd9"
ASF = bytes.fromhex("3026b2758e66cf11a6d900aa0062ce6c")
FLV, FLV_SIZE = b"FLV", b"\0\x08filesize\0"  # what stands before the size, a double
LEAST_TRIM = 0.01  # s
MXF = b"\x06\x0e\x2b\x34"
ASF_PROPERTIES = bytes.fromhex("a1dcab8c47a9cf118ee400c00c205365")


def missing_bytes(path: Path) -> int:
    """Return how many bytes a film lacks at its end.

    AVI, MP4 with its relatives, Matroska with WebM, ASF with WMV, and FLV say how long their parts
    are, and the pictures of an MJPEG stream have an end. Of others, of parts whose length was not
    known when they were written, and of whole films it is 0.
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
        elif head.startswith(FLV):
            ends = _flv(file)
        elif head.startswith(JPEG):
            ends = _pictures(file, size)
        else:
            ends = iter(())
        return max(max(ends, default=0) - size, 0)


def counts_pictures(path: Path) -> bool:
    """Tell whether a film says how many pictures it holds.

    AVI, MXF, and MP4 with its relatives do, unless it is made of fragments or was trimmed by a list
    of what to show. Of others, as Matroska, WebM, FLV and WMV, what their readers tell is an
    estimate: how long they last, which not all know, times a rate, which may vary.
    """
    with path.open("rb") as file:
        head = file.read(16)
        if head[:4] == b"RIFF":
            return _avi_counts(head + file.read(2**16))
        if head[4:8] not in BOXES + HEAVY:
            return head.startswith(MXF)
        movie = _inside(file, 0, path.stat().st_size)
        return b"moof" not in movie and _mp4_counts(file, *movie.get(b"moov", [(0, 0)])[0])


def _avi_counts(head: bytes) -> bool:
    """Tell whether the header of an AVI says how many pictures its stream has."""
    at = head.find(b"strh")
    while at >= 0 and head[at + 8 : at + 12] != b"vids":
        at = head.find(b"strh", at + 4)
    return at >= 0 and int.from_bytes(head[at + 40 : at + 44], "little") not in UNKNOWN


def _mp4_counts(file: BinaryIO, start: int, end: int) -> bool:
    """Tell whether the description of an MP4 counts all pictures that it shows."""
    movie = _inside(file, start, end)
    if b"mvex" in movie or b"mvhd" not in movie:
        return False
    unit, _ = _clock(file, *movie[b"mvhd"][0])
    for track in movie.get(b"trak", []):
        parts = _inside(file, *track)
        media = _inside(file, *parts[b"mdia"][0]) if b"mdia" in parts else {}
        edits = _inside(file, *parts[b"edts"][0]) if b"edts" in parts else {}
        kind = _inside(file, *media[b"minf"][0]) if b"minf" in media else {}
        if b"vmhd" in kind and b"mdhd" in media and b"elst" in edits:
            tick, length = _clock(file, *media[b"mdhd"][0])
            if _shown(file, *edits[b"elst"][0]) / unit < length / tick - LEAST_TRIM:
                return False
    return True


def _inside(file: BinaryIO, start: int, end: int) -> dict[bytes, list[tuple[int, int]]]:
    """Return from where to where the boxes of each name reach that lie in a part of an MP4."""
    found: dict[bytes, list[tuple[int, int]]] = {}
    for name, at, behind in _parts(file, end, start):
        found.setdefault(name, []).append((at + 8, behind))
    return found


def _clock(file: BinaryIO, start: int, end: int) -> tuple[int, int]:
    """Return the ticks of a second, and those of a whole film or track, by its header."""
    file.seek(start)
    head = file.read(end - start).ljust(32, b"\0")
    wide = head[0] == 1
    ticks, length = (head[20:24], head[24:32]) if wide else (head[12:16], head[16:20])
    return max(int.from_bytes(ticks), 1), int.from_bytes(length)


def _shown(file: BinaryIO, start: int, end: int) -> int:
    """Return how many ticks of a track its list of edits shows."""
    file.seek(start)
    head = file.read(end - start)
    entry = ">Qqi" if head[:1] == b"\1" else ">Iii"
    body = head[8 : 8 + struct.calcsize(entry) * int.from_bytes(head[4:8])]
    whole = len(body) // struct.calcsize(entry) * struct.calcsize(entry)
    return sum(length for length, first, _ in struct.iter_unpack(entry, body[:whole]) if first >= 0)


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
    return (end for name, _, end in _parts(file, size) if name in HEAVY)


def _parts(file: BinaryIO, size: int, at: int = 0) -> Iterator[tuple[bytes, int, int]]:
    """Yield the names, the starts and the ends of the boxes of an MP4 whose length is told."""
    while at + 16 <= size:
        file.seek(at)
        head = file.read(16)
        length = int.from_bytes(head[:4])
        if length == 1:
            length = int.from_bytes(head[8:])
        if length < 8:
            return
        yield head[4:8], at, at + length
        at += length


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


def _flv(file: BinaryIO) -> Iterator[int]:
    """Yield the length that the header of an FLV film tells, if there is any."""
    file.seek(0)
    _, found, behind = file.read(2**16).partition(FLV_SIZE)
    if found and (length := struct.unpack(">d", behind[:8].ljust(8, b"\0"))[0]) > 0:
        yield int(length)


def _pictures(file: BinaryIO, size: int) -> Iterator[int]:
    """Yield an end beyond that of the file if the last picture of a stream has none."""
    file.seek(max(size - 2**12, 0))
    if not file.read().rstrip(b"\0\r\n").endswith(LAST):
        yield size + len(LAST)

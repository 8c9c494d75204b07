"""Films in containers that say how long their file is, so that one that was cut is refused."""

import struct
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import pytest

from robot_perception.datasets import CorruptImage, read_film
from tests.datasets.formats.declared import Format, damages

NOISE = np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)
SMOOTH = cv2.normalize(cv2.GaussianBlur(NOISE, (0, 0), 3), None, 0, 255, cv2.NORM_MINMAX)
MOVING = [np.roll(SMOOTH, k, axis=1) for k in range(40)]
WRITES = """mp4:mp4v m4v:mp4v mov:MJPG 3gp:mp4v avi:MJPG AVI:XVID mkv:mp4v webm:VP80 wmv:WMV2
asf:WMV2 flv:FLV1 swf:FLV1 mjpeg:MJPG mjpg:MJPG vob:MPG2 mpg:MPG1 m2v:MPG2 ts:MPG2 m2ts:MPG2
mxf:MPG2 y4m:I420"""
KINDS = dict(kind.split(":") for kind in WRITES.split())  # by the ending: what this OpenCV writes
COUNT = {"mp4", "m4v", "mov", "3gp", "avi", "AVI", "mxf"}  # say how many pictures they hold
TELL = COUNT - {"mxf"} | {"mkv", "webm", "wmv", "asf", "flv", "mjpeg", "mjpg"}  # whether cut


def rate(kind: str) -> float:
    """Return the pictures a second of the films here: what their standards allow."""
    return 25 if KINDS[kind].startswith("MPG") else 12.5


@lru_cache
def content(kind: str) -> bytes:
    """Return a film of forty pictures, or nothing where this OpenCV writes none of the kind."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"once.{kind}"
        code = cv2.VideoWriter_fourcc(*KINDS[kind])
        writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, rate(kind), (64, 48))
        if not writer.isOpened():
            return b""
        for frame in MOVING:
            writer.write(frame[..., ::-1])
        writer.release()
        return path.read_bytes()


def put(folder: Path, kind: str) -> None:
    """Write a film to a folder; skip the test where this OpenCV writes none of the kind."""
    if not content(kind):
        pytest.skip(f"this OpenCV writes no {kind}")
    (folder / f"film.{kind}").write_bytes(content(kind))


def shift(frame: np.ndarray) -> int:
    """Return by how many columns a picture was rolled."""
    grey = SMOOTH.mean(axis=2)
    apart = [np.abs(np.roll(grey, k, axis=1) - frame.mean(axis=2)).mean() for k in range(64)]
    return int(np.argmin(apart))


class Seen:
    """A film that was read to its end."""

    def __init__(self, path: Path) -> None:
        film = read_film(path)
        self.before = film.count, film.missing, film.finished
        self.shifts = [shift(frame) for frame in film]
        self.film, self.remarks = film, film.remarks
        self.more = next(film, None)
        self.steps = np.diff(film.times)[2 if path.suffix == ".m2v" else 0 :]


def seconds(kind: str) -> dict[str, object]:
    """Return what is known of the times of a film."""
    if kind in {"mjpeg", "mjpg"}:  # nothing in them tells
        return {"film.rate": None, "film.times": []}
    steps = np.full(37 if kind == "m2v" else 39, 1 / rate(kind))
    return {"film.rate": np.array(float(rate(kind))), "steps": steps}


PLAYLIST = "#EXTM3U\n#EXT-X-TARGETDURATION:10\n#EXTINF:10,\na.ts\n#EXT-X-ENDLIST\n"
NO_FILM, LIST = ": no film, or a damaged one", ": no film, .*: a text, such as a list"
BAD = {
    "mp4": {
        "a list": (PLAYLIST, LIST),
        "what macOS leaves": (b"\0\5\x16\7\0\2\0\0Mac OS X" + bytes(60), NO_FILM),
        "a head alone": (b"\0\0\0\x18ftypmp42" + bytes(12), NO_FILM),
    },
    "avi": {"nothing behind RIFF": (b"RIFF" + bytes(200), NO_FILM)},
    "webm": {"nothing behind EBML": (b"\x1a\x45\xdf\xa3" + bytes(40), NO_FILM)},
    "y4m": {
        "huge": (
            b"YUV4MPEG2 W16000 H16000 F25:1 C420\nFRAME\n" + bytes(99),
            ": frames of 256000000 px are more than",
        )
    },
}


def jpeg(frame: np.ndarray) -> bytes:
    return cv2.imencode(".jpg", frame[..., ::-1])[1].tobytes()


def chunk(name: bytes, inner: bytes) -> bytes:
    return name + struct.pack("<I", len(inner)) + inner + b"\0" * (len(inner) % 2)


def avi(pictures: list[bytes]) -> bytes:
    """Return an AVI of 10 pictures a second, made by hand."""
    n = len(pictures)
    avih = struct.pack("<14I", 100_000, 0, 0, 16, n, 0, 1, 0, 64, 48, 0, 0, 0, 0)
    told = 0, 0, 0, 0, 1, 10, 0, n, 0, 2**32 - 1, 0, 0, 0, 64, 48
    strh = b"vidsMJPG" + struct.pack("<IHHIIIIIIII4H", *told)
    strf = struct.pack("<IiiHH4sIiiII", 40, 64, 48, 1, 24, b"MJPG", 0, 0, 0, 0, 0)
    strl = chunk(b"LIST", b"strl" + chunk(b"strh", strh) + chunk(b"strf", strf))
    head = chunk(b"LIST", b"hdrl" + chunk(b"avih", avih) + strl)
    movi = chunk(b"LIST", b"movi" + b"".join(chunk(b"00dc", picture) for picture in pictures))
    return chunk(b"RIFF", b"AVI " + head + movi)


def with_picture(inner: bytes) -> bytes:
    """Return a film whose picture 21 is another."""
    return avi([jpeg(frame) for frame in MOVING[:20]] + [inner] + [jpeg(f) for f in MOVING[21:]])


NAMED = ": picture 21 is damaged, and others follow it"
BAD["avi"] |= {
    f"picture 21, {name}": (with_picture(inner), NAMED)
    for name, inner in {
        "nought": bytes(900),
        "cut": jpeg(SMOOTH)[:500],
        "small and cut": jpeg(SMOOTH[::2, ::2])[:300],
    }.items()
}
FORMATS = {
    f"film_{kind}": Format(
        Seen,
        partial(put, kind=kind),
        {
            "film.size": (64, 48),
            "before": (0, 0, False),
            "film.promised": 40 if kind in COUNT else None,
            "shifts": list(range(40)),
            "film.numbers": list(range(1, 41)),
            "film.count": 40,
            "film.missing": 0,
            "film.finished": True,
            "remarks": [],
            "more": None,
        }
        | seconds(kind),
        damages(BAD.get(kind, {})),
        form="bytes" if kind in TELL else "parts",
        file=f"film.{kind}",
        error=CorruptImage,
        empty=": no (whole )?film",
        cut=r": no whole film: it was cut, \d+",
        costs=True,
        atol=2e-3,
    )
    for kind in KINDS
}
LISTS = {
    "l.m3u8": PLAYLIST,
    "l.ffconcat": "ffconcat version 1.0\nfile a.ts\n",
    "l.sdp": "v=0\nc=IN IP4 127.0.0.1\nm=video 5004 RTP/AVP 96\n",
    "l.mpd": '<?xml version="1.0"?><MPD xmlns="urn:mpeg:dash:schema:mpd:2011"></MPD>',
    "l.m3u": "\ufeff#EXTM3U\nmüde.ts\n",
    "l.txt": "no film",
}

"""Pictures, whole and damaged, and pictures that are none of ours."""

import io
import struct
import zlib
from functools import partial

import cv2
import numpy as np
from PIL import Image

from robot_perception.datasets import CorruptImage, read_image
from tests.datasets.formats.declared import Damage, Format, damages
from tests.datasets.writing import encoded

RNG = np.random.default_rng(0)
SMOOTH = cv2.GaussianBlur(RNG.integers(0, 256, (44, 60, 3), dtype=np.uint8), (0, 0), 3)
COLOUR = cv2.normalize(SMOOTH, None, 0, 255, cv2.NORM_MINMAX)
GREY = COLOUR[..., 1].copy()

# Rows that are missing: files that promise more of them than they hold ----------------------------


def taller_png(content: bytearray, height: int) -> bytearray:
    """Let a PNG promise more rows, with right checksums."""
    struct.pack_into(">I", content, 20, height)
    struct.pack_into(">I", content, 29, zlib.crc32(content[12:29]))
    return content


def taller_jpeg(content: bytearray, height: int) -> bytearray:
    at = max(content.find(b"\xff\xc0"), content.find(b"\xff\xc2"))
    struct.pack_into(">H", content, at + 5, height)
    return content


def taller_gif(content: bytearray, height: int) -> bytearray:
    struct.pack_into("<H", content, 8, height)
    struct.pack_into("<H", content, content.find(b"\x2c", 13 + 768) + 7, height)
    return content


def taller_bmp(content: bytearray, height: int) -> bytearray:
    struct.pack_into("<i", content, 22, height)
    return content


def taller_webp(content: bytearray, height: int) -> bytearray:
    struct.pack_into("<H", content, content.find(b"\x9d\x01\x2a") + 5, height)
    return content


def taller_pgm(content: bytearray, height: int) -> bytearray:
    return content.replace(b"60 44", b"60 %d" % height)


def taller_tiff(content: bytearray, height: int) -> bytearray:
    (at,) = struct.unpack_from("<I", content, 4)
    (count,) = struct.unpack_from("<H", content, at)
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from("<HH", content, entry)
        if tag in (257, 278):  # length, rows in a strip
            struct.pack_into("<H" if kind == 3 else "<I", content, entry + 8, height)
    return content


KINDS = {  # what is stored, and how, and how its header is changed
    "png_grey": (GREY, "PNG", {}, taller_png),
    "png_colour": (COLOUR, "PNG", {}, taller_png),
    "png_bit": (GREY > 99, "PNG", {}, taller_png),
    "png_16": (GREY.astype(np.uint16), "PNG", {}, taller_png),
    "jpeg": (COLOUR, "JPEG", {}, taller_jpeg),
    "jpeg_grey": (GREY, "JPEG", {}, taller_jpeg),
    "jpeg_progressive": (COLOUR, "JPEG", {"progressive": True}, taller_jpeg),
    "jpeg_restarts": (COLOUR, "JPEG", {"restart_marker_rows": 1}, taller_jpeg),
    "gif": (GREY, "GIF", {}, taller_gif),
    "bmp": (GREY, "BMP", {}, taller_bmp),
    "webp": (COLOUR, "WEBP", {}, taller_webp),
    "pgm": (GREY, "PPM", {}, taller_pgm),
    "tiff": (GREY, "TIFF", {}, taller_tiff),
    "tiff_lzw": (GREY, "TIFF", {"compression": "tiff_lzw"}, taller_tiff),
    "tiff_deflate": (GREY, "TIFF", {"compression": "tiff_deflate"}, taller_tiff),
}
NO_PICTURE = "(no picture, or a|a) damaged"
READS = {"png_colour": COLOUR, "png_bit": 255 * (GREY > 99), "png_16": 0 * GREY}
"""Where it is not the grey picture, and not what Pillow makes of one with losses."""


def as_read(name: str, content: bytes) -> np.ndarray:
    """Return the pixels that must be read."""
    if name.startswith(("jpeg", "webp")):
        return np.asarray(Image.open(io.BytesIO(content)))
    return READS.get(name, GREY)


def rows_missing(change, height: int):
    """Return what lets a file promise more rows."""
    return lambda content: bytes(change(bytearray(content), height))


# What is no picture of ours -----------------------------------------------------------------------

DEPTH = RNG.integers(2500, 20000, (40, 60)).astype(np.uint16)  # 5000 a metre, as of TUM RGB-D
DEPTH[:, :7] = 0


def by_opencv(pixels: np.ndarray, ending: str) -> bytes:
    return cv2.imencode(ending, pixels)[1].tobytes()


def animated(kind: str) -> bytes:
    """Return an animation of five pictures."""
    frames = [Image.fromarray(np.roll(COLOUR, k, axis=0)) for k in range(5)]
    frames[0].save(file := io.BytesIO(), kind, save_all=True, append_images=frames[1:])
    return file.getvalue()


def huge_png() -> bytes:
    content = taller_png(bytearray(encoded(GREY)), 10_000)
    struct.pack_into(">I", content, 16, 17_000)
    return bytes(taller_png(content, 10_000))


def huge_gif() -> bytes:
    flat = bytearray(encoded(GREY, "GIF"))
    struct.pack_into("<HH", flat, 6, 65_000, 65_000)
    return bytes(flat)


OTHERS = {
    "gif": {
        "an animation": (animated("GIF"), ": an animation of 5 pictures, not one"),
        "huge": (huge_gif(), ": more than the 67108864"),
    },
    "webp": {"an animation": (animated("WEBP"), ": an animation of 5 pictures, not one")},
    "png_grey": {
        "an animation": (animated("PNG"), ": an animation of 5 pictures, not one"),
        "huge": (huge_png(), ": 17000 x 10000 px: more than the 67108864"),
        "a text": (b"not a picture", ": no picture, or a damaged one"),
    },
    "png_16": {
        "depths": (by_opencv(DEPTH, ".png"), r": a picture of depths \(2120 of 2400 px are"),
    },
    "tiff": {
        "metres": (
            by_opencv(DEPTH / np.float32(5000), ".tif"),
            ": a picture of kind F, not of eight or sixteen",
        ),
        "32 bits": (
            encoded(DEPTH.astype(np.int32) * 99, "TIFF"),
            ": a picture of more than sixteen bits",
        ),
    },
}

CHECKED = {  # pixels are whole in both, and the checksum of their data is not
    "a checksum": (
        lambda content: content[:-13] + bytes([content[-13] ^ 1]) + content[-12:],
        ": no picture, or a damaged one",
    ),
    "20 bytes less": (lambda content: content[:-20], ": no picture, or a damaged one"),
}
FORMATS = {
    f"image_{name}": Format(
        partial(read_image, colour=pixels.ndim == 3),
        {"a": encoded(pixels, kind, **how)},
        {"T": as_read(name, encoded(pixels, kind, **how)).T},
        {
            f"{height} rows": Damage(rows_missing(change, height), f": {NO_PICTURE}")
            for height in (64, 88, 400)
        }
        | damages(OTHERS.get(name, {}) | (CHECKED if kind == "PNG" else {})),
        form="bytes",
        error=CorruptImage,
        empty=": the file is empty",
    )
    for name, (pixels, kind, how, change) in KINDS.items()
}

"""8-bit images as WebP or PNG: one image, or a film of many."""

import hashlib
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from PIL import Image


def check_image(
    array: np.ndarray, *, channels: tuple[int, ...] = (3, 4), name: str = "array"
) -> np.ndarray:
    """Return the array unless it is not of type uint8 and shape (height, width[, channels])."""
    shape = np.shape(array)
    grey, coloured = len(shape) == 2, len(shape) == 3 and shape[2] in channels
    if getattr(array, "dtype", None) != np.uint8 or not (grey or coloured) or 0 in shape:
        kind = getattr(array, "dtype", type(array).__name__)
        expected = f"(height, width[, {' or '.join(map(str, channels))}])"
        raise ValueError(f"{name}: an image must be uint8 of shape {expected}, got {kind} {shape}")
    return array


REMEMBERED = 120
"""Encoded images that are kept in memory, since the states of an explorer share pictures."""

_encoded: dict[tuple, bytes] = {}


def to_webp(array: np.ndarray, *, effort: int = 4, lossless: bool = False) -> bytes:
    """Encode an 8-bit image as WebP, with an effort from 0 (fast) to 6 (small)."""
    check_image(array)
    return _remembered(array, "WEBP", quality=88, method=effort, lossless=lossless, exact=lossless)


def to_png(array: np.ndarray) -> bytes:
    """Encode an 8-bit image as PNG."""
    return _remembered(check_image(array), "PNG")


def _remembered(array: np.ndarray, kind: str, **options: Any) -> bytes:
    """Encode an image, or return what the same one was encoded to."""
    array = np.ascontiguousarray(array)
    key = hashlib.sha256(array).digest(), array.shape, kind, *options.values()
    data = _encoded.pop(key, None) or _saved(Image.fromarray(array), kind, **options)
    _encoded[key] = data  # the latest stands last
    if len(_encoded) > REMEMBERED:
        del _encoded[next(iter(_encoded))]
    return data


def to_animated_webp(frames: Sequence[np.ndarray], *, duration_ms: int) -> bytes:
    """Encode images of one size as a film in which a frame stores what has changed.

    Frames that look alike are stored as one that is shown as long as all of them.
    """
    first, *others = (Image.fromarray(np.ascontiguousarray(frame)) for frame in frames)
    return _saved(
        first,
        "WEBP",
        save_all=True,
        append_images=others,
        duration=duration_ms,
        loop=0,
        quality=80,
        method=4,
        minimize_size=True,
    )


def _saved(image: Image.Image, kind: str, **options: Any) -> bytes:
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()

"""Writes synthetic recordings: what a logger would have written of known numbers."""

import gzip
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

RNG = np.random.default_rng(0)
GREY = RNG.integers(0, 256, (20, 30), dtype=np.uint8)
COLOUR = RNG.integers(0, 256, (20, 30, 3), dtype=np.uint8)


def save(path: Path, pixels: np.ndarray = GREY) -> Path:
    """Write a picture, and the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)
    return path


def folder(path: Path, numbers, name: str = "{:03}.png", pixels: np.ndarray = GREY) -> Path:
    """Write pictures with these numbers, each moved by its number of rows."""
    for number in numbers:
        save(path / name.format(number), np.roll(pixels, number, axis=0))
    return path


def encoded(pixels: np.ndarray, kind: str = "PNG", **how: Any) -> bytes:
    """Return a picture as a file holds it."""
    Image.fromarray(pixels).save(file := io.BytesIO(), kind, **how)
    return file.getvalue()


def row(values, label: bytes = b"") -> bytes:
    """Return numbers as a line that reads back exactly."""
    return label + b" ".join(repr(float(v)).encode() for v in np.ravel(values))


def flaser(readings, pose, odometry, time, host="host") -> bytes:
    """Return a FLASER line; numbers are written so that they read back exactly."""
    values = [*map(repr, map(float, readings)), *map(repr, map(float, [*pose, *odometry, time]))]
    return f"FLASER {len(readings)} {' '.join(values)} {host} {time!r}".encode()


def vertex(number, pose) -> bytes:
    return f"VERTEX2 {number} {' '.join(repr(float(v)) for v in pose)}".encode()


def robotlaser(readings, laser, robot, time, *, start=-1.5, resolution=0.5, remissions=()) -> bytes:
    head = f"ROBOTLASER1 0 {start} 3.0 {resolution} 50.0 0.1 0 {len(readings)}"
    values = [*map(repr, map(float, readings)), str(len(remissions)), *map(repr, remissions)]
    tail = [*map(repr, map(float, [*laser, *robot])), *["0.0"] * 5, repr(float(time)), "x", "0.5"]
    return " ".join([head, *values, *tail]).encode()


def edge(start, end, motion, information, keyword="EDGE2") -> bytes:
    values = " ".join(repr(float(v)) for v in [*motion, *information])
    return f"{keyword} {start} {end} {values}".encode()


def write(path: Path, lines: list[bytes], *, end: bytes = b"\n") -> Path:
    """Write lines to a file, compressed if it is called .gz."""
    content = b"".join(line + end for line in lines)
    path.write_bytes(gzip.compress(content) if path.suffix == ".gz" else content)
    return path


@dataclass(frozen=True, eq=False)
class Truth:
    """A log's numbers and its lines."""

    ranges: np.ndarray
    poses: np.ndarray
    odometry: np.ndarray
    times: np.ndarray
    lines: list[bytes]


def carmen_truth(scans: int = 4, beams: int = 180, seed: int = 0) -> Truth:
    """Return a valid log of random scans, all readings below 30 m."""
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.1, 29.0, (scans, beams)).round(2)
    poses, odometry = rng.normal(size=(2, scans, 3))
    times = 976052890.0 + np.arange(scans) + rng.uniform(0, 0.5, scans).round(6)
    lines = [
        flaser(*row) for row in zip(ranges.tolist(), poses, odometry, times.tolist(), strict=True)
    ]
    return Truth(ranges, poses, odometry, times, lines)

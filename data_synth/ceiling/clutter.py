"""Patches of a ceiling on cluttered grounds, where we know exactly where they lie."""

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth._kernels import kernel
from data_synth.ceiling._fixtures import PAINTERS, Stamp, lay

_SCALE = 80.0  # pixels for a metre, as a ceiling of 2.5 m is seen with a focal length of 200
_SHIFT = 4
_WIDE = ("luminaire", "vent", "sign", "hatch", "speaker", "spot", "detector")


def clutter(size: tuple[int, int], *, rng: np.random.Generator) -> np.ndarray:
    """Return a ground (rows, columns) of 8 bits that is full of things.

    Rectangles, discs, strokes and stripes of random greys, and fixtures as patches show them.

    Parameters
    ----------
    size
        Columns and rows.
    rng
        Source of what is where.
    """
    if not isinstance(size, tuple) or len(size) != 2:
        raise TypeError(f"size must be a pair, got {size!r:.60}")
    columns, rows = (whole("size", side, 8, 2048) for side in size)
    generator(rng)
    coarse = rng.uniform(60, 200, (4, 5)).astype(np.float32)
    ground = cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC)
    shares = np.array([PAINTERS[name][1] for name in PAINTERS])
    names = list(PAINTERS)
    for _ in range(max(12, columns * rows // 800)):
        at = (rng.uniform(0, columns), rng.uniform(0, rows))
        turn = rng.uniform(-np.pi, np.pi)
        if rng.random() < 0.25:
            stamp = PAINTERS[names[rng.choice(len(names), p=shares / shares.sum())]][0](rng)
            lay(ground, stamp, at, turn, _SCALE * rng.uniform(0.5, 1.3))
        else:
            lay(ground, _thing(rng), at, turn, _SCALE)
    ground += 3 * rng.standard_normal(ground.shape, dtype=np.float32)
    return np.rint(ground).clip(0, 255).astype(np.uint8)


def _thing(rng: np.random.Generator) -> Stamp:
    """Return a rectangle, a disc, a stroke, or a rectangle with stripes or cells."""
    style = rng.integers(5)
    greys = rng.uniform(20, 250, 3)
    length, width = rng.uniform(0.08, 0.8, 2)
    if style == 0:
        stamp = Stamp(length, width, greys[0])
        if rng.random() < 0.5:
            stamp.box(0, 0, 0.7 * length, 0.7 * width, greys[1])
    elif style == 1:
        across = min(length, width)
        stamp = Stamp(across, across, greys[0], is_round=True)
        stamp.disc(0, 0, rng.uniform(0.2, 0.45) * across, greys[1])
    elif style == 2:
        stamp = Stamp(3 * length, rng.uniform(0.015, 0.06), greys[0])
    else:
        stamp = Stamp(length, width, greys[0])
        pitch = rng.uniform(0.04, 0.12)
        for x in np.arange(pitch / 2, length, pitch) - length / 2:
            stamp.bar((x, -width / 2), (x, width / 2), 0.4 * pitch, greys[1])
        if style == 4:
            for y in np.arange(pitch / 2, width, pitch) - width / 2:
                stamp.bar((-length / 2, y), (length / 2, y), 0.4 * pitch, greys[2])
    return stamp


def patch(*, rng: np.random.Generator, side: int = 64) -> np.ndarray:
    """Return a picture (side, side) of a fixture and the ceiling round it, 8 bits.

    Parameters
    ----------
    rng
        Source of what it shows.
    side
        Of the picture, pixels.
    """
    generator(rng)
    whole("side", side, 16, 512)
    stamp = PAINTERS[_WIDE[rng.integers(len(_WIDE))]][0](rng)
    scale = side * rng.uniform(0.6, 0.8) / max(stamp.length, stamp.width)
    middle = (side - 1) / 2
    grain = rng.standard_normal((side, side), dtype=np.float32)
    ground = 186 + 3 * cv2.GaussianBlur(grain, (0, 0), 0.8)
    turn = rng.uniform(-np.pi, np.pi) if rng.random() < 0.3 else 0.0
    place = rng.uniform(-0.3, 0.3, 2) / scale * side  # of a crossing of joints, m
    for angle in (0.0, np.pi / 2):
        joint = Stamp(4 * side / scale, max(0.02, 1.0 / scale), 108)
        lay(ground, joint, (middle + place[0] * scale, middle + place[1] * scale), angle, scale)
    at = middle + rng.uniform(-0.03, 0.03, 2) * side
    lay(ground, stamp, (at[0], at[1]), turn, scale)
    return np.rint(ground).clip(0, 255).astype(np.uint8)


def grille_patch(*, rng: np.random.Generator, side: int = 64, pitch: float = 6.0) -> np.ndarray:
    """Return a picture (side, side) of a plain plate beside a fine grille, 8 bits.

    Some contours part two large regions of one grey each, others run between many stripes.

    Parameters
    ----------
    rng
        Source of what it shows.
    side
        Of the picture, pixels.
    pitch
        From stripe to stripe of the grille, in sixty-fourths of the side; a third more or less.
    """
    generator(rng)
    whole("side", side, 16, 512)
    number("pitch", pitch, 2.0, 16.0)
    grain = rng.standard_normal((side, side), dtype=np.float32)
    ground = 186 + 3 * cv2.GaussianBlur(grain, (0, 0), 0.8)
    scale, middle = side / 0.8, (side - 1) / 2  # pixels for a metre
    turn = rng.uniform(-np.pi, np.pi)
    along = np.array([np.cos(turn), np.sin(turn)])
    apart = rng.uniform(0.15, 0.17) * scale * along
    plate = Stamp(0.24, rng.uniform(0.35, 0.45), rng.uniform(40, 110))
    plate.box(0, 0, 0.12, rng.uniform(0.15, 0.25), rng.uniform(150, 240))
    lay(ground, plate, tuple(middle - apart), turn, scale)
    length, width = 0.26, rng.uniform(0.35, 0.45)
    grille, wide = Stamp(length, width, rng.uniform(180, 240)), 0.8 * pitch / 64
    wide *= rng.uniform(0.75, 1.33)
    for x in np.arange(wide / 2, length, wide) - length / 2:
        grille.bar((x, -width / 2), (x, width / 2), 0.5 * wide, rng.uniform(30, 90))
    lay(ground, grille, tuple(middle + apart), turn + rng.choice([0.0, np.pi / 2]), scale)
    return np.rint(ground).clip(0, 255).astype(np.uint8)


def superimpose(
    background: np.ndarray,
    patch: np.ndarray,
    state: np.ndarray,
    *,
    centre: tuple[float, float] | None = None,
) -> np.ndarray:
    """Return a picture with a patch laid over it, turned and scaled; the patch's edge is soft.

    What the patch shows at p, pixels from its centre, is found at (x, y) + s R(θ) p. The patch is
    read off by cubic convolution, which changes nothing where pixels fall on pixels; where it
    shrinks, over areas as much wider than a pixel of it as its new pixels are.

    Parameters
    ----------
    background, patch : (rows, columns)
        Grey values of 8 bits.
    state : (4,)
        x, y, θ and s: column and row of the centre, pixels, angle from columns to rows, rad, and
        scale.
    centre
        Column and row of the patch's centre; ``None`` for its middle.

    Raises
    ------
    ValueError
        If the scale is not from 0.02 to 50.
    """
    background, patch = _picture("background", background), _picture("patch", patch)
    x, y, angle, scale = array("state", state, (4,), 1e6)
    if not 0.02 <= scale <= 50:
        raise ValueError(f"state must have a scale from 0.02 to 50, got {scale:g}")
    if centre is None:
        centre = (patch.shape[1] - 1) / 2, (patch.shape[0] - 1) / 2
    elif not isinstance(centre, tuple) or len(centre) != 2:
        raise TypeError(f"centre must be a pair, got {centre!r:.60}")
    column, row = (number("centre", part, -1e4, 1e4) for part in centre)
    found = background.copy()
    wide = np.sqrt(max(1 / scale**2 - 1, 0.0))
    _superimpose(found, patch, x, y, np.cos(angle), np.sin(angle), scale, column, row, wide)
    return found


def _picture(name: str, value: np.ndarray) -> np.ndarray:
    instance(name, value, np.ndarray)
    if value.dtype != np.uint8:
        raise TypeError(f"{name} must be of 8 bits, got {value.dtype}")
    if value.ndim != 2 or not value.size:
        raise ValueError(f"{name} must be (rows, columns), got {value.shape}")
    return np.ascontiguousarray(value)


@kernel()
def _cubic(off):
    """Weights of four neighbours, the second ``off`` before the place."""
    off2, off3 = off * off, off * off * off
    return (
        -0.5 * off3 + off2 - 0.5 * off,
        1.5 * off3 - 2.5 * off2 + 1.0,
        -1.5 * off3 + 2.0 * off2 + 0.5 * off,
        0.5 * off3 - 0.5 * off2,
    )


@kernel()
def _read(patch, a, b):
    """Grey value at column a, row b, as if the edge went on."""
    rows, columns = patch.shape
    j, i = int(np.floor(a)), int(np.floor(b))
    across, down = _cubic(a - j), _cubic(b - i)
    total = 0.0
    for k in range(4):
        line = min(max(i - 1 + k, 0), rows - 1)
        for m in range(4):
            total += down[k] * across[m] * patch[line, min(max(j - 1 + m, 0), columns - 1)]
    return total


@kernel()
def _superimpose(found, patch, x, y, cos, sin, scale, column, row, wide):
    rows, columns = patch.shape
    fine = max(1, int(np.ceil(3 * wide)))
    left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
    for a in (-0.5 - column, columns - 0.5 - column):
        for b in (-0.5 - row, rows - 0.5 - row):
            at = x + scale * (cos * a - sin * b)
            left, right = min(left, at), max(right, at)
            at = y + scale * (sin * a + cos * b)
            top, bottom = min(top, at), max(bottom, at)
    first_row, last_row = max(top - 1, 0.0), min(bottom + 2, float(found.shape[0]))
    first_column, last_column = max(left - 1, 0.0), min(right + 2, float(found.shape[1]))
    for v in range(int(first_row), int(last_row)):
        for u in range(int(first_column), int(last_column)):
            east, south = (u - x) / scale, (v - y) / scale
            a = column + cos * east + sin * south
            b = row - sin * east + cos * south
            # of the pixel's own width, what lies inside along either axis
            share = min(max(scale * min(a + 0.5, columns - 0.5 - a) + 0.5, 0.0), 1.0)
            share *= min(max(scale * min(b + 0.5, rows - 0.5 - b) + 0.5, 0.0), 1.0)
            if share == 0:
                continue
            grey = 0.0
            for k in range(fine):
                for m in range(fine):
                    off = ((k + 0.5) / fine - 0.5) * wide
                    aside = ((m + 0.5) / fine - 0.5) * wide
                    grey += _read(patch, a + aside, b + off)
            grey /= fine * fine
            grey = found[v, u] + share * (grey - found[v, u])
            found[v, u] = int(min(max(grey + 0.5, 0.0), 255.0))

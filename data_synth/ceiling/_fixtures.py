"""Fixtures of a ceiling, painted four times finer than the ceiling and then laid on it.

A stamp is painted in the fixture's own frame, metres, its length along the first axis, and knows
which of its pixels it covers. Laying turns it, moves it and averages it over the ground's pixels.
"""

from collections.abc import Callable

import cv2
import numpy as np

__all__: tuple[str, ...] = ()  # for the worlds alone

FINE = 400  # pixels of a stamp, a metre
_SHIFT = 4  # bits behind the point in OpenCV's coordinates
_RIM = 0.5  # which OpenCV's soft edge adds to a radius, pixels
_SPREAD = 0.35  # deviation of the smoothing, pixels of the ground


class Stamp:
    """A fixture painted in its own frame.

    Parameters
    ----------
    length, width
        Of what it covers, m.
    grey
        Of its body.
    is_round
        Whether the body is the ellipse in the rectangle, not the rectangle; ``None`` for no body.
    """

    def __init__(
        self, length: float, width: float, grey: float, is_round: bool | None = False
    ) -> None:
        columns, rows = (int(np.ceil(side * FINE)) + 9 for side in (length, width))
        self.length, self.width = length, width
        self.greys = np.full((rows, columns), round(grey), dtype=np.uint8)
        self.cover = np.zeros((rows, columns), dtype=np.uint8)
        if is_round:
            self.disc(0, 0, length / 2, grey)
        elif is_round is not None:
            self.box(0, 0, length, width, grey)

    def _pixels(self, points: np.ndarray) -> np.ndarray:
        middle = (np.array(self.greys.shape[::-1]) - 1) / 2
        fine = np.asarray(points, dtype=float).reshape(-1, 2) * FINE + middle
        return np.rint(fine * 2**_SHIFT).astype(np.int32)

    def polygon(self, points: np.ndarray, grey: float) -> None:
        """Fill an outline (n, 2), m."""
        outline = [self._pixels(points)]
        cv2.fillPoly(self.greys, outline, round(grey), cv2.LINE_AA, _SHIFT)
        cv2.fillPoly(self.cover, outline, 255, cv2.LINE_AA, _SHIFT)

    def box(self, x: float, y: float, length: float, width: float, grey: float) -> None:
        """Fill a rectangle round a place, its length along the first axis, m."""
        half, high = length / 2, width / 2
        corners = [(-half, -high), (half, -high), (half, high), (-half, high)]
        self.polygon(np.array(corners) + np.array([x, y]), grey)

    def bar(
        self, start: tuple[float, float], end: tuple[float, float], width: float, grey: float
    ) -> None:
        """Fill a straight stroke with flat ends, m."""
        a, b = np.array(start), np.array(end)
        along = (b - a) / max(np.hypot(*(b - a)), 1e-9)
        side = np.array([-along[1], along[0]]) * width / 2
        self.polygon(np.array([a - side, b - side, b + side, a + side]), grey)

    def disc(self, x: float, y: float, radius: float, grey: float) -> None:
        """Fill a disc, m."""
        (at,), size = self._pixels(np.array([x, y])), radius * FINE - _RIM
        where, size = (int(at[0]), int(at[1])), round(max(size, 0.5) * 2**_SHIFT)
        cv2.circle(self.greys, where, size, round(grey), -1, cv2.LINE_AA, _SHIFT)
        cv2.circle(self.cover, where, size, 255, -1, cv2.LINE_AA, _SHIFT)


def lay(
    ground: np.ndarray, stamp: Stamp, at: tuple[float, float], angle: float, scale: float
) -> None:
    """Lay a stamp on a ground of 32-bit grey values; what reaches beyond is cut off.

    Parameters
    ----------
    ground : (rows, columns)
        Is written to.
    stamp
        The fixture.
    at
        Column and row of its middle.
    angle
        From the columns to its length, towards the rows, rad.
    scale
        Pixels of the ground for a metre.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    rows, columns = stamp.greys.shape
    half = np.array([columns, rows]) / 2 * scale / FINE
    reach = np.array(
        [abs(cos) * half[0] + abs(sin) * half[1], abs(sin) * half[0] + abs(cos) * half[1]]
    )
    low = np.floor(np.array(at) - reach - 2).astype(int)
    high = np.ceil(np.array(at) + reach + 3).astype(int)
    left, top = low.clip(0, ground.shape[::-1])
    right, bottom = high.clip((left, top), ground.shape[::-1])
    if right == left or bottom == top:
        return
    ratio = FINE / scale
    turned = np.array([[cos, sin], [-sin, cos]]) * ratio
    shift = turned @ (np.array([left, top]) - at) + (np.array([columns, rows]) - 1) / 2
    way = np.column_stack([turned, shift])
    flags, size = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, (int(right - left), int(bottom - top))
    spread = max(_SPREAD * ratio, 0.3)
    pad = int(2 * spread) + 1
    cover = cv2.copyMakeBorder(stamp.cover, pad, pad, pad, pad, cv2.BORDER_CONSTANT)
    cover = cv2.GaussianBlur(cover, (0, 0), spread)
    greys = cv2.GaussianBlur(stamp.greys, (0, 0), spread)
    share = cv2.warpAffine(cover, way + np.array([0, 0, pad]), size, flags=flags)
    paint = cv2.warpAffine(greys, way, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    part = ground[top:bottom, left:right]
    part += share * np.float32(1 / 255) * (paint - part)


def luminaire(rng: np.random.Generator) -> Stamp:
    """Return a lamp behind a louvre, a grid or a diffuser."""
    length, width = [(1.2, 0.6), (0.6, 0.6), (1.2, 0.3), (1.5, 0.15)][
        rng.choice(4, p=[0.3, 0.35, 0.25, 0.1])
    ]
    stamp = Stamp(length, width, rng.uniform(95, 140))
    rim = min(0.035, width / 6)
    long, wide = length - 2 * rim, width - 2 * rim
    stamp.box(0, 0, long, wide, 240)
    style = rng.integers(3)
    bands = max(1, round(wide / 0.18)) if style != 1 else 1
    for band in range(bands):  # a tube before its reflector
        y = (band + 0.5) / bands * wide - wide / 2
        stamp.box(0, y, long, wide / bands * 0.9, 214)
        stamp.box(0, y, long * 0.96, wide / bands * (0.35 if style != 1 else 0.75), 253)
        if band:
            edge = y - wide / bands / 2
            stamp.bar((-long / 2, edge), (long / 2, edge), 0.02, 150)
    if style == 0:
        blades = round(long / rng.uniform(0.09, 0.16))
        for x in (np.arange(1, blades) / blades - 0.5) * long:
            stamp.bar((x, -wide / 2), (x, wide / 2), 0.016, 128)
    elif style == 2:
        for x in np.arange(0.15, long - 0.05, 0.15) - long / 2:
            stamp.bar((x, -wide / 2), (x, wide / 2), 0.02, 165)
    else:
        stamp.bar((0, -wide / 2), (0, wide / 2), 0.02, 190)
    return stamp


def spot(rng: np.random.Generator) -> Stamp:
    """Return a round lamp with a ring."""
    across = rng.uniform(0.14, 0.3)
    stamp = Stamp(across, across, rng.uniform(60, 120), is_round=True)
    stamp.disc(0, 0, 0.4 * across, 205)
    stamp.disc(0, 0, 0.33 * across, 110 if rng.random() < 0.4 else 254)
    stamp.disc(0, 0, 0.2 * across, 254)
    return stamp


def vent(rng: np.random.Generator) -> Stamp:
    """Return a square or round outlet of air: slats, nested squares, a grid or blades."""
    side = [0.6, 0.45, 0.3][rng.choice(3, p=[0.55, 0.25, 0.2])]
    dark, light = rng.uniform(45, 80), rng.uniform(185, 215)
    style = rng.integers(4)
    stamp = Stamp(side, side, light)
    if style == 0:
        inner = side * 0.86
        stamp.box(0, 0, inner, inner, dark)
        slats = round(inner / 0.065)
        for y in ((np.arange(slats) + 0.5) / slats - 0.5) * inner:
            stamp.bar((-inner / 2, y), (inner / 2, y), 0.034, light - 15)
    elif style == 1:
        for k, size in enumerate(np.linspace(0.88, 0.16, 2 * max(3, round(side / 0.1)))):
            stamp.box(0, 0, side * size, side * size, light - 10 if k % 2 else dark)
        for way in (-1, 1):
            half = 0.44 * side
            stamp.bar((-half, -way * half), (half, way * half), 0.016, light)
    elif style == 2:
        inner = side * 0.84
        stamp.box(0, 0, inner, inner, dark + 15)
        cells = round(inner / 0.075)
        for at in (np.arange(1, cells) / cells - 0.5) * inner:
            stamp.bar((at, -inner / 2), (at, inner / 2), 0.02, light - 10)
            stamp.bar((-inner / 2, at), (inner / 2, at), 0.02, light - 10)
        stamp.box(0.25 * side, 0.25 * side, 0.2 * side, 0.2 * side, light - 10)
    else:
        stamp.disc(0, 0, 0.46 * side, light - 45)
        blades = int(rng.integers(9, 15))
        for turn in np.arange(blades) * 2 * np.pi / blades:
            ends = [
                (r * side * np.cos(turn + bent), r * side * np.sin(turn + bent))
                for r, bent in ((0.12, 0.0), (0.42, 0.25))
            ]
            stamp.bar(ends[0], ends[1], 0.05 * side, dark)
        stamp.disc(0, 0, 0.1 * side, light)
    return stamp


def detector(rng: np.random.Generator) -> Stamp:
    """Return a smoke detector: a disc, a ring and a dot."""
    across = rng.uniform(0.13, 0.18)
    stamp = Stamp(across, across, 120, is_round=True)
    stamp.disc(0, 0, 0.45 * across, 232)
    stamp.disc(0, 0, 0.3 * across, 95)
    stamp.disc(0, 0, 0.24 * across, 225)
    stamp.disc(0.36 * across, 0, 0.06 * across, 40)
    return stamp


def sign(rng: np.random.Generator) -> Stamp:
    """Return a sign: an arrow, a bar and some signs like letters, dark on light or otherwise."""
    width = rng.uniform(0.18, 0.26)
    length = width * rng.uniform(2.0, 2.6)
    ground, ink = (78, 240) if rng.random() < 0.6 else (235, 70)
    stamp = Stamp(length, width, ground)
    edge = 0.014
    for y in (-width / 2 + 0.02, width / 2 - 0.02):
        stamp.bar((-length / 2 + 0.02, y), (length / 2 - 0.02, y), edge, ink)
    way = rng.choice([-1, 1])
    tip, high = way * (length / 2 - 0.05), 0.28 * width
    stamp.polygon(
        np.array([(tip, 0), (tip - way * 1.3 * high, high), (tip - way * 1.3 * high, -high)]), ink
    )
    stamp.bar((tip - way * high, 0), (tip - way * 0.36 * length, 0), 0.2 * width, ink)
    pitch = 0.2 * width + 0.03
    for k in range(3):
        glyph(stamp, -way * (0.1 * length + k * pitch), 0, 0.2 * width, 0.5 * width, ink, rng)
    return stamp


def glyph(
    stamp: Stamp,
    x: float,
    y: float,
    wide: float,
    high: float,
    grey: float,
    rng: np.random.Generator,
) -> None:
    """Add a sign like a letter: some of the strokes of a block letter."""
    left, right, top, bottom = x - wide / 2, x + wide / 2, y - high / 2, y + high / 2
    strokes = [
        ((left, top), (left, bottom)),
        ((right, top), (right, bottom)),
        ((left, top), (right, top)),
        ((left, y), (right, y)),
        ((left, bottom), (right, bottom)),
        ((left, top), (right, bottom)),
    ]
    for k in rng.choice(6, 3, replace=False):
        stamp.bar(*strokes[k], 0.28 * wide, grey)


def hatch(rng: np.random.Generator) -> Stamp:
    """Return the door of an opening: a frame, a panel, hinges and a latch."""
    length, width = [(0.6, 0.6), (0.45, 0.45), (0.6, 0.4)][rng.integers(3)]
    stamp = Stamp(length, width, rng.uniform(110, 150))
    stamp.box(0, 0, length - 0.04, width - 0.04, 215)
    stamp.box(0, 0, length - 0.1, width - 0.1, 85)
    stamp.box(0, 0, length - 0.13, width - 0.13, rng.uniform(170, 200))
    for x in (-0.25, 0.25):
        stamp.box(x * length, -width / 2 + 0.05, 0.09, 0.05, 70)
    stamp.disc(0, width / 2 - 0.13, 0.03, 55)
    if rng.random() < 0.5:
        for k in range(3):
            glyph(stamp, (k - 1) * 0.08, 0, 0.05, 0.1, 90, rng)
    return stamp


def sprinkler(rng: np.random.Generator) -> Stamp:
    """Return a small disc with a star."""
    across = rng.uniform(0.09, 0.13)
    stamp = Stamp(across, across, 220, is_round=True)
    stamp.disc(0, 0, 0.36 * across, 65)
    for turn in np.arange(4) * np.pi / 2:
        end = (0.3 * across * np.cos(turn), 0.3 * across * np.sin(turn))
        stamp.bar((0, 0), end, 0.14 * across, 200)
    return stamp


def speaker(rng: np.random.Generator) -> Stamp:
    """Return a round plate with holes."""
    across = rng.uniform(0.2, 0.32)
    stamp = Stamp(across, across, 105, is_round=True)
    stamp.disc(0, 0, 0.46 * across, 212)
    for ring in range(1, 5):
        for turn in np.arange(6 * ring) * np.pi / (3 * ring):
            at = 0.095 * ring * across
            stamp.disc(at * np.cos(turn), at * np.sin(turn), 0.028 * across, 75)
    stamp.disc(0, 0, 0.03 * across, 75)
    return stamp


def pipe(rng: np.random.Generator) -> Stamp:
    """Return a long straight pair of pipes with brackets."""
    length, across = rng.uniform(2.0, 6.0), rng.uniform(0.05, 0.09)
    apart = across * rng.uniform(1.6, 2.2)
    stamp = Stamp(length, apart + 2 * across, 128, is_round=None)
    for y in (-apart / 2, apart / 2):
        stamp.box(0, y, length, across, 118)
        stamp.box(0, y - 0.1 * across, length, 0.5 * across, 205)
    for x in np.arange(0.4, length, 1.1) - length / 2:
        stamp.box(x, 0, 0.05, apart + 1.9 * across, 75)
    return stamp


def tray(rng: np.random.Generator) -> Stamp:
    """Return a long tray with rungs and cables."""
    length, width = rng.uniform(2.0, 5.0), rng.uniform(0.2, 0.3)
    stamp = Stamp(length, width, 92)
    for _ in range(3):
        y = rng.uniform(-0.3, 0.3) * width
        stamp.box(0, y, length, 0.02, rng.uniform(40, 210))
    for x in np.arange(0.15, length, 0.3) - length / 2:
        stamp.box(x, 0, 0.035, width, 176)
    for y in (-width / 2 + 0.0125, width / 2 - 0.0125):
        stamp.box(0, y, length, 0.025, 185)
    return stamp


PAINTERS: dict[str, tuple[Callable[[np.random.Generator], Stamp], float]] = {
    "luminaire": (luminaire, 0.24),
    "vent": (vent, 0.17),
    "spot": (spot, 0.12),
    "detector": (detector, 0.09),
    "sign": (sign, 0.08),
    "hatch": (hatch, 0.08),
    "sprinkler": (sprinkler, 0.06),
    "speaker": (speaker, 0.09),
    "pipe": (pipe, 0.04),
    "tray": (tray, 0.03),
}
"""Painter of each kind, and its share of the fixtures of a varied ceiling."""

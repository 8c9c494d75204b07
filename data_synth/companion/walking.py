"""Clothed people who stand, walk or raise an arm, seen from the front, the back or the side."""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np

from data_synth._checks import generator, instance, number, whole
from data_synth.coloured.filming import linear, one_of
from data_synth.companion.canvas import lay, tint
from data_synth.companion.faces import SPAN, FaceIdentity, FaceView, face_sprite, make_identity

__all__ = ["HIGH", "TALL", "WIDE", "Arm", "Clothes", "body_sprite", "make_clothes"]

TALL = 1.75
"""Height of a person, m."""
HIGH, WIDE = 2.3, 1.7
"""Height and width that a sprite covers, m; the feet stand on its lower edge, in the middle."""
PATTERNS = ("plain", "stripes", "checks", "halves")
"""Patterns of a shirt."""
VIEWS = ("front", "back", "side")
"""Sides from which a person is seen."""
_SHOULDER, _HIP, _HEAD = 1.45, 0.93, 1.595  # heights above the ground, m
_FINE = 2  # pixels are drawn so many times finer, and then averaged
_STEPS = 12  # phases of a gait that are drawn


@dataclass(frozen=True, slots=True)
class Clothes:
    """Clothes of a person.

    Parameters
    ----------
    shirt, other
        First and second colour of the shirt, as reflectances of red, green and blue.
    trousers, shoes
        Their colours, likewise.
    pattern
        Pattern of the shirt, one of `PATTERNS`; a plain one has the first colour only.
    """

    shirt: tuple[float, float, float]
    other: tuple[float, float, float]
    trousers: tuple[float, float, float]
    shoes: tuple[float, float, float] = (0.02, 0.02, 0.02)
    pattern: str = "plain"

    def __post_init__(self) -> None:
        for name in ("shirt", "other", "trousers", "shoes"):
            object.__setattr__(self, name, tint(name, getattr(self, name)))
        one_of("pattern", self.pattern, PATTERNS)


@dataclass(frozen=True, slots=True)
class Arm:
    """A raised arm.

    Parameters
    ----------
    side
        1 for the arm on the right as seen, -1 for that on the left.
    out, up
        Place of the wrist: sideways from the body's middle, and above the ground, m.
    """

    side: int = 1
    out: float = 0.36
    up: float = 1.70

    def __post_init__(self) -> None:
        if whole("side", self.side, -1, 1) == 0:
            raise ValueError("side must be 1 or -1, got 0")
        number("out", self.out, 0.0, 0.8)
        number("up", self.up, 0.6, 2.2)


def make_clothes(rng: np.random.Generator) -> Clothes:
    """Return random clothes."""
    generator(rng)
    hue = rng.uniform(0, 2 * np.pi)
    strong, bright = rng.uniform(0.05, 0.3), rng.uniform(0.25, 0.7)
    tint = bright + strong * np.cos(hue + 2 * np.pi / 3 * np.arange(3))
    other = np.clip(rng.uniform(0.15, 0.85) + rng.uniform(-0.15, 0.15, 3), 0.05, 0.9)
    trousers = rng.uniform(0.1, 0.45) + rng.uniform(-0.06, 0.06, 3)
    colours = (linear(c.clip(0.03, 0.95)) for c in (tint, other, trousers))
    shirt, other, trousers = (tuple(float(x) for x in c) for c in colours)
    return Clothes(shirt, other, trousers, pattern=str(rng.choice(PATTERNS)))


def body_sprite(
    clothes: Clothes,
    identity: FaceIdentity | None = None,
    *,
    phase: float = 0.0,
    walks: bool = True,
    view: str = "back",
    face: FaceView | None = None,
    arm: Arm | None = None,
    height: int = 260,
    light: float = 1.0,
) -> np.ndarray:
    """Return a sprite (h, w, 4) of a person: red, green and blue light, and cover.

    Parameters
    ----------
    clothes
        Clothes of the person.
    identity
        Whose head it is; always the same one if not given.
    phase
        Phase of the gait, rad; the nearest of twelve is drawn.
    walks
        Whether the person walks or stands.
    view
        Side from which the body is seen, one of `VIEWS`; from the side it walks to the right.
    face
        View of the head, with a light of its own; as the body is seen and lit if not given.
    arm
        A raised arm, without its hand; none if not given. It is not drawn from the side.
    height
        Height of the sprite, which stands for `HIGH` metres, 60 to 900 px.
    light
        Factor of the light on the body.
    """
    instance("clothes", clothes, Clothes)
    who = make_identity(np.random.default_rng(0), tone=1) if identity is None else identity
    instance("identity", who, FaceIdentity)
    one_of("view", view, VIEWS)
    instance("walks", walks, bool)
    for name, value, kind in (("face", face, FaceView), ("arm", arm, Arm)):
        if value is not None:
            instance(name, value, kind)
    height = whole("height", height, 60, 900)
    step = (
        round(number("phase", phase, -1e9, 1e9) / (2 * math.pi) * _STEPS) % _STEPS if walks else 0
    )
    return _drawn(clothes, who, step, view, face, arm, height, number("light", light, 0.0, 4.0))


@lru_cache(maxsize=96)
def _drawn(
    clothes: Clothes,
    who: FaceIdentity,
    step: int,
    view: str,
    face: FaceView | None,
    arm: Arm | None,
    height: int,
    light: float,
) -> np.ndarray:
    """Return the sprite of a person; it is kept, since a film draws the same ones many times."""
    scale = _FINE * height / HIGH
    size = round(scale * HIGH), round(scale * WIDE)
    figure = np.zeros((*size, 4), dtype=np.float32)
    swing = math.sin(2 * math.pi * step / _STEPS)
    paint = _Painter(figure, scale)
    if view == "side":
        _side(paint, clothes, who, swing)
    else:
        _upright(paint, clothes, who, swing, arm)
    figure[..., :3] *= light
    if face is None:
        yaw = {"front": 0.0, "back": math.pi, "side": 1.45}[view]
        face = FaceView(yaw=yaw, light=light)
    sprite = face_sprite(who, face, max(min(round(1.3 * _FINE * height * SPAN / HIGH), 400), 24))
    place = (size[1] - 1) / 2, size[0] - 1 - scale * (_HEAD + 0.012 * abs(swing))
    canvas = figure[..., :3] * figure[..., 3:]
    cover = lay(canvas, sprite, place, scale * SPAN)
    figure[..., 3] = np.maximum(figure[..., 3], cover)
    figure[..., :3] = canvas / np.maximum(figure[..., 3:], 1e-6)
    halved = cv2.resize(
        np.concatenate([figure[..., :3] * figure[..., 3:], figure[..., 3:]], axis=-1),
        (round(size[1] / _FINE), height),
        interpolation=cv2.INTER_AREA,
    )
    halved[..., :3] /= np.maximum(halved[..., 3:], 1e-6)
    halved.setflags(write=False)
    return halved


class _Painter:
    """Draws limbs and trunks in metres: x to the right of the middle, z above the ground."""

    def __init__(self, figure: np.ndarray, scale: float) -> None:
        self.figure, self.scale = figure, scale

    def _pixels(self, points: np.ndarray) -> np.ndarray:
        """Return the columns and rows of points (x, z)."""
        rows, columns = self.figure.shape[:2]
        u = (columns - 1) / 2 + self.scale * points[:, 0]
        return np.stack([u, rows - 1 - self.scale * points[:, 1]], axis=1)

    def trunk(self, outline: list[tuple[float, float]], colour: np.ndarray) -> None:
        """Fill an outline, darker towards its sides, so that it looks round."""
        self._fill([self._pixels(np.array(outline))], [], colour)

    def limb(
        self, points: list[tuple[float, float]], widths: list[float], colour: np.ndarray
    ) -> None:
        """Draw a limb of straight pieces with round ends; widths are given at its points, m."""
        places = self._pixels(np.array(points))
        pieces, ends = [], []
        for (a, b), (wa, wb) in zip(pairwise(places), pairwise(widths), strict=True):
            along = (b - a) / max(float(np.hypot(*(b - a))), 1e-6)
            aside = np.array([-along[1], along[0]]) * self.scale / 2
            pieces.append(
                np.array([a + aside * wa, b + aside * wb, b - aside * wb, a - aside * wa])
            )
            ends += [(a, self.scale * wa / 2), (b, self.scale * wb / 2)]
        self._fill(pieces, ends, np.asarray(colour, dtype=np.float32))

    def _fill(
        self, pieces: list[np.ndarray], ends: list[tuple[np.ndarray, float]], colour: np.ndarray
    ) -> None:
        """Fill polygons and discs, darker towards the left and right ends of each row."""
        most = max([radius for _, radius in ends], default=0.0) + 2
        every = np.concatenate(pieces)
        low = np.floor(every.min(axis=0) - most).astype(int).clip(0)
        high = np.ceil(every.max(axis=0) + most).astype(int) + 1
        high = np.minimum(high, self.figure.shape[1::-1])
        mask = np.zeros((high - low)[::-1].clip(1), dtype=np.uint8)
        for piece in pieces:
            cv2.fillPoly(mask, [np.rint(piece - low).astype(np.int32)], 1)
        for end, radius in ends:
            u, v = np.rint(end - low).astype(int).tolist()
            cv2.circle(mask, (u, v), max(round(radius), 1), 1, -1)
        inside = mask.astype(bool)
        filled = inside.any(axis=1)
        left = inside.argmax(axis=1)
        right = inside.shape[1] - 1 - inside[:, ::-1].argmax(axis=1)
        middle, half = (left + right) / 2, np.maximum((right - left) / 2, 1)
        across = (np.arange(inside.shape[1]) - middle[:, None]) / half[:, None]
        shade = (1.0 - 0.38 * across**2).astype(np.float32)[..., None]
        box = slice(low[1], high[1]), slice(low[0], high[0])
        if not filled.any() or self.figure[box].shape[:2] != inside.shape:
            return
        if colour.ndim == 3:
            colour = colour[box]
        part = self.figure[box]
        part[..., :3] = np.where(inside[..., None], colour * shade, part[..., :3])
        part[..., 3] = np.maximum(part[..., 3], inside)

    def cloth(self, clothes: Clothes) -> np.ndarray:
        """Return the shirt's colour at each pixel."""
        rows, columns = np.indices(self.figure.shape[:2], dtype=np.float32)
        x = (columns - self.figure.shape[1] / 2) / self.scale
        z = (self.figure.shape[0] - rows) / self.scale
        if clothes.pattern == "stripes":
            second = np.sin(2 * np.pi * z / 0.12) > 0.25
        elif clothes.pattern == "checks":
            second = (np.sin(2 * np.pi * x / 0.13) * np.sin(2 * np.pi * z / 0.13)) > 0
        elif clothes.pattern == "halves":
            second = z < 1.20
        else:
            second = np.zeros(x.shape, dtype=bool)
        pair = np.array([clothes.shirt, clothes.other], dtype=np.float32)
        return pair[second.astype(int)]


def _upright(paint: _Painter, clothes: Clothes, who: FaceIdentity, swing: float, arm) -> None:
    """Draw a person from the front or the back."""
    shirt = paint.cloth(clothes)
    for side in (-1, 1):
        lift = 0.10 * max(side * swing, 0.0)
        knee = (side * 0.095, 0.50 + 0.5 * lift)
        foot = (side * 0.10, 0.06 + lift)
        paint.limb([foot, (side * 0.105, 0.02 + lift)], [0.09, 0.10], np.array(clothes.shoes))
        paint.limb(
            [(side * 0.085, _HIP), knee, foot], [0.19, 0.15, 0.11], np.array(clothes.trousers)
        )
    for side in (-1, 1):
        if arm is None or arm.side != side:
            fore = 0.05 * side * swing
            hand = (side * 0.265, 0.83 + fore)
            paint.limb(
                [(side * 0.225, 1.40), (side * 0.262, 1.12), hand], [0.12, 0.10, 0.085], shirt
            )
            paint.limb([hand, (side * 0.262, 0.76 + fore)], [0.075, 0.07], np.array(who.skin) * 0.8)
    bob = 0.012 * abs(swing)
    paint.trunk(
        [(-0.06, 1.50 + bob), (-0.20, _SHOULDER), (-0.235, 1.36), (-0.175, 1.05), (-0.18, 0.90),
         (0.18, 0.90), (0.175, 1.05), (0.235, 1.36), (0.20, _SHOULDER), (0.06, 1.50 + bob)],
        shirt,
    )  # fmt: skip
    if arm is not None:
        shoulder, wrist = np.array([arm.side * 0.20, 1.39]), np.array([arm.side * arm.out, arm.up])
        gap = wrist - shoulder
        reach = min(float(np.hypot(*gap)), 0.55)
        bend = math.sqrt(max(0.28**2 - (reach / 2) ** 2, 0.0))
        aside = np.array([gap[1], -gap[0]]) / max(float(np.hypot(*gap)), 1e-6) * arm.side
        elbow = shoulder + gap / 2 + bend * aside
        paint.limb([tuple(shoulder), tuple(elbow), tuple(wrist)], [0.13, 0.105, 0.075], shirt)


def _side(paint: _Painter, clothes: Clothes, who: FaceIdentity, swing: float) -> None:
    """Draw a person from the side, walking to the right."""
    shirt = paint.cloth(clothes)
    for sign, dark in ((-1, 0.75), (1, 1.0)):
        angle = sign * 0.42 * swing
        knee = (0.42 * math.sin(angle), _HIP - 0.42 * math.cos(angle))
        lower = angle - 0.35 * max(-sign * swing, 0.0)
        foot = (knee[0] + 0.42 * math.sin(lower), knee[1] - 0.42 * math.cos(lower))
        paint.limb([foot, (foot[0] + 0.13, foot[1] - 0.03)], [0.09, 0.07], np.array(clothes.shoes))
        colour = np.array(clothes.trousers) * dark
        paint.limb([(0.0, _HIP), knee, foot], [0.19, 0.15, 0.11], colour)
        if sign < 0:
            _side_arm(paint, shirt * 0.8, who, -angle)
    paint.trunk(
        [(-0.05, 1.50), (-0.12, 1.42), (-0.13, 1.15), (-0.12, 0.90), (0.12, 0.90), (0.13, 1.15),
         (0.12, 1.42), (0.05, 1.50)],
        shirt,
    )  # fmt: skip
    _side_arm(paint, shirt * 0.9, who, -0.42 * swing)


def _side_arm(paint: _Painter, shirt: np.ndarray, who: FaceIdentity, angle: float) -> None:
    """Draw an arm from the side; its upper part swings by an angle, rad."""
    elbow = (0.29 * math.sin(angle), 1.40 - 0.29 * math.cos(angle))
    hand = (elbow[0] + 0.27 * math.sin(angle + 0.3), elbow[1] - 0.27 * math.cos(angle + 0.3))
    paint.limb([(0.0, 1.40), elbow, hand], [0.12, 0.10, 0.08], shirt)
    paint.limb([hand, (hand[0] + 0.02, hand[1] - 0.06)], [0.075, 0.07], np.array(who.skin) * 0.8)

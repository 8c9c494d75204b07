"""Hands: an open one that is raised, and others that are not; drawn from their bones.

A hand is a palm, a wrist and five fingers of three pieces each, which can spread, bend and turn.
Light falls from above; each piece is round, and a line of shadow divides it from the next.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth.coloured.filming import one_of
from data_synth.companion.canvas import lay, photograph, room, rows_and_columns, tint
from data_synth.companion.faces import face_sprite, make_identity
from data_synth.companion.skins import SKINS

__all__ = [
    "GESTURES",
    "HAND_BOX",
    "HandPose",
    "clutter_picture",
    "hand_sprite",
    "hand_window",
    "make_hand",
]

SPAN = 0.30
"""Height of a sprite, m; it is as wide as 0.8 of that."""
HAND_BOX = (0.5, 0.43, 0.70)
"""Middle (column, row) and side of the square round an open hand, as shares of the sprite's width,
height and height."""
GESTURES = ("open", "fist", "point", "two")
_FINE = 3
_ROOTS = ((-0.033, 0.045), (-0.011, 0.052), (0.012, 0.050), (0.033, 0.041))
_LENGTHS = (0.068, 0.078, 0.073, 0.058)
_FANS = (-0.16, -0.03, 0.09, 0.23)


@dataclass(frozen=True, slots=True)
class HandPose:
    """Pose of a hand, and its shape.

    Parameters
    ----------
    gesture
        ``"open"``, ``"fist"``, ``"point"`` (the first finger) or ``"two"``.
    spread
        How far the fingers are apart, 1 as usual.
    bends
        By how much each of the four fingers is bent, 0 to 1.
    thumb
        By which the thumb stands off, rad.
    slim
        Width of fingers and palm, 1 as usual.
    mirrored
        Whether it is the other hand.
    skin
        Light that the skin gives back.
    sleeve
        The same of the sleeve.
    lamp
        From where the light falls, rad from above.
    """

    gesture: str = "open"
    spread: float = 1.0
    bends: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    thumb: float = 0.75
    slim: float = 1.0
    mirrored: bool = False
    skin: tuple[float, float, float] = tuple(float(x) for x in SKINS[1])
    sleeve: tuple[float, float, float] = (0.2, 0.2, 0.3)
    lamp: float = 0.3

    def __post_init__(self) -> None:
        one_of("gesture", self.gesture, GESTURES)
        number("spread", self.spread, 0.0, 2.0)
        bends = array("bends", self.bends, (4,))
        if bends.min() < 0 or bends.max() > 1:
            raise ValueError(f"bends must be from 0 to 1, got {bends.tolist()}")
        instance("mirrored", self.mirrored, bool)
        for name in ("skin", "sleeve"):
            object.__setattr__(self, name, tint(name, getattr(self, name)))
        number("thumb", self.thumb, 0.0, 1.4)
        number("slim", self.slim, 0.6, 1.5)
        number("lamp", self.lamp, -3.2, 3.2)


def make_hand(
    rng: np.random.Generator, gesture: str = "open", *, tone: int | None = None
) -> HandPose:
    """Return somebody's hand.

    Parameters
    ----------
    rng
        Source of what it looks like and how it is held.
    gesture
        One of `GESTURES`.
    tone
        Which of `SKINS`; any of them if not given.
    """
    generator(rng)
    one_of("gesture", gesture, GESTURES)
    drawn = int(rng.integers(len(SKINS)))
    tone = drawn if tone is None else whole("tone", tone, 0, len(SKINS) - 1)
    skin = np.minimum(SKINS[tone] * rng.uniform(0.85, 1.1) * rng.uniform(0.96, 1.04, 3), 1.0)
    return HandPose(
        gesture,
        spread=float(rng.uniform(0.65, 1.35)),
        bends=tuple(float(x) for x in rng.uniform(0, 0.22, 4)),
        thumb=float(rng.uniform(0.55, 1.0)),
        slim=float(rng.uniform(0.85, 1.18)),
        mirrored=bool(rng.integers(2)),
        skin=tuple(float(x) for x in skin),
        sleeve=tuple(float(x) for x in rng.uniform(0.02, 0.6) * rng.uniform(0.6, 1.0, 3)),
        lamp=float(rng.uniform(-1.1, 1.1)),
    )


def hand_sprite(pose: HandPose | None = None, height: int = 96) -> np.ndarray:
    """Return a hand with its wrist (h, w, 4): light that comes back, and cover.

    Parameters
    ----------
    pose
        Whose, and how it is held; by default an open one.
    height
        Of the sprite, 24 to 300 pixels.
    """
    pose = HandPose() if pose is None else instance("pose", pose, HandPose)
    height = whole("height", height, 24, 300)
    fine = height * _FINE
    scale = fine / SPAN
    figure = np.zeros((fine, round(0.8 * fine), 4), dtype=np.float32)
    skin = np.array(pose.skin, dtype=np.float32)

    def pixels(points: np.ndarray) -> np.ndarray:
        """Return columns and rows of points in metres from the middle of the palm, upwards."""
        x = points[..., 0] * (-1 if pose.mirrored else 1)
        return np.stack(
            [figure.shape[1] / 2 + scale * x, fine * 0.60 - scale * points[..., 1]], axis=-1
        )

    def round_piece(points: list, widths: list, colour: np.ndarray, edge: float = 0.55) -> None:
        """Draw a piece with round ends, darker at its rim, over what is there."""
        mask = np.zeros(figure.shape[:2], dtype=np.uint8)
        places = pixels(np.array(points))
        for (a, b), (wa, wb) in zip(pairwise(places), pairwise(widths), strict=True):
            along = (b - a) / max(float(np.hypot(*(b - a))), 1e-6)
            aside = np.array([-along[1], along[0]]) * scale / 2
            quad = np.array([a + aside * wa, b + aside * wb, b - aside * wb, a - aside * wa])
            cv2.fillPoly(mask, [np.rint(quad).astype(np.int32)], 1)
        for end, wide in zip(places, widths, strict=True):
            u, v = np.rint(end).astype(int).tolist()
            cv2.circle(mask, (u, v), max(round(scale * wide / 2), 1), 1, -1)
        blend(mask, max(widths) / 2, colour, edge)

    def blend(mask: np.ndarray, half: float, colour: np.ndarray, edge: float) -> None:
        depth = cv2.distanceTransform(mask, cv2.DIST_L2, 3) / (scale * half)
        bulge = np.sqrt(np.clip(1 - (1 - np.clip(depth, 0, 1)) ** 2, 0, 1))
        du = cv2.Sobel(bulge.astype(np.float32), cv2.CV_32F, 1, 0, ksize=5) * scale * half / 120
        dv = cv2.Sobel(bulge.astype(np.float32), cv2.CV_32F, 0, 1, ksize=5) * scale * half / 120
        side = -(du * math.sin(pose.lamp) - dv * math.cos(pose.lamp))
        lit = np.clip(edge + (1 - edge) * bulge - 0.25 * np.clip(side, -1, 1), 0.15, 1.25)
        inside = mask.astype(bool)
        figure[inside, :3] = (colour * lit[..., None])[inside]
        figure[inside, 3] = 1

    slim = pose.slim
    round_piece([(0, -0.15), (0, -0.085)], [0.075, 0.070], np.array(pose.sleeve), 0.7)
    round_piece([(0, -0.09), (0, -0.035)], [0.050 * slim, 0.056 * slim], skin)
    palm = np.array(
        [(-0.042, 0.046), (-0.030, 0.054), (0.028, 0.053), (0.042, 0.040), (0.040, -0.02),
         (0.026, -0.045), (-0.026, -0.045), (-0.043, -0.005)]
    )  # fmt: skip
    palm[:, 0] *= slim
    mask = np.zeros(figure.shape[:2], dtype=np.uint8)
    cv2.fillPoly(mask, [np.rint(pixels(palm)).astype(np.int32)], 1)
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((9, 9), np.uint8))
    blend(mask, 0.03, skin, 0.72)
    up = {"open": (1, 1, 1, 1), "fist": (0, 0, 0, 0), "point": (1, 0, 0, 0), "two": (1, 1, 0, 0)}
    for k, (root, long, fan) in enumerate(zip(_ROOTS, _LENGTHS, _FANS, strict=True)):
        wide = (0.0195 if k < 3 else 0.0170) * slim
        root = (root[0] * slim, root[1])
        if not up[pose.gesture][k]:  # folded over the palm
            tip = (root[0], root[1] - 0.038)
            round_piece([root, tip], [1.15 * wide, 1.1 * wide], skin, 0.45)
            continue
        angle = fan * pose.spread
        parts = np.array([0.42, 0.32, 0.26]) * long * (1 - 0.55 * pose.bends[k])
        points, shades = [np.array(root)], [wide * 1.05]
        for j, part in enumerate(parts):
            turn = angle + 0.10 * pose.bends[k] * j
            points.append(points[-1] + part * np.array([math.sin(turn), math.cos(turn)]))
            shades.append(wide * (1.0 - 0.08 * (j + 1)))
        round_piece(points, shades, skin)
        for joint in points[1:-1]:  # creases
            across = np.array([math.cos(angle), -math.sin(angle)]) * wide * 0.38
            ends = np.rint(pixels(np.array([joint - across, joint + across]))).astype(np.int32)
            line = np.zeros(figure.shape[:2], dtype=np.uint8)
            cv2.line(line, ends[0].tolist(), ends[1].tolist(), 1, max(round(scale * 0.0016), 1))
            figure[line.astype(bool), :3] *= 0.72
    open_thumb = pose.gesture == "open"
    angle = -pose.thumb if open_thumb else 0.5
    start = np.array([-0.034 * slim, -0.022 if open_thumb else 0.0])
    middle = start + 0.042 * np.array([math.sin(angle), math.cos(angle)])
    tip = middle + 0.034 * np.array([math.sin(0.75 * angle), math.cos(0.75 * angle)])
    round_piece([start, middle, tip], [0.028 * slim, 0.023 * slim, 0.019 * slim], skin)
    for line in (
        ((-0.034, 0.018), (0.012, 0.030)),
        ((-0.030, 0.006), (0.026, 0.000)),
    ):  # the palm's
        if open_thumb:
            ends = np.rint(pixels(np.array(line) * [slim, 1])).astype(np.int32)
            drawn = np.zeros(figure.shape[:2], dtype=np.uint8)
            cv2.line(drawn, ends[0].tolist(), ends[1].tolist(), 1, max(round(scale * 0.002), 1))
            figure[drawn.astype(bool), :3] *= 0.8
    dense = np.concatenate([figure[..., :3] * figure[..., 3:], figure[..., 3:]], axis=-1)
    halved = cv2.resize(dense, (round(0.8 * height), height), interpolation=cv2.INTER_AREA)
    halved[..., :3] /= np.maximum(halved[..., 3:], 1e-6)
    return halved


def hand_window(
    rng: np.random.Generator,
    pose: HandPose,
    *,
    tilt: float = 0.0,
    size: int = 24,
    jitter: float = 0.04,
) -> np.ndarray:
    """Return grey values (size, size) of the square round a hand before a cluttered room.

    Parameters
    ----------
    rng
        Source of the room, the light, the framing and the noise.
    pose
        The hand.
    tilt
        By which it is turned clockwise as seen, rad.
    size
        Of the window, 8 to 128 pixels.
    jitter
        How far the window is off, as a share of its side, standard deviation.
    """
    generator(rng)
    instance("pose", pose, HandPose)
    tilt, size = number("tilt", tilt, -4.0, 4.0), whole("size", size, 8, 128)
    jitter = number("jitter", jitter, 0.0, 0.5)
    tall = 2.0 * size / HAND_BOX[2]  # twice as fine, as a camera nearby would see it
    canvas = room((round(1.5 * tall), round(1.5 * tall)), rng=rng, clutter=8)
    light = rng.uniform(0.6, 1.3)
    canvas *= np.float32(rng.uniform(0.6, 1.3))
    middle = (np.array(canvas.shape[1::-1]) - 1) / 2
    lay(canvas, hand_sprite(pose, 96), tuple(middle), tall, angle=tilt, light=light)
    image = cv2.cvtColor(photograph(canvas, rng=rng), cv2.COLOR_RGB2GRAY)
    off = np.array([0.0, (HAND_BOX[1] - 0.5) * tall])
    turned = np.array([off[0] * math.cos(tilt) - off[1] * math.sin(tilt),
                       off[0] * math.sin(tilt) + off[1] * math.cos(tilt)])  # fmt: skip
    side = HAND_BOX[2] * tall * (1 + rng.normal(0, jitter))
    corner = middle + turned - side / 2 + side * rng.normal(0, jitter, 2)
    scale = size / side
    frame = np.array([[scale, 0, -scale * corner[0] + (scale - 1) / 2],
                      [0, scale, -scale * corner[1] + (scale - 1) / 2]])  # fmt: skip
    small = cv2.GaussianBlur(image, (0, 0), 0.8)
    return cv2.warpAffine(small, frame, (size, size), borderMode=cv2.BORDER_REPLICATE)


def clutter_picture(
    rng: np.random.Generator, size: tuple[int, int] = (240, 320), *, people: float = 0.7
) -> np.ndarray:
    """Return a grey picture (rows, columns) of a room without an open hand.

    There are furniture, posters and books, at times faces, sleeves, and hands that are not open.

    Parameters
    ----------
    rng
        Source of everything.
    size
        Rows and columns.
    people
        Share of the pictures that have faces and other hands.
    """
    generator(rng)
    rows, columns = rows_and_columns("size", size, 32, 4096)
    people = number("people", people, 0.0, 1.0)
    canvas = room((rows, columns), rng=rng, clutter=int(rng.integers(6, 30)))
    if rng.uniform() < 0.4:  # many thin things: books, blinds, rails
        for _ in range(int(rng.integers(8, 40))):
            u, v = rng.uniform(0, columns), rng.uniform(0, rows)
            wide, high = rng.uniform(2, 9), rng.uniform(12, 70)
            tone = rng.uniform(0.02, 0.8) * rng.uniform(0.7, 1, 3)
            angle = rng.normal(0, 0.3)
            sprite = np.ones((24, max(round(24 * wide / high), 2), 4), dtype=np.float32)
            sprite[..., :3] = tone
            lay(canvas, sprite, (u, v), high, angle=angle)
    if rng.uniform() < people:
        for _ in range(int(rng.integers(1, 3))):
            tall = rng.uniform(50, 150)
            place = rng.uniform(0.1, 0.9) * columns, rng.uniform(0.2, 0.8) * rows
            lay(canvas, face_sprite(make_identity(rng), height=120), place, tall)
        for _ in range(int(rng.integers(0, 3))):
            pose = make_hand(rng, str(rng.choice(["fist", "point", "two"])))
            place = rng.uniform(0.1, 0.9) * columns, rng.uniform(0.1, 0.9) * rows
            tall, angle = rng.uniform(30, 110), rng.normal(0, 0.5)
            lay(canvas, hand_sprite(pose, 96), place, tall, angle=angle)
        if rng.uniform() < 0.4:  # an open hand, but upside down or on its side
            pose = replace(make_hand(rng), gesture="open")
            angle = rng.choice([-1, 1]) * rng.uniform(1.6, 3.1)
            place = rng.uniform(0.1, 0.9) * columns, rng.uniform(0.1, 0.9) * rows
            lay(canvas, hand_sprite(pose, 96), place, rng.uniform(40, 110), angle=angle)
    light = np.float32(rng.uniform(0.5, 1.3))
    return cv2.cvtColor(photograph(canvas * light, rng=rng), cv2.COLOR_RGB2GRAY)

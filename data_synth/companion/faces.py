"""Heads with faces, from any side: a surface that is shaped, painted and lit.

A head is an ellipsoid with a nose, brows, eye sockets, cheeks, lips and a chin, painted with skin,
hair, eyes and lips. It is turned, lit by a lamp and by ambient light, and projected in parallel, as
seen from afar. No face detector, and no face model that a detector uses, takes part in it.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth._kernels import kernel
from data_synth.coloured.filming import linear, one_of
from data_synth.companion.canvas import tint
from data_synth.companion.skins import SKINS

__all__ = ["FACE_BOX", "FaceIdentity", "FaceView", "face_sprite", "make_identity"]

SPAN = 0.34
"""Height of a sprite, m: from the shoulders to above the hair."""
WIDTH = 0.26
"""Width of a sprite, m."""
FACE_BOX = (0.5, 0.518, 0.52)
"""Square that a face detector would mark: its middle, as shares of the sprite's width and height,
and its side, as a share of the sprite's height."""
TURNED = 0.15
"""Shift of that square as the head turns by 90° to a side, as a share of the sprite's height."""
_AROUND, _UP = 330, 210  # points of the surface around the head, and from top to chin
_HALF_WIDTH, _HALF_HEIGHT, _HALF_DEPTH = 0.076, 0.118, 0.095  # semi-axes of the ellipsoid, m
_MIDDLE = 0.175  # of the head, below the upper edge of the sprite, m


@dataclass(frozen=True, slots=True)
class FaceIdentity:
    """Identity of a face: all that stays the same from view to view.

    Parameters
    ----------
    shape
        Sizes and places of the parts, in the order of `PARTS`, each in standard deviations from the
        mean face.
    skin
        Reflectance of the skin: shares of red, green and blue.
    hair
        Reflectance of hair, brows and beard.
    beard
        Density of the beard, 0 to 1.
    glasses
        Whether the face wears glasses.
    tone
        Number of the skin's tone in `SKINS`.
    """

    shape: tuple[float, ...]
    skin: tuple[float, float, float]
    hair: tuple[float, float, float]
    beard: float = 0.0
    glasses: bool = False
    tone: int = 0

    def __post_init__(self) -> None:
        shape = array("shape", self.shape, (None,), 4.0)
        if len(shape) != len(PARTS):
            raise ValueError(f"shape must be of {len(PARTS)} parts, got {len(shape)}")
        object.__setattr__(self, "shape", tuple(shape.tolist()))
        for name in ("skin", "hair"):
            object.__setattr__(self, name, tint(name, getattr(self, name)))
        instance("glasses", self.glasses, bool)
        number("beard", self.beard, 0.0, 1.0)
        whole("tone", self.tone, 0, len(SKINS) - 1)

    def part(self, name: str) -> float:
        """Return how many standard deviations a part, one of `PARTS`, is from the mean face."""
        one_of("name", name, PARTS)
        return self.shape[PARTS.index(name)]


PARTS = (
    "width", "height", "eyes apart", "eyes", "brows up", "brows thick", "nose wide", "nose long",
    "nose high", "mouth wide", "lips", "jaw", "cheeks", "hairline", "hair long", "mouth up",
)  # fmt: skip
"""Parts of a face that differ from person to person."""
_HAIRS = linear(
    np.array(
        [
            (0.12, 0.09, 0.08),
            (0.24, 0.16, 0.11),
            (0.40, 0.26, 0.15),
            (0.62, 0.49, 0.30),
            (0.55, 0.55, 0.55),
        ]
    )
)


@dataclass(frozen=True, slots=True)
class FaceView:
    """View of a head: its pose, its expression and the light.

    Parameters
    ----------
    yaw, pitch, roll
        Turns to its left, upwards, and clockwise as seen, rad; at yaw π the head is seen from
        behind.
    smile, opened, closed
        How far the mouth smiles, how far it is open, and how far the eyelids are closed: 0 to 1.
    azimuth, elevation
        Direction of the lamp, from that of the camera to the right as seen, and upwards, rad; it
        does not turn with the head.
    ambient
        Share of ambient light, 0 to 1; the rest comes from the lamp.
    light
        Factor of all light.
    """

    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    smile: float = 0.0
    opened: float = 0.0
    closed: float = 0.0
    azimuth: float = 0.0
    elevation: float = 0.5
    ambient: float = 0.55
    light: float = 1.0

    def __post_init__(self) -> None:
        for name in ("yaw", "pitch", "roll", "azimuth", "elevation"):
            number(name, getattr(self, name), -4.0, 4.0)
        for name in ("smile", "opened", "closed", "ambient"):
            number(name, getattr(self, name), 0.0, 1.0)
        number("light", self.light, 0.0, 4.0)


def make_identity(rng: np.random.Generator, *, tone: int | None = None) -> FaceIdentity:
    """Return a random identity.

    Parameters
    ----------
    rng
        Source of shape, colours, beard and glasses.
    tone
        Number of the skin's tone in `SKINS`; drawn if not given.
    """
    generator(rng)
    shape = tuple(rng.standard_normal(len(PARTS)).clip(-2.2, 2.2).tolist())
    drawn = int(rng.integers(len(SKINS)))
    tone = drawn if tone is None else whole("tone", tone, 0, len(SKINS) - 1)
    skin = np.minimum(SKINS[tone] * rng.uniform(0.88, 1.1) * rng.uniform(0.97, 1.03, 3), 1.0)
    hair = _HAIRS[rng.integers(2 if tone > 3 else len(_HAIRS))] * rng.uniform(0.7, 1.3)
    beard = float(rng.uniform(0.3, 0.9) if rng.uniform() < 0.25 else 0.0)
    glasses = bool(rng.uniform() < 0.2)
    return FaceIdentity(shape, tuple(skin.tolist()), tuple(hair.tolist()), beard, glasses, tone)


def face_sprite(
    identity: FaceIdentity, view: FaceView | None = None, height: int = 120
) -> np.ndarray:
    """Return a sprite (h, w, 4) of a head and its neck: red, green and blue light, and cover.

    Parameters
    ----------
    identity
        Whose head it is.
    view
        Its pose, expression and light; a default `FaceView`, from the front, if not given.
    height
        Height of the sprite, 24 to 400 px.
    """
    view = FaceView() if view is None else instance("view", view, FaceView)
    instance("identity", identity, FaceIdentity)
    height = whole("height", height, 24, 400)
    width = round(height * WIDTH / SPAN)
    points, paint, gloss = _head(identity, view.smile, view.opened, view.closed)
    turn = _turn(view)
    lamp = np.array([
        math.sin(view.azimuth) * math.cos(view.elevation),
        -math.sin(view.elevation),
        math.cos(view.azimuth) * math.cos(view.elevation),
    ])  # fmt: skip
    sprite = np.zeros((2 * height, 2 * width, 4), dtype=np.float32)  # twice as fine, then halved
    depth = np.full(sprite.shape[:2], -np.inf, dtype=np.float32)
    scale = 2 * height / SPAN
    _neck(sprite, np.array(identity.skin), scale, view.ambient)
    _splat(points, paint, gloss, turn, lamp, view.ambient, scale, width - 0.5, scale * _MIDDLE,
           sprite, depth)  # fmt: skip
    sprite[..., :3] *= view.light * sprite[..., 3:]
    halved = sprite.reshape(height, 2, width, 2, 4).mean(axis=(1, 3))
    halved[..., :3] /= np.maximum(halved[..., 3:], 1e-6)
    return halved


def face_square(u: float, v: float, tall: float, yaw: float = 0.0) -> np.ndarray:
    """Return the square round a face (4,): left, top, width and height, px.

    Parameters
    ----------
    u, v
        Column and row of the middle of the sprite, px.
    tall
        Height of the sprite, px.
    yaw
        Turn of the head to its left, rad; the square moves to the side to which the head looks.
    """
    u, v = u + TURNED * math.sin(yaw) * tall, v + (FACE_BOX[1] - 0.5) * tall
    return square((u, v), FACE_BOX[2] * tall)


def square(middle: tuple[float, float], side: float) -> np.ndarray:
    """Return a square round a point (4,): left, top, width and height, px."""
    return np.array([middle[0] - side / 2, middle[1] - side / 2, side, side])


def _turn(view: FaceView) -> np.ndarray:
    """Return the rotation of a head; x points to the right, y down, z towards the camera."""
    cy, sy = math.cos(view.yaw), math.sin(view.yaw)
    cp, sp = math.cos(view.pitch), math.sin(view.pitch)
    cr, sr = math.cos(view.roll), math.sin(view.roll)
    yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    pitch = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    roll = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return roll @ pitch @ yaw


def _bump(x: np.ndarray, y: np.ndarray, at: tuple, wide: float, high: float) -> np.ndarray:
    """Return a Gaussian bump about a point, 1 at its top."""
    return np.exp(-(((x - at[0]) / wide) ** 2) - ((y - at[1]) / high) ** 2)


@lru_cache(maxsize=64)  # 2 MB an entry
def _head(
    who: FaceIdentity, smile: float, opened: float, closed: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (rows, columns, 3) of the surface, m, their reflectance, and their gloss."""
    part = dict(zip(PARTS, who.shape, strict=True))
    around = np.linspace(-math.pi, math.pi, _AROUND, dtype=np.float32)
    up = np.linspace(-math.pi / 2, math.pi / 2, _UP, dtype=np.float32)[:, None]
    w, h = _HALF_WIDTH * (1 + 0.05 * part["width"]), _HALF_HEIGHT * (1 + 0.04 * part["height"])
    y = h * np.sin(up) * np.ones_like(around)
    x = w * np.cos(up) * np.sin(around)
    z = _HALF_DEPTH * np.cos(up) * np.cos(around)
    front = 1 / (1 + np.exp(-z / 0.008))  # 1 on the face, 0 behind
    low = np.clip(y / h, 0, 1)
    x = x * (1 + (0.10 + 0.07 * part["jaw"]) * low**2 - 0.22 * low**4)
    # places on the face, m from its middle: sideways, and downwards where named _y
    apart = 0.033 * (1 + 0.07 * part["eyes apart"])
    eye_y, eye = -0.018, 1 + 0.13 * part["eyes"]
    brow_y = eye_y - 0.019 * (1 + 0.12 * part["brows up"])
    nose_y = eye_y + 0.046 * (1 + 0.09 * part["nose long"])
    mouth_y = nose_y + 0.028 * (1 + 0.14 * part["mouth up"])
    nose_w = 0.0125 * (1 + 0.16 * part["nose wide"])
    mouth_w = 0.0245 * (1 + 0.11 * part["mouth wide"]) * (1 + 0.22 * smile)
    side = np.abs(x)
    corner = mouth_y - (0.010 * smile * (side / 0.03) ** 2)
    gap = 0.013 * opened
    bridge = np.exp(-((x / (0.5 * nose_w + 0.003)) ** 2))
    along = np.clip((y - eye_y + 0.012) / (nose_y - eye_y + 0.012), 0, 1) * (y < nose_y + 0.006)
    push = 0.020 * (1 + 0.15 * part["nose high"]) * bridge * along
    push += 0.008 * _bump(x, y, (0, nose_y), nose_w, 0.008)
    push += 0.004 * (_bump(side, y, (nose_w, nose_y + 0.001), 0.006, 0.006))
    push -= 0.011 * _bump(side, y, (apart, eye_y), 0.017, 0.012)  # sockets
    push += 0.005 * _bump(side, y, (apart, eye_y), 0.010, 0.007)  # eyeballs
    push += 0.005 * _bump(side, y, (0.9 * apart, brow_y), 0.02, 0.006)  # brows
    push += 0.006 * (1 + 0.5 * part["cheeks"]) * _bump(side, y, (0.045, 0.016), 0.018, 0.017)
    push += 0.005 * _bump(x, y, (0, corner), mouth_w, 0.011)
    push -= 0.003 * _bump(x, y, (0, mouth_y + 0.017), 0.02, 0.006)
    push += 0.007 * _bump(x, y, (0, mouth_y + 0.036), 0.018, 0.013)  # chin
    z = z + push * front
    points = np.stack([x, y, z], axis=-1).astype(np.float32)

    skin, hair = np.array(who.skin), np.array(who.hair)
    paint = np.broadcast_to(skin, points.shape).astype(np.float32).copy()

    def cover(share: np.ndarray, colour: np.ndarray) -> None:
        share = (share * front)[..., None]
        paint[:] = paint * (1 - share) + share * colour

    def soft(inside: np.ndarray, edge: float = 0.06) -> np.ndarray:
        """Return a smooth mask: 1 where a function is below 1, 0 where it is well above."""
        return 1 / (1 + np.exp(np.clip((inside - 1) / edge, -30, 30)))

    cover(0.30 * _bump(side, y, (apart, eye_y - 0.001), 0.019, 0.013), skin * 0.35)
    blush = 0.15 * _bump(side, y, (0.042, 0.022), 0.018, 0.016)
    cover(blush, skin * np.array([1.0, 0.72, 0.68]))
    if who.beard:
        jaw = soft(((side / 0.075) ** 2 + ((y - 0.066) / 0.042) ** 2), 0.15)
        jaw *= 1 - soft((x / mouth_w) ** 2 + ((y - mouth_y) / 0.009) ** 2, 0.2)
        moustache = soft((x / (1.2 * mouth_w)) ** 2 + ((y - mouth_y + 0.012) / 0.006) ** 2, 0.3)
        cover(who.beard * np.maximum(jaw, moustache), hair)
    lips = 0.0065 * (1 + 0.2 * part["lips"])
    red = skin * np.array([0.72, 0.42, 0.42])
    mouth = soft((x / mouth_w) ** 2 + ((y - corner) / (lips + gap)) ** 2, 0.15)
    cover(0.85 * mouth, red)
    cover(soft((x / mouth_w) ** 2 + ((y - corner) / (0.0016 + gap)) ** 2, 0.25), skin * 0.12)
    if opened > 0.3:
        teeth = soft((x / (0.7 * mouth_w)) ** 2 + ((y - corner + 0.6 * gap) / 0.004) ** 2, 0.2)
        cover(0.8 * teeth, np.array([0.6, 0.57, 0.5]))
    nostrils = soft(((side - 0.55 * nose_w) / 0.0042) ** 2 + ((y - nose_y - 0.006) / 0.003) ** 2)
    cover(0.8 * nostrils, skin * 0.15)
    open_ = 0.0062 * eye * (1 - 0.9 * closed)
    almond = ((side - apart) / (0.0145 * eye)) ** 2 + ((y - eye_y) / open_) ** 2
    cover(soft(almond, 0.1), np.array([0.30, 0.29, 0.28]))
    iris = ((side - apart) / 0.0062) ** 2 + ((y - eye_y) / 0.0062) ** 2
    cover(soft(iris, 0.1) * soft(almond, 0.1), np.array([0.03, 0.025, 0.02]))
    lid = np.exp(-(((almond - 1.15) / 0.35) ** 2)) * (y < eye_y + 0.002)
    cover(0.75 * lid, skin * 0.10)
    thick = 0.0036 * (1 + 0.3 * part["brows thick"])
    bow = brow_y + 3.0 * (side - apart) ** 2 / 0.02 * 0.12
    cover(0.85 * soft(((side - apart) / 0.0215) ** 2 + ((y - bow) / thick) ** 2, 0.3), hair)
    if who.glasses:
        rim = np.hypot((side - apart) / 0.0225, (y - eye_y - 0.002) / 0.0175)
        cover(0.9 * np.exp(-(((rim - 1) / 0.075) ** 2)), np.full(3, 0.03))
        over = (side < apart - 0.018) * np.exp(-(((y - eye_y + 0.003) / 0.0022) ** 2))
        cover(0.9 * over, np.full(3, 0.03))
    # hair lies on the head's top and back, and is thicker than skin
    line = -0.068 * (1 + 0.10 * part["hairline"]) + 0.030 * (side / w) ** 2 * (side > 0.02)
    long = 0.045 + 0.03 * part["hair long"]
    ear = np.clip((0.030 - z) / 0.02, 0, 1)
    is_hair = 1 / (1 + np.exp(np.clip((y - line) / 0.002, -30, 30)))
    is_hair = np.maximum(is_hair, ear / (1 + np.exp(np.clip((y - long) / 0.004, -30, 30))))
    streaks = 0.8 + 0.35 * np.sin(70 * around + 9 * up) * np.sin(41 * around - 14 * up)
    share = is_hair[..., None]
    paint[:] = paint * (1 - share) + share * hair * streaks[..., None]
    points *= 1 + (0.07 * is_hair)[..., None]
    # hollows get less ambient light
    paint *= np.clip(1 + 22 * np.minimum(push, 0) * front, 0.6, 1)[..., None]
    shiny = 0.05 + 0.09 * (_bump(x, y, (0, -0.05), 0.04, 0.02) + 0.7 * np.exp(-((x / 0.01) ** 2)))
    shiny += 0.05 * _bump(side, y, (0.045, 0.014), 0.02, 0.016)
    sockets = _bump(side, y, (apart, eye_y - 0.002), 0.02, 0.014)
    gloss = shiny * front * (1 - is_hair) * (1 - sockets) + 0.02 * is_hair
    for part_ in (points, paint, gloss):
        part_.setflags(write=False)
    return points, paint, gloss


@kernel()
def _neck(sprite, skin, scale, ambient):
    """Paint a neck below the head."""
    middle = (sprite.shape[1] - 1) / 2
    for row in range(int(scale * (_MIDDLE + 0.06)), sprite.shape[0]):
        below = row / scale - _MIDDLE
        half = scale * (0.043 + 1.3 * max(0.0, below - 0.128) ** 0.8 * 0.5)
        shade = 0.35 + 0.45 * min(max((below - 0.10) / 0.06, 0.0), 1.0)
        for column in range(sprite.shape[1]):
            away = abs(column - middle) / half
            if away < 1:
                lit = shade * (ambient + (1 - ambient) * np.sqrt(1 - away * away))
                sprite[row, column, :3] = skin * lit
                sprite[row, column, 3] = 1


@kernel()
def _splat(points, paint, gloss, turn, lamp, ambient, scale, middle, centre, sprite, depth):
    """Draw the surface: each small piece that faces the camera covers a few pixels.

    A depth buffer keeps the nearest piece at each pixel. The two differences between neighbours of
    a point, along its row and along its column, span its piece and give its normal.
    """
    rows, columns = points.shape[:2]
    halfway = np.sqrt(lamp[0] ** 2 + lamp[1] ** 2 + (lamp[2] + 1) ** 2) + 1e-9
    placed = np.empty((rows, columns, 3))
    for i in range(rows):
        for j in range(columns):
            for k in range(3):
                placed[i, j, k] = (
                    turn[k, 0] * points[i, j, 0]
                    + turn[k, 1] * points[i, j, 1]
                    + turn[k, 2] * points[i, j, 2]
                )
    for i in range(1, rows - 1):
        for j in range(columns - 1):
            before = j - 1 if j else columns - 2
            a0 = placed[i, j + 1, 0] - placed[i, before, 0]
            a1 = placed[i, j + 1, 1] - placed[i, before, 1]
            a2 = placed[i, j + 1, 2] - placed[i, before, 2]
            b0 = placed[i + 1, j, 0] - placed[i - 1, j, 0]
            b1 = placed[i + 1, j, 1] - placed[i - 1, j, 1]
            b2 = placed[i + 1, j, 2] - placed[i - 1, j, 2]
            n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            long = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            if n2 <= 0 or long == 0:
                continue
            facing = (n0 * lamp[0] + n1 * lamp[1] + n2 * lamp[2]) / long
            up = 0.85 - 0.15 * n1 / long
            lit = ambient * up + (1 - ambient) * 1.5 * max(facing, 0.0)
            mirror = (n0 * lamp[0] + n1 * lamp[1] + n2 * (lamp[2] + 1)) / long / halfway
            shine = gloss[i, j] * (1 - 0.5 * ambient) * max(mirror, 0.0) ** 12
            u = middle + scale * placed[i, j, 0]
            v = centre + scale * placed[i, j, 1]
            reach_u = scale * (abs(a0) + abs(b0)) / 4 + 0.5
            reach_v = scale * (abs(a1) + abs(b1)) / 4 + 0.5
            for row in range(max(0, int(np.ceil(v - reach_v))),
                             min(sprite.shape[0], int(v + reach_v) + 1)):  # fmt: skip
                for column in range(max(0, int(np.ceil(u - reach_u))),
                                    min(sprite.shape[1], int(u + reach_u) + 1)):  # fmt: skip
                    if placed[i, j, 2] > depth[row, column]:
                        depth[row, column] = placed[i, j, 2]
                        for k in range(3):
                            sprite[row, column, k] = paint[i, j, k] * lit + shine
                        sprite[row, column, 3] = 1

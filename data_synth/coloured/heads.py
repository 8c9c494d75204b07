"""A head that turns, tilts, comes and goes in a room, among others, in changing light."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from data_synth._checks import instance, number, whole
from data_synth._kernels import kernel
from data_synth.coloured.canvas import covered, inside, lay, texture
from data_synth.coloured.filming import LIGHTS, camera_or_default, film, linear, one_of, start, wave
from data_synth.coloured.sequences import HEIGHT, WIDTH, Camera, HeadSequence

__all__ = ["HeadScene", "head"]

_FOCAL = 300.0  # pixels
_U, _V = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
_SEMI = np.array([0.098, 0.076, 0.118])  # half axes of a head: ahead, left, up, m
_LAMP = np.array([-0.80, -0.35, -0.49])  # where the lamp stands: left, above, on our side
_LAMP = _LAMP / np.linalg.norm(_LAMP)
_LENS = np.array([[_FOCAL, 0, _U], [0, _FOCAL, _V], [0, 0, 1]])
_POINTS = 72
_PLAIN, _HEAD, _SHIRT, _BIT = 0, 1, 2, 3  # kinds of ellipsoids; a bit is neck, nose or ear
_BITS = 64  # added to the number of an owner


@dataclass(frozen=True, slots=True)
class HeadScene:
    """Scene in the room; all values are ours.

    Parameters
    ----------
    light
        ``"changing"``: brightness, colour temperature, and a lamp from the side; ``"steady"``; or
        ``"white"``: steady, and the lamp is white like the light all about.
    others
        How many pass the target: the first before it, the next behind it, and so on.
    turns
        Whether the head turns round until its back is seen.
    tilts
        Whether it leans to its sides.
    moves
        Whether it comes and goes, and walks to the sides.
    lamp
        How strong the lamp is at most, shares of full light.
    sweats
        How much more skin and hair shine at the end than at the beginning, in between in
        proportion to the time; 0 for not at all.
    """

    light: str = "changing"
    others: int = 2
    turns: bool = True
    tilts: bool = True
    moves: bool = True
    lamp: float = 0.55
    sweats: float = 0.0

    def __post_init__(self) -> None:
        one_of("light", self.light, (*LIGHTS, "white"))
        whole("others", self.others, 0, 12)
        for name in ("turns", "tilts", "moves"):
            instance(name, getattr(self, name), bool)
        number("lamp", self.lamp, 0.0, 5.0)
        number("sweats", self.sweats, 0.0, 1e4)


@dataclass(frozen=True, eq=False, slots=True)
class _Person:
    """Place and looks of somebody's head at a time."""

    place: Callable[[float], np.ndarray]
    yaw: Callable[[float], float]
    tilt: Callable[[float], float]
    skin: np.ndarray
    hair: np.ndarray
    shirt: np.ndarray
    stripes: np.ndarray
    long: bool

    def parts(self, time: float) -> tuple[np.ndarray, ...]:
        """Centres (e, 3), maps to the unit sphere (e, 3, 3), kinds (e,), colours (e, 2, 3)."""
        centre, yaw, tilt = self.place(time), self.yaw(time), self.tilt(time)
        head, upright, body = _axes(yaw, tilt), _axes(yaw, 0.4 * tilt), _axes(yaw, 0.0)
        lean = np.array([-np.sin(tilt), np.cos(tilt), 0])
        throat = centre + 0.115 * lean - 0.012 * body[0]
        chest = centre + 0.06 * lean + np.array([0, 0.50, 0]) - 0.02 * body[0]
        face, wool = [self.skin, self.hair], [self.shirt, self.stripes]
        parts = [
            (centre, head / _SEMI[:, None], _HEAD, face),
            (throat, upright / _column(0.054, 0.052, 0.10), _BIT, face),
            (chest, body / _column(0.115, 0.20, 0.40), _SHIRT, wool),
        ]
        for side in (-1, 1):
            arm = chest + [0, 0.175 * side, 0.07] @ body
            parts.append((arm, body / _column(0.062, 0.056, 0.22), _SHIRT, wool))
        for ahead, left, up, size in (
            (0.098, 0.0, -0.014, (0.020, 0.013, 0.026)),
            (-0.012, 0.073, -0.008, (0.018, 0.010, 0.030)),
            (-0.012, -0.073, -0.008, (0.018, 0.010, 0.030)),
        ):  # nose and ears
            parts.append((centre + [ahead, left, up] @ head, head / _column(*size), _BIT, face))
        if self.long:
            back = centre + [-0.045, 0, -0.07] @ head
            hair = [self.hair, self.hair]
            parts.append((back, head / _column(0.065, 0.092, 0.15), _PLAIN, hair))
        return tuple(np.array(part) for part in zip(*parts, strict=True))


def _column(*values: float) -> np.ndarray:
    return np.array(values)[:, None]


def _axes(yaw: float, tilt: float) -> np.ndarray:
    """Ahead, left and up (3, 3) of a head in the frame of the camera: right, down, away."""
    ahead = np.array([np.sin(yaw), 0, -np.cos(yaw)])
    left = np.array([np.cos(yaw), 0, np.sin(yaw)])
    cos, sin = np.cos(tilt), np.sin(tilt)
    lean = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return np.stack([ahead, left, [0, -1, 0]]) @ lean.T


def head(
    *,
    rng: np.random.Generator,
    frames: int = 150,
    scene: HeadScene | None = None,
    camera: Camera | None = None,
) -> HeadSequence:
    """Return a person in a room; the target is the head, of which the outline is an ellipse.

    The head is an ellipsoid with a face and a cap of hair, all hair from behind. Neck, nose and
    ears before it count as head, beside it as ``extra``. Others, a door and shelves of wood share
    its colours.

    Parameters
    ----------
    rng
        Source of people, paths, the room, the light and the noise.
    frames
        How many.
    scene
        What happens; by default as :class:`HeadScene` is.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.
    """
    motion, looks, passing, room, air, noise = start(rng, frames, 6)
    scene = HeadScene() if scene is None else instance("scene", scene, HeadScene)
    camera = camera_or_default(camera)
    target = _target(scene, frames, motion, looks)
    people = [target, *(_passer(k, scene.others, frames, target, passing)
                        for k in range(scene.others))]  # fmt: skip
    ambient, lamp = _lights(scene, air)
    walls, lean = _room(room)
    shifts = _shifts(camera.parts)

    def seen(time: float, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The light, and to whose head each pixel belongs."""
        near, side = ambient(time), lamp(time)
        canvas = _lit(walls, lean, near, side)
        depths = np.full((HEIGHT, WIDTH), np.inf, dtype=np.float32)
        whose = np.full((HEIGHT, WIDTH), -1, dtype=np.int16)
        for k, person in enumerate(people):
            centres, maps, kinds, colours = person.parts(time)
            wet = 1.0 + scene.sweats * time / frames * (k == 0)
            _cast(centres, maps, kinds, colours, _boxes(centres, maps), near, side, _LAMP,
                  wet, shift, k, _FOCAL, canvas, depths, whose)  # fmt: skip
        return canvas, whose

    def paint(time: float, moment: int) -> np.ndarray:
        return seen(time, shifts[moment])[0]

    masks = np.zeros((frames, HEIGHT, WIDTH), dtype=bool)
    extra = np.zeros_like(masks)
    ellipses, outlines = np.empty((frames, 4)), np.empty((frames, _POINTS, 2))
    visible = np.empty(frames)
    ring = 2 * np.pi * np.arange(_POINTS) / _POINTS
    ring = np.stack([np.cos(ring), np.sin(ring)], axis=1)
    for t in range(frames):
        whose = seen(t, np.zeros(2))[1]
        centres, maps, _, _ = target.parts(t)
        middle, spread = (part[0] for part in _silhouettes(centres[:1], maps[:1]))
        ellipses[t] = [*middle, *np.sqrt(np.diag(spread))]
        outlines[t] = middle + ring @ np.linalg.cholesky(spread).T
        within = covered(outlines[t])
        masks[t] = (whose == 0) | ((whose == _BITS) & within)
        extra[t] = (whose == _BITS) & ~within
        visible[t] = masks[t].sum() / (np.pi * np.sqrt(np.linalg.det(spread)))
    times = range(frames)
    return HeadSequence(
        frames=film(camera, paint, frames, rng=noise),
        masks=masks,
        extra=extra,
        outlines=outlines,
        light=np.stack([ambient(t) + lamp(t) for t in times]),
        ellipses=ellipses,
        tilt=np.array([target.tilt(t) for t in times]),
        yaw=np.array([target.yaw(t) for t in times]),
        depth=np.array([target.place(t)[2] for t in times]),
        visible=visible.clip(0, 1),
    )


def _shifts(count: int) -> np.ndarray:
    """Places in a pixel (count, 2) of the rays of the moments of an exposure: spread, mean 0."""
    scattered = np.arange(count)[:, None] * (0.754878, 0.569840) % 1
    return (scattered.argsort(axis=0).argsort(axis=0) + 0.5) / count - 0.5


def _silhouettes(centres: np.ndarray, maps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles m (e, 2) and spreads S (e, 2, 2) of the outlines (p - m)ᵀ S⁻¹ (p - m) = 1 of
    ellipsoids, from the duals of their cones, K (A Aᵀ - c cᵀ) Kᵀ with A from the unit sphere.
    """
    out = np.linalg.inv(maps)
    dual = _LENS @ (out @ out.mT - centres[:, :, None] * centres[:, None, :]) @ _LENS.T
    middle = dual[:, :2, 2] / dual[:, 2, 2, None]
    return middle, middle[:, :, None] * middle[:, None, :] - dual[:, :2, :2] / dual[:, 2:, 2:]


def _boxes(centres: np.ndarray, maps: np.ndarray) -> np.ndarray:
    """First and last columns and rows (e, 4) that ellipsoids can meet."""
    middle, spread = _silhouettes(centres, maps)
    reach = np.sqrt(np.diagonal(spread, axis1=1, axis2=2)) + 1
    low = np.floor(middle - reach).clip(0, (WIDTH, HEIGHT))
    high = np.ceil(middle + reach).clip(-1, (WIDTH - 1, HEIGHT - 1))
    return np.concatenate([low, high], axis=1).astype(np.int64)


@kernel()
def _lit(walls, lean, near, side):
    """The light that comes back from the walls: ``lean`` is how much of the lamp meets them."""
    canvas = np.empty_like(walls)
    for row in range(walls.shape[0]):
        for column in range(walls.shape[1]):
            for channel in range(3):
                came = near[channel] + lean[row, column] * side[channel]
                canvas[row, column, channel] = walls[row, column, channel] * came
    return canvas


@kernel()
def _cast(
    centres, maps, kinds, colours, boxes, near, side, lamp, wet, shift, owner, focal, canvas,
    depths, whose,
):  # fmt: skip
    """Write what a ray through each pixel meets first; ``whose`` gets the owner's number for a
    head, more by ``_BITS`` for a neck, a nose or an ear, else -1. All shines ``wet`` times as much.
    """
    paint = np.empty(3)
    u, v = (canvas.shape[1] - 1) / 2, (canvas.shape[0] - 1) / 2
    for e in range(len(centres)):
        S, c = maps[e], centres[e]
        o0 = -(S[0, 0] * c[0] + S[0, 1] * c[1] + S[0, 2] * c[2])
        o1 = -(S[1, 0] * c[0] + S[1, 1] * c[1] + S[1, 2] * c[2])
        o2 = -(S[2, 0] * c[0] + S[2, 1] * c[1] + S[2, 2] * c[2])
        rest = o0 * o0 + o1 * o1 + o2 * o2 - 1
        if rest <= 0:
            continue
        for row in range(boxes[e, 1], boxes[e, 3] + 1):
            for column in range(boxes[e, 0], boxes[e, 2] + 1):
                a, b = (column + shift[0] - u) / focal, (row + shift[1] - v) / focal
                d0 = S[0, 0] * a + S[0, 1] * b + S[0, 2]
                d1 = S[1, 0] * a + S[1, 1] * b + S[1, 2]
                d2 = S[2, 0] * a + S[2, 1] * b + S[2, 2]
                square, half = d0 * d0 + d1 * d1 + d2 * d2, d0 * o0 + d1 * o1 + d2 * o2
                inner = half * half - square * rest
                if inner < 0 or half >= 0:
                    continue
                depth = (-half - np.sqrt(inner)) / square
                if depth >= depths[row, column]:
                    continue
                depths[row, column] = depth
                f, s, t = o0 + depth * d0, o1 + depth * d1, o2 + depth * d2
                n0 = S[0, 0] * f + S[1, 0] * s + S[2, 0] * t
                n1 = S[0, 1] * f + S[1, 1] * s + S[2, 1] * t
                n2 = S[0, 2] * f + S[1, 2] * s + S[2, 2] * t
                long = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
                gloss = 0.0
                paint[:] = colours[e, 0]
                whose[row, column] = -1
                if kinds[e] == _HEAD:
                    whose[row, column] = owner
                    gloss = _face(f, s, t, colours[e, 1], paint)
                elif kinds[e] == _SHIRT:
                    if np.sin(2 * np.pi * (depth * b - centres[2, 1]) / 0.05) > 0.3:
                        paint[:] = colours[e, 1]
                elif kinds[e] == _BIT:
                    whose[row, column] = owner + _BITS
                up = -n1 / long
                facing = (n0 * lamp[0] + n1 * lamp[1] + n2 * lamp[2]) / long
                lit = max(facing, 0.0)
                shade = 0.72 + 0.28 * up
                mirror = -n0 * a - n1 * b - n2
                shine = wet * gloss * max(0.0, (facing * 1.0 + mirror / long) / 2) ** 24
                for channel in range(3):
                    canvas[row, column, channel] = (
                        paint[channel] * (shade * near[channel] + lit * side[channel])
                        + shine * side[channel]
                    )


@kernel()
def _face(f, s, t, hair, paint):
    """Paint a place of the unit sphere of a head: hair, eyes, brows, mouth or skin; return how
    much it shines.
    """
    line = 0.60 - 0.12 * abs(s)
    front = 0.06 + 0.30 * max(t, 0.0) - 0.5 * min(t + 0.35, 0.0)
    if t > line or (f < front and t > -0.72):
        streak = 0.85 + 0.3 * np.sin(31 * s + 9 * t) * np.sin(23 * f + 5 * s)
        for channel in range(3):
            paint[channel] = hair[channel] * streak
        return 0.10
    if f > 0.2:
        x, y = abs(s) - 0.37, t - 0.10
        if (x / 0.17) ** 2 + (y / 0.075) ** 2 < 1:
            if x * x + y * y < 0.0045:
                paint[:] = 0.03
            else:
                paint[:] = 0.55
            return 0.2
        if abs(x) < 0.21 and abs(t - 0.25 + 0.6 * x * x) < 0.03:
            paint[:] = hair
            return 0.0
        if (s / 0.30) ** 2 + ((t + 0.46) / 0.06) ** 2 < 1:
            paint[0] *= 0.62
            paint[1] *= 0.38
            paint[2] *= 0.40
            return 0.15
        blush = np.exp(-((abs(s) - 0.45) ** 2 + (t + 0.15) ** 2) / 0.03)
        paint[1] *= 1 - 0.12 * blush
        paint[2] *= 1 - 0.12 * blush
    return 0.12


_SKINS = linear(np.array([[0.89, 0.69, 0.58], [0.80, 0.58, 0.45], [0.93, 0.76, 0.66]]))
_HAIRS = linear(np.array([[0.28, 0.19, 0.13], [0.16, 0.13, 0.12], [0.47, 0.32, 0.19]]))
_SHIRTS = linear(
    np.array([[0.25, 0.33, 0.48], [0.55, 0.25, 0.22], [0.45, 0.48, 0.45], [0.62, 0.50, 0.38]])
)


def _looks(rng: np.random.Generator) -> dict:
    shirt = _SHIRTS[rng.integers(4)] * rng.uniform(0.8, 1.2)
    return {
        "skin": _SKINS[rng.integers(3)] * rng.uniform(0.9, 1.1, 3),
        "hair": _HAIRS[rng.integers(3)] * rng.uniform(0.8, 1.2),
        "shirt": shirt,
        "stripes": shirt * rng.choice([1.0, 0.6, 1.5]),
        "long": bool(rng.integers(2)),
    }


def _target(
    scene: HeadScene, frames: int, motion: np.random.Generator, looks: np.random.Generator
) -> _Person:
    aside, down = wave(0.34, (35, 110), rng=motion), wave(0.05, (25, 90), rng=motion)
    depth, lean = wave(0.38, (60, 150), rng=motion), wave(0.32, (25, 90), rng=motion)
    glance, way = wave(0.6, (30, 90), rng=motion), motion.choice([-1, 1])

    def place(time: float) -> np.ndarray:
        if not scene.moves:
            return np.array([0, -0.02, 1.25])
        z = 1.25 + depth(time)
        return np.array([aside(time) * z / 1.25, -0.02 + down(time), z])

    def yaw(time: float) -> float:
        share = time / max(frames, 2)
        back = np.pi * (_step((share - 0.30) / 0.12) + _step((share - 0.58) / 0.12))
        turned = way * back * scene.turns + glance(time)
        return float((turned + np.pi) % (2 * np.pi) - np.pi)

    own = _looks(looks) | {"long": False}
    return _Person(place, yaw, lean if scene.tilts else lambda time: 0.0, **own)


def _step(x: float) -> float:
    x = min(max(x, 0.0), 1.0)
    return x * x * (3 - 2 * x)


def _passer(k: int, count: int, frames: int, target: _Person, rng: np.random.Generator) -> _Person:
    """Somebody who crosses before the target (even ``k``) or behind it."""
    when = frames * (k + 0.5 + rng.uniform(-0.2, 0.2)) / count
    pace, sense = rng.uniform(0.022, 0.032), rng.choice([-1, 1])
    there = target.place(when)
    z = there[2] - 0.28 if k % 2 == 0 else there[2] + rng.uniform(0.35, 0.7)
    x, y = there[0] * z / there[2], there[1] * z / there[2] + rng.uniform(-0.01, 0.03)
    bob, gaze = rng.uniform(0, 2 * np.pi), rng.uniform(-0.35, 0.35)
    look = _looks(rng)

    def place(time: float) -> np.ndarray:
        way = sense * pace * (time - when)
        return np.array([x + way, y + 0.008 * np.sin(0.7 * time + bob), z])

    return _Person(place, lambda time: sense * (1.25 + gaze), lambda time: 0.03 * sense, **look)


def _lights(
    scene: HeadScene, rng: np.random.Generator
) -> tuple[Callable[[float], np.ndarray], Callable[[float], np.ndarray]]:
    """Colours (3,) of the light all about and of the lamp, by time."""
    bright, warm = wave(0.36, (40, 130), rng=rng), wave(1.0, (50, 150), rng=rng)
    glow = wave(0.5, (40, 120), rng=rng)

    def ambient(time: float) -> np.ndarray:
        if scene.light != "changing":
            return np.array([0.80, 0.80, 0.80])
        heat = warm(time)
        return (0.78 + bright(time)) * np.array(
            [1 + 0.18 * heat, 1.0, 1 - 0.26 * heat], dtype=np.float32
        )

    def lamp(time: float) -> np.ndarray:
        share = 0.5 + glow(time) if scene.light == "changing" else 0.5
        colour = [1.0, 1.0, 1.0] if scene.light == "white" else [1.0, 0.82, 0.55]
        return scene.lamp * share * np.array(colour)

    return ambient, lamp


def _room(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Paint of the room's back wall (height, width, 3), and how much of the lamp meets it."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    fine, wide = texture(4, 2, rng=rng), texture(60, 3, rng=rng)
    paint = linear(np.array([0.60, 0.67, 0.69])) * (1 + 0.03 * fine + 0.04 * wide)[..., None]

    def board(left: float, top: float, right: float, bottom: float, colour: np.ndarray) -> None:
        ring = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], dtype=float)
        lay(paint, *inside(ring), colour)

    def wood(tone: np.ndarray, upright: bool) -> np.ndarray:
        across = columns if upright else rows
        grain = np.sin(across / 1.7 + 2.2 * texture(70, 3, rng=rng)) + 0.8 * fine
        return tone * (1 + 0.09 * grain)[..., None]

    def panel(left: int, top: int, right: int, bottom: int, picture: np.ndarray) -> None:
        box = slice(top, min(bottom, HEIGHT)), slice(left, min(right, WIDTH))
        paint[box] = picture[box]

    oak = linear(np.array([0.72, 0.52, 0.38]))
    x = int(rng.integers(12, 40))  # the door
    panel(x - 5, 22, x + 79, HEIGHT, wood(oak * 0.6, True))
    panel(x, 27, x + 74, HEIGHT, wood(oak, True))
    for top in (38, 118):
        for left in (x + 10, x + 41):
            panel(left, top, left + 23, top + 66, wood(oak * 0.8, True))
    board(x + 64, 112, x + 71, 116, linear(np.array([0.8, 0.75, 0.5])))
    s = int(rng.integers(205, 225))  # shelves with books
    panel(s - 4, 40, s + 90, HEIGHT, wood(oak * 0.5, False))
    for shelf in range(4):
        top, bottom = 44 + 50 * shelf, 88 + 50 * shelf
        panel(s, top, s + 86, bottom, wood(oak * 0.28, False))
        left = float(s + 1)
        while left < s + 80:
            thick, high = rng.uniform(4, 9), rng.uniform(26, 41)
            tone = linear(rng.uniform(0.2, 0.75, 3) * rng.uniform(0.6, 1.0))
            board(left, bottom - high, left + thick - 0.6, bottom, tone)
            left += thick + (rng.uniform(3, 14) if rng.uniform() < 0.12 else 0)
        panel(s - 4, bottom, s + 90, bottom + 6, wood(oak * 0.9, False))
    p = int(rng.integers(112, 140))  # a poster
    panel(p - 2, 36, p + 58, 104, np.broadcast_to(0.05, paint.shape))
    sky = linear(np.array([0.62, 0.60, 0.50])) + 0.10 * texture(20, 3, rng=rng)[..., None] * (
        np.array([1.0, 0.6, 0.3])
    )
    panel(p, 38, p + 56, 102, sky.clip(0.02, 1))
    falls = (0.75 - 0.5 * columns / WIDTH) * (1 - 0.3 * rows / HEIGHT)
    return paint.clip(0.005, 1).astype(np.float32), falls.astype(np.float32)

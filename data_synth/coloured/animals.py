"""A beetle and a snail outdoors: sun, sky, passing clouds and shadows of leaves."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from data_synth._checks import instance, whole
from data_synth.coloured.camera import HEIGHT, WIDTH, Camera, children, wave
from data_synth.coloured.canvas import (
    Box,
    inside,
    lay,
    leaf_outline,
    place_at,
    round_outline,
    shadow,
    stroke,
    texture,
    turn,
)
from data_synth.coloured.figures import LIGHTS, one_of
from data_synth.coloured.sequences import Sequence

_SUN = np.array([0.42, 0.55, 0.72])  # where it stands: right, down, and up from the ground
_SUN = _SUN / np.linalg.norm(_SUN)
_WARM, _COLD = np.array([1.0, 0.92, 0.78]), np.array([0.24, 0.28, 0.34])  # sun and sky
_DROP = np.array([-0.42, -0.55]) / 0.72  # of a shadow, for each pixel of height
_FALLEN = np.array(  # colours of what lies about; those of beetle and snail are among them
    [
        [0.20, 0.075, 0.030],
        [0.30, 0.150, 0.060],
        [0.13, 0.050, 0.025],
        [0.36, 0.240, 0.110],
        [0.12, 0.160, 0.050],
        [0.24, 0.110, 0.040],
    ]
)

# Parts of the beetle along its axis, tail to front, half its length 1: where each begins, and the
# middle and half axes of its ellipsoid.
_PARTS = np.array(
    [
        [-1.00, -0.30, 0.70, 0.57, 0.42],
        [0.27, 0.47, 0.26, 0.46, 0.30],
        [0.66, 0.80, 0.20, 0.27, 0.18],
    ]
)


@dataclass(frozen=True, eq=False, slots=True)
class _Outdoors:
    """Light of sun and sky, and the path of an animal."""

    sun: Callable[[float], float]
    shade: np.ndarray
    wind: Callable[[float], float]
    steady: bool

    def sky(self, time: float) -> np.ndarray:
        return _COLD * (1.15 - 0.25 * self.strength(time))

    def strength(self, time: float) -> float:
        """Of the sun: clouds pass."""
        return 0.8 if self.steady else 0.62 + self.sun(time)

    def sunny(self, time: float) -> np.ndarray:
        """Share of the sun that the leaves above let through (height, width)."""
        if self.steady:
            return np.ones((HEIGHT, WIDTH), dtype=np.float32)
        shift = np.array([[1, 0, self.wind(time)], [0, 1, 0.6 * self.wind(time + 9)]])
        return cv2.warpAffine(
            self.shade, shift, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        )  # fmt: skip


def _outdoors(light: str, rng: np.random.Generator) -> _Outdoors:
    leaves = texture(70, 3, rng=rng)
    shade = 0.22 + 0.78 / (1 + np.exp(-(leaves + 0.35) * 7))
    return _Outdoors(
        wave(0.38, (35, 110), rng=rng),
        shade.astype(np.float32),
        wave(9.0, (20, 70), rng=rng),
        light == "steady",
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Path:
    """Round the image, now faster, now slower."""

    first: float
    rate: float
    pace: Callable[[float], float]
    wide: Callable[[float], float]
    high: Callable[[float], float]

    def at(self, time: float) -> tuple[np.ndarray, float, float]:
        """Place, heading and the way so far as an angle."""
        here, ahead = self._place(time - 0.05), self._place(time + 0.05)
        step = ahead - here
        way = self.first + self.rate * time + self.pace(time)
        return (here + ahead) / 2, float(np.arctan2(step[1], step[0])), way

    def _place(self, time: float) -> np.ndarray:
        way = self.first + self.rate * time + self.pace(time)
        reach = np.array([88 + self.wide(time), 55 + self.high(time)])
        return np.array([WIDTH / 2, HEIGHT / 2]) + reach * (np.cos(way), np.sin(way))


def _path(period: float, rng: np.random.Generator) -> _Path:
    rate = 2 * np.pi / period * rng.choice([-1, 1])
    pauses = wave(0.12, (0.3 * period, 0.8 * period), rng=rng)
    sides = [wave(16.0, (0.5 * period, period), rng=rng) for _ in range(2)]
    return _Path(rng.uniform(0, 2 * np.pi), rate, pauses, *sides)


def _scatter(ground: np.ndarray, leaves: int, stones: int, rng: np.random.Generator) -> None:
    """Lay leaves and stones with their shadows on the paint of the ground."""
    fine = texture(5, 3, rng=rng)
    for kind in rng.permutation([0] * leaves + [1] * stones):
        spot = rng.uniform((0, 0), (WIDTH, HEIGHT))
        paint = _FALLEN[rng.integers(len(_FALLEN))] * rng.uniform(0.8, 1.25)
        angle = rng.uniform(0, 2 * np.pi)
        if kind:
            size = rng.uniform(7, 20)
            shape = place_at(
                round_outline(4, 0.12, rng=rng) * (size, size * rng.uniform(0.6, 0.9)), angle, spot
            )
            if rng.uniform() < 0.5:
                paint = np.array([0.22, 0.20, 0.18]) * rng.uniform(0.6, 1.5)
        else:
            size = rng.uniform(30, 58)
            shape = place_at(leaf_outline(size, size * rng.uniform(0.35, 0.6)), angle, spot)
        shadow(ground, shape, _DROP * size * 0.09, 1.5, 0.65)
        box, cover = inside(shape)
        if not cover.size:
            continue
        rows, columns = np.mgrid[box]
        away = np.stack([columns - spot[0], rows - spot[1]], axis=-1) / size
        slope = 1 + (0.45 if kind else 0.25) * (away @ (_SUN[:2] / 0.7)) + 0.10 * fine[box]
        lay(ground, box, cover, paint * slope[..., None])
        if not kind:  # the veins
            tips = turn(np.array([[-size / 2, 0], [size / 2, 0]]), angle) + spot
            lay(ground, *stroke(tips, np.array([1.8, 0.8])), paint * 1.45)
            for along in np.linspace(-0.3, 0.3, 4):
                for side in (-1, 1):
                    ends = np.array([[along, 0], [along + 0.12, side * 0.14]]) * size
                    lay(ground, *stroke(turn(ends, angle) + spot, np.ones(2) * 0.7), paint * 1.25)


def beetle(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    light: str = "changing",
    legs: bool = True,
    clutter: bool = True,
    camera: Camera | None = None,
) -> Sequence:
    """Return a shiny beetle that walks over sand, soil and leaves; the target is its body.

    The outline goes round wing cases, pronotum and head; legs and antennae are ``extra``. Sun and
    sky light it, the sun through clouds and leaves; the sun's reflection moves as it turns.

    Parameters
    ----------
    rng
        Source of the ground, the path, the light and the noise.
    frames
        How many.
    light
        ``"steady"`` for a sun without clouds and leaves before it.
    legs
        Whether it has legs and antennae.
    clutter
        Whether leaves and stones, some of its colours, lie on the ground.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.
    """
    whole("frames", frames, 1, 10_000)
    one_of("light", light, LIGHTS)
    instance("legs", legs, bool)
    instance("clutter", clutter, bool)
    camera = instance("camera", camera or Camera(), Camera)
    motion, grounds, air, coat, noise = children(rng, 5)
    path, grow = _path(150, motion), wave(0.12, (50, 150), rng=motion)
    outdoors = _outdoors(light, air)
    ground = _sand(grounds)
    if clutter:
        _scatter(ground, 11, 12, grounds)
    spots = coat.uniform((-0.85, 0.12), (0.1, 0.42), (5, 2))
    radii = coat.uniform(0.07, 0.13, 5)
    ring = _beetle_outline()

    def at(time: float) -> tuple[np.ndarray, float, float, float]:
        place, heading, way = path.at(time)
        return place, heading, 43 * (1 + grow(time)), way

    def outline(time: float) -> np.ndarray:
        place, heading, size, _ = at(time)
        return place_at(size * ring, heading, place)

    def limbs(time: float) -> list[tuple[Box, np.ndarray]]:
        place, heading, size, way = at(time)
        lines = [(place_at(size * line, heading, place), size * wide) for line, wide in _limbs(way)]
        return [stroke(line, wide) for line, wide in lines] if legs else []

    def paint(time: float, _: int) -> np.ndarray:
        place, heading, size, _ = at(time)
        sun = outdoors.strength(time) * outdoors.sunny(time)[..., None]
        shape = outline(time)
        low = np.ones((HEIGHT, WIDTH, 1), dtype=np.float32)
        shadow(low, shape, _DROP * 0.16 * size, 2.0, 0.9)
        for box, cover in limbs(time):
            moved = tuple(
                slice(max(0, s.start + d), max(0, s.start + d) + s.stop - s.start)
                for s, d in zip(box, (-3, -2), strict=True)
            )
            room = low[moved]
            room *= 1 - 0.6 * cover[: room.shape[0], : room.shape[1], None]
        canvas = ground * (sun * low * (_SUN[2] * _WARM) + outdoors.sky(time) * (0.4 + 0.6 * low))
        for box, cover in limbs(time):
            came = sun[box] * 0.5 * _WARM + outdoors.sky(time)
            lay(canvas, box, cover, np.array([0.05, 0.025, 0.015]) * came)
        box, cover = inside(shape)
        if cover.size:
            rows, columns = np.mgrid[box]
            body = np.stack([columns - place[0], rows - place[1]], axis=-1) / size
            body = turn(body.reshape(-1, 2), -heading).reshape(body.shape)
            lay(canvas, box, cover, _coat(body, heading, spots, radii, sun[box],
                                          outdoors.sky(time)))  # fmt: skip
        return canvas

    masks = np.zeros((frames, HEIGHT, WIDTH), dtype=bool)
    extra = np.zeros_like(masks)
    for t in range(frames):
        box, cover = inside(outline(t))
        masks[t][box] = cover > 0.5
        for box, cover in limbs(t):
            extra[t][box] |= cover > 0.5
    return Sequence(
        frames=camera.film(paint, frames, rng=noise),
        masks=masks,
        extra=extra & ~masks,
        outlines=np.stack([outline(t) for t in range(frames)]),
        light=_light_on(outdoors, at, frames),
    )


def _light_on(outdoors: _Outdoors, at: Callable, frames: int) -> np.ndarray:
    """The light (n, 3) that falls on the middle of an animal."""
    found = []
    for t in range(frames):
        column, row = np.rint(at(t)[0]).astype(int)
        sun = outdoors.strength(t) * outdoors.sunny(t)[row, column]
        found.append(sun * _SUN[2] * _WARM + outdoors.sky(t))
    return np.stack(found)


def _sand(rng: np.random.Generator) -> np.ndarray:
    """Paint (height, width, 3) of ground: sand, here and there soil."""
    fine, rough = texture(3, 2, rng=rng)[..., None], texture(90, 3, rng=rng)[..., None]
    soil = 1 / (1 + np.exp(-(rough - 0.7) * 6))
    paint = np.array([0.40, 0.32, 0.22]) * (1 - soil) + np.array([0.15, 0.095, 0.06]) * soil
    return (paint * (1 + 0.10 * fine + 0.08 * rough).clip(0.3, None)).astype(np.float32)


def _beetle_outline(points: int = 45) -> np.ndarray:
    """Outline (2 points, 2) of the body, its axis the first, half its length 1."""
    along = -np.cos(np.pi * (np.arange(points) + 0.5) / points)
    part = np.searchsorted(_PARTS[:, 0], along, side="right") - 1
    middle, long, wide = _PARTS[part, 1:4].T
    half = wide * np.sqrt((1 - ((along - middle) / long) ** 2).clip(0, None))
    left = np.stack([along, half], axis=1)
    return np.concatenate([left, left[::-1] * (1, -1)])


def _limbs(way: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Legs in two tripods that step in turn, and antennae, in the frame of the body."""
    lines = []
    for k, hip in enumerate((0.50, 0.22, -0.05)):
        for side in (-1, 1):
            phase = 26 * way + np.pi * ((k + (side > 0)) % 2)
            swing = 0.13 * np.sin(phase)
            reach = (0.30, -0.08, -0.48)[k]
            knee = [hip + 0.6 * reach + 0.5 * swing, side * 0.66]
            heel = [hip + 1.1 * reach + swing, side * 0.92]
            toe = [hip + 1.1 * reach + 1.1 * swing + (0.14 if k == 0 else -0.16), side * 1.06]
            line = np.array([[hip, side * 0.3], knee, heel, toe])
            lines.append((line, np.array([0.12, 0.09, 0.06, 0.035])))
    for side in (-1, 1):
        nod = 0.06 * np.sin(9 * way + side)
        line = [[0.95, side * 0.12], [1.15, side * 0.3 + nod], [1.42, side * 0.42 + 1.5 * nod]]
        lines.append((np.array(line), np.array([0.05, 0.04, 0.055])))
    return lines


def _coat(
    body: np.ndarray, heading: float, spots: np.ndarray, radii: np.ndarray, sun: np.ndarray,
    sky: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Light (rows, columns, 3) that comes back from places (rows, columns, 2) of the body."""
    x, y = body[..., 0], body[..., 1]
    part = (np.searchsorted(_PARTS[:, 0], x, side="right") - 1).clip(0)
    middle, long, wide, high = np.moveaxis(_PARTS[part, 1:], -1, 0)
    steep = np.sqrt((1 - ((x - middle) / long) ** 2 - (y / wide) ** 2).clip(0.04, None))
    ahead = high * (x - middle) / long**2 / steep
    aside = high * y / wide**2 / steep
    wing = part == 0
    aside = (
        aside
        + wing * 0.12 * np.sin(55 * y)
        - wing * 0.9 * np.exp(-((y / 0.03) ** 2)) * (np.sign(y))
    )  # furrows and the seam
    scale = 1 / np.sqrt(1 + ahead**2 + aside**2)
    cos, sin = np.cos(heading), np.sin(heading)
    normal = np.stack([cos * ahead - sin * aside, sin * ahead + cos * aside, np.ones_like(x)], -1)
    normal *= scale[..., None]
    paint = np.where(
        wing[..., None], np.array([0.17, 0.050, 0.018]), np.array([0.05, 0.024, 0.016])
    )
    folded = np.stack([x, np.abs(y)], axis=-1)
    for spot, radius in zip(spots, radii, strict=True):
        off = np.hypot(*np.moveaxis(folded - spot, -1, 0))
        dark = (wing * ((radius - off) / 0.03 + 0.5).clip(0, 1))[..., None]
        paint = paint * (1 - 0.85 * dark)
    paint = paint * (1 - 0.7 * wing * np.exp(-((y / 0.018) ** 2)))[..., None]
    half = _SUN + (0, 0, 1)
    half = half / np.linalg.norm(half)
    came = sun * (normal @ _SUN).clip(0, None)[..., None] * _WARM + sky
    gloss = sun * 1.1 * (normal @ half).clip(0, None)[..., None] ** 70 * _WARM
    sheen = 0.16 * (1 - normal[..., 2:]) ** 2 * sky
    return (paint * came + gloss + sheen).astype(np.float32)


def snail(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    light: str = "changing",
    neck: bool = True,
    clutter: bool = True,
    camera: Camera | None = None,
) -> Sequence:
    """Return a snail that creeps through leaves and stones of its colours; the target is its shell.

    All outlines of the shell are affine images of one; the neck and foot in the colours of the
    shell, which stretch and contract, are ``extra``. Leaves lie over its path too.

    Parameters
    ----------
    rng
        Source of the ground, the path, the light and the noise.
    frames
        How many.
    light
        ``"steady"`` for a sun without clouds and leaves before it.
    neck
        Whether it shows its neck and foot.
    clutter
        Whether leaves and stones lie about.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.
    """
    whole("frames", frames, 1, 10_000)
    one_of("light", light, LIGHTS)
    instance("neck", neck, bool)
    instance("clutter", clutter, bool)
    camera = instance("camera", camera or Camera(), Camera)
    motion, grounds, air, coat, noise = children(rng, 5)
    path, outdoors = _path(320, motion), _outdoors(light, air)
    grow, flat = wave(0.12, (60, 150), rng=motion), wave(0.10, (40, 110), rng=motion)
    skew, swing = wave(0.12, (50, 120), rng=motion), wave(0.2, (35, 90), rng=motion)
    stretch = wave(0.38, (40, 90), rng=motion)
    ground = _sand(grounds)
    leaves = np.zeros((0, 40, 2))
    if clutter:
        _scatter(ground, 20, 16, grounds)
        leaves = np.stack([_blade(grounds) for _ in range(3)])
    base = round_outline(3, 0.06, rng=coat)
    picture = _spiral(coat)
    skin = texture(4, 3, rng=coat)

    def at(time: float) -> tuple[np.ndarray, float, np.ndarray]:
        """Place, heading, and the linear part of the shell's map."""
        place, heading, _ = path.at(time)
        size = 36 * (1 + grow(time))
        bend = np.array([[1 + flat(time), skew(time)], [0, 0.84 * (1 - flat(time))]])
        return place, heading, turn((size * bend).T, heading + swing(time)).T

    def outline(time: float) -> np.ndarray:
        place, _, linear_part = at(time)
        return base @ linear_part.T + place

    def foot(time: float) -> list[tuple[Box, np.ndarray]]:
        if not neck:
            return []
        place, heading, _ = at(time)
        size = 36 * (1 + grow(time))
        bend = 0.5 * swing(time + 12)
        parts = [inside(place_at(size * _slug(1.72 + stretch(time), bend), heading, place))]
        tip = _spine(np.array([1.72 + stretch(time)]), bend)[0]
        for side in (-1, 1):
            horn = np.array([[-0.12, 0.1 * side], [0.12, 0.22 * side], [0.30, 0.34 * side]])
            line = place_at(size * (tip + turn(horn, bend)), heading, place)
            parts.append(stroke(line, size * np.array([0.07, 0.05, 0.075])))
        return parts

    def paint(time: float, _: int) -> np.ndarray:
        place, heading, linear_part = at(time)
        sun = outdoors.strength(time) * outdoors.sunny(time)[..., None]
        sky = outdoors.sky(time)
        shape = outline(time)
        low = np.ones((HEIGHT, WIDTH, 1), dtype=np.float32)
        shadow(low, shape, _DROP * 9, 2.5, 0.85)
        canvas = ground * (sun * low * (_SUN[2] * _WARM) + sky * (0.4 + 0.6 * low))
        for k, (box, cover) in enumerate(foot(time)):
            if not cover.size:
                continue
            soft = cv2.GaussianBlur(cover, (0, 0), 4.0)
            round_ = (0.55 + 0.55 * soft)[..., None] if k == 0 else 0.8
            shift = tuple(int(d) for d in np.rint(place))
            coat_ = np.roll(skin, (shift[1], shift[0]), axis=(0, 1))[box][..., None]
            tone = np.array([0.33, 0.215, 0.115]) * (1 + 0.16 * coat_)
            lay(canvas, box, cover, tone * round_ * (sun[box] * _SUN[2] * _WARM + sky))
        box, cover = inside(shape)
        if cover.size:
            shade_ = low[box]
            shade_[...] = 1
            lay(canvas, box, cover, _shell(picture, box, place, linear_part, sun[box], sky))
        for leaf in leaves:
            shadow(canvas, leaf, _DROP * 6, 2.0, 0.45)
            box, cover = inside(leaf)
            if cover.size:
                lay(canvas, box, cover, _BLADE * (sun[box] * _WARM + sky))
        return canvas

    masks = np.zeros((frames, HEIGHT, WIDTH), dtype=bool)
    extra = np.zeros_like(masks)
    before = np.zeros((HEIGHT, WIDTH), dtype=bool)
    for leaf in leaves:
        box, cover = inside(leaf)
        before[box] |= cover > 0.5
    for t in range(frames):
        box, cover = inside(outline(t))
        masks[t][box] = cover > 0.5
        for box, cover in foot(t):
            extra[t][box] |= cover > 0.5
    return Sequence(
        frames=camera.film(paint, frames, rng=noise),
        masks=masks & ~before,
        extra=extra & ~masks & ~before,
        outlines=np.stack([outline(t) for t in range(frames)]),
        light=_light_on(outdoors, at, frames),
    )


_BLADE = np.array([0.14, 0.19, 0.06])  # colour of the leaves before the snail


def _blade(rng: np.random.Generator) -> np.ndarray:
    """Outline (40, 2) of a narrow leaf that lies over the path."""
    angle = rng.uniform(0, 2 * np.pi)
    spot = np.array([WIDTH / 2, HEIGHT / 2]) + np.array([88, 55]) * (np.cos(angle), np.sin(angle))
    return place_at(leaf_outline(rng.uniform(70, 110), rng.uniform(7, 11)),
                    rng.uniform(0, 2 * np.pi), spot)  # fmt: skip


def _spine(along: np.ndarray, bend: float) -> np.ndarray:
    """Places (n, 2) along the middle of the foot, which bends."""
    return np.stack([along * np.cos(bend * along / 2), along * np.sin(bend * along / 2)], axis=1)


def _slug(front: float, bend: float, points: int = 24) -> np.ndarray:
    """Outline (2 points, 2) of neck and foot from behind the shell to the head."""
    along = np.linspace(-1.35, front, points)
    share = (along + 1.35) / (front + 1.35)
    half = 0.42 * np.minimum(1.0, 2.2 * share) ** 0.7 * (1 - 0.38 * share)
    half *= np.sqrt((1 - (share.clip(0.86, 1) - 0.86) ** 2 / 0.14**2).clip(0, None))
    middle = _spine(along, bend)
    off = np.stack([np.zeros(points), half], axis=1)
    return np.concatenate([middle + off, (middle - off)[::-1]])


def _spiral(rng: np.random.Generator) -> np.ndarray:
    """Paint (256, 256, 3) of a shell, -1.28 to 1.28 along each side."""
    rows, columns = (np.mgrid[:256, :256] - 127.5) / 100
    x, y = columns + 0.12, rows - 0.05
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    turns = angle / (2 * np.pi) + 1.6 * np.log(radius + 0.06)
    band = 0.5 + 0.5 * np.sin(2 * np.pi * turns)
    groove = np.exp(-(((turns % 1) - 0.5) ** 2) / 0.006)
    ribs = np.sin(40 * angle + 4 * radius) * 0.06
    fine = 0.10 * texture(9, 3, rng=rng, size=(256, 256))
    light, dark = np.array([0.42, 0.27, 0.13]), np.array([0.19, 0.085, 0.035])
    paint = dark + band[..., None] * (light - dark)
    return (paint * (1 - 0.6 * groove + ribs + fine)[..., None]).clip(0.01, 1).astype(np.float32)


def _shell(
    picture: np.ndarray, box: Box, place: np.ndarray, linear_part: np.ndarray, sun: np.ndarray,
    sky: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Light (rows, columns, 3) that comes back from the shell."""
    rows, columns = np.mgrid[box]
    there = np.stack([columns - place[0], rows - place[1]], axis=-1) @ np.linalg.inv(linear_part).T
    maps = (there * 100 + 127.5).astype(np.float32)
    paint = cv2.remap(picture, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR,
                      borderMode=cv2.BORDER_REFLECT)  # fmt: skip
    lean = (there @ linear_part.T) / np.sqrt(abs(np.linalg.det(linear_part)))
    rise = np.sqrt((1 - (there**2).sum(axis=-1)).clip(0.05, None))
    normal = np.concatenate([lean, rise[..., None]], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    half = _SUN + (0, 0, 1)
    half = half / np.linalg.norm(half)
    came = sun * (normal @ _SUN).clip(0, None)[..., None] * _WARM + sky
    gloss = sun * 0.35 * (normal @ half).clip(0, None)[..., None] ** 40 * _WARM
    return (paint * came + gloss).astype(np.float32)

"""The plain ones: circles that change colour, and a rectangle that revolves about a lamp."""

import numpy as np

from data_synth._checks import instance, number, whole
from data_synth.coloured.camera import HEIGHT, WIDTH, Camera, children, linear, wave
from data_synth.coloured.canvas import inside, lay, place_at, shadow, texture
from data_synth.coloured.sequences import LampSequence, Sequence

LIGHTS = ("changing", "steady")
_POINTS = 80
_DARKEST, _BRIGHTEST = 0.12, 0.95  # of a circle's colour, in the image

_FOCAL = 300.0  # pixels
_AWAY, _SLANT = 2.0, np.deg2rad(30)  # of the table: m, and off the camera's axis
_LAMP_HIGH, _CARD_HIGH = 0.45, 0.18  # above the table, m
_SIDES = np.array([0.40, 0.28])  # of the rectangle, m
_ORBIT, _OFF = 0.52, 0.14  # radius, and what the lamp stands off its middle, m
_WARM = 0.42 * np.array([1.0, 0.70, 0.40])  # lamp: light at 1 m, shares of full light
_AMBIENT = np.array([0.075, 0.095, 0.14])
CARD = np.array([0.52, 0.105, 0.075])  # colour of the rectangle


def circles(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    others: int = 4,
    colour_step: float = 0.03,
    camera: Camera | None = None,
) -> Sequence:
    """Return circles that bounce about and change colour at random; one of them is the target.

    Colours walk at random; those of the others too, so that they meet the target's. Circles pass
    before and behind each other.

    Parameters
    ----------
    rng
        Source of places, colours and noise.
    frames
        How many.
    others
        Circles beside the target.
    colour_step
        How far a colour walks from frame to frame at most, shares of the image's range; 0 keeps
        the colours.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.

    Returns
    -------
    Sequence
        Its ``light`` is the colour of the target, which shines by itself.
    """
    whole("frames", frames, 1, 10_000)
    whole("others", others, 0, 20)
    number("colour_step", colour_step, 0.0, 0.5)
    camera = instance("camera", camera or Camera(), Camera)
    motion, colours, ground, noise = children(rng, 4)
    count, target = others + 1, (others + 1) // 2  # about half of the others pass before it
    radii = motion.uniform(20, 32, count)
    radii[target] = motion.uniform(28, 34)
    start = motion.uniform(0, 1, (count, 2)) * (WIDTH, HEIGHT)
    angle, speed = motion.uniform(0, 2 * np.pi, count), motion.uniform(1.5, 3.5, count)
    pace = speed[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    walks = np.stack([_colour_walk(frames + 1, colour_step, colours) for _ in range(count)])
    back = linear((0.55 + 0.05 * texture(24, 4, rng=ground))[..., None] * np.ones(3))
    grain = 1 + 0.05 * np.stack([texture(6, 2, rng=ground) for _ in range(count)])[..., None]
    ring = 2 * np.pi * np.arange(_POINTS) / _POINTS
    ring = np.stack([np.cos(ring), np.sin(ring)], axis=1)

    def outline(k: int, time: float) -> np.ndarray:
        room = np.array([WIDTH, HEIGHT]) - 1 - 2 * radii[k]
        way = (start[k] + pace[k] * time) % (2 * room)
        return radii[k] + np.minimum(way, 2 * room - way) + radii[k] * ring

    def colour(k: int, time: float) -> np.ndarray:
        at = min(max(time, 0.0), frames - 1.0)
        low = int(at)
        return linear(walks[k, low] + (at - low) * (walks[k, low + 1] - walks[k, low]))

    def paint(time: float, _: int) -> np.ndarray:
        canvas = back.copy()
        for k in range(count):
            box, cover = inside(outline(k, time))
            lay(canvas, box, cover, colour(k, time) * grain[k][box])
        return canvas

    masks = np.zeros((frames, HEIGHT, WIDTH), dtype=bool)
    for t in range(frames):
        box, cover = inside(outline(target, t))
        masks[t][box] = cover > 0.5
        for k in range(target + 1, count):
            box, cover = inside(outline(k, t))
            masks[t][box] &= cover <= 0.5
    return Sequence(
        frames=camera.film(paint, frames, rng=noise),
        masks=masks,
        extra=np.zeros_like(masks),
        outlines=np.stack([outline(target, t) for t in range(frames)]),
        light=np.stack([colour(target, t) for t in range(frames)]),
    )


def _colour_walk(count: int, step: float, rng: np.random.Generator) -> np.ndarray:
    """Colours (count, 3); the pace of the walk changes at random too."""
    colours = np.empty((count, 3))
    colours[0] = rng.uniform(_DARKEST, _BRIGHTEST, 3)
    pace = rng.standard_normal(3)
    for k in range(1, count):
        pace = 0.85 * pace + 0.5 * rng.standard_normal(3)
        move = step * pace / max(1.0, float(np.linalg.norm(pace)))
        free = colours[k - 1] + move
        out = (free < _DARKEST) | (free > _BRIGHTEST)
        pace[out] *= -1
        colours[k] = np.where(out, colours[k - 1] - move, free).clip(_DARKEST, _BRIGHTEST)
    return colours


def rectangle(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    light: str = "changing",
    camera: Camera | None = None,
) -> LampSequence:
    """Return a reddish Lambertian rectangle that revolves about a lamp above a table.

    A place of the rectangle at distance r from the lamp, whose light comes in at the angle α off
    its normal, sends ``albedo · (lamp · cos α / r² + ambient)`` into the camera, of which the
    sensor loses what is more than full light. The lamp is warm, the ambient light cold.

    Parameters
    ----------
    rng
        Source of the path, the table and the noise.
    frames
        How many; the rectangle goes round the lamp once in sixty.
    light
        ``"steady"`` gives the rectangle everywhere the light of its first place.
    camera
        That films; by default as :class:`~data_synth.coloured.Camera` is.
    """
    whole("frames", frames, 1, 10_000)
    one_of("light", light, LIGHTS)
    camera = instance("camera", camera or Camera(), Camera)
    motion, ground, noise = children(rng, 3)
    right, far = np.array([1.0, 0, 0]), np.array([0, -np.cos(_SLANT), np.sin(_SLANT)])
    up = np.array([0, -np.sin(_SLANT), -np.cos(_SLANT)])
    middle = np.array([0, 0, _AWAY])
    first, sense = motion.uniform(0, 2 * np.pi), motion.choice([-1, 1])
    aside = motion.uniform(0, 2 * np.pi)
    lamp = middle + _LAMP_HIGH * up + _OFF * (np.cos(aside) * right + np.sin(aside) * far)
    nod, sway = wave(0.25, (30, 90), rng=motion), wave(0.3, (40, 120), rng=motion)
    spin, lift = wave(0.7, (40, 120), rng=motion), wave(0.07, (40, 120), rng=motion)

    def frame(time: float) -> tuple[np.ndarray, np.ndarray]:
        """Centre (3,), and the axes (3, 3) along the sides and off the face."""
        turned = first + sense * 2 * np.pi * time / 60
        out = np.cos(turned) * right + np.sin(turned) * far
        along = np.cos(turned) * far - np.sin(turned) * right
        tip = 0.45 + nod(time)  # towards the lamp
        axes = [along, np.cos(tip) * out + np.sin(tip) * up, np.cos(tip) * up - np.sin(tip) * out]
        axes = _about(axes, sway(time), (1, 2))
        centre = middle + _ORBIT * out + (_CARD_HIGH + lift(time)) * up
        return centre, np.stack(_about(axes, spin(time), (0, 1)))

    def corners(time: float) -> np.ndarray:
        centre, axes = frame(time)
        halves = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * _SIDES / 2
        return centre + halves @ axes[:2]

    rays = np.stack(
        [*(np.mgrid[:HEIGHT, :WIDTH][::-1] - np.reshape(_MIDDLE, (2, 1, 1))) / _FOCAL,
         np.ones((HEIGHT, WIDTH))], axis=-1,
    )  # fmt: skip

    def shone(normal: np.ndarray, point: np.ndarray, box: tuple) -> np.ndarray:
        """The lamp's light on a plane, seen through the pixels of a box."""
        places = rays[box] * (normal @ point / (rays[box] @ normal))[..., None]
        ways = lamp - places
        squares = (ways**2).sum(axis=-1)
        return (ways @ normal).clip(0, None)[..., None] / squares[..., None] ** 1.5 * _WARM

    def received(time: float, box: tuple) -> np.ndarray:
        centre, axes = frame(time)
        return shone(axes[2], centre, box) + _AMBIENT

    def at_centre(time: float) -> np.ndarray:
        centre, axes = frame(time)
        way = lamp - centre
        return _WARM * max(float(way @ axes[2]), 0.0) / float(way @ way) ** 1.5 + _AMBIENT

    everywhere = (slice(0, HEIGHT), slice(0, WIDTH))
    paint_of_table = _table(ground)
    cold = (paint_of_table * _AMBIENT).astype(np.float32)
    warm = (paint_of_table * shone(up, middle, everywhere)).astype(np.float32)
    shade = lamp + 0.09 * (_RING[:, :1] * right + _RING[:, 1:] * far)

    def outline(time: float) -> np.ndarray:
        return _seen(_sides(corners(time), _POINTS // 4))

    def paint(time: float, _: int) -> np.ndarray:
        ways = _sides(corners(time), 4) - lamp
        drop = (middle - lamp) @ up / (ways @ up)  # from the lamp through the edge to the table
        lit = np.ones((HEIGHT, WIDTH, 1), dtype=np.float32)
        shadow(lit, _seen(lamp + drop[:, None] * ways), np.zeros(2), 2.0, 1.0)
        canvas = cold + warm * lit
        box, cover = inside(outline(time))
        if cover.size:
            came = received(time, box) if light == "changing" else at_centre(0.0)
            lay(canvas, box, cover, (CARD * came).astype(np.float32))
        box, cover = inside(_seen(shade))
        lay(canvas, box, cover, np.array([0.02, 0.02, 0.02], dtype=np.float32))
        return canvas

    masks = np.zeros((frames, HEIGHT, WIDTH), dtype=bool)
    hides, covers = inside(_seen(shade))
    for t in range(frames):
        box, cover = inside(outline(t))
        masks[t][box] = cover > 0.5
        masks[t][hides] &= covers <= 0.5
    times = np.arange(frames)
    return LampSequence(
        frames=camera.film(paint, frames, rng=noise),
        masks=masks,
        extra=np.zeros_like(masks),
        outlines=np.stack([outline(t) for t in times]),
        light=np.stack([at_centre(t if light == "changing" else 0.0) for t in times]),
        corners=np.stack([corners(t) for t in times]),
        lamp=lamp,
    )


_MIDDLE = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
_RING = 2 * np.pi * np.arange(48) / 48
_RING = np.stack([np.cos(_RING), np.sin(_RING)], axis=1)


def _seen(places: np.ndarray) -> np.ndarray:
    return _MIDDLE + _FOCAL * places[:, :2] / places[:, 2:]


def _sides(corners: np.ndarray, parts: int) -> np.ndarray:
    share = np.arange(parts)[:, None] / parts
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + share * (b - a) for a, b in zip(corners, ends, strict=True)])


def _about(axes: list, angle: float, pair: tuple[int, int]) -> list:
    """Turn two axes about the third."""
    i, j = pair
    axes = list(axes)
    cos, sin = np.cos(angle), np.sin(angle)
    axes[i], axes[j] = cos * axes[i] + sin * axes[j], cos * axes[j] - sin * axes[i]
    return axes


def _table(rng: np.random.Generator) -> np.ndarray:
    """Paint (height, width, 3) of a wooden table with papers and reddish cards on it."""
    rows = np.mgrid[:HEIGHT, :WIDTH][0]
    grain = 0.5 * texture(40, 4, rng=rng) + 0.5 * np.sin(rows / 3.1 + 1.5 * texture(90, 2, rng=rng))
    paint = np.array([0.30, 0.21, 0.13]) * (1 + 0.18 * grain.clip(-2, 2))[..., None]
    for colour in ([0.45, 0.44, 0.40], [0.34, 0.13, 0.09], [0.16, 0.20, 0.16], [0.30, 0.08, 0.06]):
        sides = rng.uniform((18, 14), (40, 30))
        card = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides / 2
        spot = rng.uniform((20, 20), (WIDTH - 20, HEIGHT - 20))
        lay(paint, *inside(place_at(card, rng.uniform(0, np.pi), spot)), np.array(colour))
    return paint


def one_of(name: str, value: object, words: tuple[str, ...]) -> None:
    """Refuse what is none of the words."""
    if not isinstance(value, str) or value not in words:
        raise ValueError(f"{name} must be one of {', '.join(words)}, got {value!r:.60}")

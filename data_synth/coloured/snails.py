"""A snail in clutter that shares its colours."""

import cv2
import numpy as np

from data_synth._checks import instance
from data_synth._kernels import kernel
from data_synth.coloured.canvas import (
    covered,
    inside,
    lay,
    leaf_outline,
    place_at,
    round_outline,
    shadow,
    shifted,
    stroke,
    texture,
    turn,
)
from data_synth.coloured.filming import camera_or_default, film, start, wave
from data_synth.coloured.outdoors import (
    DROP,
    HALF,
    LEVEL,
    SUN,
    WARM,
    lit_ground,
    make_path,
    make_weather,
    sand,
    scatter,
    shine,
)
from data_synth.coloured.sequences import HEIGHT, WIDTH, Camera, Sequence

__all__ = ["snail"]

_SIZE = 36.0  # of the shell, pixels
_SKIN = np.array([0.34, 0.18, 0.065], dtype=np.float32)


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
    motion, grounds, air, coat, noise = start(rng, frames, 5)
    instance("neck", neck, bool)
    instance("clutter", clutter, bool)
    camera = camera_or_default(camera)
    path, weather = make_path(320, rng=motion), make_weather(light, rng=air)
    grow, flat = wave(0.12, (60, 150), rng=motion), wave(0.10, (40, 110), rng=motion)
    skew, swing = wave(0.12, (50, 120), rng=motion), wave(0.2, (35, 90), rng=motion)
    stretch = wave(0.45, (40, 90), rng=motion)
    ground = sand(rng=grounds)
    blades = np.zeros((0, 40, 2))
    if clutter:
        scatter(ground, 20, 16, rng=grounds)
        blades = np.stack([_blade(grounds) for _ in range(2)])
    base = round_outline(3, 0.06, rng=coat)
    picture, bumps = _spiral(coat), texture(4, 3, rng=coat)

    def bent(time: float) -> np.ndarray:
        """The linear part (2, 2) of the shell's affine map."""
        squeeze = np.array([[1 + flat(time), skew(time)], [0, 0.84 * (1 - flat(time))]])
        size = _SIZE * (1 + grow(time))
        return size * turn(squeeze.T, path.heading(time) + swing(time)).T

    def outline(time: float) -> np.ndarray:
        return base @ bent(time).T + path.place(time)

    def foot(time: float) -> np.ndarray:
        """Share of each pixel that neck, foot and horns cover."""
        total = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
        if not neck:
            return total
        size, bend, front = _SIZE * (1 + grow(time)), 0.5 * swing(time + 12), 1.8 + stretch(time)

        def there(points: np.ndarray) -> np.ndarray:
            return place_at(size * points, path.heading(time), path.place(time))

        box, cover = inside(there(_slug(front, bend)))
        total[box] = cover
        for side in (-1, 1):
            horn = np.array([[-0.12, 0.1 * side], [0.12, 0.22 * side], [0.30, 0.34 * side]])
            line = there(_spine(np.array([front]), bend) + turn(horn, bend))
            box, cover = stroke(line, size * np.array([0.07, 0.05, 0.075]))
            total[box] = np.maximum(total[box], cover)
        return total

    over = []
    for blade in blades:
        dark = np.ones((HEIGHT, WIDTH, 1), dtype=np.float32)
        shadow(dark, blade, DROP * 6, 2.0, 0.45)
        around, _ = inside(blade, margin=20)
        over.append((around, dark[around], *inside(blade)))

    def paint(time: float, _: int) -> np.ndarray:
        shape, soft, place = outline(time), foot(time), path.place(time)
        sun, sky = weather.sun(time), weather.sky(time)
        low = 1 - 0.6 * shifted(soft, DROP * 4)
        shadow(low, shape, DROP * 9, 2.5, 0.85)
        canvas = lit_ground(ground, sun, low, sky)
        box, _ = inside(shape, margin=int(1.8 * _SIZE))
        thick = 0.5 + 0.6 * cv2.GaussianBlur(soft[box], (0, 0), 4.0)
        rows, columns = (np.arange(s.start, s.stop) for s in box)
        along, across = np.rint(place).astype(int)
        moved = bumps[np.ix_((rows - across) % HEIGHT, (columns - along) % WIDTH)]
        came = sun[box][..., None] * LEVEL + sky
        lay(canvas, box, soft[box], _SKIN * (thick * (1 + 0.16 * moved))[..., None] * came)
        box, cover = inside(shape)
        light_back = np.empty((*cover.shape, 3), dtype=np.float32)
        corner = place - (box[1].start, box[0].start)
        _shell(picture, corner, np.linalg.inv(bent(time)), bent(time), sun[box], sky, light_back)
        lay(canvas, box, cover, light_back)
        for around, dark, box, cover in over:
            canvas[around] *= dark
            lay(canvas, box, cover, _BLADE * (sun[box][..., None] * WARM + sky))
        return canvas

    times = range(frames)
    free = ~np.any([covered(blade) for blade in blades], axis=0)
    masks = np.stack([covered(outline(t)) for t in times])
    return Sequence(
        frames=film(camera, paint, frames, rng=noise),
        masks=masks & free,
        extra=np.stack([foot(t) > 0.5 for t in times]) & ~masks & free,
        outlines=np.stack([outline(t) for t in times]),
        light=np.stack([weather.at(path.place(t), t) for t in times]),
    )


_BLADE = np.array([0.14, 0.19, 0.06])  # colour of the leaves before the snail


def _blade(rng: np.random.Generator) -> np.ndarray:
    """Outline (40, 2) of a narrow leaf that lies over the path."""
    angle = rng.uniform(0, 2 * np.pi)
    spot = np.array([WIDTH / 2, HEIGHT / 2]) + np.array([88, 55]) * (np.cos(angle), np.sin(angle))
    return place_at(leaf_outline(rng.uniform(70, 110), rng.uniform(5, 8)),
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
    light, dark = np.array([0.42, 0.22, 0.075]), np.array([0.19, 0.072, 0.022])
    paint = dark + band[..., None] * (light - dark)
    return (paint * (1 - 0.6 * groove + ribs + fine)[..., None]).clip(0.01, 1).astype(np.float32)


@kernel()
def _shell(picture, place, inverse, linear, sun, sky, light):
    """Write the light that comes back from the shell, the affine image of half a ball."""
    normal = np.empty(3)
    paint = np.empty(3)
    scale = np.sqrt(abs(linear[0, 0] * linear[1, 1] - linear[0, 1] * linear[1, 0]))
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            right, down = column - place[0], row - place[1]
            x = inverse[0, 0] * right + inverse[0, 1] * down
            y = inverse[1, 0] * right + inverse[1, 1] * down
            j = min(254.99, max(0.0, 100 * x + 127.5))
            i = min(254.99, max(0.0, 100 * y + 127.5))
            k, m = int(i), int(j)
            a, b = i - k, j - m
            for channel in range(3):
                upper = (1 - b) * picture[k, m, channel] + b * picture[k, m + 1, channel]
                lower = (1 - b) * picture[k + 1, m, channel] + b * picture[k + 1, m + 1, channel]
                paint[channel] = (1 - a) * upper + a * lower
            rise = np.sqrt(max(1 - x * x - y * y, 0.05))
            long = np.sqrt((right * right + down * down) / scale**2 + rise * rise)
            normal[0], normal[1], normal[2] = right / scale / long, down / scale / long, rise / long
            shine(paint, normal, sun[row, column], sky, WARM, SUN, HALF, 0.25, 60.0,
                  light[row, column])  # fmt: skip

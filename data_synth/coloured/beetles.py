"""A shiny beetle that walks on varied ground."""

import numpy as np

from data_synth._checks import instance
from data_synth._kernels import kernel
from data_synth.coloured.canvas import covered, inside, lay, place_at, shadow, shifted, stroke
from data_synth.coloured.filming import camera_or_default, film, start, wave
from data_synth.coloured.outdoors import (
    DROP,
    HALF,
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

__all__ = ["beetle"]

# Wing cases, pronotum and head, from the tail to the front; the unit is half the beetle's length.
# For each: the place on the axis where it begins, the centre of its ellipsoid there, and the
# semi-axes of the ellipsoid along, across and up.
_PARTS = np.array(
    [
        [-1.00, -0.30, 0.70, 0.57, 0.42],
        [0.27, 0.47, 0.26, 0.46, 0.30],
        [0.66, 0.80, 0.20, 0.27, 0.18],
    ]
)


def beetle(
    *,
    rng: np.random.Generator,
    frames: int = 120,
    light: str = "changing",
    legs: bool = True,
    clutter: bool = True,
    camera: Camera | None = None,
) -> Sequence:
    """Return a film of a shiny beetle that walks over sand and moss; the target is its body.

    The outline goes round wing cases, pronotum and head; legs and antennae are ``extra``. Sun and
    sky light the beetle, and the reflection of the sun on it moves as it turns.

    Parameters
    ----------
    rng
        Source of the ground, the path, the light and the noise.
    frames
        Number of frames.
    light
        ``"changing"``: clouds pass and leaves cast shadows. ``"steady"``: the sun shines freely.
    legs
        Whether the beetle has legs and antennae.
    clutter
        Whether leaves and stones, some in colours like the beetle's, lie on the ground.
    camera
        The camera; a default :class:`~data_synth.coloured.Camera` if not given.
    """
    motion, grounds, air, coat, noise = start(rng, frames, 5)
    instance("legs", legs, bool)
    instance("clutter", clutter, bool)
    camera = camera_or_default(camera)
    path, grow = make_path(150, rng=motion), wave(0.12, (50, 150), rng=motion)
    weather = make_weather(light, rng=air)
    ground = sand(rng=grounds)
    if clutter:
        scatter(ground, 11, 12, rng=grounds)
    spots = np.array([[-0.8, 0.16], [-0.6, 0.38], [-0.36, 0.17], [-0.14, 0.4], [0.05, 0.15]])
    spots = np.column_stack([spots + coat.normal(0, 0.03, (5, 2)), coat.uniform(0.06, 0.12, 5)])
    ring = _outline()

    def size(time: float) -> float:
        return 43 * (1 + grow(time))

    def outline(time: float) -> np.ndarray:
        return place_at(size(time) * ring, path.heading(time), path.place(time))

    def limbs(time: float) -> np.ndarray:
        """Return the share of each pixel that legs and antennae cover."""
        total = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
        for line, widths in _limbs(path.way(time)) if legs else ():
            line = place_at(size(time) * line, path.heading(time), path.place(time))
            box, cover = stroke(line, size(time) * widths)
            total[box] = np.maximum(total[box], cover)
        return total

    def paint(time: float, _: int) -> np.ndarray:
        shape, thin = outline(time), limbs(time)
        sun, sky = weather.sun(time), weather.sky(time)
        low = 1 - 0.6 * shifted(thin, DROP * 0.07 * size(time))
        shadow(low, shape, DROP * 0.16 * size(time), 2.0, 0.9)
        canvas = lit_ground(ground, sun, low, sky)
        box, cover = inside(shape, margin=int(1.2 * size(time)))
        lay(canvas, box, thin[box], _LEG * (0.5 * sun[box][..., None] * WARM + sky))
        box, cover = inside(shape)
        light_back = np.empty((*cover.shape, 3), dtype=np.float32)
        corner = path.place(time) - (box[1].start, box[0].start)
        _coat(corner, path.heading(time), size(time), spots, sun[box], sky, light_back)
        lay(canvas, box, cover, light_back)
        return canvas

    times = range(frames)
    masks = np.stack([covered(outline(t)) for t in times])
    return Sequence(
        frames=film(camera, paint, frames, rng=noise),
        masks=masks,
        extra=np.stack([limbs(t) > 0.5 for t in times]) & ~masks,
        outlines=np.stack([outline(t) for t in times]),
        light=np.stack([weather.at(path.place(t), t) for t in times]),
    )


_WING, _FRONT, _LEG = np.array([[0.20, 0.042, 0.016], [0.085, 0.022, 0.012], [0.06, 0.022, 0.012]])


def _outline(points: int = 45) -> np.ndarray:
    """Return the outline (2 points, 2) of the body: along and across, in half its length."""
    along = -np.cos(np.pi * (np.arange(points) + 0.5) / points)
    part = np.searchsorted(_PARTS[:, 0], along, side="right") - 1
    middle, long, wide = _PARTS[part, 1:4].T
    half = wide * np.sqrt((1 - ((along - middle) / long) ** 2).clip(0, None))
    left = np.stack([along, half], axis=1)
    return np.concatenate([left, left[::-1] * (1, -1)])


def _limbs(way: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return lines with their widths: six legs and two antennae, in half the body's length.

    The legs form two tripods that step in turn; ``way`` sets the phase of the step.
    """
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


@kernel()
def _coat(place, heading, size, spots, sun, sky, light):
    """Write the light that comes back from each pixel of the body.

    Wing cases, pronotum and head are upper halves of ellipsoids; the wing cases have furrows, spots
    and a seam between them.
    """
    cos, sin = np.cos(heading), np.sin(heading)
    paint, normal = np.empty(3), np.empty(3)
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            right, down = (column - place[0]) / size, (row - place[1]) / size
            x, y = cos * right + sin * down, cos * down - sin * right
            part = 2 if x >= _PARTS[2, 0] else (1 if x >= _PARTS[1, 0] else 0)
            long, wide, high = _PARTS[part, 2], _PARTS[part, 3], _PARTS[part, 4]
            off = x - _PARTS[part, 1]
            steep = np.sqrt(max(1 - (off / long) ** 2 - (y / wide) ** 2, 0.04))
            ahead, aside = high * off / long**2 / steep, high * y / wide**2 / steep
            paint[:] = _FRONT
            if part == 0:
                paint[:] = _WING
                seam = np.exp(-((y / 0.03) ** 2))
                aside += 0.12 * np.sin(55 * y) - 0.9 * seam * np.sign(y)
                for k in range(len(spots)):
                    away = np.hypot(x - spots[k, 0], abs(y) - spots[k, 1])
                    paint *= 1 - 0.85 * min(max((spots[k, 2] - away) / 0.03 + 0.5, 0.0), 1.0)
                paint *= 1 - 0.7 * seam
            long = np.sqrt(1 + ahead**2 + aside**2)
            normal[0] = (cos * ahead - sin * aside) / long
            normal[1] = (sin * ahead + cos * aside) / long
            normal[2] = 1 / long
            shine(paint, normal, sun[row, column], sky, WARM, SUN, HALF, 0.9, 120.0,
                  light[row, column])  # fmt: skip

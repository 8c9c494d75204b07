"""Painted pictures for walls, doors and furniture, and their reduced copies.

Everything is painted from random numbers; no photograph is needed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from data_synth._checks import generator, reals, wholes


@dataclass(frozen=True, eq=False, slots=True)
class Atlas:
    """Pictures, each with copies of half the size down to one texel, in one array.

    Parameters
    ----------
    texels : (size,)
        Grey values 0 to 255, row by row, copy by copy, picture by picture.
    starts : (pictures, levels)
        Where each copy begins; a picture of fewer levels repeats its last.
    sizes : (pictures, levels, 2)
        Rows and columns of each copy.

    Raises
    ------
    ValueError
        If there is no picture, or a copy leaves the texels.
    """

    texels: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray

    def __post_init__(self) -> None:
        end = wholes("texels", self.texels, (None,), 0, 255).size
        starts = wholes("starts", self.starts, (None, None), 0, end)
        if not starts.size:
            raise ValueError(f"starts must be of one picture at least, got {starts.shape}")
        sizes = wholes("sizes", self.sizes, (*starts.shape, 2), 1, min(end, 2**31))
        if (sizes.astype(float).prod(axis=-1) > end - starts).any():
            raise ValueError(f"starts and sizes must stay within {end} texels")


def make_atlas(pictures: Sequence[np.ndarray]) -> Atlas:
    """Return pictures with their reduced copies; each texel of a copy is the mean of its four.

    Parameters
    ----------
    pictures
        Grey values 0 to 255 in arrays (rows, columns), both powers of two.

    Raises
    ------
    ValueError
        If there is no picture, or one has another shape or other values.
    """
    if not isinstance(pictures, Sequence) or isinstance(pictures, str) or not len(pictures):
        raise TypeError(f"pictures must be a sequence of one at least, got {pictures!r:.60}")
    copies = [_reduced(reals("pictures", picture)) for picture in pictures]
    levels = max(map(len, copies))
    starts = np.empty((len(copies), levels), dtype=np.int64)
    sizes = np.empty((len(copies), levels, 2), dtype=np.int64)
    flat, end = [], 0
    for k, row in enumerate(copies):
        for level in range(levels):
            if level < len(row):
                flat.append(np.rint(row[level]).astype(np.uint8).ravel())
                begin, end = end, end + row[level].size
            starts[k, level], sizes[k, level] = begin, row[min(level, len(row) - 1)].shape
    return Atlas(np.concatenate(flat), starts, sizes)


def _reduced(picture: np.ndarray) -> list[np.ndarray]:
    if picture.ndim != 2 or not all(n > 0 and n & (n - 1) == 0 for n in picture.shape):
        raise ValueError(f"pictures must have sides of a power of two, got {picture.shape}")
    if not ((picture >= 0) & (picture <= 255)).all():
        raise ValueError("pictures must have values from 0 to 255")
    copies = [picture]
    while copies[-1].size > 1:
        rows, columns = copies[-1].shape
        down, across = min(rows, 2), min(columns, 2)
        blocks = copies[-1].reshape(rows // down, down, columns // across, across)
        copies.append(blocks.mean(axis=(1, 3)))
    return copies


def paint(kind: str, *, rng: np.random.Generator) -> np.ndarray:
    """Return a picture of a kind, other for each draw: grey values (rows, columns) of 8 bits.

    Raises
    ------
    ValueError
        If the kind is unknown.
    """
    generator(rng)
    if not isinstance(kind, str) or kind not in _PAINTERS:
        raise ValueError(f"kind must be one of {', '.join(_PAINTERS)}, got {kind!r:.60}")
    return np.rint(np.clip(_PAINTERS[kind](rng), 0, 255)).astype(np.uint8)


def _clouds(
    rows: int, columns: int, rng: np.random.Generator, *, fall: float = 1.0, stretch: float = 1.0
) -> np.ndarray:
    """Seamless noise of mean 0 and deviation 1 whose amplitude falls with the frequency."""
    down, across = np.fft.fftfreq(rows)[:, None] * rows, np.fft.rfftfreq(columns) * columns
    frequency = np.hypot(stretch * down, across)
    frequency[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((rows, columns))) / frequency**fall
    noise = np.fft.irfft2(spectrum, s=(rows, columns))
    return noise / noise.std()


def _plaster(rng: np.random.Generator) -> np.ndarray:
    return 190 + 1.0 * _clouds(256, 256, rng, fall=1.0)


def _linoleum(rng: np.random.Generator) -> np.ndarray:
    return 118 + 3 * _clouds(256, 256, rng, fall=1.2)


def _carpet(rng: np.random.Generator) -> np.ndarray:
    return 95 + 5 * _clouds(256, 256, rng, fall=0.4)


def _panels(rng: np.random.Generator) -> np.ndarray:
    """Tiles of a suspended ceiling, 2 × 2."""
    picture = 215 + 1.5 * _clouds(256, 256, rng, fall=0.3)
    picture[::128] -= 25
    picture[:, ::128] -= 25
    return picture


def _brick(rng: np.random.Generator) -> np.ndarray:
    """Sixteen courses of eight bricks, every other course shifted by half a brick."""
    course, column = np.arange(512)[:, None] // 32, np.arange(512)[None, :]
    place = column + 32 * (course % 2)
    greys = rng.normal(118, 16, (16, 8))[course, (place // 64) % 8]
    mortar = (np.arange(512)[:, None] % 32 < 4) | (place % 64 < 4)
    return np.where(mortar, 165, greys) + 6 * _clouds(512, 512, rng, fall=0.6)


def _planks(rng: np.random.Generator) -> np.ndarray:
    """Eight upright boards with grain and knots."""
    board = np.arange(512) // 64
    picture = rng.normal(125, 10, 8)[board] + 9 * _clouds(512, 512, rng, fall=1.0, stretch=12.0)
    rows, columns = np.ogrid[:512, :512]
    for _ in range(10):
        row, column = rng.uniform(20, 492, 2)
        size = rng.uniform(2.5, 6)
        away = ((rows - row) / (1.8 * size)) ** 2 + ((columns - column) / size) ** 2
        picture -= 55 * np.exp(-away)
    return picture - 45 * (np.arange(512) % 64 < 3)


def _timber(rng: np.random.Generator) -> np.ndarray:
    return 85 + 5 * _clouds(128, 128, rng, fall=1.0, stretch=10.0)


def _letters(rows: int, columns: int, size: int, rng: np.random.Generator) -> np.ndarray:
    """Lines of writing from an alphabet of twenty letters: where there is ink."""
    down, across = rows // (9 * size), columns // (6 * size)
    alphabet = np.zeros((21, 9, 6), dtype=bool)
    alphabet[:20, 1:8, :5] = rng.random((20, 7, 5)) < 0.45
    chosen = np.where(rng.random((down, across)) < 0.18, 20, rng.integers(20, size=(down, across)))
    ends = rng.integers(across // 2, across + 1, down)
    chosen[np.arange(across) >= ends[:, None]] = 20
    lines = alphabet[chosen].transpose(0, 2, 1, 3).reshape(9 * down, 6 * across)
    ink = np.zeros((rows, columns), dtype=bool)
    ink[: 9 * down * size, : 6 * across * size] = lines.repeat(size, 0).repeat(size, 1)
    return ink


def _figure(rows: int, columns: int, rng: np.random.Generator) -> np.ndarray:
    """A picture: clouds in a few tones with discs and bars."""
    tones = np.sort(rng.uniform(20, 235, 5))[rng.permutation(5)]
    heights = _clouds(rows, columns, rng, fall=1.5)
    picture = tones[np.digitize(heights, [-1.0, -0.3, 0.3, 1.0])]
    down, across = np.ogrid[:rows, :columns]
    for _ in range(rng.integers(6, 14)):
        row, column = rng.uniform(0, rows), rng.uniform(0, columns)
        size, tone = rng.uniform(0.03, 0.13) * columns, rng.uniform(0, 255)
        if rng.random() < 0.5:
            picture[(down - row) ** 2 + (across - column) ** 2 < size**2] = tone
        else:
            flat = rng.uniform(0.3, 2.0)
            picture[(abs(down - row) < flat * size) & (abs(across - column) < size / flat)] = tone
    return picture


def _poster(rng: np.random.Generator) -> np.ndarray:
    light = rng.random() < 0.7
    paper, ink = (rng.uniform(205, 250), 30) if light else (rng.uniform(25, 70), 225)
    picture = np.full((512, 512), paper)
    picture[28:82, 30:482][_letters(54, 452, 6, rng)] = ink
    foot = rng.integers(330, 420)
    picture[100:foot, 30:482] = _figure(foot - 100, 452, rng)
    picture[foot + 16 : 496, 30:482][_letters(480 - foot, 452, 3, rng)] = ink
    picture[[*range(4), *range(508, 512)]] = picture[:, [*range(4), *range(508, 512)]] = 60
    return picture


def _notices(rng: np.random.Generator) -> np.ndarray:
    """A cork board with sheets of paper."""
    picture = 135 + 8 * _clouds(512, 512, rng, fall=0.5)
    for row in range(4):
        for column in range(4):
            if rng.random() < 0.2:
                continue
            top, left = np.array([row, column]) * 125 + rng.integers(8, 26, 2)
            high, wide = rng.integers(70, 108, 2)
            sheet = np.full((high, wide), rng.uniform(190, 250))
            if rng.random() < 0.4:
                sheet[8 : high // 2, 8:-8] = _figure(high // 2 - 8, wide - 16, rng)
            sheet[high // 2 + 4 :, 8:-4][_letters(high - high // 2 - 4, wide - 12, 2, rng)] = 50
            picture[top : top + high, left : left + wide] = sheet
    picture[:8] = picture[-8:] = picture[:, :8] = picture[:, -8:] = 90
    return picture


def _books(rng: np.random.Generator) -> np.ndarray:
    """Shelves of books, of which some are missing."""
    picture = np.full((1024, 512), 35.0)
    shelves = rng.integers(4, 6)
    high = 1024 // shelves
    for shelf in range(shelves):
        floor, left = (shelf + 1) * high - 16, 16
        picture[floor : floor + 16] = 130
        while left < 470:
            wide = int(rng.integers(14, 36))
            if rng.random() < 0.12:
                left += int(rng.integers(20, 70))
                continue
            tall = int(high * rng.uniform(0.6, 0.86))
            spine = picture[floor - tall : floor, left : min(left + wide, 496)]
            spine[:] = rng.uniform(55, 185)
            top, size = rng.integers(8, tall // 2), rng.integers(12, 40)
            spine[top : top + size, 3:-3] = rng.uniform(40, 210)
            spine[:, -1:] = 20
            left += wide
    picture[:, :16] = picture[:, -16:] = picture[:12] = 130
    return picture


def _window(rng: np.random.Generator) -> np.ndarray:
    """Sky and trees behind a cross of frames."""
    horizon = rng.uniform(150, 330) + 45 * _clouds(1, 512, rng, fall=1.2)
    below = np.arange(512)[:, None] > horizon
    trees = 105 + 24 * _clouds(512, 512, rng, fall=1.4)
    picture = np.where(below, trees, 238 + 6 * _clouds(512, 512, rng, fall=1.6))
    for bar in (0, 246, 492):
        picture[bar : bar + 20] = picture[:, bar : bar + 20] = 200
    return picture


def _radiator(rng: np.random.Generator) -> np.ndarray:
    ribs = 175 + 45 * np.sin(2 * np.pi * np.arange(256) / 16)
    picture = np.tile(ribs, (128, 1)) + rng.normal(0, 2)
    picture[[*range(10), *range(118, 128)]] = 205
    return picture


def _writing(rng: np.random.Generator) -> np.ndarray:
    """A whiteboard with notes and a drawing."""
    picture = 225 + 2 * _clouds(256, 512, rng, fall=1.5)
    picture[24:120, 30:300][_letters(96, 270, 3, rng)] = 70
    left = rng.integers(40, 300)
    picture[140:236, left : left + 150][_letters(96, 150, 2, rng)] = 50
    rows, columns = np.ogrid[:256, :512]
    for _ in range(4):
        row, column, size = rng.uniform(60, 200), rng.uniform(330, 470), rng.uniform(12, 40)
        ring = np.hypot(rows - row, columns - column)
        picture[abs(ring - size) < 2.0] = 60
    picture[:6] = picture[-6:] = picture[:, :4] = picture[:, -4:] = 120
    return picture


def _sign(rng: np.random.Generator) -> np.ndarray:
    dark, light = rng.permutation([45.0, 230.0])
    picture = np.full((64, 64), light)
    picture[10:55, 8:56][_letters(45, 48, 2 if rng.random() < 0.5 else 4, rng)] = dark
    picture[:3] = picture[-3:] = picture[:, :3] = picture[:, -3:] = 80
    return picture


def _door(rng: np.random.Generator) -> np.ndarray:
    """A door with two panels, a handle and a grille."""
    picture = 135 + 6 * _clouds(512, 256, rng, fall=1.0, stretch=10.0)
    for top, bottom in ((50, 230), (280, 400)):
        picture[top:bottom, 40:216] -= 22
        picture[top : top + 5, 40:216] = picture[top:bottom, 40:45] = 70
        picture[bottom - 5 : bottom, 40:216] = picture[top:bottom, 211:216] = 185
    picture[250:256, 20:50] = picture[240:275, 18:26] = 225
    picture[258:274, 28:32] = 30
    picture[440:490:10, 60:196] = picture[443:490:10, 60:196] = 40
    picture[:6] = picture[:, :5] = picture[:, -5:] = 75
    return picture


def _drawers(rng: np.random.Generator) -> np.ndarray:
    picture = 155 + 4 * _clouds(256, 256, rng, fall=1.0, stretch=0.2)
    rows = int(rng.integers(3, 5))
    high = 256 // rows
    for k in range(rows):
        picture[k * high : k * high + 4] = 60
        picture[k * high + high // 2 : k * high + high // 2 + 6, 104:152] = 50
        label = picture[k * high + 12 : k * high + 30, 100:156]
        label[:] = 235
        label[_letters(18, 56, 2, rng)] = 60
    picture[:, :5] = picture[:, -5:] = 70
    return picture


def _papers(rng: np.random.Generator) -> np.ndarray:
    """A table top with papers on it."""
    picture = 150 + 5 * _clouds(256, 512, rng, fall=1.0, stretch=0.1)
    for _ in range(7):
        top, left = rng.integers(5, 160), rng.integers(5, 430)
        picture[top : top + 84, left : left + 60] = rng.uniform(200, 245)
        picture[top + 6 : top + 78, left + 6 : left + 56][_letters(72, 50, 2, rng)] = 60
    return picture


def _lamp(rng: np.random.Generator) -> np.ndarray:
    picture = np.full((64, 256), 255.0)
    picture[:4] = picture[-4:] = picture[:, :4] = picture[:, -4:] = 150
    picture[:, 8::16] -= rng.uniform(20, 30)
    return picture


_PAINTERS: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "plaster": _plaster,
    "brick": _brick,
    "planks": _planks,
    "linoleum": _linoleum,
    "carpet": _carpet,
    "panels": _panels,
    "timber": _timber,
    "door": _door,
    "poster": _poster,
    "notices": _notices,
    "books": _books,
    "window": _window,
    "radiator": _radiator,
    "writing": _writing,
    "sign": _sign,
    "drawers": _drawers,
    "papers": _papers,
    "lamp": _lamp,
}

KINDS = tuple(_PAINTERS)
"""Kinds of texture; the first seven repeat without a seam."""

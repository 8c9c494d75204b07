"""Adjacent ellipses share pixels: work and time of incremental histograms beside the full count."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int64

from data_synth.coloured import HeadScene, head
from robot_perception.appearance.colour_histograms import histogram, shares
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse, candidate_scores


@dataclass(frozen=True, slots=True)
class Config:
    """What is searched; the paper gives no numbers.

    Parameters
    ----------
    half_widths
        Of the ellipses, px; ours.
    radius
        Columns and rows searched to each side, px; Birchfield's 8.
    repeats
        How often each search is timed; the median counts.
    """

    half_widths: tuple[int, ...] = (5, 10, 20, 30, 40)
    radius: int = 8
    repeats: int = 15


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Both ways to count, by size.

    Parameters
    ----------
    half_widths : (sizes,)
        px.
    full, incremental : (sizes,)
        How many times a pixel is added or subtracted in one search.
    full_s, incremental_s : (sizes,)
        Times of one search on this computer, s.
    differ : (sizes,)
        In how many candidates the two scores are not exactly the same.
    """

    half_widths: Int64[np.ndarray, " sizes"]
    full: Int64[np.ndarray, " sizes"]
    incremental: Int64[np.ndarray, " sizes"]
    full_s: Float[np.ndarray, " sizes"]
    incremental_s: Float[np.ndarray, " sizes"]
    differ: Int64[np.ndarray, " sizes"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Search a rendered picture in both ways, with ellipses of all sizes."""
    image = head(rng=rng, frames=1, scene=HeadScene(others=0)).frames[0]
    binning = Binning()
    index = binning.index(image)
    centre = image.shape[1] // 2, image.shape[0] // 2
    rows = []
    for half_width in config.half_widths:
        ellipse = Ellipse(*centre, half_width)
        model = shares(histogram(index, binning.count, ellipse.mask(image.shape[1::-1])))

        def search(incremental: bool, width: int = half_width, m: np.ndarray = model) -> np.ndarray:
            how = {"half_widths": (width,), "radius": config.radius, "measure": "shares"}
            return candidate_scores(index, centre, m, **how, incremental=incremental)

        rows.append(
            (
                *additions(half_width, config.radius),
                *(_seconds(lambda w=way: search(w), config.repeats) for way in (False, True)),
                np.count_nonzero(search(True) != search(False)),
            )
        )
    full, incremental, full_s, incremental_s, differ = map(np.array, zip(*rows, strict=True))
    return Result(np.array(config.half_widths), full, incremental, full_s, incremental_s, differ)


def additions(half_width: int, radius: int) -> tuple[int, int]:
    """Return how often a pixel is added or subtracted in a search, in full and incrementally.

    To the side two pixels a row change, downwards two a column.
    """
    side, ellipse = 2 * radius + 1, Ellipse(0, 0, half_width)
    rows, columns = 2 * int(ellipse.half_height + 1e-9) + 1, 2 * half_width + 1
    steps = side * (side - 1) * 2 * rows + (side - 1) * 2 * columns
    return side**2 * ellipse.pixels, ellipse.pixels + steps


def _seconds(work: Callable[[], object], repeats: int) -> float:
    work()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return float(np.median(times))

"""Adjacent ellipses share pixels: the next histogram from the last one, and what that saves."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from data_synth.coloured import HeadScene
from data_synth.coloured import head as filmed
from robot_perception.appearance.colour_histograms import histogram
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.evaluation.intervals import exact, exponent, proportion
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "perception-issues"
HALF_WIDTHS = (5, 10, 20, 40)
STEPS = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])


@dataclass(frozen=True, slots=True)
class Config:
    """Paths of ellipses over a rendered picture; the paper gives no numbers.

    Parameters
    ----------
    half_widths
        Of the ellipses, one a path, px.
    steps
        Of each path, one pixel each, in a random direction.
    printed
        Whether the pixels that both ellipses have are subtracted, as the paper says, instead of
        those that leave.
    """

    half_widths: tuple[int, ...] = HALF_WIDTHS
    steps: int = 60
    printed: bool = False


def run(config: Config, *, rng: np.random.Generator) -> Bool[np.ndarray, "paths steps"]:
    """Carry histograms along random paths; return whether each is that of a full count."""
    image = filmed(rng=rng, frames=1, scene=HeadScene(others=0)).frames[0]
    binning, size = Binning(), image.shape[1::-1]
    index = binning.index(image)
    same = np.empty((len(config.half_widths), config.steps), dtype=bool)
    for i, half_width in enumerate(config.half_widths):
        place = np.array(size) // 2
        before = Ellipse(*place.tolist(), half_width).mask(size)
        carried = histogram(index, binning.count, before)
        for k in range(config.steps):
            place = place + STEPS[rng.integers(len(STEPS))]
            after = Ellipse(*place.tolist(), half_width).mask(size)
            less = before & after if config.printed else before & ~after
            carried = carried - histogram(index, binning.count, less)
            carried = carried + histogram(index, binning.count, after & ~before)
            same[i, k] = np.array_equal(carried, histogram(index, binning.count, after))
            before = after
    return same


def additions(half_width: int, radius: int) -> tuple[int, int]:
    """Return how often a pixel is added or subtracted in a search, in full and incrementally.

    To the side two pixels a row change, downwards two a column.
    """
    side, ellipse = 2 * radius + 1, Ellipse(0, 0, half_width)
    rows, columns = 2 * int(ellipse.half_height + 1e-9) + 1, 2 * half_width + 1
    steps = side * (side - 1) * 2 * rows + (side - 1) * 2 * columns
    return side**2 * ellipse.pixels, ellipse.pixels + steps


def savings(half_widths: tuple[int, ...], step: float) -> Float[np.ndarray, " sizes"]:
    """Return pixels of an ellipse over those that change when it moves aside.

    Parameters
    ----------
    half_widths
        px.
    step
        How far it moves: 0 for one pixel, else a share of its half width.
    """
    found = []
    for w in half_widths:
        moved = max(1, round(step * w))
        size = 2 * w + moved + 1, 2 * int(1.2 * w) + 1
        one = Ellipse(w, int(1.2 * w), w).mask(size)
        other = Ellipse(w + moved, int(1.2 * w), w).mask(size)
        found.append(one.sum() / (one ^ other).sum())
    return np.array(found)


carrying = Study(run, full=Config(steps=240), quick=Config(), seed=77)


@carrying.claim(
    "incremental-histogram",
    paper=PAPER,
    place="§3.2, below eq. 28",
    basis="mathematics",
    statement="The histogram of an adjacent ellipse follows exactly from the last one when the "
    "pixels that leave are subtracted and those that enter are added.",
    paper_value="“by only subtracting those common pixels … and adding the new ones”",
    method="Ellipses of four sizes walk one pixel at a time over a rendered picture; share of the "
    "steps after which every bin of the carried histogram is that of a full count.",
    accepted=Accepted(1.0, 1.0, "whole numbers are carried: nothing may be lost"),
    sabotage=Change("the words as printed: the common pixels are subtracted", printed=True),
)
def carried(same: Bool[np.ndarray, "paths steps"]) -> Finding:
    """Compare carried and full histograms."""
    return Finding(
        exact(float(same.mean()), about=f"of {same.size} steps"),
        {"paths without an error": proportion(int(same.all(axis=1).sum()), len(same))},
        note="The printed sentence subtracts the common pixels; it must be those that leave.",
    )


WIDTHS = (5, 10, 20, 40, 80, 160)


def saved(step: float, *, rng: np.random.Generator) -> Float[np.ndarray, " sizes"]:
    """Return what a step saves, by size; nothing is left to chance."""
    return savings(WIDTHS, step)


saving_by_size = Study(saved, full=0.0, quick=0.0, seed=78)


@saving_by_size.claim(
    "incremental-saving",
    paper=PAPER,
    place="§3.2, below eq. 28",
    basis="mathematics",
    statement="What the incremental count saves grows in proportion to the size of the ellipse.",
    paper_value="“this redundancy can be exploited”",
    method="Pixels of an ellipse over those that change when it moves by one pixel, counted for "
    "half widths from 5 to 160 px: exponent of a power law.",
    accepted=Accepted(
        0.9, 1.1, "area over circumference grows as the first power; a tenth for the raster",
        Origin.CHOICE,
    ),
    sabotage=Change("ellipses half a width apart", config=1.0),
)  # fmt: skip
def saving(found: Float[np.ndarray, " sizes"]) -> Finding:
    """Fit the growth of the saving."""
    full, carried_on = additions(20, 8)
    return Finding(
        exponent(np.array(WIDTHS, dtype=float), found),
        {
            "saving of a step at 20 px": exact(float(found[WIDTHS.index(20)])),
            "saving of a search of ± 8 px at 20 px": exact(full / carried_on),
        },
    )

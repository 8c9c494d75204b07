"""Adjacent ellipses share pixels: the next histogram from the last one, and what that saves."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int32

from data_synth.coloured import HeadScene
from data_synth.coloured import head as filmed
from robot_perception.appearance.colour_histograms import histogram, shares
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse, candidate_scores
from robot_perception.evaluation.intervals import exact, exponent, proportion
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

PAPER = "perception-issues"
SIZE = (320, 240)
REACHED = 818
"""Cells of a histogram that colours of bytes reach, of 16 × 16 × 8 of the opponent space."""


@dataclass(frozen=True, slots=True)
class Config:
    """Searches in a rendered picture; the paper gives no numbers.

    Parameters
    ----------
    half_widths
        Of the ellipses, one a search, px.
    searches
        Of each half width, round random places.
    radius
        Columns and rows to each side of the place that are searched, px.
    """

    half_widths: tuple[int, ...] = (5, 10, 20, 40)
    searches: int = 2
    radius: int = 8


def run(config: Config, *, rng: np.random.Generator) -> Bool[np.ndarray, "searches candidates"]:
    """Search as the tracker does; return whether each score is that of an ellipse counted anew."""
    index, binning, places = _picture(config, rng)
    same = []
    for half_width in config.half_widths:
        for place in places:
            model = histogram(index, binning.count, Ellipse(*place, half_width).mask(SIZE))
            how = {"half_widths": [half_width], "radius": config.radius}
            carried, full = (
                candidate_scores(index, place, shares(model), **how, incremental=incremental)
                for incremental in (True, False)
            )
            same.append((carried == full).ravel())
    return np.array(same)


def as_printed(
    config: Config, *, rng: np.random.Generator
) -> Bool[np.ndarray, "searches candidates"]:
    """Go along a row of ellipses, and subtract the pixels that two neighbours share."""
    index, binning, places = _picture(config, rng)
    same = []
    for half_width in config.half_widths:
        for u, v in places:
            before, row = Ellipse(u, v, half_width).mask(SIZE), []
            carried = histogram(index, binning.count, before)
            for step in range(1, config.radius + 1):
                after = Ellipse(u + step, v, half_width).mask(SIZE)
                carried = carried - histogram(index, binning.count, before & after)
                carried = carried + histogram(index, binning.count, after & ~before)
                row.append(np.array_equal(carried, histogram(index, binning.count, after)))
                before = after
            same.append(row)
    return np.array(same)


def _picture(
    config: Config, rng: np.random.Generator
) -> tuple[Int32[np.ndarray, "height width"], Binning, list[tuple[int, int]]]:
    """Return the bins of a rendered picture, their histogram's cells and where to search."""
    image, binning = filmed(rng=rng, frames=1, scene=HeadScene(others=0)).frames[0], Binning()
    places = rng.integers((60, 60), np.subtract(SIZE, 60), (config.searches, 2)).tolist()
    return binning.index(image), binning, [(u, v) for u, v in places]


def additions(half_width: int, radius: int, cells: int = 0) -> tuple[int, int]:
    """Return how often a number is added or subtracted in a search, in full and incrementally.

    To the side two pixels a row change, downwards two a column. The sum of eq. (28) costs its cells
    at every candidate, unless it is carried along as well.
    """
    side, ellipse = 2 * radius + 1, Ellipse(0, 0, half_width)
    rows, columns = 2 * int(ellipse.half_height + 1e-9) + 1, 2 * half_width + 1
    steps = side * (side - 1) * 2 * rows + (side - 1) * 2 * columns
    sums = side**2 * cells
    return side**2 * ellipse.pixels + sums, ellipse.pixels + steps + sums


def savings(
    half_widths: tuple[int, ...], step: float, cells: int = 0
) -> Float[np.ndarray, " sizes"]:
    """Return pixels of an ellipse over those that change when it moves aside.

    Parameters
    ----------
    half_widths
        px.
    step
        How far it moves: 0 for one pixel, else a share of its half width.
    cells
        That are summed up for eq. (28) besides, in both ways to count.
    """
    found = []
    for w in half_widths:
        moved = max(1, round(step * w))
        size = 2 * w + moved + 1, 2 * int(1.2 * w) + 1
        one = Ellipse(w, int(1.2 * w), w).mask(size)
        other = Ellipse(w + moved, int(1.2 * w), w).mask(size)
        found.append((one.sum() + cells) / ((one ^ other).sum() + cells))
    return np.array(found)


carrying = Study(run, full=Config(searches=20), quick=Config(), seed=77)


@carrying.claim(
    "incremental-histogram",
    paper=PAPER,
    place="§3.2, below eq. 28",
    basis="mathematics",
    statement="The histogram of an adjacent ellipse follows exactly from the last one when the "
    "pixels that leave are subtracted and those that enter are added.",
    paper_value="“by only subtracting those common pixels … and adding the new ones”",
    method="The tracker's own search for ellipses of four sizes in a rendered picture, which goes "
    "from candidate to adjacent candidate: share of the candidates whose score is exactly that of "
    "an ellipse counted anew.",
    accepted=Accepted(1.0, 1.0, "whole numbers are carried: nothing may be lost"),
    sabotage=Change("the words as printed: the common pixels are subtracted", run=as_printed),
)
def carried(same: Bool[np.ndarray, "searches candidates"]) -> Finding:
    """Compare carried scores and full ones."""
    return Finding(
        exact(float(same.mean()), about=f"of {same.size} candidates"),
        {"searches without an error": proportion(int(same.all(axis=1).sum()), len(same))},
        note="The printed sentence subtracts the common pixels; it must be those that leave.",
    )


WIDTHS = (5, 10, 20, 40, 80, 160)


def saved(step: float, *, rng: np.random.Generator) -> Float[np.ndarray, "2 sizes"]:
    """Return what a step saves, by size, without and with the cells; nothing is left to chance."""
    return np.array([savings(WIDTHS, step, cells) for cells in (0, REACHED)])


saving_by_size = Study(saved, full=0.0, quick=0.0, seed=78)
PROPORTIONAL = Accepted(
    0.9, 1.1, "area over circumference grows as the first power; a tenth for the raster",
    Origin.CHOICE,
)  # fmt: skip


@saving_by_size.claim(
    "incremental-saving",
    paper=PAPER,
    place="§3.2, below eq. 28",
    basis="mathematics",
    statement="What the incremental count saves grows in proportion to the size of the ellipse.",
    paper_value="“this redundancy can be exploited”",
    method="Pixels of an ellipse over those that change when it moves by one pixel, counted for "
    "half widths from 5 to 160 px: exponent of a power law. Once with the sum of eq. 28 carried "
    f"along, as the tracker does, once summed over its {REACHED} cells at every candidate.",
    accepted=PROPORTIONAL,
    sabotage=Change("ellipses half a width apart", config=1.0),
)
def saving(found: Float[np.ndarray, "2 sizes"]) -> Finding:
    """Fit the growth of the saving; summed anew it is in proportion for no doubling of the size."""
    carried_along, summed = found
    at = WIDTHS.index(20)
    doublings = [exact(float(e)) for e in np.diff(np.log2(summed))]
    full, carried_on = additions(20, 8)
    return Finding(
        exponent(np.array(WIDTHS, dtype=float), carried_along),
        {
            "saving of a step at 20 px": exact(float(carried_along[at])),
            "saving of a step at 20 px, eq. 28 summed": exact(float(summed[at])),
            "exponent from 5 to 10 px, eq. 28 summed": doublings[0],
            "exponent from 80 to 160 px, eq. 28 summed": doublings[-1],
            "saving of a search of ± 8 px at 20 px": exact(full / carried_on),
        },
        conditions=(
            Condition(
                "the sum of eq. 28 is carried along, too",
                all(PROPORTIONAL.excludes(value) for value in doublings),
            ),
        ),
    )

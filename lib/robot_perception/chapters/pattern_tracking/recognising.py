"""Patterns that the robot chooses itself, found again in another picture: section 3.2."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from data_synth.ceiling import CeilingCamera, Exposure, Mount, make_ceiling
from robot_perception.ceiling.contours import find_contours, find_edges
from robot_perception.ceiling.patterns import Pattern, interest_windows, make_pattern
from robot_perception.ceiling.recognition import EdgeField, recognise
from robot_perception.ceiling.tracker import Layers, PatternTracker
from robot_perception.chapters.pattern_tracking.scene import RULES
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

PAPER = "ceiling-navigation"
NEAR = 5.0
"""A find is right that is no further off, px; ours."""
MATCH = 0.88
"""A find is believed whose vectors correlate as much in the mean; ours."""
TRIED = 5
"""Places by contours among which the vectors choose; ours."""
LOOK = replace(RULES, passes=2)
"""A tracker takes three looks at each of these places."""
CHOOSING = tuple(range(100, 116))
"""Ceilings on which numbers were chosen."""


@dataclass(frozen=True, slots=True)
class Config:
    """Pairs of pictures of a ceiling.

    Parameters
    ----------
    seeds
        Of ceilings, and of where the pictures are taken.
    kind
        Of ceilings.
    pairs
        Of pictures, each ceiling.
    """

    seeds: tuple[int, ...] = tuple(range(300, 360))
    kind: str = "varied"
    pairs: int = 5


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What became of the patterns, a row each.

    Parameters
    ----------
    ceiling : (n,)
        Number of its ceiling.
    contours : (n,)
        Whether the best place by contours is right; false where there is none.
    vectors : (n,)
        Whether the place that the vectors choose is right.
    match : (n,)
        Mean correlation there; -1 where there is no place.
    absent : (n,)
        The highest mean correlation in a picture in which the pattern is not.
    """

    ceiling: np.ndarray
    contours: np.ndarray
    vectors: np.ndarray
    match: np.ndarray
    absent: np.ndarray

    def share(self, right: np.ndarray) -> Interval:
        """Return a mean over the ceilings of the share of patterns."""
        each = [right[self.ceiling == k].mean() for k in np.unique(self.ceiling)]
        return bootstrap_mean(np.array(each, dtype=float))


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Choose patterns in one picture of each pair, and look for them in the other."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        return ceiling(seed, config, rng)

    rows = sweep(task, config.seeds, rng=rng, desc="ceilings")
    at = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    right, vectors, match, absent = np.concatenate(rows).T
    return Result(at, right == 1, vectors == 1, match, absent)


@lru_cache(maxsize=2)
def camera(kind: str, seed: int) -> CeilingCamera:
    """Return a camera below a ceiling of 8 m."""
    return CeilingCamera(make_ceiling(kind, rng=np.random.default_rng(seed), side=8.0), Mount())


def ceiling(seed: int, config: Config, rng: np.random.Generator) -> Float[np.ndarray, "n 4"]:
    """Return what became of the patterns of one ceiling."""
    below, other = camera(config.kind, seed), camera(config.kind, seed + 1000)
    rows = []
    for _ in range(config.pairs):
        here = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-np.pi, np.pi)])
        away = [*rng.uniform(-0.4, 0.4, 2), rng.uniform(-np.pi, np.pi)]
        there = here + np.array(away)
        first = below.image(here, exposure=Exposure(noise=2.0), rng=rng)
        light = Exposure(gain=rng.uniform(0.7, 1.2), offset=rng.uniform(-10, 10), noise=2.0)
        second = below.image(there, exposure=light, rng=rng)
        elsewhere = other.image(there, exposure=light, rng=rng)
        for pattern, place in chosen(first):
            truth = carried(below, here, there, place)
            if inside(truth, second.shape):
                found = looked_for(pattern, second, truth, rng)
                rows.append([*found, looked_for(pattern, elsewhere, truth, rng)[2]])
    return np.array(rows).reshape(-1, 4)


def chosen(image: np.ndarray) -> list[tuple[Pattern, np.ndarray]]:
    """Return the patterns that the robot chooses in a picture, and where they are."""
    edges = find_edges(image)
    windows = interest_windows(edges, find_contours(edges))
    return [(make_pattern(image, w.centre, w.size), np.array(w.centre)) for w in windows]


def carried(
    below: CeilingCamera, here: np.ndarray, there: np.ndarray, place: Float[np.ndarray, "2"]
) -> Float[np.ndarray, "2"]:
    """Return where a place of one picture is in the other, px, by what the world tells."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    (a, *sides), (b, *others) = (below.points_seen(pose, corners) for pose in (here, there))
    shares = np.linalg.solve((np.array(sides) - a).T, place - a)
    return b + (np.array(others) - b).T @ shares


def inside(place: np.ndarray, shape: tuple[int, ...], border: float = 45.0) -> bool:
    """Tell whether a whole window is in a picture, however it is turned."""
    size = np.array(shape[::-1])
    return bool(((place >= border) & (place <= size - 1 - border)).all())


def looked_for(
    pattern: Pattern, image: np.ndarray, truth: np.ndarray, rng: np.random.Generator
) -> tuple[bool, bool, float]:
    """Return whether contours find it, whether vectors do, and how these correlate."""
    edges = find_edges(image)
    places = recognise(pattern, EdgeField(edges), find_contours(edges))[:TRIED]
    if not places:
        return False, False, -1.0
    tracker, layers = PatternTracker(pattern, LOOK), Layers(image)
    infos = [tracker.step(tracker.start(one.pose), layers, rng=rng)[1] for one in places]
    matches = [float(np.nan_to_num(info.correlation, nan=-1.0).mean()) for info in infos]
    best = int(np.argmax(matches))
    off = [float(np.hypot(*(p[:2] - truth))) for p in (places[0].pose, infos[best].pose)]
    return off[0] <= NEAR, off[1] <= NEAR, matches[best]


recognised = Study(run, full=Config(), quick=Config((300, 301, 302, 303), pairs=3), seed=37)
FOUND = Accepted(0.9, 1.0, "nine of ten patterns; the paper names no number", Origin.CHOICE)


def table(result: Result) -> Table:
    """Return how many are found, and how many finds are right, by who decides."""
    believed, false = result.match >= MATCH, result.absent >= MATCH
    heads = {
        "found": "share of the patterns in view that are found where they are; by vectors only "
        f"if they correlate by {MATCH:g} in the mean",
        "right": "share right of all finds, as many pictures with the pattern as without",
    }
    n = len(result.match)
    contours = int((result.match >= 0).sum() + (result.absent >= 0).sum())  # any place is a find
    rows = {
        "contours, best place": [result.share(result.contours),
                                 proportion(int(result.contours.sum()), contours)],
        f"vectors among {TRIED} places": [
            result.share(result.vectors & believed),
            proportion(int((result.vectors & believed).sum()), int(believed.sum() + false.sum())),
        ],
    }  # fmt: skip
    about = f"95 % over {len(np.unique(result.ceiling))} ceilings, {n} patterns"
    return Table(rows, heads, about, "who decides")


@recognised.claim(
    "pattern-model",
    paper=PAPER,
    place="§3.2, eq. 4",
    basis="substitute",
    statement="Patterns are chosen and recognised automatically by their contours.",
    paper_value="“The contour representation is used to automatic generation and recognition”",
    method="Rendered ceilings, patterns chosen in one picture and looked for in another one, moved "
    "by up to half a metre, turned at random and in other light: share whose best place by "
    "contours is within 5 px of the truth. Mean over ceilings.",
    accepted=FOUND,
    sabotage=Change("ceilings whose things repeat", kind="repeated"),
)
def pattern_model(result: Result) -> Finding:
    """Compare contours alone with vectors that choose among their places."""
    contours, vectors = result.share(result.contours), result.share(result.vectors)
    n = len(result.match)
    return Finding(
        contours,
        {
            "found, vectors choose": vectors,
            "absent ones that vectors believe": proportion(int((result.absent >= MATCH).sum()), n),
            "present ones that vectors believe": proportion(int((result.match >= MATCH).sum()), n),
        },
        tables={"found": table(result)},
        conditions=(
            Condition.judged(
                "grey vectors choose among the places that contours suggest",
                FOUND,
                inside=vectors,
                outside=contours,
            ),
        ),
    )

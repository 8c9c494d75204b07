"""Fig. 4: maps of one drive with few and with many particles, and the claims about them."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.evaluation.sweep import sweep
from robot_perception.evaluation.trajectories import absolute_error, align
from robot_perception.geometry import act
from robot_perception.landmarks import StereoRules
from robot_perception.landmarks.metrics import METRICS, euclidean_mean
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

PAPER = "sift-slam"
TOLD = "told"
"""In place of a metric: the renderer names the landmarks."""
SHARE_RIGHT = 0.95
"""Of the landmarks that must lie in the room in which they are; ours."""
MARGIN = 0.5
"""How far beyond its floor a landmark still lies in a room, and how far apart two pictures of a
place may be before the room counts as drawn twice, m: half a doorway; ours."""
QUICK = frontend.SCORED[:4]
"""Buildings of the quick size."""
LEAST = 5
"""Frames of a visit of a room; the robot may cut a corner of one."""


# Topology ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Topology:
    """Whether a map has the right rooms in the right order, and none twice; the criterion is ours.

    After the best rigid motion of the path: the share of the landmarks that lie in the room in
    which they are; whether the path passes the rooms in the order in which the robot did; and how
    far two visits of one room lie apart in the map, m, where that is most: the distance between
    the mean errors of the path.
    """

    inside: float
    ordered: bool
    apart: float

    @property
    def right(self) -> bool:
        """Whether all three are as they should be."""
        return self.inside >= SHARE_RIGHT and self.ordered and self.apart < MARGIN


@cache
def rooms() -> Float[np.ndarray, "rooms 2 2"]:
    """Return the floors, of all buildings the same: lower and upper corner of each, m."""
    building, _ = frontend.world()
    frames = building.scene.frames[building.kinds == "floor"][:, :2]
    corners = frames[..., 2, None] + np.stack(
        [0 * frames[..., 0], frames[..., 0], frames[..., 1], frames[..., 0] + frames[..., 1]], -1
    )
    return np.stack([corners.min(axis=-1), corners.max(axis=-1)], axis=1)


def room_of(places: np.ndarray) -> np.ndarray:
    """Return the room that each place lies in or is nearest to."""
    low, high = rooms().swapaxes(0, 1)
    gap = np.maximum(low - places[:, None, :2], places[:, None, :2] - high)
    return np.linalg.norm(gap.clip(0), axis=-1).argmin(axis=1)


def topology(drive: Drive) -> Topology:
    """Measure whether a map is topologically right."""
    truth = drive.seen.poses
    motion = align(drive.path, truth)
    map_, path = act(motion, drive.means[:, :2]), act(motion, drive.path[:, :2])
    low, high = rooms()[room_of(drive.places)].swapaxes(0, 1)
    inside = ((map_ >= low - MARGIN) & (map_ <= high + MARGIN)).all(axis=1)
    return Topology(
        float(inside.mean()),
        order(room_of(path)) == order(room_of(truth)),
        _apart(path - truth[:, :2], room_of(truth)),
    )


def order(rooms: np.ndarray) -> list[int]:
    """Return the rooms of a path without repetitions."""
    return rooms[np.flatnonzero(np.diff(rooms, prepend=-1))].tolist()


def _apart(errors: np.ndarray, rooms: np.ndarray) -> float:
    """Return how far two visits of one room lie apart in the map, where that is most."""
    visits = np.split(np.arange(len(rooms)), np.flatnonzero(np.diff(rooms)) + 1)
    means = [(rooms[v[0]], errors[v].mean(axis=0)) for v in visits if len(v) >= LEAST]
    gaps = [np.hypot(*(a - b)) for one, a in means for other, b in means if one == other]
    return float(max(gaps))


# Many drives -------------------------------------------------------------------------------------

Numbers = Float[np.ndarray, "*buildings drives"]


class Account(NamedTuple):
    """What is kept of many drives, a number each.

    Errors in m: absolute trajectory error of the path as it is and after the best rigid motion,
    error at the end; the same of the path by the wheels alone; after the same motion, how far half
    of the landmarks are at most from their places, in the plane.
    """

    path: Numbers
    aligned: Numbers
    end: Numbers
    wheels: Numbers
    wheels_aligned: Numbers
    wheels_end: Numbers
    places: Numbers
    landmarks: Numbers
    matched: Numbers
    wrong: Numbers
    twice: Numbers
    inside: Numbers
    right: Numbers
    drawn: Numbers
    effective: Numbers


def misplaced(drive: Drive) -> float:
    """Return how far half of the landmarks are at most from their places, in the plane, m."""
    motion = align(drive.path, drive.seen.poses)
    return float(np.median(np.hypot(*(act(motion, drive.means[:, :2]) - drive.places[:, :2]).T)))


def account(drive: Drive) -> tuple[float, ...]:
    """Return what an `Account` keeps of a drive."""
    truth, found, weighed = drive.seen.poses, topology(drive), drive.observed > 0
    errors = [
        (
            absolute_error(path, truth, False),
            absolute_error(path, truth, True),
            float(np.hypot(*(path[-1] - truth[-1])[:2])),
        )
        for path in (drive.path, drive.odometry)
    ]
    return (
        *errors[0],
        *errors[1],
        misplaced(drive),
        len(drive.founders),
        drive.matched,
        drive.wrong,
        drive.twice,
        found.inside,
        found.right,
        drive.drawn[weighed].mean(),
        drive.effective[weighed].mean() / drive.options.particles,
    )


class Filter(NamedTuple):
    """A filter that drives: its name, which is a row of tables, how it runs, whom it asks.

    It asks one of the metrics which landmark it is, or the renderer: `TOLD`.
    """

    name: str
    options: Options = Options()
    metric: str = "Euclid to the mean"


@dataclass(frozen=True, slots=True)
class Config:
    """Filters that run over the same drives; Fig. 4 of the paper shows one drive.

    Parameters
    ----------
    filters
        Those that are compared.
    draws
        Of the wheels' noise in each building, for which the pictures are the same; ours.
    buildings
        Their numbers.
    frames
        Of the beginning of the drive.
    lasting
        Points whose tracks do not last for more than so many frames are left out beforehand.
    """

    filters: tuple[Filter, ...]
    draws: int
    buildings: tuple[int, ...] = frontend.SCORED
    frames: int = frontend.FRAMES
    lasting: int = 0


def run(config: Config, *, rng: np.random.Generator) -> dict[str, Account]:
    """Run the filters over the same drives: the same wheels and the same draws for all."""
    for k in config.buildings:
        frontend.seen(config.frames, k)  # before the work is handed out
    drives = [(config, k) for k in config.buildings for _ in range(config.draws)]
    done = np.array(sweep(_accounts, drives, rng=rng, desc="drives"), dtype=float)
    kept = np.moveaxis(done.reshape(-1, config.draws, *done.shape[1:]), (2, 3), (0, 1))
    return {f.name: Account(*own) for f, own in zip(config.filters, kept, strict=True)}


def _accounts(drive: tuple[Config, int], *, rng: np.random.Generator) -> list[tuple[float, ...]]:
    config, building = drive
    seen = frontend.lasting(frontend.seen(config.frames, building), config.lasting)
    wheel, own = rng.spawn(2)
    report = drives.roll(seen.poses, rng=wheel)
    return [
        account(
            drives.run(
                seen,
                f.options,
                report,
                rng=deepcopy(own),
                told=f.metric == TOLD,
                metric=METRICS.get(f.metric, euclidean_mean),
            )
        )
        for f in config.filters
    ]


# Over buildings ----------------------------------------------------------------------------------


def mean(numbers: Numbers, unit: str = "") -> Interval:
    """Return the mean over buildings, of the mean of the drives through each."""
    return _over(bootstrap_mean(numbers.mean(axis=-1), unit), "mean")


def ratio(above: Numbers, below: Numbers, about: str = "ratio") -> Interval:
    """Return the ratio of two means over the same buildings."""
    return _over(bootstrap_ratio(above.mean(axis=-1), below.mean(axis=-1)), about)


def _over(found: Interval, about: str) -> Interval:
    return replace(found, about=f"{about}, 95 % bootstrap over buildings")


def worst(numbers: Numbers) -> float:
    """Return the mean of the drives through the building where it is largest."""
    return float(numbers.mean(axis=-1).max())


def over_drives(found: Mapping[str, Account]) -> str:
    """Return what the numbers of a table are."""
    buildings, draws = next(iter(found.values())).path.shape
    return f"mean and 95 % bootstrap interval over {buildings} buildings, each driven {draws} ×"


# The claims --------------------------------------------------------------------------------------


def error_table(found: Mapping[str, Account]) -> Table:
    """Return the errors by number of particles, with the wheels alone as base line."""
    some = next(iter(found.values()))
    alone = (some.wheels, some.wheels_aligned, some.wheels_end)
    rows = {"wheels alone": (*(mean(error, "m") for error in alone), None, None, None)} | {
        name: (
            *(mean(error, "m") for error in (a.path, a.aligned, a.end)),
            worst(a.path),
            mean(a.landmarks),
            f"{a.right.sum():.0f} of {a.right.size}",
        )
        for name, a in found.items()
    }
    columns = {
        "ATE (m)": "absolute trajectory error: root mean squared error of the position",
        "aligned (m)": "the same after the best rigid motion",
        "end (m)": "error of the position at the end",
        "worst (m)": "ATE in the building where it is largest",
        "landmarks": "in the map at the end",
        "right": "drives whose map is topologically right",
    }
    return Table(rows, columns, over_drives(found), "particles")


def building_table(found: Mapping[str, Account]) -> Table:
    """Return errors and right maps by building."""
    draws = next(iter(found.values())).path.shape[1]
    cells = [
        (a.path.mean(axis=1).round(2), [f"{n:.0f} of {draws}" for n in a.right.sum(axis=1)])
        for a in found.values()
    ]
    rows = {
        f"{k + 1}": tuple(column[k] for cell in cells for column in cell)
        for k in range(len(cells[0][0]))
    }
    columns = {
        head: words
        for name in found
        for head, words in ((f"{name}, ATE (m)", "mean"), (f"{name}, right", "of the drives"))
    }
    return Table(rows, columns, f"the same {draws} drives through each building", "building")


def match_table(found: Mapping[str, Account], corner: str = "particles") -> Table:
    """Return what was recognised, what wrongly, and what not."""
    rows = {name: tuple(map(mean, (a.matched, a.wrong, a.twice))) for name, a in found.items()}
    columns = {
        "recognised": "new tracks that were taken for a landmark of the map",
        "wrong": "of these, tracks of a place that the landmark was not made of",
        "again": "landmarks made of a place of which there was one already",
    }
    return Table(rows, columns, over_drives(found), corner)


def setup_table() -> Table:
    """Return the paper's values and ours."""
    rules, options = StereoRules(), Options()
    rows = {
        "place": ("building 79, Freiburg", "rendered, rooms along a corridor", "yes: what is seen"),
        "stereo pairs": ("507, 320 × 240", "507, 320 × 240", "no"),
        "path": ("about 80 m", "81 m", "no"),
        "wheels": ("not given", "1° for each √m, 2° for each √rad turned", "yes"),
        "stereo match": (
            "±2 rows, a threshold",
            f"±{rules.rows:g} rows, {rules.threshold:g} of a length of 512",
            "little",
        ),
        "stable": (*[f"more than {options.stable} frames"] * 2, "yes"),
    }
    return Table(rows, {"paper": "sections 3 and 5", "ours": "", "matters": ""})


def counted(*counts: int) -> tuple[Filter, ...]:
    """Return filters with some numbers of particles; Fig. 4: 1, 10 and 100, the text: 50."""
    return tuple(Filter(f"M = {count}", Options(count)) for count in counts)


TEN = Study(
    run,
    full=Config((*counted(1, 10, 50, 100), Filter(TOLD, metric=TOLD)), 3),
    quick=Config(counted(10), 3, QUICK),
    seed=41,
)


@TEN.claim(
    "map-10",
    paper=PAPER,
    place="§5, Fig. 4b",
    basis="substitute",
    statement="With only 10 particles the map is topologically correct.",
    paper_value="one map, “topologically correct”",
    method="Ten rendered buildings, in which nothing was chosen, 507 stereo pairs each, three draws "
    "of the wheels: share of the maps that have 95 % of their landmarks in the room in which they "
    "are (half a doorway of tolerance), the rooms of the path in the right order, and no room "
    "drawn twice; interval over the buildings.",
    accepted=Accepted(
        0.5, 1.0, "a map is right more often than not; the paper shows one", "our choice"
    ),
    sabotage=Change(
        "a filter that recognises nothing", filters=(Filter("M = 10", Options(limit=0.0)),), draws=1
    ),
    value=lambda found: mean(found["M = 10"].right),
)
def map_10(found: dict[str, Account], value: Interval) -> Finding:
    """Count the maps that are topologically right."""
    ten = found["M = 10"]
    counted = {name: a for name, a in found.items() if name != TOLD}
    evidence: dict[str, Interval] = {}
    for name, a in counted.items():
        evidence |= {
            f"maps that are right, {name}": mean(a.right),
            f"landmarks in their room, {name}": mean(a.inside),
            f"ATE, {name}": mean(a.path, "m"),
        }
    if TOLD in found:
        evidence["ATE, landmarks told over recognised, M = 10"] = ratio(found[TOLD].path, ten.path)
    evidence |= {
        "wheels alone, ATE": mean(ten.wheels, "m"),
        "wrong among the recognised, M = 10": ratio(ten.wrong, ten.matched),
        "buildings where all maps are right, M = 10": mean(ten.right.min(axis=1, keepdims=True)),
    }
    return Finding(
        value,
        evidence,
        {
            "errors": error_table(counted),
            "matches": match_table(counted),
            "buildings": building_table(counted),
        },
        note=f"{ten.right.sum():.0f} of {ten.right.size} maps are right; "
        f"{ten.inside.mean():.1%} of the landmarks lie in their room.",
    )


FIFTY = Study(
    run,
    full=Config(counted(1, 10, 50, 400), 2),
    quick=Config(counted(10, 50, 400), 1, QUICK),
    seed=42,
)


@FIFTY.claim(
    "map-50",
    paper=PAPER,
    place="§5",
    basis="substitute",
    statement="Correct maps are built with 50 particles; 400 are not needed.",
    paper_value="50 particles, against 400 of Sim et al. (2005)",
    method="Ten rendered buildings, two draws of the wheels: trajectory error with 50 particles "
    "over that with 400, interval over the buildings. Beside it the same with 10.",
    accepted=Accepted(
        0.0, 1.5, "fifty leave at most half as much error again as four hundred", "our choice"
    ),
    sabotage=Change(
        "one particle in place of fifty",
        filters=(*counted(10), Filter("M = 50", Options(1)), *counted(400)),
    ),
)
def map_50(found: dict[str, Account]) -> Finding:
    """Compare the errors with 50 and with 400 particles on the same drives."""
    ten, fifty, many = (found[f"M = {count}"] for count in (10, 50, 400))
    evidence = {
        f"ATE, {name.removeprefix('M = ')} particles over 400": ratio(a.path, many.path)
        for name, a in found.items()
        if a is not many
    }
    evidence |= {"ATE, 10 particles over 50": ratio(ten.path, fifty.path)}
    for name, a in found.items():
        evidence |= {
            f"maps that are right, {name}": mean(a.right),
            f"ATE in the worst building, {name}": exact(worst(a.path), "m"),
        }
    return Finding(
        ratio(fifty.path, many.path, "ATE, 50 over 400"),
        evidence
        | {
            "aligned, 50 over 400": ratio(fifty.aligned, many.aligned),
            "landmarks, M = 50": mean(fifty.landmarks),
        },
        {"errors": error_table(found), "buildings": building_table(found)},
        note=f"The error is {ten.path.mean():.2f} m with 10 particles, {fifty.path.mean():.2f} m "
        f"with 50, {many.path.mean():.2f} m with 400.",
    )

"""Fig. 4: maps of one drive with few and with many particles, and the claims about them."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
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
from robot_perception.landmarks.metrics import METRICS
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Cell, Table
from robot_perception.teaching.verdicts import Accepted

PAPER = "sift-slam"
TOLD = "told"
"""In place of a metric: the renderer names the landmarks."""
SHARE_RIGHT = 0.95
"""Of the landmarks that must lie in the room in which they are; ours."""
MARGIN = 0.5
"""How far beyond its floor a landmark still lies in a room, and how far apart two pictures of a
place may be before the room counts as drawn twice, m: half a doorway; ours."""
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
    """Filters that run over the same drives; Fig. 4 of the paper shows one drive, all else is ours.

    In each building wheels' noise is drawn ``draws`` times; the pictures are the same. The drives
    end after ``frames``. Tracks of no more than ``lasting`` frames are left out beforehand.
    """

    filters: tuple[Filter, ...]
    draws: int
    buildings: tuple[int, ...] = frontend.SCORED
    frames: int = frontend.FRAMES
    lasting: int = 0


def run(config: Config, *, rng: np.random.Generator) -> dict[str, Account]:
    """Run the filters over the same drives: the same wheels and the same draws for all."""
    films = [(config.frames, k) for k in config.buildings]
    sweep(_watch, films, rng=np.random.default_rng(0), desc="films")  # no film is made twice
    each = [(config, k) for k in config.buildings for _ in range(config.draws)]
    done = np.array(sweep(_accounts, each, rng=rng, desc="drives"), dtype=float)
    kept = np.moveaxis(done.reshape(-1, config.draws, *done.shape[1:]), (2, 3), (0, 1))
    return {f.name: Account(*own) for f, own in zip(config.filters, kept, strict=True)}


def _watch(film: tuple[int, int], *, rng: np.random.Generator) -> None:
    """Let a film be seen, which is kept; it has draws of its own."""
    frontend.seen(*film)


def _accounts(one: tuple[Config, int], *, rng: np.random.Generator) -> list[tuple[float, ...]]:
    config, building = one
    seen = frontend.lasting(frontend.seen(config.frames, building), config.lasting)
    wheel, own = rng.spawn(2)
    report = drives.roll(seen.poses, rng=wheel)
    found = []
    for f in config.filters:
        who = {"told": True} if f.metric == TOLD else {"metric": METRICS[f.metric]}
        found.append(account(drives.run(seen, f.options, report, rng=deepcopy(own), **who)))
    return found


# Over buildings ----------------------------------------------------------------------------------


def mean(numbers: Numbers, unit: str = "") -> Interval:
    """Return the mean over buildings, of the mean of the drives through each."""
    return _over(bootstrap_mean(numbers.mean(axis=-1), unit), "mean")


def ratio(above: Numbers, below: Numbers, about: str = "ratio") -> Interval:
    """Return the ratio of two means over the same buildings."""
    return _over(bootstrap_ratio(above.mean(axis=-1), below.mean(axis=-1)), about)


def _over(found: Interval, about: str) -> Interval:
    return replace(found, about=f"{about}, 95 % bootstrap over buildings")


def wrong_share(found: Account) -> Float[np.ndarray, "buildings 1"]:
    """Return the share of wrong ones among the tracks that were recognised."""
    return (found.wrong.sum(axis=1) / found.matched.sum(axis=1))[:, None]


COLUMNS: Mapping[str, tuple[str, Callable[[Account], Cell]]] = MappingProxyType(
    {
        "ATE (m)": ("root mean squared error of the position", lambda a: mean(a.path, "m")),
        "aligned (m)": ("the same after the best rigid motion", lambda a: mean(a.aligned, "m")),
        "end (m)": ("error of the position at the end", lambda a: mean(a.end, "m")),
        "worst (m)": ("ATE in the building where it is largest", lambda a: worst(a.path)),
        "places (m)": ("half of the landmarks err by less", lambda a: mean(a.places, "m")),
        "landmarks": ("in the map at the end", lambda a: mean(a.landmarks)),
        "right": ("share of maps that are topologically right", lambda a: mean(a.right)),
        "recognised": ("tracks taken for a landmark of the map", lambda a: mean(a.matched)),
        "wrong": ("of these, tracks of another place", lambda a: mean(a.wrong)),
        "wrong share": ("share of such tracks", lambda a: mean(wrong_share(a))),
        "again": ("landmarks of a place that had one already", lambda a: mean(a.twice)),
        "drawn": ("share of frames after which particles are drawn", lambda a: a.drawn.mean()),
        "effective": ("number before that, as a share of M", lambda a: a.effective.mean()),
    }
)
"""What a table can say of drives: in words, and the number."""


def table(found: Mapping[str, Account], columns: Sequence[str], corner: str) -> Table:
    """Return a row for each filter."""
    buildings, draws = next(iter(found.values())).path.shape
    rows = {name: tuple(COLUMNS[column][1](a) for column in columns) for name, a in found.items()}
    about = f"mean and 95 % bootstrap interval over {buildings} buildings, each driven {draws} ×"
    return Table(rows, {column: COLUMNS[column][0] for column in columns}, about, corner)


def worst(numbers: Numbers) -> float:
    """Return the mean of the drives through the building where it is largest."""
    return float(numbers.mean(axis=-1).max())


# The claims --------------------------------------------------------------------------------------


def error_table(found: Mapping[str, Account]) -> Table:
    """Return the errors by number of particles, with the wheels alone as base line."""
    columns = "ATE (m)", "aligned (m)", "end (m)", "worst (m)", "landmarks", "right"
    whole, some = table(found, columns, "particles"), next(iter(found.values()))
    errors = (mean(error, "m") for error in (some.wheels, some.wheels_aligned, some.wheels_end))
    alone = (*errors, worst(some.wheels), None, None)
    return replace(whole, rows={"wheels alone": alone} | dict(whole.rows))


def building_table(found: Mapping[str, Account]) -> Table:
    """Return errors and right maps by building."""
    return by_building(
        {
            f"{name}, {head}": values
            for name, a in found.items()
            for head, values in (("ATE (m)", a.path), ("right", a.right))
        }
    )


def by_building(columns: Mapping[str, Numbers]) -> Table:
    """Return the means of some numbers in each building, a row by its number."""
    cells = np.transpose([numbers.mean(axis=-1) for numbers in columns.values()])
    rows = {f"{k}": row.tolist() for k, row in zip(frontend.SCORED, cells, strict=False)}
    drives = max(numbers.shape[-1] for numbers in columns.values())
    about = f"means of the drives through each building, {drives} of each filter"
    return Table(rows, dict.fromkeys(columns, "mean"), about, "building")


def more_right(buildings: Table) -> Interval:
    """Return by how much more of the maps are right with 50 particles than with 10.

    The table is that of `building_table`; drives through a building are paired.
    """
    few, many = (
        np.array([buildings[row, f"M = {count}, right"] for row in buildings.rows])
        for count in (10, 50)
    )
    return mean((many - few)[:, None])


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
    quick=Config(counted(10), 2, frontend.FEW),
    seed=41,
)


@TEN.claim(
    "map-10",
    paper=PAPER,
    place="§5, Fig. 4b",
    basis="substitute",
    statement="With only 10 particles the map is topologically correct.",
    paper_value="one map, “topologically correct”",
    method="Twenty rendered buildings, in which nothing was chosen, 507 stereo pairs each, three "
    "draws of the wheels: share of the maps that have 95 % of their landmarks in the room in which "
    "they are (half a doorway of tolerance), the rooms of the path in the right order, and no room "
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
        evidence[f"maps that are right, {name}"] = mean(a.right)
        evidence[f"ATE, {name}"] = mean(a.path, "m")
    if TOLD in found:
        evidence["ATE, landmarks told over recognised, M = 10"] = ratio(found[TOLD].path, ten.path)
    evidence["wheels alone, ATE"] = mean(ten.wheels, "m")
    evidence["wrong among the recognised, M = 10"] = ratio(ten.wrong, ten.matched)
    always = ten.right.min(axis=1, keepdims=True)
    evidence["buildings where all maps are right, M = 10"] = mean(always)
    return Finding(
        value,
        evidence,
        {
            "errors": error_table(counted),
            "matches": table(counted, ("recognised", "wrong", "again"), "particles"),
            "buildings": building_table(counted),
        },
        note=f"{ten.right.sum():.0f} of {ten.right.size} maps are right; "
        f"{ten.inside.mean():.1%} of the landmarks lie in their room.",
    )


FIFTY = Study(
    run,
    full=Config(counted(1, 10, 50, 400), 3),
    quick=Config(counted(50, 400), 2, frontend.FEW),
    seed=42,
)


@FIFTY.claim(
    "map-50",
    paper=PAPER,
    place="§5",
    basis="substitute",
    statement="Correct maps are built with 50 particles; 400 are not needed.",
    paper_value="50 particles, against 400 of Sim et al. (2005)",
    method="Twenty rendered buildings, three draws of the wheels: trajectory error with 50 "
    "particles over that with 400, interval over the buildings. Beside it the same with 10.",
    accepted=Accepted(
        0.0, 1.5, "fifty leave at most half as much error again as four hundred", "our choice"
    ),
    sabotage=Change(
        "one particle in place of fifty",
        filters=(Filter("M = 50", Options(1)), *counted(400)),
    ),
)
def map_50(found: dict[str, Account]) -> Finding:
    """Compare the errors with 50 and with 400 particles on the same drives."""
    fifty, many = found["M = 50"], found["M = 400"]
    evidence = {
        f"ATE, {name.removeprefix('M = ')} particles over 400": ratio(a.path, many.path)
        for name, a in found.items()
        if a is not many
    }
    for name, a in found.items():
        evidence[f"maps that are right, {name}"] = mean(a.right)
        evidence[f"ATE in the worst building, {name}"] = exact(worst(a.path), "m")
    return Finding(
        ratio(fifty.path, many.path, "ATE, 50 over 400"),
        evidence | {"aligned, 50 over 400": ratio(fifty.aligned, many.aligned)},
        {"errors": error_table(found), "buildings": building_table(found)},
        note=f"With 50 particles the error is {fifty.path.mean():.2f} m, with 400 "
        f"{many.path.mean():.2f} m.",
    )

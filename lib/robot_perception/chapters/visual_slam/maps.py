"""Fig. 4: maps of one drive with few and with many particles, and the claims about them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.chapters.visual_slam.frontend import Seen
from robot_perception.evaluation.intervals import (
    Interval,
    bootstrap_mean,
    bootstrap_ratio,
    proportion,
)
from robot_perception.evaluation.sweep import sweep
from robot_perception.evaluation.trajectories import absolute_error, align
from robot_perception.geometry import act
from robot_perception.landmarks import StereoRules
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

PAPER = "sift-slam"
TOLD = "told"
"""Name of the filter to which the renderer names the landmarks."""
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
    """Return the floors of the building: lower and upper corner of each, m."""
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

Numbers = Float[np.ndarray, "drives"]


class Account(NamedTuple):
    """What is kept of many drives, a number each.

    Errors in m: absolute trajectory error of the path as it is and after the best rigid motion,
    error at the end; the same of the path by the wheels alone.
    """

    path: Numbers
    aligned: Numbers
    end: Numbers
    wheels: Numbers
    wheels_aligned: Numbers
    wheels_end: Numbers
    landmarks: Numbers
    matched: Numbers
    wrong: Numbers
    twice: Numbers
    inside: Numbers
    right: Numbers
    drawn: Numbers
    effective: Numbers

    @property
    def share_right(self) -> Interval:
        """Share of the maps that are topologically right."""
        return proportion(int(self.right.sum()), self.right.size)


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
        len(drive.founders),
        drive.matched,
        drive.wrong,
        drive.twice,
        found.inside,
        found.right,
        drive.drawn[weighed].mean(),
        drive.effective[weighed].mean() / drive.options.particles,
    )


@dataclass(frozen=True, slots=True)
class Config:
    """Filters that run over the same drives; Fig. 4 of the paper shows one drive.

    Parameters
    ----------
    filters
        A name, which is a row of tables, and how it runs. To `TOLD` the renderer names the
        landmarks.
    seeds
        Draws of the wheels' noise, for which the pictures are the same; ours.
    frames
        Of the beginning of the drive.
    lasting
        Points whose tracks do not last for more than so many frames are left out beforehand.
    """

    filters: tuple[tuple[str, Options], ...]
    seeds: int
    frames: int = frontend.FRAMES
    lasting: int = 0

    @property
    def seen(self) -> Seen:
        """What the filters are given."""
        return frontend.lasting(frontend.seen(self.frames), self.lasting)


def run(config: Config, *, rng: np.random.Generator) -> dict[str, Account]:
    """Run the filters over the same drives: for each seed the same wheels for all."""
    frontend.seen(config.frames)  # before the work is handed out
    done = sweep(_accounts, [config] * config.seeds, rng=rng, desc="drives")
    kept = np.moveaxis(np.array(done, dtype=float), 0, -1)
    return {name: Account(*own) for (name, _), own in zip(config.filters, kept, strict=True)}


def _accounts(config: Config, *, rng: np.random.Generator) -> list[tuple[float, ...]]:
    seen, (wheel, *streams) = config.seen, rng.spawn(1 + len(config.filters))
    report = drives.roll(seen.poses, rng=wheel)
    return [
        account(drives.run(seen, options, report, rng=own, told=name == TOLD))
        for (name, options), own in zip(config.filters, streams, strict=True)
    ]


# The claims --------------------------------------------------------------------------------------


def error_table(found: Mapping[str, Account]) -> Table:
    """Return the errors by number of particles, with the wheels alone as base line."""
    some = next(iter(found.values()))
    alone = (some.wheels, some.wheels_aligned, some.wheels_end)
    rows = {"wheels alone": (*(bootstrap_mean(error, "m") for error in alone), None, None)} | {
        name: (
            *(bootstrap_mean(error, "m") for error in (a.path, a.aligned, a.end)),
            bootstrap_mean(a.landmarks),
            f"{a.right.sum():.0f} of {a.right.size}",
        )
        for name, a in found.items()
    }
    columns = {
        "ATE (m)": "absolute trajectory error: root mean squared error of the position",
        "aligned (m)": "the same after the best rigid motion",
        "end (m)": "error of the position at the end",
        "landmarks": "in the map at the end",
        "right": "drives whose map is topologically right",
    }
    about = f"mean and 95 % bootstrap interval over {some.path.size} draws of the wheels' noise"
    return Table(rows, columns, about, "particles")


def over_drives(found: Mapping[str, Account]) -> str:
    """Return what the numbers of a table are."""
    drives = next(iter(found.values())).path.size
    return f"mean and 95 % bootstrap interval over {drives} drives"


def match_table(found: Mapping[str, Account]) -> Table:
    """Return what was recognised, what wrongly, and what not."""
    rows = {
        name: tuple(bootstrap_mean(count) for count in (a.matched, a.wrong, a.twice))
        for name, a in found.items()
    }
    columns = {
        "recognised": "new tracks that were taken for a landmark of the map",
        "wrong": "of these, tracks of a place that the landmark was not made of",
        "again": "landmarks made of a place of which there was one already",
    }
    return Table(rows, columns, "mean and 95 % bootstrap interval over the drives", "particles")


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


def counted(*counts: int) -> tuple[tuple[str, Options], ...]:
    """Return filters with some numbers of particles; Fig. 4: 1, 10 and 100, the text: 50."""
    return tuple((f"M = {count}", Options(count)) for count in counts)


TEN = Study(
    run,
    full=Config((*counted(1, 10, 50, 100), (TOLD, Options())), 30),
    quick=Config(counted(10), 30),
    seed=41,
)


@TEN.claim(
    "map-10",
    paper=PAPER,
    place="§5, Fig. 4b",
    basis="substitute",
    statement="With only 10 particles the map is topologically correct.",
    paper_value="one map, “topologically correct”",
    method="The rendered drive of 507 stereo pairs, wheels drawn anew for each run: share of the "
    "runs whose map has 95 % of its landmarks in the room in which they are (half a doorway of "
    "tolerance), the rooms of the path in the right order, and no room drawn twice.",
    accepted=Accepted(
        0.5, 1.0, "a map is right more often than not; the paper shows one", "our choice"
    ),
    sabotage=Change(
        "a filter that recognises nothing", filters=(("M = 10", Options(limit=0.0)),), seeds=6
    ),
    value=lambda found: found["M = 10"].share_right,
)
def map_10(found: dict[str, Account], value: Interval) -> Finding:
    """Count the maps that are topologically right."""
    ten = found["M = 10"]
    counted = {name: a for name, a in found.items() if name != TOLD}
    evidence: dict[str, Interval] = {}
    for name, a in counted.items():
        evidence |= {
            f"maps that are right, {name}": a.share_right,
            f"landmarks in their room, {name}": bootstrap_mean(a.inside),
            f"ATE, {name}": bootstrap_mean(a.path, "m"),
        }
    if TOLD in found:
        ratio = bootstrap_ratio(found[TOLD].path, ten.path)
        evidence["ATE, landmarks told over recognised, M = 10"] = ratio
    evidence |= {
        "wheels alone, ATE": bootstrap_mean(ten.wheels, "m"),
        "wrong among the recognised, M = 10": bootstrap_ratio(ten.wrong, ten.matched),
    }
    return Finding(
        value,
        evidence,
        {"errors": error_table(counted), "matches": match_table(counted)},
        note=f"{ten.right.sum():.0f} of {ten.right.size} maps are right; "
        f"{ten.inside.mean():.1%} of the landmarks lie in their room.",
    )


FIFTY = Study(
    run,
    full=Config(counted(1, 10, 50, 100, 400), 10),
    quick=Config(counted(50, 400), 6),
    seed=42,
)


@FIFTY.claim(
    "map-50",
    paper=PAPER,
    place="§5",
    basis="substitute",
    statement="Correct maps are built with 50 particles; 400 are not needed.",
    paper_value="50 particles, against 400 of Sim et al. (2005)",
    method="The same drives: trajectory error with 50 particles over that with 400.",
    accepted=Accepted(
        0.0, 1.5, "fifty leave at most half as much error again as four hundred", "our choice"
    ),
    sabotage=Change(
        "one particle in place of fifty",
        filters=(("M = 50", Options(1)), *counted(400)),
        seeds=4,
    ),
)
def map_50(found: dict[str, Account]) -> Finding:
    """Compare the errors with 50 and with 400 particles on the same drives."""
    fifty, many = found["M = 50"], found["M = 400"]
    against = {
        f"ATE, {name.removeprefix('M = ')} particles over 400": bootstrap_ratio(a.path, many.path)
        for name, a in found.items()
        if a is not many
    }
    return Finding(
        bootstrap_ratio(fifty.path, many.path, "ATE, 50 over 400"),
        against
        | {
            "aligned, 50 over 400": bootstrap_ratio(fifty.aligned, many.aligned),
            "landmarks, M = 50": bootstrap_mean(fifty.landmarks),
            "maps that are right, M = 50": fifty.share_right,
        },
        {"errors": error_table(found)},
        note=f"With 50 particles the error is {fifty.path.mean():.2f} m, with 400 "
        f"{many.path.mean():.2f} m.",
    )

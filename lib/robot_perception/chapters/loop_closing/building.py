"""Fig. 7: the planar filter round the loop of a building, on scans, and the claim about it.

The paper's data set, ``usc-sal200``, is unavailable: a building of the same size stands in for it.
It shows what happens to a whole system, landmarks and association included; the posts of
:mod:`.posts` show what linearisation alone does. With an exactly known start the first landmark is
nearly an anchor already, so that the claim is tested from an uncertain one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from data_synth.building import Building, drive, make_building
from data_synth.laser import Scanner, measure, sight
from robot_perception.chapters.loop_closing import loops
from robot_perception.chapters.loop_closing.loops import SLIPS, Case, Drive, Fixes, Runs
from robot_perception.chapters.monobot.rail import PAPER
from robot_perception.evaluation.intervals import (
    Interval,
    bootstrap_mean,
    bootstrap_median,
    bootstrap_ratio,
    spread,
)
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import act
from robot_perception.slam.planar import History
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted
from robot_perception.walls.corners import LandmarkRules, find_landmarks
from robot_perception.walls.segments import to_points

FILTERS = ("plain", "anchored", "first estimates", "anchored, rule at 15", "external")
"""Variants that have to find out themselves what they see."""


def _cases() -> tuple[Case, ...]:
    cases = []
    for noise in SLIPS:
        cases += [Case(v, noise, "gated", s) for s in ("uncertain", "exact") for v in FILTERS]
        cases += [Case(v, noise, "known", "uncertain") for v in FILTERS[:3]]
        cases += [Case(v, noise, "known") for v in FILTERS[:4]]
    cases += [Case(v, "large", "joint") for v in FILTERS[:2]]
    cases += [Case(v, "small", "gated", "displaced") for v in FILTERS[:2]]
    return tuple(cases)


CASES = _cases()
QUICK_CASES = tuple(
    case
    for case in CASES
    if (case.noise == "large" and case.association != "joint" and case.variant in FILTERS[:2])
    or (case.noise, case.association, case.start) == ("large", "gated", "uncertain")
)
JUDGED = Case("anchored", start="uncertain")
"""What the paper drives round its loop, as far as it says so."""


@dataclass(frozen=True, slots=True)
class Config:
    """The drive round the building. Size and loop are the paper's; all other values are ours.

    Each of the seeds has its own noise of scanner, wheels and fixes; ``plan`` is the seed of the
    building. Scans are a ``step`` apart, and the robot drives on ``beyond`` the closing of the
    loop, m. The rules say what is taken for a landmark. All cases run on the same noise; the claim
    is about the one that is ``judged``.
    """

    seeds: int = 50
    plan: int = 1
    step: float = 0.2
    beyond: float = 8.0
    scanner: Scanner = field(default_factory=lambda: Scanner(max_range=8.0))
    rules: LandmarkRules = field(default_factory=LandmarkRules)
    fixes: Fixes = field(default_factory=lambda: Fixes(5, 0.3))
    cases: tuple[Case, ...] = CASES
    judged: Case = JUDGED

    @property
    def world(self) -> tuple[Building, Float[np.ndarray, "steps 3"], object]:
        """The building, the true path, and what the scanner could see from it."""
        return _world(self.plan, self.step, self.beyond, self.scanner)

    @property
    def before(self) -> int:
        """Number of the last step before the first landmarks come into reach again."""
        away = self.beyond + 1.5 * self.scanner.max_range
        return len(self.world[1]) - 1 - int(away / self.step)


@cache
def _world(plan: int, step: float, beyond: float, scanner: Scanner) -> tuple:
    building = make_building(rng=np.random.default_rng(plan))
    poses = drive(building, step=step, beyond=beyond)
    return building, poses, sight(building.faces, poses, scanner, reach=1.1 * scanner.max_range)


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What came out of a study, by case.

    The sightings are the landmarks found in a scan on average, and the share of them that are none;
    ``counts`` is how often each landmark that was seen was seen in its drive.
    """

    config: Config
    runs: Mapping[Case, Runs]
    sightings: tuple[float, float]
    counts: Int[np.ndarray, " landmarks"]

    def table(self, circumstances: str) -> Table:
        """Return the errors of the filters under some circumstances."""
        rows = {
            case.variant: (
                bootstrap_mean(runs.distance(self.config.before), "m"),
                bootstrap_mean(runs.distance(), "m"),
                bootstrap_mean(runs.map_error, "m"),
                bootstrap_mean(runs.map_shape, "m"),
                bootstrap_median(runs.mean_nees),
                bootstrap_mean(runs.false.astype(float)),
                bootstrap_mean(runs.twice.astype(float)),
            )
            for case, runs in self.runs.items()
            if case.circumstances == circumstances
        }
        columns = {
            "before (m)": "error of the position before the first landmarks come into reach again",
            "end (m)": "error of the position at the end",
            "map (m)": "root mean square error of the landmarks",
            "aligned (m)": "the same after the best rigid motion",
            "NEES": "of the pose, averaged over the drive, median of the drives; 3 if right",
            "wrong": "observations taken for another landmark",
            "twice": "landmarks put into the map again",
        }
        about = f"mean and 95 % bootstrap interval over {self.config.seeds} drives"
        return Table(rows, columns, about, "filter")

    def anchor_table(self) -> Table:
        """Return what the anchor does to the end error, wherever it was tried without the rule."""
        rows = {
            case.circumstances: (
                bootstrap_mean(self.runs[replace(case, variant="plain")].distance(), "m"),
                bootstrap_mean(runs.distance(), "m"),
                self.over_plain(case),
            )
            for case, runs in self.runs.items()
            if case.variant == "anchored"
        }
        columns = {
            "plain (m)": "error of the position at the end without an anchor",
            "anchored (m)": "the same with the first observed landmark as anchor",
            "ratio": "of the two, on the same noise",
        }
        about = f"mean and 95 % bootstrap interval over {self.config.seeds} drives"
        return Table(rows, columns, about, "noise, association, start")

    def over_plain(self, case: Case) -> Interval:
        """Return the end error of a case over that of the plain filter in the same case."""
        plain = self.runs[replace(case, variant="plain")].distance()
        return bootstrap_ratio(self.runs[case].distance(), plain, f"{case.variant} over plain")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive round the building and filter every case, on the same noise for all cases of a seed."""
    done = sweep(_accounts, [config] * config.seeds, rng=rng, desc="building")
    columns = zip(*(accounts for accounts, _ in done), strict=True)
    runs = {case: loops.stack(rows) for case, rows in zip(config.cases, columns, strict=True)}
    ids = np.concatenate([ids for _, ids in done])
    number = len(ids) / (config.seeds * len(config.world[1]))
    counts = np.concatenate([np.unique(own[own >= 0], return_counts=True)[1] for _, own in done])
    return Result(config, runs, (number, np.count_nonzero(ids < 0) / max(len(ids), 1)), counts)


def _accounts(config: Config, *, rng: np.random.Generator) -> tuple[list[tuple], np.ndarray]:
    one, _ = simulate(config, rng=rng)
    accounts = [loops.account(loops.filter_drive(case, one), one) for case in config.cases]
    return accounts, np.concatenate([seen.ids for seen in one.seen])


def simulate(
    config: Config, *, rng: np.random.Generator
) -> tuple[Drive, Float[np.ndarray, "steps beams"]]:
    """Return one run round the building, and the ranges of its scans, m.

    A landmark found in a scan is a true one if it lies within 20 cm of it.
    """
    building, poses, seen = config.world
    noise, *streams = rng.spawn(4)
    ranges = measure(seen, config.scanner, rng=noise).ranges
    found_in = []
    for pose, row in zip(poses, ranges, strict=True):
        found, _ = find_landmarks(row, config.scanner.angles, config.rules)
        gaps = act(pose, found.values)[:, None] - building.landmarks
        away = np.hypot(gaps[..., 0], gaps[..., 1])
        ids = np.where(away.min(axis=1) < 0.2, away.argmin(axis=1), -1)
        found_in.append(found.named(ids))
    one = loops.draw_drive(building.landmarks, poses, found_in, SLIPS, config.fixes, streams)
    return one, ranges


GIVEN: Mapping[str, Case] = {
    "nothing": Case(),
    "an anchor": Case("anchored"),
    "an anchor and the rule": Case("anchored, rule at 15"),
    "a joint test of matches": Case(association="joint"),
    "first estimates": Case("first estimates"),
    "a sensor of the position": Case("external"),
    "the names": Case(association="known"),
    "the names and an anchor": Case("anchored", association="known"),
}
"""What the plain filter may be given besides, and the case that this makes with large noise."""


@dataclass(frozen=True, eq=False, slots=True)
class Built:
    """One drive and the map that a filter made of it; faces of the true plan in m.

    The readings of the scanner, m, are put where the filter believed the robot to be at the steps
    of which they are.
    """

    given: str
    case: Case
    faces: Float[np.ndarray, "faces 2 2"]
    drive: Drive
    history: History
    readings: Float[np.ndarray, "points 2"]
    steps: Int[np.ndarray, "points"]

    @property
    def off(self) -> float:
        """Error of the position at the end, m."""
        return float(np.hypot(*(self.history.poses - self.drive.poses)[-1, :2]))

    @property
    def twice(self) -> int:
        """Number of landmarks put into the map again."""
        return int(loops.stack([loops.account(self.history, self.drive)]).twice[0])


@kept
def built(
    given: str, start: Literal["exact", "uncertain"] = "exact", every: int = 8, beams: int = 6
) -> Built:
    """Return Fig. 7 rebuilt: the map of one drive with large noise by the filter of `GIVEN`.

    Of ``every`` so many scans, and of so many ``beams`` in them, one reading is drawn.
    """
    config, case = Config(), replace(GIVEN[given], start=start)
    one, ranges = _drawn_drive(config)
    ranges = ranges[::every, ::beams]
    valid = np.isfinite(ranges)
    local = to_points(np.where(valid, ranges, 0.0), config.scanner.angles[::beams])
    history = loops.filter_drive(case, one)
    readings = act(history.poses[::every], local)[valid]
    steps = every * np.nonzero(valid)[0]
    return Built(given, case, config.world[0].faces, one, history, readings, steps)


@cache
def _drawn_drive(config: Config) -> tuple[Drive, Float[np.ndarray, "steps beams"]]:
    return simulate(config, rng=np.random.default_rng(FIG7.seed).spawn(1)[0])


def setup_table() -> Table:
    """Return what the paper says of its drive, what ours is, and what of it matters."""
    config, paper = Config(), "–"
    building, poses, _ = config.world
    way = float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()) - config.beyond
    wheels = (f"{100 * s.along:g} cm and {np.degrees(s.bend):.2g}° per √m" for s in SLIPS.values())
    x, _, heading = loops.STARTS["uncertain"]
    rows = {
        "floor, loop": ("300 m², nearly 90 m", f"{building.area:.0f} m², {way:.0f} m", "as there"),
        "drives": ("one", str(config.seeds), "yes: one proves nothing"),
        "landmarks": ("from a laser", "corners, columns from a laser", "yes: many look alike"),
        "noise of wheels (1σ)": (paper, " or ".join(wheels), "yes: metres at the end"),
        "start (1σ)": (
            paper,
            f"exact, or {100 * x:.0f} cm and {np.degrees(heading):.0f}°",
            "yes: what an anchor can add",
        ),
        "revisions before removal": ("50", "15 in the building, 50 round posts", "see the rule"),
    }
    return Table(rows, {"paper": "– where it says nothing", "ours": "", "matters": ""})


def start_table(tables: Mapping[str, Table]) -> Table:
    """Return what an anchor does from an uncertain start, the names of landmarks known."""
    columns = {
        "end (m)": "error of the position at the end",
        "aligned (m)": "error of the landmarks after the best rigid motion",
    }
    rows = {}
    for noise in SLIPS:
        found = tables[f"{noise} noise, known, uncertain start"]
        for variant in ("plain", "anchored", "first estimates"):
            rows[f"{noise} noise, {variant}"] = [found[variant, name] for name in columns]
    return Table(rows, columns, found.about, "names known, uncertain start")


FIG7 = Study(run, full=Config(), quick=Config(seeds=4, cases=QUICK_CASES), seed=7)
DISPLACED = Case("anchored", "small", "gated", "displaced")


def judged(result: Result) -> Interval:
    """Return the end error of the case that is judged over that of the plain filter."""
    return result.over_plain(result.config.judged)


@FIG7.claim(
    "planar-loop",
    paper=PAPER,
    place="§2.2, Fig. 7",
    basis="substitute",
    statement="Round a loop of about 90 m in 300 m² plain EKF-SLAM ends with large errors; "
    "with the first observed landmark as an anchor it does not.",
    paper_value="Fig. 7a against Fig. 7b: one run each",
    method="Synthetic building of that size (the data set usc-sal200 is unavailable), corners and "
    "columns from rendered scans, nearest neighbour in a gate, large odometry noise, a start known "
    "to 0.1 m and 3° (with an exact one the first landmark is nearly an anchor already): mean "
    "position error at the loop end, anchored over plain.",
    accepted=Accepted(
        0,
        0.5,
        "a cure at least halves the error; both run on the same noise, and chance is in the "
        "interval",
        "our choice",
    ),
    sabotage=Change(
        "small noise of the wheels, and a start whose place is known to a metre only",
        seeds=2,
        cases=(replace(DISPLACED, variant="plain"), DISPLACED),
        judged=DISPLACED,
    ),
    value=judged,
)
def planar_loop(result: Result, value: Interval) -> Finding:
    """Compare the filters at the loop end, from uncertain starts and from exact ones."""
    config, exactly = result.config, result.over_plain(Case("anchored"))
    ratios = {
        name: result.over_plain(Case(name, start="uncertain"))
        for name in ("anchored", "anchored, rule at 15", "external", "first estimates")
    }
    told = Case("anchored", association="known", start="uncertain")
    plain = result.runs[Case(association="known")].distance()
    tables = {"what the anchor does": result.anchor_table()} | {
        name: result.table(name) for name in dict.fromkeys(c.circumstances for c in result.runs)
    }
    return Finding(
        value,
        {f"end error, {name} over plain": ratio for name, ratio in ratios.items()}
        | {
            "end error, anchored over plain, exact start": exactly,
            "end error, anchored over plain, names known": result.over_plain(told),
            "sightings of a landmark in a drive": spread(
                result.counts.astype(float),
                about="median and central 95 % of the landmarks of all drives",
            ),
            "landmarks removed by the rule at 15": bootstrap_mean(
                result.runs[Case("anchored, rule at 15", start="uncertain")].retired.astype(float)
            ),
        },
        tables,
        note=f"With the anchor the error at the loop end is {value.estimate:.2f} of that without; "
        f"every limit below {value.low:.2f} gives this verdict. After 90 m the anchor is as far "
        f"out of sight as everything else, and the filter does not recognise where it is: told "
        f"which landmark is which, even the plain one closes the loop to {100 * plain.mean():.0f} "
        f"cm from an exact start. What an anchor does remove is the error of the start: with names "
        f"known and an uncertain start {result.over_plain(told).estimate:.2f} of the error is "
        f"left, with an exact start, where there is nothing to remove, {exactly.estimate:.2f}. The "
        f"paper's limit of 50 revisions is here one of 15, since with a scan every {config.step:g} "
        f"m a landmark is seen {np.median(result.counts):.0f} times in the median.",
    )

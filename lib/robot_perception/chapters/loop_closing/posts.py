"""Posts along a loop: what linearisation alone does, and the claims about it.

There are no scans here, each observation comes with its name and its true covariance, so that only
the linearisation can make the filter wrong.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Float

from data_synth.building import drive, first_leg
from data_synth.posts import glimpse, make_posts
from data_synth.wheels import SMALL, Slip
from robot_perception.chapters.anchored_slam import gauge
from robot_perception.chapters.loop_closing import loops
from robot_perception.chapters.loop_closing.loops import Case, Drive, Fixes, Runs
from robot_perception.chapters.monobot.rail import PAPER
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.evaluation.intervals import (
    Interval,
    bootstrap_mean,
    bootstrap_ratio,
    exact,
)
from robot_perception.evaluation.sweep import sweep
from robot_perception.observations import Observations
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

JACOBIANS = (
    "plain",
    "anchored",
    "first estimates",
    "anchored, first estimates",
    "ideal",
    "external",
)
"""Variants whose consistency is compared."""


@dataclass(frozen=True, slots=True)
class Config:
    """Posts along a loop, each observation with name and true covariance; all is ours, in m.

    Every run is filtered by all variants, on the same noise.

    There is a post every ``apart`` along the loop and an observation every ``step``; the robot
    drives on ``beyond`` the closing of the loop, no farther than to the first bend, and sees as far
    as it can ``reach``. The noise is a multiple of the small slip of the wheels and of
    ``measurement_sigma``, the deviation of each coordinate of an observed place. The filter
    believes the wheels' deviations to be a share ``believed`` of what they are.
    """

    runs: int = 50
    length: float = 90.0
    step: float = 0.25
    beyond: float = 8.0
    apart: float = 3.0
    noise: float = 1.0
    measurement_sigma: float = 0.03
    reach: float = 6.0
    start: Literal["exact", "shifted", "uncertain"] = "exact"
    fixes: Fixes = field(default_factory=lambda: Fixes(4, 0.3))
    believed: float = 1.0
    variants: tuple[str, ...] = JACOBIANS

    @property
    def slip(self) -> Slip:
        """How wrong the wheels are."""
        f = self.noise
        return Slip(SMALL.along * f, SMALL.across * f, SMALL.bend * f, SMALL.turn * f)

    @property
    def world(self) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "steps 3"]]:
        """The places of the posts and the true path."""
        return _world(self.length, self.step, self.beyond, self.apart)


@cache
def _world(length: float, step: float, beyond: float, apart: float) -> tuple:
    posts = make_posts(length, rng=np.random.default_rng(1), apart=apart)
    return posts.landmarks, drive(posts, step=step, beyond=min(beyond, first_leg(posts)))


LINEAR = Config(noise=0.3)
"""Noise so small that all errors stay of linear size, with the start known exactly."""
TURNED = replace(LINEAR, start="uncertain")
"""The same small noise; only where the robot starts, and how it is turned, is uncertain."""
ROUGH = Config(noise=6.0)
"""Noise so large that the heading is lost by tens of degrees before the loop closes."""
STUDIES = {"linear": LINEAR, "turned": TURNED, "rough": ROUGH}
RULE = Config(step=0.1, variants=("plain", "rule at 50", "considered at 50"))
"""The world of the rule: observations every 10 cm, so that each post is seen more than 50 times."""


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What came out of a study, by variant."""

    config: Config
    runs: Mapping[str, Runs]

    def __getitem__(self, variant: str) -> Runs:
        return self.runs[variant]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive round the posts with every variant, on the same noise for all variants of a run."""
    done = sweep(_accounts, [config] * config.runs, rng=rng, desc="round the posts")
    columns = zip(config.variants, zip(*done, strict=True), strict=True)
    return Result(config, {name: loops.stack(rows) for name, rows in columns})


def simulate(config: Config, *, rng: np.random.Generator) -> Drive:
    """Return one run round the posts."""
    landmarks, poses = config.world
    seeing, *streams = rng.spawn(4)
    sigma = config.noise * config.measurement_sigma
    seen = glimpse(landmarks, poses, sigma=sigma, reach=config.reach, rng=seeing)
    cov = sigma**2 * np.eye(2)
    seen = [Observations(ids, at, np.tile(cov, (len(ids), 1, 1))) for ids, at in seen]
    one = loops.draw_drive(landmarks, poses, seen, {"own": config.slip}, config.fixes, streams)
    report = one.wheels["own"]
    believed = replace(report, deviations=config.believed * report.deviations)
    return replace(one, wheels={"own": believed})


def case(config: Config, variant: str) -> Case:
    """Return a variant in the circumstances of a study."""
    return Case(variant, "own", "known", config.start)


def _accounts(config: Config, *, rng: np.random.Generator) -> list[tuple]:
    one = simulate(config, rng=rng)
    histories = (loops.filter_drive(case(config, name), one) for name in config.variants)
    return [loops.account(history, one) for history in histories]


def setup_table() -> Table:
    """Return what the studies round the posts take, and what of it matters."""
    wheels, rule = TURNED.slip, RULE.slip
    x, _, heading = loops.STARTS["uncertain"]
    consistent, removed = (100 * c.noise * c.measurement_sigma for c in (TURNED, RULE))
    rows = {
        "posts": (f"every {TURNED.apart:g} m", f"every {RULE.apart:g} m", "little"),
        "noise of an observation": (f"{consistent:.1g} cm", f"{removed:.1g} cm", "yes: see below"),
        "wheels, per √m": (
            f"{100 * wheels.along:.1g} cm, {np.degrees(wheels.bend):.2g}°",
            f"{100 * rule.along:.1g} cm, {np.degrees(rule.bend):.2g}°",
            "yes: see below",
        ),
        "start": (f"{100 * x:.0f} cm, {np.degrees(heading):.0f}°", "exact", "most of all"),
        "observations every": (f"{TURNED.step:g} m", f"{RULE.step:g} m", "for the rule"),
    }
    columns = {"consistency": "all values are ours, 1σ", "rule of fifty": "", "matters": ""}
    return Table(rows, columns)


# Is it honest? -----------------------------------------------------------------------------------


def honesty(config: Config, *, rng: np.random.Generator) -> dict[str, Result]:
    """Run the three studies of consistency, with runs and variants of a configuration."""
    own = zip(STUDIES, rng.spawn(len(STUDIES)), strict=True)
    return {name: _study(name, config, stream) for name, stream in own}


def _study(name: str, config: Config, stream: np.random.Generator) -> Result:
    return run(replace(STUDIES[name], runs=config.runs, variants=config.variants), rng=stream)


JACOBIAN = Study(honesty, full=Config(), quick=Config(runs=20, variants=JACOBIANS[:4]), seed=9)


@kept
def study(name: Literal["linear", "turned", "rough"]) -> Result:
    """Return one study of consistency at its full size, as it is recorded."""
    streams = dict(zip(STUDIES, np.random.default_rng(JACOBIAN.seed).spawn(3), strict=True))
    return _study(name, JACOBIAN.full, streams[name])


def consistency(result: Result) -> Table:
    """Return how honest the filters of a study are, and how far off at the end."""
    rows = {
        name: (
            bootstrap_mean(runs.mean_nees),
            runs.coverage.averaged_share,
            *(bootstrap_mean(end) for end in (runs.distance(), runs.heading())),
        )
        for name, runs in result.runs.items()
    }
    columns = {
        "NEES": "of the pose, averaged over time; 3 if the filter is right",
        "in band": "share of the steps at which the average over the runs lies in its 95 % band",
        "end (m)": "error of the position at the end",
        "end (°)": "error of the heading at the end",
    }
    about = f"mean and 95 % bootstrap interval over {result.config.runs} runs"
    return Table(rows, columns, about, "filter")


EXCESS = average_bounds(3, 50)[1] / 3
"""How many times its expectation a consistent filter's average NEES over 50 runs is (97.5 %)."""


def rule_table(result: Result) -> Table:
    """Return how consistent the filters with and without the rule are, how far off, how costly."""
    rows = {
        name: (
            bootstrap_mean(runs.mean_nees),
            bootstrap_mean(runs.path_error, "m"),
            bootstrap_mean(runs.stated[:, 0], "m"),
            bootstrap_mean(runs.distance(), "m"),
            runs.states.mean(),
        )
        for name, runs in result.runs.items()
    }
    columns = {
        "NEES": "of the pose, averaged over time; 3 if the filter is right",
        "path error (m)": "of the position, root mean square along the path",
        "stated (m)": "the same as the filter states it",
        "loop end (m)": "error of the position at the end",
        "cost": "entries of the covariance, averaged over time",
    }
    about = f"mean and 95 % bootstrap interval over {result.config.runs} runs"
    return Table(rows, columns, about, "filter")


def from_both_starts(config: Config, *, rng: np.random.Generator) -> tuple[Result, Result]:
    """Run a study from an exact start and from an uncertain one."""
    uncertain = rng.spawn(1)[0]
    return run(config, rng=rng), run(replace(config, start="uncertain"), rng=uncertain)


def from_an_exact_start(config: Config, *, rng: np.random.Generator) -> tuple[Result]:
    """Run a study from an exact start alone."""
    return (run(config, rng=rng),)


def inconsistency(results: tuple[Result, ...]) -> Interval:
    """Return the NEES of the second variant over that of the plain filter, from an exact start."""
    return _over_plain(results[0], results[0].config.variants[1])


def _over_plain(result: Result, variant: str) -> Interval:
    """Return the NEES of a variant over that of the plain filter on the same noise."""
    above, below = result[variant].mean_nees, result["plain"].mean_nees
    return bootstrap_ratio(above, below, f"NEES, {variant} over plain")


@dataclass(frozen=True, slots=True)
class Removed:
    """How many landmarks have left the state, and whether they are still observed."""

    landmarks: int = 2
    observed: bool = True


def unseen_by_rank(removed: Removed, *, rng: np.random.Generator | None = None) -> Interval:
    """Return the directions unseen if removed landmarks count as standing at known places."""
    sensing = ("plain", "one anchor", "two anchors")
    return gauge.unseen(sensing[removed.landmarks if removed.observed else 0])


def before_two_leave(config: Config, limit: int) -> Interval:
    """Return the share of a drive before two landmarks were revised more than ``limit`` times.

    The first observation puts a landmark into the map, and each further one revises it.
    """
    landmarks, poses = config.world
    rng = np.random.default_rng(0)  # which landmarks are in reach is no matter of noise
    seen = glimpse(landmarks, poses, sigma=0.0, reach=config.reach, rng=rng)
    counts = np.cumsum([np.bincount(ids, minlength=len(landmarks)) for ids, _ in seen], axis=0)
    gone = (counts - 1 > limit).sum(axis=1) >= 2
    return exact(1 - gone.mean(), about=f"of {len(poses)} observations")


LEFT = Study(unseen_by_rank, full=Removed(), quick=Removed())


@LEFT.claim(
    "controllability-observable",
    paper=PAPER,
    place="§2.2, text after eq. 27",
    basis="mathematics",
    statement="If landmarks that were revised more than 50 times leave the state and their "
    "observations are still used, the rest of the state stays observable.",
    paper_value="“to guarantee full observability during the entire run”",
    method="States minus rank, in exact arithmetic, by the worst of three analyses, if removed "
    "landmarks count as standing at known places, as the filter counts them: with two removed, "
    "with one, and with none.",
    accepted=gauge.FULL,
    sabotage=(
        Change("observations of removed landmarks that are not used", observed=False),
        Change("one landmark removed in place of two", landmarks=1),
    ),
)
def controllability_observable(unseen: Interval) -> Finding:
    """Count what is unseen with landmarks removed, and how long none or one has left."""
    none, one = (unseen_by_rank(Removed(count)) for count in (0, 1))
    return Finding(
        unseen,
        {
            "directions unseen, none removed": none,
            "directions unseen, one removed": one,
            "share of the run before two have left the state": before_two_leave(RULE, 50),
        },
        conditions=(
            Condition.judged(
                "two landmarks have left the state (an anchor counts as one) and count as standing "
                "at known places: before that the turn of the world about the first stays unseen",
                gauge.FULL,
                outside=one,
            ),
        ),
        note="Nobody has measured the places that count as known: what the world lets a robot see "
        "is no more than without the rule. What a filter makes of that is the claim "
        "controllability-rule.",
    )


REMOVAL = Study(from_both_starts, full=RULE, quick=replace(RULE, runs=15), seed=8)


@REMOVAL.claim(
    "controllability-rule",
    paper=PAPER,
    place="§2.2, text after eq. 27",
    basis="substitute",
    statement="To take landmarks that were revised more than 50 times out of the state, and to go "
    "on correcting the rest by their observations, leaves the filter as consistent as before.",
    paper_value="“its observations were still used to revise the remaining state vector elements”",
    method="Posts along the loop, known association, observations every 10 cm, exact start: NEES "
    "of the pose with the rule over that without; errors and cost stand beside it.",
    accepted=Accepted(
        0,
        EXCESS,
        "the rule multiplies the NEES by no more than chance does: the average over 50 runs of a "
        f"consistent filter is at most {EXCESS:.2f} times its expectation (97.5 %)",
        "our choice",
    ),
    sabotage=(
        Change(
            "removed landmarks whose uncertainty is still counted",
            from_an_exact_start,
            runs=10,
            variants=("plain", "considered at 50"),
        ),
        Change(
            "observations so far apart that no landmark is revised 50 times",
            from_an_exact_start,
            runs=10,
            step=0.5,
            variants=("plain", "rule at 50"),
        ),
    ),
    value=inconsistency,
)
def controllability_rule(results: tuple[Result, Result], value: Interval) -> Finding:
    """Compare NEES and errors with the rule, without it, and if landmarks are considered."""
    exactly, turned = results
    plain, rule, considered = exactly.runs.values()
    path = bootstrap_ratio(rule.path_error, plain.path_error, "path error, with over without")
    return Finding(
        value,
        {
            "NEES from an uncertain start, with over without": _over_plain(turned, "rule at 50"),
            "NEES, considered over without": _over_plain(exactly, "considered at 50"),
            "path error, with over without": path,
            "error at the loop end, with over without": bootstrap_ratio(
                rule.distance(), plain.distance(), "loop end, with over without"
            ),
            "cost (entries of the covariance), with over without": exact(
                rule.states.mean() / plain.states.mean(), about="ratio of means, runs alike"
            ),
            "landmarks retired": bootstrap_mean(rule.retired.astype(float)),
        },
        {
            "with and without the rule": rule_table(exactly),
            "with and without the rule, uncertain start": rule_table(turned),
        },
        note=f"With the rule the NEES is {rule.mean_nees.mean():.0f}, without it "
        f"{plain.mean_nees.mean():.1f}; 3 is right. A removed landmark keeps its error and loses "
        f"its uncertainty: the filter states {100 * rule.stated[:, 0].mean():.0f} cm and is "
        f"{100 * rule.path_error.mean():.0f} cm off. The observations do still "
        f"correct the rest: the error grows by a factor of {path.estimate:.2f} only. To let an "
        f"estimate stand and still count its uncertainty (Schmidt's filter) gives a NEES of "
        f"{considered.mean_nees.mean():.1f}, at full cost.",
    )


CHANGING = ("plain", "first estimates")
"""The filter whose Jacobians change with its estimates, and the one whose do not."""
EXCESS_SHARE = "share of the excess NEES that goes with first estimates"
ERROR_SHARE = "share of the path error that goes with first estimates"


def alone(config: Config, *, rng: np.random.Generator) -> dict[str, Result]:
    """Run one study in the place of the one that is judged."""
    return {"turned": run(config, rng=rng)}


def excess(studies: Mapping[str, Result]) -> Interval:
    """Return the NEES of the filter with changing Jacobians over that with first estimates."""
    result = studies["turned"]
    changing = "plain" if "plain" in result.runs else "ideal"
    return _excess(result, changing, "first estimates")


@JACOBIAN.claim(
    "jacobian-consistency",
    paper=PAPER,
    place="beyond the paper; its “effects of nonlinearities”, §2.2",
    basis="substitute",
    statement="EKF-SLAM becomes inconsistent through the error of the heading, because its "
    "Jacobians are taken at changing estimates.",
    paper_value="not in the paper (Julier and Uhlmann 2001; Huang et al. 2010)",
    method="Posts, known association, small noise, start turned by 3° (1σ): NEES of the pose "
    "averaged over time, mean over runs, over that of the same runs with Jacobians at first "
    "estimates. Wrong noise makes both grow alike.",
    accepted=Accepted(
        EXCESS,
        float("inf"),
        "the Jacobians alone multiply the NEES by more than chance does: the average over 50 runs "
        f"of a consistent filter is at most {EXCESS:.2f} times its expectation (97.5 %)",
        "our choice",
    ),
    sabotage=(
        Change(
            "a start whose heading is exact and whose place is not",
            alone,
            config=replace(LINEAR, start="shifted", runs=10, variants=CHANGING),
        ),
        Change(
            "an exact start, and a filter that believes a quarter of the wheels' noise",
            alone,
            config=replace(LINEAR, believed=0.25, runs=10, variants=CHANGING),
        ),
        Change(
            "Jacobians at the true states in place of the changing estimates",
            alone,
            config=replace(TURNED, runs=10, variants=("ideal", "first estimates")),
        ),
    ),
    value=excess,
)
def jacobian_consistency(studies: dict[str, Result], value: Interval) -> Finding:
    """Compare the NEES of the plain filter with those of the cures, in three studies."""
    count = studies["turned"].config.runs
    tables = {name: consistency(result) for name, result in studies.items()}
    factors = {name: _excess(result, *CHANGING) for name, result in studies.items()}
    cures = {f"NEES, plain over first estimates, {name}": f for name, f in factors.items()}
    for name in ("turned", "rough"):
        plain, anchored, first = (
            studies[name][v] for v in ("plain", "anchored", "first estimates")
        )
        cures |= {
            f"{EXCESS_SHARE}, {name}": bootstrap_ratio(
                plain.mean_nees - first.mean_nees, plain.mean_nees - 3.0, "excess NEES removed"
            ),
            f"{ERROR_SHARE}, {name}": bootstrap_ratio(
                plain.path_error - first.path_error, plain.path_error, "path error removed"
            ),
            f"share of the cure that is the anchor's, {name}": bootstrap_ratio(
                plain.mean_nees - anchored.mean_nees,
                plain.mean_nees - first.mean_nees,
                "excess NEES removed",
            ),
        }
    inside = tables["linear"]["first estimates", "in band"]
    turned = {name: float(runs.nees.mean()) for name, runs in studies["turned"].runs.items()}
    return Finding(
        value,
        cures,
        tables,
        (
            Condition(
                "the heading is uncertain from the start: with an exact start and noise of linear "
                f"size the factor is {factors['linear'].shown(3)}, with noise that loses the "
                f"heading on the way {factors['rough'].shown(3)}",
                factors["linear"].high < EXCESS,
            ),
        ),
        f"The NEES of the plain filter is {turned['plain']:.1f}, with an anchor "
        f"{turned['anchored']:.1f}, with Jacobians at first estimates "
        f"{turned['first estimates']:.1f}; 3 is right. With noise of linear size and an exact "
        f"start the average NEES of the first-estimates filter over {count} runs is inside its "
        f"95 % band at {inside:.1%} of the steps. From a turned start Jacobians that agree remove "
        f"a share of {cures[f'{EXCESS_SHARE}, turned'].shown(2)} of the excess NEES, and of "
        f"{cures[f'{ERROR_SHARE}, turned'].shown(2)} of the error along the path: they make the "
        "filter consistent, not better.",
    )


def _excess(result: Result, changing: str, fixed: str) -> Interval:
    """Return the factor between the NEES of two filters that differ in their Jacobians."""
    above, below = (result[variant].mean_nees for variant in (changing, fixed))
    return bootstrap_ratio(above, below, f"NEES, {changing} over {fixed}")

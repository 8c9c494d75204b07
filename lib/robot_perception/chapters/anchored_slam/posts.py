"""Posts along a loop: what linearisation alone does, and the states of three explorers.

There are no scans here, each observation comes with its name and its true covariance, so that only
the linearisation can make the filter wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Float
from joblib import Parallel, delayed

from data_synth.building import drive, first_leg
from data_synth.posts import glimpse, make_posts
from data_synth.wheels import SMALL, Slip
from robot_perception.chapters.anchored_slam.loops import (
    Case,
    Chance,
    Runs,
    account,
    draw_chance,
    filter_case,
    mean_of,
    stack,
)
from robot_perception.evaluation.consistency import (
    average_bounds,
)
from robot_perception.geometry import wrap_angle
from robot_perception.observations import Observations
from robot_perception.teaching.explore import choice, slider, timeline

# Posts: linearisation alone ----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PostsConfig:
    """Posts along a loop, each observation with its name and its true covariance. All is ours.

    Parameters
    ----------
    runs
        Runs, each with its own noise.
    length, step, beyond
        Length of the loop, between observations, and driven on after the loop is closed, m; no
        farther than to the first bend.
    apart
        Distance between posts along the loop, m.
    noise
        Noise of wheels and looks, as a multiple of the small slip and of ``look_sigma``.
    look_sigma
        Deviation of each coordinate of an observed place, m.
    reach
        How far the robot sees, m.
    start
        Whether the start is known exactly.
    fix_every, fix_sigma
        Steps between measured positions, and their deviation in each coordinate, m.
    """

    runs: int = 50
    length: float = 90.0
    step: float = 0.25
    beyond: float = 8.0
    apart: float = 3.0
    noise: float = 1.0
    look_sigma: float = 0.03
    reach: float = 6.0
    start: Literal["exact", "uncertain"] = "exact"
    fix_every: int = 4
    fix_sigma: float = 0.3

    @property
    def slip(self) -> Slip:
        """How wrong the wheels are."""
        f = self.noise
        return Slip(SMALL.along * f, SMALL.across * f, SMALL.bend * f, SMALL.turn * f)

    @property
    def world(self) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "steps 3"]]:
        """The places of the posts and the true path."""
        posts = make_posts(self.length, rng=np.random.default_rng(1), apart=self.apart)
        beyond = min(self.beyond, first_leg(posts))
        return posts.landmarks, drive(posts, step=self.step, beyond=beyond)


LINEAR = PostsConfig(noise=0.3)
"""Noise so small that all errors stay of linear size, with the start known exactly."""
TURNED = replace(LINEAR, start="uncertain")
"""The same small noise; only where the robot starts, and how it is turned, is uncertain."""
ROUGH = PostsConfig(noise=6.0)
"""Noise so large that the heading is lost by tens of degrees before the loop closes."""


def run_posts(
    config: PostsConfig, variants: Sequence[str], *, rng: np.random.Generator, jobs: int = 2
) -> dict[str, Runs]:
    """Drive round the posts with every variant, on the same noise for all variants of a run."""
    work = (delayed(_one_round)(config, variants, own) for own in rng.spawn(config.runs))
    done = Parallel(n_jobs=jobs)(work)
    return {name: stack([rows[i] for rows in done]) for i, name in enumerate(variants)}


def observe(config: PostsConfig, *, rng: np.random.Generator) -> tuple[list[Observations], Chance]:
    """Return what one run round the posts saw, and its chance."""
    landmarks, poses = config.world
    looks, *streams = rng.spawn(4)
    sigma = config.noise * config.look_sigma
    seen = glimpse(landmarks, poses, sigma=sigma, reach=config.reach, rng=looks)
    cov = sigma**2 * np.eye(2)
    sightings = [Observations(ids, at, np.tile(cov, (len(ids), 1, 1))) for ids, at in seen]
    return sightings, draw_chance(poses, {"own": config.slip}, config.fix_sigma, streams)


def _one_round(
    config: PostsConfig, variants: Sequence[str], rng: np.random.Generator
) -> list[tuple]:
    landmarks, poses = config.world
    sightings, chance = observe(config, rng=rng)
    rows = []
    for name in variants:
        case = Case(name, "own", "known", config.start)
        history = filter_case(config, case, landmarks, poses, sightings, chance)
        rows.append(account(history, poses, sightings, landmarks))
    return rows


STUDIES = {"linear": LINEAR, "turned": TURNED, "rough": ROUGH}
POSTS_SEED = 9
"""Seed of the claim about consistency; the chapter shows the same runs."""


@cache
def posts_study(name: Literal["linear", "turned", "rough"]) -> dict[str, Runs]:
    """Return one study of the claim about consistency at its full size; each is run once."""
    streams = dict(zip(STUDIES, np.random.default_rng(POSTS_SEED).spawn(3), strict=True))
    return run_posts(STUDIES[name], JACOBIANS, rng=streams[name])


JACOBIANS = (
    "plain",
    "anchored",
    "first estimates",
    "anchored, first estimates",
    "true Jacobians",
    "external",
)
"""Variants whose consistency is compared on posts."""


def nees_table(studies: Mapping[str, Mapping[str, Runs]]) -> str:
    """Return the consistency of studies of the posts as text: a line for each, and each variant.

    Average NEES with its 95 % interval over the runs, share of the steps whose average over the
    runs lies in the 95 % band of χ², and errors of the position and the heading at the end.
    """
    lines = []
    for name, runs_by in studies.items():
        lines.append(f"{name:27s}{'NEES':>17s}{'in band':>9s}{'end / m':>9s}{'end / °':>9s}")
        for variant, runs in runs_by.items():
            nees, band = mean_of(runs.nees.mean(axis=1), ""), runs.coverage.averaged_share
            value = f"{nees.estimate:.1f} [{nees.low:.1f}, {nees.high:.1f}]"
            end = f"{runs.distance().mean():9.3f}{runs.heading().mean():9.2f}"
            lines.append(f"{variant:27s}{value:>17s}{band:9.2f}{end}")
    return "\n".join(lines)


RULE = PostsConfig(step=0.1)
"""The world of the rule: observations every 10 cm, so that each post is seen some 60 times."""
RULE_VARIANTS = ("plain", "rule at 50", "considered at 50")


# Explorers ---------------------------------------------------------------------------------------

GROWTH_FILTERS = ("plain", "anchored", "first estimates", "external")
GROWTH_CONTROLS = {
    "noise": slider("Noise", (0.3, 1.0, 3.0, 6.0), 3.0, "× small"),
    "length": slider("Loop", (30.0, 60.0, 90.0, 120.0), 90.0, "m"),
}
ANCHOR_CONTROLS = {
    "count": slider("Anchors", (0, 1, 2), 1),
    "place": slider("First anchor at", tuple(range(0, 90, 15)), 0, "m along the loop"),
}
FRAMES = 40
PLAY_CONTROLS = {
    "variant": choice("Filter", ("plain", "anchored", "external"), "plain"),
    "time": timeline("Time", range(FRAMES), 24, fps=6),
}
_RUNS = 8
_COARSE = {"step": 0.5, "start": "uncertain"}


@dataclass(frozen=True, eq=False, slots=True)
class Curves:
    """Errors along the way, over a few runs.

    Parameters
    ----------
    along : (k,)
        Distance driven, m.
    error, nees : by filter, (k,)
        Root mean square error of the position, m, and average NEES of the pose.
    low, high
        95 % band of χ² of that average.
    """

    along: Float[np.ndarray, " k"]
    error: Mapping[str, np.ndarray]
    nees: Mapping[str, np.ndarray]
    low: float
    high: float


def curves(config: PostsConfig, runs: Mapping[str, Runs]) -> Curves:
    """Return the errors of runs round the posts against the way, at some 60 places."""
    steps = next(iter(runs.values())).errors.shape[1]
    at = np.linspace(1, steps - 1, 60).astype(int)
    error = {
        k: np.sqrt((r.errors[:, at, :2] ** 2).sum(axis=-1).mean(axis=0)) for k, r in runs.items()
    }
    nees = {k: r.nees[:, at - 1].mean(axis=0) for k, r in runs.items()}
    low, high = average_bounds(3, len(next(iter(runs.values())).errors))
    return Curves(at * config.step, error, nees, low, high)


def growth(noise: float, length: float) -> Curves:
    """Return a state of the explorer of noise and loop length; all are computed at the first."""
    return _growth()[noise, length]


@cache
def _growth() -> dict[tuple[float, float], Curves]:
    places = [
        (n, x) for n in GROWTH_CONTROLS["noise"].values for x in GROWTH_CONTROLS["length"].values
    ]
    return dict(zip(places, Parallel(n_jobs=2)(delayed(_grow)(*p) for p in places), strict=True))


def _grow(noise: float, length: float) -> Curves:
    config = PostsConfig(runs=_RUNS, noise=noise, length=length, **_COARSE)
    return curves(config, run_posts(config, GROWTH_FILTERS, rng=np.random.default_rng(5), jobs=1))


def describe_growth(noise: float, length: float) -> str:
    """Return what a state of the explorer of noise and loop length shows, in words."""
    state = growth(noise, length)
    parts = [
        f"{name}: at most {state.error[name].max():.2f} m, {state.error[name][-1]:.2f} m at the "
        f"end, NEES {state.nees[name].mean():.1f}"
        for name in GROWTH_FILTERS
    ]
    return f"Errors and NEES along a loop of {length:g} m. " + "; ".join(parts) + "."


@dataclass(frozen=True, eq=False, slots=True)
class Nailed:
    """What a few known posts do.

    Parameters
    ----------
    posts : (n, 2)
        All posts, m.
    anchors : (count, 2)
        Those whose place is known, m.
    poses : (steps, 3)
        The true path.
    along : (k,)
        Distance driven, m.
    error, heading : (k,)
        Root mean square errors, m and °.
    places, covs : (e, 2), (e, 2, 2)
        Estimated positions of one run with covariances, m and m².
    """

    posts: Float[np.ndarray, "n 2"]
    anchors: Float[np.ndarray, "count 2"]
    poses: Float[np.ndarray, "steps 3"]
    along: Float[np.ndarray, " k"]
    error: Float[np.ndarray, " k"]
    heading: Float[np.ndarray, " k"]
    places: Float[np.ndarray, "e 2"]
    covs: Float[np.ndarray, "e 2 2"]


def nailed(count: int, place: float) -> Nailed:
    """Return a state of the explorer of anchors; all are computed at the first."""
    return _all_nailed()[count, place]


@cache
def _all_nailed() -> dict[tuple[int, float], Nailed]:
    none = _nail(0, 0.0)
    states = {(0, p): none for p in ANCHOR_CONTROLS["place"].values}
    places = [(c, p) for c in (1, 2) for p in ANCHOR_CONTROLS["place"].values]
    done = Parallel(n_jobs=2)(delayed(_nail)(*p) for p in places)
    return states | dict(zip(places, done, strict=True))


def _nail(count: int, place: float) -> Nailed:
    config = PostsConfig(noise=3.0, **_COARSE)
    posts, poses = config.world
    along = config.step * np.arange(len(poses))
    anchors = []
    for distance in (place, place + config.length / 2)[:count]:
        spot = poses[np.searchsorted(along, distance % along[-1]), :2] + [1e-6, 0.0]
        anchors.append(int(np.hypot(*(posts - spot).T).argmin()))
    case = Case("anchored, first estimates", "own", "known", config.start)
    histories = []
    for own in np.random.default_rng(6).spawn(_RUNS):
        sightings, chance = observe(config, rng=own)
        histories.append(filter_case(config, case, posts, poses, sightings, chance, anchors))
    errors = np.stack([h.poses - poses for h in histories])
    at = np.linspace(1, len(poses) - 1, 60).astype(int)
    shown = np.linspace(1, len(poses) - 1, 14).astype(int)
    return Nailed(
        posts,
        posts[anchors],
        poses,
        along[at],
        np.sqrt((errors[:, at, :2] ** 2).sum(axis=-1).mean(axis=0)),
        np.rad2deg(np.sqrt((wrap_angle(errors[:, at, 2]) ** 2).mean(axis=0))),
        histories[0].poses[shown, :2],
        histories[0].pose_covs[shown, :2, :2],
    )


def describe_nailed(count: int, place: float) -> str:
    """Return what a state of the explorer of anchors shows, in words."""
    state = nailed(count, place)
    return (
        f"Loop with {count} known posts; the position error is at most {state.error.max():.2f} m "
        f"and {state.error[-1]:.2f} m at the end, that of the heading {state.heading[-1]:.1f}°."
    )


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """What a filter believes at one moment of a drive.

    Parameters
    ----------
    posts : (n, 2)
        True places, m.
    truth, path : (k, 3)
        True and estimated path up to now.
    pose_cov : (2, 2)
        Covariance of the position now, m².
    landmarks, covs : (m, 2), (m, 2, 2)
        The map now, m and m².
    along
        Distance driven, m.
    """

    posts: Float[np.ndarray, "n 2"]
    truth: Float[np.ndarray, "k 3"]
    path: Float[np.ndarray, "k 3"]
    pose_cov: Float[np.ndarray, "2 2"]
    landmarks: Float[np.ndarray, "m 2"]
    covs: Float[np.ndarray, "m 2 2"]
    along: float


def moment(variant: str, time: int) -> Moment:
    """Return a state of the explorer of the ellipses; a whole drive is computed at the first."""
    return _moments(variant)[time]


@cache
def _moments(variant: str) -> list[Moment]:
    config = PostsConfig(noise=6.0, **_COARSE)
    posts, poses = config.world
    frames = np.linspace(2, len(poses) - 1, FRAMES).astype(int)
    sightings, chance = observe(config, rng=np.random.default_rng(8))
    case = Case(variant, "own", "known", config.start)
    history = filter_case(config, case, posts, poses, sightings, chance, keep=frames.tolist())
    moments = []
    for k in frames.tolist():
        belief = history.kept[k]
        moments.append(
            Moment(
                posts,
                poses[: k + 1],
                history.poses[: k + 1],
                belief.pose_cov[:2, :2],
                belief.landmarks,
                belief.landmark_covs,
                k * config.step,
            )
        )
    return moments


def describe_moment(variant: str, time: int) -> str:
    """Return what a state of the explorer of the ellipses shows, in words."""
    state = moment(variant, time)
    off = np.hypot(*(state.path[-1, :2] - state.truth[-1, :2]))
    stated = 2 * np.sqrt(np.linalg.eigvalsh(state.pose_cov)[-1])
    return (
        f"The {variant} filter after {state.along:.0f} m, with {len(state.landmarks)} landmarks in "
        f"the map: {off:.2f} m off; the 2σ ellipse of the robot reaches {stated:.2f} m."
    )

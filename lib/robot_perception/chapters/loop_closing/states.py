"""What the explorers show: noise and length, anchors, one drive.

All states of an explorer have the same noise, so that they compare.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from robot_perception.chapters.loop_closing import loops, posts
from robot_perception.chapters.loop_closing.loops import Case, Drive, Runs
from robot_perception.evaluation.sweep import sweep
from robot_perception.slam.planar import History
from robot_perception.teaching.results import kept

GROWTH_FILTERS = ("plain", "anchored", "first estimates", "external")
NOISES = (0.3, 1.0, 3.0, 6.0)
"""Of wheels and measurements, times the small one."""
LENGTHS = (30.0, 60.0, 90.0, 120.0)
"""Of the loop, m."""
PLACES = tuple(range(0, 90, 15))
"""Of the first anchor, m along the loop."""
FRAMES = 40


def _config(noise: float, length: float = 90.0) -> posts.Config:
    return posts.Config(
        runs=8, noise=noise, length=length, step=0.5, start="uncertain", variants=GROWTH_FILTERS
    )


# Noise and length --------------------------------------------------------------------------------


def growth(noise: float, length: float) -> posts.Result:
    """Return errors and NEES round a loop of some length with some noise."""
    return grown()[noise, length]


@kept
def grown() -> dict[tuple[float, float], posts.Result]:
    """Return what came of every noise and every length."""
    states = list(product(NOISES, LENGTHS))
    done = sweep(_grow, states, rng=np.random.default_rng(5), desc="noise and length")
    return dict(zip(states, done, strict=True))


def _grow(state: tuple[float, float], *, rng: np.random.Generator) -> posts.Result:
    return posts.run(_config(*state), rng=np.random.default_rng(5))


def growth_reach() -> tuple[float, float, float]:
    """Return how far the axes of all states go together: path (m), error (m), average NEES."""
    runs = [runs for result in grown().values() for runs in result.runs.values()]
    far = max(r.config.step * len(r.config.world[1]) for r in grown().values())
    return far, max(r.rms.max() for r in runs), max(r.nees.mean(axis=0).max() for r in runs)


# Anchors -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Nailed:
    """What a few posts at known places do: over all runs, and the first run by itself."""

    config: posts.Config
    anchors: tuple[int, ...]
    runs: Runs
    first: History


def nailed(count: int, place: float) -> Nailed:
    """Return what some anchors do, the first of them at a place."""
    return all_nailed()[count, place if count else 0]


@kept
def all_nailed() -> dict[tuple[int, float], Nailed]:
    """Return what no anchor, one and two at every place do."""
    states = [(0, 0), *product((1, 2), PLACES)]
    done = sweep(_nail, states, rng=np.random.default_rng(6), desc="anchors")
    return dict(zip(states, done, strict=True))


def _nail(state: tuple[int, float], *, rng: np.random.Generator) -> Nailed:
    (count, place), config = state, _config(3.0)
    places, poses = config.world
    along = config.step * np.arange(len(poses))
    anchors = []
    for distance in (place, place + config.length / 2)[:count]:
        spot = poses[np.searchsorted(along, distance % along[-1]), :2] + [1e-6, 0.0]
        anchors.append(int(np.hypot(*(places - spot).T).argmin()))
    case = posts.case(config, "anchored, first estimates")
    drives = [
        posts.simulate(config, rng=own) for own in np.random.default_rng(6).spawn(config.runs)
    ]
    histories = [loops.filter_drive(case, drive, anchors=anchors) for drive in drives]
    accounts = [loops.account(*pair) for pair in zip(histories, drives, strict=True)]
    return Nailed(config, tuple(anchors), loops.stack(accounts), histories[0])


# One drive ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Played:
    """One drive, what a filter made of it, and the steps after which its whole belief is kept."""

    config: posts.Config
    drive: Drive
    case: Case
    history: History
    steps: tuple[int, ...]

    def off(self, time: int) -> float:
        """Return the error of the position at one of the steps, m."""
        step = self.steps[time]
        return float(np.hypot(*(self.history.poses - self.drive.poses)[step, :2]))

    def ellipse(self, time: int) -> float:
        """Return the largest 2σ of the robot's position at one of the steps, m."""
        belief = self.history.kept[self.steps[time]]
        return float(2 * np.sqrt(np.linalg.eigvalsh(belief.pose_cov[:2, :2])[-1]))


@kept
def play(variant: str) -> Played:
    """Return one drive by one of the filters."""
    config = _config(6.0)
    drive, case = posts.simulate(config, rng=np.random.default_rng(8)), posts.case(config, variant)
    steps = tuple(np.linspace(2, len(drive.poses) - 1, FRAMES).astype(int).tolist())
    return Played(config, drive, case, loops.filter_drive(case, drive, keep=steps), steps)

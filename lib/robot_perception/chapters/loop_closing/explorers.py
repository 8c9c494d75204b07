"""The states of the explorers: what a filter is given, noise and length, anchors, one drive.

All states of an explorer have the same noise, so that they compare.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from robot_perception.chapters.loop_closing import building, loops, posts
from robot_perception.chapters.loop_closing.loops import Case, Drive, Runs
from robot_perception.evaluation.sweep import sweep
from robot_perception.slam.planar import History
from robot_perception.teaching.explore import choice, slider, timeline

BUILT_CONTROLS = {
    "given": choice("The filter is given", tuple(building.GIVEN), "an anchor"),
    "start": choice("Start", {"exact": "exact", "10 cm and 3° (1σ)": "uncertain"}, "exact"),
}
BUILT_PRESETS = {
    "the names": {"given": "the names"},
    "a sensor of the position": {"given": "a sensor of the position"},
    "names, uncertain start": {"given": "the names", "start": "uncertain"},
    "and an anchor": {"given": "the names and an anchor", "start": "uncertain"},
}
GROWTH_FILTERS = ("plain", "anchored", "first estimates", "external")
GROWTH_CONTROLS = {
    "noise": slider("Noise", (0.3, 1.0, 3.0, 6.0), 3.0, "× small"),
    "length": slider("Loop", (30.0, 60.0, 90.0, 120.0), 90.0, "m"),
}
GROWTH_PRESETS = {"quiet": {"noise": 0.3}, "rough and long": {"noise": 6.0, "length": 120.0}}
ANCHOR_CONTROLS = {
    "count": slider("Anchors", (0, 1, 2), 1),
    "place": slider("First anchor at", tuple(range(0, 90, 15)), 0, "m along the loop"),
}
ANCHOR_PRESETS = {"none": {"count": 0}, "a third round": {"place": 30}, "two": {"count": 2}}
FRAMES = 40
PLAY_CONTROLS = {
    "variant": choice("Filter", ("plain", "anchored", "external"), "plain"),
    "time": timeline("Time", range(FRAMES), 24, fps=6),
}
PLAY_PRESETS = {
    "just before": {"time": 33},
    "just after": {"time": 35},
    "with the anchor": {"variant": "anchored"},
    "watched from outside": {"variant": "external"},
}


def describe_built(given: str, start: str) -> str:
    """Return what a state of the explorer of maps shows, in words."""
    made = building.built(given, start)
    return (
        f"Map of a ring of corridors, drawn by a filter that is given {given} and starts "
        f"{'exactly known' if start == 'exact' else 'uncertain'}; at the end it is "
        f"{made.off:.2f} m off and has {made.twice} landmarks twice."
    )


def _config(noise: float, length: float = 90.0) -> posts.Config:
    return posts.Config(runs=8, noise=noise, length=length, step=0.5, start="uncertain")


# Noise and length --------------------------------------------------------------------------------


def growth(noise: float, length: float) -> posts.Result:
    """Return a state of the explorer of noise and loop length."""
    return _growth()[noise, length]


@cache
def _growth() -> dict[tuple[float, float], posts.Result]:
    states = list(product(*(control.values for control in GROWTH_CONTROLS.values())))
    done = sweep(_grow, states, rng=np.random.default_rng(5), desc="noise and length")
    return dict(zip(states, done, strict=True))


def _grow(state: tuple[float, float], *, rng: np.random.Generator) -> posts.Result:
    return posts.run(_config(*state), GROWTH_FILTERS, rng=np.random.default_rng(5))


@cache
def growth_reach() -> tuple[float, float, float]:
    """Return how far the axes of all states go together: path (m), error (m), average NEES."""
    runs = [runs for result in _growth().values() for runs in result.runs.values()]
    far = max(r.config.step * len(r.config.world[1]) for r in _growth().values())
    return far, max(r.rms.max() for r in runs), max(r.nees.mean(axis=0).max() for r in runs)


def describe_growth(noise: float, length: float) -> str:
    """Return what a state of the explorer of noise and loop length shows, in words."""
    parts = [
        f"{name}: at most {runs.rms.max():.2f} m, {runs.rms[-1]:.2f} m at the "
        f"end, NEES {runs.nees.mean():.1f}"
        for name, runs in growth(noise, length).runs.items()
    ]
    return f"Errors and NEES along a loop of {length:g} m. " + "; ".join(parts) + "."


# Anchors -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Nailed:
    """What a few posts at known places do: over all runs, and the first run by itself."""

    config: posts.Config
    anchors: tuple[int, ...]
    runs: Runs
    first: History


def nailed(count: int, place: float) -> Nailed:
    """Return a state of the explorer of anchors."""
    return _all_nailed()[count, place if count else 0]


@cache
def _all_nailed() -> dict[tuple[int, float], Nailed]:
    states = [(0, 0), *product((1, 2), ANCHOR_CONTROLS["place"].values)]
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


def path_errors() -> dict[tuple[int, float], float]:
    """Return the root mean square error over drives and paths, m, by count and place of anchors."""
    states = _all_nailed().items()
    return {key: float(np.sqrt(np.mean(state.runs.rms**2))) for key, state in states}


def describe_nailed(count: int, place: float) -> str:
    """Return what a state of the explorer of anchors shows, in words."""
    runs = nailed(count, place).runs
    return (
        f"Loop with {count} known posts; the position error is at most {runs.rms.max():.2f} m "
        f"and {runs.rms[-1]:.2f} m at the end, that of the heading {runs.rms_heading[-1]:.1f}°."
    )


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


@cache
def play(variant: str) -> Played:
    """Return one drive by one of the filters; the explorer shows its steps."""
    config = _config(6.0)
    drive, case = posts.simulate(config, rng=np.random.default_rng(8)), posts.case(config, variant)
    steps = tuple(np.linspace(2, len(drive.poses) - 1, FRAMES).astype(int).tolist())
    return Played(config, drive, case, loops.filter_drive(case, drive, keep=steps), steps)


def describe_play(variant: str, time: int) -> str:
    """Return what a state of the explorer of the ellipses shows, in words."""
    played = play(variant)
    step = played.steps[time]
    belief = played.history.kept[step]
    stated = 2 * np.sqrt(np.linalg.eigvalsh(belief.pose_cov[:2, :2])[-1])
    return (
        f"The {variant} filter after {step * played.config.step:.0f} m, with "
        f"{len(belief.landmarks)} landmarks in the map: {played.off(time):.2f} m off; the 2σ "
        f"ellipse of the robot reaches {stated:.2f} m."
    )

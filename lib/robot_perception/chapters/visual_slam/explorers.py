"""The states of the explorers: one drive with few and many particles, over time, and turned.

All states of an explorer have the same wheels, so that they compare.
"""

from functools import cache

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import drives, frontend, maps
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.chapters.visual_slam.maps import Topology
from robot_perception.chapters.visual_slam.resampling import RULES
from robot_perception.evaluation.sweep import sweep
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.teaching.explore import choice, slider, timeline
from robot_perception.teaching.tables import Table

SEED = 3
"""Of the drive that is shown."""
COUNTS = (1, 10, 50, 100)
FILM = frontend.PAPER

MAP_CONTROLS = {"count": slider("Particles", COUNTS, 1)}
MAP_PRESETS = {"ten": {"count": 10}, "a hundred": {"count": 100}}

MOMENTS = tuple(range(13, FILM.frames, 17))
"""Frames of the timeline; the last one is the end of the drive."""
PLAY_COUNT = 50
PLAY_CONTROLS = {
    "rule": choice("Resampled", tuple(RULES), "below M/2"),
    "at": timeline("Frame", MOMENTS, MOMENTS[9], fps=5),
}
PLAY_PRESETS = {
    "the end": {"at": MOMENTS[-1]},
    "never": {"rule": "never"},
    "never, the end": {"rule": "never", "at": MOMENTS[-1]},
}

TURN_CONTROLS = {
    "count": choice("Particles", (1, 10, 100), 10),
    "turn": timeline("Turn", range(0, 360, 15), 30, "°", fps=6),
}
TURN_PRESETS = {"from the side": {"turn": 0}, "one particle": {"count": 1}}


def driven(count: int, rule: str = "below M/2") -> Drive:
    """Return the drive that is shown with a number of particles and a rule of resampling."""
    return _driven()[count, rule]


@cache
def _driven() -> dict[tuple[int, str], Drive]:
    states = sorted({(count, "below M/2") for count in COUNTS} | {(PLAY_COUNT, r) for r in RULES})
    frontend.seen(FILM)  # before the work is handed out
    done = sweep(_drive, states, rng=np.random.default_rng(SEED), desc="drives")
    return dict(zip(states, done, strict=True))


def _drive(state: tuple[int, str], *, rng: np.random.Generator) -> Drive:
    count, rule = state
    seen = frontend.seen(FILM)
    report = drives.roll(seen.poses, rng=np.random.default_rng(SEED))
    return drives.run(seen, Options(count, share=RULES[rule]), report, rng=rng)


@cache
def measured(count: int) -> tuple[float, Topology]:
    """Return the error of the path (m) and the topology of the map."""
    drive = driven(count)
    return absolute_error(drive.path, drive.seen.poses, False), maps.topology(drive, FILM)


def describe_map(count: int) -> str:
    """Return what a state of the explorer of maps shows, in words."""
    error, found = measured(count)
    return (
        f"Map (particles: {count}): {len(driven(count).places)} landmarks, path {error:.2f} m "
        f"off; {found.inside:.0%} of the landmarks lie in their room."
    )


def spread(drive: Drive, frame: int) -> float:
    """Return the standard deviation of the particles' places at a frame, m."""
    return float(np.sqrt(drive.poses[frame][:, :2].var(axis=0).sum()))


def ancestors(drive: Drive, frame: int) -> np.ndarray:
    """Return how many particles of each earlier frame have a descendant at a frame."""
    alive = np.arange(drive.poses.shape[1])
    counts = np.empty(frame + 1, dtype=int)
    for k in range(frame, -1, -1):
        counts[k] = len(alive)
        alive = np.unique(drive.ancestors[k][alive])
    return counts


def describe_play(rule: str, at: int) -> str:
    """Return what a state of the explorer of particles shows, in words."""
    drive = driven(PLAY_COUNT, rule)
    alive = ancestors(drive, at)
    return (
        f"Frame {at}, resampled {rule}: effective number "
        f"{drive.effective[at]:.1f} of {PLAY_COUNT}; the particles spread over "
        f"{spread(drive, at):.2f} m and descend from {alive[max(at - 20, 0)]} of those twenty "
        "frames before."
    )


def turned(points: Float[np.ndarray, "n 3"], turn: float) -> Float[np.ndarray, "n 2"]:
    """Return points of space as seen from a height, the building turned by some degrees."""
    angle, tilt = np.deg2rad(turn), np.deg2rad(35.0)
    x, y, z = (points - [10.0, 1.1, 0.0]).T
    across = np.cos(angle) * x - np.sin(angle) * y
    away = np.sin(angle) * x + np.cos(angle) * y
    return np.stack([across, np.sin(tilt) * away + np.cos(tilt) * z], axis=-1)


NUMBER = 8
"""Bytes of a number."""


def memory_table() -> Table:
    """Return the memory of the maps of the drive that is shown, and that of plain arrays."""
    states = {f"M = {m}": driven(m) for m in COUNTS}
    states[f"M = {PLAY_COUNT}, never resampled"] = driven(PLAY_COUNT, "never")
    rows = {
        name: (
            float(len(drive.places)),
            np.mean([len(block) for block in drive.maps.blocks]),
            drive.maps.nbytes / 1e6,
            plain(drive) / 1e6,
        )
        for name, drive in states.items()
    }
    columns = {
        "landmarks": "in the map at the end",
        "versions": "of a landmark that some particle holds, on average",
        "shared (MB)": "memory of the maps, each version held once",
        "plain (MB)": "memory of arrays with a mean and a covariance for each particle",
    }
    return Table(rows, columns, "the drive that is shown", "particles")


def plain(drive: Drive) -> int:
    """Return the memory of all maps as plain arrays, bytes: 3 + 9 numbers a landmark."""
    return len(drive.maps) * len(drive.places) * (3 + 9) * NUMBER


def describe_turn(count: int, turn: float) -> str:
    """Return what a state of the explorer of space shows, in words."""
    drive = driven(count)
    return (
        f"The {len(drive.places)} landmarks of the map in space (particles: {count}), the "
        f"building turned by {turn:g}°."
    )

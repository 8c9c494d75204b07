"""The explorers: the map by few and many particles, the particles over time, the map in space.

All states show one drive, with the same wheels, so that they compare.
"""

from functools import cache, partial
from itertools import islice
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from data_synth.wheels import Odometry
from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam import figures as draw
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.chapters.visual_slam.maps import Topology, topology
from robot_perception.chapters.visual_slam.resampling import RULES
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.teaching.controls import choice, slider, timeline
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure
from robot_perception.teaching.tables import Table

SEED = 3
"""Of the drive that is shown."""
COUNTS = (1, 10, 50, 100)
PLAYED = 50
"""Particles of the drive that is shown over time."""
STATES = sorted({(m, "below M/2") for m in COUNTS} | {(PLAYED, rule) for rule in RULES})
"""All that is driven, each with a generator of its own, in this order."""


def driven(count: int, rule: str = "below M/2") -> Drive:
    """Return the drive that is shown with a number of particles and a rule of resampling."""
    return _driven(count, rule)


@cache
def _driven(count: int, rule: str) -> Drive:
    seen, (report, own) = frontend.seen(), draws(count, rule)
    return drives.run(seen, Options(count, share=RULES[rule]), report, rng=own)


def draws(count: int, rule: str = "below M/2") -> tuple[Odometry, np.random.Generator]:
    """Return what the wheels of the drive that is shown report, and the draws of its particles."""
    own = np.random.default_rng(SEED).spawn(len(STATES))[STATES.index((count, rule))]
    return drives.roll(frontend.seen().poses, rng=np.random.default_rng(SEED)), own


class Glimpse(NamedTuple):
    """M particles before a frame, and what wheels and eyes then say: n landmarks of their maps.

    Places are m, of robots with the heading in rad; the points are in the frame of the camera.
    """

    poses: Float[np.ndarray, "M 3"]
    increment: Float[np.ndarray, "3"]
    increment_cov: Float[np.ndarray, "3 3"]
    mount: Float[np.ndarray, "4 4"]
    points: Float[np.ndarray, "n 3"]
    noise: Float[np.ndarray, "n 3 3"]
    means: Float[np.ndarray, "n M 3"]
    covs: Float[np.ndarray, "n M 3 3"]


def glimpse(frame: int, count: int = 5, points: int = 1) -> Glimpse:
    """Return some particles just before a frame of the drive, and the first known points in it."""
    seen, rng = frontend.seen(), np.random.default_rng(SEED)
    report = drives.roll(seen.poses, rng=rng)
    run = drives.steps(seen, Options(count), report, rng=rng)
    before, (_, info, _) = list(islice(run, frame + 1))[-2:]
    known = np.flatnonzero(info.known)[:points]
    rows, maps = np.flatnonzero(seen.frames == frame)[known], before[0].maps
    found = [maps.landmarks(m) for m in range(count)]
    own = [np.searchsorted(ids, info.names[known]) for ids, _ in found]
    motion = drives.motions(report)[frame - 1]
    return Glimpse(
        maps.poses,
        motion.increment,
        motion.increment_cov,
        frontend.RIG.T_robot_camera,
        seen.points[rows],
        seen.covs[rows],
        *(
            np.stack([part(g)[k] for k, (_, g) in zip(own, found, strict=True)], axis=1)
            for part in (attrgetter("mean"), attrgetter("cov"))
        ),
    )


Measured = tuple[Drive, float, Topology]


@cache
def measured(count: int) -> Measured:
    """Return the drive with a number of particles, the error of its path, m, and its topology."""
    drive = driven(count)
    return drive, absolute_error(drive.path, drive.seen.poses, False), topology(drive)


def describe_map(state: Measured) -> str:
    """Return what a map shows, in words."""
    drive, error, found = state
    return (
        f"Map (particles: {drive.options.particles}): {len(drive.founders)} landmarks, path "
        f"{error:.2f} m off; {found.inside:.0%} of the landmarks lie in their room."
    )


MAP = Exploration(
    lambda ax, state: draw.built(ax, state[0]),
    measured,
    describe_map,
    {"count": slider("Particles", COUNTS, 1)},
    name="slam-map",
    caption="The map with one particle and with more, as in Fig. 4 of the paper: that of the "
    "heaviest particle at the end. Grey: the true walls; thin solid: the true path; dashed red: "
    "the estimated one; green: landmarks, points of the walls and of what stands before them.",
    presets={"ten": {"count": 10}, "a hundred": {"count": 100}},
    axes=partial(figure, width=6.4, height=4.4),
    finding=lambda state: state[1:],
)


def kin(drive: Drive, frame: int) -> int:
    """Return from how many particles twenty frames before those of a frame descend."""
    return int(drive.survivors(frame)[max(frame - 20, 0)])


def describe_play(state: tuple[Drive, str, int]) -> str:
    """Return what a moment of the drive shows, in words."""
    drive, rule, frame = state
    spread = np.sqrt(drive.poses[frame, :, :2].var(axis=0).sum())
    return (
        f"Frame {frame}, resampled {rule}: effective number {drive.effective[frame]:.1f} of "
        f"{PLAYED}; the particles spread over {spread:.2f} m and descend from {kin(drive, frame)} "
        "of those twenty frames before."
    )


MOMENTS = tuple(range(13, frontend.FRAMES, 17))
"""Frames of the timeline; the last one is the end of the drive."""

PLAY = Exploration(
    lambda axes, state: draw.particles(axes, state[0], state[2]),
    lambda rule, at: (driven(PLAYED, rule), rule, at),
    describe_play,
    {
        "rule": choice("Resampled", tuple(RULES), "below M/2"),
        "at": timeline("Frame", MOMENTS, MOMENTS[9], fps=5),
    },
    name="slam-particles",
    caption="Fifty particles on the drive. Above: where they are, and the paths that led there; "
    "thin solid: the true path. Below, on a logarithmic scale: red, how many particles of each "
    "earlier frame have a descendant now; grey, the effective number in that frame.",
    presets={
        "the end": {"at": MOMENTS[-1]},
        "never": {"rule": "never"},
        "never, the end": {"rule": "never", "at": MOMENTS[-1]},
    },
    axes=partial(figure, 2, 1, width=6.4, height=7.0),
    finding=lambda state: (kin(state[0], state[2]), state[0].effective[state[2]]),
)


def describe_turn(state: tuple[Drive, float]) -> str:
    """Return what the map in space shows, in words."""
    drive, turn = state
    return (
        f"The {len(drive.founders)} landmarks of the map in space (particles: "
        f"{drive.options.particles}), the building turned by {turn:g}°."
    )


def gaps(state: tuple[Drive, float]) -> tuple[float, float]:
    """Return by how much half of the landmarks err in the plane, and in height, m."""
    x, y, z = (state[0].means - state[0].places).T
    return float(np.median(np.hypot(x, y))), float(np.median(np.abs(z)))


SPACE = Exploration(
    lambda ax, state: draw.in_space(ax, *state),
    lambda count, turn: (driven(count), turn),
    describe_turn,
    {
        "count": choice("Particles", (1, 10, 100), 10),
        "turn": timeline("Turn", range(0, 360, 15), 30, "°", fps=6),
    },
    name="slam-space",
    caption="The map in space, seen from a height; the best rigid motion has laid its path on "
    "the true one. Grey: walls on the floor; red: path; green: landmarks.",
    presets={"from the side": {"turn": 0}, "one particle": {"count": 1}},
    axes=partial(figure, width=6.4, height=4.2),
    finding=gaps,
)


def memory_table() -> Table:
    """Return the memory of the maps of the drive that is shown, and that of plain arrays."""
    shown = {f"M = {m}": driven(m) for m in COUNTS}
    shown[f"M = {PLAYED}, never resampled"] = driven(PLAYED, "never")
    rows = {
        name: (
            float(len(drive.founders)),
            np.mean([len(block) for block in drive.maps.blocks]),
            drive.maps.nbytes / 1e6,
            plain(drive) / 1e6,
        )
        for name, drive in shown.items()
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
    return len(drive.maps) * len(drive.founders) * (3 + 9) * np.dtype(float).itemsize

"""One drive through the filter of the paper: stable tracks in, path, map and accounts out."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from data_synth import wheels
from data_synth.textured_building import SLIP
from robot_perception.chapters.visual_slam.frontend import RIG, Seen
from robot_perception.geometry import compose
from robot_perception.landmarks import Euclidean
from robot_perception.observations import Observations
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import Odometry
from robot_perception.slam.visual import FrameInfo, Newcomers, Options, VisualMaps, step

SAME = 0.3
"""A match is wrong where the point lies farther than that from what the landmark was made of, m."""
AGAIN = 0.05
"""A landmark is in the map again where another one of the same surface is nearer than that, m."""
TEN = Options()


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """What came of one drive.

    Parameters
    ----------
    options
        How the filter ran.
    seen
        What it was given.
    odometry : (frames, 3)
        The path by the wheels alone.
    poses : (frames, M, 3)
        The particles at each time.
    ancestors : (frames, M)
        From which particle before it each comes.
    effective : (frames,)
        Effective number before particles are drawn.
    drawn : (frames,)
        Whether they were drawn anew.
    maps
        The belief at the end.
    rows, names
        Each point that went into the filter, and the landmark that it was taken for.
    places, carriers, made
        What the landmarks were made of: place in the world (m), surface, and the frame.
    matched, wrong
        Tracks that were recognised, and how many of them as something else.
    twice
        Landmarks that were in the map already.
    observed : (frames,)
        Observations that went into the filter.
    """

    options: Options
    seen: Seen
    odometry: Float[np.ndarray, "frames 3"]
    poses: Float[np.ndarray, "frames M 3"]
    ancestors: Int[np.ndarray, "frames M"]
    effective: Float[np.ndarray, "frames"]
    drawn: Bool[np.ndarray, "frames"]
    maps: rb.ParticleMaps
    rows: Int[np.ndarray, "points"]
    names: Int[np.ndarray, "points"]
    places: Float[np.ndarray, "n 3"]
    carriers: Int[np.ndarray, "n"]
    made: Int[np.ndarray, "n"]
    matched: int
    wrong: int
    twice: int
    observed: Int[np.ndarray, "frames"]

    @property
    def best(self) -> int:
        """The particle with the largest weight at the end."""
        return self.maps.best

    @property
    def means(self) -> Float[np.ndarray, "n 3"]:
        """The landmarks of the best particle, m."""
        return self.maps.landmarks(self.best)[1].mean

    @property
    def lineage(self) -> Int[np.ndarray, "frames M"]:
        """From which particle of each time each particle of the end comes."""
        return rb.lineage(list(self.ancestors))

    @property
    def path(self) -> Float[np.ndarray, "frames 3"]:
        """The path of the best particle."""
        return self.poses[np.arange(len(self.poses)), self.lineage[:, self.best]]

    @property
    def survivors(self) -> Int[np.ndarray, "frames"]:
        """How many particles of each time have a descendant at the end."""
        return np.array([len(set(row)) for row in self.lineage.tolist()])


def roll(poses: np.ndarray, *, rng: np.random.Generator) -> wheels.Odometry:
    """Return what the wheels report of a path."""
    return wheels.roll(poses, SLIP, rng=rng)


def dead_reckoning(start: np.ndarray, report: wheels.Odometry) -> Float[np.ndarray, "frames 3"]:
    """Return the path by the wheels alone."""
    path = [np.asarray(start, float)]
    for increment in report.increments:
        path.append(compose(path[-1], increment))
    return np.array(path)


def motions(report: wheels.Odometry) -> list[Odometry]:
    """Return what the wheels report as the filter takes it."""
    return [
        Odometry(increment, np.diag(sigma**2))
        for increment, sigma in zip(report.increments, report.deviations, strict=True)
    ]


def alike(asked: Newcomers) -> Float[np.ndarray, "m N"]:
    """Return what it costs to take newcomers for landmarks: the distances of their descriptors."""
    return np.sqrt(Euclidean(asked.landmarks).distances(asked.descriptors))


def apart(
    seen: Seen, rows: Int[np.ndarray, "m"], others: Int[np.ndarray, "N"]
) -> Float[np.ndarray, "m N"]:
    """Return how far apart points are in truth, m; infinite where it is not the same place."""
    near = np.linalg.norm(seen.places[rows][:, None] - seen.places[others], axis=-1)
    same = seen.carriers[rows][:, None] == seen.carriers[others]
    return np.where(same & (near < AGAIN), near, np.inf)


def run(
    seen: Seen,
    options: Options,
    report: wheels.Odometry,
    *,
    rng: np.random.Generator,
    told: bool = False,
) -> Drive:
    """Run the filter over a drive, and score it; ``told``, the renderer names the landmarks."""
    state = VisualMaps.start(seen.poses[0], options, length=seen.descriptors.shape[1])
    founders = np.empty(0, dtype=int)  # the points that landmarks were made of
    poses, infos = [], []
    ends = np.searchsorted(seen.frames, np.arange(len(seen.poses) + 1))
    for (begin, end), motion in zip(pairwise(ends), [None, *motions(report)], strict=True):
        rows = np.arange(begin, end)
        state, info = step(
            state,
            motion,
            Observations(seen.tracks[rows], seen.points[rows], seen.covs[rows]),
            seen.descriptors[rows].astype(float),
            RIG.T_robot_camera,
            costs=partial(_named, seen, rows, founders) if told else alike,
            options=options,
            rng=rng,
        )
        founders = np.append(founders, rows[info.new])
        poses.append(state.maps.poses)
        infos.append(info)
    return _scored(seen, options, report, np.array(poses), infos, state.maps)


def _named(seen: Seen, rows: np.ndarray, founders: np.ndarray, asked: Newcomers) -> np.ndarray:
    """Return the costs that know the truth: nothing but the place itself will do."""
    return apart(seen, rows[asked.rows], founders)


def _scored(
    seen: Seen,
    options: Options,
    report: wheels.Odometry,
    poses: np.ndarray,
    infos: Sequence[FrameInfo],
    maps: rb.ParticleMaps,
) -> Drive:
    """Judge by the truth what the filter made of each point."""
    names, first, new = (
        np.concatenate(column)
        for column in zip(*((info.names, info.first, info.new) for info in infos), strict=True)
    )
    founders, matched, used = map(np.flatnonzero, (new, first & ~new, names >= 0))
    far = np.linalg.norm(seen.places[matched] - seen.places[founders[names[matched]]], axis=1)
    made = seen.frames[founders]
    again = [apart(seen, founders[made == k], founders[made < k]) for k in np.unique(made)]
    return Drive(
        options,
        seen,
        dead_reckoning(seen.poses[0], report),
        poses,
        np.array([info.resampling.ancestors for info in infos]),
        np.array([info.resampling.effective for info in infos]),
        np.array([info.resampling.resampled for info in infos]),
        maps,
        used,
        names[used],
        seen.places[founders],
        seen.carriers[founders],
        made,
        len(matched),
        int(np.count_nonzero(far > SAME)),
        sum(int(np.isfinite(gaps).any(axis=1).sum()) for gaps in again),
        np.array([info.known.sum() for info in infos]),
    )

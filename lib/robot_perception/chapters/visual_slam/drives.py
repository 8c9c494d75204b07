"""One drive through the filter of the paper: stable tracks in, path, map and accounts out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from data_synth import wheels
from data_synth.textured_building import SLIP
from robot_perception.chapters.visual_slam.frontend import RIG, Seen
from robot_perception.landmarks.metrics import Metric, euclidean_mean
from robot_perception.observations import Observations
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import Odometry, dead_reckoning
from robot_perception.slam.visual import FrameInfo, Newcomers, Options, VisualMaps, VisualSlam

SAME = 0.3
"""A match is wrong where the point lies farther than that from what the landmark was made of, m."""
AGAIN = 0.05
"""A landmark is in the map again where another one of the same surface is nearer than that, m."""


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """What came of one drive, m and rad.

    At each time there are the path by the wheels alone, ``odometry``, the poses of the particles,
    from which particle before it each comes, the effective number before they are drawn anew,
    whether they were, and how many observations went into the filter. At the end there are the
    maps; ``rows``, the points that went in, and ``names``, the landmarks that they were taken for;
    ``founders``, the points that landmarks were made of; how many tracks were recognised, how many
    of these as something else, and how many landmarks were in the map already.

    Where each particle names by its own map, points, landmarks and what was observed are those of
    the particle with the largest weight at the end, and of those that it comes from.
    """

    options: Options
    seen: Seen
    odometry: Float[np.ndarray, "frames 3"]
    poses: Float[np.ndarray, "frames M 3"]
    ancestors: Int[np.ndarray, "frames M"]
    effective: Float[np.ndarray, "frames"]
    drawn: Bool[np.ndarray, "frames"]
    observed: Int[np.ndarray, "frames"]
    maps: rb.ParticleMaps
    rows: Int[np.ndarray, "points"]
    names: Int[np.ndarray, "points"]
    founders: Int[np.ndarray, "n"]
    matched: int
    wrong: int
    twice: int

    @property
    def places(self) -> Float[np.ndarray, "n 3"]:
        """The true places of the landmarks in the world, m."""
        return self.seen.places[self.founders]

    @property
    def means(self) -> Float[np.ndarray, "n 3"]:
        """The landmarks of the particle with the largest weight, m."""
        return self.maps.landmarks(self.maps.best)[1].mean

    @property
    def path(self) -> Float[np.ndarray, "frames 3"]:
        """The path of the same particle."""
        return self.paths()[:, self.maps.best]

    def lineage(self, frame: int = -1) -> Int[np.ndarray, "times M"]:
        """Return from which particle of each time until a frame each particle there comes."""
        return rb.lineage(list(self.ancestors[: frame % len(self.poses) + 1]))

    def paths(self, frame: int = -1) -> Float[np.ndarray, "times M 3"]:
        """Return the path of each particle until a frame."""
        lineage = self.lineage(frame)
        return self.poses[np.arange(len(lineage))[:, None], lineage]

    def survivors(self, frame: int = -1) -> Int[np.ndarray, "times"]:
        """Return how many particles of each time until a frame have a descendant there."""
        return np.array([len(set(row)) for row in self.lineage(frame).tolist()])


roll = partial(wheels.roll, slip=SLIP)
"""``roll(poses, rng=rng)``: what the wheels report of a path."""


def motions(report: wheels.Odometry) -> list[Odometry]:
    """Return what the wheels report as the filter takes it."""
    return [
        Odometry(increment, np.diag(sigma**2))
        for increment, sigma in zip(report.increments, report.deviations, strict=True)
    ]


def apart(
    seen: Seen, rows: Int[np.ndarray, "m"], others: Int[np.ndarray, "N"]
) -> Float[np.ndarray, "m N"]:
    """Return how far apart points are in truth, m; infinite where it is not the same place."""
    near = np.linalg.norm(seen.places[rows][:, None] - seen.places[others], axis=-1)
    same = seen.carriers[rows][:, None] == seen.carriers[others]
    return np.where(same & (near < AGAIN), near, np.inf)


def steps(
    seen: Seen,
    options: Options,
    report: wheels.Odometry,
    *,
    rng: np.random.Generator,
    told: bool = False,
    metric: Metric = euclidean_mean,
) -> Iterator[tuple[VisualMaps, FrameInfo, Int[np.ndarray, "made"]]]:
    """Run the filter over a drive; yield what it knows at each frame, and what it made of it.

    With them come the rows of the points that became landmarks. ``told``, the renderer names the
    landmarks.
    """
    slam = VisualSlam(RIG.T_robot_camera, options)
    state = slam.start(seen.poses[0], length=seen.descriptors.shape[1])
    founders = np.empty(0, dtype=int)
    ends = np.searchsorted(seen.frames, np.arange(len(seen.poses) + 1))
    for (begin, end), motion in zip(pairwise(ends), [None, *motions(report)], strict=True):
        rows = np.arange(begin, end)
        state, info = slam.step(
            state,
            motion,
            Observations(seen.tracks[rows], seen.points[rows], seen.covs[rows]),
            seen.descriptors[rows].astype(float),
            costs=partial(_named, seen, rows, founders) if told else metric,
            rng=rng,
        )
        founders = np.append(founders, rows[info.made])
        yield state, info, rows[info.made]


def run(
    seen: Seen,
    options: Options,
    report: wheels.Odometry,
    *,
    rng: np.random.Generator,
    told: bool = False,
    metric: Metric = euclidean_mean,
) -> Drive:
    """Run the filter over a drive as `steps` does, and score it."""
    infos, poses, rows = [], [], []
    for state, info, made in steps(seen, options, report, rng=rng, told=told, metric=metric):
        infos.append(info)
        poses.append(state.maps.poses)
        rows.append(made)
    founders = np.concatenate(rows)
    resamplings = [info.resampling for info in infos]
    own = _of_best(infos, state.maps.best)
    return Drive(
        options,
        seen,
        dead_reckoning(seen.poses[0], motions(report)),
        np.array(poses),
        np.array([drawing.ancestors for drawing in resamplings]),
        np.array([drawing.effective for drawing in resamplings]),
        np.array([drawing.resampled for drawing in resamplings]),
        np.array([info.known.sum() for info in own]),
        state.maps,
        **_scored(seen, founders, own, state.maps),
    )


def _of_best(infos: Sequence[FrameInfo], best: int) -> list[FrameInfo]:
    """Return what a particle of the end and those that it comes from made of each frame."""
    if infos[0].names.ndim == 1:
        return list(infos)
    line = rb.lineage([info.resampling.ancestors for info in infos])[:, best]
    return [
        replace(info, names=info.names[m], new=info.new[m])
        for info, m in zip(infos, line, strict=True)
    ]


def _named(seen: Seen, rows: np.ndarray, founders: np.ndarray, asked: Newcomers) -> np.ndarray:
    """Return the costs that know the truth: nothing but the place itself will do."""
    return apart(seen, rows[asked.rows], founders)


def _scored(
    seen: Seen, founders: np.ndarray, infos: Sequence[FrameInfo], maps: rb.ParticleMaps
) -> dict:
    """Judge by the truth what the filter made of each point; landmarks are those of the best."""
    names, first, new = (
        np.concatenate(column)
        for column in zip(*((info.names, info.first, info.new) for info in infos), strict=True)
    )
    own = maps.landmarks(maps.best)[0]
    founders, names = founders[own], np.where(names < 0, -1, np.searchsorted(own, names))
    matched, used = np.flatnonzero(first & ~new), np.flatnonzero(names >= 0)
    far = np.linalg.norm(seen.places[matched] - seen.places[founders[names[matched]]], axis=1)
    made = seen.frames[founders]
    again = [apart(seen, founders[made == k], founders[made < k]) for k in np.unique(made)]
    return {
        "rows": used,
        "names": names[used],
        "founders": founders,
        "matched": len(matched),
        "wrong": int(np.count_nonzero(far > SAME)),
        "twice": sum(int(np.isfinite(gaps).any(axis=1).sum()) for gaps in again),
    }

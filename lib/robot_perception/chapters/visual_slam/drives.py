"""One drive through the filter of the paper: stable tracks in, path, map and accounts out."""

import itertools
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from data_synth import wheels
from data_synth.textured_building import SLIP
from robot_perception.chapters.visual_slam.frontend import RIG, Seen
from robot_perception.geometry import compose
from robot_perception.landmarks import DescriptorClasses, Euclidean
from robot_perception.observations import Observations
from robot_perception.particles import effective_number
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import Odometry

SAME = 0.3
"""A match is wrong where the point lies farther than that from what the landmark was made of, m."""
AGAIN = 0.05
"""A landmark is in the map again where another one of the same surface is nearer than that, m."""


@dataclass(frozen=True, slots=True)
class Options:
    """How the filter runs; paper: section 3, section 5.

    Parameters
    ----------
    particles
        M; paper: 1, 10, 50, 100.
    stable
        A track gives observations once it is longer than so many frames; paper: 5.
    share
        Particles are drawn anew below this share of M; paper: 1/2; 0 is never, 1 is always.
    criterion
        What is compared with it: the effective number, or what eq. (7) prints.
    limit
        Largest distance of mean descriptors of one landmark, whose length is 512; ours.
    level
        Probability that a right match passes the gate in space; ours.
    reach
        Standard deviation that the gate adds to what the particles say of a coordinate, m; ours.
        Particles that descend from one know nothing of the error that they share.
    names
        Whether landmarks are recognised by descriptor and place (``"found"``), or told by the
        renderer (``"told"``).
    noise
        What the standard deviation of the points is multiplied by in the filter; ours.
    """

    particles: int = 10
    stable: int = 5
    share: float = 0.5
    criterion: Literal["effective", "printed"] = "effective"
    limit: float = 150.0
    level: float = 0.999
    reach: float = 0.3
    names: Literal["found", "told"] = "found"
    noise: float = 1.0


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


@dataclass(frozen=True, eq=False, slots=True)
class Stable:
    """The points of stable tracks, frame by frame, and the classes of their descriptors.

    Parameters
    ----------
    rows
        For each frame the points whose track is stable by then.
    first
        For each frame whether the track becomes so in it.
    means : (tracks, 128)
        Mean descriptor of each track when it becomes stable.
    """

    rows: tuple[np.ndarray, ...]
    first: tuple[np.ndarray, ...]
    means: np.ndarray


@cache
def stable_points(seen: Seen, stable: int) -> Stable:
    """Return the points of tracks that have been followed for more than so many frames."""
    order = np.lexsort((seen.frames, seen.tracks))
    starts = np.flatnonzero(np.diff(seen.tracks[order], prepend=-1))
    age = np.empty(len(order), dtype=int)
    lengths = np.diff(starts, append=len(order))
    age[order] = np.arange(len(order)) - np.repeat(starts, lengths) + 1
    means = np.zeros((len(starts), seen.descriptors.shape[1]))
    early = age <= stable + 1
    np.add.at(means, seen.tracks[early], seen.descriptors[early])
    means /= np.minimum(lengths, stable + 1)[:, None]
    old = np.flatnonzero(age > stable)
    ends = np.searchsorted(seen.frames[old], np.arange(len(seen.poses) + 1))
    rows = tuple(old[a:b] for a, b in itertools.pairwise(ends))
    return Stable(rows, tuple(age[r] == stable + 1 for r in rows), means)


def run(
    seen: Seen, options: Options, report: wheels.Odometry, *, rng: np.random.Generator
) -> Drive:
    """Run the filter over a drive."""
    mount = RIG.T_robot_camera
    stable = stable_points(seen, options.stable)
    count = options.particles
    maps = rb.ParticleMaps.start(seen.poses[0], count)
    criterion = effective_number if options.criterion == "effective" else rb.printed_number
    names: dict[int, int] = {}  # of tracks
    founders: list[int] = []  # rows of the points that landmarks were made of
    classes = None
    used: list[tuple[np.ndarray, np.ndarray]] = []
    poses, ancestors, effective, drawn, observed = [], [], [], [], []
    matched = wrong = twice = 0
    for k, (rows, first) in enumerate(zip(stable.rows, stable.first, strict=True)):
        if k:
            motion = Odometry(
                report.increments[k - 1],
                np.diag(report.deviations[k - 1] ** 2),
            )
            maps = rb.predict(maps, motion, rng=rng)
        tracks = seen.tracks[rows]
        look = Observations(
            np.full(len(rows), -1), seen.points[rows], options.noise**2 * seen.covs[rows]
        )
        found = np.full(len(rows), -1)
        if founders and len(rows):
            costs = np.full((len(rows), len(founders)), np.inf)
            if options.names == "found":
                costs[first] = np.sqrt(
                    Euclidean(classes.means).distances(stable.means[tracks[first]])
                )
            else:
                near = np.linalg.norm(
                    seen.places[rows[first]][:, None] - seen.places[founders], axis=-1
                )
                same = seen.carriers[rows[first]][:, None] == seen.carriers[founders]
                costs[first] = np.where(same & (near < AGAIN), near, np.inf)
            for i in np.flatnonzero(~first):
                if tracks[i] in names:
                    costs[i, names[tracks[i]]] = 0.0
            wide = Observations(look.ids, look.values, look.covs + options.reach**2 * np.eye(3))
            found = rb.associate_shared(
                maps, wide, mount, costs=costs, limit=options.limit, level=options.level
            )
        for i in np.flatnonzero(first & (found >= 0)):
            names[tracks[i]] = int(found[i])
            matched += 1
            far = np.linalg.norm(seen.places[rows[i]] - seen.places[founders[found[i]]])
            wrong += bool(far > SAME)
        known = found >= 0
        info_drawn, ancestor = False, np.arange(count)
        number = effective_number(maps.particles.log_weights)
        if known.any():
            maps, _ = rb.update(maps, look.named(found)[known], mount)
            number = effective_number(maps.particles.log_weights)
            maps, info = rb.resample(maps, rng=rng, share=options.share, criterion=criterion)
            info_drawn, ancestor = info.resampled, info.ancestors
        new = np.flatnonzero(first & ~known)
        if len(new):
            ids = len(founders) + np.arange(len(new))
            if founders:
                near = np.linalg.norm(
                    seen.places[rows[new]][:, None] - seen.places[founders], axis=-1
                )
                same = seen.carriers[rows[new]][:, None] == seen.carriers[founders]
                twice += int((same & (near < AGAIN)).any(axis=1).sum())
            maps = rb.add_landmarks(maps, look[new].named(ids), mount)
            fresh = DescriptorClasses.of(stable.means[tracks[new]])
            classes = fresh if classes is None else classes.with_others(fresh)
            names |= zip(tracks[new].tolist(), ids.tolist(), strict=True)
            founders += rows[new].tolist()
            found[new] = ids
        used.append((rows[found >= 0], found[found >= 0]))
        poses.append(maps.poses)
        ancestors.append(ancestor)
        effective.append(number)
        drawn.append(info_drawn)
        observed.append(int(known.sum()))
    return Drive(
        options,
        seen,
        dead_reckoning(seen.poses[0], report),
        np.array(poses),
        np.array(ancestors),
        np.array(effective),
        np.array(drawn),
        maps,
        *(np.concatenate(column) for column in zip(*used, strict=True)),
        seen.places[founders],
        seen.carriers[founders],
        seen.frames[founders],
        matched,
        wrong,
        twice,
        np.array(observed),
    )

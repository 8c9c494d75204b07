r"""SLAM with points that are followed from frame to frame and told apart by how they look.

A step takes what the robot knows, how it moved and the tracked points of one frame, and returns
what it knows then, with an account of the step:

``step(state, motion, observations, descriptors, mount, *, costs, options, rng) -> (state, info)``

A track that has been followed for long enough is looked up among the landmarks, once: by the mean
of its descriptors and by its place. If it is none of them, a landmark is made of it. From then on
it gives observations of its landmark for as long as it lasts. All particles share these names.

What it costs to take a track for a landmark is the caller's to say, ``costs(newcomers)``: a
distance of descriptors, or what an oracle knows. The gate in space and the choice are made here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.observations import Observations
from robot_perception.particles import StepInfo, effective_number
from robot_perception.slam.planar.motions import Motion
from robot_perception.slam.rao_blackwellised import (
    ParticleMaps,
    add_landmarks,
    associate_shared,
    predict,
    printed_number,
    resample,
    update,
)
from robot_perception.slam.rao_blackwellised.filtering import checked_seen

CRITERIA = {"effective": effective_number, "printed": printed_number}


@dataclass(frozen=True, slots=True)
class Options:
    """How the filter runs; the values are those of Gil et al., sections 3 and 5, where it has any.

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
        Largest cost of taking a track for a landmark. Ours: the distance of mean descriptors whose
        length is 512.
    level
        Probability that a right match passes the gate in space; ours.
    reach
        Standard deviation that the gate adds to what the particles say of a coordinate, m; ours.
        Particles that descend from one know nothing of the error that they share.
    noise
        What the standard deviation of the points is multiplied by in the filter; ours.

    Raises
    ------
    ValueError
        If a number is out of its range or there is no such criterion.
    """

    particles: int = 10
    stable: int = 5
    share: float = 0.5
    criterion: Literal["effective", "printed"] = "effective"
    limit: float = 150.0
    level: float = 0.999
    reach: float = 0.3
    noise: float = 1.0

    def __post_init__(self) -> None:
        checks.whole("particles", self.particles, 1)
        checks.whole("stable", self.stable, 0)
        checks.share("share", self.share)
        checks.one_of("criterion", self.criterion, CRITERIA)
        if checks.number("limit", self.limit, finite=False) < 0:
            raise ValueError(f"limit must not be negative, got {self.limit}")
        checks.level("level", self.level)
        checks.not_negative("reach", self.reach)
        checks.positive("noise", self.noise)


@dataclass(frozen=True, eq=False, slots=True)
class Ongoing:
    """The tracks that the latest frame showed. A track ends with the first frame that misses it.

    Parameters
    ----------
    ids : (k,)
        Their numbers.
    lengths : (k,)
        In how many frames each was seen.
    sums : (k, d)
        What its descriptors add up to.
    names : (k,)
        Landmark that it was taken for, or that was made of it; -1 as long as it is not stable.
    """

    ids: Int[np.ndarray, "k"]
    lengths: Int[np.ndarray, "k"]
    sums: Float[np.ndarray, "k d"]
    names: Int[np.ndarray, "k"]

    @property
    def means(self) -> Float[np.ndarray, "k d"]:
        """Mean descriptor of each track so far."""
        return self.sums / self.lengths[:, None]


@dataclass(frozen=True, eq=False, slots=True)
class VisualMaps:
    """What the filter knows: particles with maps, how the landmarks look, and tracks that go on.

    Parameters
    ----------
    maps
        Poses and landmarks. Landmarks are named 0, 1, 2 … as they are made.
    descriptors : (N, d)
        How each landmark looked when it was made: the mean descriptor of its track.
    tracks
        The tracks of the latest frame.
    """

    maps: ParticleMaps
    descriptors: Float[np.ndarray, "N d"]
    tracks: Ongoing

    @classmethod
    def start(
        cls, pose: Float[np.ndarray, "3"], options: Options = Options(), *, length: int = 128
    ) -> "VisualMaps":
        """Return empty maps with all particles at one pose.

        Parameters
        ----------
        pose : (3,)
            m, m, rad.
        options
            How many particles.
        length
            Numbers of a descriptor; that of SIFT has 128. Where names are known without, 0.

        Raises
        ------
        ValueError
            If the pose is not (3,), not finite, or the length negative.
        """
        checks.instance("options", options, Options)
        none = np.empty(0, dtype=int)
        looks = np.empty((0, checks.whole("length", length, 0)))
        maps = ParticleMaps.start(pose, options.particles)
        return cls(maps, looks, Ongoing(none, none, looks, none))


@dataclass(frozen=True, eq=False, slots=True)
class Newcomers:
    """Tracks that have just become stable, and the landmarks that they might be.

    Parameters
    ----------
    rows : (m,)
        Which observations of the frame they are.
    descriptors : (m, d)
        The mean descriptor of each.
    landmarks : (N, d)
        That of each landmark, in the order of the map.
    """

    rows: Int[np.ndarray, "m"]
    descriptors: Float[np.ndarray, "m d"]
    landmarks: Float[np.ndarray, "N d"]


Costs = Callable[[Newcomers], Float[np.ndarray, "m N"]]  # infinite where it cannot be


@dataclass(frozen=True, eq=False, slots=True)
class FrameInfo:
    """What a step made of the m observations of its frame.

    Parameters
    ----------
    names : (m,)
        Landmark that each was used for; -1 where its track is not stable yet, or it is out of the
        gate.
    first : (m,)
        Whether its track became stable in this frame and was looked up.
    new : (m,)
        Whether a landmark was made of it.
    resampling
        Effective number after weighing, whether particles were drawn anew, ancestors, evidence.
    """

    names: Int[np.ndarray, "m"]
    first: Bool[np.ndarray, "m"]
    new: Bool[np.ndarray, "m"]
    resampling: StepInfo

    @property
    def known(self) -> Bool[np.ndarray, "m"]:
        """Which observations were of landmarks of the map and went into the filter."""
        return (self.names >= 0) & ~self.new


def step(
    state: VisualMaps,
    motion: Motion | None,
    observations: Observations,
    descriptors: Float[np.ndarray, "m d"],
    mount: Float[np.ndarray, "4 4"],
    *,
    costs: Costs,
    options: Options = Options(),
    rng: np.random.Generator,
) -> tuple[VisualMaps, FrameInfo]:
    """Return what is known after a motion and a frame, and an account of it.

    The particles move. Stable tracks are observations of landmarks: one that was stable before
    keeps its landmark if it passes the gate, one that has just become so gets the cheapest possible
    one, each landmark once. The particles are weighed by them and drawn anew if need be. What is
    left of the tracks that have just become stable are new landmarks.

    Parameters
    ----------
    state
        What was known before.
    motion
        Odometry since the frame before; ``None`` if there was none, as at the first frame.
    observations
        Points in the frame of the camera, m, with covariances, m². Their names are the numbers of
        their tracks.
    descriptors : (m, d)
        Of each point.
    mount : (4, 4)
        T_robot_camera.
    costs
        Returns (m', N) costs, not negative, of taking m' newcomers for each of N landmarks. It is
        asked when there are both.
    options
        How the filter runs; the same for all frames.
    rng
        Source of randomness.

    Returns
    -------
    state : VisualMaps
    info : FrameInfo

    Raises
    ------
    ValueError
        If a point has no covariance or no track, the descriptors are not (m, d) of the length of
        the state's, the options have another number of particles, the costs are not (m', N), NaN or
        negative, or where :mod:`~robot_perception.slam.rao_blackwellised` raises.

    References
    ----------
    Gil, Payá, Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor
    environments using SIFT features", VIIP 2006, sections 3 and 5.
    """
    looks = _checked(state, observations, descriptors, mount, costs, options)
    checks.generator("rng", rng)
    maps = state.maps if motion is None else predict(state.maps, motion, rng=rng)
    tracks = _followed(state.tracks, observations.ids, looks)
    first = tracks.lengths == options.stable + 1
    covs = options.noise**2 * observations.covs
    seen = Observations(np.full(len(looks), -1), observations.values, covs)
    names = _recognised(maps, state.descriptors, tracks, seen, mount, costs, options)
    known = names >= 0
    maps, resampling = _weighed(maps, seen.named(names)[known], mount, options, rng)
    new = first & ~known
    landmarks = state.descriptors
    if new.any():
        names[new] = len(landmarks) + np.arange(np.count_nonzero(new))
        maps = add_landmarks(maps, seen.named(names)[new], mount)
        landmarks = np.concatenate([landmarks, tracks.means[new]])
    tracks = replace(tracks, names=np.where(first, names, tracks.names))
    return VisualMaps(maps, landmarks, tracks), FrameInfo(names, first, new, resampling)


def _checked(
    state: VisualMaps,
    observations: Observations,
    descriptors: np.ndarray,
    mount: np.ndarray,
    costs: Costs,
    options: Options,
) -> np.ndarray:
    """Check what a step is given; return the descriptors as numbers."""
    length = checks.instance("state", state, VisualMaps).descriptors.shape[1]
    count = len(checked_seen(observations, mount))
    if (observations.ids < 0).any():
        raise ValueError("observations must have the numbers of their tracks, got -1")
    if not callable(costs):
        raise TypeError(f"costs must be a function, got {checks.shown(costs)}")
    particles = checks.instance("options", options, Options).particles
    if particles != len(state.maps):
        raise ValueError(
            f"options must be for the {len(state.maps)} particles of the state, got {particles}"
        )
    beside = f"{count} observations, and a state of {length} numbers each"
    return checks.array("descriptors", descriptors, (count, length), beside)


def _followed(before: Ongoing, ids: np.ndarray, descriptors: np.ndarray) -> Ongoing:
    """Return the tracks of a frame: those of the frame before that go on, and those that begin."""
    _, old, on = np.intersect1d(before.ids, ids, assume_unique=True, return_indices=True)
    lengths, sums = np.ones(len(ids), dtype=int), descriptors.copy()
    names = np.full(len(ids), -1)
    lengths[on] += before.lengths[old]
    sums[on] += before.sums[old]
    names[on] = before.names[old]
    return Ongoing(ids, lengths, sums, names)


def _recognised(
    maps: ParticleMaps,
    landmarks: np.ndarray,
    tracks: Ongoing,
    seen: Observations,
    mount: np.ndarray,
    costs: Costs,
    options: Options,
) -> np.ndarray:
    """Return which landmark each observation is of, or -1.

    A track that has a landmark costs nothing there and cannot be another one.
    """
    names = np.full(len(seen), -1)
    rows = np.flatnonzero(tracks.lengths > options.stable)
    first = tracks.lengths[rows] == options.stable + 1
    if not (rows.size and len(landmarks)):
        return names
    table = np.full((rows.size, len(landmarks)), np.inf)
    if first.any():
        asked = Newcomers(rows[first], tracks.means[rows[first]], landmarks)
        size = len(asked.rows), len(landmarks)
        beside = f"{size[0]} newcomers and {size[1]} landmarks"
        table[first] = checks.array("costs(newcomers)", costs(asked), size, beside, finite=False)
    has = np.flatnonzero(tracks.names[rows] >= 0)
    table[has, tracks.names[rows[has]]] = 0.0
    wide = seen.covs[rows] + options.reach**2 * np.eye(3)
    names[rows] = associate_shared(
        maps,
        Observations(names[rows], seen.values[rows], wide),
        mount,
        costs=table,
        limit=options.limit,
        level=options.level,
    )
    return names


def _weighed(
    maps: ParticleMaps,
    seen: Observations,
    mount: np.ndarray,
    options: Options,
    rng: np.random.Generator,
) -> tuple[ParticleMaps, StepInfo]:
    """Return the maps after observations of landmarks that they have, drawn anew if need be."""
    if not len(seen):
        effective = float(effective_number(maps.particles.log_weights))
        return maps, StepInfo(effective, False, np.arange(len(maps)), 0.0)
    maps, weighing = update(maps, seen, mount)
    effective = float(effective_number(maps.particles.log_weights))
    criterion = CRITERIA[options.criterion]
    maps, drawn = resample(maps, rng=rng, share=options.share, criterion=criterion)
    return maps, StepInfo(effective, drawn.resampled, drawn.ancestors, weighing.log_evidence)

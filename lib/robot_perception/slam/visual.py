r"""SLAM with points that are followed from frame to frame and told apart by how they look.

A step takes what the robot knows, how it moved and the tracked points of one frame, and returns
what it knows then, with an account of the step:

``VisualSlam(mount, options).step(state, motion, observations, descriptors, *, costs, rng)``

A track that has been followed for long enough is looked up among the landmarks, once: by the mean
of its descriptors and by its place. If it is none of them, a landmark is made of it. From then on
it gives observations of its landmark for as long as it lasts.

All particles share these names, or each names by its own map (``Options.association``): what one
takes for a landmark may be new to another, which alone puts it into its map.

What it costs to take a track for a landmark is the caller's to say, ``costs(newcomers)``: a
distance of descriptors, as those of :mod:`robot_perception.landmarks.metrics`, or what an oracle
knows. The gate in space and the choice are made here. How a landmark looks is what the frames of
its track showed until it was made, and does not change when it is seen again: so the paper's p
descriptors are "stored" once, when it "has been tracked for p frames" (section 4).
"""

from collections.abc import Callable
from dataclasses import Field, dataclass, fields, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.fields import checked
from robot_perception.observations import Observations
from robot_perception.particles import StepInfo, effective_number
from robot_perception.slam.planar.motions import PlanarMotion
from robot_perception.slam.rao_blackwellised import (
    ParticleMaps,
    add_landmarks,
    associate_each,
    associate_shared,
    predict,
    printed_number,
    resample,
    update,
)
from robot_perception.slam.rao_blackwellised.filtering import checked_mount, checked_seen

CRITERIA = {"effective": effective_number, "printed": printed_number}


@dataclass(frozen=True, slots=True)
class Options:
    """Options of the filter; the values are those of Gil et al., sections 3 and 5, as far as given.

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
        Largest cost of taking a track for a landmark, which depends on how costs are counted; the
        paper does not tell its own. Ours: the distance of mean descriptors whose length is 512.
    level
        Probability that a right match passes the gate in space; ours.
    reach
        Standard deviation that the gate adds to what the particles say of a coordinate, m; ours.
        Particles that descend from one know nothing of the error that they share.
    noise
        What the standard deviation of the points is multiplied by in the filter; ours.
    association
        Whether all particles share the names of what is seen, ``"shared"``, or each finds them in
        its own map, ``"each"``; paper, sections 3 and 4: each.
    unmatched
        Density of a point for a particle to which it is none of its landmarks, where it is one to
        another particle, m⁻³; ours.
    patience
        How many frames in a row may miss a track before it ends; paper: none.

    Raises
    ------
    ValueError
        If a number is out of its range or there is no such criterion or association.
    """

    particles: int = 10
    stable: int = 5
    share: float = 0.5
    criterion: Literal["effective", "printed"] = "effective"
    limit: float = 150.0
    level: float = 0.999
    reach: float = 0.3
    noise: float = 1.0
    association: Literal["shared", "each"] = "shared"
    unmatched: float = 1.0
    patience: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "particles", checks.whole("particles", self.particles, 1))
        object.__setattr__(self, "stable", checks.whole("stable", self.stable, 0))
        object.__setattr__(self, "share", checks.share("share", self.share))
        checks.one_of("criterion", self.criterion, CRITERIA)
        if checks.number("limit", self.limit, finite=False) < 0:
            raise ValueError(f"limit must not be negative, got {self.limit}")
        object.__setattr__(self, "level", checks.level("level", self.level))
        object.__setattr__(self, "reach", checks.not_negative("reach", self.reach))
        object.__setattr__(self, "noise", checks.positive("noise", self.noise))
        checks.one_of("association", self.association, ("shared", "each"))
        object.__setattr__(self, "unmatched", checks.positive("unmatched", self.unmatched))
        object.__setattr__(self, "patience", checks.whole("patience", self.patience, 0))


@dataclass(frozen=True, eq=False, slots=True)
class Looks:
    r"""Statistics of the descriptors of n tracks, or of the landmarks that were made of them.

    .. math:: \bar d_i = \frac 1 p \sum_k d_k, \qquad q_i = \sum_k (d_k - \bar d_i)^2

    Parameters
    ----------
    firsts : (n, d)
        The first descriptor of each.
    means : (n, d)
        Means :math:`\bar d_i`.
    squares : (n, d)
        Sums :math:`q_i` of squared deviations from the mean, entry by entry.
    counts : (n,)
        Numbers p of descriptors.
    """

    firsts: Float[np.ndarray, "n d"]
    means: Float[np.ndarray, "n d"]
    squares: Float[np.ndarray, "n d"]
    counts: Int[np.ndarray, "n"]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.counts)


@dataclass(frozen=True, eq=False, slots=True)
class Ongoing:
    """The tracks that go on: those of the latest frame, and those that it missed but may return.

    Parameters
    ----------
    ids : (k,)
        Their numbers.
    lengths : (k,)
        In how many frames each was seen.
    firsts : (k, d)
        Its first descriptor.
    sums : (k, d)
        What its descriptors add up to.
    squares : (k, d)
        What their squared deviations from their mean add up to.
    names : (k,) or (M, k)
        Landmark that it was taken for, or that was made of it; -1 as long as it is not stable. A
        row for each particle where each names by its own map.
    missed : (k,)
        How many frames in a row have missed it since.
    """

    ids: Int[np.ndarray, "k"]
    lengths: Int[np.ndarray, "k"]
    firsts: Float[np.ndarray, "k d"]
    sums: Float[np.ndarray, "k d"]
    squares: Float[np.ndarray, "k d"]
    names: Int[np.ndarray, "*M k"]
    missed: Int[np.ndarray, "k"]
    __post_init__ = checked

    @property
    def means(self) -> Float[np.ndarray, "k d"]:
        """Mean descriptor of each track so far."""
        return self.sums / self.lengths[:, None]

    @property
    def looks(self) -> Looks:
        """Descriptors of each track so far."""
        return Looks(self.firsts, self.means, self.squares, self.lengths)


@dataclass(frozen=True, eq=False, slots=True)
class VisualMaps:
    """State of the filter: particles with maps, the landmarks' descriptors, and tracks that go on.

    Parameters
    ----------
    maps
        Poses and landmarks. Landmarks are named 0, 1, 2 … as they are made. Where each particle
        names by its own map, some have one and others not, and what nobody has any more keeps its
        name and place.
    looks
        How each of N landmarks looked when it was made: the descriptors of its track.
    tracks
        The tracks that go on.
    """

    maps: ParticleMaps
    looks: Looks
    tracks: Ongoing
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Newcomers:
    """Tracks that have just become stable, and the landmarks that they might be.

    Parameters
    ----------
    rows : (m,)
        Which observations of the frame they are.
    descriptors : (m, d)
        The mean descriptor of each.
    looks
        How each of N landmarks looked when it was made, in the order of the map.
    """

    rows: Int[np.ndarray, "m"]
    descriptors: Float[np.ndarray, "m d"]
    looks: Looks


Costs = Callable[[Newcomers], Float[np.ndarray, "m N"]]  # infinite where it cannot be


@dataclass(frozen=True, eq=False, slots=True)
class FrameInfo:
    """Diagnostics of one step with the m observations of its frame.

    Where each particle names by its own map, names have a row for each of the particles that the
    step returns.

    Parameters
    ----------
    names : (m,) or (M, m)
        Landmark that each was used for; -1 where its track is not stable yet, or it is out of the
        gate.
    first : (m,)
        Whether its track became stable in this frame and was looked up.
    new : (m,) or (M, m)
        Whether a landmark was made of it.
    resampling
        Effective number after weighing, whether particles were drawn anew, ancestors, evidence.
    """

    names: Int[np.ndarray, "*M m"]
    first: Bool[np.ndarray, "m"]
    new: Bool[np.ndarray, "*M m"]
    resampling: StepInfo

    @property
    def known(self) -> Bool[np.ndarray, "*M m"]:
        """Mask of the observations of landmarks of the map, which went into the filter."""
        return (self.names >= 0) & ~self.new

    @property
    def made(self) -> Bool[np.ndarray, "m"]:
        """Mask of the observations that became landmarks, in the map of some particle at least."""
        return _somewhere(self.new)


@dataclass(frozen=True, eq=False, slots=True)
class VisualSlam:
    """Finds where a robot is, and the landmarks that its camera sees, frame by frame.

    Parameters
    ----------
    mount : (4, 4)
        T_robot_camera.
    options
        How the filter runs.

    Raises
    ------
    ValueError
        If the mount is no rigid motion.

    References
    ----------
    Gil, Payá, Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor
    environments using SIFT features", VIIP 2006, sections 3 and 5.
    """

    mount: Float[np.ndarray, "4 4"]
    options: Options = Options()

    def __post_init__(self) -> None:
        object.__setattr__(self, "mount", checked_mount(self.mount))
        checks.instance("options", self.options, Options)

    def start(self, pose: Float[np.ndarray, "3"], *, length: int = 128) -> VisualMaps:
        """Return empty maps with all particles at one pose.

        Parameters
        ----------
        pose : (3,)
            m, m, rad.
        length
            Numbers of a descriptor; that of SIFT has 128. Where names are known without, 0.

        Raises
        ------
        ValueError
            If the pose is not (3,), not finite, or the length negative.
        """
        options = self.options
        none = np.empty(0, dtype=int)
        empty = np.empty((0, checks.whole("length", length, 0)))
        maps = ParticleMaps.start(pose, options.particles)
        names = none if options.association == "shared" else np.empty((len(maps), 0), dtype=int)
        tracks = Ongoing(none, none, empty, empty, empty, names, none)
        return VisualMaps(maps, Looks(empty, empty, empty, none), tracks)

    def step(
        self,
        state: VisualMaps,
        motion: PlanarMotion | None,
        observations: Observations,
        descriptors: Float[np.ndarray, "m d"],
        *,
        costs: Costs,
        rng: np.random.Generator,
    ) -> tuple[VisualMaps, FrameInfo]:
        """Return what is known after a motion and a frame, and an account of it.

        The particles move. Stable tracks are observations of landmarks: one that was stable before
        keeps its landmark if it passes the gate, one that has just become so gets the cheapest
        possible one, each landmark once. The particles are weighed by them and drawn anew if need
        be. What is left of the tracks that have just become stable are new landmarks.

        Where each particle names by its own map, all this is so for each, and its names descend
        with it. An observation that some particle has a landmark for weighs with the others by the
        density ``options.unmatched``. A new landmark is one to all particles that did not recognise
        it.

        Parameters
        ----------
        state
            What was known before.
        motion
            Odometry since the frame before; ``None`` if there was none, as at the first frame.
        observations
            Points in the frame of the camera, m, with covariances, m². Their names are the numbers
            of their tracks.
        descriptors : (m, d)
            Of each point.
        costs
            Returns (m', N) costs, not negative, of taking m' newcomers for each of N landmarks: a
            metric of :mod:`robot_perception.landmarks.metrics`, or a function of the caller's own.
            It is asked when there are both.
        rng
            Source of randomness.

        Returns
        -------
        state : VisualMaps
        info : FrameInfo

        Raises
        ------
        ValueError
            If a point has no covariance or no track, the descriptors are not (m, d) of the length
            of the state's, the state has other particles or another association than the options,
            the costs are not (m', N), NaN or negative, or where
            :mod:`~robot_perception.slam.rao_blackwellised` raises.
        """
        mount, options = self.mount, self.options
        found = _checked(state, observations, descriptors, mount, costs, options)
        checks.generator("rng", rng)
        maps = state.maps if motion is None else predict(state.maps, motion, rng=rng)
        tracks = _followed(state.tracks, observations.ids, found)
        first = tracks.lengths == options.stable + 1
        covs = options.noise**2 * observations.covs
        seen = Observations(np.full(len(found), -1), observations.values, covs)
        names = _recognised(maps, state.looks, tracks, seen, mount, costs, options)
        maps, resampling = _weighed(maps, seen, names, mount, options, rng)
        waiting = _waited_for(state.tracks, observations.ids, options.patience)
        names, held, kept = (
            _inherited(own, resampling.ancestors) for own in (names, tracks.names, waiting.names)
        )
        new, looks = first & (names < 0), state.looks
        made = _somewhere(new)
        fresh = len(looks) + np.cumsum(made) - 1
        names = np.where(new, fresh, names)
        if made.any():
            where = None if new.ndim == 1 else new[:, made]
            maps = add_landmarks(maps, seen[made].named(fresh[made]), mount, where)
            looks = _joined(looks, tracks.looks, made)
        tracks = replace(tracks, names=np.where(first, names, held))
        tracks = _appended(tracks, replace(waiting, names=kept))
        return VisualMaps(maps, looks, tracks), FrameInfo(names, first, new, resampling)


def _checked(
    state: VisualMaps,
    observations: Observations,
    descriptors: np.ndarray,
    mount: np.ndarray,
    costs: Costs,
    options: Options,
) -> np.ndarray:
    """Check what a step is given; return the descriptors as numbers."""
    length = checks.instance("state", state, VisualMaps).looks.means.shape[1]
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
    if (options.association == "shared") != (state.tracks.names.ndim == 1):
        raise ValueError(
            f"options must have the association of the state, got {options.association!r}"
        )
    beside = f"{count} observations, and a state of {length} numbers each"
    return checks.array("descriptors", descriptors, (count, length), beside)


def _followed(before: Ongoing, ids: np.ndarray, descriptors: np.ndarray) -> Ongoing:
    """Return the tracks of a frame: those of the frame before that go on, and those that begin."""
    _, old, on = np.intersect1d(before.ids, ids, assume_unique=True, return_indices=True)
    lengths, firsts, sums = np.ones(len(ids), dtype=int), descriptors.copy(), descriptors.copy()
    squares = np.zeros_like(sums)
    names = np.full((*before.names.shape[:-1], len(ids)), -1)
    count, apart = before.lengths[old, None], descriptors[on] - before.means[old]
    lengths[on] += before.lengths[old]
    firsts[on] = before.firsts[old]
    sums[on] += before.sums[old]
    squares[on] = before.squares[old] + count / (count + 1) * apart**2
    names[..., on] = before.names[..., old]
    return Ongoing(ids, lengths, firsts, sums, squares, names, np.zeros(len(ids), dtype=int))


def _waited_for(before: Ongoing, ids: np.ndarray, patience: int) -> Ongoing:
    """Return the tracks of the frame before that a frame misses, and that do not end with that."""
    rows = np.flatnonzero(~np.isin(before.ids, ids) & (before.missed < patience))
    kept = {
        field.name: getattr(before, field.name).take(rows, _axis(field))
        for field in fields(Ongoing)
    }
    return Ongoing(**kept | {"missed": kept["missed"] + 1})


def _appended(tracks: Ongoing, others: Ongoing) -> Ongoing:
    """Return some tracks and after them others."""
    both = [
        ([getattr(part, field.name) for part in (tracks, others)], _axis(field))
        for field in fields(Ongoing)
    ]
    return Ongoing(*(np.concatenate(*one) for one in both))


def _axis(field: Field) -> int:
    """Return which axis of a field counts the tracks."""
    return -1 if field.name == "names" else 0


def _recognised(
    maps: ParticleMaps,
    landmarks: Looks,
    tracks: Ongoing,
    seen: Observations,
    mount: np.ndarray,
    costs: Costs,
    options: Options,
) -> np.ndarray:
    """Return which landmark each observation is of, or -1, as the tracks have their names.

    A track that has a landmark costs nothing there and cannot be another one.
    """
    names = np.full(tracks.names.shape, -1)
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
    held = tracks.names[..., rows]
    has = np.nonzero(held >= 0)
    table[has[-1], held[has]] = 0.0
    wide = seen.covs[rows] + options.reach**2 * np.eye(3)
    look = Observations(np.full(rows.size, -1), seen.values[rows], wide)
    found: dict = {"costs": table, "limit": options.limit, "level": options.level}
    if options.association == "shared":
        names[rows] = associate_shared(maps, look, mount, **found)
    else:
        names[:, rows] = associate_each(maps, look, mount, held, **found)
    return names


def _weighed(
    maps: ParticleMaps,
    seen: Observations,
    names: np.ndarray,
    mount: np.ndarray,
    options: Options,
    rng: np.random.Generator,
) -> tuple[ParticleMaps, StepInfo]:
    """Return the maps after observations of landmarks that they have, drawn anew if need be."""
    used = _somewhere(names >= 0)
    if not used.any():
        effective = float(effective_number(maps.particles.log_weights))
        return maps, StepInfo(effective, False, np.arange(len(maps)), 0.0)
    if options.association == "shared":
        maps, weighing = update(maps, seen.named(names)[used], mount)
    else:
        own, density = names[:, used], options.unmatched
        maps, weighing = update(maps, seen[used], mount, own, unmatched_density=density)
    effective = float(effective_number(maps.particles.log_weights))
    criterion = CRITERIA[options.criterion]
    maps, drawn = resample(maps, rng=rng, share=options.share, criterion=criterion)
    return maps, StepInfo(effective, drawn.resampled, drawn.ancestors, weighing.log_evidence)


def _inherited(names: np.ndarray, ancestors: np.ndarray) -> np.ndarray:
    """Return the names of particles drawn anew: shared ones, or those of their ancestors."""
    return names if names.ndim == 1 else names[ancestors]


def _somewhere(mask: np.ndarray) -> np.ndarray:
    """Return which observations something is true of, for some particle at least."""
    return np.atleast_2d(mask).any(axis=0)


def _joined(looks: Looks, others: Looks, rows: np.ndarray) -> Looks:
    """Return how some look, and after them some of the others."""
    names = [field.name for field in fields(Looks)]
    columns = ((getattr(looks, name), getattr(others, name)[rows]) for name in names)
    return Looks(*map(np.concatenate, columns))

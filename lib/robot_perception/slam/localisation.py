r"""Monte Carlo localisation in a finished map, by the landmarks that the robot sees.

The map is what :mod:`.visual` leaves: landmarks in space with covariances, and how they look. The
belief is a set of poses. A step moves them, takes each point that the two eyes see for the landmark
that looks most like it, weighs the poses by how well the points lie, and draws them anew:

``MapLocaliser(map, mount).step(state, motion, observations, descriptors, *, costs, rng)``

Gil, Payá, Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor
environments using SIFT features", VIIP 2006, say that such a map "has been used to effectively
localize a robot", and do not say how. Weights and drawing are those of their filter, eqs (4) to
(7), with a map that stays. What they have no need of there is ours, and off or small where it can
be: where the particles begin, that a match may be wrong, ``reach``, ``candidates``, ``roughness``,
``fresh``, and what is told of the particles.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, no_type_check

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.beliefs import Gaussian, ParticleSet, normalise
from robot_perception.fields import Level, NotNegative, Positive, checked, from_to
from robot_perception.geometry import act, wrap_angle
from robot_perception.kernels import kernel
from robot_perception.observations import Observations
from robot_perception.particles import MOST_DRAWS, effective_number, systematic
from robot_perception.slam.planar.motions import Odometry, PlanarMotion, Velocity
from robot_perception.slam.rao_blackwellised import kernels
from robot_perception.slam.rao_blackwellised.belief import UPPER
from robot_perception.slam.rao_blackwellised.filtering import checked_mount, checked_seen
from robot_perception.slam.visual import Costs, Looks, Newcomers, VisualMaps

CELLS = 1.0, np.pi / 6  # in which the heaviest place is looked for, m and rad
MOST_CLUSTERS = 10
APART = 0.5  # of two points that tell a heading, at least, m
TRIES = 8  # pairs of matches that are tried for each pose
TURN = 2 * np.pi


Share = Annotated[float, checks.share]
SOURCES = "matches", "area"


def _source(name: str, value: str) -> str:
    return checks.one_of(name, value, SOURCES)


Source = Annotated[Literal["matches", "area"], _source]


@dataclass(frozen=True, eq=False, slots=True)
class LandmarkMap:
    r"""A finished map: landmarks :math:`\theta_k = \{\mu_k, \Sigma_k, d_k\}`.

    Parameters
    ----------
    means : (n, 3)
        Places :math:`\mu_k` in the world, m.
    covs : (n, 3, 3)
        Their covariances :math:`\Sigma_k`, m².
    looks
        How each of them looked: the descriptors :math:`d_k` of its track.

    Raises
    ------
    ValueError
        If there is no landmark, the shapes disagree, a number is not finite, a covariance is none,
        or there are not as many looks as landmarks.

    References
    ----------
    Gil et al. (2006), section 3.
    """

    means: Float[np.ndarray, "n 3"]
    covs: Float[np.ndarray, "n 3 3"]
    looks: Looks

    def __post_init__(self) -> None:
        checked(self)
        checks.check_covariance("covs", self.covs)
        if not len(self.means):
            raise ValueError("means must hold at least one landmark, got none")
        if len(self.looks) != len(self.means):
            raise ValueError(
                f"looks must be of the {len(self.means)} landmarks, got {len(self.looks)}"
            )

    @classmethod
    def of(cls, state: VisualMaps) -> "LandmarkMap":
        """Return the map of the particle with the largest weight.

        Parameters
        ----------
        state
            What :class:`~robot_perception.slam.visual.VisualSlam` knew at the end of a drive.

        Raises
        ------
        ValueError
            If it knew no landmark.
        """
        maps = checks.instance("state", state, VisualMaps).maps
        names, places = maps.landmarks(maps.best)
        looks = state.looks
        columns = (looks.firsts, looks.means, looks.squares, looks.counts)
        return cls(places.mean, places.cov, Looks(*(column[names] for column in columns)))

    def __len__(self) -> int:
        return len(self.means)

    @property
    def extent(self) -> Float[np.ndarray, "2 2"]:
        """Lower and upper corner of the plan of all landmarks but the outermost hundredths, m."""
        return np.quantile(self.means[:, :2], [0.01, 0.99], axis=0)


@dataclass(frozen=True, slots=True)
class LocaliserRules:
    r"""Rules of the localisation; the paper has none of these values but ``share``.

    Parameters
    ----------
    particles
        M.
    limit
        Largest cost of taking a point for a landmark, which depends on how costs are counted. Ours:
        the distance of descriptors whose length is 512.
    candidates
        For how many landmarks a point may be taken, those that cost least; paper, section 4: one.
    wrong
        Probability ε that a match is wrong; 0 in eq. (4).
    unmatched
        Density u of a point that is none of its candidates, m⁻³.
    reach
        Standard deviation that is added to that of each coordinate, m; 0 in eq. (4). Particles lie
        some way apart, and the errors of landmarks of a map that is finished are not independent.
    share
        Particles are drawn anew below this share of M; paper: 1/2.
    roughness
        Standard deviations by which particles that were drawn anew are moved, m, m, rad.
    fresh
        Share of the particles that are replaced after each picture by new ones.
    source
        Where these come from: poses that pairs of ``"matches"`` imply, or the whole ``"area"``.
    near
        What belongs to a cluster lies within so much of its mean, m and rad.
    within
        A match agrees with a pose from which its point lies within that of its landmark, m.
    sure
        The robot is located where the heaviest cluster has that share of the weight and ``agree``
        of the picture's matches agree with its mean.
    agree
        That share.

    Raises
    ------
    ValueError
        If a number is out of its range or there is no such source.
    """

    particles: Annotated[int, from_to(1, MOST_DRAWS)] = 5000
    limit: NotNegative = 200.0
    candidates: Annotated[int, from_to(1)] = 1
    wrong: Share = 0.3
    unmatched: Positive = 0.01
    reach: NotNegative = 0.3
    share: Share = 0.5
    roughness: tuple[NotNegative, NotNegative, NotNegative] = (0.05, 0.05, 0.02)
    fresh: Share = 0.0
    source: Source = "matches"
    near: tuple[Positive, Positive] = (1.0, 0.5)
    within: Positive = 0.5
    sure: Level = 0.9
    agree: Share = 0.2
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Cluster:
    """Particles that lie together.

    Parameters
    ----------
    share
        Their part of the weight.
    pose : (3,)
        Their mean: m, m, rad.
    cov : (3, 3)
        Their covariance about it: m², m rad, rad².
    """

    share: Share
    pose: Float[np.ndarray, "3"]
    cov: Float[np.ndarray, "3 3"]
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Whereabouts:
    """State of the localisation.

    Parameters
    ----------
    particles
        M poses (m, m, rad) with weights.
    clusters
        Where they lie together, the heaviest first, ten at most; at least one.
    located
        Whether the heaviest has the weight, and the agreement of the latest picture, that the rules
        ask for. It tells how sure the filter is, and may be wrong.
    """

    particles: ParticleSet
    clusters: tuple[Cluster, ...]
    located: bool

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("particles", self.particles.states, ("M", 3))
        if not self.clusters:
            raise ValueError("clusters must hold at least one, got none")

    @property
    def pose(self) -> Float[np.ndarray, "3"]:
        """Mean of the heaviest cluster: m, m, rad."""
        return self.clusters[0].pose


@dataclass(frozen=True, eq=False, slots=True)
class LocaliserInfo:
    """Diagnostics of one step with the m points of its picture.

    Parameters
    ----------
    names : (m, k)
        Which landmarks each might be, that of the least cost first; -1 where there is none.
    effective
        Effective number of particles once they were weighed.
    resampled
        Whether they were drawn anew.
    ancestors : (M,)
        From which particle before each comes; -1 for a fresh one.
    log_evidence
        Logarithm of the density of the picture's points, given all before.
    agreeing
        How many of the matches agree with the mean of the heaviest cluster.
    """

    names: Int[np.ndarray, "m k"]
    effective: float
    resampled: bool
    ancestors: Int[np.ndarray, "M"]
    log_evidence: float
    agreeing: Annotated[int, from_to(0)]
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Fix:
    """A pose that one picture implies.

    Parameters
    ----------
    pose : (3,)
        m, m, rad.
    support
        How many of the picture's points lie where it expects them.
    """

    pose: Float[np.ndarray, "3"]
    support: int
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class MapLocaliser:
    r"""Finds where a robot is in a finished map, from anywhere, picture by picture.

    A particle is a pose :math:`s^{[m]}`. It moves by a draw of what the wheels report. A point
    :math:`v_i` of the picture is taken for the landmark :math:`c_i` that looks most like it, and
    the weight is, with the innovation and its covariance in the frame of the robot,

    .. math::
        \omega^{[m]} \propto \prod_i \left[ (1 - \varepsilon) \,
        \mathcal N(v_i; \hat v_{c_i}^{[m]}, Z_{c_i} + r^2 I) + \varepsilon u \right].

    For ε = 0 and r = 0 these are eqs (4) to (6). Of several candidates the mean density counts.

    Parameters
    ----------
    map
        Where it may be.
    mount : (4, 4)
        T_robot_camera.
    rules
        How it is found.
    area : (2, 2), optional
        Lower and upper corner of the rectangle that it may be in, m; the extent of the map, if left
        out.

    Raises
    ------
    ValueError
        If the mount is no rigid motion or the area is empty.

    References
    ----------
    Gil et al. (2006), sections 3 and 4. Dellaert, Fox, Burgard and Thrun, "Monte Carlo localization
    for mobile robots", ICRA 1999: the particles of a global start.
    """

    map: LandmarkMap
    mount: Float[np.ndarray, "4 4"]
    rules: LocaliserRules = LocaliserRules()
    area: Float[np.ndarray, "2 2"] | None = None

    def __post_init__(self) -> None:
        checked(self)
        checked_mount(self.mount)
        if self.area is not None and not (self.area[0] < self.area[1]).all():
            raise ValueError(
                f"area must be a lower corner and an upper one, got {self.area.tolist()}"
            )

    def start(self, prior: Gaussian | None = None, *, rng: np.random.Generator) -> Whereabouts:
        """Return particles all over the area, or where the robot is believed to be.

        Parameters
        ----------
        prior
            Belief in its pose (m, m, rad); ``None`` if nothing is known.
        rng
            Source of randomness.

        Raises
        ------
        ValueError
            If the prior is not one belief in three numbers.
        """
        checks.generator("rng", rng)
        count = self.rules.particles
        if prior is None:
            poses = self._anywhere(count, rng)
        else:
            mean = checks.instance("prior", prior, Gaussian).mean
            if mean.shape != (3,) or prior.cov.shape != (3, 3):
                raise ValueError(f"prior must be of one pose (3,), got {mean.shape}")
            poses = mean + rng.standard_normal((count, 3)) @ kernels.root(prior.cov).T
        nothing = np.empty((0, kernels.ROW)), np.empty((0, 1), dtype=int)
        return self._told(poses, np.zeros(count), *nothing)[0]

    def step(
        self,
        state: Whereabouts,
        motion: PlanarMotion | None,
        observations: Observations,
        descriptors: Float[np.ndarray, "m d"],
        *,
        costs: Costs,
        rng: np.random.Generator,
    ) -> tuple[Whereabouts, LocaliserInfo]:
        """Return where the robot may be after a motion and a picture, and an account of it.

        Parameters
        ----------
        state
            Where it was.
        motion
            What the wheels report since the picture before; ``None`` if it stood.
        observations
            Points in the frame of the camera, m, with covariances, m². Names are not asked for.
        descriptors : (m, d)
            Of each point.
        costs
            Returns (m, N) costs of taking m points for N landmarks, not negative: a metric of
            :mod:`robot_perception.landmarks.metrics`, or a function of the caller's own.
        rng
            Source of randomness.

        Returns
        -------
        state : Whereabouts
        info : LocaliserInfo

        Raises
        ------
        ValueError
            If a point has no covariance, the descriptors are not (m, d) of the length of the map's,
            the costs are not (m, N), NaN or negative, or no particle can have seen the picture.
        """
        rules, seen = self.rules, checked_seen(observations, self.mount)
        names = self._named(seen, descriptors, costs)
        poses = checks.instance("state", state, Whereabouts).particles.states
        checks.generator("rng", rng)
        if motion is not None:
            checks.instance("motion", motion, Odometry, Velocity)
            draws = rng.standard_normal(poses.shape)
            poses = kernels.moved(poses, motion.increment, motion.increment_cov, draws)
        prior = state.particles.log_weights
        logs = prior + self._log_likelihoods(poses, seen, names)
        if not (logs > -np.inf).any():
            raise ValueError(
                "observations cannot come from any particle: with wrong = 0 all matches must be "
                "right"
            )
        logs, log_evidence = normalise(logs)
        count, effective = len(poses), float(effective_number(logs))
        ancestors, resampled = np.arange(count), effective < rules.share * count
        if resampled:
            ancestors = systematic(np.exp(logs), count, rng=rng)
            rough = rng.standard_normal(poses.shape) * np.array(rules.roughness)
            poses, logs = poses[ancestors] + rough, np.full(count, -np.log(count))
        poses, logs, ancestors = self._refreshed(poses, logs, ancestors, seen, names, rng)
        told, agreeing = self._told(poses, logs, seen, names)
        account = names, effective, resampled, ancestors, float(log_evidence), agreeing
        return told, LocaliserInfo(*account)

    def fix(
        self,
        observations: Observations,
        descriptors: Float[np.ndarray, "m d"],
        *,
        costs: Costs,
        rng: np.random.Generator,
        tries: int = 200,
    ) -> Fix | None:
        """Return the pose that one picture implies by itself, without wheels and particles.

        Poses that pairs of matches imply are weighed as particles are, and the best is fitted to
        the matches that agree with it.

        Parameters
        ----------
        observations, descriptors, costs, rng
            As in `step`.
        tries
            How many poses.

        Returns
        -------
        Fix or None
            ``None`` where no two matches lie as their landmarks do.

        Raises
        ------
        ValueError
            As `step`.

        References
        ----------
        Se, Lowe and Little, "Global localization using distinctive visual features", IROS 2002,
        has the idea, with points of one picture; fit and weights are ours.
        """
        seen = checked_seen(observations, self.mount)
        names = self._named(seen, descriptors, costs)
        checks.generator("rng", rng)
        tries = checks.whole("tries", tries, 1, MOST_DRAWS)
        poses = self._implied(seen, names, tries, rng)
        if not len(poses):
            return None
        pose = poses[np.argmax(self._log_likelihoods(poses, seen, names))]
        for _ in range(3):
            rows = self._agreeing(pose, seen, names)
            if rows.size < 2:
                break
            pose = _fitted(seen[rows, :2], self.map.means[names[rows, 0], :2])
        return Fix(pose, self._agreeing(pose, seen, names).size)

    def _named(self, seen: np.ndarray, descriptors: np.ndarray, costs: Costs) -> np.ndarray:
        """Return which landmarks each point may be (m, k), by least cost; -1 for none."""
        looks, count = self.map.looks, self.rules.candidates
        beside = f"{len(seen)} observations, and a map of {looks.means.shape[1]} numbers each"
        size = len(seen), looks.means.shape[1]
        found = checks.array("descriptors", descriptors, size, beside)
        if not callable(costs):
            raise TypeError(f"costs must be a function, got {checks.shown(costs)}")
        names = np.full((len(seen), count), -1)
        if not len(seen):
            return names
        size = len(seen), len(self.map)
        beside = f"{size[0]} points and {size[1]} landmarks"
        asked = Newcomers(np.arange(len(seen)), found, looks)
        table = checks.array("costs(newcomers)", costs(asked), size, beside, finite=False)
        if not (table >= 0).all():
            raise ValueError(f"costs must not be negative or NaN, got {np.min(table)}")
        least = min(count, size[1])
        first = np.argpartition(table, least - 1, axis=1)[:, :least]
        order = np.argsort(np.take_along_axis(table, first, axis=1), axis=1, kind="stable")
        first = np.take_along_axis(first, order, axis=1)
        cheap = np.take_along_axis(table, first, axis=1) <= self.rules.limit
        names[:, :least] = np.where(cheap, first, -1)
        return names

    def _log_likelihoods(
        self, poses: np.ndarray, seen: np.ndarray, names: np.ndarray
    ) -> np.ndarray:
        """Return the logarithm of the weight of each pose, but for the prior."""
        rows = names[:, 0] >= 0
        places = np.concatenate([self.map.means, self.map.covs[:, *UPPER]], axis=1)
        rules = self.rules
        return _weigh(
            poses, seen[rows], names[rows], places, rules.reach**2, rules.wrong, rules.unmatched
        )

    def _agreeing(self, pose: np.ndarray, seen: np.ndarray, names: np.ndarray) -> np.ndarray:
        """Return which points lie near the landmark that they look most like, seen from a pose."""
        rows = np.flatnonzero(names[:, 0] >= 0)
        there = np.column_stack([act(pose, seen[rows, :2]), seen[rows, 2]])
        gaps = np.linalg.norm(there - self.map.means[names[rows, 0]], axis=1)
        return rows[gaps < self.rules.within]

    def _anywhere(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return so many poses all over the area."""
        low, high = self.map.extent if self.area is None else self.area
        bounds = np.array([*low, -np.pi]), np.array([*high, np.pi])
        return rng.uniform(*bounds, (count, 3))

    def _implied(
        self, seen: np.ndarray, names: np.ndarray, count: int, rng: np.random.Generator
    ) -> np.ndarray:
        """Return poses that pairs of matches imply, so many at most."""
        rows = np.flatnonzero(names[:, 0] >= 0)
        if rows.size < 2:
            return np.empty((0, 3))
        points, places = seen[rows, :3], self.map.means[names[rows, 0]]
        one, two = rng.integers(rows.size, size=(2, TRIES * count))
        near = np.abs(points[:, 2] - places[:, 2]) < 3 * max(self.rules.reach, 0.1)
        here, there = points[two, :2] - points[one, :2], places[two, :2] - places[one, :2]
        long, far = np.hypot(*here.T), np.hypot(*there.T)
        fits = np.abs(long - far) < 3 * max(self.rules.reach, 0.1)
        good = np.flatnonzero(near[one] & near[two] & fits & (long > APART) & (far > APART))[:count]
        here, there, one, two = here[good], there[good], one[good], two[good]
        turn = np.arctan2(there[:, 1], there[:, 0]) - np.arctan2(here[:, 1], here[:, 0])
        turned = act(
            np.column_stack([np.zeros((len(good), 2)), turn]),
            ((points[one] + points[two]) / 2)[:, None, :2],
        )[:, 0]
        middle = (places[one] + places[two])[:, :2] / 2
        return np.column_stack([middle - turned, wrap_angle(turn)])

    def _refreshed(
        self,
        poses: np.ndarray,
        logs: np.ndarray,
        ancestors: np.ndarray,
        seen: np.ndarray,
        names: np.ndarray,
        rng: np.random.Generator,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Replace some particles by fresh ones of mean weight: the next picture judges them."""
        rules, count = self.rules, len(poses)
        number = int(rules.fresh * count)
        if not number:
            return poses, logs, ancestors
        if rules.source == "area":
            new = self._anywhere(number, rng)
        else:
            new = self._implied(seen, names, number, rng)
        rows = rng.choice(count, len(new), replace=False)
        poses, logs, ancestors = poses.copy(), logs.copy(), ancestors.copy()
        poses[rows], logs[rows], ancestors[rows] = new, -np.log(count), -1
        return poses, logs, ancestors

    def _told(
        self, poses: np.ndarray, logs: np.ndarray, seen: np.ndarray, names: np.ndarray
    ) -> tuple[Whereabouts, int]:
        """Return a state, and how many matches agree with what it says."""
        rules = self.rules
        particles = ParticleSet(np.column_stack([poses[:, :2], wrap_angle(poses[:, 2])]), logs)
        found = clusters(particles, near=rules.near)
        matches = np.count_nonzero(names[:, 0] >= 0)
        agreeing = self._agreeing(found[0].pose, seen, names).size
        agree = matches > 0 and agreeing >= rules.agree * matches
        return Whereabouts(particles, found, bool(found[0].share >= rules.sure and agree)), agreeing


def clusters(particles: ParticleSet, *, near: tuple[float, float]) -> tuple[Cluster, ...]:
    """Return where particles lie together, the heaviest first, ten clusters at most.

    The heaviest cell of a grid begins a cluster: what lies near the mean of its particles, and
    then near the mean of these. It is taken away, and the next begins, until one in a hundred parts
    of the weight is left. The method is ours.

    Parameters
    ----------
    particles
        Poses (M, 3): m, m, rad.
    near
        How far from its mean a particle of a cluster may be, m and rad.

    Raises
    ------
    ValueError
        If the states are not (M, 3), or a limit is not positive.
    """
    poses = checks.instance("particles", particles, ParticleSet).states
    checks.shaped("particles", poses, ("M", 3))
    both = checks.vector("near", near, 2).tolist()
    far, turned = (checks.positive(f"near[{i}]", limit) for i, limit in enumerate(both))
    weights = particles.weights
    cells = np.floor(poses / [CELLS[0], CELLS[0], CELLS[1]])
    cells[:, 2] %= round(TURN / CELLS[1])
    order = np.lexsort(cells.T)
    changes = (np.diff(cells[order], axis=0) != 0).any(axis=1)
    cell = np.empty(len(poses), dtype=int)
    cell[order] = np.cumsum(np.r_[False, changes])
    left, found = np.ones(len(poses), dtype=bool), []
    while len(found) < MOST_CLUSTERS and (not found or weights[left].sum() > 0.01):
        heaviest = np.argmax(np.bincount(cell, weights * left))
        own = left & (cell == heaviest)
        for _ in range(3):
            mean, _ = _moments(poses[own], weights[own])
            gap = np.abs(wrap_angle(poses[:, 2] - mean[2]))
            again = left & (np.hypot(*(poses[:, :2] - mean[:2]).T) < far) & (gap < turned)
            if not weights[again].sum() > 0:
                break
            own = again
        mean, cov = _moments(poses[own], weights[own])
        found.append(Cluster(min(float(weights[own].sum()), 1.0), mean, cov))
        left &= ~own
    return tuple(sorted(found, key=lambda cluster: -cluster.share))


def _moments(poses: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and covariance of poses, headings on the circle."""
    weights = weights / weights.sum()
    heading = np.arctan2(weights @ np.sin(poses[:, 2]), weights @ np.cos(poses[:, 2]))
    mean = np.array([*(weights @ poses[:, :2]), heading])
    off = poses - mean
    off[:, 2] = wrap_angle(off[:, 2])
    cov = (weights * off.T) @ off
    return mean, (cov + cov.T) / 2


def _fitted(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the pose from which points are seen at places, by least squares."""
    here, there = points - points.mean(axis=0), places - places.mean(axis=0)
    sine = (here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]).sum()
    turn = np.arctan2(sine, (here * there).sum())
    pose = np.array([0.0, 0.0, turn])
    return np.array([*(places.mean(axis=0) - act(pose, points).mean(axis=0)), turn])


@kernel()
@no_type_check
def _weigh(poses, seen, names, places, spread, wrong, unmatched):  # pragma: no cover - compiled
    """Return the logarithm of the weight of each pose, for points and places as nine numbers.

    A row is a place and the upper triangle of its covariance, points in the frame of the robot.
    """
    logs, none = np.zeros(len(poses)), -np.inf
    if wrong * unmatched > 0:
        none = np.log(wrong * unmatched)
    for m in range(len(poses)):
        x, y = poses[m, 0], poses[m, 1]
        c, s = np.cos(poses[m, 2]), np.sin(poses[m, 2])
        for i in range(len(seen)):
            own, count = seen[i], 0
            while count < names.shape[1] and names[i, count] >= 0:
                count += 1
            right = np.log((1 - wrong) / count) - 1.5 * np.log(2 * np.pi) if wrong < 1 else -np.inf
            best, total = none, 1.0 if none > -np.inf else 0.0
            for q in range(count):
                place = places[names[i, q]]
                dx, dy = place[0] - x, place[1] - y
                e0 = own[0] - (c * dx + s * dy)
                e1 = own[1] - (c * dy - s * dx)
                e2 = own[2] - place[2]
                p00, p01, p02, p11, p12 = place[3], place[4], place[5], place[6], place[7]
                a = own[3] + spread + c * c * p00 + 2 * c * s * p01 + s * s * p11
                b = own[4] + c * s * (p11 - p00) + (c * c - s * s) * p01
                d = own[5] + c * p02 + s * p12
                e = own[6] + spread + s * s * p00 - 2 * c * s * p01 + c * c * p11
                f = own[7] + c * p12 - s * p02
                g = own[8] + spread + place[8]
                k0, k1, k2 = e * g - f * f, d * f - b * g, b * f - d * e
                k3, k4, k5 = a * g - d * d, b * d - a * f, a * e - b * b
                det = a * k0 + b * k1 + d * k2
                if not det > 0:
                    continue
                square = k0 * e0 * e0 + k3 * e1 * e1 + k5 * e2 * e2
                square += 2 * (k1 * e0 * e1 + k2 * e0 * e2 + k4 * e1 * e2)
                one = right - 0.5 * (square / det + np.log(det))
                if one > best:
                    total, best = total * np.exp(best - one) + 1.0, one
                elif best > -np.inf:
                    total += np.exp(one - best)
            logs[m] += best + np.log(total) if total > 0 else -np.inf
    return logs

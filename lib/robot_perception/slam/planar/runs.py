"""Run of the planar filter over a whole drive: its steps, its settings and its history."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.fields import OPEN, checked
from robot_perception.observations import Observations
from robot_perception.slam.planar.association import IGNORED, NEW, Association, associate
from robot_perception.slam.planar.belief import MapBelief, checked_places
from robot_perception.slam.planar.filtering import checked_anchors
from robot_perception.slam.planar.motions import Odometry, PlanarMotion, Velocity
from robot_perception.slam.planar.sensors import (
    Compass,
    Fix,
    LandmarkSensor,
    PositionFix,
    checked_noises,
    checked_sensor,
)
from robot_perception.slam.planar.workspace import Workspace
from studies.files import destination, written


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """One step of a drive: a motion, then fixes, then observations of landmarks.

    Parameters
    ----------
    motion
        The motion since the step before; ``None`` if there was none.
    observations
        Landmarks observed after the motion, if any.
    fixes
        Positions and headings measured after the motion.
    time
        Time at the end of the step, s; it must not decrease along the drive. ``None`` if unknown.

    Raises
    ------
    ValueError
        If the time is not finite.
    """

    motion: PlanarMotion | None
    observations: Observations | None = None
    fixes: tuple[Fix, ...] = ()
    time: float | None = None

    def __post_init__(self) -> None:
        if self.motion is not None:
            checks.instance("motion", self.motion, Odometry, Velocity)
        if self.observations is not None:
            checks.instance("observations", self.observations, Observations)
        if type(self.fixes) is not tuple or self.fixes:
            fixes = checks.instances("fixes", self.fixes, PositionFix, Compass)
            object.__setattr__(self, "fixes", fixes)
        if self.time is not None:
            object.__setattr__(self, "time", checks.number("time", self.time))


@dataclass(frozen=True, eq=False, slots=True)
class Truth:
    """The true states of a drive, at which the ideal filter linearises.

    Parameters
    ----------
    poses : (k + 1, 3)
        True pose at the start and after each step, m, m, rad.
    landmarks : identifier -> (2,)
        True positions of the landmarks, m.

    Raises
    ------
    ValueError
        If ``poses`` is not (k + 1, 3), a number is not finite, or an identifier is not an integer
        of at least 0.
    """

    poses: Float[np.ndarray, "poses 3"]
    landmarks: Mapping[int, np.ndarray]

    def __post_init__(self) -> None:
        poses = checks.reals("poses", self.poses).copy()
        if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses):
            raise ValueError(f"poses must be (k + 1, 3), got {poses.shape}")
        checks.check_finite("poses", poses)
        object.__setattr__(self, "poses", poses)
        object.__setattr__(self, "landmarks", checked_places("landmark", self.landmarks))


@dataclass(frozen=True, eq=False, slots=True)
class Settings:
    """Settings of the filter.

    Parameters
    ----------
    sensor
        Sensor that observes the landmarks.
    anchors : identifier -> (2,)
        Landmarks whose position in the world is known, m.
    association
        Rules of data association; ``"known"``, ``"gated"`` or ``"joint"`` stands for an
        :class:`Association` of that kind with its defaults.
    linearisation
        Where Jacobians are taken. ``"latest"``: at the latest estimate, as in the plain filter.
        ``"first"``: at the first estimate of each state, so that all Jacobians of a run agree on
        what is unobservable. :class:`Truth`: at the true states (the ideal filter).
    revision_limit
        A landmark that was updated more often than this is retired; ``None`` retires none. The
        paper's limit is 50.
    retirement
        How a landmark is retired. ``"freeze"``, the paper's rule: its estimate becomes an anchor,
        as if it were known exactly. ``"consider"``: its estimate no longer changes, but its
        covariance and correlations still count (Schmidt's consider filter).
    keep
        Indices of the steps after which the whole belief is stored, from 0; the drive must have
        all of them.

    Raises
    ------
    ValueError
        If a word is not one of those listed, an anchor is not two finite numbers, an identifier is
        not an integer of at least 0, the limit is not an integer of at least 1, or an index of a
        step is not an integer.
    TypeError
        If the sensor is a class, or lacks a part of :class:`LandmarkSensor`.
    """

    sensor: LandmarkSensor
    anchors: Mapping[int, np.ndarray] = field(default_factory=dict)
    association: Association | Literal["known", "gated", "joint"] = "known"
    linearisation: Literal["latest", "first"] | Truth = "latest"
    revision_limit: int | None = None
    retirement: Literal["freeze", "consider"] = "freeze"
    keep: Sequence[int] = ()

    def __post_init__(self) -> None:
        checked_sensor(self.sensor)
        object.__setattr__(self, "anchors", checked_places("anchor", self.anchors))
        if not isinstance(self.association, Association):
            object.__setattr__(self, "association", Association(self.association))
        if not isinstance(self.linearisation, Truth):
            checks.one_of("linearisation", self.linearisation, ("latest", "first"), " or a Truth")
        checks.one_of("retirement", self.retirement, ("freeze", "consider"))
        if self.revision_limit is not None:
            object.__setattr__(
                self, "revision_limit", checks.whole("revision_limit", self.revision_limit, 1)
            )
        checks.integers("keep", self.keep, ("steps",))


@dataclass(frozen=True, slots=True)
class Counts:
    """Counts of the observations of a run, by how the filter used them.

    Parameters
    ----------
    observed
        All observations: the sum of the next five counts.
    matched
        Observations of landmarks of the map, used for updates.
    anchored
        Observations of anchors or frozen landmarks, used for updates.
    new
        Observations that put a new landmark into the map.
    rejected
        Observations that named a landmark but fell outside its gate.
    ignored
        Observations without a name that lie inside an outer gate but match no landmark, or that
        come where names are required.
    retired
        Landmarks (not observations) that were frozen, or whose estimates are no longer updated.
    """

    observed: int
    matched: int
    anchored: int
    new: int
    rejected: int
    ignored: int
    retired: int


@dataclass(frozen=True, eq=False, slots=True)
class History:
    r"""History of a run of k steps; index 0 of each array is the first step.

    Parameters
    ----------
    start : (3,)
        Estimated pose before the first step, m, m, rad.
    times : (k,)
        Time of each step, s; NaN for a step without a time.
    poses : (k, 3)
        Estimated pose after each step, m, m, rad.
    pose_covs : (k, 3, 3)
        Covariance of each of these poses.
    nis : (k,)
        Normalised innovation squared :math:`\tilde z^\top S^{-1} \tilde z`, summed over the
        updates of each step.
    dof : (k,)
        Degrees of freedom of ``nis``: how many numbers were measured in each step.
    sizes : (k,)
        Number of landmarks in the state after each step.
    used : k arrays (m,)
        For each step, the identifier of the landmark that each observation was used for (new
        landmarks included); -1 for an observation that was not used.
    belief
        Belief after the last step.
    frozen : identifier -> (2,)
        Landmarks that were frozen and left the state, and their last estimated positions, m.
    counts
        How the observations were used.
    kept : index of a step -> belief
        Belief after each step of ``Settings.keep``.
    points : index of a step -> (3 + 2n,)
        State at which Jacobians were taken after each of these steps, m, m, rad, then m.
    """

    start: Float[np.ndarray, "3"]
    times: Annotated[Float[np.ndarray, "k"], OPEN]
    poses: Float[np.ndarray, "k 3"]
    pose_covs: Float[np.ndarray, "k 3 3"]
    nis: Float[np.ndarray, "k"]
    dof: Int[np.ndarray, "k"]
    sizes: Int[np.ndarray, "k"]
    used: tuple[Int[np.ndarray, "..."], ...]
    belief: MapBelief
    frozen: dict[int, np.ndarray]
    counts: Counts
    kept: dict[int, MapBelief]
    points: dict[int, np.ndarray]
    __post_init__ = checked

    @property
    def path(self) -> Float[np.ndarray, "poses 3"]:
        """Estimated poses from the start on, (k + 1, 3), m, m, rad."""
        return np.vstack([self.start, self.poses])

    def to_tum(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the trajectory as ``timestamp tx ty tz qx qy qz qw``, one line for each step.

        Trajectory tools such as evo read this format: s, m, and the heading as a quaternion about
        z. The pose at the start has no time and is left out.

        Parameters
        ----------
        path
            File to write, in a folder that exists.
        overwrite
            Whether a file that exists may be replaced.

        Raises
        ------
        ValueError
            If a step has no time.
        FileNotFoundError
            If there is no such folder.
        FileExistsError
            If the file exists and must not be replaced.
        """
        path = destination(path, overwrite=overwrite)
        x, y, heading = self.poses.T
        none = np.zeros(len(x))
        quaternion = none, none, np.sin(heading / 2), np.cos(heading / 2)
        columns = np.column_stack([self._known_times(), x, y, none, *quaternion])
        with written(path) as beside:
            np.savetxt(beside, columns, fmt="%.9f")

    def to_csv(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the trajectory with its covariances as CSV, one line for each step.

        The first line names the columns and their units; covariances are those of x, y and heading.
        Parameters and errors are those of :meth:`to_tum`.
        """
        path = destination(path, overwrite=overwrite)
        rows, cols = np.triu_indices(3)
        columns = np.column_stack([self._known_times(), self.poses, self.pose_covs[:, rows, cols]])
        names = "time_s,x_m,y_m,heading_rad,cov_xx,cov_xy,cov_xh,cov_yy,cov_yh,cov_hh"
        formats = ["%.9f"] * 4 + ["%.12g"] * 6
        with written(path) as beside:
            np.savetxt(beside, columns, fmt=formats, delimiter=",", header=names, comments="")

    def _known_times(self) -> np.ndarray:
        """Return the times of the steps, or raise ``ValueError`` if a step has none."""
        without = np.flatnonzero(np.isnan(self.times))
        if without.size:
            raise ValueError(
                f"a trajectory needs times: {without.size} of {self.times.size} steps have none, "
                f"the first is step {without[0]}"
            )
        return self.times


def run_filter(start: MapBelief, steps: Iterable[Step], settings: Settings) -> History:
    """Run the filter over a drive.

    Each step, in this order: predict with the motion, update with the fixes, associate the
    observations, update with those of known landmarks, and put new landmarks into the map.

    The identifier that the filter gives to an unnamed new landmark is larger than all identifiers
    so far. A later observation with this identifier is taken as one of that landmark.

    Parameters
    ----------
    start
        Belief before the first step.
    steps
        The drive; it is read once, so a generator will do.
    settings
        Settings of the filter.

    Raises
    ------
    ValueError
        If there is no step, a step to keep does not occur, time goes backwards, an anchor is also
        in the map, the covariance of the start is not symmetric, or an update is impossible: an
        innovation covariance is singular, say, or a landmark lies exactly at the robot. Where one
        step is at fault, the message names it.
    """
    checks.instance("start", start, MapBelief)
    run = _Run(start, checks.instance("settings", settings, Settings))
    clock = -np.inf
    for k, step in enumerate(checks.iterable("steps", steps)):
        if not isinstance(step, Step):
            raise TypeError(f"steps must be of type Step, got {checks.shown(step)}")
        if step.time is not None:
            if step.time < clock:
                raise ValueError(f"step {k}: time goes backwards, from {clock} to {step.time}")
            clock = step.time
        try:
            run.take(k, step)
        except ValueError as error:
            raise ValueError(f"step {k}: {error}") from error
    if not run.poses:
        raise ValueError("steps are empty: a drive needs at least one step, got none")
    missing = [k for k in settings.keep if k not in run.kept]
    if missing:
        raise ValueError(f"keep names steps that a drive of {len(run.poses)} has not: {missing}")
    return run.history()


class _Run:
    """Mutable state of a run: the belief, the linearisation point, and what is recorded so far."""

    def __init__(self, start: MapBelief, settings: Settings) -> None:
        self.settings, self.work = settings, Workspace(start)
        self.anchors = checked_anchors(settings.anchors, start)  # frozen landmarks join them
        self.frozen: dict[int, np.ndarray] = {}
        self.revisions: dict[int, int] = {}
        self.rejections: dict[int, int] = {}  # how many in a row, by landmark
        self.next_id = max((-1, *self.work.ids, *self.anchors)) + 1
        self.tally = dict.fromkeys(Counts.__dataclass_fields__, 0)
        self.start, self.times = start.pose.copy(), []
        self.poses, self.pose_covs, self.nis, self.dof = [], [], [], []
        self.sizes, self.used, self.kept, self.points = [], [], {}, {}
        self.truth = settings.linearisation if isinstance(settings.linearisation, Truth) else None
        # state at which Jacobians are taken, laid out as the mean; None: at the latest estimate
        self.point = None if settings.linearisation == "latest" else start.mean.copy()
        if self.truth is not None:
            self.point[:3] = self.truth.poses[0]
            self.point[3:] = self._true_places(self.work.ids)

    def take(self, k: int, step: Step) -> None:
        """Run step k of the filter and record the result."""
        work = self.work
        if step.motion is not None:
            self._predict(k, step.motion)
        nis, dof = 0.0, 0
        for fix in step.fixes:
            innovation, _, squared = work.correct(fix)
            nis, dof = nis + squared, dof + innovation.size
        used = np.empty(0, dtype=np.int64)
        if step.observations is not None and len(step.observations):
            used, squared, size = self._see(step.observations)
            nis, dof = nis + squared, dof + size
        self.times.append(np.nan if step.time is None else step.time)
        self.poses.append(work.mean[:3].copy())
        self.pose_covs.append(work.pose_cov())
        self.nis.append(nis)
        self.dof.append(dof)
        self.sizes.append(len(work.ids))
        self.used.append(used)
        if k in self.settings.keep:
            self.kept[k] = work.snapshot()
            self.points[k] = (work.mean if self.point is None else self.point).copy()

    def history(self) -> History:
        """Return the record of all steps."""
        return History(
            start=self.start,
            times=np.array(self.times, dtype=float),
            poses=np.array(self.poses),
            pose_covs=np.array(self.pose_covs),
            nis=np.array(self.nis),
            dof=np.array(self.dof),
            sizes=np.array(self.sizes),
            used=tuple(self.used),
            belief=self.work.release(),
            frozen=self.frozen,
            counts=Counts(**self.tally),
            kept=self.kept,
            points=self.points,
        )

    def _predict(self, k: int, motion: PlanarMotion) -> None:
        """Predict with the motion of step k, linearised as the settings say."""
        if self.point is None:
            self.work.predict(motion)
        elif self.truth is None:
            self.work.predict(motion, at=self.point[:3])
            self.point[:3] = self.work.mean[:3]
        else:
            if k + 1 >= len(self.truth.poses):
                raise ValueError(f"the truth has {len(self.truth.poses)} poses, need {k + 2}")
            self.work.predict(motion, at=self.truth.poses[k], after=self.truth.poses[k + 1])
            self.point[:3] = self.truth.poses[k + 1]

    def _see(self, observed: Observations) -> tuple[np.ndarray, float, int]:
        """Associate, update and extend the map; return `History.used`, NIS and dof of the step."""
        work, tally, values = self.work, self.tally, observed.values
        noises = checked_noises(observed, self.settings.sensor)
        used = self._associated(observed, noises)
        names = used.tolist()
        seen = [i for i, n in enumerate(names) if n in work.slots or n in self.anchors]
        new = [i for i, n in enumerate(names) if n not in work.slots and n not in self.anchors]
        new = [i for i in new if names[i] != IGNORED]
        tally["observed"] += len(names)
        tally["ignored"] += len(names) - len(seen) - len(new)
        squared, seen = self._revise(names, seen, values, noises, used) if seen else (0.0, [])
        if new:
            self._add(new, values, noises, used)
        return used, squared, 2 * len(seen)

    def _associated(self, observed: Observations, noises: np.ndarray) -> np.ndarray:
        """Return an identifier, ``IGNORED`` or ``NEW`` for each observation."""
        settings = self.settings
        if settings.association.kind == "known":
            return observed.ids.copy()
        return associate(
            self.work, observed, noises, settings.sensor, self.anchors, settings.association
        )

    def _revise(
        self,
        names: list[int],
        seen: list[int],
        values: np.ndarray,
        noises: np.ndarray,
        used: np.ndarray,
    ) -> tuple[float, list[int]]:
        """Update with observations of the map and of anchors; return NIS and the rows used.

        ``seen`` are the rows of these observations. Rows that the gate for known names rejects
        are set to ``IGNORED`` in ``used``.
        """
        work, association = self.work, self.settings.association
        slots, points = work.targets([names[i] for i in seen], self.anchors)
        values, noises = values[seen], _some(noises, seen)
        innovation, by_pose, by_point = work.linearise(
            slots, points, values, self.settings.sensor, self.point
        )
        if association.kind == "known" and np.isfinite(association.limit):
            distances = work.distances(by_pose, by_point, slots, innovation, noises)
            passed = self._passed([names[i] for i in seen], distances)
            inside = np.flatnonzero(passed)
            used[[seen[i] for i in np.flatnonzero(~passed)]] = IGNORED
            self.tally["rejected"] += len(seen) - inside.size
            seen = [seen[i] for i in inside]
            if not seen:
                return 0.0, seen
            slots, innovation, noises = slots[inside], innovation[inside], _some(noises, inside)
            by_pose, by_point = by_pose[inside], by_point[inside]
        _, squared = work.revise(by_pose, by_point, slots, innovation, noises)
        for i in seen:
            self._count(names[i])
        return squared, seen

    def _passed(self, names: list[int], distances: np.ndarray) -> np.ndarray:
        """Tell which observations pass the gate for known names, or are let in by its patience."""
        association = self.settings.association
        passed = distances <= association.limit
        if association.patience is not None:
            for i, name in enumerate(names):
                passed[i] |= self.rejections.get(name, 0) >= association.patience
                self.rejections[name] = 0 if passed[i] else self.rejections.get(name, 0) + 1
        return passed

    def _count(self, name: int) -> None:
        """Count an update with a landmark, and retire the landmark at the revision limit."""
        if name in self.anchors:
            self.tally["anchored"] += 1
            return
        self.tally["matched"] += 1
        self.revisions[name] = count = self.revisions.get(name, 0) + 1
        if self.settings.revision_limit is not None and count == self.settings.revision_limit + 1:
            self._retire(name)

    def _retire(self, name: int) -> None:
        """Freeze a landmark and take it out of the state, or stop updating its estimate."""
        self.tally["retired"] += 1
        if self.settings.retirement == "consider":
            self.work.consider(name)
            return
        slot = self.work.slots[name]
        if self.point is not None:
            self.point = np.delete(self.point, [slot, slot + 1])
        self.frozen[name] = self.work.remove(name)
        self.anchors[name] = tuple(self.frozen[name].tolist())

    def _add(
        self, new: list[int], values: np.ndarray, noises: np.ndarray, used: np.ndarray
    ) -> None:
        """Put the landmarks of the observations in rows ``new`` into the map.

        Unnamed ones get the next free identifiers, which are written to ``used``.
        """
        work = self.work
        self.next_id = max(self.next_id, int(used.max()) + 1)
        for i in new:
            if used[i] == NEW:
                used[i] = self.next_id
                self.next_id += 1
        names, n = used[new].tolist(), work.mean.size
        there = None if self.truth is None else self._true_places(names).reshape(-1, 2)
        work.add(names, values[new], _some(noises, new), self.settings.sensor, self.point, there)
        self.tally["new"] += len(new)
        if self.point is not None:
            first = work.mean[n:] if self.truth is None else self._true_places(names)
            self.point = np.concatenate([self.point, first])

    def _true_places(self, names: Sequence[int]) -> np.ndarray:
        """Return the true positions of landmarks, flat as in the state."""
        missing = [name for name in names if name not in self.truth.landmarks]
        if missing:
            raise ValueError(f"the truth has no landmarks {missing}")
        return np.array([self.truth.landmarks[name] for name in names]).ravel()


def _some(noises: np.ndarray, rows: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return the covariances of some observations; one that all share stays as it is."""
    return noises if len(noises) == 1 else noises[rows]

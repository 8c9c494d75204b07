"""The filter's own copy of a belief, which it changes in place."""

from collections.abc import Mapping, Sequence

import numpy as np

from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.belief import MapBelief, trusted
from robot_perception.slam.planar.motions import Motion
from robot_perception.slam.planar.sensors import Fix, LandmarkSensor

SYMMETRY = 1e-9  # relative; as in beliefs.check_covariance


class Workspace:
    """State and covariance with room to grow, and where each landmark stands in them.

    Raises
    ------
    ValueError
        If the covariance of the belief has lost its symmetry or holds a number that is not finite.
    """

    def __init__(self, belief: MapBelief) -> None:
        self.n = belief.mean.size
        room = self.n + 32
        self.mean, self.cov = np.zeros(room), np.zeros((room, room))
        self.mean[: self.n] = belief.mean
        asymmetry, largest = kernels.copy_symmetric(belief.cov, self.cov)
        if not (np.isfinite(largest) and asymmetry <= SYMMETRY * largest):
            raise ValueError(f"cov must be finite and symmetric, asymmetry is {asymmetry:.3g}")
        self.ids = belief.ids.tolist()
        self.slots = {name: 3 + 2 * i for i, name in enumerate(self.ids)}
        self.considered = np.zeros(room, dtype=bool)

    @property
    def pose(self) -> np.ndarray:
        """Estimated pose, a view."""
        return self.mean[:3]

    def belief(self) -> MapBelief:
        """Return the state as it is now."""
        n = self.n
        ids = np.array(self.ids, dtype=np.int64)
        return trusted(self.mean[:n].copy(), self.cov[:n, :n].copy(), ids)

    def predict(
        self, motion: Motion, at: np.ndarray | None = None, after: np.ndarray | None = None
    ) -> None:
        """Move the robot; see :func:`~robot_perception.slam.planar.predict`."""
        at = self.mean[:3].copy() if at is None else at
        kernels.move(self.mean, motion.increment)
        after = self.mean if after is None else after
        kernels.predict_cov(self.cov, self.n, motion.increment_cov, at, after)

    def targets(
        self, ids: Sequence[int], anchors: Mapping[int, tuple[float, float]]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return for each landmark its slot (-1: an anchor) and its estimated or known place."""
        slots, points = np.empty(len(ids), dtype=np.int64), np.empty((len(ids), 2))
        for i, name in enumerate(ids):
            slots[i] = slot = self.slots.get(name, -1)
            if slot < 0:
                points[i] = anchors[name]
        kernels.gather(self.mean, slots, points)
        return slots, points

    def linearise(
        self,
        slots: np.ndarray,
        points: np.ndarray,
        values: np.ndarray,
        sensor: LandmarkSensor,
        at: np.ndarray | None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return innovations and Jacobians; the latter at the estimate or at a given state."""
        expected, by_pose, by_point = sensor.look(self.mean[:3], points)
        if at is not None:
            elsewhere = points.copy()
            kernels.gather(at, slots, elsewhere)
            _, by_pose, by_point = sensor.look(at[:3], elsewhere)
        return sensor.residual(values, expected), by_pose, by_point

    def revise(
        self,
        by_pose: np.ndarray,
        by_point: np.ndarray,
        slots: np.ndarray,
        innovation: np.ndarray,
        noises: np.ndarray,
    ) -> tuple[np.ndarray, float]:
        """Update in place with k linearised observations; return S and ε, or raise."""
        S, squared, regular = kernels.update(
            self.mean, self.cov, self.n, by_pose, by_point, slots, innovation, noises,
            self.considered,
        )  # fmt: skip
        if not regular:
            raise ValueError("innovation covariance is singular: observations without noise?")
        return S, squared

    def distances(
        self,
        by_pose: np.ndarray,
        by_point: np.ndarray,
        slots: np.ndarray,
        innovation: np.ndarray,
        noises: np.ndarray,
    ) -> np.ndarray:
        """Return the squared Mahalanobis distance of each of k observations by itself."""
        B = np.empty((innovation.size, self.n))
        kernels.cross_rows(self.cov, self.n, by_pose, by_point, slots, B)
        S = kernels.innovation_cov(B, by_pose, by_point, slots, noises)
        blocks = S.reshape(len(slots), 2, len(slots), 2)
        own = np.moveaxis(np.diagonal(blocks, axis1=0, axis2=2), -1, 0)
        return (innovation * np.linalg.solve(own, innovation[..., None])[..., 0]).sum(axis=-1)

    def correct(self, fix: Fix) -> tuple[np.ndarray, np.ndarray, float]:
        """Update with a pose sensor; return innovation, S and ε."""
        by_pose, innovation = fix.matrix(), fix.residual(self.mean[:3])
        by_point = np.zeros((1, innovation.size, 2))
        S, squared = self.revise(
            by_pose[None], by_point, np.array([-1]), innovation[None], fix.covariance()[None]
        )
        return innovation, S, squared

    def add(
        self,
        ids: Sequence[int],
        values: np.ndarray,
        noises: np.ndarray,
        sensor: LandmarkSensor,
        at: np.ndarray | None = None,
    ) -> None:
        """Append landmarks seen for the first time, with their cross-covariances."""
        needed = self.n + 2 * len(ids)
        if needed > self.mean.size:
            self._grow(2 * needed)
        points = sensor.locate(self.mean[:3], values)
        by_pose, by_value = sensor.locate_jacobians(
            self.mean[:3] if at is None else at, points, values
        )
        kernels.append(self.mean, self.cov, self.n, points, by_pose, by_value, noises)
        for i, name in enumerate(ids):
            self.slots[name] = self.n + 2 * i
            self.ids.append(name)
        self.n = needed

    def remove(self, landmark_id: int) -> np.ndarray:
        """Take a landmark out of the state and return where it was."""
        slot, n = self.slots.pop(landmark_id), self.n
        place = self.mean[slot : slot + 2].copy()
        keep = np.r_[0:slot, slot + 2 : n]
        for array in (self.mean, self.considered):
            array[: n - 2] = array[keep]
        self.cov[: n - 2, : n - 2] = self.cov[np.ix_(keep, keep)]
        self.considered[n - 2 : n] = False
        self.ids.remove(landmark_id)
        for name, other in self.slots.items():
            self.slots[name] = other - 2 if other > slot else other
        self.n = n - 2
        return place

    def consider(self, landmark_id: int) -> None:
        """Let a landmark's estimate stand from now on; its covariance still counts."""
        slot = self.slots[landmark_id]
        self.considered[slot : slot + 2] = True

    def _grow(self, room: int) -> None:
        n = self.n
        mean, cov, considered = np.zeros(room), np.zeros((room, room)), np.zeros(room, dtype=bool)
        mean[:n], cov[:n, :n], considered[:n] = (
            self.mean[:n],
            self.cov[:n, :n],
            self.considered[:n],
        )
        self.mean, self.cov, self.considered = mean, cov, considered

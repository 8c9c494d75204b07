"""The filter's own copy of a belief, which it changes in place."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg.blas import dsyrk

from robot_perception.slam.planar import kernels
from robot_perception.slam.planar.belief import MapBelief, trusted
from robot_perception.slam.planar.motions import PlanarMotion
from robot_perception.slam.planar.sensors import Fix, LandmarkSensor

SYMMETRY = 1e-9  # relative; as in beliefs.check_covariance
SINGULAR = "innovation covariance is singular: observations without noise?"


class Workspace:
    """State, lower triangle of the covariance, and where each landmark stands in them.

    The other triangle is not set; the beliefs that come out are whole.

    Raises
    ------
    ValueError
        If the covariance of the belief has lost its symmetry or holds a number that is not finite.
    """

    def __init__(self, belief: MapBelief) -> None:
        self.cov = np.empty_like(belief.cov)
        wrong = kernels.fill_lower(self.cov, belief.cov, SYMMETRY)
        if wrong:
            raise ValueError(f"cov must be finite and symmetric, {wrong} pairs of entries are not")
        self.mean = belief.mean.copy()
        self.ids = belief.ids.tolist()
        self.slots = {name: 3 + 2 * i for i, name in enumerate(self.ids)}
        self.considered = np.zeros(self.mean.size, dtype=bool)

    def snapshot(self) -> MapBelief:
        """Return the state as it is now."""
        cov = self.cov.copy()
        kernels.mirror(cov)
        return trusted(self.mean.copy(), cov, np.array(self.ids, dtype=np.int64))

    def release(self) -> MapBelief:
        """Return the state without a copy; the workspace is not to be used afterwards."""
        kernels.mirror(self.cov)
        return trusted(self.mean, self.cov, np.array(self.ids, dtype=np.int64))

    def pose_cov(self) -> np.ndarray:
        """Return the covariance of the pose."""
        cov = self.cov[:3, :3].copy()
        kernels.mirror(cov)
        return cov

    def predict(
        self, motion: PlanarMotion, at: np.ndarray | None = None, after: np.ndarray | None = None
    ) -> None:
        """Move the robot; see :func:`~robot_perception.slam.planar.predict`."""
        at = self.mean[:3].copy() if at is None else at
        kernels.move(self.mean, motion.increment)
        after = self.mean if after is None else after
        kernels.predict_cov(self.cov, motion.increment_cov, at, after)

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
        expected, by_pose, by_point = sensor.expect(self.mean[:3], points)
        if at is not None:
            elsewhere = points.copy()
            kernels.gather(at, slots, elsewhere)
            _, by_pose, by_point = sensor.expect(at[:3], elsewhere)
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
        W, white, S, regular = kernels.whiten(
            self.cov, by_pose, by_point, slots, innovation, noises
        )
        if not regular:
            raise ValueError(SINGULAR)
        change = white @ W  # K z̃, eqs (6) and (7)
        fixed = np.flatnonzero(self.considered)
        if fixed.size:
            change[fixed] = 0.0
            block = np.ix_(fixed, fixed)
            kept = self.cov[block]
        self.mean += change
        self.mean[2] = kernels.wrapped(self.mean[2])
        # eq. (9); BLAS sees the transpose and writes what is for us the lower triangle
        self.cov = dsyrk(-1.0, W.T, 1.0, self.cov.T, overwrite_c=1).T
        if fixed.size:
            self.cov[block] = kept
        return S, float(white @ white)

    def innovation_cov(
        self, by_pose: np.ndarray, by_point: np.ndarray, slots: np.ndarray, noises: np.ndarray
    ) -> np.ndarray:
        """Return the joint covariance S of k observations."""
        B = kernels.cross_rows(self.cov, by_pose, by_point, slots)
        return kernels.innovation_cov(B, by_pose, by_point, slots, noises)

    def distances(
        self,
        by_pose: np.ndarray,
        by_point: np.ndarray,
        slots: np.ndarray,
        innovation: np.ndarray,
        noises: np.ndarray,
    ) -> np.ndarray:
        """Return the squared Mahalanobis distance of each of k observations by itself."""
        S = kernels.own_covs(self.cov, by_pose, by_point, slots) + noises
        return (innovation * np.linalg.solve(S, innovation[..., None])[..., 0]).sum(axis=-1)

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
        there: np.ndarray | None = None,
    ) -> None:
        """Append landmarks seen for the first time, with their cross-covariances.

        Jacobians are taken at the pose ``at`` and the points ``there``, each the estimate if not
        given.
        """
        n, needed = self.mean.size, self.mean.size + 2 * len(ids)
        points = sensor.locate(self.mean[:3], values)
        by_pose, by_value = sensor.locate_jacobians(
            self.mean[:3] if at is None else at, points if there is None else there, values
        )
        cov = np.empty((needed, needed))
        cov[:n, :n] = self.cov
        self.mean, self.cov = np.concatenate([self.mean, points.ravel()]), cov
        self.considered = np.concatenate([self.considered, np.zeros(2 * len(ids), dtype=bool)])
        kernels.append(cov, n, by_pose, by_value, noises)
        for i, name in enumerate(ids):
            self.slots[name] = n + 2 * i
            self.ids.append(name)

    def remove(self, landmark_id: int) -> np.ndarray:
        """Take a landmark out of the state and return where it was."""
        slot = self.slots.pop(landmark_id)
        place = self.mean[slot : slot + 2].copy()
        keep = np.delete(np.arange(self.mean.size), [slot, slot + 1])
        self.mean, self.considered = self.mean[keep], self.considered[keep]
        self.cov = self.cov[np.ix_(keep, keep)]
        self.ids.remove(landmark_id)
        for name, other in self.slots.items():
            self.slots[name] = other - 2 if other > slot else other
        return place

    def consider(self, landmark_id: int) -> None:
        """Let a landmark's estimate stand from now on; its covariance still counts."""
        slot = self.slots[landmark_id]
        self.considered[slot : slot + 2] = True

"""The planar filter as the textbook writes it, with whole matrices.

The same numbers as :mod:`.filtering`, at O(n³) a step: this is the version to read.
"""

import numpy as np
from jaxtyping import Float
from scipy.linalg import block_diag

from robot_perception import checks
from robot_perception.geometry import rotation, wrap_angle
from robot_perception.observations import Observations
from robot_perception.slam.planar.belief import MapBelief
from robot_perception.slam.planar.filtering import Anchors, Innovation, checked_anchors, pose_of
from robot_perception.slam.planar.motions import Odometry, PlanarMotion, Velocity
from robot_perception.slam.planar.sensors import (
    Compass,
    Fix,
    LandmarkSensor,
    PositionFix,
    checked_noises,
    checked_sensor,
)


def motion_matrix(
    at: Float[np.ndarray, "states"], after: Float[np.ndarray, "..."]
) -> Float[np.ndarray, "states states"]:
    r"""Return F, the derivative of the state after a motion by the state before.

    .. math:: F = \begin{bmatrix} I_2 & J (t' - t) & 0 \\ 0 & 1 & 0 \\ 0 & 0 & I \end{bmatrix}

    Parameters
    ----------
    at : (3 + 2n,)
        State before the motion.
    after : (3 + 2n,) or (3,)
        State or pose after it.
    """
    at, after = checks.array("at", at, ("states",)), checks.array("after", after, ("states",))
    for name, state in (("at", at), ("after", after)):
        if len(state) < 3:
            raise ValueError(f"{name} must hold a pose, got {state.shape}")
    F = np.eye(len(at))
    F[:2, 2] = at[1] - after[1], after[0] - at[0]
    return F


def measurement_matrix(
    at: Float[np.ndarray, "states"],
    slots: list[int | None],
    points: Float[np.ndarray, "m 2"],
    sensor: LandmarkSensor,
) -> Float[np.ndarray, "rows states"]:
    r"""Return H, two rows for each observation.

    Parameters
    ----------
    at : (3 + 2n,)
        State at which to differentiate.
    slots
        Where each landmark stands in the state; ``None`` for an anchor, eq. (25).
    points : (m, 2)
        Where each landmark is, m.
    sensor
        What measures them.
    """
    at = checks.array("at", at, ("states",))
    points = checks.array("points", points, ("m", 2))
    slots = checks.instances("slots", slots, int, np.integer, type(None))
    if len(slots) != len(points):
        raise ValueError(f"need slots for each of points, got {len(slots)} and {points.shape}")
    outside = [s for s in slots if s is not None and not 3 <= s < len(at) - 1]
    if outside or len(at) < 3:
        raise ValueError(f"slots must be in the state at {at.shape} behind its pose, got {outside}")
    _, by_pose, by_point = checked_sensor(sensor).expect(at[:3], points)
    H = np.zeros((2 * len(slots), len(at)))
    for i, slot in enumerate(slots):
        H[2 * i : 2 * i + 2, :3] = by_pose[i]
        if slot is not None:
            H[2 * i : 2 * i + 2, slot : slot + 2] = by_point[i]
    return H


def predict(
    belief: MapBelief,
    motion: PlanarMotion,
    at: np.ndarray | None = None,
    after: np.ndarray | None = None,
) -> MapBelief:
    r"""Return the belief after a motion: :math:`P' = F P F^\top + G Q G^\top`, eqs (3) and (5)."""
    checks.instance("belief", belief, MapBelief)
    checks.instance("motion", motion, Odometry, Velocity)
    at = belief.mean if at is None else np.r_[pose_of("at", at), belief.mean[3:]]
    pose = motion.move(belief.pose)
    F = motion_matrix(at, pose if after is None else pose_of("after", after))
    G = np.zeros((len(at), 3))
    G[:3] = block_diag(rotation(at[2]), 1.0)
    cov = F @ belief.cov @ F.T + G @ motion.increment_cov @ G.T
    return MapBelief(np.r_[pose, belief.mean[3:]], _symmetric(cov), belief.ids)


@checks.computable("belief and observations")
def update(
    belief: MapBelief,
    observations: Observations,
    sensor: LandmarkSensor,
    anchors: Anchors | None = None,
    at: np.ndarray | None = None,
) -> tuple[MapBelief, Innovation]:
    r"""Return the belief after observing known landmarks and anchors, eqs (6) to (9).

    .. math::
        K = P H^\top S^{-1}, \qquad P^+ = (I - K H) P (I - K H)^\top + K R K^\top
    """
    checks.instance("belief", belief, MapBelief)
    checks.instance("observations", observations, Observations)
    checked_sensor(sensor)
    anchors = checked_anchors({} if anchors is None else anchors, belief)
    at = belief.mean if at is None else checks.vector("at", at, belief.mean.size)
    ids = observations.ids.tolist()
    slots = [None if i in anchors else belief.slot(i) for i in ids]

    def points(state: np.ndarray) -> np.ndarray:
        pairs = zip(ids, slots, strict=True)
        found = (anchors[i] if s is None else state[s : s + 2] for i, s in pairs)
        return np.array(list(found))

    noises = _noises(observations, sensor)
    expected, _, _ = sensor.expect(belief.pose, points(belief.mean))
    H = measurement_matrix(at, slots, points(at), sensor)
    innovation = sensor.residual(observations.values, expected).ravel()
    return _joseph(belief, H, block_diag(*noises), innovation)


@checks.computable("belief and fix")
def correct(belief: MapBelief, fix: Fix) -> tuple[MapBelief, Innovation]:
    """Return the belief after a fix of the pose, eqs (26) and (27)."""
    checks.instance("belief", belief, MapBelief)
    checks.instance("fix", fix, PositionFix, Compass)
    H = np.hstack([fix.matrix(), np.zeros((len(fix.matrix()), belief.mean.size - 3))])
    return _joseph(belief, H, fix.covariance(), fix.residual(belief.pose))


def add_landmarks(
    belief: MapBelief,
    observations: Observations,
    sensor: LandmarkSensor,
    at: np.ndarray | None = None,
) -> MapBelief:
    r"""Return the belief with all observed landmarks put into the map.

    .. math::
        P' = Y \begin{bmatrix} P & 0 \\ 0 & R \end{bmatrix} Y^\top, \qquad
        Y = \begin{bmatrix} I & 0 \\ [G_r \; 0] & G_z \end{bmatrix}
    """
    checks.instance("belief", belief, MapBelief)
    checks.instance("observations", observations, Observations)
    points = checked_sensor(sensor).locate(belief.pose, observations.values)
    at = belief.pose if at is None else pose_of("at", at)
    by_pose, by_value = sensor.locate_jacobians(at, points, observations.values)
    known, new = belief.mean.size, 2 * len(points)
    Y = np.eye(known + new)
    Y[known:, :3] = by_pose.reshape(-1, 3)
    Y[known:, known:] = block_diag(*by_value)
    cov = Y @ block_diag(belief.cov, *_noises(observations, sensor)) @ Y.T
    mean = np.concatenate([belief.mean, points.ravel()])
    return MapBelief(mean, _symmetric(cov), np.concatenate([belief.ids, observations.ids]))


def _joseph(
    belief: MapBelief, H: np.ndarray, R: np.ndarray, innovation: np.ndarray
) -> tuple[MapBelief, Innovation]:
    P = belief.cov
    S = H @ P @ H.T + R  # eq. (8)
    K = np.linalg.solve(S, H @ P).T  # eq. (7)
    mean = belief.mean + K @ innovation  # eq. (6)
    mean[2] = wrap_angle(mean[2])
    rest = np.eye(len(mean)) - K @ H
    cov = rest @ P @ rest.T + K @ R @ K.T  # eq. (9)
    nis = innovation @ np.linalg.solve(S, innovation)
    return MapBelief(mean, _symmetric(cov), belief.ids), Innovation(innovation, S, float(nis))


def _noises(observations: Observations, sensor: LandmarkSensor) -> np.ndarray:
    return np.broadcast_to(checked_noises(observations, sensor), (len(observations), 2, 2))


def _symmetric(cov: np.ndarray) -> np.ndarray:
    return (cov + cov.T) / 2

r"""The planar extended Kalman filter, one step at a time.

Each function takes a belief and returns a new one. Equation numbers are those of Andrade-Cetto,
"Perception Issues in Mobile Robotics", section 2. :mod:`.textbook` has it with whole matrices.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.observations import Observations
from robot_perception.slam.planar.belief import MapBelief, checked_places
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

Anchors = Mapping[int, np.ndarray]


@dataclass(frozen=True, eq=False, slots=True)
class Innovation:
    r"""Diagnostics of one update.

    Parameters
    ----------
    innovation : (m,)
        Measured minus expected values, angles in [-π, π).
    innovation_cov : (m, m)
        :math:`S`, eq. (8).
    nis
        :math:`\tilde z^\top S^{-1} \tilde z`, χ² with m degrees of freedom for a right model.
    """

    innovation: Float[np.ndarray, "m"]
    innovation_cov: Float[np.ndarray, "m m"]
    nis: float


def predict(
    belief: MapBelief,
    motion: PlanarMotion,
    at: Float[np.ndarray, "..."] | None = None,
    after: Float[np.ndarray, "..."] | None = None,
) -> MapBelief:
    r"""Return the belief after a motion.

    .. math::
        P' = F P F^\top + G Q G^\top, \qquad
        F = \begin{bmatrix} I & J (t' - t) \\ 0 & 1 \end{bmatrix} \text{ on the pose},
        \quad F = I \text{ on the landmarks}

    Only the three rows and columns of the robot change: the cost grows as n, not as n².

    Parameters
    ----------
    belief
        Belief before the motion.
    motion
        :class:`Odometry` or :class:`Velocity`.
    at : (3 + 2n,) or (3,), optional
        State before the motion at which to linearise; the estimate if left out.
    after : (3 + 2n,) or (3,), optional
        State after the motion at which to linearise; the predicted estimate if left out.

    Raises
    ------
    ValueError
        If a linearisation point has no three finite numbers, or the covariance is not symmetric.

    References
    ----------
    Andrade-Cetto, eqs (3) and (5). Huang, Mourikis and Roumeliotis, "Observability-based rules for
    designing consistent EKF SLAM estimators", 2010, for F written with two poses.
    """
    work = Workspace(checks.instance("belief", belief, MapBelief))
    checks.instance("motion", motion, Odometry, Velocity)
    work.predict(motion, pose_of("at", at), pose_of("after", after))
    return work.release()


def update(
    belief: MapBelief,
    observations: Observations,
    sensor: LandmarkSensor,
    anchors: Anchors | None = None,
    at: Float[np.ndarray, "states"] | None = None,
) -> tuple[MapBelief, Innovation]:
    r"""Return the belief after observing known landmarks and anchors, and what that showed.

    .. math::
        B = P H^\top, \quad S = H B + R = L L^\top, \quad W = L^{-1} B^\top, \qquad
        \hat x^+ = \hat x + W^\top L^{-1} \tilde z, \quad P^+ = P - W^\top W

    Each row of H touches three entries of the pose and at most two of a landmark, so B costs
    O(n m), and what remains is one symmetric update of rank m. With the best gain
    :math:`K = B S^{-1}` that is the Joseph form (9). A landmark that is *considered* has zeros for
    its rows of K; multiplied out, the Joseph form is then the same but for the covariance of the
    considered states among themselves, which stays as it was. One triangle is computed and
    mirrored, so the result is exactly symmetric.

    Parameters
    ----------
    belief
        Belief before the observations.
    observations
        Each of a landmark of the map or of an anchor.
    sensor
        :class:`CartesianSensor` or :class:`RangeBearing`.
    anchors : identifier -> (2,), optional
        Landmarks whose place in the world is known, m. They are no part of the state, eq. (20).
    at : (3 + 2n,), optional
        State at which to linearise H; the estimate if left out.

    Raises
    ------
    ValueError
        If an identifier is neither in the map nor that of an anchor, that of an anchor is in the
        map too or no integer of at least 0, a range is too short for the sensor, the
        covariance is not symmetric, a landmark lies exactly at the robot, or S is singular.

    References
    ----------
    Andrade-Cetto, eqs (6) to (9), (24) and (25).
    """
    work = Workspace(checks.instance("belief", belief, MapBelief))
    checks.instance("observations", observations, Observations)
    checked_sensor(sensor)
    anchors = checked_anchors({} if anchors is None else anchors, belief)
    noises, ids = checked_noises(observations, sensor), observations.ids.tolist()
    unknown = [name for name in ids if name not in work.slots and name not in anchors]
    if unknown:
        raise ValueError(f"no landmark of the map and no anchor: {unknown}")
    if not ids:
        return work.release(), Innovation(np.empty(0), np.empty((0, 0)), 0.0)
    point = None if at is None else checks.vector("at", at, belief.mean.size)
    slots, points = work.targets(ids, anchors)
    with checks.computable("belief and observations"):
        innovation, by_pose, by_point = work.linearise(
            slots, points, observations.values, sensor, point
        )
        S, squared = work.revise(by_pose, by_point, slots, innovation, noises)
    return work.release(), Innovation(innovation.ravel(), S, squared)


def correct(belief: MapBelief, fix: Fix) -> tuple[MapBelief, Innovation]:
    r"""Return the belief after a fix of the pose, and what the fix showed.

    Parameters
    ----------
    belief
        Belief before the fix.
    fix
        :class:`PositionFix`, eq. (26), or :class:`Compass`.

    Raises
    ------
    ValueError
        If the covariance is not symmetric or S is singular.

    References
    ----------
    Andrade-Cetto, eqs (26) and (27).
    """
    work = Workspace(checks.instance("belief", belief, MapBelief))
    checks.instance("fix", fix, PositionFix, Compass)
    seen = Innovation(*work.correct(fix))
    return work.release(), seen


def add_landmarks(
    belief: MapBelief,
    observations: Observations,
    sensor: LandmarkSensor,
    at: Float[np.ndarray, "..."] | None = None,
) -> MapBelief:
    r"""Return the belief with every observed landmark put into the map.

    .. math::
        p = g(x_r, z), \qquad P_{pp} = G_r P_{rr} G_r^\top + G_z R G_z^\top, \qquad
        P_{px} = G_r P_{rx}

    Without the cross-covariance :math:`P_{px}` the filter would take the error of the pose, which
    all new landmarks share, for errors of their own.

    Parameters
    ----------
    belief
        Belief before.
    observations
        Of landmarks that are not in the map.
    sensor
        The sensor they are from.
    at : (3 + 2n,) or (3,), optional
        Pose at which to linearise; the estimate if left out.

    Raises
    ------
    ValueError
        If an identifier is unknown (-1) or already in the map, a range is too short for the sensor,
        or the covariance is not symmetric.
    """
    work = Workspace(checks.instance("belief", belief, MapBelief))
    checks.instance("observations", observations, Observations)
    checked_sensor(sensor)
    noises, ids = checked_noises(observations, sensor), observations.ids.tolist()
    if -1 in ids:
        raise ValueError("a new landmark needs an identifier, got -1")
    known = [name for name in ids if name in work.slots]
    if known:
        raise ValueError(f"already in the map: {known}")
    work.add(ids, observations.values, noises, sensor, pose_of("at", at))
    return work.release()


def checked_anchors(anchors: Anchors, belief: MapBelief) -> dict[int, tuple[float, float]]:
    """Return anchors as pairs of numbers, or raise ``ValueError``; none may be in the map."""
    places = checked_places("anchor", anchors)
    both = sorted(set(places) & set(belief.ids.tolist()))
    if both:
        raise ValueError(f"in the map and an anchor: {both}")
    return {name: tuple(place.tolist()) for name, place in places.items()}


def pose_of(name: str, state: np.ndarray | None) -> np.ndarray | None:
    """Return the pose of a state, or ``None`` of none; ``ValueError`` if it is not finite."""
    if state is None:
        return None
    state = checks.array(name, state, ("states",), finite=False)
    return checks.vector(name, state[:3], 3)

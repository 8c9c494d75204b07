"""Errors of an estimated path in the plane: absolute, relative and final errors."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.geometry import act, between, rotation, wrap_angle


@dataclass(frozen=True, slots=True)
class PoseError:
    """Distance of one pose from another.

    Parameters
    ----------
    position
        Distance of the positions, m.
    heading
        Difference of the headings (estimate minus truth), rad, from -π to π.
    """

    position: float
    heading: float


@dataclass(frozen=True, eq=False, slots=True)
class RelativeErrors:
    """Errors of the motions between pairs of poses.

    Parameters
    ----------
    translation : (pairs,)
        Length of the error of each motion's translation, m.
    rotation : (pairs,)
        Error of each motion's rotation, rad: in the plane estimate minus truth, from -π to π; in
        space its angle, from 0 to π.
    """

    translation: Float[np.ndarray, " pairs"]
    rotation: Float[np.ndarray, " pairs"]

    @property
    def translation_rms(self) -> float:
        """Root of the mean squared translation error, m."""
        return float(np.sqrt(np.mean(self.translation**2)))

    @property
    def rotation_rms(self) -> float:
        """Root of the mean squared rotation error, rad."""
        return float(np.sqrt(np.mean(self.rotation**2)))


def align(
    estimate: Float[np.ndarray, "k _"], truth: Float[np.ndarray, "k _"]
) -> Float[np.ndarray, "3"]:
    r"""Return the rigid motion, without change of scale, that brings a path closest to another.

    .. math:: \min_{R, t} \sum_i \lVert q_i - (R p_i + t) \rVert^2

    with :math:`p_i` the estimated and :math:`q_i` the true positions. In the plane the singular
    value decomposition of [1] is an arctangent: with the centred positions as complex numbers, the
    angle is that of :math:`\sum_i \bar p_i q_i`.

    Parameters
    ----------
    estimate : (k, 2) or (k, 3)
        Positions, or poses, whose headings are not used; m.
    truth : (k, 2) or (k, 3)
        True positions at the same times, m.

    Returns
    -------
    (3,)
        The motion as a pose (x, y, φ), m and rad: `geometry.act` applies it.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite, or the positions do not determine
        the angle: if either path stands still, or its turned copies fit the other equally well.

    References
    ----------
    [1] Umeyama, "Least-squares estimation of transformation parameters between two point patterns",
    IEEE Transactions on Pattern Analysis and Machine Intelligence 13(4), 1991, eqs 34-42, with
    c = 1.
    """
    p, q = _positions(estimate, truth)
    p_mean, q_mean = p.mean(axis=0), q.mean(axis=0)  # eqs 34, 35
    p_centred, q_centred = p - p_mean, q - q_mean
    cos = np.sum(p_centred * q_centred)  # Σ of eq 38: its rotation-like part
    sin = np.sum(p_centred[:, 0] * q_centred[:, 1] - p_centred[:, 1] * q_centred[:, 0])
    spread = np.sqrt(np.sum(p_centred**2) * np.sum(q_centred**2))
    rounding = np.finfo(float).eps * len(p) * np.abs(p).max() * np.abs(q).max()
    if np.hypot(cos, sin) <= 1e-12 * spread + rounding:
        raise ValueError(
            f"estimate and truth do not determine a rotation: spread {spread:.3g} m², "
            f"common part {np.hypot(cos, sin):.3g} m²"
        )
    angle = np.arctan2(sin, cos)  # eq 40
    return np.array([*(q_mean - rotation(angle) @ p_mean), angle])  # eq 41


def absolute_error(
    estimate: Float[np.ndarray, "k _"], truth: Float[np.ndarray, "k _"], aligned: bool
) -> float:
    r"""Return the absolute trajectory error: the root mean squared distance of the positions.

    .. math:: \sqrt{\tfrac 1 k \sum_i \lVert q_i - p_i \rVert^2}

    Parameters
    ----------
    estimate : (k, 2) or (k, 3)
        Estimated positions or poses, m.
    truth : (k, 2) or (k, 3)
        True ones at the same times, m.
    aligned
        Whether the estimate is first moved as a rigid body to where it fits best (`align`). An
        error of the first pose then does not count, nor does part of what came later.

    Returns
    -------
    float
        m.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite; if aligned, also where `align`
        raises.

    References
    ----------
    Sturm, Engelhard, Endres, Burgard and Cremers, "A benchmark for the evaluation of RGB-D SLAM
    systems", IROS 2012, section IV.
    """
    p, q = _positions(estimate, truth)
    if checks.flag("aligned", aligned):
        p = act(align(p, q), p)
    return float(np.sqrt(np.mean(np.sum((p - q) ** 2, axis=1))))


def end_error(estimate: Float[np.ndarray, "k 3"], truth: Float[np.ndarray, "k 3"]) -> PoseError:
    """Return the error of the last pose, as at the end of a loop; paths as in `relative_error`."""
    estimate, truth = _poses(estimate, truth)
    x, y, heading = estimate[-1] - truth[-1]
    return PoseError(float(np.hypot(x, y)), float(wrap_angle(heading)))


def relative_error(
    estimate: Float[np.ndarray, "k 3"], truth: Float[np.ndarray, "k 3"], steps: int
) -> RelativeErrors:
    r"""Return the errors of all motions over a fixed number of steps.

    .. math:: E_i = (Q_i^{-1} Q_{i+\Delta})^{-1} (P_i^{-1} P_{i+\Delta})

    No alignment is needed: where a path begins does not matter.

    Parameters
    ----------
    estimate : (k, 3)
        Poses (x, y, φ), m and rad.
    truth : (k, 3)
        True poses at the same times.
    steps
        Number of steps Δ, at least 1 and less than k.

    Returns
    -------
    RelativeErrors
        Of k - Δ motions.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite, or do not have so many steps.

    References
    ----------
    Sturm et al. 2012 (see `absolute_error`), section IV.
    """
    estimate, truth = _poses(estimate, truth)
    checks.whole("steps", steps, 1, len(truth) - 1)
    first = np.arange(len(truth) - steps)
    pairs = np.stack([first, first + steps], axis=1)
    return motion_errors(relative_poses(estimate, pairs), relative_poses(truth, pairs))


def relative_error_over(
    estimate: Float[np.ndarray, "k 3"], truth: Float[np.ndarray, "k 3"], distance: float
) -> RelativeErrors:
    """Return the errors of all motions over a fixed distance along the true path.

    From each pose the motion leads to the first pose that is at least so far along the true path;
    poses nearer to its end have none.

    Parameters
    ----------
    estimate, truth : (k, 3)
        As in `relative_error`.
    distance
        Length of path, m.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite, or the true path is shorter.
    """
    estimate, truth = _poses(estimate, truth)
    pairs = _pairs_over("truth", truth[:, :2], distance)
    return motion_errors(relative_poses(estimate, pairs), relative_poses(truth, pairs))


def pairs_over(positions: Float[np.ndarray, "k _"], distance: float) -> Int[np.ndarray, "pairs 2"]:
    """Return from which position to which a path goes over a distance.

    Parameters
    ----------
    positions : (k, 2) or (k, 3)
        Positions along the path, m.
    distance
        Length of path, m.

    Returns
    -------
    (pairs, 2)
        Rows of (from, to): each position, and the first that is at least so far along the path;
        positions nearer to its end are in no row as the first.

    Raises
    ------
    ValueError
        If the positions are not finite or of another shape, or the path is shorter.
    """
    positions = checks.array("positions", positions, ("k", "n"))
    if positions.shape[1] not in (2, 3) or not len(positions):
        raise ValueError(f"positions must be (k, 2) or (k, 3), k >= 1, got {positions.shape}")
    return _pairs_over("positions", positions, distance)


def relative_poses(
    poses: Float[np.ndarray, "k 3"], pairs: Int[np.ndarray, "pairs 2"]
) -> Float[np.ndarray, "pairs 3"]:
    """Return the second pose of each pair as seen from the first.

    Parameters
    ----------
    poses : (k, 3)
        Poses (x, y, φ) in the world, m and rad.
    pairs : (pairs, 2)
        Which pose is seen from which: rows of (from, to).

    Returns
    -------
    (pairs, 3)
        Poses in the frame of the first, heading from -π to π.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, or a pair names a pose that there is not.
    """
    poses = checks.array("poses", poses, ("k", 3))
    pairs = checks.integers("pairs", pairs, ("n", 2))
    if pairs.size and not (pairs.min() >= 0 and pairs.max() < len(poses)):
        raise ValueError(f"pairs name poses {pairs.min()} to {pairs.max()} of {len(poses)}")
    return between(poses[pairs[:, 0]], poses[pairs[:, 1]])


def motion_errors(
    estimate: Float[np.ndarray, "pairs 3"], truth: Float[np.ndarray, "pairs 3"]
) -> RelativeErrors:
    """Return the errors of estimated motions.

    Parameters
    ----------
    estimate : (pairs, 3)
        Motions (x, y, φ) in the frame of the pose where each begins, m and rad.
    truth : (pairs, 3)
        True ones, such as a file of verified relations holds.

    Raises
    ------
    ValueError
        If there is no motion, the numbers differ, or an entry is not finite.
    """
    estimate, truth = _poses(estimate, truth)
    x, y, turn = (estimate - truth).T
    return RelativeErrors(np.hypot(x, y), np.asarray(wrap_angle(turn)))


def _pairs_over(name: str, positions: np.ndarray, distance: float) -> np.ndarray:
    """Return the pairs of `pairs_over`; ``name`` is what the caller calls the path."""
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    most = travelled[-1]
    if not 0 < checks.number("distance", distance) <= most:
        raise ValueError(
            f"distance must be from 0 to {most:.6g} m, the length of {name}, got {distance}"
        )
    end = np.searchsorted(travelled, travelled + distance)
    first = np.flatnonzero(end < len(positions))
    return np.stack([first, end[first]], axis=1)


def _poses(estimate: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Check two paths of poses."""
    estimate, truth = checks.reals("estimate", estimate), checks.reals("truth", truth)
    if estimate.shape != truth.shape or estimate.ndim != 2 or estimate.shape[1] != 3:
        raise ValueError(
            "estimate and truth must be two paths (k, 3) of one length, got "
            f"{estimate.shape} and {truth.shape}"
        )
    _check_path(estimate, truth)
    return estimate, truth


def _positions(estimate: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Check two paths of poses or positions and return the positions."""
    estimate, truth = checks.reals("estimate", estimate), checks.reals("truth", truth)
    flat = estimate.ndim == 2 and truth.ndim == 2
    if not flat or len(estimate) != len(truth) or {estimate.shape[1], truth.shape[1]} - {2, 3}:
        raise ValueError(
            "estimate and truth must be two paths (k, 2 or 3) of one length, got "
            f"{estimate.shape} and {truth.shape}"
        )
    _check_path(estimate, truth)
    return estimate[:, :2], truth[:, :2]


def _check_path(estimate: np.ndarray, truth: np.ndarray) -> None:
    if not len(estimate):
        raise ValueError("the paths are empty: there is no error of an estimate to speak of")
    for name, path in (("estimate", estimate), ("truth", truth)):
        checks.array(name, path)

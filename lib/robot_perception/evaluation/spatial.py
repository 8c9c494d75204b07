"""Errors of an estimated path in 3-D: association, alignment, absolute and relative errors.

Association, alignment and errors are defined as in evo (https://github.com/MichaelGrupp/evo), so
that its numbers can be compared with ours.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation

from robot_perception import checks
from robot_perception.evaluation.trajectories import RelativeErrors, pairs_over
from robot_perception.fields import checked
from robot_perception.geometry import se3

ALIGNMENTS = ("none", "se3", "sim3")


@dataclass(frozen=True, eq=False, slots=True)
class Similarity:
    r"""A similarity transformation, a rigid motion with a scale: :math:`p \mapsto c R\, p + t`.

    Parameters
    ----------
    scale
        Scale :math:`c`.
    motion : (4, 4)
        Rigid motion with rotation R and translation t, m.
    """

    scale: float
    motion: Float[np.ndarray, "4 4"]
    __post_init__ = checked

    def act(self, points: Float[np.ndarray, "... n 3"]) -> Float[np.ndarray, "... n 3"]:
        """Return transformed points.

        Raises
        ------
        ValueError
            If the last axis is not 3 or a number is not finite.
        """
        points = checks.array("points", points, (..., "n", 3))
        return se3.act(self.motion, self.scale * points)

    def move(self, poses: Float[np.ndarray, "k 4 4"]) -> Float[np.ndarray, "k 4 4"]:
        r"""Return transformed poses: :math:`(R_i, p_i) \mapsto (R R_i,\; c R p_i + t)`.

        Raises
        ------
        ValueError
            If a pose is not a rigid motion.
        """
        poses = checks.reals("poses", poses)
        checks.shaped("poses", poses, ("k", 4, 4))
        scaled = se3.checked("poses", poses).copy()
        scaled[:, :3, 3] *= self.scale
        return se3.compose(self.motion, scaled)


def associate(
    estimate: Float[np.ndarray, " k"], truth: Float[np.ndarray, " m"], most: float = 0.01
) -> Int[np.ndarray, "pairs 2"]:
    """Return the pairs of poses of two paths that belong together by their times.

    Each pose of the shorter path (of the estimate, if both have as many poses) is paired with the
    pose of the other path that is nearest in time, or left out if none is near enough. A pose of
    the longer path may occur in several pairs.

    Parameters
    ----------
    estimate : (k,)
        Times of the estimated poses, s, rising.
    truth : (m,)
        Times of the true ones, s, rising.
    most
        Largest difference of two times, s.

    Returns
    -------
    (pairs, 2)
        Indices of a pose of the estimate and of one of the truth, in the order of time.

    Raises
    ------
    ValueError
        If times do not rise or are not finite, or the difference is negative.

    References
    ----------
    Sturm et al. 2012 (see `absolute_error`), section IV; evo's `associate_trajectories`.
    """
    times = []
    for name, own in (("estimate", estimate), ("truth", truth)):
        own = checks.moderate(name, checks.array(name, own, ("k",)))
        if (np.diff(own) <= 0).any():
            raise ValueError(f"{name} must be times that rise, got one that does not")
        times.append(own)
    most = checks.not_negative("most", most)
    swapped = len(times[0]) > len(times[1])
    few, many = times[::-1] if swapped else times
    if not few.size:
        return np.zeros((0, 2), dtype=int)
    after = np.minimum(np.searchsorted(many, few, side="right"), len(many) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(many[after] - few) < np.abs(few - many[before]), after, before)
    near = np.flatnonzero(np.abs(many[nearest] - few) <= most)
    pairs = np.stack([near, nearest[near]], axis=1)
    return pairs[:, ::-1] if swapped else pairs


def align(
    estimate: Float[np.ndarray, "k 3"], truth: Float[np.ndarray, "k 3"], scaled: bool
) -> Similarity:
    r"""Return the rigid motion or similarity that brings one path closest to another.

    .. math:: \min_{c, R, t} \sum_i \lVert q_i - (c R p_i + t) \rVert^2

    Parameters
    ----------
    estimate : (k, 3)
        Estimated positions :math:`p_i`, m.
    truth : (k, 3)
        True positions :math:`q_i` at the same times, m.
    scaled
        Whether the scale c is free, as for a single camera, which cannot observe it; else c is 1.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite, or the positions do not determine
        the rotation, because a path is straight or several rotations fit equally well.

    References
    ----------
    Umeyama, "Least-squares estimation of transformation parameters between two point patterns",
    IEEE Transactions on Pattern Analysis and Machine Intelligence 13(4), 1991, eqs 34-43.
    """
    p, q = _paths("positions (k, 3)", (3,), estimate, truth)
    scaled = checks.flag("scaled", scaled)
    p_mean, q_mean = p.mean(axis=0), q.mean(axis=0)  # eqs 34, 35
    p_centred, q_centred = p - p_mean, q - q_mean
    U, D, Vt = np.linalg.svd(q_centred.T @ p_centred / len(p))  # Σ of eq 38
    S = np.array([1, 1, np.sign(np.linalg.det(U) * np.linalg.det(Vt))])  # eqs 39, 43
    spread = np.sqrt(np.mean(p_centred**2) * np.mean(q_centred**2))
    rounding = np.finfo(float).eps * np.abs(p).max() * np.abs(q).max()
    if D[1] + S[2] * D[2] <= 1e-12 * spread + rounding:
        raise ValueError(
            "estimate and truth do not determine a rotation: "
            f"singular values {D[0]:.3g}, {D[1]:.3g}, {S[2] * D[2]:.3g} m²"
        )
    R = U @ np.diag(S) @ Vt  # eq 40
    scale = float(D @ S / np.mean(np.sum(p_centred**2, axis=1))) if scaled else 1.0  # eq 42
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = R, q_mean - scale * R @ p_mean  # eq 41
    return Similarity(scale, motion)


def align_poses(
    estimate: Float[np.ndarray, "k 4 4"], truth: Float[np.ndarray, "k 4 4"], alignment: str
) -> tuple[Float[np.ndarray, "k 4 4"], Similarity]:
    """Return estimated poses aligned with the true ones, by their positions.

    Parameters
    ----------
    estimate : (k, 4, 4)
        Poses, m.
    truth : (k, 4, 4)
        True poses at the same times.
    alignment
        ``"none"``: both paths are in one frame. ``"se3"``: the frame of the estimate is arbitrary,
        as in most SLAM. ``"sim3"``: its scale is, too, as with a single camera.

    Returns
    -------
    poses, similarity
        The aligned poses, and the transformation that aligned them.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not of rigid motions, the alignment is not
        one of these, or `align` raises.
    """
    estimate, truth = _paths("poses (k, 4, 4)", (4, 4), estimate, truth)
    if checks.one_of("alignment", alignment, ALIGNMENTS) == "none":
        found = Similarity(1.0, np.eye(4))
    else:
        found = align(estimate[:, :3, 3], truth[:, :3, 3], alignment == "sim3")
    return found.move(estimate), found


def absolute_error(estimate: Float[np.ndarray, "k 3"], truth: Float[np.ndarray, "k 3"]) -> float:
    r"""Return the absolute trajectory error: the root mean squared distance of the positions, m.

    .. math:: \sqrt{\tfrac 1 k \sum_i \lVert q_i - p_i \rVert^2}

    This function does not align. If frame or scale of the estimate are arbitrary, align it first,
    with `align` and `Similarity.act`.

    Parameters
    ----------
    estimate : (k, 3)
        Estimated positions, m.
    truth : (k, 3)
        True ones at the same times, m.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not finite.

    References
    ----------
    Sturm, Engelhard, Endres, Burgard and Cremers, "A benchmark for the evaluation of RGB-D SLAM
    systems", IROS 2012, section IV.
    """
    p, q = _paths("positions (k, 3)", (3,), estimate, truth)
    return float(np.sqrt(np.mean(np.sum((p - q) ** 2, axis=1))))


def relative_error(
    estimate: Float[np.ndarray, "k 4 4"], truth: Float[np.ndarray, "k 4 4"], steps: int
) -> RelativeErrors:
    r"""Return the relative pose errors: the errors of all motions over a fixed number of steps.

    .. math:: E_i = (Q_i^{-1} Q_{i+\Delta})^{-1} (P_i^{-1} P_{i+\Delta})

    with the true poses :math:`Q_i` and the estimated poses :math:`P_i`. The errors are the length
    of the translation of :math:`E_i` and its angle of rotation.

    Parameters
    ----------
    estimate : (k, 4, 4)
        Poses, m.
    truth : (k, 4, 4)
        True poses at the same times.
    steps
        Number of steps Δ, at least 1 and less than k.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not of rigid motions, or have too few poses
        for this number of steps.

    References
    ----------
    Sturm et al. 2012 (see `absolute_error`), section IV.
    """
    estimate, truth = _paths("poses (k, 4, 4)", (4, 4), estimate, truth)
    steps = checks.whole("steps", steps, 1, len(truth) - 1)
    first = np.arange(len(truth) - steps)
    return _motion_errors(estimate, truth, np.stack([first, first + steps], axis=1))


def relative_error_over(
    estimate: Float[np.ndarray, "k 4 4"], truth: Float[np.ndarray, "k 4 4"], distance: float
) -> RelativeErrors:
    """Return the relative pose errors over a fixed distance along the true path.

    Divided by the distance, they are the drift of the KITTI benchmark, in metres and radians per
    metre. For the errors see `relative_error`.

    Parameters
    ----------
    estimate : (k, 4, 4)
        Poses, m.
    truth : (k, 4, 4)
        True poses at the same times.
    distance
        Length of path between two poses, m; `trajectories.pairs_over` chooses the pairs.

    Raises
    ------
    ValueError
        If the paths are empty, of different length or not of rigid motions, or the true path is
        shorter than the distance.

    References
    ----------
    Geiger, Lenz and Urtasun, "Are we ready for autonomous driving? The KITTI vision benchmark
    suite", CVPR 2012, section 3.
    """
    estimate, truth = _paths("poses (k, 4, 4)", (4, 4), estimate, truth)
    return _motion_errors(estimate, truth, pairs_over(truth[:, :3, 3], distance))


def _motion_errors(
    estimate: np.ndarray, truth: np.ndarray, pairs: Int[np.ndarray, "pairs 2"]
) -> RelativeErrors:
    """Return the errors of the motions between pairs of poses; see `relative_error`."""
    moved, right = (se3.between(path[pairs[:, 0]], path[pairs[:, 1]]) for path in (estimate, truth))
    translation = np.linalg.norm(moved[:, :3, 3] - right[:, :3, 3], axis=1)  # length of that of E
    turn = Rotation.from_matrix(right[:, :3, :3].mT @ moved[:, :3, :3])
    return RelativeErrors(translation, turn.magnitude())


def _paths(
    what: str, shape: tuple[int, ...], estimate: np.ndarray, truth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return two checked paths of one length, of positions or of poses."""
    estimate, truth = checks.reals("estimate", estimate), checks.reals("truth", truth)
    if estimate.shape != truth.shape or estimate.shape[1:] != shape or not len(estimate):
        raise ValueError(
            f"estimate and truth must be two paths of {what}, not empty and of one length, "
            f"got {estimate.shape} and {truth.shape}"
        )
    for name, path in (("estimate", estimate), ("truth", truth)):
        checks.array(name, path)
    if shape == (4, 4):
        return se3.checked("estimate", estimate), se3.checked("truth", truth)
    return estimate, truth

"""Ranks and unseen directions of linearised systems, in numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.fields import checked
from robot_perception.geometry import rotation
from robot_perception.slam.observability.sensors import StateSensor, see

MOST_STEPS = 10_000


@dataclass(frozen=True, eq=False, slots=True)
class Analysis:
    """Rank and null space of an observability matrix.

    Parameters
    ----------
    rank
        Number of directions that are seen.
    unseen : (states, states - rank)
        Orthonormal basis of the directions that are not.
    """

    rank: int
    unseen: Float[np.ndarray, "states hidden"]
    __post_init__ = checked

    def hides(self, direction: Float[np.ndarray, "states"]) -> float:
        """Return the share of a direction that is unseen.

        Returns
        -------
        float
            Length of its projection on the unseen directions over its own: 1 if no measurement
            changes along it, 0 if it is orthogonal to all that is unseen.

        Raises
        ------
        ValueError
            If the direction is zero or of another shape.
        """
        direction = checks.array("direction", direction)
        if direction.shape != self.unseen.shape[:1] or not np.linalg.norm(direction) > 0:
            raise ValueError(
                f"direction must be {self.unseen.shape[:1]} and not zero, got {direction}"
            )
        return float(np.linalg.norm(self.unseen.T @ direction) / np.linalg.norm(direction))


def analyse(matrix: Float[np.ndarray, "rows states"], *, tolerance: float = 1e-9) -> Analysis:
    """Return rank and unseen directions of an observability matrix.

    Columns are scaled to unit length first, so that metres and millimetres give the same rank.

    Parameters
    ----------
    matrix : (rows, states)
        Any of the observability matrices.
    tolerance
        A singular value counts if it is larger than this share of the largest one. The default is
        far above rounding (1e-13 for a hundred steps) and far below what a motion of a millimetre
        in a room of ten metres leaves.

    Raises
    ------
    ValueError
        If the matrix is empty or not finite, or the tolerance no share.
    """
    matrix = checks.array("matrix", matrix, ("rows", "states"))
    if not matrix.size:
        raise ValueError(f"matrix must be (rows, states) and not empty, got {matrix.shape}")
    tolerance = checks.share("tolerance", tolerance)
    lengths = np.linalg.norm(matrix, axis=0)
    scale = 1 / np.where(lengths > 0, lengths, 1.0)
    _, values, rows = np.linalg.svd(matrix * scale)
    rank = int((values > tolerance * values[0]).sum()) if values[0] > 0 else 0
    unseen, _ = np.linalg.qr(scale[:, None] * rows[rank:].T)
    return Analysis(rank, unseen)


def fixed_point_matrix(
    sensors: Sequence[StateSensor],
    state: Float[np.ndarray, "states"],
    increment: Float[np.ndarray, "3"],
    steps: int | None = None,
) -> Float[np.ndarray, "rows states"]:
    r"""Return the observability matrix of the system linearised at one point.

    .. math::
        \begin{bmatrix} H \\ HF \\ HF^2 \\ \vdots \end{bmatrix}, \qquad
        F = I + \begin{bmatrix} J R\, d \\ 0 \\ \mathbf 0 \end{bmatrix} e_\varphi^\top

    F knows that the robot moves by :math:`R\,d`, but H stays where the motion began: the robot
    moves in the one and not in the other.

    Parameters
    ----------
    sensors
        What is measured.
    state : (3 + 2n,)
        The one point, m, m, rad, then m.
    increment : (3,)
        Motion in the frame of the robot :math:`(d_x, d_y, \theta)`, m and rad.
    steps
        Number of blocks; as many as there are states if left out.

    Raises
    ------
    ValueError
        If something is of the wrong shape or not finite, or there is no step or more than ten
        thousand.

    References
    ----------
    Andrade-Cetto, text to eqs (25) and (27).
    """
    _, H = see(sensors, state)
    increment = checks.vector("increment", increment, 3)
    steps = H.shape[1] if steps is None else checks.whole("steps", steps, 1, MOST_STEPS)
    F = _transition(H.shape[1], rotation(state[2]) @ increment[:2])
    return np.vstack([H @ np.linalg.matrix_power(F, k) for k in range(steps)])


def trajectory_matrix(
    sensors: Sequence[StateSensor], states: Float[np.ndarray, "steps states"]
) -> Float[np.ndarray, "rows states"]:
    r"""Return the local observability matrix along a trajectory.

    .. math::
        \begin{bmatrix} H_0 \\ H_1 F_0 \\ H_2 F_1 F_0 \\ \vdots \end{bmatrix}, \qquad
        F_{k-1} \cdots F_0 = I + \begin{bmatrix} J (t_k - t_0) \\ 0 \\ \mathbf 0 \end{bmatrix}
        e_\varphi^\top

    Parameters
    ----------
    sensors
        What is measured.
    states : (steps, 3 + 2n)
        True states; the landmarks are the same in all of them.

    Raises
    ------
    ValueError
        If there is no state, something is of the wrong shape or not finite, or a landmark moves.

    References
    ----------
    Huang, Mourikis and Roumeliotis, "Observability-based rules for designing consistent EKF SLAM
    estimators", 2010.
    """
    states = checks.array("states", states)
    rows, size = states.shape if states.ndim == 2 else (0, 0)
    if rows == 0 or size < 3 or size % 2 == 0:
        raise ValueError(f"states must be (steps, 3 + 2n) and not empty, got {states.shape}")
    if (states[:, 3:] != states[0, 3:]).any():
        raise ValueError("the landmarks must stay where they are in all states")
    blocks = []
    for state in states:
        _, H = see(sensors, state)
        blocks.append(H @ _transition(state.size, state[:2] - states[0, :2]))
    return np.vstack(blocks)


def _transition(size: int, displacement: np.ndarray) -> np.ndarray:
    """Return F of a motion that moves the robot by a displacement in the world."""
    F = np.eye(size)
    F[:2, 2] = -displacement[1], displacement[0]
    return F

"""The motions of the whole world that sensors may fail to see."""

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.geometry import act
from robot_perception.slam.observability.sensors import checked_state

SHIFT_X, SHIFT_Y, TURN = "shift in x", "shift in y", "turn"


def translate(
    state: Float[np.ndarray, "states"], shift: Float[np.ndarray, "2"]
) -> Float[np.ndarray, "states"]:
    r"""Return the state with robot and landmarks moved together: :math:`t + s,\ p_i + s`.

    Parameters
    ----------
    state : (3 + 2n,)
        m, m, rad, then m.
    shift : (2,)
        :math:`s`, m.
    """
    return _moved(state, np.append(checks.vector("shift", shift, 2), 0.0))


def rotate(
    state: Float[np.ndarray, "states"], angle: float, about: Float[np.ndarray, "2"]
) -> Float[np.ndarray, "states"]:
    r"""Return the state with robot and landmarks turned together about a point.

    .. math:: t \to c + A (t - c), \quad \varphi \to \varphi + \alpha, \quad
        p_i \to c + A (p_i - c), \qquad A = R(\alpha)

    The heading is not wrapped, so that small turns stay small differences.

    Parameters
    ----------
    state : (3 + 2n,)
        m, m, rad, then m.
    angle
        :math:`\alpha`, rad.
    about : (2,)
        :math:`c`, m.
    """
    about = checks.vector("about", about, 2)
    pose = np.array([0.0, 0.0, checks.number("angle", angle)])
    pose[:2] = about - act(pose, about[None])[0]
    return _moved(state, pose)


def gauge_directions(
    state: Float[np.ndarray, "states"], about: Float[np.ndarray, "2"]
) -> dict[str, Float[np.ndarray, "states"]]:
    r"""Return how the state moves when the whole world is shifted or turned a little.

    .. math:: (e, 0, e, …, e), \qquad \big(J (t - c),\, 1,\, J (p_1 - c), …\big)

    Parameters
    ----------
    state : (3 + 2n,)
        Where the directions are taken, m, m, rad, then m.
    about : (2,)
        :math:`c`, centre of the turn, m.

    Returns
    -------
    dict
        ``"shift in x"``, ``"shift in y"`` (per metre) and ``"turn"`` (per radian).
    """
    points = _points(checked_state(state)) - checks.vector("about", about, 2)
    return {
        SHIFT_X: _state(0.0, np.broadcast_to([1.0, 0.0], points.shape)),
        SHIFT_Y: _state(0.0, np.broadcast_to([0.0, 1.0], points.shape)),
        TURN: _state(1.0, np.stack([-points[:, 1], points[:, 0]], axis=1)),
    }


def information_along(
    direction: Float[np.ndarray, "states"], cov: Float[np.ndarray, "states states"]
) -> float:
    r"""Return the information that a belief claims along a direction.

    .. math:: I = N^\top P^{-1} N

    If the sensors do not see :math:`N` it can only fall. For the turn of the world, whose
    component along the heading is 1, no heading variance is below its inverse:
    :math:`P_{\varphi\varphi} \ge 1/I` (Cauchy and Schwarz).

    Parameters
    ----------
    direction : (3 + 2n,)
        :math:`N`.
    cov : (3 + 2n, 3 + 2n)
        :math:`P`.

    Raises
    ------
    ValueError
        If the shapes disagree, an entry is not finite, or the covariance is none or singular.
    """
    direction = checks.array("direction", direction, ("n",))
    size = (direction.size, direction.size)
    cov = checks.covariance("cov", cov, size, f"direction {direction.shape}")
    diagonal = np.diagonal(cov)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))  # metres and radians side by side
    try:
        factor = np.linalg.cholesky(cov * scale * scale[:, None])
    except np.linalg.LinAlgError:
        lowest = np.linalg.eigvalsh(cov)[0]
        raise ValueError(f"cov is singular, smallest eigenvalue is {lowest:.3g}") from None
    return float((np.linalg.solve(factor, scale * direction) ** 2).sum())


def _points(state: np.ndarray) -> np.ndarray:
    """Return the position of the robot and below it the landmarks."""
    return np.delete(state, 2).reshape(-1, 2)


def _state(heading: float, points: np.ndarray) -> np.ndarray:
    return np.insert(np.asarray(points, dtype=float).ravel(), 2, heading)


def _moved(state: np.ndarray, pose: np.ndarray) -> np.ndarray:
    state = checked_state(state)
    return _state(state[2] + pose[2], act(pose, _points(state)))

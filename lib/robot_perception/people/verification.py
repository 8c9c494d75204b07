"""One cue after the other: a sensor detects, another verifies, as the paper's forerunners do.

``step(verified, hypotheses, directions, reach) -> (verified, chosen)``
"""

from collections.abc import Set

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import Hypotheses


def step(
    verified: Set[int],
    hypotheses: Hypotheses,
    directions: Float[np.ndarray, " d"],
    reach: float,
) -> tuple[frozenset[int], Bool[np.ndarray, " n"]]:
    r"""Return who has been verified by now, and which hypotheses these are.

    A hypothesis is verified by a direction :math:`\psi` with :math:`|\varphi - \psi| \le` the
    reach, and stays so for as long as its identity lives.

    Parameters
    ----------
    verified
        Identities of those who were verified before.
    hypotheses
        Of the sensor that detects, n.
    directions : (d,)
        In which the other one has seen somebody since the last time, rad.
    reach
        Largest difference of the two, rad.

    Returns
    -------
    frozenset
        Identities; those of hypotheses that are gone are forgotten.
    (n,)
        Which of the hypotheses are verified.

    Raises
    ------
    ValueError
        If a direction is not finite, or the reach is negative.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross (see `Detections`), section 1, on EXPO-ROBOTS and
    BIRON.
    """
    checks.instance("verified", verified, Set)
    checks.instance("hypotheses", hypotheses, Hypotheses)
    directions = checks.array("directions", directions, ("d",))
    reach = checks.not_negative("reach", reach)
    off = np.abs(wrap_angle(hypotheses.mean[:, 1, None] - directions))
    chosen = (off <= reach).any(axis=1) | np.isin(hypotheses.identity, list(verified))
    return frozenset(hypotheses.identity[chosen].tolist()), chosen

"""One cue after the other: a sensor detects, another verifies, as the paper's forerunners do.

``Verifier(reach).step(state, hypotheses, directions) -> (state, VerificationInfo)``
"""

from collections.abc import Set
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import Hypotheses


@dataclass(frozen=True, eq=False, slots=True)
class VerificationInfo:
    """Diagnostics of one step of a verifier.

    Parameters
    ----------
    chosen : (n,)
        Which of the hypotheses are verified.
    """

    chosen: Bool[np.ndarray, " n"]


@dataclass(frozen=True, slots=True)
class Verifier:
    """Takes from a sensor that detects whom another one has seen, too.

    Parameters
    ----------
    reach
        Largest difference of their directions, rad.

    Raises
    ------
    ValueError
        If the reach is negative.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross (see `Detections`), section 1, on EXPO-ROBOTS and
    BIRON.
    """

    reach: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "reach", checks.not_negative("reach", self.reach))

    def start(self) -> frozenset[int]:
        """Return who has been verified at first: nobody."""
        return frozenset()

    def step(
        self,
        state: frozenset[int],
        hypotheses: Hypotheses,
        directions: Float[np.ndarray, " d"],
    ) -> tuple[frozenset[int], VerificationInfo]:
        r"""Return who has been verified by now, and which hypotheses these are.

        A hypothesis is verified by a direction :math:`\psi` with :math:`|\varphi - \psi| \le` the
        reach, and stays so for as long as its identity lives.

        Parameters
        ----------
        state
            Identities of those who were verified before.
        hypotheses
            Of the sensor that detects, n.
        directions : (d,)
            In which the other one has seen somebody since the last time, rad.

        Returns
        -------
        frozenset
            Identities; those of hypotheses that are gone are forgotten.
        VerificationInfo

        Raises
        ------
        ValueError
            If a direction is not finite.
        """
        checks.instance("state", state, Set)
        checks.instance("hypotheses", hypotheses, Hypotheses)
        directions = checks.array("directions", directions, ("d",))
        off = np.abs(wrap_angle(hypotheses.mean[:, 1, None] - directions))
        chosen = (off <= self.reach).any(axis=1) | np.isin(hypotheses.identity, list(state))
        return frozenset(hypotheses.identity[chosen].tolist()), VerificationInfo(chosen)

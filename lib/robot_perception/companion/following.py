r"""Control law of a robot with a narrow view that follows the person it tracks.

The camera looks ahead. With u the column of the person relative to the middle, f the focal length
in pixels, h the person's height in the picture and :math:`h^*` the height at the distance to keep,

.. math::
    \omega = -k_\omega \arctan(u / f), \qquad
    v = k_v \left( h^* / h - 1 \right)

both limited. A height is inversely proportional to the distance, so v is proportional to what the
distance is too large by. The paper says only that the robot coordinates its displacements with
those of the person, "even if only coarsely": the law is ours.
"""

import math
from dataclasses import dataclass
from typing import final

from robot_perception import checks
from robot_perception.fields import Positive, checked

__all__ = ["Follower"]


@final
@dataclass(frozen=True, slots=True)
class Follower:
    """A robot that follows.

    Parameters
    ----------
    focal
        Focal length, px.
    height
        Of the person in the picture at the distance to keep, px.
    turn_gain
        1/s.
    speed_gain
        m/s when the person is twice as far as it should be.
    most_turn
        Largest turn rate, rad/s.
    most_speed
        Largest speed, m/s; backwards a third of it.
    """

    focal: Positive
    height: Positive
    turn_gain: Positive = 2.5
    speed_gain: Positive = 2.0
    most_turn: Positive = 1.5
    most_speed: Positive = 1.2
    __post_init__ = checked

    def command(self, offset: float, height: float) -> tuple[float, float]:
        """Return speed (m/s) and turn rate (rad/s, to the left).

        Parameters
        ----------
        offset
            Column of the person less that of the middle of the picture, px.
        height
            Of the person, px.

        Raises
        ------
        ValueError
            If the offset is not finite or the height not positive.
        """
        offset = checks.number("offset", offset)
        height = checks.positive("height", height)
        turn = -self.turn_gain * math.atan2(offset, self.focal)
        speed = self.speed_gain * (self.height / height - 1)
        # who looks far to the side turns first: driving on would take the person out of view
        speed *= max(math.cos(2 * math.atan2(offset, self.focal)), 0.0)
        return (
            min(max(speed, -self.most_speed / 3), self.most_speed),
            min(max(turn, -self.most_turn), self.most_turn),
        )

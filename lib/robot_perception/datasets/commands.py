"""Commands of a robot, or what its wheels did: speeds and turn rates."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from jaxtyping import Float

from robot_perception.datasets import limits
from robot_perception.datasets.bags import Topics, check_topic, is_bag
from robot_perception.datasets.logs import ReadReport
from robot_perception.datasets.tables import read_rows
from robot_perception.fields import checked

LARGEST = {"time_s": np.inf, "speed_m_s": 50, "turn_rate_rad_s": 20}
"""The columns of a table of commands, and the largest numbers in them."""


@dataclass(frozen=True, eq=False, slots=True)
class Commands:
    """Velocities a robot logged, each held until the next.

    Parameters
    ----------
    times : (k,)
        s, never falling.
    velocities : (k, 2)
        Forward speed in m/s and turn rate in rad/s.
    report
        What became of all messages, if they come from a ROS bag.

    Raises
    ------
    TypeError
        If a field is of another type.
    ValueError
        If shapes disagree, a number is not finite, or the times fall.
    """

    times: Annotated[Float[np.ndarray, " k"], limits.in_order]
    velocities: Float[np.ndarray, "k 2"]
    report: ReadReport | None = None
    __post_init__ = checked


def read_commands(path: str | Path, *, time_unit: str = "s", topic: Topics = None) -> Commands:
    """Read the velocities of a robot from CSV, plain or gzip, or from a ROS bag.

    Parameters
    ----------
    path
        CSV with the columns ``time_s, speed_m_s, turn_rate_rad_s``, or a bag, as
        `read_bag_commands` reads it.
    time_unit
        What a table counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. Bags tell.
    topic
        Of a bag, where several would do.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, a column is missing, times are in another unit, a number is
        beyond 50 m/s or 20 rad/s, times fall, or a bag does not hold velocities.
    FileNotFoundError
        If there is no such file.
    """
    topic = check_topic(topic)
    if is_bag(path):
        from robot_perception.datasets.bag_motion import read_bag_commands  # which makes commands

        return read_bag_commands(path, topic)
    rows = read_rows(path, LARGEST, time_unit=time_unit)
    rows.check_order("time_s", "times")
    times, *velocities = rows.columns.values()
    return Commands(times, np.column_stack(velocities))

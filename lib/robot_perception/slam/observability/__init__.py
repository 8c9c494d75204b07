r"""Observability of the planar robot's state, by sensors.

The state is :math:`x = (t_x, t_y, \varphi, p_{1x}, p_{1y}, …)`. Three analyses stand side by side:

* :func:`fixed_point_matrix`: transition and measurement linearised at one point, as a linear
  system is analysed;
* :func:`trajectory_matrix`: each Jacobian at the state in which it acts;
* :func:`~robot_perception.slam.observability.symbolic.lie_matrix`: no linearisation of the motion.

They need not agree. :mod:`~robot_perception.slam.observability.symbolic` has all three in symbols.

References
----------
Andrade-Cetto, "Perception Issues in Mobile Robotics", eqs (24) to (27); Hermann and Krener,
"Nonlinear controllability and observability", 1977; Huang, Mourikis and Roumeliotis,
"Observability-based rules for designing consistent EKF SLAM estimators", 2010.
"""

from robot_perception.slam.observability.gauge import (
    gauge_directions,
    information_along,
    rotate,
    translate,
)
from robot_perception.slam.observability.numeric import (
    Analysis,
    analyse,
    fixed_point_matrix,
    trajectory_matrix,
)
from robot_perception.slam.observability.sensors import (
    CARTESIAN,
    RANGE_BEARING,
    Anchor,
    Heading,
    Landmarks,
    Position,
    StateSensor,
    see,
)

__all__ = [
    "CARTESIAN",
    "RANGE_BEARING",
    "Analysis",
    "Anchor",
    "Heading",
    "Landmarks",
    "Position",
    "StateSensor",
    "analyse",
    "fixed_point_matrix",
    "gauge_directions",
    "information_along",
    "rotate",
    "see",
    "trajectory_matrix",
    "translate",
]

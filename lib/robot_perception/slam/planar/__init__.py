"""Extended Kalman filter SLAM for a vehicle in the plane."""

from robot_perception.observations import Observations
from robot_perception.slam.planar.association import Association
from robot_perception.slam.planar.belief import MapBelief
from robot_perception.slam.planar.filtering import (
    Innovation,
    add_landmarks,
    correct,
    predict,
    update,
)
from robot_perception.slam.planar.motions import Odometry, Velocity, compound, dead_reckoning
from robot_perception.slam.planar.runs import Counts, History, Settings, Step, Truth, run_filter
from robot_perception.slam.planar.sensors import (
    CartesianSensor,
    Compass,
    PositionFix,
    RangeBearing,
)
from robot_perception.slam.planar.smoothing import Optimum, smooth

__all__ = [
    "Association",
    "CartesianSensor",
    "Compass",
    "Counts",
    "History",
    "Innovation",
    "MapBelief",
    "Observations",
    "Odometry",
    "Optimum",
    "PositionFix",
    "RangeBearing",
    "Settings",
    "Step",
    "Truth",
    "Velocity",
    "add_landmarks",
    "compound",
    "correct",
    "dead_reckoning",
    "predict",
    "run_filter",
    "smooth",
    "update",
]

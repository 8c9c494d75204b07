"""Extended Kalman filter SLAM for a vehicle in the plane."""

from robot_perception.slam.planar.association import Gated, Joint, Known
from robot_perception.slam.planar.belief import MapBelief
from robot_perception.slam.planar.filtering import (
    Innovation,
    add_landmarks,
    correct,
    predict,
    update,
)
from robot_perception.slam.planar.motions import Odometry, Velocity
from robot_perception.slam.planar.runs import Counts, History, Settings, Step, Truth, run_filter
from robot_perception.slam.planar.sensors import (
    CartesianSensor,
    Compass,
    PositionFix,
    RangeBearing,
    Scan,
)

__all__ = [
    "CartesianSensor",
    "Compass",
    "Counts",
    "Gated",
    "History",
    "Innovation",
    "Joint",
    "Known",
    "MapBelief",
    "Odometry",
    "PositionFix",
    "RangeBearing",
    "Scan",
    "Settings",
    "Step",
    "Truth",
    "Velocity",
    "add_landmarks",
    "correct",
    "predict",
    "run_filter",
    "update",
]

"""Valid calls of `kalman`."""

import numpy as np

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.kalman import Motion, Sensor
from tests.hostile.sweep import call

EYE = np.eye(2)
PRIOR, MOTION, SENSOR = Gaussian(np.ones(2), EYE), Motion(EYE, EYE, np.ones(2)), Sensor(EYE, EYE)

CALLS = {
    Motion: lambda: call(EYE, EYE, np.ones(2)),
    Sensor: lambda: call(EYE[:1], EYE[:1, :1]),
    kalman.predict: lambda: call(PRIOR, MOTION),
    kalman.update: lambda: call(PRIOR, np.ones(2), SENSOR),
    kalman.fisher_information: lambda: call(EYE, np.stack([EYE, EYE])),
    kalman.start_information: lambda: call([MOTION, MOTION], [SENSOR, SENSOR]),
    kalman.state_information: lambda: call([MOTION, MOTION], [SENSOR, SENSOR], EYE),
    kalman.steady_state: lambda: call(MOTION, SENSOR, tolerance=1e-13),
    kalman.scale_free_rank: lambda: call(EYE),
}

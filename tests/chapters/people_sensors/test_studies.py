"""Laws of what a sensor makes of people, on sessions written down by hand."""

import numpy as np

from robot_perception.chapters.people_sensors import witnesses
from robot_perception.chapters.people_sensors.sessions import SENSORS, Recording


def recording(polar, found, *, clear=True, sensor="laser"):
    """Return a session of one reading: people and detections at distances and directions."""
    polar, found = np.array(polar, float).reshape(-1, 2), np.array(found, float).reshape(-1, 2)
    p, one = len(polar), np.ones((1, len(polar)))
    return Recording(
        times=np.array([1.0]),
        sensors=np.array([SENSORS.index(sensor)]),
        poses=np.zeros((1, 3)),
        reckoned=np.zeros((1, 3)),
        counts=np.array([len(found)]),
        means=found,
        covs=np.tile(np.diag([0.01, 0.01]), (len(found), 1, 1)),
        judged=np.array([0]),
        polar=polar[None],
        present=one > 0,
        clear=np.broadcast_to(clear, (1, p)).copy(),
        beams=one.astype(int),
        cones=one.astype(int),
        side=0 * one,
        gaze=one,
        swing=0 * one,
        skirt=np.zeros(p, dtype=bool),
    )


def test_each_detection_is_one_persons():
    scene = recording([(2, 0), (2, 0.1)], [(2, 0.05), (4, 2)])
    seen = witnesses.answers([scene], "laser", "upright")
    assert seen.people.hit.sum() == 1
    assert (seen.readings.item(), seen.found.item(), seen.false.item()) == (1, 2, 1)


def test_a_camera_is_judged_by_direction_round_the_back():
    scene = recording([(2, 3.1)], [(4, -3.1)], sensor="camera")
    assert witnesses.answers([scene], "camera", "facing").people.hit.all()

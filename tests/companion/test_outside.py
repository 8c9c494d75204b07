"""What is told of a picture must lie in it: every tracker of people refuses a place outside."""

import numpy as np
import pytest

from robot_perception.arms.tracker import ArmTracker
from robot_perception.cameras import Pinhole
from robot_perception.companion.boxes import crop
from robot_perception.companion.faces.icondensation import FaceFilter
from robot_perception.companion.hands.windows import window_at
from robot_perception.companion.tutor import TutorTracker

WIDE, HIGH = 320, 240
IMAGE = np.random.default_rng(0).integers(0, 256, (HIGH, WIDE, 3)).astype(np.uint8)
ARMS = ArmTracker(Pinhole((400.0, 400.0), ((WIDE - 1) / 2, (HIGH - 1) / 2), (WIDE, HIGH)))


def rng():
    return np.random.default_rng(1)


TOLD = {
    "a face": lambda box: FaceFilter().start(IMAGE, box, rng=rng()),
    "a tutor": lambda box: TutorTracker().start(IMAGE, box, rng=rng()),
    "arms": lambda box: ARMS.start(IMAGE, rng=rng(), face=box, pose=np.zeros(8)),
    "a face to recognise": lambda box: crop(IMAGE[..., 0], box),
    "a hand": lambda box: window_at(IMAGE[..., 0], box),
}
INSIDE = np.array([130.0, 60, 40, 40])
PLACES = {
    "left": (-500, 60),
    "right": (WIDE + 1, 60),
    "above": (130, -500),
    "below": (130, HIGH + 1),
    "far": (1e5, 1e5),
}


@pytest.mark.parametrize("start", TOLD.values(), ids=TOLD)
def test_a_place_in_the_picture_is_taken(start):
    start(INSIDE)


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("start", TOLD.values(), ids=TOLD)
def test_a_place_outside_is_refused(start, place):
    with pytest.raises(ValueError, match=r"(box|face) must .*reach into the picture"):
        start(np.array([*place, 40.0, 40.0]))


def test_a_face_whose_hair_is_above_the_picture_is_one():
    state = FaceFilter().start(IMAGE, np.array([130.0, -10, 40, 40]), rng=rng())
    assert not state.reference[1].any()
    np.testing.assert_allclose(state.box, [130, -10, 40, 40], atol=3)


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_a_filter_sees_faces_in_the_picture_only(place):
    assert FaceFilter().sees(IMAGE, INSIDE)
    assert not FaceFilter().sees(IMAGE, np.array([*place, 40.0, 40.0]))

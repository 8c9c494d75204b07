"""The detector on a photograph with a face, in windows of it, and on what it cannot use."""

import pickle

import cv2
import numpy as np
import pytest
from skimage import data

from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.detection import FaceDetector
from tests.unchecked import unchecked


@pytest.fixture(scope="module")
def portrait():
    return cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2GRAY)


DETECTOR = FaceDetector()
FACE = np.array([[170.0, 65, 110, 110]])


def test_a_face_is_found_as_opencv_finds_it(portrait):
    found = DETECTOR.find(portrait)
    assert overlap(found[:1], FACE)[0, 0] > 0.6
    theirs = cv2.CascadeClassifier(
        cv2.data.haarcascades + "haarcascade_frontalface_default.xml"
    ).detectMultiScale(portrait, 1.1, 4, minSize=(24, 24))
    assert {tuple(box) for box in found.astype(int).tolist()} == {tuple(b) for b in theirs.tolist()}


def test_boxes_stand_by_size(portrait):
    both = np.hstack([portrait, cv2.resize(portrait, (256, 512))[:, :256]])
    widths = FaceDetector(neighbours=1).find(both)[:, 2]
    assert (np.diff(widths) <= 0).all()


def test_a_window_gives_places_in_the_whole_picture(portrait):
    box = DETECTOR.find(portrait)[0]
    window = np.array([box[0] - 30.5, box[1] - 40.25, box[2] + 60, box[3] + 80])
    found = DETECTOR.find(portrait, window)
    assert overlap(found[:1], box[None])[0, 0] > 0.75
    assert DETECTOR.find(portrait, np.array([0.0, 300, 100, 100])).shape == (0, 4)


def test_a_window_is_cut_at_the_border(portrait):
    window = np.array([-100.0, -100, 500, 400])
    np.testing.assert_array_equal(
        DETECTOR.find(portrait, window), DETECTOR.find(portrait[:300, :400])
    )


def test_no_face_is_found_where_there_is_none_or_no_room_for_one(portrait):
    assert DETECTOR.find(np.zeros((200, 200), np.uint8)).shape == (0, 4)
    assert DETECTOR.find(portrait[:20, :20]).shape == (0, 4)
    assert DETECTOR.find(portrait, np.array([600.0, 600, 50, 50])).shape == (0, 4)
    assert FaceDetector(least=200).find(portrait).shape == (0, 4)
    assert (FaceDetector(neighbours=1, most=60).find(portrait)[:, 2] <= 60).all()


def test_only_sides_that_are_asked_for_are_found(portrait):
    side = float(DETECTOR.find(portrait)[0, 2])
    near = DETECTOR.find(portrait, sides=(0.8 * side, 1.2 * side))
    assert abs(near[0, 2] - side) < 0.2 * side
    assert not len(DETECTOR.find(portrait, sides=(1.6 * side, 3 * side)))
    with pytest.raises(ValueError, match="sides must rise"):
        DETECTOR.find(portrait, sides=(90.0, 40.0))


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (lambda p: FaceDetector(scale=1.0), ValueError, "scale must be above 1"),
        (lambda p: FaceDetector(least=20), ValueError, "least must be"),
        (lambda p: FaceDetector(least=90, most=60), ValueError, "least must be"),
        (lambda p: DETECTOR.find(np.dstack([p] * 3)), ValueError, "made grey first"),
        (lambda p: DETECTOR.find(p.astype(float)), TypeError, "image must be a picture of bytes"),
        (lambda p: DETECTOR.find(p, np.array([0.0, 0, 0, 9])), ValueError, "window must have"),
    ],
)
def test_what_is_wrong_is_named(portrait, wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong(portrait)


def test_a_picture_that_is_enlarged_shows_smaller_faces_in_their_places(portrait):
    small = cv2.resize(portrait, None, fx=0.16, fy=0.16, interpolation=cv2.INTER_AREA)
    assert not len(DETECTOR.find(small))  # the face is 18 px wide
    found = FaceDetector(least=12, enlarge=2).find(small)
    assert overlap(found[:1], 0.16 * FACE)[0, 0] > 0.6
    large = cv2.resize(portrait, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    np.testing.assert_array_equal(
        FaceDetector(least=50, most=200, enlarge=2).find(portrait),
        FaceDetector(least=100, most=400).find(large) / 2,
    )
    window = np.array([150.0, 40, 150, 160])
    near = FaceDetector(enlarge=2).find(portrait, window)
    assert overlap(near[:1], FACE)[0, 0] > 0.6


def test_a_detector_can_be_sent_to_another_process(portrait):
    own = FaceDetector(scale=1.3, neighbours=2, least=40, most=200)
    sent = pickle.loads(pickle.dumps(own))
    np.testing.assert_array_equal(sent.find(portrait), own.find(portrait))
    assert (sent.scale, sent.neighbours, sent.least, sent.most) == (1.3, 2, 40, 200)

"""The tutor: his face in a window, an open hand, and patches of colour that are followed."""

import cv2
import numpy as np

from data_synth.companion.face_films import FaceScene, film_faces
from data_synth.companion.walks import WalkScene, film_walk
from robot_perception.chapters.tutor_following.training import stored
from robot_perception.companion.boxes import overlap
from robot_perception.companion.cues import (
    patch_histograms,
    patch_histograms_textbook,
    patch_points,
)
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.region import FaceTracker
from robot_perception.companion.hands.cascade import HandDetector
from robot_perception.companion.tutor import PATCHES, TutorTracker
from tests.tools.benchmarks.harness import Row

PICTURES = 40
LEAST_HANDS, LEAST_TUTOR = 10.0, 30.0
"""Pictures a second, at least."""


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern the tutor."""
    face = film_faces(np.random.default_rng(3), PICTURES, FaceScene(glances=0.0))
    greys = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in face.frames]
    walk = film_walk(np.random.default_rng(4), PICTURES, WalkScene("none"))
    detector, tracker = FaceDetector(), TutorTracker()
    hands = HandDetector(stored().cascade)
    states = np.random.default_rng(5).normal([160, 120, 0, 110], [30, 20, 0.05, 8], (200, 4))

    def windowed() -> list:
        follower, found = FaceTracker(detector), []
        state = follower.start()
        for grey in greys:
            state, _ = follower.step(state, grey)
            found.append(state.box)
        return found

    def whole() -> list:
        return [detector.find(grey) for grey in greys]

    def same_face() -> None:
        pairs = zip(windowed(), face.boxes[:, 0], strict=True)
        near = [
            box is not None and overlap(box[None], true[None])[0, 0] > 0.4 for box, true in pairs
        ]
        assert np.mean(near) > 0.9

    def followed() -> np.ndarray:
        rng = np.random.default_rng(6)
        state = tracker.start(walk.frames[0], walk.boxes[0], rng=rng)
        for image in walk.frames[1:]:
            state, _ = tracker.step(state, image, rng=rng)
        return state.box

    def same_person() -> None:
        assert overlap(followed()[None], walk.boxes[-1:])[0, 0] > 0.4

    def same_colours() -> None:
        functions = patch_histograms, patch_histograms_textbook
        points = patch_points(states, PATCHES)
        both = [function(walk.frames[0], points) for function in functions]
        np.testing.assert_allclose(both[0][0], both[1][0])

    return [
        Row(
            work=f"tutor face in the window of a filter, {PICTURES} images of 320 × 240",
            ours=windowed,
            peer=whole,
            peer_name="whole images",
            ratio=3.0,
            agree=same_face,
            repeats=3,
        ),
        Row(
            work="tutor hand, open, in an image of 320 × 240",
            ours=lambda: hands.find(greys[0]),
            at_most=1 / LEAST_HANDS,
        ),
        Row(
            work=f"tutor followed, 200 particles, {PICTURES - 1} images of 320 × 240",
            ours=followed,
            at_most=(PICTURES - 1) / LEAST_TUTOR,
            agree=same_person,
            repeats=3,
        ),
        Row(
            work="tutor patches, four, for 200 particles",
            ours=lambda: patch_histograms(walk.frames[0], patch_points(states, PATCHES)),
            peer=lambda: patch_histograms_textbook(walk.frames[0], patch_points(states, PATCHES)),
            peer_name="as written",
            ratio=20.0,
            agree=same_colours,
        ),
    ]

"""The motion of a stereo camera is found though some features are matched with others."""

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.geometry import se3
from robot_perception.landmarks import (
    Features,
    Sighting,
    StereoPoints,
    Tracks,
    extend,
    stereo_motion,
)
from tests.landmarks.worlds import features

CAMERA = Pinhole((300.0, 300.0), (159.5, 119.5), (320, 240))
RIG = StereoRig(CAMERA, 0.2)
MOTION = se3.exp(np.array([0.02, -0.01, -0.3, 0.01, 0.05, -0.02]))


def sighting(points: np.ndarray, found: Features, tracks: Tracks) -> Sighting:
    measured = np.zeros((len(points), 3))
    covs = np.tile(np.eye(3), (len(points), 1, 1))
    both = StereoPoints(found, measured, Gaussian(points, covs), (len(points), len(points)))
    return Sighting(both, tracks)


def pairs(count: int, wrong: int = 0, noise: float = 0.0) -> tuple[Sighting, Sighting]:
    """Return two sightings of points before and after a motion, some of which go on as others."""
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-1, 1, (count, 2)), rng.uniform(3, 9, count)])
    moved = se3.act(MOTION, points)
    pixels = CAMERA.project(moved) + noise * rng.standard_normal((count, 2))
    pixels[:wrong] += rng.uniform(15, 40, (wrong, 2))
    turned = np.arange(count)[::-1]  # the later pair has them in another order, after a new one
    before = features(CAMERA.project(points), np.arange(count))
    after = features(np.vstack([[5.0, 5.0], pixels[turned]]), np.r_[count, turned])
    tracks = Tracks.start(before)
    now = extend(tracks, before, after, predicted=pixels)
    later = np.vstack([[0, 0, 9.0], moved[turned]])
    return sighting(points, before, tracks), sighting(later, after, now)


@pytest.mark.parametrize("wrong", [0, 12])
def test_the_motion_is_that_of_the_camera(wrong):
    found = stereo_motion(*pairs(40, wrong), CAMERA)
    np.testing.assert_allclose(found.T_now_before, MOTION, atol=1e-5)
    assert found.used.tolist() == [False] + [True] * (40 - wrong) + [False] * wrong


def test_noise_of_pixels_does_little_harm():
    found = stereo_motion(*pairs(200, 20, noise=0.3), CAMERA)
    np.testing.assert_allclose(found.T_now_before, MOTION, atol=0.01)


def test_too_few_points_tell_nothing():
    assert stereo_motion(*pairs(5), CAMERA) is None
    assert stereo_motion(*pairs(6), CAMERA) is not None


def test_a_pair_must_follow_the_other():
    before, now = pairs(20)
    with pytest.raises(ValueError, match="now must follow before, which has 6 points"):
        stereo_motion(pairs(6)[0], now, CAMERA)
    with pytest.raises(ValueError, match="reach_px must be positive"):
        stereo_motion(before, now, CAMERA, reach_px=0.0)

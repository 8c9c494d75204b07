"""Posts along a loop, and what is seen of them."""

import numpy as np
import pytest
import shapely
from scipy import stats

from data_synth.building import drive
from data_synth.posts import glimpse, make_posts


@pytest.mark.parametrize("length", [18.0, 30.0, 90.0, 150.0])
def test_posts_stand_one_to_two_metres_from_a_loop_of_the_length(length):
    posts = make_posts(length, rng=np.random.default_rng(0))
    ring = shapely.LinearRing(posts.loop)
    assert ring.length == pytest.approx(length)
    side = length / 3  # the drive starts 6 m behind the corner, or in the middle of a short side
    np.testing.assert_allclose(posts.loop[:2, 0], -min(6.0, side / 2) + np.array([0, side]))
    gaps = shapely.distance(ring, shapely.points(posts.landmarks))
    assert (gaps <= 2.0 + 1e-9).all()
    from_corners = shapely.distance(shapely.MultiPoint(posts.loop), shapely.points(posts.landmarks))
    straight_on = from_corners > np.hypot(2.0, 2.0)
    assert (gaps[straight_on] >= 1.0 - 1e-9).all()
    inside = shapely.contains(shapely.Polygon(posts.loop), shapely.points(posts.landmarks))
    np.testing.assert_array_equal(inside, np.arange(len(gaps)) % 2 == 0)  # either side in turn
    along = np.array([ring.project(shapely.Point(p)) for p in posts.landmarks])
    straight = np.abs(np.diff(np.sort(along)) - 3.0) < 1e-6  # not those near a corner
    assert straight.mean() > 0.5 or length < 60
    poses = drive(posts, step=0.2, beyond=2.0)
    np.testing.assert_allclose(poses[0], 0, atol=1e-12)
    assert ring.distance(shapely.points(poses[:, :2])).max() < 0.42  # arcs cut the corners


def test_a_loop_too_short_is_named():
    with pytest.raises(ValueError, match=r"17\.0"):
        make_posts(17.0, rng=np.random.default_rng(0))


def test_glimpse_gives_the_place_in_the_robots_frame_of_what_is_ahead_and_near():
    rng = np.random.default_rng(1)
    landmarks, poses = rng.uniform(-9, 9, (40, 2)), rng.uniform(-4, 4, (25, 3))
    seen = glimpse(landmarks, poses, sigma=0.0, reach=6.0, rng=rng)
    for pose, (ids, at) in zip(poses, seen, strict=True):
        place = (landmarks - pose[:2]) @ [1, 1j] * np.exp(-1j * pose[2])
        np.testing.assert_allclose(at @ [1, 1j], place[ids])
        expected = (np.abs(place) < 6.0) & (np.abs(np.angle(place)) < np.pi / 2)
        np.testing.assert_array_equal(ids, np.flatnonzero(expected))


def test_noise_has_the_stated_deviation():
    landmarks, poses = np.array([[2.0, 1.0]]), np.zeros((2000, 3))
    seen = glimpse(landmarks, poses, sigma=0.1, reach=6.0, rng=np.random.default_rng(0))
    error = np.concatenate([at for _, at in seen]) - landmarks
    assert abs(np.corrcoef(error.T)[0, 1]) < 4.5 / np.sqrt(len(error))
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], error.size) / error.size
    assert low < (error**2).mean() / 0.01 < high

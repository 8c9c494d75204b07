"""Stereo matches and points: against all distances at once, a rendered wall, and a real pair."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception import datasets
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.landmarks import (
    StereoRules,
    detect,
    match_stereo,
    observe,
    require_rectified,
    textbook,
)
from tests.landmarks.worlds import COLUMNS, ROWS, features, shifted, texture
from tests.unchecked import unchecked

RIG = StereoRig(Pinhole((300.0, 280.0), (159.5, 119.5), (COLUMNS, ROWS)), 0.12)


def recording(name):
    found = datasets.find(name)
    if found is None:
        pytest.skip(f"the recording {name} is not on this computer")
    return found


@given(
    st.integers(0, 40),
    st.integers(0, 40),
    st.integers(1, 6),
    st.floats(0.5, 8),
    st.floats(20, 600),
    st.integers(0, 99),
)
@settings(max_examples=60)
def test_matches_are_those_of_all_distances_at_once(n, m, kinds, rows, threshold, seed):
    """Few kinds of descriptors with noise, so that most have rivals in the window."""
    rng = np.random.default_rng(seed)
    left, right = (
        features(rng.uniform(0, 40, (k, 2)), rng.integers(kinds, size=k), seed + k, noise=30.0)
        for k in (n, m)
    )
    rules = StereoRules(rows, threshold, (1.0, 25.0))
    pairs = match_stereo(left, right, rules)
    np.testing.assert_array_equal(pairs, textbook.match_stereo(left, right, rules))
    assert len(set(pairs[:, 0].tolist())) == len(set(pairs[:, 1].tolist())) == len(pairs)


def test_the_window_takes_its_edges_in():
    left = features([[50, 50]], [0])
    rules = StereoRules(2.0, 100.0, (1.0, 10.0))
    for u, v, matched in [
        (45, 52, True),
        (45, 48, True),
        (45, 52.1, False),
        (45, 47.9, False),
        (49, 50, True),
        (49.5, 50, False),
        (51, 50, False),
        (40, 50, True),
        (39.9, 50, False),
    ]:
        assert len(match_stereo(left, features([[u, v]], [0]), rules)) == matched


def test_a_descriptor_at_the_threshold_is_a_match():
    left, right = features([[50, 50]], [0]), features([[45, 50]], [1])
    apart = float(np.linalg.norm(left.descriptors - right.descriptors))
    assert len(match_stereo(left, right, StereoRules(threshold=apart * (1 + 1e-6)))) == 1
    assert len(match_stereo(left, right, StereoRules(threshold=apart * (1 - 1e-6)))) == 0


def test_the_nearest_must_be_nearest_both_ways():
    """The left two are alike; the right one goes to the more alike, and the other stays alone."""
    left = features([[50, 50], [60, 50]], [0, 0], seed=1, noise=20.0)
    right = left[np.array([1])]
    right = features(right.pixels - [20, 0], [0], seed=2)
    distances = np.linalg.norm(left.descriptors - right.descriptors, axis=1)
    pairs = match_stereo(left, right, StereoRules(threshold=400.0))
    np.testing.assert_array_equal(pairs, [[distances.argmin(), 0]])


@pytest.mark.parametrize("disparity", [4.0, 9.6, 23.3])
def test_points_of_a_wall_lie_on_it(disparity):
    """A wall square to the view: one depth f b / d; the row's noise is that of a mean of two."""
    left = texture(0)
    seen = observe(left, shifted(left, -disparity), RIG, sigma_px=0.3)
    depth = 300 * 0.12 / disparity
    good = np.abs(seen.measurements[:, 0] - seen.measurements[:, 2] - disparity) < 1
    assert good.mean() > 0.95
    assert len(seen) > 0.6 * seen.found[0]
    z = seen.points.mean[good, 2]
    np.testing.assert_allclose(np.median(z), depth, rtol=0.01)
    sigma = np.sqrt(seen.points.cov[good, 2, 2])
    np.testing.assert_allclose(sigma, z**2 / (300 * 0.12) * 0.3 * np.sqrt(2), rtol=1e-9)
    back = RIG.project(seen.points.mean)
    np.testing.assert_allclose(back, seen.measurements, atol=1e-9)
    np.testing.assert_allclose(seen.measurements[good, 1], seen.features.pixels[good, 1], atol=1)
    y, far = seen.points.mean[:, 1], seen.points.mean[:, 2]
    by_row = (far / 280 * 0.3) ** 2 / 2  # of the mean of two rows
    by_depth = (y / far) ** 2 * seen.points.cov[:, 2, 2]
    np.testing.assert_allclose(seen.points.cov[:, 1, 1], by_row + by_depth, rtol=1e-9)


def test_the_row_of_a_point_is_the_mean_of_two():
    image = texture(1)
    lower = observe(image, shifted(image, -8.0, 1.0), RIG)
    level = lower.features.pixels[:, 1]
    np.testing.assert_allclose(np.median(lower.measurements[:, 1] - level), 0.5, atol=0.05)


def test_blank_walls_give_no_points():
    blank = np.full((ROWS, COLUMNS), 90, np.uint8)
    for pair in ((blank, blank), (texture(2), blank), (blank, texture(2))):
        seen = observe(*pair, RIG)
        assert len(seen) == 0
        assert seen.points.mean.shape == (0, 3)
        assert seen.points.cov.shape == (0, 3, 3)
    assert seen.found[0] == 0 < seen.found[1]


def test_pictures_that_do_not_fit_the_rig_are_named():
    good = texture(3)
    with unchecked():
        with pytest.raises(ValueError, match=r"right must be \(240, 320\) for the rig, got \(240,"):
            observe(good, good[:, :300].copy(), RIG)
        with pytest.raises(ValueError, match=r"left must be \(240, 320\) for the rig, got \(320,"):
            observe(np.ascontiguousarray(good.T), good, RIG)
        with pytest.raises(TypeError, match=r"right must be a picture of bytes .* got float32"):
            observe(good, good.astype(np.float32), RIG)
        with pytest.raises(ValueError, match=r"left must be grey, \(height, width\), got .* 3\)"):
            observe(cv2.merge([good] * 3), good, RIG)
        with pytest.raises(TypeError, match="rig must be a StereoRig, got None"):
            observe(good, good, None)
        with pytest.raises(ValueError, match="disparities must be positive and rise"):
            StereoRules(disparities=(5.0, 1.0))
        short = features([[1, 2]], [0])
        short = type(short)(short.pixels, short.descriptors[:, :64], short.scales, short.angles)
        with pytest.raises(ValueError, match="descriptors of right must have 64 numbers as left"):
            match_stereo(short, features([[1, 2]], [0]))


def test_a_pair_that_is_not_rectified_is_told_by_its_rows():
    image = texture(4)
    left = detect(image)
    require_rectified(left, detect(shifted(image, -9.0, 1.5)))
    with pytest.raises(
        ValueError, match=r"not a rectified pair: .* median offset is 6\.[0-9] rows"
    ):
        require_rectified(left, detect(shifted(image, -9.0, 6.5)))
    with pytest.raises(ValueError, match="left and right have 0 matches by descriptor, at least"):
        require_rectified(left, left[:0])


@pytest.mark.parametrize(("level", "good"), [(7, True), (6, False)])
def test_more_than_half_of_the_matches_must_be_level(level, good):
    left = features(np.arange(24).reshape(12, 2) * 10 + 20, np.arange(12))
    offsets = np.where(np.arange(12) < level, 2.0, 2.1)
    right = features(left.pixels + np.stack([np.full(12, -9.0), offsets], axis=1), np.arange(12))
    if good:
        require_rectified(left, right)
        with pytest.raises(ValueError, match="12 matches by descriptor, at least 13 must tell"):
            require_rectified(left, right, least=13)
    else:
        with pytest.raises(ValueError, match="of 12 matches by descriptor 6 lie within 2 rows"):
            require_rectified(left, right)


@pytest.mark.parametrize("shift", [-25.0, -6.0, -1.2])
def test_swapped_eyes_are_noticed(shift):
    image = texture(4)
    left, right = detect(image), detect(shifted(image, shift, 0.0))
    require_rectified(left, right)
    with pytest.raises(
        ValueError, match=r"left and right seem to be swapped: of .* further to the"
    ):
        require_rectified(right, left)


@pytest.mark.parametrize(("behind", "good"), [(6, True), (7, False)])
def test_more_points_must_lie_before_the_eyes_than_behind_them(behind, good):
    left = features(np.arange(28).reshape(14, 2) * 10 + 20, np.arange(14))
    shifts = np.where(np.arange(14) < behind, 9.0, -9.0)
    shifts[-2:] = 0.9  # as far away as may be: of no side
    right = features(left.pixels + np.stack([shifts, np.zeros(14)], axis=1), np.arange(14))
    if good:
        require_rectified(left, right)
    else:
        with pytest.raises(ValueError, match=r"of 14 matches on equal rows 7 lie further .*, 5 fu"):
            require_rectified(left, right)


# ---- real pairs ----------------------------------------------------------------------------------


def test_matches_of_the_aloe_have_its_disparity():
    """At a third of the size: 320 px are what the paper had, and OpenCV finds 2000 features."""
    pair = datasets.read_depth_pair(recording("image_pairs"))
    scale = 3
    small = [
        cv2.resize(image, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA)
        for image in (pair.left, pair.right)
    ]
    left, right = map(detect, small)
    require_rectified(left, right)
    pairs = match_stereo(left, right)
    places = (left.pixels[pairs[:, 0]] + 0.5) * scale - 0.5  # of pixels' centres
    disparity = scale * (left.pixels[pairs[:, 0], 0] - right.pixels[pairs[:, 1], 0])
    u, v = np.rint(places).astype(int).T
    known = pair.known[v, u]
    error = np.abs(disparity - pair.disparity[v, u])[known] / scale
    assert known.sum() > 700
    assert (error < 1).mean() > 0.95
    assert np.median(error) < 0.2
    strict = match_stereo(left, right, StereoRules(threshold=100.0))
    assert set(map(tuple, strict.tolist())) <= set(map(tuple, pairs.tolist()))


def test_matches_of_graffiti_obey_its_homography():
    """A wall from two sides, some 40° apart: most of the nearest that are sure are right."""
    from robot_perception.geometry import homographies
    from robot_perception.landmarks.association import Euclidean

    pair = datasets.read_plane_pair(recording("image_pairs"))
    first, second = detect(pair.first), detect(pair.second)
    nearest = Euclidean(second.descriptors).two_nearest(first.descriptors)
    far = np.linalg.norm(
        homographies.apply(pair.homography, first.pixels) - second.pixels[nearest.classes[:, 0]],
        axis=1,
    )
    sure = nearest.within(np.inf, ratio=0.7) >= 0
    assert sure.sum() > 200
    assert (far[sure] < 3).mean() > 0.6
    assert (far[~sure] < 3).mean() < 0.5 * (far[sure] < 3).mean()


def test_kitti_pairs_give_points_that_move_with_the_camera():
    """Points of one frame, moved by the true motion, lie where the next frame sees them."""
    from robot_perception.geometry import se3
    from robot_perception.landmarks import Tracks, extend, predict_pixels

    drive = datasets.read_kitti(recording("kitti_stereo_straight"))
    rig = drive.calibration.rig(drive.frames.size)
    left, right = drive.frames[0]
    require_rectified(detect(left), detect(right))
    with pytest.raises(ValueError, match="swapped"):
        require_rectified(detect(right), detect(left))
    before, after = (observe(*drive.frames[k], rig) for k in (0, 1))
    motion = se3.between(drive.poses[1], drive.poses[0])
    predicted = predict_pixels(before.points.mean, motion, rig.camera)
    tracks = extend(
        Tracks.start(before.features), before.features, after.features, predicted=predicted
    )
    goes_on = tracks.origins >= 0
    moved = se3.act(motion, before.points.mean)[tracks.origins[goes_on]]
    near = moved[:, 2] < 20
    apart = np.linalg.norm(moved - after.points.mean[goes_on], axis=1)[near]
    assert goes_on.sum() > 300
    assert np.median(apart) < 0.15


def test_a_camera_that_is_not_rectified_is_refused():
    folder = recording("euroc_static_stereo")
    left, right = (datasets.read_images(folder / side)[0] for side in ("cam0", "cam1"))
    with pytest.raises(ValueError, match="not a rectified pair"):
        require_rectified(detect(left), detect(right))

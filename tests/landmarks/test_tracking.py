"""Tracks: who goes on, who begins, what is stable; on features made by hand and on pictures."""

from itertools import pairwise

import numpy as np
import pytest

from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.landmarks import (
    DescriptorClasses,
    Missed,
    TrackRules,
    Tracks,
    detect,
    extend,
    follow,
    observe,
    predict_pixels,
    sight,
)
from tests.landmarks.worlds import features, shifted, texture
from tests.unchecked import unchecked

CAMERA = Pinhole((300.0, 280.0), (159.5, 119.5), (320, 240))


def frames():
    """Three frames by hand: kind 0 stays, 1 is missed once, 2 leaves, 3 and 4 come."""
    return [
        features([[10, 10], [50, 10], [90, 10]], [0, 1, 2], seed=1, noise=3),
        features([[12, 10], [92, 11], [130, 90]], [0, 2, 3], seed=2, noise=3),
        features([[130, 92], [14, 11], [52, 10], [60, 60]], [3, 0, 1, 4], seed=3, noise=3),
    ]


def test_tracks_go_on_end_and_begin():
    first, second, third = frames()
    tracks = Tracks.start(first)
    np.testing.assert_array_equal(tracks.ids, [0, 1, 2])
    np.testing.assert_array_equal(tracks.origins, [-1, -1, -1])
    tracks = extend(tracks, first, second)
    np.testing.assert_array_equal(tracks.ids, [0, 2, 3])
    np.testing.assert_array_equal(tracks.origins, [0, 2, -1])
    np.testing.assert_array_equal(tracks.classes.counts, [2, 2, 1])
    tracks = extend(tracks, second, third)
    np.testing.assert_array_equal(tracks.ids, [3, 0, 4, 5])  # the third kind 1 is a new track
    np.testing.assert_array_equal(tracks.origins, [2, 0, -1, -1])
    np.testing.assert_array_equal(tracks.classes.counts, [2, 3, 1, 1])
    assert tracks.begun == 6
    assert len(tracks) == 4
    seen = np.stack([first.descriptors[0], second.descriptors[0], third.descriptors[1]])
    np.testing.assert_allclose(tracks.classes.means[1], seen.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(
        tracks.classes.squares[1], 3 * seen.astype(float).var(axis=0), rtol=1e-6, atol=1e-6
    )
    np.testing.assert_array_equal(tracks.classes.means[3], third.descriptors[3])


def test_stable_is_more_than_five_frames():
    classes = DescriptorClasses(np.ones((3, 2)), np.zeros((3, 2)), np.array([4, 5, 6]))
    tracks = Tracks(np.arange(3), np.arange(3), classes, 3)
    np.testing.assert_array_equal(tracks.stable(), [False, False, True])
    np.testing.assert_array_equal(tracks.stable(4), [False, True, True])


def test_followed_tracks_are_those_of_the_frames():
    sequence = frames()
    tracks = follow(sequence)
    assert [(t.number, t.begin, t.rows.tolist()) for t in tracks] == [
        (0, 0, [0, 0, 1]),
        (1, 0, [1]),
        (2, 0, [2, 1]),
        (3, 1, [2, 0]),
        (4, 2, [2]),
        (5, 2, [3]),
    ]
    assert [len(track) for track in tracks] == [3, 1, 2, 2, 1, 1]
    for track in tracks:
        for k, row in enumerate(track.rows):
            frame = sequence[track.begin + k]
            np.testing.assert_array_equal(track.features.pixels[k], frame.pixels[row])
            np.testing.assert_array_equal(track.features.descriptors[k], frame.descriptors[row])


def test_followed_tracks_have_the_classes_of_their_descriptors():
    image = texture(0)
    sequence = [detect(shifted(image, 1.3 * k, 0.7 * k)) for k in range(4)]
    tracks = Tracks.start(sequence[0])
    for before, after in pairwise(sequence):
        tracks = extend(tracks, before, after)
    by_number = {track.number: track for track in follow(iter(sequence))}
    long = np.flatnonzero(tracks.stable(3))
    assert len(long) > 50
    for row in long[:20]:
        found = by_number[int(tracks.ids[row])].features.descriptors.astype(float)
        np.testing.assert_allclose(tracks.classes.means[row], found.mean(axis=0), atol=1e-9)
    moved = [np.diff(by_number[int(tracks.ids[row])].features.pixels, axis=0) for row in long]
    np.testing.assert_allclose(np.median(moved, axis=(0, 1)), [1.3, 0.7], atol=0.05)


def test_the_window_lies_about_the_predicted_place():
    before, after = features([[50, 50]], [0]), features([[80, 50]], [0])
    start = Tracks.start(before)
    assert extend(start, before, after).origins[0] == -1
    for u, v, found in [(92, 50, 0), (68, 62, 0), (92.1, 50, -1), (80, 37.9, -1)]:
        predicted = np.array([[u, v]], dtype=float)
        assert extend(start, before, after, predicted=predicted).origins[0] == found
    wide = TrackRules(window=30.0)
    assert extend(start, before, after, wide).origins[0] == 0
    nowhere = np.full((1, 2), np.inf)
    assert extend(start, before, after, wide, predicted=nowhere).origins[0] == -1


def test_a_large_turn_is_followed_only_where_it_is_predicted():
    image = texture(1, (420, 240))
    left, right = image[:, :320].copy(), image[:, 60:380].copy()
    sequence = [detect(left), detect(right)]
    predicted = sequence[0].pixels - [60.0, 0.0]
    shares = []
    for predictions in ((), [predicted]):
        tracks = follow(sequence, predictions=predictions)
        shares.append(np.mean([len(track) == 2 for track in tracks]))
    assert shares[0] < 0.02
    assert shares[1] > 0.3


def test_a_descriptor_beyond_the_threshold_begins_a_track():
    before, after = features([[50, 50]], [0]), features([[50, 50]], [0], seed=5, noise=10)
    apart = float(np.linalg.norm(before.descriptors - after.descriptors))
    start = Tracks.start(before)
    assert extend(start, before, after, TrackRules(threshold=apart + 0.1)).ids[0] == 0
    assert extend(start, before, after, TrackRules(threshold=apart - 0.1)).ids[0] == 1


def test_points_are_expected_where_the_moved_camera_projects_them():
    points = np.array([[0.0, 0.0, 4.0], [1.0, 0.5, 3.0], [0.0, 0.0, 0.5]])
    at_rest = predict_pixels(points, np.eye(4), CAMERA)
    np.testing.assert_allclose(at_rest, CAMERA.project(points))
    ahead = np.eye(4)
    ahead[2, 3] = -1.0  # the camera has gone one metre forward
    pixels = predict_pixels(points, ahead, CAMERA)
    np.testing.assert_allclose(pixels[:2], CAMERA.project(points[:2] - [0, 0, 1]))
    np.testing.assert_array_equal(pixels[2], [np.inf, np.inf])


def test_frames_without_features():
    none, some = features(np.empty((0, 2)), []), features([[1, 2]], [0])
    tracks = follow([none, some, none, none, some, some])
    assert [(track.begin, len(track)) for track in tracks] == [(1, 1), (4, 2)]
    assert follow([]) == []
    assert extend(Tracks.start(none), none, none).begun == 0


def test_wrong_arguments_are_named():
    first, second, _ = frames()
    with unchecked():
        with pytest.raises(ValueError, match="tracks must be of the 3 features of before, got 1"):
            extend(Tracks.start(first[:1]), first, second)
        with pytest.raises(ValueError, match=r"predicted must be \(3, 2\) for 3 features"):
            extend(Tracks.start(first), first, second, predicted=np.ones((2, 2)))
        with pytest.raises(ValueError, match="predicted must be numbers, got 6 NaN"):
            extend(Tracks.start(first), first, second, predicted=np.full((3, 2), np.nan))
        with pytest.raises(ValueError, match=r"predictions\[0\] must be \(3, 2\)"):
            follow([first, second], predictions=[np.ones((1, 2))])
        with pytest.raises(TypeError, match=r"frames\[1\] must be a Features, got None"):
            follow([first, None])
        with pytest.raises(ValueError, match="T_now_before must hold rotations"):
            predict_pixels(np.ones((1, 3)), np.diag([2.0, 2, 2, 1]), CAMERA)
        with pytest.raises(TypeError, match="camera must be a Pinhole"):
            predict_pixels(np.ones((1, 3)), np.eye(4), None)


def test_a_track_that_is_missed_is_looked_for_where_its_point_should_be():
    """The cameras go aside three times, and see nothing twice; a track has two frames at most."""
    rig, left = StereoRig(CAMERA, 0.2), texture(3)  # a wall 3 m away
    nothing = np.full_like(left, 128)
    aside = np.eye(4)
    aside[0, 3] = -0.12  # of the wall, to the left: by 12 px a pair
    pairs = [(left, shifted(left, -20.0)), *[(nothing, nothing)] * 2]
    third = shifted(left, -36.0)
    pairs.append((third, shifted(third, -20.0)))

    def followed(patience):
        found = None
        for pair in pairs:
            found = sight(found, *pair, rig, aside, patience=patience)
            yield found

    with unchecked():
        patient, hasty = list(followed(2)), list(followed(1))
    first, once, twice, last = patient
    assert len(first.tracks) == len(once.missed) == len(twice.missed) > 50
    assert (once.missed.frames == 1).all()
    assert (twice.missed.frames == 2).all()
    np.testing.assert_allclose(
        twice.missed.points - first.points.points.mean,
        np.tile([-0.24, 0, 0], (len(twice.missed), 1)),
    )
    again = last.tracks.ids < len(first.tracks)
    assert again.mean() > 0.5
    assert (last.tracks.classes.counts[again] == 2).all()
    assert (last.tracks.origins == -1).all()  # the pair before showed none of them
    before = first.tracks.ids.searchsorted(last.tracks.ids[again])
    moved = last.points.features.pixels[again] - first.points.features.pixels[before]
    np.testing.assert_allclose(np.median(moved, axis=0), [-36, 0], atol=0.1)
    assert last.missed is None or not np.isin(last.missed.ids, last.tracks.ids).any()
    assert hasty[1].missed is not None
    assert hasty[2].missed is None
    assert hasty[3].tracks.ids.min() >= len(first.tracks)


def test_what_is_waited_for_is_one_thing_of_each_track():
    found = features([[10, 10], [50, 10]], [0, 1])
    classes = DescriptorClasses.of(found.descriptors)
    columns = np.arange(2), np.ones(2, dtype=int), np.ones((2, 3))
    assert len(Missed(*columns, found, classes)) == 2
    with unchecked():
        with pytest.raises(ValueError, match="features must be of 2 tracks, got 1"):
            Missed(*columns, found[:1], classes)
        with pytest.raises(ValueError, match="classes must be of 2 tracks, got 1"):
            Missed(*columns, found, classes[:1])
        with pytest.raises(ValueError, match="frames must not be negative, got -1"):
            Missed(np.arange(2), np.array([1, -1]), np.ones((2, 3)), found, classes)


def test_a_sighting_is_what_a_filter_takes():
    left = texture(3)
    found = sight(None, left, shifted(left, -20.0), StereoRig(CAMERA, 0.2), np.eye(4))
    seen, points = found.observations, found.points.points
    np.testing.assert_array_equal(seen.ids, found.tracks.ids)
    np.testing.assert_array_equal(seen.values, points.mean)
    np.testing.assert_array_equal(seen.covs, points.cov)
    assert (found.points.observations.ids == -1).all()
    assert found.descriptors.dtype == float
    np.testing.assert_array_equal(found.descriptors, found.points.features.descriptors)


def test_points_of_two_eyes_are_followed_where_the_motion_of_the_camera_expects_them():
    """The same pictures twice: all points go on; where they are expected elsewhere, none does."""
    left = texture(3)
    rig = StereoRig(CAMERA, 0.2)
    pair = left, shifted(left, -20.0)
    aside = np.eye(4)
    aside[0, 3] = 0.5
    with unchecked():
        first = sight(None, *pair, rig, aside)
        again, elsewhere = (sight(first, *pair, rig, motion) for motion in (np.eye(4), aside))
    seen = observe(*pair, rig)
    np.testing.assert_array_equal(first.points.points.mean, seen.points.mean)
    assert first.tracks.ids.tolist() == again.tracks.ids.tolist() == list(range(len(seen)))
    assert elsewhere.tracks.ids.min() >= len(seen) > 50

"""The loop building: its size, its landmarks, its drive, and scans in two steps."""

import numpy as np
import pytest
import shapely

from data_synth.building import drive, first_leg, make_building
from data_synth.laser import Scanner, measure, scan, sight
from data_synth.posts import make_posts

SEEDS = range(5)


def floor_of(building):
    """Return the free floor as shapely sees it: rings in the order of the faces."""
    starts = np.flatnonzero(
        np.r_[True, (building.faces[1:, 0] != building.faces[:-1, 1]).any(axis=-1)]
    )
    rings = np.split(building.faces[:, 0], starts[1:])
    return shapely.Polygon(rings[0], rings[1:]), rings


@pytest.mark.parametrize("seed", SEEDS)
def test_floor_has_the_size_of_the_paper(seed):
    building = make_building(rng=np.random.default_rng(seed))
    floor, rings = floor_of(building)
    assert floor.is_valid
    assert shapely.LinearRing(rings[0]).is_ccw  # free space to the left of every face
    assert not any(shapely.LinearRing(ring).is_ccw for ring in rings[1:])
    assert building.area == pytest.approx(floor.area)
    assert building.area == pytest.approx(300, abs=2)


@pytest.mark.parametrize("seed", SEEDS)
def test_drive_goes_once_round_in_the_free_space_and_sees_its_start_again(seed):
    building = make_building(rng=np.random.default_rng(seed))
    poses = drive(building, step=0.2, beyond=6.0)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    turns = (np.diff(poses[:, 2]) + np.pi) % (2 * np.pi) - np.pi
    assert steps.max() <= 0.2
    assert np.abs(turns).max() <= 0.2 + 1e-9
    np.testing.assert_allclose(poses[0], 0, atol=1e-12)
    again = len(poses) - 1 - int(6.0 / 0.2)
    closest = np.abs(poses[again - 5 : again + 6, :2]).sum(axis=1).argmin() + again - 5
    np.testing.assert_allclose(poses[closest], 0, atol=1e-9)
    assert steps[:closest].sum() == pytest.approx(90, abs=2.5)
    np.testing.assert_allclose(poses[closest:], poses[: len(poses) - closest], atol=1e-9)
    assert shapely.LineString(poses[:, :2]).distance(floor_of(building)[0].boundary) > 0.5
    assert turns.sum() == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("seed", SEEDS)
def test_headings_point_along_the_way(seed):
    poses = drive(make_building(rng=np.random.default_rng(seed)), step=0.2)
    chord = np.diff(poses[:, :2], axis=0)
    middle = np.unwrap(poses[:, 2])[:-1] + np.diff(np.unwrap(poses[:, 2])) / 2
    off = np.arctan2(chord[:, 1], chord[:, 0]) - middle
    assert (
        np.abs(np.angle(np.exp(1j * off))).max() < 0.06
    )  # a step may begin on a leg, end on an arc


def test_corners_are_taken_on_circles():
    building = make_building(rng=np.random.default_rng(0))
    poses = drive(building, step=0.2, radius=0.9)
    turning = np.abs(np.angle(np.exp(4j * poses[:, 2]))) > 1e-6
    assert turning.sum() > 20
    centres = building.loop + 0.9 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    away = np.linalg.norm(poses[turning, None, :2] - centres, axis=-1).min(axis=1)
    np.testing.assert_allclose(away, 0.9)


@pytest.mark.parametrize("length", [30.0, 90.0])
def test_the_drive_ends_before_it_would_leave_the_loop(length):
    posts = make_posts(length, rng=np.random.default_rng(0))
    first = first_leg(posts)
    assert first == pytest.approx(posts.loop[1, 0] - 1)
    poses = drive(posts, beyond=first)
    assert (poses[:, :2] <= posts.loop.max(axis=0) + 1e-9).all()
    assert poses[-1, 2] == pytest.approx(0, abs=1e-9)  # still straight ahead
    for beyond in (first + 0.01, -0.5, np.nan):
        with pytest.raises(ValueError, match=f"0 to {first:g} m, got {beyond}"):
            drive(posts, beyond=beyond)


@pytest.mark.parametrize("seed", SEEDS)
def test_landmarks_are_the_corners_and_the_columns(seed):
    building = make_building(rng=np.random.default_rng(seed))
    floor, rings = floor_of(building)
    poles = building.landmarks[building.kinds == "pole"]
    assert len(poles) == len(rings) - 2
    for pole, ring in zip(poles, rings[2:], strict=True):
        np.testing.assert_allclose(np.hypot(*(ring - pole).T), building.pole_radius)
    # a small disc about a corner is free to three quarters where the wall juts out
    share = {"convex": 0.75, "concave": 0.25}
    for point, kind in zip(building.landmarks, building.kinds, strict=True):
        if kind != "pole":
            disc = shapely.Point(point).buffer(0.05)
            assert floor.intersection(disc).area / disc.area == pytest.approx(share[kind], abs=0.01)


def test_same_seed_same_building_and_another_seed_another():
    first, again, other = (make_building(rng=np.random.default_rng(s)) for s in (2, 2, 3))
    np.testing.assert_array_equal(first.faces, again.faces)
    assert not np.allclose(first.landmarks, other.landmarks)


def test_scan_is_sight_and_measure():
    building, scanner = make_building(rng=np.random.default_rng(0)), Scanner(beams=61)
    poses = drive(building)[::60]
    whole = scan(building.faces, poses, scanner, rng=np.random.default_rng(4))
    parts = measure(sight(building.faces, poses, scanner), scanner, rng=np.random.default_rng(4))
    np.testing.assert_array_equal(whole.ranges, parts.ranges)
    np.testing.assert_array_equal(whole.mixed, parts.mixed)


def test_faces_out_of_reach_do_not_change_what_is_near():
    building, scanner = make_building(rng=np.random.default_rng(0)), Scanner(beams=61)
    poses = drive(building)[::60]
    whole = sight(building.faces, poses, scanner)
    near = sight(building.faces, poses, scanner, reach=6.0)
    inside = whole.distances <= 6.0
    np.testing.assert_array_equal(near.distances[inside], whole.distances[inside])
    np.testing.assert_array_equal(near.faces[inside], whole.faces[inside])
    assert (near.distances[~inside] > 6.0).all()
    assert not np.array_equal(near.distances, whole.distances)
    nothing = sight(building.faces, np.array([[500.0, 0.0, 0.0]]), scanner, reach=6.0)
    assert np.isinf(nothing.distances).all()
    assert (nothing.faces == -1).all()

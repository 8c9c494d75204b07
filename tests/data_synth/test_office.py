"""The office world and its scanner against shapely and against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from data_synth.laser import Scanner, cast, scan, scan_moving
from data_synth.office import drive, make_office


@pytest.mark.parametrize("seed", range(6))
def test_free_space_is_one_simple_polygon_with_the_furniture_and_the_robot_inside(seed):
    office = make_office(rng=np.random.default_rng(seed))
    outline = office.faces[office.kinds != "furniture"]
    floor = shapely.Polygon(outline[:, 0])
    assert floor.is_valid
    assert floor.exterior.is_ccw  # free space to the left
    boxes = office.faces[office.kinds == "furniture"].reshape(-1, 4, 2, 2)
    for box in boxes:
        ring = shapely.Polygon(box[:, 0])
        assert not ring.exterior.is_ccw
        assert floor.buffer(1e-6).contains(ring)
    poses = drive(office)
    free = floor.difference(shapely.union_all([shapely.Polygon(b[:, 0]) for b in boxes]))
    assert all(free.contains(shapely.Point(p)) for p in poses[:, :2])
    assert shapely.LineString(office.waypoints).distance(free.boundary) > 0.3


def test_poses_move_and_turn_in_small_steps():
    poses = drive(make_office(rng=np.random.default_rng(0)), step=0.25, turn=0.3)
    steps = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=-1)
    turns = (np.diff(poses[:, 2]) + np.pi) % (2 * np.pi) - np.pi
    assert steps.max() <= 0.25 + 1e-9
    assert np.abs(turns).max() <= 0.3 + 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_a_turned_office_is_driven_by_the_same_poses(seed):
    office = make_office(rng=np.random.default_rng(seed))
    poses = drive(office)
    for tilt in np.linspace(-3, 3, 12):
        turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
        turned = drive(replace(office, waypoints=office.waypoints @ turn.T))
        np.testing.assert_allclose(turned[:, :2], poses[:, :2] @ turn.T, atol=1e-9)
        headings = np.exp(1j * (turned[:, 2] - poses[:, 2] - tilt))
        np.testing.assert_allclose(headings, 1, atol=1e-9)


def test_rays_end_where_shapely_says():
    office = make_office(rng=np.random.default_rng(1))
    directions = np.linspace(-3, 3, 40)
    origin = office.waypoints[0]
    distances, faces = cast(origin, directions, office.faces)
    lines = shapely.linestrings(office.faces)
    for direction, distance, face in zip(directions, distances, faces, strict=True):
        far = origin + 100 * np.array([np.cos(direction), np.sin(direction)])
        hits = shapely.intersection(shapely.LineString([origin, far]), lines)
        truth = shapely.distance(shapely.Point(origin), hits)
        assert distance == pytest.approx(np.nanmin(truth))
        assert truth[face] == pytest.approx(distance)


def test_a_ray_into_the_open_meets_nothing():
    distances, faces = cast(np.zeros(2), np.array([0.0, np.pi]), np.array([[[1.0, -1], [1, 1]]]))
    assert distances.tolist() == [1.0, np.inf]
    assert faces.tolist() == [0, -1]


def test_noise_has_the_stated_spread_and_readings_their_resolution():
    wall = np.array([[[2.0, -50.0], [2.0, 50.0]]])
    scanner = Scanner(range_sigma=0.02, resolution=0.01, dropout=0.0, max_range=5.0)
    scans = scan(wall, np.zeros((400, 3)), scanner, rng=np.random.default_rng(0))
    seen = np.isfinite(scans.ranges)
    near = seen & (scans.true_ranges < 4.5)
    error = scans.ranges[near] - scans.true_ranges[near]
    assert error.std() == pytest.approx(np.hypot(0.02, 0.01 / np.sqrt(12)), rel=0.02)
    np.testing.assert_allclose(scans.ranges[seen] * 100, np.round(scans.ranges[seen] * 100))
    assert scans.ranges[seen].max() <= 5.0


def test_mixed_pixels_lie_between_the_two_surfaces_at_an_edge():
    faces = np.array([[[2.0, -9.0], [2.0, 0.0]], [[4.0, 9.0], [4.0, -9.0]]])
    scanner = Scanner(range_sigma=1e-6, resolution=0.0, dropout=0.0, spot=np.deg2rad(0.25))
    scans = scan(faces, np.zeros((50, 3)), scanner, rng=np.random.default_rng(0))
    assert scans.mixed.any()
    beams = np.flatnonzero(scans.mixed.any(axis=0))
    assert np.abs(scanner.angles[beams]).max() < np.deg2rad(0.5)
    values = scans.ranges[scans.mixed]
    assert values.min() > 2.0 - 1e-4
    assert values.max() < 4.0 + 1e-3
    assert np.ptp(values) > 1.0


def test_same_seed_same_scan_and_standing_still_is_the_limit_of_moving():
    office = make_office(rng=np.random.default_rng(0))
    pose = drive(office)[5]
    both = [
        scan(office.faces, pose[None], Scanner(), rng=np.random.default_rng(3)).ranges,
        scan_moving(
            office.faces, pose, (0.0, 0.0), 0.1, Scanner(), rng=np.random.default_rng(3)
        ).ranges,
    ]
    np.testing.assert_array_equal(*both)
    moving = scan_moving(
        office.faces, pose, (1.0, 0.5), 0.1, Scanner(), rng=np.random.default_rng(3)
    )
    assert not np.array_equal(moving.ranges, both[0])

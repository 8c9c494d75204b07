"""The office world and its scanner against shapely and against closed forms."""

from dataclasses import replace
from itertools import combinations

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
    rooms, thickness, door = 4, 0.12, 1.0
    widths = 2 * (20.0 - rooms * thickness) * (4.5 - thickness)  # of the rooms on both sides
    assert floor.area == pytest.approx(20.0 * 2.0 + widths + 2 * rooms * door * thickness)
    ahead = office.waypoints[-1] - office.waypoints[0]
    assert np.arctan2(ahead[1], ahead[0]) == pytest.approx(office.tilt)
    boxes = office.faces[office.kinds == "furniture"].reshape(-1, 4, 2, 2)
    for box in boxes:
        ring = shapely.Polygon(box[:, 0])
        assert not ring.exterior.is_ccw
        assert floor.buffer(1e-6).contains(ring)
    poses = drive(office)
    free = floor.difference(shapely.union_all([shapely.Polygon(b[:, 0]) for b in boxes]))
    assert all(free.contains(shapely.Point(p)) for p in poses[:, :2])
    assert shapely.LineString(office.waypoints).distance(free.boundary) > 0.3


@pytest.mark.parametrize("seed", range(4))
def test_furniture_of_one_room_stands_apart(seed):
    office = make_office(rng=np.random.default_rng(seed), furniture=8)
    walls = shapely.MultiLineString(list(office.faces[office.kinds != "furniture"]))
    boxes = office.faces[office.kinds == "furniture"].reshape(-1, 4, 2, 2)
    boxes = [shapely.Polygon(box[:, 0]) for box in boxes]
    assert len(boxes) > 10
    for one, other in combinations(boxes, 2):
        between = shapely.LineString([one.centroid, other.centroid])
        assert one.distance(other) >= 0.3 - 1e-9 or between.intersects(walls)


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
    spread = np.hypot(0.02, 0.01 / np.sqrt(12))
    assert error.std() == pytest.approx(spread, rel=0.02)
    assert abs(error.mean()) < 5 * spread / np.sqrt(error.size)
    assert scans.ranges[:, 180].std() == pytest.approx(spread, rel=0.2)  # each scan has its own
    np.testing.assert_allclose(scans.ranges[seen] * 100, np.round(scans.ranges[seen] * 100))
    assert scans.ranges[seen].max() <= 5.0


def test_the_stated_share_of_readings_is_lost():
    wall = np.array([[[2.0, -500.0], [2.0, 500.0]]])
    scanner = Scanner(beams=181, dropout=0.1, max_range=np.inf)
    scans = scan(wall, np.zeros((200, 3)), scanner, rng=np.random.default_rng(0))
    there = np.isfinite(scans.true_ranges)
    lost = np.isinf(scans.ranges[there])
    assert lost.mean() == pytest.approx(0.1, abs=4 * np.sqrt(0.1 * 0.9 / lost.size))


def test_noise_carries_no_reading_beyond_the_range_of_the_scanner_nor_behind_it():
    near, far = ([[[d, -9.0], [d, 9.0]]] for d in (0.02, 2.0))
    scanner = Scanner(beams=5, range_sigma=0.05, max_range=2.0, dropout=0.0)
    for wall, lost in ((near, 0.0), (far, 0.5)):
        scans = scan(np.array(wall), np.zeros((500, 3)), scanner, rng=np.random.default_rng(0))
        ahead = scans.ranges[:, 2]
        assert np.isinf(ahead).mean() == pytest.approx(lost, abs=0.1)
        assert ((ahead[np.isfinite(ahead)] > 0) & (ahead[np.isfinite(ahead)] <= 2.0)).all()


def test_true_ranges_and_faces_are_those_of_the_middle_of_each_beam():
    office, scanner = make_office(rng=np.random.default_rng(2)), Scanner(beams=91)
    poses = drive(office)[::40]
    scans = scan(office.faces, poses, scanner, rng=np.random.default_rng(0))
    for pose, true, face in zip(poses, scans.true_ranges, scans.faces, strict=True):
        distances, hit = cast(pose[:2], pose[2] + scanner.angles, office.faces)
        np.testing.assert_array_equal(true, distances)
        np.testing.assert_array_equal(face, hit)


@pytest.mark.parametrize(("gap", "is_mixed"), [(0.15, False), (0.3, True)])
def test_a_beam_mixes_two_surfaces_within_its_spot_if_they_are_a_clear_step_apart(gap, is_mixed):
    faces = np.array([[[2.0, -9.0], [2.0, 0.0]], [[2.0 + gap, 9.0], [2.0 + gap, -9.0]]])
    scanner = Scanner(beams=3601, spot=np.deg2rad(0.42))
    mixed = scan(faces, np.zeros((1, 3)), scanner, rng=np.random.default_rng(0)).mixed[0]
    away = np.abs(scanner.angles) - scanner.spot
    sure = np.abs(away) > 1e-6
    np.testing.assert_array_equal(mixed[sure], ((away < 0) & is_mixed)[sure])


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


def test_each_beam_of_a_sweep_looks_from_the_arc_on_which_the_robot_is():
    corners = np.array([[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]])
    room = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    pose, speed, rate, scanner = np.array([-1.0, 0.5, 0.4]), 0.6, 0.5, Scanner()
    turn = np.linspace(0.0, 3.0, scanner.beams) * rate
    ahead, left = speed / rate * np.sin(turn), speed / rate * (1 - np.cos(turn))
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    places = pose[:2] + np.stack([cos * ahead - sin * left, sin * ahead + cos * left], axis=-1)
    distances, _ = cast(places, pose[2] + turn + scanner.angles, room)
    swept = scan_moving(room, pose, (speed, rate), 3.0, scanner, rng=np.random.default_rng(0))
    np.testing.assert_allclose(swept.true_ranges[0], distances, atol=speed * 3.0 / 360)  # a step

"""The textured building: its walls, what hangs on them, the drive, and what an eye finds there."""

from functools import cache

import cv2
import numpy as np
import pytest
import shapely

from data_synth.stereo import Rig, render, surface_points
from data_synth.textured_building import SLIP, drive, make_textured_building
from data_synth.wheels import roll, true_increments
from tests.data_synth.rooms import standing, walls_where_a_laser_finds_them

each_building = pytest.mark.parametrize("building", range(2), indirect=True)


@cache
def made(seed):
    return make_textured_building(rng=np.random.default_rng(seed))


@pytest.fixture
def building(request):
    return made(request.param)


def way(building, seed=0):
    return drive(building, rng=np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(3))
def test_the_drive_has_the_length_of_the_paper(seed):
    poses = way(made(0), seed)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert poses.shape == (507, 3)
    assert steps.sum() == pytest.approx(80, abs=2)
    assert steps.max() < 0.2
    assert np.rad2deg(np.abs(true_increments(poses)[:, 2]).max()) < 8
    assert np.abs(poses[:, 2]).max() <= np.pi


@pytest.mark.parametrize("seed", range(3))
def test_headings_point_along_the_way(seed):
    forward, leftward, turned = true_increments(way(made(0), seed)).T
    off = np.abs(np.arctan2(leftward, forward) - turned / 2)
    assert (off < 1e-3).mean() > 0.93
    assert off.max() < 0.03  # where an arc begins or ends


def test_turns_and_way_take_their_share_of_the_poses():
    steps = true_increments(way(made(0)))
    pace = np.hypot(np.hypot(steps[:, 0], steps[:, 1]), 1.2 * steps[:, 2])
    assert (np.abs(pace / np.median(pace) - 1) < 0.01).mean() > 0.93  # else an arc begins or ends


@each_building
def test_the_drive_keeps_clear_of_all_that_stands(building):
    low = standing(building)
    for seed in range(3):
        assert shapely.LineString(way(building, seed)[:, :2]).distance(low) > 0.27


def test_the_drive_returns_to_places_in_the_same_direction():
    poses = way(made(0))
    near = np.hypot(*(poses[:, None, :2] - poses[:, :2]).T) < 0.3
    along = np.cos(poses[:, None, 2] - poses[:, 2]) > np.cos(np.deg2rad(10))
    late = np.subtract.outer(np.arange(507), np.arange(507)) > 60
    again = (near & along & late).any(axis=1)
    assert again.sum() > 120
    assert again[-20:].all()


def test_other_numbers_of_poses_give_the_same_way():
    few, many = (drive(made(0), rng=np.random.default_rng(0), poses=count) for count in (102, 506))
    np.testing.assert_allclose(many[::5], few[:], atol=1e-9)


def test_without_wandering_the_way_leads_through_the_legs():
    building = made(0)
    poses = drive(building, rng=np.random.default_rng(0), wander=0.0, poses=3000)
    line = shapely.LineString(building.waypoints)
    away = shapely.distance(line, shapely.points(poses[:, :2]))
    assert away.max() == pytest.approx(0.8 * (1 - np.sqrt(0.5)), abs=2e-3)  # the middle of an arc
    np.testing.assert_allclose(poses[0, :2], building.waypoints[0])
    np.testing.assert_allclose(poses[-1, :2], building.waypoints[-1])


def test_odometry_ends_some_metres_away():
    poses = way(made(0))
    away = []
    for seed in range(40):
        forward, left, turned = roll(poses, SLIP, rng=np.random.default_rng(seed)).increments.T
        heading = poses[0, 2] + np.r_[0.0, np.cumsum(turned)][:-1]
        gone = np.exp(1j * heading) * (forward + 1j * left)
        away.append(abs(poses[0, :2] @ [1, 1j] + gone.sum() - poses[-1, :2] @ [1, 1j]))
    assert 0.5 < np.median(away) < 5


@each_building
def test_no_ray_leaves_the_building(building):
    rows, columns = np.mgrid[0:240:12, 0:320:8]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=-1)
    for pose in way(building)[::20]:
        assert (surface_points(building.scene, Rig(), pose, pixels).surfaces >= 0).all()


@each_building
def test_walls_stand_where_a_laser_finds_them(building):
    assert walls_where_a_laser_finds_them(building, way(building)[::25]) > 300


@each_building
def test_what_hangs_lies_on_its_carrier(building):
    scene = building.scene
    hung = np.flatnonzero(scene.carriers != np.arange(len(scene.carriers)))
    assert len(hung) > 100
    for k in hung:
        frame, wall = scene.frames[k], scene.frames[scene.carriers[k]]
        normal = np.cross(wall[:, 0], wall[:, 1])
        away = normal @ (wall[:, 2] - frame[:, 2]) / np.linalg.norm(normal)
        assert away == pytest.approx(0.005)  # on the side from which it is seen
        middle = frame @ [0.5, 0.5, 1.0]
        if building.kinds[k] == "jamb":
            continue  # a frame is named after the wall above its doorway
        basis = np.stack([wall[:, 0], wall[:, 1], normal], axis=-1)
        for a, b in ((0, 0), (1, 1)):
            share = np.linalg.solve(basis, frame @ [a, b, 1.0] - wall[:, 2])
            assert (np.abs(share[:2] - 0.5) <= 0.5).all(), building.kinds[k]
        assert 0 < middle[2] <= 2.7


@each_building
def test_some_places_look_alike(building):
    for kind in ("poster", "door", "notices", "books"):
        shown = building.scene.pictures[building.kinds == kind]
        counts = np.unique(shown, return_counts=True)[1]
        assert counts.max() >= 2, kind


@pytest.mark.parametrize("seed", range(2))
def test_there_is_something_to_see_in_most_images_and_little_on_bare_walls(seed):
    building, rng = made(seed), np.random.default_rng(seed)
    poses = way(building, seed)
    sift = cv2.SIFT_create()

    def features(pose):
        return len(sift.detect(render(building.scene, Rig(), pose, rng=rng).left, None))

    counts = [features(pose) for pose in poses[::46]]
    assert 50 < np.median(counts) < 300
    assert min(counts) >= 8
    assert features(np.array([2.0, 4.7, np.pi])) < 25  # the blank wall of the room that is shut

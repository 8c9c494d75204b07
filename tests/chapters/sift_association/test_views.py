"""Landmarks and tests against the renderer's truth, and by hand."""

import numpy as np
import pytest

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textured_building import drive, make_textured_building
from data_synth.textures import paint
from robot_perception.book import sift_association as page
from robot_perception.book.sift_association import APART, FOCUS, Stations, Views
from robot_perception.landmarks import detect, raw_variances
from tests.chapters.sift_association.worlds import features, places, tiled_wall
from tests.unchecked import unchecked

RNG = np.random.default_rng
RIG = Rig()
SMALL = Stations(count=2, frames=6, sightings=4, again=2, swing=0.05, aside=(0.3,))


def recorded(seed: int) -> Views:
    with unchecked():
        return page.views.__wrapped__(SMALL, seed)


@pytest.fixture(scope="module")
def seen():
    return recorded(3)


@pytest.fixture(scope="module")
def frames():
    """The same pictures, rendered anew, with their features: poses and features of each station."""
    world, path, *streams = RNG(3).spawn(2 + SMALL.count)
    building = make_textured_building(rng=world)
    way = np.hypot(*np.diff(building.waypoints, axis=0).T).sum()
    poses = drive(building, rng=path, poses=int(way / SMALL.step))
    out = []
    for start, rng in zip((0, len(poses) - SMALL.frames - 1), streams, strict=True):
        ways = np.linspace(-SMALL.swing, SMALL.swing, SMALL.frames)
        straight = poses[start : start + SMALL.frames]
        part = np.stack([page.stand_aside(p, a) for p, a in zip(straight, ways, strict=True)])
        taken = stereo.frames(building.scene, RIG, part, rng=rng)
        out.append((part, [detect(frame.left) for frame in taken]))
    return out


# Where features lie


def test_places_are_on_the_wall_where_the_ray_meets_it():
    wall, pose = tiled_wall(paint("poster", rng=RNG(1))), np.array([1.0, 0.5, 0.1])
    points = np.array([[4.0, y, z] for y in (-1.5, 0.3, 1.2) for z in (0.4, 1.7)])
    at = stereo.project(RIG, pose, points)
    found = page.place(wall, RIG, pose, features(at[:, :2], scales=3.0, angles=0.4))
    assert found["points"] == pytest.approx(points)
    assert (found["carriers"] == 0).all()
    assert found["sizes"] == pytest.approx(3.0 * at[:, 2] / RIG.focal_px)
    assert (found["angles"] == 0.4).all()
    across, below = 3.0 - points[:, 1], 3.0 - points[:, 2]
    assert (found["pictures"] == 0).all()
    assert found["spots"] == pytest.approx(np.column_stack([across % 2, below % 1.5]))


def test_a_feature_on_nothing_has_no_carrier_and_no_features_no_places():
    wall, pose = tiled_wall(paint("poster", rng=RNG(1))), np.array([1.0, 0.0, np.pi])
    assert (page.place(wall, RIG, pose, features([[5.0, 7.0]]))["carriers"] == -1).all()
    assert len(page.place(wall, RIG, pose, features([]))) == 0


@pytest.mark.parametrize("aside", [-0.6, 0.3])
def test_who_stands_aside_looks_at_the_same_place(aside):
    pose = np.array([2.0, -1.0, 2.5])
    ahead = np.array([[np.cos(2.5), np.sin(2.5), 0.0]])
    target = np.array([*pose[:2], 1.0]) + FOCUS * ahead
    stood = page.stand_aside(pose, aside)
    (column, _, depth), middle = stereo.project(RIG, stood, target)[0], RIG.centre_px[0]
    assert column == pytest.approx(middle)
    assert depth == pytest.approx(np.hypot(FOCUS, aside))
    assert np.hypot(*(stood - pose)[:2]) == pytest.approx(abs(aside))
    left = np.array([-np.sin(2.5), np.cos(2.5)])
    assert (stood - pose)[:2] @ left == pytest.approx(aside)


# The same place, like features, look-alikes


def hand_made() -> Views:
    """Landmarks: one, one beside it, its copy, one on another wall; tests at and about them."""
    marks = places(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 0]],
        carriers=[0, 0, 0, 1],
        prints=[[0, 0.1, 0.1], [0, 0.9, 0.1], [0, 0.1, 0.1], [1, 0.1, 0.1]],
    )
    near = 0.9 * APART
    tested = places(
        [[near, 0, 0], [0, 0, 1.1 * APART], [0, 0, 0], [0, 0, 0], [1, 0, 0], [5, 0, 0]],
        carriers=[0, 0, 0, 0, 0, -1],
        prints=[
            [0, 0.1 + near, 0.1],
            [0, 0.1, 0.1 + 1.1 * APART],
            [0, 0.1, 0.1],
            [0, 0.1, 0.1],
            [0, 0.9, 0.1],
            [2, 0.1, 0.1],
        ],
        sizes=[0.01, 0.01, 0.01 * 2**0.6, 0.01 * 2**-0.4, 0.01, 0.01],
        angles=[2 * np.pi - 0.1, 0, 0, 0, np.deg2rad(31), 0],
    )
    blank = np.zeros((6, 128), np.uint8)
    return Views(np.zeros((4, 2, 128), np.uint8), marks, blank, tested, np.zeros(6))


def test_the_same_place_is_near_and_on_the_same_surface():
    expected = np.zeros((6, 4), dtype=bool)
    expected[[0, 2, 3, 4], [0, 0, 0, 1]] = True
    assert (hand_made().same() == expected).all()


def test_what_is_meant_is_of_like_size_and_direction_besides():
    expected = np.zeros((6, 4), dtype=bool)
    expected[[0, 3], [0, 0]] = True  # a size 2^0.6 is another, and a turn by 31°
    assert (hand_made().meant() == expected).all()


def test_look_alikes_show_the_same_spot_of_the_same_picture_elsewhere():
    expected = np.zeros((6, 4), dtype=bool)
    expected[[0, 2, 3], [2, 2, 2]] = True
    assert (hand_made().alike() == expected).all()


def test_masks_are_those_of_a_comparison_one_by_one(seen):
    part = slice(None, None, 7)
    shown = seen.tests[part], seen.tested[part], seen.aside[part]
    small = Views(seen.stacks, seen.landmarks, *shown)
    tested, marks = small.tested, small.landmarks
    same = np.zeros((len(tested), len(marks)), dtype=bool)
    alike = same.copy()
    for i, j in np.ndindex(same.shape):
        near = np.linalg.norm(tested["points"][i] - marks["points"][j]) < APART
        same[i, j] = near and tested["carriers"][i] == marks["carriers"][j]
        spot = np.linalg.norm(tested["spots"][i] - marks["spots"][j]) < APART
        alike[i, j] = spot and tested["pictures"][i] == marks["pictures"][j] and not same[i, j]
    assert (small.same() == same).all()
    assert (small.alike() == alike).all()
    assert same.any()


# What is recorded


def test_every_landmark_has_a_descriptor_of_its_own_place_from_each_sighting(seen, frames):
    """Each is a feature of one of the frames, in the order of the frames, where the landmark is."""
    assert len(seen.landmarks) > 50
    assert seen.stacks.shape == (len(seen.landmarks), SMALL.sightings, 128)
    for stack, point in zip(seen.stacks[::3], seen.landmarks["points"][::3], strict=True):
        taken = max((_taken(stack, point, *station) for station in frames), key=len)
        assert len(taken) == SMALL.sightings
        assert taken == sorted(set(taken))


def _taken(stack, point, poses, seen) -> list[int]:
    """Return in which frames the descriptors of a landmark are found near its place."""
    out = []
    for look in stack:
        for k, (pose, found) in enumerate(zip(poses, seen, strict=True)):
            column, row, depth = stereo.project(RIG, pose, point[None])[0]
            reach = APART * RIG.focal_px / max(depth, 0.1) + 1
            rows = np.flatnonzero((found.descriptors == look).all(axis=1))
            gaps = np.linalg.norm(found.pixels[rows] - [column, row], axis=1)
            if depth > 0 and (gaps < 3 * reach).any():
                out.append(k)
                break
    return out


def test_tests_are_features_on_surfaces_from_between_and_from_farther_aside(seen):
    assert len(seen.tests) == len(seen.tested) == len(seen.aside)
    assert set(seen.aside) == {0.0, SMALL.swing + 0.3}
    assert (seen.tested["carriers"] >= 0).all()
    assert seen.meant().any(axis=1).mean() > 0.2


def test_the_same_seed_records_the_same_and_another_does_not(seen):
    again, other = recorded(3), recorded(4)
    for name in ("stacks", "tests", "aside"):
        assert np.array_equal(getattr(again, name), getattr(seen, name))
    assert len(other.tests) != len(seen.tests)


@pytest.mark.parametrize(("p", "part"), [(2, slice(1, 3)), (4, slice(0, 4)), (3, slice(0, 3))])
def test_classes_are_means_and_variances_of_the_frames_in_the_middle(seen, p, part):
    own = seen.stacks[:, part].astype(float)
    classes = seen.classes(p)
    assert classes.means == pytest.approx(own.mean(axis=1))
    assert (classes.counts == p).all()
    expected = np.maximum(own.var(axis=1, ddof=1), 1 / 12)
    assert raw_variances(classes) == pytest.approx(expected)

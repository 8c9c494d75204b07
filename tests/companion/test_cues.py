"""Colours of patches and distances to edges: kernels against what is read, and laws."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from robot_perception.companion.cues import (
    bhattacharyya,
    contour_distances,
    distance_transform,
    edge_distances,
    edge_picture,
    patch_histograms,
    patch_histograms_textbook,
    patch_points,
    sampled,
)
from tests.unchecked import unchecked

RNG = np.random.default_rng(0)
IMAGE = RNG.integers(0, 256, (40, 60, 3), dtype=np.uint8)
PATCHES = np.array([[-0.5, -0.5, 1.0, 1.0], [0.2, -1.0, 0.4, 2.0]])
POINTS = patch_points(np.array([[20.0, 20.0, 0.1, 15.0]]), PATCHES)
SEEN = np.ones(POINTS.shape[:3], dtype=bool)


def drawn(count, seed=1):
    rng = np.random.default_rng(seed)
    return np.column_stack([
        rng.uniform(-15, 75, count), rng.uniform(-15, 55, count),
        rng.uniform(-4, 4, count), rng.uniform(1, 40, count),
    ])  # fmt: skip


@pytest.mark.parametrize(("bins", "grid"), [(8, 8), (2, 3), (256, 5), (5, 16)])
def test_the_kernel_is_the_textbook(bins, grid):
    points = patch_points(drawn(60), PATCHES, grid=grid)
    visible = np.random.default_rng(3).random(points.shape[:3]) < 0.7
    for more in ((), (visible,)):
        for ours, theirs in zip(
            patch_histograms(IMAGE, points, *more, bins=bins),
            patch_histograms_textbook(IMAGE, points, *more, bins=bins),
            strict=True,
        ):
            np.testing.assert_allclose(ours, theirs, atol=1e-12)


@pytest.mark.parametrize("grid", [2, 3, 16])
def test_points_are_those_of_the_grid_scaled_turned_and_moved(grid):
    states, steps = drawn(20), (np.arange(grid) + 0.5) / grid
    along, down = (part.ravel() for part in np.meshgrid(steps, steps))
    found = patch_points(states, PATCHES, grid=grid)
    for own, (x, y, theta, s) in zip(found, states, strict=True):
        turn = s * np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
        for points, (left, top, wide, high) in zip(own, PATCHES, strict=True):
            there = np.stack([left + wide * along, top + high * down])
            np.testing.assert_allclose(points, np.add((turn @ there).T, (x, y)), atol=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_each_channel_is_counted_alone_and_what_is_hidden_is_not(channels):
    picture = RNG.integers(0, 256, (30, 20, channels), dtype=np.uint8)
    points = RNG.uniform(-2, 32, (5, 3, 40, 2))
    visible = RNG.random((5, 3, 40)) < 0.5
    found, share = patch_histograms(picture, points, visible)
    assert found.shape == (5, 3, channels, 8)
    for c in range(channels):
        alone, _ = patch_histograms(picture[..., c : c + 1], points, visible)
        np.testing.assert_array_equal(alone[:, :, 0], found[:, :, c])
    only, _ = patch_histograms(picture, points[:1, :1, visible[0, 0]])
    np.testing.assert_allclose(only[0, 0], found[0, 0])
    assert share[0, 0] <= visible[0, 0].mean()
    gone = np.where(visible[..., None], points, np.nan)
    np.testing.assert_array_equal(patch_histograms(picture, gone)[0], found)


@pytest.mark.parametrize("size", [1, 2, 3, 64, 65])
def test_points_at_the_ends_of_a_picture_fall_on_its_pixels_or_outside(size):
    picture = np.zeros((size, size, 1), np.uint8)
    ends = np.array([-0.5, 0.5, size - 0.5])
    at = np.concatenate([ends, np.nextafter(ends, -9), np.nextafter(ends, 1e3)])
    points = np.stack([at, np.zeros(at.size)], axis=-1)[None, :, None]
    inside = (np.floor(at + 0.5) >= 0) & (np.floor(at + 0.5) < size)
    for function in (patch_histograms, patch_histograms_textbook):
        np.testing.assert_array_equal(function(picture, points)[1][0], inside)


def test_a_patch_that_covers_whole_pixels_counts_each_once():
    state = np.array([[10.0 + 7.5, 5.0 + 7.5, 0.0, 16.0]])
    points = patch_points(state, np.array([[-0.5, -0.5, 1, 1]]), grid=16)
    found, inside = patch_histograms(IMAGE, points)
    assert inside[0, 0] == 1
    for c in range(3):
        expected = np.bincount(IMAGE[5:21, 10:26, c].ravel() // 32, minlength=8) / 256
        np.testing.assert_allclose(found[0, 0, c], expected)


def test_turned_and_scaled_the_same_colours_are_seen():
    """A picture turned by 90° about a pixel, seen by a state turned the same way."""
    image = np.rot90(IMAGE[:39, :39], -1).copy()  # clockwise: the top goes to the right
    upright = np.array([[14.0, 22.0, 0.0, 12.0]])
    turned = np.array([[38.0 - 22.0, 14.0, np.pi / 2, 12.0]])
    patch = np.array([[-0.3, 0.11, 0.9, 0.36]])
    one, _ = patch_histograms(IMAGE[:39, :39], patch_points(upright, patch, grid=7))
    other, _ = patch_histograms(image, patch_points(turned, patch, grid=7))
    np.testing.assert_allclose(one, other)


def test_what_lies_outside_is_left_out_and_told():
    state = np.array([[-0.5, 20.0, 0.0, 10.0], [500.0, 20.0, 0.0, 10.0]])
    points = patch_points(state, np.array([[-0.5, -0.5, 1, 1]]), grid=10)
    found, inside = patch_histograms(IMAGE, points)
    np.testing.assert_allclose(inside[:, 0], [0.5, 0.0])
    np.testing.assert_allclose(found[0].sum(axis=-1), 1)
    assert not found[1].any()


HISTOGRAMS = st.lists(st.floats(0, 1), min_size=4, max_size=4).filter(lambda h: sum(h) > 1e-3)


@given(HISTOGRAMS, HISTOGRAMS)
def test_the_distance_is_one_of_hellinger(one, other):
    p, q = (np.array(h) / sum(h) for h in (one, other))
    hellinger = np.linalg.norm(np.sqrt(p) - np.sqrt(q)) / np.sqrt(2)
    assert bhattacharyya(p, q) == pytest.approx(hellinger, abs=2e-7)
    assert bhattacharyya(p, q) == bhattacharyya(q, p)


def test_the_ends_of_the_distance():
    one, other = np.array([0.5, 0.5, 0, 0]), np.array([0, 0, 0.3, 0.7])
    assert bhattacharyya(one, one) == pytest.approx(0, abs=1e-7)
    assert bhattacharyya(one, other) == 1
    assert bhattacharyya(np.zeros(4), one) == 1
    assert bhattacharyya(np.tile(one, (3, 2, 1)), one).shape == (3, 2)


def square():
    image = np.full((60, 80), 40, dtype=np.uint8)
    cv2.rectangle(image, (25, 15), (54, 44), 220, -1)
    return image


def test_distances_to_edges_are_those_of_another_transform():
    found = edge_distances(square(), most=50.0)
    edges = found == 0
    assert edges.sum() > 80
    np.testing.assert_allclose(found, distance_transform_edt(~edges), rtol=0.05, atol=0.3)
    assert edge_distances(square(), most=4.0).max() == 4
    assert (edge_distances(np.full((9, 9), 7, np.uint8), most=6.0) == 6).all()


def test_an_exact_transform_is_that_of_scipy_and_need_not_be_cut():
    edges = edge_picture(square(), thresholds=(60.0, 140.0))
    assert edges.dtype == bool
    exact = distance_transform_edt(~edges)
    np.testing.assert_allclose(distance_transform(edges), exact, atol=1e-4)
    np.testing.assert_allclose(distance_transform(edges, most=3.0), np.minimum(exact, 3), atol=1e-4)
    rough = distance_transform(edges, precise=False)
    assert 0 < np.abs(rough - exact).max() < 0.05 * exact.max()
    nothing = np.zeros((4, 5), dtype=bool)
    assert np.isinf(distance_transform(nothing)).all()
    assert (distance_transform(nothing, most=2.0) == 2).all()


def test_a_point_has_the_distance_of_the_nearest_pixel():
    field = np.arange(12.0).reshape(3, 4)
    points = np.array([[[0.4, 0.4], [2.6, 1.0], [-0.6, 1.0], [3.0, 2.5]]])
    np.testing.assert_array_equal(sampled(field, points, 99.0), [[0.0, 7.0, 99.0, 99.0]])


def test_the_contour_of_a_thing_is_nearest_to_edges_at_its_place():
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.5
    sides = np.linspace(corners, np.roll(corners, -1, axis=0), 12, endpoint=False)
    contour = sides.reshape(-1, 2)
    distance = edge_distances(square())
    shifts = np.arange(-8, 9)
    states = np.array([[39.5 + a, 29.5 + b, 0.0, 30.0] for a in shifts for b in shifts])
    found = contour_distances(distance, states, contour).reshape(17, 17)
    assert np.unravel_index(found.argmin(), found.shape) in {(8, 8), (7, 8), (8, 7), (7, 7)}
    assert found.min() < 1.0
    assert found[0, 8] > 4
    sizes = [[39.5, 29.5, 0.0, s] for s in (20.0, 30.0, 40.0)]
    by_size = contour_distances(distance, np.array(sizes), contour)
    assert by_size.argmin() == 1
    by_turn = contour_distances(
        distance, np.array([[39.5, 29.5, a, 30.0] for a in (0.0, 0.5)]), contour
    )
    assert by_turn[0] < by_turn[1]


def test_the_measure_is_the_root_mean_square_and_outside_is_far():
    distance = np.array([[0.0, 3.0], [4.0, 1.0]])
    contour = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    found = contour_distances(distance, np.array([[0.0, 0.0, 0.0, 1.0]]), contour)
    assert found[0] == pytest.approx(np.sqrt((0 + 9 + 16) / 3))
    away = contour_distances(distance, np.array([[9.0, 9.0, 0.0, 1.0]]), contour)
    assert away[0] == 4
    field = np.arange(25.0).reshape(5, 5)
    turned = contour_distances(field, np.array([[2.0, 2.0, np.pi / 2, 1.0]]), np.array([[0.0, 1]]))
    assert turned[0] == field[2, 1], "down is left after a quarter turn"


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (lambda: patch_histograms(IMAGE.astype(float), POINTS), TypeError, "picture must hold by"),
        (lambda: patch_histograms(IMAGE[..., 0], POINTS), ValueError, "picture must be"),
        (lambda: patch_histograms(IMAGE[:0], POINTS), ValueError, "picture must be"),
        (lambda: patch_histograms(IMAGE, POINTS[:, :, :0]), ValueError, "points must be one"),
        (lambda: patch_histograms(IMAGE, POINTS[..., :1]), ValueError, "points must be"),
        (lambda: patch_histograms(IMAGE, POINTS, SEEN[:, :1]), ValueError, "visible must be"),
        (lambda: patch_histograms(IMAGE, POINTS, 1.0 * SEEN), TypeError, "visible must be truth"),
        (lambda: patch_histograms(IMAGE, POINTS, bins=1), ValueError, "bins must be"),
        (lambda: patch_points(-drawn(1), PATCHES), ValueError, "a positive scale"),
        (lambda: patch_points(drawn(1), PATCHES * 0), ValueError, "patches must be one"),
        (lambda: patch_points(drawn(1), PATCHES, grid=1), ValueError, "grid must be"),
        (lambda: bhattacharyya(np.ones(3), np.ones(4)), ValueError, "must have the same bins"),
        (lambda: bhattacharyya(np.ones((2, 3)), np.ones((4, 3))), ValueError, "must broadcast"),
        (lambda: bhattacharyya(-np.ones(3), np.ones(3)), ValueError, "candidate must not be"),
        (lambda: edge_distances(IMAGE), ValueError, "grey must be"),
        (lambda: edge_distances(square(), most=0.0), ValueError, "most must be"),
        (lambda: edge_picture(square(), thresholds=(9.0, 3.0)), ValueError, "thresholds must rise"),
        (lambda: distance_transform(square()), TypeError, "edges must be truth values"),
        (lambda: distance_transform(np.ones(4, bool)), ValueError, "edges must be .height"),
        (
            lambda: sampled(-np.ones((3, 3)), np.zeros((1, 1, 2)), 1.0),
            ValueError,
            "not be negative",
        ),
        (
            lambda: contour_distances(np.ones((3, 3)), drawn(1), np.zeros((0, 2))),
            ValueError,
            "empty",
        ),
        (
            lambda: contour_distances(np.ones((3, 3)), drawn(1) * np.nan, PATCHES[:, :2]),
            ValueError,
            "finite",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong()

"""Rays in a plan: faces as the laser's own cast finds them, ellipses as polygons say."""

import numpy as np
import pytest
import shapely
from shapely import affinity

from data_synth.laser import cast
from data_synth.outlines import cast_outlines

NONE = np.zeros((0, 5))


def rays(count, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (count, 2)), rng.uniform(-np.pi, np.pi, count)


@pytest.mark.parametrize("seed", range(3))
def test_faces_are_met_where_the_laser_meets_them(seed):
    origins, directions = rays(300, seed)
    faces = np.random.default_rng(seed + 10).uniform(-4, 4, (12, 2, 2))
    distances, indices, slants = cast_outlines(origins, directions, faces, NONE)
    expected, which = cast(origins, directions, faces)
    np.testing.assert_allclose(distances, expected, rtol=1e-9)
    np.testing.assert_array_equal(indices, which)
    hit = indices >= 0
    along = np.diff(faces[indices[hit]], axis=1)[:, 0]
    turn = np.arctan2(along[:, 1], along[:, 0]) - directions[hit]
    np.testing.assert_allclose(slants[hit], np.abs(np.arcsin(np.cos(turn))), atol=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_ellipses_are_met_where_a_polygon_is(seed):
    origins, directions = rays(300, seed)
    rng = np.random.default_rng(seed + 20)
    turn = rng.uniform(-np.pi, np.pi, 5)
    middles = rng.uniform(2, 4, (5, 1)) * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    ellipses = np.column_stack([middles, rng.uniform(0.1, 0.9, (5, 2)), rng.uniform(-3, 3, 5)])
    shapes = [
        affinity.translate(
            affinity.rotate(
                affinity.scale(shapely.Point(0, 0).buffer(1, 400), a, b), turn, use_radians=True
            ),
            x,
            y,
        )
        for x, y, a, b, turn in ellipses
    ]
    distances, indices, slants = cast_outlines(
        origins, directions, np.array([[[9.0, -9], [9, 9]]]), ellipses
    )
    assert (indices > 0).sum() > 60
    for k in np.flatnonzero(indices > 0):
        shape = shapes[indices[k] - 1]
        if shape.contains(shapely.Point(origins[k])):
            continue
        ahead = np.array([np.cos(directions[k]), np.sin(directions[k])])
        way = shapely.LineString([origins[k], origins[k] + 20 * ahead])
        meets = [way.intersection(s).distance(shapely.Point(origins[k])) for s in shapes]
        met = min(m for m in meets if m > 0)
        if np.cos(slants[k]) > 0.1:  # a grazing ray misses the polygon
            assert distances[k] == pytest.approx(met, abs=1e-3)
        x, y, a, b, turn = ellipses[indices[k] - 1]
        offset = origins[k] + distances[k] * ahead - [x, y]
        p = np.cos(turn) * offset[0] + np.sin(turn) * offset[1]
        q = np.cos(turn) * offset[1] - np.sin(turn) * offset[0]
        assert (p / a) ** 2 + (q / b) ** 2 == pytest.approx(1)
        normal = np.arctan2(q / b**2, p / a**2) + turn
        assert np.cos(slants[k]) == pytest.approx(-np.cos(normal - directions[k]))


def test_a_ray_does_not_meet_what_it_starts_in_or_what_lies_behind():
    wall = np.array([[[3.0, -1], [3, 1]]])
    around = np.array([[0.0, 0, 0.5, 0.4, 0.3], [-2, 0, 0.5, 0.5, 0]])
    distances, indices, _ = cast_outlines(
        np.zeros((2, 2)), np.array([0.0, np.pi / 2]), wall, around
    )
    np.testing.assert_allclose(distances, [3.0, np.inf])
    np.testing.assert_array_equal(indices, [0, -1])


def test_bad_ellipses_are_named():
    flat = np.array([[0.0, 0, 1, 0, 0]])
    with pytest.raises(ValueError, match=r"ellipses .* 0"):
        cast_outlines(np.zeros((1, 2)), np.zeros(1), np.zeros((0, 2, 2)), flat)

"""A hall seen through a pinhole, by points that are projected on their own."""

import math
from dataclasses import replace

import numpy as np
import pytest

from data_synth.companion.hall import Hall, RobotCamera, make_hall

CAMERA = RobotCamera()
FINE = 48


@pytest.fixture(scope="module")
def hall():
    return make_hall(np.random.default_rng(3))


def marked(hall, wall, along, up):
    """Return the hall in black with a white mark on a wall."""
    walls = [np.zeros_like(paint) for paint in hall.walls]
    row, column = round(FINE * (hall.tall - up)), round(FINE * along)
    walls[wall][row - 3 : row + 4, column - 3 : column + 4] = 1
    return replace(hall, walls=tuple(walls), floor=np.zeros_like(hall.floor))


def seen(hall, pose, camera=CAMERA):
    """Return column and row of the bright mark, below the ceiling."""
    light = hall.view(np.array(pose), camera)[..., 0].copy()
    light[light == np.float32(0.75)] = 0
    rows, columns = np.nonzero(light > 0.4)
    return columns.mean(), rows.mean()


@pytest.mark.parametrize(
    ("wall", "along", "pose"),
    [
        (1, 4.0, (5.0, 4.5, 0.1)),  # x = length, from its left end, which is y = width
        (3, 4.0, (9.0, 4.5, math.pi - 0.1)),  # x = 0 from y = 0
        (2, 6.0, (6.5, 3.0, math.pi / 2)),  # y = width from x = 0
        (0, 6.0, (9.5, 7.0, -math.pi / 2)),  # y = 0 from x = length
    ],
)
def test_a_mark_on_a_wall_appears_where_a_pinhole_shows_it(hall, wall, along, pose):
    place = {
        0: (hall.length - along, 0.0),
        1: (hall.length, hall.width - along),
        2: (along, hall.width),
        3: (0.0, along),
    }[wall]
    dx, dy = place[0] - pose[0], place[1] - pose[1]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
    expected = CAMERA.project(ahead, left, 1.6)
    found = seen(marked(hall, wall, along, 1.6), pose)
    np.testing.assert_allclose(found, expected, atol=1.0)


def test_the_view_turns_and_grows_with_the_robot(hall):
    black = marked(hall, 1, 5.0, 1.9)  # straight ahead, above the camera
    u, v = seen(black, (6.0, 5.0, 0.0))
    assert seen(black, (6.0, 5.0, 0.1))[0] == pytest.approx(u + 386 * math.tan(0.1), abs=1)
    nearer = seen(black, (11.0, 5.0, 0.0))[1]
    middle = CAMERA.middle[1]
    assert (nearer - middle) / (v - middle) == pytest.approx(2, abs=0.1)


def test_the_floor_lies_below_and_the_ceiling_above(hall):
    red = replace(hall, floor=np.full_like(hall.floor, 0.5))
    light = red.view(np.array([3.0, 5.0, 0.0]), CAMERA)
    edge = CAMERA.project(13.0, 0.0, 0.0)[1], CAMERA.project(13.0, 0.0, 3.0)[1]
    is_floor, is_ceiling = (light == 0.5).all(axis=-1), (light == 0.75).all(axis=-1)
    assert is_floor[math.ceil(edge[0]) :, 160].all()
    assert is_ceiling[: math.floor(edge[1]), 160].all()
    assert not (is_floor | is_ceiling)[math.ceil(edge[1]) : math.floor(edge[0]), 160].any()


def test_the_same_seed_gives_the_same_hall():
    one, other = (make_hall(np.random.default_rng(5)) for _ in range(2))
    for a, b in zip((*one.walls, one.floor), (*other.walls, other.floor), strict=True):
        np.testing.assert_array_equal(a, b)
    assert isinstance(one, Hall)
    assert all(wall.min() > 0 and wall.max() <= 1 for wall in one.walls)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda hall: hall.view(np.array([0.0, 5.0, 0.0]), CAMERA), "pose must be inside 16 x 10"),
        (lambda hall: hall.view(np.array([1.0, np.nan, 0.0]), CAMERA), "pose must be finite"),
        (lambda hall: make_hall(np.random.default_rng(0), length=1.0), "length must be"),
        (lambda hall: RobotCamera(focal=0.0), "focal must be"),
        (lambda hall: RobotCamera(height=9.0), "height must be"),
        (lambda hall: CAMERA.project(0.0, 1.0, 1.0), "ahead must be"),
    ],
)
def test_what_is_wrong_is_named(hall, wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong(hall)

"""The fisheye camera: marks, pictures and boxes lie where the projection says, in their light."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from data_synth.fisheye import Bodies, Fisheye, Stage, expose, linear, view

CAMERA = Fisheye()
POSE = np.array([0.3, -0.4, 0.5])
EMPTY = np.zeros((0, 3))
NOBODY = Bodies(EMPTY, np.zeros((0, 3, 3)), EMPTY, EMPTY, *np.zeros((3, 0), dtype=int))
LIGHT = np.ones((3, 3))


def stage(*, boxes=(), spans=(), hung=(), paint=0.0, picture=None):
    """A room of 8 m with walls that send nothing back; boxes and hangings are white."""
    ring = np.array([[-4.0, -4], [4, -4], [4, 4], [-4, 4]])
    count, high = len(boxes), 2.7
    plan = np.zeros((10, 10), dtype=np.uint8)
    first = np.array([0, len(hung), len(hung), len(hung), len(hung)])
    return Stage(
        np.stack([ring, np.roll(ring, -1, axis=0)], axis=1),
        np.full((4, 3), paint),
        np.zeros(4, dtype=int),
        np.array(hung, dtype=float).reshape(-1, 4),
        first,
        np.zeros(len(hung), dtype=int),
        np.ones(len(hung), dtype=int),
        np.array(boxes, dtype=float).reshape(-1, 4, 2),
        np.array(spans, dtype=float).reshape(-1, 2),
        np.ones((count, 3)),
        np.full(count, -1),
        np.ones(count, dtype=int),
        np.ones((1, 4, 4, 3), dtype=np.float32) if picture is None else picture[None],
        plan,
        plan,
        np.array([-4.0, -4.0]),
        0.8,
        high,
    )


def dark(light=1.0):
    """Light 0 out, light 1 on."""
    return np.array([[0.0] * 3, [light] * 3, [0.0] * 3])


def sphere(centre, radius=0.04, paint=1.0, owner=0, head=0, hair=0.0, gaze=0.0):
    cos, sin = np.cos(gaze), np.sin(gaze)
    frame = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) / radius
    return ([*centre], frame, [paint] * 3, [hair] * 3, head, owner, 1)


def bodies(*parts):
    return Bodies(*map(np.array, zip(*parts, strict=True)))


def in_robot(points):
    """Points of the world ahead, to the left and above."""
    gap = np.asarray(points, dtype=float)[:, :2] - POSE[:2]
    cos, sin = np.cos(POSE[2]), np.sin(POSE[2])
    return np.column_stack([gap @ [cos, sin], gap @ [-sin, cos], np.asarray(points)[:, 2]])


def centroid(image):
    weight = image.sum(axis=2)
    rows, columns = np.indices(weight.shape)
    return np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.3, 2.6))
def test_pixels_tell_bearing_and_elevation(ahead, left, up):
    if np.hypot(ahead, left) < 0.05:
        return
    pixel = CAMERA.project(np.array([[ahead, left, up]]))
    assert np.exp(1j * CAMERA.bearing(pixel)[0]) == pytest.approx(
        (ahead + 1j * left) / np.hypot(ahead, left), abs=1e-9
    )
    rise = np.arctan2(up - CAMERA.height, np.hypot(ahead, left))
    assert CAMERA.elevation(pixel)[0] == pytest.approx(rise, abs=1e-9)


def test_ahead_is_down_and_left_is_left():
    u, v = CAMERA.centre_px
    pixels = CAMERA.project(np.array([[1.0, 0, 1.2], [0, 1, 1.2], [0, 0, 2]]))
    quarter = CAMERA.focal_px * np.pi / 2
    np.testing.assert_allclose(pixels, [[u, v + quarter], [u - quarter, v], [u, v]], atol=1e-9)


@pytest.mark.parametrize("turn", np.arange(0, 6.3, 0.7))
@pytest.mark.parametrize(("away", "up"), [(1.0, 1.7), (2.5, 1.3), (0.6, 2.4), (3.0, 0.9)])
def test_marks_lie_where_the_projection_says(turn, away, up):
    mark = [POSE[0] + away * np.cos(turn), POSE[1] + away * np.sin(turn), up]
    seen = view(CAMERA, stage(), POSE, bodies(sphere(mark, 0.05 * away)), dark())
    away_px = centroid(1.0 * (seen.light > 0)) - CAMERA.project(in_robot([mark]))[0]
    assert np.hypot(*away_px) < 0.3


def outline(corners, steps=200):
    """A polygon in pixels of a polygon in space."""
    corners = np.array(corners, dtype=float)
    share = np.linspace(0, 1, steps, endpoint=False)[:, None]
    edges = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return shapely.Polygon(
        CAMERA.project(in_robot(np.concatenate([a + share * (b - a) for a, b in edges])))
    )


def test_a_picture_on_a_wall_lies_where_the_projection_says():
    seen = view(CAMERA, stage(hung=[(2.0, 4.5, 1.0, 2.2)]), POSE, NOBODY, dark()).light
    shape = outline([(-2, -4, 1.0), (0.5, -4, 1.0), (0.5, -4, 2.2), (-2, -4, 2.2)])
    mask = (seen > 0).astype(float)
    assert (seen[..., 0] > 0.3).sum() == pytest.approx(shape.area, rel=0.05)
    assert np.hypot(*(centroid(mask) - [shape.centroid.x, shape.centroid.y])) < 0.3


def test_a_picture_on_a_wall_is_not_mirrored():
    picture = np.zeros((4, 4, 3), dtype=np.float32)
    picture[:2, :2] = 1.0  # upper left
    seen = view(CAMERA, stage(hung=[(2.0, 4.5, 1.0, 2.2)], picture=picture), POSE, NOBODY, dark())
    shape = outline([(-0.75, -4, 1.6), (0.5, -4, 1.6), (0.5, -4, 2.2), (-0.75, -4, 2.2)])
    away = centroid(1.0 * (seen.light > 0)) - [shape.centroid.x, shape.centroid.y]
    assert np.hypot(*away) < 0.3


@pytest.mark.parametrize("span", [(0.9, 1.9), (1.6, 2.2), (0.2, 0.95)])
def test_a_box_covers_what_its_sides_cover(span):
    ring = np.array([[1.0, 0.5], [2.0, 0.8], [1.8, 1.4], [0.8, 1.1]])
    seen = view(CAMERA, stage(boxes=[ring], spans=[span]), POSE, NOBODY, dark()).light
    sides = [
        outline([(*a, span[0]), (*b, span[0]), (*b, span[1]), (*a, span[1])])
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)
    ]
    ends = [outline([(*p, z) for p in ring]) for z in span]
    lens = shapely.Point(CAMERA.centre_px).buffer(CAMERA.focal_px * CAMERA.widest, 200)
    shape = shapely.union_all([*sides, *ends]).intersection(lens)
    mask = 1.0 * (seen.sum(axis=2, keepdims=True) > 0.8)
    assert mask.sum() == pytest.approx(shape.area, rel=0.06)
    assert (
        np.hypot(*(centroid(mask) - [shape.centroid.x, shape.centroid.y])) < 0.4
    )  # cut by the lens


def test_what_is_nearer_hides_what_is_behind():
    mark = [2.5, -0.4, 1.6]
    for away, seen in ((-0.2, False), (0.2, True)):
        left, right = 2.5 + away, 2.6 + away
        ring = np.array([[left, -1.0], [right, -1.0], [right, 0.2], [left, 0.2]])
        black = replace_paint(stage(boxes=[ring], spans=[(0.0, 2.4)]))
        light = view(CAMERA, black, POSE, bodies(sphere(mark)), dark()).light
        assert (light.sum() > 0) == seen
    front = [1.2, -0.4, 1.5]
    one = bodies(sphere(mark, 0.05, 1.0), sphere(front, 0.2, 0.0))
    other = bodies(sphere(front, 0.2, 0.0), sphere(mark, 0.05, 1.0))
    for both in (one, other):
        assert view(CAMERA, stage(), POSE, both, dark()).light.sum() == 0


def replace_paint(scene):
    fields = {name: getattr(scene, name) for name in Stage.__dataclass_fields__}
    return Stage(**fields | {"box_paint": np.zeros_like(scene.box_paint)})


def test_each_thing_is_lit_by_its_light():
    mark = bodies(sphere([1.5, 0.0, 1.6], 0.2, 0.5))
    once = view(CAMERA, stage(paint=0.4), POSE, mark, dark(0.5))
    twice = view(CAMERA, stage(paint=0.4), POSE, mark, dark(1.0))
    np.testing.assert_allclose(twice.light, 2 * once.light, rtol=1e-5)
    coloured = np.array([[0.0] * 3, [0.2, 0.5, 1.0], [0.0] * 3])
    light = view(CAMERA, stage(), POSE, mark, coloured).light
    np.testing.assert_allclose(light[..., 0], 0.2 * light[..., 2], rtol=1e-5, atol=1e-7)


def test_turning_the_robot_turns_the_picture():
    mark = bodies(sphere([1.5, 0.7, 1.6], 0.2))
    one, other = (
        view(CAMERA, stage(), np.array([0.3, -0.4, h]), mark, dark()).light for h in (0.5, 0.9)
    )
    bearing = [CAMERA.bearing(centroid(image)[None])[0] for image in (one, other)]
    assert bearing[0] - bearing[1] == pytest.approx(0.4, abs=0.003)


def test_a_face_is_skin_and_the_back_of_a_head_is_hair():
    at = [POSE[0] + 1.2, POSE[1], 1.65]
    faces = [
        view(CAMERA, stage(), POSE, bodies(sphere(at, 0.1, 0.5, 1, head, 0.02, gaze)), dark()).faces
        for head in (1, 2)
        for gaze in (np.pi, 0.0)
    ]
    front, back, long_front, long_back = (float(f[1]) for f in faces)
    area = (CAMERA.focal_px * 0.1 / 1.2) ** 2 * np.pi  # of the disc, at least
    assert 0.5 * area < front < 1.2 * area
    assert back < 0.35 * front
    assert long_back == 0
    assert 0.3 * front < long_front < front


def test_an_image_shows_colours_as_they_are():
    quiet = replace(CAMERA, read_noise=0.0, photon_noise=0.0)
    colour = np.array([200, 120, 60])
    light = np.broadcast_to(linear(colour), (320, 320, 3)).copy()
    image = expose(quiet, light, 1.0, rng=np.random.default_rng(0))
    np.testing.assert_allclose(image[160, 160], colour[::-1], atol=1)
    rim = np.round(CAMERA.centre_px[0] + CAMERA.focal_px * (CAMERA.widest + 0.05)).astype(int)
    assert image[160, min(rim, 319)].max() == 0


def test_noise_grows_with_the_light():
    middle = np.s_[150:170, 150:170]
    for value, gain in ((0.02, 1.0), (0.4, 1.0), (0.1, 3.0)):
        light = np.full((320, 320, 3), value)
        rng = np.random.default_rng(1)
        image = np.stack([expose(CAMERA, light, gain, rng=rng)[middle] for _ in range(10)])
        back = (image / 255) ** 2.2 / gain
        expected = np.sqrt(CAMERA.read_noise**2 + CAMERA.photon_noise * value)
        assert back.std() == pytest.approx(expected, rel=0.1)
        assert back.mean() == pytest.approx(value, rel=0.05)


def test_the_same_view_twice_is_the_same():
    mark = bodies(sphere([1.5, 0.7, 1.6], 0.2))
    scene = stage(paint=0.3)
    first = view(CAMERA, scene, POSE, mark, LIGHT).light
    np.testing.assert_array_equal(view(CAMERA, scene, POSE, mark, LIGHT).light, first)
    alone = view(CAMERA, scene, POSE, NOBODY, LIGHT).light
    assert np.abs(alone - first).max() > 0.1
    assert cv2.countNonZero((np.abs(alone - first).max(axis=2) > 0).astype(np.uint8)) < 5000


def test_missing_lights_are_named():
    with pytest.raises(ValueError, match="light must be one for each of 2, got 1"):
        view(CAMERA, stage(hung=[(2.0, 4.5, 1.0, 2.2)]), POSE, NOBODY, np.ones((1, 3)))

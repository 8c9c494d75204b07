"""One floor for all sensors: what one sees the others see at the same place."""

from types import SimpleNamespace

import numpy as np
import pytest

import data_synth.day.building as module
from data_synth.companion.hall import RobotCamera
from data_synth.day.building import make_building
from data_synth.outlines import cast_outlines
from data_synth.stereo import Rig, surface_points

CAMERA = RobotCamera()
HERE = np.array([6.0, 1.0, 0.3])
NOBODY = np.zeros((0, 3))


@pytest.fixture(scope="module")
def building():
    return make_building(rng=np.random.default_rng(5))


def test_a_seed_makes_one_building(building):
    again = make_building(rng=np.random.default_rng(5))
    np.testing.assert_array_equal(building.scene.frames, again.scene.frames)
    np.testing.assert_array_equal(building.above.ceiling.texture, again.above.ceiling.texture)
    other = make_building(rng=np.random.default_rng(6))
    assert not np.array_equal(building.above.ceiling.texture, other.above.ceiling.texture)


def test_what_hangs_on_walls_keeps_its_colours():
    """The hall paints in blue, green, red; the eyes of the robot see red, green, blue."""
    painted = np.zeros((1, 8, 8, 3))
    painted[..., :] = [0.0, 0.2, 0.7]
    stage, ceiling = SimpleNamespace(pictures=painted), SimpleNamespace(texture=np.zeros((8, 8)))
    *_, hung = module._pictures(stage, ceiling, np.random.default_rng(1))
    red, green, blue = hung[0, 0]
    assert red > green > blue == 0


@pytest.mark.parametrize("heading", [-2.5, -1.1, 0.3, 1.6, 2.9])
def test_the_pair_sees_what_a_laser_at_its_height_meets(building, heading):
    """Along the middle row a ray is level: what it meets is as far as a beam in the plan."""
    rig, pose = Rig(), np.array([*HERE[:2], heading])
    columns = np.linspace(5, rig.size[0] - 6, 24)
    pixels = np.column_stack([columns, np.full(24, rig.centre_px[1])])
    seen = surface_points(building.scene, rig, pose, pixels).points
    turns = heading + np.arctan((rig.centre_px[0] - columns) / rig.focal_px)
    faces, posts = building.office.section(rig.height)
    round_ = np.column_stack([posts, posts[:, 2], np.zeros(len(posts))])
    beams, _, _ = cast_outlines(np.tile(pose[:2], (24, 1)), turns, faces, round_)
    away = np.hypot(*(seen[:, :2] - pose[:2]).T)
    near = np.abs(away - beams) < 0.05  # pictures hang 15 mm before the wall; posts are cut edges
    assert near.mean() > 0.85


def test_colours_are_those_of_the_grey_picture(building):
    light = building.ahead(CAMERA, HERE)
    assert light.shape == (*CAMERA.size, 3)
    assert 0 <= light.min() < light.max() <= 1.0
    rig = Rig(focal_px=CAMERA.focal, size=CAMERA.size[::-1], height=CAMERA.height, blur_px=0.0,
              read_noise=0.0, photon_noise=0.0, vignetting=0.0, imbalance=0.0)  # fmt: skip
    grey = building.pair(rig, HERE, rng=np.random.default_rng(0)).left
    mixed = 255 * light ** (1 / 2.2) @ [0.299, 0.587, 0.114]
    assert np.median(np.abs(mixed - grey)) < 1.5


def test_the_ceiling_is_that_of_both_cameras(building):
    """The texel above the robot is in the middle of the picture of the ceiling's camera."""
    mount = building.above.mount
    column, row = (round(one) for one in mount.middle)
    there = HERE[:2] - building.middle
    (u, v), texture = building.above.ceiling.texels(there[None])[0], building.above.ceiling.texture
    around = texture[round(v) - 2 : round(v) + 3, round(u) - 2 : round(u) + 3].mean()
    shown = building.overhead(HERE, NOBODY, rng=np.random.default_rng(0))
    assert abs(shown[row - 1 : row + 2, column - 1 : column + 2].mean() - around) < 8


def test_a_head_hides_the_ceiling_where_it_is(building):
    ahead = HERE[:2] + 0.4 * np.array([np.cos(HERE[2]), np.sin(HERE[2])])
    clear, hidden = (
        building.overhead(HERE, heads, rng=np.random.default_rng(0)).astype(int)
        for heads in (NOBODY, np.array([[*ahead, 1.6]]))
    )
    changed = np.abs(hidden - clear) > 12
    rows, columns = np.nonzero(changed)
    u, v = building.above.mount.middle
    assert columns.mean() - u > 30  # columns run ahead
    assert abs(rows.mean() - v) < 8


def test_walls_hide_a_place_and_nothing_hides_one_that_is_near(building):
    along = np.array([2.0, 1.2, 0.0])
    room = building.office.rooms[1]
    places = np.array([[5.0, 1.2], (room[:2] + room[2:]) / 2, [0.5, 1.2]])
    assert building.in_sight(CAMERA, along, places).tolist() == [True, False, False]

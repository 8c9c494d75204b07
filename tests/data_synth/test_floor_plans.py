"""Ten floor plans: closed rooms, a way through each that touches nothing, look-alikes or none."""

from functools import cache

import numpy as np
import pytest
import shapely

from data_synth.floor_plans import LENGTH, NAMES, PLANS, make_floor
from data_synth.stereo import Rig, surface_points
from data_synth.textured_building import drive
from tests.data_synth.rooms import standing, walls_where_a_laser_finds_them

each_plan = pytest.mark.parametrize("plan", range(len(PLANS)), ids=NAMES)
HUNG = "poster", "notices", "books", "door", "drawers", "window"


@cache
def floor(plan):
    """Return a building of a plan, look-alikes in every second one."""
    return make_floor(plan, alike=plan % 2 == 0, rng=np.random.default_rng(plan))


def way(plan, seed=0):
    return drive(floor(plan), rng=np.random.default_rng(seed))


@each_plan
def test_a_route_is_as_long_as_the_papers(plan):
    steps = np.hypot(*np.diff(way(plan)[:, :2], axis=0).T)
    assert steps.sum() == pytest.approx(LENGTH, abs=2)
    assert steps.max() < 0.25


@each_plan
def test_the_drive_keeps_clear_of_all_that_stands(plan):
    low = standing(floor(plan))
    for seed in range(3):
        assert shapely.LineString(way(plan, seed)[:, :2]).distance(low) > 0.27


@each_plan
def test_no_ray_leaves_the_building(plan):
    rows, columns = np.mgrid[0:240:16, 0:320:10]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=-1)
    for pose in way(plan)[::30]:
        assert (surface_points(floor(plan).scene, Rig(), pose, pixels).surfaces >= 0).all()


@each_plan
def test_walls_stand_where_a_laser_finds_them(plan):
    assert walls_where_a_laser_finds_them(floor(plan), way(plan)[::40]) > 100


@each_plan
def test_cells_do_not_overlap_and_doors_lie_between_two(plan):
    boxes = [shapely.box(c.west, c.south, c.east, c.north) for c in PLANS[plan].cells]
    for k, one in enumerate(boxes):
        assert all(one.intersection(other).area == 0 for other in boxes[:k])
    for door in PLANS[plan].doors:
        assert sum(box.boundary.distance(shapely.Point(door)) < 1e-9 for box in boxes) == 2


@each_plan
def test_pictures_are_used_again_or_not_at_all(plan):
    building, most = floor(plan), []
    for kind in HUNG:
        shown = building.scene.pictures[building.kinds == kind]
        most.append(np.unique(shown, return_counts=True)[1].max() if len(shown) else 0)
    assert max(most) == 1 if plan % 2 else max(most) > 3


def test_plans_have_loops_or_dead_ends():
    """A plan of dead ends leads back the way it came; a loop does not."""
    back = set()
    for plan, name in enumerate(NAMES):
        poses = way(plan)
        near = np.hypot(*(poses[:, None, :2] - poses[:, :2]).T) < 0.4
        against = np.cos(poses[:, None, 2] - poses[:, 2]) < -0.9
        back |= {name} if (near & against).any(axis=1).mean() > 0.2 else set()
    assert back == {"comb", "bent", "three arms", "cross", "long", "zigzag"}


def test_the_same_numbers_give_the_same_building():
    one, other = (make_floor(3, alike=True, rng=np.random.default_rng(5)) for _ in range(2))
    assert (one.scene.frames == other.scene.frames).all()
    assert (one.scene.pictures == other.scene.pictures).all()

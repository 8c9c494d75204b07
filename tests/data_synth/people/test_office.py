"""The office with people: free ways, legs that look like legs, and lights that go out."""

import numpy as np
import pytest
import shapely

from data_synth.people import World, make_people_office
from tests.data_synth.offices import office as made

each_office = pytest.mark.parametrize("office", range(3), indirect=True)


@pytest.fixture
def office(request):
    return made(request.param)


def middles(office):
    return (office.rooms[:, :2] + office.rooms[:, 2:]) / 2


def solids(office):
    return [shapely.Polygon(ring) for ring in office.stage.boxes[: office.boxes]]


@each_office
def test_the_middle_of_each_room_is_free_and_can_be_reached(office):
    centres = middles(office)
    assert (office.free(centres) > 0.7).all()
    world = World(office, (), (), np.array([*centres[0], 0.0]), rng=np.random.default_rng(0))
    for goal in [*centres[1:], *office.exits]:
        way = world.way(centres[0], goal)
        assert np.hypot(*np.diff(way, axis=0).T).max() < 0.3
        assert (office.free(way) > 0.25).all()
        np.testing.assert_allclose(way[-1], goal)


@each_office
def test_clearance_is_the_distance_to_what_stands(office):
    rng = np.random.default_rng(1)
    places = rng.uniform(office.rooms[:, :2].min(0), office.rooms[:, 2:].max(0), (300, 2))
    low = office.stage.spans[: office.boxes, 0] < 1.9
    things = [ring for ring, is_low in zip(solids(office), low, strict=True) if is_low]
    things += [shapely.Point(x, y).buffer(r) for x, y, r, _ in office.posts]
    things += [shapely.LineString(ends) for ends in office.stage.walls]
    standing = shapely.union_all(things)
    inside = office.free(places) > 0.1
    assert inside.sum() > 100
    away = shapely.distance(standing, shapely.points(places[inside]))
    assert np.abs(away - office.free(places[inside])).max() < 0.15  # two cells and rounding


@each_office
def test_furniture_stands_in_rooms_and_not_in_each_other(office):
    boxes = [
        (solid, span)
        for solid, span in zip(solids(office), office.stage.spans, strict=False)
        if span[1] - span[0] > 0.3
    ]
    for k, (one, (low, high)) in enumerate(boxes):
        for other, (bottom, top) in boxes[:k]:
            shared = min(high, top) > max(low, bottom) + 0.06  # leaves of plants
            assert not shared or one.intersection(other).area < 1e-9
    floor = shapely.union_all([shapely.box(*room) for room in office.rooms]).buffer(0.13)
    assert all(floor.contains(solid) for solid in solids(office))


@each_office
def test_walls_have_the_free_space_to_their_left(office):
    ends = office.stage.walls
    way = np.diff(ends, axis=1)[:, 0]
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1) / np.hypot(*way.T)[:, None]
    floor = shapely.union_all([shapely.box(*room) for room in office.rooms]).buffer(0.07)
    beside = ends.mean(axis=1) + 0.05 * left
    assert shapely.contains(floor, shapely.points(beside)).all()


@each_office
def test_a_cut_at_the_height_of_the_laser_meets_legs(office):
    faces, circles = office.section(0.3)
    assert ((circles[:, 2] > 0.01) & (circles[:, 2] < 0.06)).sum() > 20  # of tables and chairs
    assert ((circles[:, 2] > 0.1) & (circles[:, 2] < 0.16)).sum() > 3  # baskets
    pairs = np.hypot(*(circles[:, None, :2] - circles[:, :2]).transpose(2, 0, 1))
    assert ((pairs > 0.08) & (pairs < 0.5)).any()
    assert len(office.section(2.3)[1]) == 0
    lower, upper = (len(office.section(h)[0]) for h in (0.3, 0.72))
    assert upper > lower  # the tops of the tables
    np.testing.assert_array_equal(faces[: len(office.stage.walls)], office.stage.walls)


def test_without_distractors_nothing_stands_on_legs_or_looks_like_skin():
    assert len(made(0, distractors=False).posts) == 0
    assert len(made(0).posts) > 30

    def red_over_blue(office):
        pictures = office.stage.pictures[[0, 1, 2, 3]]  # door, timber, planks
        return (pictures[..., 2].mean() + 1e-9) / pictures[..., 0].mean()

    assert red_over_blue(made(0)) > 2
    assert red_over_blue(made(0, distractors=False)) < 1.1


@each_office
def test_lights_differ_from_room_to_room_wander_and_go_out(office):
    light = office.light(0.0)
    assert light.shape == (len(office.rooms) + 1, 3)
    warm = light[:, 2] / light[:, 0]
    assert warm[:-1].max() / warm[:-1].min() > 1.1
    later = np.array([office.light(t) for t in np.arange(0, 100, 5.0)])
    assert (later.std(axis=0) > 0).all()
    assert (later.std(axis=0) < 0.4 * light).all()
    out = np.full(len(office.rooms), np.inf)
    out[2] = 10.0
    np.testing.assert_array_equal(office.light(9.9, out), office.light(9.9))
    gone, before = office.light(10.0, out), office.light(10.0)
    assert (gone[2] < 0.4 * before[2]).all()
    assert (gone[2] > 0).all()
    np.testing.assert_array_equal(np.delete(gone, 2, 0), np.delete(before, 2, 0))


@each_office
def test_each_room_has_its_own_light(office):
    np.testing.assert_array_equal(
        office.stage.light_at(middles(office)), np.arange(len(office.rooms))
    )
    for k, place in enumerate(middles(office)):
        assert office.room_of(place) == k


def test_the_same_seed_makes_the_same_office():
    again = make_people_office(rng=np.random.default_rng(0))
    np.testing.assert_array_equal(again.stage.boxes, made(0).stage.boxes)
    np.testing.assert_array_equal(again.stage.pictures, made(0).stage.pictures)
    assert len(made(1).stage.boxes) != len(made(0).stage.boxes)

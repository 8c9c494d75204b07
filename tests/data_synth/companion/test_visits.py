"""Visits: who stands where, what the camera sees of it, and when."""

import numpy as np
import pytest

from data_synth.companion.hall import RobotCamera, make_hall
from data_synth.companion.visits import (
    START,
    Stance,
    make_visit,
    make_visitor,
    see,
)

CAMERA = RobotCamera()
POSE = np.array(START)


@pytest.fixture(scope="module")
def hall():
    return make_hall(np.random.default_rng(3))


@pytest.fixture(scope="module")
def visit():
    return make_visit(np.random.default_rng(5))


def sight(hall, *stances, pose=POSE, seed=1, **more):
    who = make_visitor(np.random.default_rng(7))
    people = [(who, stance) for stance in stances]
    return see(hall, CAMERA, pose, people, rng=np.random.default_rng(seed), **more)


def changed(one, other):
    return np.abs(one.image.astype(int) - other.image).max(axis=2) > 12


def inside(box):
    left, top, wide, high = np.rint(box).astype(int)
    return slice(max(top, 0), top + high), slice(max(left, 0), left + wide)


def test_a_raised_hand_is_what_has_changed_and_is_where_its_square_is(hall):
    down, up = (sight(hall, Stance(6.2, 5.0, raised=r)) for r in (0.0, 1.0))
    assert np.isnan(down.hands).all()
    assert changed(down, up)[inside(up.hands[0])].mean() > 0.3
    assert up.hands[0, 1] + up.hands[0, 3] / 2 < up.faces[0, 1]  # above the face
    assert up.hands[0, 0] > up.faces[0, 0]  # the left hand, as it faces the camera


def test_a_hand_beside_the_body_is_below_the_upper_edge_of_the_face(hall):
    beside = sight(hall, Stance(6.2, 5.0, raised=1.0, beside=True))
    assert beside.hands[0, 1] + beside.hands[0, 3] / 2 > beside.faces[0, 1]


def test_a_tilt_turns_the_hand_about_the_middle_of_its_sprite(hall):
    straight, tilted = (sight(hall, Stance(6.2, 5.0, raised=1.0, tilt=t)) for t in (0.0, np.pi / 2))
    middles = [box[:2] + box[2:] / 2 for box in (straight.hands[0], tilted.hands[0])]
    turned = middles[1] - middles[0]
    assert turned[0] > 0
    assert turned[1] == pytest.approx(turned[0], abs=1e-6)


def test_who_is_twice_as_far_is_half_as_tall(hall):
    near, far = (sight(hall, Stance(4.0 + d, 5.0)) for d in (2.0, 4.0))
    assert near.boxes[0, 3] == pytest.approx(2 * far.boxes[0, 3])
    assert near.faces[0, 2] == pytest.approx(2 * far.faces[0, 2])


def test_one_to_the_left_stands_left_and_a_turn_of_the_robot_moves_all(hall):
    left = sight(hall, Stance(6.5, 5.5))
    assert left.boxes[0, 0] + left.boxes[0, 2] / 2 < CAMERA.middle[0]
    turned = sight(hall, Stance(6.5, 5.5), pose=np.array([4, 5, np.arctan2(0.5, 2.5)]))
    assert turned.boxes[0, 0] + turned.boxes[0, 2] / 2 == pytest.approx(CAMERA.middle[0])
    straight = sight(hall, Stance(4 + np.hypot(2.5, 0.5), 5.0))
    assert turned.boxes[0, 3] == pytest.approx(straight.boxes[0, 3])  # as far as it is


def test_faces_are_marked_of_those_who_look_at_the_robot(hall):
    looks = [Stance(6.5, 5.0), Stance(6.5, 5.0, np.pi), Stance(6.5, 5.0, 0.0),
             Stance(6.5, 5.0, np.pi / 2)]  # fmt: skip
    faces = [np.isfinite(sight(hall, stance).faces).all() for stance in looks]
    assert faces == [True, True, False, False]


def test_who_is_behind_the_robot_is_not_seen(hall):
    behind, nobody = sight(hall, Stance(2.0, 5.0)), sight(hall)
    assert np.isnan(behind.boxes).all()
    np.testing.assert_array_equal(behind.image, sight(hall, Stance(1.5, 5.0)).image)
    assert nobody.boxes.shape == (0, 4)


def test_the_nearer_one_hides_the_other(hall):
    both = sight(hall, Stance(8.0, 5.0), Stance(6.0, 5.0))
    swapped = sight(hall, Stance(6.0, 5.0), Stance(8.0, 5.0))
    np.testing.assert_allclose(both.boxes, swapped.boxes[::-1])
    alone = sight(hall, Stance(6.0, 5.0))
    rows, columns = inside(alone.boxes[0])
    middle = slice(columns.start + 20, columns.stop - 20)
    differs = changed(both, alone)[rows, middle].mean()
    assert differs < 0.2


def test_a_visit_comes_in_turn_and_a_brief_one_is_shorter(visit):
    names = [order.what for order in visit.orders]
    assert names[:4] == ["a stranger's hand", "tutor", "hand above", "walks"]
    assert names[-1] == "leaves"
    gaps = [b.first - a.last for a, b in zip(visit.orders, visit.orders[1:], strict=False)]
    assert min(gaps) >= 1
    brief = make_visit(np.random.default_rng(5), brief=True)
    assert brief.frames < 0.6 * visit.frames
    assert "hand beside" not in [order.what for order in brief.orders]


def test_nobody_jumps(visit):
    places: dict[int, list] = {}
    for frame in range(visit.frames):
        for who, stance in visit.at(frame):
            places.setdefault(id(who), []).append((frame, stance.x, stance.y))
    assert len(places) == 3
    for way in places.values():
        frames, x, y = np.array(way).T
        steps = np.hypot(np.diff(x), np.diff(y))[np.diff(frames) == 1]
        assert steps.max() < 0.25


def test_hands_rise_while_ordered_and_rest_otherwise(visit):
    def raised(frame):
        return next(s.raised for who, s in visit.at(frame) if who is visit.tutor)

    for what in ("hand above", "halt", "hand beside"):
        order = visit.order(what)
        assert raised((order.first + order.last) // 2) == 1
        assert 0 < raised(order.first) < 1
    assert raised(visit.order("tutor").last) == 0
    assert raised(visit.order("hand down").first + 2) == 0


def test_the_passer_crosses_the_way_between_robot_and_tutor(visit):
    walks = visit.order("walks")
    when = (walks.first + walks.last) // 2
    found = dict(visit.at(when))
    tutor, passer = found[visit.tutor], found[visit.passer]
    assert passer.x < tutor.x
    assert np.hypot(passer.x - tutor.x, passer.y - tutor.y) < 2


def test_an_order_that_nobody_gives_is_named(visit):
    with pytest.raises(ValueError, match="'sing'"):
        visit.order("sing")
    with pytest.raises(ValueError, match="frame"):
        visit.at(visit.frames)

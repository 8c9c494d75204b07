"""People of a day: one and the same to each sensor, and where their acts say."""

import numpy as np
import pytest

from data_synth.companion.hall import RobotCamera
from data_synth.day import acts
from data_synth.day.building import make_building

CAMERA = RobotCamera()
ROBOT = np.array([3.0, 1.2, 0.0])


@pytest.fixture(scope="module")
def building():
    return make_building(rng=np.random.default_rng(7))


@pytest.fixture(scope="module")
def people():
    return [acts.make_someone(np.random.default_rng(k)) for k in range(3)]


def test_somebody_wears_one_shirt_and_has_one_skin(people):
    for one in people:
        shirt = (np.array(one.person.shirt) / 255) ** 2.2
        np.testing.assert_allclose(shirt, one.visitor.clothes.shirt, atol=0.01)
        assert one.body.outfit.shirt == one.visitor.clothes.shirt
        assert one.body.identity is one.visitor.identity
        assert one.person.tone == min(one.visitor.identity.tone / 5, 1.0)
    assert people[0].person.shirt != people[1].person.shirt


def test_who_leads_goes_there_and_back_and_touches_nothing(building):
    path = acts.led_path(building, rng=np.random.default_rng(1))
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert steps.max() < 0.06
    assert building.office.free(path[:, :2]).min() > 0.25  # the radius of the robot
    assert path[0, 2] == 0
    assert path[-1, 2] == pytest.approx(np.pi)
    assert np.ptp(path[:, 0]) > 15
    assert abs(path[0, 0] - path[-1, 0]) < 0.3
    turned = np.abs(np.diff(path[:, 2]))
    assert turned.max() < 0.06


def walked(act, until, command=(0.0, 0.0)):
    """Return the moments of an act, ten a second."""
    found = []
    while act.world.now.time < until:
        found.append(act.world.advance(0.1, command))
    return found


def test_a_visitor_comes_along_and_two_step_aside_when_they_are_asked(building, people):
    robot = np.array([15.0, acts.WEST, np.pi])
    act = acts.guided_tour(building, people, robot, 5.0, rng=np.random.default_rng(2))
    before = walked(act, 2.0)[-1]
    assert np.hypot(*(before.positions[0] - robot[:2])) < 1.8
    assert np.abs(before.positions[1:, 1] - acts.WEST).max() < 0.4
    acts.clear_the_way(act)
    after = walked(act, 6.0)[-1]
    assert np.abs(after.positions[1:, 1] - acts.WEST).min() > 0.9


def test_hands_go_up_when_they_should_and_are_seen_above_the_face(building, people):
    act = acts.tutor_comes(building, people, ROBOT, rng=np.random.default_rng(3))
    seen = {}
    for moment in walked(act, 29.0):
        for at in (8.5, 12.0, 24.0, 28.0):
            if abs(moment.time - at) < 0.01:
                seen[at] = act.look(CAMERA, moment, rng=np.random.default_rng(0))
    raised = {at: np.isfinite(one.hands[:, 0]).tolist() for at, one in seen.items()}
    assert raised[8.5][0]
    assert not raised[8.5][1]
    assert not any(raised[12.0])
    assert not any(raised[24.0])
    assert raised[28.0][1]
    assert not raised[28.0][0]
    both = seen[28.0]
    assert both.hands[1, 1] + both.hands[1, 3] < both.faces[1, 1] + both.faces[1, 3]


def test_the_box_of_somebody_is_where_they_stand(building, people):
    act = acts.tutor_comes(building, people, ROBOT, rng=np.random.default_rng(3))
    moment = walked(act, 8.0)[-1]
    seen = act.look(CAMERA, moment, rng=np.random.default_rng(0))
    ahead, left = moment.positions[0] - ROBOT[:2]
    column, _ = CAMERA.project(float(ahead), float(left), 1.2)
    assert abs(seen.boxes[0, 0] + seen.boxes[0, 2] / 2 - column) < 6
    assert not np.isfinite(seen.boxes[1]).any()  # the tutor has not come yet


@pytest.mark.parametrize(("door", "side"), [(np.array([6.0, 2.4]), -1), (np.array([6.0, 0.0]), 1)])
def test_an_arm_points_to_the_side_of_the_door(building, people, door, side):
    """Pixels that change lie to the left of the person for a door to the left of the robot."""
    place = np.array([6.2, 1.2])
    shown = acts.pointing(
        building, people[1], place, np.array([4.0, 1.2, 0.0]), door, CAMERA,
        rng=np.random.default_rng(0), pictures=12,
    )  # fmt: skip
    changed = np.abs(shown[-1].astype(int) - shown[0]).max(axis=2) > 60
    columns = np.nonzero(changed)[1] - CAMERA.middle[0]
    assert len(columns) > 50
    assert side * np.median(columns) > 10


def test_nobody_points_behind_a_wall_of_flesh(building, people):
    with pytest.raises(ValueError, match="target must be where an arm reaches"):
        acts.pointing(
            building, people[1], np.array([6.2, 1.2]), np.array([4.0, 1.2, 0.0]),
            np.array([12.0, 1.2]), CAMERA, rng=np.random.default_rng(0),
        )  # fmt: skip

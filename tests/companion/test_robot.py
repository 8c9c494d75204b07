"""The robot, whose detectors are told what to find: its link, its windows, its states."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import Recognition
from robot_perception.companion.faces.icondensation import (
    FaceFilter,
    FaceFilterRules,
    FaceFilterState,
)
from robot_perception.companion.faces.link import Link, LinkRules, SeenFace
from robot_perception.companion.faces.region import FaceTracker, RegionState
from robot_perception.companion.following import Follower
from robot_perception.companion.hands.boosting import Boosted
from robot_perception.companion.hands.cascade import Cascade, HandDetector, Stage
from robot_perception.companion.hands.features import feature_pool
from robot_perception.companion.interaction import (
    Event,
    Interaction,
    InteractionState,
    StateTable,
    Transition,
    paper_table,
)
from robot_perception.companion.robot import (
    EVENTS,
    CompanionRobot,
    RobotRules,
    RobotState,
    body_of,
    face_of,
)
from robot_perception.companion.tutor import TutorModel, TutorRules, TutorTracker

FACE = np.array([140.0, 40, 40, 40])
ABOVE, BESIDE = np.array([200.0, 5, 30, 30]), np.array([200.0, 60, 30, 30])
NONE = np.zeros((0, 4))
STUMPS = Boosted(np.array([0]), np.zeros(1), np.array([1]), np.ones(1))
HANDS = HandDetector(Cascade(feature_pool(np.random.default_rng(0), 1), (Stage(STUMPS, 0.5),)))
FEW = TutorTracker(TutorModel(), TutorRules(particles=20, gate=0.3, whole_gate=0.4))
IMAGE = np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)
KEEPS = Follower(300.0, 200.0)


@pytest.fixture
def sees(monkeypatch):
    """What the detectors find, and in which windows they are asked to look."""
    found = {"faces": FACE[None], "hands": NONE, "windows": []}

    def faces(self, image, window=None, sides=None):
        found["windows"].append(("face", window))
        return found["faces"]

    def hands(self, image, window=None, sides=None):
        found["windows"].append(("hand", window))
        return found["hands"]

    monkeypatch.setattr(FaceDetector, "find", faces)
    monkeypatch.setattr(HandDetector, "find", hands)
    return found


def robot(**parts) -> CompanionRobot:
    parts = {"tracker": FEW, "follower": KEEPS} | parts
    parts = {"recognise": lambda grey, box: "ann"} | parts
    return CompanionRobot(hands=HANDS, **parts)


def run(machine, state, count, image=IMAGE):
    """Return the state after so many pictures, the last info, and the names of the states."""
    rng, names, info = np.random.default_rng(2), [], None
    for _ in range(count):
        state, info = machine.step(state, image, rng=rng)
        names.append(state.name)
    return state, info, names


def idle(machine):
    return run(machine, machine.start(), 5)[0]


def test_a_body_below_a_face_has_that_face():
    np.testing.assert_allclose(face_of(body_of(FACE)), FACE, atol=1e-9)
    left, top, wide, high = body_of(FACE)
    assert left < FACE[0] < FACE[0] + FACE[2] < left + wide
    assert top < FACE[1] < FACE[1] + 3 * FACE[3] < top + high


def test_a_face_is_identified_and_the_robot_idles_with_its_tutor(sees):
    machine = robot()
    state, info, names = run(machine, machine.start(), 5)
    assert names == ["wait", "identify", "identify", "identify", "idle"]
    assert state.link.name == "ann"
    assert info.held == 0
    np.testing.assert_array_equal(info.faces[0].box, FACE)
    assert {kind for kind, _ in sees["windows"]} == {"face"}  # hands do not matter yet


def test_a_stranger_has_no_link_and_the_robot_stands(sees):
    machine = replace(robot(), recognise=lambda grey, box: None)
    state, info, names = run(machine, machine.start(), 9)
    assert names[-1] == "identify"
    assert state.link is None
    assert info.held is None
    assert info.command == (0.0, 0.0)


def test_nobody_is_obeyed_without_a_face(sees):
    machine, sees["faces"], sees["hands"] = robot(), NONE, ABOVE[None]
    _, info, names = run(machine, machine.start(), 20)
    assert set(names) == {"wait"}
    assert not len(info.hands)
    assert not any(kind == "hand" for kind, _ in sees["windows"])


def test_faces_and_hands_are_looked_for_round_the_tutor(sees):
    machine = robot()
    state = idle(machine)
    sees["windows"].clear()
    run(machine, state, 1)
    (_, near), (_, wide) = sees["windows"]
    np.testing.assert_allclose(near, [160 - 120, 60 - 120, 240, 240])
    np.testing.assert_allclose(wide, [160 - 200, 60 - 200, 400, 400])
    machine = robot(rules=RobotRules(face_window=1.0, hand_window=2.0))
    sees["windows"].clear()
    run(machine, state, 1)
    assert [window[2] for _, window in sees["windows"]] == [80, 160]


def test_the_robot_turns_to_the_face_that_has_the_link(sees):
    machine = robot()
    state = idle(machine)
    for left, sign in ((200.0, -1), (80.0, 1)):
        sees["faces"] = FACE[None] + [left - FACE[0], 0, 0, 0]
        _, info, _ = run(
            machine, replace(state, link=Link("ann", SeenFace(sees["faces"][0], "ann"))), 1
        )
        assert info.command[0] == 0
        assert np.sign(info.command[1]) == sign
    sees["faces"] = FACE[None] + [159.5 - 20 - FACE[0], 0, 0, 0]
    assert run(machine, state, 1)[1].command == (0.0, pytest.approx(0.0, abs=1e-12))
    assert run(replace(machine, follower=None), state, 1)[1].command == (0.0, 0.0)


def test_a_hand_above_the_face_is_followed_and_one_beside_is_a_gesture(sees):
    machine = robot()
    state = idle(machine)
    for hand, name, pictures in ((ABOVE, "follow", 3), (BESIDE, "gesture", 8)):
        sees["hands"] = hand[None]
        after, info, names = run(machine, state, pictures)
        assert names == ["idle"] * (pictures - 1) + [name]
        assert (after.person is None) == (name != "follow")
        assert len(info.hands) == 1


@pytest.mark.parametrize(("middle", "name"), [(39.9, "follow"), (40.0, "idle")])
def test_a_hand_is_above_if_its_middle_is_above_the_face(sees, middle, name):
    machine = robot()
    sees["hands"] = np.array([[200.0, middle - 15, 30, 30]])
    assert run(machine, idle_without_hand(machine, sees), 3)[0].name == name


def idle_without_hand(machine, sees):
    hands, sees["hands"] = sees["hands"], NONE
    state = idle(machine)
    sees["hands"] = hands
    return state


def test_who_is_not_seen_whole_is_not_followed(sees):
    """The belly is below the picture, where the tracker could not start."""
    machine, sees["hands"] = robot(), ABOVE[None]
    state = idle_without_hand(machine, sees)
    for rows, name in ((240, "follow"), (140, "idle")):  # where it is no gesture either
        assert run(machine, state, 9, IMAGE[:rows])[0].name == name


def test_who_is_followed_starts_where_his_face_says_and_the_link_goes_with_him(sees):
    machine, sees["hands"] = robot(), ABOVE[None]
    state, info, _ = run(machine, idle_without_hand(machine, sees), 3)
    body = body_of(FACE)
    np.testing.assert_allclose(state.person.box, body, atol=0.2 * body[3])
    left, _, wide, high = state.person.box
    assert info.command == KEEPS.command(left + wide / 2 - 159.5, high)
    sees["windows"].clear()
    after, info, _ = run(machine, state, 1)
    ((kind, window),) = sees["windows"]  # no face is looked for
    left, top, wide, high = after.person.box
    assert kind == "hand"
    np.testing.assert_allclose(window, [left - wide, top - 0.6 * high, 3 * wide, 1.4 * high])
    np.testing.assert_allclose(after.link.face.box, face_of(after.person.box))
    assert after.link.name == "ann"
    assert info.faces == ()


def test_the_hand_that_began_the_following_does_not_end_it(sees):
    """It must have been down for five pictures; without the rule it ends it at once."""
    machine, sees["hands"] = robot(), ABOVE[None]
    began = run(machine, idle_without_hand(machine, sees), 3)[0]
    assert began.fresh is False
    assert set(run(machine, began, 10)[2]) == {"follow"}
    sees["hands"] = NONE
    for pictures, fresh in ((4, False), (5, True)):
        down = run(machine, began, pictures)[0]
        assert (down.name, down.fresh, down.quiet) == ("follow", fresh, pictures)
    sees["hands"] = ABOVE[None]
    assert run(machine, down, 3)[2] == ["follow", "follow", "halt"]
    careless = robot(rules=RobotRules(fresh=False))
    began = run(careless, idle_without_hand(careless, sees), 3)[0]
    sees["hands"] = ABOVE[None]
    assert run(careless, began, 3)[0].name == "halt"


def test_after_the_following_faces_are_looked_for_and_nobody_is_tracked(sees):
    machine, sees["hands"] = robot(), ABOVE[None]
    began = run(machine, idle_without_hand(machine, sees), 3)[0]
    sees["hands"] = NONE
    down = run(machine, began, 5)[0]
    sees["hands"] = ABOVE[None]
    halted = run(machine, down, 3)[0]
    assert halted.person is None
    sees["windows"].clear()
    run(machine, halted, 1)
    assert [kind for kind, _ in sees["windows"]] == ["face", "hand"]


def test_a_tutor_who_is_gone_has_no_link_in_the_end(sees):
    machine = robot(rules=RobotRules(link=LinkRules(patience=99)))
    state = idle(machine)
    sees["faces"] = NONE
    state, _, names = run(machine, state, 30)
    assert names[-2:] == ["idle", "wait"]
    assert state.link is None


def test_who_is_hidden_for_long_is_lost(sees):
    machine, sees["hands"] = robot(), ABOVE[None]
    began = run(machine, idle_without_hand(machine, sees), 3)[0]
    sees["hands"], blank = NONE, np.zeros_like(IMAGE)
    state, info, names = run(machine, began, 25, blank)
    assert info.hidden
    assert names[-2:] == ["follow", "wait"]
    assert state.link is None


def test_it_stands_while_its_tutor_is_hidden_if_it_waits(sees):
    machine, sees["hands"] = robot(), ABOVE[None]
    began = run(machine, idle_without_hand(machine, sees), 3)[0]
    sees["hands"], blank = NONE, np.zeros_like(IMAGE)
    asked = replace(began, person=replace(began.person, particles=aside(began.person.particles)))
    info = run(machine, asked, 1, blank)[1]
    assert info.hidden
    assert info.command == (0.0, 0.0)
    info = run(replace(machine, rules=RobotRules(waits=False)), asked, 1, blank)[1]
    assert info.hidden
    assert info.command[1] < 0
    assert run(machine, asked, 1)[1].command != (0.0, 0.0)  # who is seen is followed


def aside(particles):
    """Return particles that stand 10 px farther to the right."""
    return replace(particles, states=np.add(particles.states, [10.0, 0.0, 0.0, 0.0]))


def test_a_kalman_filter_says_where_the_face_is_looked_for(sees):
    machine = robot(face_tracking=FaceTracker())
    state = idle(machine)
    tracker = FaceTracker()
    place = tracker.start(FACE)
    for _ in range(4):
        place, _ = tracker.step(place, IMAGE[..., 0])
    np.testing.assert_allclose(state.place.belief.mean, place.belief.mean)
    sees["windows"].clear()
    run(machine, state, 1)
    window = sees["windows"][0][1]
    np.testing.assert_allclose(window, tracker.window(tracker.predict(place)))
    assert window[2] < 2.5 * FACE[2]  # where six sides are looked through without it


def test_a_face_that_is_missed_is_where_it_is_expected(sees):
    """The face moves by 6 px a picture, and the link goes on with it while it is not found."""
    machine = robot(face_tracking=FaceTracker())
    state, _, _ = run(machine, machine.start(), 3)
    for k in range(1, 9):
        sees["faces"] = FACE[None] + [6 * k, 0, 0, 0]
        state, _, _ = run(machine, state, 1)
    sees["faces"] = NONE
    state, info, _ = run(machine, state, 4)
    assert info.held is None
    assert state.link.missed == 4
    assert state.link.face.box[0] == pytest.approx(FACE[0] + 6 * 12, abs=4)
    sees["faces"] = FACE[None]
    state = idle(robot())
    sees["faces"] = NONE
    np.testing.assert_array_equal(run(robot(), state, 4)[0].link.face.box, FACE)


def test_a_face_that_is_given_up_is_looked_for_everywhere(sees):
    machine = robot(face_tracking=FaceTracker(), rules=RobotRules(link=LinkRules(patience=60)))
    state = idle(machine)
    sees["faces"] = NONE
    state, _, _ = run(machine, state, 25)
    assert state.place == RegionState() or state.place.belief is None
    assert state.link is not None
    sees["windows"].clear()
    run(machine, state, 1)
    assert sees["windows"][0] == ("face", None)


def test_particles_that_the_detector_steers_keep_the_place(sees):
    rules = FaceFilterRules(particles=60)
    machine = robot(face_tracking=FaceFilter(rules))
    state, _, _ = run(machine, machine.start(), 5)
    assert isinstance(state.place, FaceFilterState)
    assert len(state.place.particles.states) == 60
    sees["faces"] = NONE
    state, info, _ = run(machine, state, 1)
    assert info.held is None
    np.testing.assert_allclose(state.link.face.box, state.place.box)


def test_without_a_link_and_while_it_follows_no_face_has_a_place(sees):
    machine = robot(face_tracking=FaceTracker(), recognise=lambda grey, box: None)
    assert run(machine, machine.start(), 4)[0].place is None
    machine = robot(face_tracking=FaceTracker())
    state = idle(machine)
    sees["hands"] = ABOVE[None]
    state, _, names = run(machine, state, 3)
    assert names[-1] == "follow"
    assert state.place is None
    sees["hands"] = NONE
    state, _, _ = run(machine, state, 8)
    sees["hands"] = ABOVE[None]
    state, _, names = run(machine, state, 4)
    assert names[-1] == "halt"
    assert state.place is not None  # from where the body's face should be


def test_the_descriptor_goes_along_and_is_what_the_link_is_verified_by(sees):
    said, asked = Recognition("ann", "ann", 0.1, 0.1, np.arange(3.0)), []

    def verify(link, face):
        asked.append((link.name, face.descriptor.tolist()))
        return False

    machine = robot(verify=verify, recognise=lambda grey, box: said)
    state, info, _ = run(machine, machine.start(), 1)
    assert info.held == 0  # the first one begins the link, and nothing is asked
    assert not asked
    _, info, _ = run(machine, state, 1)
    assert info.held is None
    assert asked == [("ann", [0.0, 1.0, 2.0])]
    np.testing.assert_array_equal(info.faces[0].descriptor, said.descriptor)


def test_events_are_those_of_the_table():
    Interaction(paper_table(), EVENTS)


def test_a_table_that_follows_nobody_is_refused(sees):
    table = StateTable("a", (Transition("a", "now", "follow"), Transition("follow", "never", "a")))
    events = {"now": Event(lambda seen: True), "never": Event(lambda seen: False)}
    machine = replace(
        robot(interaction=Interaction(table, events)), recognise=lambda grey, box: None
    )
    with pytest.raises(ValueError, match="interaction must lead to 'follow' with a link only"):
        run(machine, machine.start(), 1)
    state = idle(robot())
    with pytest.raises(ValueError, match="link must be there where person is, got none"):
        replace(run_to_follow(sees, state), link=None)


def run_to_follow(sees, state):
    sees["hands"] = ABOVE[None]
    return run(robot(), state, 3)[0]


def test_a_state_checks_its_numbers():
    with pytest.raises(ValueError, match="quiet"):
        RobotState(InteractionState("wait"), quiet=-1)
    with pytest.raises(ValueError, match="face_window"):
        RobotRules(face_window=0.0)
    with pytest.raises(TypeError, match="recognise"):
        CompanionRobot("ann", HANDS)


def test_of_several_faces_the_robot_turns_to_the_one_that_has_the_link(sees):
    """The tutor stands at the left; a stranger at the right is found first."""
    tutor, stranger = np.array([60.0, 40, 40, 40]), np.array([230.0, 40, 44, 44])
    sees["faces"] = np.array([stranger, tutor])
    machine = replace(robot(), recognise=lambda grey, box: "ann" if box[0] < 160 else None)
    _, info, _ = run(machine, machine.start(), 6)
    assert info.held == 1
    assert info.command == (0.0, KEEPS.command(80 - 159.5, KEEPS.height)[1])
    assert info.command[1] > 0

"""A learned path driven again: arrival, what the robot does when it is blind, and each rule."""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from data_synth.ceiling import drive
from robot_perception.ceiling import navigator as module
from robot_perception.ceiling.mapping import MapRules, inside
from robot_perception.ceiling.mosaic import Mosaic, NoCommonPattern
from robot_perception.ceiling.navigator import Navigator, ReplayState
from robot_perception.ceiling.visual_memory import (
    KeyImage,
    PathGraph,
    ServoRules,
    relative_pose,
    servo,
)
from robot_perception.geometry import se2
from tests.ceiling.ceilings import (
    BLANK,
    CENTRE,
    SCALE,
    TILTED,
    camera,
    corrects,
    driven,
    film,
    run,
)
from tests.unchecked import unchecked

KEYS = (4, 9, 13)  # of the pictures of the path
PATH = driven(14, 0.05, 0.0)
OFF = np.array([-0.06, 0.05, -0.1])  # where the robot starts beside it
DT = 0.4


def gen(seed=0):
    return np.random.default_rng(seed)


def taught(**changed):
    """Return a navigator along a straight path of 65 cm."""
    learned = run()
    route = [KeyImage(learned[k][1].sightings) for k in KEYS]
    state = learned[-1][0]
    parts = {"route": route, "patterns": state.patterns, "mosaic": state.mosaic}
    parts |= {"centre": CENTRE, "scale": SCALE, "servo": ServoRules(tolerance=0.06, fastest=0.12)}
    return Navigator(**(parts | changed))


@lru_cache
def replayed():
    """Return poses, states and infos of a drive beside the start, to a step after the arrival."""
    navigator, rng, pose, found = taught(), gen(5), OFF, []
    state = navigator.start(camera().image(pose), rng=rng)
    for _ in range(60):
        state, info = navigator.step(state, camera().image(pose), rng=rng)
        found.append((pose, state, info))
        if [one.status for *_, one in found[-2:]] == ["arrived"] * 2:
            break
        pose = drive(pose, *info.command, DT, rng=rng)
    return found


def driven_by(navigator, start, rng, most=60):
    """Return what `Navigator.drive` makes of it."""
    poses, found = [start], []
    state = navigator.start(camera().image(start), rng=rng)
    for after, info in navigator.drive(
        state,
        lambda: camera().image(poses[-1]),
        lambda *command: poses.append(drive(poses[-1], *command, DT, rng=rng)),
        rng=rng,
        most=most,
    ):
        found.append((poses[-1], after, info))
    return found


@lru_cache
def begun():
    """Return the state after the start, where the path begins."""
    return taught().start(film()[0], rng=gen())


def pose_in_map(pose):
    return se2.compose(run()[0][0].pose, se2.between(PATH[0], pose))


# The start ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("off", [(0, 0, 0), OFF, (0.1, -0.1, 1.4), (0, 0, -3.0)])
def test_the_start_finds_the_robot_wherever_it_looks(off):
    """Within three pixels and 3°, by patterns of the first key image that agree."""
    off = np.array(off, dtype=float)
    state = taught().start(camera().image(off), rng=gen(2))
    assert {*state.tracked} <= {*taught().route[0].sightings}
    assert len(state.tracked) >= 2
    error = state.pose - pose_in_map(off)
    assert np.hypot(*error[:2]) < 3 * SCALE
    assert abs(math.remainder(error[2], 2 * math.pi)) < math.radians(3)
    assert (state.key, state.blind, state.count) == (0, 0, 0)
    away = taught().mosaic.locate({name: one.pose for name, one in state.tracked.items()})
    np.testing.assert_array_equal(state.pose, away[0])
    assert max(np.hypot(*miss[:2]) for miss in away[1].values()) <= 6 * SCALE


def test_below_another_ceiling_nothing_is_found():
    for picture in (BLANK, camera("plain", 8).image(np.zeros(3))):
        with pytest.raises(
            NoCommonPattern, match=r"image must show a pattern .* got none of \('0'"
        ):
            taught().start(picture, rng=gen())


def test_the_start_is_that_of_the_first_key_image():
    """Of its patterns and no others, though all are in view."""
    first, *others = (KeyImage({name: place}) for name, place in run()[0][1].sightings.items())
    state = taught(route=(first, *others)).start(film()[0], rng=gen(2))
    assert [*state.tracked] == [*first.sightings]


# The drive ----------------------------------------------------------------------------------------


def test_it_arrives():
    """Within the tolerance by its own account, and three pixels more by the truth."""
    pose, state, info = replayed()[-1]
    assert info.status == "arrived"
    assert state.key == len(KEYS)
    assert info.command == (0.0, 0.0)
    away = se2.between(PATH[-1], pose)
    assert np.hypot(*away[:2]) < 0.06 + 3 * SCALE
    assert abs(away[2]) < math.radians(10)
    assert [one.status for *_, one in replayed()].count("arrived") == 2  # and it stays there
    assert len(replayed()) > 10


def test_keys_never_decrease_and_each_is_neared():
    keys = [state.key for _, state, _ in replayed()]
    assert keys == sorted(keys)
    assert {*keys} == {0, 1, 2, 3}
    for (_, before, _), (pose, state, _) in zip(replayed(), replayed()[1:], strict=False):
        for key in range(before.key, state.key):
            target = se2.between(pose, PATH[KEYS[key]])
            near = taught().servo.tolerance if key == len(KEYS) - 1 else taught().near
            assert np.hypot(*target[:2]) < near + 3 * SCALE or target[0] < 2 * SCALE
    assert [state.count for _, state, _ in replayed()] == [*range(1, len(keys) + 1)]


def test_command_and_target_are_those_of_the_key_image():
    navigator = taught()
    for pose, state, info in replayed():
        if info.status == "driving":
            key = navigator.route[state.key]
            target = relative_pose(info.sightings, key, centre=np.array(CENTRE), scale=SCALE)
            np.testing.assert_array_equal(info.target, target)
            assert info.command == servo(target, navigator.servo)
            away = target - se2.between(pose, PATH[KEYS[state.key]])
            assert np.hypot(*away[:2]) < 4 * SCALE
        assert state.blind == 0


def test_the_pose_is_that_in_the_mosaic():
    for pose, state, _ in replayed()[1:]:
        error = state.pose - pose_in_map(pose)
        assert np.hypot(*error[:2]) < 4 * SCALE
        assert abs(error[2]) < math.radians(3)


def test_the_scale_of_the_map_cancels_and_that_of_the_robot_is_a_factor():
    poses = {n: pose * [0.5, 0.5, 1] for n, pose in taught().mosaic.poses.items()}
    smaller = Mosaic(poses, SCALE / 2, np.array(CENTRE))
    half = replace(begun(), pose=begun().pose * [0.5, 0.5, 1])
    first, other, twice = (
        navigator.step(state, film()[0], rng=gen(7))[1].target
        for navigator, state in (
            (taught(), begun()),
            (taught(mosaic=smaller), half),
            (taught(scale=2 * SCALE, near=0.5), begun()),
        )
    )
    np.testing.assert_allclose(other, first, atol=1e-9)
    np.testing.assert_allclose(twice, first * [2, 2, 1], atol=1e-9)


def test_the_same_seed_gives_the_same_command():
    before = begun().pose.copy(), dict(begun().tracked)
    first, second = (taught().step(begun(), film()[1], rng=gen(9)) for _ in range(2))
    assert first[1].command == second[1].command
    np.testing.assert_array_equal(first[0].pose, second[0].pose)
    np.testing.assert_array_equal(begun().pose, before[0])
    assert dict(begun().tracked) == before[1]


def test_the_loop_is_that_of_the_steps():
    """Bit by bit, up to the first arrival."""
    found = driven_by(taught(), OFF, gen(5))
    assert len(found) == len(replayed()) - 1
    for (pose, state, info), (there, after, told) in zip(found, replayed(), strict=False):
        np.testing.assert_array_equal(pose, there)
        np.testing.assert_array_equal(state.pose, after.pose)
        assert (info.command, info.status) == (told.command, told.status)
    assert found[-1][2].status == "arrived"
    assert len(driven_by(taught(), OFF, gen(5), most=3)) == 3


def test_two_trajectories_that_meet_lead_from_the_first_place_to_the_last():
    """A to B and B to C were learned; the robot drives from A to C. A way round is longer."""
    one = taught()
    first, second, third = one.route
    graph = PathGraph().add("A", "B", [first, second]).add("B", "C", [third])
    graph = graph.add("A", "C", [first, second, second, third])
    parts = (one.patterns, one.mosaic, CENTRE, SCALE)
    navigator = Navigator.between(graph, "A", "C", *parts, servo=one.servo)
    assert navigator.route == (first, second, third)
    assert (navigator.scale, navigator.servo) == (SCALE, one.servo)
    pose, _, info = driven_by(navigator, OFF, gen(5))[-1]
    assert info.status == "arrived"
    assert np.hypot(*se2.between(PATH[-1], pose)[:2]) < 0.06 + 3 * SCALE
    assert Navigator.between(graph, "B", "C", *parts).route == (third,)
    with pytest.raises(ValueError, match="route must have a key image, got none"):
        Navigator.between(graph, "A", "A", *parts)
    with pytest.raises(ValueError, match="got no way from 'C' to 'A'"):
        Navigator.between(graph, "C", "A", *parts)


def test_a_tilted_camera_is_corrected_on_the_way():
    """It learned by pictures of the level one, so that nothing else can make up for the tilt."""
    one, eye, rng, poses = taught(correction=corrects(TILTED)), camera(mount=TILTED), gen(5), [OFF]
    state = one.start(eye.image(OFF), rng=rng)
    for _, told in one.drive(
        state,
        lambda: eye.image(poses[-1]),
        lambda *command: poses.append(drive(poses[-1], *command, DT, rng=rng)),
        rng=rng,
        most=60,
    ):
        info = told
    assert info.status == "arrived"
    away = se2.between(PATH[-1], poses[-1])
    assert np.hypot(*away[:2]) < 0.06 + 3 * SCALE
    assert abs(away[2]) < math.radians(10)
    blind = taught().start(eye.image(OFF), rng=gen(5))
    off = se2.between(pose_in_map(OFF), blind.pose)
    assert np.hypot(*off[:2]) > 0.1  # without it the robot believes itself elsewhere
    assert np.hypot(*se2.between(pose_in_map(OFF), state.pose)[:2]) < 3 * SCALE


# What is in view ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("near", "key"), [(0.23, 1), (0.17, 0)])
def test_from_so_near_it_turns_to_the_next_key_image(near, key):
    """The first is 20 cm ahead."""
    state, info = taught(near=near).step(begun(), film()[0], rng=gen(3))
    assert state.key == key
    assert info.status == "driving"
    np.testing.assert_allclose(info.target[0], PATH[KEYS[key]][0], atol=2 * SCALE)


@pytest.mark.parametrize(("tolerance", "status"), [(0.03, "driving"), (0.07, "arrived")])
def test_at_the_last_the_tolerance_of_the_servo_counts(tolerance, status):
    """5 cm before it, though `near` is wider."""
    navigator = taught(servo=ServoRules(tolerance=tolerance))
    learned = run()[12]
    state = ReplayState(learned[0].tracked, learned[0].pose, key=2)
    after, info = navigator.step(state, film()[12], rng=gen(3))
    assert info.status == status
    assert after.key == 2 + (status == "arrived")
    np.testing.assert_allclose(info.target, [0.05, 0, 0], atol=1.5 * SCALE)


def test_key_images_that_are_passed_are_skipped_at_once():
    learned = run()[11]
    state = ReplayState(learned[0].tracked, learned[0].pose, key=0)
    after, info = taught().step(state, film()[11], rng=gen(3))
    assert after.key == 2
    np.testing.assert_allclose(info.target, [0.1, 0, 0], atol=2 * SCALE)


def test_blind_it_stands_and_after_its_patience_says_that_it_is_lost():
    navigator, rng = taught(patience=2), gen(4)
    state = begun()
    for blind in range(1, 6):
        state, info = navigator.step(state, BLANK, rng=rng)
        assert info.command == (0.0, 0.0)
        assert info.target is None
        assert not info.sightings
        assert state.blind == blind
        assert info.status == ("driving" if blind <= 2 else "lost")
        assert state.key == begun().key
        np.testing.assert_array_equal(state.pose, begun().pose)
    assert not state.tracked
    state, info = navigator.step(state, film()[0], rng=rng)
    assert info.status == "driving"
    assert state.blind == 0
    assert info.command[0] > 0


@pytest.fixture
def sought(monkeypatch):
    """Note what is looked for."""
    told = []
    inner = module.look_for

    def noted(expected, patterns, sought, rules, *, rng):
        told.append(dict(expected))
        return inner(expected, patterns, sought, rules, rng=rng)

    monkeypatch.setattr(module, "look_for", noted)
    return told


def four():
    """Return a state of the third picture with four patterns tracked."""
    state = run()[2][0]
    tracked = dict([*state.tracked.items()][:4])
    assert len(tracked) == 4
    return ReplayState(tracked, state.pose, count=1)


def test_known_patterns_are_looked_for_every_so_often_or_where_few_are_seen(sought):
    for count, every, enough, asked in (
        (1, 5, 4, 0),
        (1, 5, 5, 1),
        (10, 5, 4, 1),
        (11, 5, 4, 0),
        (3, 3, 4, 1),
    ):
        sought.clear()
        navigator = taught(rules=MapRules(every=every, enough=enough))
        navigator.step(replace(four(), count=count), film()[2], rng=gen(1))
        assert len(sought) == asked


def test_patterns_of_the_next_three_key_images_are_looked_for(sought):
    """If they should be in view and are not tracked."""
    state, names = four(), [*run()[2][1].sightings]
    where = run()[2][1].sightings
    known = taught().patterns["0"]
    poses = dict(taught().mosaic.poses)
    far = {"edge": [26.0, 120, 0, 1], "in": [200.0, 120, 0, 1]}
    for name, place in far.items():
        there = (np.array(place[:3]) - [*CENTRE, 0]) * [SCALE, SCALE, 1]
        poses[name] = se2.compose(state.pose, there)
    one = np.array([160.0, 120, 0, 1])
    own = {name: where[name] for name in names}
    images = [own, {"edge": one}, {"in": one}, {names[5]: one}, own]
    navigator = taught(
        route=tuple(map(KeyImage, images)),
        patterns={**taught().patterns, "edge": known, "in": known},
        mosaic=Mosaic(poses, SCALE, np.array(CENTRE)),
        rules=MapRules(enough=9),
        near=1e-3,
    )
    for key, expected in ((0, {names[4], names[5], "in"}), (1, {"in", names[5]})):
        sought.clear()
        navigator.step(replace(state, key=key), film()[2], rng=gen(1))
        assert {*sought[0]} == expected
        for name, place in sought[0].items():
            assert inside(place, BLANK.shape, 30.0)
            if name in where:
                np.testing.assert_allclose(place[:2], where[name][:2], atol=3)


def test_what_is_found_is_tracked_and_steered_by(sought):
    navigator = taught(rules=MapRules(enough=9))
    after, info = navigator.step(four(), film()[2], rng=gen(1))
    (asked,) = sought
    assert asked
    assert {*after.tracked} == {*info.sightings}
    assert {*after.tracked} > {*four().tracked}


def test_what_slid_is_let_go():
    learned = run()[2][0]
    slid, *_ = four().tracked
    poses = dict(taught().mosaic.poses)
    poses[slid] = poses[slid] + [20 * SCALE, 0, 0]
    navigator = taught(mosaic=Mosaic(poses, SCALE, np.array(CENTRE)), rules=MapRules(enough=3))
    after, info = navigator.step(four(), film()[2], rng=gen(1))
    assert slid not in after.tracked
    assert slid not in info.sightings
    assert len(after.tracked) == 3
    np.testing.assert_allclose(after.pose, learned.pose, atol=1.5 * SCALE)


# Bad input ----------------------------------------------------------------------------------------


def test_a_route_has_key_images_of_known_patterns():
    with pytest.raises(ValueError, match="route must have a key image, got none"):
        taught(route=())
    strange = KeyImage({"0": np.zeros(4), "x": np.zeros(4), "y": np.zeros(4)})
    route = (taught().route[0], strange)
    with pytest.raises(ValueError, match=r"route\[1\] must show known patterns, got \['x', 'y'\]"):
        taught(route=route)
    known = {**taught().patterns, "x": taught().patterns["0"], "y": taught().patterns["0"]}
    with pytest.raises(ValueError, match=r"route\[1\] must show known patterns, got \['x', 'y'\]"):
        Navigator(route, known, taught().mosaic, CENTRE)  # not in the mosaic


@pytest.mark.parametrize(
    ("wrong", "error", "said"),
    [
        ({"route": (5,)}, TypeError, r"route\[0\] must be a KeyImage, got 5"),
        ({"patterns": {"0": 5}}, TypeError, r"patterns\['0'\] must be a Pattern, got 5"),
        ({"mosaic": 5}, TypeError, "mosaic must be a Mosaic, got 5"),
        ({"centre": (1.0, math.inf)}, ValueError, "centre must be finite, got"),
        ({"scale": 0.0}, ValueError, "scale must be positive and finite, got 0"),
        ({"servo": 5}, TypeError, "servo must be a ServoRules, got 5"),
        ({"rules": 5}, TypeError, "rules must be a MapRules, got 5"),
        ({"near": 0.0}, ValueError, "near must be positive and finite, got 0"),
        ({"patience": -1}, ValueError, "patience must be at least 0, got -1"),
    ],
)
def test_a_navigator_is_checked(wrong, error, said):
    one = taught()
    parts = {name: getattr(one, name) for name in ("route", "patterns", "mosaic", "centre")}
    with pytest.raises(error, match=said), unchecked():
        Navigator(**(parts | wrong))


@pytest.mark.parametrize(
    ("wrong", "error", "said"),
    [
        ({"tracked": {"0": 5}}, TypeError, r"tracked\['0'\] must be a PatternState, got 5"),
        ({"pose": np.zeros(2)}, ValueError, r"pose must be \(3,\), got \(2,\)"),
        ({"key": -1}, ValueError, "key must be at least 0, got -1"),
        ({"blind": -2}, ValueError, "blind must be at least 0, got -2"),
        ({"count": -3}, ValueError, "count must be at least 0, got -3"),
    ],
)
def test_a_state_is_checked(wrong, error, said):
    with pytest.raises(error, match=said), unchecked():
        ReplayState(**({"tracked": {}, "pose": np.zeros(3)} | wrong))


def test_steps_are_checked():
    with unchecked():
        with pytest.raises(TypeError, match="state must be a ReplayState, got 5"):
            taught().step(5, BLANK, rng=gen())
        with pytest.raises(TypeError, match="rng must be a Generator, got 5"):
            taught().step(begun(), BLANK, rng=5)
        with pytest.raises(TypeError, match="rng must be a Generator, got 5"):
            taught().start(BLANK, rng=5)
    with pytest.raises(TypeError):
        begun().tracked["x"] = None

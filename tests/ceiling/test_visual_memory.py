"""Visual memory: key images, ways between places, relative poses, and a law that steers by them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_lyapunov
from scipy.sparse.csgraph import shortest_path

from robot_perception.ceiling.mosaic import Mosaic, camera_pose, in_camera
from robot_perception.ceiling.visual_memory import (
    Breach,
    Follower,
    KeyImage,
    KeyRules,
    NoCommonPattern,
    PathGraph,
    ServoRules,
    breaches,
    choose_key_images,
    closed_loop,
    passed,
    relative_pose,
    servo,
)
from robot_perception.geometry import se2
from tests.unchecked import unchecked

CENTRE = np.array([159.5, 119.5])
SCALE = 0.007
POSES = arrays(float, 3, elements=st.floats(-3, 3))


def seen(pose, pattern, scale=SCALE):
    """Return the sighting of a pattern from a pose by the camera's equation."""
    (c, s), away = (math.cos(pose[2]), math.sin(pose[2])), np.subtract(pattern, pose)
    ahead, left = c * away[0] + s * away[1], c * away[1] - s * away[0]
    return np.array([*(CENTRE + np.array([ahead, left]) / scale), away[2], 1.3])


def picture(pose, patterns, reach=1.0):
    """Return what is seen from a pose: the patterns that are near."""
    return {
        name: seen(pose, pattern)
        for name, pattern in patterns.items()
        if math.hypot(*(pattern - pose)[:2]) < reach
    }


CORRIDOR = {str(k): np.array([0.5 * k, 0.3 * (-1) ** k, 0.7 * k]) for k in range(20)}


def turned(*headings, name="a"):
    """Return a run in which one pattern turns."""
    return [{name: np.array([0.0, 0.0, math.radians(h), 1.0])} for h in headings]


def test_key_images_fulfil_the_conditions_and_are_few():
    path = [
        np.array([0.05 * k, 0.1 * math.sin(k / 15), 0.5 * math.sin(k / 15)]) for k in range(190)
    ]
    run = [picture(pose, CORRIDOR) for pose in path]
    rules = KeyRules(common=2)
    chosen = choose_key_images(run, rules)
    assert chosen[0] == 0
    assert chosen[-1] == 189
    assert all(a < b for a, b in pairwise(chosen))
    assert not breaches([KeyImage(run[k]) for k in chosen], rules)
    for last, after in pairwise(chosen):  # no farther image would do before the turn is too large
        for k in range(after + 1, 190):
            found = breaches([KeyImage(run[last]), KeyImage(run[k])], rules)
            assert found
            if any(b.condition == "turn" for b in found):
                break
    assert len(chosen) < 30
    assert len(choose_key_images(run, KeyRules(turn=math.radians(30), common=2))) < len(chosen)


def test_a_turn_is_not_cut_off_where_it_turns_back():
    assert choose_key_images(turned(0, 10, 20, 30, 20, 10, 0)) == (0, 1, 2, 5, 6)
    assert choose_key_images(turned(0, 5, 10, 5, 0)) == (0, 4)
    assert choose_key_images(turned(0, 15 - 1e-9)) == (0, 1)
    whole = choose_key_images(turned(*range(0, 361, 10)))
    assert whole == tuple(range(37))
    assert choose_key_images(turned(*range(0, 31, 5))) == (0, 2, 4, 6)
    assert choose_key_images(turned(355, -8 + 360 * 2)) == (0, 1)  # wrapped


def test_an_image_without_the_patterns_is_passed_over():
    run = turned(0, 1, 2)
    assert choose_key_images([run[0], {}, run[2]]) == (0, 2)
    assert choose_key_images([run[0]]) == (0,)


@pytest.mark.parametrize(
    ("run", "rules", "said"),
    [
        ([], KeyRules(), "run must have an image, got none"),
        (turned(0, 1) + turned(2, name="b"), KeyRules(), "from its image 1 by the rules, but no"),
        (turned(0, 1), KeyRules(common=2), "from its image 0 by the rules, but no later"),
        (turned(0, 5, 20), KeyRules(), r"from its image 1 .* turns by 0\.26"),
        (
            turned(0, 5, 10),
            KeyRules(shift=1e-9, turn=0.1),
            r"from its image 1 .* but a pattern turns",
        ),
    ],
)
def test_a_run_that_breaks_off_is_named(run, rules, said):
    if rules.turn == 0.1:
        run = [run[0], turned(4)[0], turned(11)[0]]
    with pytest.raises(ValueError, match=said):
        choose_key_images(run, rules)


def test_a_pattern_must_not_move_too_far():
    run = [{"a": np.array([3.0 * k, 4.0 * k, 0, 1])} for k in range(5)]
    assert choose_key_images(run, KeyRules(shift=10.0)) == (0, 2, 4)
    assert choose_key_images(run) == (0, 4)
    with pytest.raises(ValueError, match="image 0 by the rules, but a pattern moves by 5 px"):
        choose_key_images(run, KeyRules(shift=4.9))


def test_breaches_are_told_one_by_one():
    one, two = np.array([0.0, 0, 3.1, 1]), np.array([30.0, 40, -3.1, 1])
    back = one - [0, 0, 0.3, 0]
    keys = [KeyImage({"a": one, "b": one}), KeyImage({"a": two, "b": back})]
    keys += [KeyImage({"b": one}), KeyImage({"c": one})]
    found = breaches(keys, KeyRules(turn=0.2, common=2, shift=49))
    assert [(b.index, b.condition) for b in found] == [
        (0, "turn"),
        (0, "shift"),
        (1, "common"),
        (1, "turn"),
        (2, "common"),
    ]
    assert np.allclose([b.value for b in found], [0.3, 50, 1, 0.3, 0])
    assert isinstance(found[0], Breach)
    assert not breaches(keys[:1])
    both = {"a": one - [0, 0, 0.3, 0], "b": one - [0, 0, -0.1, 0]}
    (found,) = breaches([keys[0], KeyImage(both)], KeyRules(turn=0.2))  # the one that turns most
    assert np.isclose(found.value, 0.3)
    assert not breaches(keys[:2], KeyRules(turn=0.31))
    assert breaches(keys[:2], KeyRules(turn=0.3 - 1e-9))


def key(*names, angle=0.0):
    return KeyImage({name: np.array([0.0, 0, angle, 1]) for name in names})


@given(st.integers(0, 2**32 - 1))
def test_a_route_is_the_shortest(seed):
    """Where all joints fit, against SciPy's."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(1, 9, (6, 6)) * (rng.random((6, 6)) < 0.35)
    np.fill_diagonal(lengths, 0)
    graph = PathGraph()
    for a, b in np.argwhere(lengths).tolist():
        graph = graph.add(str(a), str(b), [key("x")] * lengths[a, b])
    best = shortest_path(lengths)
    for a in graph.places:
        for b in graph.places:
            length = best[int(a), int(b)]
            if np.isfinite(length):
                assert len(graph.route(a, b)) == length
            else:
                with pytest.raises(ValueError, match=f"no way from '{a}' to '{b}'"):
                    graph.route(a, b)


def test_a_route_joins_only_what_fits_and_in_its_order():
    ab, bc = [key("1"), key("2")], [key("2"), key("3")]
    graph = PathGraph().add("A", "B", ab).add("B", "C", bc)
    assert graph.route("A", "C") == (*ab, *bc)
    assert graph.places == ("A", "B", "C")
    assert graph.route("B", "B") == ()
    with pytest.raises(ValueError, match="no way from 'C' to 'A'"):  # one way
        graph.route("C", "A")
    stranger = PathGraph().add("A", "B", ab).add("B", "C", [key("9")])
    with pytest.raises(ValueError, match="'A' to 'C'; key images do not fit together at 'B'"):
        stranger.route("A", "C")
    # the short way to B does not go on, the long one does
    longer = [key("1"), key("4"), key("9")]
    both = stranger.add("A", "B", longer)
    assert len(both.route("A", "B")) == 2
    assert both.route("A", "C")[:3] == tuple(longer)
    assert len(stranger.trajectories) == 2
    strict = PathGraph(KeyRules(turn=0.2)).add("A", "B", ab).add("B", "C", [key("2", angle=0.3)])
    with pytest.raises(ValueError, match="fit together at 'B'"):
        strict.route("A", "C")
    with pytest.raises(ValueError, match=r"goal must be a place of the graph, .*'B'.*, got 'Z'"):
        graph.route("A", "Z")
    with pytest.raises(ValueError, match="start must be a place"):
        graph.route("Z", "A")
    with pytest.raises(ValueError, match="keys must have a key image"):
        graph.add("A", "D", [])
    with pytest.raises(ValueError, match="goal must be another place"):
        graph.add("A", "A", ab)


@given(POSES, POSES, POSES, POSES)
def test_the_relative_pose_is_that_of_the_two_places(now, then, one, two):
    patterns = {"a": one, "b": two}
    current = {name: seen(now, p) for name, p in patterns.items()}
    image = KeyImage({name: seen(then, p) for name, p in patterns.items()})
    true = se2.between(now, then)
    for names in ("a", "b", "ab"):
        part = {name: current[name] for name in names} | {"x": np.zeros(4)}
        found = relative_pose(part, image, centre=CENTRE, scale=SCALE)
        np.testing.assert_allclose(found[:2], true[:2], atol=1e-8)
        assert abs(math.remainder(found[2] - true[2], 2 * math.pi)) < 1e-8
    px = relative_pose(current, image, centre=CENTRE)
    np.testing.assert_allclose(px[:2] * SCALE, true[:2], atol=1e-8)


def test_one_pattern_gives_the_quotient_and_several_the_least_squares():
    rng = np.random.default_rng(0)
    patterns = {str(k): rng.uniform(-1, 1, 3) for k in range(3)}
    now, then = np.array([0.2, 0.1, 0.3]), np.array([0.6, -0.1, 0.5])
    noise = [1.0, 1, 0.02, 0]
    images = [
        {k: seen(pose, p) + rng.normal(size=4) * noise for k, p in patterns.items()}
        for pose in (now, then)
    ]
    current, image = images[0], KeyImage(images[1])
    how = {"centre": CENTRE, "scale": SCALE}
    alone = relative_pose({"1": current["1"]}, image, **how)
    T = [in_camera(i["1"], **how) for i in images]
    np.testing.assert_allclose(alone, camera_pose(T[0], T[1]), atol=1e-12)
    for scale in (0.25, 1.0, 4.0):  # the shape of the answer does not depend on the scale
        found = relative_pose(current, image, centre=CENTRE, scale=scale)
        expected = relative_pose(current, image, centre=CENTRE) * [scale, scale, 1]
        np.testing.assert_allclose(found, expected, rtol=1e-12)
    heading_only = relative_pose(current, image, sigma_px=1e6, **how)
    turns = [current[k][2] - image.sightings[k][2] for k in patterns]
    assert np.isclose(heading_only[2], np.angle(np.exp(1j * np.array(turns)).sum()))


@given(POSES, POSES, POSES)
def test_an_offset_gives_the_pose_of_the_robot(now, then, offset):
    pattern = np.array([0.4, 0.3, 0.2])
    current, image = (seen(se2.compose(p, offset), pattern) for p in (now, then))
    found = relative_pose(
        {"a": current}, KeyImage({"a": image}), centre=CENTRE, scale=SCALE, offset=offset
    )
    true = se2.between(now, then)
    np.testing.assert_allclose(found[:2], true[:2], atol=1e-7)
    assert abs(math.remainder(found[2] - true[2], 2 * math.pi)) < 1e-7


def tilted(pose, pattern, tilt, height=2.0, focal=300.0):
    """Return a sighting by a camera that is pitched, from two points of the pattern."""
    T = se2.between(pose, pattern)
    points = se2.act(T, np.array([[0.0, 0], [0.01, 0]]))
    x, y = points.T
    depth = height * math.cos(tilt) - x * math.sin(tilt)
    ahead = x * math.cos(tilt) + height * math.sin(tilt)
    (u, v), (u2, v2) = (focal * np.stack([ahead, y]) / depth).T
    return np.array([CENTRE[0] + u, CENTRE[1] + v, math.atan2(v2 - v, u2 - u), 1.0])


def test_a_tilt_moves_the_zero_only_if_it_has_changed():
    pattern, place = np.array([0.1, 0.2, 0.3]), np.array([0.3, 0.1, 0.5])
    how = {"centre": CENTRE, "scale": 2.0 / 300}

    def pose(learned, now):
        image = KeyImage({"a": tilted(place, pattern, learned)})
        return relative_pose({"a": tilted(place, pattern, now)}, image, **how)

    np.testing.assert_allclose(pose(0.1, 0.1), 0, atol=1e-12)
    np.testing.assert_allclose(pose(0, 0.01), [2 * math.tan(0.01), 0, 0], atol=2e-3)


def test_nothing_in_common_has_its_own_error():
    with pytest.raises(NoCommonPattern, match="current and key must have a pattern in common"):
        relative_pose({"a": np.zeros(4)}, KeyImage({"b": np.zeros(4)}), centre=CENTRE)


def test_key_images_keep_copies():
    pose = np.zeros(4)
    sightings = {"a": pose}
    image = KeyImage(sightings)
    pose[:] = 5
    sightings["b"] = pose
    assert list(image.sightings) == ["a"]
    assert not image.sightings["a"].any()
    with pytest.raises(ValueError, match=r"sightings\['a'\] must be \(4,\)"), unchecked():
        KeyImage({"a": np.zeros(3)})


# The robot of these tests lives in the plane: (x, y) as a complex number, and a heading.


def in_robot(state, goal, scale=1.0):
    """Return what the robot believes of the goal, by complex numbers."""
    away = (goal[0] - state[0]) * np.exp(-1j * state[1])
    turn = math.remainder(goal[1] - state[1], 2 * math.pi)
    return np.array([scale * away.real, scale * away.imag, turn])


def follow(start, rules, scale=1.0, steps=2000, dt=0.1, near=0.03):
    """Drive from a start to the origin on arcs; return all states."""
    states = [start]
    for _ in range(steps):
        z, heading = states[-1]
        if abs(z) < near:
            break
        speed, rate = servo(in_robot((z, heading), (0j, 0.0), scale), rules)
        # an arc as the integral of exp(i heading)
        chord = dt if abs(rate) < 1e-9 else (np.exp(1j * rate * dt) - 1) / (1j * rate)
        states.append((z + speed * chord * np.exp(1j * heading), heading + rate * dt))
    return states


STARTS = [
    (distance * np.exp(1j * bearing), heading)
    for distance in (0.5, 1.5)
    for bearing in np.radians([-170, -75, -10, 40, 130])
    for heading in np.radians([-135, -30, 60, 180])
]


@pytest.mark.parametrize("scale", [0.25, 0.5, 1.0, 2.0, 4.0])
def test_the_robot_arrives_from_everywhere_whatever_the_scale(scale):
    rules = ServoRules()
    assert scale < rules.largest_scale
    for start in STARTS:
        states = follow(start, rules, scale)
        away = np.abs([z for z, _ in states])
        assert away[-1] < 0.03
        assert (np.diff(away) < 1e-3).all()  # never away from the goal


def test_the_heading_falls_as_a_power_of_the_distance_from_everywhere():
    for start in STARTS:
        first, last = (
            abs(math.remainder(follow(start, ServoRules(), near=near)[-1][1], 2 * math.pi))
            for near in (0.03, 0.003)
        )
        assert last < 0.4 * first + 0.01  # ten times nearer: 0.195 by the smaller eigenvalue


def test_a_robot_that_starts_behind_arrives_with_the_heading():
    """From where the next key image usually is."""
    for angle in (-20, 0, 20):
        for heading in (-15, 0, 15):
            start = (-0.8 * np.exp(1j * math.radians(angle)), math.radians(heading))
            ends = [follow(start, ServoRules(), near=near)[-1][1] for near in (0.1, 0.02, 0.004)]
            assert abs(ends[1]) < math.radians(8)
            if abs(ends[0]) > 1e-3:
                slope = math.log(abs(ends[2] / ends[1])) / math.log(5)
                assert -1.0 < slope < -0.5


def loop(rules, scale):
    """Return the closed loop in (x, y, heading), the goal at the origin."""

    def derivative(_, state):
        speed, rate = servo(in_robot((complex(*state[:2]), state[2]), (0j, 0.0), scale), rules)
        return [speed * math.cos(state[2]), speed * math.sin(state[2]), rate]

    return derivative


def polar(state):
    """Return log distance, bearing and heading error of the goal, from the robot's state."""
    x, y, heading = state
    line = math.atan2(-y, -x)
    return np.array([math.hypot(x, y), line - heading, -line])


def polar_rates(rules, distance, alpha, beta, scale=1.0, step=1e-6):
    """Return the rates of distance, bearing and heading error by driving a moment."""
    line = -beta
    state = np.array([-distance * math.cos(line), -distance * math.sin(line), line - alpha])
    rates = np.array(loop(rules, scale)(0.0, state))
    ahead, back = polar(state + step * rates), polar(state - step * rates)
    moved = ahead - back
    moved[1:] = [math.remainder(m, 2 * math.pi) for m in moved[1:]]
    return moved / (2 * step)


WIDE = {"fastest": 1e6, "fastest_turn": 1e6}


@pytest.mark.parametrize("scale", [0.25, 1.0, 3.0, 4.9, 5.1, 8.0])
def test_eigenvalues_of_the_linearised_loop(scale):
    rules = ServoRules(**WIDE)
    A = np.zeros((2, 2))
    for axis in range(2):
        e = 1e-4 * np.eye(2)[axis]
        both = (polar_rates(rules, 1.0, *(sign * e), scale=scale)[1:] for sign in (1, -1))
        A[:, axis] = np.subtract(*both) / 2e-4
    k = rules.gain_distance * scale
    trace, product = rules.gain_bearing - k, -k * rules.gain_heading
    expected = np.sort_complex(np.roots([1, trace, product]))
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(A)), expected, atol=1e-6)
    stable = np.linalg.eigvals(A).real.max() < 0
    assert stable == (scale < rules.largest_scale)
    assert np.isclose(polar_rates(rules, 1.0, 0.0, 0.0, scale)[0], -k)
    if stable:  # a Lyapunov function: V' = -|(α, β)|²
        P = solve_continuous_lyapunov(A.T, -np.eye(2))
        assert np.linalg.eigvalsh(P).min() > 0


def test_beyond_the_largest_scale_the_robot_sways_ever_more():
    rules = ServoRules(**WIDE)
    start = [-1.0, 1e-3, 0.0]
    sway = {}
    for scale in (3.0, 6.5):
        run = solve_ivp(loop(rules, scale), [0, 12], start, rtol=1e-9, atol=1e-16)
        angles = [np.abs(polar(state)[1]) for state in run.y.T]
        sway[scale] = max(angles[-20:]) / max(angles[:5])
    assert sway[3.0] < 0.1
    assert sway[6.5] > 5


@pytest.mark.parametrize("scale", [0.25, 1.0, 4.0])
def test_far_from_the_goal_there_is_no_cycle_and_no_other_rest(scale):
    """The target stays ahead; the divergence in (α, β) is negative: Bendixson's criterion."""
    rules = ServoRules(**WIDE)
    for beta in np.linspace(-3.1, 3.1, 9):
        assert polar_rates(rules, 1.0, math.pi / 2, beta, scale)[1] < 0
        assert polar_rates(rules, 1.0, -math.pi / 2, beta, scale)[1] > 0
        for alpha in np.linspace(-1.5, 1.5, 9):
            rate = polar_rates(rules, 1.0, alpha, beta, scale)
            assert rate[0] < 0
            assert np.hypot(*rate[1:]) > 1e-3 or max(abs(alpha), abs(beta)) < 1e-9
            e = 1e-4
            spread = (
                polar_rates(rules, 1.0, alpha + e, beta, scale)[1]
                - polar_rates(rules, 1.0, alpha - e, beta, scale)[1]
                + polar_rates(rules, 1.0, alpha, beta + e, scale)[2]
                - polar_rates(rules, 1.0, alpha, beta - e, scale)[2]
            ) / (2 * e)
            assert spread < 0


@given(POSES, st.floats(0.1, 10))
def test_bounds_keep_the_curve(target, scale):
    assume(not ((target != 0) & (np.abs(target) < 1e-290)).any())  # a half of the least is 0
    free, bound = ServoRules(**WIDE), ServoRules()
    speed, rate = servo(target, free)
    slow, turn = servo(target, bound)
    assert 0 <= slow <= bound.fastest + 1e-12
    assert abs(turn) <= bound.fastest_turn + 1e-12
    assert np.isclose(slow * rate, speed * turn, atol=1e-12)
    assert rate * turn >= 0
    if speed <= bound.fastest and abs(rate) <= bound.fastest_turn:
        assert (slow, turn) == (speed, rate)
    else:
        assert np.isclose(max(slow / bound.fastest, abs(turn) / bound.fastest_turn), 1)
    # a wrong scale is a wrong gain, and nothing else
    faster, same = servo(target * [scale, scale, 1], free)
    assert np.isclose(faster, scale * speed)
    assert np.isclose(same, rate, atol=1e-9)


@given(POSES)
def test_the_law_is_the_same_to_the_left_and_to_the_right(target):
    if abs(target[1]) > 1e-9 and abs(abs(target[2] - math.atan2(*target[1::-1])) - math.pi) > 1e-6:
        speed, rate = servo(target)
        mirrored = servo(target * [1, -1, -1])
        np.testing.assert_allclose(mirrored, (speed, -rate), atol=1e-12)


def test_a_few_commands():
    rules = ServoRules(gain_distance=0.5, gain_bearing=2.0, gain_heading=-0.4, **WIDE)
    assert servo(np.zeros(3), rules) == (0.0, 0.0)
    np.testing.assert_allclose(servo(np.array([1.0, 0, 0]), rules), (0.5, 0.0))
    np.testing.assert_allclose(servo(np.array([1.0, 0, 0.2]), rules), (0.5, -0.08))
    quarter = math.pi / 4
    np.testing.assert_allclose(servo(np.array([1.0, 1.0, quarter]), rules), (0.5, 2 * quarter))
    speed, rate = servo(np.array([-1.0, 0.2, 0.0]), rules)
    assert speed == 0
    assert rate > 0
    np.testing.assert_allclose(
        servo(np.array([1.0, 1.0, 0])), servo(np.array([1.0, 1.0, 0]), ServoRules())
    )


def off_centre(start, offset, rules, near=0.03):
    """Drive with a camera ahead of the axle; return the last heading and distance of the camera."""
    z, heading = start
    for _ in range(4000):
        camera = z + offset * np.exp(1j * heading), heading
        target = in_robot(camera, (offset + 0j, 0.0))
        if math.hypot(*target[:2]) < near:
            break
        speed, rate = servo(target, rules)
        z, heading = z + 0.02 * speed * np.exp(1j * heading), heading + 0.02 * rate
    return abs(math.remainder(heading, 2 * math.pi)), math.hypot(*target[:2])


def test_a_camera_ahead_of_the_axle_is_harmless_and_one_behind_turns_the_robot_round():
    for start in ((-1 + 0.2j, 0.2), (-0.8 - 0.3j, 0.0)):
        for offset, most in ((0.0, 0.3), (0.15, 0.4)):
            heading, away = off_centre(start, offset, ServoRules())
            assert away < 0.03
            assert heading < most
        assert off_centre(start, -0.15, ServoRules())[0] > 1.0


def test_passed_is_reached_or_left_behind():
    rules = ServoRules(tolerance=0.1)
    assert passed(np.array([0.06, 0.08, 2.0]), rules)
    assert not passed(np.array([0.08, 0.08, 0.0]), rules)
    assert passed(np.array([-0.2, 0.3, 0.0]), rules)
    assert not passed(np.array([0.2, 0.3, 0.0]), rules)
    assert not passed(np.array([0.06, 0.0, 0.0]))
    # the robot looks away, but has not come to the line yet
    assert not passed(np.array([-0.5, 0.0, math.pi]), rules)
    assert passed(np.array([0.5, 0.0, math.pi]), rules)


@given(POSES, POSES)
def test_passed_is_the_side_of_the_line(robot, place):
    target = se2.between(robot, place)
    side = np.dot(robot[:2] - place[:2], [math.cos(place[2]), math.sin(place[2])])
    away = math.hypot(*(robot - place)[:2])
    if abs(side) > 1e-9 and abs(away - 0.05) > 1e-9:
        assert passed(target) == (side >= 0 or away <= 0.05)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"gain_distance": 0.0}, "gain_distance must be positive"),
        ({"gain_heading": 0.0}, "gain_heading must be negative"),
        ({"gain_heading": -0.75}, "gain_heading must be negative and less than half"),
        ({"gain_distance": 1.5}, "gain_bearing must be larger than gain_distance"),
        ({"fastest": -1.0}, "fastest must be positive"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
    ],
)
def test_gains_that_are_not_stable_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        ServoRules(**wrong)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"turn": 0.0}, "turn must be positive"),
        ({"common": 0}, "common must be at least 1"),
        ({"shift": 0.0}, "shift must be positive"),
    ],
)
def test_conditions_that_nothing_fulfils_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        KeyRules(**wrong)


# The loop -----------------------------------------------------------------------------------------

STOPS = tuple(np.array([x, 0.1 * x, 0.1]) for x in (0.4, 0.8, 1.2))
SWIFT = ServoRules(gain_distance=1.0, gain_bearing=2.5, gain_heading=-0.8, tolerance=0.02)


def follower(**changed):
    """Return one that knows three key images of a corridor."""
    route = [KeyImage(picture(pose, CORRIDOR)) for pose in STOPS]
    return Follower(
        **({"route": route, "centre": tuple(CENTRE), "scale": SCALE, "servo": SWIFT} | changed)
    )


def moved(pose, speed, turn, seconds=0.1):
    """Return where a unicycle is after a while, by small steps."""
    x, y, heading = pose
    for _ in range(50):
        x += speed * math.cos(heading) * seconds / 50
        y += speed * math.sin(heading) * seconds / 50
        heading += turn * seconds / 50
    return np.array([x, y, heading])


def walked(one, start=(0.0, 0.05, 0.1), *, most=600, **how):
    """Return the poses of a drive, and what each look led to."""
    poses, told = [np.array(start)], []
    for at in one.drive(
        lambda: picture(poses[-1], CORRIDOR),
        lambda speed, turn: poses.append(moved(poses[-1], speed, turn)),
        most=most,
        **how,
    ):
        told.append((poses[-1], at))
    return poses, told


@pytest.mark.parametrize("by_mosaic", [False, True])
def test_a_follower_comes_to_the_last_key_image_by_way_of_all(by_mosaic):
    mosaic = Mosaic(CORRIDOR, SCALE, CENTRE) if by_mosaic else None
    poses, told = walked(one := follower(mosaic=mosaic))
    assert [at.status for _, at in told] == ["driving"] * (len(told) - 1) + ["arrived"]
    assert len(poses) == len(told)  # at the end it does not move
    assert told[-1][1].command == (0.0, 0.0)
    assert told[-1][1].key == 3
    assert math.hypot(*(poses[-1] - STOPS[-1])[:2]) <= SWIFT.tolerance + 1e-9
    for (pose, at), after in zip(told, poses[1:], strict=False):
        np.testing.assert_allclose(at.target, se2.between(pose, STOPS[at.key]), atol=1e-9)
        assert at.command == servo(at.target, SWIFT)
        np.testing.assert_array_equal(after, moved(pose, *at.command))
        if at.key < 2:
            assert math.hypot(*at.target[:2]) > one.near
    keys = [at.key for _, at in told]
    assert keys == sorted(keys)
    assert {*keys} == {0, 1, 2, 3}


def test_a_scale_twice_too_large_is_one_that_sees_twice_as_far():
    """Without the mosaic; with it the scale of the follower says nothing."""
    view = picture(np.array([0.0, 0.05, 0.1]), CORRIDOR)
    near, far = (follower(scale=k * SCALE, near=k * 0.2).steer(view) for k in (1, 2))
    assert near.key == far.key
    np.testing.assert_allclose(far.target, near.target * [2, 2, 1], atol=1e-12)
    mosaic = Mosaic(CORRIDOR, SCALE, CENTRE)
    one, two = (follower(scale=k * SCALE, mosaic=mosaic).steer(view) for k in (1, 2))
    np.testing.assert_array_equal(one.target, two.target)


def test_a_key_image_that_is_left_behind_counts_or_does_not():
    """0.15 m beside and beyond the last: passed, though not near."""
    view = picture(STOPS[-1] + [0.1, 0.15, 0.0], CORRIDOR)
    assert follower().steer(view, 2).status == "arrived"
    told = follower(behind=False).steer(view, 2)
    assert told.status == "driving"
    assert told.key == 2
    near = picture(STOPS[-1] + [0.01, 0.01, 0.0], CORRIDOR)
    assert follower(behind=False).steer(near, 2).status == "arrived"


def test_the_last_key_image_asks_for_more_than_those_before():
    """A tenth of a metre before the second of two, and of three."""
    view = picture(STOPS[1] - [0.1, 0.0, 0.0], CORRIDOR)
    assert follower().steer(view, 1).key == 2
    last = follower(route=follower().route[:2]).steer(view, 1)
    assert (last.key, last.status) == (1, "driving")
    assert follower(near=0.05).steer(view, 1).key == 1


def test_without_a_common_pattern_a_follower_is_lost_and_stands():
    told = follower().steer({"z": np.array([*CENTRE, 0.0, 1.0])}, 1)
    assert (told.key, told.target, told.command, told.status) == (1, None, (0.0, 0.0), "lost")
    _, looks = walked(follower(), start=(50.0, 0.0, 0.0))
    assert [at.status for _, at in looks] == ["lost"]
    done = follower().steer({}, 3)
    assert (done.key, done.command, done.status) == (3, (0.0, 0.0), "arrived")


def test_a_drive_begins_with_the_key_image_that_is_named_and_ends_after_so_many_looks():
    poses, told = walked(follower(), most=4)
    assert [at.status for _, at in told] == ["driving"] * 4
    assert len(poses) == 5
    assert walked(follower(), key=2)[1][0][1].key == 2


def test_a_follower_does_not_go_back_to_a_key_image():
    """Pushed back behind one that it has neared, it steers for the next."""
    views = iter([picture(STOPS[0], CORRIDOR), picture(STOPS[0] - [0.35, 0, 0], CORRIDOR)])
    one = follower(near=0.1)
    keys = [at.key for at in one.drive(lambda: next(views), lambda speed, turn: None, most=2)]
    assert keys == [1, 1]
    assert one.steer(picture(STOPS[0] - [0.35, 0, 0], CORRIDOR)).key == 0


def test_the_loop_looks_then_decides_then_moves():
    done = []

    def step(seen):
        done.append(f"step {seen}")
        return follower().steer({}, 3 if seen == 2 else 0) if seen else Going()

    class Going:
        status, command = "driving", (0.1, 0.2)

    looks = iter(range(5))
    loop = closed_loop(step, lambda: next(looks), lambda *how: done.append(how), most=9)
    assert not done
    assert next(loop).status == "driving"
    assert done == ["step 0"]
    assert [one.status for one in loop] == ["lost"]
    assert done == ["step 0", (0.1, 0.2), "step 1"]


@pytest.mark.parametrize(
    ("wrong", "error", "said"),
    [
        ({"route": ()}, ValueError, "route must have a key image, got none"),
        ({"route": (5,)}, TypeError, r"route\[0\] must be a KeyImage, got 5"),
        ({"centre": (1.0, math.inf)}, ValueError, "centre must be finite, got"),
        ({"scale": 0.0}, ValueError, "scale must be positive and finite, got 0"),
        ({"servo": 5}, TypeError, "servo must be a ServoRules, got 5"),
        ({"near": 0.0}, ValueError, "near must be positive and finite, got 0"),
        ({"behind": 5}, TypeError, "behind must be"),
        ({"mosaic": 5}, TypeError, "mosaic must be a Mosaic"),
    ],
)
def test_a_follower_is_checked(wrong, error, said):
    with pytest.raises(error, match=said), unchecked():
        follower(**wrong)


def test_a_loop_is_checked():
    for wrong in ({"step": 5}, {"look": None}, {"move": "on"}):
        parts = {"step": follower().steer, "look": dict, "move": dict} | wrong
        said = f"{next(iter(wrong))} must be a function, got"
        with pytest.raises(TypeError, match=said), unchecked():
            closed_loop(**parts)
    with pytest.raises(ValueError, match="most must be at least 1, got 0"):
        closed_loop(follower().steer, dict, dict, most=0)
    with pytest.raises(ValueError, match="key must be from 0 to 3, got 4"):
        follower().steer({}, 4)
    with pytest.raises(ValueError, match="key must be from 0 to 3, got 4"):
        follower().drive(dict, dict, key=4)

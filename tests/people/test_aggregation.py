"""Aggregation: the paper's equations term by term, motion of the robot, and several sensors."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.geometry import se2, wrap_angle
from robot_perception.people.aggregation import (
    AggregationRules,
    Aggregator,
    Hypotheses,
    SensorRules,
    predict,
)
from robot_perception.people.detections import Detections, polar
from tests.unchecked import unchecked

RULES = AggregationRules()
STILL = np.zeros(3)
EVEN = SensorRules(alpha=0.25, patience=2.0)
PLAIN = AggregationRules(
    sensors=dict.fromkeys(("laser", "sonar", "camera"), EVEN), walk=0.0, alike=0.0
)
seeds = st.integers(0, 10**6)


def seen(time, sensor, *positions, sigma=0.1):
    """Return detections at (r, φ)."""
    r, phi = np.array(positions, dtype=float).reshape(-1, 2).T
    return Detections(time, sensor, polar(r, phi, sigma, sigma))


def known(*positions, weight=1.0, time=0.0, cov=0.01):
    """Return hypotheses at (r, φ), the sensors all heard at a time."""
    mean = np.array(positions, dtype=float).reshape(-1, 2)
    n = len(mean)
    covs = np.broadcast_to(cov * np.eye(2) if np.ndim(cov) == 0 else cov, (n, 2, 2)).copy()
    times, numbers = np.full(n, time), np.arange(n)
    return Hypotheses(
        mean,
        covs,
        np.broadcast_to(weight, n).astype(float),
        numbers,
        times,
        times,
        times,
        dict.fromkeys(PLAIN.sensors, time),
        n,
    )


def trusting(rules, **sensors):
    """Return rules with some sensors in place of those of the same name, or beside the others."""
    return replace(rules, sensors={**rules.sensors, **sensors})


def drawn(seed, n):
    """Return hypotheses with covariances of all kinds, some metres away."""
    rng = np.random.default_rng(seed)
    root = 0.1 * rng.standard_normal((n, 2, 2))
    mean = np.stack([rng.uniform(1, 6, n), rng.uniform(-np.pi, np.pi, n)], axis=-1)
    return known(*mean, cov=root @ root.mT + 1e-3 * np.eye(2))


def run(rules, readings, hypotheses=None):
    """Return the hypotheses after some readings of a robot at rest."""
    hypotheses = Hypotheses.none() if hypotheses is None else hypotheses
    for reading in readings:
        hypotheses, info = Aggregator(rules).step(hypotheses, reading, STILL)
    return hypotheses, info


def test_the_first_reading_is_copied():
    reading = seen(3.0, "laser", (1, 0.5), (2, -2))
    found, info = run(RULES, [reading])
    np.testing.assert_array_equal(found.mean, reading.positions.mean)
    np.testing.assert_array_equal(found.cov, reading.positions.cov)
    np.testing.assert_allclose(found.weight, 0.2 + 0.3 * 0.8)
    assert found.identity.tolist() == info.identities.tolist() == [0, 1]
    assert found.born.tolist() == found.last_seen.tolist() == [3.0, 3.0]
    assert found.time == 3.0
    assert not info.matched.any()


def test_a_match_raises_the_weight_and_silence_lowers_it():
    before = known((2, 0), (2, 2), weight=[0.6, 0.9])
    after, info = run(PLAIN, [seen(0.5, "laser", (2, 0.01))], before)
    np.testing.assert_allclose(after.weight, [0.6 + 0.25 * 0.4, 0.9 - 0.8 * 0.5 / 2.0])
    assert after.last_seen.tolist() == [0.5, 0.0]
    assert after.born.tolist() == [0.0, 0.0]
    assert info.identities.tolist() == [0]
    assert info.matched.tolist() == [True]


@given(st.floats(0.5, 5), st.floats(0.05, 0.9), st.integers(1, 6), st.floats(0.05, 1))
@settings(max_examples=25)
def test_a_weight_of_one_is_lost_after_the_patience_however_often_nothing_is_seen(
    patience, threshold, readings, weight
):
    """Eq. (6): from w it takes (w - θ) / (1 - θ) of the patience."""
    sensor = SensorRules(alpha=0.5, patience=patience)
    rules = AggregationRules(threshold=threshold, person=threshold, sensors={"camera": sensor})
    weight = threshold + weight * (1 - threshold)
    life = patience * (weight - threshold) / (1 - threshold)
    times = np.linspace(0, 1, readings + 1)[1:]
    for share, left in ((0.999, 1), (1.001, 0)):
        quiet = [seen(t, "camera") for t in share * life * times]
        found, info = run(rules, quiet, known((2, 0), weight=weight))
        assert len(found) == left
        assert len(info.removed) == 1 - left


def test_the_patience_is_that_of_the_sensor_that_sees_nothing():
    rules = trusting(PLAIN, sonar=SensorRules(alpha=0.25, patience=8.0))
    for sensor, patience in (("laser", 2.0), ("sonar", 8.0)):
        found, _ = run(rules, [seen(0.5, sensor)], known((2, 0)))
        np.testing.assert_allclose(found.weight, 1 - 0.8 * 0.5 / patience)


def test_time_is_counted_once_however_many_sensors_speak():
    quiet = [seen(t, s) for t in (0.5, 1.0, 1.5) for s in ("laser", "sonar", "camera")]
    found, _ = run(PLAIN, quiet, known((2, 0)))
    np.testing.assert_allclose(found.weight, 1 - 0.8 * 1.5 / 2)


def test_the_camera_counts_more_behind_the_robot():
    rules = trusting(PLAIN, camera=SensorRules(alpha=0.1, patience=2.0, alpha_behind=0.4))
    places = [(2, 1.5), (2, -1.5), (2, 1.65), (2, -1.65)]
    found, _ = run(rules, [seen(0.1, "camera", *places)], known(*places, weight=0.5))
    np.testing.assert_allclose(found.weight, 0.5 + 0.5 * np.array([0.1, 0.1, 0.4, 0.4]))
    new, _ = run(rules, [seen(0.1, "camera", *places)])
    np.testing.assert_allclose(new.weight, 0.2 + 0.8 * np.array([0.1, 0.1, 0.4, 0.4]))


EAR = SensorRules(alpha=0.5, patience=2.0, silence=False)


def test_another_sensor_takes_a_name_and_its_rules():
    rules = trusting(PLAIN, microphone=EAR)
    found, info = run(rules, [seen(0.5, "microphone", (2, 0.01))], known((2, 0), weight=0.5))
    np.testing.assert_allclose(found.weight, 0.75)
    assert found.heard["microphone"] == 0.5
    assert info.matched.tolist() == [True]
    with pytest.raises(ValueError, match="sensor 'microphone', got some for camera, laser, sonar"):
        run(PLAIN, [seen(0.5, "microphone", (2, 0))])


def test_who_is_not_heard_is_silent_and_the_next_who_looks_counts_all_the_time():
    rules = trusting(PLAIN, microphone=EAR)
    ears = [seen(t, "microphone") for t in (0.2, 0.5, 0.9)]
    quiet, _ = run(rules, ears, known((2, 0)))
    assert quiet.weight.tolist() == [1.0]
    for readings in (ears, []):
        found, _ = run(rules, [*readings, seen(1.0, "laser")], known((2, 0)))
        np.testing.assert_allclose(found.weight, 1 - 0.8 * 1.0 / 2.0)


def test_silence_counts_from_the_last_sight():
    readings = [seen(0.5, "laser", (2, 0)), seen(0.8, "laser")]
    found, _ = run(PLAIN, readings, known((2, 0)))
    np.testing.assert_allclose(found.weight, 1 - 0.8 * 0.3 / 2.0)


def test_a_sensor_says_nothing_of_where_it_cannot_look():
    ahead = replace(EVEN, reach=3.0, sector=(-np.pi / 2, np.pi / 2))
    places = [(2, 0), (2, -1.5), (2, 1.6), (2, np.pi), (3.1, 0)]
    found, _ = run(trusting(PLAIN, laser=ahead), [seen(1.0, "laser")], known(*places))
    np.testing.assert_allclose(found.weight, [0.6, 0.6, 1, 1, 1])
    over_the_back = replace(EVEN, sector=(np.pi / 2, 3 * np.pi / 2))
    np.testing.assert_array_equal(
        over_the_back.sees(np.array(places)), [False, False, True, True, False]
    )


@given(seeds, st.permutations(["laser", "sonar", "camera"]))
@settings(max_examples=20)
def test_rules_are_the_same_in_whatever_order_their_sensors_are_named(seed, names):
    rules = replace(RULES, sensors={name: RULES.sensors[name] for name in names})
    assert rules == RULES
    assert hash(rules) == hash(RULES)
    assert list(rules.sensors) == ["camera", "laser", "sonar"]


@given(seeds, st.sampled_from(["determinants", "least determinant", "least trace"]))
@settings(max_examples=40)
def test_a_match_is_merged_by_the_rule(seed, omega):
    before = drawn(seed, 1)
    rng = np.random.default_rng(seed)
    there = before.mean[0] + 0.01 * rng.standard_normal(2)
    there[1] = wrap_angle(there[1])
    reading = Detections(0.1, "laser", Gaussian(there[None], np.diag([0.04, 0.01])[None]))
    a, b = reading.positions, Gaussian(before.mean, before.cov)
    weigh = getattr(fusion, "omega_" + omega.replace(" ", "_"))
    expected = {
        "intersection": fusion.covariance_intersection(a, b, weigh(a, b), angles=(1,)),
        "kalman": fusion.kalman_fusion(a, b, angles=(1,)),
    }
    for rule, one in expected.items():
        found, _ = run(replace(PLAIN, fusion=rule, omega=omega), [reading], before)
        np.testing.assert_allclose(found.mean, one.mean, rtol=1e-9)
        np.testing.assert_allclose(found.cov, one.cov, rtol=1e-9, atol=1e-15)


def test_the_nearest_pair_is_matched_first_and_each_once():
    before = known((2, 0.0), (2, 0.3))
    found, info = run(PLAIN, [seen(0.1, "laser", (2, 0.16), (2, 0.29))], before)
    assert info.identities.tolist() == [0, 1]
    found, info = run(PLAIN, [seen(0.1, "laser", (2, 0.2), (2, 0.29))], known((2, 0.3)))
    assert info.identities.tolist() == [1, 0]  # one is left over and new
    assert info.matched.tolist() == [False, True]
    assert found.following == 2


def test_the_gate_weighs_both_covariances():
    """d_m = x² / (C_i + C_j) on one axis; χ² of two numbers at the level 0.99 is 9.21."""
    for r, matched in (
        (2 + 0.98 * np.sqrt(9.21 * 0.05), True),
        (2 + 1.02 * np.sqrt(9.21 * 0.05), False),
    ):
        reading = seen(0.1, "laser", (r, 0), sigma=0.2)
        _, info = run(PLAIN, [reading], known((2, 0), cov=0.01))
        assert info.matched.tolist() == [matched]


def test_a_person_behind_the_robot_is_one_on_both_sides_of_pi():
    readings = [
        seen(0.1 * k, "laser", (2, wrap_angle(np.pi + 0.05 * (-1) ** k))) for k in range(1, 20)
    ]
    found, info = run(PLAIN, readings)
    assert len(found) == 1
    assert info.identities.tolist() == [0]
    assert abs(wrap_angle(found.mean[0, 1] - np.pi)) < 0.06


@given(seeds)
@settings(max_examples=40)
def test_prediction_moves_points_exactly_and_covariances_by_the_derivative(seed):
    before, rng = drawn(seed, 3), np.random.default_rng(seed)
    motion = np.array([*0.3 * rng.standard_normal(2), rng.uniform(-3, 3)])
    after = predict(before, 0.0, motion, 0.5)
    np.testing.assert_allclose(after.points, se2.act(se2.inverse(motion), before.points), atol=1e-9)
    h = 1e-6
    for k in range(3):
        columns = []
        for axis in range(2):
            ends = []
            for side in (h, -h):
                mean = before.mean.copy()
                mean[k, axis] += side
                ends.append(predict(replace(before, mean=mean), 0.0, motion, 0.5).mean[k])
            ends = np.subtract(*ends)
            columns.append(np.array([ends[0], wrap_angle(ends[1])]) / (2 * h))
        J = np.stack(columns, axis=-1)
        expected = J @ before.cov[k] @ J.T
        np.testing.assert_allclose(after.cov[k], expected, atol=1e-6 * np.abs(expected).max())


@given(seeds)
def test_two_motions_are_one(seed):
    before, rng = drawn(seed, 4), np.random.default_rng(seed)
    first, second = (np.array([*0.1 * rng.standard_normal(2), rng.normal()]) for _ in range(2))
    twice = predict(predict(before, 0.1, first, 0.0), 0.1, second, 0.0)
    once = predict(before, 0.2, se2.compose(first, second), 0.0)
    np.testing.assert_allclose(wrap_angle(twice.mean - once.mean), 0, atol=1e-9)
    np.testing.assert_allclose(twice.cov, once.cov, rtol=1e-6, atol=1e-12)


def test_people_walk_as_far_in_every_direction():
    """A random walk of 0.5 m in a second: in metres the variance grows alike on both axes."""
    for r in (0.5, 2.0, 8.0):
        before = known((r, 1.0), cov=1e-12)
        cov = predict(before, 4.0, STILL, 0.5).cov[0]
        np.testing.assert_allclose(cov, np.diag([1.0, 1.0 / r**2]), atol=1e-9)
        once = predict(before, 0.4, STILL, 0.5)
        many = before
        for _ in range(4):
            many = predict(many, 0.1, STILL, 0.5)
        np.testing.assert_allclose(many.cov, once.cov, atol=1e-9)


def test_who_stands_still_is_one_hypothesis_about_a_robot_that_drives():
    place = np.array([3.0, 1.0])
    motion = np.array([0.05, 0.01, 0.08])
    pose, found = np.zeros(3), Hypotheses.none()
    for k in range(60):
        x, y = se2.act(se2.inverse(pose), place[None])[0]
        reading = seen(0.1 * (k + 1), "laser", (np.hypot(x, y), np.arctan2(y, x)))
        found, _ = Aggregator(RULES).step(found, reading, motion if k else STILL)
        np.testing.assert_allclose(found.points, [[x, y]], atol=1e-6)
        assert found.identity.tolist() == [0]
        pose = se2.compose(pose, motion)


def test_bearing_of_the_camera_and_distance_of_the_sonar_make_a_place():
    """Only the aggregate knows where the person is: neither sensor alone is near."""
    r, phi = 1.2, 2.8
    camera = Gaussian(np.array([[2.5, phi]]), np.diag([2.0**2, 0.05**2])[None])
    sonar = Gaussian(np.array([[r, phi + 0.25]]), np.diag([0.15**2, 0.3**2])[None])
    readings = [
        Detections(0.1 * k, *pair)
        for k in range(40)
        for pair in (("camera", camera), ("sonar", sonar))
    ]
    found, _ = run(replace(RULES, omega="least determinant", walk=0.1), readings)
    np.testing.assert_allclose(found.mean, [[r, phi]], atol=0.1)
    assert found.persons(RULES).identity.tolist() == [0]


def test_hypotheses_that_have_become_one_are_made_one():
    before = known((2, 0.0), (2, 0.05), (4, 1), weight=[0.5, 0.9, 0.9], cov=0.01)
    found, info = run(replace(PLAIN, alike=1.0), [seen(0.1, "sonar", (4, 1))], before)
    assert info.absorbed == ((0, 1),)
    assert found.identity.tolist() == [0, 2]
    np.testing.assert_allclose(found.mean[0], [2, 0.025], atol=1e-12)
    np.testing.assert_allclose(found.weight[0], 0.9 - 0.8 * 0.1 / 2)
    apart, info = run(replace(PLAIN, alike=0.1), [seen(0.1, "sonar", (4, 1))], before)
    assert info.absorbed == ()
    assert len(apart) == 3


@given(seeds, st.integers(0, 5), st.integers(0, 5))
def test_all_pairs_of_detections_and_hypotheses_and_of_these_are_compared(seed, m, n):
    before = drawn(seed, n)
    found = seen(1.0, "laser", *np.random.default_rng(seed).uniform(1, 6, (m, 2)))
    after, info = Aggregator(PLAIN).step(before, found, STILL)
    assert info.compared == m * n + len(after) ** 2


def test_who_was_made_one_is_compared_again_with_all():
    """Three at one place: nine pairs, and three more for each of the two that go."""
    place = (2.0, 0.5)
    three = known(place, place, place)
    _, info = Aggregator(replace(PLAIN, alike=1.0)).step(three, seen(1.0, "laser"), STILL)
    assert len(info.absorbed) == 2
    assert info.compared == 9 + 3 + 3


def test_a_row_of_hypotheses_is_united_from_the_nearest_pair_on():
    before = known((2, 0.0), (2, 0.13), (2, 0.16), cov=0.01)
    found, info = run(replace(PLAIN, alike=1.2), [seen(0.1, "sonar", (5, -2))], before)
    assert info.absorbed == ((1, 2), (0, 1))
    assert found.identity.tolist() == [0, 3]
    np.testing.assert_allclose(found.mean[0], [2, (0.0 + 0.145) / 2], atol=1e-12)
    _, info = run(replace(PLAIN, alike=1.0), [seen(0.1, "sonar", (5, -2))], before)
    assert info.absorbed == ((1, 2),)  # 0.845 from the second alone, 1.05 from the two as one
    turned = known((2, 0.0), (2, 0.16), (2, 0.13), cov=0.01)
    _, info = run(replace(PLAIN, alike=1.0), [seen(0.1, "sonar", (5, -2))], turned)
    assert info.absorbed == ((1, 2),)  # who is gone is no longer near anybody
    two = seen(0.1, "laser", (2, 0.0), (2, 0.1))
    _, info = run(replace(PLAIN, alike=1.0), [two])
    assert info.identities.tolist() == [0, 0]


def test_persons_are_those_above_the_weight_of_a_person():
    found = known((2, 0), (3, 1), (4, 2), weight=[0.4, 0.5, 0.6])
    assert found.persons(RULES).identity.tolist() == [2]
    assert found.persons(replace(RULES, person=0.3)).identity.tolist() == [0, 1, 2]


def test_two_hundred_detections_at_once():
    rng = np.random.default_rng(1)
    places = np.stack([rng.uniform(0.5, 8, 200), rng.uniform(-np.pi, np.pi, 200)], axis=-1)
    found, info = run(RULES, [seen(0.1, "sonar", *places), seen(0.2, "sonar", *places)])
    assert len(info.identities) == 200
    assert set(info.identities.tolist()) == set(found.identity.tolist())


def test_a_hypothesis_is_never_nearer_than_has_a_meaning():
    moved = predict(known((0.5, 0.0)), 0.1, np.array([0.5, 0.0, 0.0]), 0.5)
    assert moved.mean[0, 0] == 0.1
    assert np.isfinite(moved.cov).all()
    found, _ = run(PLAIN, [seen(0.1, "sonar", (0.0, 1.0))])
    assert found.mean[0, 0] == 0.1


def test_nothing_that_goes_in_is_changed():
    before = drawn(7, 4)
    copy = [np.copy(getattr(before, name)) for name in before.__slots__]
    Aggregator(RULES).step(before, seen(0.1, "laser", *before.mean), np.array([0.1, 0.0, 0.2]))
    for name, value in zip(before.__slots__, copy, strict=True):
        np.testing.assert_array_equal(getattr(before, name), value)


def test_readings_in_the_wrong_order_are_refused():
    later, _ = run(RULES, [seen(1.0, "laser", (2, 0)), seen(1.0, "camera", (2, 0))])
    assert len(later) == 1  # another sensor may speak at the same time
    with pytest.raises(
        ValueError, match=r"must not be older than the last reading, of 1.0 s, got 0.5"
    ):
        Aggregator(RULES).step(later, seen(0.5, "sonar", (2, 0)), STILL)
    with pytest.raises(ValueError, match=r"detections of the laser at 1.0 s were there already"):
        Aggregator(RULES).step(later, seen(1.0, "laser", (2, 0)), STILL)


def test_a_long_silence_forgets_everybody():
    found, info = run(RULES, [seen(1000.0, "laser")], known((2, 0), (3, 1)))
    assert len(found) == 0
    assert info.removed == (0, 1)


def test_names_of_sensors_are_texts_and_rules_are_rules():
    with unchecked(), pytest.raises(TypeError, match="a name in sensors must be a str, got 3"):
        AggregationRules(sensors={3: EVEN, "a": EVEN})
    with unchecked(), pytest.raises(TypeError, match=r"sensors\['a'\] must be a SensorRules"):
        AggregationRules(sensors={"a": 0.5})


SOUND = known((2, 0), (3, 1))
BAD = [
    (
        lambda: Aggregator(RULES).step(SOUND, seen(1.0, "laser", (1, 0), sigma=0.0), STILL),
        "detections must have",
    ),
    (lambda: Aggregator(RULES).step(SOUND, seen(1.0, "laser"), np.zeros(2)), "motion must be"),
    (lambda: predict(SOUND, -1.0, STILL, 0.5), "duration must not be negative"),
    (lambda: replace(SOUND, weight=np.array([0.5, 1.5])), "weight must be from 0 to 1"),
    (lambda: replace(SOUND, identity=np.array([1, 0])), "identity must rise to below 2"),
    (lambda: replace(SOUND, following=1), "identity must rise to below 1"),
    (lambda: replace(SOUND, cov=np.zeros((2, 2, 2))), "cov must be positive definite"),
    (lambda: replace(SOUND, mean=-SOUND.mean), "mean must not have a negative distance"),
    (lambda: replace(SOUND, heard={"laser": np.inf}), "heard of laser must be finite"),
    (lambda: replace(SOUND, charged=np.zeros(3)), "charged must be"),
    (lambda: SOUND.select(np.array([True])), "chosen must be 2 truth values"),
    (lambda: SensorRules(0.0, 1.0), "alpha must be above 0"),
    (lambda: SensorRules(0.5, 0.0), "patience must be positive"),
    (lambda: SensorRules(0.5, 1.0, reach=0.0), "reach must be positive"),
    (lambda: SensorRules(0.5, 1.0, sector=(1.0, 1.0)), "sector must rise by a full turn"),
    (lambda: SensorRules(0.5, 1.0, sector=(-4.0, 4.0)), "sector must rise by a full turn"),
    (lambda: AggregationRules(sensors={}), "sensors must be one at least"),
    (lambda: AggregationRules(sensors={"": EVEN}), "sensors must be the name of a sensor"),
    (lambda: AggregationRules(threshold=0.5, person=0.4), "person must not be below"),
    (lambda: AggregationRules(omega="best"), "omega must be one of"),
    (lambda: AggregationRules(fusion="split"), "fusion must be one of"),
]


@pytest.mark.parametrize(("wrong", "message"), BAD)
def test_bad_input_is_named(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        wrong()

"""The exercises' answers are what happens."""

import numpy as np
import pytest

from robot_perception.beliefs import Gaussian
from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import (
    EXERCISES,
    adds_alpha,
    falls_to_nothing,
    never_deletes,
    repeated,
    update_weight,
)
from robot_perception.people.aggregation import (
    AggregationRules,
    Aggregator,
    Hypotheses,
    SensorRules,
)
from robot_perception.people.detections import Detections
from tests.chapters.exercises import assert_judged, assert_told

RULES = AggregationRules(threshold=0.3, walk=0.0, sensors={"laser": SensorRules(0.1, 3.0)})


def reading(time: float, *places: tuple[float, float]) -> Detections:
    mean = np.array(places).reshape(-1, 2)
    return Detections(time, "laser", Gaussian(mean, np.tile(0.01 * np.eye(2), (len(mean), 1, 1))))


def one(weight: float) -> Hypotheses:
    """Return a single hypothesis ahead, seen last at the time 0."""
    zero = np.zeros(1)
    return Hypotheses(
        np.array([[2.0, 0.0]]), 0.01 * np.eye(2)[None], np.array([weight]),
        np.zeros(1, dtype=np.int64), zero, zero, zero, {"laser": 0.0}, 1,
    )  # fmt: skip


def test_the_written_function_is_judged():
    exercise = EXERCISES["people-update"]
    assert exercise.judge(update_weight)[0] == "right"
    assert exercise.judge(0.5)[0] == "wrong"
    assert exercise.judge(lambda weight: weight)[0] == "wrong"
    wrong = (never_deletes, adds_alpha, falls_to_nothing)
    for given, (_, words) in zip(wrong, exercise.mistakes, strict=True):
        outcome, said = exercise.judge(given)
        assert outcome == "wrong"
        assert words in said


@pytest.mark.parametrize("weight", [0.31, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("matched", [True, False])
@pytest.mark.parametrize("elapsed", [0.02, 0.1, 1.0])
def test_the_written_function_is_what_the_aggregation_does(weight, matched, elapsed):
    seen = reading(elapsed, *[(2.0, 0.0)] * matched)
    after, _ = Aggregator(RULES).step(one(weight), seen, np.zeros(3))
    expected = update_weight(weight, matched, elapsed, 0.1, 3.0, 0.3)
    assert expected == pytest.approx(after.weight[0] if len(after) else 0.0)


def test_a_hypothesis_is_deleted_after_the_time_of_the_exercise():
    gone = EXERCISES["people-forgotten"].answer
    assert len(Aggregator(RULES).step(one(0.9), reading(gone - 1e-3), np.zeros(3))[0]) == 1
    assert len(Aggregator(RULES).step(one(0.9), reading(gone + 1e-3), np.zeros(3))[0]) == 0


def test_four_readings_of_the_faster_laser_are_one_of_the_old_one():
    faster = EXERCISES["people-rate"].answer
    old, new = repeated.one(0.2, 5)["power"], repeated.one(faster, 20)["power"]
    assert old * np.log(0.8) == pytest.approx(new * np.log(1 - faster))


def test_two_thresholds_cost_less_than_one_and_one_is_told():
    exercise = EXERCISES["people-counts"]
    assert_judged(exercise, lambda weights: weights.max() > 0.7)
    assert exercise.judge(page.HALF_MINUTE["weight above 0.4, as above"])[0] == "wrong"
    assert_told(exercise, lambda weights: weights[-1] > 0.6, "what the weight was before")


def test_no_single_threshold_is_better_than_the_one_of_the_exercise():
    best = page.cost_of(page.HALF_MINUTE["weight above 0.7"])
    for least in np.arange(0.3, 1.0, 0.05):
        assert page.cost_of(lambda weights, least=least: weights[-1] > least) >= best


def test_the_rule_of_the_page_misses_whom_the_page_misses():
    missed, false = page.costs(page.HALF_MINUTE["weight above 0.4, as above"])
    counts = page.tally(page.committee(page.page_session()), {"": page.EVERYWHERE})
    people, found, matched = (counts[name][0] for name in ("people", "found", "matched"))
    assert (missed, false) == (people - matched, found - matched)

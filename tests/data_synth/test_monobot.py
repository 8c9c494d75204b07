"""The rail world does what its words say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from data_synth.monobot import measure_anchor, planned_path, simulate_rail, watch_vehicle

SHAPES = ("sine", "there and back", "straight", "at rest")


def world(runs=3, *, seed=0, start=0.5, slip=0.1, blur=0.2, landmarks=(1.0, 3.0), steps=40):
    return simulate_rail(
        planned_path("sine", steps, start=-1.0, reach=1.0),
        np.array(landmarks),
        runs,
        start_deviation=start,
        motion_deviation=slip,
        measurement_deviation=blur,
        rng=np.random.default_rng(seed),
    )


@given(st.sampled_from(SHAPES), st.integers(1, 300), st.floats(-5, 5), st.floats(0, 5))
def test_plans_start_where_told_and_keep_their_reach(shape, steps, start, reach):
    plan = planned_path(shape, steps, start=start, reach=reach)
    assert plan.shape == (steps + 1,)
    assert plan[0] == start
    assert np.abs(plan - start).max() <= reach + 1e-12
    if shape != "straight":
        assert plan[-1] == pytest.approx(start, abs=1e-12)


def test_without_noise_the_robot_follows_its_plan_and_measures_exactly():
    runs = world(start=0.0, slip=0.0, blur=0.0)
    plan = planned_path("sine", 40, start=-1.0, reach=1.0)
    np.testing.assert_allclose(runs.positions, np.broadcast_to(plan, (3, 41)), atol=1e-12)
    np.testing.assert_allclose(
        runs.measurements[..., 0], np.broadcast_to(1.0 - plan, (3, 41)), atol=1e-12
    )


def test_a_run_is_the_same_however_many_are_made():
    few, many = world(2), world(50)
    np.testing.assert_array_equal(few.positions, many.positions[:2])
    np.testing.assert_array_equal(few.measurements, many.measurements[:2])


def test_noises_have_the_spread_that_was_asked_for_and_are_independent():
    slip = np.linspace(0.0, 0.5, 40)
    runs = world(4000, slip=slip, seed=5)
    starts = runs.positions[:, 0] + 1.0
    moves = np.diff(runs.positions, axis=1) - runs.commands
    measurements = runs.measurement_errors[:, 7, 1]
    assert np.abs(moves[:, 0]).max() < 1e-12
    for samples, deviation in ((starts, 0.5), (moves[:, -1], 0.5), (measurements, 0.2)):
        low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 4000) / 4000
        assert low < np.mean(samples**2) / deviation**2 < high
    # every draw of a run but the first move, which has none here
    together = np.column_stack([starts, moves[:, 1:], runs.measurement_errors.reshape(4000, -1)])
    correlations = np.corrcoef(together.T)[np.triu_indices(together.shape[1], 1)]
    assert np.abs(correlations).max() < 6 / np.sqrt(4000)
    runs = world(4000, seed=6)
    together = np.column_stack([runs.positions[:, 0], np.diff(runs.positions[:, :3], axis=1)])
    assert np.abs(np.corrcoef(together.T)[np.triu_indices(3, 1)]).max() < 6 / np.sqrt(4000)


def test_references_measure_what_they_say_with_the_same_errors():
    runs = world(500)
    anchor = measure_anchor(runs, 0.7, 0.2, rng=np.random.default_rng(1))
    camera = watch_vehicle(runs, 0.7, 0.2, rng=np.random.default_rng(1))
    errors = anchor - (0.7 - runs.positions[:, 1:])
    np.testing.assert_allclose(camera - (runs.positions[:, 1:] - 0.7), errors, atol=1e-12)
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], errors.size) / errors.size
    assert low < np.mean(errors**2) / 0.2**2 < high
    measurements = runs.measurement_errors[:, 1:, 0].ravel()
    assert abs(np.corrcoef(errors.ravel(), measurements)[0, 1]) < 4.5 / np.sqrt(errors.size)
    few = measure_anchor(world(3), 0.7, 0.2, rng=np.random.default_rng(1))
    np.testing.assert_array_equal(few, anchor[:3])


def test_reference_noise_may_differ_from_step_to_step():
    deviation = np.linspace(0.0, 0.5, 40)
    values = watch_vehicle(world(), 0.0, deviation, rng=np.random.default_rng(1))
    errors = values - world().positions[:, 1:]
    assert np.all(errors[:, 0] == 0)
    assert np.all(errors[:, 1:] != 0)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: planned_path("zigzag", 5, start=0, reach=1), "shape must be one of sine"),
        (lambda: planned_path("sine", 0, start=0, reach=1), "steps must be at least 1"),
        (lambda: world(0), "need a run and a landmark, got 0"),
        (lambda: world(landmarks=()), "need a run and a landmark"),
        (lambda: world(slip=-0.1), "motion_deviation must be finite and >= 0, got -0.1"),
        (lambda: world(blur=np.nan), "measurement_deviation must be finite"),
        (lambda: world(start=-1.0), "start_deviation must be finite"),
        (
            lambda: measure_anchor(world(), 0.0, -0.1, rng=np.random.default_rng(0)),
            "deviation must be finite and >= 0, got -0.1",
        ),
        (
            lambda: watch_vehicle(world(), 0.0, np.inf, rng=np.random.default_rng(0)),
            "deviation must be finite",
        ),
    ],
)
def test_bad_input_is_named(build, message):
    with pytest.raises(ValueError, match=message):
        build()

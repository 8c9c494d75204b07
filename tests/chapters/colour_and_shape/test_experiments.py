"""Studies of the chapter, small: one film of each, one iteration, samples, the path of a colour."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import experiments, iteration, samples

SMALL = experiments.Config(films=(9001,), trackers=("fused", "shape", "CamShift"), frames=3)


@pytest.fixture(scope="module")
def found():
    return experiments.run(SMALL, rng=np.random.default_rng(0))


@pytest.fixture(scope="module")
def step():
    return iteration.run(iteration.Config(), rng=np.random.default_rng(3))


@pytest.fixture(scope="module")
def shown():
    return samples.run("circles", 3, 4, rng=np.random.default_rng(1))


def test_every_tracker_is_scored_on_every_film(found):
    assert set(found) == {f"{w}, {t}" for w in experiments.WORLDS for t in SMALL.trackers}
    for overlap in found.values():
        assert overlap.shape == (1, 3)
        assert ((overlap >= 0) & (overlap <= 1)).all()


def test_a_film_is_as_long_as_it_is_tracked_and_its_first_frame():
    assert len(experiments.filmed("circles", 9001, 3).frames) == 4


def test_who_else_follows_a_film_changes_nothing(found):
    """A changed tracker is compared with the unchanged one on the same draws."""
    fused = experiments.run(
        replace(SMALL, trackers=("fused", "one sample")), rng=np.random.default_rng(0)
    )
    for world in experiments.WORLDS:
        np.testing.assert_array_equal(fused[f"{world}, fused"], found[f"{world}, fused"])
    spawned = np.random.default_rng(0).spawn(4)[0].spawn(len(experiments.TRACKERS))
    film = experiments.filmed("circles", 9001, 3)
    dynamics, rules = experiments.trained("circles"), experiments.rules_of("circles", "one sample")
    rng = spawned[experiments.TRACKERS.index("fused")]
    alone = experiments.follow("one sample", film, dynamics, rules, rng=rng)
    np.testing.assert_array_equal(experiments.scored(alone, film), fused["circles, one sample"][0])


def test_in_the_first_frames_the_fused_tracker_is_on_the_object(found):
    assert found["circles, fused"].min() > 0.5
    assert found["snail, fused"].min() > 0.5


def test_overlap_of_squares():
    square = np.array([[10.0, 10.0], [29.0, 10.0], [29.0, 29.0], [10.0, 29.0]])
    assert experiments.overlap(square, square, (60, 60)) == 1
    assert experiments.overlap(square, square + 30, (60, 60)) == 0
    aside = experiments.overlap(square, square + np.array([10.0, 0.0]), (60, 60))
    assert aside == pytest.approx(9 / 29, abs=1e-12)  # they are 19 px wide


def test_samples_drift_and_spread_from_those_drawn(step):
    config = iteration.Config()
    np.testing.assert_allclose(step.drifted, step.start[step.ancestors] + config.velocity)
    assert 0 < np.abs(step.moved - step.drifted).max() < 5 * config.noise
    assert step.start_weights.sum() == pytest.approx(1)


def test_weights_are_what_the_frame_says(step):
    says = iteration.likelihood(step.moved, iteration.Config())
    np.testing.assert_allclose(step.weights, says / says.sum(), rtol=1e-9)


def test_without_noise_samples_only_drift():
    still = iteration.run(replace(iteration.Config(), noise=0.0), rng=np.random.default_rng(3))
    np.testing.assert_allclose(still.moved, still.drifted)


def test_the_frame_fits_the_object_best(step):
    assert step.grid[step.likelihood.argmax()] == pytest.approx(iteration.Config().seen, abs=0.01)


def test_samples_come_best_first(shown):
    assert shown.weights[0] == pytest.approx(1)
    assert (np.diff(shown.weights) <= 1e-12).all()
    assert shown.clouds.shape[0] == shown.blobs.shape[0] == shown.outlines.shape[0] == 4
    assert shown.blobs.any(axis=(1, 2)).all()


def test_the_rectangle_loses_its_colour():
    colours = experiments.shown_colours(experiments.filmed("rectangle", 9001, 40))
    assert colours.shape == (41, 3)
    assert np.ptp(colours.astype(float), axis=0).max() > 60


def test_longest_stages_come_first_and_nothing_is_left_out():
    found = experiments.cost_table({"a": 0.001, "b": 0.004, "c": 0.002, "d": 0.0005}, most=2)
    assert list(found.rows) == ["b", "c", "all others", "together"]
    assert found["b", "ms a frame"] == pytest.approx(4)
    assert found["all others", "ms a frame"] == pytest.approx(1.5)
    assert found["together", "ms a frame"] == pytest.approx(7.5)

"""Studies of the chapter, small: one film of each, one iteration, samples, the path of a colour."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import experiments, iteration, samples

SMALL = experiments.Config(worlds=("circles", "snail"), films=(9001,), frames=3)


@pytest.fixture(scope="module")
def found():
    return experiments.run(SMALL, rng=np.random.default_rng(0))


@pytest.fixture(scope="module")
def step():
    return iteration.run(iteration.Config(), rng=np.random.default_rng(3))


@pytest.fixture(scope="module")
def shown():
    return samples.run(frame=3, rng=np.random.default_rng(1))


def test_every_tracker_is_scored_on_every_film(found):
    names = {f"{w}, {t}" for w in SMALL.worlds for t in experiments.TRACKERS}
    assert set(found.overlap) == set(found.missed) == names
    for name in names:
        assert found.overlap[name].shape == found.missed[name].shape == (1, 3)
        assert ((found.overlap[name] >= 0) & (found.overlap[name] <= 1)).all()


def test_a_film_is_as_long_as_it_is_tracked_and_its_first_frame():
    assert len(SMALL.film("circles", 9001).frames) == SMALL.frames + 1


def test_a_film_is_the_same_again(found):
    one = replace(SMALL, worlds=("circles",))
    again = experiments.run(one, rng=np.random.default_rng(0))
    for name, values in again.overlap.items():
        np.testing.assert_array_equal(found.overlap[name], values)


def test_who_else_follows_a_film_changes_nothing(found):
    """A changed tracker is compared with the unchanged one on the same draws."""
    alone = experiments.run(replace(SMALL, trackers=("fused",)), rng=np.random.default_rng(0))
    assert set(alone.overlap) == {"circles, fused", "snail, fused"}
    for name, values in alone.overlap.items():
        np.testing.assert_array_equal(found.overlap[name], values)


def test_in_the_first_frames_the_fused_tracker_is_on_the_object(found):
    assert found.overlap["circles, fused"].min() > 0.5
    assert found.overlap["snail, fused"].min() > 0.5


def test_lost_counts_last_frames_only():
    overlap = np.array([[0.0, 0.9], [0.9, 0.1], [0.9, 0.2]])
    found = experiments.Result({"snail, fused": overlap}, {"snail, fused": overlap < 0})
    assert found.lost("snail", "fused") == pytest.approx(1 / 3)
    np.testing.assert_allclose(found.mean("snail", "fused"), [0.45, 0.5, 0.55])


def test_overlap_of_squares():
    square = np.array([[10.0, 10.0], [29.0, 10.0], [29.0, 29.0], [10.0, 29.0]])
    assert experiments.overlap(square, square, (60, 60)) == 1
    assert experiments.overlap(square, square + 30, (60, 60)) == 0
    aside = experiments.overlap(square, square + np.array([10.0, 0.0]), (60, 60))
    assert aside == pytest.approx(9 / 29, abs=1e-12)  # they are 19 px wide


def test_no_scored_film_was_chosen_on():
    assert not {*experiments.CHOOSING, experiments.TRAINING} & {*experiments.Config().films}


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
    assert ((shown.scores >= 0) & (shown.scores <= 1)).all()


def test_the_rectangle_loses_its_colour():
    seen = samples.path()
    assert seen.colours.shape == seen.light.shape
    assert np.ptp(seen.colours.astype(float), axis=0).max() > 60

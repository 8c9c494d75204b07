"""The posts: only linearisation can make the filter wrong."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.posts import glimpse
from data_synth.wheels import roll
from robot_perception.chapters.loop_closing import loops, posts
from robot_perception.chapters.loop_closing.posts import LINEAR, TURNED
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.evaluation.intervals import bootstrap_mean
from tests.unchecked import unchecked

RNG = np.random.default_rng


@pytest.fixture(scope="module")
def linear():
    with unchecked():  # the checks of shapes take six sevenths of the time
        return posts.run(replace(LINEAR, variants=posts.JACOBIANS[:5]), rng=RNG(11))


@pytest.mark.parametrize("variant", posts.JACOBIANS[:5])
def test_noise_of_linear_size_leaves_the_filters_consistent(linear, variant):
    runs = linear[variant]
    low, high = average_bounds(3, 50, 1 - 1e-4)
    for step in (4, 100, 300, -1):
        assert low < runs.nees[:, step].mean() < high
    # steps of a run hang together, so that the share varies; see the next test for what it is
    assert runs.coverage.averaged_share > 0.75


def test_share_of_steps_in_the_band_is_what_honest_errors_of_such_memory_give(linear):
    """Errors drawn from the filter's own covariances, with the runs' memory, fill the band so."""
    runs = linear["first estimates"]
    averages = runs.coverage.averages - 3
    memory = np.corrcoef(averages[:-1], averages[1:])[0, 1]
    shocks = RNG(0).standard_normal((200, averages.size, 150))
    state, inside = RNG(1).standard_normal((200, 150)), np.zeros(200)
    low, high = average_bounds(3, 50)
    for k in range(averages.size):
        root = np.sqrt(max(memory, 0.0))  # squares remember the square of what errors remember
        state = root * state + np.sqrt(1 - root**2) * shocks[:, k]
        mean = (state**2).sum(axis=1) / 50
        inside += (low < mean) & (mean < high)
    least = np.quantile(inside / averages.size, 1e-2)
    assert runs.coverage.averaged_share >= least


def test_an_uncertain_start_breaks_the_plain_filter_and_not_the_one_with_first_estimates():
    variants = ("plain", "first estimates", "ideal")
    runs = posts.run(replace(TURNED, runs=30, variants=variants), rng=RNG(2))
    high = average_bounds(3, 30, 1 - 1e-6)[1]
    assert runs["plain"].nees[:, -1].mean() > high
    for variant in ("first estimates", "ideal"):
        assert runs[variant].nees[:, -1].mean() < high


def test_what_a_run_saw_is_the_worlds_glimpse_with_its_covariance():
    config = posts.Config(noise=2.0)
    places, poses = config.world
    drive = posts.simulate(config, rng=RNG(5))
    streams = RNG(5).spawn(4)
    seen = glimpse(places, poses, sigma=0.06, reach=6.0, rng=streams[0])
    for sighting, (ids, at) in zip(drive.seen, seen, strict=True):
        np.testing.assert_array_equal(sighting.ids, ids)
        np.testing.assert_array_equal(sighting.values, at)
        np.testing.assert_allclose(
            sighting.covs, np.broadcast_to(0.06**2 * np.eye(2), (len(ids), 2, 2))
        )
    assert drive.wheels["own"].deviations[0, 0] == pytest.approx(
        2 * roll(poses, posts.SMALL, rng=RNG(0)).deviations[0, 0]
    )


@pytest.fixture(scope="module")
def ruled():
    with unchecked():
        return posts.run(replace(posts.RULE, runs=12), rng=RNG(4))


def test_considered_landmarks_keep_the_filter_honest_and_frozen_ones_do_not(ruled):
    plain, rule, considered = ruled.runs.values()
    assert rule.retired.min() > 20
    assert rule.states.mean() < 0.2 * plain.states.mean()
    assert considered.states.mean() == pytest.approx(plain.states.mean())
    assert rule.path_error.mean() < 1.5 * plain.path_error.mean()
    assert rule.nees.mean() > 30 * plain.nees.mean()
    assert considered.nees.mean() == pytest.approx(plain.nees.mean(), rel=0.2)


def test_the_rule_states_less_than_it_errs_and_the_others_what_they_err(ruled):
    table = posts.rule_table(ruled)
    assert list(table.rows) == list(posts.RULE.variants)
    for name in ("plain", "considered at 50"):
        stated, error = (table[name, c].estimate for c in ("stated (m)", "path error (m)"))
        assert 0.5 < stated / error < 2
    assert table["rule at 50", "stated (m)"].estimate < table["rule at 50", "path error (m)"].low


def test_a_shifted_start_errs_in_place_and_not_in_heading():
    config = replace(posts.RULE, step=0.5, start="shifted")
    drive = posts.simulate(config, rng=RNG(3))
    history = loops.filter_drive(posts.case(config, "plain"), drive)
    off = history.start - drive.poses[0]
    np.testing.assert_allclose(off[:2], 0.1 * drive.start[:2], atol=1e-12)
    assert off[2] == 0


def test_table_has_the_numbers_of_each_filter(linear):
    table = posts.consistency(linear)
    assert list(table.rows) == list(linear.runs)
    for name, runs in linear.runs.items():
        assert table[name, "NEES"] == bootstrap_mean(runs.nees.mean(axis=1))
        assert table[name, "in band"] == runs.coverage.averaged_share
        assert table[name, "end (m)"].estimate == runs.distance().mean()


def test_a_filter_may_believe_less_of_its_wheels_than_is_true():
    true, believed = (
        posts.simulate(replace(LINEAR, believed=share), rng=RNG(6)).wheels["own"]
        for share in (1.0, 0.25)
    )
    np.testing.assert_array_equal(believed.increments, true.increments)
    np.testing.assert_allclose(believed.deviations, true.deviations / 4)

"""The page's filters against the exact belief and the library, and laws of weights and draws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception import particles
from robot_perception.beliefs import ParticleSet
from robot_perception.book import many_guesses as page
from robot_perception.book import one_belief
from tests.chapters.exercises import assert_judged, assert_told

STEPS = [page.condensation, page.auxiliary, page.importance]
weights = st.lists(st.floats(0, 1), min_size=2, max_size=30).filter(lambda w: sum(w) > 0.1)


def share(given):
    found = np.array(given)
    return found / found.sum()


# Weights and draws -------------------------------------------------------------------------------


@given(weights)
def test_the_effective_number_is_the_librarys_and_of_any_sum(given):
    some = np.maximum(share(given), 1e-12)
    assert page.effective(some) == pytest.approx(particles.effective_number(np.log(some)))
    assert page.effective(7 * some) == pytest.approx(page.effective(some))
    assert 1 - 1e-9 <= page.effective(some) <= len(some) + 1e-9


@pytest.mark.parametrize("name", page.WAYS)
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_each_way_draws_what_the_librarys_draws(name, seed):
    some = np.random.default_rng(seed).dirichlet(np.full(40, 0.3))
    ours = page.WAYS[name](some, 40, np.random.default_rng(seed))
    theirs = getattr(particles, name)(some, 40, rng=np.random.default_rng(seed))
    assert (ours == theirs).all()


@pytest.mark.parametrize("name", page.WAYS)
def test_each_way_draws_as_often_as_the_weights_say(name):
    some, rng = np.array([0.5, 0.3, 0.15, 0.05]), np.random.default_rng(0)
    counts = sum(np.bincount(page.WAYS[name](some, 10, rng), minlength=4) for _ in range(4000))
    assert np.abs(counts / 4000 - 10 * some).max() < 0.1


def test_weights_make_means_under_another_density():
    rng = np.random.default_rng(1)
    x = 1 + 2 * rng.standard_normal(200_000)
    w = page.over(x, lambda x: np.exp(-0.5 * (x - 2) ** 2), page.flat)
    assert w @ x == pytest.approx(2, abs=0.02)
    assert w @ x**2 == pytest.approx(5, abs=0.08)


# Steps -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("sensor", [0.05, 0.4])
@pytest.mark.parametrize("seed", range(6))
def test_a_step_is_the_librarys(step, sensor, seed):
    rng = np.random.default_rng(seed)
    samples, some = rng.uniform(0, page.LENGTH, 60), rng.dirichlet(np.ones(60))
    z = rng.uniform(0, 4)
    prior = ParticleSet(samples[:, None], np.log(some))
    theirs, _ = page.BY_LIBRARY[step.__name__](prior, z, sensor, np.random.default_rng(seed))
    ours = step(samples, some, z, sensor, np.random.default_rng(seed))
    np.testing.assert_allclose(ours[0], theirs.states[:, 0], atol=1e-12)
    np.testing.assert_allclose(ours[1], theirs.weights, atol=1e-12)


@pytest.mark.parametrize("step", STEPS)
def test_each_filter_aims_at_the_exact_belief(step):
    x, z = page.drive(np.random.default_rng(5), 0.2)
    beliefs = page.exact(z, 0.2)
    for (samples, some), belief in zip(
        page.follow(step, z, 0.2, np.random.default_rng(0), 50_000), beliefs, strict=True
    ):
        counted = np.histogram(samples, 40, (0, page.LENGTH), weights=some)[0]
        listed = belief.reshape(40, -1).sum(axis=1)
        assert np.abs(counted - listed).max() < 0.03
    assert len(beliefs) == len(x) + 1


def test_the_exact_belief_is_that_of_the_other_page():
    """By cells of a decimetre, rolled by a matrix instead of a convolution."""
    z = [1.0, 0.3]
    belief = one_belief.ANYWHERE
    for measurement in z:
        belief = one_belief.predict(belief, page.SPEED, page.WHEELS)
        likelihood = np.exp(page.log_likelihood(measurement, one_belief.PLACES, 0.4))
        belief = one_belief.update(belief, likelihood)
    fine = page.exact(z, 0.4)[-1].reshape(200, 10).sum(axis=1)
    assert np.abs(fine - belief).max() < 2e-3


def test_a_proposal_is_the_product_of_motion_and_measurement():
    mean, deviation = page.proposed(np.array([2.0]), 0.7, 0.2)  # to 3 m, where the door is at 4
    by_update = one_belief.gaussian_update(3.0, page.WHEELS**2, 4.0 - 0.7, 0.2**2)
    assert (mean[0], deviation**2) == pytest.approx(by_update)


@pytest.mark.slow
def test_a_better_sensor_is_worse_for_few_guesses_and_not_for_the_list():
    found = page.lost_by_sensor("condensation")
    listed = page.lost_by_sensor("exact")
    assert found[0.02].low > found[0.2].high
    assert listed[0.02].estimate <= listed[0.2].estimate
    mended = page.lost_by_sensor("importance")
    assert mended[0.02].high < page.lost_by_sensor("auxiliary")[0.02].high
    assert page.lost_by_sensor("auxiliary")[0.02].high < found[0.02].low


# Exercises ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "right"),
    [
        ("guesses-weights", page.over),
        ("guesses-effective", page.effective),
        ("guesses-comb", page.with_offset),
    ],
)
def test_answers_are_judged(key, right):
    assert_judged(page.EXERCISES[key], right)


@pytest.mark.parametrize(
    ("key", "wrong", "said"),
    [
        ("guesses-weights", lambda x, f, g: f(x) / g(x), "their sum"),
        ("guesses-weights", lambda x, f, g: page.over(x, g, f), "too often"),
        ("guesses-weights", lambda x, f, g: f(x) / f(x).sum(), "already more"),
        ("guesses-effective", lambda w: 1 / (w**2).sum(), "add up"),
        ("guesses-effective", lambda w: 1 / w.sum(), "always 1"),
        ("guesses-comb", lambda w, u: page.picked(w, np.full(len(w), u)), "tooth for each"),
    ],
)
def test_typical_mistakes_are_told_apart(key, wrong, said):
    assert_told(page.EXERCISES[key], wrong, said)


def test_a_comb_is_systematic_drawing_with_its_random_number():
    some = np.random.default_rng(0).dirichlet(np.ones(20))
    offset = np.random.default_rng(9).random()
    drawn = page.systematic(some, 20, np.random.default_rng(9))
    assert (page.with_offset(some, offset) == drawn).all()


def test_heavy_tails_keep_the_drives_and_stay_sharp():
    """What the solution says, and both ways in which a Gaussian fails."""
    own = page.EXERCISES["guesses-own"]
    assert own.judge(lambda gaps: -np.log(1 + (gaps / 0.02) ** 2))[0] == "right"
    for sigma, words in ((0.02, "too many drives"), (0.1, "blunt")):
        outcome, said = own.judge(lambda gaps, sigma=sigma: -0.5 * (gaps / sigma) ** 2)
        assert outcome == "wrong"
        assert words in said

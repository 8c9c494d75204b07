"""Resampling against its law and other libraries; particle filters against the Kalman filter."""

import numpy as np
import pytest
from filterpy.monte_carlo import residual_resample
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, chisquare, multivariate_normal

from robot_perception import kalman
from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.particles import (
    auxiliary,
    condensation,
    effective_number,
    importance,
    multinomial,
    residual,
    stratified,
    systematic,
)
from tests.unchecked import unchecked

SCHEMES = [systematic, stratified, residual, multinomial]
WEIGHTS = np.array([0.0, 0.31, 0.02, 0.17, 0.0, 0.4, 0.1, 0.0])
SEEDS = st.integers(0, 2**31)
LISTS = st.lists(st.floats(0, 1), min_size=1, max_size=30).filter(lambda w: sum(w) > 1e-3)


def picked(draw, runs, rng):
    """Return how often each particle is a draw picked blindly: independent over the runs."""
    drawn = [(found := draw())[rng.integers(found.size)] for _ in range(runs)]
    return np.bincount(drawn, minlength=WEIGHTS.size)


def p_value(draw, rng):
    """Return how likely a scatter like this one is if the expected numbers are N ω."""
    runs, may = 3000, WEIGHTS > 0
    counts = picked(draw, runs, rng)
    assert not counts[~may].any()
    return chisquare(counts[may], runs * WEIGHTS[may]).pvalue


@pytest.mark.parametrize("count", [3, 11])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme_is_unbiased(scheme, count):
    rng = np.random.default_rng(count)
    assert p_value(lambda: scheme(7 * WEIGHTS, count, rng=rng), rng) > 1e-3


def test_filterpys_residual_resampling_is_biased_for_want_of_the_factor_n(monkeypatch):
    rng = np.random.default_rng(0)
    monkeypatch.setattr("filterpy.monte_carlo.resampling.random", rng.random)
    assert p_value(lambda: residual_resample(WEIGHTS), rng) < 1e-20
    theirs = [np.bincount(residual_resample(WEIGHTS), minlength=8) for _ in range(2000)]
    ours = [np.bincount(residual(WEIGHTS, 8, rng=rng), minlength=8) for _ in range(2000)]
    assert WEIGHTS[6] > 0
    assert np.mean(theirs, axis=0)[6] == 0  # without a whole copy for certain it has no chance
    np.testing.assert_allclose(np.mean(ours, axis=0), 8 * WEIGHTS, atol=0.06)


@given(LISTS, st.integers(1, 60), SEEDS)
def test_numbers_of_copies_stay_within_what_the_scheme_promises(weights, count, seed):
    rng, weights = np.random.default_rng(seed), np.array(weights)
    expected = count * weights / weights.sum()
    for scheme, below, above in (
        (systematic, 1, 1),
        (stratified, 2, 2),
        (residual, 1, count),
        (multinomial, count, count),
    ):
        drawn = scheme(weights, count, rng=rng)
        assert (np.diff(drawn) >= 0).all()
        copies = np.bincount(drawn, minlength=weights.size)
        assert copies.size == weights.size
        assert copies.sum() == count
        assert not copies[weights == 0].any()
        assert (copies > expected - below - 1e-9).all()
        assert (copies < expected + above + 1e-9).all()


@given(LISTS, st.integers(1, 60), SEEDS)
def test_points_are_looked_up_in_the_cumulative_sum(weights, count, seed):
    """Oracle: NumPy's binary search; in eighths, so that points on an edge are there and exact."""
    weights = np.ceil(8 * np.array(weights))
    weights[0] += 2.0 ** np.ceil(np.log2(weights.sum())) - weights.sum()
    edges = np.cumsum(weights) / weights.sum()
    for scheme, offsets in (
        (systematic, lambda twin: np.full(count, twin.random())),
        (stratified, lambda twin: twin.random(count)),
    ):
        points = (np.arange(count) + offsets(np.random.default_rng(seed))) / count
        drawn = scheme(weights, count, rng=np.random.default_rng(seed))
        near = np.abs(edges[:, None] - points).min(axis=0) < 1e-12
        found = np.searchsorted(edges, points, side="right")
        np.testing.assert_array_equal(drawn[~near], found[~near])


class Fixed(np.random.Generator):
    """A generator whose points of [0, 1) all lie in one place; those of `multinomial` at 0 or 1."""

    def __init__(self, value):
        super().__init__(np.random.PCG64(0))
        self.value = value

    def random(self, size=None):
        return np.full(size, self.value) if size else self.value

    def standard_exponential(self, size):
        return np.eye(1, size, 0 if self.value else size - 1)[0]


@pytest.mark.parametrize("scheme", [systematic, stratified])
def test_a_point_on_an_edge_belongs_to_the_next_particle_with_a_weight(scheme):
    weights = np.array([0.0, 1, 0, 1, 0, 2, 0])
    assert scheme(weights, 4, rng=Fixed(0.0)).tolist() == [1, 3, 5, 5]
    last = Fixed(np.nextafter(1, 0))
    assert scheme(weights, 4, rng=last).tolist() == [1, 3, 5, 5]
    assert scheme(weights, 1, rng=last).tolist() == [5]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_particle_without_weight_is_not_drawn_by_a_point_at_zero(scheme):
    drawn = scheme(np.array([0.0, 0.0, 1.0, 2.0]), 4, rng=Fixed(0.0))
    assert drawn.min() == 2


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_point_that_rounding_leaves_over_falls_to_the_last_particle_with_a_weight(scheme):
    rng, last = np.random.default_rng(0), Fixed(np.nextafter(1, 0))
    for m in range(1, 200):
        weights = np.append(rng.random(m), [0.0, 0.0])
        assert scheme(weights, 7, rng=last).max() == m - 1


@pytest.mark.parametrize("scheme", SCHEMES)
def test_one_heavy_particle_takes_all_and_the_scale_does_not_matter(scheme):
    rng = np.random.default_rng(0)
    heavy = np.array([0.0, 0.0, 1e-300, 0.0])
    assert scheme(heavy, 9, rng=rng).tolist() == [2] * 9
    for unit in (2.0**-1030, 1e-250, 1e300):
        drawn = scheme(unit * WEIGHTS, 9, rng=np.random.default_rng(1))
        np.testing.assert_array_equal(drawn, scheme(WEIGHTS, 9, rng=np.random.default_rng(1)))


@pytest.mark.parametrize("copies", [1, 3])
def test_what_is_whole_but_for_rounding_is_drawn_for_certain(copies):
    rng = np.random.default_rng(0)
    for m in range(1, 300):
        weights = np.full(m, 1 / m) if m % 2 else np.tile([0.1, 0.1], m // 2)
        drawn = residual(weights, copies * m, rng=rng)
        np.testing.assert_array_equal(drawn, np.repeat(np.arange(m), copies))


def test_schemes_scatter_as_theory_says():
    """Multinomial numbers scatter as χ² does; those of the others less, Douc and Cappé 2005."""
    rng, runs, count = np.random.default_rng(1), 4000, 12
    weights = WEIGHTS[WEIGHTS > 0]
    scatter = {}
    for scheme in SCHEMES:
        copies = [
            np.bincount(scheme(weights, count, rng=rng), minlength=weights.size)
            for _ in range(runs)
        ]
        scatter[scheme] = np.sum((np.array(copies) - count * weights) ** 2 / (count * weights))
    low, high = chi2(runs * (weights.size - 1)).ppf([1e-4, 1 - 1e-4])
    assert low < scatter[multinomial] < high
    for scheme in (systematic, stratified, residual):
        assert scatter[scheme] < scatter[multinomial] / 2


def test_effective_number_by_hand():
    assert effective_number(np.full(7, -1e4)) == pytest.approx(7)
    assert effective_number(np.array([1e4, 0.0, -1e4])) == pytest.approx(1)
    assert effective_number(np.log([2.0, 1.0, 1.0])) == pytest.approx(16 / 6)
    two = np.stack([np.zeros(3), [0, -np.inf, -np.inf]])
    np.testing.assert_allclose(effective_number(two), [3, 1])
    rng = np.random.default_rng(0)
    belief = ParticleSet(np.zeros((9, 1)), rng.normal(size=9))
    assert effective_number(belief) == pytest.approx(1 / np.sum(belief.weights**2))
    assert 1 / np.sum(belief.weights) == pytest.approx(1)  # the printed form decides nothing


F, Q = np.array([[1.0, 0.5], [0.0, 0.9]]), np.array([[0.05, 0.02], [0.02, 0.1]])
H, R = np.array([[1.0, 0.3]]), np.array([[0.2]])
START = Gaussian(np.array([0.5, -1.0]), np.array([[0.4, 0.1], [0.1, 0.3]]))
ROOT = np.linalg.cholesky(Q)
LOOKS = np.array([0.3, 0.1, -0.6, -1.3, -0.4])


def move(states, rng):
    return states @ F.T + rng.standard_normal(states.shape) @ ROOT.T


def expect(states):
    return states @ F.T


def likelihood(z):
    def log_likelihood(states):
        return -((z - states @ H[0]) ** 2) / (2 * R[0, 0]) - np.log(2 * np.pi * R[0, 0]) / 2

    return log_likelihood


def best_proposal(z):
    """Return a draw from the best proposal, p(x | x before, z), and the ratio of its density."""
    gain = Q @ H.T / (H @ Q @ H.T + R)
    cov = (np.eye(2) - gain @ H) @ Q
    root = np.linalg.cholesky(cov)
    aim, motion = multivariate_normal(np.zeros(2), cov), multivariate_normal(np.zeros(2), Q)

    def centre(states):
        return states @ F.T + (z - states @ F.T @ H.T) @ gain.T

    def propose(states, rng):
        return centre(states) + rng.standard_normal(states.shape) @ root.T

    def log_ratio(before, after):
        return motion.logpdf(after - before @ F.T) - aim.logpdf(after - centre(before))

    return propose, log_ratio


def proposed(prior, z, rng, share=0.5):
    propose, ratio = best_proposal(z)
    return importance(prior, propose, likelihood(z), rng=rng, share=share, log_ratio=ratio)


FILTERS = {
    "condensation": lambda p, z, rng: condensation(p, move, likelihood(z), rng=rng),
    "residual": lambda p, z, rng: condensation(p, move, likelihood(z), rng=rng, scheme=residual),
    "importance": lambda p, z, rng: importance(p, move, likelihood(z), rng=rng, share=0.7),
    "never": lambda p, z, rng: importance(p, move, likelihood(z), rng=rng, share=0.0),
    "proposal": proposed,
    "auxiliary": lambda p, z, rng: auxiliary(p, move, expect, likelihood(z), rng=rng),
    "auxiliary, other first stage": lambda p, z, rng: auxiliary(
        p, move, expect, likelihood(z), rng=rng, ahead=lambda s: 0.5 * likelihood(z)(s)
    ),
}


@pytest.mark.parametrize("name", FILTERS)
def test_a_particle_filter_is_the_kalman_filter_but_for_chance(name):
    """Over 60 runs the means of mean, covariance and evidence are the filter's; of the evidence
    itself, not its logarithm, as theory has it.
    """
    exact, log_evidence = START, 0.0
    for z in LOOKS:
        exact, info = kalman.update(
            kalman.predict(exact, kalman.Motion(F, Q)), np.array([z]), kalman.Sensor(H, R)
        )
        log_evidence += float(info.log_likelihood)
    found = []
    for rng in np.random.default_rng(3).spawn(60):
        states = START.mean + rng.standard_normal((1000, 2)) @ np.linalg.cholesky(START.cov).T
        belief, total = ParticleSet.uniform(states), 0.0
        for z in LOOKS:
            belief, step = FILTERS[name](belief, z, rng)
            total += step.log_evidence
        spread = belief.cov[np.triu_indices(2)]
        found.append([*belief.mean, *spread, np.exp(total - log_evidence)])
    wanted = np.array([*exact.mean, *exact.cov[np.triu_indices(2)], 1.0])
    errors = np.std(found, axis=0, ddof=1) / np.sqrt(len(found))
    assert (np.abs(np.mean(found, axis=0) - wanted) < 4 * errors).all()
    std = np.sqrt(np.diag(exact.cov))
    sizes = np.array([*std, *np.outer(std, std)[np.triu_indices(2)], 1.0])
    assert (errors < 0.025 * sizes).all(), "chance hides nothing"


def prior_of(count=50, seed=0):
    rng = np.random.default_rng(seed)
    return ParticleSet(rng.normal(size=(count, 2)), rng.normal(size=count))


def test_the_best_proposal_leaves_weights_that_do_not_depend_on_the_draw():
    prior, z = prior_of(), 0.7
    posterior, info = proposed(prior, z, np.random.default_rng(0), share=0.0)
    S = H @ Q @ H.T + R
    expected = prior.log_weights + multivariate_normal([0.0], S).logpdf(
        z - prior.states @ F.T @ H.T
    )
    assert info.log_evidence == pytest.approx(np.log(np.exp(expected).sum()))
    np.testing.assert_allclose(posterior.weights, np.exp(expected - info.log_evidence), rtol=1e-9)


def test_an_auxiliary_step_that_foresees_the_state_leaves_equal_weights():
    """A motion without noise: all that is left to chance is the draw."""
    prior, z = prior_of(), 0.7
    posterior, info = auxiliary(
        prior, lambda s, _: expect(s), expect, likelihood(z), rng=np.random.default_rng(0)
    )
    joint = prior.weights * np.exp(likelihood(z)(expect(prior.states)))
    assert info.effective == pytest.approx(50)
    assert info.log_evidence == pytest.approx(np.log(joint.sum()))
    np.testing.assert_allclose(posterior.states, expect(prior.states[info.ancestors]))
    copies = np.bincount(info.ancestors, minlength=50)
    assert (np.abs(copies - 50 * joint / joint.sum()) < 1).all()


def test_condensation_draws_by_the_old_weights_and_weighs_by_the_new():
    prior, z = prior_of(), 0.7
    still = prior.states.copy(), prior.log_weights.copy()
    posterior, info = condensation(
        prior, lambda s, _: expect(s), likelihood(z), rng=np.random.default_rng(0)
    )
    copies = np.bincount(info.ancestors, minlength=50)
    assert (np.abs(copies - 50 * prior.weights) < 1).all()
    np.testing.assert_allclose(posterior.states, expect(prior.states[info.ancestors]))
    likely = np.exp(likelihood(z)(posterior.states))
    np.testing.assert_allclose(posterior.weights, likely / likely.sum())
    assert info.log_evidence == pytest.approx(np.log(likely.mean()))
    assert info.effective == pytest.approx(effective_number(posterior))
    assert info.resampled
    np.testing.assert_array_equal(prior.states, still[0])
    np.testing.assert_array_equal(prior.log_weights, still[1])


@pytest.mark.parametrize(("share", "both"), [(0.0, {False}), (0.3, {False, True}), (1.0, {True})])
def test_importance_draws_anew_only_below_the_share(share, both):
    prior, seen = prior_of(), set()
    for z in np.linspace(-4, 4, 9):
        rng = np.random.default_rng(0)
        posterior, info = importance(
            prior, lambda s, _: s, likelihood(z), rng=rng, share=share, scheme=stratified
        )
        weights = prior.weights * np.exp(likelihood(z)(prior.states))
        assert info.effective == pytest.approx(weights.sum() ** 2 / np.sum(weights**2))
        assert info.log_evidence == pytest.approx(np.log(weights.sum()))
        assert info.resampled == (info.effective < share * 50)
        np.testing.assert_array_equal(posterior.states, prior.states[info.ancestors])
        if info.resampled:
            assert effective_number(posterior) == pytest.approx(50)
            drawn = stratified(weights / weights.sum(), 50, rng=np.random.default_rng(0))
            np.testing.assert_array_equal(info.ancestors, drawn)
        else:
            np.testing.assert_allclose(posterior.weights, weights / weights.sum())
            np.testing.assert_array_equal(info.ancestors, np.arange(50))
        seen.add(info.resampled)
    assert seen == both


def test_particles_that_cannot_have_made_the_measurement_die_out():
    states = np.array([[0.0], [1.0], [2.0], [3.0]])
    wall = lambda s: np.where(s[:, 0] > 1.5, 0.0, -np.inf)  # noqa: E731
    rng = np.random.default_rng(0)
    prior = ParticleSet.uniform(states)
    posterior, info = importance(prior, lambda s, _: s, wall, rng=rng, share=1.0)
    assert set(info.ancestors) == {2, 3}
    assert info.log_evidence == pytest.approx(np.log(0.5))
    posterior, info = auxiliary(prior, lambda s, _: s, lambda s: s, wall, rng=rng)
    assert set(info.ancestors) == {2, 3}
    np.testing.assert_allclose(posterior.weights, 0.25)


@pytest.mark.parametrize("name", FILTERS)
def test_same_seed_same_numbers(name):
    one, other = (FILTERS[name](prior_of(), 0.7, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one[0].states, other[0].states)
    np.testing.assert_array_equal(one[0].log_weights, other[0].log_weights)
    assert one[1].log_evidence == other[1].log_evidence


RNG, PRIOR = np.random.default_rng(0), prior_of(4)


def stay(states, _):
    return states


def none(states):
    return np.full(len(states), -np.inf)


def step(**changes):
    """Return a step of which something is wrong."""
    words = {"prior": PRIOR, "move": stay, "log_likelihood": likelihood(0.0), **changes}
    return importance(
        words.pop("prior"), words.pop("move"), words.pop("log_likelihood"), rng=RNG, **words
    )


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: systematic(np.array([]), 3, rng=RNG), "weights must not be empty"),
        (lambda: systematic(np.zeros(3), 3, rng=RNG), "a sum of 0"),
        (lambda: stratified(np.array([1.0, np.nan]), 3, rng=RNG), "a least weight of nan"),
        (lambda: residual(np.array([2.0, -0.5]), 3, rng=RNG), "a least weight of -0.5"),
        (lambda: multinomial(np.array([1.0, np.inf]), 3, rng=RNG), "a sum of inf"),
        (lambda: systematic(np.ones((2, 2)), 3, rng=RNG), r"weights must be \(m,\), got \(2, 2\)"),
        (lambda: systematic(np.ones(2), 0, rng=RNG), "count must be at least 1, got 0"),
        (lambda: effective_number(np.full(3, -np.inf)), "log_weights must not all be -inf"),
        (lambda: step(prior=ParticleSet.uniform(np.ones((2, 3, 1)))), "prior must be one set"),
        (
            lambda: step(prior=ParticleSet(np.ones((3, 1)), np.ones((2, 3)))),
            "prior must be one set",
        ),
        (lambda: step(move=lambda s, _: s[:2]), r"move\(states, rng\) must be \(4, 2\), got"),
        (lambda: step(move=lambda s, _: s / 0), r"move\(states, rng\) must be finite, got 8 of 8"),
        (lambda: step(log_likelihood=none), "log_likelihood is -inf for all 4 particles"),
        (lambda: step(log_likelihood=lambda s: s), r"log_likelihood\(states\) must be \(4,\)"),
        (
            lambda: step(log_likelihood=lambda s: np.where(s[:, 0] > 0, np.nan, 0)),
            r"log_likelihood must be finite or -inf, got \d of 4 otherwise",
        ),
        (
            lambda: step(log_ratio=lambda s, _: np.full(4, np.inf)),
            "log_ratio must be finite or -inf, got 4 of 4 otherwise",
        ),
        (lambda: step(share=1.5), "share must be from 0 to 1, got 1.5"),
        (
            lambda: step(share=1.0, scheme=lambda w, n, *, rng: np.full(n, 4)),
            "scheme must draw from 4 particles, got 4",
        ),
        (
            lambda: step(share=1.0, scheme=lambda w, n, *, rng: np.arange(3)),
            r"scheme\(weights, count\) must be \(4,\), got \(3,\)",
        ),
        (
            lambda: condensation(
                ParticleSet(np.ones((2, 1)), np.array([0.0, -np.inf])),
                stay,
                lambda s: s[:, 0],
                rng=RNG,
                scheme=lambda w, n, *, rng: np.arange(2),
            ),
            "scheme must not draw a particle without weight, got 1",
        ),
        (
            lambda: auxiliary(PRIOR, stay, lambda s: s[:, :1], likelihood(0.0), rng=RNG),
            r"expect\(states\) must be \(4, 2\), got \(4, 1\)",
        ),
        (lambda: auxiliary(PRIOR, stay, lambda s: s, none, rng=RNG), "log_likelihood is -inf for"),
        (
            lambda: auxiliary(
                PRIOR, stay, lambda s: s, likelihood(0.0), rng=RNG, ahead=lambda s: s[:, 0] / 0
            ),
            "ahead must be finite or -inf",
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()

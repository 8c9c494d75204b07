"""Fusion of two beliefs: the information form, SciPy's minimisers, every correlation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.geometry import wrap_angle
from tests.unchecked import unchecked

CRITERIA = [
    (fusion.omega_least_determinant, lambda cov: np.linalg.slogdet(cov)[1]),
    (fusion.omega_least_trace, np.trace),
]
seeds = st.integers(0, 10**6)


def drawn(rng, n, *batch, spread=1.0):
    """Return beliefs whose axes differ in length by factors of about e^spread."""
    turns = np.linalg.qr(rng.standard_normal((*batch, n, n)))[0]
    scaled = turns * np.exp(spread * rng.standard_normal((*batch, 1, n)))
    return Gaussian(rng.standard_normal((*batch, n)), scaled @ scaled.mT)


def root(cov):
    """Return a symmetric root."""
    values, vectors = np.linalg.eigh(cov)
    return vectors * np.sqrt(np.maximum(values, 0))[..., None, :] @ vectors.mT


def cross_covariances(rng, a, b, count):
    """Draw cross-covariances that the two covariances admit, extreme ones too.

    They are the products of the two roots and a matrix of singular values up to 1.
    """
    n = a.mean.shape[-1]
    U, _, Vt = np.linalg.svd(rng.standard_normal((count, n, n)))
    values = rng.uniform(size=(count, 1, n)) ** rng.choice([0, 0.2, 1], (count, 1, 1))
    signs = rng.choice([-1, 1], (count, 1, n))
    return root(a.cov) @ (U * values * signs @ Vt) @ root(b.cov)


def errors_of(result_gain, a, b, cross):
    """Return the covariance of the error of a mean (I - K) a + K b for a cross-covariance."""
    K, rest = result_gain, np.eye(len(a.mean)) - result_gain
    mixed = rest @ cross @ K.T
    return rest @ a.cov @ rest.T + K @ b.cov @ K.T + mixed + mixed.mT


def gain_of(rule, a, b):
    """Return the gain of a rule by which means it makes of unit differences."""
    n = len(a.mean)
    units = Gaussian(a.mean + np.eye(n), b.cov)
    return (rule(Gaussian(a.mean, a.cov), units).mean - a.mean).T


def surplus(cov, error_covs):
    """Return by how much a covariance exceeds others in the worst direction, relative to it."""
    whiten = np.linalg.inv(np.linalg.cholesky(cov))
    return 1 - np.linalg.eigvalsh(whiten @ error_covs @ whiten.T).max()


@given(seeds, st.integers(1, 5), st.floats(0.01, 0.99))
def test_intersection_is_that_of_the_information_form(seed, n, omega):
    rng = np.random.default_rng(seed)
    a, b = drawn(rng, n, 4), drawn(rng, n, 1, 3, 1)
    found = fusion.covariance_intersection(a, b, omega)
    printed = fusion.intersection_by_inverses(a, b, omega)
    Y = (1 - omega) * np.linalg.inv(a.cov) + omega * np.linalg.inv(b.cov)
    y = (1 - omega) * np.linalg.solve(a.cov, a.mean[..., None]) + omega * np.linalg.solve(
        b.cov, b.mean[..., None]
    )
    for result in (found, printed):
        assert result.mean.shape == (1, 3, 4, n)
        np.testing.assert_allclose(Y @ result.cov, np.broadcast_to(np.eye(n), Y.shape), atol=1e-9)
        np.testing.assert_allclose((Y @ result.mean[..., None]), y, atol=1e-9 * np.abs(Y).max())
    np.testing.assert_array_equal(found.cov, found.cov.mT)


def test_the_ends_are_the_two_beliefs_even_if_one_is_sure():
    rng = np.random.default_rng(1)
    a, b = drawn(rng, 3), drawn(rng, 3)
    for omega, expected in ((0.0, a), (1.0, b)):
        for rule in (fusion.covariance_intersection, fusion.inverse_covariance_intersection):
            found = rule(a, b, omega)
            np.testing.assert_allclose(found.mean, expected.mean, rtol=1e-9)
            np.testing.assert_allclose(found.cov, expected.cov, rtol=1e-9)
    sure = Gaussian(np.zeros(2), np.diag([0.0, 1.0]))
    found = fusion.covariance_intersection(sure, Gaussian(np.ones(2), np.eye(2)), 0.5)
    np.testing.assert_allclose(found.cov, np.diag([0.0, 1.0]), atol=1e-15)
    np.testing.assert_allclose(found.mean, [0.0, 0.5], atol=1e-15)


@pytest.mark.parametrize("omega", [0.0, 1.0])
@pytest.mark.parametrize("regular", [(True, False), (False, True), (False, False), (True, True)])
def test_all_weight_on_one_belief_is_that_belief_whatever_the_other(regular, omega):
    """Singular or not, alone and in a batch with others that are regular."""
    rng, turned = np.random.default_rng(4), np.linalg.qr(np.ones((3, 3)) + np.eye(3))[0]
    covs = [turned @ np.diag([1.0, 4.0, 2.0 * good]) @ turned.T for good in regular]
    beliefs = [Gaussian(rng.normal(size=3), (cov + cov.T) / 2) for cov in covs]
    one = fusion.covariance_intersection(*beliefs, omega, angles=(2,))
    expected = beliefs[int(omega)]
    wrapped = [*expected.mean[:2], wrap_angle(expected.mean[2])]
    np.testing.assert_allclose(one.mean, wrapped, atol=1e-12)
    np.testing.assert_allclose(one.cov, expected.cov, atol=1e-12)
    if any(regular):
        many = fusion.covariance_intersection(*beliefs, np.array([omega, 0.5]), angles=(2,))
        np.testing.assert_array_equal(many.mean[0], one.mean)
        np.testing.assert_array_equal(many.cov[0], one.cov)


@given(seeds, st.integers(1, 4))
def test_swapping_the_beliefs_swaps_the_weights(seed, n):
    a, b = (drawn(np.random.default_rng(seed + i), n) for i in range(2))
    for rule in (fusion.omega_determinants, *(rule for rule, _ in CRITERIA)):
        w = rule(a, b)
        assert w == pytest.approx(1 - rule(b, a), abs=1e-9)
        one = fusion.covariance_intersection(a, b, w)
        other = fusion.covariance_intersection(b, a, 1 - w)
        np.testing.assert_allclose(one.mean, other.mean, atol=1e-9)
        np.testing.assert_allclose(one.cov, other.cov, rtol=1e-9, atol=1e-12)


@given(seeds, st.integers(1, 4))
@settings(max_examples=40)
def test_the_best_weights_are_those_that_scipy_finds(seed, n):
    rng = np.random.default_rng(seed)
    a, b = drawn(rng, n, spread=0.5), drawn(rng, n, spread=0.5)
    for rule, size in CRITERIA:

        def cost(w, size=size):
            return size(fusion.intersection_by_inverses(a, b, float(w)).cov)

        best = minimize_scalar(cost, bounds=(0, 1), method="bounded", options={"xatol": 1e-10})
        w = rule(a, b)
        assert cost(w) <= min(best.fun, cost(0.0), cost(1.0)) + 1e-12 * (1 + abs(best.fun))
        flat = max(abs(cost(0.0) - best.fun), abs(cost(1.0) - best.fun)) < 1e-6
        assert flat or w == pytest.approx(best.x, abs=1e-3)


@given(seeds, st.integers(2, 4))
def test_the_slope_of_the_size_is_zero_at_a_weight_between_the_ends(seed, n):
    rng = np.random.default_rng(seed)
    a, b = drawn(rng, n), drawn(rng, n)
    for rule, size in CRITERIA:
        w, h = rule(a, b), 1e-5
        if not 0.01 < w < 0.99:
            continue
        before, at, after = (
            size(fusion.intersection_by_inverses(a, b, w + d).cov) for d in (-h, 0, h)
        )
        curvature = (before - 2 * at + after) / h**2
        assert abs(after - before) / (2 * h) <= 1e-4 * max(curvature, 1e-3)


def test_many_pairs_are_weighed_as_one_by_one():
    rng = np.random.default_rng(2)
    a, b = drawn(rng, 3, 5, 1), drawn(rng, 3, 4)
    for rule in (fusion.omega_determinants, *(rule for rule, _ in CRITERIA)):
        together = rule(a, b)
        assert together.shape == (5, 4)
        for i, j in np.ndindex(5, 4):
            one = rule(Gaussian(a.mean[i, 0], a.cov[i, 0]), Gaussian(b.mean[j], b.cov[j]))
            assert one == pytest.approx(together[i, j], abs=1e-12)


def test_a_belief_that_is_better_in_every_direction_is_taken_alone():
    rng = np.random.default_rng(3)
    a = drawn(rng, 3)
    better = Gaussian(a.mean, 0.5 * a.cov)
    for rule, _ in CRITERIA:
        assert rule(a, better) == 1
        assert rule(better, a) == 0
        assert rule(a, a) == 0.5
        assert 0 < fusion.omega_determinants(better, a) < 0.5


def test_weights_do_not_overflow():
    small, large = (Gaussian(np.zeros(2), s * np.eye(2)) for s in (1e-70, 1e70))
    for rule in (fusion.omega_determinants, *(rule for rule, _ in CRITERIA)):
        assert rule(small, large) == 0
        assert rule(large, small) == 1


def pair_with(eigenvalues, rng):
    """Return two covariances of which Cb⁻¹ Ca has these eigenvalues."""
    b = drawn(rng, len(eigenvalues))
    T = np.linalg.cholesky(b.cov) @ np.linalg.qr(rng.standard_normal(b.cov.shape))[0]
    return Gaussian(b.mean, T * np.array(eigenvalues) @ T.T), b


@given(seeds, st.floats(0.05, 20), st.floats(0.05, 20))
def test_equation_4_is_the_best_weight_of_two_numbers_in_two_cases_and_no_other(seed, x, y):
    """Equal determinants, or tr(Cb⁻¹ Ca) = 2 (1 + |Ca| / |Cb|)."""
    rng = np.random.default_rng(seed)
    other = (2 - x) / (1 - 2 * x) if x != 0.5 else 0  # x + other = 2 (1 + x other)
    for eigenvalues, equal in (((x, 1 / x), True), ((x, other), True), ((x, y), False)):
        if min(eigenvalues) <= 1e-3 or abs(x - 1) < 0.01:
            continue
        product, total = np.prod(eigenvalues), sum(eigenvalues)
        a, b = pair_with(eigenvalues, rng)
        apart = fusion.omega_determinants(a, b) - fusion.omega_least_determinant(a, b)
        if equal:
            assert apart == pytest.approx(0, abs=1e-6)
        elif abs(product - 1) > 0.01 and abs(total - 2 * (1 + product)) > 0.01:
            assert abs(apart) > 1e-6


@pytest.mark.parametrize("q", [1.0, 4.0, 25.0, 100.0])
def test_how_far_equation_4_is_from_the_least_determinant(q):
    """Two beliefs that know different things, Ca = 1 and Cb = diag(d, q / d) with large d."""
    a, b = (Gaussian(np.zeros(2), np.diag(values)) for values in ([1.0, 1.0], [1e8, q / 1e8]))
    sizes = [
        np.linalg.det(fusion.covariance_intersection(a, b, rule(a, b)).cov)
        for rule in (fusion.omega_determinants, fusion.omega_least_determinant)
    ]
    assert sizes[0] / sizes[1] == pytest.approx((1 + q) ** 2 / (4 * q), rel=1e-3)


def test_equation_4_can_give_a_larger_determinant_than_one_belief_alone():
    """The better one is better in every direction: nothing is to be gained from the other."""
    a, b = pair_with((1 / 1.7, 1 / 1.7), np.random.default_rng(9))
    found = fusion.covariance_intersection(a, b, fusion.omega_determinants(a, b))
    alone = fusion.covariance_intersection(a, b, fusion.omega_least_determinant(a, b))
    np.testing.assert_allclose(alone.cov, a.cov, rtol=1e-9)
    ratio = np.linalg.det(found.cov) / np.linalg.det(a.cov)
    assert ratio == pytest.approx(((1.7 + 1.7**3) / (1 + 1.7**3)) ** 2, rel=1e-9)


def test_equal_determinants_do_not_make_equation_4_best_for_three_numbers():
    a, b = pair_with((10.0, 1.0, 0.1), np.random.default_rng(4))
    assert fusion.omega_least_determinant(a, b) == pytest.approx(0.5, abs=1e-9)
    a, b = pair_with((4.0, 4.0, 1 / 16), np.random.default_rng(4))
    assert fusion.omega_determinants(a, b) == pytest.approx(0.5, abs=1e-9)
    # 6 / (1 + 3 ω) = 15 / (16 - 15 ω), the derivative of log |C⁻¹| at ω
    assert fusion.omega_least_determinant(a, b) == pytest.approx(0.6, abs=1e-6)


@given(seeds, st.integers(1, 4), st.floats(0, 1))
@settings(max_examples=60)
def test_intersection_is_consistent_for_every_correlation(seed, n, omega):
    rng = np.random.default_rng(seed)
    a, b = drawn(rng, n), drawn(rng, n)
    covs = cross_covariances(rng, a, b, 100)
    weights = [omega, *(rule(a, b) for rule, _ in CRITERIA), fusion.omega_determinants(a, b)]
    for w in weights:

        def rule(a, b, w=w):
            return fusion.covariance_intersection(a, b, w)

        result = rule(a, b)
        assert surplus(result.cov, errors_of(gain_of(rule, a, b), a, b, covs)) >= -1e-9


@given(seeds, st.integers(1, 4))
@settings(max_examples=30)
def test_the_kalman_filter_is_not(seed, n):
    """Nor is any other rule that gives a smaller covariance than a's in some direction."""
    rng = np.random.default_rng(seed)
    a = drawn(rng, n)
    b = Gaussian(a.mean, a.cov)
    same = a.cov[None]  # twice the same belief
    result, gain = fusion.kalman_fusion(a, b), gain_of(fusion.kalman_fusion, a, b)
    np.testing.assert_allclose(result.cov, a.cov / 2, rtol=1e-9)
    np.testing.assert_allclose(errors_of(gain, a, b, same)[0], a.cov, rtol=1e-9)
    assert surplus(result.cov, errors_of(gain, a, b, same)) == pytest.approx(-1, abs=1e-6)
    independent = errors_of(gain, a, b, 0 * same)
    np.testing.assert_allclose(independent[0], result.cov, rtol=1e-9)


@given(seeds, st.integers(1, 4))
@settings(max_examples=60)
def test_inverse_intersection_is_consistent_for_common_information_and_tighter(seed, n):
    """Beliefs with information of their own and some, of covariance Γ or less, that both have."""
    rng = np.random.default_rng(seed)
    common, own_a, own_b = (drawn(rng, n) for _ in range(3))
    a, b = (Gaussian(own.mean, _both(common, own)) for own in (own_a, own_b))
    # errors of a and b: weighted sums of independent errors, of which they share one
    cross = a.cov @ np.linalg.solve(common.cov, b.cov)
    for w in (0.1, 0.5, 0.8):

        def rule(a, b, w=w):
            return fusion.inverse_covariance_intersection(a, b, w)

        result, intersection = rule(a, b), fusion.covariance_intersection(a, b, w)
        errors = errors_of(gain_of(rule, a, b), a, b, cross[None])
        assert surplus(result.cov, errors) >= -1e-7
        assert surplus(intersection.cov, result.cov[None]) >= -1e-7


def _both(one, other):
    return one.cov @ np.linalg.solve(one.cov + other.cov, other.cov)


def test_inverse_intersection_is_not_consistent_for_every_correlation():
    rng = np.random.default_rng(5)
    a, b = drawn(rng, 2), drawn(rng, 2)

    def rule(a, b):
        return fusion.inverse_covariance_intersection(a, b, 0.5)

    errors = errors_of(gain_of(rule, a, b), a, b, cross_covariances(rng, a, b, 200))
    assert surplus(rule(a, b).cov, errors) < -0.05


@given(seeds, st.integers(1, 4), st.floats(0.05, 0.95))
@settings(max_examples=40)
def test_split_intersection_is_consistent_and_joins_the_two_others(seed, n, omega):
    rng = np.random.default_rng(seed)
    dependent = [drawn(rng, n) for _ in range(2)]
    own = [drawn(rng, n).cov for _ in range(2)]
    a, b = (Gaussian(d.mean, d.cov + i) for d, i in zip(dependent, own, strict=True))

    def rule(a, b):
        return fusion.split_covariance_intersection(a, b, *own, omega)[0]

    result, independent = fusion.split_covariance_intersection(a, b, *own, omega)
    gain = gain_of(rule, a, b)
    covs = cross_covariances(rng, *dependent, 100)
    assert surplus(result.cov, errors_of(gain, a, b, covs)) >= -1e-9
    rest = np.eye(n) - gain
    expected = rest @ own[0] @ rest.T + gain @ own[1] @ gain.T
    np.testing.assert_allclose(independent, expected, rtol=1e-7, atol=1e-9 * expected.max())
    none, everything = np.zeros((n, n)), (a.cov, b.cov)
    for parts, other in (
        ((none, none), fusion.covariance_intersection(a, b, omega)),
        (everything, fusion.kalman_fusion(a, b)),
    ):
        found, _ = fusion.split_covariance_intersection(a, b, *parts, omega)
        np.testing.assert_allclose(found.mean, other.mean, atol=1e-9)
        np.testing.assert_allclose(found.cov, other.cov, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_angles_wrap(side):
    """Turned so that the angles are on the two sides of ±π, the result is turned and no more."""
    rng = np.random.default_rng(6)
    cov_a, cov_b = drawn(rng, 2).cov, drawn(rng, 2).cov
    parts = (0.2 * cov_a, 0.3 * cov_b)
    rules = [
        fusion.kalman_fusion,
        lambda a, b, **k: fusion.covariance_intersection(a, b, 0.3, **k),
        lambda a, b, **k: fusion.inverse_covariance_intersection(a, b, 0.3, **k),
        lambda a, b, **k: fusion.split_covariance_intersection(a, b, *parts, 0.3, **k)[0],
    ]
    turn = np.array([0.0, np.pi])
    for rule in rules:
        plain = rule(
            Gaussian(np.array([2.0, 0.1 * side]), cov_a),
            Gaussian(np.array([2.5, -0.2 * side]), cov_b),
        )
        across = rule(
            Gaussian(np.array([2.0, side * (0.1 - np.pi)]), cov_a),
            Gaussian(np.array([2.5, side * (np.pi - 0.2)]), cov_b),
            angles=(1,),
        )
        apart = across.mean - plain.mean - turn
        apart[1] = (apart[1] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(apart, 0, atol=1e-12)
        assert -np.pi <= across.mean[1] < np.pi
        np.testing.assert_allclose(across.cov, plain.cov, rtol=1e-12)


@given(seeds, st.floats(-6, 6), st.floats(-6, 6))
def test_units_change_nothing_but_the_trace(seed, one, two):
    rng = np.random.default_rng(seed)
    a, b = drawn(rng, 2), drawn(rng, 2)
    U = np.diag([10.0**one, 10.0**two])
    scaled_a, scaled_b = (Gaussian(U @ x.mean, U @ x.cov @ U) for x in (a, b))
    for rule in (fusion.omega_determinants, fusion.omega_least_determinant):
        w = rule(a, b)
        assert rule(scaled_a, scaled_b) == pytest.approx(w, abs=1e-6)
    plain = fusion.covariance_intersection(a, b, 0.3)
    scaled = fusion.covariance_intersection(scaled_a, scaled_b, 0.3)
    np.testing.assert_allclose(U @ plain.cov @ U / scaled.cov, 1, rtol=1e-6)
    np.testing.assert_allclose(U @ plain.mean, scaled.mean, rtol=1e-6, atol=1e-9 * U.max())


ONE = Gaussian(np.zeros(2), np.eye(2))
SURE = Gaussian(np.zeros(2), np.diag([1.0, 0.0]))
LONG = Gaussian(np.zeros(3), np.eye(3))
MANY = Gaussian(np.zeros((4, 2)), np.eye(2))
BAD = [
    (lambda: fusion.covariance_intersection(ONE, LONG, 0.5), "a and b must be of the same n"),
    (lambda: fusion.covariance_intersection(ONE, ONE, 1.5), "omega must be from 0 to 1, got 1.5"),
    (lambda: fusion.covariance_intersection(MANY, ONE, np.full(3, 0.5)), "omega"),
    (lambda: fusion.covariance_intersection(ONE, ONE, 0.5, angles=(2,)), "angles must be indices"),
    (lambda: fusion.covariance_intersection(SURE, SURE, 0.5), "a and b must have a regular sum"),
    (lambda: fusion.covariance_intersection(SURE, SURE, 1e-300), "regular sum"),
    (lambda: fusion.intersection_by_inverses(SURE, ONE, 0.5), "covariance of a"),
    (lambda: fusion.kalman_fusion(SURE, SURE), "sum of the covariances"),
    (lambda: fusion.inverse_covariance_intersection(ONE, SURE, 0.5), "covariance of b"),
    (lambda: fusion.omega_determinants(ONE, SURE), "covariance of b"),
    (lambda: fusion.omega_least_determinant(SURE, ONE), "positive definite, got a singular one"),
    (lambda: fusion.omega_least_trace(ONE, SURE), "positive definite, got a singular one"),
    (
        lambda: fusion.split_covariance_intersection(ONE, ONE, 0 * np.eye(2), np.eye(2), 1.0),
        "omega must be between 0 and 1",
    ),
    (
        lambda: fusion.split_covariance_intersection(ONE, ONE, 2 * np.eye(2), np.eye(2), 0.5),
        "a_independent must not exceed",
    ),
]


@pytest.mark.parametrize(("wrong", "message"), BAD)
def test_bad_input_is_named(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        wrong()

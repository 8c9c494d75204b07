"""Particles that detections steer: what they believe, and what they find."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import integrate, stats

from robot_perception.beliefs import ParticleSet
from robot_perception.companion.cues import contour_distances, edge_distances
from robot_perception.companion.faces.icondensation import (
    ELLIPSE,
    PATCHES,
    FaceFilter,
    FaceFilterRules,
    FaceFilterState,
)
from tests.unchecked import unchecked

NONE = np.zeros((0, 4))
RULES = FaceFilterRules(particles=400)


def picture(u=160.0, v=120.0, side=60.0):
    """Return noise with a head: an ellipse of skin with hair above it."""
    image = np.random.default_rng(0).integers(90, 130, (240, 320, 3)).astype(np.uint8)
    middle = round(u), round(v + 0.06 * side)
    cv2.ellipse(
        image, middle, (round(0.44 * side), round(0.58 * side)), 0, 0, 360, (60, 40, 30), -1
    )
    face = round(u), round(v + 0.12 * side)
    cv2.ellipse(
        image, face, (round(0.40 * side), round(0.48 * side)), 0, 0, 360, (210, 160, 130), -1
    )
    return image


def square(u, v, side):
    return np.array([u - side / 2, v - side / 2, side, side])


def started(rules=RULES):
    return FaceFilter(rules).start(picture(), square(160, 120, 60), rng=np.random.default_rng(1))


def test_detections_say_where_to_look_and_not_what_to_believe():
    """With many particles the steered and the plain filter have the same mean and spread."""
    many = replace(RULES, particles=8_000, anywhere=0.05)
    state, image = started(many), picture(166, 123, 63)
    told = np.array([square(172, 118, 60), square(60, 60, 40)])
    found = []
    for rules in (many, replace(many, steered=0.0)):
        after, _ = FaceFilter(rules).step(state, image, told, rng=np.random.default_rng(2))
        found.append((after.particles.mean, np.sqrt(np.diag(after.particles.cov))))
    (steered, wide), (plain, narrow) = found
    np.testing.assert_allclose(steered, plain, atol=0.15 * narrow.max())
    np.testing.assert_allclose(wide, narrow, rtol=0.15)


def test_the_weights_of_both_estimate_the_same_evidence():
    many = replace(RULES, particles=8_000, anywhere=0.05)
    state, image = started(many), picture(166, 123, 63)
    logs = [
        FaceFilter(rules).step(state, image, told, rng=np.random.default_rng(3))[1].log_evidence
        for rules, told in ((many, square(168, 122, 62)[None]), (many, NONE))
    ]
    assert logs[0] == pytest.approx(logs[1], abs=0.1)


def test_the_prior_and_the_proposal_are_densities():
    """Of u, v and the logarithm of the side: they integrate to 1."""
    faces = FaceFilter(replace(RULES, anywhere=0.3))
    before = ParticleSet.uniform(np.array([[150.0, 110, 50], [180.0, 130, 60]]))
    size = np.array([320.0, 240.0])
    u, v = np.arange(-20.0, 341, 2.0), np.arange(-20.0, 261, 2.0)
    logs = np.linspace(np.log(24), np.log(160), 60)
    grid = np.stack(np.meshgrid(u, v, np.exp(logs), indexing="ij"), axis=-1).reshape(-1, 3)
    boxes = np.array([square(100, 90, 45)])
    for density in (faces._prior(grid, before, size), faces._proposal(grid, boxes)):
        table = density.reshape(len(u), len(v), len(logs))
        total = integrate.simpson(integrate.simpson(integrate.simpson(table, logs), v), u)
        assert total == pytest.approx(1.0, abs=0.02)


def test_a_face_that_is_suddenly_elsewhere_is_found_by_a_detection():
    image, told = picture(60, 90, 50), square(61, 91, 50)[None]
    rng = np.random.default_rng(4)
    state = started()
    steered, info = FaceFilter(RULES).step(state, image, told, rng=rng)
    assert info.steered == 200
    assert np.hypot(*(steered.particles.mean[:2] - (60, 90))) < 8
    plain, info = FaceFilter(RULES).step(state, image, NONE, rng=rng)
    assert info.steered == 0
    assert np.hypot(*(plain.particles.mean[:2] - (60, 90))) > 25  # half a face off


def test_false_detections_do_not_draw_the_filter_away():
    state, rng = started(), np.random.default_rng(5)
    false = np.array([square(40, 40, 50), square(280, 200, 50)])
    for k in range(6):
        state, info = FaceFilter(RULES).step(state, picture(160 + 3 * k), false, rng=rng)
        assert np.hypot(*(state.particles.mean[:2] - (160 + 3 * k, 120))) < 10
    assert info.effective > 5


def test_without_detections_it_is_condensation():
    state = started()
    one, _ = FaceFilter(RULES).step(state, picture(), NONE, rng=np.random.default_rng(6))
    plain = replace(RULES, steered=0.0)
    told = square(160, 120, 60)[None]
    other, _ = FaceFilter(plain).step(state, picture(), told, rng=np.random.default_rng(6))
    np.testing.assert_array_equal(one.particles.states, other.particles.states)
    np.testing.assert_array_equal(one.particles.weights, other.particles.weights)


def test_the_likelihood_is_highest_at_the_face():
    state, faces = started(), FaceFilter(RULES)
    around = np.array([[160.0 + a, 120 + b, 60.0] for a in (-20, 0, 20) for b in (-20, 0, 20)])
    assert faces.log_likelihood(picture(), around, state.reference).argmax() == 4
    sizes = np.array([[160.0, 120, s] for s in (40.0, 60.0, 85.0)])
    assert faces.log_likelihood(picture(), sizes, state.reference).argmax() == 1


def test_the_box_is_that_of_the_mean():
    even = np.full((len(PATCHES), 3, 8), 0.125)
    states = np.array([[100.0, 80, 40], [110.0, 90, 60]])
    box = FaceFilterState(ParticleSet.uniform(states), even).box
    np.testing.assert_allclose(box, [80, 60, 50, 50])


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: FaceFilterRules(particles=1), "particles must be"),
        (lambda: FaceFilterRules(steered=1.0), "steered must be below 1"),
        (lambda: FaceFilterRules(sides=(90.0, 30.0)), "sides must rise"),
        (lambda: FaceFilterRules(move=0.0), "move must be"),
        (
            lambda: FaceFilter().step(started(), picture(), np.zeros((1, 4)), rng=RNG),
            "boxes must have",
        ),
        (lambda: FaceFilter().step(started(), picture()[..., 0], NONE, rng=RNG), "image must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with unchecked(), pytest.raises(ValueError, match=text):
        wrong()


RNG = np.random.default_rng(0)


def test_a_side_beyond_the_largest_has_no_prior_by_a_jump():
    rules, state = replace(RULES, anywhere=0.5), started()
    size = np.array([320.0, 240.0])
    low, high = rules.sides
    places = np.array([[10.0, 10, s] for s in (0.99 * low, 1.01 * low, 0.99 * high, 1.01 * high)])
    f = FaceFilter(rules)._prior(places, state.particles, size)
    assert (f[[1, 2]] > 1e-7).all()
    assert (f[[0, 3]] < 1e-12).all()


def test_a_share_of_the_walking_particles_jumps():
    rules = replace(RULES, particles=4000, steered=0.0, anywhere=0.25)
    after, _ = FaceFilter(rules).step(started(rules), picture(), NONE, rng=np.random.default_rng(4))
    away = np.hypot(*(after.particles.states[:, :2] - [160, 120]).T) > 60
    assert 0.18 < away.mean() < 0.26


def test_jumps_are_even_in_the_logarithm_of_the_side_as_their_density_says():
    rules = FaceFilterRules(particles=2_000, anywhere=1.0, steered=0.0)
    after, _ = FaceFilter(rules).step(started(rules), picture(), NONE, rng=np.random.default_rng(3))
    low, high = np.log(rules.sides)
    share = (np.log(after.particles.states[:, 2]) - low) / (high - low)
    assert stats.kstest(share, "uniform").pvalue > 0.01


def test_particles_of_weight_are_the_ancestors():
    """One of four hundred has all the weight: without jumps all others come from it."""
    rules = replace(RULES, anywhere=0.0, steered=0.0)
    state = started(rules)
    states, logs = np.tile([60.0, 60.0, 40.0], (400, 1)), np.full(400, -1e3)
    states[17], logs[17] = [160, 120, 60], 0.0
    after, _ = FaceFilter(rules).step(
        replace(state, particles=ParticleSet(states, logs)), picture(), NONE,
        rng=np.random.default_rng(4),
    )  # fmt: skip
    assert np.abs(after.particles.states - [160, 120, 60]).max() < 40


def test_steered_particles_spread_about_detections_as_the_proposal_says():
    rules = replace(RULES, place_sigma=0.03, side_sigma=0.3)
    drawn = FaceFilter(rules)._near(square(100, 80, 50)[None], 4000, np.random.default_rng(5))
    np.testing.assert_allclose(drawn[:, :2].mean(axis=0), [100, 80], atol=0.2)
    np.testing.assert_allclose(drawn[:, :2].std(axis=0), 1.5, rtol=0.05)
    assert np.log(drawn[:, 2] / 50).std() == pytest.approx(0.3, rel=0.05)


def test_the_prior_is_the_walk_of_all_before_and_the_jumps():
    """Two ancestors of different weight and size; place and side have deviations of their own."""
    rules = replace(RULES, move=0.05, grow=0.2, anywhere=0.1)
    before = ParticleSet(np.array([[100.0, 80, 40], [110.0, 90, 80]]), np.log([0.3, 0.7]))
    states = np.random.default_rng(6).uniform([80, 60, 30], [130, 110, 100], (50, 3))
    found = FaceFilter(rules)._prior(states, before, np.array([320.0, 240.0]))
    walk = sum(
        weight
        * stats.norm.pdf(states[:, :2], at[:2], 0.05 * at[2]).prod(axis=1)
        * stats.norm.pdf(np.log(states[:, 2]), np.log(at[2]), 0.2)
        for weight, at in zip(before.weights, before.states, strict=True)
    )
    jump = 1 / (320 * 240 * np.log(rules.sides[1] / rules.sides[0]))
    np.testing.assert_allclose(found, 0.9 * walk + 0.1 * jump, rtol=1e-9)


def test_the_likelihood_of_the_outline_is_that_of_its_squared_distance():
    rules, image = replace(RULES, colour_sigma=1e6, shape_sigma=7.0), picture()
    states = np.array([[160.0, 120, 60], [150.0, 118, 70], [60.0, 60, 40]])
    logs = FaceFilter(rules).log_likelihood(image, states, started(rules).reference)
    framed = np.insert(states, 2, 0.0, axis=1)
    away = contour_distances(edge_distances(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)), framed,
                             ELLIPSE)  # fmt: skip
    np.testing.assert_allclose(logs, -(away**2) / (2 * 7.0**2), atol=1e-9)


def test_where_all_states_are_alike_the_evidence_is_their_likelihood():
    wall, rules = np.full((240, 320, 3), 120, np.uint8), replace(RULES, anywhere=0.0)
    filter = FaceFilter(rules)
    state = filter.start(wall, square(160, 120, 60), rng=np.random.default_rng(7))
    _, info = filter.step(state, wall, NONE, rng=np.random.default_rng(8))
    logs = filter.log_likelihood(wall, state.particles.states, state.reference)
    assert np.ptp(logs) < 1e-9
    assert info.log_evidence == pytest.approx(logs[0], abs=1e-9)
    assert info.effective == pytest.approx(400)

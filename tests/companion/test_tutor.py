"""The tracker of a person: on a painted one, by laws, and what learns when."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from robot_perception.beliefs import ParticleSet
from robot_perception.companion.cues import bhattacharyya, contour_distances, edge_distances
from robot_perception.companion.tutor import (
    PATCHES,
    SILHOUETTE,
    WHOLE,
    TutorModel,
    TutorRules,
    TutorState,
    TutorTracker,
)
from tests.unchecked import unchecked

COLOURS = ((190, 150, 120), (200, 40, 40), (40, 60, 200), (60, 160, 60))
BOX = np.array([80.0, 60.0, 50.0, 100.0])
MIDDLE = np.array([105.0, 110.0, 0.0, 100.0])


def picture(at=MIDDLE, hidden=None, seed=0, colours=COLOURS):
    """Return noise on which the four patches of a person are painted in colours of their own."""
    rng = np.random.default_rng(seed)
    image = rng.integers(90, 130, (240, 320, 3)).astype(np.uint8)
    x, y, _, s = at
    for (left, top, wide, high), colour in zip(PATCHES, colours, strict=True):
        u, v = round(x + s * left), round(y + s * top)
        image[max(v, 0) : v + round(s * high), max(u, 0) : u + round(s * wide)] = colour
    if hidden is not None:
        u, v, w, h = hidden
        image[v : v + h, u : u + w] = (20, 220, 220)
    return image


def rng():
    return np.random.default_rng(1)


TRACKER = TutorTracker(TutorModel(contour=None), TutorRules(particles=400))


def run(pictures, tracker=TRACKER, seed=1):
    source = np.random.default_rng(seed)
    state = tracker.start(pictures[0], BOX, rng=source)
    found = []
    for image in pictures[1:]:
        state, info = tracker.step(state, image, rng=source)
        found.append((state, info))
    return found


def test_patches_and_outline_are_their_own_mirror_images():
    for boxes in (PATCHES, WHOLE):
        left, top, wide, high = boxes.T
        mirrored = np.stack([-left - wide, top, wide, high], axis=1)
        assert {*map(tuple, mirrored.round(9))} == {*map(tuple, boxes.round(9))}
    np.testing.assert_array_equal(SILHOUETTE[:11] * [-1, 1], SILHOUETTE[11:])


def test_patches_lie_within_the_outline_of_head_and_shoulders():
    """The head's is a little wider than the head."""
    outline = SILHOUETTE[11:]
    for left, top, wide, high in PATCHES:
        beside = np.interp(top + high / 2, outline[:, 1], outline[:, 0])
        assert max(-left, left + wide) <= beside + 0.02
        assert top >= -0.5
        assert top + high <= 0.5


def test_a_person_who_walks_and_comes_nearer_is_followed():
    way = [MIDDLE + np.array([4.0 * k, 1.0 * k, 0, 2.0 * k]) for k in range(25)]
    found = run([picture(at, seed=k) for k, at in enumerate(way)])
    errors = np.array([state.estimate - at for (state, _), at in zip(found, way[1:], strict=True)])
    assert np.abs(errors[5:, :2]).max() < 12
    tall = np.array(way)[6:, 3]
    assert np.abs(errors[5:, 3] / tall).max() < 0.2  # colours alone lag behind a growing person


def test_the_likelihood_is_highest_where_the_person_is_and_is_eq_1():
    image = picture()
    state = TRACKER.start(image, BOX, rng=rng())
    shifts = np.array([[a, b, 0, 0] for a in range(-20, 21, 5) for b in range(-20, 21, 5)])
    logs = TRACKER.log_likelihood(image, MIDDLE + shifts, state.reference)
    assert (shifts[logs.argmax()] == 0).all()
    assert logs.max() == pytest.approx(0, abs=1e-9)
    sizes = MIDDLE + np.array([[0, 0, 0, d] for d in (-25.0, -12.0, 0.0, 12.0, 25.0)])
    assert TRACKER.log_likelihood(image, sizes, state.reference).argmax() == 2
    both = TutorTracker(TutorModel(), TRACKER.rules)
    shape = both.log_likelihood(image, sizes, state.reference) - TRACKER.log_likelihood(
        image, sizes, state.reference
    )
    edges = edge_distances(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
    expected = -(contour_distances(edges, sizes, SILHOUETTE) ** 2) / (2 * 3.0**2)
    np.testing.assert_allclose(shape, expected)


def test_a_users_cue_counts():
    image = picture()
    told = {"left half": lambda seen, states: np.where(states[:, 0] < 100, 0.0, -1e3)}
    tracker = TutorTracker(TutorModel(contour=None, cues=told), TRACKER.rules)
    state, _ = tracker.step(tracker.start(image, BOX, rng=rng()), image, rng=rng())
    assert state.estimate[0] < 100
    usual, _ = TRACKER.step(TRACKER.start(image, BOX, rng=rng()), image, rng=rng())
    assert usual.estimate[0] > 102
    wrong = TutorModel(contour=None, cues={"odd": lambda seen, states: np.zeros(3)})
    with pytest.raises(ValueError, match=r"cues.'odd'."):
        TutorTracker(wrong, TRACKER.rules).step(state, image, rng=rng())


def test_models_take_in_what_is_seen_at_their_rate():
    image = picture()
    dim = (image * 0.9).astype(np.uint8)
    rules = TutorRules(rate=0.2, gate=1.0, whole_gate=1.0)
    tracker = TutorTracker(TutorModel(contour=None), rules)
    before = tracker.start(image, BOX, rng=rng())
    after, info = tracker.step(before, dim, rng=rng())
    assert info.learnt.all()
    seen = (after.reference - 0.8 * before.reference) / 0.2
    np.testing.assert_allclose(seen.sum(axis=-1), 1)
    assert seen.min() > -1e-9
    distances = bhattacharyya(np.clip(seen, 0, 1), before.reference).mean(axis=-1)
    np.testing.assert_allclose(distances, info.distances, atol=1e-6)
    fixed = replace(tracker, rules=replace(rules, rate=0.0))
    same, info = fixed.step(before, dim, rng=rng())
    np.testing.assert_array_equal(same.reference, before.reference)
    assert not info.learnt.any()


def test_a_patch_beyond_the_gate_does_not_learn_and_the_others_do():
    image = picture()
    changed = picture(colours=(*COLOURS[:3], (250, 250, 20)))
    rules = TutorRules(rate=0.3, gate=0.3, whole_gate=0.9, particles=400)
    tracker = TutorTracker(TutorModel(contour=None), rules)
    before = tracker.start(image, BOX, rng=rng())
    after, info = tracker.step(before, changed, rng=rng())
    assert info.learnt.tolist() == [True, True, True, False]
    assert info.distances[3] > 0.9
    np.testing.assert_array_equal(after.reference[3], before.reference[3])


def test_a_person_who_is_hidden_is_said_to_be_and_nothing_is_learnt():
    clear, hidden = picture(), picture(hidden=(40, 20, 140, 200))
    found = run([clear, clear, hidden, hidden, hidden, clear, clear, clear])
    assert [info.hidden for _, info in found] == [False, True, True, True, False, False, False]
    assert [state.missed for state, _ in found] == [0, 1, 2, 3, 0, 0, 0]
    before, during = found[0][0].reference, found[3][0].reference
    np.testing.assert_array_equal(before, during)
    assert not found[2][1].learnt.any()
    assert np.abs(found[-1][0].estimate - MIDDLE)[:2].max() < 12


def test_while_it_sees_nothing_the_particles_spread():
    clear, hidden = picture(), picture(hidden=(0, 0, 320, 240))
    found = run([clear, clear, *[hidden] * 6])
    spreads = [np.sqrt(np.diag(state.particles.cov)[:2]).mean() for state, _ in found]
    assert spreads[-1] > 2 * spreads[0]


def test_the_silhouette_tells_more_of_the_size_than_the_colours_do():
    """A person of one colour before another one."""
    grey = np.full((240, 320, 3), 60, dtype=np.uint8)
    points = MIDDLE[:2] + 100 * SILHOUETTE
    hull = np.concatenate([points[:11][::-1], points[11:], [[137, 160], [73, 160]]])
    cv2.fillPoly(grey, [np.rint(hull).astype(np.int32)], (200, 90, 60))
    states = MIDDLE + np.array([[0, 0, 0, d] for d in (-30.0, 0.0)])
    plain, shaped = TutorTracker(TutorModel(contour=None)), TutorTracker()
    reference = plain.start(grey, BOX, rng=rng()).reference
    by_colour = plain.log_likelihood(grey, states, reference)
    by_both = shaped.log_likelihood(grey, states, reference)
    assert by_both[1] - by_both[0] > by_colour[1] - by_colour[0] + 1


def test_one_patch_is_a_model_too_and_the_box_is_where_it_looks():
    one = TutorTracker(TutorModel(WHOLE, None))
    state = one.start(picture(), BOX, rng=rng())
    assert state.reference.shape == (1, 3, 8)
    state, info = one.step(state, picture(), rng=rng())
    assert info.contour is None
    x, y, _, s = state.estimate
    np.testing.assert_allclose(state.box, [x - 0.25 * s, y - 0.5 * s, 0.5 * s, s])


def test_the_same_seed_gives_the_same_track():
    pictures = [picture(seed=k) for k in range(4)]
    one, other = run(pictures)[-1][0], run(pictures)[-1][0]
    np.testing.assert_array_equal(one.particles.states, other.particles.states)
    assert np.abs(run(pictures, seed=2)[-1][0].estimate - one.estimate).max() > 0


def test_motion_is_a_random_walk_of_the_stated_deviations_within_limits():
    rules = TutorRules(particles=20_000, move=0.1, turn=0.02, grow=0.05)
    tracker = TutorTracker(TutorModel(contour=None), rules)
    states = tracker.start(picture(), BOX, rng=rng()).particles.states
    np.testing.assert_allclose(states.mean(axis=0)[:3], MIDDLE[:3], atol=0.5)
    np.testing.assert_allclose(states[:, :2].std(axis=0), 10, rtol=0.03)
    assert states[:, 2].std() == pytest.approx(0.02, rel=0.03)
    assert np.log(states[:, 3] / 100).std() == pytest.approx(0.05, rel=0.03)
    wild = replace(tracker, rules=replace(rules, turn=9.0, particles=500))
    assert np.abs(wild.start(picture(), BOX, rng=rng()).particles.states[:, 2]).max() == math.pi / 4


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (lambda: TutorModel(np.zeros((0, 4))), ValueError, "patches must be one at least"),
        (lambda: TutorModel(contour=np.zeros((0, 2))), ValueError, "contour must not be empty"),
        (lambda: TutorModel(cues={"a": 3}), TypeError, "cues.'a'. must be"),
        (lambda: TutorRules(particles=1), ValueError, "particles must be"),
        (lambda: TutorRules(colour_sigma=0.0), ValueError, "colour_sigma must be"),
        (lambda: TutorRules(rate=1.5), ValueError, "rate must be"),
        (lambda: TRACKER.start(picture(), np.zeros(4), rng=rng()), ValueError, "box must have"),
        (
            lambda: TRACKER.start(picture(), np.array([900.0, 900, 50, 100]), rng=rng()),
            ValueError,
            "box must let every patch",
        ),
        (
            lambda: TRACKER.step(
                TutorState(ParticleSet.uniform(np.tile(MIDDLE, (5, 1))), np.zeros((1, 3, 8))),
                picture(),
                rng=rng(),
            ),
            ValueError,
            "state.reference must be",
        ),
        (
            lambda: TRACKER.start(picture().astype(float), BOX, rng=rng()),
            TypeError,
            "image must be",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong()


def test_colours_count_by_the_sum_of_the_squares_of_their_distances():
    image = picture()
    state = TRACKER.start(image, BOX, rng=rng())
    places = MIDDLE + np.array([[8.0, 0, 0, 0], [0, 15, 0, 0], [0, 0, 0.2, 10]])
    seen, _ = TRACKER._colours(image, places)
    squared = bhattacharyya(seen, state.reference) ** 2
    expected = [-one.sum() / (2 * TRACKER.rules.colour_sigma**2) for one in squared]
    np.testing.assert_allclose(TRACKER.log_likelihood(image, places, state.reference), expected)


def test_a_patch_that_is_there_twice_counts_twice():
    """Eq. (1): the likelihood is a product over the measures."""
    image, places = picture(), MIDDLE + np.array([[8.0, 0, 0, 0], [0, 15, 0, 0]])
    logs = []
    for patches in (PATCHES[:1], PATCHES[1:2], PATCHES[[0, 1]], PATCHES[[0, 0]]):
        tracker = TutorTracker(TutorModel(patches, None))
        reference = tracker.start(image, BOX, rng=rng()).reference
        logs.append(tracker.log_likelihood(image, places, reference))
    np.testing.assert_allclose(logs[2], logs[0] + logs[1])
    np.testing.assert_allclose(logs[3], 2 * logs[0])


@pytest.mark.parametrize("tall", [40.0, 100.0, 200.0])
def test_the_motion_is_in_proportion_to_the_person(tall):
    """A person twice as near moves twice as far in the picture."""
    rules = TutorRules(particles=20_000, move=0.1)
    tracker = TutorTracker(TutorModel(contour=None), rules)
    box = np.array([160 - tall / 4, 120 - tall / 2, tall / 2, tall])
    states = tracker.start(picture(), box, rng=rng()).particles.states
    np.testing.assert_allclose(states[:, :2].std(axis=0), 0.1 * tall, rtol=0.03)
    assert np.log(states[:, 3] / tall).std() == pytest.approx(rules.grow, rel=0.03)


def test_while_the_person_is_hidden_no_patch_learns_however_well_it_fits():
    tracker = TutorTracker(TutorModel(contour=None), replace(TRACKER.rules, whole_gate=0.2))
    half = picture(hidden=(40, 105, 140, 100))  # head and upper chest are seen as before
    (_, _), (_, info) = run([picture(), picture(), half], tracker)
    assert info.hidden
    assert info.distances.min() < tracker.rules.gate
    assert not info.learnt.any()


def test_distances_are_those_of_the_patches_at_the_estimate():
    away = MIDDLE + np.array([14, 6, 0, 0])
    (state, info), *_ = run([picture(), picture(away)], replace(
        TRACKER, rules=replace(TRACKER.rules, rate=0.0)))  # fmt: skip
    seen, _ = TRACKER._colours(picture(away), state.estimate[None])
    wanted = bhattacharyya(seen[0], state.reference).mean(axis=-1)
    np.testing.assert_allclose(info.distances, wanted, rtol=1e-12)

"""Colour and shape tracked together, and each alone, on drawn objects."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from robot_perception.appearance import single_cues
from robot_perception.appearance.colour_distribution import Dynamics, describe
from robot_perception.appearance.colour_shape import (
    ColourShapeRules,
    ColourShapeTracker,
    colours_inside,
)
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.segmentation import filled
from robot_perception.appearance.single_cues import ColourTracker, EdgeTracker, WindowTracker
from tests.appearance.shapes import MIDDLE, SHAPE, overlap, pear
from tests.unchecked import unchecked

RULES = ColourShapeRules(samples=20, binning=Binning("RGB", (16, 16, 16)), opening=3)
STEP = np.diag([0.012, 0.012, 0.012, 0.002, 0.002, 0.002, 0.02, 0.02])
DYNAMICS = Dynamics(np.diag([1.0] * 6 + [0.0] * 2), np.zeros(8), STEP)
GREEN = np.array([60, 150, 70])


def scene(outline, colour=(190, 60, 50), seed=0):
    """Return the picture of an outline of a colour on green ground, with noise."""
    picture = np.where(filled(outline, SHAPE)[..., None], colour, GREEN)
    noisy = picture + np.random.default_rng(seed).normal(scale=4.0, size=picture.shape)
    return noisy.clip(0, 255).astype(np.uint8)


def rng():
    return np.random.default_rng(1)


def there(k):
    return pear() + MIDDLE + [2.0 * k, k]


def tracked(rules, pictures, source=None):
    """Return states and infos of the tracker on pictures, the outline of the first given."""
    source = rng() if source is None else source
    tracker = ColourShapeTracker(DYNAMICS, rules)
    states, infos = [tracker.start(pictures[0], there(0), rng=source)], []
    for picture in pictures[1:]:
        state, info = tracker.step(states[-1], picture, rng=source)
        states.append(state)
        infos.append(info)
    return states, infos


FADING = [scene(there(k), (190 - 4 * k, 60 + 3 * k, 50 + 5 * k), k) for k in range(13)]


def test_an_object_that_moves_and_changes_colour_is_followed():
    states, infos = tracked(RULES, FADING)
    assert min(overlap(state.outline, there(k)) for k, state in enumerate(states)) > 0.9
    assert not any(info.lost for info in infos)
    seen = describe(RULES.binning.space.coordinates(FADING[-1][filled(there(12), SHAPE)]))
    np.testing.assert_allclose(states[-1].distribution.mean, seen.mean, atol=0.01)


def test_a_step_is_told_in_full():
    (before, after), (info,) = tracked(RULES, FADING[:2])
    found = np.isfinite(info.rho)
    np.testing.assert_allclose(info.weights.sum(), 1)
    mu = np.array(RULES.importance)
    np.testing.assert_allclose(info.rho[found], ((1 - info.scores) @ mu)[found])
    expected = np.where(found, np.exp(-(info.rho**2) / (2 * RULES.sigma**2)), 0.0)
    np.testing.assert_allclose(info.weights, expected / expected.sum())
    assert info.best == info.rho.argmin()
    assert info.blobs[info.best].any()
    assert info.edges.any()
    np.testing.assert_array_equal(info.states[0].shape, (8,))
    # the description of what was seen takes the place of the best sample
    own = after.particles.states[info.best]
    np.testing.assert_array_equal(own, after.distribution.state)
    assert after.areas[1] == before.areas[0]


def test_samples_are_segmented_by_their_own_colours():
    (before, _), (info,) = tracked(RULES, FADING[:2])
    tracker = ColourShapeTracker(DYNAMICS, RULES)
    for state, cloud in zip(info.states, tracker.warped(before, info.states), strict=True):
        np.testing.assert_allclose(cloud.mean(axis=0), state[:3])
    binning = RULES.binning
    cloud = tracker.warped(before, info.states)[info.best]
    seen = np.isin(binning.index(FADING[1]), binning.of(cloud.clip(0, 1)))
    blob = info.blobs[info.best]
    # the piece is what has these colours, but for what opening and closing change
    eroded = cv2.erode(blob.view(np.uint8), np.ones((9, 9))).astype(bool)
    assert seen[eroded].mean() > 0.5
    assert not seen[~cv2.dilate(blob.view(np.uint8), np.ones((15, 15))).astype(bool)].mean() > 0.02


def test_colours_that_do_not_move_are_those_of_the_first_frame():
    """The angles of a sample are turns since the frame before: at first there is none."""
    still = Dynamics(np.eye(8), np.zeros(8), np.zeros((8, 8)))
    picture = scene(there(0)).astype(float)
    picture[..., 0] += np.linspace(-60, 60, SHAPE[1])  # a long cloud, off the axes of the space
    picture[..., 1] += np.linspace(-20, 20, SHAPE[1])
    picture = picture.clip(0, 255).astype(np.uint8)
    tracker, source = ColourShapeTracker(still, RULES), rng()
    before = tracker.start(picture, there(0), rng=source)
    clouds = tracker.warped(before, before.particles.states)
    np.testing.assert_allclose(clouds, np.broadcast_to(before.colours, clouds.shape), atol=1e-12)
    after, info = tracker.step(before, picture, rng=source)
    assert not info.lost
    assert overlap(after.outline, there(0)) > 0.9


def test_the_same_seed_gives_the_same_outlines():
    first, second = (tracked(RULES, FADING[:4])[0][-1] for _ in range(2))
    np.testing.assert_array_equal(first.outline, second.outline)
    np.testing.assert_array_equal(first.particles.states, second.particles.states)


def test_another_object_of_the_colour_but_not_of_the_shape_weighs_less():
    wide = [scene(there(0)), scene(there(0))]
    cv2.rectangle(wide[1], (120, 60), (300, 135), (190, 60, 50), -1)  # touches the object
    _, (clear,) = tracked(RULES, [wide[0], wide[0]])
    _, (merged,) = tracked(RULES, wide)
    assert merged.rho.min() > clear.rho.min() + 0.05


def test_the_printed_sign_is_right_side_down():
    _, (good,) = tracked(RULES, FADING[:2])
    _, (printed,) = tracked(replace(RULES, printed_area=True), FADING[:2])
    found = np.isfinite(good.rho)
    np.testing.assert_allclose(good.scores[found, 1] + printed.scores[found, 1], 1)


def test_without_shape_all_samples_that_see_a_piece_weigh_the_same():
    _, (info,) = tracked(replace(RULES, shape=False), FADING[:2])
    found = np.isfinite(info.rho)
    np.testing.assert_allclose(info.weights[found], 1 / found.sum())
    assert info.best == found.argmax()  # the first of them leads on


def test_colours_that_are_not_taken_anew_stay():
    states, _ = tracked(replace(RULES, refresh=False), FADING[:3])
    assert states[-1].colours is states[0].colours


def test_an_object_that_vanishes_is_lost_and_found_again():
    gone = np.broadcast_to(GREEN, (*SHAPE, 3)).astype(np.uint8)
    pictures = [scene(there(0), seed=0), gone, gone, scene(there(4), seed=1), scene(there(4))]
    states, infos = tracked(RULES, pictures)
    assert [info.lost for info in infos] == [True, True, False, False]
    assert [state.lost for state in states] == [0, 1, 2, 0, 0]
    np.testing.assert_array_equal(states[2].outline, states[0].outline)
    assert np.isinf(infos[0].rho).all()
    assert not infos[0].weights.any()
    assert overlap(states[-1].outline, there(4)) > 0.9


def test_an_object_that_comes_back_elsewhere_is_found():
    gone = np.broadcast_to(GREEN, (*SHAPE, 3)).astype(np.uint8)
    far = pear() + np.array([60, 180])
    states, _ = tracked(RULES, [scene(there(0)), gone, scene(far), scene(far)])
    assert overlap(states[-1].outline, far) > 0.9


@pytest.mark.parametrize("value", [0, 255])
def test_one_colour_everywhere_is_a_loss_and_no_accident(value):
    blank = np.full((*SHAPE, 3), value, dtype=np.uint8)
    states, infos = tracked(RULES, [FADING[0], blank, FADING[0]])
    assert infos[0].lost
    assert np.isfinite(states[-1].outline).all()


@pytest.mark.parametrize("wide", [1, 5])
def test_a_speck_of_the_colour_is_not_the_object(wide):
    speck = np.broadcast_to(GREEN, (*SHAPE, 3)).astype(np.uint8).copy()
    speck[120 : 120 + wide, 160 : 160 + wide] = (190, 60, 50)
    rules = replace(RULES, opening=1, closing=1, worst=10.0)  # whatever its shape
    _, (info,) = tracked(rules, [FADING[0], speck])
    assert info.lost


def test_an_outline_of_a_pixel_has_one_colour():
    dot = np.array([[160.0, 120.0], [160.4, 120.0], [160.0, 120.4]])
    found = colours_inside(FADING[0], dot, RULES, rng=rng())
    assert 1 <= len(found) <= 4


def test_no_more_colours_than_asked_for_and_none_from_the_rim():
    rules = replace(RULES, colours=50, inset=3)
    found = colours_inside(scene(there(0)), there(0), rules, rng=rng())
    assert len(found) == 50
    assert (found[:, 0] > 0.6).all()  # no green


def test_stages_are_told_in_turn():
    told = []
    tracker = ColourShapeTracker(DYNAMICS, replace(RULES, samples=2))
    state = tracker.start(FADING[0], there(0), rng=rng())
    tracker.step(state, FADING[1], rng=rng(), watch=told.append)
    assert told[:3] == ["bins of the pixels", "draw and propagate", "warp"]
    assert told.count("histogram") == 2
    assert told[-1] == "outline on the image's edges"


def test_an_image_of_another_size_is_refused():
    tracker = ColourShapeTracker(DYNAMICS, RULES)
    state = tracker.start(FADING[0], there(0), rng=rng())
    with pytest.raises(ValueError, match="image"):
        tracker.step(state, FADING[0][:100], rng=rng())
    for wrong in (FADING[0][..., 0], FADING[0].astype(float)):
        with unchecked(), pytest.raises((TypeError, ValueError), match="image"):
            tracker.step(state, wrong, rng=rng())


def test_an_outline_beyond_the_image_is_refused():
    tracker = ColourShapeTracker(DYNAMICS, RULES)
    with pytest.raises(ValueError, match="outline"):
        tracker.start(FADING[0], pear() + 1000.0, rng=rng())


def single(tracker, pictures):
    state = tracker.start(pictures[0], there(0))
    for picture in pictures[1:]:
        state, info = tracker.step(state, picture)
        assert info.found == (state.lost == 0)
    return state


def test_fixed_colours_lose_what_fades_and_adapted_ones_follow():
    fixed, adapted = (single(ColourTracker(RULES, adapt), FADING) for adapt in (False, True))
    assert overlap(adapted.outline, there(12)) > 0.8
    assert overlap(fixed.outline, there(12)) < 0.6
    assert fixed.lost > 0


def test_colour_alone_takes_in_what_touches_the_object_and_fused_does_not():
    pictures = [scene(there(0), seed=k) for k in range(2)]
    cv2.rectangle(pictures[1], (20, 100), (130, 220), (190, 60, 50), -1)
    state = single(ColourTracker(RULES, adapt=True), pictures)
    assert overlap(state.outline, there(0)) < 0.4
    assert overlap(tracked(RULES, pictures)[0][-1].outline, there(0)) > 0.8


def test_edges_alone_follow_an_object_on_plain_ground():
    assert overlap(single(EdgeTracker(RULES), FADING).outline, there(12)) > 0.95


def test_edges_alone_reach_only_so_far():
    far = replace(RULES, snake=replace(RULES.snake, reach=(201.0, 3.0)))
    with unchecked(), pytest.raises(ValueError, match="reach must be at most 200 px, got 201"):
        EdgeTracker(far)


def test_edges_alone_wait_where_there_are_none():
    blank = np.full((*SHAPE, 3), 90, dtype=np.uint8)
    state = single(EdgeTracker(RULES), [FADING[0], blank])
    assert state.lost == 1
    assert overlap(state.outline, there(0)) > 0.99


def test_a_rigid_window_follows_what_fades_only_if_it_adapts_by_contrast():
    moved = {}
    for rate, contrast in ((0.2, True), (0.0, True), (0.2, False)):
        tracker = WindowTracker(RULES.binning, rigid=True, rate=rate, contrast=contrast)
        moved[rate, contrast] = single(tracker, FADING).outline
    good = moved.pop((0.2, True))
    np.testing.assert_allclose(good - good[0], there(0) - there(0)[0])  # it keeps its form
    for other in moved.values():
        assert overlap(other, there(12)) < 0.5 < 0.75 < overlap(good, there(12))


def test_camshift_is_opencvs():
    tracker = WindowTracker(Binning("HSI", (30, 16, 1)))
    states = [tracker.start(FADING[0], there(0))]
    likely = (255 * states[0].counts / states[0].counts.max())[tracker.binning.index(FADING[1])]
    box, window = cv2.CamShift(likely.astype(np.uint8), states[0].window, single_cues.STOP)
    found, _ = tracker.step(states[0], FADING[1])
    assert found.window == tuple(window)
    (u, v), _, _ = cv2.minAreaRect(found.outline.astype(np.float32))
    np.testing.assert_allclose((u, v), box[0], atol=0.5)
    corners, spread = cv2.boxPoints(box), found.outline - found.outline.mean(axis=0)
    for side in (corners[1] - corners[0], corners[2] - corners[1]):
        along = spread @ (side / np.linalg.norm(side))
        np.testing.assert_allclose(np.ptp(along), np.linalg.norm(side), rtol=0.02)


@pytest.mark.parametrize("angle", [25, 115])
def test_the_ellipse_of_a_window_leans_as_the_object_does(angle):
    leaning = cv2.ellipse2Poly((60, 45), (26, 9), angle, 0, 360, 4).astype(float)
    pictures = [scene(leaning, seed=k) for k in range(3)]
    state = WindowTracker(Binning("HSI", (30, 16, 1))).start(pictures[0], leaning)
    for picture in pictures[1:]:
        state, _ = WindowTracker(Binning("HSI", (30, 16, 1))).step(state, picture)
    assert overlap(state.outline, leaning) > 0.7
    assert overlap(state.outline * [1, -1] + [0, 90], leaning) < 0.5, "the mirrored one does not"


def test_a_window_that_finds_nothing_stays():
    blank = np.full((*SHAPE, 3), 90, dtype=np.uint8)
    for rigid in (False, True):
        state = single(WindowTracker(RULES.binning, rigid=rigid), [FADING[0], blank])
        assert state.lost == 1
        np.testing.assert_array_equal(state.outline, there(0))


def test_a_state_without_a_window_is_refused():
    tracker = WindowTracker(RULES.binning)
    with pytest.raises(ValueError, match="state must have a window"):
        tracker.step(ColourTracker(RULES).start(FADING[0], there(0)), FADING[1])


@pytest.mark.parametrize(
    "tracker", [ColourTracker(RULES), EdgeTracker(RULES), WindowTracker(RULES.binning)]
)
def test_a_single_cue_refuses_an_outline_beyond_the_image(tracker):
    with pytest.raises(ValueError, match="must hold pixels of the image"):
        tracker.start(scene(there(0)), there(0) + 1000.0)


def test_a_histogram_of_other_bins_is_refused():
    image = scene(there(0))
    state = ColourTracker(replace(RULES, binning=Binning("RGB", (4, 4, 4)))).start(image, there(0))
    for tracker in (ColourTracker(RULES), WindowTracker(RULES.binning)):
        with pytest.raises(ValueError, match="counts, got 64"):
            tracker.step(state, image)

"""The studies: worlds, rivals, and what they count, by law."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.book import pattern_tracking as page
from robot_perception.ceiling.patterns import PatternRules
from robot_perception.chapters.pattern_tracking.scene import RULES, SIGMAS, START, errors
from studies.rows import Rows, framed

RNG = np.random.default_rng
SHAPE = (240, 320)


def test_errors_are_in_sigmas_and_angles_go_round():
    off = errors(np.array([5.0, 0.0, 2 * np.pi, 1.2]), np.array([0.0, 10.0, 0.0, 1.0]))
    np.testing.assert_allclose(off, [1, -2, 0, 2], atol=1e-9)


def test_paths_begin_at_the_start_and_step_by_half_a_sigma():
    steps = [np.diff(page.path(400, RNG(k)), axis=0) / SIGMAS for k in range(20)]
    assert all((page.path(10, RNG(k))[0] == START).all() for k in range(3))
    rms = np.sqrt(np.mean(np.square(steps), axis=(0, 1)))
    np.testing.assert_allclose(rms, [0.5, 0.5, 0.5, 0.25], rtol=0.05)
    assert np.abs(steps).max() < 0.8


# Several places


def test_peaks_rise_above_half_the_height():
    surface = np.zeros((40, 40))
    for v, u, height in ((5, 5, 1.0), (20, 30, 0.6), (20, 31, 0.55), (30, 8, 0.4)):
        surface[v, u] = height
    assert page.peaks(surface) == 2


def test_a_plain_ground_has_nothing_but_the_patch():
    assert np.ptp(page.scene(100, plain=True)[1]) == 0
    assert np.ptp(page.scene(100)[1]) > 100
    assert page.swept.trial(sign=103)["contours"] >= 1


def test_the_likelihoods_are_highest_at_the_true_place():
    for surface in page.surfaces(105, RNG(0)):
        v, u = np.unravel_index(surface.argmax(), surface.shape)
        assert np.abs(np.array([u, v]) - 30).max() <= 2


def test_directions_leave_fewer_places():
    trials = [page.swept.but(directed=d) for d in (True, False)]
    few, many = (
        np.mean([one.trial(sign=k)["contours"] for k in (100, 101, 102)]) for one in trials
    )
    assert few < many / 2


def test_only_patterns_with_one_place_on_an_empty_ground_count():
    found = page.crowded.trial(sign=103)
    assert not any(found[f"{by} more"] > found[f"{by} one"] for by in ("contours", "vectors"))
    trials = [{"sign": k, "contours one": k < 4, "contours more": k < 1} for k in range(6)]
    assert page.made_ambiguous(Rows(framed(trials), "sign", {})).estimate == 0.25


# Slopes and light


def test_kinds_of_slopes_differ_in_their_slopes_alone():
    kinds = page.fitted(100, True, 2, RNG(0))
    own, one = kinds["each its own"], kinds["one for all"]
    np.testing.assert_array_equal(own.places, one.places)
    np.testing.assert_allclose(one.decay.rate, own.decay.rate.mean())
    vectors = own.vectors - own.vectors.mean(axis=1, keepdims=True)
    fall = [(vectors[:, k:] * vectors[:, : 11 - k]).sum(axis=1) for k in range(3)]
    lost = 1 - np.array(fall[1:]) / fall[0]
    np.testing.assert_allclose(own.decay.rate, np.maximum([1, 2] @ lost / 5, 1e-3))


def test_a_grille_spreads_the_slopes():
    spreads = [
        np.mean([page.searched.but(grille=grille, moves=1).trial(sign=k, sigma=2.0)["spread"]
                 for k in range(100, 104)])
        for grille in (True, False)
    ]  # fmt: skip
    assert spreads[0] > spreads[1]


def test_what_is_not_normalised_wants_the_same_light():
    pattern = page.learnt(100, PatternRules(centred=False))
    places = np.array([START, START + 4 * SIGMAS])
    for gain, best in ((1.0, True), (0.4, False)):
        image = np.rint(gain * page.picture(100, START)).astype(np.uint8)
        logs = page.plain_weigh(pattern, image, RULES.deviation)(places)
        assert (abs(logs[0]) < 1e-9) == best
    assert logs[0] < -1


# Displacements


@pytest.mark.parametrize("name", page.METHODS)
def test_everybody_finds_a_patch_that_has_hardly_moved(name):
    truth = START + SIGMAS * [0.3, -0.2, 0.1, 0.1]
    pictures = [page.seen(page.picture(100, truth), RNG(k)) for k in range(2, 7)]
    first = page.seen(page.picture(100, START), RNG(1))
    task = SimpleNamespace(pattern=page.learnt(100), first=first, pictures=pictures)
    assert np.abs(errors(page.METHODS[name](task, RNG(0)), truth)).mean() < 0.6


def test_windows_are_turned_and_scaled_as_the_patch_is():
    """In steps of 0.7 σ: this one is on the raster."""
    truth = START + SIGMAS * [0, 0, 2.1, 1.4]
    first, then = (page.picture(102, place) for place in (START, truth))
    task = SimpleNamespace(pattern=page.learnt(102), first=first, pictures=[then])
    off = errors(page.METHODS["template matching"](task, RNG(0)), truth)
    np.testing.assert_allclose(off, 0, atol=0.11)  # half a pixel


def test_windows_are_found_where_the_patch_has_moved():
    truth = START + SIGMAS * [2.0, -1.0, 0, 0]
    first, then = (page.picture(102, place) for place in (START, truth))
    task = SimpleNamespace(pattern=page.learnt(102), first=first, pictures=[then])
    off = errors(page.METHODS["template matching"](task, RNG(0)), truth)
    np.testing.assert_allclose(off, 0, atol=0.11)


def test_a_patch_moves_along_one_coordinate_at_a_time(monkeypatch):
    """A tracker that stays where it was errs by the whole move, in σ."""
    monkeypatch.setitem(page.METHODS, "one picture", lambda task, rng: START)
    found = page.displaced.but(sigmas=(3.0,)).trial(sign=100, method="one picture")
    assert np.array(found["off"]) == pytest.approx(3, abs=0.101)
    assert np.array(found["error"]) * found["side"] == pytest.approx(-3, abs=0.101)
    assert list(found["coordinate"][::2]) == ["x", "y", "θ", "s"]


def test_the_worst_coordinate_is_told():
    offs = {"x": 0.1, "y": 0.2, "θ": 1.5, "s": 0.3}
    trials = [
        {"sign": k, "method": "one picture", "coordinate": list(offs), "moved": 2.0,
         "off": [value + 0.01 * k for value in offs.values()]}
        for k in range(5)
    ]  # fmt: skip
    rows = Rows(framed(trials), "sign", {})
    assert page.worst(rows, 2.0).estimate == pytest.approx(1.52)
    assert page.typical(rows, 2.0, "x").estimate == pytest.approx(0.12)


# Covers


def test_a_cover_hides_its_share_of_the_window_from_its_side():
    image, other = np.zeros(SHAPE, np.uint8), np.full(SHAPE, 255, np.uint8)
    for side, (u, v) in enumerate(((186, 120), (160, 146), (134, 120), (160, 94))):
        for share in (0.3, 0.6):
            covered = page.covered_by(image, other, START, share, side)
            window = covered[88:152, 128:192]
            assert (window > 0).mean() == pytest.approx(share, abs=0.03)
            assert covered[v, u] == 255
    np.testing.assert_array_equal(page.covered_by(image, other, START, 0.0, 0), image)


def test_a_turned_pattern_is_covered_along_its_own_side():
    image, other = np.zeros(SHAPE, np.uint8), np.full(SHAPE, 255, np.uint8)
    turned = START + np.array([0, 0, np.pi / 2, 0])
    covered = page.covered_by(image, other, turned, 0.5, 0)
    np.testing.assert_array_equal(covered[150, 150:170], 255)  # its right is below now
    np.testing.assert_array_equal(covered[95, 150:170], 0)


def test_what_tolerates_nothing_is_the_tracker_without_tolerance():
    some = page.covered.but(rules=("none", "left out"), tolerated=0.0, moves=1)
    one, other = some.trial(sign=100, share=0.3)["error"]
    assert one == other
    assert some.trial(sign=100, share=0.0)["hidden"] == 0


# Both products


def test_where_the_products_are_one_their_errors_are_too():
    found = page.counted.but(few=120, moves=1).trial(sign=300)
    assert found["printed"] == found["right"] < 0.5
    assert (found["factors"], found["vectors"]) == (200, 120)


# Recognition


def test_a_place_is_carried_by_what_the_world_tells():
    below = page.camera("varied", 300)
    here, there = np.array([0.5, -0.3, 0.2]), np.array([0.7, -0.1, 2.0])
    corner = np.array([[0.9, 0.1]])
    seen, expected = below.points_seen(here, corner)[0], below.points_seen(there, corner)[0]
    np.testing.assert_allclose(page.carried(below, here, there, seen), expected, atol=1e-6)


def test_a_pattern_is_found_where_it_was_chosen():
    below, rng = page.camera("varied", 301), RNG(0)
    image = below.image(np.array([0.3, 0.4, 0.0]))
    chosen = page.chosen(image)
    assert chosen
    for pattern, place in chosen:
        contours, vectors, match = page.looked_for(pattern, image, place, rng)
        assert contours
        assert vectors
        assert match > 0.9


def test_nothing_is_found_in_a_blank_picture():
    below, rng = page.camera("varied", 301), RNG(0)
    pattern, place = page.chosen(below.image(np.array([0.3, 0.4, 0.0])))[0]
    blank = np.full(SHAPE, 128, np.uint8)
    assert page.looked_for(pattern, blank, place, rng) == (False, False, -1.0)


def test_vectors_choose_the_place_that_is_most_alike(monkeypatch):
    """The best place by contours is wrong, and the next one right."""
    pattern, image = page.learnt(100), page.picture(100, START)
    wrong = SimpleNamespace(pose=np.add(START, [60.0, 0, 0, 0]))
    monkeypatch.setattr(page, "recognise", lambda *_: (wrong, SimpleNamespace(pose=START)))
    contours, vectors, match = page.looked_for(pattern, image, START[:2], RNG(0))
    assert (contours, vectors) == (False, True)
    assert match > 0.9
    assert page.looked_for(pattern, image, START[:2], RNG(0), among=2)[0]


@pytest.mark.parametrize(
    ("place", "held"), [((45, 45), True), ((44, 100), False), ((274, 194), True), ((275, 9), False)]
)
def test_a_whole_window_is_inside_however_it_is_turned(place, held):
    assert page.inside(np.array(place, dtype=float), SHAPE) == held


def test_a_model_that_is_smoothed_is_smoother():
    sharp, smooth = (page.modelled(100, blur) for blur in (False, True))
    steps = [np.abs(np.diff(one.vectors, axis=1)).mean() for one in (sharp, smooth)]
    assert steps[1] < steps[0]
    assert replace(RULES, smoothing="scale").smoothing == page.SMOOTHINGS["σ = s"][0]

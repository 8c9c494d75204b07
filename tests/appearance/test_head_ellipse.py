"""The ellipse of a head: exact scores on every path, search, size, adaptation, loss, recovery."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.appearance.colour_histograms import (
    histogram,
    intersection,
    intersection_of_shares,
    shares,
    two_views,
)
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import (
    Ellipse,
    HeadRules,
    HeadState,
    HeadTracker,
    candidate_scores,
)
from tests.unchecked import unchecked

SIZE = (160, 120)
SKIN, HAIR, WALL = (210, 150, 120), (60, 40, 30), (90, 120, 150)
RULES = HeadRules(measure="shares", rate=0.1, gate=0.7, floor=0.4, gives_up=0.4)
TRACKER = HeadTracker(Binning("opponent", (16, 16, 4)), RULES)


def scene(u, v, half_width=12, *, light=1.0, turned=False, size=SIZE):
    """Return a picture of a head: its upper third is hair, all of it from behind."""
    columns, rows = np.arange(size[0]), np.arange(size[1])[:, None]
    image = np.full((size[1], size[0], 3), WALL, dtype=float)
    inside = ((columns - u) / half_width) ** 2 + ((rows - v) / (1.2 * half_width)) ** 2 <= 1
    image[inside] = HAIR
    if not turned:
        image[inside & (rows > v - 0.4 * half_width)] = SKIN
    image[inside] *= (0.75 + 0.25 * np.sin((columns - u) / half_width + (rows - v) / 9))[
        inside, None
    ]
    noise = np.random.default_rng(0).normal(0, 2, image.shape)
    return np.clip(light * image + noise, 0, 255).astype(np.uint8)


def start(tracker=TRACKER, **more):
    ellipse = Ellipse(60, 60, 12)
    return HeadState(ellipse, tracker.colours(scene(60, 60), ellipse), **more)


@given(st.integers(1, 60))
def test_an_ellipse_has_its_pixels(half_width):
    mask = Ellipse(70, 80, half_width).mask((141, 161))
    dv, du = np.nonzero(mask)
    inside = ((du - 70) / half_width) ** 2 + ((dv - 80) / (1.2 * half_width)) ** 2
    assert inside.max() <= 1 + 1e-12
    assert abs(mask.sum() - np.pi * 1.2 * half_width**2) <= 2 * half_width
    if 1.2 * half_width < 80:
        assert Ellipse(0, 0, half_width).pixels == mask.sum()
    assert np.isclose(Ellipse(0, 0, half_width).half_height, 1.2 * half_width)


CASES = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 2**32 - 1),
        "width": st.integers(1, 40),
        "height": st.integers(1, 40),
        "bins": st.integers(1, 9),
        "half_widths": st.lists(st.integers(1, 14), min_size=1, max_size=3),
        "radius": st.integers(0, 6),
        "measure": st.sampled_from(["printed", "shares"]),
    }
)


def drawn(case):
    """Return an image of bins, a model and where to search, of a case."""
    rng = np.random.default_rng(case["seed"])
    index = rng.integers(0, case["bins"], (case["height"], case["width"]), dtype=np.int32)
    model = rng.uniform(0, 1, case["bins"]) + 1e-3
    model *= (1 if case["measure"] == "shares" else 300) / model.sum()
    centre = (int(rng.integers(case["width"])), int(rng.integers(case["height"])))
    how = {name: case[name] for name in ("half_widths", "radius", "measure")}
    return index, centre, model, how


@given(CASES)
@settings(max_examples=150)
def test_incremental_scores_equal_the_full_count_exactly(case):
    index, centre, model, how = drawn(case)
    found = candidate_scores(index, centre, model, **how)
    full = candidate_scores(index, centre, model, **how, incremental=False)
    np.testing.assert_array_equal(found, full)


@given(CASES)
@settings(max_examples=40)
def test_scores_are_the_intersections(case):
    index, centre, model, how = drawn(case)
    found = candidate_scores(index, centre, model, **how)
    bins, reach = len(model), 30
    wide = np.pad(index, reach, constant_values=bins)  # outside the image nothing matches
    compare = intersection if case["measure"] == "printed" else intersection_of_shares
    for k, half_width in enumerate(how["half_widths"]):
        for row, column in np.ndindex(found.shape[1:]):
            u, v = centre[0] + column - how["radius"], centre[1] + row - how["radius"]
            mask = Ellipse(u + reach, v + reach, half_width).mask(wide.shape[::-1])
            score = compare(histogram(wide, bins + 1, mask), np.append(model, 0.0))
            assert np.isclose(found[k, row, column], score, atol=1e-4)


def test_scores_do_not_depend_on_what_else_is_searched():
    rng = np.random.default_rng(3)
    index = rng.integers(0, 64, (60, 80), dtype=np.int32)
    model = shares(rng.uniform(0, 1, 64))
    wide = candidate_scores(index, (40, 30), model, half_widths=[8, 9], radius=9)
    narrow = candidate_scores(index, (42, 31), model, half_widths=[9], radius=2)
    np.testing.assert_array_equal(narrow[0], wide[1, 8:13, 9:14])


def test_a_moving_head_is_followed_with_its_size():
    state = start()
    for k in range(30):
        truth = 60 + 2 * k, 60 + round(10 * np.sin(k / 5)), 12 + k // 6
        state, info = TRACKER.step(state, scene(*truth))
        assert np.abs(np.subtract((state.ellipse.u, state.ellipse.v), truth[:2])).max() <= 2
        assert abs(state.ellipse.half_width - truth[2]) <= 1
        assert not info.lost
    assert info.candidates.shape == (3, 17, 17)
    assert info.candidates.max() == info.score
    assert info.best == state.ellipse


def test_the_printed_measure_lets_the_ellipse_shrink():
    for measure, size, low, high in (
        ("printed", "score", 5, 12),  # a part of the head has all its pixels in the model
        ("shares", "excess", 14, 16),
    ):
        tracker = replace(TRACKER, rules=replace(RULES, measure=measure, size=size))
        state = start(tracker)
        for _ in range(15):
            state, _ = tracker.step(state, scene(60, 60, 15))
        assert low <= state.ellipse.half_width <= high


def test_a_given_size_is_not_searched():
    state, info = TRACKER.step(start(), scene(62, 60, 15), half_width=14.6)
    assert state.ellipse.half_width == 15
    assert info.half_widths == (15,)
    assert info.candidates.shape == (1, 17, 17)


def test_the_search_begins_where_the_head_would_be():
    state, _ = TRACKER.step(start(), scene(67, 57))
    assert (state.ellipse.u, state.ellipse.v) == (67, 57)
    assert state.velocity == (7, -3)
    state, info = TRACKER.step(state, scene(80, 53))  # 13 columns: beyond the radius of 8
    assert info.centre == (74, 54)
    assert (state.ellipse.u, state.ellipse.v) == (80, 53)


def test_of_equal_scores_the_nearest_to_the_middle_is_taken():
    even = np.full((100, 100, 3), 128, dtype=np.uint8)
    for tracker, half_width in (
        (replace(TRACKER, rules=replace(RULES, size="score")), 9),
        (TRACKER, 10),  # most pixels
    ):
        state = HeadState(Ellipse(50, 50, 9), tracker.colours(even, Ellipse(50, 50, 9)))
        assert tracker.step(state, even)[0].ellipse == Ellipse(50, 50, half_width)


def test_a_fading_light_is_followed_by_adaptation_alone():
    scores = []
    for rate in (0.2, 0.0):
        tracker = replace(TRACKER, rules=replace(RULES, rate=rate, gate=0.5))
        state = start(tracker)
        for light in np.linspace(1, 0.5, 80):
            state, info = tracker.step(state, scene(60, 60, light=light), half_width=12)
        scores.append(info.score)
        assert info.adapted == (rate > 0)
    assert scores[0] > 0.8 > 0.5 > scores[1]


def test_the_model_is_adapted_only_above_the_gate():
    image, state = scene(60, 60, light=0.8), start()
    _, seen = TRACKER.step(state, image)
    for gate in (seen.score, np.nextafter(seen.score, 1)):
        tracker = replace(TRACKER, rules=replace(RULES, gate=gate))
        after, info = tracker.step(state, image)
        assert info.adapted == (gate <= seen.score)
        assert np.array_equal(after.model, state.model) != info.adapted
    adapted, _ = replace(TRACKER, rules=replace(RULES, gate=0.0)).step(state, image)
    expected = 0.9 * state.model + 0.1 * TRACKER.colours(image, adapted.ellipse)
    np.testing.assert_allclose(adapted.model, expected, atol=1e-15)


def test_two_views_follow_a_head_that_turns_round():
    back = TRACKER.colours(scene(60, 60, turned=True), Ellipse(60, 60, 12))
    for model, kept in ((two_views(start().model, back), True), (start().model, False)):
        state = replace(start(), model=model)
        _, info = TRACKER.step(state, scene(60, 60, turned=True))
        assert (info.score > 0.9) == kept


def test_a_head_that_is_hidden_is_reported_lost_and_found_again():
    state, wall = start(), np.full((120, 160, 3), WALL, dtype=np.uint8)
    state, _ = TRACKER.step(state, scene(62, 60))
    for k in range(1, 5):
        hidden, info = TRACKER.step(state, wall)
        assert info.lost
        assert not info.adapted
        assert hidden.lost == k
        assert hidden.velocity == (0, 0)
        assert hidden.ellipse == Ellipse(62, 60, 12)
        np.testing.assert_array_equal(hidden.model, state.model)
        state = hidden
    assert info.candidates.shape == (3, 129, 129)  # 8 doubled three times is 64
    state, info = TRACKER.step(state, scene(110, 70))
    assert (state.ellipse.u, state.ellipse.v, state.lost) == (110, 70, 0)
    assert state.velocity == (0, 0)  # nobody knows how fast it is
    assert not info.lost


def test_a_lost_head_is_found_only_where_it_is_surely_the_head():
    state, image = replace(start(), lost=1), scene(60, 60, turned=True)
    for again, lost in ((0.2, False), (0.9, True)):
        tracker = replace(TRACKER, rules=replace(RULES, again=again, gives_up=0.0))
        assert tracker.step(state, image)[1].lost == lost


def test_a_head_that_leaves_the_image_is_lost_and_the_ellipse_stays_in_the_image():
    state, seen = start(), []
    for k in range(40):
        state, info = TRACKER.step(state, scene(60 - 3 * k, 60))
        seen.append(info.lost)
        assert 0 <= info.centre[0] < SIZE[0]
        assert np.isfinite(info.candidates).all()
    assert not any(seen[:18])
    assert seen[-1]


def test_colours_are_those_of_the_pixels_inside():
    image = scene(10, 60)
    ellipse = Ellipse(3, 60, 12)  # a part of it lies outside
    mask = ellipse.mask(SIZE)
    counts = histogram(TRACKER.binning.index(image), TRACKER.binning.count, mask)
    np.testing.assert_array_equal(TRACKER.colours(image, ellipse), shares(counts))
    printed = replace(TRACKER, rules=replace(RULES, measure="printed"))
    np.testing.assert_array_equal(printed.colours(image, ellipse), counts)
    drawn = cv2.ellipse(np.zeros(SIZE[::-1], np.uint8), (3, 60), (12, 14), 0, 0, 360, 1, -1)
    assert np.mean(drawn.astype(bool) != mask) < 0.005


def test_wrong_images_and_states_are_refused():
    state, image = start(), scene(60, 60)
    after, _ = TRACKER.step(state, image)
    with unchecked():
        for wrong, error in (
            (image[..., 0], ValueError),
            (image.astype(float), TypeError),
            (image[:0], ValueError),
        ):
            with pytest.raises(error, match="image must"):
                TRACKER.step(state, wrong)
        with pytest.raises(ValueError, match=r"image must be \(160, 120\) px as those before"):
            TRACKER.step(after, image[:100])
        with pytest.raises(ValueError, match=r"state\.model must be"):
            HeadTracker(Binning("RGB")).step(state, image)
        with pytest.raises(ValueError, match="half_width must be from 1 to 200, got 0"):
            TRACKER.step(state, image, half_width=0.2)
        with pytest.raises(ValueError, match="half_width must be finite"):
            TRACKER.step(state, image, half_width=np.nan)
        with pytest.raises(ValueError, match="ellipse must reach into the image"):
            TRACKER.colours(image, Ellipse(400, 60, 10))
        with pytest.raises(ValueError, match="model must hold a pixel"):
            HeadState(Ellipse(1, 1, 1), np.zeros(8))

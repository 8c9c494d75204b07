"""Pictures that show nothing, and pictures of another size than those before."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.ceiling.mapping import Mapper, MapRules, MapState, PatternTrackers
from robot_perception.ceiling.navigator import Navigator, ReplayState
from robot_perception.ceiling.tracker import PatternTracker
from robot_perception.ceiling.visual_memory import KeyImage
from tests.ceiling.ceilings import BLANK, CENTRE, SCALE, camera, driven, film, mapped, run

STEEP = (401, 402, 411)  # ceilings on which some patterns fall so fast that 0 is near 1


@lru_cache
def first(seed: int) -> MapState:
    """Return what the first picture below a ceiling leaves."""
    picture = camera("varied", seed).image(np.zeros(3))
    mapper = Mapper(SCALE, CENTRE)
    return mapper.step(mapper.start(), picture, rng=np.random.default_rng(1))[0]


@given(st.sampled_from(STEEP), st.integers(0, 255), st.integers(0, 2**31))
@settings(max_examples=12, deadline=None)
def test_a_picture_of_one_grey_fits_no_pattern(seed, grey, chance):
    state, picture = first(seed), np.full_like(BLANK, grey)
    for name, pattern in state.patterns.items():
        tracker = PatternTracker(pattern, MapRules().tracker)
        _, info = tracker.step(state.tracked[name], picture, rng=np.random.default_rng(chance))
        assert info.lost
        assert not info.good.any()


@given(st.integers(0, 2**31))
@settings(max_examples=12, deadline=None)
def test_a_vector_that_is_like_nothing_in_the_picture_is_a_bad_one(chance):
    rng, state = np.random.default_rng(chance), first(STEEP[0])
    picture = rng.integers(0, 256, BLANK.shape).astype(np.uint8)
    for name, pattern in state.patterns.items():
        tracker = PatternTracker(pattern, MapRules().tracker)
        _, info = tracker.step(state.tracked[name], picture, rng=rng)
        assert (info.correlation[info.good] > 0).all()


@pytest.mark.parametrize("seed", STEEP[:2])
def test_in_the_dark_a_robot_does_not_know_where_it_is_and_finds_itself_again(seed):
    pictures, dark = [camera("varied", seed).image(p) for p in driven(8, 0.02, 0.0)], range(3, 6)
    for k in dark:
        pictures[k] = np.zeros_like(BLANK)
    states = mapped(np.array(pictures))
    assert [info.located for _, info in states] == [k not in dark for k in range(8)]
    (begin, _), (end, _) = states[0], states[-1]
    away = np.hypot(*(end.pose - begin.pose)[:2])
    assert away == pytest.approx(7 * 0.02, abs=0.01)


def followed(image, rng):
    state = run(2)[-1][0]
    trackers = PatternTrackers(state.patterns, MapRules().tracker, 30.0)
    return trackers.step(state.tracked, image, rng=rng)


def stepped(image, rng):
    state = run(2)[-1][0]
    name, pattern = next(iter(state.patterns.items()))
    return PatternTracker(pattern).step(state.tracked[name], image, rng=rng)


def map_continued(image, rng):
    return Mapper(SCALE, CENTRE).step(run(2)[-1][0], image, rng=rng)


def map_continued_blindly(image, rng):
    mapper, (state, _) = Mapper(SCALE, CENTRE), run(2)[0]
    for _ in range(3):
        state, _ = mapper.step(state, BLANK, rng=rng)
    assert not state.tracked
    return mapper.step(state, image, rng=rng)


@lru_cache
def replay() -> tuple[Navigator, ReplayState]:
    state, info = run(2)[0]
    route = [KeyImage(info.sightings)]
    navigator = Navigator(route, state.patterns, state.mosaic, CENTRE, SCALE)
    return navigator, navigator.start(film(2)[0], rng=np.random.default_rng(0))


def replayed(image, rng):
    navigator, state = replay()
    return navigator.step(state, image, rng=rng)


def replayed_blindly(image, rng):
    navigator, state = replay()
    return navigator.step(replace(state, tracked={}), image, rng=rng)


STEPS = (
    followed,
    stepped,
    map_continued,
    map_continued_blindly,
    replayed,
    replayed_blindly,
)


@pytest.mark.parametrize(
    "other",
    [
        lambda image: image[:-1],
        lambda image: np.ascontiguousarray(image.T),
        lambda image: np.tile(image, (2, 2)),
        lambda image: image[:1, :1],
    ],
    ids=["a row less", "on its side", "twice as large", "a pixel"],
)
@pytest.mark.parametrize("step", STEPS)
def test_a_picture_of_another_size_is_refused(step: Callable, other: Callable):
    picture, rng = film(2)[1], np.random.default_rng(0)
    height, width = picture.shape
    with pytest.raises(ValueError, match=rf"image must be \({height}, {width}\) as the pictures"):
        step(other(picture), rng)
    step(picture, rng)

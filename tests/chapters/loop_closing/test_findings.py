"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import building, explorers, posts
from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.teaching.figures import figure
from tests.chapters.findings import limits, presets_that_show_the_default, states
from tests.unchecked import unchecked

CLOSES = ("a sensor of the position", "the names", "the names and an anchor")


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes, which double their time."""
    with unchecked():
        explorers.growth(3.0, 90.0)
        explorers.nailed(0, 0)
        for state in states(explorers.BUILT_CONTROLS):
            building.built(**state)


@pytest.mark.parametrize(
    ("presets", "controls"),
    [
        (explorers.BUILT_PRESETS, explorers.BUILT_CONTROLS),
        (explorers.PLAY_PRESETS, explorers.PLAY_CONTROLS),
        (explorers.ANCHOR_PRESETS, explorers.ANCHOR_CONTROLS),
        (explorers.GROWTH_PRESETS, explorers.GROWTH_CONTROLS),
    ],
)
def test_no_preset_shows_the_default(presets, controls):
    assert not presets_that_show_the_default(presets, controls)


# The building


def test_only_names_or_a_position_close_the_loop():
    for state in states(explorers.BUILT_CONTROLS):
        made = building.built(**state)
        assert (made.off < 0.5) == (state["given"] in CLOSES), state
        assert (made.off > 2.0) == (state["given"] not in CLOSES), state
        assert (made.twice == 0) == state["given"].startswith("the names"), state


def test_an_anchor_changes_nothing_unless_the_names_are_known_and_the_start_is_not():
    off = {tuple(s.values()): building.built(**s).off for s in states(explorers.BUILT_CONTROLS)}
    for start in ("exact", "uncertain"):
        assert off["an anchor", start] == pytest.approx(off["nothing", start], rel=0.02)
    assert off["the names and an anchor", "exact"] == pytest.approx(
        off["the names", "exact"], rel=0.02
    )
    assert off["the names and an anchor", "uncertain"] < off["the names", "uncertain"] / 2


def test_axes_of_the_map_stay_and_hold_it():
    _, ax = figure()
    seen = set()
    for state in states(explorers.BUILT_CONTROLS):
        made = building.built(**state)
        seen.add(limits(draw.built_map(ax, made)))
        left, right, low, high = limits(ax)
        assert ((made.readings > [left, low]) & (made.readings < [right, high])).mean() > 0.9
    assert len(seen) == 1


# What the filter believes on the way


def ellipse(played, time):
    """Return the largest 2σ of the robot's position, m."""
    belief = played.history.kept[played.steps[time]]
    return 2 * np.sqrt(np.linalg.eigvalsh(belief.pose_cov[:2, :2])[-1])


def test_ellipses_grow_across_the_path_and_shrink_when_the_first_posts_return():
    before, after = explorers.PLAY_PRESETS["just before"], explorers.PLAY_PRESETS["just after"]
    for variant in ("plain", "anchored"):
        played = explorers.play(variant)
        reach = [ellipse(played, time) for time in range(explorers.FRAMES)]
        assert max(reach) > 5 * reach[0]
        assert reach[after["time"]] < reach[before["time"]] / 2
        first, last = (played.history.kept[played.steps[p["time"]]] for p in (before, after))
        shrunk = np.trace(last.landmark_covs[: len(first.landmarks)], axis1=1, axis2=2)
        assert (shrunk < np.trace(first.landmark_covs, axis1=1, axis2=2)).all()


def test_the_anchor_opens_the_same_fan_from_a_sharper_point():
    plain, anchored, external = map(explorers.play, explorers.PLAY_CONTROLS["variant"].values)
    assert ellipse(anchored, 0) < 0.8 * ellipse(plain, 0)
    widest = [max(ellipse(p, t) for t in range(explorers.FRAMES)) for p in (plain, anchored)]
    assert widest[1] > 0.7 * widest[0]
    assert max(ellipse(external, t) for t in range(explorers.FRAMES)) < widest[0] / 3


def test_axes_of_the_play_stay():
    _, ax = figure()
    seen = set()
    for variant in explorers.PLAY_CONTROLS["variant"].values:
        for time in (0, 20, 39):
            seen.add(limits(draw.moment(ax, explorers.play(variant), time)))
    assert len(seen) == 1


# Anchors


def test_an_anchor_works_where_the_robot_has_had_time_to_err():
    rms = explorers.path_errors()
    ones = {place: rms[1, place] for place in explorers.ANCHOR_CONTROLS["place"].values}
    assert max(ones.values()) < rms[0, 0]
    best = min(ones, key=ones.get)
    assert 15 <= best <= 45
    assert ones[best] < min(ones[0], ones[75])
    twos = [rms[2, place] for place in ones]
    assert all(two < one for two, one in zip(twos, ones.values(), strict=True))


def test_two_that_are_far_apart_hold_the_heading():
    for place in explorers.ANCHOR_CONTROLS["place"].values:
        one, two = (explorers.nailed(count, place).runs for count in (1, 2))
        assert np.mean(two.rms_heading**2) < np.mean(one.rms_heading**2)


def test_axes_of_the_anchors_stay():
    _, axes = figure(2, 1)
    seen = set()
    for state in states(explorers.ANCHOR_CONTROLS):
        draw.nailed(axes, explorers.nailed(**state))
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1


# Noise and length


def lengths():
    return explorers.GROWTH_CONTROLS["length"].values


def test_errors_grow_with_the_loop_and_hardly_with_the_external_sensor():
    for noise in explorers.GROWTH_CONTROLS["noise"].values:
        plain, external = (
            [explorers.growth(noise, length)[name].rms.max() for length in lengths()]
            for name in ("plain", "external")
        )
        assert plain[-1] > 5 * plain[0]
        assert max(external) < 0.6


def test_axes_of_noise_and_length_stay():
    _, axes = figure(2, 1)
    seen = set()
    for state in states(explorers.GROWTH_CONTROLS):
        draw.growth(axes, explorers.growth(**state), explorers.growth_reach())
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1


def test_the_quietest_filter_is_not_better_and_less_honest():
    quiet, next_to_it, *_ = explorers.GROWTH_CONTROLS["noise"].values
    for length in lengths():
        first, other = explorers.growth(quiet, length), explorers.growth(next_to_it, length)
        assert first["plain"].nees.mean() > 1.5 * other["plain"].nees.mean()
        assert first["plain"].rms.max() > other["plain"].rms.max()
        assert first["first estimates"].nees.mean() < 0.6 * first["plain"].nees.mean()


# The rule


def test_with_the_rule_the_error_hardly_grows_and_the_filter_is_far_too_sure():
    rule = posts.run(posts.RULE_DRAWN, posts.RULE_VARIANTS, rng=np.random.default_rng(4))
    plain, removed, considered = rule.runs.values()
    assert removed.path_error.mean() < 1.5 * plain.path_error.mean()
    assert removed.nees.mean() > 30 * plain.nees.mean()
    assert considered.nees.mean() < 2 * plain.nees.mean()
    assert (removed.retired > 0).all()

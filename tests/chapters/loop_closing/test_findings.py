"""What the chapter tells a reader to find, in every state of its explorers."""

import itertools

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


def test_names_or_a_position_close_the_loop_and_nothing_else_does():
    for state in states(explorers.BUILT_CONTROLS):
        made = building.built(**state)
        assert (made.twice == 0) == (state["given"] in CLOSES), state
        if state["given"] not in CLOSES:
            assert made.off > 1.0


def test_an_anchor_changes_nothing_and_names_leave_centimetres_from_an_exact_start():
    off = {given: building.built(given).off for given in building.GIVEN}
    assert off["an anchor"] == pytest.approx(off["nothing"], rel=0.02)
    assert off["the names"] < 0.1
    assert off["a sensor of the position"] < 0.5


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
        assert max(reach[:20]) > 5 * reach[0] or max(reach) > 5 * reach[0]
        assert reach[after["time"]] < reach[before["time"]] / 2
        first, last = (played.history.kept[played.steps[p["time"]]] for p in (before, after))
        shrunk = np.trace(last.landmark_covs[: len(first.landmarks)], axis1=1, axis2=2)
        assert (shrunk < np.trace(first.landmark_covs, axis1=1, axis2=2)).all()


def test_the_anchor_opens_the_same_fan_from_a_sharper_point():
    plain, anchored, external = map(explorers.play, explorers.PLAY_CONTROLS["variant"].values)
    assert ellipse(anchored, 0) < ellipse(plain, 0) / 1.5
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
    assert 30 <= best <= 60
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


def test_errors_grow_with_the_loop_except_with_the_external_sensor():
    for noise in explorers.GROWTH_CONTROLS["noise"].values:
        most = {
            name: [explorers.growth(noise, length)[name].rms.max() for length in lengths()]
            for name in ("plain", "external")
        }
        assert most["plain"][-1] > most["plain"][0]
        assert most["external"][-1] < 1.5 * most["external"][0]


def test_axes_of_noise_and_length_stay():
    _, axes = figure(2, 1)
    seen = set()
    for state in states(explorers.GROWTH_CONTROLS):
        draw.growth(axes, explorers.growth(**state), explorers.growth_reach())
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1


def test_less_noise_makes_the_filter_better_and_not_more_honest():
    for length in lengths():
        runs = [
            explorers.growth(n, length)["plain"] for n in explorers.GROWTH_CONTROLS["noise"].values
        ]
        assert all(a.rms.max() < b.rms.max() for a, b in itertools.pairwise(runs))
        assert runs[0].nees.mean() > 0.9 * runs[-1].nees.mean()


# The rule


def test_with_the_rule_the_error_hardly_grows_and_the_filter_is_far_too_sure():
    rule = posts.run(posts.RULE_DRAWN, posts.RULE_VARIANTS, rng=np.random.default_rng(4))
    plain, removed, considered = rule.runs.values()
    assert removed.path_error.mean() < 1.5 * plain.path_error.mean()
    assert removed.nees.mean() > 30 * plain.nees.mean()
    assert considered.nees.mean() < 2 * plain.nees.mean()
    assert (removed.retired > 0).all()

"""What the chapter tells a reader to find, in every state of its explorers."""

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.chapters.loop_closing import posts, states
from robot_perception.chapters.loop_closing.explorers import ANCHORS, BUILT, GROWTH, PLAY
from robot_perception.teaching.figures.style import MEANING
from tests.chapters.findings import ExplorerTests, limits
from tests.unchecked import unchecked

CLOSES = ("a sensor of the position", "the names", "the names and an anchor")


@pytest.fixture(autouse=True, scope="module")
def computed():
    """All states, computed once, without the checks of shapes, which double their time."""
    with unchecked():
        states.grown()
        states.all_nailed()
        for state in BUILT.parameters():
            BUILT.state(**state)


class TestExplorers(ExplorerTests):
    explorers = (BUILT, PLAY, ANCHORS, GROWTH)


# The building


def test_only_names_or_a_position_close_the_loop():
    for state in BUILT.parameters():
        made = BUILT.state(**state)
        assert (made.off < 0.5) == (state["given"] in CLOSES), state
        assert (made.off > 2.0) == (state["given"] not in CLOSES), state
        assert (made.twice == 0) == state["given"].startswith("the names"), state


def test_an_anchor_changes_nothing_unless_the_names_are_known_and_the_start_is_not():
    off = {tuple(s.values()): BUILT.found(**s)[0] for s in BUILT.parameters()}
    for start in ("exact", "uncertain"):
        assert off["an anchor", start] == pytest.approx(off["nothing", start], rel=0.02)
    assert off["the names and an anchor", "exact"] == pytest.approx(
        off["the names", "exact"], rel=0.02
    )
    assert off["the names and an anchor", "uncertain"] < off["the names", "uncertain"] / 2


def test_the_map_holds_nearly_all_readings():
    for state in BUILT.parameters():
        left, right, low, high = limits(BUILT.drawn(**state))
        readings = BUILT.state(**state).readings
        assert ((readings > [left, low]) & (readings < [right, high])).mean() > 0.9


# What the filter believes on the way


def test_ellipses_grow_across_the_path_and_shrink_when_the_first_posts_return():
    before, after = PLAY.presets["just before"], PLAY.presets["just after"]
    for variant in ("plain", "anchored"):
        played, reach = states.play(variant), PLAY.found(variant=variant)
        assert max(reach) > 5 * reach[0]
        assert reach[after["time"]] < reach[before["time"]] / 2
        first, last = (played.history.kept[played.steps[p["time"]]] for p in (before, after))
        shrunk = np.trace(last.landmark_covs[: len(first.landmarks)], axis1=1, axis2=2)
        assert (shrunk < np.trace(first.landmark_covs, axis1=1, axis2=2)).all()


def test_the_anchor_opens_the_same_fan_from_a_sharper_point():
    plain, anchored, external = (PLAY.found(variant=v) for v in PLAY.controls["variant"].values)
    assert anchored[0] < 0.8 * plain[0]
    assert max(anchored) > 0.7 * max(plain)
    assert max(external) < max(plain) / 3


def test_the_last_posts_in_sight_again_make_the_whole_map_sharp():
    played = states.play("plain")
    before, after = (played.history.kept[played.steps[i]] for i in (33, states.FRAMES - 1))
    assert np.trace(after.pose_cov[:2, :2]) < 0.1 * np.trace(before.pose_cov[:2, :2])
    assert len(after.landmarks) == len(played.drive.landmarks)


# Anchors


def test_an_anchor_works_where_the_robot_has_had_time_to_err():
    (none,) = set(ANCHORS.found(count=0))
    ones, twos = (dict(zip(states.PLACES, ANCHORS.found(count=n), strict=True)) for n in (1, 2))
    assert max(ones.values()) < none
    best = min(ones, key=ones.get)
    assert 15 <= best <= 45
    assert ones[best] < min(ones[0], ones[75])
    assert all(twos[place] < one for place, one in ones.items())


def test_two_that_are_far_apart_hold_the_heading():
    for place in states.PLACES:
        one, two = (states.nailed(count, place).runs for count in (1, 2))
        assert np.mean(two.rms_heading**2) < np.mean(one.rms_heading**2)


# Noise and length


def test_errors_grow_with_the_loop_and_hardly_with_the_external_sensor():
    for noise in states.NOISES:
        found = GROWTH.found(noise=noise)
        assert found[-1]["plain"] > 5 * found[0]["plain"]
        assert max(errors["external"] for errors in found) < 0.6


def test_errors_grow_with_the_noise_from_the_quietest_to_the_roughest():
    quiet, *_, rough = GROWTH.found(length=90.0)
    assert all(rough[name] > error for name, error in quiet.items())


def test_the_quietest_filter_is_not_better_and_less_honest():
    quiet, next_to_it, *_ = states.NOISES
    for length in states.LENGTHS:
        first, other = states.growth(quiet, length), states.growth(next_to_it, length)
        assert first["plain"].nees.mean() > 1.5 * other["plain"].nees.mean()
        louder = (states.growth(noise, length)["plain"] for noise in states.NOISES[2:])
        assert all(first["plain"].nees.mean() > 1.1 * one.nees.mean() for one in louder)
        assert first["plain"].rms.max() > other["plain"].rms.max()
        assert first["first estimates"].nees.mean() < 0.6 * first["plain"].nees.mean()


# Words and colours


def test_every_variant_has_its_own_colour():
    assert len({draw.tint(name) for name in posts.JACOBIANS}) == len(posts.JACOBIANS)
    assert MEANING["rule"] not in map(draw.tint, posts.JACOBIANS)


def test_words_say_what_the_pictures_show():
    most = states.growth(0.3, 30.0)["external"].rms.max()
    assert f"external: at most {most:.2f} m" in GROWTH.described(noise=0.3, length=30.0)
    last = states.nailed(2, 15).runs.rms[-1]
    assert f"{last:.2f} m at the end" in ANCHORS.described(count=2, place=15)
    number = len(states.play("plain").drive.landmarks)
    assert f"{number} landmarks" in PLAY.described(time=states.FRAMES - 1)

"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from explorables.figures import figure
from explorables.figures.style import MEANING
from robot_perception.book import loop_closing as loop
from robot_perception.chapters.loop_closing import figures as draw
from tests.chapters.findings import limits

# The building


@pytest.mark.slow
def test_from_an_uncertain_start_the_names_and_an_anchor_do_better_than_the_names():
    off = {(given, start): loop.built(given, start).off
           for given in ("the names", "the names and an anchor")
           for start in ("exact", "uncertain")}  # fmt: skip
    exact, turned = ([off[given, start] for given in ("the names and an anchor", "the names")]
                     for start in ("exact", "uncertain"))  # fmt: skip
    assert exact[0] == pytest.approx(exact[1], rel=0.02)
    assert turned[0] < turned[1] / 2


def test_the_map_holds_nearly_all_readings():
    for state in loop.give.parameters():
        made = loop.built(**state)
        left, right, low, high = limits(draw.built_map.on(figure()[1], made))
        readings = made.readings
        assert ((readings > [left, low]) & (readings < [right, high])).mean() > 0.9


@pytest.mark.parametrize("given", ["a sensor of the position", "nothing"])
def test_readings_of_a_good_path_lie_on_the_plan(given):
    made = loop.built(given, every=40, beams=12)
    along = made.faces[:, 1] - made.faces[:, 0]
    arm = made.readings[:, None] - made.faces[:, 0]
    share = ((arm * along).sum(axis=-1) / (along**2).sum(axis=-1)).clip(0, 1)
    gaps = np.linalg.norm(arm - share[..., None] * along, axis=-1).min(axis=1)
    assert (np.median(gaps) < 0.15) == (given != "nothing")
    title = draw.built_map.on(figure()[1], made).get_title(loc="left")
    assert title == f"{made.off:.2f} m off, {made.twice} landmarks twice"


def test_an_exact_start_leaves_the_anchor_nothing_to_do_and_an_uncertain_one_does():
    table = loop.by_setting(loop.rounded.rows())
    for noise in ("small", "large"):
        exact, uncertain = (
            table[f"{noise} noise, known, {start} start", "ratio"]
            for start in ("exact", "uncertain")
        )
        assert uncertain.high < 1
        assert uncertain.estimate < exact.low
    assert table["small noise, gated, displaced start", "ratio"].high < 0.2


def test_hardly_a_landmark_of_the_building_is_seen_often_enough_for_the_papers_limit():
    seen = loop.sighted.rows().spread("times")
    assert 5 < seen.estimate < seen.high < 50
    ruled = loop.rounded.rows().where(filter="anchored, rule at 15", setting=loop.UNKNOWN)
    assert ruled.mean("retired").low > 5


def test_the_figure_of_ends_has_the_filters_of_its_tables():
    tables = {name: loop.at_the_end(name) for name in (loop.UNKNOWN, loop.KNOWN)}
    _, axes = figure(1, 2)
    draw.end_errors.on(axes, tables)
    for ax, table in zip(axes, tables.values(), strict=True):
        names = [name.get_text().replace("\n", " ") for name in ax.get_yticklabels()]
        assert names == list(table.rows)


# The posts


def test_when_the_first_posts_return_every_one_becomes_surer():
    before, after = (loop.play.presets[name]["time"] for name in ("just before", "just after"))
    for way in ("plain", "anchored"):
        first, last = (loop.moment(way, time).belief for time in (before, after))
        shrunk = np.trace(last.landmark_covs[: len(first.landmarks)], axis1=1, axis2=2)
        assert (shrunk < np.trace(first.landmark_covs, axis1=1, axis2=2)).all()


def test_the_last_posts_in_sight_again_make_the_whole_map_sharp():
    before, after = (loop.moment("plain", time) for time in (33, loop.FRAMES - 1))
    assert np.trace(after.belief.pose_cov[:2, :2]) < 0.1 * np.trace(before.belief.pose_cov[:2, :2])
    assert len(after.belief.landmarks) == len(after.posts)


def test_errors_grow_with_the_noise_from_the_quietest_to_the_roughest():
    quiet, rough = (loop.grown(noise, 90.0) for noise in (loop.NOISES[0], loop.NOISES[-1]))
    assert all(rough.rms[way].max() > quiet.rms[way].max() for way in loop.GROWN)


def test_agreeing_jacobians_remove_most_of_the_excess_nees_and_little_of_the_error():
    excess, error, _ = loop.removed(loop.honest.rows(), "turned")
    assert excess.low > 0.5
    assert error.high < 0.5


# Words and colours


def test_every_variant_has_its_own_colour():
    assert len({draw.tint(name) for name in loop.JACOBIANS}) == len(loop.JACOBIANS)
    assert MEANING["rule"] not in map(draw.tint, loop.JACOBIANS)


def test_words_say_what_the_pictures_show():
    most = loop.grown(0.3, 30.0).rms["external"].max()
    assert f"external: at most {most:.2f} m" in loop.grow.described(noise=0.3, length=30.0)
    last = loop.nailed(2, 15).rms[-1]
    assert f"{last:.2f} m at the end" in loop.anchor.described(count=2, place=15)
    number = len(loop.played("plain")[0].landmarks)
    assert f"{number} landmarks" in loop.play.described(time=loop.FRAMES - 1)
    whole = f"{loop.nailed(1, 30).drive_error:.2f} m"
    assert whole in loop.anchor.drawn(count=1, place=30)[1].get_title(loc="left")

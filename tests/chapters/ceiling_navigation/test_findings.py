"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from robot_perception.book import ceiling_navigation as page
from tests.chapters.findings import limits


def test_half_the_scale_is_slower_and_cuts_the_bends():
    for bearing in page.BEARINGS:
        true, half, quarter = (page.as_driven(factor, bearing, 0.0) for factor in (1.0, 0.5, 0.25))
        assert len(true.path) < len(half.path) < len(quarter.path)
        reach = [np.abs(s.path[:, 1]).max() for s in (quarter, half, true)]
        assert reach[0] < reach[1] < reach[2]


def test_a_robot_that_turns_more_quickly_bears_a_scale_three_times_too_large():
    slow, quick = (page.as_driven(3.0, bearing, 0.6) for bearing in (1.8, 4.0))
    assert slow.swings > 1 > quick.swings


def test_what_is_drawn_of_the_quotient_is_inside_the_axes():
    for state in page.dragged.parameters():
        left, right, low, high = limits(page.dragged.drawn(**state))
        found = page.placed(**state)
        for x, y, _ in (found.right, found.wrong):
            assert left < x < right
            assert high < y < low


def test_words_say_what_is_shown():
    assert "unstable" in page.servoing.described(factor=3.0)
    assert "lost" not in page.servoing.described(factor=3.0)
    off = page.placed(0.6, 0.4, 45.0).off
    assert f"{off:.2f} m away" in page.dragged.described()


def test_the_circle_is_driven_only_by_key_images_as_they_should_be():
    driven = [found[1:] for found in page.by_conditions().values()]
    (circle, came), (stood, lost), (cut, there) = driven
    assert (came, lost, there) == ("arrived", "lost", "arrived")
    assert page.came_of(page.taught("circle"), circle, came)["fits"]
    assert cut[:, 1].max() < 0.3 < 1.3 < circle[:, 1].max()
    assert len(stood) < len(circle) / 2


def test_a_robot_that_went_to_the_key_image_and_looks_elsewhere_did_go_there():
    rows = page.approached.rows()
    for name in ("2 times", "3 times"):
        assert rows.largest("near", change=name) < 0.05
        assert rows.rate("arrives", change=name).estimate < 1
    assert page.only(page.BEHIND).estimate == 0
    assert rows.median("near", change=page.SINCE) == pytest.approx(0.087, abs=0.01)


def test_by_our_rules_the_adjusted_mosaic_is_nearer_to_the_truth_and_most_loops_close():
    ours = page.mapped.rows().where(rules="ours")
    chained, adjusted = (ours.mean("patterns", by=name) for name in ("chained", "adjusted"))
    assert adjusted.high < chained.low
    assert ours.rate("closed", by="chained").estimate > 0.7


def test_two_patterns_in_common_are_more_than_one():
    one, two = (page.kept.rows().rate("fits", way=way) for way in page.WAYS[:2])
    assert two.low > one.high


@pytest.mark.parametrize("claim", [page.mosaic_fig9, page.visual_memory])
def test_a_claim_on_what_is_left_open_is_of_the_printed_form_with_more_particles(claim):
    rows = claim.study.rows()
    least, *_, last = rows.levels("choice")
    assert last == page.MORE
    assert claim.value(rows) == claim.value(rows.where(choice=page.MORE))
    assert claim.value(rows) != claim.value(rows.where(choice=least))


def test_only_errors_that_are_wholly_within_the_range_are_bold():
    table = page.by_choice(page.left_open.rows(), page.repeated.rows(), page.longer.rows())
    bold = page.holding(table)
    errors = [name for name in table.columns if name != "reproduced"]
    for row in table.rows:
        for name in errors:
            cell = table[row, name]
            assert ((row, name) in bold) == (cell is not None and cell.high <= page.SEARCHED)


def test_the_composed_picture_is_the_ceiling_where_the_robot_was_right():
    """At the beginning of the loop it was."""
    start, plan = page.loop("ours").true[0], page.composed()
    points = start[:2] + np.random.default_rng(5).uniform(-0.8, 0.8, (2000, 2))
    left, right, bottom, top = plan.extent
    rows, columns = plan.image.shape
    share = (points - [left, top]) / [right - left, bottom - top]
    x, y = (share * [columns, rows]).T.astype(int)
    above = page.below(page.SHOWN, side=17.0)
    texels = np.round(above.texels(points)).astype(int)
    true = above.texture[texels[:, 1], texels[:, 0]].astype(float)
    assert np.corrcoef(true, plan.image[y, x].astype(float))[0, 1] > 0.4
    assert (plan.image == 255).any()

"""The explorers: what the chapter tells a reader to find, and what their states say and draw."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from explorables.figures.style import MEANING
from robot_perception.book import sift_association as page
from robot_perception.book.sift_association import ANY
from robot_perception.chapters.sift_association import recordings
from tests.chapters.findings import limits

PLANT, TABLE, VIEW = page.plant, page.deciding, page.aside


def test_all_lines_between_the_two_rooms_are_wrong():
    rooms = page.doors()
    assert len(rooms.here) > 50
    assert not rooms.right.any()


# A viewpoint


@pytest.mark.parametrize("picture", page.PICTURES.values())
def test_features_are_found_again_or_lost(picture):
    views = [page.view(picture, angle) for angle in (0.0, 30.0, 60.0)]
    assert len({len(one.pixels) + one.lost for one in views}) == 1
    for one in views:
        assert len(one.distances) == len(one.pixels) > 0
        high, wide = one.image.shape
        assert ((one.pixels >= 0) & (one.pixels < [wide, high])).all()
        assert ((one.distances >= 0) & (one.distances < 1024)).all()


@pytest.mark.parametrize("angle", [0.0, 45.0])
def test_words_of_a_view_are_its_numbers(angle):
    found = page.view("notices", angle)
    numbers = re.findall(r"\d+", VIEW.described(subject="notices", angle=angle))
    total = len(found.pixels) + found.lost
    moved = round(float(np.median(found.distances)))
    assert [int(n) for n in numbers] == [int(angle), len(found.pixels), total, moved, 512]


def test_words_of_a_view_without_features():
    none = SimpleNamespace(
        subject="notices", angle=60.0, pixels=np.empty((0, 2)), distances=np.empty(0), lost=7
    )
    said = VIEW.alt(none)
    assert "0 of 7 features" in said
    assert "by nothing" in said


def test_a_view_shows_every_feature():
    found = page.view("poster", 30.0)
    (ax,) = VIEW.drawn(angle=30.0).axes
    near, far = ax.collections
    assert len(near.get_offsets()) + len(far.get_offsets()) == len(found.pixels)
    moved = np.sort(found.distances[found.distances > 200])
    assert np.sort(far.get_sizes()) == pytest.approx((2 + moved / 30) ** 2)


# The aloe


def test_on_the_plant_each_rule_needs_the_other():
    alone = [PLANT.state(rows=2.0, threshold=ANY), PLANT.state(rows=ANY, threshold=200.0)]
    both = PLANT.state(rows=2.0, threshold=200.0).share
    assert max(one.share for one in alone) < both - 0.3


def test_a_finding_that_is_turned_round_is_noticed():
    found = np.reshape(PLANT.found(), (3, 4, 4))
    assert PLANT.finds(found.ravel().tolist())
    for place in ((0, 1, 2), (2, 3, 0), (0, 3, 3)):  # too few right with two rows, by a ratio, free
        other = found.copy()
        other[place] = 0.0
        assert not PLANT.finds(other.ravel().tolist())


def test_words_of_the_aloe_are_its_matches():
    aloe = page.aloe()
    for state in list(PLANT.parameters())[::5]:
        found = recordings.choose(aloe.result, **state)
        matched, known = np.count_nonzero(found.others >= 0), np.count_nonzero(aloe.result.known)
        assert PLANT.described(**state) == (
            f"Of {known} features of the left picture {matched} are matched, {found.share:.0%} of "
            "them right."
        )
    assert "image_pairs" in aloe.note


def test_the_aloe_shows_every_match():
    pair, chosen = page.aloe().result, page.chosen(2.0, 100.0, 0.7)
    for _ in range(2):
        ax = PLANT.drawn(threshold=100.0, ratio=0.7)
        assert len(ax.lines) == 5  # nothing is left of the last one
    for name, right in (("right", True), ("wrong", False)):
        lines = [line for line in ax.lines if line.get_color() == MEANING[name]]
        (joined,) = (line.get_xydata() for line in lines if line.get_marker() == "None")
        assert np.isnan(joined[2::3]).all()  # gaps
        rows = np.flatnonzero((chosen.others >= 0) & (chosen.right == right))
        ends = np.stack([pair.pixels[rows], pair.others[chosen.others[rows]]], axis=1)
        assert joined.reshape(-1, 3, 2)[:, :2] == pytest.approx(ends)


# Table 1


def test_a_finding_of_table_1_that_is_turned_round_is_noticed():
    found = TABLE.found()
    assert TABLE.finds(found)
    for model, where, gain in (("raw", page.OTHER, 1.0), ("raw", page.OWN, -1.0),
                               ("pooled", page.FARTHER, -2.0)):  # fmt: skip
        at = next(k for k, one in enumerate(found) if one[:2] == (model, where))
        other = [*found]
        other[at] = (*found[at][:3], gain)
        assert not TABLE.finds(other)


def test_every_state_of_table_1_is_said_and_is_that_of_the_rows():
    rows = page.straight.rows()
    for parameters in TABLE.parameters():
        state = TABLE.state(**parameters)
        good, like = state.share[state.model], state.like[state.model]
        assert 0 <= good + like <= 100 + 1e-9
        means, first = (state.share[name] for name in (page.EUCLID, page.ONE_VIEW))
        said = TABLE.alt(state)
        assert f"{good:.1f} % right, {like:.1f} % taken" in said
        assert f"Euclid has {means:.1f} % to the means and {first:.1f} % to the first" in said
    where = {"p": 10, "model": "shrunk", "where": page.FARTHER}
    shown = TABLE.state(p=10, model="shrunk", where=page.FARTHER, track="straight on")
    assert shown.share["shrunk"] == pytest.approx(rows.of("right", **where).mean())
    assert shown.like["shrunk"] == pytest.approx(rows.of("alike", **where).mean())


def test_bars_of_table_1_are_the_errors_and_the_dot_is_on_the_line():
    model = "shrunk, log-determinant"
    state = TABLE.state(p=10, model=model, where=page.FARTHER, track="to either side")
    above, below = TABLE.drawn(p=10, model=model, where=page.FARTHER)
    names = page.ONE_VIEW, page.EUCLID, model
    widths = np.reshape([bar.get_width() for bar in above.patches], (2, 3)).T
    assert widths.sum(axis=1) == pytest.approx([100 - state.share[n] for n in names])
    assert widths[:, 0] == pytest.approx([state.like[n] for n in names])
    assert [t.get_text() for t in above.get_yticklabels()] == ["first views", "means", "variances"]
    *lines, dot = below.lines
    assert len(lines) == len(page.MODELS)
    assert dot.get_xydata() == pytest.approx(np.array([[10, state.share[model]]]))
    strong = [line for line in lines if line.get_linewidth() > 2]
    assert sorted((line.get_color(), line.get_linestyle()) for line in strong) == sorted(
        [(MEANING["Euclid"], "--"), (MEANING["Euclid"], "-"), (MEANING["shrunk"], "-")]
    )


def test_axes_of_table_1_stay():
    states = list(TABLE.parameters())[::7]
    assert len({tuple(map(limits, TABLE.drawn(**state))) for state in states}) == 1


# What the text says of the rows


def test_right_matches_are_fewer_without_either_rule():
    table = page.with_and_without(page.matched.rows())
    both = table["both rules", "right"]
    for name in ("no row rule", "no threshold", "neither"):
        assert table[name, "right"].estimate < both.estimate
    assert table["neither", "right"].high < both.low


def test_a_landmark_from_aside_is_farther_than_a_look_alike_and_nearer_than_another_landmark():
    rows = page.viewed.rows()
    alike, slight, large = (page.moved(rows, angle) for angle in (0, 5, 30))
    assert alike.high < large.low
    assert large.high < rows.mean("other", angle=0).low
    assert rows.ratio("moved", ("angle", 5, 0)).low > 1.5
    assert large.low > 1.5 * slight.high


def test_the_verdict_hangs_on_which_descriptor_euclid_is_to():
    rows = page.assigned.rows()
    assert page.gain(rows, page.OTHER).low > 0 > page.gain(rows, page.OTHER, over="Euclid").high


def test_a_class_knows_its_own_frames_and_with_few_of_them_hardly_any_others():
    rows = page.assigned.rows()
    assert page.right_by(rows, page.OWN, "raw", 3).low > 99
    raw, means = (page.right_by(rows, page.OTHER, name, 3) for name in ("raw", "Euclid"))
    assert raw.estimate < means.estimate - 2


def test_shared_variances_do_not_lose_where_raw_ones_do():
    gains = page.gains()["straight on, then aside"]
    assert all(one.high < -5 for one in gains["raw"])
    assert all(one.low > -1 for one in gains["pooled"])


def test_as_printed_nothing_is_new_and_as_meant_most_of_it():
    rows = page.called.rows()
    assert rows.mean("called").high == 0
    assert rows.mean("as meant").low > 0.7


def test_shrunk_variances_break_even_and_with_the_log_determinant_gain_less_than_two_points():
    rows = page.assigned.rows()
    even = page.gain(rows, page.OTHER, model="shrunk", over="Euclid")
    assert even.low < 0 < even.high
    best = page.gain(rows, page.OTHER, model="shrunk" + page.WITH, over="Euclid")
    assert 0 < best.low < 2

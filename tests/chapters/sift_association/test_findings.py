"""The explorers: what the chapter tells a reader to find, and what their states say and draw."""

import re
from itertools import pairwise, product

import numpy as np
import pytest

from robot_perception.chapters.sift_association import explorers, hero, recordings, table1
from robot_perception.chapters.sift_association.explorers import ANY, PLANT, TABLE, VIEW, Decision
from robot_perception.chapters.sift_association.viewpoint import View
from robot_perception.teaching.figures.style import MEANING
from tests.chapters.findings import ExplorerTests, limits


class TestExplorers(ExplorerTests):
    explorers = (VIEW, PLANT, TABLE)


def test_all_lines_between_the_two_rooms_are_wrong():
    rooms = hero.doors()
    assert len(rooms.here) > 50
    assert not rooms.right.any()


# A viewpoint


@pytest.mark.parametrize("picture", explorers.PICTURES.values())
def test_with_30_degrees_more_fewer_are_found_and_their_descriptors_have_moved_farther(picture):
    count, median = zip(*VIEW.found(subject=picture), strict=True)
    assert explorers.ANGLES[6] - explorers.ANGLES[0] == 30
    assert all(a > b for a, b in zip(count, count[6:], strict=False))
    assert all(a < b for a, b in zip(median, median[6:], strict=False))


@pytest.mark.parametrize("picture", explorers.PICTURES.values())
def test_features_are_found_again_or_lost(picture):
    views = [explorers.view(picture, angle) for angle in (0.0, 30.0, 60.0)]
    assert len({len(one.pixels) + one.lost for one in views}) == 1
    for one in views:
        assert len(one.distances) == len(one.pixels) > 0
        high, wide = one.image.shape
        assert ((one.pixels >= 0) & (one.pixels < [wide, high])).all()
        assert ((one.distances >= 0) & (one.distances < 1024)).all()


@pytest.mark.parametrize("angle", [0.0, 45.0])
def test_words_of_a_view_are_its_numbers(angle):
    found = explorers.view("notices", angle)
    numbers = re.findall(r"\d+", VIEW.described(subject="notices", angle=angle))
    total = len(found.pixels) + found.lost
    moved = round(float(np.median(found.distances)))
    assert [int(n) for n in numbers] == [int(angle), len(found.pixels), total, moved, 512]


def test_words_of_a_view_without_features():
    none = View(np.zeros((4, 4), np.uint8), np.empty((0, 2)), np.empty(0), 7)
    said = VIEW.alt(("notices", 60.0, none))
    assert "0 of 7 features" in said
    assert "by nothing" in said


def test_a_view_shows_every_feature():
    found = explorers.view("poster", 30.0)
    (ax,) = VIEW.drawn(angle=30.0).axes
    near, far = ax.collections
    assert len(near.get_offsets()) + len(far.get_offsets()) == len(found.pixels)
    moved = np.sort(found.distances[found.distances > 200])
    assert np.sort(far.get_sizes()) == pytest.approx((2 + moved / 30) ** 2)


# The aloe


def test_up_to_a_threshold_of_200_two_rows_are_better_than_any_row():
    for threshold in (100.0, 200.0):
        two, free = (PLANT.found(rows=rows, threshold=threshold) for rows in (2.0, ANY))
        assert all(a > b for a, b in zip(two, free, strict=True))


def test_without_a_threshold_a_ratio_is_better_without_rows():
    alone = [PLANT.state(rows=2.0, threshold=ANY), PLANT.state(rows=ANY, threshold=200.0)]
    both = PLANT.state(rows=2.0, threshold=200.0).share
    assert max(one.share for one in alone) < both - 0.3  # each rule needs the other
    two, free = (PLANT.found(rows=rows, threshold=ANY) for rows in (2.0, ANY))
    for ratio, a, b in zip(PLANT.controls["ratio"].values, two, free, strict=True):
        assert (a < b) == (ratio < 1), ratio


def test_words_of_the_aloe_are_its_matches():
    aloe = explorers.aloe()
    for state in list(PLANT.parameters())[::5]:
        found = recordings.choose(aloe.result, **state)
        matched, known = np.count_nonzero(found.others >= 0), np.count_nonzero(aloe.result.known)
        assert PLANT.described(**state) == (
            f"Of {known} features of the left picture {matched} are matched, {found.share:.0%} of "
            "them right."
        )
    assert "image_pairs" in aloe.note


def test_the_aloe_shows_every_match():
    pair, chosen = explorers.aloe().result, explorers.matched(2.0, 100.0, 0.7)
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


def test_raw_variances_win_on_their_own_frames_and_lose_on_all_others():
    for where in table1.TESTS:
        gains = TABLE.found(model=table1.RAW, where=where)
        assert all((gain > 0) == (where == "trained") for gain in gains), where


def test_raw_variances_lose_the_more_the_fewer_frames_they_come_from():
    for where, track in product(("again", "aside"), table1.TRACKS):
        gains = TABLE.found(model=table1.RAW, where=where, track=track)
        assert all(a < b for a, b in pairwise(gains)), (where, track)


def test_pooled_variances_never_lose_much():
    assert min(TABLE.found(model="pooled")) > -1


def test_every_state_of_table_1_is_recorded_and_said():
    for state in (Decision(**parameters) for parameters in TABLE.parameters()):
        column = f"p = {state.p}"
        good, like = (t[state.model, column].estimate for t in state.tables())
        assert 0 <= good + like <= 100 + 1e-9
        means, first = (state.share(name) for name in (table1.EUCLID, table1.ONE_VIEW))
        said = TABLE.alt(state)
        assert f"{good:.1f} % right, {like:.1f} % taken" in said
        assert f"Euclid has {means:.1f} % to the means and {first:.1f} % to the first" in said


def test_bars_of_table_1_are_the_errors_and_the_dot_is_on_the_line():
    model, column = "shrunk, log-determinant", "p = 10"
    state = Decision(10, model, "aside", "")
    above, below = TABLE.drawn(p=10, model=model, where="aside")
    names = table1.ONE_VIEW, table1.EUCLID, model
    widths = np.reshape([bar.get_width() for bar in above.patches], (2, 3)).T
    wrong, alike = [100 - state.share(n) for n in names], state.tables()[1]
    assert widths.sum(axis=1) == pytest.approx(wrong)
    assert widths[:, 0] == pytest.approx([alike[n, column].estimate for n in names])
    assert [t.get_text() for t in above.get_yticklabels()] == ["first views", "means", "variances"]
    *lines, dot = below.lines
    assert len(lines) == len(table1.MODELS)
    assert dot.get_xydata() == pytest.approx(np.array([[10, state.share(model)]]))
    strong = [line for line in lines if line.get_linewidth() > 2]
    assert sorted((line.get_color(), line.get_linestyle()) for line in strong) == sorted(
        [(MEANING["Euclid"], "--"), (MEANING["Euclid"], "-"), (MEANING["shrunk"], "-")]
    )


def test_axes_of_table_1_stay():
    states = list(TABLE.parameters())[::7]
    assert len({tuple(map(limits, TABLE.drawn(**state))) for state in states}) == 1

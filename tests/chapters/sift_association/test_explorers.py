"""The explorers: states agree with the studies, and their words with the states."""

import re

import numpy as np
import pytest

from robot_perception.chapters.sift_association import explorers, recordings, table1
from robot_perception.chapters.sift_association import figures as draw
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.style import image_axes
from tests.chapters.findings import states

TABLE_STATES = list(states(explorers.TABLE_CONTROLS))


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
    said = explorers.describe_view("notices", angle)
    numbers = [int(n) for n in re.findall(r"\d+", said)]
    total = len(found.pixels) + found.lost
    moved = round(float(np.median(found.distances)))
    assert numbers == [int(angle), len(found.pixels), total, moved, 512]


def test_words_of_a_view_without_features(monkeypatch):
    none = explorers.View(np.zeros((4, 4), np.uint8), np.empty((0, 2)), np.empty(0), 7)
    monkeypatch.setattr(explorers, "view", lambda subject, angle: none)
    assert "0 of 7 features" in explorers.describe_view("notices", 60.0)
    assert "by nothing" in explorers.describe_view("notices", 60.0)


def test_rules_of_the_aloe_are_those_of_the_recording():
    for state in list(states(explorers.PAIR_CONTROLS))[::5]:
        found, own = explorers.chosen(**state), recordings.choose(explorers.aloe(), **state)
        assert (found.others == own.others).all()
        said = explorers.describe_pair(**state)
        matched = np.count_nonzero(found.others >= 0)
        known = np.count_nonzero(explorers.aloe().known)
        assert said.startswith(f"Of {known} features of the left picture {matched} are matched")
        assert f" {found.share:.0%} of them right" in said
    assert "image_pairs" in explorers.note()


def test_every_state_of_table_1_is_recorded_and_said():
    for state in TABLE_STATES:
        where = state["where"], state["track"]
        right, alike = explorers.rates(*where), explorers.confusions(*where)
        column = f"p = {state['p']}"
        good, like = right[state["model"], column], alike[state["model"], column]
        assert 0 <= good.estimate + like.estimate <= 100 + 1e-9
        said = explorers.describe_table(**state)
        assert f"{good.estimate:.1f} % right, {like.estimate:.1f} % taken" in said
        assert f"Euclid has {right[table1.EUCLID, column].estimate:.1f} % to the means" in said
        assert f"and {right[table1.ONE_VIEW, column].estimate:.1f} % to the first" in said


# The drawings of all states


def test_pictures_show_every_feature_and_every_match():
    found = explorers.view("poster", 30.0)
    _, ax = image_axes(found.image)
    for _ in range(2):  # drawn again, nothing is left of the last one
        draw.view(ax, found)
        near, far = ax.collections
    assert len(near.get_offsets()) + len(far.get_offsets()) == len(found.pixels)
    assert len(far.get_offsets()) == np.count_nonzero(found.distances > 200)
    moved = np.sort(found.distances[found.distances > 200])
    assert np.sort(far.get_sizes()) == pytest.approx((2 + moved / 30) ** 2)
    pair = explorers.aloe()
    _, ax = image_axes(pair.first)
    chosen = explorers.chosen(2.0, 100.0, 0.7)
    for _ in range(2):
        draw.pair(ax, pair, chosen)
        assert len(ax.lines) == 5  # nothing is left of the last one
    for name, right in (("right", True), ("wrong", False)):
        lines = [line for line in ax.lines if line.get_color() == draw.MEANING[name]]
        (joined,) = (line.get_xydata() for line in lines if line.get_marker() == "None")
        drawn = joined.reshape(-1, 3, 2)[:, :2]
        assert np.isnan(joined[2::3]).all()  # gaps
        rows = np.flatnonzero((chosen.others >= 0) & (chosen.right == right))
        assert len(drawn) == len(rows)
        for ends, k in zip(drawn, rows, strict=True):
            assert ends == pytest.approx(np.stack([pair.pixels[k], pair.others[chosen.others[k]]]))


def test_bars_of_table_1_are_the_errors_and_the_dot_is_on_the_line():
    _, axes = figure(2, 1)
    model, column = "shrunk, log-determinant", "p = 10"
    right, alike = explorers.rates("aside"), explorers.confusions("aside")
    draw.table_state(axes, 10, model, right, alike)
    above, below = axes
    names = table1.ONE_VIEW, table1.EUCLID, model
    widths = np.reshape([bar.get_width() for bar in above.patches], (3, 2))
    assert widths.sum(axis=1) == pytest.approx([100 - right[n, column].estimate for n in names])
    assert widths[:, 0] == pytest.approx([alike[n, column].estimate for n in names])
    assert [t.get_text() for t in above.get_yticklabels()] == ["first views", "means", "variances"]
    *lines, dot = below.lines
    assert len(lines) == len(table1.MODELS)
    assert dot.get_xydata() == pytest.approx(np.array([[10, right[model, column].estimate]]))
    strong = [line for line in lines if line.get_linewidth() > 2]
    assert sorted((line.get_color(), line.get_linestyle()) for line in strong) == sorted(
        [
            (draw.MEANING["Euclid"], "--"),
            (draw.MEANING["Euclid"], "-"),
            (draw.MEANING["shrunk"], "-"),
        ]
    )

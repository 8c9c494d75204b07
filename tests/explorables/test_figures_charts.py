"""Curves, bars and arrows say what they are given."""

import numpy as np
import pytest
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from explorables.figures import MEANING, figure
from explorables.figures.charts import Arrow, bars, curve, states, strip
from studies.intervals import Interval

FOUND = [Interval(0.5, 0.4, 0.7, "", "a"), Interval(0.9, 0.8, 0.95, "", "b")]


def test_a_curve_goes_through_estimates_and_its_band_through_the_ends():
    _, ax = figure()
    curve(ax, (10, 20), FOUND, MEANING["estimate"], "--s", label="named")
    (line,) = ax.get_lines()
    np.testing.assert_array_equal(line.get_xydata(), [[10, 0.5], [20, 0.9]])
    assert (line.get_linestyle(), line.get_marker(), line.get_label()) == ("--", "s", "named")
    ends = {tuple(corner) for corner in ax.collections[0].get_paths()[0].vertices}
    assert {(10, 0.4), (10, 0.7), (20, 0.8), (20, 0.95)} <= ends


def test_what_is_no_share_is_written_where_its_bar_would_be():
    _, ax = figure()
    bars(ax, {"one": FOUND[0], "none": "–"}, MEANING["right"], "held")
    assert len(ax.patches) == 1
    (text,) = ax.texts
    assert (text.get_text(), text.get_position()[1]) == ("–", 1)


def test_bars_are_as_long_as_estimates_and_lines_as_intervals_the_first_on_top():
    _, ax = figure()
    bars(ax, {"one": FOUND[0], "two": FOUND[1]}, MEANING["right"], "held")
    assert [(bar.get_width(), bar.get_y() + bar.get_height() / 2) for bar in ax.patches] == [
        (0.5, 0.0), (0.9, 1.0),
    ]  # fmt: skip
    ends = [list(line.get_xdata()) for line in ax.get_lines()]
    assert ends == [[0.4, 0.7], [0.8, 0.95]]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["one", "two"]
    assert ax.get_xlabel() == "held"
    assert ax.get_ylim()[0] > ax.get_ylim()[1]


def test_states_stand_at_their_places_and_arrows_lead_from_one_to_the_other():
    _, ax = figure()
    places = {"a": (0.0, 0.0), "b": (1.0, 0.5)}
    states(ax, places, [Arrow("a", "b"), Arrow("b", "a", -0.3, dashed=True)])
    assert {text.get_text(): text.get_position() for text in ax.texts} == places
    boxes = [patch for patch in ax.patches if isinstance(patch, FancyBboxPatch)]
    middles = [(box.get_x() + box.get_width() / 2, box.get_y() + box.get_height() / 2)
               for box in boxes]  # fmt: skip
    assert middles == list(places.values())
    there, back = (patch for patch in ax.patches if isinstance(patch, FancyArrowPatch))
    assert there._posA_posB == [places["a"], places["b"]]
    assert back._posA_posB == [places["b"], places["a"]]
    assert (there.get_linestyle(), back.get_linestyle()) == ("-", "--")
    assert there.get_edgecolor() != back.get_edgecolor()


def test_the_text_of_an_arrow_stands_on_its_middle():
    _, ax = figure()
    places = {"a": (0.0, 0.0), "b": (2.0, 1.0)}
    states(ax, places, [Arrow("a", "b", 0.5, "comes")])
    text = ax.texts[-1]
    assert text.get_text() == "comes"
    (arrow,) = (patch for patch in ax.patches if isinstance(patch, FancyArrowPatch))
    curve = arrow.get_connectionstyle().connect(*arrow._posA_posB).vertices
    assert text.get_position() == pytest.approx(curve.T @ [0.25, 0.5, 0.25])


def test_a_strip_rings_the_run_that_is_shown_in_each_row():
    _, ax = figure()
    drawn = {"one": [1.0, 3.0], "ten": [0.5, 0.7, 2.0]}
    strip(ax, drawn, {"one": 2.0, "ten": 0.6}, "off by (m)")
    dots, rings = ax.lines[::2], ax.lines[1::2]
    assert [line.get_xdata().tolist() for line in dots] == list(drawn.values())
    assert [(*line.get_xdata(), *line.get_ydata()) for line in rings] == [(2.0, 0), (0.6, 1)]
    assert [text.get_text() for text in ax.texts] == ["one", "ten"]
    with pytest.raises(KeyError, match="ten"):
        strip(ax, drawn, {"one": 2.0}, "off by (m)")

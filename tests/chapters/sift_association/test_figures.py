"""The drawings hold what the results say, on axes that stay."""

from types import SimpleNamespace

import numpy as np
import pytest

from explorables.figures import figure
from explorables.figures.style import MEANING, image_axes
from robot_perception.book.sift_association import MODELS, RAW, Rooms, expected_distance
from robot_perception.chapters.sift_association import figures as draw
from studies.intervals import Interval
from studies.tables import Table
from tests.chapters.findings import limits

AROUND = 2.0
RNG = np.random.default_rng
DRAWN = (RAW, "shrunk", "pooled")


def interval(value: float) -> Interval:
    return Interval(value, value - AROUND, value + AROUND, "", "made up")


def texts(ax) -> set[str]:
    return {text.get_text() for text in ax.texts}


def check_band(band, low, high):
    heights = {round(y, 9) for y in band.get_paths()[0].vertices[:, 1]}
    np.testing.assert_allclose(sorted(heights), sorted({round(y, 9) for y in (*low, *high)}))


@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_the_colour_of_its_variance(model):
    assert draw.tint(model) == MEANING[model.split(",")[0]]


def test_lines_between_rooms_lead_from_the_left_to_the_right():
    image = np.zeros((240, 650), np.uint8)
    here, there = RNG(1).uniform(10, 200, (2, 8, 2))
    found = Rooms(image, here, there, np.arange(8) == 0, 8.0)
    _, ax = image_axes(image)
    for _ in range(2):
        draw.hero.on(ax, found)
        dots = [line for line in ax.lines if line.get_marker() == "o"]
        lines = [line for line in ax.lines if line.get_marker() != "o"]
        assert (len(dots), len(lines)) == (8, 2)
    for k, name in ((0, "right"), (6, "wrong")):
        for drawn in (dots[k], lines[k // 6]):
            assert drawn.get_xydata().tolist() == [there[k].tolist(), here[k].tolist()]
            assert drawn.get_color() == MEANING[name]


def angles(scale: float) -> Table:
    rows = {f"{a}°": (interval(scale * a), interval(0.5)) for a in (0, 30, 60)}
    return Table(rows, {"distance": "", "found": ""}, "made up", "viewpoint")


def test_distance_by_angle_has_its_band_and_what_it_meets():
    seen = set()
    for scale in (3.0, 5.0):
        _, ax = figure()
        draw.distance_by_angle.on(ax, angles(scale), interval(300.0), interval(40.0))
        curve, other, alike = ax.lines
        assert curve.get_xdata().tolist() == [0, 30, 60]
        assert curve.get_ydata() == pytest.approx([0, 30 * scale, 60 * scale])
        ends = np.array([0, 30, 60]) * scale
        check_band(ax.collections[0], ends - AROUND, ends + AROUND)
        assert set(other.get_ydata()) == {300.0}
        assert set(alike.get_ydata()) == {40.0}
        assert texts(ax) == {"nearest other landmark", "look-alike, same viewpoint"}
        seen.add(limits(ax))
        assert ax.get_xlabel()
        assert ax.get_ylabel()
    assert seen == {(0, 60, 0, 350)}


def test_rules_are_drawn_by_threshold_in_order():
    rows = {"2.0": (interval(0.95), interval(0.9)), "240.0": (interval(0.92), interval(0.85))}
    table = Table(rows, {"100": "", "800": ""}, "made up", "rows")
    _, ax = figure()
    draw.right_by_rules.on(ax, table)
    two, free = ax.lines
    assert two.get_ydata() == pytest.approx([95, 90])
    assert free.get_ydata() == pytest.approx([92, 85])
    assert two.get_color() == MEANING["right"]
    assert texts(ax) == {"±2 rows", "any row"}
    assert [t.get_text() for t in ax.get_xticklabels()] == ["100", "none"]
    assert ax.get_ylim() == (80, 100)


def test_gains_have_a_panel_for_each_test_and_a_line_for_each_variance():
    panels = "as the track", "from aside"
    value = {
        title: {name: (-10.0 * k - j, -float(k)) for k, name in enumerate(DRAWN)}
        for j, title in enumerate(panels)
    }
    cells = {t: {n: [*map(interval, v)] for n, v in some.items()} for t, some in value.items()}
    _, axes = figure(1, 2)
    draw.gains.on(axes, cells, (3, 30))
    for ax, title in zip(axes, panels, strict=True):
        _, *lines = ax.lines
        assert ax.get_title(loc="left") == title
        for line, band, name in zip(lines, ax.collections, DRAWN, strict=True):
            expected = np.array(value[title][name])
            assert line.get_ydata() == pytest.approx(expected)
            assert line.get_xdata() == pytest.approx([3, 30])
            assert line.get_color() == MEANING[name]
            check_band(band, expected - AROUND, expected + AROUND)
        assert limits(ax) == (0, 32, -30, 5)
    names = [t.get_text() for t in axes[0].get_legend().get_texts()]
    assert names == list(DRAWN)


def test_an_infinite_law_is_left_out():
    _, ax = figure()
    rows = {"3": (interval(6000.0), "∞"), "30": (interval(900.0), expected_distance(30))}
    draw.own_distance.on(ax, Table(rows, {"measured": "", "law": ""}, "", "frames"))
    measured, law, known = ax.lines
    assert measured.get_xydata().tolist() == [[3, 6000], [30, 900]]
    assert law.get_xydata().tolist() == [[30, expected_distance(30)]]
    assert set(known.get_ydata()) == {128}
    assert ax.get_yscale() == "log"
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["measured", "law"]


def test_new_landmarks_have_a_dot_at_the_best_threshold():
    limits_ = np.array([1.0, 2.0, 3.0])
    precision, recall = np.array([0.5, 0.9, 1.0]), np.array([1.0, 0.8, 0.0])
    made = SimpleNamespace(limits=limits_, precision=precision, recall=recall, best=1)
    _, ax = figure()
    draw.new_landmarks.on(ax, {"Euclid": made, "pooled": made})
    for name, line, dot in zip(("Euclid", "pooled"), ax.lines[::2], ax.lines[1::2], strict=True):
        assert line.get_xydata() == pytest.approx(np.array([[100, 50], [80, 90], [0, 100]]))
        assert dot.get_xydata() == pytest.approx(np.array([[80, 90]]))
        assert line.get_color() == dot.get_color() == MEANING[name]
    assert limits(ax) == (0, 100, 40, 100)
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["Euclid", "pooled"]

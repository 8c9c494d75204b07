"""A plan shows what is given at one scale, up is y, and its grid says how many metres."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from robot_perception import datasets

SVG = "{http://www.w3.org/2000/svg}"
WALLS = np.array([[[0.0, 0], [6, 0]], [[6, 0], [6, 3]]])
WAY = np.array([[1.0, 1], [2, 1], [5, 2]])
MARKS = np.array([[1.5, 2.5], [4, 0.5]])


def drawn(path):
    """Return the root of a plan, and the points of its lines."""
    root = ElementTree.parse(path).getroot()
    lines = [
        np.array([list(map(float, pair.split(","))) for pair in line.get("points").split()])
        for line in root.iter(f"{SVG}polyline")
    ]
    return root, lines


def test_what_is_drawn_is_similar_to_what_is_there_with_y_up(tmp_path):
    datasets.write_plan(tmp_path / "a.svg", walls=WALLS, way=WAY, marks=MARKS, names=["7", "<8>"])
    root, lines = drawn(tmp_path / "a.svg")
    dots = [[float(dot.get(name)) for name in ("cx", "cy")] for dot in root.iter(f"{SVG}circle")]
    found = np.concatenate([*lines, np.array(dots)])
    true = np.concatenate([*WALLS, WAY, WAY[:1], MARKS])
    scale = np.linalg.norm(lines[0][1] - lines[0][0]) / 6
    flipped = scale * true * [1, -1]
    np.testing.assert_allclose(found - found[0], flipped - flipped[0], atol=0.11)
    assert {"7", "<8>"} <= {text.text for text in root.iter(f"{SVG}text")}
    size = np.array([float(root.get("width")), float(root.get("height"))])
    assert size.max() == 1000
    assert (found >= 0).all()
    assert (found <= size).all()


def test_the_grid_says_its_metres(tmp_path):
    """Between two lines lie as many pixels as the scale and the difference of their names say."""
    datasets.write_plan(tmp_path / "a.svg", walls=WALLS + 100.3)
    root, lines = drawn(tmp_path / "a.svg")
    scale = np.linalg.norm(lines[0][1] - lines[0][0]) / 6
    upright = [line for line in root.iter(f"{SVG}line") if line.get("x1") == line.get("x2")]
    names = [text.text for text in root.iter(f"{SVG}text")][: len(upright)]
    values = [float(re.sub(" m$", "", name)) for name in names]
    places = [float(line.get("x1")) for line in upright]
    assert 4 <= len(values) <= 13
    step = values[1] - values[0]
    np.testing.assert_allclose(values, step * np.round(np.divide(values, step)))
    np.testing.assert_allclose(np.diff(places), scale * np.diff(values), atol=0.11)
    assert places[0] == pytest.approx(lines[0][0, 0] + scale * (values[0] - 100.3), abs=0.11)


@pytest.mark.parametrize("far", [0.0, 1e-9, 1e6, 1e12])
def test_a_plan_of_nothing_or_of_one_place_is_a_picture(tmp_path, far):
    datasets.write_plan(tmp_path / "none.svg")
    datasets.write_plan(tmp_path / "one.svg", way=np.full((1, 2), far))
    for name in ("none.svg", "one.svg"):
        assert float(drawn(tmp_path / name)[0].get("width")) >= 1


def test_each_mark_has_a_name_or_none_has(tmp_path):
    with pytest.raises(ValueError, match="names must be one for each of 2 marks, got 1"):
        datasets.write_plan(tmp_path / "a.svg", marks=MARKS, names=["7"])
    datasets.write_plan(tmp_path / "a.svg", marks=MARKS)
    assert len(list(drawn(tmp_path / "a.svg")[0].iter(f"{SVG}circle"))) == 2

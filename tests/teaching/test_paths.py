"""Ways through a small book, and the drawing of its chapters."""

import re
from xml.etree import ElementTree

import pytest

from explorables.figures.output import PAGE_VARIABLE
from robot_perception.teaching.pages.contents import Contents
from robot_perception.teaching.pages.paths import Path, graph, hours, paths
from tests.teaching.test_contents import boxed, page

BOOK = Contents(
    [
        page("walls", "word " * 6000),
        boxed("slam", "You need [walls](walls.ipynb)."),
        boxed("loop", "You need [slam](slam.ipynb), [walls](walls.ipynb)."),
        page("own", "word " * 2000, number=None),
    ]
)


def test_a_path_holds_what_its_goal_needs():
    way = Path("Maps", ("slam",), ("own",))
    assert way.stops(BOOK) == ("walls", "slam", "own")
    assert way.minutes(BOOK) == pytest.approx((6000 + 2000) / 200, abs=0.2)


def test_paths_name_pages_with_links_and_hours():
    shown = paths(BOOK, [Path("Maps <2>", ("slam",))])
    html = shown.bundle["text/html"]
    assert "Maps &lt;2&gt;" in html
    assert repr(shown) == "Maps <2>, 30 minutes: 1. Walls, 1. Slam"


@pytest.mark.parametrize(
    ("minutes", "told"),
    [(22, "20 minutes"), (50, "1 hour"), (95, "1 ½ hours"), (350, "6 hours")],
)
def test_hours_are_told_in_halves(minutes, told):
    assert hours(minutes) == told


def test_the_graph_links_each_chapter_and_draws_each_need_once(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    html = graph(BOOK).bundle["text/html"]
    svg = re.search(r"<svg.*</svg>", html, re.S)[0]
    assert re.findall(r'<a href="([^"]*)"', svg) == ["walls.html", "slam.html", "loop.html"]
    tree = ElementTree.fromstring(svg)
    assert tree.get("role") == "group"
    assert "Loop needs Slam" in tree.get("aria-label")
    arcs = [
        node for node in tree.iter() if node.tag.endswith("path") and "C" in node.get("d", "")
        and "var(--rp-muted" in node.get("style", "")
    ]  # fmt: skip
    assert len(arcs) == 2

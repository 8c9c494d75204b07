"""One colour, one meaning: what figures name, and what they may not name."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from matplotlib.colors import is_color_like

import robot_perception
from explorables.figures import MEANING, style
from tests.explorables.test_figures import contrast, palette

ROOT = Path(robot_perception.__file__).parents[1]
CHAPTERS = ROOT / "robot_perception" / "chapters"
DRAWN = [*sorted(CHAPTERS.rglob("*.py")), ROOT / "explorables/figures/maps.py"]
PALETTE = {
    name: value
    for name, value in vars(style).items()
    if isinstance(value, str) and re.fullmatch("#[0-9a-f]{6}", value)
}
VISIBLE = set(PALETTE.values()) - {style.FAINT, style.GROUND}


def test_every_meaning_has_a_colour_of_the_palette():
    assert set(MEANING.values()) <= VISIBLE


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_meaning_is_seen_on_the_ground(theme):
    colours = palette(theme)
    names = {value: name.lower() for name, value in PALETTE.items()}
    for meaning, colour in MEANING.items():
        assert contrast(colours[names[colour]], colours["ground"]) >= 3, meaning


def is_colour(text: str) -> bool:
    """Tell whether a string in a drawing names a colour, and nothing else."""
    return is_color_like(text) and len(text) > 1 and text != "none" and not text.isdigit()


@pytest.mark.parametrize("path", DRAWN, ids=lambda path: str(path.relative_to(ROOT)))
def test_drawings_name_meanings_and_no_colours(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Name | ast.Attribute):
            name = node.id if isinstance(node, ast.Name) else node.attr
            assert name not in {*PALETTE, "COLOURS"}, f"line {node.lineno}: {name}"
        if isinstance(node, ast.keyword) and "color" in (node.arg or ""):
            for text in ast.walk(node.value):
                named = isinstance(text, ast.Constant) and isinstance(text.value, str)
                assert not (named and is_colour(text.value)), f"line {node.value.lineno}"
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            assert not re.search("#[0-9a-fA-F]{6}", node.value), f"line {node.lineno}"


def functions(path: Path) -> dict[str, ast.FunctionDef]:
    """Return the functions of a module by name."""
    tree = ast.parse(path.read_text("utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def meanings(name: str, known: dict[str, ast.FunctionDef], seen: set[str]) -> Iterator[str]:
    """Yield the meanings that a function names, or a function of its module that it calls."""
    seen.add(name)
    nodes = [node for statement in known[name].body for node in ast.walk(statement)]
    given = [n.value for n in nodes if isinstance(n, ast.keyword) and n.arg in ("ha", "side")]
    placed = [node for value in given for node in ast.walk(value)]
    for node in nodes:
        if isinstance(node, ast.Constant) and node.value in MEANING and node not in placed:
            yield node.value
        if isinstance(node, ast.Name) and node.id in known and node.id not in seen:
            yield from meanings(node.id, known, seen)


SYNONYMS = ({"landmark", "walls"}, {"robot", "estimate"}, {"anchor", "anchored"})
"""Words for one thing: on a map and in a state, a place and the filter that is told of it."""
FIGURES = [path for path in DRAWN if "figures" in (path.stem, path.parent.name)]


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: str(path.relative_to(ROOT)))
def test_different_meanings_in_a_drawing_have_different_colours(path):
    known = functions(path)
    for name in known:
        found = set(meanings(name, known, set()))
        for one in found:
            alike = {other for other in found if MEANING[other] == MEANING[one]} - {one}
            assert all({one, other} in SYNONYMS for other in alike), f"{name}: {one}, {alike}"


def test_filters_compared_side_by_side_differ():
    filters = (
        "plain", "anchored", "two anchors", "first estimates", "anchored, first estimates",
        "ideal", "rule", "expected", "error",
    )  # fmt: skip
    assert len({MEANING[name] for name in filters}) == len(filters)
    assert MEANING["external"] not in {MEANING[name] for name in filters if name != "two anchors"}

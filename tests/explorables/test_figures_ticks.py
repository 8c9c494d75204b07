"""Kept ticks: whatever was drawn before, a picture is that of a figure that was never drawn on."""

import io
from collections.abc import Callable

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axis import Tick
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from explorables.figures import figure, to_html, to_svg
from explorables.figures.style import BLUE, RED
from explorables.figures.svg import _NUMBER, HEAVY, _Renderer
from explorables.figures.ticks import MOST_KEPT, checked, settings

Change = Callable[[object], object]

CHANGES: dict[str, Change] = {
    "wider": lambda ax: ax.set_xlim(-3, 12),
    "upside down": lambda ax: ax.set_ylim(4, -1),
    "large numbers": lambda ax: ax.set_ylim(1_000_000.001, 1_000_000.002),
    "logarithm": lambda ax: ax.set(yscale="log", ylim=(0.01, 300)),
    "less than a power of ten": lambda ax: ax.set(yscale="log", ylim=(2, 9)),
    "square": lambda ax: ax.set_aspect("equal"),
    "given places": lambda ax: ax.set_xticks([0, 0.25, 1]),
    "given labels": lambda ax: ax.set_xticks([0, 0.25, 1], ["none", "a quarter", "all"]),
    "coloured labels": lambda ax: ax.set_xticks([0, 1], ["none", "all"], color=RED),
    "formula": lambda ax: ax.set_yticks([0, 1], ["0", r"$\sigma^2$"]),
    "no ticks": lambda ax: ax.set_yticks([]),
    "no minor ticks": lambda ax: ax.minorticks_off(),
    "minor ticks": lambda ax: ax.minorticks_on(),
    "few ticks": lambda ax: ax.locator_params(nbins=3),
    "no labels": lambda ax: ax.tick_params(labelbottom=False),
    "ticks on top": lambda ax: ax.xaxis.tick_top(),
    "large labels": lambda ax: ax.tick_params(labelsize=13, length=9),
    "no grid": lambda ax: ax.grid(False),
    "label": lambda ax: ax.set(xlabel="time / s", ylabel="x / m"),
    "label as a formula": lambda ax: ax.set_xlabel(r"$\sigma$"),
    "label far away": lambda ax: ax.set_xlabel("x", labelpad=30),
    "label on top": lambda ax: (ax.set_xlabel("x"), ax.xaxis.set_label_position("top")),
    "title": lambda ax: ax.set_title("A title"),
    "spine outside": lambda ax: ax.spines["left"].set_position(("outward", 12)),
    "no axis": lambda ax: ax.set_axis_off(),
    "no abscissa": lambda ax: ax.xaxis.set_visible(False),
    "ticks' markers": lambda ax: ax.plot([0.5], [0.5], "|", color="#5b6470", markersize=3.5),
    "one label by hand": lambda ax: ax.get_xticklabels()[0].set_color(RED),
    "moved": lambda ax: ax.set_position([0.3, 0.3, 0.5, 0.5]),
}
"""What a drawing may do to its axes."""


def drawn_on(axes: np.ndarray, names: list[str]) -> None:
    """Clear axes and draw on the first what some changes say, on the second a line."""
    for ax in axes:
        ax.clear()
        ax.plot([0, 1], [0.5, 1], color=BLUE)
    for name in names:
        CHANGES[name](axes[0])


def fresh(names: list[str], rows: int, cols: int) -> str:
    """Return what some changes make of a new figure."""
    fig, axes = figure(rows, cols, height=5)
    drawn_on(axes, names)
    return to_html(fig, prefix="x")


LASTING = {"square", "no labels", "ticks on top", "large labels", "no abscissa", "moved"}
"""Changes that clearing does not take back."""


@pytest.mark.parametrize(("rows", "cols"), [(2, 1), (1, 2)])
def test_a_picture_does_not_depend_on_those_before(rows, cols):
    rng = np.random.default_rng(rows)
    names = sorted(CHANGES.keys() - LASTING)
    states = [rng.choice(names, rng.integers(0, 4), replace=False).tolist() for _ in range(8)]
    expected = [fresh(state, rows, cols) for state in states]
    assert len(set(expected)) > 6
    fig, axes = figure(rows, cols, height=5)
    for place in [*range(8), *rng.integers(0, 8, 12)]:
        drawn_on(axes, states[place])
        assert to_html(fig, prefix="x") == expected[place], states[place]


@pytest.mark.parametrize("name", CHANGES)
def test_each_change_is_seen_and_seen_again(name):
    fig, axes = figure(2, 1, height=5)
    expected = {False: fresh([], 2, 1), True: fresh([name], 2, 1)}
    assert (expected[True] != expected[False]) == (name != "no minor ticks")
    for changed in (False, True, True, *([] if name in LASTING else [False, True])):
        drawn_on(axes, [name] if changed else [])
        assert to_html(fig, prefix="x") == expected[changed]


def test_a_change_without_clearing_is_seen():
    fig, ax = figure()
    seen = {to_svg(fig, prefix="x")}
    for name in ("wider", "few ticks", "large labels", "label", "title", "moved", "spine outside"):
        CHANGES[name](ax)
        seen.add(to_svg(fig, prefix="x"))
        assert to_svg(fig, prefix="x") in seen
    fig.set_size_inches(4, 3)
    assert to_svg(fig, prefix="x") not in seen
    assert len(seen) == 8


def test_settings_of_matplotlib_are_seen():
    fig, ax = figure()
    before = to_svg(fig, prefix="x")
    with mpl.rc_context({"xtick.direction": "in", "ytick.major.pad": 9.0}):
        ax.clear()
        inside = to_svg(fig, prefix="x")
        assert inside == to_svg(figure()[0], prefix="x") != before
    ax.clear()
    assert to_svg(fig, prefix="x") == before


@pytest.fixture
def ticks_drawn(monkeypatch) -> list[Tick]:
    """Return the ticks that are drawn from now on."""
    drawn: list[Tick] = []
    draw = Tick.draw
    monkeypatch.setattr(Tick, "draw", lambda self, *args: (drawn.append(self), draw(self, *args)))
    return drawn


def test_ticks_are_drawn_once(ticks_drawn):
    fig, ax = figure()
    for slope in (1.0, 0.8, 0.6):
        ax.clear()
        ax.plot([0, 1], [0, slope])
        ax.set(xlim=(0, 1), ylim=(0, 1), xlabel="x", title=f"slope {slope}")
        to_svg(fig, prefix="x")
        if slope == 1.0:
            first = len(ticks_drawn)
    assert len(ticks_drawn) == first > 8


def test_a_page_has_the_same_text_as_without_memory(ticks_drawn):
    fig, _ = figure(1, 2)
    once = to_html(fig)
    to_html(fig, prefix="x")
    count = len(ticks_drawn)
    assert to_html(fig) == once  # the identifiers of a page are a hash of all that is written
    assert len(ticks_drawn) == count + count // 2


def test_memory_has_an_end():
    fig, ax = figure()
    for right in range(1, 2 * MOST_KEPT):
        ax.set_xlim(0, right)
        to_svg(fig, prefix="x")
    assert 0 < len(ax.xaxis._drawn) <= MOST_KEPT


def test_settings_are_those_of_matplotlib_and_are_put_back():
    values = {"axes.labelsize": "10", "font.family": "serif", "axes.grid": "on"}
    before = dict(mpl.rcParams)
    with mpl.rc_context(values):
        expected = dict(mpl.rcParams)
    with settings(checked(values)):
        assert dict(mpl.rcParams) == expected != before
    assert dict(mpl.rcParams) == before
    with pytest.raises(ValueError, match="labelsize"):
        checked({"axes.labelsize": "ten"})


def paths() -> list[Path]:
    """Return paths of all kinds: ragged, on a grid of twentieths, smooth, with gaps, curved."""
    rng = np.random.default_rng(0)
    walk = 150 + np.cumsum(rng.normal(size=(300, 2)), axis=0)
    gaps = walk.copy()
    gaps[[3, 40, 41]] = np.nan
    steps = np.arange(400.0)
    return [
        Path(rng.uniform(-50, 450, (200, 2))),
        Path(rng.integers(-100, 8000, (400, 2)) / 20),
        Path(np.column_stack([steps, 150 + 50 * np.sin(steps / 9)])),
        Path(walk, closed=True),
        Path(gaps),
        Path(np.array([[-0.04, 0.04], [-0.06, 0.06], [1e-9, 300.0]])),
        Path.unit_circle().transformed(Affine2D().scale(90).translate(100, 100)),
        Path(np.empty((0, 2))),
        Path(np.full((4, 2), np.nan)),
        Path(np.array([[-90.0, -90.0], [-80.0, -85.0], [-70.0, -90.0]])),
    ]


@pytest.mark.parametrize("path", paths())
@pytest.mark.parametrize("simplify", [False, True])
@pytest.mark.parametrize("clip", [False, True])
def test_paths_are_written_as_if_shortened_afterwards(path, simplify, clip):
    renderer = _Renderer(403.2, 244.8, io.StringIO())
    flip = Affine2D().scale(1, -1).translate(0, 244.8)
    long = RendererSVG._convert_path(renderer, path, flip, clip, simplify)
    shortened = _NUMBER.sub(lambda n: f"{float(n[0]):.1f}".removesuffix(".0"), long)
    assert renderer._convert_path(path, flip, clip, simplify) == shortened


def test_a_drawing_is_heavy_with_all_its_decimals():
    fig, ax = figure()
    line = ax.plot(*np.random.default_rng(0).uniform(size=(2, 10_000)))[0]
    line.get_path().should_simplify = False
    ax.set(xlim=(0, 1), ylim=(0, 1))
    for count, heavy in ((HEAVY // 28, False), (HEAVY // 22, True)):
        line.set_data(*np.random.default_rng(0).uniform(0.4, 0.6, size=(2, count)))
        line.get_path().should_simplify = False
        svg = to_svg(fig)
        assert len(svg) < 0.7 * HEAVY
        assert ("data:image/png" in svg) == heavy

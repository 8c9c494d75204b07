"""The explorers of the chapter "Tracking a pattern"."""

from functools import partial

from robot_perception.chapters.pattern_tracking import figures as draw
from robot_perception.chapters.pattern_tracking import views
from robot_perception.chapters.pattern_tracking.hidden import SHARES, TOLERANCES
from robot_perception.chapters.pattern_tracking.scene import START
from robot_perception.teaching.controls import Drag, choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.9}


def middle(dx: int, dy: int, spread: float, particles: int) -> tuple[float, float]:
    """Return where the pattern is."""
    return float(START[0] + dx), float(START[1] + dy)


displaced = Exploration(
    draw.moving,
    views.sought,
    views.Sought.words,
    controls={
        "dx": slider("Moved to the right", (-25, -15, -5, 5, 15, 25), 5, "px"),
        "dy": slider("Moved down", (-12, 0, 12), 0, "px"),
        "spread": slider("σ of the walk", (2.5, 5.0, 10.0), 5.0, "px"),
        "particles": choice("Particles", {"200": 200, "2000": 2000}, 200),
    },
    name="pattern-displaced",
    caption="One step. Dotted: the pattern. Solid: the estimate. Dots: places that particles try, "
    "drawn by the random walk about where the pattern was. θ and s are tried, too, with spreads in "
    "the same proportion.",
    presets={
        "three σ": {"dx": 15},
        "five σ": {"dx": 25},
        "five σ, a wider walk": {"dx": 25, "spread": 10.0},
        "five σ, a wider walk, more particles": {"dx": 25, "spread": 10.0, "particles": 2000},
    },
    axes=partial(figure, width=5.2, height=4.3, gridspec_kw=_PHOTO),
    finding=lambda state: state.error,
    drag=Drag(("dx", "dy"), "the pattern", middle),
)

POINTS = tuple(range(0, 120, 3))
"""Points of the pattern that can be picked."""


def point(at: int) -> tuple[float, float]:
    """Return where a point of the pattern is, in the picture on the left."""
    x, y = views.vector(at).points[at]
    return float(x), float(y)


slopes = Exploration(
    draw.falling,
    views.vector,
    views.Vector.words,
    controls={"at": slider("Point", POINTS, POINTS[8])},
    name="pattern-slope",
    caption="Left: the pattern's points, and across one of them the line on which eleven grey "
    "values are taken. Middle: these. Right: their correlation with those beside them, and the "
    "line that is fitted to its fall: from a correlation it tells a deviation.",
    presets={"another point": {"at": POINTS[20]}, "the last": {"at": POINTS[-1]}},
    axes=partial(figure, 1, 3, width=8.0, height=2.9),
    finding=lambda state: state.rate,
    drag=Drag(("at",), "the point", point),
)

hides = Exploration(
    draw.covering,
    views.hidden,
    views.Hidden.words,
    controls={
        "share": slider("Covered", SHARES, 0.3),
        "tolerance": choice("Bad vectors", {name: name for name in TOLERANCES}, "left out"),
        "side": choice("From", {"right": 0, "below": 1, "left": 2, "above": 3}, 0),
    },
    name="pattern-hidden",
    caption="Dotted: the pattern, which has moved by half a σ or so. Solid: the estimate, of "
    "3000 particles. Green points: vectors whose deviation is below the threshold. Magenta: bad "
    "ones. 30 % of them are tolerated.",
    presets={
        "nothing covered": {"share": 0.0},
        "60 %, none tolerated": {"share": 0.6, "tolerance": "none"},
        "60 %, left out": {"share": 0.6},
        "60 %, counted as the threshold": {"share": 0.6, "tolerance": "at worst"},
    },
    axes=partial(figure, width=5.2, height=4.3, gridspec_kw=_PHOTO),
    finding=lambda state: (float((~state.good).mean()), state.error, state.lost),
)

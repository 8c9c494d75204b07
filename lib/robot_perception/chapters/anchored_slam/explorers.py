"""The explorers: the world turned and moved, references on the rail, robots with anchors."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.anchored_slam import figures as draw
from robot_perception.chapters.anchored_slam import gauge, rails
from robot_perception.chapters.anchored_slam.mrclam import UTIAS, Robots
from robot_perception.chapters.monobot import rail
from robot_perception.teaching.controls import Drag, choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

# Worlds moved ------------------------------------------------------------------------------------


def describe(world: gauge.MovedWorld) -> str:
    """Return the words for a reader who does not see the moved world."""
    turned = world.direction.startswith("turn")
    by = f"{15 * world.amount:g}°" if turned else f"{world.amount:g} m"
    heading = f", heading {np.degrees(world.radians):.0f}°" if world.radians > 0 else ""
    return (
        f"Robot and landmarks, grey, and again in blue after a {world.direction} by {by}. Sensors: "
        f"{world.sensing}. The largest residual is {world.metres:.2f} m{heading}."
    )


def turned(degrees: float) -> gauge.MovedWorld:
    """Return the world turned about the anchor."""
    return gauge.move_world("one anchor", gauge.TURN, degrees / 15)


def last_pose(degrees: float) -> tuple[float, float]:
    """Return where the robot of the turned world is last."""
    x, y, _ = turned(degrees).moved_poses[-1]
    return float(x), float(y)


TURNED = Exploration(
    draw.moved_world,
    turned,
    describe,
    {"degrees": slider("Turn by", (-30, -20, -10, 0, 10, 20, 30), 30, "°")},
    name="turned-world",
    caption="Grey: one world. Blue: the same, turned about the anchor (square), all measurements "
    "taken again; triangles: the robot. Drag its last pose. In which of the two is the robot?",
    axes=partial(figure, width=5.4, height=4.9),
    drag=Drag(("degrees",), "the robot", last_pose),
    finding=lambda world: world.residual,
)

MOVED = Exploration(
    draw.moved_world,
    gauge.move_world,
    describe,
    {
        "sensing": choice("Sensors", (*gauge.SETS, gauge.AT_REST), "one anchor"),
        "direction": choice("Move the world", gauge.DIRECTIONS, "shift in x"),
        "amount": choice(
            "By", {f"{m} m, or {15 * m}°".replace("-", "−"): m for m in (-2, -1, 1, 2)}, 1
        ),
    },
    name="moved-world",
    caption="Grey: the world; blue: the world moved, all measurements taken again; triangles: the "
    "robot. Magenta: what no longer fits, drawn from where a measurement asks a known thing to be "
    "to where it is.",
    presets={
        "one anchor, turned about it": {"direction": gauge.TURN},
        "two anchors": {"sensing": "two anchors", "direction": gauge.TURN},
        "anchor and compass": {"sensing": "anchor + compass", "direction": gauge.TURN},
        "position sensor": {"sensing": "position sensor", "direction": "turn about the robot"},
        "robot at rest": {"sensing": gauge.AT_REST, "direction": "turn about the robot"},
    },
    axes=partial(figure, width=5.4, height=4.9),
    finding=lambda world: world.residual,
)


# References on the rail --------------------------------------------------------------------------

THIRTY = replace(rail.FIG4, runs=30)


def refer(reference: rail.Kind, deviation: float, offset: float) -> rail.Result:
    """Return what a reference that stands off does, in m; all in the same worlds, erring alike."""
    setting = {"reference": reference, "reference_deviation": deviation, "misplaced": offset}
    config, rng = replace(THIRTY, **setting), np.random.default_rng(7)
    world, own = rail.simulate(config, rng=rng), np.random.default_rng(rng.integers(2**32))
    return rail.Result(config, world, rails.refilter(config, world, rng=own))


REFERENCES = Exploration(
    draw.fan_and_gains,
    refer,
    "Landmark errors of thirty runs inside the stated ±2σ, and the gains below.",
    {
        "reference": choice("Reference", ("none", *rail.SIGNS), "anchor"),
        "deviation": slider("σ of the reference", (0.02, 0.1, 0.5), 0.1, "m"),
        "offset": slider("It stands off by", (0.0, 0.1, 0.3), 0.0, "m"),
    },
    name="misplaced-references",
    caption="Thirty runs in the world of Fig. 4. Above: landmark errors, grey ±2σ as stated. "
    "Below: gains on the landmark's own innovation. When is the filter sure and wrong?",
    presets={
        "no reference": {"reference": "none"},
        "a good anchor": {"deviation": 0.02},
        "an anchor 10 cm off": {"offset": 0.1},
        "a camera 30 cm off": {"reference": "external sensor", "offset": 0.3},
    },
    axes=partial(figure, 2, 1, height=5.0),
    finding=lambda result: result.last_errors,
)


# Robots with anchors -----------------------------------------------------------------------------


@cache
def _robots() -> Robots:
    return UTIAS.read().result


def _path(ax: Axes, chosen: tuple[int, int]) -> None:
    draw.robot_path(ax, _robots(), *chosen)


def _error(chosen: tuple[int, int]) -> float:
    return _robots().errors["lasting"].ate[chosen[0] - 1, chosen[1]]


ANCHORS = slider("Anchors", (0, 1, 2), 1)

ROBOT_2 = Exploration(
    _path,
    lambda anchors: (2, anchors),
    "Path of robot 2 by the filter and by motion capture, with posts and their ellipses.",
    {"anchors": ANCHORS},
    name="robot-2",
    caption="Robot 2 and its map beside motion capture; ellipses 95 %. With one anchor the map is "
    "held at one point, and hangs askew.",
    presets={"no anchor": {"anchors": 0}, "two anchors": {"anchors": 2}},
    axes=partial(figure, width=5.6, height=6.2),
    finding=_error,
)

FIVE = Exploration(
    _path,
    lambda robot, anchors: (robot, anchors),
    "Path of one robot by the filter and by motion capture, with posts and their ellipses.",
    {"robot": slider("Robot", (1, 2, 3, 4, 5), 2), "anchors": ANCHORS},
    name="five-robots",
    caption="Each robot's path and map beside motion capture; ellipses 95 %. Anchors: none, the "
    "post seen first, or that and the one farthest from it.",
    presets={"robot 2, two anchors": {"anchors": 2}, "robot 5, none": {"robot": 5, "anchors": 0}},
    axes=partial(figure, width=5.6, height=6.2),
    finding=_error,
)

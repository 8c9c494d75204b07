"""The explorers: what a filter is given, noise and length, anchors, one drive."""

from functools import partial

import numpy as np

from robot_perception.chapters.loop_closing import building, posts, states
from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.chapters.loop_closing.states import Nailed, Played
from robot_perception.teaching.controls import Drag, choice, slider, timeline
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure


def describe_built(made: building.Built) -> str:
    """Return what a map shows, in words."""
    return (
        f"Map of a ring of corridors, drawn by a filter that is given {made.given} and starts "
        f"{'exactly known' if made.case.start == 'exact' else 'uncertain'}; at the end it is "
        f"{made.off:.2f} m off and has {made.twice} landmarks twice."
    )


BUILT = Exploration(
    draw.built_map.on,
    building.built,
    describe_built,
    {
        "given": choice("The filter is given", tuple(building.GIVEN), "an anchor"),
        "start": choice("Start", {"exact": "exact", "10 cm and 3° (1σ)": "uncertain"}, "exact"),
    },
    name="loop-given",
    caption="The same drive with one thing more; colours as above, cross: anchor. A loop that "
    "closes shows as a jump of the red path at its end and as green landmarks on the true walls; "
    "readings stay where they were drawn.",
    presets={
        "the names": {"given": "the names"},
        "a sensor of the position": {"given": "a sensor of the position"},
        "names, uncertain start": {"given": "the names", "start": "uncertain"},
        "and an anchor": {"given": "the names and an anchor", "start": "uncertain"},
    },
    axes=partial(figure, width=6.4, height=4.6),
    finding=lambda made: made.off,
)


def describe_growth(result: posts.Result) -> str:
    """Return what noise and loop length do, in words."""
    parts = [
        f"{name}: at most {runs.rms.max():.2f} m, {runs.rms[-1]:.2f} m at the "
        f"end, NEES {runs.nees.mean():.1f}"
        for name, runs in result.runs.items()
    ]
    length = result.config.length
    return f"Errors and NEES along a loop of {length:g} m. " + "; ".join(parts) + "."


GROWTH = Exploration(
    lambda axes, result: draw.growth.on(axes, result, states.growth_reach()),
    states.growth,
    describe_growth,
    {
        "noise": slider("Noise", states.NOISES, 3.0, "× small"),
        "length": slider("Loop", states.LENGTHS, 90.0, "m"),
    },
    name="loop-growth",
    caption="Posts along a loop, start uncertain, eight runs. Above: root mean square error. "
    "Below: average NEES, grey the 95 % band if honest.",
    presets={"quiet": {"noise": 0.3}, "rough and long": {"noise": 6.0, "length": 120.0}},
    axes=partial(figure, 2, 1, height=5.6, gridspec_kw={"right": 0.72}),
    finding=lambda result: {name: runs.rms.max() for name, runs in result.runs.items()},
)


def describe_nailed(state: Nailed) -> str:
    """Return what anchors do, in words."""
    runs = state.runs
    return (
        f"Loop with {len(state.anchors)} known posts; the position error is at most "
        f"{runs.rms.max():.2f} m and {runs.rms[-1]:.2f} m at the end, that of the heading "
        f"{runs.rms_heading[-1]:.1f}°."
    )


def first_anchor(count: int, place: float) -> tuple[float, float] | None:
    """Return where the first anchor is, if there is one."""
    if not count:
        return None
    state = states.nailed(count, place)
    x, y = state.config.world[0][state.anchors[0]]
    return float(x), float(y)


ANCHORS = Exploration(
    draw.nailed,
    states.nailed,
    describe_nailed,
    {
        "count": slider("Anchors", (0, 1, 2), 1),
        "place": slider("First anchor at", states.PLACES, 0, "m along the loop"),
    },
    name="loop-anchors",
    caption="Anchors on the loop, first estimates, start uncertain. Above: 2σ of the position "
    "along one run; cross: anchor (drag it). Below: errors over eight runs, root mean square.",
    presets={"none": {"count": 0}, "a third round": {"place": 30}, "two": {"count": 2}},
    axes=partial(figure, 2, 1, width=6.4, height=7.0),
    drag=Drag(("place",), "the first anchor", first_anchor),
    finding=lambda state: float(np.sqrt(np.mean(state.runs.rms**2))),
)


def _moment(variant: str, time: int) -> tuple[Played, int]:
    return states.play(variant), time


def describe_play(state: tuple[Played, int]) -> str:
    """Return what a filter believes at one moment, in words."""
    played, time = state
    step = played.steps[time]
    return (
        f"The {played.case.variant} filter after {step * played.config.step:.0f} m, with "
        f"{len(played.history.kept[step].landmarks)} landmarks in the map: {played.off(time):.2f} "
        f"m off; the 2σ ellipse of the robot reaches {played.ellipse(time):.2f} m."
    )


PLAY = Exploration(
    lambda ax, state: draw.moment(ax, *state),
    _moment,
    describe_play,
    {
        "variant": choice("Filter", ("plain", "anchored", "external"), "plain"),
        "time": timeline("Time", range(states.FRAMES), 24, fps=6),
    },
    name="loop-belief",
    caption="Posts (dots) along a loop of 90 m, names known, rough noise, start uncertain. "
    "Ellipses 2σ, of the robot and of every post in its map. Dashed: the true path; cross: "
    "the anchor.",
    presets={
        "just before": {"time": 33},
        "just after": {"time": 35},
        "with the anchor": {"variant": "anchored"},
        "watched from outside": {"variant": "external"},
    },
    axes=partial(figure, width=6.4, height=4.8),
    finding=lambda state: state[0].ellipse(state[1]),
)

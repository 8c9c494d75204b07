"""The explorers of the chapter: one run, vehicle and landmark, the factors of Fig. 4."""

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from robot_perception.chapters.monobot import figures as draw
from robot_perception.chapters.monobot import information, rail, steady
from robot_perception.chapters.monobot.information import Plane
from robot_perception.chapters.monobot.rail import FIG4, Result
from robot_perception.teaching.controls import choice, slider, timeline, toggle
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure
from robot_perception.teaching.figures.style import AxesRow

# One run ---------------------------------------------------------------------------------------


@cache
def watched(landmarks: int, known: bool, shape: str) -> Result:
    """Return the ten runs of a setting; all settings have the same noise draws."""
    start = 0.0 if known else FIG4.start_deviation
    config = replace(FIG4, runs=10, landmarks=landmarks, start_deviation=start, shape=shape)
    return rail.run(config, rng=np.random.default_rng(11))


def draw_run(axes: AxesRow, state: tuple[Result, int]) -> None:
    """Draw path and landmark error of one run, on scales that all states share."""
    draw.one_run(axes, *state)
    axes[0].set(ylim=(-2.6, 1.7))
    axes[1].set(ylim=(-0.32, 0.32))


def describe_run(state: tuple[Result, int]) -> str:
    """Return from where to where errors and band go, in words."""
    result, run = state
    first, last = result.landmark_errors[run, [0, -1]]
    before, after = 2 * result.deviations[[0, -1], 1]
    if first.size == 1:
        errors = f"the landmark error goes from {first[0]:+.2f} m to {last[0]:+.2f} m"
    else:
        errors = f"ten landmark errors, {_span(first)} at first, are {_span(last)} in the end"
    moving = "at rest" if result.config.shape == "at rest" else "swinging"
    start = "uncertain" if result.config.start_deviation else "known"
    return (
        f"Run {run + 1}, the robot {moving}, its start {start}: {errors}, and the band of two "
        f"deviations from {before:.2f} m to {after:.2f} m."
    )


def _span(errors: np.ndarray) -> str:
    return f"between {errors.min():+.2f} m and {errors.max():+.2f} m"


one_run = Exploration(
    draw_run,
    lambda run, **setting: (watched(**setting), int(run) - 1),
    describe_run,
    caption="Above: path of the robot and place of the landmark, true (uncoloured) and estimated "
    "(red and green); blue dots: single measurements. Below: landmark error; dot: after the first "
    "measurement. Bands are ±2σ as the filter states them.",
    controls={
        "run": slider("Run", range(1, 11), 1),
        "landmarks": choice("Landmarks", (1, 10), 1),
        "known": toggle("Start known exactly"),
        "shape": choice("Robot", {"moving": "sine", "at rest": "at rest"}, "sine"),
    },
    presets={
        "another run": {"run": 4},
        "ten landmarks": {"run": 5, "landmarks": 10},
        "known and at rest": {"run": 5, "known": True, "shape": "at rest"},
    },
    axes=partial(figure, 2, 1, height=5.2),
    finding=lambda state: state[0].deviations[:, 1],
)


# Vehicle and landmark --------------------------------------------------------------------------


@cache
def planes(anchored: bool) -> list[Plane]:
    """Return what is known after each measurement of one run."""
    return information.planes(anchored=anchored, rng=np.random.default_rng(3))


def describe_plane(plane: Plane) -> str:
    """Return what the measurements allow and what the filter states, in words."""
    vehicle, landmark = 2 * np.sqrt(np.diagonal(plane.belief.cov))
    region = "an ellipse" if plane.anchored and plane.measurements else "a strip along the diagonal"
    return (
        f"After {plane.measurements} more measurements "
        f"{'with' if plane.anchored else 'without'} an anchor: they allow {region}. The filter's "
        f"ellipse lies inside and touches it or nearly so; its two deviations are {vehicle:.2f} m "
        f"for the vehicle and {landmark:.2f} m for the landmark."
    )


plane = Exploration(
    draw.plane,
    lambda measurements, anchored: planes(anchored)[int(measurements)],
    describe_plane,
    caption="One run at $P_0 = V = W = 1$ m². Outside: what the measurements allow, by "
    "$\\mathbf Y$. Inside: the filter's ellipse. Both 2σ.",
    controls={
        "measurements": timeline(
            "Measurements after the first", (0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89), 3
        ),
        "anchored": toggle("One more landmark is an anchor"),
    },
    presets={
        "34 measurements": {"measurements": 34},
        "34 measurements, with an anchor": {"measurements": 34, "anchored": True},
    },
    axes=partial(figure, width=5.0, height=4.4),
    finding=lambda plane: plane,
)


# The factors of Fig. 4 -------------------------------------------------------------------------


def studied(**setting: Any) -> Result:
    """Return eight runs of Fig. 4 with other factors."""
    return rail.run(replace(FIG4, runs=8, **setting), rng=np.random.default_rng(1))


def describe_study(result: Result) -> str:
    """Return from where to where band and gain go, in words."""
    before, after = 2 * result.deviations[[0, -1], 1]
    gain = result.gains[[0, -1], 1]
    return (
        f"Landmark errors of eight runs; the band of two deviations goes from {before:.2f} m to "
        f"{after:.2f} m. The gain of the landmark goes from {gain[0]:.2f} to {gain[1]:.2f}."
    )


study = Exploration(
    draw.study,
    studied,
    describe_study,
    caption="Noise as in Fig. 4, eight runs. Left: landmark errors, grey ±2σ as the filter states "
    "them. Right: gains on the landmark's innovation.",
    controls={
        "landmarks": slider("Landmarks", (1, 5, 20), 1),
        "start_deviation": slider("σ of the start", (0.0, 0.1, 0.3), 0.1, "m"),
        "motion_share": slider("σ of a move", (0.1, 0.5), 0.5, "of the command"),
        "measurement_share": slider("σ of a measurement", (0.05, 0.1), 0.05, "of the distance"),
        "shape": choice("Path", {"as in Fig. 4": "sine", "at rest": "at rest"}, "sine"),
    },  # their names are those of `rail.Config`
    presets={
        "lost from the start": {"start_deviation": 0.3},
        "good wheels": {"motion_share": 0.1},
        "twenty landmarks, start known": {"landmarks": 20, "start_deviation": 0.0},
    },
    axes=partial(figure, 1, 2, width=7.4, height=3.4),
    finding=lambda result: steady.expected_persistence(result.config),
)

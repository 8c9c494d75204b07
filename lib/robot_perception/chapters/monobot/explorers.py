"""The explorers of the chapter: states, controls, presets, and the words for each state."""

from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from robot_perception.chapters.monobot import figures as draw
from robot_perception.chapters.monobot import information, rail, steady
from robot_perception.chapters.monobot.figures import AxesRow
from robot_perception.chapters.monobot.information import Plane
from robot_perception.chapters.monobot.rail import FIG4, Config, Result
from robot_perception.teaching.explore import choice, slider, timeline, toggle

PATHS = {"as in Fig. 4": "sine", "at rest": "at rest"}


# One run ---------------------------------------------------------------------------------------

RUN_CONTROLS = {
    "run": slider("Run", range(1, 11), 1),
    "landmarks": choice("Landmarks", (1, 10), 1),
    "known": toggle("Start known exactly"),
    "shape": choice("Robot", {"moving": "sine", "at rest": "at rest"}, "sine"),
}
RUN_PRESETS = {
    "another run": {"run": 4},
    "ten landmarks": {"run": 5, "landmarks": 10},
    "known and at rest": {"run": 5, "known": True, "shape": "at rest"},
}


@cache
def watched(landmarks: int, known: bool, shape: str) -> Result:
    """Return the ten runs of a setting; all settings have the same noise draws."""
    start = 0.0 if known else FIG4.start_deviation
    config = replace(FIG4, runs=10, landmarks=landmarks, start_deviation=start, shape=shape)
    return rail.run(config, rng=np.random.default_rng(11))


def draw_run(axes: AxesRow, run: int, **setting: Any) -> None:
    """Draw path and landmark error of one run, on scales that all states share."""
    draw.one_run(axes, watched(**setting), run - 1)
    axes[0].set(ylim=(-2.6, 1.7))
    axes[1].set(ylim=(-0.32, 0.32))


def describe_run(run: int, **setting: Any) -> str:
    """Return the alternative text of a state."""
    result = watched(**setting)
    first, last = result.landmark_errors[run - 1, [0, -1]]
    before, after = 2 * result.deviations[[0, -1], 1]
    if first.size == 1:
        errors = f"the landmark error goes from {first[0]:+.2f} m to {last[0]:+.2f} m"
    else:
        errors = f"ten landmark errors, {_span(first)} at first, are {_span(last)} in the end"
    return (
        f"Run {run}, the robot {'at rest' if setting['shape'] == 'at rest' else 'swinging'}, its "
        f"start {'known' if setting['known'] else 'uncertain'}: {errors}, and the band of two "
        f"deviations from {before:.2f} m to {after:.2f} m."
    )


def _span(errors: np.ndarray) -> str:
    return f"between {errors.min():+.2f} m and {errors.max():+.2f} m"


# Vehicle and landmark --------------------------------------------------------------------------

PLANE_CONTROLS = {
    "measurements": timeline(
        "Measurements after the first", (0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89), 3
    ),
    "anchored": toggle("One more landmark is an anchor"),
}
PLANE_PRESETS = {
    "34 measurements": {"measurements": 34},
    "34 measurements, with an anchor": {"measurements": 34, "anchored": True},
}


@cache
def planes(anchored: bool) -> list[Plane]:
    """Return what is known after each measurement of one run."""
    return information.planes(anchored=anchored, rng=np.random.default_rng(3))


def draw_plane(ax: Axes, measurements: int, anchored: bool) -> None:
    """Draw the filter's ellipse in the region that the measurements allow."""
    draw.plane(ax, planes(anchored)[measurements])


def describe_plane(measurements: int, anchored: bool) -> str:
    """Return the alternative text of a state."""
    vehicle, landmark = 2 * np.sqrt(np.diagonal(planes(anchored)[measurements].belief.cov))
    region = "an ellipse" if anchored and measurements else "a strip along the diagonal"
    return (
        f"After {measurements} more measurements {'with' if anchored else 'without'} an anchor: "
        f"they allow {region}. The filter's ellipse lies inside and touches it or nearly so; its "
        f"two deviations are {vehicle:.2f} m for the vehicle and {landmark:.2f} m for the landmark."
    )


# The factors of Fig. 4 -------------------------------------------------------------------------

STUDY_CONTROLS = {
    "landmarks": slider("Landmarks", (1, 5, 20), 1),
    "start_deviation": slider("σ of the start", (0.0, 0.1, 0.3), 0.1, "m"),
    "motion_share": slider("σ of a move", (0.1, 0.5), 0.5, "of the command"),
    "measurement_share": slider("σ of a measurement", (0.05, 0.1), 0.05, "of the distance"),
    "shape": choice("Path", PATHS, "sine"),
}
"""Controls over the settings of a study; their names are those of :class:`.rail.Config`."""

STUDY_PRESETS = {
    "lost from the start": {"start_deviation": 0.3},
    "good wheels": {"motion_share": 0.1},
    "twenty landmarks, start known": {"landmarks": 20, "start_deviation": 0.0},
}


def draw_study(axes: AxesRow, **setting: Any) -> None:
    """Draw errors and gains of eight runs, on scales that all states share."""
    draw.study(axes, rail.run(_studied(setting), rng=np.random.default_rng(1)))
    axes[0].set(ylim=(-0.9, 0.9))
    axes[1].set(ylim=(-0.45, 0.65))


def describe_study(**setting: Any) -> str:
    """Return the alternative text of a state."""
    config = _studied(setting)
    before, after = 2 * rail.covariances(config).deviations[0, [0, -1], 1]
    gain = rail.covariances(config).gains[0, [0, -1], 1, 0]
    return (
        f"Landmark errors of eight runs; the band of two deviations goes from {before:.2f} m to "
        f"{after:.2f} m. The gain of the landmark goes from {gain[0]:.2f} to {gain[1]:.2f}."
    )


def persistences(**fixed: Any) -> list[float]:
    """Return :func:`.steady.expected_persistence` of all states in which some controls are set."""
    every = product(*(control.values for control in STUDY_CONTROLS.values()))
    states = (dict(zip(STUDY_CONTROLS, values, strict=True)) for values in every)
    return [
        steady.expected_persistence(_studied(state))
        for state in states
        if all(state[name] == value for name, value in fixed.items())
    ]


def _studied(setting: dict[str, Any]) -> Config:
    return replace(FIG4, runs=8, **setting)

"""What the explorers of the chapter can show: controls, presets, and the states they are read from.

A preset is neither the default nor an empty picture; what the chapter finds holds in all states.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robot_perception.chapters.walls import office, splitting
from robot_perception.chapters.walls.office import Growing
from robot_perception.chapters.walls.splitting import Step
from robot_perception.teaching.explore import choice, slider, timeline, toggle

KNOB = {
    "presets": {
        "noise eats the walls": {"sigma": 3, "tolerance": 0.05},
        "corners cut off": {"tolerance": 0.8},
        "perfect scanner": {"sigma": 0, "tolerance": 0.02},
    },
    "tolerance": slider("Tolerance ε", splitting.TOLERANCES, splitting.TOLERANCE, "m"),
    "sigma": slider("Noise σ", [0, 0.5, 1.5, 3, 6], 1.5, "cm"),
}
"""The tolerance and the noise of one scan."""

BAND = {
    "presets": {
        "few readings": {"readings": 20},
        "many readings": {"readings": 160},
        "a rough wall": {"readings": 160, "rough": True},
    },
    "readings": slider("Readings", [20, 30, 40, 60, 80, 120, 160], 30),
    "sigma": slider("Noise σ", [0.5, 1, 2, 3, 4], 2, "cm"),
    "rough": toggle("Wall rough by 2 cm", False),
}
"""The search range of a wall."""


def replay(calls: Sequence[Step]) -> dict[str, object]:
    """Return the controls of the replay of a recursion, call by call."""
    closed = next(k for k, call in enumerate(calls, start=1) if not call.split)
    return {
        "presets": {"first chord kept": {"step": closed}, "half way": {"step": len(calls) // 2}},
        "step": timeline("Step", range(1, len(calls) + 1), 1, fps=2),
    }


def growing(frames: Sequence[Growing]) -> dict[str, object]:
    """Return the controls of the map that grows over the scans of a drive."""
    scans = [frame.scans for frame in frames]
    least = {"one scan or more": 1, "three or more": 3, "ten or more": 10}
    return {
        "presets": {
            "first rooms": {"scans": scans[len(scans) // 4]},
            "half way": {"scans": scans[len(scans) // 2]},
            "doubtful walls too": {"least": 1},
        },
        "scans": timeline("Scans", scans, scans[-1], fps=3),
        "least": choice("Walls seen in", least, 3),
    }


def band(readings: float, sigma: float, rough: bool) -> office.SearchRange:
    """Return a state of the explorer of the search range; noise in cm."""
    return office.search_range(int(readings), sigma / 100, 0.99, 0.02 if rough else 0.0)


@dataclass(frozen=True, slots=True)
class Knob:
    """One scan with one tolerance and noise, m.

    How large the tolerance is beside the noise of the readings and their rounding together; how
    many walls are found and how many vertices are kept.
    """

    tolerance: float
    sigma: float
    deviations: float
    walls: int
    vertices: int


def knob_states() -> list[Knob]:
    """Return what is found in every state of the explorer of the tolerance."""
    states = []
    for tolerance in KNOB["tolerance"].values:
        for sigma in (value / 100 for value in KNOB["sigma"].values):
            look = splitting.one_scan(tolerance, sigma)
            deviations = tolerance / float(np.hypot(sigma, splitting.ROUNDING))
            states.append(Knob(tolerance, sigma, deviations, len(look.segments), len(look.kept)))
    return states


@dataclass(frozen=True, slots=True)
class Plateau:
    """Where the number of walls does not depend on the tolerance.

    All ``walls`` are found at every tolerance from ``low`` times the noise up to ``high`` m; at
    ``too_low`` times the noise and below it is ``at_most`` walls, above ``high`` it is ``beyond``.
    """

    walls: int
    low: float
    high: float
    too_low: float
    at_most: int
    beyond: int


def plateau() -> Plateau:
    """Return the range of tolerances in which every state of the explorer has the same walls."""
    states = knob_states()
    most = max(state.walls for state in states)
    largest = max(state.tolerance for state in states)
    inside = [state for state in states if state.tolerance < largest]
    lost = [state for state in inside if state.walls < most]
    too_low = max(state.deviations for state in lost)
    found = [state for state in inside if state.deviations > too_low]
    return Plateau(
        walls=most,
        low=min(state.deviations for state in found),
        high=max(state.tolerance for state in found),
        too_low=too_low,
        at_most=max(state.walls for state in lost),
        beyond=max(state.walls for state in states if state.tolerance == largest),
    )

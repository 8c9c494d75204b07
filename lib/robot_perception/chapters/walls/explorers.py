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
    """What is found in one scan with one tolerance and noise, m.

    ``deviations`` is the tolerance over the noise of the readings and of their rounding together.
    """

    tolerance: float
    sigma: float
    deviations: float
    walls: int
    vertices: int


def knob(tolerance: float, sigma: float) -> Knob:
    """Return a state of the explorer of the tolerance; both in m."""
    scan = splitting.one_scan(tolerance, sigma)
    deviations = tolerance / float(np.hypot(sigma, splitting.ROUNDING))
    return Knob(tolerance, sigma, deviations, len(scan.segments), len(scan.kept))


def knob_states() -> list[Knob]:
    """Return what is found in every state of the explorer of the tolerance."""
    sigmas = [value / 100 for value in KNOB["sigma"].values]
    return [knob(tolerance, sigma) for tolerance in KNOB["tolerance"].values for sigma in sigmas]


def near_the_noise() -> list[Knob]:
    """Return what is found between the steps of the slider, at one to six times the noise."""
    sigmas = [value / 100 for value in KNOB["sigma"].values if value > 0]
    noises = [(sigma, float(np.hypot(sigma, splitting.ROUNDING))) for sigma in sigmas]
    factors = np.arange(1.0, 6.1, 0.25).tolist()
    return [knob(k * noise, sigma) for sigma, noise in noises for k in factors]


@dataclass(frozen=True, slots=True)
class Plateau:
    """Where the walls found do not depend on the tolerance.

    All ``walls`` are found at every tolerance from ``low`` times the noise up to ``high`` m; nearer
    to the noise there are up to ``most``, above ``high`` there are ``beyond``.
    """

    walls: int
    low: float
    high: float
    most: int
    beyond: int


def plateau() -> Plateau:
    """Return the range of tolerances in which the same walls are found at every noise."""
    walls = len(splitting.one_scan().segments)
    *_, high, largest = KNOB["tolerance"].values
    states = [*knob_states(), *near_the_noise()]
    inside = sorted((s for s in states if s.tolerance <= high), key=lambda s: s.deviations)
    last = max(k for k, state in enumerate(inside) if state.walls != walls)
    return Plateau(
        walls=walls,
        low=inside[last + 1].deviations,
        high=high,
        most=max(state.walls for state in inside[: last + 1]),
        beyond=max(state.walls for state in states if state.tolerance == largest),
    )

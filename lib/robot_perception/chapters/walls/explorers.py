"""The explorers of the chapter: tolerance, view point, recursion, search range, map."""

from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from robot_perception.chapters.walls import figures, office, splitting
from robot_perception.chapters.walls.office import Growing, SearchRange
from robot_perception.chapters.walls.splitting import OneScan, Step
from robot_perception.teaching.controls import Drag, choice, slider, timeline, toggle
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure
from robot_perception.teaching.results import kept

# The tolerance and the noise of one scan ---------------------------------------------------------


knob = Exploration(
    lambda ax, scan: figures.scan_state(ax, scan, splitting.one_scan().points),
    lambda tolerance, sigma: splitting.one_scan(tolerance, sigma / 100),
    "One scan with the true faces in grey, the readings in blue, and the simplified chain in "
    "orange.",
    caption="Grey: the true faces. Blue: readings. Orange: the chain that is left of them. The "
    "title counts its vertices, and the walls made of it.",
    controls={
        "tolerance": slider("Tolerance ε", splitting.TOLERANCES, splitting.TOLERANCE, "m"),
        "sigma": slider("Noise σ", [0, 0.5, 1.5, 3, 6], 1.5, "cm"),
    },
    presets={
        "noise eats the walls": {"sigma": 3, "tolerance": 0.05},
        "corners cut off": {"tolerance": 0.8},
        "perfect scanner": {"sigma": 0, "tolerance": 0.02},
    },
    axes=partial(figure, width=4.2, height=4.2),
    finding=lambda scan: scan,
)


@kept
def knob_states() -> tuple[OneScan, ...]:
    """Return what is found in every state of the explorer."""
    return tuple(knob.found())


@kept
def near_the_noise() -> tuple[OneScan, ...]:
    """Return what is found between the steps of the slider, at one to six times the noise."""
    sigmas = [value / 100 for value in knob.controls["sigma"].values if value > 0]
    noises = [(sigma, float(np.hypot(sigma, splitting.ROUNDING))) for sigma in sigmas]
    factors = np.arange(1.0, 6.1, 0.25).tolist()
    return tuple(splitting.one_scan(k * noise, sigma) for sigma, noise in noises for k in factors)


def plateau() -> dict[str, float]:
    """Return the range of tolerances in which the same walls are found at every noise.

    All ``walls`` are found at every tolerance from ``low`` times the noise up to ``high`` m; nearer
    to the noise there are up to ``most``, above ``high`` there are ``beyond``.
    """
    walls = len(splitting.one_scan().segments)
    *_, high, largest = knob.controls["tolerance"].values
    states = [*knob_states(), *near_the_noise()]
    inside = sorted((s for s in states if s.tolerance <= high), key=lambda s: s.deviations)
    last = max(k for k, state in enumerate(inside) if len(state.segments) != walls)
    return {
        "walls": walls,
        "low": inside[last + 1].deviations,
        "high": high,
        "most": max(len(state.segments) for state in inside[: last + 1]),
        "beyond": max(len(state.segments) for state in states if state.tolerance == largest),
    }


# One room from many places -----------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Viewed:
    """A scan from a place, ahead and to the left of the chapter's, m."""

    place: tuple[float, float]
    scan: OneScan


def viewed(x: float, y: float) -> Viewed:
    """Return the scan from a place."""
    return Viewed((x, y), splitting.one_scan(at=(x, y)))


def describe_view(view: Viewed) -> str:
    """Return where the scanner is and what the scan gives, in words."""
    x, y = view.place
    return (
        f"The room from above with the scanner {x:g} m ahead and {y:g} m to the left of where it "
        f"was: its readings in blue, and {len(view.scan.segments)} green walls."
    )


stand = Exploration(
    lambda ax, view: figures.viewed(ax, view.scan, view.place, splitting.one_scan().truth),
    viewed,
    describe_view,
    caption="Drag the scanner (red), which looks to the right. Grey: the true faces. Blue: "
    "readings. Green: the walls made of them; the title counts them.",
    controls={
        "x": slider("Ahead", splitting.PLACES[0], 0.0, "m"),
        "y": slider("Left", splitting.PLACES[1], 0.0, "m"),
    },
    presets={
        "into the gap": {"x": 0.0, "y": 1.5},
        "close to furniture": {"x": 2.5, "y": 1.5},
    },
    axes=partial(figure, width=4.2, height=4.8),
    drag=Drag(("x", "y"), "the scanner"),
    finding=lambda view: len(view.scan.segments),
)


# The recursion, call by call ---------------------------------------------------------------------


@cache
def replay() -> Exploration[tuple[Step, ...]]:
    """Return the explorer of the calls on the opening scan."""
    calls, chain = splitting.asked(), splitting.one_scan().points
    closed = next(k for k, call in enumerate(calls, start=1) if not call.split)
    return Exploration(
        lambda ax, done: figures.recursion_state(ax, chain, done),
        lambda step: calls[: int(step)],
        "One step of the recursion: the stretch under judgement, its chord, its farthest vertex, "
        "and the vertices kept so far.",
        caption="Blue: the stretch under judgement. Orange: its chord, and the vertices kept so "
        "far. Magenta: its farthest vertex, filled if it lies farther than ε and splits the "
        "stretch, hollow if it is near enough.",
        controls={"step": timeline("Step", range(1, len(calls) + 1), 1, fps=2)},
        presets={"first chord kept": {"step": closed}, "half way": {"step": len(calls) // 2}},
        axes=partial(figure, width=4.2, height=4.2),
        finding=lambda done: done[-1],
    )


# The search range of a wall ----------------------------------------------------------------------


def band_of(readings: float, sigma: float, rough: bool) -> SearchRange:
    """Return the search range of a wall; noise in cm."""
    return office.search_range(int(readings), sigma / 100, 0.99, 0.02 if rough else 0.0)


band = Exploration(
    figures.search_range,
    band_of,
    "A wall with its readings, and the band in which the same wall may lie in another scan.",
    caption="Blue: readings. Green: the hypothesis and its 99 % band (2.6σ). Across the wall the "
    "scale is enlarged.",
    controls={
        "readings": slider("Readings", [20, 30, 40, 60, 80, 120, 160], 30),
        "sigma": slider("Noise σ", [0.5, 1, 2, 3, 4], 2, "cm"),
        "rough": toggle("Wall rough by 2 cm", False),
    },
    presets={
        "few readings": {"readings": 20},
        "many readings": {"readings": 160},
        "a rough wall": {"readings": 160, "rough": True},
    },
    axes=partial(figure, height=3.4),
    finding=lambda state: state.half_width,
)


# The map that grows over the scans of a drive ----------------------------------------------------


@cache
def growing() -> Exploration[tuple[Growing, int]]:
    """Return the explorer of the map of the chapter's drive."""
    drive, frames = office.office_run(), {state.scans: state for state in office.growing_map()}
    scans, extent = list(frames), drive.points
    return Exploration(
        lambda ax, state: figures.map_state(ax, *state, extent),
        lambda scans, least: (frames[int(scans)], int(least)),
        "The map after some scans: readings as blue dots, walls as green segments, the robot's "
        "path in red.",
        caption="In the colours of the paper's Fig. 1b: blue the raw readings (thinned), green the "
        f"walls, red the path of the robot. All {len(drive.poses)} scans took "
        f"{drive.seconds:.1f} s on the machine that made this page.",
        controls={
            "scans": timeline("Scans", scans, scans[-1], fps=3),
            "least": choice(
                "Walls seen in", {"one scan or more": 1, "three or more": 3, "ten or more": 10}, 3
            ),
        },
        presets={
            "first rooms": {"scans": scans[len(scans) // 4]},
            "half way": {"scans": scans[len(scans) // 2]},
            "doubtful walls too": {"least": 1},
        },
        axes=partial(figure, height=5.4),
        finding=lambda state: len(state[0].found.seen_in(state[1])),
    )

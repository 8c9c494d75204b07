"""The film of the page: picture, scan, echoes and what the committee knows, by one clock."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_synth.people import LASER_ANGLES
from explorables.figures.films import film
from explorables.figures.style import MEANING, figure
from explorables.media import Shown
from robot_perception.chapters.people_fusion.figures import aggregated
from robot_perception.chapters.people_sensors.figures import (
    Room,
    arcs,
    bodies,
    directions,
    floor,
    heads,
    polar,
)
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import AggregationRules, Hypotheses

FPS = 5
TIMES = np.arange(0.4, 10.4, 1 / FPS).round(2)
"""Times of the frames, s: ten seconds of the session, as fast as they went by."""
WIDTH, HEIGHT = 6.4, 3.3
PLACES = (0.0, 0.04, 0.46, 0.86), (0.55, 0.15, 0.44, 0.78)
"""Places of picture and plan in the frame of the film: left, bottom, width, height."""


@dataclass(frozen=True, eq=False, slots=True)
class Instant:
    """Last reports of the sensors before a time (s), and what the committee then knows.

    The picture is red, green and blue; ranges are m, 0 where nothing came back. Where the people
    are (ahead, to the left, and up to the head, m), and where their bodies are turned (rad).
    """

    time: float
    picture: UInt8[np.ndarray, "height width 3"]
    scan: Float[np.ndarray, "beams"]
    echoes: Float[np.ndarray, "sonars"]
    faces: Float[np.ndarray, "n"]
    hypotheses: Hypotheses
    people: Float[np.ndarray, "p 3"]
    headings: Float[np.ndarray, "p"]


def spread(instants: Sequence[Instant], rules: AggregationRules, person: int, time: float) -> float:
    """Return how well the committee knew at a time how far away somebody is (1σ, m).

    That is of the hypothesis, among those that count as persons, that is nearest in direction.
    """
    instant = instants[int(np.abs(TIMES - time).argmin())]
    ahead, left, _ = instant.people[person]
    known = instant.hypotheses.persons(rules)
    off = np.abs(wrap_angle(known.mean[:, 1] - np.arctan2(left, ahead)))
    return float(np.sqrt(known.cov[off.argmin(), 0, 0]))


def show(instants: Iterable[Instant], room: Room, least: float) -> Shown:
    """Show ten seconds: what the sensors see, and whom the committee knows from a weight on."""
    return film(
        frames(instants, room, least),
        fps=FPS,
        name="people-clock",
        poster=len(TIMES) // 2,
        alt="A round frame of a fisheye camera, in which three heads move along the rim and "
        "green lines follow faces, and the floor plan, in which dots of a laser, arcs of "
        "sonars and red ellipses move with three people. One walks round to the back: a long "
        "wedge becomes a small ellipse when a sonar hears the person, and grows again.",
        caption="Ten seconds, as fast as they went by. Picture: the camera's frame, directions "
        "of faces (green) and the true heads (rings). Plan: the last scan (orange), echoes (thick "
        "blue arcs), the people (discs A, B and C), and the hypotheses after each measurement "
        "(red, 2σ; filled: persons; dotted: too light to count).",
    )


def frames(instants: Iterable[Instant], room: Room, least: float) -> Iterator[Figure]:
    """Yield the frames of the film, all drawn on one figure."""
    fig, axes = figure(1, 2, width=WIDTH, height=HEIGHT)
    for ax, place in zip(axes, PLACES, strict=True):
        ax.set_position(place)
    for instant in instants:
        look(axes[0], instant)
        plan(axes[1], instant, room, least)
        yield fig


def look(ax: Axes, instant: Instant) -> Axes:
    """Draw picture, faces and heads, on axes cleared first."""
    ax.clear()
    ax.imshow(instant.picture)
    directions(ax, instant.faces)
    heads(ax, instant.people)
    ax.set_axis_off()
    return ax


def plan(ax: Axes, instant: Instant, room: Room, least: float) -> Axes:
    """Draw scan, echoes, hypotheses and people from above, on axes cleared first."""
    ax.clear()
    floor(ax, room, 0.3)
    back = instant.scan > 0
    beams = polar(instant.scan[back], LASER_ANGLES[back])
    ax.plot(*beams.T, "o", color=MEANING["laser"], markersize=1.8)
    arcs(ax, instant.echoes)
    bodies(ax, instant.people[:, :2], instant.headings)
    aggregated(ax, instant.hypotheses, least)
    ax.set_title(f"{instant.time:.1f} s")
    return ax

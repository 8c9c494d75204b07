"""Drawings of the chapter: the room from above, and what each sensor says of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from data_synth.people import LASER_ANGLES, SONAR_ANGLES
from data_synth.people.staging import RIG
from explorables.figures import drawn, image_axes
from explorables.figures.maps import dots, lines
from explorables.figures.style import MEANING, label
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.people_sensors.recordings import Pedestrians
from robot_perception.people import legs
from robot_perception.people.places import points
from studies.intervals import Interval

REACH = 3.4  # the drawings show so much around the robot, m
NEAR = 2.9  # and that of somebody who stands there so much
DEVIATIONS = 2.0  # all ellipses and wedges reach so far, standard deviations
NAMES = "ABCDEFGH"  # of the people
BODY, ROBOT = 0.2, 0.25  # radius of what is drawn of a person and of the robot, m
_TURN = np.linspace(0, 2 * np.pi, 65)
CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=-1)
OUT = 0.36  # from the middle of a person to the letter, m
FAR = 10.0  # what is further away lies outside of the drawing of a real scan, m
FARTHEST = 3.5  # beyond that hardly anybody stands, and a share of them says little, m


# The room ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """Things in a room, ahead and to the left of the robot, m.

    Walls and furniture at the height of the laser, tops of tables, and round things with their
    radius.
    """

    walls: Float[np.ndarray, "f 2 2"]
    tops: Float[np.ndarray, "t 2 2"]
    posts: Float[np.ndarray, "c 3"]


def from_above(points: Float[np.ndarray, "... 2"]) -> Float[np.ndarray, "... 2"]:
    """Return places ahead and to the left as they are drawn: ahead is up, left is left."""
    ahead, left = np.moveaxis(points, -1, 0)
    return np.stack([-left, ahead], axis=-1)


def polar(r: np.ndarray | float, phi: np.ndarray | float) -> Float[np.ndarray, "... 2"]:
    """Return places of distances and directions (m, rad) as they are drawn."""
    return from_above(points(np.stack(np.broadcast_arrays(r, phi), axis=-1)))


def floor(ax: Axes, room: Room, furniture: float) -> None:
    """Draw walls, furniture and the robot, and frame them."""
    grey = MEANING["world"]
    for faces, strength in ((room.tops, 0.35), (room.walls, 0.9)):
        lines(ax, from_above(faces), grey, 1.0, alpha=strength * furniture)
    for place, radius in zip(from_above(room.posts[:, :2]), room.posts[:, 2], strict=True):
        if np.abs(place).max() < REACH:
            ax.plot(*(place + radius * CIRCLE[::4]).T, color=grey, linewidth=1.0, alpha=furniture)
    _robot(ax, REACH, [-2, 0, 2])
    ax.grid(visible=False)


def _robot(ax: Axes, behind: float, ticks: Sequence[float]) -> None:
    """Draw the robot, and show so much around it and behind it."""
    ax.plot(*ROBOT * CIRCLE.T, color=MEANING["robot"], linewidth=1.6)
    ax.plot([0, 0], [0, ROBOT], color=MEANING["robot"], linewidth=1.6)
    ax.set(xlim=(-REACH, REACH), ylim=(-behind, REACH))
    ax.set_aspect("equal", adjustable="box")
    ax.set_xticks([-2, 0, 2], ["2", "0", "2"])
    ax.set_yticks(ticks)
    ax.set(xlabel="left, right (m)", ylabel="ahead (m)")


def people(ax: Axes, scene: Any, *, strong: bool = True, words: Sequence[str] = NAMES) -> None:
    """Draw where people were, each with the direction of the body and a letter."""
    bodies(ax, scene.people, scene.headings, strong=strong, words=words)


def bodies(
    ax: Axes,
    places: Float[np.ndarray, "p 2"],
    headings: Float[np.ndarray, "p"],
    *,
    strong: bool = True,
    words: Sequence[str] = NAMES,
) -> None:
    """Draw people who stand ahead and to the left (m) and look somewhere (rad), with letters."""
    truth = MEANING["truth"]
    for word, place, heading in zip(words, places, headings, strict=False):
        middle = from_above(place)
        if not ax.viewLim.contains(*middle):
            continue
        rim = middle + BODY * CIRCLE
        if strong:
            ax.fill(*rim.T, color=truth, alpha=0.2, linewidth=0)
        ax.plot(*rim.T, color=truth, linewidth=1.2, linestyle="-" if strong else ":")
        nose = np.array([middle, middle + BODY * polar(1.0, heading)])
        ax.plot(*nose.T, color=truth, linewidth=1.2)
        label(ax, *(1 + OUT / np.hypot(*middle)) * middle, word, truth, ha="center")


# What the sensors say ----------------------------------------------------------------------------


def bent(
    mean: Float[np.ndarray, "n 2"], cov: Float[np.ndarray, "n 2 2"]
) -> Float[np.ndarray, "n corners 2"]:
    """Return the outlines of distributions of distance and direction (m, rad), about the robot, m.

    An ellipse of distance and direction is bent in the plane.
    """
    r, phi = np.moveaxis(mean[:, :, None] + DEVIATIONS * np.linalg.cholesky(cov) @ CIRCLE.T, 1, 0)
    return points(np.stack([np.maximum(r, 0.0), phi], axis=-1))


def rims(
    mean: Float[np.ndarray, "n 2"], cov: Float[np.ndarray, "n 2 2"]
) -> Float[np.ndarray, "n corners 2"]:
    """Return the outlines of `bent` ellipses as they are drawn."""
    return from_above(bent(mean, cov))


def _wedges(mean: np.ndarray, cov: np.ndarray) -> Float[np.ndarray, "n corners 2"]:
    """Return sectors of directions, for beliefs that say nothing of the distance."""
    wide = DEVIATIONS * np.sqrt(cov[:, 1, 1])
    phi = mean[:, 1, None] + wide[:, None] * np.linspace(-1, 1, 9)
    ends = np.zeros((len(mean), 1, 2))
    return np.concatenate([ends, polar(np.full(phi.shape, 2 * REACH), phi), ends], axis=1)


def said(ax: Axes, sensor: str, detections: Gaussian) -> None:
    """Draw what a sensor takes for people: bent 2σ ellipses, of the camera wedges."""
    shapes = (_wedges if sensor == "camera" else rims)(detections.mean, detections.cov)
    for shape in shapes:
        ax.fill(*shape.T, color=MEANING[sensor], alpha=0.2, linewidth=0)
        ax.plot(*shape.T, color=MEANING[sensor], linewidth=1.6)


def crosses(ax: Axes, mean: Float[np.ndarray, "n 2"]) -> None:
    """Mark what is nobody's, by distance and direction (m, rad), with a cross."""
    ax.plot(*polar(*mean.T).T, "x", color=MEANING["wrong"], markersize=10, markeredgewidth=2.4)


@drawn(
    name="people-hero",
    alt="Three floor plans of a room with three people around a robot. The camera has three "
    "directions, the laser two people, the sonars one of these two.",
    caption="One moment, from above; the robot looks up the page. Dotted discs A, B and C: the "
    "people. Coloured, 2σ: what each sensor takes for people in one measurement. The camera knows "
    "directions only, the laser misses A, and the sonars miss A and B. The paper's Fig. 7 shows "
    "such a moment.",
    cols=3,  # they fill the row: their margins have room for ticks, the caption says what is up
    width=8.2,
    height=3.1,
    gridspec_kw={"left": 0.42 / 8.2, "right": 1 - 0.11 / 8.2, "wspace": 0.54 / 2.2},
)
def hero(axes: np.ndarray, scene: Any) -> np.ndarray:
    """Draw the middle of Fig. 7 again on three axes: what each sensor says of the scene."""
    for ax, sensor in zip(axes, ("camera", "laser", "sonar"), strict=True):
        ax.clear()
        floor(ax, scene.room, 0.4)
        ax.set_ylabel("")
        people(ax, scene, strong=False)
        said(ax, sensor, scene.found[sensor].positions)
        ax.set_title(f"{sensor} alone")
    return axes


def overlay(ax: Axes, scene: Any, words: Sequence[str] = ("", "", "")) -> Axes:
    """Draw what all three say of a moment, and where the people are, on axes cleared first."""
    ax.clear()
    floor(ax, scene.room, 0.5)
    for sensor in ("camera", "sonar", "laser"):
        said(ax, sensor, scene.found[sensor].positions)
    people(ax, scene, words=words)
    return ax


def bare(ax: Axes) -> Axes:
    """Let a drawing of the room fill its card."""
    ax.set(xlim=(-REACH, REACH), ylim=(-2.5, 1.9))
    ax.set_position((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    ax.set_title("")
    return ax


@drawn(
    name="people-scan",
    alt="A scan of a laser from above: the arcs of legs, chair legs, and walls behind. Pairs of "
    "legs are joined by a bar.",
    caption="One scan of the laser at the same moment. Points: where the beams ended. Joined dots: "
    "two legs that are taken for a person. Dotted discs: the people. Small squares: things that "
    "look like a leg and have no second leg beside them.",
    height=4.2,
)
def scan(ax: Axes, scene: Any, gate: float) -> Axes:
    """Draw one scan: what is taken for legs, and for pairs of them, right within a gate, m."""
    ax.clear()
    ranges, back = scene.scan, scene.scan > 0
    seen = legs.profiles(np.where(back, ranges, np.inf), LASER_ANGLES)
    middles = seen.middles[legs.are_legs(seen)]
    paired = legs.pairs(middles)
    dots(ax, polar(ranges[back], LASER_ANGLES[back]), MEANING["laser"], 2.2)
    _robot(ax, 0.6, [0, 1, 2, 3])
    people(ax, scene, strong=False)
    for pair in paired:
        middle = middles[pair].mean(axis=0)
        near = np.hypot(*(scene.people - middle).T).min() < gate
        colour = MEANING["right" if near else "wrong"]
        ax.plot(*from_above(middles[pair]).T, "o-", color=colour, markersize=6, linewidth=2.4)
    single = from_above(middles[np.setdiff1d(np.arange(len(middles)), paired.ravel())])
    ax.plot(*single.T, "s", color=MEANING["expected"], markersize=5, fillstyle="none")
    return ax


@drawn(
    name="people-ring",
    alt="Arcs around a robot, one for each sonar: one at a person, and all others at the limit of "
    "two metres.",
    caption="One round of the sonars. Thick arc: an echo; thin dotted arcs: nothing within 2 m. "
    "An arc is as wide as a cone. Dotted discs: the people.",
    width=5.0,
    height=5.0,
)
def ring(ax: Axes, scene: Any) -> Axes:
    """Draw one round of the sonars: an arc across each cone, and where the people are."""
    ax.clear()
    floor(ax, scene.room, 0.5)
    people(ax, scene, strong=False)
    arcs(ax, scene.echoes)
    return ax


def arcs(ax: Axes, echoes: Float[np.ndarray, "sonars"], *, beyond: bool = True) -> None:
    """Draw a round of the sonars: thick where an echo came back, thin at the limit where none."""
    half = RIG.ring.cone / 2 * np.linspace(-1, 1, 9)
    for echo, angle in zip(echoes, SONAR_ANGLES, strict=True):
        near = 0 < echo < RIG.ring.cut
        if not near and not beyond:
            continue
        r = RIG.ring.radius + (echo if near else RIG.ring.cut)
        arc = polar(np.full(half.shape, r), angle + half)
        width, line = (3.0, "-") if near else (1.2, ":")
        ax.plot(*arc.T, color=MEANING["sonar"], linewidth=width, linestyle=line)


@drawn(
    name="people-fisheye",
    alt="A round fisheye picture of a room: lamps on the ceiling in the middle, walls, people, "
    "wooden doors and notice boards along the rim. Three green lines point at faces.",
    caption="A frame of the camera, ahead at the bottom. Green: directions in which it takes "
    "something for a face; they say nothing about distance. Rings: where the heads are.",
    axes=lambda scene: image_axes(scene.picture),
)
def fisheye(ax: Axes, scene: Any) -> Axes:
    """Draw over a picture the directions of the clouds, and where the heads are."""
    ax.clear()
    directions(ax, scene.found["camera"].positions.mean[:, 1])
    heads(ax, np.column_stack([scene.people, scene.heads]))
    middle, below = RIG.camera.centre_px[0], 0.985 * RIG.camera.size
    label(ax, middle, below, "ahead", MEANING["robot"], ha="center", va="bottom")
    return ax


def directions(ax: Axes, phis: Float[np.ndarray, "n"]) -> None:
    """Draw over a picture directions (rad) in which something is taken for a face."""
    centre, rim = np.array(RIG.camera.centre_px), RIG.camera.size / 2
    for phi in phis:
        out = np.array([-np.sin(phi), np.cos(phi)])
        ends = centre + np.outer([0.28 * rim, 0.97 * rim], out)
        ax.plot(*ends.T, color=MEANING["camera"], linewidth=2.4)


def heads(ax: Axes, places: Float[np.ndarray, "p 3"]) -> None:
    """Draw over a picture a ring and a letter where heads are: ahead, to the left and up, m."""
    centre = np.array(RIG.camera.centre_px)
    for name, pixel in zip(NAMES, RIG.camera.project(places), strict=False):
        ax.plot(*pixel, "o", color=MEANING["truth"], markersize=15, fillstyle="none")
        inwards = pixel + 24 * (centre - pixel) / np.hypot(*(centre - pixel))
        label(ax, *inwards.tolist(), name, MEANING["truth"], ha="center")


# Numbers -----------------------------------------------------------------------------------------


@drawn(
    name="people-distance",
    alt="Share of people found against distance: that of the sonars falls from the start and ends "
    "beyond two metres; those of laser and camera stay high up to two metres and then fall.",
    caption="Share of people found by one measurement, in each half metre of distance. Only the "
    "people whom a sensor could find are counted: for the laser those in trousers who do not stand "
    "sideways and whose legs its beams meet, for the sonars those in a cone within 2 m, for the "
    "camera those who look at it. Bars: 95 % over forty sessions.",
    height=3.2,
)
def rates_by_distance(ax: Axes, found: Mapping[str, Mapping[float, Interval]]) -> Axes:
    """Draw the share that each sensor finds, by the end of half a metre of distance, m."""
    beside = {"camera": (5, 0.1, "bottom"), "laser": (4, -0.1, "top")}
    beside_each_other = {"laser": 0.0, "sonar": 0.03, "camera": -0.03}  # m
    for sensor, every in found.items():
        shares = {end: share for end, share in every.items() if end <= FARTHEST}
        colour = MEANING[sensor]
        middles = np.array(list(shares)) - 0.25 + beside_each_other[sensor]
        for x, share in zip(middles, shares.values(), strict=True):
            ax.plot([x, x], [share.low, share.high], color=colour, linewidth=2.0)
        estimates = [share.estimate for share in shares.values()]
        ax.plot(middles, estimates, "o-", color=colour, linewidth=1.4)
        at, gap, va = beside.get(sensor, (-1, 0.1, "center"))  # there the curves are apart
        at = min(at, len(estimates) - 1)
        x, y = middles[at] + gap, estimates[at]
        label(ax, x, y, sensor, colour, ha="left" if gap > 0 else "right", va=va)
    ax.set(xlim=(0, 4), ylim=(-0.02, 1.02), xlabel="distance (m)", ylabel="share found")
    return ax


@drawn(
    name="people-searches",
    alt="Faces found against samples looked at, on a logarithmic axis: a curve of searches by "
    "lattices that rises, and three dots for clouds with few, some and many seeds.",
    caption="Share of the faces found against the share of a picture's samples that is looked at. "
    "Curve: searches of the whole picture, from one sample of 96 to every sample, each with the "
    "threshold by which it makes up as many faces as the clouds with 400 seeds. Dots: clouds of "
    "particles, by the number of seeds. Where dot and curve are equally high, both find as many "
    "faces, and the one with the smaller share looks at less.",
    height=3.2,
)
def searches(
    ax: Axes,
    clouds: Mapping[int, Float[np.ndarray, "2"]],
    lattices: Float[np.ndarray, "n 2"],
) -> Axes:
    """Draw what clouds, by their seeds, and lattices look at and find, shares of all."""
    ax.plot(*lattices.T, "o-", color=MEANING["expected"], markersize=4)
    label(ax, *lattices[1], "searches", MEANING["expected"], ha="right", va="bottom")
    for seeds, (looked, found) in clouds.items():
        ax.plot(looked, found, "o", color=MEANING["camera"], markersize=7)
        words = f"{seeds} seeds" if seeds == min(clouds) else f"{seeds}"
        label(ax, looked, found - 0.05, words, MEANING["camera"], ha="center", va="top")
    ax.set_xscale("log")
    ax.set(xlim=(0.008, 1.6), ylim=(0, 1), xlabel="share of the samples that is looked at")
    ax.set_ylabel("share of faces found")
    return ax


# Real scans --------------------------------------------------------------------------------------


@drawn(
    name="people-real",
    alt="A real scan of a room from above: walls, and small arcs of legs, some with a ring or a "
    "cross.",
    caption="A real scan (points) of a laser (triangle). Rings: marked legs that are found with "
    "every third beam. Crosses: marked legs that are missed. Squares: legs reported where none "
    "was marked.",
    height=4.4,
)
def real_scan(ax: Axes, result: Any, reach: float) -> Axes:
    """Draw a real scan: legs that somebody marked, found in reach (m) and missed, and others."""
    angles, there = result.angles, result.ranges < FAR
    dots(ax, polar(result.ranges[there], angles[there]), MEANING["laser"], 1.6)
    apart = np.hypot(*(result.marked[:, None] - result.found).transpose(2, 0, 1))
    near = apart <= reach
    for places, name, mark in (
        (result.marked[near.any(axis=1)], "right", "o"),
        (result.marked[~near.any(axis=1)], "missed", "x"),
        (result.found[~near.any(axis=0)], "wrong", "s"),
    ):
        pen = {"markersize": 9, "fillstyle": "none", "markeredgewidth": 1.8}
        ax.plot(*from_above(places).T, mark, color=MEANING[name], **pen)
    ax.plot(0, 0, marker=(3, 0, 0), color=MEANING["robot"], markersize=9)
    ax.set(xlim=(-6, 6), ylim=(-2.6, 5.4), xlabel="left, right (m)", ylabel="ahead (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.set_xticks([-4, -2, 0, 2, 4], ["4", "2", "0", "2", "4"])
    return ax


@drawn(
    name="people-street",
    alt="A street with pedestrians, a brick building and a lawn. Red covers most of the bricks, "
    "patches of gravel, and few pixels of the pedestrians.",
    caption="One frame. Red: what the model of skin, learnt in rendered offices, takes for skin.",
    axes=lambda result: image_axes(result.frame[..., ::-1]),
)
def taken_for_skin(ax: Axes, result: Pedestrians) -> Axes:
    """Mark on a frame what is taken for skin."""
    over = np.zeros((*result.skin.shape, 4))
    over[result.skin] = to_rgba(MEANING["wrong"], 0.9)
    ax.imshow(over, interpolation="nearest")
    return ax


# Explorer ----------------------------------------------------------------------------------------


def look(ax: Axes, now: Any) -> Axes:
    """Draw what one sensor takes for people at a moment, on axes cleared first.

    A detection that is nobody's has a cross in the middle.
    """
    ax.clear()
    floor(ax, now.scene.room, 0.5)
    words = [name if found else f"{name}?" for name, found in zip(NAMES, now.found, strict=False)]
    people(ax, now.scene, strong=False, words=words)
    said(ax, now.sensor, now.detections.positions)
    crosses(ax, now.detections.positions.mean[now.nobody])
    ax.set_title(f"{now.sensor}: {now.found.sum()} of {len(now.found)} found")
    return ax


def stood(ax: Axes, now: Any) -> Axes:
    """Draw somebody who stands somewhere, the signals, and what each sensor takes for people."""
    ax.clear()
    lines(ax, from_above(now.room), MEANING["world"], 1.0, alpha=0.45)
    back = np.isfinite(now.scan)
    dots(ax, polar(now.scan[back], LASER_ANGLES[back]), MEANING["laser"], 1.8)
    arcs(ax, now.echoes, beyond=False)
    for sensor in ("camera", "sonar", "laser"):
        said(ax, sensor, now.found[sensor].positions)
    _robot(ax, NEAR, [-2, 0, 2])
    ax.set(xlim=(-NEAR, NEAR), ylim=(-NEAR, NEAR))
    bodies(ax, points(now.polar), np.array([now.heading]), words=("",))
    for sensor, wrong in now.nobody.items():
        crosses(ax, now.found[sensor].positions.mean[wrong])
    ax.set_title(f"{now.words}; false: {now.false}")
    return ax

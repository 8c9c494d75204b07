"""Drawings of the chapter: the room from above, what each sensor says of it, and the rates."""

import re
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from data_synth.people import LASER_ANGLES, SONAR_ANGLES
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.people_fusion import committee, rates, recordings, scene
from robot_perception.chapters.people_fusion.modalities import GATES
from robot_perception.chapters.people_fusion.recordings import Legs, Pedestrians
from robot_perception.chapters.people_fusion.scene import Choice, State
from robot_perception.chapters.people_fusion.sessions import RIG
from robot_perception.evaluation.intervals import Interval
from robot_perception.geometry import se2
from robot_perception.people import legs
from robot_perception.people.aggregation import Hypotheses
from robot_perception.teaching.figures import drawn, image_axes
from robot_perception.teaching.figures.maps import dots, lines
from robot_perception.teaching.figures.style import MEANING, label
from robot_perception.teaching.ledger import Ledger
from robot_perception.teaching.tables import Table

REACH = 3.4  # the drawings show so much around the robot, m
DEVIATIONS = 2.0  # all ellipses and wedges reach so far, standard deviations
NAMES = "ABCDEFGH"  # of the people
BODY, ROBOT = 0.2, 0.25  # radius of what is drawn of a person and of the robot, m
_TURN = np.linspace(0, 2 * np.pi, 65)
CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=-1)
WITNESSES: dict[str, str] = {"camera": "fisheye", "laser": "legs", "sonar": "sonar"}
"""The claim about each sensor."""
OUT = 0.36  # from the middle of a person to the letter, m


# The room ----------------------------------------------------------------------------------------


def _drawn(points: Float[np.ndarray, "... 2"]) -> Float[np.ndarray, "... 2"]:
    """Return places ahead and to the left as they are drawn: ahead is up, left is left."""
    ahead, left = np.moveaxis(points, -1, 0)
    return np.stack([-left, ahead], axis=-1)


def _polar(r: np.ndarray | float, phi: np.ndarray | float) -> Float[np.ndarray, "... 2"]:
    return _drawn(np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1))


def _floor(ax: Axes, furniture: float) -> None:
    """Draw walls, furniture and the robot, and frame them."""
    room, grey = scene.signals(), MEANING["world"]
    for faces, strength in ((room.tops, 0.35), (room.faces, 0.9)):
        lines(ax, _drawn(faces), grey, 1.0, alpha=strength * furniture)
    for place, radius in zip(_drawn(room.posts[:, :2]), room.posts[:, 2], strict=True):
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


def _people(ax: Axes, at: float, *, strong: bool = True, words: Sequence[str] = NAMES) -> None:
    """Draw where people were, each with the direction of the body and a letter."""
    truth = MEANING["truth"]
    headings = scene.signals().headings[scene.MOMENTS.index(at)]
    for word, place, heading in zip(words, scene.people(at), headings, strict=False):
        middle = _drawn(place)
        if not ax.viewLim.contains(*middle):
            continue
        rim = middle + BODY * CIRCLE
        if strong:
            ax.fill(*rim.T, color=truth, alpha=0.2, linewidth=0)
        ax.plot(*rim.T, color=truth, linewidth=1.2, linestyle="-" if strong else ":")
        nose = np.array([middle, middle + BODY * _polar(1.0, heading)])
        ax.plot(*nose.T, color=truth, linewidth=1.2)
        label(ax, *(1 + OUT / np.hypot(*middle)) * middle, word, truth, ha="center")


# What the sensors say ----------------------------------------------------------------------------


def rims(
    mean: Float[np.ndarray, "n 2"], cov: Float[np.ndarray, "n 2 2"]
) -> Float[np.ndarray, "n corners 2"]:
    """Return the outlines of distributions of distance and direction (m, rad), as they are drawn.

    An ellipse of distance and direction is bent in the plane.
    """
    polar = mean[:, :, None] + DEVIATIONS * np.linalg.cholesky(cov) @ CIRCLE.T
    return _polar(np.maximum(polar[:, 0], 0.0), polar[:, 1])


def _wedges(mean: np.ndarray, cov: np.ndarray) -> Float[np.ndarray, "n corners 2"]:
    """Return sectors of directions, for beliefs that say nothing of the distance."""
    wide = DEVIATIONS * np.sqrt(cov[:, 1, 1])
    phi = mean[:, 1, None] + wide[:, None] * np.linspace(-1, 1, 9)
    ends = np.zeros((len(mean), 1, 2))
    return np.concatenate([ends, _polar(np.full(phi.shape, 2 * REACH), phi), ends], axis=1)


def said(ax: Axes, sensor: str, detections: Gaussian) -> None:
    """Draw what a sensor takes for people: bent 2σ ellipses, of the camera wedges."""
    shapes = (_wedges if sensor == "camera" else rims)(detections.mean, detections.cov)
    for shape in shapes:
        ax.fill(*shape.T, color=MEANING[sensor], alpha=0.2, linewidth=0)
        ax.plot(*shape.T, color=MEANING[sensor], linewidth=1.6)


def aggregated(
    ax: Axes, hypotheses: Hypotheses, nobody: Bool[np.ndarray, " n"] | None = None
) -> None:
    """Draw hypotheses as bent 2σ ellipses: the heavier the stronger, the persons filled.

    Persons that are ``nobody`` have a cross in the middle, not a dot.
    """
    colour = MEANING["estimate"]
    shapes = rims(hypotheses.mean, hypotheses.cov)
    crossed = np.zeros(len(hypotheses), dtype=bool) if nobody is None else nobody
    parts = zip(shapes, hypotheses.mean, hypotheses.weight, crossed, strict=True)
    for shape, mean, weight, cross in parts:
        person = weight > committee.RULES.person
        if person:
            ax.fill(*shape.T, color=colour, alpha=0.25 * weight, linewidth=0)
            mark, size = ("x", 10) if cross else ("o", 4)
            ax.plot(*_polar(*mean), mark, color=colour, markersize=size)
        width = 0.6 + 2.4 * weight
        ax.plot(*shape.T, color=colour, linewidth=width, linestyle="-" if person else ":")


@drawn(
    name="people-hero",
    alt="Three plans of a room with three people around a robot. The camera has three directions, "
    "the laser two people, the sonars one of these two.",
    caption="One moment, from above; the robot looks up the page. A, B and C are the people. What "
    "one reading of each sensor takes for people, 2σ: the camera knows directions only, the laser "
    "misses A, and the sonars miss A and B. It is the middle of the paper's Fig. 7.",
    cols=3,  # they fill the row: their margins have room for ticks, the caption says what is up
    width=8.2,
    height=3.1,
    gridspec_kw={"left": 0.42 / 8.2, "right": 1 - 0.11 / 8.2, "wspace": 0.54 / 2.2},
)
def hero(axes: np.ndarray, at: float) -> np.ndarray:
    """Draw the middle of Fig. 7 again on three axes: what each sensor says of the scene."""
    for ax, sensor in zip(axes, ("camera", "laser", "sonar"), strict=True):
        ax.clear()
        _floor(ax, 0.4)
        ax.set_ylabel("")
        _people(ax, at, strong=False)
        said(ax, sensor, scene.found(at, sensor).positions)
        ax.set_title(f"{sensor} alone")
    return axes


def card(ax: Axes, at: float) -> Axes:
    """Draw all in one for a card: people, the three sensors, and the persons they agree on."""
    ax.clear()
    _floor(ax, 0.5)
    for sensor in ("camera", "sonar", "laser"):
        said(ax, sensor, scene.found(at, sensor).positions)
    _people(ax, at, words=("", "", ""))
    aggregated(ax, scene.history().at(at).persons(committee.RULES))
    ax.set(xlim=(-3.4, 3.4), ylim=(-2.5, 1.9))
    ax.set_position((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    return ax


@drawn(
    name="people-scan",
    alt="Readings of a laser from above: the arcs of legs, chair legs, and walls behind. Pairs of "
    "legs are joined by a bar.",
    caption="One scan at the same moment. Points: where the beams ended. Joined dots: two legs "
    "taken for a person; somebody is there (dotted discs). Grey squares: look like a leg and have "
    "no second.",
    height=4.2,
)
def scan(ax: Axes, at: float) -> Axes:
    """Draw one scan of the laser: what is taken for legs, and for pairs of them."""
    ax.clear()
    ranges = scene.signals().scans[scene.MOMENTS.index(at)]
    back, rules = ranges > 0, legs.LegRules()
    seen = legs.profiles(np.where(back, ranges, np.inf), LASER_ANGLES, rules)
    middles = seen.middles[legs.are_legs(seen, rules)]
    paired = legs.pairs(middles, rules)
    dots(ax, _polar(ranges[back], LASER_ANGLES[back]), MEANING["laser"], 2.2)
    _robot(ax, 0.6, [0, 1, 2, 3])
    _people(ax, at, strong=False)
    for pair in paired:
        middle = middles[pair].mean(axis=0)
        near = np.hypot(*(scene.people(at) - middle).T).min() < GATES["laser"]
        colour = MEANING["right" if near else "wrong"]
        ax.plot(*_drawn(middles[pair]).T, "o-", color=colour, markersize=6, linewidth=2.4)
    single = _drawn(middles[np.setdiff1d(np.arange(len(middles)), paired.ravel())])
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
def ring(ax: Axes, at: float) -> Axes:
    """Draw one round of the sonars: an arc across each cone, and where the people are."""
    ax.clear()
    _floor(ax, 0.5)
    _people(ax, at, strong=False)
    echoes = scene.signals().echoes[scene.MOMENTS.index(at)]
    half = RIG.ring.cone / 2 * np.linspace(-1, 1, 9)
    for echo, angle in zip(echoes, SONAR_ANGLES, strict=True):
        near = 0 < echo < RIG.ring.cut
        r = RIG.ring.radius + (echo if near else RIG.ring.cut)
        arc = _polar(np.full(half.shape, r), angle + half)
        width, line = (3.0, "-") if near else (1.2, ":")
        ax.plot(*arc.T, color=MEANING["sonar"], linewidth=width, linestyle=line)
    return ax


@drawn(
    name="people-fisheye",
    alt="A round fisheye picture of a room: lamps on the ceiling in the middle, walls, people, "
    "wooden doors and notice boards along the rim. Three green lines point at faces.",
    caption="The picture of the camera, ahead at the bottom. Green: directions in which it takes "
    "something for a face; they do not tell how far away. Rings: where the heads are.",
    axes=lambda at: image_axes(scene.picture(at)),
)
def fisheye(ax: Axes, at: float) -> Axes:
    """Draw over a picture the directions of the clouds, and where the heads are."""
    ax.clear()
    camera = RIG.camera
    centre, rim = np.array(camera.centre_px), camera.size / 2
    for phi in scene.found(at, "camera").positions.mean[:, 1]:
        out = np.array([-np.sin(phi), np.cos(phi)])
        ends = centre + np.outer([0.28 * rim, 0.97 * rim], out)
        ax.plot(*ends.T, color=MEANING["camera"], linewidth=2.4)
    heads = np.column_stack([scene.people(at), scene.signals().heads])
    for name, pixel in zip(NAMES, camera.project(heads), strict=False):
        ax.plot(*pixel, "o", color=MEANING["truth"], markersize=15, fillstyle="none")
        inwards = pixel + 24 * (centre - pixel) / np.hypot(*(centre - pixel))
        label(ax, *inwards.tolist(), name, MEANING["truth"], ha="center")
    label(ax, centre[0], 0.985 * camera.size, "ahead", MEANING["robot"], ha="center", va="bottom")
    return ax


# Numbers -----------------------------------------------------------------------------------------


@drawn(
    name="people-distance",
    alt="Share of people found against distance: the camera falls slowly up to four metres, the "
    "laser from two metres on, the sonars from the start.",
    caption="Share found by a single reading, by distance: of people met by the laser in trousers "
    "and not sideways, met by a sonar, and facing the camera. Bars: 95 % over ten sessions.",
    height=3.2,
)
def rates_by_distance(ax: Axes, ledger: Ledger) -> Axes:
    """Draw the share of people found against their distance, with intervals."""
    beside = {"camera": (5, "left", "bottom"), "laser": (4, "right", "top")}
    for shift, (sensor, claim) in zip((-0.03, 0.0, 0.03), WITNESSES.items(), strict=True):
        points = shares(ax, sensor, ledger[claim].evidence, shift)
        at, ha, va = beside.get(sensor, (-1, "left", "center"))  # there the curves are apart
        r = points[at, 0] + (0.1 if ha == "left" else -0.1)
        label(ax, r, points[at, 1], sensor, MEANING[sensor], ha=ha, va=va)
    ax.set(xlim=(0, 4.6), ylim=(-0.02, 1.02), xlabel="distance (m)", ylabel="share found")
    return ax


def shares(
    ax: Axes, sensor: str, evidence: Mapping[str, Interval], shift: float
) -> Float[np.ndarray, "n 2"]:
    """Draw what of the evidence is named "found, 1 to 1.5 m", moved to the side by a little.

    Its points are returned.
    """
    named = {
        re.fullmatch(r"found, ([\d.]+) to ([\d.]+) m", name): s for name, s in evidence.items()
    }
    found = {np.mean([*map(float, m.groups())]) + shift: s for m, s in named.items() if m}
    colour = MEANING[sensor]
    for r, share in found.items():
        ax.plot([r, r], [share.low, share.high], color=colour, linewidth=2.0)
    points = np.array([(r, share.estimate) for r, share in found.items()])
    ax.plot(*points.T, "o-", color=colour, linewidth=1.4)
    return points


@drawn(
    name="people-ways",
    alt="Paths around a robot: broad grey ones of three people, and thin red ones that follow "
    "them in pieces.",
    caption="Half a minute. Broad: the true paths of the people. Thin: the paths of hypotheses "
    "that count as persons, with a dot where one ends.",
    width=5.0,
    height=5.0,
)
def ways(ax: Axes, run: committee.Tracked) -> Axes:
    """Draw the ways of all persons, those who were static at last with a square, and the truth."""
    ax.clear()
    known = run.recording
    start = se2.inverse(known.poses[0])
    _floor(ax, 0.4)
    for way in np.moveaxis(known.places, 1, 0):
        ax.plot(*_drawn(way).T, color=MEANING["truth"], linewidth=3.0, alpha=0.3)
    still = {one for _, persons, static in run.persons for one in persons.identity[static].tolist()}
    for way in rates.ways(run):
        points = _drawn(se2.act(start, way.points))
        static = way.identity in still
        colour = MEANING["wrong" if static else "estimate"]
        ax.plot(*points.T, color=colour, linewidth=1.3)
        ax.plot(*points[-1], "s" if static else "o", color=colour, markersize=5)
    return ax


@drawn(
    name="people-trade",
    alt="Three panels of the share of people tracked against the share of false hypotheses: the "
    "curves rise slowly to the right and pass below the paper's point.",
    caption="Ten sessions; θ changed alone, all α, or all patiences, from a quarter to three times "
    "ours. All three move along the same curve, which passes below the paper's point.",
    cols=3,
    width=7.4,
    height=3.0,
)
def trade(axes: np.ndarray, sweeps: Table) -> np.ndarray:
    """Draw tracked against false shares as θ, α or t_v changes, and the paper's two numbers.

    The recorded table has rows "θ = 0.1", "2 α" and "2 t_v".
    """
    for ax, name in zip(axes, ("θ", "α", "t_v"), strict=True):
        rows = [row for row in sweeps.rows if name in row.split()]
        false, tracked = (
            np.array([sweeps[row, column].estimate for row in rows])
            for column in ("false", "tracked")
        )
        colour = MEANING[name]
        ax.plot(false, tracked, "o-", color=colour, linewidth=1.4, markersize=4)
        for k, ha, va, gap in ((0, "left", "top", -0.01), (-1, "center", "bottom", 0.015)):
            text = rows[k].replace("t_v", "t\u1d65")
            label(ax, false[k], tracked[k] + gap, text, colour, ha=ha, va=va, fontsize=9)
        _paper(ax)
    return axes


@drawn(
    name="people-rooms",
    alt="Seven rows, each with two dots: the share of hypotheses that are nobody, left, and of "
    "people tracked, right. The left dot moves to the paper's line only without table legs, wood "
    "and cork; the right one if people who stop look at the robot, or walk half as fast.",
    caption="What the paper's two numbers would need: the same system in rooms and among people in "
    "which one thing is changed, and at last all of them. Left: hypotheses that are nobody; right: "
    "people who are tracked. Bars: 95 % over ten sessions; dotted: the paper.",
    height=5.0,
)
def rooms(ax: Axes, table: Table) -> Axes:
    """Draw what each property of room and people does to both shares, a row for each."""
    for x, column in zip(rates.OF_THE_PAPER, ("false", "tracked"), strict=True):
        ax.axvline(x, color=MEANING["paper"], linewidth=1.4, linestyle=":")
        label(ax, x - 0.01, -0.8, f"{column}: {x:.0%}", MEANING["paper"], ha="right")
    for row, name in enumerate(table.rows):
        for column, meaning in (("false", "wrong"), ("tracked", "right")):
            share, colour = table[name, column], MEANING[meaning]
            ax.plot([share.low, share.high], [row, row], color=colour, linewidth=1.8)
            ax.plot(share.estimate, row, "o", color=colour, markersize=6)
        label(ax, 0.01, row - 0.38, name, MEANING["world"])
    ax.set(xlim=(0, 1), ylim=(len(table.rows) - 0.5, -1.2), xlabel="share", yticks=[])
    return ax


def _paper(ax: Axes) -> None:
    """Mark the paper's two numbers, and make the axes of shares."""
    colour = MEANING["paper"]
    ax.plot(*rates.OF_THE_PAPER, "D", color=colour, markersize=8)
    label(ax, rates.OF_THE_PAPER[0], 0.972, "the paper", colour, ha="center")
    ax.set(xlim=(0, 0.6), ylim=(0.4, 1.01))
    ax.set(xlabel="hypotheses: share false", ylabel="people: share tracked")


# Real scans --------------------------------------------------------------------------------------


@drawn(
    name="people-real",
    alt="A real scan of a room from above: walls, and small arcs of legs, some circled.",
    caption="A real scan. Rings: marked legs, bright ones found with every third beam, dark ones "
    "missed; squares: reported where nobody marked a leg.",
    height=4.4,
)
def real_scan(ax: Axes, result: Legs) -> Axes:
    """Draw a real scan: legs that somebody marked, found and missed, and what else is reported."""
    angles, there = result.angles, result.ranges < recordings.FAR
    dots(ax, _polar(result.ranges[there], angles[there]), MEANING["laser"], 1.6)
    apart = np.hypot(*(result.marked[:, None] - result.found).transpose(2, 0, 1))
    near = apart <= recordings.NEAR
    for points, name, mark in (
        (result.marked[near.any(axis=1)], "right", "o"),
        (result.marked[~near.any(axis=1)], "missed", "o"),
        (result.found[~near.any(axis=0)], "wrong", "s"),
    ):
        pen = {"markersize": 9, "fillstyle": "none", "markeredgewidth": 1.8}
        ax.plot(*_drawn(points).T, mark, color=MEANING[name], **pen)
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


# Explorers ---------------------------------------------------------------------------------------


def committee_at(ax: Axes, state: State) -> Axes:
    """Draw the hypotheses of some sensors at a moment over the truth, on axes cleared first."""
    ax.clear()
    _floor(ax, 0.5)
    gone = zip(NAMES, state.missed, strict=False)
    words = [f"{name}?" if missed else name for name, missed in gone]
    _people(ax, state.at, strong=False, words=words)
    aggregated(ax, state.hypotheses, state.nobody)
    ax.set_title(f"{state.who}: {len(state.missed) - state.missed.sum()} of 3 found")
    return ax


def rules(ax: Axes, now: Choice) -> Axes:
    """Draw the two shares under a choice of the rules, on axes cleared first."""
    ax.clear()
    every = np.array([[one.false, one.tracked] for one in scene.all_chosen().values()])
    ax.plot(*every.T, "o", color=MEANING["expected"], markersize=2.5)
    _paper(ax)
    ax.plot(now.false, now.tracked, "o", color=MEANING["estimate"], markersize=10)
    label(ax, now.false + 0.03, now.tracked, "here", MEANING["estimate"])
    return ax

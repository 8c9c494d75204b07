"""Films of the behaviours: the office from above, what the robot believes, and what it says."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from explorables.figures.films import film
from explorables.figures.maps import lines, plan
from explorables.figures.style import MEANING, figure, label
from explorables.media import Shown
from robot_perception.chapters.people_sensors.figures import CIRCLE, bent
from robot_perception.geometry import se2
from robot_perception.people.behaviours import MOVES, PARTNER

FRAMES = 40
FPS = 3.0
WIDTH, HEIGHT = 5.0, 3.6
BODY = 0.22  # radius of what is drawn of a person and of the robot, m
LASTS = 2.0  # for so long what was said stands in the picture, s
_WORDS = {
    "come back": "Please come back!",
    "welcome back": "Welcome back.",
    "come nearer": "Please come nearer.",
    "take part": "Would you take part?",
    "clear the path": "May we pass, please?",
    "thank you": "Thank you.",
}
_TOLD = {
    "guide": (
        23,
        "The robot drives along the corridor with a visitor behind it; the visitor turns back, the "
        "robot stops and says: Please come back! The visitor returns and the tour goes on.",
        "A guide. Disc with a dotted path: the person. Disc with a nose: the robot. Ellipses "
        "(2σ): what it takes for persons, with the one it deals with filled; grey ones do not "
        "count. The greater the weight, the wider the line.",
    ),
    "blocked": (
        17,
        "A guide drives along the corridor towards two people who stand in its way. It stops a "
        "good metre before them and asks to pass; they step aside, and it drives on between them.",
        "Two people block the path of a guide. Discs: the people, and the robot (with a nose). "
        "Ellipses: what it takes for persons.",
    ),
    "follow": (
        20,
        "A person leads the robot out of a room and along the corridor; an ellipse stays on the "
        "person, and the robot stays about a metre and a half behind.",
        "A robot follows a person by laser and sonars alone. Discs: the person, and the robot "
        "(with a nose). Ellipses: what it takes for persons.",
    ),
    "survey": (
        32,
        "A visitor comes down the corridor, is asked nearer and to take part, walks away after "
        "nine seconds, and the robot calls after them three seconds later.",
        "A visitor breaks off a survey. Discs: the visitor, and the robot (with a nose). "
        "Ellipses: what it takes for persons; grey ones do not count.",
    ),
}
"""The frame that stands first, alternative text and caption."""


def show(kind: str, story: Any, world: Any) -> Shown:
    """Show a story of a kind, in its world, as a film."""
    poster, alt, caption = _TOLD[kind]
    return film(
        frames(story, world),
        fps=FPS,
        name=f"people-{kind}",
        alt=alt,
        caption=caption,
        poster=poster,
    )


def frames(story: Any, world: Any) -> Iterator[Figure]:
    """Yield the frames of a story, all drawn on one figure."""
    faces, posts = world.office.section(0.3)
    fig, ax = figure(width=WIDTH, height=HEIGHT)
    for look in np.linspace(0, len(story.looks) - 1, FRAMES).round().astype(int).tolist():
        frame(ax, story, look, faces, posts)
        yield fig


def frame(
    ax: Axes,
    story: Any,
    look: int,
    faces: Float[np.ndarray, "f 2 2"],
    posts: Float[np.ndarray, "p 3"],
) -> Axes:
    """Draw one moment: what stands, both paths, the persons of the robot, and its words."""
    ax.clear()
    k = int(story.looks[look])
    lines(ax, faces, MEANING["world"], 1.6, alpha=0.5, zorder=0)
    ax.scatter(*posts[:, :2].T, s=5, color=MEANING["world"], linewidths=0, alpha=0.5, zorder=0)
    for way in np.moveaxis(story.people[: k + 1], 1, 0):
        ax.plot(*way.T, color=MEANING["truth"], linewidth=1.0, linestyle=":")
    ax.plot(*story.robot[: k + 1, :2].T, color=MEANING["robot"], linewidth=1.4)
    first, last = story.counts[:look].sum(), story.counts[: look + 1].sum()
    for row in range(first, last):
        _hypothesis(ax, story, row, story.robot[k])
    for place in story.people[k]:
        _disc(ax, place, MEANING["truth"])
    _disc(ax, story.robot[k, :2], MEANING["robot"])
    nose = se2.act(story.robot[k], np.array([[0.0, 0.0], [1.6 * BODY, 0.0]]))
    ax.plot(*nose.T, color=MEANING["robot"], linewidth=2.5)
    plan(ax, np.concatenate([*np.moveaxis(story.people, 1, 0), story.robot[:, :2]]), margin=1.4)
    _widen(ax)
    ax.grid(visible=False)
    ax.set_title(f"{story.times[k]:.0f} s: {story.phase[k]}")
    word = _last_word(story, k)
    if word:
        above = story.robot[k, :2] + [0.0, 0.75]
        low, high = ax.get_xlim()
        room = 0.24 * (high - low)  # half of the longest words
        x = float(np.clip(above[0], low + room, high - room))
        label(ax, x, float(above[1]), word, MEANING["robot"], ha="center", zorder=9)
    return ax


def _hypothesis(ax: Axes, story: Any, row: int, pose: np.ndarray) -> None:
    """Draw where a hypothesis reaches with 2σ; the line is as wide as its weight."""
    (rim,) = bent(story.mean[[row]], story.cov[[row]])
    points, status = se2.act(pose, rim), story.status[row]
    colour = MEANING["estimate"] if status >= MOVES else MEANING["expected"]
    width = 0.4 + 2.0 * float(story.weight[row])
    ax.plot(*points.T, color=colour, linewidth=width, zorder=6)
    if status == PARTNER:
        ax.fill(*points.T, color=colour, alpha=0.25, linewidth=0, zorder=6)


def _disc(ax: Axes, place: np.ndarray, colour: str) -> None:
    ax.fill(*(place + BODY * CIRCLE).T, color=colour, linewidth=0, zorder=5)


def _widen(ax: Axes) -> None:
    """Make the limits as wide and as high as the panel, so that all of it is used."""
    box = ax.get_position(original=True)
    ratio = (box.width * WIDTH) / (box.height * HEIGHT)
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    wide, high = max(x1 - x0, ratio * (y1 - y0)), max(y1 - y0, (x1 - x0) / ratio)
    ax.set_xlim((x0 + x1 - wide) / 2, (x0 + x1 + wide) / 2)
    ax.set_ylim((y0 + y1 - high) / 2, (y0 + y1 + high) / 2)


def _last_word(story: Any, k: int) -> str:
    """Return what was said a short while ago, or nothing."""
    spoken = np.flatnonzero(story.said[: k + 1] != "")
    if not spoken.size or story.times[k] - story.times[spoken[-1]] > LASTS:
        return ""
    return _WORDS[story.said[spoken[-1]]]

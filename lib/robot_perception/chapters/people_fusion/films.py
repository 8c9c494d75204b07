"""Films of the behaviours: the office from above, what the robot believes, and what it says."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot_perception.chapters.people_fusion import behaviours
from robot_perception.chapters.people_fusion.behaviours import SAID, WITHOUT_CAMERA, Kind, Story
from robot_perception.chapters.people_sensors.figures import CIRCLE, bent
from robot_perception.chapters.people_sensors.sessions import SENSORS
from robot_perception.geometry import se2
from robot_perception.people.behaviours import MOVES, PARTNER, PHASES
from robot_perception.teaching.figures.films import film
from robot_perception.teaching.figures.maps import lines, plan
from robot_perception.teaching.figures.style import MEANING, figure, label
from robot_perception.teaching.media import Shown
from robot_perception.teaching.recorded import recorded

FRAMES = 40
FPS = 3.0
WIDTH, HEIGHT = 5.0, 3.6
BODY = 0.22  # radius of what is drawn of a person and of the robot, m
LASTS = 2.0  # for so long what was said stands in the picture, s
_WORDS = {
    "come back": "Please come back!",
    "welcome back": "Welcome back.",
    "take part": "Would you take part?",
    "first question": "First question …",
    "thank you": "Thank you.",
}
_TOLD: dict[Kind, tuple[int, tuple[str, ...], str, str]] = {
    "guide": (
        6002,
        SENSORS,
        "The robot drives along the corridor with a visitor behind it; the visitor turns back, the "
        "robot stops and says: Please come back! The visitor returns and the tour goes on.",
        "A guide. Dark disc with a dotted path: the person; disc with a nose: the robot. "
        "Ellipses (2σ): what it takes for persons, with the one it deals with filled; grey ones "
        "do not count. The greater the weight, the wider the line.",
    ),
    "follow": (
        6003,
        WITHOUT_CAMERA,
        "A person leads the robot out of a room and along the corridor; an ellipse stays on the "
        "person, and the robot stays about a metre and a half behind.",
        "Followed by laser and sonars alone; drawn as above.",
    ),
    "survey": (
        6004,
        SENSORS,
        "A visitor comes down the corridor, is invited and asked, walks away after nine seconds, "
        "and the robot calls after them three seconds later.",
        "A survey that is broken off; drawn as above.",
    ),
}
"""Seed and sensors of the story that is shown, alternative text and caption."""


@recorded("people-stories", ((kind,) for kind in _TOLD))
def story(kind: Kind) -> Story:
    """Return the story of a kind that is shown."""
    seed, sensors, _, _ = _TOLD[kind]
    return behaviours.told(kind, seed, sensors)


def show(kind: Kind) -> Shown:
    """Show a story of a kind as a film."""
    *_, alt, caption = _TOLD[kind]
    return film(frames(kind), fps=FPS, name=f"people-{kind}", alt=alt, caption=caption)


def frames(kind: Kind) -> Iterator[Figure]:
    """Yield the frames of a story, all drawn on one figure."""
    told = story(kind)
    world, _ = behaviours.stage(kind, np.random.default_rng(_TOLD[kind][0]))
    faces, posts = world.office.section(0.3)
    fig, ax = figure(width=WIDTH, height=HEIGHT)
    for look in np.linspace(0, len(told.looks) - 1, FRAMES).round().astype(int).tolist():
        frame(ax, told, look, faces, posts)
        yield fig


def frame(
    ax: Axes,
    story: Story,
    look: int,
    faces: Float[np.ndarray, "f 2 2"],
    posts: Float[np.ndarray, "p 3"],
) -> Axes:
    """Draw one moment: what stands, both paths, the persons of the robot, and its words."""
    ax.clear()
    k = int(story.looks[look])
    lines(ax, faces, MEANING["world"], 1.6, alpha=0.5, zorder=0)
    ax.scatter(*posts[:, :2].T, s=5, color=MEANING["world"], linewidths=0, alpha=0.5, zorder=0)
    ax.plot(*story.visitor[: k + 1].T, color=MEANING["truth"], linewidth=1.0, linestyle=":")
    ax.plot(*story.robot[: k + 1, :2].T, color=MEANING["robot"], linewidth=1.4)
    first, last = story.counts[:look].sum(), story.counts[: look + 1].sum()
    for row in range(first, last):
        _hypothesis(ax, story, row, story.robot[k])
    _disc(ax, story.visitor[k], MEANING["truth"])
    _disc(ax, story.robot[k, :2], MEANING["robot"])
    nose = se2.act(story.robot[k], np.array([[0.0, 0.0], [1.6 * BODY, 0.0]]))
    ax.plot(*nose.T, color=MEANING["robot"], linewidth=2.5)
    plan(ax, np.concatenate([story.visitor, story.robot[:, :2]]), margin=1.4)
    _widen(ax)
    ax.grid(visible=False)
    ax.set_title(f"{story.times[k]:.0f} s: {PHASES[story.phase[k]]}")
    word = _last_word(story, k)
    if word:
        above = story.robot[k, :2] + [0.0, 0.75]
        low, high = ax.get_xlim()
        room = 0.24 * (high - low)  # half of the longest words
        x = float(np.clip(above[0], low + room, high - room))
        label(ax, x, float(above[1]), word, MEANING["robot"], ha="center", zorder=9)
    return ax


def _hypothesis(ax: Axes, story: Story, row: int, pose: np.ndarray) -> None:
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


def _last_word(story: Story, k: int) -> str:
    """Return what was said a short while ago, or nothing."""
    spoken = np.flatnonzero(story.said[: k + 1])
    if not spoken.size or story.times[k] - story.times[spoken[-1]] > LASTS:
        return ""
    return _WORDS[SAID[story.said[spoken[-1]]]]

"""The film of the chapter: a whole visit, with the state of the robot below."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np
from matplotlib.figure import Figure

from explorables.figures import figure
from explorables.figures.films import film
from explorables.figures.style import MEANING
from explorables.media import Shown
from robot_perception.chapters.tutor_following import figures as draw

FPS = 6.0
EVERY = 3
"""Pictures of the visit from one that is shown to the next."""
STATES = tuple(draw.PLACES)


def whole(shown: Sequence[SimpleNamespace]) -> Shown:
    """Show the visit: picture, what is found in it, the way from above, and the state."""
    names = [moment.state for moment in shown]
    return film(
        frames(shown),
        fps=FPS,
        name="following-film",
        poster=names.index("follow") // EVERY + 18,
        alt="A stranger raises a hand before the robot and nothing happens. A second person comes, "
        "raises a hand, turns and walks off; the robot drives after him while somebody walks "
        "through between them. He raises a hand again, and it stops.",
        caption="What the robot sees. Squares: faces, known (solid) or not (dashed), hands, and "
        "the person it follows (dotted: the truth). In the plan: robot (triangle) and person (dot) "
        "from above, and the paths they took (solid and dotted). In the curve: the state.",
    )


def frames(shown: Sequence[SimpleNamespace]) -> Iterator[Figure]:
    """Yield the pictures of the film, all on one figure."""
    levels = np.array([STATES.index(moment.state) for moment in shown])
    ways = np.array([moment.pose[:2] for moment in shown])
    people = np.array([moment.tutor for moment in shown])
    fig, (top, plan, below) = figure(3, width=4.8, height=5.9)  # narrow: read on telephones
    top.set_position((0.0, 0.39, 1.0, 0.61))
    plan.set_position((0.01, 0.03, 0.26, 0.34))
    below.set_position((0.45, 0.10, 0.53, 0.27))
    for k in range(0, len(shown), EVERY):
        moment = shown[k]
        top.clear()
        draw.picture(top, moment.image())
        draw.seen(top, moment)
        plan.clear()
        plan.plot(-people[: k + 1, 1], people[: k + 1, 0], ":", color=MEANING["truth"])
        plan.plot(-ways[: k + 1, 1], ways[: k + 1, 0], color=MEANING["robot"])
        plan.plot(-people[k, 1], people[k, 0], "o", color=MEANING["truth"], markersize=6)
        plan.plot(-ways[k, 1], ways[k, 0], "^", color=MEANING["robot"], markersize=8)
        plan.set(xlim=(-8.5, -1.5), ylim=(3, 14), xticks=[], yticks=[], aspect="equal")
        below.clear()
        below.step(
            1 + np.arange(k + 1) / EVERY, levels[: k + 1], where="post", color=MEANING["robot"],
            linewidth=2.2,
        )  # fmt: skip
        frames_shown = 1 + (len(shown) - 1) // EVERY  # the unit of the film's counter
        below.set(xlim=(1, frames_shown), ylim=(len(STATES) - 0.5, -0.5), xlabel="frame")
        below.set_yticks(range(len(STATES)), STATES)
        yield fig

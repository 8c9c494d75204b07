"""The film of the chapter: a robot comes back along its path, by what it sees of the ceiling."""

from collections.abc import Iterator
from types import SimpleNamespace

from matplotlib.figure import Figure

from data_synth.ceiling import CeilingCamera
from explorables.figures import figure
from explorables.figures.films import film
from explorables.media import Shown
from robot_perception.chapters.ceiling_navigation import figures as draw
from robot_perception.chapters.ceiling_navigation.scene import MOUNT, plan

FPS = 8.0
EVERY = 2
"""Pictures from one frame to the next: the film runs nearly twice as fast as the robot."""
PLACES = (0.005, 0.01, 0.49, 0.88), (0.505, 0.01, 0.49, 0.88)


def frames(found: SimpleNamespace, every: int = EVERY) -> Iterator[Figure]:
    """Yield frames: what the corrected picture shows, and the plan beside it, on one clock."""
    eye, above = CeilingCamera(found.ceiling, MOUNT), plan(found.ceiling, found.taught)
    fig, axes = figure(1, 2, width=7.2, height=3.0)
    for ax, place in zip(axes, PLACES, strict=True):
        ax.set_position(place)
    for k in range(0, len(found.driven), every):
        draw.filmed(axes, above, found, eye.image(found.driven[k]), k)
        yield fig


def comeback(found: SimpleNamespace) -> Shown:
    """Show the replay of the page."""
    return film(
        frames(found),
        fps=FPS,
        name="nav-film",
        poster=len(found.driven) // EVERY // 3,
        alt="A picture and a plan. In the picture, what the camera sees: lamps, vents and joints "
        "of a ceiling slide by, squares stay on some of them. In the plan a robot that starts "
        "beside a taught path joins it within two metres and follows it round a corner to its end.",
        caption="The picture: the ceiling as the robot sees it, with the patterns that are "
        "tracked. The plan, as seen looking up: the taught path (broad) with its key images "
        "(dots), the robot's true path (thin) and two triangles, which nearly coincide: where it "
        "is and where it is in its own mosaic. It was put down beside the path.",
    )

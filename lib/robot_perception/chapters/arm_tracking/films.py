"""The films of the chapter: picture, outline, arms in space and errors, one clock."""

from collections.abc import Iterator, Sequence
from types import SimpleNamespace

from matplotlib.figure import Figure

from explorables.figures.films import film
from explorables.media import Shown
from robot_perception.chapters.arm_tracking import figures as draw

FPS = 7.5
EVERY = 2
"""Pictures from one that is shown to the next."""


def points(moments: Sequence[SimpleNamespace]) -> Shown:
    """Show somebody who points, tracked by all cues; every second picture of the film."""
    return film(
        frames(moments),
        fps=FPS,
        name="arms-points",
        poster=8,
        alt="A person before a bare wall lifts one arm, points, lets it sink, and points with the "
        "other one. Outlines stay on both arms; below it two stick figures move together.",
        caption=f"All cues, bare wall; the picture as above. {words(moments)}",
    )


def gestures(moments: Sequence[SimpleNamespace]) -> Shown:
    """Show somebody who gestures in clutter, tracked by all cues; every second picture."""
    return film(
        frames(moments),
        fps=FPS,
        name="arms-gestures",
        poster=16,
        alt="A person before a cluttered wall moves both arms while two others walk behind. "
        "Outlines follow the arms; below it two stick figures, and the errors.",
        caption="All cues, clutter, two people behind. In the picture: points on the outline of "
        f"the estimate, and lines through the true joints. {words(moments)}",
    )


def words(moments: Sequence[SimpleNamespace]) -> str:
    """Return what is drawn below the picture."""
    return (
        "Stick figures: both arms in space, turned by 35°, truth and estimate. Curves: how far off "
        f"the two wrists are, solid and dashed; dotted: {moments[0].near:.0f} px."
    )


def frames(moments: Sequence[SimpleNamespace]) -> Iterator[Figure]:
    """Yield the pictures of a film, all on one figure."""
    fig, axes = draw.laid_out()
    for state in moments:
        draw.following(axes, state)
        yield fig

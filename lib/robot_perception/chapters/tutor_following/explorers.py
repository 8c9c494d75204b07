"""The explorers of the chapter "Follow me"."""

from functools import partial

from robot_perception.chapters.tutor_following import figures as draw
from robot_perception.chapters.tutor_following import views
from robot_perception.teaching.controls import Drag, choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

tracked = Exploration(
    draw.tracking,
    views.followed,
    views.Followed.words,
    controls={
        "patches": choice("Patches", {name: name for name in views.PATCHES}, "one"),
        "learning": choice("Learns", {name: name for name in views.LEARNING}, "slowly"),
        "time": slider("Picture", views.TIMES, 70),
    },
    name="following-tracked",
    caption="Somebody stops between robot and person for 2.5 s. Dotted: the person. Solid: where "
    "the tracker has him. Below: how far the two overlap; dashed: less counts as lost.",
    presets={
        "one, never": {"learning": "never"},
        "four, slowly": {"patches": "four and a silhouette"},
        "four, gated": {"patches": "four and a silhouette", "learning": "slowly, gated"},
        "the end": {"time": 89},
    },
    axes=partial(figure, 2, width=4.8, height=5.0, gridspec_kw={"height_ratios": (3, 1)}),
    finding=lambda state: state.held,
)


def corner(x: int, y: int) -> tuple[float, float]:
    """Return the middle of the window."""
    half = views.raised().side / 2
    return float(x + half), float(y + half)


dragged = Exploration(
    draw.judging,
    views.windowed,
    views.Windowed.words,
    controls={
        "x": slider("To the right", views.ACROSS, views.ACROSS[5], "px"),
        "y": slider("Down", views.DOWN, views.DOWN[4], "px"),
    },
    name="following-dragged",
    caption="Left: drag the window. Middle: what the cascade sees of it. Right: the votes of each "
    "stage above its threshold; the first stage that is not passed rejects the window, and the "
    "grey ones are not asked.",
    presets={
        "half a hand": {"x": views.ACROSS[8]},
        "below the hand": {"y": views.DOWN[-1]},
        "beside": {"x": views.ACROSS[0], "y": views.DOWN[0]},
    },
    axes=partial(figure, 1, 3, width=7.8, height=3.2),
    finding=lambda state: state.passed,
    drag=Drag(("x", "y"), "the window", corner),
)

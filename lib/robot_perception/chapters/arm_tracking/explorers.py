"""The explorers of the chapter "Two arms, one camera"."""

from robot_perception.chapters.arm_tracking import figures as draw
from robot_perception.chapters.arm_tracking import views
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration

counted = Exploration(
    draw.following,
    views.counted,
    views.Tracked.words,
    controls={
        "filter": choice("Filter", {name: name for name in views.FILTERS}, "auxiliary"),
        "particles": slider("Particles", views.COUNTS, 200),
        "time": slider("Picture", views.TIMES, 32),
    },
    name="arms-counted",
    caption="Left: the picture, the outline of the estimate, and the true joints (green). Right: "
    "both arms in space, truth and estimate. Below: how far off the wrists are; dotted: more at "
    "the end counts as lost.",
    presets={
        "50 particles": {"particles": 50},
        "800 particles": {"particles": 800},
        "condensation": {"filter": "condensation"},
        "the end": {"time": views.TIMES[-1]},
    },
    axes=draw.laid_out,
    finding=lambda state: state.held,
)
cued = Exploration(
    draw.following,
    views.cued,
    views.Tracked.words,
    controls={
        "way": choice("Cues", {name: name for name in views.WAYS}, "contours only"),
        "behind": choice("Behind", {name: name for name in views.SCENES}, "clutter"),
        "time": slider("Picture", views.TIMES, 40),
    },
    name="arms-cued",
    caption="As before, 400 particles, auxiliary filter: which cues hold which arm.",
    presets={
        "all cues": {"way": "all cues"},
        "bare wall": {"behind": "bare wall"},
        "no motion": {"way": "no motion"},
        "no patches": {"way": "no patches"},
    },
    axes=draw.laid_out,
    finding=lambda state: state.held,
)

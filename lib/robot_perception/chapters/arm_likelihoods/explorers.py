"""The explorers of the chapter "What a likelihood looks like"."""

from functools import partial

import numpy as np

from robot_perception.chapters.arm_likelihoods import figures as draw
from robot_perception.chapters.arm_likelihoods import views
from robot_perception.chapters.arm_likelihoods.sweeping import NEAR
from robot_perception.teaching.controls import Drag, choice, slider, toggle
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure

_AXES = {"left": 0.005, "right": 0.975, "bottom": 0.15, "top": 0.97, "wspace": 0.24}
MIXES = ("shape", "colour", "all")

dragged = Exploration(
    draw.dragging,
    views.dragged,
    views.Dragged.words,
    controls={
        "mix": choice("Cues", {name: name for name in MIXES}, "shape"),
        "away": slider("Arm lifted by", views.ACROSS, 70, "°"),
        "bend": slider("Elbow bent by", views.DOWN, 90, "°"),
    },
    name="likelihoods-dragged",
    caption="Left: drag the hand. Red: the outlines of the model. Right: the likelihood of two "
    "of this arm's four angles. Cross: the dragged arm. Ring: the truth.",
    presets={
        "colour": {"mix": "colour"},
        "all cues": {"mix": "all"},
        "near the truth": {"mix": "all", "away": views.ACROSS[1], "bend": views.DOWN[3]},
    },
    axes=partial(figure, 1, 2, width=7.6, height=3.0, gridspec_kw=_AXES),
    finding=lambda state: (state.peaks.count, bool(state.peaks.off <= NEAR)),
    drag=Drag(("away", "bend"), "the hand", views.hand_place),
)
gained = Exploration(
    draw.gaining,
    views.gained,
    views.Gained.words,
    controls={
        "gain": slider("K", views.GAINS, 0.5),
        "wall": choice("Behind", {name: name for name in views.WALLS}, "cluttered, people walk"),
        "stops": toggle("The arms stand still"),
    },
    name="likelihoods-gained",
    caption="Left: the smaller of the distance to an edge and K times that to a moving edge. "
    "Bright: near. Right: the likelihood of the arm's angles by it. Ring: the truth.",
    presets={
        "K of a tenth": {"gain": 0.1},
        "K of 1": {"gain": 1.0},
        "standing still": {"stops": True, "wall": "cluttered"},
        "bare wall": {"wall": "bare"},
    },
    axes=partial(figure, 1, 2, width=7.6, height=3.0, gridspec_kw=_AXES),
    finding=lambda state: (state.same, float(np.degrees(state.peaks.off))),
)

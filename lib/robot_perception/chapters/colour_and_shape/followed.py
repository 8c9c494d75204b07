"""What every tracker makes of films that no number was chosen on: one result for all claims."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

import data_synth.coloured
from robot_perception.appearance import (
    affine_snake,
    colour_distribution,
    colour_shape,
    colour_spaces,
    segmentation,
    shape_scores,
    single_cues,
)
from robot_perception.chapters.colour_and_shape import experiments
from robot_perception.chapters.colour_and_shape.experiments import Config, Result
from robot_perception.teaching.kept import kept

SCORED = tuple(range(2001, 2021))
"""Seeds of the films of each kind; no number was chosen on them."""
FRAMES = 40
"""Frames that are tracked, at 15 a second."""
FEW = 6
"""Films of each kind on which the fused tracker is followed with one thing changed."""
CHANGES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "printed area": {"printed_area": True},
        "no spread": {"noise": 0.0},
        "one sample": {"samples": 1},
    }
)
CODE = (
    data_synth.coloured,
    affine_snake,
    colour_distribution,
    colour_shape,
    colour_spaces,
    segmentation,
    shape_scores,
    single_cues,
    experiments,
)


def followed() -> Result:
    """Return what all trackers make of all films; kept on this computer."""
    return kept(_follow, Result, len(SCORED), "", code=CODE)


def changed(change: str) -> Result:
    """Return what the fused tracker, changed in one of `CHANGES`, makes of the first films."""
    return kept(_follow, Result, FEW, change, code=CODE)


def _follow(films: int, change: str) -> Result:
    config = Config(films=SCORED[:films], frames=FRAMES)
    if change:
        config = replace(
            config,
            trackers=("fused",),
            rules=replace(config.rules, **CHANGES[change]),
            in_rgb=replace(config.in_rgb, **CHANGES[change]),
        )
    return experiments.run(config, rng=np.random.default_rng(43))

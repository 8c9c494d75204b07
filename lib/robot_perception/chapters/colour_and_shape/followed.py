"""What every tracker makes of films that no number was chosen on: one result for all claims."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

import data_synth.coloured
from robot_perception import appearance, beliefs, particles
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.chapters.colour_and_shape import experiments
from robot_perception.chapters.colour_and_shape.experiments import Config, Result
from robot_perception.evaluation import sweep
from robot_perception.teaching.claims import Size
from robot_perception.teaching.kept import kept

SEEDS = tuple(range(2001, 2041))
"""Of the films of each kind; no number was chosen on them."""
FEW = 3
"""Films of each kind at the quick size."""
PRINTED = 10
"""Films of each kind that are followed with the printed sign."""
SOME = 6
"""Films of each kind on which numbers of samples and spaces are compared."""
NEVER = 10.0
"""Of `worst`: no ρ is that great. With the printed sign a perfect match has a ρ of 0.4, so the
threshold that goes with the right sign would give up most right segmentations."""
FRAMES = 40
"""Frames that are tracked, at 15 a second."""
RULES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "unweighed": {"shape": False},
        "printed area": {"printed_area": True, "worst": NEVER},
        "never given up": {"worst": NEVER},
        "one sample, unweighed": {"samples": 1, "shape": False},
        "one sample": {"samples": 1},
        "five samples": {"samples": 5},
        "twenty samples": {"samples": 20},
        "a hundred samples": {"samples": 100},
        "opponent": {"binning": Binning("opponent", (32, 32, 4))},
        "RGB": {"binning": Binning("RGB", (16, 16, 16))},
        "normalised rgb": {"binning": Binning("normalised rgb", (64, 64, 1))},
        "HSI": {"binning": Binning("HSI", (16, 16, 16))},
    }
)
"""What may be different about the fused tracker; the spaces have 4096 cells each."""
CODE = (data_synth.coloured, appearance, beliefs, particles, sweep, experiments)


def films(size: Size) -> int:
    """Return how many films of each kind are followed by all trackers."""
    return len(SEEDS) if size is Size.FULL else FEW


def followed(size: Size) -> Result:
    """Return what all trackers make of all films; kept on this computer."""
    return kept(_follow, Result, films(size), "", code=CODE)


def changed(change: str, count: int = FEW) -> Result:
    """Return what comes of the first films with one thing changed, of `RULES`."""
    return kept(_follow, Result, count, change, code=CODE)


def _follow(count: int, change: str) -> Result:
    config = Config(films=SEEDS[:count], frames=FRAMES)
    if change:
        own = RULES[change]
        config = replace(
            config,
            trackers=("fused",),
            rules=replace(config.rules, **own),
            in_rgb=replace(config.in_rgb, **own),
        )
    return experiments.run(config, rng=np.random.default_rng(43))

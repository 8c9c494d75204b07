"""What every tracker makes of films that no number was chosen on: one result for all claims."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

import data_synth.coloured
from robot_perception import appearance, particles
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.chapters.colour_and_shape import experiments
from robot_perception.chapters.colour_and_shape.experiments import BARE, STEADY, Config, Result
from robot_perception.teaching.claims import Size
from robot_perception.teaching.kept import kept

SEEDS = tuple(range(2001, 2041))
"""Of the films of each kind; no number was chosen on them."""
FEW = 3
"""Films of each kind at the quick size, and of sabotages."""
SOME = 6
"""Films of each kind on which numbers of samples and spaces are compared."""
FRAMES = 40
"""Frames that are tracked, at 15 a second."""
RULES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "unweighed": {"shape": False},
        "printed area": {"printed_area": True},
        "one sample": {"samples": 1},
        "one sample, unweighed": {"samples": 1, "shape": False},
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
FILMS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "steady colours": {"options": STEADY, "trackers": ("colour, fixed", "fused")},
        "nothing else": {"options": BARE, "trackers": ("shape", "fused")},
    }
)
"""What may be different about the films."""
CODE = (data_synth.coloured, appearance, particles, experiments)


def films(size: Size) -> int:
    """Return how many films of each kind are followed by all trackers."""
    return len(SEEDS) if size is Size.FULL else FEW


def followed(size: Size) -> Result:
    """Return what all trackers make of all films; kept on this computer."""
    return kept(_follow, Result, films(size), "", code=CODE)


def changed(change: str, count: int = FEW) -> Result:
    """Return what comes of the first films with one thing changed, of `RULES` or `FILMS`."""
    return kept(_follow, Result, count, change, code=CODE)


def _follow(count: int, change: str) -> Result:
    config = Config(films=SEEDS[:count], frames=FRAMES)
    if change in FILMS:
        config = replace(config, **FILMS[change])
    elif change:
        own = RULES[change]
        config = replace(
            config,
            trackers=("fused",),
            rules=replace(config.rules, **own),
            in_rgb=replace(config.in_rgb, **own),
        )
    return experiments.run(config, rng=np.random.default_rng(43))

"""Films of a person who walks before the robot, and trackers that follow him."""

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float

from data_synth.companion.walks import OCCLUSIONS, WalkFilm, WalkScene, film_walk
from robot_perception.chapters.tutor_following.scene import RULES, SAME
from robot_perception.companion.boxes import overlap_in_pairs
from robot_perception.companion.tutor import (
    PATCHES,
    SILHOUETTE,
    WHOLE,
    TutorModel,
    TutorRules,
    TutorTracker,
)
from robot_perception.teaching.results import kept

FRAMES = 90
LAST = 10
"""Pictures at the end of a film that say whether the person is still followed; ours."""
ONE, SEVERAL = TutorModel(WHOLE, None), TutorModel(PATCHES, SILHOUETTE)
BLIND = TutorModel(PATCHES, None)
FREE = {"gate": 1.0, "whole_gate": 1.0}
SHAPELESS = "several, gated, no shape"
WAYS: Mapping[str, TutorTracker] = MappingProxyType(
    {
        "one patch, adapting": TutorTracker(ONE, TutorRules(**FREE)),
        "one patch, gated": TutorTracker(ONE, TutorRules(gate=1.0, whole_gate=0.25)),
        "one patch, fixed": TutorTracker(ONE, TutorRules(rate=0.0, **FREE)),
        "several, adapting": TutorTracker(SEVERAL, TutorRules(**FREE)),
        "several, gated": TutorTracker(SEVERAL, RULES),
        SHAPELESS: TutorTracker(BLIND, RULES),
        "several, fixed": TutorTracker(SEVERAL, TutorRules(rate=0.0, **FREE)),
    }
)
"""One patch for head and trunk, or four with a silhouette. Adapting: a model takes in 5 % of what
is seen in every picture. Gated: not where the colours are too far off. Fixed: never."""
PASSING = MappingProxyType({name: WalkScene(name) for name in OCCLUSIONS})
"""Nobody passes, or somebody passes below or before the person, or stops beside or before him."""
LIT = MappingProxyType({"to and fro": WalkScene("none", "changing"),
                        "darker": WalkScene("none", "darker")})  # fmt: skip
"""Nobody passes, and the light changes."""
SCENES = MappingProxyType({**PASSING, **LIT})


@lru_cache(maxsize=4)
def film(seed: int, scene: str, frames: int = FRAMES) -> WalkFilm:
    """Return the film of a seed."""
    return film_walk(np.random.default_rng(seed), frames, SCENES[scene])


@kept
def tracked(
    seed: int, scene: str, ways: tuple[str, ...], frames: int = FRAMES
) -> Float[np.ndarray, "ways frames"]:
    """Return how far the boxes of several trackers overlap the person's in each picture."""
    shown = film(seed, scene, frames)
    return np.array([overlaps(WAYS[way], shown, seed) for way in ways])


def overlaps(tracker: TutorTracker, shown: WalkFilm, seed: int) -> Float[np.ndarray, " frames"]:
    """Follow the person of a film and return how far the box overlaps the true one."""
    rng = np.random.default_rng([seed, 1])
    state = tracker.start(shown.frames[0], shown.boxes[0], rng=rng)
    found = [state.box]
    for image in shown.frames[1:]:
        state, _ = tracker.step(state, image, rng=rng)
        found.append(state.box)
    return overlap_in_pairs(np.array(found), shown.boxes)


def locked(overlap: Float[np.ndarray, "... frames"]) -> Bool[np.ndarray, "..."] | bool:
    """Tell whether the person is still followed at the end of a film."""
    found = np.median(overlap[..., -LAST:], axis=-1) >= SAME
    return found if overlap.ndim > 1 else bool(found)

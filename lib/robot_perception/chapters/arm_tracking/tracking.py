"""Films of people who point and gesture, and trackers that follow their arms."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import cv2
import numpy as np
from jaxtyping import Bool, Float

from data_synth.arms.gestures import ArmFilm, ArmScene, film_arms
from robot_perception.arms.likelihoods import (
    COLOUR,
    TEXTURE,
    Cue,
    EdgeCue,
    PatchCue,
    edge_weight,
)
from robot_perception.arms.tracker import (
    BOUNDS,
    CUES,
    ArmRules,
    ArmState,
    ArmTracker,
    CueMaker,
    First,
    find_face,
)
from robot_perception.cameras import Pinhole
from robot_perception.companion.faces.region import FaceTracker
from robot_perception.teaching.results import kept

CAMERA = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
FRAMES = 60
BEGIN, LAST = 15, 15
"""Pictures after which errors count, and those at the end that tell whether an arm is held."""
HELD = 15.0
"""An arm is held at the end if its wrist is that near on average, px: some 9 cm; ours."""
SCENES: Mapping[str, ArmScene] = MappingProxyType(
    {
        "pointing, plain": ArmScene("pointing"),
        "gesturing, plain": ArmScene("gesturing"),
        "pointing, clutter": ArmScene("pointing", 40, 2),
        "gesturing, clutter": ArmScene("gesturing", 40, 2),
        "near, plain": ArmScene("near"),
    }
)
"""One arm after the other points, or both gesture, or stay near the body; a bare wall, or forty
things on it and two people who walk behind."""
PLAIN, CLUTTER = "pointing, plain", "gesturing, clutter"


def _plain_edges(first: First) -> Cue:
    return EdgeCue(weight=edge_weight(first.seen))


def _tolled_edges(first: First) -> Cue:
    return EdgeCue(toll=1.0, weight=edge_weight(first.seen))


def _even(channels: tuple[int, ...]) -> CueMaker:
    def make(first: First) -> Cue:
        return PatchCue(first.patches, first.reference, channels)

    return make


def _without(*names: str) -> dict[str, CueMaker]:
    return {name: maker for name, maker in CUES.items() if name not in names}


EVEN = {**CUES, "colour": _even(COLOUR), "texture": _even(TEXTURE)}
WAYS: Mapping[str, tuple[Mapping[str, CueMaker], Mapping[str, CueMaker]]] = MappingProxyType(
    {
        "all cues": (CUES, BOUNDS),
        "contours only": ({**_without("colour", "texture"), "edges": _plain_edges}, BOUNDS),
        "no patches": (_without("colour", "texture"), BOUNDS),
        "no motion": ({**CUES, "edges": _plain_edges}, BOUNDS),
        "a toll in place of K": ({**CUES, "edges": _tolled_edges}, BOUNDS),
        "no contours": (_without("edges"), BOUNDS),
        "no colour": (_without("colour"), BOUNDS),
        "no texture": (_without("texture"), BOUNDS),
        "no stabiliser": (_without("stabiliser"), BOUNDS),
        "patches trusted alike": (EVEN, BOUNDS),
        "no collisions": (CUES, {"limits": BOUNDS["limits"]}),
        "no picture": ({"stabiliser": CUES["stabiliser"]}, BOUNDS),
    }
)
"""Cues and bounds: those of the paper, or without one of them."""


@lru_cache(maxsize=3)
def film(seed: int, scene: str, frames: int = FRAMES, **changes: float) -> ArmFilm:
    """Return the film of a seed, with some numbers of its scene changed."""
    return film_arms(np.random.default_rng(seed), frames, replace(SCENES[scene], **changes))


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """What a tracker made of a film.

    Parameters
    ----------
    states, spreads : (n, 8)
        Mean and standard deviation in each picture, rad.
    angles : (n, 8)
        Size of the error of each angle, rad.
    wrists : (n, 2)
        From the estimated wrists to the true ones in the picture, px.
    hands : (n, 2)
        The same in space, m.
    saved, effective : (n,)
        Share of the particles that were not measured, and effective number of particles.
    lost : (n,)
        Whether the tracker took the arms to be lost.
    found : ()
        Whether the face was found; it was told otherwise.
    """

    states: Float[np.ndarray, "n 8"]
    spreads: Float[np.ndarray, "n 8"]
    angles: Float[np.ndarray, "n 8"]
    wrists: Float[np.ndarray, "n 2"]
    hands: Float[np.ndarray, "n 2"]
    saved: Float[np.ndarray, " n"]
    effective: Float[np.ndarray, " n"]
    lost: Bool[np.ndarray, " n"]
    found: Bool[np.ndarray, ""]

    @property
    def held(self) -> Bool[np.ndarray, " 2"]:
        """Whether each arm is held at the end."""
        return self.wrists[-LAST:].mean(axis=0) < HELD

    @property
    def angle(self) -> float:
        """Mean error of the angles, degrees."""
        return float(np.degrees(self.angles[BEGIN:].mean()))

    @property
    def each(self) -> Float[np.ndarray, " 4"]:
        """Mean error of α, β, γ and δ, degrees."""
        return np.degrees(self.angles[BEGIN:].reshape(-1, 4).mean(axis=0))

    @property
    def wrist(self) -> float:
        """Median error of the wrists, px."""
        return float(np.median(self.wrists[BEGIN:]))


def tracker(
    way: str = "all cues", *, filter: str = "auxiliary", particles: int = 400
) -> ArmTracker:
    """Return a tracker with cues of a name."""
    cues, bounds = WAYS[way]
    rules = ArmRules(particles=particles, filter=filter)
    return ArmTracker(CAMERA, rules=rules, cues=cues, bounds=bounds)


def started(
    following: ArmTracker, shown: ArmFilm, rng: np.random.Generator
) -> tuple[ArmState, bool]:
    """Return the state after the first picture, and whether the face was found in it."""
    try:
        face, found = find_face(shown.frames[0]), True
    except ValueError:  # the detector misses some faces, dark ones above all
        face, found = shown.face, False
    return following.start(shown.frames[0], rng=rng, face=face), found


def follow(following: ArmTracker, shown: ArmFilm, seed: int, *, moving: bool = False) -> Run:
    """Track the arms of a film; the shoulders stay, or go with the face."""
    rng = np.random.default_rng([seed, 1])
    state, found = started(following, shown, rng)
    model, faces = state.first.model, FaceTracker()
    place = faces.start(shown.face if not found else find_face(shown.frames[0]))
    nothing = (0.0, float(following.rules.particles), False)
    rows = [(state.mean, state.spread, model.joints(state.mean[None])[0], *nothing)]
    for image in shown.frames[1:]:
        if moving:
            place, _ = faces.step(place, cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        state, info = following.step(state, image, rng=rng, face=place.box if moving else None)
        rows.append((state.mean, state.spread, info.joints, info.saved, info.effective, info.lost))
    states, spreads, joints, saved, effective, lost = (
        np.array(part) for part in zip(*rows, strict=True)
    )
    wrists = model.pixels(joints[:, :, 2]) - shown.stage.pixels(shown.joints[:, :, 2])
    hands = joints[:, :, 2] - shown.joints[:, :, 2]
    sizes = (np.linalg.norm(part, axis=-1) for part in (wrists, hands))
    return Run(
        states, spreads, np.abs(states - shown.angles), *sizes, saved, effective, lost,
        np.array(found),
    )  # fmt: skip


@kept
def tracked(
    seed: int,
    scene: str,
    way: str = "all cues",
    filter: str = "auxiliary",
    particles: int = 400,
    frames: int = FRAMES,
) -> Run:
    """Track the arms of the film of a seed."""
    return follow(tracker(way, filter=filter, particles=particles), film(seed, scene, frames), seed)

"""Films of people who point and gesture, and trackers that follow their arms."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import cv2
import numpy as np
from jaxtyping import Bool, Float

from data_synth.arms.gestures import ArmFilm, ArmScene, film_arms
from robot_perception.arms.likelihoods import Cue, EdgeCue, edge_weight
from robot_perception.arms.tracker import (
    BOUNDS,
    CUES,
    ArmRules,
    ArmTracker,
    CueMaker,
    First,
    find_face,
)
from robot_perception.cameras import Pinhole
from robot_perception.companion.faces.region import FaceTracker

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


def _without(*names: str) -> dict[str, CueMaker]:
    return {name: maker for name, maker in CUES.items() if name not in names}


WAYS: Mapping[str, tuple[Mapping[str, CueMaker], Mapping[str, CueMaker]]] = MappingProxyType(
    {
        "all cues": (CUES, BOUNDS),
        "contours only": ({**_without("colour", "texture"), "edges": _plain_edges}, BOUNDS),
        "no patches": (_without("colour", "texture"), BOUNDS),
        "no motion": ({**CUES, "edges": _plain_edges}, BOUNDS),
        "no contours": (_without("edges"), BOUNDS),
        "no picture": ({"stabiliser": CUES["stabiliser"]}, BOUNDS),
    }
)
"""Cues and bounds: those of the paper, or without some of them."""


@lru_cache(maxsize=3)
def film(
    seed: int, scene: str, frames: int = FRAMES, varied: float = 0.0, **changes: float
) -> ArmFilm:
    """Return the film of a seed, with some numbers of its scene changed."""
    happens = replace(SCENES[scene], varied=varied, **changes)
    return film_arms(np.random.default_rng(seed), frames, happens)


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """What a tracker made of a film.

    Parameters
    ----------
    states : (n, 8)
        Mean in each picture, rad.
    angles : (n, 8)
        Size of the error of each angle, rad.
    wrists : (n, 2)
        From the estimated wrists to the true ones in the picture, px.
    saved, effective : (n,)
        Share of the particles that were not measured, and effective number of particles.
    lost : (n,)
        Whether the tracker took the arms to be lost.
    """

    states: Float[np.ndarray, "n 8"]
    angles: Float[np.ndarray, "n 8"]
    wrists: Float[np.ndarray, "n 2"]
    saved: Float[np.ndarray, " n"]
    effective: Float[np.ndarray, " n"]
    lost: Bool[np.ndarray, " n"]

    @property
    def angle(self) -> float:
        """Mean error of the angles, degrees."""
        return float(np.degrees(self.angles[BEGIN:].mean()))


def tracker(
    way: str = "all cues", *, filter: str = "auxiliary", particles: int = 400
) -> ArmTracker:
    """Return a tracker with cues of a name."""
    cues, bounds = WAYS[way]
    rules = ArmRules(particles=particles, filter=filter)
    return ArmTracker(CAMERA, rules=rules, cues=cues, bounds=bounds)


def face_of(shown: ArmFilm) -> Float[np.ndarray, " 4"]:
    """Return the face that is found in the first picture, and the true one where none is."""
    try:
        return find_face(shown.frames[0])
    except ValueError:  # the detector misses some faces, dark ones above all
        return shown.face


def follow(following: ArmTracker, shown: ArmFilm, seed: int, *, moving: bool = False) -> Run:
    """Track the arms of a film, and compare them with the true ones.

    The shoulders stay where the first face puts them, or go with the face as a Kalman filter
    follows it.
    """
    rng, face = np.random.default_rng([seed, 1]), face_of(shown)
    state = following.start(shown.frames[0], rng=rng, face=face)
    model, faces = state.first.model, FaceTracker()
    place = faces.start(face)
    rows = [(state.mean, model.joints(state.mean[None])[0], 0.0,
             float(following.rules.particles), False)]  # fmt: skip
    for image in shown.frames[1:]:
        if moving:
            place, _ = faces.step(place, cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        state, info = following.step(state, image, rng=rng, face=place.box if moving else None)
        rows.append((state.mean, info.joints, info.saved, info.effective, info.lost))
    states, joints, saved, effective, lost = (np.array(part) for part in zip(*rows, strict=True))
    off = model.pixels(joints[:, :, 2]) - shown.stage.pixels(shown.joints[:, :, 2])
    wrists = np.linalg.norm(off, axis=-1)
    return Run(states, np.abs(states - shown.angles), wrists, saved, effective, lost)

"""Two arms: a film by all cues, and what its stages take."""

import time
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from data_synth.arms.gestures import ArmScene, film_arms
from robot_perception.arms.body_model import REST, BodyModel, contours_textbook
from robot_perception.arms.likelihoods import (
    Bodies,
    EdgeCue,
    PatchCue,
    look,
)
from robot_perception.arms.tracker import ArmTracker
from robot_perception.book.arm_tracking import CAMERA, IMAGES, WHOLE
from robot_perception.companion.cues import patch_histograms, patch_histograms_textbook
from tests.tools.benchmarks.harness import Row, Timing

MOST = 1.15
PARTICLES, LEAST = 400, 40
"""Of the paper; and the pictures a second that are asked for."""


def growth(name: str, sizes: tuple[int, ...], work: Callable[[int], object]) -> Timing:
    """Return the exponent with which a time grows: 1 where each particle or point costs as much."""
    samples = []
    for _ in range(7):
        for size in sizes:  # in turn, so that a busy spell hits all sizes
            begin = time.perf_counter()
            work(size)
            samples.append(time.perf_counter() - begin)
    seconds = np.median(np.reshape(samples, (-1, len(sizes))), axis=0)
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    return Timing(
        f"arms scored with {sizes[0]} to {sizes[-1]} {name}: exponent {exponent:.2f}",
        float(seconds[-1]),
        None,
        "",
        target=f"exponent ≤ {MOST}",
        reached=exponent <= MOST,
    )


def rows() -> list[Row | Timing]:
    """Return the rows of the benchmark table that concern two arms."""
    film = film_arms(np.random.default_rng(3), IMAGES + 1, ArmScene("pointing"))
    model = BodyModel.from_face(film.face, CAMERA)
    rng = np.random.default_rng(4)
    states = film.angles[20] + rng.normal(0, 0.15, (PARTICLES, 8))
    patches, grey = model.place(REST), cv2.cvtColor(film.frames[19], cv2.COLOR_RGB2GRAY)
    seen = look(film.frames[20], grey)
    surface = model.surface(states, patches)
    covered = seen.channels, surface.points, surface.visible
    rest = model.surface(REST[None], patches)
    reference = patch_histograms(look(film.frames[0]).channels, rest.points, rest.visible)[0][0]
    tracker = ArmTracker(CAMERA)

    def finer(times: int) -> BodyModel:
        return replace(model, counts=tuple(times * count for count in model.counts))

    def tracked() -> np.ndarray:
        rng = np.random.default_rng(6)
        state = tracker.start(film.frames[0], rng=rng, face=film.face, pose=film.angles[0])
        for image in film.frames[1:]:
            state, _ = tracker.step(state, image, rng=rng)
        return model.pixels(model.joints(state.mean[None]))[0, :, 2]

    def same_wrists() -> None:
        true = film.stage.pixels(film.joints[-1, :, 2])
        assert np.linalg.norm(tracked() - true, axis=1).max() < 20

    def same_outlines() -> None:
        few = states[:5]
        fast, plain = model.contours(few), contours_textbook(model, few)
        np.testing.assert_array_equal(fast.visible, plain.visible)

    def same_colours() -> None:
        functions = patch_histograms, patch_histograms_textbook
        np.testing.assert_allclose(*(function(*covered)[0] for function in functions))

    return [
        Row(
            work=f"{WHOLE}, {PARTICLES} particles, {IMAGES} images of 320 × 240",
            ours=tracked,
            at_most=IMAGES / LEAST,
            agree=same_wrists,
            repeats=3,
        ),
        Row(
            work=f"arms in outline, hidden parts told, {PARTICLES} particles",
            ours=lambda: model.contours(states),
            peer=lambda: contours_textbook(model, states),
            peer_name="as written",
            ratio=100.0,
            agree=same_outlines,
            repeats=3,
        ),
        Row(
            work=f"arms by the colours of their patches, {PARTICLES} particles",
            ours=lambda: patch_histograms(*covered),
            peer=lambda: patch_histograms_textbook(*covered),
            peer_name="as written",
            ratio=20.0,
            agree=same_colours,
            repeats=3,
        ),
        Row(
            work="arms looked at: flow, edges, distance transforms",
            ours=lambda: look(film.frames[20], grey),
        ),
        Row(
            work=f"arms covered by patches, and which of these are seen, {PARTICLES} particles",
            ours=lambda: model.surface(states, patches),
        ),
        Row(
            work=f"arms scored by contours, {PARTICLES} particles",
            ours=lambda: EdgeCue(gain=0.5)(seen, Bodies(model, states)),
        ),
        Row(
            work=f"arms scored by patches, {PARTICLES} particles",
            ours=lambda: PatchCue(patches, reference)(seen, Bodies(model, states)),
        ),
        Row(
            work=f"arms tested for collisions, {PARTICLES} particles",
            ours=lambda: model.collides(states),
        ),
        growth(
            "particles",
            (400, 800, 1600, 3200),
            lambda n: EdgeCue(gain=0.5)(seen, Bodies(model, np.resize(states, (n, 8)))),
        ),
        growth(
            "points on an outline",
            (76, 152, 304, 608),
            lambda n: EdgeCue(gain=0.5)(seen, Bodies(finer(n // 76), states)),
        ),
    ]

"""What figures, films and explorers show: films of people who point and gesture, and tracks."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, UInt8

from data_synth.arms.gestures import ArmFilm
from robot_perception.arms.body_model import BodyModel
from robot_perception.arms.tracker import ArmState
from robot_perception.chapters.arm_likelihoods.scene import CHOOSING
from robot_perception.chapters.arm_tracking.tracking import (
    CAMERA,
    CLUTTER,
    HELD,
    LAST,
    PLAIN,
    Run,
    face_of,
    film,
    follow,
    tracker,
)
from studies.stored.recorded import recorded

POINTS, GESTURES = CHOOSING[9], CHOOSING[17]
"""Seeds of the films that are shown; none that is scored."""
FRAMES = 48
TIMES = (0, 8, 16, 24, 32, 40, 47)
"""Pictures that can be looked at."""
FILTERS = ("auxiliary", "condensation", "importance")
FOUR = (*FILTERS, "apart")
COUNTS = (50, 200, 800)
SCENES = {"bare wall": "gesturing, plain", "clutter": CLUTTER}
WAYS = ("all cues", "contours only", "no patches", "no motion")
RUNS = (
    (POINTS, PLAIN, WAYS[0], FILTERS[0], 400),
    *product((GESTURES,), SCENES.values(), WAYS, FILTERS[:1], (400,)),
    *product((GESTURES,), (SCENES["bare wall"],), WAYS[:1], FILTERS, COUNTS),
)
"""Seed, scene, cues, filter and particles of all that is shown."""


@dataclass(frozen=True, eq=False, slots=True)
class Tracked:
    """A picture of a film, and where a tracker has the arms.

    Parameters
    ----------
    image : (240, 320, 3)
        The picture.
    points, visible : (n, 2), (n,)
        Silhouette of the estimate.
    true, joints : (2, 4, 3)
        Shoulders, elbows, wrists and fingertips, in truth and estimated, m.
    sticks : (2, 4, 2)
        The true ones in the picture, px.
    wrists : (frames, 2)
        From the estimated wrists to the true ones in each picture, px.
    time
        Which picture it is.
    """

    image: UInt8[np.ndarray, "240 320 3"]
    points: Float[np.ndarray, "n 2"]
    visible: Bool[np.ndarray, " n"]
    true: Float[np.ndarray, "2 4 3"]
    joints: Float[np.ndarray, "2 4 3"]
    sticks: Float[np.ndarray, "2 4 2"]
    wrists: Float[np.ndarray, "frames 2"]
    time: int

    @property
    def held(self) -> int:
        """How many arms are held at the end of the film."""
        return int((self.wrists[-LAST:].mean(axis=0) < HELD).sum())

    def words(self) -> str:
        """Return what the drawing shows."""
        off = " and ".join(f"{px:.0f}" for px in self.wrists[self.time])
        end = ("neither arm is held", "one arm is held", "both arms are held")[self.held]
        return f"Picture {self.time}: the wrists are off by {off} px. At the end {end}."


@lru_cache(maxsize=4)
def body(seed: int, scene: str) -> BodyModel:
    """Return the model that a tracker has of the person of a film."""
    return BodyModel.from_face(face_of(film(seed, scene, FRAMES)), CAMERA)


@recorded("arms-followed", RUNS)
def followed(seed: int, scene: str, way: str, filter: str, particles: int) -> Run:
    """Return what a tracker makes of a film that is shown."""
    shown = film(seed, scene, FRAMES)
    return follow(tracker(way, filter=filter, particles=particles), shown, seed)


@lru_cache(maxsize=512)
def moment(
    seed: int, scene: str, time: int, way: str = "all cues", filter: str = "auxiliary",
    particles: int = 400,
) -> Tracked:  # fmt: skip
    """Return a picture of a film with what a tracker makes of it."""
    shown = film(seed, scene, FRAMES)
    run = followed(seed, scene, way, filter, particles)
    model = body(seed, scene)
    state = run.states[time][None]
    contours = model.contours(state)
    return Tracked(
        shown.frames[time], contours.points[0], contours.visible[0], shown.joints[time],
        model.joints(state)[0], shown.stage.pixels(shown.joints[time]), run.wrists, time,
    )  # fmt: skip


def pointing(time: int) -> Tracked:
    """Return a picture of somebody who points before a bare wall, tracked by all cues."""
    return moment(POINTS, PLAIN, time)


def first(seed: int = POINTS) -> tuple[ArmFilm, ArmState]:
    """Return the film of somebody who points, and what is known after its first picture."""
    shown = film(seed, PLAIN, FRAMES)
    rng = np.random.default_rng(seed)
    return shown, tracker().start(shown.frames[0], rng=rng, face=face_of(shown))


WHOLE = "arms tracked by all cues"
"""How the row of the benchmarks begins that tells what a film takes."""
IMAGES = 39
"""Of that film."""

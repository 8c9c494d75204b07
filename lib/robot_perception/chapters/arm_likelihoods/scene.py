"""A person before the camera, a picture at rest and one of a gesture, and what is made of them."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from jaxtyping import Float, UInt8

from data_synth.arms.bodies import make_person
from data_synth.arms.gestures import ArmScene, film_arms, make_motion
from data_synth.companion.faces import make_identity
from robot_perception.arms.body_model import BodyModel
from robot_perception.arms.likelihoods import (
    TEXTURE,
    Bodies,
    Cue,
    EdgeCue,
    Look,
    PatchCue,
    look,
    summed,
)
from robot_perception.arms.tracker import First
from robot_perception.cameras import Pinhole
from robot_perception.companion.cues import patch_histograms
from robot_perception.teaching.tables import Table

CAMERA = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
CHOOSING = tuple(range(100, 140))
"""Seeds of people and films on which numbers were chosen."""
SCORED = tuple(range(5000, 5400))
"""Those that are scored."""
GAIN = 0.5
"""K; ours."""
AWAY, BEND = 0, 3
"""Which angles of the arm on the left are swept: away from the body, and the elbow's."""
AWAYS = np.radians(np.arange(-10.0, 150.1, 5.0))
BENDS = np.radians(np.arange(0.0, 140.1, 5.0))
CLUTTER, PASSERS = 40, 2
"""Things on the wall and people who walk behind, in a cluttered scene."""


@dataclass(frozen=True, eq=False, slots=True)
class Glance:
    """Two pictures of somebody: at rest, and in a gesture.

    Parameters
    ----------
    image : (240, 320, 3)
        Of the gesture.
    seen
        What it says, together with the picture before it.
    angles : (8,)
        True ones, rad.
    wrists : (2, 2)
        Where the wrists are in the picture, px.
    parts : (240, 320)
        Which part each pixel is of.
    first
        What is known from the picture at rest.
    """

    image: UInt8[np.ndarray, "240 320 3"] = field(repr=False)
    seen: Look = field(repr=False)
    angles: Float[np.ndarray, " 8"]
    wrists: Float[np.ndarray, "2 2"]
    parts: UInt8[np.ndarray, "240 320"] = field(repr=False)
    first: First = field(repr=False)

    @property
    def model(self) -> BodyModel:
        """The body."""
        return self.first.model


@lru_cache(maxsize=16)
def glance(
    seed: int,
    clutter: int = 0,
    passers: int = 0,
    stops: bool = False,
    off: float = 0.0,
    pose: tuple[float, ...] | None = None,
) -> Glance:
    """Return the pictures of a seed.

    Parameters
    ----------
    seed
        Of person, room and gesture.
    clutter, passers
        Behind the person.
    stops
        Whether the arms stand still when the second picture is taken.
    off
        By which the pose at rest is told wrongly, rad.
    pose
        Of the gesture, rad; one that is drawn if not given.
    """
    rng = np.random.default_rng(seed)
    person, scene = make_person(rng, make_identity(rng)), ArmScene("gesturing", clutter, passers)
    motion = make_motion(rng, 21, scene, person)
    if pose is not None:
        motion[20] = pose
        motion[19] = motion[20] + 0.1
    shown = film_arms(rng, 3, scene, person, angles=motion[[0, 20 if stops else 19, 20]])
    rest, before, now = shown.frames
    model = BodyModel.from_face(shown.face, CAMERA)
    begin = look(rest)
    told = motion[0] + off
    patches = model.place(told)
    surface = model.surface(told[None], patches)
    reference = patch_histograms(begin.channels, surface.points, surface.visible)[0][0]
    seen = look(now, look(before).grey)
    wrists = shown.stage.pixels(shown.joints[2, :, 2])
    first = First(begin, model, told, patches, reference)
    return Glance(now, seen, shown.angles[2], wrists, shown.parts[2], first)


def cues(first: First) -> dict[str, Cue]:
    """Return the cues whose surfaces are drawn, by name."""
    return {
        "shape": EdgeCue(),
        "shape and motion": EdgeCue(gain=GAIN),
        "colour": PatchCue(first.patches, first.reference),
        "texture": PatchCue(first.patches, first.reference, TEXTURE),
    }


MIXES: dict[str, tuple[str, ...]] = {
    "shape": ("shape",),
    "shape, motion": ("shape and motion",),
    "colour": ("colour",),
    "shape, colour": ("shape", "colour"),
    "all": ("shape and motion", "colour", "texture"),
}
"""Which cues are multiplied."""


def swept(angles: Float[np.ndarray, " 8"]) -> Float[np.ndarray, "m 8"]:
    """Return states in which two angles of the arm on the left take all values of the sweep."""
    states = np.tile(angles, (len(AWAYS) * len(BENDS), 1))
    states[:, AWAY] = np.repeat(AWAYS, len(BENDS))
    states[:, BEND] = np.tile(BENDS, len(AWAYS))
    return states


def surfaces(shown: Glance) -> dict[str, Float[np.ndarray, "aways bends"]]:
    """Return the logarithm of each cue's likelihood over the sweep."""
    bodies = Bodies(shown.model, swept(shown.angles))
    logs = summed(cues(shown.first), shown.seen, bodies)
    return {name: log.reshape(len(AWAYS), len(BENDS)) for name, log in logs.items()}


def setup_table() -> Table:
    """Return what the paper gives, what is ours, and what matters."""
    rows = {
        "angles of an arm": ("4", "4", "their order is ours"),
        "colour bins of a channel": ("N_bi", "8", "not tested"),
        "gain K of moving edges": ("a constant", f"{GAIN}", "yes: below 1"),
        "largest distance to an edge": ("–", "5 px", "yes"),
        "patches of an arm": ("3", "3", "not tested"),
        "pull of the stabiliser": ("negligible", "0.15 per rad²", "little"),
    }
    return Table(rows, {"paper": "its values", "ours": "", "matters": ""})

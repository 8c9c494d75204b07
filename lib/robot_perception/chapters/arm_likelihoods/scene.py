"""A person before the camera: a picture at rest and one of a gesture, and what is known of both."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import sympy
from jaxtyping import Bool, Float, UInt8

from data_synth.arms.bodies import Outfit, make_person
from data_synth.arms.gestures import ArmScene, film_arms, make_motion
from data_synth.companion.faces import make_identity
from robot_perception.arms.body_model import BodyModel
from robot_perception.arms.likelihoods import (
    TEXTURE,
    Cue,
    EdgeCue,
    Look,
    PatchCue,
    look,
)
from robot_perception.arms.tracker import First
from robot_perception.cameras import Pinhole
from robot_perception.companion.cues import patch_histograms

CAMERA = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
CHOOSING = tuple(range(100, 140))
"""Seeds of people and films on which numbers were chosen."""
SHOWN = CHOOSING[10]
"""Seed of the person that is shown; none that is scored."""
GAIN = 0.5
"""K; ours."""
AWAY, BEND = 0, 3
"""Angles of the arm on the left that are swept: away from the body, and the elbow's."""
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
    outfit
        What the person wears.
    """

    image: UInt8[np.ndarray, "240 320 3"] = field(repr=False)
    seen: Look = field(repr=False)
    angles: Float[np.ndarray, " 8"]
    wrists: Float[np.ndarray, "2 2"]
    parts: UInt8[np.ndarray, "240 320"] = field(repr=False)
    first: First = field(repr=False)
    outfit: Outfit = field(repr=False)

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
    return Glance(now, seen, shown.angles[2], wrists, shown.parts[2], first, person.outfit)


def cues(first: First) -> dict[str, Cue]:
    """Return the cues whose surfaces are drawn, by name."""
    return {
        "shape": EdgeCue(),
        "shape and motion": EdgeCue(gain=GAIN),
        "colour": PatchCue(first.patches, first.reference),
        "texture": PatchCue(first.patches, first.reference, TEXTURE),
    }


def swept(angles: Float[np.ndarray, " 8"]) -> Float[np.ndarray, "m 8"]:
    """Return states in which two angles of the arm on the left take all values of the sweep."""
    states = np.tile(angles, (len(AWAYS) * len(BENDS), 1))
    states[:, AWAY] = np.repeat(AWAYS, len(BENDS))
    states[:, BEND] = np.tile(BENDS, len(AWAYS))
    return states


def held_to_the_side(bend: float, about: float = 1.2) -> Float[np.ndarray, " 8"]:
    """Return a pose in which both arms are held to the side, their upper arms turned, rad."""
    return np.tile([1.2, 0.3, about, bend], 2)


def kinds(of: Glance) -> list[str]:
    """Return what each patch of somebody is on."""
    sleeve = "plain sleeve" if of.outfit.pattern == "plain" else "printed sleeve"
    bare = "bare forearm" if of.outfit.short else sleeve
    return [(sleeve, bare, "hand")[limb % 3] for limb in of.first.patches.limbs]


def shown() -> Glance:
    """Return the person that is shown, before a cluttered wall with others who walk behind."""
    return glance(SHOWN, CLUTTER, PASSERS)


def outline(
    of: Glance, state: Float[np.ndarray, " 8"]
) -> tuple[Float[np.ndarray, "n 2"], Bool[np.ndarray, " n"]]:
    """Return the silhouette of a pose, and which of its points are seen."""
    contours = of.model.contours(state[None])
    return contours.points[0], contours.visible[0]


def derivative() -> sympy.MatrixBase:
    """Return the derivative of the forearm's direction by γ at a straight elbow, by algebra."""
    alpha, beta, gamma, delta = sympy.symbols("alpha beta gamma delta", real=True)
    sin, cos = sympy.sin, sympy.cos
    u = sympy.Matrix([sin(alpha) * cos(beta), cos(alpha) * cos(beta), -sin(beta)])
    e1 = sympy.Matrix([cos(alpha), -sin(alpha), 0])
    w = cos(delta) * u + sin(delta) * (cos(gamma) * e1 + sin(gamma) * u.diff(beta))
    return sympy.simplify(w.diff(gamma).subs(delta, 0))

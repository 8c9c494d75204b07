"""Films of a person who walks before a following robot, while others pass and the light changes."""

import math
from dataclasses import dataclass, field

import numpy as np

from data_synth._checks import generator, instance, number, whole
from data_synth.coloured.filming import one_of, wave
from data_synth.companion.canvas import lay, photograph
from data_synth.companion.faces import FaceIdentity, make_identity
from data_synth.companion.hall import RobotCamera, make_hall
from data_synth.companion.walking import HIGH, Clothes, body_sprite, make_clothes

__all__ = ["OCCLUSIONS", "REGION", "WalkFilm", "WalkScene", "film_walk", "person_box"]

OCCLUSIONS = {
    "none": (0, 0.0),
    "short, half": (0, 0.24),
    "short, whole": (0, 0.0),
    "long, half": (25, 0.24),
    "long, whole": (25, 0.0),
}
"""Number of pictures for which the passer-by stops before the person, and distance beside, m."""
LIGHTS = ("steady", "changing", "darker")
_DARK = np.array([0.36, 0.30, 0.24])  # what is left of the light at the end of the way
REGION = (-0.25, 0.93, 0.25, 1.75)
"""Region that a tracker is told to follow: head and trunk, m to the right of the middle and
above the ground."""
_PACE = 0.11  # of who passes, m a picture: 1.1 m/s


@dataclass(frozen=True, slots=True)
class WalkScene:
    """Scene of a film.

    Parameters
    ----------
    occlusion
        One of `OCCLUSIONS`: somebody walks past between the robot and the person, stops there for
        long or not, and hides the half or the whole of him. ``"short, half"`` passes below: a
        child's height.
    light
        ``"steady"``; ``"changing"``, to and fro in brightness and colour; or ``"darker"``: the way
        leads out of the light into a part of the hall that has a third of it, in a warmer colour.
    alike
        Whether who passes wears the same clothes.
    others
        How many walk in the hall behind.
    sway
        How much robot and person weave, 1 as usual.
    """

    occlusion: str = "short, whole"
    light: str = "steady"
    alike: bool = False
    others: int = 2
    sway: float = 1.0

    def __post_init__(self) -> None:
        one_of("occlusion", self.occlusion, tuple(OCCLUSIONS))
        one_of("light", self.light, LIGHTS)
        instance("alike", self.alike, bool)
        whole("others", self.others, 0, 10)
        number("sway", self.sway, 0.0, 5.0)


@dataclass(frozen=True, eq=False, slots=True)
class WalkFilm:
    """A film, and where the person truly is.

    Parameters
    ----------
    frames : (n, 240, 320, 3)
        Red, green and blue.
    boxes : (n, 4)
        Left, top, width and height of the person's head and trunk, px; they may leave the picture.
    visible : (n,)
        Share of that box that nobody hides and that lies in the picture.
    passer : (n, 4)
        The same box of who passes; of no size where nobody does.
    light : (n, 3)
        On everything: red, green, blue.
    """

    frames: np.ndarray = field(repr=False)
    boxes: np.ndarray = field(repr=False)
    visible: np.ndarray = field(repr=False)
    passer: np.ndarray = field(repr=False)
    light: np.ndarray = field(repr=False)


def person_box(camera: RobotCamera, ahead: float, left: float) -> np.ndarray:
    """Return the box (4,) of the head and trunk of somebody who stands there."""
    instance("camera", camera, RobotCamera)
    left = number("left", left)
    u0, v1 = camera.project(ahead, left - REGION[0], REGION[1])
    u1, v0 = camera.project(ahead, left - REGION[2], REGION[3])
    return np.array([u0, v0, u1 - u0, v1 - v0])


def film_walk(
    rng: np.random.Generator, frames: int = 90, scene: WalkScene | None = None
) -> WalkFilm:
    """Return a film of ten pictures a second.

    Parameters
    ----------
    rng
        Source of people, clothes, ways, the hall, the light and the noise.
    frames
        How many, 40 to 400.
    scene
        What happens; by default somebody passes once and hides the person for a moment.
    """
    generator(rng)
    frames = whole("frames", frames, 40, 400)
    scene = WalkScene() if scene is None else instance("scene", scene, WalkScene)
    parts = [np.random.default_rng(seed) for seed in rng.integers(2**63, size=6)]
    looks, ways, walls, air, noise, behind = parts
    camera, hall = RobotCamera(), make_hall(walls, length=24.0)
    who, clothes = make_identity(looks), make_clothes(looks)
    other, dress = make_identity(looks), make_clothes(looks)
    dress = clothes if scene.alike else dress
    crowd = [(make_identity(behind), make_clothes(behind)) for _ in range(scene.others)]
    starts = behind.uniform((6.0, -3.0), (11.0, 3.0), (scene.others, 2))
    paces = behind.choice([-1, 1], scene.others) * behind.uniform(0.04, 0.10, scene.others)

    side, near = wave(0.45 * scene.sway, (35, 90), rng=ways), wave(0.35, (40, 110), rng=ways)
    turn, bump = wave(0.07 * scene.sway, (25, 70), rng=ways), wave(2.0, (7, 15), rng=ways)
    bright, warm = wave(0.38, (30, 80), rng=air), wave(0.22, (35, 90), rng=air)
    stop, beside = OCCLUSIONS[scene.occlusion]
    passes = scene.occlusion != "none"
    low = scene.occlusion == "short, half"
    sense = float(ways.choice([-1, 1]))
    meets = frames * 0.45 - stop / 2
    nearer = ways.uniform(0.62, 0.72)

    images = np.empty((frames, *camera.size, 3), dtype=np.uint8)
    boxes, passer = np.empty((frames, 4)), np.zeros((frames, 4))
    visible, light = np.empty(frames), np.ones((frames, 3))
    for t in range(frames):
        if scene.light == "changing":
            light[t] = (1 + bright(t)) * (1 + warm(t) * np.array([1.0, 0.0, -1.0]))
        elif scene.light == "darker":
            light[t] = _DARK ** np.clip(1.6 * t / (frames - 1) - 0.3, 0, 1)
        pose = np.array([1.5 + 0.075 * t, 5.0 + 0.4 * side(0.5 * t), turn(t)])
        canvas = hall.view(pose, camera) * light[t].astype(np.float32)
        shake = np.array([0.0, bump(t)])
        people = [
            (starts[k, 0], starts[k, 1] + paces[k] * t, crowd[k], "side", 0.33 * t + k, paces[k])
            for k in range(scene.others)
        ]
        ahead, left = 2.7 + near(t), side(t)
        people.append((ahead, left, (who, clothes), "back", 0.8 * t, 0.0))
        if passes:
            way = _way(t, meets, stop)
            # as seen, the one who passes comes to stand before the person, or beside
            across = sense * _PACE * way + (left + (0.0 if low else sense * beside)) * nearer
            depth = ahead * nearer
            view = "side" if stop == 0 or abs(way) > 0.5 else "front"
            people.append((depth, across, (other, dress), view, 0.5 * way, sense))
        boxes[t] = person_box(camera, ahead, left) + np.array([*shake, 0.0, 0.0])
        hidden = np.zeros(camera.size, dtype=np.float32)
        passing = people[-1] if passes else None
        for person in sorted(people, key=lambda person: -person[0]):
            depth, across, (identity, wears), view, phase, goes = person
            if depth < 0.5 or abs(across) > 1.2 * depth:
                continue
            cover = _draw(
                canvas, camera, depth, across, identity, wears, view, phase, light[t], shake,
                flip=goes > 0 and view == "side",
                small=0.78 if low and person is passing else 1.0,
            )  # fmt: skip
            if person is passing:
                hidden = cover
                passer[t] = person_box(camera, depth, across) + np.array([*shake, 0.0, 0.0])
        visible[t] = _shown(boxes[t], hidden)
        images[t] = photograph(canvas, rng=noise)
    return WalkFilm(images, boxes, visible, passer, light)


def _way(t: float, meets: float, stop: float) -> float:
    """Return how many steps from the meeting place somebody is who stops there for a while."""
    if t < meets:
        return t - meets
    return max(t - meets - stop, 0.0)


def _draw(
    canvas: np.ndarray,
    camera: RobotCamera,
    ahead: float,
    left: float,
    identity: FaceIdentity,
    clothes: Clothes,
    view: str,
    phase: float,
    light: np.ndarray,
    shake: np.ndarray,
    *,
    flip: bool = False,
    small: float = 1.0,
) -> np.ndarray:
    """Lay a person into a picture; return what of it he covers."""
    sprite = body_sprite(clothes, identity, phase=phase, view=view, height=260)
    if flip:
        sprite = sprite[:, ::-1]
    tall = small * HIGH
    u, v = camera.project(ahead, left, tall / 2)
    place = float(u + shake[0]), float(v + shake[1])
    return lay(canvas, sprite, place, camera.focal * tall / ahead, light=light)


def _shown(box: np.ndarray, hidden: np.ndarray) -> float:
    """Return which share of a box lies in the picture and is not hidden."""
    left, top, wide, high = box
    u0, u1 = math.floor(left), math.ceil(left + wide)
    v0, v1 = math.floor(top), math.ceil(top + high)
    inside = hidden[max(v0, 0) : max(v1, 0), max(u0, 0) : max(u1, 0)]
    return float((1 - inside).sum() / ((u1 - u0) * (v1 - v0)))

"""Films of people before a robot: they move, look away, pass before each other; the light changes.

And the portraits by which they were enrolled.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth.coloured.filming import linear, one_of, wave
from data_synth.companion.canvas import lay, photograph, room, rows_and_columns
from data_synth.companion.faces import (
    FaceIdentity,
    FaceView,
    face_sprite,
    face_square,
    make_identity,
)

__all__ = ["FaceFilm", "FaceScene", "film_faces", "portraits"]

SIZE = (240, 320)
LIGHTS = ("steady", "changing")
_TORSO_DEEP = 0.72  # middle of the shoulders below that of the head, in heights of its sprite


@dataclass(frozen=True, slots=True)
class FaceScene:
    """Scene of a film.

    Parameters
    ----------
    people
        How many there are.
    wander
        How far they go sideways, as a share of half the picture's width.
    pace
        How fast, 1 as people who stand and shift do.
    glances
        How often each looks away, times a hundred pictures.
    glance
        For how many pictures, the longest.
    light
        ``"steady"`` or ``"changing"``.
    jumps
        How often each is suddenly elsewhere, as one who ducks or whom the robot's turn throws
        about, times a hundred pictures.
    cross
        Whether they change places, each once, so that the nearer hides the other.
    tall
        Heights of the heads' sprites, from the furthest to the nearest person, pixels.
    """

    people: int = 1
    wander: float = 0.5
    pace: float = 1.0
    glances: float = 2.0
    glance: int = 8
    light: str = "steady"
    jumps: float = 0.0
    cross: bool = False
    tall: tuple[float, float] = (90.0, 130.0)

    def __post_init__(self) -> None:
        whole("people", self.people, 1, 6)
        whole("glance", self.glance, 1, 200)
        for name in ("wander", "pace", "glances", "jumps"):
            number(name, getattr(self, name), 0.0, 50.0)
        one_of("light", self.light, LIGHTS)
        instance("cross", self.cross, bool)
        low, high = array("tall", self.tall, (2,)).tolist()
        if not 40 <= low <= high <= 300:
            raise ValueError(f"tall must rise from 40 to 300 at most, got {(low, high)}")


@dataclass(frozen=True, eq=False, slots=True)
class FaceFilm:
    """A film, and where each face truly is.

    Parameters
    ----------
    frames : (n, 240, 320, 3)
        Red, green and blue.
    boxes : (n, people, 4)
        Left, top, width and height of the square that marks each face, px.
    yaw : (n, people)
        By which each head is turned, rad.
    visible : (n, people)
        Share of each square that no other person hides and that lies in the picture.
    identities
        Who they are.
    light : (n,)
        Brightness, 1 as usual.
    """

    frames: np.ndarray = field(repr=False)
    boxes: np.ndarray = field(repr=False)
    yaw: np.ndarray = field(repr=False)
    visible: np.ndarray = field(repr=False)
    identities: tuple[FaceIdentity, ...]
    light: np.ndarray = field(repr=False)


def film_faces(
    rng: np.random.Generator,
    frames: int,
    scene: FaceScene | None = None,
    identities: tuple[FaceIdentity, ...] | None = None,
) -> FaceFilm:
    """Return a film.

    Parameters
    ----------
    rng
        Source of people, paths, glances, the room, the light and the noise.
    frames
        How many, ten a second.
    scene
        What happens; by default one person who moves and at times looks away.
    identities
        Who the people are; by default whoever comes.
    """
    generator(rng)
    frames = whole("frames", frames, 1, 2000)
    scene = FaceScene() if scene is None else instance("scene", scene, FaceScene)
    parts = [np.random.default_rng(seed) for seed in rng.integers(2**63, size=6)]
    looks, walks, turns, air, walls, noise = parts
    drawn = tuple(make_identity(looks) for _ in range(scene.people))
    people = drawn if identities is None else tuple(instance("identities", identities, tuple))
    if len(people) != scene.people:
        raise ValueError(f"identities must be {scene.people}, as the people, got {len(people)}")
    shirts = [linear(looks.uniform(0.15, 0.75, 3)) for _ in people]
    paths = _paths(walks, frames, scene)
    yaws = np.stack([_yaws(turns, frames, scene) for _ in people], axis=1)
    pitches = [wave(0.12, (20, 60), rng=turns) for _ in people]
    smiles = [wave(0.5, (25, 70), rng=turns) for _ in people]
    lamp = wave(0.9, (60, 160), rng=air)
    glow = wave(0.45, (40, 120), rng=air)
    wall = room(SIZE, rng=walls)
    images = np.empty((frames, *SIZE, 3), dtype=np.uint8)
    boxes = np.empty((frames, len(people), 4))
    visible = np.empty((frames, len(people)))
    light = np.ones(frames)
    for t in range(frames):
        light[t] = 1.0 + (glow(t) if scene.light == "changing" else 0.0)
        azimuth = lamp(t) if scene.light == "changing" else 0.25
        canvas = wall * np.float32(light[t])
        covers = []
        for k, who in enumerate(people):  # from the furthest to the nearest
            u, v, tall = paths[t, k]
            smile = max(smiles[k](t), 0.0)
            view = FaceView(
                yaw=float(yaws[t, k]),
                pitch=pitches[k](t),
                smile=min(round(4 * smile) / 4, 1.0),
                azimuth=azimuth,
                light=float(light[t]),
            )
            cover = lay(
                canvas, _torso(shirts[k]), (u, v + _TORSO_DEEP * tall), 0.85 * tall, light=light[t]
            )
            covers.append(np.maximum(cover, lay(canvas, face_sprite(who, view), (u, v), tall)))
            boxes[t, k] = face_square(u, v, tall, yaws[t, k])
        for k in range(len(people)):
            hidden = np.max([*covers[k + 1 :], np.zeros(SIZE)], axis=0)
            visible[t, k] = _seen(boxes[t, k], hidden)
        images[t] = photograph(canvas, rng=noise)
    return FaceFilm(images, boxes, yaws, visible, people, light)


def portraits(
    rng: np.random.Generator,
    identity: FaceIdentity,
    count: int,
    *,
    size: tuple[int, int] = (112, 92),
    lamp: float = 0.5,
    turn: float = 0.15,
    jitter: float = 0.03,
) -> np.ndarray:
    """Return grey portraits of a person (count, rows, columns), as a camera at a door takes them.

    Parameters
    ----------
    rng
        Source of looks, light, framing and noise.
    identity
        Who.
    count
        How many.
    size
        Rows and columns.
    lamp
        How far the lamp goes to either side, rad, standard deviation.
    turn
        How far the head turns, rad, standard deviation.
    jitter
        How far the frame is off the face, as a share of its side, standard deviation.
    """
    generator(rng)
    instance("identity", identity, FaceIdentity)
    count = whole("count", count, 1, 2000)
    rows, columns = rows_and_columns("size", size, 8, 400)
    for name, value in (("lamp", lamp), ("turn", turn), ("jitter", jitter)):
        number(name, value, 0.0, 2.0)
    found = np.empty((count, rows, columns), dtype=np.uint8)
    for k in range(count):
        yaw, pitch = rng.normal(0, turn), rng.normal(0, turn / 2)
        view = FaceView(
            yaw=float(np.clip(yaw, -1, 1)),
            pitch=float(np.clip(pitch, -0.6, 0.6)),
            roll=float(rng.normal(0, 0.04)),
            smile=round(min(abs(float(rng.normal(0, 0.5))), 1.0), 1),
            opened=round(float(rng.uniform() < 0.15), 1),
            closed=round(float(rng.uniform() < 0.1), 1),
            azimuth=float(np.clip(rng.normal(0, lamp), -1.5, 1.5)),
            elevation=float(rng.uniform(0.2, 0.8)),
            ambient=float(rng.uniform(0.35, 0.65)),
            light=float(rng.uniform(0.6, 1.2)),
        )
        tall = 150.0
        canvas = room((200, 200), rng=rng, clutter=6)
        lay(canvas, face_sprite(identity, view, 150), (99.5, 99.5), tall)
        image = cv2.cvtColor(photograph(canvas, rng=rng), cv2.COLOR_RGB2GRAY)
        left, top, side, _ = face_square(99.5, 99.5, tall, yaw)
        left, top = np.array([left, top]) + side * rng.normal(0, jitter, 2)
        side *= 1 + rng.normal(0, jitter)
        high = side * rows / columns
        top -= (high - side) / 2
        scale = np.array([columns / side, rows / high])
        frame = np.column_stack([np.diag(scale), -scale * np.array([left, top])])
        found[k] = cv2.warpAffine(image, frame, (columns, rows), flags=cv2.INTER_AREA,
                                  borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
    return found


def _seen(box: np.ndarray, hidden: np.ndarray) -> float:
    """Return which share of a square lies in the picture and is not hidden."""
    left, top, wide, high = box
    x0, x1 = (round(x) for x in (left, left + wide))
    y0, y1 = (round(y) for y in (top, top + high))
    inside = hidden[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)]
    return float((1 - inside).sum() / max((x1 - x0) * (y1 - y0), 1))


def _paths(rng: np.random.Generator, frames: int, scene: FaceScene) -> np.ndarray:
    """Return column, row and height of each head (frames, people, 3)."""
    rows, columns = SIZE
    found = np.empty((frames, scene.people, 3))
    steps = np.arange(frames)
    places = (np.arange(scene.people) + 1) / (scene.people + 1) * columns
    rng.shuffle(places)
    periods = 40 / max(scene.pace, 0.05), 130 / max(scene.pace, 0.05)
    tall = np.linspace(*scene.tall, scene.people) if scene.people > 1 else [np.mean(scene.tall)]
    half = columns / 2 / scene.people * scene.wander
    for k in range(scene.people):
        side, down, near = (wave(reach, periods, rng=rng) for reach in (half * 2, 14.0, 0.12))
        home = np.full(frames, places[k])
        if scene.cross and scene.people > 1:
            other = places[(k + 1) % scene.people]
            when = frames * rng.uniform(0.35, 0.65)
            home = home + (other - home) / (1 + np.exp(-(steps - when) / (0.05 * frames)))
        size = tall[k] * np.array([1 + near(t) for t in steps])
        jump = np.zeros((frames, 2))
        for t in np.flatnonzero(rng.uniform(size=frames) < scene.jumps / 100):
            jump[t:] = rng.uniform(-1, 1, 2) * (0.28 * columns, 0.1 * rows)
        found[:, k, 0] = home + [side(t) for t in steps] + jump[:, 0]
        found[:, k, 1] = 0.46 * rows + np.array([down(t) for t in steps]) + jump[:, 1]
        margin = 0.30 * size
        found[:, k, 0] = np.clip(found[:, k, 0], margin, columns - margin)
        found[:, k, 2] = size
    return found


def _yaws(rng: np.random.Generator, frames: int, scene: FaceScene) -> np.ndarray:
    """Return the yaw of a head (frames,): small, but for glances to the side."""
    drift = wave(0.22, (25, 80), rng=rng)
    away = np.zeros(frames)
    for t in np.flatnonzero(rng.uniform(size=frames) < scene.glances / 100):
        last = int(rng.integers(3, scene.glance + 1)) if scene.glance > 3 else scene.glance
        far = rng.choice([-1, 1]) * rng.uniform(0.9, 1.4)
        course = far * np.sin(np.pi * (np.arange(last) + 0.5) / last) ** 0.5
        away[t : t + last] = course[: frames - t]
    return away + [drift(t) for t in range(frames)]


def _torso(shirt: np.ndarray) -> np.ndarray:
    """Return the sprite of shoulders (h, w, 4)."""
    rows, columns = np.mgrid[:60, :110].astype(np.float32)
    x, y = (columns - 54.5) / 52, rows / 60
    edge = np.abs(x) - (0.45 + 0.55 * np.clip(y / 0.5, 0, 1) ** 0.5)
    sprite = np.empty((60, 110, 4), dtype=np.float32)
    sprite[..., :3] = shirt * (1 - 0.35 * np.abs(x) ** 2 - 0.1 * y)[..., None]
    sprite[..., 3] = np.clip(0.5 - 26 * edge, 0, 1)
    return sprite

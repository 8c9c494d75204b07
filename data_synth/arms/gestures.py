"""Films of people who point and gesture before a camera that stands still."""

from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from data_synth._checks import array, generator, instance, number, whole
from data_synth.arms.bodies import SIDES, Build, Person, Stage, make_person
from data_synth.coloured.filming import one_of, wave
from data_synth.companion.canvas import lay, photograph, room
from data_synth.companion.faces import make_identity
from data_synth.companion.walking import body_sprite, make_clothes

__all__ = ["REST", "ArmFilm", "ArmScene", "film_arms", "make_motion"]

KINDS = ("pointing", "gesturing", "pausing", "still", "near")
REST = np.array([0.24, 0.05, 1.2, 0.25])
"""Angles of an arm at rest, rad."""
LEAST = np.array([0.15, -0.10, -0.1, 0.05])
MOST = np.array([2.1, 1.2, 2.6, 2.1])
"""Between which the key poses are drawn, rad."""
CLOSE, TOUCHING = 0.0, -0.03
"""Distances of limbs from other parts of the body in films of the kind "near", m; elsewhere
they keep off them by the second number more."""


@dataclass(frozen=True, slots=True)
class ArmScene:
    """Scene of a film.

    Parameters
    ----------
    kind
        ``"pointing"``: one arm after the other points; ``"gesturing"``: both move; ``"pausing"``:
        they move, stop for a third of the film, and move; ``"still"``; ``"near"``: both move from
        one pose to the next in which a hand or a forearm is close to trunk, head or other arm.
    clutter
        How many things stand or hang behind the person.
    passers
        How many people walk behind.
    light
        By which share the light changes in the course of the film, to and fro.
    pace
        Of all motion; 1 is a gesture in a good second.
    varied
        By how much people differ beyond a few percent: standard deviation of the logarithms of
        their measures, and half of that of the angles (rad) in which they begin and rest.
    sway, turn
        How far the trunk sways to either side, m, and turns, rad, in waves of two to four seconds.
    """

    kind: str = "gesturing"
    clutter: int = 0
    passers: int = 0
    light: float = 0.0
    pace: float = 1.0
    varied: float = 0.0
    sway: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        one_of("kind", self.kind, KINDS)
        whole("clutter", self.clutter, 0, 1000)
        whole("passers", self.passers, 0, 20)
        number("light", self.light, 0.0, 0.9)
        number("pace", self.pace, 0.05, 10.0)
        number("varied", self.varied, 0.0, 0.3)
        number("sway", self.sway, 0.0, 0.5)
        number("turn", self.turn, 0.0, 0.8)


@dataclass(frozen=True, eq=False, slots=True)
class ArmFilm:
    """A film and what is true in it.

    Parameters
    ----------
    frames : (n, rows, columns, 3)
        Red, green, blue.
    angles : (n, 8)
        Of both arms, rad.
    joints : (n, 2, 4, 3)
        Shoulder, elbow, wrist and fingertips, m in the camera's frame.
    parts : (n, rows, columns)
        Which part each pixel is of, as of `Stage.paint`.
    face : (4,)
        The square that marks the face in the first picture, px.
    person, stage
        Who stands where in the first picture.
    """

    frames: np.ndarray = field(repr=False)
    angles: np.ndarray = field(repr=False)
    joints: np.ndarray = field(repr=False)
    parts: np.ndarray = field(repr=False)
    face: np.ndarray
    person: Person = field(repr=False)
    stage: Stage = field(repr=False)


def film_arms(
    rng: np.random.Generator,
    frames: int,
    scene: ArmScene | None = None,
    person: Person | None = None,
    stage: Stage | None = None,
    angles: np.ndarray | None = None,
) -> ArmFilm:
    """Return a film, fifteen pictures a second.

    Parameters
    ----------
    rng
        Source of person, room, motion and noise.
    frames
        How many.
    scene
        What happens; by default a person gestures before a bare wall.
    person
        Who; by default somebody.
    stage
        Camera and lamp.
    angles : (frames, 8), optional
        The motion; by default one of the scene's kind.
    """
    generator(rng)
    frames = whole("frames", frames, 1, 10_000)
    scene = ArmScene() if scene is None else instance("scene", scene, ArmScene)
    stage = Stage() if stage is None else instance("stage", stage, Stage)
    drawn = make_person(rng, make_identity(rng))
    if person is None:
        person = _varied(rng, drawn, scene.varied)
    instance("person", person, Person)
    if angles is None:
        angles = make_motion(rng, frames, scene, person)
    angles = array("angles", angles, (frames, 8), 10.0)
    wall = room(stage.size, rng=rng, clutter=scene.clutter)
    walkers = [_Walker(rng, stage) for _ in range(scene.passers)]
    phase = rng.uniform(0, 2 * np.pi)
    stages = _swaying(rng, frames, scene, stage)
    shown, parts = [], []
    for t in range(frames):
        light = 1 + scene.light * float(np.sin(2 * np.pi * t / 60 + phase) - np.sin(phase)) / 2
        canvas = wall.copy()
        for walker in walkers:
            walker.lay(canvas, t)
        canvas *= np.float32(light)
        painted, part = stages[t].paint(person, angles[t], canvas, light)
        parts.append(part)
        shown.append(photograph(painted, rng=rng))
    joints = np.array([at.joints(person, each) for at, each in zip(stages, angles, strict=True)])
    return ArmFilm(
        np.array(shown), angles, joints, np.array(parts), stages[0].face(person), person, stages[0]
    )


def make_motion(
    rng: np.random.Generator, frames: int, scene: ArmScene, person: Person
) -> np.ndarray:
    """Return the angles of both arms in each picture (frames, 8), rad.

    Key poses are drawn and joined smoothly; a pose in which an arm would go through the body, the
    head or the other arm is drawn again.
    """
    generator(rng)
    frames = whole("frames", frames, 1, 10_000)
    instance("scene", scene, ArmScene)
    instance("person", person, Person)
    rest, begin = _rests(rng, person, scene.varied)
    if scene.kind == "still":
        return np.tile(_pose(rng, person, rest, SIDES), (frames, 1))
    times, poses = [0.0], [begin]
    side, least = int(rng.choice(SIDES)), TOUCHING if scene.kind == "near" else 0.0
    while times[-1] < frames:
        both = SIDES if scene.kind != "pointing" else (side,)
        before = rest if scene.kind == "pointing" else poses[-1]
        pose = _pose(rng, person, before, both, near=scene.kind == "near")
        if scene.kind == "pointing":
            pose[[2, 3] if side < 0 else [6, 7]] *= [1.0, 0.25]  # a straight arm points
        way = np.linspace(poses[-1], pose, 9)
        if any(_hits(person, each, least) for each in way):
            continue
        lasts = 15 * rng.uniform(0.8, 1.5) / scene.pace
        times.append(times[-1] + lasts)
        poses.append(pose)
        if scene.kind == "pointing":  # it is held for a moment, and the arm sinks
            times += [times[-1] + 0.4 * lasts, times[-1] + 1.4 * lasts]
            poses += [pose, rest]
            side = -side
    clock = np.arange(frames, dtype=float)
    if scene.kind == "pausing":
        stop = frames / 3
        clock = np.where(clock < stop, clock, np.maximum(stop, clock - stop))
    return PchipInterpolator(times, poses)(clock)


def _pose(
    rng: np.random.Generator,
    person: Person,
    before: np.ndarray,
    sides: tuple[int, ...],
    near: bool = False,
) -> np.ndarray:
    """Return a pose that the body can take, with the arms of some sides in other places."""
    for _ in range(20_000):
        pose = before.copy()
        for side in sides:
            pose[2 * (side + 1) : 2 * (side + 1) + 4] = rng.uniform(LEAST, MOST)
        if not _hits(person, pose, TOUCHING if near else 0.0) and (
            not near or _hits(person, pose, CLOSE)
        ):
            return pose
    raise RuntimeError("no pose without a collision in 20 000 draws")  # pragma: no cover


def _swaying(rng: np.random.Generator, frames: int, scene: ArmScene, stage: Stage) -> list[Stage]:
    """Return where the body is in each picture; the generator's own stream stays where it is."""
    if scene.sway == 0 and scene.turn == 0:
        return [stage] * frames
    own = rng.spawn(1)[0]
    aside, turn = (wave(1.0, (30, 60), rng=own) for _ in range(2))
    return [
        replace(stage, aside=stage.aside + scene.sway * aside(t), turn=scene.turn * turn(t))
        for t in range(frames)
    ]


def _varied(rng: np.random.Generator, person: Person, by: float) -> Person:
    """Return somebody of another build; the generator's own stream stays where it is."""
    if by == 0:
        return person
    own = rng.spawn(1)[0]
    measures = {name: value * float(np.exp(by * own.standard_normal()))
                for name, value in asdict(person.build).items()}  # fmt: skip
    return replace(person, build=Build(**measures))


def _rests(rng: np.random.Generator, person: Person, by: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the pose of rest and the one at the beginning (8,), rad."""
    rest = np.tile(REST, 2)
    if by == 0:
        return rest, rest
    own, found = rng.spawn(1)[0], []
    while len(found) < 2:
        pose = rest + 2 * by * own.standard_normal(8)
        pose = np.clip(pose, np.tile(LEAST, 2), np.tile(MOST, 2))
        if not _hits(person, pose):
            found.append(pose)
    return found[0], found[1]


def _hits(person: Person, pose: np.ndarray, more: float = 0.0) -> bool:
    """Tell whether a forearm or a hand goes through trunk, head or the other arm.

    With ``more`` all of them are wider by that, m.
    """
    joints = person.joints(pose, np.zeros(3))
    share = np.linspace(0.0, 1.0, 9)[:, None]
    arms = [np.concatenate([a + share * (b - a) for a, b in pairwise(arm)])
            for arm in joints]  # fmt: skip
    for arm in arms:
        far = arm[9:]
        trunk = (far[:, 0] / (0.22 + more)) ** 2 + (far[:, 2] / (0.17 + more)) ** 2 < 1
        if (trunk & (far[:, 1] > -0.05)).any():
            return True
        if (np.linalg.norm(far - [0, -person.build.drop, 0], axis=1) < 0.16 + more).any():
            return True
    gaps = np.linalg.norm(arms[0][:, None] - arms[1][None], axis=-1)
    return bool(gaps.min() < 0.11 + more)


class _Walker:
    """Somebody who walks to and fro behind the person."""

    def __init__(self, rng: np.random.Generator, stage: Stage) -> None:
        self.clothes, self.who = make_clothes(rng), make_identity(rng)
        self.away = float(rng.uniform(3.0, 4.5))
        self.begin = float(rng.uniform(-1.2, 1.2))
        self.speed = float(rng.choice(SIDES) * rng.uniform(0.7, 1.3))
        self.stage = stage

    def lay(self, canvas: np.ndarray, t: int) -> None:
        scale = self.stage.focal / self.away
        reach = 2.4
        x = (self.begin + self.speed * t / 15 + reach) % (4 * reach)
        x, way = (x, 1) if x < 2 * reach else (4 * reach - x, -1)
        sprite = body_sprite(
            self.clothes, self.who, phase=4.0 * t / 15 * abs(self.speed), view="side"
        )
        if way * self.speed < 0:
            sprite = sprite[:, ::-1]
        rows, columns = self.stage.size
        u = (columns - 1) / 2 + scale * (x - reach)
        v = (rows - 1) / 2 + scale * (1.2 - 1.15)
        lay(canvas, np.ascontiguousarray(sprite), (u, v), scale * 2.3)

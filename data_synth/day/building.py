"""One office floor for all sensors of a robot: laser, sonars, and all its cameras.

The floor is that of :mod:`data_synth.people.office`, which simulates laser, sonars and a fisheye
camera. Its walls, boxes and pictures become the surfaces of a :mod:`data_synth.stereo` scene, which
a stereo pair sees in grey and a camera that looks ahead in colour. Above the whole floor is one
painted ceiling for a camera that looks up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from data_synth._checks import array, generator, instance
from data_synth.ceiling import Ceiling, CeilingCamera, Exposure, Mount, Occluder, make_ceiling
from data_synth.companion.hall import RobotCamera
from data_synth.fisheye import Stage
from data_synth.people.office import PeopleOffice, make_people_office
from data_synth.stereo import (
    Rig,
    Scene,
    StereoFrame,
    Surface,
    ideal_image,
    make_scene,
    render,
    visible,
)
from data_synth.textures import paint

__all__ = ["Building", "make_building"]

_SIDE = 26.0  # side of the ceiling, m
_OUT = 0.015  # distance from a wall to the pictures that hang on it, m
_GAMMA = 2.2  # grey value = 255 light^(1 / 2.2)
_TEXELS = 128  # side of a picture, texels
_PLASTER = 190.0  # mean grey value of the texture of plaster
_TILE = 2.0  # period of the textures of plaster and floor, m
_GRAIN = Exposure(noise=2.0)
_HAIR = 60.0  # grey value of a head seen from below


@dataclass(frozen=True, eq=False, slots=True)
class Building:
    """An office floor, and the pictures that the cameras of a robot take of it.

    Parameters
    ----------
    office
        Walls, furniture, doors and lights, for laser, sonars and fisheye camera.
    scene
        The same as surfaces in grey, for a stereo pair.
    colours
        The same as surfaces in red, green and blue, for a camera that looks ahead.
    above
        Camera that looks up at the painted ceiling.
    middle : (2,)
        Point of the floor below the centre of the ceiling, m.
    """

    office: PeopleOffice
    scene: Scene = field(repr=False)
    colours: tuple[Scene, Scene, Scene] = field(repr=False)
    above: CeilingCamera = field(repr=False)
    middle: np.ndarray

    def __post_init__(self) -> None:
        instance("office", self.office, PeopleOffice)
        instance("scene", self.scene, Scene)
        for scene in instance("colours", self.colours, tuple):
            instance("colours", scene, Scene)
        instance("above", self.above, CeilingCamera)
        array("middle", self.middle, (2,))

    def pair(self, rig: Rig, pose: np.ndarray, *, rng: np.random.Generator) -> StereoFrame:
        """Return the pictures of a stereo pair at a robot pose (3,), m and rad; without people."""
        instance("rig", rig, Rig)
        return render(self.scene, rig, array("pose", pose, (3,)), rng=generator(rng))

    def ahead(self, camera: RobotCamera, pose: np.ndarray) -> np.ndarray:
        """Return the picture of a camera that looks ahead, without people and noise.

        Parameters
        ----------
        camera
            Camera of the robot: level, on the robot's vertical axis.
        pose : (3,)
            Pose of the robot, m and rad.

        Returns
        -------
        (rows, columns, 3)
            Linear light in red, green and blue, 1 for white; not the grey values of a file.
        """
        rig, pose = _eye(camera), array("pose", pose, (3,))
        grey = [ideal_image(scene, rig, pose) for scene in self.colours]
        return np.stack([(channel / 255) ** _GAMMA for channel in grey], axis=-1).astype(np.float32)

    def in_sight(
        self, camera: RobotCamera, pose: np.ndarray, places: np.ndarray, high: float = 1.5
    ) -> np.ndarray:
        """Tell which points the camera that looks ahead sees; walls and furniture hide points.

        People do not hide anything here.

        Parameters
        ----------
        camera
            Camera of the robot, as in `ahead`.
        pose : (3,)
            Pose of the robot, m and rad.
        places : (n, 2)
            Positions of the points on the floor plan, m.
        high
            Height of all points above the floor, m.
        """
        places = array("places", places, (None, 2))
        points = np.column_stack([places, np.full(len(places), high)])
        return visible(self.scene, _eye(camera), pose, points)

    def overhead(
        self, pose: np.ndarray, heads: np.ndarray, *, rng: np.random.Generator
    ) -> np.ndarray:
        """Return the picture of the camera that looks up: grey values (rows, columns) of 8 bits.

        Parameters
        ----------
        pose : (3,)
            Pose of the robot, m and rad.
        heads : (n, 3)
            Heads of people: position on the floor plan and height above the floor, m.
        rng
            Source of the noise.
        """
        mount = self.above.mount
        low = self.office.stage.high - mount.height
        discs = [
            Occluder(float(x), float(y), 0.09, float(up - low), _HAIR)
            for x, y, up in array("heads", heads, (None, 3)) - np.append(self.middle, 0.0)
        ]
        there = array("pose", pose, (3,)) - np.append(self.middle, 0.0)
        return self.above.image(there, rng=rng, exposure=_GRAIN, occluders=discs)


def make_building(*, rng: np.random.Generator) -> Building:
    """Return a random office floor with a painted ceiling.

    Parameters
    ----------
    rng
        Source of randomness.
    """
    of_office, of_ceiling, of_pictures = generator(rng).spawn(3)
    office = make_people_office(rng=of_office)
    ceiling = make_ceiling("varied", rng=of_ceiling, side=_SIDE)
    middle = (office.rooms[:, :2].min(axis=0) + office.rooms[:, 2:].max(axis=0)) / 2
    surfaces, tints = _surfaces(office.stage, middle)
    pictures = _pictures(office.stage, ceiling, of_pictures)
    weights = np.array([0.299, 0.587, 0.114])
    grey = [picture @ weights if picture.ndim == 3 else picture for picture in pictures]
    scenes = [_scene(surfaces, tints @ weights, grey)]
    for channel in range(3):
        one = [picture[..., channel] if picture.ndim == 3 else picture for picture in pictures]
        scenes.append(_scene(surfaces, tints[:, channel], one))
    above = CeilingCamera(ceiling, Mount())
    return Building(office, scenes[0], (scenes[1], scenes[2], scenes[3]), above, middle)


def _eye(camera: RobotCamera) -> Rig:
    """Return a stereo rig whose left camera is the camera that looks ahead."""
    rows, columns = instance("camera", camera, RobotCamera).size
    return Rig(focal_px=camera.focal, size=(columns, rows), height=camera.height)


def _scene(surfaces: Sequence[tuple], gains: np.ndarray, pictures: Sequence[np.ndarray]) -> Scene:
    """Return the scene of one channel; ``gains`` multiply the pictures of the surfaces."""
    found = [
        Surface(corner, right, down, picture, tiles, float(gain), carrier)
        for (corner, right, down, picture, tiles, carrier), gain in zip(
            surfaces, gains, strict=True
        )
    ]
    return make_scene(found, [np.rint(picture).clip(0, 255) for picture in pictures])


def _pictures(stage: Stage, ceiling: Ceiling, rng: np.random.Generator) -> list[np.ndarray]:
    """Return the pictures of floor, plaster and ceiling in grey, then all hung ones in colour."""
    above = cv2.resize(ceiling.texture, (1024, 1024), interpolation=cv2.INTER_AREA)
    found = [paint("linoleum", rng=rng), paint("plaster", rng=rng), above]
    for picture in stage.pictures[..., ::-1]:  # from blue, green, red to red, green, blue
        shown = 255 * np.clip(picture, 0, 1) ** (1 / _GAMMA)
        found.append(cv2.resize(shown.astype(np.float32), (_TEXELS, _TEXELS)))
    return [picture.astype(float) for picture in found]


_FLOOR, _WALL, _CEILING, _HUNG = range(4)  # index of a picture; those that hang begin at _HUNG


def _surfaces(stage: Stage, middle: np.ndarray) -> tuple[list[tuple], np.ndarray]:
    """Return all surfaces (corner, right, down, picture, tiles, carrier), and a tint for each.

    A tint is the factor of the picture's red, green and blue. A carrier is the index of the wall on
    which a picture hangs, or -1.
    """
    found: list[tuple] = []
    tints: list[np.ndarray] = []

    def add(corner, right, down, picture, tint, tiles=(1.0, 1.0), carrier=-1):
        found.append((np.array(corner, dtype=float), right, down, picture, tiles, carrier))
        tints.append(np.broadcast_to(tint, 3))

    low = stage.corner
    wide, deep = np.array(stage.plan.shape[::-1]) * stage.cell
    across, up = np.array([wide, 0.0, 0.0]), np.array([0.0, deep, 0.0])
    count = wide / _TILE, deep / _TILE
    add([low[0], low[1] + deep, 0.0], across, -up, _FLOOR, 1.1, count)
    west, south = middle - _SIDE / 2
    edge = np.array([_SIDE, 0.0, 0.0]), np.array([0.0, _SIDE, 0.0])
    add([west, south, stage.high], *edge, _CEILING, 1.0)
    for k, (a, b) in enumerate(stage.walls):
        long, height = float(np.hypot(*(b - a))), stage.high
        along = (b - a) / long  # the free space is to its left
        out = _OUT * np.array([-along[1], along[0]])
        carrier = len(found)
        _upright(add, a, b, 0.0, height, _WALL, _tint(stage.wall_paint[k]), long / _TILE)
        for n in range(stage.hung_first[k], stage.hung_first[k + 1]):
            first, last, bottom, top = stage.hung[n]
            ends = a + first * along + out, a + last * along + out
            picture = _HUNG + int(stage.hung_picture[n])
            _upright(add, *ends, bottom, top, picture, 1.0, carrier=carrier)
    for k, (ring, (bottom, top)) in enumerate(zip(stage.boxes, stage.spans, strict=True)):
        tint, shows = _tint(stage.box_paint[k]), int(stage.box_picture[k])
        picture, gain = (_HUNG + shows, 1.0) if shows >= 0 else (_WALL, tint)
        for a, b in zip(ring[::-1], np.roll(ring[::-1], -1, axis=0), strict=True):
            _upright(add, a, b, bottom, top, picture, gain)
        if top < stage.high - 0.05:
            right, down = ring[1] - ring[0], ring[0] - ring[3]
            add([*ring[3], top], np.append(right, 0.0), np.append(down, 0.0), _WALL, tint)
    return found, np.array(tints)


def _upright(add, a, b, bottom, top, picture, tint, tiles=1.0, carrier=-1) -> None:
    """Add an upright face from a to b that is seen from the left of the line from a to b."""
    right, down = np.append(a - b, 0.0), np.array([0.0, 0.0, bottom - top])
    if np.hypot(*right[:2]) > 1e-3 and top - bottom > 1e-3:
        repeats = (max(tiles, 0.05), 1.0)
        add([*b, top], right, down, picture, tint, repeats, carrier)


def _tint(light: np.ndarray) -> np.ndarray:
    """Return the factors of plaster's grey that give a paint, given as linear light (b, g, r)."""
    return 255 * np.clip(light[::-1], 0, 1) ** (1 / _GAMMA) / _PLASTER

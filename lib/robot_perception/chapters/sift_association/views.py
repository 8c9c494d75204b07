"""What the studies of association see: landmarks tracked at stations of a drive, and tests of them.

At each station the robot drives a little way and then looks again: from between, and from
aside. The renderer knows where in the world each feature lies, and with that a landmark is followed
through the frames that miss it; so the study is one of association alone, not of tracking.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from data_synth import stereo
from data_synth.stereo import Rig, Scene
from data_synth.textured_building import TexturedBuilding, drive, make_textured_building
from robot_perception.geometry import wrap_angle
from robot_perception.landmarks import DescriptorClasses, Features, detect
from robot_perception.teaching.results import kept

PAPER = "sift-slam"
FOCUS = 2.5  # m ahead: what the robot looks at when it stands aside
APART = 0.04  # m: two features nearer than that, on one surface, show the same place


@dataclass(frozen=True, slots=True)
class Stations:
    """How the sequences are recorded; all values are ours, lengths in m.

    At ``count`` stations along the drive a landmark is tracked in ``frames``, in ``sightings`` of
    which it must be found; its descriptors are so many. A ``step`` leads from frame to frame, or a
    turn by 1°, and from right to left, a ``swing`` to either side of the way. Test frames are
    ``again`` ones between two frames of the track, and others so much farther ``aside``.
    """

    count: int = 20
    frames: int = 40
    sightings: int = 30
    step: float = 0.02
    again: int = 4
    swing: float = 0.3
    aside: tuple[float, ...] = (0.3, 0.6)


PLACE = np.dtype(
    [
        ("points", float, 3),  # on a surface, m
        ("carriers", int),  # the surface, or what it hangs on; -1 for none
        ("pictures", int),  # which picture is there
        ("spots", float, 2),  # where in the picture, m
        ("sizes", float),  # of the blob in the world (1σ), m
        ("angles", float),  # direction of the gradient in the image, rad
    ]
)
Places = np.ndarray
"""Where in the world features lie: an array of `PLACE`."""


@dataclass(frozen=True, eq=False, slots=True)
class Views:
    """Landmarks with their descriptors, and descriptors to be assigned to them.

    ``stacks`` are descriptors of each landmark, frame by frame; ``landmarks`` is where they are,
    seen from the frame in the middle. ``tests`` are descriptors from other frames, ``tested`` is
    where these are, and ``aside`` how far aside the robot stood, m, 0 between frames of the track.
    """

    stacks: UInt8[np.ndarray, "n frames 128"]
    landmarks: Places
    tests: UInt8[np.ndarray, "m 128"]
    tested: Places
    aside: Float[np.ndarray, " m"]

    def window(self, p: int) -> UInt8[np.ndarray, "n p 128"]:
        """Return the descriptors of the p frames in the middle of the tracks."""
        start = (self.stacks.shape[1] - p) // 2
        return self.stacks[:, start : start + p]

    def classes(self, p: int) -> DescriptorClasses:
        """Return the classes of the p frames in the middle of the tracks."""
        return classes_of(self.window(p))

    def same(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests and landmarks are at the same place."""
        return _each(_near, self.tested, self.landmarks, "carriers")

    def meant(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests show which landmarks: same place, like size and direction."""
        return _each(_same_feature, self.tested, self.landmarks, "carriers")

    def alike(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests and landmarks are the same place of the same print, hung elsewhere."""
        return _each(_same_spot, self.tested, self.landmarks, "pictures") & ~self.same()


def classes_of(stacks: np.ndarray) -> DescriptorClasses:
    """Return the classes of stacks of descriptors, (n, p, 128)."""
    stacks = stacks.astype(float)
    mean = stacks.mean(axis=1)
    squares = ((stacks - mean[:, None]) ** 2).sum(axis=1)
    return DescriptorClasses(mean, squares, np.full(len(mean), stacks.shape[1]))


def _near(mine: Places, theirs: Places) -> Bool[np.ndarray, "m n"]:
    """Tell which are nearer to each other than `APART`; all are on one surface."""
    return np.linalg.norm(mine["points"][:, None] - theirs["points"], axis=-1) < APART


def _same_feature(mine: Places, theirs: Places) -> Bool[np.ndarray, "m n"]:
    """Tell which are of like size and direction besides."""
    ratio = np.abs(np.log2(mine["sizes"][:, None] / theirs["sizes"]))
    turned = np.abs(wrap_angle(mine["angles"][:, None] - theirs["angles"]))
    return _near(mine, theirs) & (ratio < 0.5) & (turned < np.pi / 6)


def _same_spot(mine: Places, theirs: Places) -> Bool[np.ndarray, "m n"]:
    """Tell which are nearer than `APART` in the picture; all are of one picture."""
    return np.linalg.norm(mine["spots"][:, None] - theirs["spots"], axis=-1) < APART


def _each(
    test: Callable[[Places, Places], np.ndarray], mine: Places, theirs: Places, name: str
) -> Bool[np.ndarray, "m n"]:
    """Tell which of one carrier, or of one picture, pass a test.

    They are compared carrier by carrier: all at once would take gigabytes.
    """
    out = np.zeros((len(mine), len(theirs)), dtype=bool)
    for key in np.unique(theirs[name][theirs[name] >= 0]):
        rows, columns = (np.flatnonzero(places[name] == key) for places in (mine, theirs))
        out[np.ix_(rows, columns)] = test(mine[rows], theirs[columns])
    return out


def nearest(gaps: Float[np.ndarray, "n m"], good: Bool[np.ndarray, "n m"]) -> Int[np.ndarray, " n"]:
    """Return the column of the least good gap in each row; -1 for none."""
    if not gaps.size:
        return np.full(len(gaps), -1)
    return np.where(good.any(axis=1), np.where(good, gaps, np.inf).argmin(axis=1), -1)


@kept
def views(config: Stations, seed: int) -> Views:
    """Render the sequences of all stations, and find the landmarks in them."""
    world, path, *streams = np.random.default_rng(seed).spawn(2 + config.count)
    building = make_textured_building(rng=world)
    way = np.hypot(*np.diff(building.waypoints, axis=0).T).sum()
    poses = drive(building, rng=path, poses=int(way / config.step))
    starts = np.linspace(0, len(poses) - config.frames - 1, config.count).astype(int)
    found = [
        _station(building, poses[k : k + config.frames + 1], config, rng)
        for k, rng in zip(starts, streams, strict=True)
    ]
    return Views(*map(np.concatenate, zip(*found, strict=True)))


def _station(
    building: TexturedBuilding, poses: np.ndarray, config: Stations, rng: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Record a station: tracks of all its frames, and the features of its test frames."""
    scene, rig, middle = building.scene, Rig(), config.frames // 2
    ways = np.linspace(-config.swing, config.swing, config.frames)
    floors = (np.linspace(0.2, 0.8, config.again) * (config.frames - 1)).astype(int)
    steps = poses[floors + 1] - poses[floors]
    steps[:, 2] = wrap_angle(steps[:, 2])
    sides = np.array([side * (config.swing + a) for a in config.aside for side in (-1, 1)])
    there = [poses[:-1], poses[floors] + steps / 2, np.tile(poses[middle], (len(sides), 1))]
    away = [ways, (ways[floors] + ways[floors + 1]) / 2, sides]
    stood = np.stack([*map(stand_aside, np.concatenate(there), np.concatenate(away))])
    seen = [detect(left) for left in stereo.left_frames(scene, rig, stood, rng=rng)]
    spots = [place(scene, rig, pose, features) for pose, features in zip(stood, seen, strict=True)]
    begun = spots[middle][spots[middle]["carriers"] >= 0]
    rows = np.stack([_follow(begun, spot) for spot in spots[: config.frames]], axis=1)
    stay = np.flatnonzero((rows >= 0).sum(axis=1) >= config.sightings)
    stacks = np.empty((len(stay), config.sightings, 128), dtype=np.uint8)
    for out, own in zip(stacks, rows[stay], strict=True):
        at = np.flatnonzero(own >= 0)
        near = np.argsort(np.abs(at - middle), kind="stable")[: config.sightings]
        for q, k in enumerate(np.sort(at[near])):
            out[q] = seen[k].descriptors[own[k]]
    tests = np.concatenate([f.descriptors for f in seen[config.frames :]]).astype(np.uint8)
    tested = np.concatenate(spots[config.frames :])
    offsets = np.concatenate([np.zeros(config.again), np.abs(sides)])
    aside = np.repeat(offsets, [len(spot) for spot in spots[config.frames :]])
    hit = tested["carriers"] >= 0
    return stacks, begun[stay], tests[hit], tested[hit], aside[hit]


def _follow(begun: Places, spots: Places) -> Int[np.ndarray, " n"]:
    """Return which of the features of a frame each landmark is, the nearest; -1 for none."""
    gaps = np.linalg.norm(begun["points"][:, None] - spots["points"], axis=-1)
    return nearest(gaps, _each(_same_feature, begun, spots, "carriers"))


def stand_aside(pose: Float[np.ndarray, "3"], aside: float) -> Float[np.ndarray, "3"]:
    """Return a pose some way to the left, m, that looks at the same place ahead."""
    x, y, heading = pose
    across, along = aside * np.cos(heading), aside * np.sin(heading)
    return np.array([x - along, y + across, heading - np.arctan2(aside, FOCUS)])


def place(scene: Scene, rig: Rig, pose: np.ndarray, features: Features) -> Places:
    """Return where the features of the left image lie in the world."""
    sight = stereo.surface_points(scene, rig, pose, features.pixels)
    hit = sight.surfaces >= 0
    out = np.empty(len(features), PLACE)
    out["points"] = np.where(hit[:, None], sight.points, 0.0)
    out["carriers"] = sight.carriers
    out["pictures"] = scene.pictures[sight.surfaces]
    out["spots"] = _spots(scene, out["points"], sight.surfaces)
    depth = np.where(hit, stereo.project(rig, pose, out["points"])[:, 2], 1.0)
    out["sizes"] = features.scales * np.abs(depth) / rig.focal_px
    out["angles"] = features.angles
    return out


def _spots(scene: Scene, points: np.ndarray, surfaces: np.ndarray) -> Float[np.ndarray, "n 2"]:
    """Return where in its picture each point lies: m from its corner."""
    *edges, corner = np.moveaxis(scene.frames[surfaces], -1, 0)
    spots = []
    for edge, tiles in zip(edges, scene.tiles[surfaces].T, strict=True):
        long = np.linalg.norm(edge, axis=-1)
        along = np.einsum("nk,nk->n", points - corner, edge) / long**2
        spots.append((along * tiles) % 1.0 * long / tiles)
    return np.stack(spots, axis=1)

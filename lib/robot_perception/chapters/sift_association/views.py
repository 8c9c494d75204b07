"""What the studies of association see: landmarks tracked at stations of a drive, and tests of them.

At each station the robot drives a little way and then looks again: from between, and from
aside. The renderer knows where in the world each feature lies, and with that a landmark is followed
through the frames that miss it; so the study is one of association alone, not of tracking.
"""

from collections.abc import Callable, Sequence
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
    """How the sequences are recorded; all values are ours.

    Parameters
    ----------
    count
        Stations along the drive.
    frames
        Frames at each in which a landmark is tracked.
    sightings
        In how many of them a landmark must be found; its descriptors are so many.
    step
        From frame to frame, m; as much is a turn by 1°.
    again
        Test frames between two frames of the track.
    swing
        How far to either side of the way the robot goes while it tracks, from right to left, m.
    aside
        How much farther aside it stands for further test frames, on either side, m.
    """

    count: int = 20
    frames: int = 40
    sightings: int = 30
    step: float = 0.02
    again: int = 4
    swing: float = 0.3
    aside: tuple[float, ...] = (0.3, 0.6)


@dataclass(frozen=True, eq=False, slots=True)
class Places:
    """Where in the world features lie.

    Parameters
    ----------
    points : (n, 3)
        On a surface, m.
    carriers : (n,)
        The surface, or what it hangs on.
    prints : (n, 3)
        Index of the picture, and where in it, m.
    sizes : (n,)
        Of the blob in the world (1σ), m.
    angles : (n,)
        Direction of the gradient in the image, rad.
    """

    points: Float[np.ndarray, "n 3"]
    carriers: Int[np.ndarray, " n"]
    prints: Float[np.ndarray, "n 3"]
    sizes: Float[np.ndarray, " n"]
    angles: Float[np.ndarray, " n"]

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, rows: np.ndarray | slice) -> "Places":
        """Return some of them."""
        return Places(*(getattr(self, name)[rows] for name in self.__slots__))


@dataclass(frozen=True, eq=False, slots=True)
class Views:
    """Landmarks with their descriptors, and descriptors to be assigned to them.

    Parameters
    ----------
    stacks : (n, frames, 128)
        Descriptors of each landmark, frame by frame.
    landmarks
        Where they are, seen from the frame in the middle.
    tests : (m, 128)
        Descriptors from other frames.
    tested
        Where these are.
    aside : (m,)
        How far aside the robot stood, m; 0 between frames of the track.
    """

    stacks: UInt8[np.ndarray, "n frames 128"]
    landmarks: Places
    tests: UInt8[np.ndarray, "m 128"]
    tested: Places
    aside: Float[np.ndarray, " m"]

    def classes(self, p: int) -> DescriptorClasses:
        """Return the classes of the p frames in the middle of the tracks."""
        return classes_of(self.window(p))

    def window(self, p: int) -> UInt8[np.ndarray, "n p 128"]:
        """Return the descriptors of the p frames in the middle of the tracks."""
        start = (self.stacks.shape[1] - p) // 2
        return self.stacks[:, start : start + p]

    def same(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests and landmarks are at the same place."""
        return _on_one_surface(self.tested, self.landmarks, _near)

    def meant(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests show which landmarks: same place, like size and direction."""
        return _on_one_surface(self.tested, self.landmarks, _same_feature)

    def alike(self) -> Bool[np.ndarray, "m n"]:
        """Tell which tests and landmarks are the same place of the same print, hung elsewhere."""
        mine, theirs = self.tested.prints, self.landmarks.prints
        out = np.zeros((len(mine), len(theirs)), dtype=bool)
        for picture in np.unique(mine[:, 0]):
            rows, columns = (np.flatnonzero(p[:, 0] == picture) for p in (mine, theirs))
            gaps = mine[rows, None, 1:] - theirs[columns, 1:]
            out[np.ix_(rows, columns)] = np.hypot(gaps[..., 0], gaps[..., 1]) < APART
        return out & ~self.same()


def classes_of(stacks: np.ndarray) -> DescriptorClasses:
    """Return the classes of stacks of descriptors, (n, p, 128)."""
    stacks = stacks.astype(float)
    mean = stacks.mean(axis=1)
    squares = ((stacks - mean[:, None]) ** 2).sum(axis=1)
    return DescriptorClasses(mean, squares, np.full(len(mean), stacks.shape[1]))


def _near(mine: Places, theirs: Places) -> Bool[np.ndarray, "m n"]:
    """Tell which are nearer to each other than `APART`; all are on one surface."""
    return np.linalg.norm(mine.points[:, None] - theirs.points, axis=-1) < APART


def _same_feature(mine: Places, theirs: Places) -> Bool[np.ndarray, "m n"]:
    """Tell which are of like size and direction besides."""
    ratio = np.abs(np.log2(mine.sizes[:, None] / theirs.sizes))
    turned = np.abs(wrap_angle(mine.angles[:, None] - theirs.angles))
    return _near(mine, theirs) & (ratio < 0.5) & (turned < np.pi / 6)


def _on_one_surface(
    mine: Places, theirs: Places, test: Callable[[Places, Places], np.ndarray]
) -> Bool[np.ndarray, "m n"]:
    """Tell which pass a test, surface by surface: all at once would take gigabytes."""
    out = np.zeros((len(mine), len(theirs)), dtype=bool)
    for carrier in np.unique(theirs.carriers[theirs.carriers >= 0]):
        rows, columns = (np.flatnonzero(p.carriers == carrier) for p in (mine, theirs))
        out[np.ix_(rows, columns)] = test(mine[rows], theirs[columns])
    return out


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
    return Views(
        np.concatenate([v.stacks for v in found]),
        _joined([v.landmarks for v in found]),
        np.concatenate([v.tests for v in found]),
        _joined([v.tested for v in found]),
        np.concatenate([v.aside for v in found]),
    )


def _joined(parts: Sequence[Places]) -> Places:
    return Places(*(np.concatenate([getattr(p, n) for p in parts]) for n in Places.__slots__))


def _station(
    building: TexturedBuilding,
    poses: Float[np.ndarray, "frames_and_one 3"],
    config: Stations,
    rng: np.random.Generator,
) -> Views:
    """Record a station: tracks of all its frames, and the features of its test frames."""
    scene, rig, middle = building.scene, Rig(), config.frames // 2
    ways = np.linspace(-config.swing, config.swing, config.frames)
    floors = (np.linspace(0.2, 0.8, config.again) * (config.frames - 1)).astype(int)
    steps = poses[floors + 1] - poses[floors]
    steps[:, 2] = wrap_angle(steps[:, 2])
    sides = np.array([side * (config.swing + a) for a in config.aside for side in (-1, 1)])
    stood = np.stack(
        [
            *map(stand_aside, poses[:-1], ways),
            *map(stand_aside, poses[floors] + steps / 2, (ways[floors] + ways[floors + 1]) / 2),
            *(stand_aside(poses[middle], side) for side in sides),
        ]
    )
    seen = [detect(frame.left) for frame in stereo.frames(scene, rig, stood, rng=rng)]
    spots = [place(scene, rig, pose, features) for pose, features in zip(stood, seen, strict=True)]
    begun = spots[middle][spots[middle].carriers >= 0]
    rows = np.stack([_follow(begun, spot) for spot in spots[: config.frames]], axis=1)
    stay = np.flatnonzero((rows >= 0).sum(axis=1) >= config.sightings)
    stacks = np.empty((len(stay), config.sightings, 128), dtype=np.uint8)
    for out, own in zip(stacks, rows[stay], strict=True):
        at = np.flatnonzero(own >= 0)
        nearest = np.argsort(np.abs(at - middle), kind="stable")[: config.sightings]
        for q, k in enumerate(np.sort(at[nearest])):
            out[q] = seen[k].descriptors[own[k]]
    tests = np.concatenate([f.descriptors for f in seen[config.frames :]]).astype(np.uint8)
    tested = _joined(spots[config.frames :])
    offsets = np.concatenate([np.zeros(config.again), np.abs(sides)])
    aside = np.repeat(offsets, [len(spot) for spot in spots[config.frames :]])
    hit = tested.carriers >= 0
    return Views(stacks, begun[stay], tests[hit], tested[hit], aside[hit])


def _follow(begun: Places, spots: Places) -> Int[np.ndarray, " n"]:
    """Return which of the features of a frame each landmark is, the nearest; -1 for none."""
    if not len(begun) or not len(spots):
        return np.full(len(begun), -1)
    gaps = np.linalg.norm(begun.points[:, None] - spots.points, axis=-1)
    gaps[~_on_one_surface(begun, spots, _same_feature)] = np.inf
    best = gaps.argmin(axis=1)
    return np.where(np.isfinite(gaps[np.arange(len(begun)), best]), best, -1)


def stand_aside(pose: Float[np.ndarray, "3"], aside: float) -> Float[np.ndarray, "3"]:
    """Return a pose some way to the left, m, that looks at the same place ahead."""
    x, y, heading = pose
    return np.array(
        [
            x - aside * np.sin(heading),
            y + aside * np.cos(heading),
            heading - np.arctan2(aside, FOCUS),
        ]
    )


def place(scene: Scene, rig: Rig, pose: np.ndarray, features: Features) -> Places:
    """Return where the features of the left image lie in the world."""
    sight = stereo.surface_points(scene, rig, pose, features.pixels)
    hit = sight.surfaces >= 0
    points = np.where(hit[:, None], sight.points, 0.0)
    depth = np.where(hit, stereo.project(rig, pose, points)[:, 2], 1.0)
    return Places(
        points,
        sight.carriers,
        _prints(scene, points, sight.surfaces),
        features.scales * np.abs(depth) / rig.focal_px,
        features.angles,
    )


def _prints(
    scene: Scene, points: np.ndarray, surfaces: Int[np.ndarray, " n"]
) -> Float[np.ndarray, "n 3"]:
    """Return the picture at each point, and where in it: m from its corner."""
    frames = scene.frames[surfaces]
    right, down, corner = np.moveaxis(frames, -1, 0)
    long, high = (np.linalg.norm(edge, axis=-1) for edge in (right, down))
    away = points - corner
    a = np.einsum("nk,nk->n", away, right) / long**2
    b = np.einsum("nk,nk->n", away, down) / high**2
    tiles = scene.tiles[surfaces]
    across = (a * tiles[:, 0]) % 1.0 * long / tiles[:, 0]
    below = (b * tiles[:, 1]) % 1.0 * high / tiles[:, 1]
    return np.column_stack([scene.pictures[surfaces], across, below])

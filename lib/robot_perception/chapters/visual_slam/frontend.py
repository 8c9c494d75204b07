"""From two films to observations: what every study of the chapter starts from.

The drive is rendered once. Features of both pictures are matched along rows and triangulated, and
followed from frame to frame; the renderer says which place of the world each of them shows. The
result is kept on the reader's computer.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice

import numpy as np
from jaxtyping import Float, Int, UInt8

from data_synth import stereo, wheels
from data_synth.textured_building import SLIP, TexturedBuilding, drive, make_textured_building
from robot_perception import landmarks
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.geometry import se3
from robot_perception.landmarks import StereoRules, TrackRules
from robot_perception.teaching.results import kept


@dataclass(frozen=True, slots=True)
class Config:
    """The drive and what is made of its pictures.

    Paper: 507 pairs of 320 × 240 over some 80 m, rows within 2 px (section 3.1, section 5). Ours:
    the building, the cameras, all thresholds and the noise of a feature's column and row, ``sigma``
    px. Only the first ``frames`` pairs of the drive are used.
    """

    seed: int = 0
    poses: int = 507
    frames: int = 507
    rows: float = 2.0
    threshold: float = 200.0
    window: float = 12.0
    sigma: float = 0.5

    def first(self, frames: int) -> "Config":
        """Return the same with the beginning of the drive alone."""
        return replace(self, frames=frames)


PAPER = Config()


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What the two eyes saw on the drive: n points, frame after frame.

    Parameters
    ----------
    poses : (frames, 3)
        The true ones, m and rad.
    frames : (n,)
        Frame of each point.
    tracks : (n,)
        Track of each point, by when the tracks began.
    pixels : (n, 2)
        In the left picture.
    points : (n, 3)
        As triangulated, in the frame of the left camera, m.
    covs : (n, 3, 3)
        Their covariances, m².
    descriptors : (n, 128)
        In the left picture.
    places : (n, 3)
        What the pixel shows, in the world, m: the truth.
    carriers : (n,)
        The surface that it lies on; -1 for nothing.
    """

    poses: Float[np.ndarray, "frames 3"]
    frames: Int[np.ndarray, "n"]
    tracks: Int[np.ndarray, "n"]
    pixels: Float[np.ndarray, "n 2"]
    points: Float[np.ndarray, "n 3"]
    covs: Float[np.ndarray, "n 3 3"]
    descriptors: UInt8[np.ndarray, "n 128"]
    places: Float[np.ndarray, "n 3"]
    carriers: Int[np.ndarray, "n"]


@cache
def world(seed: int, poses: int) -> tuple[TexturedBuilding, Float[np.ndarray, "poses 3"]]:
    """Return the building, and the true path through it."""
    make, steer, _ = _streams(seed)
    building = make_textured_building(rng=make)
    return building, drive(building, rng=steer, poses=poses)


RIG = stereo.Rig()
CAMERAS = StereoRig(Pinhole((RIG.focal_px, RIG.focal_px), RIG.centre_px, RIG.size), RIG.baseline)
"""The two eyes as the library models them."""


def pictures(config: Config) -> Iterator[stereo.StereoFrame]:
    """Yield the pairs of pictures of the drive, one after the other."""
    building, poses = world(config.seed, config.poses)
    pairs = stereo.frames(building.scene, RIG, poses, rng=_streams(config.seed)[2])
    return islice(pairs, config.frames)


@kept
def seen(config: Config = PAPER) -> Seen:
    """Render the drive, find and follow what both eyes see, and ask the renderer what it is."""
    building, path = world(config.seed, config.poses)
    rules = StereoRules(config.rows, config.threshold)
    follow = TrackRules(config.window, config.threshold)
    # where a feature is looked for next: by the wheels of a drive of its own
    wheel = wheels.roll(path, SLIP, rng=np.random.default_rng([config.seed, 1]))
    T_robot_camera = RIG.T_robot_camera
    parts: list[tuple[np.ndarray, ...]] = []
    before, tracks = None, None
    for k, pair in enumerate(pictures(config)):
        found = landmarks.observe(
            pair.left, pair.right, CAMERAS, rules=rules, sigma_px=config.sigma
        )
        if tracks is None:
            tracks = landmarks.Tracks.start(found.features)
        else:
            T_before_now = se3.from_se2(wheel.increments[k - 1])
            T_now_before = se3.inverse(
                se3.compose(se3.inverse(T_robot_camera), se3.compose(T_before_now, T_robot_camera))
            )
            expected = landmarks.predict_pixels(before.points.mean, T_now_before, CAMERAS.camera)
            tracks = landmarks.extend(
                tracks, before.features, found.features, follow, predicted=expected
            )
        before = found
        shown = stereo.surface_points(building.scene, RIG, path[k], found.features.pixels)
        parts.append(
            (
                np.full(len(found), k),
                tracks.ids,
                found.features.pixels,
                found.points.mean,
                found.points.cov,
                found.features.descriptors.astype(np.uint8),
                np.where(shown.surfaces[:, None] < 0, 0.0, shown.points),
                shown.carriers,
            )
        )
    return Seen(
        path[: config.frames], *(np.concatenate(column) for column in zip(*parts, strict=True))
    )


def _streams(seed: int) -> list[np.random.Generator]:
    """Return generators of the building, the path and the pictures."""
    return np.random.default_rng(seed).spawn(3)

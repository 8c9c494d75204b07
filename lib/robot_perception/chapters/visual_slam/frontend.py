"""From two films to observations: what every study of the chapter starts from.

The drive through a building is rendered once. Features of both pictures are matched along rows and
triangulated, and followed from frame to frame; the renderer says which place of the world each of
them shows. The result is kept on the reader's computer.

Buildings are told apart by a number. They have one plan; what hangs and stands in them is drawn
anew, and so is the line that the robot takes. The page shows building 0, claims are scored in
`SCORED`, and what the filter's limits are chosen in is `CHOOSING`.
"""

from dataclasses import dataclass, fields
from functools import cache
from itertools import islice

import numpy as np
from jaxtyping import Float, Int, UInt8

from data_synth import stereo, wheels
from data_synth.textured_building import SLIP, TexturedBuilding, drive, make_textured_building
from robot_perception import landmarks
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.geometry import se3
from robot_perception.teaching.results import kept

FRAMES = 507
"""Pairs of 320 × 240 over some 80 m; paper: section 5. Building and cameras are ours."""
SCORED = tuple(range(21, 41))
FEW = SCORED[:6]
"""Those of quick sizes."""
CHOOSING = (101, 102, 103)
EVERY = 10
"""Frames from one picture that is shown to the next."""
RIG = stereo.Rig()
CAMERAS = StereoRig(Pinhole((RIG.focal_px, RIG.focal_px), RIG.centre_px, RIG.size), RIG.baseline)
"""The two eyes as the library models them."""


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What the two eyes saw on the drive: the true poses (m, rad), and n points frame after frame.

    Each point has a frame, a track, numbered by when they began, a pixel of the left picture and a
    descriptor there. It is a point in the frame of the left camera as triangulated, m, with its
    covariance, m². What the pixel shows is a place in the world, m, and the surface that carries
    it, -1 for none: the truth.
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
def world(building: int = 0) -> tuple[TexturedBuilding, Float[np.ndarray, "frames 3"]]:
    """Return a building, and the true path through it."""
    make, steer, _ = _streams(building)
    made = make_textured_building(rng=make)
    return made, drive(made, rng=steer, poses=FRAMES)


def film() -> UInt8[np.ndarray, "pictures height width"]:
    """Return some of the left pictures of the drive, to show."""
    return _watched(0, FRAMES)[1]


@cache
def seen(frames: int = FRAMES, building: int = 0) -> Seen:
    """Return what was seen on the beginning of the drive through a building."""
    return _watched(building, frames)[0]


@kept
def _watched(building: int, frames: int) -> tuple[Seen, UInt8[np.ndarray, "pictures height width"]]:
    """Render the beginning of the drive, follow what both eyes see, and ask what it is."""
    made, path = world(building)
    # where a feature is looked for next: by the wheels of a drive of its own
    report = wheels.roll(path, SLIP, rng=np.random.default_rng([building, 1]))
    pairs = stereo.frames(made.scene, RIG, path, rng=_streams(building)[2])
    film, parts, found = [], [], None
    for k, (pair, T) in enumerate(zip(islice(pairs, frames), moved(report), strict=False)):
        if k % EVERY == 0:
            film.append(pair.left)
        found = landmarks.sight(found, pair.left, pair.right, CAMERAS, T)
        features, points = found.points.features, found.points.points
        shown = stereo.surface_points(made.scene, RIG, path[k], features.pixels)
        parts.append(
            (
                np.full(len(features), k),
                found.tracks.ids,
                features.pixels,
                points.mean,
                points.cov,
                features.descriptors.astype(np.uint8),
                np.where(shown.surfaces[:, None] < 0, 0.0, shown.points),
                shown.carriers,
            )
        )
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Seen(path[:frames], *columns), np.stack(film)


def moved(
    report: wheels.Odometry, T_robot_camera: Float[np.ndarray, "4 4"] = RIG.T_robot_camera
) -> Float[np.ndarray, "frames 4 4"]:
    """Return T_now_before of the camera at each frame, as the wheels report it."""
    increments = np.concatenate([np.zeros((1, 3)), report.increments])
    T_before_now = se3.compose(se3.from_se2(increments), T_robot_camera)
    return se3.between(T_before_now, T_robot_camera)


def _streams(building: int) -> list[np.random.Generator]:
    """Return generators of a building, the path and the pictures."""
    return np.random.default_rng(building).spawn(3)


def lasting(seen: Seen, frames: int) -> Seen:
    """Return the points whose tracks last for more than so many frames, now or later."""
    lengths = np.bincount(seen.tracks)
    numbers = np.cumsum(lengths > frames) - 1  # tracks are numbered without gaps
    kept = lengths[seen.tracks] > frames
    columns = {field.name: getattr(seen, field.name)[kept] for field in fields(Seen)[1:]}
    return Seen(seen.poses, **columns | {"tracks": numbers[seen.tracks[kept]]})

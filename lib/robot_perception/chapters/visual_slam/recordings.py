"""The filter on real stereo pictures from a car: does it follow the known path?

The recordings have no wheels, so these are simulated from the true path; points and matches are
those of the pictures. The filter is planar, and the car pitches a little: heights count less.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from data_synth import wheels
from robot_perception.cameras import level_mount
from robot_perception.chapters.visual_slam.odometry import motions, moved
from robot_perception.datasets import read_kitti, read_stereo_features
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.landmarks import StereoRules, TrackRules, sight
from robot_perception.observations import Observations
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import Odometry, dead_reckoning
from studies.stored.recordings import Recording
from studies.tables import Table

SLIP = wheels.LARGE
PITCH = 0.01  # by how much the camera nods, rad (1σ); ours
NEAR = 8.0  # least disparity of a point that is used, px: 48 m on these cameras; ours
COUNTS = (1, 10, 100)
SEEDS = 10
MOUNT = level_mount(np.zeros(3))
SIGMA = 0.5  # of a column, and of a row, px; ours


@dataclass(frozen=True, eq=False, slots=True)
class Followed:
    """Result of the filter on a recording, by number of particles, m and rad.

    Of the first run there are the true path in the plane, that by the simulated ``wheels``, those
    of the heaviest particle, and the map of the last of them. Each run has an absolute trajectory
    error; that of the wheels alone stands under 0. ``observed`` is the mean of a frame.
    """

    truth: Float[np.ndarray, "k 3"]
    wheels: Float[np.ndarray, "k 3"]
    paths: Mapping[int, Float[np.ndarray, "k 3"]]
    errors: Mapping[int, Float[np.ndarray, "runs"]]
    points: Float[np.ndarray, "n 2"]
    observed: float

    @property
    def share(self) -> float:
        """The error with a hundred particles as a share of that of the wheels alone."""
        return float(self.errors[100].mean() / self.errors[0].mean())

    def table(self) -> Table:
        """Return mean and spread of the errors."""
        rows = {
            f"M = {count}" if count else "wheels alone": (errors.mean(), errors.max())
            for count, errors in self.errors.items()
        }
        columns = {
            "ATE (m)": "mean of the absolute trajectory error over the draws of the wheels' noise",
            "worst (m)": "the largest",
        }
        return Table(rows, columns, f"{SEEDS} draws of the wheels' noise", "particles")


def planar(poses: Float[np.ndarray, "k 4 4"]) -> Float[np.ndarray, "k 3"]:
    """Return poses of a camera that looks ahead as poses in the plane: x ahead, y to the left."""
    ahead = poses[:, [0, 2], 2]
    headings = np.arctan2(-ahead[:, 0], ahead[:, 1])
    return np.stack([poses[:, 2, 3], -poses[:, 0, 3], headings], axis=-1)


def followed(frames: list[Observations], truth: Float[np.ndarray, "k 3"]) -> Followed:
    """Run the filter over named observations, with simulated wheels."""
    paths: dict[int, np.ndarray] = {}
    errors: dict[int, list[float]] = {count: [] for count in (0, *COUNTS)}
    for seed in range(SEEDS):
        wheel, *streams = np.random.default_rng(seed).spawn(1 + len(COUNTS))
        moved = motions(wheels.roll(truth, SLIP, rng=wheel))
        alone = dead_reckoning(truth[0], moved)
        errors[0].append(absolute_error(alone, truth, False))
        for count, own in zip(COUNTS, streams, strict=True):
            path, maps = _filter(frames, truth[0], moved, count, own)
            errors[count].append(absolute_error(path, truth, False))
            if not seed:
                paths[count], first, points = path, alone, maps.landmarks(maps.best)[1].mean
    return Followed(
        truth,
        first,
        paths,
        {count: np.array(values) for count, values in errors.items()},
        points[:, :2],
        float(np.mean([len(frame) for frame in frames])),
    )


def _filter(
    frames: list, start: np.ndarray, moved: list, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, rb.ParticleMaps]:
    still = Odometry(np.zeros(3), np.zeros((3, 3)))
    slam = rb.RaoBlackwellisedSlam(MOUNT, count)
    maps, poses, ancestors = slam.start(start), [], []
    for motion, frame in zip([still, *moved], frames, strict=True):
        maps, info = slam.step(maps, motion, frame, rng=rng)
        poses.append(maps.poses)
        ancestors.append(info.ancestors)
    return rb.paths(poses, ancestors)[:, maps.best], maps


def _loosened(seen: Observations) -> Observations:
    """Return observations whose heights count less the farther they are."""
    covs = seen.covs.copy()
    covs[:, 1, 1] += (PITCH * seen.values[:, 2]) ** 2
    return Observations(seen.ids, seen.values, covs)


def gtsam_tracks(folder: Path) -> Followed:
    """Follow the car by features that somebody else found and named."""
    read = read_stereo_features(folder)
    rig = read.calibration.rig((1242, 375))
    near = read.measurements[:, 0] - read.measurements[:, 2] >= NEAR
    frames = []
    for k in range(len(read.poses)):
        mine = (read.frames == k) & near
        names, rows = np.unique(read.landmarks[mine], return_index=True)
        points = rig.triangulate(read.measurements[mine][rows], SIGMA)
        frames.append(_loosened(Observations(names, points.mean, points.cov)))
    return followed(frames, planar(read.poses))


def kitti(folder: Path) -> Followed:
    """Follow the car by our own features and tracks, with those of more than two frames."""
    read = read_kitti(folder)
    truth = planar(read.poses)
    report = wheels.roll(truth, SLIP, rng=np.random.default_rng(1))
    rig, rules = read.calibration.rig(read.frames.size), StereoRules(disparities=(NEAR, np.inf))
    frames, found = [], None
    for pair, T in zip(read.frames, moved(report, MOUNT), strict=True):
        found = sight(found, *pair, rig, T, rules=rules, track_rules=TrackRules(30.0))
        frames.append(_loosened(found.observations[found.tracks.stable(2)]))
    return followed(frames, truth)


CAR = Recording("stereo_feature_tracks", gtsam_tracks, Followed, "slam-car")
STRAIGHT = Recording("kitti_stereo_straight", kitti, Followed, "slam-straight")
TURN = Recording("kitti_stereo_turn", kitti, Followed, "slam-turn")

"""Recordings of stereo cameras: pictures with poses, and features that others have matched."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.datasets import limits
from robot_perception.datasets.images import StereoSequence, read_images
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import CorruptLog, Lines, as_path, read_table, repeats

if TYPE_CHECKING:
    from robot_perception.cameras import StereoRig

SIDES = (("image_l", "image_r"), ("image_0", "image_1"))  # of the snippets, and of KITTI


@dataclass(frozen=True, eq=False, slots=True)
class Calibration:
    """A rectified stereo camera.

    Parameters
    ----------
    focal
        Focal lengths (fx, fy), px.
    centre
        Principal point (cx, cy), px.
    baseline
        Distance of the right camera from the left, m.
    """

    focal: tuple[float, float]
    centre: tuple[float, float]
    baseline: float

    def rig(self, size: tuple[int, int]) -> "StereoRig":
        """Return the cameras.

        Parameters
        ----------
        size
            Width and height of the pictures, px.

        Raises
        ------
        ValueError
            If the size is not two positive whole numbers.
        """
        from robot_perception.cameras import Pinhole, StereoRig  # which need OpenCV

        return StereoRig(Pinhole(self.focal, self.centre, size), self.baseline)


@dataclass(frozen=True, eq=False, slots=True)
class StereoDrive:
    """Rectified stereo pairs with poses.

    Parameters
    ----------
    frames
        The pairs, k of them.
    calibration
        Of the camera.
    poses : (k, 4, 4)
        ``T_world_camera`` of the left camera at each pair; the world is the frame of one of them.
    """

    frames: StereoSequence
    calibration: Calibration
    poses: Float[np.ndarray, "k 4 4"]


@dataclass(frozen=True, eq=False, slots=True)
class StereoFeatures:
    """Landmarks seen by a rectified stereo camera, each with its name.

    Parameters
    ----------
    calibration
        Of the camera.
    poses : (k, 4, 4)
        ``T_world_camera`` of the left camera in each frame.
    frames : (m,)
        In which frame each observation was made: a row of ``poses``.
    landmarks : (m,)
        Which landmark it is of.
    measurements : (m, 3)
        Column left, row, column right, px.
    points : (m, 3)
        The point that whoever made the file triangulated, in the frame of the left camera, m.
    """

    calibration: Calibration
    poses: Float[np.ndarray, "k 4 4"]
    frames: Int[np.ndarray, " m"]
    landmarks: Int[np.ndarray, " m"]
    measurements: Float[np.ndarray, "m 3"]
    points: Float[np.ndarray, "m 3"]


def read_kitti(folder: str | Path, *, allow_gaps: bool = False) -> StereoDrive:
    """Read a drive in the form of the KITTI odometry benchmark, or a snippet of one.

    ``calib.txt`` has the projection matrices of the left and the right camera, 3 × 4 by rows, in
    its first two lines, with or without a label such as ``P0:``. A line of ``poses.txt`` is the
    pose of the left camera, 3 × 4 by rows, after the number of its picture or alone; then the lines
    count from 0. The pictures are in ``image_l`` and ``image_r``, or ``image_0`` and ``image_1``.

    Parameters
    ----------
    folder
        Where the files are.
    allow_gaps
        Whether pictures may be missing.

    Raises
    ------
    CorruptLog
        If a text file is empty or damaged, the matrices are not those of a rectified pair, a pose
        is no rigid motion, or a picture has none.
    CorruptImage
        If pictures are missing, without partner, or the first is damaged.
    NotADirectoryError
        If there is no folder of pictures.
    FileNotFoundError
        If a text file is missing.

    References
    ----------
    Geiger, Lenz and Urtasun, "Are we ready for autonomous driving? The KITTI vision benchmark
    suite", CVPR 2012.
    """
    folder = as_path(folder, "folder")
    allow_gaps = checks.flag("allow_gaps", allow_gaps)
    calibration = read_calibration(folder / "calib.txt")
    poses = _poses(folder / "poses.txt")
    sides = next((pair for pair in SIDES if (folder / pair[0]).is_dir()), SIDES[0])
    frames = StereoSequence(*(read_images(folder / side, allow_gaps=allow_gaps) for side in sides))
    lost = [number for number in frames.numbers if number not in poses]
    if lost:
        raise CorruptLog(
            f"{folder / 'poses.txt'}: {len(lost)} pictures have no pose, the first is {lost[0]}"
        )
    return StereoDrive(frames, calibration, np.array([poses[number] for number in frames.numbers]))


def read_calibration(path: str | Path) -> Calibration:
    """Read the projection matrices of a rectified pair, as `read_kitti` does.

    Parameters
    ----------
    path
        The file: the matrices of the left and the right camera, 3 × 4 by rows, in its first two
        lines, with or without a label such as ``P0:``.

    Raises
    ------
    CorruptLog
        If the file is empty or damaged, or the matrices are not those of a rectified pair.
    FileNotFoundError
        If there is no such file.
    """
    path = as_path(path)
    lines, matrices = Lines(path), []
    for words in lines.rows():
        if len(matrices) < 2:
            lines.expect(words := words[words[0].endswith(b":") :], 12)
            matrices.append(lines.numbers(lines.points(words)).reshape(3, 4))
    if len(matrices) < 2:
        raise CorruptLog(f"{path}: there must be two projection matrices, got {len(matrices)}")
    found = rectified_pair(*matrices)
    if found is None:
        raise CorruptLog(f"{path}: the matrices are not those of a rectified pair")
    return found


def rectified_pair(
    left: Float[np.ndarray, "3 4"], right: Float[np.ndarray, "3 4"]
) -> Calibration | None:
    """Return what two projection matrices tell, or nothing if they are of no rectified pair."""
    (fx, skew, cx, _), (low, fy, cy, _), _ = left.tolist()
    rectified = (
        (left[:, :3] == right[:, :3]).all()
        and (left[2] == [0, 0, 1, 0]).all()
        and (left[:, 3] == 0).all()
        and (right[1:, 3] == 0).all()
        and skew == low == 0 < min(fx, fy)
    )
    if not rectified or not right[0, 3] < 0:
        return None
    return Calibration((fx, fy), (cx, cy), -float(right[0, 3]) / fx)


def _poses(path: Path) -> dict[int, Float[np.ndarray, "4 4"]]:
    """Return the poses by the numbers of their pictures."""
    lines, poses = Lines(path), {}
    for count, words in enumerate(lines.rows()):
        numbered = len(words) > 12 and bool(words[12])
        number = lines.integer(words, 0) if numbered else count
        lines.expect(words := words[numbered:], 12)
        if number in poses:
            raise lines.error("names a picture a second time")
        values = lines.numbers(lines.points(words))
        lines.check(values[None], [lines.number], limits.far_places(3, 7, 11))
        poses[number] = np.vstack([values.reshape(3, 4), [0, 0, 0, 1]])
        if not _is_rigid(poses[number]):
            raise lines.error("the pose is no rigid motion")
    return poses


def read_stereo_features(folder: str | Path) -> StereoFeatures:
    """Read matched stereo features in the form of GTSAM's visual odometry example.

    The files are ``VO_calibration.txt`` (fx fy skew cx cy baseline), ``VO_camera_poses_large.txt``
    (id and 4 × 4 by rows) and ``VO_stereo_factors_large.txt`` (pose landmark u_left u_right v
    X Y Z), plain or gzip.

    Raises
    ------
    CorruptLog
        If a file is empty or damaged, the camera has a skew, a pose is no rigid motion, there
        twice or missing, or an observation has no positive disparity.
    FileNotFoundError
        If a file is missing.

    References
    ----------
    Dellaert et al., GTSAM, examples/StereoVOExample_large; features of KITTI by Geiger et al.
    """
    folder = as_path(folder, "folder")
    camera, _ = read_table(folder / "VO_calibration.txt", "calibration", 6, CAMERA)
    poses, _ = read_table(folder / "VO_camera_poses_large.txt", "pose", 17, POSES)
    table, _ = read_table(folder / "VO_stereo_factors_large.txt", "observation", 8, FACTORS)
    fx, fy, _, cx, cy, baseline = camera[0].tolist()
    order = np.argsort(poses[:, 0])
    frames = np.searchsorted(poses[order, 0], table[:, 0])
    frames = np.minimum(frames, len(poses) - 1)
    lost = table[poses[order[frames], 0] != table[:, 0], 0]
    if lost.size:
        raise CorruptLog(
            f"{folder}: {lost.size} observations are from poses that are not there,"
            f" the first from {lost[0]:g}"
        )
    return StereoFeatures(
        Calibration((fx, fy), (cx, cy), baseline),
        poses[order, 1:].reshape(-1, 4, 4),
        frames,
        table[:, 1].astype(int),
        table[:, [2, 4, 3]],
        table[:, 5:],
    )


def _is_rigid(pose: np.ndarray) -> bool:
    from robot_perception.geometry import se3  # the other readers do without SciPy's rotations

    try:
        se3.checked("pose", pose)
    except ValueError:
        return False
    return True


def _no_id(rows: np.ndarray) -> np.ndarray:
    return ((rows < 0) | (rows > 1e9) | (rows != np.floor(rows))).any(axis=1)


CAMERA: tuple[Check, ...] = (
    (
        "a focal length or the baseline is not positive",
        lambda r: (r[:, [0, 1, 5]] <= 0).any(axis=1),
    ),
    ("the camera has a skew", lambda rows: rows[:, 2] != 0),
    ("is a second camera", lambda rows: np.arange(len(rows)) > 0),
)
POSES: tuple[Check, ...] = (
    ("a pose's number is no whole number", lambda rows: _no_id(rows[:, :1])),
    ("names a pose a second time", lambda rows: repeats(rows[:, :1])),
    (
        "the pose is no rigid motion",
        lambda rows: np.array([not _is_rigid(row) for row in rows[:, 1:].reshape(-1, 4, 4)]),
    ),
    limits.far_places(4, 8, 12),
)
FACTORS: tuple[Check, ...] = (
    ("a pose's or landmark's number is no whole number", lambda rows: _no_id(rows[:, :2])),
    ("sees a landmark a second time in one frame", lambda rows: repeats(rows[:, :2])),
    ("the disparity is not positive", lambda rows: rows[:, 2] <= rows[:, 3]),
)

"""Recordings of stereo cameras: pictures with poses, and features that others have matched."""

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks
from robot_perception.datasets import limits
from robot_perception.datasets.calibrations import ROUNDING, Calibration, read_pair
from robot_perception.datasets.images import StereoSequence, picture_files, read_images
from robot_perception.datasets.limits import Check
from robot_perception.datasets.logs import (
    CorruptLog,
    Lines,
    ReadReport,
    as_path,
    read_table,
    repeats,
)
from robot_perception.datasets.poses import are_no_rotations, rigid

SIDES = {  # folders of left and right pictures, and which cameras of a calibration these are
    ("image_l", "image_r"): None,  # of the snippets
    ("image_0", "image_1"): (0, 1),  # of KITTI's odometry, grey
    ("image_2", "image_3"): (2, 3),  # and in colour
    ("image_00/data", "image_01/data"): (0, 1),  # of its raw drives
    ("image_02/data", "image_03/data"): (2, 3),
    ("left", "right"): None,
    ("cam0/data", "cam1/data"): None,
    ("cam0", "cam1"): None,
}
CALIBRATIONS = (  # the first that is there is taken
    "calib.txt",
    "calib_cam_to_cam.txt",
    "../calib_cam_to_cam.txt",  # of the day on which a raw drive of KITTI was made
    "*extrinsics*.y*ml",
    "*left*.y*ml",
    "*camchain*.y*ml",
)


@dataclass(frozen=True, eq=False, slots=True)
class StereoPictures:
    """Rectified stereo pairs.

    Parameters
    ----------
    frames
        The pairs.
    calibration
        Of the camera.
    report
        Which files are the pictures, and how they and the calibration were read.
    """

    frames: StereoSequence
    calibration: Calibration
    report: ReadReport


RIGID: Check = ("the pose is no rigid motion", are_no_rotations)


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


def read_stereo(
    folder: str | Path,
    *,
    sides: tuple[str, str] | None = None,
    calibration: str | Calibration | None = None,
    allow_gaps: bool = False,
) -> StereoPictures:
    """Read a folder with the pictures of a rectified pair of cameras and their calibration.

    The pictures are in ``image_l`` and ``image_r``, ``image_0`` and ``image_1`` or ``image_2`` and
    ``image_3`` as of KITTI's odometry, ``image_00/data`` and ``image_01/data`` as of its raw
    drives, ``left`` and ``right``, or ``cam0`` and ``cam1``; the first pair of folders that is
    there is taken. The calibration is ``calib.txt``, ``calib_cam_to_cam.txt``, ``extrinsics.yml``,
    ``left.yaml`` beside ``right.yaml``, a camchain of Kalibr or another YAML, as `read_calibration`
    reads them.

    Parameters
    ----------
    folder
        Where the files are.
    sides
        Other folders of left and right pictures; a last part with ``*``, as in ``both/left*.png``,
        says which files of a folder they are.
    calibration
        The name of another file of the folder, or what it would say.
    allow_gaps
        Whether pictures may be missing.

    Raises
    ------
    CorruptLog
        If the calibration is damaged, or not that of a rectified pair.
    CorruptImage
        If pictures are missing, without partner, or the first is damaged.
    NotADirectoryError
        If there is no folder of pictures.
    FileNotFoundError
        If there is no calibration.
    """
    return _read_stereo(folder, sides, calibration, allow_gaps)[0]


def _read_stereo(
    folder: str | Path,
    sides: tuple[str, str] | None,
    calibration: str | Calibration | None,
    allow_gaps: bool,
) -> tuple[StereoPictures, Float[np.ndarray, " 3"]]:
    """Return the pairs of a folder, and the place of the left camera in the calibration, m."""
    folder, allow_gaps = as_path(folder, "folder"), checks.flag("allow_gaps", allow_gaps)
    pairs = [pair for pair in SIDES if all((folder / side).is_dir() for side in pair)]
    there = [pair for pair in pairs if all(picture_files(folder / side)[0] for side in pair)]
    taken = next(iter(there or pairs or SIDES))
    if sides is not None:
        taken = checks.instances("sides", checks.instance("sides", sides, tuple), str)
    if len(taken) != 2:
        raise ValueError(f"sides must be two folders, got {len(taken)}")
    place, remarks = np.zeros(3), []
    if not isinstance(calibration, Calibration):
        file, *others = _calibration_files(folder, calibration)
        calibration, place = read_pair(file, cameras=SIDES.get(taken))
        remarks += calibration.report.remarks
        if others:
            names = ", ".join(other.name for other in others)
            remarks.append(f"the calibration is that of {file.name}, not of {names}")
    if sides is None and len(there) > 1:
        others = ", ".join(side for pair in there[1:] for side in pair)
        remarks.append(f"pictures are those of {' and '.join(taken)}, not of {others}")
    frames = StereoSequence(*(_side(folder, side, allow_gaps) for side in taken))
    remarks += dict.fromkeys([*frames.left.remarks, *frames.right.remarks])
    skipped = len({*frames.left.skipped, *frames.right.skipped})
    counts = {"pairs": len(frames)}, {"skipped": skipped} if skipped else {}
    report = ReadReport(folder, *counts, "pairs and files", tuple(remarks))
    return StereoPictures(frames, calibration, report), place


def _calibration_files(folder: Path, name: str | None) -> list[Path]:
    """Return the calibrations of a folder, the one to take first; one at least."""
    if name is not None:
        return [folder / checks.instance("calibration", name, str)]
    for patterns in (CALIBRATIONS, ("*.yaml", "*.yml")):
        endings = ("", ".gz")
        found = [file for p in patterns for end in endings for file in sorted(folder.glob(p + end))]
        if found:
            return list(dict.fromkeys(found))
    raise FileNotFoundError(f"{folder}: no calibration: none of {', '.join(CALIBRATIONS)}")


def _side(folder: Path, name: str, allow_gaps: bool):
    """Return the pictures of one side."""
    inner, pattern = PurePosixPath(name), None
    if "*" in inner.name:
        inner, pattern = inner.parent, inner.name
    return read_images(folder / inner, pattern, allow_gaps=allow_gaps)


def read_kitti(folder: str | Path, *, allow_gaps: bool = False) -> StereoDrive:
    """Read a drive in the form of the KITTI odometry benchmark, or a snippet of one.

    Pictures and calibration are those of `read_stereo`. A line of ``poses.txt``, or of
    ``../../poses/00.txt`` beside the sequence ``00``, is the pose of the camera from which the
    calibration counts, 3 × 4 by rows, after the number of its picture or alone; then the lines
    count from 0.

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
    poses, named = folder / "poses.txt", folder.resolve()
    official = named.parent.parent / "poses" / f"{named.name}.txt"
    file = official if official.is_file() and not poses.is_file() else poses
    poses = _poses(file)
    found, place = _read_stereo(folder, None, None, allow_gaps)
    lost = [number for number in found.frames.numbers if number not in poses]
    if lost:
        raise CorruptLog(f"{file}: {len(lost)} pictures have no pose, the first is {lost[0]}")
    T = np.array([poses[number] for number in found.frames.numbers])
    if place.any():
        T[:, :3, 3] += T[:, :3, :3] @ place
    return StereoDrive(found.frames, found.calibration, T)


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
        lines.check(values[None], [lines.number], limits.far_places(3, 7, 11), RIGID)
        poses[number] = rigid(values.reshape(1, 3, 4))[0]
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
    table, _ = read_table(folder / FEATURES, "observation", 8, FACTORS)
    fx, fy, _, cx, cy, baseline = camera[0].tolist()
    order = np.argsort(poses[:, 0])
    frames = np.searchsorted(poses[order, 0], table[:, 0])
    frames = np.minimum(frames, len(poses) - 1)
    lost = table[poses[order[frames], 0] != table[:, 0], 0]
    if lost.size:
        raise CorruptLog(
            f"{folder / FEATURES}: {lost.size} observations are from poses that are not there,"
            f" the first from {lost[0]:g}"
        )
    return StereoFeatures(
        Calibration((fx, fy), (cx, cy), baseline),
        rigid(poses[order, 1:13].reshape(-1, 3, 4)),
        frames,
        table[:, 1].astype(int),
        table[:, [2, 4, 3]],
        table[:, 5:],
    )


def _no_id(rows: np.ndarray) -> np.ndarray:
    return ((rows < 0) | (rows > 1e9) | (rows != np.floor(rows))).any(axis=1)


FEATURES = "VO_stereo_factors_large.txt"
CAMERA: tuple[Check, ...] = (
    (
        "a focal length or the baseline is not positive",
        lambda r: (r[:, [0, 1, 5]] <= 0).any(axis=1),
    ),
    ("the camera has a skew", lambda rows: np.abs(rows[:, 2]) > ROUNDING * rows[:, 0]),
    ("is a second camera", lambda rows: np.arange(len(rows)) > 0),
)
POSES: tuple[Check, ...] = (
    ("a pose's number is no whole number", lambda rows: _no_id(rows[:, :1])),
    ("names a pose a second time", lambda rows: repeats(rows[:, :1])),
    ("the pose is no rigid motion", lambda rows: are_no_rotations(rows[:, 1:13])),
    ("the last row is not 0 0 0 1", lambda rows: (rows[:, 13:] != [0, 0, 0, 1]).any(axis=1)),
    limits.far_places(4, 8, 12),
)
FACTORS: tuple[Check, ...] = (
    ("a pose's or landmark's number is no whole number", lambda rows: _no_id(rows[:, :2])),
    ("sees a landmark a second time in one frame", lambda rows: repeats(rows[:, :2])),
    ("the disparity is not positive", lambda rows: rows[:, 2] <= rows[:, 3]),
)

"""Stereo recordings: read back, conventions, damage named; the real ones where they are."""

import numpy as np
import pytest

from robot_perception.datasets import (
    Calibration,
    CorruptImage,
    CorruptLog,
    read_kitti,
    read_stereo,
    read_stereo_features,
)
from robot_perception.datasets.stereo import SIDES
from robot_perception.geometry import se3
from tests.datasets.formats.stereo import CALIB, LEFT, NUMBERED, POSES, RIGHT
from tests.datasets.here import recording
from tests.datasets.writing import folder, row, write
from tests.unchecked import unchecked

# ---- KITTI ---------------------------------------------------------------------------------------


def kitti(path, calib=None, poses=None, numbers=range(3), sides=("image_l", "image_r")):
    for side in sides:
        folder(path / side, numbers)
    write(path / "calib.txt", calib or CALIB)
    write(path / "poses.txt", poses or NUMBERED)
    return path


COLOUR = {"P2": LEFT.copy(), "P3": RIGHT.copy()}
COLOUR["P2"][0, 3], COLOUR["P3"][0, 3] = 42.0, -308.0  # 0.06 m left of the grey ones
ALL = [row(LEFT, b"P0: "), row(RIGHT, b"P1: ")]
ALL += [row(matrix, name.encode() + b": ") for name, matrix in COLOUR.items()]


@pytest.mark.parametrize("sides", SIDES, ids=lambda sides: sides[0])
def test_pictures_are_found_by_the_usual_names(sides, tmp_path):
    found = read_stereo(kitti(tmp_path, ALL, sides=sides))
    assert len(found.frames) == 3
    assert found.frames.left.paths[0].parent == tmp_path / sides[0]
    assert found.calibration.baseline == pytest.approx(0.5)
    np.testing.assert_array_equal(read_kitti(tmp_path).poses[:, :3, :3], POSES[:, :3, :3])


def test_the_first_of_several_sides_is_taken_and_the_others_are_named(tmp_path):
    kitti(tmp_path, ALL, sides=("image_2", "image_3"))
    kitti(tmp_path, ALL, sides=("image_0", "image_1"))
    (tmp_path / "times.txt").write_text("0.0\n0.1037\n0.2073\n")
    found = read_stereo(tmp_path)
    assert found.frames.left.times == found.frames.right.times == (0.0, 0.1037, 0.2073)
    assert found.report.remarks == (
        "pictures are those of image_0 and image_1, not of image_2, image_3",
        "times of the pictures are those of times.txt, in seconds",
    )
    other = read_stereo(tmp_path, sides=("image_2", "image_3"))
    assert other.frames.left.paths[0].parent.name == "image_2"
    assert other.report.remarks == found.report.remarks[1:]


CALIBRATED = {"calib_cam_to_cam.txt": "P_rect_0{}: ", "calib.txt.gz": "P{}: "}


@pytest.mark.parametrize("name", CALIBRATED)
@pytest.mark.parametrize("above", [False, True])
def test_the_calibration_is_found_by_the_usual_names(name, above, tmp_path):
    drive = kitti(tmp_path / "drive", sides=("image_00/data", "image_01/data"))
    (drive / "calib.txt").unlink()
    place = tmp_path / name if above else drive / name
    write(place, [row(m, CALIBRATED[name].format(k).encode()) for k, m in enumerate((LEFT, RIGHT))])
    if above and name == "calib.txt.gz":
        with pytest.raises(FileNotFoundError, match="no calibration"):
            read_stereo(drive)
        return
    assert read_stereo(drive).calibration.baseline == 0.5
    write(drive / "left.yaml", [b"camera_name: left"])
    remark = f"the calibration is that of {name}, not of left.yaml"
    assert read_stereo(drive).report.remarks == (remark,)
    place.unlink()
    (drive / "left.yaml").rename(drive / "mine.yaml")
    with pytest.raises(CorruptLog, match=r"mine\.yaml: YAML, camera_info of ROS; wanted are"):
        read_stereo(drive)


def test_sides_and_calibration_may_have_other_names(tmp_path):
    for side in ("a", "b"):
        folder(tmp_path / "both", range(2), f"{side}{{}}.png")
    write(tmp_path / "mine.txt", [row(LEFT, b"P0: "), row(RIGHT, b"P1: ")])
    told = Calibration((1.0, 1.0), (2.0, 2.0), 3.0)
    sides = ("both/a*.png", "both/b*.png")
    assert read_stereo(tmp_path, sides=sides, calibration="mine.txt").calibration.baseline == 0.5
    found = read_stereo(tmp_path, sides=sides, calibration=told)
    assert found.calibration is told
    assert [path.name for path in found.frames.right.paths] == ["b0.png", "b1.png"]
    with pytest.raises(
        FileNotFoundError, match=r"no calibration: none of calib\.txt, calib_cam_to"
    ):
        read_stereo(tmp_path, sides=sides)
    with unchecked(), pytest.raises(ValueError, match="sides must be two folders, got 1"):
        read_stereo(tmp_path, sides=("a",), calibration=told)
    with pytest.raises(NotADirectoryError, match="image_l: there is no such folder"):
        read_stereo(tmp_path, calibration=told)


def test_poses_are_those_of_the_camera_that_took_the_pictures(tmp_path):
    """The file has them of the grey camera, from which the colour camera is 0.06 m to the left."""
    grey = read_kitti(kitti(tmp_path / "grey", ALL, sides=("image_0", "image_1")))
    colour = read_kitti(kitti(tmp_path / "colour", ALL, sides=("image_2", "image_3")))
    np.testing.assert_array_equal(grey.poses, POSES)
    apart = se3.between(grey.poses, colour.poses)
    np.testing.assert_allclose(apart[:, :3, 3], np.tile([-0.06, 0, 0], (3, 1)), atol=1e-12)


def test_poses_stand_where_the_benchmark_has_them(tmp_path):
    sequence = kitti(tmp_path / "sequences" / "07", ALL, sides=("image_0", "image_1"))
    (tmp_path / "poses").mkdir()
    (sequence / "poses.txt").rename(tmp_path / "poses" / "07.txt")
    np.testing.assert_array_equal(read_kitti(sequence).poses, POSES)
    (tmp_path / "poses" / "07.txt").write_text("")
    with pytest.raises(CorruptLog, match=r"07\.txt: the file is empty"):
        read_kitti(sequence)


@pytest.mark.parametrize("decimals", [1, 2, 3, 4, 6])
def test_rounded_poses_are_made_rigid(decimals, tmp_path):
    turn = se3.exp(np.array([[1.0, 2, 3, 0.3, -0.2, 0.1]] * 3))
    rounded = [row(np.round(T[:3], decimals)) for T in turn]
    found = read_kitti(kitti(tmp_path, poses=rounded)).poses
    np.testing.assert_allclose(found, turn, atol=2 * 10.0**-decimals)
    assert se3.checked("poses", found) is not None


def test_poses_belong_to_pictures_by_number(tmp_path):
    """As in the second half of a drive; more poses than pictures do no harm."""
    poses = [row(T[:3], b"%d " % k) for k, T in zip((26, 25, 99), POSES, strict=True)]
    drive = read_kitti(kitti(tmp_path, poses=poses, numbers=(25, 26)))
    np.testing.assert_array_equal(drive.poses, POSES[[1, 0]])


def test_missing_pictures_and_files_are_named(tmp_path):
    kitti(tmp_path, poses=[row(POSES[0, :3], b"%d " % k) for k in range(6)], numbers=(0, 1, 2, 5))
    with pytest.raises(CorruptImage, match=r"image_l: pictures .* missing: 3 to 4 \(2 in all"):
        read_kitti(tmp_path)
    assert read_kitti(tmp_path, allow_gaps=True).frames.numbers == (0, 1, 2, 5)
    (tmp_path / "image_r" / "005.png").unlink()
    with pytest.raises(CorruptImage, match="1 pictures of left have no partner: 5"):
        read_kitti(tmp_path, allow_gaps=True)
    (tmp_path / "poses.txt").unlink()
    with pytest.raises(FileNotFoundError):
        read_kitti(tmp_path)
    with pytest.raises(FileNotFoundError):
        read_kitti(tmp_path / "elsewhere")
    kitti(tmp_path / "new")
    for picture in (tmp_path / "new" / "image_r").iterdir():
        picture.unlink()
    (tmp_path / "new" / "image_r").rmdir()
    with pytest.raises(NotADirectoryError, match="image_r: there is no such folder"):
        read_kitti(tmp_path / "new")


@pytest.mark.parametrize(
    ("name", "size", "metres", "degrees"),
    [
        ("kitti_stereo_straight", (1226, 370), (28.5, 28.8), (0.0, 2.0)),
        ("kitti_stereo_turn", (1241, 376), (20.0, 29.0), (60.0, 100.0)),
    ],
)
def test_the_snippets_hold_what_is_known_of_them(name, size, metres, degrees):
    drive = read_kitti(recording(name))
    assert len(drive.frames) == len(drive.poses) == 25
    assert drive.frames.size == size
    np.testing.assert_allclose(drive.calibration.baseline, 0.537, atol=1e-3)
    steps = np.linalg.norm(np.diff(drive.poses[:, :3, 3], axis=0), axis=1)
    assert metres[0] < steps.sum() < metres[1]
    ahead = drive.poses[-1, :3, 2]
    assert degrees[0] <= np.rad2deg(np.arccos(ahead[2])) < degrees[1]
    left, right = drive.frames[24]
    assert left.shape == right.shape == size[::-1]


# ---- GTSAM ---------------------------------------------------------------------------------------


def test_the_features_of_gtsam_are_seen_where_their_poses_say():
    """Points of one landmark from two neighbouring frames agree in the world."""
    found = read_stereo_features(recording("stereo_feature_tracks"))
    assert found.poses.shape == (26, 4, 4)
    assert len(found.measurements) == 8189
    assert len(np.unique(found.landmarks)) == 2634
    rig = found.calibration.rig((1242, 375))
    points = rig.triangulate(found.measurements, 0.5).mean
    near = points[:, 2] < 15
    np.testing.assert_allclose(points[near], found.points[near], rtol=1e-3, atol=0.02)
    world = np.stack(
        [se3.act(found.poses[k], p[None])[0] for k, p in zip(found.frames, points, strict=True)]
    )
    order = np.lexsort((found.frames, found.landmarks))
    one, two = order[:-1], order[1:]
    pairs = (found.landmarks[one] == found.landmarks[two]) & near[one] & near[two]
    apart = np.linalg.norm(world[one] - world[two], axis=1)[pairs]
    assert pairs.sum() > 1000
    assert np.median(apart) < 0.15


# ---- pairs with truth ----------------------------------------------------------------------------


def test_the_cameras_need_a_size(tmp_path):
    calibration = read_kitti(kitti(tmp_path)).calibration
    with unchecked(), pytest.raises(ValueError, match="size must be at least 1, got 0"):
        calibration.rig((0, 5))

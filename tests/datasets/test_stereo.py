"""Stereo recordings: read back, conventions, damage named; the real ones where they are."""

import numpy as np
import pytest

from robot_perception.datasets import (
    Calibration,
    CorruptImage,
    CorruptLog,
    read_depth_pair,
    read_kitti,
    read_plane_pair,
    read_stereo,
    read_stereo_features,
)
from robot_perception.datasets.stereo import SIDES
from robot_perception.geometry import se3
from tests.datasets.here import recording
from tests.datasets.test_images import GREY, folder, save
from tests.datasets.writing import write
from tests.unchecked import unchecked

K = [[700.0, 0, 15, 0], [0, 690, 10, 0], [0, 0, 1, 0]]
LEFT, RIGHT = np.array(K), np.array(K)
RIGHT[0, 3] = -350.0
POSES = np.array([np.eye(4), np.eye(4), np.eye(4)])
POSES[1, :3, 3] = 0.1, -0.2, 1.5
POSES[2, :3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]


def row(values, label=b""):
    return label + b" ".join(repr(float(v)).encode() for v in np.ravel(values))


# ---- KITTI ---------------------------------------------------------------------------------------


def kitti(path, calib=None, poses=None, numbers=range(3), sides=("image_l", "image_r")):
    for side in sides:
        folder(path / side, numbers)
    write(path / "calib.txt", calib or [row(LEFT), row(RIGHT)])
    if poses is None:
        poses = [row(T[:3], b"%d " % k) for k, T in enumerate(POSES)]
    write(path / "poses.txt", poses)
    return path


def test_a_snippet_is_read_back(tmp_path):
    drive = read_kitti(kitti(tmp_path))
    assert drive.calibration.focal == (700.0, 690.0)
    assert drive.calibration.centre == (15.0, 10.0)
    assert drive.calibration.baseline == 0.5
    np.testing.assert_array_equal(drive.poses, POSES)
    np.testing.assert_array_equal(drive.frames[2][0], np.roll(GREY, 2, axis=0))
    rig = drive.calibration.rig(drive.frames.size)
    np.testing.assert_allclose(rig.project(np.array([[0.0, 0, 7.0]])), [[15, 10, 15 - 50]])


def test_the_form_of_the_benchmark_is_read_too(tmp_path):
    calib = [row(LEFT, b"P0: "), row(RIGHT, b"P1: "), row(LEFT, b"P2: "), b"Tr: 1 2 3"]
    poses = [row(T[:3]) for T in POSES]
    drive = read_kitti(kitti(tmp_path, calib, poses, sides=("image_0", "image_1")))
    assert drive.calibration.baseline == 0.5
    np.testing.assert_array_equal(drive.poses, POSES)


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


OTHER = np.array(K)
OTHER[0, 3], OTHER[1, 1] = -350.0, 691.0
SKEW = [matrix + np.array([[0, 1.0, 0, 0], [0] * 4, [0] * 4]) for matrix in (LEFT, RIGHT)]
BAD = {
    "another camera": ({"calib": [row(LEFT), row(OTHER)]}, "not those of a rectified pair"),
    "a skew": ({"calib": [row(SKEW[0]), row(SKEW[1])]}, "not those of a rectified pair"),
    "no baseline": ({"calib": [row(LEFT), row(LEFT)]}, "not those of a rectified pair"),
    "left and right": ({"calib": [row(RIGHT), row(LEFT)]}, "not those of a rectified pair"),
    "a matrix less": ({"calib": [row(LEFT)]}, "must be two projection matrices, got 1"),
    "a number less": ({"calib": [row(LEFT), row(RIGHT[:2])]}, r"calib\.txt, line 2: fewer"),
    "no number": ({"calib": [row(LEFT), row(RIGHT[:2]) + b" 0 0 1 x"]}, "line 2: a value is not"),
    "no rotation": ({"poses": [row(2 * POSES[0, :3], b"0 ")]}, "line 1: the pose is no rigid mot"),
    "a reflection": ({"poses": [row(np.diag([1, 1, -1, 1])[:3], b"0 ")]}, "no rigid motion"),
    "a pose twice": ({"poses": [row(POSES[0, :3], b"1 ")] * 2}, "line 2: names a picture a sec"),
    "a word more": ({"poses": [row(POSES[0], b"1 ")]}, "line 1: more values"),
    "half a picture": ({"poses": [row(POSES[0, :3], b"1.5 ")]}, "line 1: an id or a count"),
    "a pose less": (
        {"poses": [row(POSES[0, :3], b"%d " % k) for k in (0, 2)]},
        r"poses\.txt: 1 pictures have no pose, the first is 1",
    ),
}


@pytest.mark.parametrize(("change", "message"), BAD.values(), ids=BAD)
def test_damage_is_named(tmp_path, change, message):
    with pytest.raises(CorruptLog, match=message):
        read_kitti(kitti(tmp_path, **change))


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


def tracks(path, camera=b"700 690 0 15 10 0.5", poses=None, factors=None):
    write(path / "VO_calibration.txt", [camera])
    if poses is None:
        poses = [row(T, b"%d " % k) for k, T in zip((3, 1, 2), POSES[[2, 0, 1]], strict=True)]
    write(path / "VO_camera_poses_large.txt", poses)
    if factors is None:
        factors = [b"1 7 115 65 79 1 1 7", b"2 7 110 60 80 1 1 7", b"3 9 65 15 10 0.5 0 7"]
    write(path / "VO_stereo_factors_large.txt.gz", factors)
    return path


def test_stereo_features_are_read_back(tmp_path):
    found = read_stereo_features(tracks(tmp_path))
    assert found.calibration.focal == (700.0, 690.0)
    assert found.calibration.centre == (15.0, 10.0)
    assert found.calibration.baseline == 0.5
    np.testing.assert_array_equal(found.poses, POSES)  # by their numbers
    np.testing.assert_array_equal(found.frames, [0, 1, 2])
    np.testing.assert_array_equal(found.landmarks, [7, 7, 9])
    np.testing.assert_array_equal(found.measurements[0], [115, 79, 65])  # left, row, right
    np.testing.assert_allclose(
        found.calibration.rig((40, 30)).triangulate(found.measurements, 1.0).mean[0], [1, 0.7, 7]
    )


BAD_FEATURES = {
    "a skew": ({"camera": b"700 690 1 15 10 0.5"}, "the camera has a skew"),
    "no baseline": ({"camera": b"700 690 0 15 10 0"}, "baseline is not positive"),
    "a pose twice": ({"poses": [row(POSES[0], b"1 ")] * 2}, "line 2: names a pose a second"),
    "no rotation": ({"poses": [row(2 * POSES[0], b"1 ")]}, "line 1: the pose is no rigid"),
    "a pose less": (
        {"poses": [row(POSES[0], b"2 ")]},
        "2 observations are from poses that are not",
    ),
    "a landmark twice": (
        {"factors": [b"1 7 115 65 80 1 1 7"] * 2},
        "line 2: sees a landmark a second time",
    ),
    "no disparity": ({"factors": [b"1 7 65 65 80 1 1 7"]}, "line 1: the disparity is not positive"),
    "half a landmark": ({"factors": [b"1 7.5 115 65 80 1 1 7"]}, "line 1: .* no whole number"),
    "a number less": ({"factors": [b"1 7 115 65 80 1 1"]}, "line 1: fewer values"),
}


@pytest.mark.parametrize(("change", "message"), BAD_FEATURES.values(), ids=BAD_FEATURES)
def test_damage_of_features_is_named(tmp_path, change, message):
    with pytest.raises(CorruptLog, match=message):
        read_stereo_features(tracks(tmp_path, **change))


def test_a_second_camera_is_named(tmp_path):
    tracks(tmp_path)
    write(tmp_path / "VO_calibration.txt", [b"700 690 0 15 10 0.5"] * 2)
    with pytest.raises(CorruptLog, match=r"VO_calibration\.txt, line 2: is a second camera"):
        read_stereo_features(tmp_path)


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

XML = b'<?xml version="1.0"?><s><H><rows>3</rows><data>\n 2 0 5\n 0 3. 6 0 0 1e0 </data></H></s>'


def test_a_homography_is_read_as_opencv_writes_it(tmp_path):
    save(tmp_path / "graf1.png")
    save(tmp_path / "graf3.png", GREY[:10].copy())
    (tmp_path / "H1to3p.xml").write_bytes(XML)
    pair = read_plane_pair(tmp_path)
    np.testing.assert_array_equal(pair.homography, [[2, 0, 5], [0, 3, 6], [0, 0, 1]])
    assert pair.first.shape == (20, 30)
    assert pair.second.shape == (10, 30)
    for content, message in [
        (XML.replace(b"3. 6", b"3."), "nine finite numbers, got 8"),
        (XML.replace(b"3.", b"nan"), "nine finite numbers"),
        (XML.replace(b"3.", b"x"), "no matrix as OpenCV stores one"),
        (XML.replace(b"3.", b"0"), "the homography is singular"),
        (XML[:60], "no matrix as OpenCV stores one"),
        (b"<a></a>", "no matrix as OpenCV stores one"),
    ]:
        (tmp_path / "H1to3p.xml").write_bytes(content)
        with pytest.raises(CorruptLog, match=rf"H1to3p\.xml: .*{message}"):
            read_plane_pair(tmp_path)


def test_a_pair_with_disparities_is_read_back(tmp_path):
    for name, pixels in {"aloeL.jpg": GREY, "aloeR.jpg": GREY, "aloeGT.png": GREY}.items():
        save(tmp_path / name, pixels)
    pair = read_depth_pair(tmp_path)
    np.testing.assert_array_equal(pair.disparity, GREY)
    np.testing.assert_array_equal(pair.known, GREY > 0)
    assert pair.disparity.dtype == float
    save(tmp_path / "aloeGT.png", GREY[:10].copy())
    with pytest.raises(
        CorruptImage, match=r"aloeGT\.png: \(10, 30\), but aloeL\.jpg is \(20, 30\)"
    ):
        read_depth_pair(tmp_path)
    (tmp_path / "aloeR.jpg").unlink()
    with pytest.raises(FileNotFoundError, match="aloeR"):
        read_depth_pair(tmp_path)


def test_the_cameras_need_a_size(tmp_path):
    calibration = read_kitti(kitti(tmp_path)).calibration
    with unchecked(), pytest.raises(ValueError, match="size must be at least 1, got 0"):
        calibration.rig((0, 5))

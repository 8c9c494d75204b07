"""Calibrations: one pair of cameras in every form in which tools write it, found by its names."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptLog, read_calibration
from robot_perception.datasets.calibrations import read_pair, rectified_pair, unrectified

K = np.array([[300.0, 0, 32], [0, 290, 24], [0, 0, 1]])
BASELINE = 0.12


def projection(at=(0.0, 0, 0), K=K):
    """Return the matrix of a camera at a place."""
    return np.column_stack([K, -K @ at])


LEFT, RIGHT = projection(), projection((BASELINE, 0, 0))
FAR = projection((-0.06, 0.001, -0.004)), projection((BASELINE - 0.06, 0.0008, -0.0045))


def text(values):
    return " ".join(repr(float(v)) for v in np.ravel(values))


def lines(**matrices):
    return "".join(f"{name}: {text(matrix)}\n" for name, matrix in matrices.items())


def opencv(**matrices):
    parts = []
    for name, matrix in matrices.items():
        rows, columns = matrix.shape
        data = text(matrix).replace(" ", ", ")
        parts.append(f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n")
        parts.append(f"   data: [ {data} ]\n")
    return "%YAML:1.0\n---\n" + "".join(parts)


def xml(**matrices):
    parts = (
        f'<{name} type_id="opencv-matrix"><rows>3</rows><cols>4</cols><dt>d</dt>\n'
        f"<data>\n {text(matrix)}</data></{name}>"
        for name, matrix in matrices.items()
    )
    return f'<?xml version="1.0"?>\n<opencv_storage>{"".join(parts)}</opencv_storage>'


def ros(matrix, name):
    data = text(matrix).replace(" ", ", ")
    return (
        f"image_width: 64\nimage_height: 48\ncamera_name: {name}\ndistortion_model: plumb_bob\n"
        f"projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{data}]\n"
    )


def camchain(T="- [1.0, 0.0, 0.0, -0.12]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]"):
    camera = "  camera_model: pinhole\n  intrinsics: [300.0, 290.0, 32.0, 24.0]\n"
    bent = "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n"
    return f"cam0:\n{camera}{bent}cam1:\n  T_cn_cnm1:\n  {T}\n{camera}{bent}"


RAW = lines(
    calib_time=[], corner_dist=[0.1], S_00=[64, 48], K_00=K, P_rect_00=LEFT, K_01=K, P_rect_01=RIGHT
).replace("calib_time: ", "calib_time: 09-Jan-2012 13:57:47")
FORMS = {
    "KITTI": {"calib.txt": lines(P0=LEFT, P1=RIGHT, P2=FAR[0], P3=FAR[1], Tr=LEFT)},
    "in another order": {"calib.txt": lines(P1=RIGHT, P3=FAR[1], P0=LEFT, P2=FAR[0])},
    "two of KITTI's": {"calib.txt": lines(P3=RIGHT, P2=LEFT)},
    "without colons": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(":", "")},
    "with colons apart": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(":", " :")},
    "with colons and no blank": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(": ", ":")},
    "by sides": {"calib.txt": lines(right=RIGHT, left=LEFT)},
    "by sides of P": {"calib.txt": lines(P_right=RIGHT, P_left=LEFT)},
    "KITTI raw": {"calib_cam_to_cam.txt": RAW},
    "no names": {"calib.txt": f"{text(LEFT)}\n{text(RIGHT)}\n"},
    "unknown names": {"calib.txt": lines(alpha=LEFT, beta=RIGHT)},
    "OpenCV": {"extrinsics.yml": opencv(R=K, P2=RIGHT, P1=LEFT, Q=np.eye(4))},
    "OpenCV's XML": {"extrinsics.xml": xml(P2=RIGHT, P1=LEFT)},
    "ORB-SLAM": {"car.yaml": opencv(**{"RIGHT.P": RIGHT, "LEFT.P": LEFT, "LEFT.K": K})},
    "ROS": {"left.yaml": ros(LEFT, "left"), "right.yaml": ros(RIGHT, "right")},
    "Kalibr": {"camchain.yaml": camchain()},
}


def put(folder, files):
    """Write files, and return the first."""
    for name, content in files.items():
        (folder / name).write_text(content, "utf-8")
    return folder / next(iter(files))


@pytest.mark.parametrize("name", FORMS)
def test_a_pair_is_the_same_in_every_form(name, tmp_path):
    found = read_calibration(put(tmp_path, FORMS[name]))
    assert (found.focal, found.centre) == ((300.0, 290.0), (32.0, 24.0))
    assert found.baseline == pytest.approx(BASELINE, rel=1e-12)
    by_position = "taken for the left camera" in " ".join(found.report.remarks)
    assert by_position == (name in ("KITTI", "in another order", "no names", "unknown names"))


@pytest.mark.parametrize("name", ["KITTI", "in another order"])
def test_of_several_pairs_the_cameras_tell_which(name, tmp_path):
    """Colour cameras of KITTI lie beside the grey one from which the file counts."""
    path = put(tmp_path, FORMS[name])
    found, place = read_pair(path, cameras=(2, 3))
    assert found.baseline == pytest.approx(BASELINE)
    assert found.report.remarks == ()
    np.testing.assert_allclose(place, [-0.06, 0.001, -0.004], atol=1e-12)
    assert read_pair(path, cameras=(0, 1))[1].tolist() == [0, 0, 0]
    with pytest.raises(CorruptLog, match=r"no matrices of cameras 4 and 5; there are P0, P1, P2"):
        read_pair(path, cameras=(4, 5))


def test_two_cameras_of_other_numbers_are_taken_and_named(tmp_path):
    found = read_calibration(put(tmp_path, FORMS["two of KITTI's"]), cameras=(0, 1))
    (remark,) = found.report.remarks
    assert remark.startswith("calib.txt: P2 is taken for the left camera, P3 for the right one")


def test_files_of_one_camera_are_read_together(tmp_path):
    left, right = (
        put(tmp_path, {name: ros(matrix, "camera")})
        for name, matrix in {"a.yaml": LEFT, "b.yaml": RIGHT}.items()
    )
    assert read_calibration(left, right).baseline == pytest.approx(BASELINE)
    with pytest.raises(CorruptLog, match=r"a\.yaml: YAML, camera_info of ROS, of one camera; want"):
        read_calibration(left)
    text_file = put(tmp_path, FORMS["KITTI"])
    with pytest.raises(CorruptLog, match=r"calib\.txt: text, and not of one camera"):
        read_calibration(text_file, right)
    with pytest.raises(CorruptLog, match=r"calib\.txt: text, and not of one right camera"):
        read_calibration(left, text_file)


TURNED = "- [0, -1, 0, 0]\n  - [1, 0, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]"
BENT = camchain().replace("[0.0, 0.0, 0.0, 0.0]", "[0.1, 0.0, 0.0, 0.0]")
UNRECTIFIED = {
    "OpenCV's cameras": ("a.yml", opencv(M1=K, M2=K), "YAML of OpenCV with M1, M2; wanted are"),
    "ROS without P": (
        "a.yaml",
        "image_width: 64\ncamera_name: left\n",
        "YAML, camera_info of ROS; wanted are the projection matrices",
    ),
    "Kalibr with a lens": ("a.yaml", BENT, "camchain of Kalibr, whose cam0 is pinhole with dist"),
    "Kalibr turned": ("a.yaml", camchain(TURNED), "whose cam1 is turned against cam0, not rectif"),
    "Kalibr with a fisheye": (
        "a.yaml",
        camchain().replace("pinhole", "omni"),
        "whose cam0 is omni with distortion",
    ),
    "Kalibr's one camera": (
        "a.yaml",
        camchain().split("cam1")[0],
        r"two projection matrices, got 1 \(cam0\); it is YAML, camchain of Kalibr; wanted",
    ),
    "EuRoC": (
        "sensor.yaml",
        "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0]\nintrinsics: [1, 2, 3, 4]\n",
        "YAML, sensor.yaml of EuRoC; wanted",
    ),
    "ROS's text": (
        "ost.txt",
        "# oST version 5.0\n\n[image]\n\nwidth\n64\n",
        "line 3: a section in",
    ),
    "a list": ("a.yaml", "- 1\n", "YAML without names; wanted"),
    "no YAML": ("a.yaml", "a: [1,\nb: }\n", "line 2: no YAML, or a damaged one"),
    "no XML": ("a.xml", "<a><b></a>", "no XML, or a damaged one"),
    "no matrix": ("calib.txt", "# nothing\n", "two projection matrices, got 0; it is text"),
    "one matrix": ("calib.txt", lines(P0=LEFT), r"two projection matrices, got 1 \(P0\)"),
    "a name twice": ("calib.txt", lines(P0=LEFT) * 2, "line 2: names P0 a second time"),
    "a number less": ("calib.txt", lines(P0=LEFT, P1=RIGHT[:2]), "line 2: fewer values"),
    "no number": ("calib.txt", lines(P0=LEFT).replace("0.0", "x"), "line 1: .* number: '30x'"),
    "a number of YAML": (
        "a.yml",
        opencv(P1=LEFT, P2=RIGHT).replace("300.0", "x"),
        "a value of P1 is not a number",
    ),
    "numbers of YAML": (
        "a.yml",
        opencv(P1=LEFT, P2=RIGHT).replace("300.0, ", ""),
        "P1 must be 12 finite numbers",
    ),
}


@pytest.mark.parametrize(("name", "content", "message"), UNRECTIFIED.values(), ids=UNRECTIFIED)
def test_what_is_no_pair_is_named_as_what_it_is(name, content, message, tmp_path):
    with pytest.raises(CorruptLog, match=message) as raised:
        read_calibration(put(tmp_path, {name: content}))
    assert str(raised.value).startswith(str(tmp_path / name))


NEAR = np.zeros((3, 4))
NEAR[0, 0] = NEAR[1, 1] = NEAR[0, 2] = 1.0
FAULTS = {
    "the left one twice": (LEFT, LEFT, "have no baseline"),
    "the right one twice": (RIGHT, RIGHT, "have no baseline"),
    "swapped": (RIGHT, LEFT, "are swapped: the right camera lies 0.12 m left of the left one"),
    "above each other": (LEFT, projection((0.12, 0.01, 0)), "are not side by side: .* by 0.01 m"),
    "one behind the other": (LEFT, projection((0, 0, 0.1)), "are not side by side"),
    "other focal lengths": (LEFT, RIGHT + 0.01 * NEAR, "differ by 0.01 px"),
    "a skew": (LEFT + np.eye(3, 4, 1), RIGHT + np.eye(3, 4, 1), "have a skew of 1 px"),
    "zero": (0 * LEFT, 0 * RIGHT, "have a focal length of 0 px, as of a camera that is not cal"),
    "another last row": (LEFT * [[1], [1], [2]], RIGHT * [[1], [1], [2]], "have a last row"),
}


@pytest.mark.parametrize(("left", "right", "fault"), FAULTS.values(), ids=FAULTS)
def test_why_matrices_are_of_no_rectified_pair_is_said(left, right, fault, tmp_path):
    assert rectified_pair(left, right) is None
    with pytest.raises(CorruptLog, match=f"not those of a rectified pair: P0 and P1 {fault}"):
        read_calibration(put(tmp_path, {"calib.txt": lines(P0=left, P1=right)}))


@pytest.mark.parametrize("decimals", [3, 4, 5])
@pytest.mark.parametrize("at", [(BASELINE, 0, 0), (BASELINE, 0.0009, -0.0005)])
def test_matrices_of_a_pair_may_be_rounded_and_a_little_aside(decimals, at):
    """One of them at least, as where a file holds float32."""
    odd = K + np.array([[0.123456, 0, 0.7654321], [0, 0.314159, 0.271828], [0, 0, 0]])
    left, right = projection(K=odd), np.round(projection(at, odd), decimals)
    assert unrectified(left, right) == ""
    found = rectified_pair(left, right)
    assert found.focal == (odd[0, 0], odd[1, 1])
    assert found.baseline == pytest.approx(BASELINE, rel=1e-3)

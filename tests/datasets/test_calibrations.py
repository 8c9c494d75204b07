"""Calibrations: which pair of several is meant, files of one camera, and rounded matrices."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptLog, read_calibration
from robot_perception.datasets.calibrations import read_pair, rectified_pair, unrectified
from tests.datasets.formats.calibrations import (
    BASELINE,
    FAULTS,
    FORMS,
    LEFT,
    RIGHT,
    K,
    projection,
    ros,
)


def put(folder, files):
    """Write files, and return the first."""
    for name, content in files.items():
        (folder / name).write_text(content, "utf-8")
    return folder / next(iter(files))


@pytest.mark.parametrize("name", ["benchmark", "another_order"])
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
    found = read_calibration(put(tmp_path, FORMS["two"]), cameras=(0, 1))
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
    text_file = put(tmp_path, FORMS["benchmark"])
    with pytest.raises(CorruptLog, match=r"calib\.txt: text, and not of one camera"):
        read_calibration(text_file, right)
    with pytest.raises(CorruptLog, match=r"calib\.txt: text, and not of one right camera"):
        read_calibration(left, text_file)


@pytest.mark.parametrize(("left", "right", "fault"), FAULTS.values(), ids=FAULTS)
def test_matrices_with_a_fault_are_of_no_rectified_pair(left, right, fault):
    assert rectified_pair(left, right) is None


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

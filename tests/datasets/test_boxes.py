"""Boxes drawn round a thing: what the file says is read, anything else stops."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptLog, read_boxes, read_images
from tests.datasets.here import recording

HEAD = "frame,x,y,w,h\n"


def put(folder, rows):
    path = folder / "boxes.csv"
    path.write_text(HEAD + rows)
    return path


def test_pixels_are_counted_from_nought(tmp_path):
    found = read_boxes(put(tmp_path, "1,1,2,4,5\n2,1.5,3,1,1\n"), (1, 2))
    np.testing.assert_array_equal(found.numbers, [1, 2])
    np.testing.assert_array_equal(found.boxes, [[0, 1, 4, 5], [0.5, 2, 1, 1]])
    np.testing.assert_array_equal(found.centres, [[1.5, 3], [0.5, 2]])


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "no row line"),
        ("1,2,3,4\n", "line 2: fewer values"),
        ("1,2,3,nan,5\n", "line 2: w is 'nan', not a finite number"),
        ("1,2,3,1e9,5\n", "line 2: w is '1e9', beyond"),
        ("1.5,2,3,4,5\n", "line 2: frame is '1.5', not a whole number"),
        ("1,2,3,4,0\n", "line 2: the box of frame 1 has no area"),
        ("1,2,3,4,5\n2,2,3,-4,5\n", "line 3: the box of frame 2 has no area"),
        ("1,2,3,4,5\n1,2,3,4,5\n", "line 3: frames must rise, got 1 before 1"),
        ("2,2,3,4,5\n1,2,3,4,5\n", "line 3: frames must rise, got 2 before 1"),
        ("1,2,3,4,5\n", "frames are not those of numbers, such as 2"),
        ("1,2,3,4,5\n3,2,3,4,5\n", "frames are not those of numbers, such as 2"),
    ],
)
def test_what_is_no_box_is_refused(tmp_path, rows, message):
    with pytest.raises(CorruptLog, match=message):
        read_boxes(put(tmp_path, rows), (1, 2))


def test_a_missing_column_and_a_missing_file(tmp_path):
    path = tmp_path / "boxes.csv"
    with pytest.raises(FileNotFoundError):
        read_boxes(path)
    path.write_text("frame,x,y,w\n1,2,3,4\n")
    with pytest.raises(CorruptLog, match="no column h"):
        read_boxes(path)


def test_the_head_has_a_box_in_every_picture():
    path = recording("head_girl", "groundtruth_rect.csv")
    pictures = read_images(path.parent / "img", "*.jpg", colour=True)
    found = read_boxes(path, pictures.numbers)
    assert found.boxes.shape == (250, 4)
    assert pictures.size == (128, 96)
    last = found.boxes[:, :2] + found.boxes[:, 2:]
    assert (found.boxes[:, :2] >= 0).all()
    assert (last <= pictures.size).all()

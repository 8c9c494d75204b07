"""Boxes drawn round a thing, in a recording."""

from robot_perception.datasets import read_boxes, read_images
from tests.datasets.here import recording


def test_the_head_has_a_box_in_every_picture():
    path = recording("head_girl", "groundtruth_rect.csv")
    pictures = read_images(path.parent / "img", "*.jpg", colour=True)
    found = read_boxes(path, pictures.numbers)
    assert found.boxes.shape == (250, 4)
    assert pictures.size == (128, 96)
    last = found.boxes[:, :2] + found.boxes[:, 2:]
    assert (found.boxes[:, :2] >= 0).all()
    assert (last <= pictures.size).all()

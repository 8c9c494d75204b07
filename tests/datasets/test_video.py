"""Films: read back, and damage named with its file."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptImage, read_video
from tests.datasets.films import write_film

COLOURS = np.array([[200, 40, 60], [40, 180, 60], [30, 60, 220]], dtype=np.uint8)
FRAMES = np.broadcast_to(COLOURS[:, None, None], (3, 48, 64, 3))


def test_frames_come_back_in_order_red_green_blue(tmp_path):
    write_film(tmp_path / "a.avi", FRAMES)
    read = np.array(list(read_video(tmp_path / "a.avi")))
    assert read.shape == FRAMES.shape
    assert np.abs(read.astype(int) - FRAMES).max() < 12  # JPEG


def test_a_film_that_ends_early_is_refused(tmp_path):
    write_film(tmp_path / "a.avi", np.repeat(FRAMES, 20, axis=0))
    whole = (tmp_path / "a.avi").read_bytes()
    (tmp_path / "b.avi").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CorruptImage, match=r"b\.avi"):
        list(read_video(tmp_path / "b.avi"))


@pytest.mark.parametrize("content", [b"", b"no film", b"RIFF" + bytes(200)])
def test_what_is_no_film_is_refused(tmp_path, content):
    path = tmp_path / "c.avi"
    path.write_bytes(content)
    with pytest.raises(CorruptImage, match=r"c\.avi"):
        read_video(path)


def test_a_missing_film_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"d\.avi"):
        read_video(tmp_path / "d.avi")

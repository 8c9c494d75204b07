"""Times of pictures by a file beside them: every form tells the same, what does not fit is said."""

import numpy as np
import pytest
from PIL import Image

from robot_perception.datasets import read_film, read_images
from tests.datasets.writing import folder

TIMES = 1305031102.0 + np.array([0.175304, 0.211214, 0.5, 1.0112])
MICRO = np.round(TIMES * 1e6).astype(int).tolist()
DATE = "2011-05-10 12:38:{:02d}.{:06d}000".format


def written(lines):
    return "".join(f"{line}\n" for line in lines)


SINCE = [k - MICRO[0] for k in MICRO]
FORMS = {  # name of the file, what it holds, and from when its times count
    "seconds": ("times.txt", [f"{k / 1e6:.6f}" for k in MICRO], 0),
    "seconds since the first": ("times.txt", [f"{k / 1e6:e}" for k in SINCE], TIMES[0]),
    "milliseconds": ("timestamps.txt", [f"{k / 1e3:.3f}" for k in MICRO], 0),
    "microseconds": ("times.txt", MICRO, 0),
    "microseconds since the first": ("times.txt", SINCE, TIMES[0]),
    "nanoseconds": ("times.txt", [f"{k}000" for k in MICRO], 0),
    "nanoseconds since the first": ("times.txt", [f"{k}000" for k in SINCE], TIMES[0]),
    "seconds and nanoseconds": (
        "times.txt",
        [f"{k // 10**6} {k % 10**6}000" for k in MICRO],
        0,
    ),
    "numbers and seconds": ("times.txt", [f"{k} {t / 1e6}" for k, t in enumerate(MICRO)], 0),
    "dates": (
        "timestamps.txt",
        [DATE(22 + (k // 10**6 - 1305031102), k % 10**6) for k in MICRO],
        0,
    ),
    "names of columns": ("times.csv", ["time_s", *(f"{k / 1e6:.6f}" for k in MICRO)], 0),
    "EuRoC": (
        "data.csv",
        ["#timestamp [ns],filename", *(f"{t}000,{k:03}.png" for k, t in enumerate(MICRO))][::-1],
        0,
    ),
    "TUM": ("rgb.txt", [f"{t / 1e6:.6f} rgb/{k:03}.png" for k, t in enumerate(MICRO)][::-1], 0),
    "names first": ("times.txt", [f"{k:03}.png {t / 1e6:.6f}" for k, t in enumerate(MICRO)], 0),
}


@pytest.mark.parametrize("inside", [False, True], ids=["beside the folder", "in it"])
@pytest.mark.parametrize(("name", "lines", "since"), FORMS.values(), ids=FORMS)
def test_times_are_the_same_in_every_form(name, lines, since, inside, tmp_path):
    rgb = folder(tmp_path / "rgb", range(4))
    ((rgb if inside else tmp_path) / name).write_text(written(lines))
    found = read_images(rgb)
    np.testing.assert_allclose(np.array(found.times) + since, TIMES, rtol=0, atol=5e-7)
    assert found.remarks[0].startswith(f"times of the pictures are those of {name}, ")
    assert found.skipped == ()
    assert found[1:].times == found.times[1:]


def test_more_lines_than_pictures_are_of_numbers(tmp_path):
    """As in a part of a drive of KITTI, and where pictures are missing."""
    (tmp_path / "times.txt").write_text(written(0.1 * np.arange(30) + 7))
    found = read_images(folder(tmp_path / "image_0", [25, 26, 28]), allow_gaps=True)
    np.testing.assert_allclose(found.times, [9.5, 9.6, 9.8])


UNFIT = {
    "fewer": (["0.0", "0.1", "0.2"], "3 times for 4 pictures"),
    "as many as their last number": (["0"], "1 times for 4 pictures"),
    "falling": (["0.0", "0.1", "0.05", "0.2"], "line 3: its time does not lie after that before"),
    "equal": (["0.0", "0.1", "0.1", "0.2"], "line 3: its time does not lie after"),
    "words": (["a", "b", "c", "d"], "0 times for 4 pictures"),
    "words between": (["0.0", "b", "c", "d"], "line 2: no time, or more than in other lines: b"),
    "three numbers": (["1 2 3"] * 4, "3 numbers in a line, of which one should be a time"),
    "two numbers": (["1 2.5"] * 4, "2 numbers in a line"),
    "milliseconds and more": ([f"{k // 1000} 5" for k in MICRO], "2 numbers in a line"),
    "days": (["2024-05-01"] * 4, "a day or a time of day alone is no time"),
    "a week": (["0", "1e6", "2e9", "3e17"], "span 3e"),
    "other names": ([f"{k}.5 {k:03}.jpg" for k in range(4)], "4 pictures have no time, the first"),
}


@pytest.mark.parametrize(("lines", "why"), UNFIT.values(), ids=UNFIT)
def test_what_does_not_fit_is_said_and_not_used(lines, why, tmp_path):
    folder(tmp_path, range(4))
    (tmp_path / "times.txt").write_text(written(lines))
    found = read_images(tmp_path)
    assert found.times is None
    (remark,) = found.remarks
    assert remark.startswith(f"times beside the pictures are not used: {tmp_path / 'times.txt'}")
    assert why in remark
    film = read_film(tmp_path)
    list(film)
    np.testing.assert_allclose(film.seconds(10.0), [0, 0.1, 0.2, 0.3])
    assert film.remarks[0] == remark


def test_stamps_in_names_go_before_a_file_and_dates_after_it(tmp_path):
    for name, first in (("clock", "1305031102.175304"), ("date", "20240501_235958")):
        for k in range(2):
            stem = first[:-1] + str(int(first[-1]) + k)
            (tmp_path / name).mkdir(exist_ok=True)
            Image.new("L", (4, 3)).save(tmp_path / name / f"{stem}.png")
        (tmp_path / name / "times.txt").write_text("5.0\n5.5\n")
    assert read_images(tmp_path / "clock").times == (1305031102.175304, 1305031102.175305)
    assert read_images(tmp_path / "date").times == (5.0, 5.5)


def test_a_table_of_another_thing_beside_pictures_is_left_alone(tmp_path):
    rgb = folder(tmp_path / "rgb", range(2))
    for name in ("rgb.txt", "data.csv", "rgb.csv"):
        (tmp_path / name).write_text("t,ax\n1,2\n3,4\n5,6\n")
    found = read_images(rgb)
    assert (found.times, found.remarks) == (None, ())

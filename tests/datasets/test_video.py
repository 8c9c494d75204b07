"""Films as they come: upright, with their own rate, whatever the header says."""

import re
import struct
import subprocess
import sys
from contextlib import suppress
from itertools import count

import cv2
import numpy as np
import pytest
from PIL import Image

from robot_perception.datasets import (
    CorruptImage,
    containers,
    read_film,
    read_video,
    video,
    write_video,
)
from tests.datasets.films import write_film
from tests.datasets.formats.films import (
    COUNT,
    KINDS,
    LISTS,
    MOVING,
    SMOOTH,
    TELL,
    avi,
    jpeg,
    put,
    shift,
)

COLOURS = np.array([[200, 40, 60], [40, 180, 60], [30, 60, 220]], dtype=np.uint8)
FRAMES = np.broadcast_to(COLOURS[:, None, None], (3, 48, 64, 3))


@pytest.mark.parametrize("kind", sorted(KINDS.keys() - TELL))
def test_of_a_film_that_was_cut_unnoticed_what_is_there_is_read(kind, tmp_path):
    """And what is missing is told if the header promises it."""
    put(tmp_path, kind)
    film = tmp_path / f"film.{kind}"
    whole = film.read_bytes()
    for length in (len(whole) // 2, len(whole) * 19 // 20, len(whole) - 1):
        film.write_bytes(whole[:length])
        found = read_video(film)
        with suppress(CorruptImage):  # some decoders notice that half a picture is there
            assert [shift(frame) for frame in found][:-1] == list(range(found.count - 1))
        assert 10 < found.count < 41
        if kind in COUNT and length < len(whole) - 1:
            assert found.missing == 40 - found.count
            assert found.remarks == [f"the film promises 40 pictures and holds {found.count}"]


@pytest.mark.parametrize("ending", ["mp4", "avi"])
def test_frames_come_back_in_order_red_green_blue(ending, tmp_path):
    write_video(tmp_path / f"a.{ending}", FRAMES, rate=10)
    read = np.array(list(read_video(tmp_path / f"a.{ending}")))
    assert read.shape == FRAMES.shape
    assert read.flags.c_contiguous
    assert np.abs(read.astype(int) - FRAMES).max() < 12  # JPEG


# ---- what stands in the header -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("turn", "matrix"),
    [(0, (1, 0, 0, 1)), (3, (0, 1, -1, 0)), (2, (-1, 0, 0, -1)), (1, (0, -1, 1, 0))],
)
def test_a_film_is_turned_as_the_telephone_was_held(turn, matrix, tmp_path):
    write_video(tmp_path / "a.mp4", MOVING, rate=10)
    plain = next(read_video(tmp_path / "a.mp4"))
    content = bytearray((tmp_path / "a.mp4").read_bytes())
    at = content.find(b"tkhd") + 44  # the matrix of the track, of a header of version 0
    for place, value in zip((0, 4, 12, 16), matrix, strict=True):
        struct.pack_into(">i", content, at + place, value * 2**16)
    (tmp_path / "b.mp4").write_bytes(content)
    found = read_video(tmp_path / "b.mp4")
    upright = np.rot90(plain, turn)
    assert found.size == upright.shape[1::-1]
    np.testing.assert_array_equal(next(found), upright)


def test_of_a_variable_rate_each_picture_has_its_time(tmp_path):
    """An animated GIF has a duration for each."""
    frames, lasting = [Image.fromarray(frame) for frame in MOVING[:5]], [100, 50, 200, 100, 100]
    frames[0].save(tmp_path / "a.gif", save_all=True, append_images=frames[1:], duration=lasting)
    found = read_video(tmp_path / "a.gif")
    assert len(list(found)) == 5
    np.testing.assert_allclose(found.times, [0, 0.1, 0.15, 0.35, 0.45], atol=1e-9)
    assert found.rate == pytest.approx(5 / 0.55)


def test_a_header_that_contradicts_the_times_does_not_tell_the_rate():
    times = [k / 30 for k in range(20)]
    assert video._rate(29.97, times) == 29.97
    assert video._rate(1000.0, times) == pytest.approx(30)
    assert video._rate(0.0, times) == pytest.approx(30)
    assert video._rate(25.0, [0.0]) == 25.0
    assert video._rate(0.0, [0.0]) is None
    assert video._rate(np.nan, [0.0]) is None


def test_a_film_that_counts_more_pictures_than_it_holds_is_read(tmp_path):
    write_film(tmp_path / "b.avi", np.stack(MOVING))
    content = bytearray((tmp_path / "b.avi").read_bytes())
    for place in (content.find(b"avih") + 24, content.find(b"strh") + 40):  # numbers of pictures
        assert struct.unpack_from("<I", content, place) == (40,)
        struct.pack_into("<I", content, place, 100)
    (tmp_path / "b.avi").write_bytes(content)
    found = read_video(tmp_path / "b.avi")
    assert len(list(found)) == 40
    assert (found.promised, found.missing) == (100, 60)
    assert found.remarks == ["the film promises 100 pictures and holds 40"]


@pytest.mark.parametrize(("ending", "code"), [("wmv", "WMV2"), ("mkv", "mp4v"), ("flv", "FLV1")])
def test_how_long_a_film_lasts_is_no_promise(ending, code, tmp_path):
    """The header of ASF counts a pause before its first picture; of other rates it is the same."""
    path = tmp_path / f"a.{ending}"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), 30, (64, 48))
    for frame in MOVING[:2]:
        writer.write(frame)
    writer.release()
    found = read_video(path)
    assert len(list(found)) == 2
    assert (found.promised, found.missing, found.remarks) == (None, 0, [])


@pytest.mark.parametrize(("lasts", "first"), [(4000, 0), (2000, 0), (2000, 20), (1000, 13)])
def test_a_film_that_was_trimmed_lacks_nothing(lasts, first, tmp_path):
    """A telephone only notes what to show: the list of edits in an MP4."""
    write_video(tmp_path / "a.mp4", MOVING, rate=10)
    content = bytearray((tmp_path / "a.mp4").read_bytes())
    (ticks,) = struct.unpack_from(">I", content, content.find(b"mdhd") + 16)
    struct.pack_into(">Ii", content, content.find(b"elst") + 12, lasts, first * ticks // 10)
    (tmp_path / "a.mp4").write_bytes(content)
    found = read_video(tmp_path / "a.mp4")
    assert [shift(frame) for frame in found] == list(range(first, first + lasts // 100))
    assert found.promised == (40 if lasts == 4000 else None)
    assert found.remarks == []


def test_a_film_in_fragments_counts_nothing(tmp_path):
    """As browsers and cameras of surveillance write MP4."""
    write_video(tmp_path / "a.mp4", MOVING, rate=10)
    content = (tmp_path / "a.mp4").read_bytes()
    assert containers.counts_pictures(tmp_path / "a.mp4")
    (tmp_path / "a.mp4").write_bytes(content + struct.pack(">I", 16) + b"moof" + bytes(8))
    assert not containers.counts_pictures(tmp_path / "a.mp4")
    at = content.find(b"udta")
    (tmp_path / "a.mp4").write_bytes(content[:at] + b"mvex" + content[at + 4 :])
    assert not containers.counts_pictures(tmp_path / "a.mp4")


@pytest.mark.parametrize("at", [0, 20, 39])
def test_pictures_that_a_recorder_dropped_are_counted(at, tmp_path):
    """They have no content, and the times of the others stay."""
    pictures = [jpeg(frame) for frame in MOVING]
    pictures[at] = b""
    (tmp_path / "a.avi").write_bytes(avi(pictures))
    found, others = read_video(tmp_path / "a.avi"), [k for k in range(40) if k != at]
    assert [shift(frame) for frame in found] == others
    assert (found.promised, found.missing) == (40, 1)
    np.testing.assert_allclose(found.times, np.array(others) / 10, atol=1e-9)


def test_a_recording_that_was_not_finished_is_read_to_its_end(tmp_path):
    """Its recorder did not know its length, and promised none."""
    write_film(tmp_path / "a.avi", np.stack(MOVING))
    content = bytearray((tmp_path / "a.avi").read_bytes())
    for unknown in (0, 2**32 - 1):
        struct.pack_into("<I", content, 4, unknown)
        (tmp_path / "a.avi").write_bytes(content[: len(content) * 3 // 4])
        found = list(read_video(tmp_path / "a.avi"))
        assert [shift(frame) for frame in found] == list(range(len(found)))
        assert 20 < len(found) < 40


def test_pixels_that_are_not_square_are_told(tmp_path):
    head = b"YUV4MPEG2 W64 H48 F25:1 Ip A16:15 C420\n"
    (tmp_path / "a.y4m").write_bytes(head + (b"FRAME\n" + b"a" * (64 * 48 * 3 // 2)) * 3)
    found = read_video(tmp_path / "a.y4m")
    assert len(list(found)) == 3
    assert found.remarks == ["pixels are not square but 16 wide and 15 high"]


# ---- what is no film -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", LISTS)
def test_a_list_of_films_is_no_film(name, tmp_path):
    write_film(tmp_path / "a.ts", np.stack(MOVING))
    (tmp_path / name).write_text(LISTS[name], encoding="utf-8")
    with pytest.raises(
        CorruptImage, match=rf"{re.escape(name)}: no film, .*: a text, such as a list"
    ):
        read_video(tmp_path / name)


def test_the_name_of_a_film_is_no_pattern(tmp_path):
    for name in ("img00.png", "img01.png", "img%02d.png"):
        Image.fromarray(SMOOTH).save(tmp_path / name)
    with pytest.raises(
        CorruptImage, match=r"img%02d\.png: a picture, and no film; read_film takes"
    ):
        read_video(tmp_path / "img%02d.png")
    for name in ("run%02d.avi", "concat:a|b.avi", "Zürich 1.mp4"):
        assert write_video(tmp_path / name, MOVING, rate=10) == 40
        assert len(list(read_video(tmp_path / name))) == 40
        (tmp_path / name).unlink()


# ---- folders -------------------------------------------------------------------------------------


def test_a_folder_of_pictures_is_a_film(tmp_path):
    names = ["1305031102.175304", "1305031102.275304", "1305031102.375304", "1305031102.575304"]
    for frame, name in zip(MOVING, names, strict=False):
        Image.fromarray(frame).save(tmp_path / f"{name}.PNG")
    (tmp_path / "._1305031102.175304.PNG").write_bytes(b"\0\5\x16\7")
    found = read_film(tmp_path)
    assert (found.size, found.promised, found.rate) == ((64, 48), 4, pytest.approx(10, rel=1e-5))
    assert [shift(frame) for frame in found] == [0, 1, 2, 3]
    assert found.times == [float(name) for name in names]
    assert found.numbers == [int(name.replace(".", "")) for name in names]
    assert found.missing == 0
    assert [path.name[:2] for path in found.skipped] == ["._"]
    assert found.remarks == [
        "pictures that are missing: 1 (1305031102475304)",
        "files that are skipped: 1 (._1305031102.175304.PNG)",
    ]


def test_a_folder_of_counted_pictures_has_no_rate(tmp_path):
    for k, ending in zip(count(8), ["jpg", "png", "jpg", "bmp"], strict=False):
        Image.fromarray(SMOOTH).save(tmp_path / f"frame{k}.{ending}")
    found = read_film(tmp_path)
    assert len(list(found)) == 4
    assert (found.rate, found.times, found.numbers) == (None, [], [8, 9, 10, 11])
    assert read_film(tmp_path, "*8.JPG").promised == 1
    with pytest.raises(CorruptImage, match=r"no file fits pattern '\*\.gif'"):
        read_film(tmp_path, "*.gif")
    Image.fromarray(SMOOTH[1:]).save(tmp_path / "frame12.png")
    with pytest.raises(
        CorruptImage, match=r"frame12\.png: 64 x 47 px, but frame8\.jpg has 64 x 48"
    ):
        list(read_film(tmp_path))


# ---- writing -------------------------------------------------------------------------------------

FULL = """
import resource, sys
import numpy as np
from robot_perception import datasets

frames = np.random.default_rng(0).integers(0, 256, (60, 240, 320, 3), dtype=np.uint8)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
try:
    print(datasets.write_video(sys.argv[1], frames, rate=10, overwrite=True))
except OSError as error:
    print(error)
"""


@pytest.mark.parametrize("room", [4096, 200_000, 1_000_000])
@pytest.mark.parametrize("ending", ["mp4", "avi"])
def test_a_film_that_does_not_fit_on_the_disk_is_no_success(ending, room, tmp_path):
    path = tmp_path / f"film.{ending}"
    path.write_text("old")
    run = [sys.executable, "-c", FULL, str(path), str(room)]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert re.search(r"film\.\w+: of 60 frames only \d+ could be written; is the disk full\?", said)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", ["mp4", "avi"])
@pytest.mark.parametrize(
    "rate", [0.01, 1 / 3, 9.99, 24000 / 1001, 27.364821, 30.0003, 240.0, 1000.0]
)
def test_a_film_is_written_at_any_rate(ending, rate, tmp_path):
    assert write_video(tmp_path / f"a.{ending}", MOVING[:5], rate=rate) == 5
    assert read_video(tmp_path / f"a.{ending}").rate == pytest.approx(rate, abs=1e-3)


def test_times_are_those_of_the_film_or_at_a_rate_that_is_told(tmp_path):
    """A number that is missing in a folder leaves a gap."""
    write_video(tmp_path / "film.avi", FRAMES, rate=5)
    film = read_film(tmp_path / "film.avi")
    next(film)
    np.testing.assert_allclose(film.seconds(30), [0])
    assert len(list(film)) == 2
    np.testing.assert_allclose(film.seconds(30), [0, 0.2, 0.4])
    (tmp_path / "pictures").mkdir()
    for number in (7, 8, 10):
        Image.fromarray(SMOOTH).save(tmp_path / "pictures" / f"{number}.png")
    folder = read_film(tmp_path / "pictures")
    assert len(list(folder)) == 3
    np.testing.assert_allclose(folder.seconds(10), [0, 0.1, 0.3])
    with pytest.raises(ValueError, match="rate must be positive and finite, got 0"):
        folder.seconds(0)

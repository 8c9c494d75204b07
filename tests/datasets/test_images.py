"""Pictures and sequences: their order, read late, gaps counted, galleries and pairs."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.datasets import (
    CorruptImage,
    ImageSequence,
    StereoSequence,
    images,
    read_film,
    read_image,
    read_images,
)
from robot_perception.datasets.names import numbering
from tests.datasets.writing import COLOUR, GREY, folder, save
from tests.unchecked import unchecked


def test_pictures_are_read_back(tmp_path):
    np.testing.assert_array_equal(read_image(save(tmp_path / "a.png")), GREY)
    path = save(tmp_path / "b.png", COLOUR)
    np.testing.assert_array_equal(read_image(path, colour=True), COLOUR)
    luma = COLOUR @ [0.299, 0.587, 0.114]
    assert np.abs(read_image(path) - luma).max() < 1
    grey_in_colour = read_image(tmp_path / "a.png", colour=True)
    np.testing.assert_array_equal(grey_in_colour, np.repeat(GREY[..., None], 3, axis=2))
    read_image(path)[:] = 0  # it is the caller's own


@given(place=st.integers(0, 10**6), value=st.integers(1, 255))
@settings(max_examples=80)
def test_no_changed_byte_of_a_png_passes_unnoticed(tmp_path_factory, place, value):
    """All of its content is under a checksum: it is refused, or the same picture all the same."""
    path = save(tmp_path_factory.mktemp("changed") / "a.png")
    content = bytearray(path.read_bytes())
    content[place % len(content)] ^= value
    path.write_bytes(content)
    try:
        found = read_image(path)
    except CorruptImage as error:
        assert "a.png" in str(error)  # noqa: PT017 - either outcome is right
        assert "BytesIO" not in str(error)  # noqa: PT017
    else:
        np.testing.assert_array_equal(found, GREY)


# ---- sequences -----------------------------------------------------------------------------------


def test_a_sequence_is_in_the_order_of_its_numbers(tmp_path):
    found = read_images(folder(tmp_path, range(8, 13), "frame{}.png"))
    assert found.numbers == (8, 9, 10, 11, 12)
    assert len(found) == 5
    assert found.size == (30, 20)
    assert found.gaps == ()
    for number, picture in zip(found.numbers, found, strict=True):
        np.testing.assert_array_equal(picture, np.roll(GREY, number, axis=0))
    np.testing.assert_array_equal(found[-1], np.roll(GREY, 12, axis=0))
    part = found[1:4:2]
    assert part.numbers == (9, 11)
    np.testing.assert_array_equal(part[1], np.roll(GREY, 11, axis=0))
    with pytest.raises(IndexError):
        found[5]


def test_pictures_are_read_when_they_are_asked_for(tmp_path, monkeypatch):
    found, asked = read_images(folder(tmp_path, range(3))), []
    monkeypatch.setattr(
        images, "read_image", lambda path, colour: asked.append(path.name) or GREY.copy()
    )
    going = iter(found)
    next(going)
    found[2]
    assert asked == ["000.png", "002.png"]


def test_colours_are_kept_where_they_are_wanted(tmp_path):
    folder(tmp_path, range(2), pixels=COLOUR)
    assert read_images(tmp_path, colour=True)[1].shape == (20, 30, 3)
    assert read_images(tmp_path, colour=True)[:1][0].shape == (20, 30, 3)
    assert read_images(tmp_path)[1].shape == (20, 30)


@pytest.mark.parametrize(
    ("numbers", "missing", "words"),
    [
        ([0, 1, 3], [2], r": 2 \(1 in all"),
        ([4, 5, 9, 10, 12], [6, 7, 8, 11], r"between 4 and 12 are missing: 6 to 8, 11 \(4 in all"),
        ([0, 10, 20, 40], [30], r": 30 \(1 in all"),
        ([0, 1, 2, 3, 10**19 - 1], None, r"4 to 9999999999999999998 \(9999999999999999995 in all"),
    ],
)
def test_gaps_are_counted_and_named(tmp_path, numbers, missing, words):
    folder(tmp_path, numbers, "{}.png")
    with pytest.raises(CorruptImage, match=words):
        read_images(tmp_path)
    found = read_images(tmp_path, allow_gaps=True)
    assert len(found) == len(numbers)
    if missing:
        assert [number for gap in found.gaps for number in gap] == missing


NANOSECONDS = [1403715274512143104 + 10**9 * k + 17 * k**2 for k in range(4)]


@pytest.mark.parametrize(
    "numbers", [[7], [3, 8], [0, 10, 20], [0, 10, 20, 21, 31, 41], NANOSECONDS]
)
def test_steps_of_any_length_are_no_gaps(tmp_path, numbers):
    found = read_images(folder(tmp_path, numbers, "{}.png"))
    assert found.numbers == tuple(numbers)
    assert found.gaps == ()


def test_many_gaps_are_shortened():
    gaps = tuple(range(k, k + 1) for k in range(0, 40, 4))
    assert images.name_gaps(gaps) == "0, 4, 8, 12, 16, 20, 24, 28, …"


def test_a_damaged_picture_is_named_when_its_turn_comes(tmp_path):
    folder(tmp_path, range(4))
    (tmp_path / "002.png").write_bytes((tmp_path / "002.png").read_bytes()[:200])
    found = read_images(tmp_path)
    found[1]
    with pytest.raises(CorruptImage, match=r"002\.png: no picture, or a damaged one"):
        list(found)
    (tmp_path / "000.png").write_bytes(b"")
    with pytest.raises(CorruptImage, match=r"000\.png: the file is empty"):
        read_images(tmp_path)


def test_a_picture_of_another_size_is_named(tmp_path):
    folder(tmp_path, range(2))
    save(tmp_path / "002.png", GREY[:, :28].copy())
    with pytest.raises(CorruptImage, match=r"002\.png: 28 x 20 px, but 000\.png has 30 x 20"):
        read_images(tmp_path)[2]


def test_names_without_numbers_and_with_the_same_are_named(tmp_path):
    folder(tmp_path, [1])
    with pytest.raises(CorruptImage, match=r"no file fits pattern '\*\.jpg'"):
        read_images(tmp_path, "*.jpg")
    save(tmp_path / "1.png")
    with pytest.raises(CorruptImage, match=r"1\.png: has the number of 001\.png"):
        read_images(tmp_path)
    save(tmp_path / "2" / f"{10**19}.png")
    with pytest.raises(CorruptImage, match=r"0\.png: the name has no number"):
        read_images(tmp_path / "2")
    save(tmp_path / "cover.png")
    with pytest.raises(CorruptImage, match=r"cover\.png: the name has no number"):
        read_images(tmp_path, "c*")
    save(tmp_path / "3" / "a_1.png")
    save(tmp_path / "3" / "b_1_2.png")
    with pytest.raises(CorruptImage, match=r"b_1_2\.png: the name has 2 numbers, that of a_1\.png"):
        read_images(tmp_path / "3")
    (tmp_path / "4").mkdir()
    with pytest.raises(CorruptImage, match=r"4: no file is a picture"):
        read_images(tmp_path / "4")
    with pytest.raises(NotADirectoryError, match="there is no such folder"):
        read_images(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match="pattern must be of names in the folder"):
        read_images(tmp_path, "../*.png")


NAMES = {  # in order: what they say, the numbers, the times
    "one changes": (["cam1_2024_frame9left", "cam1_2024_frame10left"], (9, 10), None),
    "the first changes": (["frame9_of_20", "frame10_of_20"], (9, 10), None),
    "stamps of TUM RGB-D": (
        ["1305031102.175304", "1305031102.975326", "1305031103.011200"],
        (1305031102175304, 1305031102975326, 1305031103011200),
        (1305031102.175304, 1305031102.975326, 1305031103.0112),
    ),
    "stamps within a second": (
        ["1305031102.175304", "1305031102.211214"],
        (1305031102175304, 1305031102211214),
        (1305031102.175304, 1305031102.211214),
    ),
    "stamps as Python writes them": (
        ["1305031102.05", "1305031102.1", "1305031102.25"],
        (130503110205, 130503110210, 130503110225),
        (1305031102.05, 1305031102.1, 1305031102.25),
    ),
    "whole seconds and nanoseconds": (
        ["1305031102.5304000", "1305031102.175304000", "1305031103.1"],
        (1305031102005304000, 1305031102175304000, 1305031103000000001),
        (1305031102.005304, 1305031102.175304, 1305031103.0),
    ),
    "whole seconds and microseconds": (
        ["1305031102.17", "1305031102.530400"],
        (1305031102000017, 1305031102530400),
        (1305031102.000017, 1305031102.5304),
    ),
    "a counter that is no clock": (["5000000001", "5000000003"], (5000000001, 5000000003), None),
    "counters from nought": (["scene1.0", "scene1.9", "scene2.10"], (100, 109, 210), None),
    "nanoseconds": (
        ["1403715274512143104", "1403715275512143104"],
        (1403715274512143104, 1403715275512143104),
        (1403715274.512143104, 1403715275.512143104),
    ),
    "microseconds": (
        ["img_1403715274512143", "img_1403715274562143"],
        (1403715274512143, 1403715274562143),
        (1403715274.512143, 1403715274.562143),
    ),
    "seconds of a film": (
        ["0.033333", "0.066667", "1.000000"],
        (33333, 66667, 1000000),
        (0.033333, 0.066667, 1.0),
    ),
    "a counter with a stamp": (
        [
            "frame0008_1305031102.175304",
            "frame0009_1305031102.211214",
            "frame0010_1305031103.011200",
        ],
        (8, 9, 10),
        (1305031102.175304, 1305031102.211214, 1305031103.0112),
    ),
    "scenes of KITTI": (["000001_10", "000001_11", "000002_10"], (110, 111, 210), None),
    "counters with a point": (["scene1.9", "scene1.10", "scene2.1"], (109, 110, 201), None),
    "a day and an hour": (
        ["IMG_20240131_235959", "IMG_20240201_000001"],
        (20240131, 20240201),
        (0.0, 2.0),
    ),
    "a day, an hour and milliseconds": (
        ["IMG_20240501_235958_120", "IMG_20240501_235958_920", "IMG_20240502_000001_020"],
        (20240501235958120, 20240501235958920, 20240502000001020),
        (0.0, 0.8, 2.9),
    ),
    "milliseconds behind seconds": (
        ["PXL_20240501_235958120", "PXL_20240501_235959020"],
        (235958120, 235959020),
        (0.0, 0.9),
    ),
    "a date in words": (
        ["WhatsApp Image 2024-05-01 at 23.59.58", "WhatsApp Image 2024-05-02 at 00.00.01"],
        (1, 2),
        (0.0, 3.0),
    ),
    "a date with parts": (
        ["cam1_2024-05-01T23:59:58.5004", "cam1_2024-05-01T23:59:59.2504"],
        (585004, 592504),
        (0.0, 0.75),
    ),
    "a date as one number": (
        ["20240501235958", "20240502000001"],
        (20240501235958, 20240502000001),
        (0.0, 3.0),
    ),
    "counters of a second": (
        ["01-20240501235958-00", "01-20240501235958-01", "01-20240501235959-00"],
        (2024050123595800, 2024050123595801, 2024050123595900),
        None,
    ),
    "a day and a counter": (["20240501_000000", "20240501_000001"], (0, 1), None),
    "seconds and nanoseconds apart": (
        ["1305031102_175304000", "1305031102_975326000", "1305031103_011200000"],
        (1305031102175304000, 1305031102975326000, 1305031103011200000),
        (1305031102.175304, 1305031102.975326, 1305031103.0112),
    ),
    "seconds and nanoseconds as they are": (
        ["1305031102-5304000", "1305031102-175304000", "1305031103-7"],
        (1305031102005304000, 1305031102175304000, 1305031103000000007),
        (1305031102.005304, 1305031102.175304, 1305031103.0),
    ),
    "seconds and a counter": (
        ["1305031102_1", "1305031102_2", "1305031103_3"],
        (13050311021, 13050311022, 13050311033),
        None,
    ),
    "bursts": (
        ["IMG_20240131_235959_002", "IMG_20240131_235959_010", "IMG_20240201_000001_001"],
        (20240131235959002, 20240131235959010, 20240201000001001),
        None,
    ),
    "a burst that is long": (
        ["IMG_20240131_235959_107", "IMG_20240131_235959_108", "IMG_20240131_235959_109"],
        (107, 108, 109),
        None,
    ),
    "midnight": (["2024-05-01_00-00-01", "2024-05-01_00-00-03"], (1, 3), (0.0, 2.0)),
    "months and days": (["2024.01.31", "2024.02.01"], (131, 201), None),
    "a point without meaning": (["shot.1.0008", "shot.1.0009"], (8, 9), None),
}


@pytest.mark.parametrize("kind", NAMES)
@pytest.mark.parametrize("ending", [".png", ".PNG", ".jpg"])
def test_pictures_are_in_the_order_of_the_whole_numbers(kind, ending, tmp_path):
    names, numbers, times = NAMES[kind]
    for k, name in enumerate(names):
        save(tmp_path / f"{name}{ending}", np.full((20, 30), 40 * k, np.uint8))
    found = read_images(tmp_path, allow_gaps=True)
    assert [path.stem for path in found.paths] == names
    assert found.numbers == numbers
    assert (found.times is None) == (times is None)
    np.testing.assert_allclose(found.times or (), times or (), rtol=0, atol=3e-7)
    assert [int(picture[0, 0]) for picture in found] == [40 * k for k in range(len(names))]
    assert found[1:].times == (times and found.times[1:])
    assert len(read_images(tmp_path, f"*{ending.lower()}", allow_gaps=True)) == len(names)


def test_times_of_day_may_stand_in_a_folder_with_the_day(tmp_path):
    day = tmp_path / "2024-05-01"
    for name in ("23-59-57", "23-59-59"):
        save(day / f"{name}.png")
    assert read_images(day).times == (0.0, 2.0)
    folder(tmp_path / "2024-05-02", [0, 1, 2], "{:06}.png")
    assert read_images(tmp_path / "2024-05-02").times is None


@pytest.mark.parametrize(
    "names", [NAMES["bursts"][0], NAMES["scenes of KITTI"][0], NAMES["seconds and a counter"][0]]
)
def test_numbers_that_are_put_together_count_nothing(names, tmp_path):
    for name in names:
        save(tmp_path / f"{name}.png")
    found = read_images(tmp_path)
    assert (found.counts, found[1:].counts) == ((0, 1, 2), (0, 1))
    film = read_film(tmp_path)
    list(film)
    np.testing.assert_allclose(film.seconds(10.0), [0.0, 0.1, 0.2])
    assert read_images(folder(tmp_path / "counted", [7, 9, 11])).counts == (7, 9, 11)


def test_of_one_name_the_last_number_counts(tmp_path):
    assert read_images(folder(tmp_path, [7], "cam1_{}.png")).numbers == (7,)


def test_numbers_that_are_put_together_have_no_gaps(tmp_path):
    for scene in range(4):
        folder(tmp_path, [10, 11], f"{scene:06}_{{}}.png")
    found = read_images(tmp_path)
    assert (len(found), found.gaps, found[2:].gaps) == (8, (), ())


@given(
    st.lists(st.integers(0, 4 * 10**15), min_size=2, max_size=20, unique=True), st.integers(0, 6)
)
def test_stamps_have_the_order_of_their_times(microseconds, shift):
    """Whatever their decimals, as long as all have as many."""
    exact = sorted(10**15 + stamp // 10**shift * 10**shift for stamp in set(microseconds))
    exact = sorted(set(exact))
    paths = [Path(f"{stamp // 10**6}.{stamp % 10**6:06}.png") for stamp in exact]
    found = numbering(sorted(paths, key=lambda path: path.name[::-1]))
    assert list(found.paths) == paths
    if len(exact) > 1:
        np.testing.assert_allclose(found.times, np.array(exact) / 1e6, rtol=0, atol=5e-7)


@given(st.lists(st.integers(0, 10**6), min_size=1, max_size=20, unique=True), st.booleans())
def test_counters_have_their_own_order(numbers, padded):
    paths = [Path(f"left_{n:07}.png" if padded else f"left_{n}.png") for n in numbers]
    assert numbering(paths).numbers == tuple(sorted(numbers))


def test_names_that_can_be_read_in_two_ways_are_refused():
    with pytest.raises(CorruptImage, match=r"may be decimal numbers or hold two counters"):
        numbering([Path(f"{name}.png") for name in ("0.25", "0.5", "1.75")])


def test_hidden_files_and_what_is_no_picture_are_skipped_and_told(tmp_path):
    folder(tmp_path, [1, 2], "{}.png")
    (tmp_path / "._1.png").write_bytes(b"\0\5\x16\7")  # as macOS writes it on other drives
    (tmp_path / ".thumbnails").mkdir()
    (tmp_path / "3.png").mkdir()
    (tmp_path / "notes.txt").write_text("1\n2\n")
    found = read_images(tmp_path)
    assert found.numbers == (1, 2)
    assert [path.name for path in found.skipped] == ["._1.png", ".thumbnails", "3.png", "notes.txt"]
    assert [path.name for path in read_images(tmp_path, "*.png").skipped] == ["._1.png", "3.png"]
    assert found[1:].skipped == found.skipped
    assert images.picture_files(tmp_path, "*.gif") == ((), ())


def test_a_gallery_has_a_folder_for_each_person(tmp_path):
    """Names are as they are; what is hidden or no picture is skipped, and told."""
    for name in ("Smith, Ann", "王 小明", ".cache", "empty/.hidden"):
        (tmp_path / "all" / name).mkdir(parents=True)
    people = tmp_path / "all"
    with pytest.raises(CorruptImage, match="Smith, Ann: no file is a picture"):
        images.gallery_files(people)
    (people / "empty").rename(tmp_path / "empty")
    mine = [save(people / "Smith, Ann" / name) for name in ("b.png", "a.BMP")]
    (theirs,) = (save(people / "王 小明" / "1.png"),)
    others = [people / "Smith, Ann" / "._a.png", people / "Smith, Ann" / "x.txt", people / "y.txt"]
    for path in others:
        path.write_text("no picture")
    found, skipped = images.gallery_files(people)
    assert found == {"Smith, Ann": (mine[1], mine[0]), "王 小明": (theirs,)}
    assert sorted(skipped) == sorted([people / ".cache", *others])
    for name in ("a\nb", "a\x1bb", "a\u2028b"):
        (people / name).mkdir()
        with pytest.raises(CorruptImage, match="is no name that can be written"):
            images.gallery_files(people)
        (people / name).rmdir()
    with pytest.raises(CorruptImage, match="the gallery needs a folder for each person"):
        images.gallery_files(tmp_path / "empty")
    with pytest.raises(NotADirectoryError, match="none: there is no such folder"):
        images.gallery_files(tmp_path / "none")


def test_sequences_made_by_hand_must_fit(tmp_path):
    path = save(tmp_path / "1.png")
    with unchecked():
        for paths, numbers, message in [
            ((), (), "paths must be one at least"),
            ((path,), (1, 2), "as many as numbers, got 1 and 2"),
            ((path, path), (2, 2), "numbers must rise, got 2 before 2"),
        ]:
            with pytest.raises(ValueError, match=message):
                ImageSequence(paths, numbers)
        for times, message in [
            ((1.0,), "times must be 2 for paths, got 1"),
            ((1.0, 1.0), "times must rise, got 1.0 before 1.0"),
            ((1.0, np.nan), "times must be finite"),
        ]:
            with pytest.raises(ValueError, match=message):
                ImageSequence((path, path), (1, 2), times=times)
        with pytest.raises(TypeError, match=r"at must be a whole number, got '0'"):
            ImageSequence((path,), (1,))["0"]


# ---- stereo --------------------------------------------------------------------------------------


def test_pairs_go_together(tmp_path):
    left = read_images(folder(tmp_path / "l", range(3)))
    right = read_images(folder(tmp_path / "r", range(3), pixels=GREY[::-1].copy()))
    pairs = StereoSequence(left, right)
    assert (len(pairs), pairs.numbers, pairs.size) == (3, (0, 1, 2), (30, 20))
    for k, (one, two) in enumerate(pairs):
        np.testing.assert_array_equal(one, np.roll(GREY, k, axis=0))
        np.testing.assert_array_equal(two, np.roll(GREY[::-1], k, axis=0))
    np.testing.assert_array_equal(pairs[1:][0][1], right[1])


def test_pictures_without_partner_and_of_other_size_are_named(tmp_path):
    left = read_images(folder(tmp_path / "l", range(4)))
    right = read_images(folder(tmp_path / "r", range(4)))
    with pytest.raises(CorruptImage, match=r"r: 2 pictures of right have no partner: 2, 3"):
        StereoSequence(left[:2], right)
    with pytest.raises(CorruptImage, match=r"l: 1 pictures of left have no partner: 0"):
        StereoSequence(left, right[1:])
    small = read_images(folder(tmp_path / "s", range(4), pixels=GREY[:10].copy()))
    with pytest.raises(CorruptImage, match=r"one size, got \(30, 20\) and \(30, 10\)"):
        StereoSequence(left, small)

"""CARMEN logs: every number read, every line accounted for."""

import gzip
import tempfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robot_perception.datasets import CorruptLog, read_carmen_log
from robot_perception.datasets import logs as reasons
from tests.datasets.writing import carmen_truth, flaser, write


def accounted(report) -> int:
    """Return the number of lines the report explains."""
    return sum(report.kept.values()) + sum(report.others.values()) + report.skipped_lines


@pytest.mark.parametrize("name", ["a.log", "a.log.gz"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_every_number_is_read_back(tmp_path, name, end):
    truth = carmen_truth()
    log = read_carmen_log(write(tmp_path / name, truth.lines, end=end), strict=True)
    np.testing.assert_array_equal(log.ranges, truth.ranges)
    np.testing.assert_array_equal(log.poses, truth.poses)
    np.testing.assert_array_equal(log.odometry, truth.odometry)
    np.testing.assert_array_equal(log.times, truth.times)
    assert log.report.scans == log.report.lines == len(truth.lines)
    assert log.report.skipped == ()
    assert not log.report.truncated


def test_gzip_is_told_from_content_and_either_name_will_do(tmp_path):
    truth = carmen_truth()
    (tmp_path / "misnamed.log").write_bytes(gzip.compress(b"\n".join(truth.lines)))
    np.testing.assert_array_equal(read_carmen_log(tmp_path / "misnamed.log").ranges, truth.ranges)
    write(tmp_path / "plain.log", truth.lines)
    write(tmp_path / "packed.log.gz", truth.lines)
    assert read_carmen_log(tmp_path / "plain.log.gz").report.path == tmp_path / "plain.log"
    assert read_carmen_log(tmp_path / "packed.log").report.path == tmp_path / "packed.log.gz"


def test_several_gzip_streams_in_a_row_are_one_log(tmp_path):
    truth = carmen_truth()
    packed = b"".join(gzip.compress(line + b"\n") for line in truth.lines)
    (tmp_path / "a.log.gz").write_bytes(packed + b"\0" * 512)
    np.testing.assert_array_equal(read_carmen_log(tmp_path / "a.log.gz").ranges, truth.ranges)


@pytest.mark.parametrize(
    ("beams", "first_deg", "last_deg"),
    [(180, -90, 89), (181, -90, 90), (360, -90, 89.5), (361, -90, 90)],
)
def test_beams_point_where_convention_says(tmp_path, beams, first_deg, last_deg):
    truth = carmen_truth(scans=1, beams=beams)
    angles = read_carmen_log(write(tmp_path / "a.log", truth.lines)).angles
    np.testing.assert_allclose(np.rad2deg(angles[[0, -1]]), [first_deg, last_deg])
    assert (np.diff(angles) > 0).all()


def test_other_numbers_of_beams_need_a_field_of_view(tmp_path):
    path = write(tmp_path / "a.log", carmen_truth(beams=5).lines)
    with pytest.raises(CorruptLog, match=r"no FLASER line .*\(give field_of_view\)"):
        read_carmen_log(path)
    log = read_carmen_log(path, field_of_view=(-1.0, 1.0))
    np.testing.assert_allclose(log.angles, [-1.0, -0.5, 0.0, 0.5, 1.0])
    with pytest.raises(ValueError, match=r"two finite angles, got \(nan, 1\.0\)"):
        read_carmen_log(path, field_of_view=(np.nan, 1.0))


@pytest.mark.parametrize(
    ("readings", "threshold", "returns"),
    [
        ([1.0, 60.0, 81.83, 81.91], 80.0, 2),
        ([1.0, 49.9, 50.0, 51.25], 50.0, 2),
        ([1.0, 32.598, 32.759, 32.767], 32.759, 2),
        ([1.0, 20.0, 30.0, 40.0], np.inf, 4),
        ([1.0, 50.5, 55.0, 60.0], np.inf, 4),
    ],
)
def test_largest_reading_tells_what_no_return_is(tmp_path, readings, threshold, returns):
    line = flaser(readings, np.zeros(3), np.zeros(3), 1.0)
    log = read_carmen_log(write(tmp_path / "a.log", [line]), field_of_view=(-1.0, 1.0))
    assert log.max_range == threshold
    np.testing.assert_array_equal(log.ranges[0, :returns], readings[:returns])
    assert np.isinf(log.ranges[0, returns:]).all()


def test_threshold_can_be_given(tmp_path):
    line = flaser([1.0, 8.0, 8.1, 81.91], np.zeros(3), np.zeros(3), 1.0)
    path = write(tmp_path / "a.log", [line])
    log = read_carmen_log(path, field_of_view=(-1.0, 1.0), max_range=8.1)
    np.testing.assert_array_equal(log.ranges, [[1.0, 8.0, np.inf, np.inf]])
    with pytest.raises(ValueError, match="max_range must be positive, got -1"):
        read_carmen_log(path, field_of_view=(-1.0, 1.0), max_range=-1.0)


GOOD = carmen_truth()


def changed(word: int, value: bytes) -> bytes:
    """Return the first good line with one word replaced."""
    words = GOOD.lines[0].split()
    words[word] = value
    return b" ".join(words)


BAD_LINES = {
    "truncated": (b" ".join(GOOD.lines[0].split()[:60]), reasons.SHORT),
    "keyword only": (b"FLASER", reasons.BAD_COUNT),
    "one word too many": (GOOD.lines[0] + b" 7", reasons.LONG),
    "two lines in one": (GOOD.lines[0] + b" " + GOOD.lines[1], reasons.LONG),
    "count too high": (changed(1, b"181"), reasons.SHORT),
    "count too low": (changed(1, b"179"), reasons.LONG),
    "count zero": (changed(1, b"0"), reasons.BAD_COUNT),
    "count negative": (changed(1, b"-180"), reasons.BAD_COUNT),
    "count huge": (changed(1, b"9" * 30), reasons.BAD_COUNT),
    "count not a number": (changed(1, b"many"), reasons.BAD_COUNT),
    "word among readings": (changed(40, b"3.x"), reasons.NOT_NUMBERS),
    "underscore": (changed(40, b"1_0"), reasons.NOT_NUMBERS),
    "word in pose": (changed(183, b"north"), reasons.NOT_NUMBERS),
    "NaN reading": (changed(40, b"nan"), reasons.BAD_READING),
    "infinite reading": (changed(40, b"inf"), reasons.BAD_READING),
    "overflowing reading": (changed(40, b"1e999"), reasons.BAD_READING),
    "negative reading": (changed(40, b"-0.01"), reasons.BAD_READING),
    "NaN pose": (changed(183, b"nan"), reasons.NOT_FINITE),
    "infinite time": (changed(188, b"inf"), reasons.NOT_FINITE),
    "other number of beams": (carmen_truth(beams=360).lines[0], reasons.OTHER_BEAMS),
    "not UTF-8": (GOOD.lines[0] + b"\xff\xfe", reasons.NOT_TEXT),
    "control bytes": (b"FLASER \x00\x01\x02", reasons.CONTROL),
    "numbers alone": (b"1.0 2.0 3.0", reasons.NO_KEYWORD),
    "binary junk": (bytes(range(128, 256)), reasons.NOT_TEXT),
}


@pytest.mark.parametrize(("line", "reason"), BAD_LINES.values(), ids=BAD_LINES)
def test_bad_line_is_counted_with_its_reason_and_number(tmp_path, line, reason):
    lines = [GOOD.lines[0], line, *GOOD.lines[1:], line]
    path = write(tmp_path / "a.log", lines)
    log = read_carmen_log(path)
    np.testing.assert_array_equal(log.ranges, GOOD.ranges)
    (skipped,) = log.report.skipped
    assert (skipped.reason, skipped.count, skipped.first) == (reason, 2, (2, 6))
    assert accounted(log.report) == log.report.lines == 6
    with pytest.raises(CorruptLog, match=r"a\.log, line 2: ") as failure:
        read_carmen_log(path, strict=True)
    assert reason in str(failure.value)


def test_only_the_first_few_line_numbers_are_kept(tmp_path):
    lines = [GOOD.lines[0], *[b"FLASER x"] * 9]
    (skipped,) = read_carmen_log(write(tmp_path / "a.log", lines)).report.skipped
    assert skipped.count == 9
    assert skipped.first == (2, 3, 4, 5, 6)


def test_other_kinds_are_counted_by_keyword(tmp_path):
    others = [b"# comment", b"#", b"", b"  ", b"ODOM 0 0 0 0 0 0 1 h 1", b"ODOM", b"PARAM a b"]
    log = read_carmen_log(write(tmp_path / "a.log", [*others, *GOOD.lines]), strict=True)
    assert log.report.others == {"#": 2, "blank": 2, "ODOM": 2, "PARAM": 1}
    assert "other kinds 2 #, 2 blank, 2 ODOM, 1 PARAM" in str(log.report)


@pytest.mark.parametrize("name", ["empty.log", "empty.log.gz"])
def test_empty_file(tmp_path, name):
    (tmp_path / name).touch()
    with pytest.raises(CorruptLog, match=rf"{name}: the file is empty"):
        read_carmen_log(tmp_path / name)


def test_no_scan_at_all(tmp_path):
    path = write(tmp_path / "a.log", [b"ODOM 1", b"VERTEX2 0 0 0 0", b"FLASER 180"])
    with pytest.raises(CorruptLog, match=r"no FLASER line .* 1 ODOM, 1 VERTEX2; skipped 1 \("):
        read_carmen_log(path)
    with pytest.raises(CorruptLog, match="no FLASER line"):
        read_carmen_log(write(tmp_path / "b.log.gz", []))


def test_not_gzip_in_spite_of_its_name(tmp_path):
    (tmp_path / "a.log.gz").write_bytes(b"<html>404</html>")
    with pytest.raises(CorruptLog, match=r"a\.log\.gz: not a gzip file"):
        read_carmen_log(tmp_path / "a.log.gz")


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere"):
        read_carmen_log(tmp_path / "nowhere.log")


def read_bytes(content: bytes, name: str = "a.log", **options):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_carmen_log(path, **options)


def test_gzip_cut_at_every_place():
    """Of every beginning of a gzip file exactly its complete lines are read, or none."""
    truth = carmen_truth(scans=3, beams=30)
    view = {"field_of_view": (-1.0, 1.0)}
    text = b"".join(line + b"\n" for line in truth.lines)
    ends = [sum(len(line) + 1 for line in truth.lines[: i + 1]) for i in range(3)]
    whole = gzip.compress(text)
    counts = set()
    for cut in range(1, len(whole)):
        piece = whole[:cut]
        if cut >= 2:
            readable = _decompressed(piece)
            complete = sum(end <= readable for end in ends)
        else:
            complete = 0
        message = "cut short; (.*) complete FLASER" if cut >= 2 else "not a gzip file"
        with pytest.raises(CorruptLog, match=message) as failure:
            read_bytes(piece, "a.log.gz", **view)
        if cut >= 2:
            assert f"cut short; {complete} complete FLASER lines" in str(failure.value)
        if complete:
            log = read_bytes(piece, "a.log.gz", **view, allow_truncated=True, strict=True)
            np.testing.assert_array_equal(log.ranges, truth.ranges[:complete])
            assert log.report.truncated
            assert accounted(log.report) == log.report.lines
        elif cut >= 2:
            with pytest.raises(CorruptLog, match="no FLASER line could be read"):
                read_bytes(piece, "a.log.gz", **view, allow_truncated=True)
        counts.add(complete)
    assert counts == {0, 1, 2, 3}


def _decompressed(piece: bytes) -> int:
    """Return how many bytes of text the beginning of a gzip file holds, by another route."""
    if len(piece) <= 10:
        return 0
    return len(zlib.decompressobj(wbits=-15).decompress(piece[10:]))


def test_a_scan_cut_inside_its_last_number_is_not_taken_for_whole(tmp_path):
    """Cut in the time stamp, the words are all there and still wrong."""
    truth = carmen_truth(scans=2)
    text = truth.lines[0] + b"\n" + truth.lines[1][:-3]
    packed = gzip.compress(text)[:-8]  # the checksum is cut off
    log = read_bytes(packed, "a.log.gz", allow_truncated=True)
    assert log.report.scans == 1
    assert [item.reason for item in log.report.skipped] == [reasons.CUT]


@pytest.mark.parametrize("place", [0.3, 0.6, 0.9])
def test_flipped_bits_in_gzip_are_noticed(place):
    packed = bytearray(gzip.compress(b"\n".join(carmen_truth(scans=20).lines) + b"\n"))
    packed[int(place * len(packed))] ^= 0x55
    with pytest.raises(CorruptLog, match=r"damaged gzip file|cut short"):
        read_bytes(bytes(packed), "a.log.gz")


def test_something_after_the_gzip_stream_is_noticed():
    packed = gzip.compress(b"\n".join(GOOD.lines) + b"\n")
    with pytest.raises(CorruptLog, match="not gzip follows"):
        read_bytes(packed + b"<html>", "a.log.gz")
    assert read_bytes(packed + b"<html>", "a.log.gz", allow_truncated=True).report.scans == 4


LINES = st.one_of(
    st.binary(max_size=60),
    st.text(max_size=40).map(str.encode),
    st.builds(
        lambda words: b" ".join(words),
        st.lists(
            st.sampled_from(
                [b"FLASER", b"180", b"2", b"1.5", b"-1", b"nan", b"ODOM", b"#", b"\xff", b"1_0"]
            ),
            max_size=20,
        ),
    ),
    st.sampled_from([line for line, why in BAD_LINES.values() if why != reasons.OTHER_BEAMS]),
    st.integers(0, 300).map(lambda cut: GOOD.lines[0][:cut]),
)


@given(st.lists(st.tuples(st.integers(0, 4), LINES), max_size=12))
def test_junk_lines_never_hurt_a_good_log(insertions):
    """Whatever is inserted between the lines of a log: its scans are read, all is accounted for."""
    lines = [*GOOD.lines]
    for place, junk in insertions:
        lines.insert(place, junk.replace(b"\n", b"?"))
    assume(not lines[0].startswith(reasons.GZIP_MAGIC))  # that is no junk line: it is a gzip file
    log = read_bytes(b"\n".join(lines) + b"\n")
    assert accounted(log.report) == log.report.lines == len(lines)
    assert log.report.kept == {"FLASER": 4}
    np.testing.assert_array_equal(log.ranges, GOOD.ranges)
    np.testing.assert_array_equal(log.times, GOOD.times)


@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=40), st.booleans())
def test_bytes_anywhere_raise_nothing_but_corrupt_log(place, junk, packed):
    """Random bytes anywhere in a file, plain or gzip: an account of it all, or CorruptLog."""
    content = b"\n".join(GOOD.lines) + b"\n"
    content = gzip.compress(content, mtime=0) if packed else content
    place %= len(content) + 1
    damaged = content[:place] + junk + content[place:]
    try:
        log = read_bytes(damaged, allow_truncated=True)
    except CorruptLog:
        return
    assert accounted(log.report) == log.report.lines
    assert log.report.scans == len(log.ranges) == len(log.times) == len(log.poses)
    assert not np.isnan(log.ranges).any()
    assert (log.ranges >= 0).all()

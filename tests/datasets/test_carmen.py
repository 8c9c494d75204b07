"""CARMEN logs: where beams point, what no return is, and that the first bad line is named."""

import gzip
import re
import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from robot_perception.datasets import (
    CorruptLog,
    logs,
    read_carmen_log,
)
from tests.datasets.formats.lasers import BAD_LINES, OTHER, at_times, robot_lines
from tests.datasets.formats.lasers import TRUTH as GOOD
from tests.datasets.writing import carmen_truth, flaser, write


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
    told = r"line 1: no field of view is known for 5 beams: field_of_view=.*, in a script --field"
    with pytest.raises(CorruptLog, match=told):
        read_carmen_log(path)
    log = read_carmen_log(path, field_of_view=(-1.0, 1.0))
    np.testing.assert_allclose(log.angles, [-1.0, -0.5, 0.0, 0.5, 1.0])
    with pytest.raises(ValueError, match=r"two angles within a turn, got \(nan, 1\.0\)"):
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


def test_one_beam_is_a_scan_and_zero_a_reading(tmp_path):
    lines = [flaser([r], np.zeros(3), np.zeros(3), t) for r, t in ((0.0, 1.0), (2.0, 2.0))]
    log = read_carmen_log(write(tmp_path / "a.log", lines), field_of_view=(0.0, 0.0))
    np.testing.assert_array_equal(log.ranges, [[0.0], [2.0]])


def test_threshold_can_be_given(tmp_path):
    line = flaser([1.0, 8.0, 8.1, 81.91], np.zeros(3), np.zeros(3), 1.0)
    path = write(tmp_path / "a.log", [line])
    log = read_carmen_log(path, field_of_view=(-1.0, 1.0), max_range=8.1)
    np.testing.assert_array_equal(log.ranges, [[1.0, 8.0, np.inf, np.inf]])
    with pytest.raises(ValueError, match="max_range must be positive, got -1"):
        read_carmen_log(path, field_of_view=(-1.0, 1.0), max_range=-1.0)


def test_times_that_do_not_matter_are_read_as_they_are(tmp_path):
    (tmp_path / "a.log").write_bytes(at_times([0, 1, 2, 4e9]))
    log = read_carmen_log(tmp_path / "a.log", timed=False)
    np.testing.assert_array_equal(log.times, [0, 1, 2, 4e9])


def test_other_kinds_are_counted_by_keyword(tmp_path):
    others = [b"# comment", b"#", b"", b"  ", b"ODOM 0 0 0 0 0 0 1 h 1", b"ODOM", b"PARAM a b"]
    log = read_carmen_log(write(tmp_path / "a.log", [*others, *GOOD.lines]))
    assert log.report.others == {"#": 2, "blank": 2, "ODOM": 2, "PARAM": 1}
    assert "other kinds 2 #, 2 blank, 2 ODOM, 1 PARAM" in str(log.report)


def test_a_log_of_the_newer_form_is_the_same(tmp_path):
    """It tells where its beams point, so that any number of them will do."""
    truth = carmen_truth(beams=7)
    log = read_carmen_log(write(tmp_path / "a.log", robot_lines(truth, resolution=0.25)))
    np.testing.assert_allclose(log.angles, -np.pi / 2 + 0.25 * np.arange(7))
    for name in ("ranges", "poses", "odometry", "times"):
        np.testing.assert_array_equal(getattr(log, name), getattr(truth, name))
    assert log.report.kept == {"ROBOTLASER1": len(truth.times)}
    told = read_carmen_log(tmp_path / "a.log", field_of_view=(-1.0, 1.0))
    np.testing.assert_allclose(told.angles, np.linspace(-1, 1, 7))


def test_where_a_log_has_both_forms_the_older_one_counts(tmp_path):
    """Whatever the newer lines hold."""
    pairs = zip(robot_lines(GOOD), GOOD.lines, strict=True)
    lines = [line for pair in pairs for line in pair]
    log = read_carmen_log(write(tmp_path / "a.log", [b"ROBOTLASER1 x", *lines]))
    np.testing.assert_array_equal(log.ranges, GOOD.ranges)
    assert (log.report.kept, log.report.others) == ({"FLASER": 4}, {"ROBOTLASER1": 5})
    assert log.report.lines == 9


def read_bytes(content: bytes, name: str = "a.log", **options):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_carmen_log(path, **options)


@pytest.mark.parametrize("line", [b"\n", b"# " + b"x" * 998 + b"\n", b"0" * 1000])
def test_gzip_bomb_is_refused_before_it_fills_the_memory(tmp_path, line):
    """Of 300 MB in 0.6 MB, little more than the hundredfold of the file is ever unpacked."""
    path = tmp_path / "a.log.gz"
    path.write_bytes(gzip.compress(line * (10_000_000 // len(line))) * 30)
    size = path.stat().st_size
    assert size < 700_000
    tracemalloc.start()
    with pytest.raises(
        CorruptLog, match=rf"a\.log\.gz: {size} bytes unpack to more than {100 * size}"
    ):
        read_carmen_log(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 250 * size


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
    st.sampled_from([line for line, why in BAD_LINES.values() if why != OTHER][:-1]),
    st.integers(0, 300).map(lambda cut: GOOD.lines[0][:cut]),
)


def outcome(lines: list[bytes]) -> int:
    """Return the number of the line that is named, or 0 if the log is read, as it was written."""
    try:
        log = read_bytes(b"\n".join(lines) + b"\n")
    except CorruptLog as error:
        return int(re.search(r"line (\d+): ", str(error))[1])
    assert log.report.lines == len(lines)
    np.testing.assert_array_equal(log.ranges, GOOD.ranges)
    np.testing.assert_array_equal(log.times, GOOD.times)
    return 0


@given(st.lists(st.tuples(st.integers(0, 4), LINES), max_size=6))
@settings(deadline=None)
def test_the_first_bad_line_is_named_whatever_stands_around_it(insertions):
    """Law: a line is bad or not by itself, and without bad lines nothing is lost."""
    lines = [(line, False) for line in GOOD.lines]
    for place, junk in insertions:
        line = re.sub(rb"[\r\n]", b"?", junk)  # either ends a line
        lines.insert(place, (line, outcome([*GOOD.lines, line]) == 5))
    marks = (logs.GZIP_MAGIC, *logs.ENCODINGS)  # no junk line begins so, but a file of another kind
    assume(not lines[0][0].startswith(marks))
    bad = [number for number, (_, is_bad) in enumerate(lines, start=1) if is_bad]
    assert outcome([line for line, _ in lines]) == (bad[0] if bad else 0)

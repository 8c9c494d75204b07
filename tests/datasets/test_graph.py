"""Pose-graph logs: scans stay with their vertices, edges with theirs, whatever is damaged."""

import gzip
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robot_perception.datasets import CorruptLog, graph, read_graph_log
from robot_perception.datasets import logs as reasons
from tests.datasets.writing import edge, robotlaser, vertex, write

BEAMS, VERTICES = 7, 4
RNG = np.random.default_rng(7)
RANGES = RNG.uniform(0.1, 29.0, (VERTICES, BEAMS))
POSES, LASER, ROBOT = RNG.normal(size=(3, VERTICES, 3))
TIMES = 1211.5 + np.arange(VERTICES)
IDS = [0, 10, 20, 35]
EDGES = [(0, 10), (10, 20), (20, 35), (0, 35)]
MOTIONS = RNG.normal(size=(4, 3))
TERMS = [1.0, 0.1, 2.0, 3.0, 0.2, 0.3]  # TORO: xx xy yy tt xt yt
INFORMATION = [[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]]


def scan(row: int, **options) -> bytes:
    return robotlaser(RANGES[row], LASER[row], ROBOT[row], TIMES[row], **options)


BODY = [line for row in range(VERTICES) for line in (vertex(IDS[row], POSES[row]), scan(row))]
EDGE_LINES = [edge(*ends, motion, TERMS) for ends, motion in zip(EDGES, MOTIONS, strict=True)]
GOOD = [*BODY, b"#LOOP EDGES", *EDGE_LINES]


def accounted(report) -> int:
    return sum(report.kept.values()) + sum(report.others.values()) + report.skipped_lines


@pytest.mark.parametrize("name", ["a.log", "a.log.gz"])
def test_every_number_is_read_back(tmp_path, name):
    log = read_graph_log(write(tmp_path / name, GOOD), strict=True)
    np.testing.assert_array_equal(log.ranges, RANGES)
    np.testing.assert_array_equal(log.poses, LASER)
    np.testing.assert_array_equal(log.odometry, ROBOT)
    np.testing.assert_array_equal(log.times, TIMES)
    np.testing.assert_array_equal(log.vertices, POSES)
    np.testing.assert_array_equal(log.vertex_ids, IDS)
    np.testing.assert_array_equal(log.scan_vertices, [0, 1, 2, 3])
    np.testing.assert_array_equal(log.edges, [[0, 1], [1, 2], [2, 3], [0, 3]])
    np.testing.assert_array_equal(log.motions, MOTIONS)
    np.testing.assert_array_equal(log.information, [INFORMATION] * 4)
    np.testing.assert_allclose(log.angles, -1.5 + 0.5 * np.arange(BEAMS))
    assert log.report.kept == {"VERTEX2": 4, "ROBOTLASER1": 4, "EDGE2": 4}
    assert log.report.scans == 4
    assert log.report.others == {"#": 1}


def test_g2o_orders_the_information_by_rows(tmp_path):
    """The same six numbers mean another matrix under EDGE_SE2 than under EDGE2."""
    line = edge(0, 10, MOTIONS[0], [1.0, 0.1, 0.2, 2.0, 0.3, 3.0], keyword="EDGE_SE2")
    body = [row.replace(b"VERTEX2", b"VERTEX_SE2") for row in BODY]
    log = read_graph_log(write(tmp_path / "a.g2o", [*body, line]), strict=True)
    np.testing.assert_array_equal(log.information, [INFORMATION])
    assert log.report.kept["VERTEX_SE2"] == 4


def test_edges_may_stand_before_their_vertices(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [*EDGE_LINES, *BODY]), strict=True)
    np.testing.assert_array_equal(log.edges, [[0, 1], [1, 2], [2, 3], [0, 3]])


def test_no_edges_and_vertices_without_scan(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [vertex(3, POSES[0]), *BODY]), strict=True)
    assert log.edges.shape == (0, 2)
    assert log.motions.shape == (0, 3)
    assert log.information.shape == (0, 3, 3)
    np.testing.assert_array_equal(log.scan_vertices, [1, 2, 3, 4])


def test_remissions_are_passed_over(tmp_path):
    lines = [vertex(0, POSES[0]), scan(0, remissions=(5.0, 6.0))]
    log = read_graph_log(write(tmp_path / "a.log", lines), strict=True)
    np.testing.assert_array_equal(log.poses, LASER[:1])
    assert log.times[0] == TIMES[0]


def test_no_return_comes_from_readings_not_from_the_line(tmp_path):
    """The known logs write maxrange 50 and keep readings up to 81.91."""
    readings = [1.0, 60.0, 81.91]
    line = robotlaser(readings, LASER[0], ROBOT[0], 1.0)
    log = read_graph_log(write(tmp_path / "a.log", [vertex(0, POSES[0]), line]))
    np.testing.assert_array_equal(log.ranges, [[1.0, 60.0, np.inf]])
    assert log.max_range == 80.0


def without(row: int, word: int, value: bytes | None) -> bytes:
    """Return scan ``row`` with one word replaced, or all from there on cut off."""
    words = scan(row).split()
    words[word:] = [] if value is None else [value, *words[word + 1 :]]
    return b" ".join(words)


BAD_SCANS = {
    "header cut": (without(1, 5, None), reasons.SHORT),
    "readings cut": (without(1, 12, None), reasons.SHORT),
    "before remissions cut": (without(1, 9 + BEAMS, None), reasons.SHORT),
    "tail cut": (without(1, 20, None), reasons.SHORT),
    "too long": (scan(1) + b" 1", reasons.LONG),
    "count": (without(1, 8, b"x"), reasons.BAD_COUNT),
    "count too low": (without(1, 8, b"6"), graph.REMISSION_COUNT),
    "remission count": (without(1, 9 + BEAMS, b"-1"), graph.REMISSION_COUNT),
    "word": (without(1, 10, b"1.x"), reasons.NOT_NUMBERS),
    "NaN": (without(1, 10, b"nan"), reasons.BAD_READING),
    "negative": (without(1, 10, b"-1"), reasons.BAD_READING),
    "pose": (without(1, 18, b"inf"), reasons.NOT_FINITE),
    "beams": (robotlaser(RANGES[1][:5], LASER[1], ROBOT[1], 1.0), reasons.OTHER_BEAMS),
    "start": (scan(1, start=-1.0), graph.OTHER_FIELD),
    "resolution": (scan(1, resolution=0.25), graph.OTHER_FIELD),
    "control bytes": (b"ROBOTLASER1 \x00\x01", reasons.CONTROL),
}


@pytest.mark.parametrize(("line", "reason"), BAD_SCANS.values(), ids=BAD_SCANS)
def test_bad_scan_leaves_its_vertex_and_all_others(tmp_path, line, reason):
    lines = [*GOOD[:3], line, *GOOD[4:]]
    path = write(tmp_path / "a.log", lines)
    log = read_graph_log(path)
    np.testing.assert_array_equal(log.ranges, RANGES[[0, 2, 3]])
    np.testing.assert_array_equal(log.scan_vertices, [0, 2, 3])
    np.testing.assert_array_equal(log.vertices, POSES)
    assert [(item.reason, item.first) for item in log.report.skipped] == [(reason, (4,))]
    assert accounted(log.report) == log.report.lines
    with pytest.raises(CorruptLog, match=r"a\.log, line 4: ") as failure:
        read_graph_log(path, strict=True)
    assert reason in str(failure.value)


BAD_VERTICES = {
    "cut": (b"VERTEX2 10 0.5", reasons.SHORT),
    "long": (vertex(10, POSES[1]) + b" 1", reasons.LONG),
    "id": (b"VERTEX2 1.5 0 0 0", graph.BAD_ID),
    "word": (b"VERTEX2 10 a 0 0", reasons.NOT_NUMBERS),
    "NaN": (b"VERTEX2 10 nan 0 0", reasons.NOT_FINITE),
    "repeated": (vertex(0, POSES[1]), graph.REPEATED),
    "not text": (b"VERTEX2 10 0 0 \xff", reasons.NOT_TEXT),
    "misspelt": (b"VERTXE2 10 0 0 0", None),
}


@pytest.mark.parametrize("scan_before", [True, False])
@pytest.mark.parametrize(("line", "reason"), BAD_VERTICES.values(), ids=BAD_VERTICES)
def test_scan_of_a_bad_vertex_goes_to_no_other(tmp_path, line, reason, scan_before):
    """Also where the vertex before has no scan, and could be mistaken for the owner."""
    before = GOOD[:2] if scan_before else GOOD[:1]
    log = read_graph_log(write(tmp_path / "a.log", [*before, line, *GOOD[3:]]))
    rows = [0, 2, 3] if scan_before else [2, 3]
    np.testing.assert_array_equal(log.ranges, RANGES[rows])
    np.testing.assert_array_equal(log.vertices, POSES[[0, 2, 3]])
    np.testing.assert_array_equal(log.scan_vertices, [0, 1, 2] if scan_before else [1, 2])
    skipped = {item.reason: item.count for item in log.report.skipped}
    expected = {reason: 1} if reason else {}
    assert skipped == {**expected, graph.NO_VERTEX: 1, graph.LOST_END: 2}
    np.testing.assert_array_equal(log.edges, [[1, 2], [0, 2]])
    assert accounted(log.report) == log.report.lines


def test_second_scan_and_scan_without_vertex_are_reported(tmp_path):
    lines = [scan(3), *GOOD[:2], scan(1), b"", b"# comment", *GOOD[2:3], b"", b"#", GOOD[3]]
    log = read_graph_log(write(tmp_path / "a.log", lines))
    np.testing.assert_array_equal(log.ranges, RANGES[:2])
    (skipped,) = log.report.skipped
    assert (skipped.reason, skipped.first) == (graph.NO_VERTEX, (1, 4))


BAD_EDGES = {
    "cut": (b"EDGE2 0 10 1 2", reasons.SHORT),
    "long": (EDGE_LINES[0] + b" 1", reasons.LONG),
    "id": (b"EDGE2 0 b" + EDGE_LINES[0][10:], graph.BAD_ID),
    "word": (EDGE_LINES[0][:-3] + b"x.3", reasons.NOT_NUMBERS),
    "infinite": (edge(0, 10, [np.inf, 0, 0], TERMS), reasons.NOT_FINITE),
    "lost": (edge(0, 999, MOTIONS[0], TERMS), graph.LOST_END),
}


@pytest.mark.parametrize(("line", "reason"), BAD_EDGES.values(), ids=BAD_EDGES)
def test_bad_edge_is_left_out(tmp_path, line, reason):
    path = write(tmp_path / "a.log", [*GOOD, line])
    log = read_graph_log(path)
    assert len(log.edges) == 4
    assert [(item.reason, item.first) for item in log.report.skipped] == [(reason, (14,))]
    assert accounted(log.report) == log.report.lines == 14
    with pytest.raises(CorruptLog, match="line 14"):
        read_graph_log(path, strict=True)


def test_no_scan_at_all(tmp_path):
    path = write(tmp_path / "a.log", [vertex(0, POSES[0]), b"FLASER 1 2"])
    with pytest.raises(CorruptLog, match=r"no ROBOTLASER1 line .*1 VERTEX2; other kinds 1 FLASER"):
        read_graph_log(path)


def read_bytes(content: bytes, name: str = "a.log", **options):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_graph_log(path, **options)


def test_gzip_cut_at_every_place():
    whole = gzip.compress(b"".join(line + b"\n" for line in GOOD))
    scans = []
    for cut in range(2, len(whole)):
        with pytest.raises(CorruptLog, match=r"cut short; \d complete ROBOTLASER1 lines"):
            read_bytes(whole[:cut], "a.log.gz")
        try:
            log = read_bytes(whole[:cut], "a.log.gz", allow_truncated=True)
        except CorruptLog:
            scans.append(0)
            continue
        assert log.report.truncated
        assert accounted(log.report) == log.report.lines
        scans.append(len(log.ranges))
        np.testing.assert_array_equal(log.ranges, RANGES[: scans[-1]])
    assert scans == sorted(scans)
    assert set(scans) == {0, 1, 2, 3, 4}


BAD_AS_SECOND_ONLY = (reasons.OTHER_BEAMS, graph.OTHER_FIELD)
JUNK = st.one_of(
    st.binary(max_size=50),
    st.sampled_from([line for line, _ in [*BAD_VERTICES.values(), *BAD_EDGES.values()]]),
    st.sampled_from([line for line, why in BAD_SCANS.values() if why not in BAD_AS_SECOND_ONLY]),
    st.integers(0, 200).map(lambda cut: BODY[1][:cut]),
)


@given(st.lists(st.tuples(st.integers(0, len(GOOD)), JUNK), max_size=12))
def test_junk_lines_cost_at_most_the_scan_they_part_from_its_vertex(insertions):
    """No scan is ever given to a vertex that is not its own, and every line is accounted for."""
    lines = [*GOOD]
    for place, junk in insertions:
        lines.insert(place, junk.replace(b"\n", b"?"))
    # an unparted pair at the end, so that one scan at least can be read
    lines += [vertex(99, POSES[0]), scan(0)]
    assume(not lines[0].startswith(reasons.GZIP_MAGIC))  # that is no junk line: it is a gzip file
    log = read_bytes(b"\n".join(lines) + b"\n")
    assert accounted(log.report) == log.report.lines == len(lines)
    owners = {reading: {number} for reading, number in zip(RANGES[:, 0], IDS, strict=True)}
    owners[RANGES[0, 0]].add(99)
    for row, readings in zip(log.scan_vertices, log.ranges, strict=True):
        assert log.vertex_ids[row] in owners[readings[0]]
    assert np.isfinite(log.vertices).all()
    assert log.edges.max(initial=-1) < len(log.vertices)


@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=40), st.booleans())
def test_bytes_anywhere_raise_nothing_but_corrupt_log(place, junk, packed):
    content = b"\n".join(GOOD) + b"\n"
    content = gzip.compress(content, mtime=0) if packed else content
    place %= len(content) + 1
    try:
        log = read_bytes(content[:place] + junk + content[place:], allow_truncated=True)
    except CorruptLog:
        return
    assert accounted(log.report) == log.report.lines
    assert len(log.ranges) == len(log.scan_vertices) == log.report.scans

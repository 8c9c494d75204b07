"""Pose-graph logs: scans stay with their vertices, edges with theirs, bad lines are named."""

import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception.datasets import CorruptLog, logs, read_graph_log
from robot_perception.geometry import wrap_angle
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


@pytest.mark.parametrize("name", ["a.log", "a.log.gz"])
def test_every_number_is_read_back(tmp_path, name):
    log = read_graph_log(write(tmp_path / name, GOOD))
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
    assert log.report.others == {"#": 1}


def test_g2o_orders_the_information_by_rows(tmp_path):
    """The same six numbers mean another matrix under EDGE_SE2 than under EDGE2."""
    line = edge(0, 10, MOTIONS[0], [1.0, 0.1, 0.2, 2.0, 0.3, 3.0], keyword="EDGE_SE2")
    body = [row.replace(b"VERTEX2", b"VERTEX_SE2") for row in BODY]
    log = read_graph_log(write(tmp_path / "a.g2o", [*body, line]))
    np.testing.assert_array_equal(log.information, [INFORMATION])
    assert log.report.kept["VERTEX_SE2"] == 4


def test_edges_may_stand_before_their_vertices(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [*EDGE_LINES, *BODY]))
    np.testing.assert_array_equal(log.edges, [[0, 1], [1, 2], [2, 3], [0, 3]])


def test_no_edges_and_vertices_without_scan(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [vertex(3, POSES[0]), *BODY]))
    assert log.edges.shape == (0, 2)
    assert log.motions.shape == (0, 3)
    assert log.information.shape == (0, 3, 3)
    np.testing.assert_array_equal(log.scan_vertices, [1, 2, 3, 4])


def test_a_vertex_may_have_two_scans(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [*GOOD[:2], scan(1), *GOOD[4:8]]))
    np.testing.assert_array_equal(log.scan_vertices, [0, 0, 1, 2])
    np.testing.assert_array_equal(log.vertex_ids, [IDS[0], *IDS[2:]])
    np.testing.assert_array_equal(log.ranges, RANGES)


def in_space(keyword, ids, pose, *, height=0.0, tilt=(0, 0), information=None) -> bytes:
    """Return a vertex or an edge as g2o writes it of a pose in space."""
    turn = Rotation.from_euler("ZYX", [pose[2], *tilt]).as_quat()
    terms = [] if information is None else information[np.triu_indices(6)]
    values = [*pose[:2], height, *turn, *terms]
    return " ".join([keyword, *map(str, ids), *(repr(float(v)) for v in values)]).encode()


def space_lines(**last):
    vertices = [in_space("VERTEX_SE3:QUAT", [i], pose, height=0.25) for i, pose in enumerate(POSES)]
    body = [line for row in range(VERTICES) for line in (vertices[row], scan(row))]
    return [*body, in_space("EDGE_SE3:QUAT", (0, 1), MOTIONS[0], **last)]


def test_a_graph_in_space_that_lies_in_a_plane_is_read(tmp_path):
    root = RNG.normal(size=(6, 6))
    information = root @ root.T
    log = read_graph_log(write(tmp_path / "a.g2o", space_lines(information=information)))
    wrapped = np.column_stack([POSES[:, :2], wrap_angle(POSES[:, 2])])
    np.testing.assert_allclose(log.vertices, wrapped, atol=1e-12)
    motion = [*MOTIONS[0, :2], wrap_angle(MOTIONS[0, 2])]
    np.testing.assert_allclose(log.motions, [motion], atol=1e-12)
    np.testing.assert_array_equal(log.edges, [[0, 1]])

    def cost(motion):
        """Of a motion that was measured as 0, by g2o's error: places and the quaternion's part."""
        turn = Rotation.from_euler("Z", motion[2]).as_quat()
        error = np.array([*motion[:2], 0, *turn[:3]])
        return error @ information @ error

    small = RNG.normal(0, 1e-4, (9, 3))
    found = np.einsum("ki,ij,kj->k", small, log.information[0], small)
    np.testing.assert_allclose(found, [cost(motion) for motion in small], rtol=1e-6)


@pytest.mark.parametrize(
    ("line", "change", "reason"),
    [
        (2, {"height": 0.5}, "it does not lie in one plane with the others"),
        (2, {"height": 0.25, "tilt": (0, 0.1)}, "it does not lie in one plane with the others"),
        (2, {"height": 0.25, "tilt": (0.1, 0)}, "it does not lie in one plane with the others"),
        (8, {"height": 0.1, "information": np.eye(6)}, "it does not lie in one plane with the"),
        (8, {"tilt": (0, 0.1), "information": np.eye(6)}, "it does not lie in one plane with the"),
    ],
)
def test_a_graph_that_leaves_the_plane_stops_at_its_line(tmp_path, line, change, reason):
    lines = space_lines(information=np.eye(6))
    keyword, *ids = lines[line].decode().split()[: 2 if line < 8 else 3]
    lines[line] = in_space(keyword, ids, np.zeros(3), **change)
    with pytest.raises(CorruptLog, match=rf"a\.g2o, line {line + 1}: {reason}"):
        read_graph_log(write(tmp_path / "a.g2o", lines))


def test_a_quaternion_of_another_length_stops_at_its_line(tmp_path):
    lines = [b"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1.1", scan(0)]
    with pytest.raises(CorruptLog, match=r"line 1: its quaternion qx qy qz qw is not of unit"):
        read_graph_log(write(tmp_path / "a.g2o", lines))


def test_ids_may_be_as_long_as_nanoseconds(tmp_path):
    number = 2**63 - 1
    log = read_graph_log(write(tmp_path / "a.log", [vertex(number, POSES[0]), scan(0)]))
    assert log.vertex_ids.tolist() == [number]


def test_remissions_are_passed_over(tmp_path):
    lines = [vertex(0, POSES[0]), scan(0, remissions=(5.0, 6.0))]
    log = read_graph_log(write(tmp_path / "a.log", lines))
    np.testing.assert_array_equal(log.poses, LASER[:1])
    assert log.times[0] == TIMES[0]


def test_no_return_comes_from_readings_not_from_the_line(tmp_path):
    """The known logs write maxrange 50 and keep readings up to 81.91."""
    readings = [1.0, 60.0, 81.91]
    line = robotlaser(readings, LASER[0], ROBOT[0], 1.0)
    log = read_graph_log(write(tmp_path / "a.log", [vertex(0, POSES[0]), line]))
    np.testing.assert_array_equal(log.ranges, [[1.0, 60.0, np.inf]])
    assert log.max_range == 80.0


def without(row: int, word: int, value: bytes) -> bytes:
    """Return scan ``row`` with one word replaced."""
    words = scan(row).split()
    return b" ".join([*words[:word], value, *words[word + 1 :]])


NO_VERTEX = "no vertex stands right before"
BAD_SCANS = {
    "count zero": (without(1, 8, b"0"), "an id or a count is not an integer"),
    "count too low": (without(1, 8, b"6"), "an id or a count is not an integer"),
    "remission": (scan(1, remissions=("x",)), "a value is not a number"),
    "negative": (without(1, 10, b"-1"), "a reading is negative"),
    "beams": (robotlaser(RANGES[1][:5], LASER[1], ROBOT[1], 1.0), logs.OTHER_BEAMS),
    "start": (scan(1, start=-1.0), "its first angle or resolution differs"),
    "resolution": (scan(1, resolution=0.25), "its first angle or resolution differs"),
}
LOST = edge(0, 999, MOTIONS[0], TERMS)
BAD = [
    *[(GOOD[:3], *case, GOOD[4:]) for case in BAD_SCANS.values()],
    (GOOD[:2], vertex(0, POSES[1]), "repeats the id of an earlier vertex", GOOD[3:]),
    (GOOD[:9], LOST, "one of its vertices is not in the log", GOOD[9:]),
    ([], scan(3), NO_VERTEX, GOOD),
    ([*GOOD[:2], b"VERTXE2 10 0 0 0"], scan(1), NO_VERTEX, GOOD[4:]),
    ([GOOD[0], b"VERTXE2 10 0 0 0"], scan(1), NO_VERTEX, GOOD[4:]),  # nor to the vertex before
]


@pytest.mark.parametrize(("before", "line", "reason", "after"), BAD)
def test_bad_line_is_named_with_its_number_and_reason(tmp_path, before, line, reason, after):
    path = write(tmp_path / "a.log", [*before, line, *after])
    with pytest.raises(CorruptLog, match=rf"a\.log, line {len(before) + 1}: {reason}"):
        read_graph_log(path)


def test_comments_may_part_a_scan_from_its_vertex(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [GOOD[0], b"", b"# comment", *GOOD[1:]]))
    np.testing.assert_array_equal(log.scan_vertices, [0, 1, 2, 3])


def test_times_that_are_none_are_an_error_unless_they_do_not_matter(tmp_path):
    lines = [word for i in range(2) for word in (vertex(i, POSES[i]), scan(0))]
    path = write(tmp_path / "a.log", lines)
    with pytest.raises(CorruptLog, match=r"its 2 times are all the same \(timed=False reads"):
        read_graph_log(path)
    assert len(read_graph_log(path, timed=False).times) == 2


def test_no_scan_at_all(tmp_path):
    path = write(tmp_path / "a.log", [vertex(0, POSES[0]), b"FLASER 1 2"])
    with pytest.raises(CorruptLog, match=r"no ROBOTLASER1 line .*1 VERTEX2; other kinds 1 FLASER"):
        read_graph_log(path)


def read_bytes(content: bytes, name: str = "a.log", **options):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_graph_log(path, **options)


JUNK = st.one_of(
    st.binary(max_size=50),
    st.sampled_from([vertex(0, POSES[1]), b"VERTEX2 10 a 0 0", b"EDGE2 0 10 1 2", LOST]),
    st.sampled_from([line for line, _ in BAD_SCANS.values()]),
    st.integers(0, 200).map(lambda cut: BODY[1][:cut]),
)


@given(st.lists(st.tuples(st.integers(0, len(GOOD)), JUNK), max_size=4))
@settings(deadline=None)
def test_no_scan_is_given_to_a_vertex_that_is_not_its_own(insertions):
    """Whatever is inserted: a line that exists is named, or all is read with its owner."""
    lines = [*GOOD]
    for place, junk in insertions:
        lines.insert(place, junk.replace(b"\n", b"?").replace(b"\r", b"?"))
    assume(not lines[0].startswith((logs.GZIP_MAGIC, *logs.ENCODINGS)))  # they change all lines
    try:
        log = read_bytes(b"\n".join(lines) + b"\n")
    except CorruptLog as error:
        assert 1 <= int(re.search(r"line (\d+): ", str(error))[1]) <= len(lines)  # noqa: PT017
        return
    assert log.report.lines == len(lines)
    np.testing.assert_array_equal(log.ranges, RANGES)
    np.testing.assert_array_equal(log.vertex_ids[log.scan_vertices], IDS)
    np.testing.assert_array_equal(log.vertex_ids[log.edges], EDGES)

"""Pose-graph logs: scans stay with their vertices, edges with theirs."""

import re
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception.datasets import CorruptLog, logs, read_graph_log
from robot_perception.geometry import wrap_angle
from tests.datasets.formats.lasers import (
    BAD_SCANS,
    BODY,
    EDGE_LINES,
    EDGES,
    IDS,
    INFORMATION,
    LASER,
    LOST,
    MOTIONS,
    POSES,
    RANGES,
    ROBOT,
    TIMES,
    scan,
    space_lines,
)
from tests.datasets.formats.lasers import GRAPH as GOOD
from tests.datasets.writing import edge, robotlaser, vertex, write

RNG = np.random.default_rng(8)


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


def test_comments_may_part_a_scan_from_its_vertex(tmp_path):
    log = read_graph_log(write(tmp_path / "a.log", [GOOD[0], b"", b"# comment", *GOOD[1:]]))
    np.testing.assert_array_equal(log.scan_vertices, [0, 1, 2, 3])


def test_times_that_do_not_matter_may_be_the_same(tmp_path):
    lines = [word for i in range(2) for word in (vertex(i, POSES[i]), scan(0))]
    path = write(tmp_path / "a.log", lines)
    assert len(read_graph_log(path, timed=False).times) == 2


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

"""Pose-graph logs: vertices, each with its laser scan, and edges between them."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from robot_perception.datasets import limits, logs
from robot_perception.datasets.carmen import SCAN, laser_fields, robot_scan
from robot_perception.datasets.logs import LaserLog, Lines
from robot_perception.datasets.poses import UNIT_LENGTH, headings

IN_SPACE = b"VERTEX_SE3:QUAT", b"EDGE_SE3:QUAT"
POSE_LENGTH = {  # x y theta, or x y z qx qy qz qw
    b"VERTEX2": 3,
    b"VERTEX_SE2": 3,
    b"VERTEX_SE3:QUAT": 7,
    b"EDGE2": 3,
    b"EDGE_SE2": 3,
    b"EDGE_SE3:QUAT": 7,
}
VERTICES = tuple(keyword for keyword in POSE_LENGTH if keyword.startswith(b"VERTEX"))
FLAT = 1e-3  # of a pose in the plane: height in m, and sines of half the roll and pitch

# Upper triangle of the information matrix: TORO writes xx xy yy tt xt yt, g2o xx xy xt yy yt tt and
# in space, by rows, that of x y z qx qy qz, where qz of a small turn is half of it.
INFORMATION_ORDER = {
    b"EDGE2": np.array([[0, 1, 4], [1, 2, 5], [4, 5, 3]]),
    b"EDGE_SE2": np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]]),
    b"EDGE_SE3:QUAT": np.array([[0, 1, 5], [1, 6, 10], [5, 10, 20]]),
}
INFORMATION_LENGTH = {b"EDGE2": 6, b"EDGE_SE2": 6, b"EDGE_SE3:QUAT": 21}
HALF_TURN = np.outer([1, 1, 0.5], [1, 1, 0.5])


@dataclass(frozen=True, eq=False, slots=True)
class GraphLog(LaserLog):
    """Laser scans at the vertices of a pose graph, and the edges between the vertices.

    Everything of `LaserLog` (``poses`` are laser poses, ``odometry`` the robot poses written with
    the scans), and the graph.

    Parameters
    ----------
    vertex_ids : (vertices,)
        The log's own numbers of the vertices.
    vertices : (vertices, 3)
        Robot pose (x, y, theta) at each vertex, in m and rad.
    scan_vertices : (scans,)
        Row of ``vertices`` each scan belongs to.
    edges : (edges, 2)
        Rows of ``vertices`` an edge runs from and to.
    motions : (edges, 3)
        Pose (x, y, theta) of the second vertex seen from the first, as measured, in m and rad.
    information : (edges, 3, 3)
        Inverse covariance of each motion.
    """

    vertex_ids: Int[np.ndarray, " vertices"]
    vertices: Float[np.ndarray, "vertices 3"]
    scan_vertices: Int[np.ndarray, " scans"]
    edges: Int[np.ndarray, "edges 2"]
    motions: Float[np.ndarray, "edges 3"]
    information: Float[np.ndarray, "edges 3 3"]


def read_graph_log(
    path: str | Path,
    *,
    max_range: float | None = None,
    timed: bool = True,
    time_unit: str = "s",
) -> GraphLog:
    """Read a pose-graph log with laser scans, plain or gzip.

    Lines are ``VERTEX2 id x y theta`` (or ``VERTEX_SE2``), each followed by its scans
    ``ROBOTLASER1 type start fov resolution maxrange accuracy mode n r1 … rn m [m values] lx ly
    ltheta x y theta tv rv fs ss ta t host t``, and ``EDGE2 i j dx dy dtheta`` (or ``EDGE_SE2``)
    with six information terms. A vertex need not have a scan, but a scan must have a vertex, or
    another scan of it, right before it: were the last vertex enough, a misspelt one would hand its
    scan to another.

    ``VERTEX_SE3:QUAT id x y z qx qy qz qw`` and ``EDGE_SE3:QUAT i j dx dy dz qx qy qz qw``, with 21
    information terms, are read where all vertices have one height and nothing rolls or pitches.
    Then height, roll and pitch are known, and the information of the others is its own part of the
    matrix.

    Parameters
    ----------
    path
        The file.
    max_range
        Readings of at least this many metres mean "no return" and become ``inf``. Without it the
        largest reading of the log decides (see `logs.no_return_threshold`), not the scans' own
        ``maxrange``, which the known logs set to 50 m and do not keep to.
    timed
        Whether the times of the scans must differ and be those of a recording.
    time_unit
        What the file counts time in: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.

    Returns
    -------
    GraphLog
        The scans, vertices and edges in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no scan; at the first line
        that cannot be read, does not lie in the plane, or whose numbers are in another unit.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    CARMEN's ROBOTLASER1 message; the TORO and g2o file formats.
    """
    logs.check_reading(max_range, timed, time_unit)
    lines = Lines(path)
    rows: dict[int, int] = {}
    vertices, owners, scans, edges = [], [], [], []
    place = None  # of the last vertex or scan
    for words in lines.of(SCAN, *POSE_LENGTH):
        if words[0] == SCAN:
            if place is None or lines.place != place + 1:
                raise lines.error(
                    f"no vertex stands right before the scan{'' if vertices else LOG}"
                )
            scans.append(robot_scan(lines, words, scans[:1]))
            owners.append(len(vertices) - 1)
            place = lines.place
        elif words[0] in VERTICES:
            lines.expect(words, 2 + POSE_LENGTH[words[0]])
            number = lines.integer(words, 1)
            if number in rows:
                raise lines.error("repeats the id of an earlier vertex")
            rows[number] = len(vertices)
            vertices.append(_Vertex(lines.number, *_in_plane(lines, words[0], words[2:])))
            if abs(vertices[-1].height - vertices[0].height) > FLAT:
                raise lines.error(NOT_FLAT)
            place = lines.place
        else:
            edges.append(_parse_edge(lines, words))
    lost = [edge.line for edge in edges if not rows.keys() >= set(edge.ends)]
    if lost:  # only now: edges may stand before their vertices
        raise lines.error("one of its vertices is not in the log", lost[0])
    how = {"max_range": max_range, "timed": timed, "time_unit": time_unit}
    poses = np.array([vertex.pose for vertex in vertices])
    lines.check(poses, [vertex.line for vertex in vertices], *POSE_CHECKS)
    return GraphLog(
        **laser_fields(lines, scans, **how),
        vertex_ids=np.array(list(rows)),
        vertices=poses,
        scan_vertices=np.array(owners),
        edges=np.array([[rows[i] for i in edge.ends] for edge in edges], int).reshape(-1, 2),
        motions=np.array([edge.motion for edge in edges]).reshape(-1, 3),
        information=np.array([edge.information for edge in edges]).reshape(-1, 3, 3),
    )


LOG = ", nor any before; a CARMEN log has none: read_carmen_log, in a script carmen"
NOT_FLAT = "it does not lie in one plane with the others, and scans make no map of planes in space"
POSE_CHECKS = limits.far_places(0, 1), *limits.no_headings(2)
MOTION_CHECKS = limits.far_places(0, 1), limits.wide_angles(2)


class _Vertex(NamedTuple):
    line: int
    pose: Float[np.ndarray, "3"]
    height: float


class _Edge(NamedTuple):
    line: int
    ends: tuple[int, int]
    motion: Float[np.ndarray, "3"]
    information: Float[np.ndarray, "3 3"]


def _parse_edge(lines: Lines, words: list[bytes]) -> _Edge:
    kind, size = words[0], 3 + POSE_LENGTH[words[0]]
    lines.expect(words, size + INFORMATION_LENGTH[kind])
    ends = lines.integer(words, 1), lines.integer(words, 2)
    motion, height = _in_plane(lines, kind, words[3:size])
    if abs(height) > FLAT:
        raise lines.error(NOT_FLAT)
    lines.check(motion[None], [lines.number], *MOTION_CHECKS)
    information = lines.numbers(words[size:])[INFORMATION_ORDER[kind]]
    information = information * HALF_TURN if kind in IN_SPACE else information
    return _Edge(lines.number, ends, motion, information)


def _in_plane(
    lines: Lines, kind: bytes, words: list[bytes]
) -> tuple[Float[np.ndarray, "3"], float]:
    """Return the pose x, y, theta that words tell, and its height."""
    values = lines.numbers(words)
    if kind not in IN_SPACE:
        return values, 0.0
    lines.check(values[None, 3:], [lines.number], UNIT_LENGTH)
    if np.hypot(*values[3:5]) > FLAT:
        raise lines.error(NOT_FLAT)
    return np.append(values[:2], headings(values[None, 3:])), float(values[2])

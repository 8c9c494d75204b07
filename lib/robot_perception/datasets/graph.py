"""Pose-graph logs: vertices, each with its laser scan, and edges between them."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from robot_perception.datasets import logs
from robot_perception.datasets.logs import LaserLog, Lines

VERTICES = (b"VERTEX2", b"VERTEX_SE2")
EDGES = (b"EDGE2", b"EDGE_SE2")
SCAN = b"ROBOTLASER1"
VERTEX_LENGTH = 5  # keyword id x y theta
EDGE_LENGTH = 12  # keyword i j dx dy dtheta and six information terms
HEADER = 9  # keyword type start fov resolution maxrange accuracy mode n
TAIL = 14  # lx ly ltheta x y theta tv rv fs ss ta t host t

# Upper triangle of the information matrix: TORO writes xx xy yy tt xt yt, g2o xx xy xt yy yt tt.
INFORMATION_ORDER = {
    b"EDGE2": np.array([[0, 1, 4], [1, 2, 5], [4, 5, 3]]),
    b"EDGE_SE2": np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]]),
}


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
    path: str | Path, *, max_range: float | None = None, timed: bool = True
) -> GraphLog:
    """Read a pose-graph log with laser scans, plain or gzip.

    Lines are ``VERTEX2 id x y theta`` (or ``VERTEX_SE2``), each followed by its scan
    ``ROBOTLASER1 type start fov resolution maxrange accuracy mode n r1 … rn m [m values] lx ly
    ltheta x y theta tv rv fs ss ta t host t``, and ``EDGE2 i j dx dy dtheta`` (or ``EDGE_SE2``)
    with six information terms. A vertex need not have a scan, but a scan must have a vertex right
    before it: were the last vertex enough, a misspelt one would hand its scan to another.

    Parameters
    ----------
    path
        The file.
    max_range
        Readings of at least this many metres mean "no return" and become ``inf``. Without it the
        largest reading of the log decides (see `logs.no_return_threshold`), not the scans' own
        ``maxrange``, which the known logs set to 50 m and do not keep to.
    timed
        Whether the times of the scans must differ and lie within a week.

    Returns
    -------
    GraphLog
        The scans, vertices and edges in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no scan; at the first line
        that cannot be read.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    CARMEN's ROBOTLASER1 message; the TORO and g2o file formats.
    """
    logs.check_reading(max_range, timed)
    lines = Lines(path)
    rows: dict[int, int] = {}
    vertices, owners, scans, edges = [], [], [], []
    vertex_place = None
    for words in lines.of(SCAN, *VERTICES, *EDGES):
        if words[0] == SCAN:
            if vertex_place is None or lines.place != vertex_place + 1:
                raise lines.error("no vertex stands right before the scan")
            scans.append(_parse_scan(lines, words))
            if scans[-1].readings.size != scans[0].readings.size:
                raise lines.error(logs.OTHER_BEAMS)
            if scans[-1].field != scans[0].field:
                raise lines.error("its first angle or resolution differs from the first scan's")
            owners.append(len(vertices) - 1)
        elif words[0] in VERTICES:
            lines.expect(words, VERTEX_LENGTH)
            number = lines.integer(words, 1)
            if number in rows:
                raise lines.error("repeats the id of an earlier vertex")
            rows[number] = len(vertices)
            vertices.append(lines.numbers(words[2:]))
            vertex_place = lines.place
        else:
            edges.append(_parse_edge(lines, words))
    lost = [edge.line for edge in edges if not rows.keys() >= set(edge.ends)]
    if lost:  # only now: edges may stand before their vertices
        raise lines.error("one of its vertices is not in the log", lost[0])
    start, resolution = scans[0].field
    readings, tails = [scan.readings for scan in scans], [scan.tail for scan in scans]
    angles = start + resolution * np.arange(readings[0].size)
    return GraphLog(
        **logs.make_laser_log(lines, readings, angles, tails, max_range=max_range, timed=timed),
        vertex_ids=np.array(list(rows)),
        vertices=np.array(vertices),
        scan_vertices=np.array(owners),
        edges=np.array([[rows[i] for i in edge.ends] for edge in edges], int).reshape(-1, 2),
        motions=np.array([edge.motion for edge in edges]).reshape(-1, 3),
        information=np.array([edge.information for edge in edges]).reshape(-1, 3, 3),
    )


class _Scan(NamedTuple):
    field: tuple[float, float]  # first angle and resolution
    readings: Float[np.ndarray, " beams"]
    tail: Float[np.ndarray, "12"]  # lx ly ltheta x y theta tv rv fs ss ta t


class _Edge(NamedTuple):
    line: int
    ends: tuple[int, int]
    motion: Float[np.ndarray, "3"]
    information: Float[np.ndarray, "3 3"]


def _parse_scan(lines: Lines, words: list[bytes]) -> _Scan:
    end = HEADER + lines.integer(words, HEADER - 1, least=1)
    lines.expect(words, end + 1 + lines.integer(words, end) + TAIL)
    _, start, _, resolution, *_ = lines.numbers(words[1:HEADER]).tolist()
    tail = lines.numbers(words[end:-2])[2 - TAIL :]  # without host and the logger's own clock
    return _Scan((start, resolution), lines.readings(words[HEADER:end]), tail)


def _parse_edge(lines: Lines, words: list[bytes]) -> _Edge:
    lines.expect(words, EDGE_LENGTH)
    ends = lines.integer(words, 1), lines.integer(words, 2)
    values = lines.numbers(words[3:])
    return _Edge(lines.number, ends, values[:3], values[3:][INFORMATION_ORDER[words[0]]])

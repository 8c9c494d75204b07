"""Pose-graph logs: vertices, each with its laser scan, and edges between them."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from robot_perception.datasets import logs
from robot_perception.datasets.logs import LaserLog, Tally

VERTICES = frozenset({b"VERTEX2", b"VERTEX_SE2"})
EDGES = frozenset({b"EDGE2", b"EDGE_SE2"})
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

BAD_ID = "an id is not an integer"
REPEATED = "repeats the id of an earlier vertex"
NO_VERTEX = "no vertex stands right before the scan"
OTHER_FIELD = "its first angle or resolution differs from the first scan's"
REMISSION_COUNT = "the number of remission values is not an integer"
LOST_END = "one of its vertices is not in the log"


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


@dataclass(frozen=True, eq=False, slots=True)
class _Scan:
    start: float
    resolution: float
    readings: Float[np.ndarray, " beams"]
    tail: Float[np.ndarray, "12"]  # lx ly ltheta x y theta tv rv fs ss ta t


@dataclass(frozen=True, eq=False, slots=True)
class _Edge:
    line: int
    keyword: str
    ends: tuple[int, int]
    motion: Float[np.ndarray, "3"]
    information: Float[np.ndarray, "3 3"]


@dataclass(slots=True)
class _Builder:
    """What has been read so far.

    A scan belongs to the vertex on the line before it (comments and blank lines aside). Were the
    last vertex read enough, one damaged vertex line would hand a scan to the wrong vertex.
    """

    tally: Tally
    rows: dict[int, int] = field(default_factory=dict)
    vertices: list[Float[np.ndarray, "3"]] = field(default_factory=list)
    scans: list[_Scan] = field(default_factory=list)
    scan_vertices: list[int] = field(default_factory=list)
    edges: list[_Edge] = field(default_factory=list)
    vertex_place: int | None = None

    def place(self, line: int) -> int:
        """Return the number of a line among those that are neither blank nor comment."""
        return line - self.tally.others["blank"] - self.tally.others["#"]

    def add_vertex(self, line: int, tokens: list[bytes]) -> str | None:
        problem = logs.wrong_length(tokens, VERTEX_LENGTH)
        if problem:
            return problem
        number = _integer(tokens[1])
        if number is None:
            return BAD_ID
        pose = logs.numbers(tokens[2:])
        if pose is None:
            return logs.NOT_NUMBERS
        if not np.isfinite(pose).all():
            return logs.NOT_FINITE
        if number in self.rows:
            return REPEATED
        self.rows[number] = len(self.vertices)
        self.vertices.append(pose)
        self.vertex_place = self.place(line)
        return None

    def add_scan(self, line: int, tokens: list[bytes]) -> str | None:
        if self.vertex_place != self.place(line) - 1:
            return NO_VERTEX
        scan = _parse_scan(tokens)
        if isinstance(scan, str):
            return scan
        if self.scans:
            first = self.scans[0]
            if scan.readings.size != first.readings.size:
                return logs.OTHER_BEAMS
            if (scan.start, scan.resolution) != (first.start, first.resolution):
                return OTHER_FIELD
        self.scans.append(scan)
        self.scan_vertices.append(len(self.vertices) - 1)
        return None

    def add_edge(self, line: int, tokens: list[bytes]) -> str | None:
        problem = logs.wrong_length(tokens, EDGE_LENGTH)
        if problem:
            return problem
        start, end = _integer(tokens[1]), _integer(tokens[2])
        if start is None or end is None:
            return BAD_ID
        values = logs.numbers(tokens[3:])
        if values is None:
            return logs.NOT_NUMBERS
        if not np.isfinite(values).all():
            return logs.NOT_FINITE
        information = values[3:][INFORMATION_ORDER[tokens[0]]]
        self.edges.append(_Edge(line, tokens[0].decode(), (start, end), values[:3], information))
        return None

    def drop_lost_edges(self) -> None:
        """Count the edges, which may stand before their vertices, and drop those without both."""
        kept = []
        for edge in self.edges:
            if all(end in self.rows for end in edge.ends):
                self.tally.kept[edge.keyword] += 1
                kept.append(edge)
            else:
                self.tally.skip(edge.line, LOST_END)
        self.edges = kept


def read_graph_log(
    path: str | Path,
    *,
    max_range: float | None = None,
    strict: bool = False,
    allow_truncated: bool = False,
) -> GraphLog:
    """Read a pose-graph log with laser scans, plain or gzip.

    Lines are ``VERTEX2 id x y theta`` (or ``VERTEX_SE2``), each followed by its scan
    ``ROBOTLASER1 type start fov resolution maxrange accuracy mode n r1 … rn m [m values] lx ly
    ltheta x y theta tv rv fs ss ta t host t``, and ``EDGE2 i j dx dy dtheta`` (or ``EDGE_SE2``)
    with six information terms. A line that cannot be read is left out, counted and reported.

    Parameters
    ----------
    path
        The file.
    max_range
        Readings of at least this many metres mean "no return" and become ``inf``. Without it the
        largest reading of the log decides (see `logs.no_return_threshold`), not the scans' own
        ``maxrange``, which the known logs set to 50 m and do not keep to.
    strict
        Raise at the first line that cannot be read.
    allow_truncated
        Accept a damaged gzip file and return what stands complete before the damage. Its checksum
        cannot be verified.

    Returns
    -------
    GraphLog
        The scans, vertices and edges in the order of the file.

    Raises
    ------
    CorruptLog
        If the file is empty, damaged, not what its name says, or holds no scan; with ``strict``,
        at the first bad line.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    CARMEN's ROBOTLASER1 message; the TORO and g2o file formats.
    """
    recording = logs.read_recording(path)
    tally = Tally(recording.path, strict)
    builder = _Builder(tally)
    for number, tokens in logs.keyword_lines(recording, tally, VERTICES | EDGES | {SCAN}):
        if tokens[0] in EDGES:
            problem = builder.add_edge(number, tokens)
        else:
            add = builder.add_scan if tokens[0] == SCAN else builder.add_vertex
            problem = add(number, tokens)
            if problem is None:
                tally.kept[tokens[0].decode()] += 1
        if problem is not None:
            tally.skip(number, problem)
    builder.drop_lost_edges()
    report = logs.close(recording, tally, allow_truncated=allow_truncated, what=SCAN.decode())
    readings = np.array([scan.readings for scan in builder.scans])
    ranges, max_range = logs.mark_no_returns(readings, max_range)
    first = builder.scans[0]
    tails = np.array([scan.tail for scan in builder.scans])
    rows = builder.rows
    return GraphLog(
        ranges=ranges,
        angles=first.start + first.resolution * np.arange(first.readings.size),
        poses=tails[:, :3],
        odometry=tails[:, 3:6],
        times=tails[:, 11],
        max_range=max_range,
        report=report,
        vertex_ids=np.array(list(rows)),
        vertices=np.array(builder.vertices),
        scan_vertices=np.array(builder.scan_vertices),
        edges=np.array(
            [[rows[end] for end in edge.ends] for edge in builder.edges], dtype=int
        ).reshape(-1, 2),
        motions=np.array([edge.motion for edge in builder.edges]).reshape(-1, 3),
        information=np.array([edge.information for edge in builder.edges]).reshape(-1, 3, 3),
    )


def _integer(token: bytes) -> int | None:
    """Return a token as an id, or nothing."""
    return int(token) if token.isdigit() and len(token) <= 18 else None


def _parse_scan(tokens: list[bytes]) -> _Scan | str:
    """Return the scan, or the reason why the line is none."""
    beams = logs.positive_integer(tokens[HEADER - 1 : HEADER])
    if beams is None:
        return logs.BAD_COUNT if len(tokens) >= HEADER else logs.SHORT
    end = HEADER + beams
    if len(tokens) <= end:
        return logs.SHORT
    if not tokens[end].isdigit() or len(tokens[end]) > 9:
        return REMISSION_COUNT
    remissions = int(tokens[end])
    problem = logs.wrong_length(tokens, end + 1 + remissions + TAIL)
    if problem:
        return problem
    values = logs.numbers(tokens[1:-2])  # without host and the logger's own clock
    if values is None:
        return logs.NOT_NUMBERS
    readings = values[HEADER - 1 : end - 1]
    if logs.bad_readings(readings):
        return logs.BAD_READING
    if not np.isfinite(values).all():
        return logs.NOT_FINITE
    return _Scan(float(values[1]), float(values[3]), readings, values[2 - TAIL :])

"""Logs of laser scanners: CARMEN's, in two forms, and pose graphs with scans."""

import numpy as np
from scipy.spatial.transform import Rotation

from robot_perception.datasets import logs, read_carmen_log, read_graph_log
from robot_perception.geometry import wrap_angle
from tests.datasets.formats.declared import Damage, Format, added, damages, joined
from tests.datasets.writing import carmen_truth, edge, flaser, robotlaser, vertex

# CARMEN -------------------------------------------------------------------------------------------

TRUTH = carmen_truth()
FLASER = TRUTH.lines
OTHER = "its number of beams differs"


def changed(line: bytes, word: int, value: bytes) -> bytes:
    """Return a line with one word replaced."""
    words = line.split()
    return b" ".join([*words[:word], value, *words[word + 1 :]])


def third(line: bytes) -> bytes:
    """Return a log with another third line."""
    return joined(FLASER[0], b"# comment", line, *FLASER[1:])


def at_times(times) -> bytes:
    """Return a log with scans at these times."""
    rows = zip(TRUTH.ranges, TRUTH.poses, TRUTH.odometry, times, strict=True)
    return joined(*(flaser(*row) for row in rows))


BAD_LINES = {
    "count too high": (changed(FLASER[0], 1, b"181"), OTHER),
    "count too low": (changed(FLASER[0], 1, b"179"), OTHER),
    "count zero": (changed(FLASER[0], 1, b"0"), "is not an integer of at least 1"),
    "negative reading": (changed(FLASER[0], 40, b"-0.01"), "a reading is negative"),
    "other number of beams": (carmen_truth(beams=360).lines[0], OTHER),
    "numbers alone": (b"1.0 2.0 3.0", "does not begin with a keyword"),
    "endless": (b"ODOM " + b"1" * logs.LONGEST_LINE, "longer than 262144 bytes"),
}
CARMEN = damages(
    {name: (third(line), f", line 3: .*{reason}") for name, (line, reason) in BAD_LINES.items()}
    | {
        "first count too high": (joined(changed(FLASER[0], 1, b"181")), "line 1: .*fewer values"),
        "first count too low": (
            joined(changed(FLASER[0], 1, b"179")),
            "line 1: .*(more values|no field of view)",
        ),
        "one time": (at_times([0.0] * 4), "its 4 times are all the same.*timed=False reads"),
        "ten days": (at_times([0, 1e6, 2e6, 3e6]), r"its 4 times span 3e\+06 s, more than a week"),
        "an odd time": (at_times([0, 1, 2, 4e9]), r"span 4e\+09 s, more than a week.*timed=False"),
        "no scan": (b"ODOM 1\nVERTEX2 0 0 0 0\n", "no FLASER line .* kinds 1 ODOM, 1 VERTEX2"),
        "a pose graph": (
            joined(b"VERTEX2 0 0 0 0", b"EDGE2 0 1 1 0 0 1 0 1 1 0 0"),
            "it seems to be a pose graph: use read_graph_log",
        ),
    }
)


def robot_lines(truth, **how):
    """Return the scans of a log as CARMEN has written them since 2007."""
    how = {"start": -np.pi / 2, "resolution": np.pi / 180} | how
    rows = zip(truth.ranges, truth.poses, truth.odometry, truth.times, strict=True)
    return [robotlaser(*row, **how, remissions=[1.0, 2.0]) for row in rows]


SCANS = {
    "ranges": TRUTH.ranges,
    "poses": TRUTH.poses,
    "odometry": TRUTH.odometry,
    "times": TRUTH.times,
}
NEWER = robot_lines(TRUTH)
BAD_NEWER = {
    "beams": (robot_lines(carmen_truth(scans=1, beams=5))[0], OTHER),
    "start": (
        robot_lines(carmen_truth(scans=1), start=0.0)[0],
        "its first angle or resolution differs",
    ),
    "cut": (NEWER[0][:60], "fewer values than announced"),
    "count": (NEWER[0].replace(b" 180 ", b" 0 ", 1), "integer of at least 1: '0'"),
    "degrees": (robot_lines(carmen_truth(scans=1), start=-90.0)[0], r"radians\? \(-90\)"),
}

# Pose graphs --------------------------------------------------------------------------------------

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
GRAPH = [*BODY, b"#LOOP EDGES", *EDGE_LINES]
LOST = edge(0, 999, MOTIONS[0], TERMS)
NO_VERTEX = "no vertex stands right before"
BAD_SCANS = {
    "count zero": (changed(scan(1), 8, b"0"), "an id or a count is not an integer"),
    "count too low": (changed(scan(1), 8, b"6"), "an id or a count is not an integer"),
    "remission": (scan(1, remissions=("x",)), "a value is not a number"),
    "negative": (changed(scan(1), 10, b"-1"), "a reading is negative"),
    "beams": (robotlaser(RANGES[1][:5], LASER[1], ROBOT[1], 1.0), logs.OTHER_BEAMS),
    "start": (scan(1, start=-1.0), "its first angle or resolution differs"),
    "resolution": (scan(1, resolution=0.25), "its first angle or resolution differs"),
}
BAD_GRAPHS = (
    {  # lines before the bad one, the bad one, why, lines after it
        name: (GRAPH[:3], line, reason, GRAPH[4:]) for name, (line, reason) in BAD_SCANS.items()
    }
    | {
        "id": (GRAPH[:2], vertex(0, POSES[1]), "repeats the id of an earlier vertex", GRAPH[3:]),
        "edge": (GRAPH[:9], LOST, "one of its vertices is not in the log", GRAPH[9:]),
        "scan first": ([], scan(3), NO_VERTEX, GRAPH),
        "word": ([*GRAPH[:2], b"VERTXE2 10 0 0 0"], scan(1), NO_VERTEX, GRAPH[4:]),
        "nor the vertex before": ([GRAPH[0], b"VERTXE2 10 0 0 0"], scan(1), NO_VERTEX, GRAPH[4:]),
    }
)
IN_PLANE = "it does not lie in one plane with the others"


def in_space(keyword, ids, pose, *, height=0.0, tilt=(0, 0), information=None) -> bytes:
    """Return a vertex or an edge as g2o writes it of a pose in space."""
    turn = Rotation.from_euler("ZYX", [pose[2], *tilt]).as_quat()
    terms = [] if information is None else information[np.triu_indices(6)]
    values = [*pose[:2], height, *turn, *terms]
    return " ".join([keyword, *map(str, ids), *(repr(float(v)) for v in values)]).encode()


def space_lines(**last) -> list[bytes]:
    """Return a graph in space, with one edge."""
    vertices = [in_space("VERTEX_SE3:QUAT", [i], pose, height=0.25) for i, pose in enumerate(POSES)]
    body = [line for row in range(VERTICES) for line in (vertices[row], scan(row))]
    return [*body, in_space("EDGE_SE3:QUAT", (0, 1), MOTIONS[0], **last)]


def leaves(line: int, **change) -> tuple[bytes, str]:
    """Return a graph in space with another line, and what is said."""
    lines = space_lines(information=np.eye(6))
    keyword, *ids = lines[line].decode().split()[: 2 if line < 8 else 3]
    lines[line] = in_space(keyword, ids, np.zeros(3), **change)
    return joined(*lines), f", line {line + 1}: {IN_PLANE}"


SPACE = {
    "height": leaves(2, height=0.5),
    "pitch": leaves(2, height=0.25, tilt=(0, 0.1)),
    "roll": leaves(2, height=0.25, tilt=(0.1, 0)),
    "an edge's height": leaves(8, height=0.1, information=np.eye(6)),
    "an edge's pitch": leaves(8, tilt=(0, 0.1), information=np.eye(6)),
    "a long quaternion": (
        joined(b"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1.1", scan(0)),
        ", line 1: its quaternion qx qy qz qw is not of unit",
    ),
}


def graph_words(words: list[bytes]) -> tuple[list[int], list[int]]:
    """Return the places of whole numbers and of numbers in a line of a graph."""
    after = 9 + BEAMS
    if words[0] == b"ROBOTLASER1":
        return [8, after], [*range(1, 8), *range(9, after), *range(after + 1, len(words) - 2)]
    return ([1], [2, 3, 4]) if words[0] == b"VERTEX2" else ([1, 2], [*range(3, len(words))])


FORMATS = {
    "carmen": Format(
        read_carmen_log,
        {"a.log": joined(*FLASER)},
        SCANS | {"report.kept": {"FLASER": 4}, "report.others": {}},
        CARMEN,
        form="keyed",
        words=lambda w: ([1], [*range(2, len(w) - 2)]),
    ),
    "carmen_newer": Format(
        read_carmen_log,
        {"a.log": joined(*NEWER)},
        SCANS | {"report.kept": {"ROBOTLASER1": 4}},
        added(NEWER, BAD_NEWER),
        form="keyed",
    ),
    "graph": Format(
        read_graph_log,
        {"a.log": joined(*GRAPH)},
        {
            "ranges": RANGES,
            "poses": LASER,
            "odometry": ROBOT,
            "times": TIMES,
            "vertices": POSES,
            "vertex_ids": IDS,
            "scan_vertices": [0, 1, 2, 3],
            "edges": [[0, 1], [1, 2], [2, 3], [0, 3]],
            "motions": MOTIONS,
            "information": [INFORMATION] * 4,
            "angles": -1.5 + 0.5 * np.arange(BEAMS),
            "report.kept": {"VERTEX2": 4, "ROBOTLASER1": 4, "EDGE2": 4},
            "report.others": {"#": 1},
        },
        damages(
            {
                name: (joined(*before, line, *after), f", line {len(before) + 1}: {reason}")
                for name, (before, line, reason, after) in BAD_GRAPHS.items()
            }
            | {
                "no scan": (
                    joined(vertex(0, POSES[0]), b"FLASER 1 2"),
                    "no ROBOTLASER1 line .*1 VERTEX2; other kinds 1 FLASER",
                ),
                "CARMEN": (joined(*FLASER), "it seems to be a CARMEN log: use read_carmen_log"),
                "newer CARMEN": (
                    joined(*NEWER),
                    "line 1: no vertex .*a CARMEN log has none: read_carmen",
                ),
                "one time": (
                    joined(*(w for i in range(2) for w in (vertex(i, POSES[i]), scan(0)))),
                    r"its 2 times are all the same \(timed=False reads",
                ),
                "degrees": (
                    joined(vertex(0, [0] * 3), robotlaser([1, 2], [0] * 3, [0] * 3, 1, start=-90)),
                    r"beyond a full turn: are these radians\?",
                ),
            }
        ),
        form="keyed",
        words=graph_words,
        atol=1e-15,
    ),
    "graph_in_space": Format(
        read_graph_log,
        {"a.g2o": joined(*space_lines(information=np.eye(6)))},
        {
            "edges": [[0, 1]],
            "ranges": RANGES,
            "vertices": np.column_stack([POSES[:, :2], wrap_angle(POSES[:, 2])]),
        },
        {name: Damage(*case) for name, case in SPACE.items()},
        form="keyed",
        atol=1e-12,
    ),
}

"""One's own tables: columns by name, ranges, boxes, what sensors saw and what drove a robot."""

import io
from functools import partial

import numpy as np

from robot_perception import datasets
from tests.datasets.formats.declared import Format, added, damages, joined, plain, table

NAN, INF = np.nan, np.inf


def rows_of(column: str):
    """Return what counts the rows of columns, and the line of names."""
    return lambda found: len(found[column]) + 1


def with_names(found) -> int:
    """Return how many rows were read, and the line of names."""
    return len(found.times) + 1


# Columns ------------------------------------------------------------------------------------------

LIMITS = {"time_s": INF, "id": 100.0, "bearing_rad": 7.0}
HEAD = "time_s,id,bearing_rad"
COLUMNS = table(r"""
another head | 0,1,2 | line 1: no column time_s and .*; there is 0, 1, 2
a column less | time_s,id\n1,2 | line 1: no column bearing_rad; there is time_s, id
a column twice | time_s,id,bearing_rad,id\n1,2,3,4 | line 1: column id is there twice
no row | time_s,id,bearing_rad | no row line
""") | table(
    r"""
a cell less | 1,2,3\n1,2 | line 3: fewer values
a cell more | 1,2,3,4 | line 2: more values
a word | 1,2,x | line 2: bearing_rad is 'x', not a finite number
no number | 1,2, | line 2: bearing_rad is '', not a finite number
infinite | inf,2,3 | line 2: time_s is 'inf', not a finite number
NaN | 1,2,3\n1,2,nan | line 3: bearing_rad is 'nan', not a finite
degrees | 1,2,-45 | line 2: bearing_rad is '-45', beyond 7: is the unit right
half an id | 1,2.5,3 | line 2: id is '2.5', not a whole number
underscore | 1_0,2,3 | line 2: time_s is '1_0', not a finite number
""",
    HEAD,
)
AMBIGUOUS = damages(  # texts that can be read in two ways
    {
        "both commas": (b"time_s;x\n0,5;1\n1.5;1\n", "line 3: decimal commas and decimal points"),
        "thousands": (b"time_s;x\n1.000,5;1\n", "line 2: decimal commas and decimal points"),
        "an open quote": (
            b'time_s,x\n0,1\n1,"2\n3,4\n',
            r"line 3: its quotes are wrong \(unexpected end of data",
        ),
        "behind a quote": (
            b'time_s,x\n0,"1"2\n',
            r"line 2: its quotes are wrong \(',' expected",
        ),
        "Latin 1": (b"time_s,x\n0,1 \xe4\n", "line 2: not text in UTF-8"),
        "UTF-16": (b"\xff\xfet\0i\0", "line 1: no column time_s"),
        "half of UTF-16": (b"\xff\xfet\0i", "line 1: not text in UTF-16-LE"),
        "UTF-16 without a mark": (
            "time_s,x\n0,1\n".encode("utf-16-le"),
            "line 1: not text in UTF-8",
        ),
        "commas at some ends": (b"time_s,x\n0,1,\n1,2,3,\n", "line 3: more values than announced"),
        "no number": (b"time_s,x,\n0,,\n", "line 2: x is '', not a finite number"),
        "blanks and commas": (b"time_s x\n0,5 1\n", "line 2: time_s is '0,5', not a finite number"),
    }
)
read_sensors = partial(
    datasets.read_columns, limits={"time_s": 99.0, "id": 9.0}, integers=["id"], texts=["sensor"]
)
SENSORS = "time_s,id,sensor"

# Ranges -------------------------------------------------------------------------------------------

read_ranges = partial(datasets.read_ranges, max_range=80.0)
RANGES = table(r"""
a reading less | 1,2\n1 | line 2: fewer values
a reading more | 1,2\n1,2,3 | line 2: more values
names | r1,r2\n1,2 | line 1: a value is not a number: 'r1' in column 1
a word | 1,2\n1,x | line 2: a value is not a number: 'x' in column 2
no scan | # nothing | no scan line
""") | table(
    r"""
nothing near | 80,80 | : no reading is below 80 m; are they in metres?
millimetres | 300,4000 | : no reading is below 80 m; are they in metres?
""",
    error=ValueError,
)


def npy(array) -> bytes:
    """Return an array as NumPy stores it."""
    np.save(file := io.BytesIO(), array)
    return file.getvalue()


ARRAYS = damages(
    {
        "no scans": (npy(np.zeros(3)), r"ranges must be \(scans, beams\), got \(3,\)"),
        "none of them": (npy(np.zeros((0, 3))), r"got \(0, 3\)"),
        "words": (npy(np.array([["a"]])), "no array of numbers"),
        "objects": (npy(np.array([[None]])), "no array of numbers"),
        "far": (
            npy(np.array([[1.0, 2.0], [3.0, -2e6]])),
            "reading 2, 2 is -2e\\+06, no distance in metres",
        ),
        "no array": (b"no array", "no array of numbers"),
    },
)
VOID = [[1, NAN, INF], [-1, 0, INF]]

# What sensors saw ---------------------------------------------------------------------------------

SEEN = "time_s,landmark,range_m,bearing_rad"
LANDMARKS = table(
    r"""
seen twice | 1,7,3,0\n2,7,3,0\n1,7,3,1 | line 4: landmark 7: .* line 2
range 0 | 1,7,3,0\n\n2,7,0,0 | line 4: range_m must be positive, got 0
a negative range | 1,7,-3,0 | line 2: range_m must be positive, got -3
no landmark | 1,-2,3,0 | line 2: landmark must be at least -1, got -2
half a landmark | 1,1.5,3,0 | line 2: landmark is '1.5', not a whole
degrees | 1,1,3,45 | line 2: bearing_rad is '45', beyond 7
""",
    SEEN,
)
FELT = "time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad"
DETECTIONS = table(
    r"""
sigma 0 | 1,laser,2,0,0,1 | line 2: distance_sigma_m must be posit
no spread | 1,laser,2,0,1,0 | line 2: direction_sigma_rad must be
another sensor | 1,eye,2,0,1,1\n1,radar,2,0,1,1 | line 3: sensor is 'radar', none of the sensors las
""",
    FELT,
)
MOVES = "time_s,speed_m_s,turn_rate_rad_s"

# Boxes --------------------------------------------------------------------------------------------

BOX = "frame,x,y,w,h"
BOXES = table(
    r"""
none |  | no row line
a cell less | 1,2,3,4 | line 2: fewer values
NaN | 1,2,3,nan,5 | line 2: w is 'nan', not a finite number
far | 1,2,3,1e9,5 | line 2: w is '1e9', beyond
half a frame | 1.5,2,3,4,5 | line 2: frame is '1.5', not a whole number
no height | 1,2,3,4,0 | line 2: the box of frame 1 has no area
no width | 1,2,3,4,5\n2,2,3,-4,5 | line 3: the box of frame 2 has no area
a frame twice | 1,2,3,4,5\n1,2,3,4,5 | line 3: frames must rise, got 1 before 1
frames that fall | 2,2,3,4,5\n1,2,3,4,5 | line 3: frames must rise, got 2 before 1
a frame less | 1,2,3,4,5 | frames are not those of numbers, such as 2
another frame | 1,2,3,4,5\n3,2,3,4,5 | frames are not those of numbers, such as 2
""",
    BOX,
) | table("a column less | frame,x,y,w\\n1,2,3,4 | no column h")

# Relations ----------------------------------------------------------------------------------------

RNG = np.random.default_rng(3)
RELATED = np.column_stack([RNG.uniform(0, 100, (5, 2)).round(6), RNG.normal(size=(5, 6)).round(6)])
RELATIONS = [" ".join(map(repr, row)).encode() for row in RELATED.tolist()]

NO_COLUMN = "no column .*; there is nothing"
FORMATS = {
    "columns": Format(
        partial(datasets.read_columns, limits=LIMITS, integers=["id"]),
        {"own.csv": joined("bearing_rad,time_s,note,id", "0.5,1.5e1,1,3", "-7,2,2,4")},
        {"time_s": [15, 2], "bearing_rad": [0.5, -7], "id": [3, 4], "id.dtype": np.int64},
        COLUMNS,
        form="named",
        nothing="no column time_s and no column id and .*; there is nothing",
        count=rows_of("id"),
        accounts=False,
        again=datasets.write_columns,
    ),
    "ambiguous": Format(
        partial(datasets.read_columns, limits={"time_s": 9, "x": 9}),
        {"a.csv": joined("time_s;x", "0,5;1", "1,5;1")},
        {"time_s": [0.5, 1.5], "x": [1, 1]},
        AMBIGUOUS,
        form="text",
        count=rows_of("x"),
    ),
    "sensors": Format(
        read_sensors,
        {"a.csv": joined(SENSORS, "0.5,3,left", "1,4,right")},
        {"time_s": [0.5, 1], "sensor": ["left", "right"]},
        damages(
            {
                "no word": (f"{SENSORS}\n1,2,eye\n2,2,\n", "line 3: sensor is empty"),
                "no such column": ("time_s,id\n1,1\n", "no column of texts sensor"),
                "a column twice": (
                    f"{SENSORS},sensor\n1,1,eye,ear\n",
                    "column sensor is there twice",
                ),
            }
        ),
        form="named",
        nothing=NO_COLUMN,
        count=rows_of("id"),
        accounts=False,
        again=datasets.write_columns,
    ),
    "ranges": Format(
        read_ranges,
        {"own.csv": joined("1.5,nan,inf", "-1,0,80")},
        {"0": [1.5, NAN, INF], "1": [-1, 0, INF]},
        RANGES,
        nothing="no scan line",
        count=len,
        accounts=False,
    ),
    "ranges_npy": Format(
        read_ranges,
        {"own.npy": npy(np.where(np.isposinf(VOID), 81.0, VOID))},
        {"0": VOID[0], "1": VOID[1]},
        ARRAYS,
        form="bytes",
        error=ValueError,
        empty="no array of numbers",
        again=np.save,
    ),
    "landmarks": Format(
        partial(datasets.read_landmarks, measured={"range_m": 200, "bearing_rad": 7}),
        {"seen.csv": joined(SEEN, "2,3,0.5,0", "1,3,1.5,0.5")},
        {
            "times": [1, 2],
            "landmarks": [3, 3],
            "values": [[1.5, 0.5], [0.5, 0]],
            "report.kept": {"observation": 2},
            "report.remarks": ("seen.csv: rows were brought into the order of their times",),
        },
        LANDMARKS,
        form="named",
        count=with_names,
        accounts=False,
        nothing=NO_COLUMN,
    ),
    "detections": Format(
        partial(datasets.read_detections, sensors=["laser", "eye"]),
        {"seen.csv": joined(FELT, "2,laser,1,.5,.1,.2", "1,eye,-1,0,0,0", "3,laser,0,0,1,1")},
        {
            "times": [2, 1, 3],
            "sensors": ["laser", "eye", "laser"],
            "seen": [True, False, True],
            "values.0": [1, 0.5, 0.1, 0.2],
        },
        DETECTIONS,
        form="named",
        count=with_names,
        accounts=False,
        nothing=NO_COLUMN,
    ),
    "commands": Format(
        datasets.read_commands,
        {"seen.csv": joined(MOVES, "1,0,0.5", "1,1,-0.5", "2,0,0")},
        {"times": [1, 1, 2], "velocities": [[0, 0.5], [1, -0.5], [0, 0]]},
        table(r"times fall | 1,0,0\n3,0,0\n2,0,0 | line 4: times must not fall, got 3 befo", MOVES),
        form="named",
        count=with_names,
        accounts=False,
        nothing=NO_COLUMN,
    ),
    "boxes": Format(
        partial(datasets.read_boxes, numbers=(1, 2)),
        {"boxes.csv": joined(BOX, "1,1,2,4,5", "2,1.5,3,1,1")},
        {
            "numbers": [1, 2],
            "boxes": [[0, 1, 4, 5], [0.5, 2, 1, 1]],  # pixels are counted from nought
            "centres": [[1.5, 3], [0.5, 2]],
        },
        BOXES,
        form="named",
        count=lambda found: len(found.numbers) + 1,
        accounts=False,
        nothing=NO_COLUMN,
    ),
    "relations": Format(
        datasets.read_relations,
        {"a.relations": joined(*RELATIONS)},
        {
            "times": RELATED[:, :2],
            "motions": RELATED[:, 2:],
            "planar": RELATED[:, [2, 3, 7]],
            "report.kept": {"relation": 5},
        },
        added(
            RELATIONS,
            {"degrees": (b"1 2 0 0 0 0 0 -45", "an angle is beyond a full turn: are these rad")},
        ),
        words=plain,
    ),
}

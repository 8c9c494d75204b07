"""Text as it comes: whatever wrote a file, every reader reads the same numbers."""

import re
from functools import partial
from itertools import product

import pytest
from PIL import Image

from robot_perception import datasets
from robot_perception.datasets import (
    CorruptLog,
    read_columns,
    read_ranges,
    read_space_track,
    read_track,
)
from tests.datasets import test_lines
from tests.datasets.test_lines import Kind, plain

COLUMNS = partial(
    read_columns, limits={"time_s": 99.0, "id": 9.0}, integers=["id"], texts=["sensor"]
)
POSE = b" 1 0 0 0.5 0 1 0 -1.5 0 0 1 2"
LEFT = b"9.5 0 8 0 0 9.5 7 0 0 0 1 0"


def pictures(folder):
    for side, number in product(("image_0", "image_1"), range(2)):
        (folder / side).mkdir(exist_ok=True)
        Image.new("L", (4, 3)).save(folder / side / f"{number}.png")
    (folder / "calib.txt").write_bytes(LEFT + b"\n" + LEFT.replace(b"8 0", b"8 -4.75", 1))


NAMED = {  # by the names of columns
    "columns": Kind(COLUMNS, "a.csv", [b"time_s,id,sensor", b"0.5,3,left", b"1,4,right"], plain),
    "boxes": Kind(datasets.read_boxes, "a.csv", [b"frame,x,y,w,h", b"1,3.5,4,10,12"], plain),
    "track": Kind(
        read_track, "a.csv", [b"time_s,x_m,y_m,heading_rad", b"1,0,0,0.5", b"2,-1.5,0,1e-3"], plain
    ),
    "landmarks": Kind(
        partial(datasets.read_landmarks, measured={"range_m": 9}),
        "a.csv",
        [b"time_s,landmark,range_m", b"2,3,0.5", b"1,3,1.5"],
        plain,
    ),
    "detections": Kind(
        datasets.read_detections,
        "a.csv",
        [
            b"time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad",
            b"1,laser,2.5,0.5,0.1,0.1",
            b"1,laser,-1,0,0,0",
        ],
        plain,
    ),
    "track in space": Kind(
        read_space_track,
        "a.csv",
        [b"time_s,x_m,y_m,z_m,qx,qy,qz,qw", b"1,0,0,2,0.6,0,0,-0.8", b"2,-1.5,0,1e-3,0,0,0,1"],
        plain,
    ),
    "EuRoC": Kind(
        read_space_track,
        "a.csv",
        [
            b"timestamp,p_RS_R_x,p_RS_R_y,p_RS_R_z,q_RS_w,q_RS_x,q_RS_y,q_RS_z",
            b"1403636580838555648,1.5,-2,3,0.6,0,0.8,0",
            b"1403636580843555328,1.5,-2,3.25,1,0,0,0",
        ],
        plain,
    ),
}
IN_SPACE = ("TUM in space", "KITTI poses")
TABLES = {
    name: test_lines.KINDS[name] for name in ("relations", "TUM", "wheels", "camera", *IN_SPACE)
} | {
    "stereo": test_lines.KINDS["stereo"],
    "ranges": Kind(partial(read_ranges, max_range=8.0), "a.csv", [b"1.5,inf", b"3,9"], plain),
    "calibration": Kind(
        datasets.read_calibration, "calib.txt", [LEFT, LEFT.replace(b"8 0", b"8 -4.75", 1)], plain
    ),
    "named calibration": Kind(
        datasets.read_calibration,
        "calib.txt",
        [b"P1: " + LEFT.replace(b"8 0", b"8 -4.75", 1), b"P0: " + LEFT],
        plain,
    ),
    "KITTI": Kind(
        datasets.read_kitti, "poses.txt", [b"1" + POSE, b"0" + POSE.replace(b"2", b"3")],
        plain, pictures,
    ),
    "KITTI's own": Kind(datasets.read_kitti, "poses.txt", [POSE.strip()] * 2, plain, pictures),
}  # fmt: skip
ALL = test_lines.KINDS | TABLES | NAMED

ENCODED = {
    "byte order mark": lambda text: text.decode().encode("utf-8-sig"),
    "UTF-16": lambda text: ("\ufeff" + text.decode()).encode("utf-16-le"),
    "UTF-16 of the other end": lambda text: ("\ufeff" + text.decode()).encode("utf-16-be"),
    "UTF-32": lambda text: ("\ufeff" + text.decode()).encode("utf-32-le"),
    "CRLF": lambda text: text.replace(b"\n", b"\r\n"),
    "CR": lambda text: text.replace(b"\n", b"\r"),
    "no last line end": lambda text: text.removesuffix(b"\n"),
    "blanks at the ends": lambda text: text.replace(b"\n", b" \t\n"),
}


@pytest.mark.parametrize("change", ENCODED.values(), ids=ENCODED)
@pytest.mark.parametrize("kind", ALL.values(), ids=ALL)
def test_an_encoding_changes_no_number(kind, change):
    assert kind.outcome(change(kind.good)) == kind.outcome(kind.good)


def rendered(kind, separator, *, quoted=False, comma=False, trailing=False):
    """Return the lines of a table with other marks between its cells."""
    lines = []
    for line in kind.lines:
        cells = re.split(rb"[,\s]+", line)
        if not line.startswith(b"#"):
            cells = [cell.replace(b".", b",") for cell in cells] if comma else cells
            cells = [b'"' + cell + b'"' for cell in cells] if quoted else cells
            line = separator.join(cells) + separator * trailing
        lines.append(line)
    return b"\n".join(lines) + b"\n"


SEPARATORS = {"comma": b",", "semicolon": b";", "tab": b"\t", "blank": b" ", "wide": b" ; "}
DIALECTS = {
    f"{name}{', quoted' * quoted}{', decimal commas' * comma}{', trailing' * trailing}": {
        "separator": separator, "quoted": quoted, "comma": comma, "trailing": trailing
    }
    for (name, separator), quoted, comma, trailing in product(
        SEPARATORS.items(), (False, True), (False, True), (False, True)
    )
    if not (comma and name in ("comma", "blank")) and not (quoted and name == "wide")
}  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
@pytest.mark.parametrize("kind", (TABLES | NAMED).values(), ids=TABLES | NAMED)
def test_a_dialect_changes_no_number(kind, dialect):
    assert kind.outcome(rendered(kind, **dialect)) == kind.outcome(kind.good)


@pytest.mark.parametrize("mark", [b"#", b"# ", b"\xef\xbb\xbf#"])
@pytest.mark.parametrize("separator", [b",", b";", b"\t", b" "])
@pytest.mark.parametrize("kind", NAMED.values(), ids=NAMED)
def test_names_may_stand_behind_a_hash(kind, separator, mark):
    text, quoted = rendered(kind, separator), rendered(kind, separator, quoted=True)
    for content in (
        mark + text,
        b'# "odd, comment\n' + b"#" + text,
        b"#" + kind.lines[0] + b"\n" + text,
        b"#" + quoted,
    ):
        found = re.sub(r"others=mappingproxy\(\{'#': \d\}\)", "others=", kind.outcome(content))
        assert found == kind.outcome(kind.good).replace("others=mappingproxy({})", "others=")


@pytest.mark.parametrize("kind", (TABLES | NAMED).values(), ids=TABLES | NAMED)
def test_a_comment_may_have_quotes_of_any_kind(kind):
    comments = [b'# "odd', b'# "rgb" trajectory, "desk', b'# "", "a"b', b"# it's"]
    text = b"\n".join([*comments, kind.good])
    assert kind.outcome(text) == kind.outcome(b"# x\n" * 4 + kind.good)


def test_names_may_be_parted_by_other_marks_than_numbers(tmp_path):
    """As numpy.savetxt writes a header and rows."""
    (tmp_path / "a.csv").write_text("# time_s,x_m,y_m,heading_rad\n0 1 2 3\n1 1 2 3\n")
    assert read_track(tmp_path / "a.csv").poses.tolist() == [[1, 2, 3]] * 2


def test_a_last_cell_may_be_empty_in_a_column_that_is_left_out(tmp_path):
    (tmp_path / "a.csv").write_text("#time_s,id,note\n0,1,\n1,2,hi\n")
    assert read_columns(tmp_path / "a.csv", {"time_s": 9, "id": 9})["id"].tolist() == [1, 2]


def test_texts_keep_what_stands_in_quotes(tmp_path):
    text = 'time_s,note\n0,"left, then ""right"""\n\n1,"two\n# lines\n\nand more"\n2,5" wide\n'
    (tmp_path / "a.csv").write_text(text)
    notes = read_columns(tmp_path / "a.csv", {"time_s": 9}, texts=["note"])["note"]
    assert notes.tolist() == ['left, then "right"', "two\n# lines\n\nand more", '5" wide']


def test_names_may_hold_what_parts_cells(tmp_path):
    (tmp_path / "a.csv").write_text('"a;b","c\td",x\n1,2,3\n')
    limits = {"a;b": 9, "c\td": 9, "x": 9}
    found = read_columns(tmp_path / "a.csv", limits)
    assert {name: column.tolist() for name, column in found.items()} == dict(
        zip(limits, [[1], [2], [3]], strict=True)
    )


def test_every_line_of_a_quoted_text_is_counted(tmp_path):
    (tmp_path / "a.txt").write_text('1 2 0 0 0 0 0 "0\n"\n1 3 0 0 0 0 0 0\n')
    report = datasets.read_relations(tmp_path / "a.txt").report
    assert (report.kept, report.others) == ({"relation": 2}, {"continued": 1})
    assert report.lines == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"time_s;x\n0,5;1\n1.5;1\n", "line 3: decimal commas and decimal points"),
        (b"time_s;x\n1.000,5;1\n", "line 2: decimal commas and decimal points"),
        (b'time_s,x\n0,1\n1,"2\n3,4\n', r"line 3: its quotes are wrong \(unexpected end of data"),
        (b'time_s,x\n0,"1"2\n', r"line 2: its quotes are wrong \(',' expected"),
        (b"time_s,x\n0,1 \xe4\n", "line 2: not text in UTF-8"),
        (b"\xff\xfet\0i\0", "line 1: no column time_s"),
        (b"\xff\xfet\0i", "line 1: not text in UTF-16-LE"),
        ("time_s,x\n0,1\n".encode("utf-16-le"), "line 1: not text in UTF-8"),
        (b"time_s,x\n0,1,\n1,2,3,\n", "line 3: more values than announced"),
        (b"time_s,x,\n0,,\n", "line 2: x is '', not a finite number"),
        (b"time_s x\n0,5 1\n", "line 2: time_s is '0,5', not a finite number"),
    ],
)
def test_text_that_can_be_read_in_two_ways_stops_at_its_line(tmp_path, text, message):
    (tmp_path / "a.csv").write_bytes(text)
    with pytest.raises(CorruptLog, match=rf"a\.csv, {message}"):
        read_columns(tmp_path / "a.csv", {"time_s": 9, "x": 9})

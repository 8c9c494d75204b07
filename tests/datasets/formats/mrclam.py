"""MRCLAM: a folder with two files of landmarks, and three of each robot."""

from robot_perception.datasets import mrclam, read_mrclam
from tests.datasets.formats.declared import Damage, Format, added, joined, listed, plain

HEADER = b"# Time [s]    x [m]"
FILES = {
    "Barcodes": [b"1 5", b"2 14", b"3 41", b"4 32", b"5 23", b"6 63", b"7 81"],
    "Landmark_Groundtruth": [b"7 2.5 -1.0 0.0003 0.0001", b"6 1.5 -4.25 0.0001 0.0002"],
    "Odometry": [b"10.0 0.5 0.1", b"10.5 0.5 0.1", b"11.0 0.25 0.0"],
    "Measurement": [b"10.25 63 2.0 0.5", b"10.25 90 1.0 0.0", b"10.5 14 3.0 -0.5"],
    "Groundtruth": [b"10.0 0.0 0.0 3.1", b"11.0 2.0 4.0 -3.1"],
}


def files(**changes: list[bytes]) -> dict[str, bytes]:
    """Return a small data set, with other lines in the files named (of robot 2)."""
    found = {}
    for name, lines in FILES.items():
        mine = joined(HEADER, *changes.get(name, lines))
        if name in {"Barcodes", "Landmark_Groundtruth"}:
            found[f"{name}.dat"] = mine
            continue
        for robot in mrclam.ROBOTS:
            found[f"Robot{robot}_{name}.dat"] = mine if robot == 2 else joined(HEADER, *lines)
    return found


SECOND, NO_ID = "names a subject or barcode a second time", "a subject or barcode is not a positive"
BAD_LINES = {
    "Barcodes": listed(r"""
a barcode twice | 8 63 | names a subject or barcode a second time
half a subject | 8.5 99 | a subject or barcode is not a positive
subject 0 | 0 99 | a subject or barcode is not a positive
"""),
    "Landmark_Groundtruth": listed(r"""
a subject twice | 6 0 0 0 0 | names a subject or barcode a second time
a negative sigma | 8 0 0 -1 0 | a standard deviation is negative
a negative subject | -8 0 0 0 0 | a subject or barcode is not a positive
"""),
    "Odometry": listed(r"""
time falls | 10.75 0.5 0.1 | its time lies before that of an earlier line
"""),
    "Measurement": listed(r"""
time falls | 10.25 63 2.0 0.5 | its time lies before that of an earlier line
a barcode twice | 10.5 14 2.9 -0.5 | sees a barcode a second time in one image
range 0 | 10.75 63 0 0.5 | a range is not positive
half a barcode | 10.75 6.5 1 0.5 | a subject or barcode is not a positive
degrees | 10.75 63 2 45 | beyond a full turn: are these radians\?
"""),
    "Groundtruth": listed(r"""
time stays | 11.0 0 0 0 | has the time of an earlier line
time falls | 9.0 0 0 0 | its time lies before that of an earlier line
"""),
}
ALONE = {
    "Barcodes": {
        "a subject that is nowhere": Damage(
            joined(HEADER, *FILES["Barcodes"], b"9 99"),
            r": subjects \[9\] have a barcode and no position",
            of_folder=True,
        ),
        "missing": Damage(None, "", error=FileNotFoundError),
    },
    "Odometry": {
        "the first of several": Damage(
            joined(HEADER, FILES["Odometry"][0], b"#", b"10.1 x 0", b"10.2 0 y"),
            "line 4: .*not a number",
        ),
        "none": Damage(joined(HEADER), "no odometry line"),
        "missing": Damage(None, "", error=FileNotFoundError),
    },
}
READS = {
    "landmarks.ids": [6, 7],
    "landmarks.positions": [[1.5, -4.25], [2.5, -1.0]],
    "landmarks.sigmas": [[1e-4, 2e-4], [3e-4, 1e-4]],
    "robots.3.commands.times": [10, 10.5, 11],
    "robots.3.commands.velocities": [[0.5, 0.1], [0.5, 0.1], [0.25, 0]],
    "robots.2.truth.poses": [[0, 0, 3.1], [2, 4, -3.1]],
    "robots.1.landmarks.subjects": [6],  # robots, landmarks and misread barcodes are kept apart
    "robots.1.landmarks.values": [[2.0, 0.5]],
    "robots.1.robots.subjects": [2],
    "robots.1.robots.times": [10.5],
    "robots.1.unknown": {90: 1},
    "reports.16.others": {"#": 1},
}


def utias(name: str) -> Format:
    """Return the format of one of the files."""
    good = files()
    place = name if f"{name}.dat" in good else f"Robot2_{name}"
    lines = [HEADER, *FILES[name]]
    return Format(
        read_mrclam,
        good,
        READS,
        added(lines, BAD_LINES[name]) | ALONE.get(name, {}),
        file=f"{place}.dat",
        opens=".",
        words=plain,
        count=lambda found: next(
            report.lines for report in found.reports if report.path.name.startswith(place)
        ),
    )


FORMATS = {f"mrclam_{name.lower()}": utias(name) for name in FILES}

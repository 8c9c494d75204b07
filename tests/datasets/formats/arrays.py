"""Arrays that MATLAB or NumPy stored: Victoria Park's vehicle and fixes, scans with marked legs.

And Victoria Park's graph, which is text.
"""

import io

import numpy as np
from scipy.io import savemat
from scipy.sparse import coo_array

from robot_perception.datasets import (
    Sector,
    read_fixes,
    read_landmark_graph,
    read_leg_scans,
    read_vehicle,
)
from tests.datasets.formats import lasers
from tests.datasets.formats.declared import Damage, Format, added, byte, damages, joined, listed
from tests.datasets.formats.tables import npy

# The graph ----------------------------------------------------------------------------------------

MOTION = b"0.01 0.001 0.002 0.04 0.003 0.05"
CHAIN = [
    b"# a drive",
    b"ODOMETRY 0 1 1.5 0.25 0.5 " + MOTION,
    b"LANDMARK 3 2 4.0 -2.0 0.4 0.1 0.5",
    b"LANDMARK 0 2 5.0 -3.0 0.4 0 0.4",
    b"ODOMETRY 1 3 2.5 0 -0.5 " + MOTION,
    b"LANDMARK 3 1 1.0 1.0 0.4 0 0.4",
]
BROKEN = listed(r"""
another pose | ODOMETRY 1 4 1 0 0 0.01 0.001 0.002 0.04 0.003 0.05 | does not begin at the pose wher
a pose twice | ODOMETRY 3 1 1 0 0 0.01 0.001 0.002 0.04 0.003 0.05 | repeats a pose
a motion's matrix | ODOMETRY 3 4 1 0 0 1 2 0 1 0 1 | its matrix is not positive definite
a sighting's matrix | LANDMARK 3 8 1 1 0.4 0 0 | its matrix is not positive definite
no pose | LANDMARK 9 8 1 1 0.4 0 0.4 | its pose is not among those the motions lead to
a sighting twice | LANDMARK 3 1 1 1 0.4 0 0.4 | repeats a sighting
degrees | ODOMETRY 3 4 1 0 -45 0.01 0.001 0.002 0.04 0.003 0.05 | an angle is beyond a full turn: ar
""")
SEEMS = "it seems to be a CARMEN log: use read_carmen_log"

# MATLAB -------------------------------------------------------------------------------------------


def matlab(**arrays) -> bytes:
    """Return arrays as MATLAB stores them."""
    savemat(file := io.BytesIO(), arrays)
    return file.getvalue()


TIME, ONES = np.array([[0], [25], [50]], dtype=np.int32), np.ones((3, 1))


def fixes(**changes) -> bytes:
    """Return fixes, of which some arrays are others."""
    return matlab(**{"timeGps": TIME, "Lo_m": ONES, "La_m": ONES} | changes)


NO_MATLAB = r"not a MATLAB file with timeGps, Lo_m, La_m \("
FIXES = damages(
    {
        "an array less": (matlab(timeGps=TIME, Lo_m=ONES), "La_m"),
        "a value less": (fixes(La_m=ONES[:2]), r"have \[2, 3\] values"),
        "no value": (fixes(timeGps=TIME[:0], Lo_m=ONES[:0], La_m=ONES[:0]), r"have \[0\] values"),
        "NaN": (fixes(La_m=np.nan * ONES), "La_m is NaN .* at row 1"),
        "times that fall": (fixes(timeGps=TIME[::-1]), "timeGps does not rise after row 1"),
        "times that stay": (fixes(timeGps=25 * (TIME > 0)), "does not rise after row 2"),
        "words": (fixes(Lo_m=np.array("fast")), "Lo_m holds no real numbers but .*<U4"),
        "a struct": (fixes(Lo_m={"left": 1.0}), "Lo_m holds no real numbers but .*left"),
        "sparse": (fixes(Lo_m=coo_array(np.eye(3))), "Lo_m holds no real numbers but .*object"),
        "complex": (fixes(Lo_m=ONES + 1j), "Lo_m holds no real numbers but .*complex128"),
    }
) | {  # bytes that end SciPy's interpreter
    f"interpreter, byte {place}": Damage(byte(place, value), "not a MATLAB file with timeGps")
    for place, value in ((145, 9), (172, 15), (185, 255))
}

# NumPy --------------------------------------------------------------------------------------------

PLAIN = {
    "stamp": np.array([3.0, 3.1, 3.2]),
    "ranges": np.array([[1.0, 0.0, 2.0], [np.nan, -np.inf, 8.5], [0.05, np.inf, 8.0]], np.float32),
    "angle_min": np.float64(-0.5),
    "angle_increment": np.float64(0.25),
    "range_min": np.float64(0.1),
    "range_max": np.float64(8.0),
}
MARKED = PLAIN | {
    "leg_scan": np.array([0, 2, 2], np.int32),
    "leg_xy": np.array([[1.0, 0.1], [2.0, -0.25], [2.5, 0.0]], np.float32),
    "label_sector_deg_m": np.array([-15, 30, 5], np.float32),
}
INF = np.inf
FAR = PLAIN | {  # a scanner without a farthest range
    "range_max": INF,
    "ranges": np.array([[1.0, INF, 3e38], [np.nan, 0.05, 90.0], [2.0, 0.0, -INF]]),
}
TURN = PLAIN | {  # a full turn of float32
    "angle_min": np.float32(-np.pi),
    "angle_increment": np.float32(2 * np.pi) / np.float32(719),
    "ranges": np.ones((3, 720)),
}


def archive(**arrays) -> bytes:
    """Return arrays as NumPy stores them, without those that are ``None``."""
    file = io.BytesIO()
    np.savez(file, **{name: value for name, value in arrays.items() if value is not None})
    return file.getvalue()


LEGS = {
    "no legs": ({"leg_xy": None}, "has no array leg_xy"),
    "no scans": ({"stamp": None, "ranges": None}, "has no array stamp, ranges"),
    "times stay": ({"stamp": np.array([3.0, 3.0, 3.1])}, "stamp must rise"),
    "NaN": ({"stamp": np.array([3.0, np.nan, 3.1])}, "stamp must be finite"),
    "a scan less": ({"ranges": np.ones((2, 3))}, r"ranges must be \(3, beams\), got \(2, 3\)"),
    "words": ({"ranges": np.array(["a"])}, "ranges must be real numbers"),
    "no step": ({"angle_increment": np.float64(0.0)}, "angle_increment must be positive"),
    "no farthest": ({"range_max": np.nan}, "range_max must be above range_min, got nan and 0.1"),
    "nothing between": ({"range_max": 0.1}, "range_max must be above range_min, got 0.1 and 0.1"),
    "degrees": ({"angle_min": -135.0}, "beams must lie within a turn, got from -135 to -134.5"),
    "degrees of a step": (
        {"angle_increment": 45.0},
        "beams must lie within a turn, got from -0.5 to 89.5",
    ),
    "marks fall": ({"leg_scan": np.array([0, 2, 1])}, "leg_scan must not fall, and be below 3"),
    "no such scan": ({"leg_scan": np.array([0, 2, 3])}, "leg_scan must not fall, and be below 3"),
    "a mark less": ({"leg_scan": np.array([0, 2])}, r"leg_xy must be \(2, 2\), got \(3, 2\)"),
    "half a sector": (
        {"label_sector_deg_m": np.ones(2)},
        r"label_sector_deg_m must be \(3,\), got \(2,\)",
    ),
}
NO_ARCHIVE = "no NumPy archive, or a damaged one"


def legs(arrays, reads, **more) -> Format:
    """Return the format of scans at leg height."""
    return Format(
        read_leg_scans,
        {"legs.npz": archive(**arrays)},
        reads,
        form="bytes",
        empty=NO_ARCHIVE,
        **more,
    )


FORMATS = {
    "chain": Format(
        read_landmark_graph,
        {"a.txt": joined(*CHAIN)},
        {
            "motions": [[1.5, 0.25, 0.5], [2.5, 0, -0.5]],
            "motion_covs": [[[0.01, 0.001, 0.002], [0.001, 0.04, 0.003], [0.002, 0.003, 0.05]]] * 2,
            "observers": [0, 2, 2],  # pose 3 of the file is the third
            "landmarks": [2, 2, 1],  # of a pose as in the file
            "values": [[5, -3], [4, -2], [1, 1]],
            "value_covs.1": [[0.4, 0.1], [0.1, 0.5]],
            "report.kept": {"ODOMETRY": 2, "LANDMARK": 3},
            "report.others": {"#": 1},
        },
        added(CHAIN, BROKEN)
        | damages(
            {
                "no motion": (b"LANDMARK 3 7 1 1 1 0 1\n", "no ODOMETRY line"),
                "CARMEN": (joined(*lasers.FLASER), SEEMS),
                "newer CARMEN": (joined(*lasers.NEWER), SEEMS),
            }
        ),
        form="keyed",
        words=lambda words: ([1, 2], [*range(3, len(words))]),
    ),
    "vehicle": Format(
        read_vehicle,
        {"a.mat": matlab(time=TIME, speed=2 * ONES, steering=0.5 * ONES)},
        {"times": [0, 0.025, 0.05], "speeds": [2, 2, 2], "steerings": [0.5] * 3},
        damages(
            {
                "degrees": (
                    matlab(time=TIME, speed=ONES, steering=9 * ONES),
                    r"beyond a full turn: are these radians\?",
                )
            }
        ),
        form="bytes",
        empty="not a MATLAB file with time, speed, steering",
        costs=True,
    ),
    "fixes": Format(
        read_fixes,
        {"a.mat": fixes(Lo_m=3 * ONES, La_m=-ONES)},
        {"times": [0, 0.025, 0.05], "positions": [[3, -1]] * 3},
        FIXES,
        form="bytes",
        empty=NO_MATLAB,
        costs=True,
    ),
    "legs": legs(
        MARKED,
        {
            "times": MARKED["stamp"],
            "ranges": [[1, INF, 2], [INF, INF, INF], [INF, INF, 8]],
            "angles": [-0.5, -0.25, 0],
            "scans_of_legs": [0, 2, 2],
            "legs": MARKED["leg_xy"],
            "sector": Sector(np.deg2rad(-15), np.deg2rad(30), 5.0),
        },
        damages=damages(
            {name: (archive(**MARKED | changes), why) for name, (changes, why) in LEGS.items()}
            | {
                "no archive": (b"not an archive", NO_ARCHIVE),
                "an array alone": (npy(np.ones(3)), NO_ARCHIVE),
            }
        ),
    ),
    "legs_far": legs(FAR, {"ranges": [[1, INF, INF], [INF, INF, 90], [2, INF, INF]]}),
    "legs_turn": legs(TURN, {"angles": np.linspace(-np.pi, np.pi, 720)}, atol=1e-6),
    "legs_plain": legs(PLAIN, {"sector": None, "legs": np.zeros((0, 2))}),
}

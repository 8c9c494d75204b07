"""Trajectories in the plane and in space, in every format in which benchmarks hold them."""

from functools import partial

import numpy as np

from robot_perception import datasets
from robot_perception.datasets.poses import Layout, read_poses
from robot_perception.datasets.space_tracks import read_matrices
from tests.datasets.formats.declared import Damage, Format, joined, plain, table

CSV = "time_s,x_m,y_m,heading_rad"
COVS = f"{CSV},cov_xx,cov_xy,cov_xh,cov_yy,cov_yh,cov_hh"
IN_PLANE = (
    table(
        r"""
times that stay | 1,0,0,0\n#\n1,0,0,0 | line 4: times must rise, got 1 bef
degrees | 1,0,0,0\n2,0,0,90 | line 3: heading_rad is 90, .* are these degr
""",
        CSV,
    )
    | table(r"""
a column less | time_s,x_m,y_m\n1,0,0 | line 1: no column heading_rad
a covariance | time_s,x_m,y_m,heading_rad,cov_xx\n1,0,0,0,1 | some covariances are there, but no col
""")
    | table(
        r"""
no covariance | 1,0,0,0,1,0,0,1,0,1\n2,0,0,0,1,2,0,1,0,1 | line 3: covariances must be
""",
        COVS,
    )
)
TUM = table(r"""
a value less | 1 0 0 0 0 0 0 | line 1: fewer values
times that fall | 2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1 | line 2: its time does not lie after
times that stay | 2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1 | line 2: its time does not lie after
a long quaternion | 1 0 0 0 0 0 0 1.01 | line 1: its quaternion qx qy qz qw is not of unit length
a longer one | 1 0 0 0 0 0 1 1 | line 1: its quaternion qx qy qz qw is not of unit length
on its side | 1 0 0 0 1 0 0 0 | line 1: its quaternion qx qy qz qw turns the robot onto its side
NaN | 1 0 0 0 0 0 nan 1 | line 1: a value is NaN or infinite, in column 7
a word | 1 0 0 0 0 0 x 1 | line 1: a value is not a number: 'x'
KITTI | 1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0 | line 1: more .*
""")
NAMED = "timestamp,p_RS_R_x,p_RS_R_y,p_RS_R_z,q_RS_w,q_RS_x,q_RS_y,q_RS_z"
IN_SPACE = table(r"""
a quaternion of length 2 | 0 0 0 0 0 0 0 2 | line 1: its quaternion qx qy qz qw is not of unit lengt
a time twice | 1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1 | line 2: its time does not lie after
a stretched matrix | 1 0 0 0 0 1 0 0 0 0 2 0 | line 1: its matrix of 3 × 3 is no rotation
a reflection | -1 0 0 0 0 1 0 0 0 0 1 0 | line 1: its matrix of 3 × 3 is no rotation
a value less | 0 0 0 0 0 0 0 | line 1: fewer values than announced
half a nanosecond | 0.5,0,0,0,1,0,0,0,0 | line 1: its time is not in whole nanoseconds
seconds for nanoseconds | 0,0,0,0,1,0,0,0,0\n1,0,0,0,1,0,0,0,0 | line 2: its time is not in whole na
EuRoC's quaternion | 0,0,0,0,1,1,0,0 | line 1: its quaternion
a name less of EuRoC | timestamp,p_RS_R_x,p_RS_R_y,p_RS_R_z,q_RS_w,q_RS_x,q_RS_y\n1,0,0,0,1,0,0 | li
named TUM | #timestamp,tx,ty,tz,qx,qy,qz,qw\n0,0,0,0,0,0,0,2 | line 2: its quaternion
far | 0 2e8 0 0 0 0 0 1 | line 1: a place lies beyond 1e\+08 m
far by a matrix | 1 0 0 2e8 0 1 0 0 0 0 1 0 | line 1: a place lies beyond 1e\+08 m
far between commas | 0,2e8,0,0,1,0,0,0 | line 1: a place lies beyond 1e\+08 m
nanoseconds | 0 0 0 0 0 0 0 1\n9e9 0 0 0 0 0 0 1 | look like .*time_unit='ns'
a value less between commas | 0,0,0,0,1,0,0 | line 1: fewer values than announced
our quaternion | time_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0.5,0,1 | line 2: its quaternion
no height | time_s,x_m,y_m,qx,qy,qz,qw\n0,0,0,0,0,0,1 | no column z_m
a name less of TUM | timestamp,tx,ty,tz,qx,qy,qz\n0,0,0,0,0,0,0 | line 1: no column qw
1 % | 0 0 0 0 0 0 0 1.01 | line 1: its quaternion
two ones | 0 0 0 0 0 0 1 1 | line 1: its quaternion
a digit | 0 0 0 0 0 0 0.5 1.0 | line 1: its quaternion
three digits | 0 0 0 0 0 0 0.712 0.712 | line 1: its quaternion
a shrunk matrix | 0.9 0 0 0 0 0.9 0 0 0 0 0.9 0 | line 1: its matrix
other names | a,b\n1,2 | no column time_s
no pose | # nothing | no pose line
""")

TURN = np.array([[0, -1.0, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
ON_HEAD = np.diag([1.0, -1, -1, 1])  # half a turn about x
PLACED = np.eye(4)
PLACED[:3, 3] = 1, 2, 3
PITCHED = np.array([[-0.28, 0, 0.96, 1.5], [0, 1, 0, -2], [-0.96, 0, -0.28, 3], [0, 0, 0, 1]])
HIGHER = np.eye(4)
HIGHER[:3, 3] = 1.5, -2, 3.25
ROLLED = np.array([[1, 0, 0, 0], [0, 0.28, 0.96, 0], [0, -0.96, 0.28, 2], [0, 0, 0, 1]])
AHEAD = np.eye(4)
AHEAD[:3, 3] = -1.5, 0, 1e-3


def space(files, reads, **more) -> Format:
    """Return a format of `read_space_track`."""
    return Format(
        datasets.read_space_track, files, reads, **{"nothing": "no pose line", "atol": 1e-9} | more
    )


def rows(found) -> int:
    """Return how many poses were read, and the line of names."""
    return len(found.times) + 1


FORMATS = {
    "track": Format(
        datasets.read_track,
        {"own.csv": joined(CSV, "1,0,0,0.5", "2,-1.5,0,1e-3")},
        {"times": [1, 2], "poses": [[0, 0, 0.5], [-1.5, 0, 1e-3]], "covs": None},
        IN_PLANE,
        form="named",
        nothing="no pose line",
        count=rows,
        accounts=False,
    ),
    "track_covs": Format(
        datasets.read_track,
        {"own.csv": joined(COVS, "1,0,0,0.5,4,1,0.5,3,0.25,2")},
        {"covs": [[[4, 1, 0.5], [1, 3, 0.25], [0.5, 0.25, 2]]]},
        form="named",
        nothing="no pose line",
        count=rows,
        accounts=False,
    ),
    "tum": Format(
        datasets.read_track,
        {"a.tum": joined("1 0 0 0 0 0 0 1", "#", "2 1 0 0 0 0 0 1")},
        {"times": [1, 2], "poses": [[0, 0, 0], [1, 0, 0]], "report.others": {"#": 1}},
        TUM,
        words=plain,
    ),
    "tum_space": Format(
        partial(read_poses, found=Layout("TUM"), time_unit="s"),
        {"a.tum": joined("1 0 0 0 1 0 0 0", "#", "2 1 2 3 0 0 0 1")},
        {},
        words=plain,
        count=lambda found: found[-1].lines,
    ),
    "kitti_poses": Format(
        read_matrices,
        {"a.txt": joined("1 0 0 1 0 1 0 2 0 0 1 3", "#", "0 1 0 1 0 0 1 2 1 0 0 3")},
        {},
        words=plain,
    ),
    "space_tum": space(
        {"path.txt": joined("1 0 0 0 1 0 0 0", "2 1 2 3 0 0 0 1")},
        {"times": [1, 2], "poses": [ON_HEAD, PLACED]},
        damages=IN_SPACE,
        again=lambda to, found: datasets.write_tum(to, found.times, found.poses),
    ),
    "space_kitti": space(
        {"path.txt": joined("1 0 0 1 0 1 0 2 0 0 1 3", "0 -1 0 1 1 0 0 2 0 0 1 3")},
        {"times": None, "poses": [PLACED, TURN]},
        damages={
            "a row less": Damage("1 0 0 1 0 1 0 2 0 0 1 3\n1 0 0\n", "line 2: fewer values"),
        },
        again=lambda to, found: datasets.write_kitti(to, found.poses),
    ),
    "space_named": space(
        {
            "a.csv": joined(
                "time_s,x_m,y_m,z_m,qx,qy,qz,qw", "1,0,0,2,0.6,0,0,-0.8", "2,-1.5,0,1e-3,0,0,0,1"
            )
        },
        {"times": [1, 2], "poses": [ROLLED, AHEAD]},
        form="named",
        count=lambda found: found.report.lines + 1,
    ),
    "euroc": space(
        {
            "a.csv": joined(
                NAMED,
                "1403636580838555648,1.5,-2,3,0.6,0,0.8,0",
                "1403636580843555328,1.5,-2,3.25,1,0,0,0",
            )
        },
        {"poses": [PITCHED, HIGHER], "times": [1403636580.838555648, 1403636580.843555328]},
        form="named",
        atol=1e-6,
        count=lambda found: found.report.lines + 1,
    ),
}

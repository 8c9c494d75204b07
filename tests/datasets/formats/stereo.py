"""Pairs of cameras: KITTI's drives, GTSAM's features, and pairs of pictures with their truth."""

import numpy as np

from robot_perception.datasets import (
    CorruptImage,
    read_depth_pair,
    read_kitti,
    read_plane_pair,
    read_stereo_features,
)
from tests.datasets.formats.declared import Damage, Format, damages, joined, plain, without
from tests.datasets.writing import GREY, encoded, row

K = [[700.0, 0, 15, 0], [0, 690, 10, 0], [0, 0, 1, 0]]
LEFT, RIGHT = np.array(K), np.array(K)
RIGHT[0, 3] = -350.0
POSES = np.array([np.eye(4), np.eye(4), np.eye(4)])
POSES[1, :3, 3] = 0.1, -0.2, 1.5
POSES[2, :3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]

# KITTI --------------------------------------------------------------------------------------------

CALIB = [row(LEFT), row(RIGHT)]
NUMBERED = [row(T[:3], b"%d " % k) for k, T in enumerate(POSES)]


def kitti(calib, poses, sides) -> dict[str, bytes]:
    """Return the files of a drive of three pairs."""
    pictures = {
        f"{side}/{k:03}.png": encoded(np.roll(GREY, k, axis=0)) for side in sides for k in range(3)
    }
    return {"poses.txt": joined(*poses), "calib.txt": joined(*calib)} | pictures


OTHER = np.array(K)
OTHER[0, 3], OTHER[1, 1] = -350.0, 691.0
SKEW = [matrix + np.array([[0, 1.0, 0, 0], [0] * 4, [0] * 4]) for matrix in (LEFT, RIGHT)]
NO_PAIR = "not those of a rectified pair"
DRIVE = damages(
    {
        "another camera": (joined(row(LEFT), row(OTHER)), NO_PAIR),
        "a skew": (joined(row(SKEW[0]), row(SKEW[1])), NO_PAIR),
        "no baseline": (joined(row(LEFT), row(LEFT)), NO_PAIR),
        "left and right": (joined(row(RIGHT), row(LEFT)), NO_PAIR),
        "a matrix less": (joined(row(LEFT)), "must be two projection matrices, got 1"),
        "a number less": (joined(row(LEFT), row(RIGHT[:2])), ", line 2: fewer"),
        "no number": (
            joined(row(LEFT), row(RIGHT[:2]) + b" 0 0 1 x"),
            ", line 2: a value is not",
        ),
    },
    file="calib.txt",
) | damages(
    {
        "no rotation": (joined(row(2 * POSES[0, :3], b"0 ")), ", line 1: the pose is no rigid mot"),
        "a reflection": (joined(row(np.diag([1, 1, -1, 1])[:3], b"0 ")), ", line 1: .* rigid mot"),
        "a pose twice": (
            joined(*[row(POSES[0, :3], b"1 ")] * 2),
            ", line 2: names a picture a sec",
        ),
        "a word more": (joined(row(POSES[0], b"1 ")), ", line 1: more values"),
        "half a picture": (joined(row(POSES[0, :3], b"1.5 ")), ", line 1: an id or a count"),
        "a pose less": (
            joined(NUMBERED[0], NUMBERED[2]),
            "1 pictures have no pose, the first is 1",
        ),
    }
)
DRIVE["missing"] = Damage(None, "", error=FileNotFoundError)
FOUND = {
    "calibration.focal": (700.0, 690.0),
    "calibration.centre": (15.0, 10.0),
    "calibration.baseline": 0.5,
    "poses": POSES,
    "frames.2.0": np.roll(GREY, 2, axis=0),
    "frames.1.1": np.roll(GREY, 1, axis=0),
}


def drive(calib, poses, sides, cases=None) -> Format:
    """Return the format of a drive."""
    return Format(
        read_kitti,
        kitti(calib, poses, sides),
        FOUND,
        cases or {},
        opens=".",
        nothing="pictures have no pose",
        count=lambda found: len(found.poses),
        accounts=False,
    )


# GTSAM --------------------------------------------------------------------------------------------

CAMERA = b"700 690 0 15 10 0.5"
FACTORS = [b"1 7 115 65 79 1 1 7", b"2 7 110 60 80 1 1 7", b"3 9 65 15 10 0.5 0 7"]
BY_NUMBER = [row(T, b"%d " % k) for k, T in zip((3, 1, 2), POSES[[2, 0, 1]], strict=True)]
FEATURES = (
    damages(
        {
            "a skew": (b"700 690 1 15 10 0.5\n", "the camera has a skew"),
            "no baseline": (b"700 690 0 15 10 0\n", "baseline is not positive"),
            "a second camera": (joined(CAMERA, CAMERA), ", line 2: is a second camera"),
        },
        file="VO_calibration.txt",
    )
    | damages(
        {
            "a pose twice": (joined(*[row(POSES[0], b"1 ")] * 2), ", line 2: names a pose a seco"),
            "no rotation": (joined(row(2 * POSES[0], b"1 ")), ", line 1: the pose is no rigid"),
        },
        file="VO_camera_poses_large.txt",
    )
    | damages(
        {
            "a landmark twice": (
                joined(*[b"1 7 115 65 80 1 1 7"] * 2),
                ", line 2: sees a landmark a second time",
            ),
            "no disparity": (b"1 7 65 65 80 1 1 7\n", ", line 1: the disparity is not positive"),
            "half a landmark": (b"1 7.5 115 65 80 1 1 7\n", ", line 1: .* no whole number"),
            "a number less": (b"1 7 115 65 80 1 1\n", ", line 1: fewer values"),
        }
    )
    | {
        "a pose less": Damage(
            joined(FACTORS[0], b"5 9 65 15 10 0.5 0 7"),
            ": 1 observations are from poses that are not",
        )
    }
)

# Pairs with truth ---------------------------------------------------------------------------------

XML = b'<?xml version="1.0"?><s><H><rows>3</rows><data>\n 2 0 5\n 0 3. 6 0 0 1e0 </data></H></s>'
NO_MATRIX = "no matrix as OpenCV stores one"
PLANE = damages(
    {
        "a number less": (without(rb"3\. 6", b"3."), "nine finite numbers, got 8"),
        "NaN": (without(rb"3\.", b"nan"), "nine finite numbers"),
        "a word": (without(rb"3\.", b"x"), NO_MATRIX),
        "singular": (without(rb"3\.", b"0"), "the homography is singular"),
        "cut": (XML[:60], NO_MATRIX),
        "another XML": (b"<a></a>", NO_MATRIX),
    }
)
ALOE = {f"aloe{name}": encoded(GREY) for name in ("GT.png", "L.jpg", "R.jpg")}

FORMATS = {
    "kitti_snippet": drive(CALIB, NUMBERED, ("image_l", "image_r"), DRIVE),
    "kitti": drive(
        [row(LEFT, b"P0: "), row(RIGHT, b"P1: "), row(LEFT, b"P2: "), b"Tr: 1 2 3"],
        [row(T[:3]) for T in POSES],
        ("image_0", "image_1"),
    ),
    "features": Format(
        read_stereo_features,
        {
            "VO_stereo_factors_large.txt": joined(*FACTORS),
            "VO_calibration.txt": joined(CAMERA),
            "VO_camera_poses_large.txt": joined(*BY_NUMBER),
        },
        {name: FOUND[name] for name in FOUND if name.startswith("calib")}
        | {
            "poses": POSES,  # by their numbers
            "frames": [0, 1, 2],
            "landmarks": [7, 7, 9],
            "measurements.0": [115, 79, 65],  # left, row, right
        },
        FEATURES,
        opens=".",
        words=plain,
        count=lambda found: len(found.measurements),
        accounts=False,
    ),
    "plane_pair": Format(
        read_plane_pair,
        {
            "H1to3p.xml": XML,
            "graf1.png": encoded(GREY),
            "graf3.png": encoded(GREY[:10]),
        },
        {
            "homography": [[2, 0, 5], [0, 3, 6], [0, 0, 1]],
            "first": GREY,
            "second": GREY[:10],
        },
        PLANE,
        form="text",
        opens=".",
        empty=NO_MATRIX,
    ),
    "depth_pair": Format(
        read_depth_pair,
        ALOE,
        {"disparity": GREY, "disparity.dtype": float, "known": GREY > 0},
        {
            "another size": Damage(
                encoded(GREY[:10]), r": \(10, 30\), but aloeL\.jpg is \(20, 30\)"
            ),
            "missing": Damage(None, "", "aloeR.jpg", FileNotFoundError),
        },
        form="bytes",
        opens=".",
        error=CorruptImage,
        empty="the file is empty",
    ),
}

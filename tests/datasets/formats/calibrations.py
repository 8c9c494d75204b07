"""Calibrations: one pair of cameras in every form in which tools write it."""

import re

import numpy as np

from robot_perception.datasets import read_calibration
from tests.datasets.formats.declared import Format, damages

K = np.array([[300.0, 0, 32], [0, 290, 24], [0, 0, 1]])
BASELINE = 0.12


def projection(at=(0.0, 0, 0), K=K):
    """Return the matrix of a camera at a place."""
    return np.column_stack([K, -K @ at])


LEFT, RIGHT = projection(), projection((BASELINE, 0, 0))
FAR = projection((-0.06, 0.001, -0.004)), projection((BASELINE - 0.06, 0.0008, -0.0045))


def text(values):
    return " ".join(repr(float(v)) for v in np.ravel(values))


def lines(**matrices):
    return "".join(f"{name}: {text(matrix)}\n" for name, matrix in matrices.items())


def opencv(**matrices):
    parts = []
    for name, matrix in matrices.items():
        rows, columns = matrix.shape
        data = text(matrix).replace(" ", ", ")
        parts.append(f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n")
        parts.append(f"   data: [ {data} ]\n")
    return "%YAML:1.0\n---\n" + "".join(parts)


def xml(**matrices):
    parts = (
        f'<{name} type_id="opencv-matrix"><rows>3</rows><cols>4</cols><dt>d</dt>\n'
        f"<data>\n {text(matrix)}</data></{name}>"
        for name, matrix in matrices.items()
    )
    return f'<?xml version="1.0"?>\n<opencv_storage>{"".join(parts)}</opencv_storage>'


def ros(matrix, name):
    data = text(matrix).replace(" ", ", ")
    return (
        f"image_width: 64\nimage_height: 48\ncamera_name: {name}\ndistortion_model: plumb_bob\n"
        f"projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{data}]\n"
    )


def camchain(T="- [1.0, 0.0, 0.0, -0.12]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]"):
    camera = "  camera_model: pinhole\n  intrinsics: [300.0, 290.0, 32.0, 24.0]\n"
    bent = "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n"
    return f"cam0:\n{camera}{bent}cam1:\n  T_cn_cnm1:\n  {T}\n{camera}{bent}"


RAW = lines(
    calib_time=[], corner_dist=[0.1], S_00=[64, 48], K_00=K, P_rect_00=LEFT, K_01=K, P_rect_01=RIGHT
).replace("calib_time: ", "calib_time: 09-Jan-2012 13:57:47")
FORMS = {
    "benchmark": {"calib.txt": lines(P0=LEFT, P1=RIGHT, P2=FAR[0], P3=FAR[1], Tr=LEFT)},
    "another_order": {"calib.txt": lines(P1=RIGHT, P3=FAR[1], P0=LEFT, P2=FAR[0])},
    "two": {"calib.txt": lines(P3=RIGHT, P2=LEFT)},
    "without_colons": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(":", "")},
    "colons_apart": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(":", " :")},
    "colons_alone": {"calib.txt": lines(P1=RIGHT, P0=LEFT).replace(": ", ":")},
    "sides": {"calib.txt": lines(right=RIGHT, left=LEFT)},
    "sides_of_P": {"calib.txt": lines(P_right=RIGHT, P_left=LEFT)},
    "raw": {"calib_cam_to_cam.txt": RAW},
    "bare": {"calib.txt": f"{text(LEFT)}\n{text(RIGHT)}\n"},
    "unknown": {"calib.txt": lines(alpha=LEFT, beta=RIGHT)},
    "OpenCV": {"extrinsics.yml": opencv(R=K, P2=RIGHT, P1=LEFT, Q=np.eye(4))},
    "OpenCV_XML": {"extrinsics.xml": xml(P2=RIGHT, P1=LEFT)},
    "ORB_SLAM": {"car.yaml": opencv(**{"RIGHT.P": RIGHT, "LEFT.P": LEFT, "LEFT.K": K})},
    "ROS": {"left.yaml": ros(LEFT, "left"), "right.yaml": ros(RIGHT, "right")},
    "Kalibr": {"camchain.yaml": camchain()},
}
BY_PLACE = {"benchmark", "another_order", "bare", "unknown"}
"""In which the order of the matrices tells the sides, and a remark says so."""
TURNED = "- [0, -1, 0, 0]\n  - [1, 0, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]"
BENT = camchain().replace("[0.0, 0.0, 0.0, 0.0]", "[0.1, 0.0, 0.0, 0.0]")
EUROC = "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0]\nintrinsics: [1, 2, 3, 4]\n"
NEAR = np.zeros((3, 4))
NEAR[0, 0] = NEAR[1, 1] = NEAR[0, 2] = 1.0
FAULTS = {
    "the left one twice": (LEFT, LEFT, "have no baseline"),
    "the right one twice": (RIGHT, RIGHT, "have no baseline"),
    "swapped": (RIGHT, LEFT, "are swapped: the right camera lies 0.12 m left of the left one"),
    "above each other": (LEFT, projection((0.12, 0.01, 0)), "are not side by side: .* by 0.01 m"),
    "one behind the other": (LEFT, projection((0, 0, 0.1)), "are not side by side"),
    "other focal lengths": (LEFT, RIGHT + 0.01 * NEAR, "differ by 0.01 px"),
    "a skew": (LEFT + np.eye(3, 4, 1), RIGHT + np.eye(3, 4, 1), "have a skew of 1 px"),
    "zero": (0 * LEFT, 0 * RIGHT, "have a focal length of 0 px, as of a camera that is not cal"),
    "another last row": (LEFT * [[1], [1], [2]], RIGHT * [[1], [1], [2]], "have a last row"),
}
DAMAGES = {
    "benchmark": {
        name: (lines(P0=one, P1=other), f"not those of a rectified pair: P0 and P1 {fault}")
        for name, (one, other, fault) in FAULTS.items()
    }
    | {
        "no matrix": ("# nothing\n", "two projection matrices, got 0; it is text"),
        "one matrix": (lines(P0=LEFT), r"two projection matrices, got 1 \(P0\)"),
        "a name twice": (lines(P0=LEFT) * 2, ", line 2: names P0 a second time"),
        "a number less": (lines(P0=LEFT, P1=RIGHT[:2]), ", line 2: fewer values"),
        "no number": (lines(P0=LEFT).replace("0.0", "x"), ", line 1: .* number: '30x'"),
        "ROS's text": ("# oST version 5.0\n\n[image]\n\nwidth\n64\n", ", line 3: a section in"),
    },
    "OpenCV": {
        "cameras": (opencv(M1=K, M2=K), "YAML of OpenCV with M1, M2; wanted are"),
        "a list": ("- 1\n", "YAML without names; wanted"),
        "no YAML": ("a: [1,\nb: }\n", ", line 2: no YAML, or a damaged one"),
        "EuRoC": (EUROC, "YAML, sensor.yaml of EuRoC; wanted"),
        "no number": (
            opencv(P1=LEFT, P2=RIGHT).replace("300.0", "x"),
            "a value of P1 is not a number",
        ),
        "a number less": (
            opencv(P1=LEFT, P2=RIGHT).replace("300.0, ", ""),
            "P1 must be 12 finite numbers",
        ),
    },
    "OpenCV_XML": {"no XML": ("<a><b></a>", "no XML, or a damaged one")},
    "ROS": {
        "without P": (
            "image_width: 64\ncamera_name: left\n",
            "YAML, camera_info of ROS; wanted are the projection matrices",
        ),
    },
    "Kalibr": {
        "a lens": (BENT, "camchain of Kalibr, whose cam0 is pinhole with dist"),
        "turned": (camchain(TURNED), "whose cam1 is turned against cam0, not rectif"),
        "a fisheye": (
            camchain().replace("pinhole", "omni"),
            "whose cam0 is omni with distortion",
        ),
        "one camera": (
            camchain().split("cam1")[0],
            r"two projection matrices, got 1 \(cam0\); it is YAML, camchain of Kalibr; wanted",
        ),
    },
}
SAID = "taken for the left camera"

FORMATS = {
    f"calibration_{name}": Format(
        read_calibration,
        files,
        {
            "focal": (300.0, 290.0),
            "centre": (32.0, 24.0),
            "baseline": np.array(BASELINE),
            "report.remarks": re.compile(SAID if name in BY_PLACE else f"^(?!.*{SAID})"),
        },
        damages(DAMAGES.get(name, {})),
        form="rows" if next(iter(files)).endswith(".txt") else "text",
        nothing="two projection matrices, got 0",
        count=lambda found: found.report.kept["projection"],
        accounts=False,
        empty="",
        atol=1e-13,
    )
    for name, files in FORMS.items()
}

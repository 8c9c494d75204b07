"""Walls from scans: python walls.py carmen|graph LOG OUT, or array RANGES POSES OUT"""

import sys

import numpy as np

from robot_perception.datasets import read_carmen_log, read_graph_log, read_ranges, read_track
from robot_perception.walls import Extraction, Gate, RangeNoise, build_map

FIELD = np.deg2rad([-90.0, 90.0])  # directions of the first and last beam of an array
MAX_RANGE = 80.0  # a reading of an array from here on means "nothing there", m
WALLS = Extraction(RangeNoise(range_sigma=0.02), tolerance=0.1)  # of your laser; how straight, m
GATE = Gate(roughness=0.05, roughness_angle=np.deg2rad(2.0))  # how far a true wall may stray
POSES = np.diag([0.03, 0.03, np.deg2rad(0.4)]) ** 2  # covariance of a pose, m and rad
LEAST_SCANS = 4  # a wall seen in fewer is left out


def main(kind: str, *files: str) -> None:
    if kind == "array":
        ranges, poses = read_ranges(files[0], max_range=MAX_RANGE), read_track(files[1]).poses
        angles = np.linspace(*FIELD, ranges.shape[1])
    else:
        log = (read_carmen_log if kind == "carmen" else read_graph_log)(files[0])
        ranges, angles, poses = log.ranges, log.angles, log.poses
    found, report = build_map(ranges, angles, poses, WALLS, GATE, pose_cov=POSES)
    found = found.seen_in(LEAST_SCANS)
    rows = np.column_stack([found.ends.reshape(-1, 4), found.scans])
    np.savetxt(files[-1], rows, "%.6g", ",", header="x1_m,y1_m,x2_m,y2_m,scans", comments="")
    print(f"scans: {len(ranges)}, walls: {len(found)} of {found.lengths.sum():.1f} m in all")
    print(f"readings: {report.readings}, from nothing: {report.no_return}")
    print(f"void: {report.not_a_number + report.not_positive}")


if __name__ == "__main__":
    try:
        files = {"carmen": 2, "graph": 2, "array": 3}.get("".join(sys.argv[1:2]))
        sys.exit(main(*sys.argv[1:]) if len(sys.argv) - 2 == files else __doc__)
    except (OSError, ValueError) as error:
        sys.exit(str(error))

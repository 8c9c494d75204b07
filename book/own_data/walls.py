"""Walls from scans: python walls.py carmen|graph|bag LOG OUT, or array RANGES POSES OUT"""

import numpy as np

from robot_perception import datasets
from robot_perception.extras import needing
from robot_perception.scripts import Clocks, Recording, Results, script, tell
from robot_perception.walls import Extraction, Gate, RangeNoise, ScanReport, WallMapper

with needing():
    import click

FIELD = np.deg2rad([-90.0, 90.0])  # directions of the first and last beam of an array
MAX_RANGE = 80.0  # a reading of an array from here on means "nothing there", m
WALLS = Extraction(RangeNoise(range_sigma=0.02), tolerance=0.1)  # of your laser; how straight, m
GATE = Gate(roughness=0.05, roughness_angle=np.deg2rad(2.0))  # how far a true wall may stray
POSES = np.diag([0.03, 0.03, np.deg2rad(0.4)]) ** 2  # covariance of a pose, m and rad
LEAST_SCANS = 4  # a wall seen in fewer is left out


@script
@click.argument("kind", type=click.Choice(["carmen", "graph", "bag", "array"]))
@click.argument("files", type=Recording(), nargs=-1, required=True)
@click.argument("out", type=Results())
def main(kind, files, out, topic, time_unit, force):
    """Walls from scans: carmen LOG OUT, graph LOG OUT, bag LOG OUT, or array RANGES POSES OUT."""
    if len(files) != (2 if kind == "array" else 1):
        raise ValueError("array takes RANGES and POSES, the others one LOG; then comes OUT")
    if kind == "array":
        ranges = datasets.read_ranges(files[0], max_range=MAX_RANGE)
        angles = np.linspace(*FIELD, ranges.shape[1])
        clock = Clocks(time_unit, files[1])
        poses = tell(clock.read(datasets.read_track, files[1], topic=topic)).poses
    else:
        if kind == "bag":
            log = tell(datasets.read_bag_log(files[0], topic))
        else:
            read = datasets.read_carmen_log if kind == "carmen" else datasets.read_graph_log
            log = read(files[0], timed=False)  # a map needs no times
        ranges, angles, poses = log.ranges, log.angles, log.poses
    if len(ranges) != len(poses):
        counts = f"{len(ranges)} and {len(poses)}"
        raise ValueError(f"ranges and poses must have a pose for each scan, got {counts}")
    mapper = WallMapper(angles, WALLS, GATE, POSES)
    state, report = mapper.start(), ScanReport(0, 0, 0, 0, 0, 0, 0)
    for scan, pose in zip(ranges, poses, strict=True):
        state, info = mapper.step(state, scan, pose)
        report += info.report
    found = state.seen_in(LEAST_SCANS)
    columns = dict(zip(("x1_m", "y1_m", "x2_m", "y2_m"), found.ends.reshape(-1, 4).T, strict=True))
    datasets.write_columns(out[""], columns | {"scans": found.scans}, overwrite=force)
    print(f"scans: {len(ranges)}, walls: {len(found)} of {found.lengths.sum():.1f} m in all")
    print(f"readings: {report.readings}, from nothing: {report.no_return}")
    print(f"void: {report.not_a_number + report.not_positive}")


if __name__ == "__main__":
    main()

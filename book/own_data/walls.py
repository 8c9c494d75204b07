"""Walls from scans: python walls.py carmen|graph|bag LOG OUT, or array RANGES POSES OUT"""

import numpy as np

from robot_perception import datasets
from robot_perception.scripts import Clocks, Kinds, Recording, Results, installed, script, tell
from robot_perception.walls import Extraction, Gate, RangeNoise, ScanReport, WallMapper

with installed():
    import click
    from tqdm import tqdm

ARRAY = -np.pi / 2, np.pi / 2  # directions of an array's first and last beam without --field, rad
MAX_RANGE = 80.0  # a reading of an array from here on means "nothing there", m
WALLS = Extraction(RangeNoise(range_sigma=0.02), tolerance=0.1)  # of your laser; how straight, m
GATE = Gate(roughness=0.05, roughness_angle=np.deg2rad(2.0))  # how far a true wall may stray
POSES = np.diag([0.03, 0.03, np.deg2rad(0.4)]) ** 2  # covariance of a pose, m and rad
LEAST_SCANS = 4  # a wall seen in fewer is left out
KINDS = {
    "carmen": "FILES is a CARMEN log: lines FLASER n r1 ... rn x y heading ...",
    "graph": "FILES is a graph log: lines VERTEX2 id x y heading, each followed by ROBOTLASER1 ...",
    "bag": "FILES is a ROS bag with scans and odometry.",
    "array": "FILES are RANGES (.npy, or CSV with a line for each scan, m) and POSES (CSV with"
    " columns time_s,x_m,y_m,heading_rad, or TUM).",
}
RESULTS = {
    ".csv": "The walls: x1_m,y1_m,x2_m,y2_m,scans.",
    ".svg": "The map with the way, for a browser.",
}


@script
@click.argument("kind", type=Kinds(KINDS))
@click.argument("files", type=Recording("What is read, see above."), nargs=-1, required=True)
@click.argument("out", type=Results(RESULTS))
def main(kind, files, out, field, topic, time_unit, force):
    """Walls from scans: carmen LOG OUT, graph LOG OUT, bag LOG OUT, or array RANGES POSES OUT."""
    if len(files) != (2 if kind == "array" else 1):
        raise ValueError("array takes RANGES and POSES, the others one LOG; then comes OUT")
    if kind == "array":
        ranges = datasets.read_ranges(files[0], max_range=MAX_RANGE)
        angles, clock = np.linspace(*(field or ARRAY), ranges.shape[1]), Clocks(time_unit, files[1])
        poses = tell(clock.read(datasets.read_track, files[1], topic=topic)).poses
    else:
        if kind == "bag":
            log = tell(datasets.read_bag_log(files[0], topic))
        elif kind == "carmen":  # a map needs no times
            log = datasets.read_carmen_log(files[0], field_of_view=field, timed=False)
        else:
            log = datasets.read_graph_log(files[0], timed=False)
        ranges, angles, poses = log.ranges, log.angles, log.poses
    if len(ranges) != len(poses):
        counts = f"{len(ranges)} and {len(poses)}"
        raise ValueError(f"ranges and poses must have a pose for each scan, got {counts}")
    mapper = WallMapper(angles, WALLS, GATE, POSES)
    state, report = mapper.start(), ScanReport(0, 0, 0, 0, 0, 0, 0)
    for scan, pose in zip(tqdm(ranges, "scans"), poses, strict=True):
        state, info = mapper.step(state, scan, pose)
        report += info.report
    found = state.seen_in(LEAST_SCANS)
    columns = dict(zip(("x1_m", "y1_m", "x2_m", "y2_m"), found.ends.reshape(-1, 4).T, strict=True))
    datasets.write_columns(out[".csv"], columns | {"scans": found.scans}, overwrite=force)
    datasets.write_plan(out[".svg"], walls=found.ends, way=poses[:, :2], overwrite=force)
    print(f"scans: {len(ranges)}, walls: {len(found)} of {found.lengths.sum():.1f} m in all")
    print(f"readings: {report.readings}, from nothing: {report.no_return}")
    print(f"void: {report.not_a_number + report.not_positive}")


if __name__ == "__main__":
    main()

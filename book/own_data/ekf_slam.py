"""EKF-SLAM on a robot's log: python ekf_slam.py polar|points COMMANDS OBSERVATIONS OUT"""

from itertools import repeat

import numpy as np

from robot_perception.datasets import read_commands, read_landmarks, write_columns, write_plan
from robot_perception.scripts import Clocks, Kinds, Recording, Results, installed, script, tell
from robot_perception.slam import planar
from robot_perception.streams import merge

with installed():
    import click
    from tqdm import tqdm

DELAY = 0.0  # from a command to its effect, s
WHEELS = np.array([0.05, 0.05]) ** 2  # variance per second of distance, m²/s, and turn, rad²/s
SENSORS = {  # what is in an observation beside its time and landmark, and its noise
    "polar": ({"range_m": 200, "bearing_rad": 7}, planar.RangeBearing(np.diag([0.1, 0.03]) ** 2)),
    "points": ({"x_m": 200, "y_m": 200}, planar.CartesianSensor(np.diag([0.1, 0.1]) ** 2)),
}
GATE = 0.99  # share of right observations that is let in; misread names stay out
KINDS = {
    "polar": "OBSERVATIONS has columns time_s,landmark,range_m,bearing_rad.",
    "points": "OBSERVATIONS has columns time_s,landmark,x_m,y_m.",
}
COMMANDS = "CSV with columns time_s,speed_m_s,turn_rate_rad_s, or a ROS bag with odometry."
OBSERVATIONS = "CSV as above; without landmark, or where it is -1, nobody knows which was seen."
RESULTS = {
    ".csv": "The poses with their covariances; judge.py reads it.",
    ".tum": "The poses as other tools read them.",
    "_map.csv": "The landmarks: landmark,x_m,y_m.",
    ".svg": "The map with the way, for a browser.",
}
START = planar.MapBelief.start(np.zeros(3), np.diag([0.01, 0.01, 0.005]) ** 2)  # m, m, rad


@script
@click.argument("kind", type=Kinds(KINDS))
@click.argument("commands", type=Recording(COMMANDS))
@click.argument("observations", type=Recording(OBSERVATIONS))
@click.argument("out", type=Results(RESULTS))
def main(kind, commands, observations, out, topic, time_unit, force):
    """EKF-SLAM on a robot's log: its commands and what it saw."""
    (measured, sensor), clocks = SENSORS[kind], Clocks(time_unit, commands, observations)
    told = tell(clocks.read(read_commands, commands, topic=topic))
    table = tell(clocks.read(read_landmarks, observations, measured))
    clocks.check((commands, told.times), (observations, table.times))
    ids, values = table.landmarks, table.values  # -1: nobody knows which
    merged = merge(told.times, told.velocities, table.times, delay=DELAY)
    motions = map(planar.Odometry, *planar.compound(merged.held, WHEELS))
    seen = [planar.Observations(ids[rows], values[rows]) for rows in merged.rows]
    steps = map(planar.Step, motions, seen, repeat(()), merged.times[1:])
    found = planar.Association("known" if ids.min() >= 0 else "gated", level=GATE)
    steps = tqdm(steps, "steps", len(seen))
    run = planar.run_filter(START, steps, planar.Settings(sensor, association=found))
    run.to_csv(out[".csv"], overwrite=force)
    run.to_tum(out[".tum"], overwrite=force)
    marks, names = run.belief.landmarks, run.belief.ids
    columns = {"landmark": names, "x_m": marks[:, 0], "y_m": marks[:, 1]}
    write_columns(out["_map.csv"], columns, overwrite=force)
    way = {"way": run.poses[:, :2], "marks": marks, "names": list(map(str, names))}
    write_plan(out[".svg"], **way, overwrite=force)
    print(f"steps: {len(seen)}, not between commands: {merged.early + merged.late}\n{run.counts}")


if __name__ == "__main__":
    main()

"""EKF-SLAM on a robot's log: python ekf_slam.py polar|points COMMANDS OBSERVATIONS OUT"""

from itertools import repeat

import numpy as np

from robot_perception.datasets import read_columns, read_commands, write_columns
from robot_perception.extras import needing
from robot_perception.scripts import Clocks, Recording, Results, script, tell
from robot_perception.slam import planar
from robot_perception.streams import merge

with needing():
    import click

DELAY = 0.0  # from a command to its effect, s
WHEELS = np.array([0.05, 0.05]) ** 2  # variance per second of distance, m²/s, and turn, rad²/s
NAMED = {"time_s": np.inf, "landmark": 1e9}  # a landmark is optional
SENSORS = {  # what else is in an observation, and its noise
    "polar": ({"range_m": 200, "bearing_rad": 7}, planar.RangeBearing(np.diag([0.1, 0.03]) ** 2)),
    "points": ({"x_m": 200, "y_m": 200}, planar.CartesianSensor(np.diag([0.1, 0.1]) ** 2)),
}
GATE = 0.99  # share of right observations that is let in; misread names stay out
START = planar.MapBelief.start(np.zeros(3), np.diag([0.01, 0.01, 0.005]) ** 2)  # m, m, rad


@script
@click.argument("kind", type=click.Choice(list(SENSORS)))
@click.argument("commands", type=Recording())
@click.argument("observations", type=Recording())
@click.argument("out", type=Results(".csv", ".tum", "_map.csv"))
def main(kind, commands, observations, out, topic, time_unit, force):
    """EKF-SLAM on a robot's log: its commands and what it saw."""
    (measured, sensor), clocks = SENSORS[kind], Clocks(time_unit, commands, observations)
    told, name = tell(clocks.read(read_commands, commands, topic=topic)), ["landmark"]
    limits = NAMED | measured
    seen = clocks.read(read_columns, observations, limits, optional=name, integers=name)
    clocks.check((commands, told.times), (observations, seen["time_s"]))
    ids = seen.get("landmark", np.full(len(seen["time_s"]), -1))  # -1: nobody knows which
    values = np.column_stack([seen[column] for column in measured])
    merged = merge(told.times, told.velocities, seen["time_s"], delay=DELAY)
    motions = map(planar.Odometry, *planar.compound(merged.held, WHEELS))
    seen = [planar.Observations(ids[rows], values[rows]) for rows in merged.rows]
    steps = map(planar.Step, motions, seen, repeat(()), merged.times[1:])
    found = planar.Association("known" if ids.min() >= 0 else "gated", level=GATE)
    run = planar.run_filter(START, steps, planar.Settings(sensor, association=found))
    run.to_csv(out[".csv"], overwrite=force)
    run.to_tum(out[".tum"], overwrite=force)
    (x, y), names = run.belief.landmarks.T, run.belief.ids
    write_columns(out["_map.csv"], {"landmark": names, "x_m": x, "y_m": y}, overwrite=force)
    print(f"steps: {len(seen)}, not between commands: {merged.early + merged.late}\n{run.counts}")


if __name__ == "__main__":
    main()

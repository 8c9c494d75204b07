"""People round a robot: python people.py detections|legs FILE OUT [POSES]"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robot_perception import datasets
from robot_perception.extras import needing
from robot_perception.geometry import se2
from robot_perception.people import PeopleTracker, legs
from robot_perception.people.aggregation import AggregationRules, SensorRules
from robot_perception.people.detections import Detections, polar
from robot_perception.people.trajectories import StaticRules
from robot_perception.scripts import Clocks, Recording, Results, script, tell
from robot_perception.streams import ticks

with needing():
    import click
    import cv2
    from tqdm import tqdm

SENSORS = {  # any name may join: how much it is believed, and when its silence ends a belief, s
    "laser": SensorRules(alpha=0.3, patience=3.0, reach=6.0),
    "sonar": SensorRules(alpha=0.1, patience=5.0, reach=4.0),
    "camera": SensorRules(alpha=0.15, patience=4.0, alpha_behind=0.3),
    "microphone": SensorRules(alpha=0.3, patience=4.0, silence=False),
}
PEOPLE = AggregationRules(sensors=SENSORS, walk=0.5, person=0.5)  # m in a second; least weight
STATIC = StaticRules(spread=0.4, longest=20.0)  # who stays within 0.4 m for 20 s may be furniture
LEGS = legs.LegRules()  # their widths and distances in a scan
GAP = 0.5  # longest gap of the robot's poses that is bridged, s
DISTANCE = {"distance_m": 200, "distance_sigma_m": 20}  # largest number; -1: it saw nobody
DIRECTION = {"direction_rad": 7, "direction_sigma_rad": 7}
RATE, SIDE, REACH, TRAIL = 10.0, 480, 8.0, 5.0  # of the film: pictures in a second, px, m, s

Reading = tuple[Detections, np.ndarray]  # and the points (n, 2) of a scan, m


def from_table(file: Path, clocks: Clocks) -> list[Reading]:
    """Readings of any sensors in the order of their times."""
    most, words = {"time_s": np.inf} | DISTANCE | DIRECTION, ["sensor"]
    times, *numbers, names = clocks.read(datasets.read_columns, file, most, texts=words).values()
    if unknown := sorted({*names} - {*SENSORS}):
        raise ValueError(f"{file}: SENSORS has no rules for {', '.join(unknown)}")
    found = []
    for time, name in sorted({*zip(times.tolist(), names.tolist(), strict=True)}):
        rows = (times == time) & (names == name) & (numbers[0] >= 0)
        r, r_sigma, phi, phi_sigma = (column[rows] for column in numbers)
        found.append((Detections(time, name, polar(r, phi, r_sigma, phi_sigma)), np.zeros((0, 2))))
    return found


def from_laser(file: Path, topic: tuple[str, ...], clocks: Clocks, way) -> tuple:
    """Scans at the height of legs, and the poses that their log knows, if it does."""
    read = datasets.read_leg_scans if file.suffix == ".npz" else datasets.read_carmen_log
    if datasets.is_bag(file):
        log = tell(datasets.read_bag_log(file, topic, still=True, way=way))
    else:
        log = tell(clocks.read(read, file))
    found, ahead = [], np.stack([np.cos(log.angles), np.sin(log.angles)], axis=-1)
    for time, ranges in zip(log.times.tolist(), tqdm(log.ranges, "scans"), strict=True):
        there, seen = np.isfinite(ranges), legs.detect(ranges, log.angles, LEGS)
        found.append((Detections(time, "laser", seen), ranges[there, None] * ahead[there]))
    return found, getattr(log, "poses", None)


def film(shown: list[tuple], times: np.ndarray) -> Iterator[np.ndarray]:
    """From above, x to the right: scans grey, detections orange, people with their trails."""
    middle = np.mean([pose[:2] for pose, *_ in shown], axis=0)
    trails, before = {}, 0

    def pixels(points: np.ndarray) -> np.ndarray:
        return (SIDE / 2 * (1 + (points - middle) * [1, -1] / REACH)).round().astype(np.int32)

    for time in ticks(times, rate=RATE, longest_gap=TRAIL):  # none in a pause
        picture = np.full((SIDE, SIDE, 3), 255, np.uint8)
        now = int(np.searchsorted(times, time, side="right"))
        for pose, scan, seen, *_ in shown[min(before, now - 1) : now]:
            for at in pixels(se2.act(pose, scan)).tolist():
                cv2.circle(picture, at, 1, (150, 150, 150), -1)
            for at in pixels(se2.act(pose, seen)).tolist():
                cv2.circle(picture, at, 5, (230, 120, 0), 1)
        pose, _, _, numbers, places, _ = shown[now - 1]
        for number, at in zip(numbers.tolist(), pixels(places), strict=True):
            trails[number] = [*trails.get(number, []), at][-round(TRAIL * RATE) :]
            cv2.polylines(picture, [np.array(trails[number])], False, (0, 90, 200), 1)
            cv2.putText(picture, str(number), (at[0] + 6, at[1] - 6), 0, 0.5, (0, 90, 200))
            cv2.circle(picture, at, 5, (0, 90, 200), -1)
        robot = pixels(se2.act(pose, np.array([[0.3, 0], [-0.2, 0.2], [-0.2, -0.2]])))
        cv2.polylines(picture, [robot], True, (0, 0, 0), 2)
        before = now
        yield picture


@script
@click.argument("kind", type=click.Choice(["detections", "legs"]))
@click.argument("file", type=Recording())
@click.argument("out", type=Results(".csv", "_mot.txt", ".mp4"))
@click.argument("way", type=Recording(), required=False)
def main(kind, file, out, way, topic, time_unit, force):
    """People round a robot, by detections of any sensors or by the legs in laser scans."""
    files = [file, way] if way else [file]
    clocks, topics = Clocks(time_unit, *files), datasets.share_topics(topic, *files)
    track = tell(clocks.read(datasets.read_track, way, topic=topics[1])) if way else None
    if kind == "legs":
        readings, poses = from_laser(file, topics[0], clocks, track)
    else:
        readings, poses = from_table(file, clocks), None
    times = np.array([seen.time for seen, _ in readings])
    covered = np.ones(len(times), dtype=bool)
    if way and not datasets.is_bag(file):
        clocks.check((file, times), (way, track.times))
        poses, covered = track.at(times, longest_gap=GAP)
    elif poses is None:
        print("no POSES: the robot is taken to stand still")
        poses = np.zeros((len(times), 3))
    if not covered.any():
        raise ValueError(f"{way}: no pose at the time of a reading")
    tracker, shown = PeopleTracker(PEOPLE, STATIC), []
    state, used = tracker.start(poses[covered][0]), np.flatnonzero(covered)
    for k in tqdm(used, "readings"):
        seen, scan = readings[k]
        state, info = tracker.step(state, seen, poses[k])
        sure = state.hypotheses.weight > PEOPLE.person
        people, (r, phi) = state.hypotheses.select(sure), seen.positions.mean.T
        points = np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)
        marks = np.stack([people.weight, info.static[sure]], axis=-1)
        places = se2.act(poses[k], people.points)
        shown.append((poses[k], scan, points, people.identity + 1, places, marks))
    numbers, places, marks = map(np.concatenate, list(zip(*shown, strict=True))[3:])
    rows = np.repeat(used, [len(one[3]) for one in shown])
    (x, y), (weight, static) = places.T, marks.T
    columns = {"time_s": times[rows], "person": numbers, "x_m": x, "y_m": y}
    columns |= {"weight": weight, "static": static}
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    flat = np.stack([x, y, 0 * x], axis=-1)
    how = {"points": flat, "confidences": weight, "overwrite": force}
    datasets.write_mot(out["_mot.txt"], rows + 1, numbers, **how)
    pictures = tqdm(film(shown, times[used]), "film")
    datasets.write_video(out[".mp4"], pictures, rate=RATE, overwrite=force)
    print(f"readings: {len(times)}, without a pose: {len(times) - len(used)}")
    print(f"detections: {sum(len(seen) for seen, _ in readings)}, people: {len({*numbers})}")
    print(f"at once: {max(len(one[3]) for one in shown)}, static: {len({*numbers[static > 0]})}")


if __name__ == "__main__":
    main()

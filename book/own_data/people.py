"""People round a robot: python people.py detections|legs FILE OUT [POSES]"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from robot_perception import datasets
from robot_perception.geometry import se2
from robot_perception.geometry.scan_matching import follow_scans
from robot_perception.people import PeopleTracker, legs
from robot_perception.people.aggregation import AggregationRules, SensorRules
from robot_perception.people.detections import Detections, polar
from robot_perception.people.trajectories import StaticRules
from robot_perception.people.walking import WalkRules, Walks, watch_walks
from robot_perception.scripts import Clocks, Kinds, Recording, Results, installed, script, tell
from robot_perception.streams import ticks

with installed():
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
WALK = WalkRules()  # whose legs have not walked is a chair; None: everybody counts
STILL = 0.02  # m by which most readings change from scan to scan if the scanner stands still
GAP = 0.5  # longest gap of the robot's poses that is bridged, s
KINDS = {
    "detections": "FILE is CSV with columns time_s,sensor,distance_m,direction_rad,"
    "distance_sigma_m,direction_sigma_rad; a distance of -1 says that the sensor saw nobody.",
    "legs": "FILE has scans at the height of legs: a CARMEN log, a NumPy archive or a ROS bag.",
}
WAY = "The robot's trajectory, if it drives: CSV with columns time_s,x_m,y_m,heading_rad, or TUM."
RESULTS = {
    ".csv": "Who was where at each reading: time_s,person,x_m,y_m,weight,static,walked_m.",
    "_mot.txt": "The same as the MOT challenge has it; frames are readings.",
    ".mp4": "All seen from above.",
}
RATE, SIDE, REACH, TRAIL = 10.0, 480, 8.0, 5.0  # of the film: pictures in a second, px, m, s

Reading = tuple[Detections, np.ndarray]  # and the points (n, 2) of a scan, m


def from_table(file: Path, clocks: Clocks) -> list[Reading]:
    """Readings of any sensors in the order of their times."""
    table = tell(clocks.read(datasets.read_detections, file, SENSORS))
    times, names, found = table.times, table.sensors, []
    for time, name in sorted({*zip(times.tolist(), names.tolist(), strict=True)}):
        r, phi, *sigmas = table.values[(times == time) & (names == name) & table.seen].T
        found.append((Detections(time, name, polar(r, phi, *sigmas)), np.zeros((0, 2))))
    return found


def from_laser(file: Path, topic, field, clocks: Clocks, way: datasets.Track | None) -> tuple:
    """Scans at the height of legs, and poses if their log knows them, or they do if all alone."""
    if datasets.is_bag(file):
        log = tell(datasets.read_bag_log(file, topic, still=True, way=way))
    elif file.suffix == ".npz":
        log = tell(clocks.read(datasets.read_leg_scans, file))
    else:
        log = tell(clocks.read(datasets.read_carmen_log, file, field_of_view=field))
    found, ahead = [], np.stack([np.cos(log.angles), np.sin(log.angles)], axis=-1)
    for time, ranges in zip(log.times.tolist(), tqdm(log.ranges, "scans"), strict=True):
        there, seen = np.isfinite(ranges), legs.detect(ranges, log.angles, LEGS)
        found.append((Detections(time, "laser", seen), ranges[there, None] * ahead[there]))
    poses = getattr(log, "poses", None)
    if way is None and (poses is None or not poses.any()):
        by_scans = moved(found, log.ranges)
        poses = poses if by_scans is None else by_scans
    return found, poses


def moved(readings: list[Reading], ranges: np.ndarray) -> np.ndarray | None:
    """The poses of a scanner of which nobody tells them: by its scans, unless it stands still."""
    with np.errstate(invalid="ignore"):  # where nothing came back twice
        steps = np.abs(np.diff(ranges, axis=0))
    if not (steps := steps[np.isfinite(steps)]).size or np.median(steps) < STILL:
        return None
    scans = (scan for _, scan in tqdm(readings, "motion"))
    poses = follow_scans(scans)
    way = np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()
    print(f"the scanner moves, by its scans: {way:.1f} m; POSES would tell it better")
    return poses


def walkers(shown: list[tuple], distance: float) -> list[tuple]:
    """What is shown, with those alone who walk so far at some time."""
    numbers, walked = (np.concatenate([one[k] for one in shown]) for k in (3, 5))
    who = np.unique(numbers[walked[:, 2] >= distance])
    kept = [np.isin(one[3], who) for one in shown]
    return [
        (*one[:3], *(part[mask] for part in one[3:])) for one, mask in zip(shown, kept, strict=True)
    ]


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
@click.argument("kind", type=Kinds(KINDS))
@click.argument("file", type=Recording("What is read, see above."))
@click.argument("out", type=Results(RESULTS))
@click.argument("way", metavar="[POSES]", type=Recording(WAY), required=False)
def main(kind, file, out, way, field, topic, time_unit, force):
    """People round a robot, by detections of any sensors or by the legs in laser scans."""
    files = [file, way] if way else [file]
    clocks, topics = Clocks(time_unit, *files), datasets.share_topics(topic, *files)
    track = tell(clocks.read(datasets.read_track, way, topic=topics[1])) if way else None
    if kind == "legs":
        readings, poses = from_laser(file, topics[0], field, clocks, track)
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
    asked, rules, walks = kind == "legs" and WALK is not None, WALK or WalkRules(), Walks.none()
    if len(used) > 1:  # of a slow scanner, too
        rules = replace(rules, gap=max(rules.gap, 3 * float(np.median(np.diff(times[used])))))
    for k in tqdm(used, "readings"):
        seen, scan = readings[k]
        state, info = tracker.step(state, seen, poses[k])
        walks = watch_walks(walks, state.hypotheses, poses[k], rules)
        sure = state.hypotheses.weight > PEOPLE.person
        sure &= walks.are_known(seen.time, rules) | (not asked)
        people, (r, phi) = state.hypotheses.select(sure), seen.positions.mean.T
        points = np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)
        marks = np.stack([people.weight, info.static[sure], walks.walked[sure]], axis=-1)
        places = se2.act(poses[k], people.points)
        shown.append((poses[k], scan, points, people.identity + 1, places, marks))
    tracks = {*np.concatenate([numbers for *_, numbers, _, _ in shown]).tolist()}
    if asked:
        shown = walkers(shown, rules.distance)
    numbers, places, marks = map(np.concatenate, list(zip(*shown, strict=True))[3:])
    rows = np.repeat(used, [len(one[3]) for one in shown])
    (x, y), (weight, static, walked) = places.T, marks.T
    columns = {"time_s": times[rows], "person": numbers, "x_m": x, "y_m": y}
    columns |= {"weight": weight, "static": static, "walked_m": walked}
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    flat = np.stack([x, y, 0 * x], axis=-1)
    how = {"points": flat, "confidences": weight, "overwrite": force}
    datasets.write_mot(out["_mot.txt"], rows + 1, numbers, **how)
    pictures = tqdm(film(shown, times[used]), "film")
    datasets.write_video(out[".mp4"], pictures, rate=RATE, overwrite=force)
    print(f"readings: {len(times)}, without a pose: {len(times) - len(used)}")
    found = len({*numbers})
    print(f"detections: {sum(len(seen) for seen, _ in readings)}, people: {found or 'nobody'}")
    if asked:
        print(f"tracks that never walked {rules.distance:g} m, left out: {len(tracks) - found}")
    print(f"at once: {max(len(one[3]) for one in shown)}, static: {len({*numbers[static > 0]})}")


if __name__ == "__main__":
    main()

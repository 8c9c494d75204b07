"""SLAM with a stereo camera: python stereo_slam.py FOLDER|BAG OUT [WHEELS] [--map MAP]"""

import numpy as np

from robot_perception import datasets
from robot_perception.geometry import se2, se3
from robot_perception.observations import Observations
from robot_perception.scripts import Clocks, Recording, Results, installed, script, tell
from robot_perception.slam import localisation, planar, rao_blackwellised, visual
from robot_perception.streams import hold
from studies.files import reading, written

with installed():
    import click
    import cv2
    from tqdm import tqdm

    from robot_perception import landmarks
    from robot_perception.cameras import level_mount
    from robot_perception.landmarks.metrics import euclidean_mean

SIDES = None  # folders of left and right pictures, if they have no usual names
CALIBRATION = None  # file, if of no usual name; or datasets.Calibration((fx, fy), (cx, cy), b)
TICK = 0.1  # from one picture to the next, s, where neither names nor a file tell the times
APART = 0.01  # between the two pictures of a pair in a BAG, s
GAPS = False  # whether numbers may be missing
MOUNT = level_mount(np.array([0.0, 0.0, 0.0]))  # where the left camera sits on the robot, m
WHEELS = np.array([0.05, 0.05]) ** 2  # variance per second of distance, m²/s, and turn, rad²/s
NO_WHEELS = "stereo"  # the motion without them: by the pictures, or at "constant" velocity
SIGMAS = {"stereo": [0.03, 0.03, 0.003], "constant": [0.1, 0.05, 0.02]}  # of it, m, m, rad
PAIRS = landmarks.StereoRules(disparities=(8.0, np.inf))  # nearer than focal · baseline / 8 px
TRACKS = landmarks.TrackRules(window=40.0)  # how far a feature may be from where it should be, px
PITCH = 0.01  # by how much the camera nods, rad
FILTER = visual.Options(particles=100, stable=2, patience=0)  # three pairs in a row
FINDER = localisation.LocaliserRules(particles=5000, fresh=0.05)  # with --map; starts anywhere
MAP = "means", "covs", "firsts", "descriptors", "squares", "counts"  # what a map's file holds
RATE, HIGH = 10.0, 360  # of the film: pictures in a second, px
ROOT = "A folder with pictures of a rectified pair and calib.txt, or a ROS bag with two cameras."
SPEEDS = "CSV with columns time_s,speed_m_s,turn_rate_rad_s, or a ROS bag with odometry."
MAPPED = "Localise in the map of another drive, its _map.npz; writes OUT.tum alone."
RESULTS = {
    ".tum": "The robot's trajectory; judge.py reads it.",
    "_kitti.txt": "Poses of the left camera from its first one.",
    ".ply": "The landmarks, for a viewer of point clouds.",
    "_map.npz": "The map, for --map.",
    ".mp4": "The pictures with their features, beside the map.",
}


def recorded(root, topic, baseline):
    """The pairs of pictures, the cameras and the times, from a folder or a bag."""
    if datasets.is_bag(root):
        given = CALIBRATION if isinstance(CALIBRATION, datasets.Calibration) else None
        how = {"baseline": baseline, "calibration": given}
        pairs = tell(datasets.read_bag_stereo(root, topic, tolerance=APART, **how))
        return pairs, pairs.calibration.rig(pairs.size), pairs.times
    if baseline is not None:
        raise ValueError(
            f"--baseline is for a BAG; {root} has a calibration, or CALIBRATION is one"
        )
    how = {"sides": SIDES, "calibration": CALIBRATION, "allow_gaps": GAPS}
    found = tell(datasets.read_stereo(root, **how))
    pairs, times = found.frames, found.frames.left.times
    times = np.array(pairs.left.counts) * TICK if times is None else np.array(times)
    return pairs, found.calibration.rig(pairs.size), np.round(times, 9)


def by_wheels(file, clocks, topic, root, times: np.ndarray) -> list[planar.Odometry]:
    told = tell(clocks.read(datasets.read_commands, file, topic=topic))
    clocks.check((file, told.times), (root, times))
    held = hold(told.times, told.velocities, times)
    return list(map(planar.Odometry, *planar.compound(held, WHEELS)))


def by_pictures(before, found, camera, last: np.ndarray) -> tuple[planar.Odometry, bool]:
    """The robot's motion, and whether it had to be guessed as the last one."""
    seen = landmarks.stereo_motion(before, found, camera) if NO_WHEELS == "stereo" else None
    if seen is None:
        return planar.Odometry(last, np.diag(SIGMAS["constant"]) ** 2), True
    T = se3.conjugated(se3.inverse(seen.T_now_before), se3.inverse(MOUNT))
    increment = np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])
    return planar.Odometry(increment, np.diag(SIGMAS["stereo"]) ** 2), False


def localised(pairs, rig, moved, file):
    """The robot's pose in a map at each pair, and whether it counts as located."""
    with reading(file, "no map of this script"), np.load(file) as kept:
        means, covs, *looks = (kept[name] for name in MAP)
    known = localisation.LandmarkMap(means, covs, visual.Looks(*looks))
    tracker, rng = localisation.MapLocaliser(known, MOUNT, FINDER), np.random.default_rng(1)
    state, found, last = tracker.start(rng=rng), None, np.zeros(3)
    for pair, motion in zip(tqdm(pairs, "pairs"), moved, strict=True):
        before, ahead = found, se3.from_se2(motion.increment if motion else last)
        T = se3.conjugated(se3.inverse(ahead), MOUNT)
        found = landmarks.sight(before, *pair, rig, T, rules=PAIRS, track_rules=TRACKS)
        if before is not None and motion is None:
            motion, _ = by_pictures(before, found, rig.camera, last)
        last = motion.increment if motion else last
        seen, how = found.points.observations, {"costs": euclidean_mean, "rng": rng}
        state, _ = tracker.step(state, motion, seen, found.descriptors, **how)
        yield state.pose, state.located


def film(lefts, looks, path, places):
    """Each picture with its features, those of known landmarks green, beside the map so far."""
    most = np.vstack([path, np.percentile(places, [5, 95], axis=0)])  # farther ones are cut off
    low, high = most.min(axis=0) - 1, most.max(axis=0) + 1
    scale = HIGH / (high - low).max()
    for k, (left, (pixels, known, count)) in enumerate(zip(lefts, looks, strict=True)):
        picture, plan = np.dstack([left] * 3), np.full((HIGH, HIGH, 3), 255, np.uint8)
        for at, old in zip(pixels.round().astype(int).tolist(), known, strict=True):
            cv2.circle(picture, at, 3, (0, 200, 0) if old else (230, 120, 0), 1)
        points, way = (  # ahead is up
            (HIGH / 2 + scale * ((low + high) / 2 - some)[:, ::-1]).astype(np.int32)
            for some in (places[:count], path[: k + 1])
        )
        for at in points.tolist():
            cv2.circle(plan, at, 1, (120, 120, 120), -1)
        cv2.polylines(plan, [way], False, (0, 90, 200), 2)
        yield np.hstack([cv2.resize(picture, (HIGH * left.shape[1] // left.shape[0], HIGH)), plan])


@script
@click.argument("root", metavar="FOLDER|BAG", type=Recording(ROOT))
@click.argument("out", type=Results(RESULTS))
@click.argument("wheels", type=Recording(SPEEDS), required=False)
@click.option("--map", "known", type=Recording(MAPPED), metavar="MAP", help=MAPPED)
@click.option("--baseline", type=float, help="Of a bag that does not tell it, m.")
def main(root, out, wheels, known, baseline, topic, time_unit, force):
    """SLAM with a stereo camera, with the commands of the wheels or without."""
    if NO_WHEELS not in SIGMAS:
        raise ValueError(f"NO_WHEELS must be one of {', '.join(SIGMAS)}, got {NO_WHEELS!r}")
    topics, clocks = datasets.share_topics(topic, root, wheels), Clocks(time_unit, wheels)
    (pairs, rig, times), rng = recorded(root, topics[0], baseline), np.random.default_rng(1)
    landmarks.require_rectified(*map(landmarks.detect, pairs[0]))
    own = (wheels, clocks, topics[1], root, times)
    moved = [None, *(by_wheels(*own) if wheels else [None] * (len(pairs) - 1))]
    if known is not None:
        poses, sure = map(np.array, zip(*localised(pairs, rig, moved, known), strict=True))
        datasets.write_tum(out[".tum"], times, se3.from_se2(poses), overwrite=force)
        print(f"pairs: {len(pairs)}, located: {sure.sum()}")
        return
    slam, found = visual.VisualSlam(MOUNT, FILTER), None
    state, last = slam.start(np.zeros(3)), np.zeros(3)
    rules = {"rules": PAIRS, "track_rules": TRACKS, "patience": FILTER.patience}
    looks, steps, greys = [], [], []
    guessed, asked = 0, {"costs": euclidean_mean, "rng": rng}
    for pair, motion in zip(tqdm(pairs, "pairs"), moved, strict=True):
        before, ahead = found, se3.from_se2(motion.increment if motion else last)
        T_now_before = se3.conjugated(se3.inverse(ahead), MOUNT)
        found = landmarks.sight(before, *pair, rig, T_now_before, **rules)
        if before is not None and motion is None:
            motion, blind = by_pictures(before, found, rig.camera, last)
            guessed += blind
        features, seen, pose = found.points.features, found.observations, state.maps.pose
        covs = seen.covs.copy()
        covs[:, 1, 1] += (PITCH * seen.values[:, 2]) ** 2  # of heights
        seen = Observations(seen.ids, seen.values, covs)
        state, info = slam.step(state, motion, seen, found.descriptors, **asked)
        last = se2.between(pose, state.maps.pose)
        columns, rows = features.pixels[info.made].round().astype(int).T
        greys.extend(pair[0][rows, columns])
        looks.append((features.pixels, np.atleast_2d(info.known).any(axis=0), len(greys)))
        steps.append((state.maps.poses, info.resampling.ancestors))
    poses, ancestors = map(list, zip(*steps, strict=True))
    best, (names, places) = state.maps.best, state.maps.landmarks(state.maps.best)
    if not len(names):
        raise ValueError(f"{root}: no feature is in more than {FILTER.stable} pictures in a row")
    path = rao_blackwellised.paths(poses, ancestors)[:, best]
    robot, shades = se3.from_se2(path), np.array(greys, dtype=np.uint8)[names]
    datasets.write_tum(out[".tum"], times, robot, overwrite=force)
    seen_from = se3.conjugated(se3.between(robot[:1], robot), MOUNT)
    datasets.write_kitti(out["_kitti.txt"], seen_from, overwrite=force)
    datasets.write_ply(out[".ply"], places.mean, np.stack([shades] * 3, axis=1), overwrite=force)
    kept = localisation.LandmarkMap.of(state)
    looks_of = kept.looks.firsts, kept.looks.means, kept.looks.squares, kept.looks.counts
    with written(out["_map.npz"]) as path_of_map:
        np.savez(path_of_map, **dict(zip(MAP, (kept.means, kept.covs, *looks_of), strict=True)))
    frames = tqdm(film(pairs.left, looks, path[:, :2], places.mean[:, :2]), "film", len(pairs))
    datasets.write_video(out[".mp4"], frames, rate=RATE, overwrite=force)
    used = sum(known.sum() for _, known, _ in looks)
    way = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum()
    print(f"pairs: {len(pairs)}, motion: {'wheels' if wheels else NO_WHEELS}, guessed: {guessed}")
    print(f"points: {sum(len(pixels) for pixels, *_ in looks)}, of known landmarks: {used}")
    print(f"driven: {way:.1f} m, landmarks: {len(names)}")


if __name__ == "__main__":
    main()

"""Valid calls of `datasets`: on files that are written once, below a directory that is empty."""

import atexit
import shutil
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.io import savemat

from robot_perception import datasets
from robot_perception.datasets import DataFile, Dataset, Relations, Sector, SpaceTrack, Track
from tests.datasets import bags
from tests.datasets.films import write_film
from tests.datasets.writing import flaser, robotlaser, vertex, write
from tests.hostile.sweep import call

FOLDER = Path(tempfile.mkdtemp())
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)
SCANS = [robotlaser([1, 2, 3], [0, 0, 0], [0, 0, 0], time) for time in (1, 2)]
CARMEN = write(
    FOLDER / "carmen.log", [flaser([1.0] * 180, [0.0] * 3, [0.0] * 3, t) for t in (1.0, 2.0)]
)
GRAPH = write(FOLDER / "graph.log", [vertex(0, [0] * 3), SCANS[0], vertex(1, [1] * 3), SCANS[1]])
CHAIN = write(FOLDER / "chain.txt", [b"ODOMETRY 0 1 1 0 0 1 0 0 1 0 1"])
RELATIONS = write(FOLDER / "pairs.txt", [b"1 2 0.1 0 0 0 0 0"])
TABLE = write(FOLDER / "table.csv", [b"time_s,x_m,y_m,heading_rad", b"1,0,0,0", b"2,1,0,0"])
BOXES = write(FOLDER / "boxes.csv", [b"frame,x,y,w,h", b"1,3,4,10,12"])
COLUMNS = write(FOLDER / "columns.csv", [b"time_s,x_m,wrong", b"1,0,0.5"])
MOVES = write(FOLDER / "moves.csv", [b"time_s,speed_m_s,turn_rate_rad_s", b"1,0,0.5"])
SEEN = write(FOLDER / "seen.csv", [b"time_s,landmark,x_m,wrong", b"1,0,0.5,0.5"])
FELT = write(
    FOLDER / "felt.csv",
    [
        b"time_s,sensor,distance_m,direction_rad,distance_sigma_m,direction_sigma_rad",
        b"1,laser,2,0,0.1,0.1",
    ],
)
READINGS = write(FOLDER / "ranges.csv", [b"0.4,2", b"3,4"])
TIMES = np.array([1.0, 2.0, 3.0])
savemat(FOLDER / "car.mat", {"time": TIMES, "speed": TIMES, "steering": TIMES})
savemat(FOLDER / "fix.mat", {"timeGps": TIMES, "Lo_m": TIMES, "La_m": TIMES})
np.savez(
    FOLDER / "legs.npz",
    stamp=TIMES,
    ranges=np.ones((3, 5)),
    angle_min=-1.0,
    angle_increment=0.5,
    range_min=0.1,
    range_max=8.0,
)
UTIAS = FOLDER / "utias"
UTIAS.mkdir()
for name, line in {
    "Barcodes": b"6 14",
    "Landmark_Groundtruth": b"6 1 2 0.1 0.1",
    **{f"Robot{k}_Odometry": b"1 0.1 0" for k in range(1, 6)},
    **{f"Robot{k}_Measurement": b"1 14 1 0" for k in range(1, 6)},
    **{f"Robot{k}_Groundtruth": b"1 0 0 0" for k in range(1, 6)},
}.items():
    write(UTIAS / f"{name}.dat", [line])
KITTI, FEATURES, PAIRS = (FOLDER / name for name in ("kitti", "features", "pairs"))
for folder in (KITTI / "image_l", KITTI / "image_r", FEATURES, PAIRS):
    folder.mkdir(parents=True)
GREY = np.arange(256, dtype=np.uint8).reshape(16, 16)
for name in ("kitti/image_l/0.png", "kitti/image_r/0.png", "pairs/graf1.png", "pairs/graf3.png"):
    Image.fromarray(GREY).save(FOLDER / name)
for name in ("aloeL.jpg", "aloeR.jpg", "aloeGT.png"):
    Image.fromarray(GREY).save(PAIRS / name)
LEFT = b"9 0 8 0 0 9 8 0 0 0 1 0"
NAMED = write(
    FOLDER / "named.txt", [b"P0: " + LEFT, b"P1: " + LEFT.replace(b"8 0 0", b"8 -1 0", 1)]
)
write(KITTI / "calib.txt", [LEFT, LEFT.replace(b"8 0 0", b"8 -1 0", 1)])
write(KITTI / "poses.txt", [b"0 1 0 0 0 0 1 0 0 0 0 1 0"])
write(FEATURES / "VO_calibration.txt", [b"9 9 0 8 8 0.5"])
write(FEATURES / "VO_camera_poses_large.txt", [b"1 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"])
write(FEATURES / "VO_stereo_factors_large.txt", [b"1 7 9 8 8 0 0 1"])
(PAIRS / "H1to3p.xml").write_text("<s><data>1 0 0 0 1 0 0 0 1</data></s>")
PICTURE = KITTI / "image_l" / "0.png"
FILM = FOLDER / "film.avi"
write_film(FILM, np.stack([np.dstack([GREY] * 3)] * 3))
LEFT_EYE = np.array([[9.0, 0, 8, 0], [0, 9, 8, 0], [0, 0, 1, 0]])
RIGHT_EYE = LEFT_EYE - np.eye(3, 4, 3)
BAG = bags.write_bag(
    FOLDER / "robot.bag",
    [
        *(bags.odometry(time, np.eye(4)) for time in TIMES),
        *(bags.scan(time, [1.0, 2.0]) for time in TIMES),
        bags.image(0, GREY, "mono8", topic="/left/image_rect"),
        bags.image(0, GREY, "mono8", topic="/right/image_rect"),
        bags.camera_info(0, LEFT_EYE, (16, 16), topic="/left/camera_info"),
        bags.camera_info(0, RIGHT_EYE, (16, 16), topic="/right/camera_info"),
    ],
)
MOTION = datasets.read_bag_motion(BAG)
SEQUENCE = datasets.read_images(KITTI / "image_l")
OWN = FOLDER / "own"
(OWN / "mine").mkdir(parents=True)
(OWN / "mine" / "a.txt").write_text("1\n")
datasets.add_dataset(OWN / "mine", title="Mine", licence="free", origin="here", to=OWN)
ENVIRONMENT = {"ROBOT_PERCEPTION_DATA": str(OWN)}
FILE = DataFile("a.txt", "0" * 64)
SET = Dataset("own", "a title", "free", "here", (FILE,), 3)


def fresh() -> Path:
    """Return a registry's directory with a folder that is not in it yet."""
    folder = Path(tempfile.mkdtemp(dir=FOLDER)) / "drive"
    folder.mkdir()
    (folder / "log.txt").write_text("1 2 3\n")
    return folder


def adding():
    folder = fresh()
    told = {"title": "a title", "licence": "free", "origin": "here", "note": "none"}
    return call(folder, **told, url="https://example.org/a", to=folder.parent)


CALIBRATION = datasets.read_kitti(KITTI).calibration
CALLS = {
    datasets.BagMotion.commands: lambda: call(MOTION),
    datasets.BagMotion.is_flat: lambda: call(MOTION),
    datasets.BagMotion.track: lambda: call(MOTION),
    datasets.Calibration.rig: lambda: call(CALIBRATION, (20, 10)),
    datasets.Commands: lambda: call(TIMES, np.ones((len(TIMES), 2)), MOTION.report),
    Dataset.file: lambda: call(SET, "a.txt"),
    Relations.match: lambda: call(datasets.read_relations(RELATIONS), TIMES, decimals=3),
    Sector.holds: lambda: call(Sector(-0.3, 0.3, 5.0), np.array([[1.0, 0.1]])),
    Track.at: lambda: call(datasets.read_track(TABLE), TIMES, longest_gap=2.0),
    SpaceTrack: lambda: call(TIMES, np.array([np.eye(4)] * 3), MOTION.report),
    SpaceTrack.at: lambda: call(
        SpaceTrack(TIMES[:2], np.array([np.eye(4)] * 2)), TIMES, longest_gap=2.0
    ),
    datasets.ImageSequence: lambda: call((PICTURE,), (0,), False, (0.5,), (), False, ("a",)),
    datasets.StereoSequence: lambda: call(SEQUENCE, SEQUENCE),
    datasets.add_dataset: adding,
    datasets.bag_topics: lambda: call(BAG),
    datasets.is_bag: lambda: call(BAG),
    datasets.read_bag_film: lambda: call(BAG, "/left/image_rect"),
    datasets.read_bag_commands: lambda: call(BAG, "/odom"),
    datasets.read_bag_log: lambda: call(
        BAG, ("/odom", "/scan"), still=True, way=datasets.read_track(BAG)
    ),
    datasets.read_bag_motion: lambda: call(BAG, "/odom"),
    datasets.read_bag_scans: lambda: call(BAG, "/scan"),
    datasets.read_bag_stereo: lambda: call(
        BAG, None, tolerance=0.1, baseline=0.1, calibration=CALIBRATION
    ),
    datasets.share_topics: lambda: call(("/odom", "/scan"), BAG, BAG),
    datasets.dataset: lambda: call("mine"),
    datasets.fetch: lambda: call("mine", "a.txt", progress=False, timeout=1.0),
    datasets.find: lambda: call("mine", "a.txt"),
    datasets.path: lambda: call("mine", "a.txt", download=False),
    datasets.status: lambda: call("mine", "a.txt"),
    datasets.registry: lambda: call(),
    datasets.read_boxes: lambda: call(BOXES, np.array([1])),
    datasets.read_carmen_log: lambda: call(
        CARMEN, max_range=80.0, field_of_view=(-1.5, 1.5), timed=True, time_unit="s"
    ),
    datasets.read_depth_pair: lambda: call(PAIRS),
    datasets.read_image: lambda: call(PICTURE, colour=True),
    datasets.read_video: lambda: call(FILM),
    datasets.Film.seconds: lambda: call(datasets.read_video(FILM), 10.0),
    datasets.read_film: lambda: call(KITTI / "image_l", "*.png", topic="/a"),
    datasets.picture_files: lambda: call(KITTI / "image_l", "*.png"),
    datasets.gallery_files: lambda: call(KITTI),
    datasets.read_images: lambda: call(KITTI / "image_l", "*.png", colour=True, allow_gaps=True),
    datasets.read_kitti: lambda: call(KITTI, allow_gaps=True),
    datasets.read_plane_pair: lambda: call(PAIRS),
    datasets.read_stereo_features: lambda: call(FEATURES),
    datasets.read_columns: lambda: call(
        COLUMNS,
        {"time_s": 1e9, "x_m": 1e9},
        optional=["x_m"],
        integers=["time_s"],
        texts=["wrong"],
        time_unit="s",
    ),
    datasets.read_fixes: lambda: call(FOLDER / "fix.mat", time_unit="ms"),
    datasets.read_graph_log: lambda: call(GRAPH, max_range=80.0, timed=True, time_unit="s"),
    datasets.read_landmark_graph: lambda: call(CHAIN),
    datasets.read_leg_scans: lambda: call(FOLDER / "legs.npz", time_unit="s", topic="/a"),
    datasets.read_mrclam: lambda: call(UTIAS, time_unit="s"),
    datasets.read_ranges: lambda: call(READINGS, max_range=8.0),
    datasets.read_relations: lambda: call(RELATIONS, time_unit="s"),
    datasets.read_track: lambda: call(TABLE, time_unit="s", topic="/a"),
    datasets.read_vehicle: lambda: call(FOLDER / "car.mat", time_unit="ms"),
    datasets.read_space_track: lambda: call(TABLE, time_unit="s", topic="/a"),
    datasets.track_format: lambda: call(TABLE, topic="/a"),
    datasets.read_commands: lambda: call(MOVES, time_unit="s", topic="/a"),
    datasets.read_calibration: lambda: call(NAMED, cameras=(0, 1)),
    datasets.read_detections: lambda: call(FELT, ["laser"], time_unit="s"),
    datasets.read_landmarks: lambda: call(SEEN, {"x_m": 9.0}, time_unit="s"),
    datasets.read_stereo: lambda: call(
        KITTI, sides=("image_l", "image_r"), calibration="calib.txt", allow_gaps=True
    ),
    datasets.write_columns: lambda: call(FOLDER / "out.csv", {"time_s": TIMES}, overwrite=True),
    datasets.write_kitti: lambda: call(FOLDER / "out.txt", np.eye(4)[None], overwrite=True),
    datasets.write_mot: lambda: call(
        FOLDER / "out.txt",
        np.array([1, 2]),
        np.array([1, 1]),
        boxes=np.ones((2, 4)),
        points=np.ones((2, 3)),
        confidences=np.ones(2),
        overwrite=True,
    ),
    datasets.write_plan: lambda: call(
        FOLDER / "out.svg",
        walls=np.ones((2, 2, 2)),
        way=np.ones((3, 2)),
        marks=np.ones((2, 2)),
        names=["1", "2"],
        overwrite=True,
    ),
    datasets.write_ply: lambda: call(
        FOLDER / "out.ply", np.ones((2, 3)), np.ones((2, 3), np.uint8), overwrite=True
    ),
    datasets.write_tum: lambda: call(
        FOLDER / "out.tum", TIMES, np.array([np.eye(4)] * 3), overwrite=True
    ),
    datasets.write_video: lambda: call(
        FOLDER / "out.avi", [np.zeros((16, 16, 3), np.uint8)], rate=10.0, overwrite=True
    ),
}

"""Real recordings: where they are, where they come from, and how they are read.

`find` never downloads, `fetch` does; the readers return arrays and an account of every line, and
stop at the first that cannot be read. What is written appears whole or not at all.
"""

from robot_perception.datasets.bag_motion import BagMotion, read_bag_commands, read_bag_motion
from robot_perception.datasets.bag_pictures import (
    BagPictures,
    BagStereo,
    read_bag_film,
    read_bag_stereo,
)
from robot_perception.datasets.bag_scans import BagScans, read_bag_log, read_bag_scans
from robot_perception.datasets.bags import bag_topics, is_bag, share_topics
from robot_perception.datasets.boxes import Boxes, read_boxes
from robot_perception.datasets.calibrations import Calibration, read_calibration
from robot_perception.datasets.carmen import read_carmen_log
from robot_perception.datasets.commands import Commands, read_commands
from robot_perception.datasets.entries import (
    DataFile,
    Dataset,
    UnknownDataset,
    add_dataset,
    dataset,
    registry,
)
from robot_perception.datasets.graph import GraphLog, read_graph_log
from robot_perception.datasets.images import (
    ImageSequence,
    StereoSequence,
    gallery_files,
    picture_files,
    read_images,
)
from robot_perception.datasets.leg_scans import LegScans, Sector, read_leg_scans
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport
from robot_perception.datasets.mrclam import (
    Mrclam,
    MrclamRobot,
    Sightings,
    SurveyedLandmarks,
    read_mrclam,
)
from robot_perception.datasets.observed import (
    DetectionTable,
    LandmarkTable,
    read_detections,
    read_landmarks,
)
from robot_perception.datasets.pairs import DepthPair, PlanePair, read_depth_pair, read_plane_pair
from robot_perception.datasets.pictures import CorruptImage, read_image
from robot_perception.datasets.plans import write_plan
from robot_perception.datasets.relations import Relations, read_relations
from robot_perception.datasets.space_tracks import SpaceTrack, read_space_track, track_format
from robot_perception.datasets.stereo import (
    StereoDrive,
    StereoFeatures,
    StereoPictures,
    read_kitti,
    read_stereo,
    read_stereo_features,
)
from robot_perception.datasets.store import (
    DatasetMissing,
    DownloadError,
    FileStatus,
    fetch,
    find,
    path,
    status,
)
from robot_perception.datasets.tables import read_columns, read_ranges
from robot_perception.datasets.tracks import Track, read_track
from robot_perception.datasets.victoria import (
    Fixes,
    LandmarkGraph,
    VehicleLog,
    read_fixes,
    read_landmark_graph,
    read_vehicle,
)
from robot_perception.datasets.video import Film, read_film, read_video, write_video
from robot_perception.datasets.writing import (
    write_columns,
    write_kitti,
    write_mot,
    write_ply,
    write_tum,
)

__all__ = [
    "BagMotion",
    "BagPictures",
    "BagScans",
    "BagStereo",
    "Boxes",
    "Calibration",
    "Commands",
    "CorruptImage",
    "CorruptLog",
    "DataFile",
    "Dataset",
    "DatasetMissing",
    "DepthPair",
    "DetectionTable",
    "DownloadError",
    "FileStatus",
    "Film",
    "Fixes",
    "GraphLog",
    "ImageSequence",
    "LandmarkGraph",
    "LandmarkTable",
    "LaserLog",
    "LegScans",
    "Mrclam",
    "MrclamRobot",
    "PlanePair",
    "ReadReport",
    "Relations",
    "Sector",
    "Sightings",
    "SpaceTrack",
    "StereoDrive",
    "StereoFeatures",
    "StereoPictures",
    "StereoSequence",
    "SurveyedLandmarks",
    "Track",
    "UnknownDataset",
    "VehicleLog",
    "add_dataset",
    "bag_topics",
    "dataset",
    "fetch",
    "find",
    "gallery_files",
    "is_bag",
    "path",
    "picture_files",
    "read_bag_commands",
    "read_bag_film",
    "read_bag_log",
    "read_bag_motion",
    "read_bag_scans",
    "read_bag_stereo",
    "read_boxes",
    "read_calibration",
    "read_carmen_log",
    "read_columns",
    "read_commands",
    "read_depth_pair",
    "read_detections",
    "read_film",
    "read_fixes",
    "read_graph_log",
    "read_image",
    "read_images",
    "read_kitti",
    "read_landmark_graph",
    "read_landmarks",
    "read_leg_scans",
    "read_mrclam",
    "read_plane_pair",
    "read_ranges",
    "read_relations",
    "read_space_track",
    "read_stereo",
    "read_stereo_features",
    "read_track",
    "read_vehicle",
    "read_video",
    "registry",
    "share_topics",
    "status",
    "track_format",
    "write_columns",
    "write_kitti",
    "write_mot",
    "write_plan",
    "write_ply",
    "write_tum",
    "write_video",
]

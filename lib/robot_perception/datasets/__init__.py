"""Real recordings: where they are, where they come from, and how they are read.

`find` never downloads, `fetch` does; the readers return arrays and an account of every line, and
stop at the first that cannot be read.
"""

from robot_perception.datasets.carmen import read_carmen_log
from robot_perception.datasets.entries import (
    DataFile,
    Dataset,
    UnknownDataset,
    add_dataset,
    dataset,
    registry,
)
from robot_perception.datasets.graph import GraphLog, read_graph_log
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport
from robot_perception.datasets.mrclam import (
    Commands,
    Mrclam,
    MrclamRobot,
    Sightings,
    SurveyedLandmarks,
    read_mrclam,
)
from robot_perception.datasets.relations import Relations, read_relations
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

__all__ = [
    "Commands",
    "CorruptLog",
    "DataFile",
    "Dataset",
    "DatasetMissing",
    "DownloadError",
    "FileStatus",
    "Fixes",
    "GraphLog",
    "LandmarkGraph",
    "LaserLog",
    "Mrclam",
    "MrclamRobot",
    "ReadReport",
    "Relations",
    "Sightings",
    "SurveyedLandmarks",
    "Track",
    "UnknownDataset",
    "VehicleLog",
    "add_dataset",
    "dataset",
    "fetch",
    "find",
    "path",
    "read_carmen_log",
    "read_columns",
    "read_fixes",
    "read_graph_log",
    "read_landmark_graph",
    "read_mrclam",
    "read_ranges",
    "read_relations",
    "read_track",
    "read_vehicle",
    "registry",
    "status",
]

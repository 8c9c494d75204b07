"""Real recordings: where they are, where they come from, and how they are read.

`find` never downloads, `fetch` does; the readers return arrays and an account of every line.
"""

from robot_perception.datasets.carmen import read_carmen_log
from robot_perception.datasets.entries import (
    DataFile,
    Dataset,
    Origin,
    UnknownDataset,
    dataset,
    registry,
)
from robot_perception.datasets.graph import GraphLog, read_graph_log
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport, SkippedLines
from robot_perception.datasets.mrclam import Mrclam, read_mrclam
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
from robot_perception.datasets.victoria import (
    LandmarkGraph,
    read_fixes,
    read_landmark_graph,
    read_vehicle,
)

__all__ = [
    "CorruptLog",
    "DataFile",
    "Dataset",
    "DatasetMissing",
    "DownloadError",
    "FileStatus",
    "GraphLog",
    "LandmarkGraph",
    "LaserLog",
    "Mrclam",
    "Origin",
    "ReadReport",
    "Relations",
    "SkippedLines",
    "UnknownDataset",
    "dataset",
    "fetch",
    "find",
    "path",
    "read_carmen_log",
    "read_fixes",
    "read_graph_log",
    "read_landmark_graph",
    "read_mrclam",
    "read_relations",
    "read_vehicle",
    "registry",
    "status",
]

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

__all__ = [
    "CorruptLog",
    "DataFile",
    "Dataset",
    "DatasetMissing",
    "DownloadError",
    "FileStatus",
    "GraphLog",
    "LaserLog",
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
    "read_graph_log",
    "read_relations",
    "registry",
    "status",
]

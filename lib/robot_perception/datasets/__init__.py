"""Real recordings: where they are, where they come from, and how they are read."""

from robot_perception.datasets.carmen import read_carmen_log
from robot_perception.datasets.graph import GraphLog, read_graph_log
from robot_perception.datasets.logs import CorruptLog, LaserLog, ReadReport
from robot_perception.datasets.relations import Relations, read_relations

__all__ = [
    "CorruptLog",
    "GraphLog",
    "LaserLog",
    "ReadReport",
    "Relations",
    "read_carmen_log",
    "read_graph_log",
    "read_relations",
]

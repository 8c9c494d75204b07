"""What a frame costs, stage by stage."""

from robot_perception.chapters.colour_and_shape.experiments import Stages
from robot_perception.teaching.tables import Table


def table(stages: Stages, most: int = 4) -> Table:
    """Return the longest stages in milliseconds a frame, the others together, and all."""
    ordered = sorted(stages.seconds.items(), key=lambda item: -item[1])
    rows = {name: [1e3 * seconds] for name, seconds in ordered[:most]}
    rows["all others"] = [1e3 * sum(seconds for _, seconds in ordered[most:])]
    rows["together"] = [1e3 * stages.total]
    return Table(rows, {"ms a frame": "mean over the frames, all samples together"}, "", "stage")

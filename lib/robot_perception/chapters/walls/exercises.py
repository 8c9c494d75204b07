"""The exercises of the chapter."""

import numpy as np

from robot_perception import walls
from robot_perception.chapters.walls.growth import worst_case
from robot_perception.teaching.exercises import Exercise, Sheet


def _keeps_only_by_segment(answer: object) -> bool:
    """Whether a vertex is within 0.5 of the line but not of the segment of a three-vertex chain."""
    chain = np.asarray(answer, dtype=float)
    if chain.shape != (3, 2):
        raise ValueError(f"three points wanted, got shape {chain.shape}")
    away = walls.distance_to_segments(chain[1, None], chain[None, [0, 2]]).item()
    return walls.find_split(chain, 0, 2)[1] <= 0.5 < away


EXERCISES = Sheet(
    {
        "walls-1": Exercise(
            answer=walls.count_distances(worst_case(1000), 0.1),
            mistakes=(
                (1000 * 999 // 2, "the two ends of a sub-chain are not measured."),
                (1000 * 1000, "each round looks at one vertex fewer than the last."),
            ),
            hint="The first round measures 998 vertices, the next 997, and so on.",
        ),
        "walls-2": Exercise(
            answer=_keeps_only_by_segment,
            hint="Let the middle vertex lie beyond the end of the chord, almost on its line.",
        ),
        "walls-3": Exercise(
            answer=0.5,
            mistakes=((0.05, "0.05 is the printed measure, a slope; multiply by the chord."),),
            hint="The printed measure is the distance divided by the length of the chord.",
        ),
        "walls-4": Exercise(
            answer="only if the pose stood still",
            mistakes=(("yes", "what if the robot moves while the beam sweeps?"),),
            hint="Use the words of one of the three options.",
        ),
    }
)
check = EXERCISES.check

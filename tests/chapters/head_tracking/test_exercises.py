"""The exercises of the chapter."""

from robot_perception.chapters.head_tracking.exercises import EXERCISES
from tests.chapters.exercises import ExerciseTests


class TestExercises(ExerciseTests):
    stem = "head_tracking"
    sheet = EXERCISES

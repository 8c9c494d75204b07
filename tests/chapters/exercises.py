"""What the exercises of every chapter must pass: answers are judged, mistakes have their words."""

import re
from pathlib import Path

from robot_perception.teaching.course.exercises import Exercise


def assert_values_told(exercise: Exercise) -> None:
    """Check that an exercise takes its answer, waits, and tells each mistake by its words."""
    assert exercise.judge(exercise.answer)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    for wrong, words in exercise.mistakes:
        assert_told(exercise, wrong, words)


def asked(stem: str) -> list[str]:
    """Return the exercises that a chapter asks, in the order of the alphabet."""
    notebook = Path(__file__).parents[2] / "book" / f"{stem}.ipynb"
    return sorted(re.findall(r'check\(\\"(.+?)\\",', notebook.read_text(encoding="utf-8")))


def assert_judged(exercise: Exercise, right: object) -> None:
    """Check that an exercise by code takes the right function, waits, and takes no constant."""
    assert exercise.judge(right)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    assert exercise.judge(lambda *_: 0.0)[0] == "wrong"


def assert_told(exercise: Exercise, wrong: object, said: str) -> None:
    """Check that a typical mistake is wrong, and is told by its own words."""
    outcome, words = exercise.judge(wrong)
    assert outcome == "wrong"
    assert said in words

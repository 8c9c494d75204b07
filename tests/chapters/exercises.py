"""What the exercises of every chapter must pass; a chapter's ``test_exercises.py`` takes these."""

import re
from pathlib import Path

import pytest

from robot_perception.teaching.exercises import Exercise, Sheet


class ExerciseTests:
    """Answers are judged, mistakes have their words, and the chapter asks each exercise once."""

    stem: str
    sheet: Sheet

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make one test an exercise whose answer is a value."""
        if "key" in metafunc.fixturenames:
            values = [key for key, e in self.sheet.items() if not callable(e.answer)]
            metafunc.parametrize("key", values)

    def test_each_mistake_has_its_words(self, key: str):
        exercise = self.sheet[key]
        assert exercise.judge(exercise.answer)[0] == "right"
        assert exercise.judge(...)[0] == "not yet"
        for wrong, words in exercise.mistakes:
            outcome, said = exercise.judge(wrong)
            assert outcome == "wrong"
            assert words in said

    def test_chapter_asks_each_exercise_once(self):
        notebook = Path(__file__).parents[2] / "book" / f"{self.stem}.ipynb"
        asked = re.findall(r'check\(\\"(.+?)\\",', notebook.read_text(encoding="utf-8"))
        assert sorted(asked) == sorted(self.sheet)


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

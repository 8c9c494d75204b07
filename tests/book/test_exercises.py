"""The sheets of exercises of computing chapters."""

import pytest

from tests.book.registry import COMPUTING, SHEET, Declared, every
from tests.chapters.exercises import asked, assert_values_told

SHEETS = pytest.mark.parametrize("sheet", every(SHEET), ids=lambda sheet: sheet.stem)


def test_each_chapter_has_one():
    assert [sheet.stem for sheet in every(SHEET)] == [*COMPUTING]


@SHEETS
def test_each_mistake_has_its_words(sheet: Declared):
    for exercise in sheet.value().values():
        if not callable(exercise.answer):
            assert_values_told(exercise)


@SHEETS
def test_the_chapter_asks_each_exercise_once(sheet: Declared):
    assert asked(sheet.stem) == sorted(sheet.value())

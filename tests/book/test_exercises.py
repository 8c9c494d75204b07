"""The sheets of exercises of computing chapters."""

from robot_perception.teaching.exercises import Sheet
from tests.book.computing import COMPUTING, module
from tests.chapters.exercises import ExerciseTests


def sheet_of(stem: str) -> Sheet:
    """Return the sheet of a chapter, which has one."""
    (sheet,) = {id(v): v for v in vars(module(stem)).values() if isinstance(v, Sheet)}.values()
    return sheet


for _stem in COMPUTING:
    _own = {"stem": _stem, "sheet": sheet_of(_stem)}
    globals()[f"Test_{_stem}"] = type(f"Test_{_stem}", (ExerciseTests,), _own)

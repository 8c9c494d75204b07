"""Copies for a course: what is left out, what is added, and what stays as it is."""

import copy

from robot_perception.teaching.course.copies import asked, copied

SHEET = """def good(answer):
    return answer == 3


LIMIT, DEEP = 1, 2
EXERCISES = Sheet({"one-1": Exercise(3)})
check = EXERCISES.check"""
CELLS = [
    ("markdown", "# One"),
    ("code", SHEET),
    ("markdown", "### Count (by hand)\n\nHow many?\n\n:::{dropdown} Hint\nFew.\n:::"),
    ("code", 'answer = ...\ncheck("one-1", answer)'),
    ("markdown", ":::{dropdown} Solution\nThree.\n:::\n\n### Write (by code)\n\nWhich?"),
    ("code", 'rule = ...\ncheck("one-2", rule)'),
    ("markdown", "::::{dropdown} Solution\n:::{note}\nNo.\n:::\n::::\n\n### Say (prose)\n\nWhy?\n\n"
                 ":::{dropdown} What a good answer mentions\nAll.\n:::\n\n## Claims"),
]  # fmt: skip
TAGS = ["remove-input", "study"]
NOTEBOOK = {
    "nbformat": 4,
    "cells": [
        {"cell_type": kind, "id": f"c{k}", "metadata": {"tags": TAGS}, "source": source}
        for k, (kind, source) in enumerate(CELLS)
    ],
}


def made(solutions):
    return copied(NOTEBOOK, "one", solutions=solutions)["cells"]


def test_exercises_have_their_headings_and_points():
    found = [(one.key, one.title, one.name, one.points) for one in asked(NOTEBOOK)]
    assert found == [
        ("one-1", "Count (by hand)", "answer", 1),
        ("one-2", "Write (by code)", "rule", 2),
    ]


def test_the_book_itself_is_not_changed():
    before = copy.deepcopy(NOTEBOOK)
    made(solutions=False)
    assert before == NOTEBOOK


def test_a_student_gets_exercises_hints_and_points_and_no_solutions():
    texts = [cell["source"] for cell in made(solutions=False)]
    said = "\n".join(texts)
    assert "Three." not in said
    assert "All." not in said
    assert "No." not in said
    assert "Few." in said
    assert "*Exercise `one-1`, 1 point.*" in said
    assert "*Exercise `one-2`, 2 points.*" in said
    assert "Why?" in said
    assert texts[1] == (
        "from robot_perception.book.one import (\n    good,\n    LIMIT,\n    DEEP,\n"
        "    EXERCISES,\n    check,\n)"
    )


def test_an_answer_in_sentences_has_its_place_before_what_follows():
    for solutions in (False, True):
        *_, asks, answer, rest = (cell["source"] for cell in made(solutions))
        assert "Why?" in asks
        assert answer.startswith("*Your answer")
        assert rest == "## Claims"


def test_what_a_sheet_reaches_in_unseen_cells_is_taken_from_the_package():
    cells = [
        ("helper", "from math import pi as PI\ndef deep():\n    return PI", TAGS),
        ("right", "def right(x):\n    return deep()", TAGS),
        ("other", "def other():\n    return 1", TAGS),
        ("seen", "def seen(x):\n    return 1", ["study"]),
        ("sheet", "E = Sheet({})\nE |= {'a': Exercise(right), 'b': Exercise(seen)}",
         ["remove-input", "study"]),
    ]  # fmt: skip
    page = {
        "cells": [
            {"cell_type": "code", "id": name, "metadata": {"tags": tags}, "source": source}
            for name, source, tags in cells
        ]
    }
    texts = {c["id"]: c["source"] for c in copied(page, "one", solutions=False)["cells"]}
    take = "from robot_perception.book.one import (\n"
    assert texts["helper"] == f"{take}    PI,\n    deep,\n)"
    assert texts["right"] == f"{take}    right,\n)"
    assert texts["sheet"] == f"{take}    E,\n)"
    assert texts["seen"] == cells[3][1]
    assert texts["other"] == cells[2][1]


def test_an_instructor_gets_all_of_it():
    said = "\n".join(cell["source"] for cell in made(solutions=True))
    assert "Three." in said
    assert "All." in said
    assert SHEET in said
    assert "*Exercise `one-2`, 2 points.*" in said


def test_cells_are_marked_as_nbgrader_marks_them():
    about = [cell["metadata"].get("nbgrader") for cell in made(solutions=False)]
    named = "grade_id", "grade", "solution", "locked", "points"
    found = [tuple(a.get(name) for name in named) for a in about if a]
    assert found == [
        ("one-1", False, True, False, None),
        ("one-1-points", True, False, True, 1),
        ("one-2", False, True, False, None),
        ("one-2-points", True, False, True, 2),
        ("one-prose-1", True, True, False, 2),
    ]
    locked = [c for c in made(solutions=False) if c["metadata"].get("nbgrader", {}).get("locked")]
    assert all("raises-exception" in cell["metadata"]["tags"] for cell in locked)
    assert all(a["schema_version"] == 3 and a["task"] is False for a in about if a)


def test_the_cell_that_counts_fails_unless_the_answer_is_right():
    from robot_perception.teaching.course.exercises import Exercise, Sheet

    check = Sheet({"one-1": Exercise(3)}).check
    counts = next(c["source"] for c in made(solutions=False) if c["id"] == "c3-points")
    exec(counts, {"check": check, "answer": 3})
    for wrong in (4, ...):
        try:
            exec(counts, {"check": check, "answer": wrong})
        except AssertionError:
            continue
        raise RuntimeError(f"{wrong} counts")

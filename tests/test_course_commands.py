"""``robot-perception course`` and ``grade``: answers that are right, wrong, or worse."""

import csv
import io
import json

import pytest
from click.testing import CliRunner

from robot_perception.cli import main
from robot_perception.cli.course import _line
from robot_perception.teaching.course import grading

STEM = "covariance_intersection"
KEYS = "ci-echo", "ci-three", "ci-weight", "ci-hits"


@pytest.fixture
def run():
    return lambda *words: CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture
def right():
    """The right answers of a chapter, as a student would write them."""
    from robot_perception.book.covariance_intersection import EXERCISES

    given = {"ci-weight": "lambda a, b: fusion.omega_least_determinant(plain(a), plain(b))"}
    return given | {key: repr(float(EXERCISES[key].answer)) for key in KEYS if key not in given}


def hand_in(folder, cells):
    """Write a notebook of answers: by key what stands before the check, or all of the cell."""
    folder.mkdir(parents=True)
    made = [
        {
            "cell_type": "code",
            "id": key,
            "metadata": {},
            "source": f'{said}\ncheck("{key}", answer)'.splitlines(keepends=True),
        }
        for key, said in cells.items()
    ]
    locked = {"nbgrader": {"locked": True}}
    made.append({"cell_type": "code", "id": "p", "metadata": locked,
                 "source": 'assert check("ci-echo", 0)'})  # fmt: skip
    (folder / f"{STEM}.ipynb").write_text(json.dumps({"cells": made}))
    return folder


def outcomes(result):
    table = csv.DictReader(io.StringIO(result.stdout))
    return {(row["student"], row["exercise"]): row for row in table}


def test_a_line_for_every_student_and_exercise_whatever_was_handed_in(run, right, tmp_path):
    ada = {key: f"answer = {value}" for key, value in right.items()}
    bob = {
        "ci-echo": "answer = -1.0",
        "ci-three": "raise RuntimeError('no\\nidea')",
        "ci-weight": "while True: pass",
        "ci-hits": f"answer = {right['ci-hits']}",
    }
    eve = {
        "ci-echo": "import os; os._exit(0)",
        "ci-three": "import sys; sys.exit()",
        "ci-weight": "answer = ...",
    }
    folders = [
        hand_in(tmp_path / "ada" / "week", ada).parent,
        hand_in(tmp_path / "bob", bob),
        hand_in(tmp_path / "eve", eve),
    ]
    (tmp_path / "joe").mkdir()
    result = run("grade", *folders, tmp_path / "joe", "--limit", 2)
    assert result.exit_code == 0, result.output
    found = outcomes(result)
    assert len(found) == 4 * len(KEYS)
    names = "ada", "bob", "eve", "joe"
    told = {name: [found[name, key]["outcome"] for key in KEYS] for name in names}
    assert told == {
        "ada": ["right"] * 4,
        "bob": ["wrong", "error", "too long", "right"],
        "eve": ["error", "error", "not yet", "missing"],
        "joe": ["missing"] * 4,
    }
    assert found["bob", "ci-three"]["said"] == "RuntimeError: no idea"
    assert all(row["points"] == (row["of"] if row["outcome"] == "right" else "0")
               for row in found.values())  # fmt: skip
    assert "bob: 1 of 5 points; 1 error, 1 too long" in result.stderr
    assert "joe: 0 of 5 points; 4 missing" in result.stderr


def test_a_damaged_notebook_and_two_of_one_name_are_told(run, tmp_path):
    (tmp_path / "ann").mkdir()
    (tmp_path / "ann" / f"{STEM}.ipynb").write_text("{")
    hand_in(tmp_path / "dan" / "a", {})
    hand_in(tmp_path / "dan" / "b", {})
    hand_in(tmp_path / "dan" / ".ipynb_checkpoints", {})
    found = outcomes(run("grade", tmp_path / "ann", tmp_path / "dan"))
    assert {row["outcome"] for row in found.values()} == {"error"}
    assert "no notebook" in found["ann", KEYS[0]]["said"]
    assert found["dan", KEYS[0]]["said"] == "2 notebooks of that name"


def test_the_table_is_written_to_a_file(run, right, tmp_path):
    folder = hand_in(tmp_path / "ada", {"ci-echo": f"answer = {right['ci-echo']}"})
    file = tmp_path / "marks.csv"
    assert run("grade", folder, "--chapter", STEM, "--write", file).exit_code == 0
    assert file.read_text().splitlines()[0] == "student,chapter,exercise,outcome,points,of,said"
    assert len(file.read_text().splitlines()) == 1 + len(KEYS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("grade", "{}/a"), "none of these folders"),
        (("grade", "{}/a", "{}/b/a", "--chapter", STEM), "two folders are called a"),
        (("grade", "{}/a", "--chapter", "scorecard"), "no chapter 'scorecard'"),
        (("course",), "--student DIR"),
        (("course", "--student", "{}/a", "--chapter", "house"), "no chapter 'house'"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(run, tmp_path, words, said):
    (tmp_path / "b" / "a").mkdir(parents=True)
    (tmp_path / "a").mkdir()
    result = run(*(word.format(tmp_path) for word in words))
    assert result.exit_code != 0
    assert said in result.output
    assert "Traceback" not in result.output


def test_copies_are_written_for_both_and_never_over_what_is_there(run, tmp_path):
    words = "--student", tmp_path / "s", "--instructor", tmp_path / "i", "--chapter", STEM
    result = run("course", *words)
    assert result.exit_code == 0, result.output
    ours, theirs = (json.loads((tmp_path / d / f"{STEM}.ipynb").read_text()) for d in "is")
    assert "{dropdown} Solution" in json.dumps(ours)
    assert "{dropdown} Solution" not in json.dumps(theirs)
    again = run("course", *words)
    assert again.exit_code != 0
    assert "is there already; nothing was written" in again.output


def test_a_copy_that_nobody_has_answered_is_not_yet(run, tmp_path):
    run("course", "--student", tmp_path / "ada", "--chapter", STEM)
    found = outcomes(run("grade", tmp_path / "ada"))
    assert [row["outcome"] for row in found.values()] == ["not yet"] * len(KEYS)


def test_a_chapter_that_cannot_run_here_is_named_before_anybody_is_graded(
    monkeypatch, run, tmp_path
):
    folder = hand_in(tmp_path / "ada", {"ci-echo": "answer = 1"})

    def fails(name):
        raise ModuleNotFoundError(f"no module for {name}")

    monkeypatch.setattr(grading, "import_module", fails)
    result = run("grade", folder, "--write", tmp_path / "marks.csv")
    assert result.exit_code != 0
    assert f"the study cells of {STEM} cannot be run here" in result.output
    assert not (tmp_path / "marks.csv").exists()


def test_what_fails_with_one_notebook_is_said_in_its_lines(monkeypatch, run, right, tmp_path):
    ada, bob = (
        hand_in(tmp_path / name, {"ci-echo": f"answer = {right['ci-echo']}"})
        for name in ("ada", "bob")
    )
    whole = grading.notebooks

    def fails(place, stem):
        if place == ada:
            raise OSError("the disk is gone \ud800")
        return whole(place, stem)

    monkeypatch.setattr(grading, "notebooks", fails)
    result = run("grade", ada, bob)
    assert result.exit_code == 0, result.output
    found = outcomes(result)
    assert found["bob", "ci-echo"]["outcome"] == "right"
    assert {found["ada", key]["outcome"] for key in KEYS} == {"error"}
    assert found["ada", "ci-echo"]["said"] == r"OSError: the disk is gone \ud800"


def test_the_table_grows_by_a_line_and_keeps_what_is_graded(monkeypatch, run, tmp_path):
    def marks(*_):
        yield grading.Mark("ada", STEM, "ci-echo", "right", 1, 1, "Right.")
        grown.append(file.read_text())
        raise KeyboardInterrupt

    grown, file = [], tmp_path / "marks.csv"
    monkeypatch.setattr(grading, "grade", marks)
    assert run("grade", hand_in(tmp_path / "ada", {}), "--write", file).exit_code != 0
    lines = "student,chapter,exercise,outcome,points,of,said\n", f"ada,{STEM},ci-echo,right,1,1,"
    assert grown == [f"{lines[0]}{lines[1]}Right.\n"]
    assert file.read_text() == grown[0]


@pytest.mark.parametrize(
    ("cell", "written"),
    [
        ("=1+1", "'=1+1"),
        ("+1", "'+1"),
        ("-1", "'-1"),
        ("@a", "'@a"),
        ("\t=1", "'\\t=1"),
        ("\ra", "'\\ra"),
        ("a=1", "a=1"),
        ("\ud800", "\\ud800"),
        ("a\0b\nc", "a\\x00b\\nc"),
        ("Zoë", "Zoë"),
    ],
)
def test_no_cell_of_the_table_is_a_formula_or_breaks_it(cell, written):
    assert _line([cell, 2]).decode() == f"{written},2\n"

"""Planted errors: their lines fit the present code, and what a run of the tests says of them."""

from dataclasses import replace
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from tests.tools.mutants import ROOT, Mutant, read, rooms
from tests.tools.mutants.__main__ import BY_BOOK, BY_DRAWS, _module, further, table, verdict

CODE = "def f(a, b):\n    return a + b  # a + b\n"


def planted(folder: Path, *lines: str) -> list[Mutant]:
    """Write a room of planted errors, and the code that they change, and read the room."""
    (folder / "code.py").write_text(CODE)
    (folder / "room.txt").write_text("\n".join(("tests: -k 'not b' t.py", "", "# why", *lines)))
    return read(folder / "room.txt")


@pytest.mark.parametrize("room", rooms())
def test_every_planted_error_fits_the_code(room):
    mutants = read(rooms()[room])
    assert mutants
    for mutant in mutants:
        mutant.applied()
        for word in mutant.tests:
            file = word.partition("::")[0]
            assert not file.startswith("tests/") or (ROOT / file).exists(), mutant.name


def test_a_line_says_what_is_changed_where_and_what_should_notice(tmp_path):
    one, two, three = planted(
        tmp_path,
        "code.py#1: `a + b` -> `a - b`",
        "code.py: `return ` -> `return 2 * `",
        "code.py: `f(a, b)` -> `f(b, a)` = a sum = a sum",
    )
    assert one.name == "room:4"
    assert one.tests == ("-k", "not b", "t.py")
    assert one.applied(tmp_path) == CODE.replace("a + b", "a - b", 1)
    assert two.applied(tmp_path) == CODE.replace("return ", "return 2 * ")
    assert (one.reason, three.reason) == ("", "a sum = a sum")


@pytest.fixture
def notebook(tmp_path):
    """Write a notebook: the same line in prose, in a study cell, and in one that is none."""
    study = new_code_cell('def said(a):\n    """Say a."""\n    return {"a": a}', id="study")
    study.metadata["tags"] = ["study"]
    cells = [new_markdown_cell('About {"b": b}.'), study, new_code_cell('print({"b": b})')]
    (tmp_path / "page.ipynb").write_text(nbformat.writes(new_notebook(cells=cells)))
    return tmp_path


def test_an_error_is_planted_in_a_study_cell_as_it_reads(notebook):
    (one,) = planted(notebook, 'page.ipynb: `return {"a": a}` -> `return {"a": -a}`')
    changed = nbformat.reads(one.applied(notebook), as_version=4)
    assert changed.cells[1].source.endswith('    return {"a": -a}')
    page = notebook / "page.ipynb"
    assert [c.source for c in changed.cells[::2]] == [
        c.source for c in nbformat.read(page, as_version=4).cells[::2]
    ]


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ('`{"b": b}` -> `{}`', "stands 2 times"),
        ('`print({"b": b})` -> `print(1)`', "changes nothing"),
        ("`(a):` -> `(a)`", "no longer parses"),
    ],
)
def test_what_is_no_error_in_a_study_cell_is_refused(notebook, change, problem):
    (one,) = planted(notebook, f"page.ipynb: {change}")
    with pytest.raises(ValueError, match=f"^room:4: .*{problem}"):
        one.applied(notebook)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("code.py: a -> b", "is no planted error"),
        ("code.py `a` -> `b`", "is no planted error"),
        ("code.py#0: `a` -> `b`", "is no planted error"),
        ("code.py: `a` -> `b` =", "is no planted error"),
        ("code.py: `` -> `b`", "is no planted error"),
        ("cold.py: `a` -> `b`", "no file cold.py"),
        ("code.py: `c +` -> `c -`", "stands 0 times"),
        ("code.py: `a + b` -> `a - b`", "stands 2 times"),
        ("code.py#3: `a + b` -> `a - b`", "stands 2 times"),
        ("code.py#2: `a + b` -> `a - b`", "changes nothing"),
        ("code.py: `return` -> `return`", "changes nothing"),
        ("code.py: `return` -> `return +*`", "no longer parses"),
    ],
)
def test_a_line_that_does_not_fit_is_named(tmp_path, line, problem):
    with pytest.raises(ValueError, match=f"^room:4: .*{problem}"):
        [mutant.applied(tmp_path) for mutant in planted(tmp_path, line)]


def test_a_line_needs_tests_above_it(tmp_path):
    (tmp_path / "room.txt").write_text("code.py: `a` -> `b`\n")
    with pytest.raises(ValueError, match=r"room:1: has no line `tests: …` above it"):
        read(tmp_path / "room.txt")


@pytest.mark.parametrize(
    ("code", "imports", "said"),
    [
        (0, True, "escaped"),
        (1, True, "caught"),
        (2, False, "did not import"),
        (2, True, "did not collect"),
        (4, False, "did not import"),
        (5, True, "exit code 5"),
        (-11, True, "crashed"),
        (None, True, "hung"),
    ],
)
def test_verdict_follows_from_the_exit_code(code, imports, said):
    assert verdict(code, imports) == said


def test_share_is_over_what_is_not_equivalent_and_only_the_caught_count(tmp_path):
    lines = [f"code.py: `return ` -> `return {i} * `" for i in range(2, 7)]
    mutants = planted(tmp_path, *lines, "code.py: `f(a, b)` -> `f(b, a)` = a sum")
    said = ["caught", "hung", "escaped", "exit code 5", "did not import"]
    text, share = table(mutants, dict(zip([m.name for m in mutants], said, strict=False)))
    assert share == 3 / 5
    _, room, every, escaped, ended, equivalent = text.splitlines()
    assert room.split() == ["room", "6", "3", "2", "1", "60.0%"]
    assert every.split()[1:] == room.split()[1:]
    assert escaped.startswith("escaped     room:6 ")
    assert ended.startswith("exit code 5 room:7 ")
    assert equivalent.endswith(" = a sum")


def test_what_the_book_notices_is_counted_and_told_apart(tmp_path):
    lines = [f"code.py: `return ` -> `return {i} * `" for i in range(2, 6)]
    mutants = planted(tmp_path, *lines)
    said = dict(zip([m.name for m in mutants], [BY_BOOK, BY_DRAWS, BY_BOOK, "caught"], strict=True))
    text, share = table(mutants, said)
    assert share == 1
    assert text.splitlines()[-2:] == [f"{BY_BOOK:16s}       2", f"{BY_DRAWS:16s}       1"]


def test_the_book_is_asked_of_notebooks_alone_and_never_for_a_key(tmp_path):
    [code] = planted(tmp_path, "code.py: `return ` -> `return 2 * `")
    assert not list(further(code))
    names, tests = zip(*further(replace(code, file="book/walls.ipynb")), strict=True)
    assert names == (BY_BOOK, BY_BOOK, BY_DRAWS)
    assert all("walls" in " ".join(words) and "of_this_code" not in words for words in tests)


def test_compiled_code_is_that_of_its_module():
    tree = Path("tree")
    cache = tree / "lib" / "package" / "room" / "__pycache__"
    assert _module(cache / "kernels.fill-12.py311.1.nbc", tree) == "package.room.kernels"
    assert _module(tree / "lib" / "package" / "room" / "kernels.py", tree) == "package.room.kernels"
    assert _module(tree / "data_synth" / "__init__.py", tree) == "data_synth"
    assert _module(tree / "book" / "walls.ipynb", tree) == "robot_perception.book.walls"

"""The rules of notebooks that compute: their study cells are a module that a reader can read."""

import ast
import re
import sys

import pytest
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell

from tests.book.computing import (
    CHECKED,
    COMPUTING,
    EXERCISE,
    FURTHER,
    code_cells,
    is_study,
    is_visible,
    lines,
    tags,
)
from tests.book.pages import BOOK, notebook

SHOWN, FOLDED, UNSEEN = 30, 40, 45
"""Lines of a cell that shows its code, of one behind a fold, and of one that no page shows."""
FOLDS = 8
"""Most folds that a page shows to readers: proofs, how something was chosen or measured, rows."""
LEAST, MOST = 60, 220
"""So many lines of code shows a chapter, exercises apart."""
THIRD_PARTY = {"numpy", "scipy", "pandas", "sympy", "cv2"}
OURS = {"robot_perception", "data_synth", "explorables", "studies"}
NOT_OURS = re.compile(r"robot_perception\.cli\b")
DEAR = {"rows", "run", "show", "record", "find", "found", "result", "drawn", "trial"}
"""Methods that compute; none is called while study cells are imported."""
RECORDS = {"recorded", "ledger", "Ledger"}
PARTS = {"evidence", "tables", "stored"}

EACH = pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])


def imports(source: str) -> set[str]:
    """Return the modules from which a text imports."""
    nodes = list(ast.walk(ast.parse(source)))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    return names | {f"{n.module}" for n in nodes if isinstance(n, ast.ImportFrom)}


def forbidden(source: str) -> set[str]:
    """Return the modules that study cells may not import."""
    allowed = OURS | THIRD_PARTY | sys.stdlib_module_names
    every = imports(source)
    return {name for name in every if name.split(".")[0] not in allowed or NOT_OURS.match(name)}


def dear(source: str) -> list[str]:
    """Return what is called while a text is imported, and computes."""
    todo: list[ast.AST] = list(ast.parse(source).body)
    called = []
    while todo:
        node = todo.pop()
        if isinstance(node, ast.Lambda):
            continue
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            todo += [
                *node.decorator_list,
                *node.args.defaults,
                *filter(None, node.args.kw_defaults),
            ]
            continue
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") in DEAR:
            called.append(ast.unparse(node))
        todo += ast.iter_child_nodes(node)
    return called


def read_alone(source: str) -> list[str]:
    """Return what a text takes from records instead of computing it from rows."""
    nodes = ast.walk(ast.parse(source))
    return [ast.unparse(node) for node in nodes if getattr(node, "id", "") in RECORDS
            or getattr(node, "attr", "") in PARTS]  # fmt: skip


def declares(source: str) -> list[str]:
    """Return the names of the studies that a text declares."""
    return [node.name for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)
            and any(getattr(getattr(d, "func", None), "attr", "") == "study"
                    for d in node.decorator_list)]  # fmt: skip


def asked_of_itself(stem: str, source: str) -> list[str]:
    """Return the imports by which a notebook takes its own cells from the module they make."""
    nodes = [n for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Import | ast.ImportFrom)]
    named = {
        ".".join(filter(None, (getattr(node, "module", None), alias.name)))
        for node in nodes
        for alias in node.names
    }
    own = f"robot_perception.book.{stem}"
    return sorted(name for name in named if f"{name}.".startswith(f"{own}."))


def places(stem: str, call: str, given: int) -> list[tuple[int, str]]:
    """Return where a notebook calls `later` or `now`, and the names that it gives.

    A chapter that has a `later` of its own calls ours by the module; theirs is given other things.
    """
    return [
        (k, node.args[0].value)
        for k, cell in enumerate(code_cells(stem))
        for node in ast.walk(ast.parse(cell.source))
        if isinstance(node, ast.Call)
        and call in (getattr(node.func, "id", ""), getattr(node.func, "attr", ""))
        and len(node.args) == given
    ]


@EACH
def test_an_edit_reaches_the_picture_since_no_notebook_imports_itself(stem: str):
    for cell in code_cells(stem):
        assert not asked_of_itself(stem, cell.source), cell.id


@EACH
def test_a_place_for_what_comes_later_is_filled_once_and_further_down(stem: str):
    kept, filled = places(stem, "later", 1), places(stem, "now", 2)
    cells = code_cells(stem)
    assert not [cells[k].id for k, _ in kept + filled if is_study(cells[k])]  # they are imported
    assert sorted(name for _, name in kept) == sorted({name for _, name in filled})
    assert len(kept) == len(filled)
    where = {name: k for k, name in kept}
    assert all(where[name] < k for k, name in filled)


@EACH
def test_study_cells_import_what_a_notebook_may(stem: str):
    for cell in filter(is_study, code_cells(stem)):
        assert not forbidden(cell.source), cell.id


@EACH
def test_nothing_is_computed_while_study_cells_are_imported(stem: str):
    for cell in filter(is_study, code_cells(stem)):
        assert not dear(cell.source), cell.id


@EACH
def test_study_cells_have_no_output_and_folded_cells_say_so_twice(stem: str):
    """By a tag to the page, by `source_hidden` to JupyterLab."""
    for cell in code_cells(stem):
        assert not (is_study(cell) and (cell.outputs or cell.metadata.get("keep_output"))), cell.id
        folded = cell.metadata.get("jupyter", {}).get("source_hidden", False)
        assert folded != is_visible(cell), f"{cell.id}: {tags(cell)}, source_hidden: {folded}"


def most_lines(cell: NotebookNode) -> int:
    """Return how long a cell may be; claims have many words, and no page unfolds them."""
    if is_visible(cell):
        return SHOWN
    return UNSEEN if "remove-input" in tags(cell) else FOLDED


@EACH
def test_a_cell_is_one_idea(stem: str):
    long = [
        f"cell {cell.id} ({lines(cell)[0]}): {len(lines(cell))} lines of code"
        for cell in code_cells(stem)
        if len(lines(cell)) > most_lines(cell)
    ]
    assert not long, "\n".join(long)


def is_fold(cell: NotebookNode) -> bool:
    """Tell whether a page shows a cell as a fold; other code waits for the switch of the page."""
    return "hide-output" in tags(cell) or {"hide-input", "fold"} <= tags(cell)


@EACH
def test_a_page_has_few_folds_and_drawings_are_none(stem: str):
    folds = [cell for cell in code_cells(stem) if is_fold(cell)]
    assert len(folds) <= FOLDS
    for cell in folds:
        assert cell.metadata["mystnb"]["code_prompt_show"] not in ("Draw", "Imports"), cell.id
    assert not [c.id for c in code_cells(stem) if "fold" in tags(c) and not is_fold(c)]


@EACH
def test_a_chapter_shows_its_code_and_not_too_much(stem: str):
    shown = [c for c in code_cells(stem) if is_visible(c) and not EXERCISE.search(c.source)]
    assert LEAST <= sum(len(lines(cell)) for cell in shown) <= MOST


@EACH
def test_after_each_study_that_is_seen_a_reader_is_told_what_to_try(stem: str):
    waiting: list[str] = []
    for cell in notebook(BOOK / f"{stem}.ipynb").cells:
        if cell.cell_type == "markdown" and "*Try it.*" in cell.source:
            waiting = []
        elif cell.cell_type == "code" and is_study(cell) and is_visible(cell):
            found = declares(cell.source)
            assert not (found and waiting), f"nothing to try after {', '.join(waiting)}"
            waiting += found
    assert not waiting, f"nothing to try after {', '.join(waiting)}"


@EACH
def test_compared_cells_compute(stem: str):
    """One that reads what is recorded of a claim would be the same whatever the code does."""
    for cell in code_cells(stem):
        if cell.source.startswith(CHECKED):
            assert not read_alone(cell.source), cell.id


# The rules notice


def test_what_may_not_be_imported_is_found():
    allowed = (
        "import numpy as np, json\nfrom data_synth import office\nfrom robot_perception import slam"
    )
    assert not forbidden(f"{allowed}\nfrom robot_perception.chapters.walls import figures")
    for line in ("import matplotlib", "from tests import book",
                 "from robot_perception.cli import main",
                 "def f():\n    import torch"):  # fmt: skip
        assert len(forbidden(f"{allowed}\n{line}")) == 1


def test_what_is_computed_at_import_is_found():
    free = """A = slider("a", (1, 2))
half = study.but(gain=2)

@study.claim("x", value=lambda rows: study.rows().largest("a"))
def claim(rows):
    return study.run()

BET = Bet("?", because=lambda: study.rows().mean("a"))
show
"""
    assert not dear(free)
    for line in ("study.rows()", "A = [study.run(film=k) for k in range(3)]", "explorer.show()",
                 "def f(x=study.rows()):\n    pass", "if True:\n    study.record()",
                 "class A:\n    rows = study.rows()"):  # fmt: skip
        assert len(dear(free + line)) == 1, line


def test_what_reads_a_record_is_found():
    assert not read_alone("rows = study.rows()\nrows.by('rule', {'mean': ('mean', 'x')}).show()")
    for line in ("recorded()['a']", "ledger['a'].value", "found.evidence['x']",
                 "recorded.tables['x'].show()", "walls.stored().value"):  # fmt: skip
        assert read_alone(line), line


def test_studies_are_found():
    text = "@chapter.study(film=range(3))\ndef a(film): ...\n@a.claim('x')\ndef b(rows): ..."
    assert declares(f"{text}\ndef c(): ...") == ["a"]


def test_lines_are_counted_without_those_that_are_empty_or_a_mark():
    assert lines(new_code_cell(f"{CHECKED}\na = 1\n\nb = 2\n")) == ["a = 1", "b = 2"]

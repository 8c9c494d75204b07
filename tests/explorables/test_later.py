"""What a cell further down makes is shown in the place that was kept for it, in a real kernel."""

import nbformat
import pytest
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

from explorables.progress import PAGE_VARIABLE

IMPORTS = """from IPython.display import display
from explorables.later import later, now"""
TWICE = """class Twice:
    def _ipython_display_(self):
        display({"text/plain": "picture"}, raw=True, metadata={"kind": "drawn"})
        display({"text/plain": "view"}, raw=True)"""


def outputs(*cells: str) -> list[list[str]]:
    """Run cells in a kernel and return what each has shown."""
    notebook = nbformat.v4.new_notebook(cells=[*map(nbformat.v4.new_code_cell, (IMPORTS, *cells))])
    NotebookClient(notebook, kernel_name="python3").execute()
    return [[out["data"]["text/plain"] for out in cell.outputs] for cell in notebook.cells[1:]]


def test_what_is_shown_now_stands_where_it_was_announced():
    first, between, last = outputs('later("hero")', "2", 'now("hero", 1 + 1)')
    assert first == ["2", ""]
    assert (between, last) == (["2"], [])


def test_a_place_says_that_cells_further_down_fill_it():
    ((said, nothing),) = outputs('later("hero")')
    assert "run them all" in said
    assert not nothing


def test_a_picture_and_its_view_are_both_shown_and_what_is_drawn_anew_replaces_them():
    first, *_ = outputs('later("hero")', TWICE, 'now("hero", Twice())')
    assert first == ["picture", "view"]
    first, *_ = outputs('later("hero")', 'now("hero", 1)', 'now("hero", 2)')
    assert first == ["2", ""]


def test_on_a_page_a_place_has_one_output(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    assert outputs('later("hero")', 'now("hero", 3)')[0] == ["3"]
    with pytest.raises(CellExecutionError, match="hero has 2 outputs, its place takes 1"):
        outputs('later("hero")', TWICE, 'now("hero", Twice())')

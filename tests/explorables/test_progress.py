"""Bars of progress: for whoever waits in a notebook, for nobody on a page or under test."""

import nbformat
import pytest
from nbclient import NotebookClient

from explorables.progress import PAGE_VARIABLE, progress

CODE = "from explorables.progress import progress\n"


def outputs(monkeypatch, code, **environment):
    """Return what a cell puts out in a kernel of its own, as seen while it runs."""
    monkeypatch.delenv("PYTEST_VERSION", raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CODE + code)])
    NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
    return notebook.cells[0].outputs


def test_items_come_as_they_are():
    assert list(progress(range(5), "five")) == [0, 1, 2, 3, 4]
    assert list(progress((x for x in "ab"), total=2)) == ["a", "b"]


@pytest.mark.parametrize(
    "code", ["list(progress(range(3), 'work'));", "next(progress('ab', 'work'));"]
)
def test_a_notebook_shows_a_bar(monkeypatch, code):
    (shown,) = outputs(monkeypatch, code)
    assert "application/vnd.jupyter.widget-view+json" in shown["data"]
    assert "work" in shown["data"]["text/plain"]


@pytest.mark.parametrize("quiet", [{PAGE_VARIABLE: "1"}, {"PYTEST_VERSION": "8"}])
def test_pages_and_tests_show_none(monkeypatch, quiet):
    assert outputs(monkeypatch, "list(progress(range(3), 'work'));", **quiet) == []


def test_a_script_without_a_terminal_prints_nothing(capfd):
    list(progress(range(3), "work"))
    assert capfd.readouterr() == ("", "")

"""Citations in notebooks are links, which JupyterLab shows as the page does."""

import re
from pathlib import Path

import nbformat
import pytest
from pybtex.database import parse_file
from pybtex.richtext import Text

BOOK = Path(__file__).parents[1] / "book"
ENTRIES = parse_file(str(BOOK / "references.bib")).entries
LINK = re.compile(r"\[([^\]]+)\]\(references\.md#([\w-]+)\)")
ROLE = re.compile(r"\{cite(?::\w)?\}`([^`]+)`")


def prose(path):
    """Return the prose of a page."""
    if path.suffix == ".md":
        return path.read_text("utf-8")
    cells = nbformat.read(path, as_version=4).cells
    return "\n".join(cell.source for cell in cells if cell.cell_type == "markdown")


PAGES = {path.name: prose(path) for path in sorted([*BOOK.glob("*.ipynb"), *BOOK.glob("*.md")])}
LINKS = [(name, *found) for name, text in PAGES.items() for found in LINK.findall(text)]


@pytest.mark.parametrize("name", [name for name in PAGES if name.endswith(".ipynb")])
def test_a_notebook_has_no_role_that_it_cannot_show(name):
    assert not ROLE.findall(PAGES[name])


def test_a_citation_names_the_first_author_and_the_year_of_its_entry():
    assert LINKS
    for name, text, key in LINKS:
        assert key in ENTRIES, f"{name}: references.bib has no {key}"
        author = ENTRIES[key].persons["author"][0]
        last = Text.from_latex(author.last_names[-1]).render_as("text")
        assert last in text, (name, text)
        assert ENTRIES[key].fields["year"] in text, (name, text)


def test_every_entry_is_cited():
    roles = {
        key.strip() for t in PAGES.values() for keys in ROLE.findall(t) for key in keys.split(",")
    }
    assert set(ENTRIES) <= roles | {key for _, _, key in LINKS}

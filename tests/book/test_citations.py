"""Citations in notebooks are links, which JupyterLab shows as the page does."""

import re
from functools import cache

from pybtex.database import Entry, parse_file
from pybtex.richtext import Text

from tests.book import pages

LINK = re.compile(r"\[([^\]]+)\]\(references\.md#([\w-]+)\)")
ROLE = re.compile(r"\{cite(?::\w)?\}`([^`]+)`")


@cache
def entries() -> dict[str, Entry]:
    """Return what may be cited."""
    return dict(parse_file(str(pages.BOOK / "references.bib")).entries)


def links() -> list[tuple[pages.Passage, str, str]]:
    """Return the links to what is cited: where they stand, their text and key."""
    return [(p, *found) for p in pages.prose() for found in LINK.findall(p.text)]


def test_a_notebook_has_no_role_that_it_cannot_show():
    for passage in pages.prose():
        assert passage.place.endswith(".md") or not ROLE.findall(passage.text), passage


def test_a_citation_names_the_first_author_and_the_year_of_its_entry():
    assert links()
    for place, text, key in links():
        assert key in entries(), f"{place}: references.bib has no {key}"
        author = entries()[key].persons["author"][0]
        last = Text.from_latex(author.last_names[-1]).render_as("text")
        assert last in text, (place, text)
        assert entries()[key].fields["year"] in text, (place, text)


def test_every_entry_is_cited():
    roles = {
        key.strip()
        for passage in pages.prose()
        for keys in ROLE.findall(passage.text)
        for key in keys.split(",")
    }
    assert set(entries()) <= roles | {key for _, _, key in links()}

"""The first use of each word on a page leads to what it means: an extension of Sphinx's builder.

A word is marked in prose only: in the text of a paragraph, not in headings, links, emphasis, code,
formulas or captions, nor in boxes, folds and tables, and only where it has the meaning of the list.
A script shows what it means; without one it is a link with a title.
"""

from collections.abc import Iterator
from html import escape
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx_design.dropdown import dropdown_main

from robot_perception.teaching.words import terms
from studies.records import records

APART = (
    dropdown_main, nodes.Admonition, nodes.caption, nodes.figure, nodes.table, nodes.term,
)  # fmt: skip
"""Nodes beside the main line of a page."""
UNMARKED = ("library", "_modules")
"""First parts of the names of pages that are no prose."""


def connect_terms(app: Sphinx) -> None:
    """Have words marked."""
    app.add_config_value("book_terms", "", "env")  # a change of them renews every page
    app.connect("config-inited", _configure)
    app.add_post_transform(MarkTerms)
    app.add_js_file("words.js")
    app.add_css_file("words.css")


def _configure(app: Sphinx, config: Config) -> None:
    here = Path(app.srcdir, f"{terms.PAGE}.md").exists()  # another book may have no such page
    config.book_terms = (records() / terms.TERMS).read_text("utf-8") if here else ""


class MarkTerms(SphinxPostTransform):
    """Makes the first use of each word on a page a link to what it means."""

    default_priority = 900  # after outputs are chosen and references resolved
    formats = ("html",)

    def run(self, **kwargs: object) -> None:
        """Mark the words of one page."""
        page = self.env.docname
        if not self.config.book_terms or page == terms.PAGE or page.split("/")[0] in UNMARKED:
            return
        find, seen = terms.Finder(terms.read(), page), set()
        target = self.app.builder.get_relative_uri(page, terms.PAGE)
        for text in list(_texts(self.document)):
            said, made, done = text.astext(), [], 0
            for start, end, term in find(said):
                if term.id not in seen:
                    seen.add(term.id)
                    made += [nodes.Text(said[done:start]), _link(target, term, said[start:end])]
                    done = end
            if made:
                text.parent.replace(text, [*made, nodes.Text(said[done:])])


def _texts(document: nodes.document) -> Iterator[nodes.Text]:
    for paragraph in document.findall(nodes.paragraph):
        above = paragraph.parent
        while above is not None and not isinstance(above, APART):
            above = above.parent
        if above is None:
            yield from (node for node in paragraph.children if isinstance(node, nodes.Text))


def _link(target: str, term: terms.Term, said: str) -> nodes.raw:
    html = (
        f'<a class="rp-term" href="{target}#{term.id}" title="{escape(term.plain)}">'
        f"{escape(said)}</a>"
    )
    return nodes.raw("", html, format="html")

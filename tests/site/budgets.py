"""How much a built chapter asks of its reader: words, numbers, figures, cells, and their order."""

import re
from collections.abc import Iterator
from functools import cached_property

from bs4 import NavigableString, Tag

from tests.site.soup import parsed

NO_PROSE = (
    "script, noscript, style, svg, table, form, fieldset, button, .cell_input, .rp-source, "
    ".highlight, .rp-badges, .rp-controls, .rp-table, .rp-cards, .rp-check, .rp-bet, "
    "details.sd-dropdown, details.hide > summary"
)
"""What is no prose of the main line: code, drawings, tables, controls, badges, folds and labels."""
TRY = re.compile(r"Try it\.")
"""Begins what a reader may do, as an exercise is."""

BLOCKS = ("p", "li", "h1", "h2", "h3", "figcaption", "dd", "dt")
"""Elements that hold a paragraph."""

NAMES = re.compile(
    r"(\b(Figs?|Tables?|eqs?|equations?|Sections?|steps?|statements?|robots?|sets?|building"
    r"|Freiburg)\.?\s*|§+\s*)\(?\d[\d.]*[a-z]?\)?(\s*(to|and|,|–)\s*\(?\d[\d.]*[a-z]?\)?)*",
    re.IGNORECASE,
)
"""Numbers that are names of things."""

NUMBER = re.compile(r"(?<![\w.])\d(?:[\d.,\u202f\u2009\u00a0]| (?=\d{3}\b))*")

PRINTED = re.compile(r"(?:^[^\[\n]*\S {2,}\S+ {2,}\S[^\[\n]*\n?){3,}", re.MULTILINE)
"""Three lines or more in columns, no array: a table made of spaces."""


class Chapter:
    """The main text of a page, without its exercises."""

    def __init__(self, html: str) -> None:
        found = parsed(html).select_one("article")
        assert found is not None, "the page has no article"
        for section in found.select("section#exercises"):
            section.decompose()
        self.text = found

    def count(self, selector: str) -> int:
        """Count the elements of a kind."""
        return len(self.text.select(selector))

    @property
    def visible(self) -> list[Tag]:
        """The code cells that show their code."""
        hidden = "tag_hide-input", "tag_remove-input", "tag_hide-cell", "tag_remove-cell"
        cells = self.text.select("div.cell:has(.cell_input)")
        return [cell for cell in cells if not set(hidden) & set(cell["class"])]

    def paragraphs(self) -> list[str]:
        """Return the paragraphs of the main line, headings and captions among them."""
        return [text for _, text in self._paragraphs]

    @cached_property
    def _paragraphs(self) -> list[tuple[Tag, str]]:
        return list(self._found())

    def _found(self) -> Iterator[tuple[Tag, str]]:
        hidden = {id(node) for node in self.text.select(NO_PROSE)}
        for node in self.text.find_all(BLOCKS):
            above = {id(parent) for parent in (node, *node.parents)}
            inside = node.find_parent(BLOCKS) is not None
            if inside or above & hidden:
                continue
            if not TRY.match(text := _plain(node, hidden)):
                yield node, text

    def words(self) -> int:
        """Count the words of the main line."""
        return sum(map(_words, self.paragraphs()))

    def words_before(self, selector: str) -> int:
        """Count the words of the main line before the first element of a kind."""
        first = self.text.select_one(selector)
        assert first is not None, f"the page has nothing of the kind {selector}"
        after = {id(node) for node in first.find_all_next(BLOCKS)}
        after |= {id(node) for node in first.find_all(BLOCKS)}
        return sum(_words(text) for node, text in self._paragraphs if id(node) not in after)

    def numbers(self) -> list[tuple[int, str]]:
        """Return how many numbers each paragraph has outside formulae, code and links."""
        copy = Chapter(str(self.text))
        for node in copy.text.select(".math, code, a"):
            node.string = "…"
        texts = copy.paragraphs()
        return [(len(NUMBER.findall(NAMES.sub("", text))), text) for text in texts]

    def questions(self) -> list[str]:
        """Return the captions that end in a question."""
        captions = (node.get_text(" ").strip() for node in self.text.select("figcaption"))
        return [caption for caption in captions if caption.endswith("?")]

    def early_badges(self) -> list[str]:
        """Return the badges at the chapter's head, or above which their section shows nothing."""
        kinds = "figure, table, pre, div.math"
        early = []
        for badges in self.text.select(".rp-badges"):
            section = badges.find_parent("section")
            shown = section.select(kinds) if section and section.find_parent("section") else []
            below = {id(node) for node in badges.find_all_next()}
            if all(id(node) in below for node in shown):
                early.append(" ".join(badges.get_text(" ").split()))
        return early

    def printed(self) -> list[str]:
        """Return the outputs that are tables made of spaces."""
        outputs = (node.get_text() for node in self.text.select(".cell_output pre"))
        return [text for text in outputs if PRINTED.search(text)]


def _plain(node: Tag, hidden: set[int]) -> str:
    """Return the text of a paragraph without what is no prose."""
    texts = (
        part
        for part in node.descendants
        if isinstance(part, NavigableString) and not {id(p) for p in part.parents} & hidden
    )
    return " ".join("".join(texts).split())


def _words(text: str) -> int:
    return sum(bool(re.search(r"\w", word)) for word in text.split())

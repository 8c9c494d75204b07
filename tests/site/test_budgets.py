"""A chapter keeps the budgets: it is read in an hour at most, and shows before it judges."""

from functools import lru_cache
from pathlib import Path

import pytest

from robot_perception.chapters import CHAPTERS, PRIMER
from tests.book.contents import CONTENTS
from tests.site.budgets import Chapter

WORDS, NUMBERS = 4000, 5
FIGURES, EXPLORERS, QUESTIONS, BETS = 12, 5, 3, 3
CELLS, VISIBLE = 90, 35
"""Cells in all and those that show their code."""
BEFORE_FIGURE, BEFORE_EXPLORER = 350, 700
IDEAS = {"many_numbers": 6}
"""Explorers of a page that has one for each of more ideas."""


@lru_cache(maxsize=1)
def built(page: Path) -> Chapter:
    """Return a chapter of the built site."""
    return Chapter(page.read_text("utf-8"))


@pytest.fixture(params=(*PRIMER, *CHAPTERS), scope="module")
def stem(request: pytest.FixtureRequest) -> str:
    """The name of a chapter."""
    return request.param


@pytest.fixture(scope="module")
def chapter(stem: str, site: Path) -> Chapter:
    """A chapter of the built site."""
    return built(site / f"{stem}.html")


def test_its_main_line_is_short(chapter: Chapter) -> None:
    """Computed words included."""
    assert chapter.words() <= WORDS


def test_the_words_that_are_counted_are_those_of_the_page(stem: str, chapter: Chapter) -> None:
    """Counted from the notebook; exercises and folds come on top of the main line."""
    shown = chapter.words()
    assert 0.95 * shown <= CONTENTS.pages[stem].words <= 1.6 * shown


def test_it_shows_early(chapter: Chapter) -> None:
    """A figure within a page, something to move within two."""
    assert chapter.words_before("figure") <= BEFORE_FIGURE
    assert chapter.words_before("div.explorer") <= BEFORE_EXPLORER


def test_each_figure_is_looked_at(stem: str, chapter: Chapter) -> None:
    """Few figures, few explorers, few captions that ask, few bets."""
    explorers = chapter.count("div.explorer")
    assert chapter.count("figure.rp-figure") - explorers <= FIGURES
    assert explorers <= IDEAS.get(stem, EXPLORERS)
    assert chapter.count(".rp-bet") <= BETS
    questions = chapter.questions()
    assert len(questions) <= QUESTIONS, "\n".join(questions)


def test_a_visible_cell_is_an_idea(chapter: Chapter) -> None:
    """Few cells, and fewer that show their code; exercises apart."""
    assert chapter.count("div.cell:has(.cell_input, .cell_output)") <= CELLS
    assert len(chapter.visible) <= VISIBLE


def test_a_paragraph_has_few_numbers(chapter: Chapter) -> None:
    """The reader remembers one."""
    many = [f"{count}: {text}" for count, text in chapter.numbers() if count > NUMBERS]
    assert not many, "\n".join(many)


def test_a_badge_comes_after_its_result(chapter: Chapter) -> None:
    """Its section has shown something above it; the head of the chapter has no badge."""
    early = chapter.early_badges()
    assert not early, "\n".join(early)


def test_no_table_is_printed(chapter: Chapter) -> None:
    """Tables are tables, for screen readers and for print."""
    printed = chapter.printed()
    assert not printed, "\n".join(printed)


PAGE = """
<article><section><h1>Walls of 2 rooms</h1>
<p class="rp-badges">walls-fig1</p>
<p>One, <span class="math">x = 1</span> two <code>f(3)</code> <a href="#">Fig. 4</a>.</p>
<section><p class="rp-badges">dp-recursive</p>
<p>Robot 2 has 1 234 points, 0.5 m and Fig. 3; eqs 24–27 (of 95 %), v2.</p>
<figure class="rp-figure"><svg><text>5 m</text></svg><figcaption>Where?</figcaption></figure>
<details class="sd-dropdown"><p>Folded away.</p></details>
<p class="rp-badges">dp-quadratic</p></section>
<div class="cell tag_hide-input"><div class="cell_input"></div>
<div class="cell_output"><pre>a   b   c
1   2   3
4   5   6
</pre></div></div>
<div class="cell"><div class="cell_input"></div>
<div class="cell_output"><pre>1   2   3</pre></div></div>
<section id="exercises"><p>Not counted.</p></section></section></article>
"""


def test_what_is_counted() -> None:
    """Words, numbers, cells and badges of a small page, counted by hand."""
    page = Chapter(PAGE)
    assert [text.split()[0] for text in page.paragraphs()] == ["Walls", "One,", "Robot", "Where?"]
    assert page.words() == 4 + 7 + 16 + 1
    assert page.words_before("figure") == 4 + 7 + 16
    assert [count for count, _ in page.numbers()] == [1, 0, 3, 0]
    assert page.questions() == ["Where?"]
    assert page.early_badges() == ["walls-fig1", "dp-recursive"]
    assert len(page.visible) == 1
    assert page.printed() == ["a   b   c\n1   2   3\n4   5   6\n"]

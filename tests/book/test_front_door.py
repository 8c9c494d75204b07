"""The way in: landing page, README and errata are in step with the chapters."""

import re
from string import Formatter

import pytest

from robot_perception.chapters import CHAPTERS, PRIMER
from robot_perception.teaching.pages.paths import PATHS
from robot_perception.teaching.scores.badges import recorded
from robot_perception.teaching.scores.overview import holds
from robot_perception.teaching.scores.papers import PAPERS
from robot_perception.teaching.scores.scorecard import OURS
from tests.book.contents import CONTENTS
from tests.book.pages import BOOK, ROOT

ERRATA = (BOOK / "errata.md").read_text("utf-8")
PARTS = ("The paper prints", "It must be", "Why", "What the difference does")


def test_every_chapter_of_the_package_is_a_chapter_of_the_contents():
    assert set(CHAPTERS) <= {page.stem for page in CONTENTS.chapters}


def test_chapters_have_a_box_of_what_to_know():
    assert not {page.stem for page in CONTENTS.chapters if not page.box}


SAID = re.compile(rf"\[([^]]+)\]\(({'|'.join(PRIMER)})\.ipynb#(\w+)\)")
SMALL = {"what", "that", "with", "from", "and", "the", "its", "for", "list"}


def primer_section(stem: str, anchor: str) -> str:
    """Return the prose of a page of the primer from an anchor to the next heading."""
    text = "\n".join(CONTENTS.pages[stem].source)
    return re.split(r"^##", text[text.index(f'<a id="{anchor}">') :], flags=re.M)[0].lower()


@pytest.mark.parametrize("page", CONTENTS.chapters, ids=lambda page: page.stem)
def test_what_a_chapter_needs_is_said_in_the_primer_by_the_same_words(page):
    for words, stem, anchor in SAID.findall(page.box or ""):
        section = primer_section(stem, anchor)
        asked = {w.removesuffix("s") for w in re.findall(r"[a-z]{4,}", words.lower())} - SMALL
        assert asked, words
        missing = {word for word in asked if word not in section}
        assert not missing, f"{words}: {stem}#{anchor} has no {', '.join(sorted(missing))}"


def test_the_readme_lists_the_chapters_in_their_order():
    text = (ROOT / "README.md").read_text("utf-8")
    listed = re.findall(r"^\| \[(.+?)\]\(book/(\w+)\.ipynb\)", text, re.M)
    assert listed == [(page.title, page.stem) for page in CONTENTS.chapters]


@pytest.mark.parametrize("way", PATHS, ids=lambda way: way.name)
def test_paths_lead_to_pages_that_are_there_and_take_some_afternoons(way):
    stops = way.stops(CONTENTS)
    assert len(set(stops)) == len(stops) > len(way.goals)
    assert 45 < way.minutes(CONTENTS) < 14 * 60


def test_a_chapter_takes_as_long_as_the_front_page_says():
    assert "Half an hour to an hour for a chapter" in (BOOK / "intro.md").read_text("utf-8")
    for stem in (*PRIMER, *CHAPTERS):
        page = CONTENTS.pages[stem]
        assert 25 <= page.minutes(exercises=False) <= 62, stem
        assert 10 <= page.minutes() - page.minutes(exercises=False) <= 40, stem


def test_the_landing_page_says_what_a_verdict_is_before_the_first_badge():
    text = (BOOK / "intro.md").read_text("utf-8")
    said = [
        text.index(words) for words in ("For whom", "What to know", "How long", "Where to begin")
    ]
    assert max(said) < text.index("explained()") < text.index("overview(")


def test_every_erratum_has_its_derivation_and_a_claim_of_the_ledger():
    for entry in re.split(r"^## ", ERRATA, flags=re.M)[1:]:
        names = tuple(re.findall(r"^(\w[\w ]+)\n: ", entry, re.M))
        assert names == PARTS, entry
        claims = re.findall(r"scorecard\.ipynb#([\w-]+)", entry)
        assert claims, entry
        assert all(recorded()[claim] for claim in claims)


def test_errata_name_every_paper_and_every_claim_of_an_erratum():
    assert set(re.findall(r"^\{cite\}`(\w+)`", ERRATA, re.M)) == {
        paper.reference for paper in PAPERS.values()
    }
    claims = {entry.id for entry in recorded().entries if entry.id.startswith("erratum-")}
    assert claims <= set(re.findall(r"scorecard\.ipynb#([\w-]+)", ERRATA))


def test_it_is_said_what_holds_of_each_paper_and_of_ours_by_claims_that_are_recorded():
    said = holds()
    assert {*said} == {*PAPERS, OURS}
    for key, text in said.items():
        named = {name for _, name, _, _ in Formatter().parse(text) if name}
        assert all(recorded()[name].paper == key for name in named)
        assert len(named) >= 2 or key == OURS

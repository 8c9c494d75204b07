"""The course is made of the book: bets, studies and exercises are there, and weeks fit a class."""

import ast
import re

import pytest

from robot_perception.teaching.course.copies import asked, copied
from robot_perception.teaching.course.weeks import (
    CLASS_MINUTES,
    MOST,
    Week,
    doubted,
    exercise,
    overview,
    question,
    tried,
    week,
    weeks,
)
from tests.book.contents import CONTENTS
from tests.book.pages import BOOK, NOTEBOOKS, notebook

WEEKS = weeks()
PROJECT = 2
"""Weeks at the end that belong to a project on the students' own data."""
PAGE = (BOOK / "course.md").read_text("utf-8")
NUMBERED = [pytest.param(one, id=f"week {n}") for n, one in enumerate(WEEKS, 1)]
ASKING = [path for path in NOTEBOOKS if asked(notebook(path))]
SECRET = re.compile(r"\{dropdown\} (Solution|What a good answer)|Exercise\(")


def all_of(cells):
    return "\n".join("".join(cell["source"]) for cell in cells)


def answering(page):
    """Return the functions of unseen cells that an exercise names as its answer."""
    unseen = [
        c.source for c in page.cells if {"remove-input", "study"} <= {*c.metadata.get("tags", ())}
    ]
    defined = set(re.findall(r"^def (\w+)\(", "\n".join(unseen), re.M))
    calls = [
        node.args[0]
        for source in unseen
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Exercise" and node.args
    ]
    named = {n.id for call in calls for n in ast.walk(call) if isinstance(n, ast.Name)}
    return defined & named


def test_there_are_twelve_weeks_and_the_page_tells_of_each():
    assert len(WEEKS) == 12
    assert re.findall(r"^## Week (\d+): \w", PAGE, re.M) == [str(n) for n in range(1, 13)]
    assert re.findall(r"^week\((\d+), book\)$", PAGE, re.M) == [str(n) for n in range(1, 13)]
    assert PAGE.count("**In class.**") == 12


@pytest.mark.parametrize("one", NUMBERED)
def test_a_week_fits_a_class_and_an_afternoon(one):
    assert sum(one.minutes.values()) == CLASS_MINUTES
    assert 0 < one.before(CONTENTS) <= one.before(CONTENTS) + one.later(CONTENTS) <= MOST


@pytest.mark.parametrize("one", NUMBERED[:-PROJECT])
def test_a_week_bets_changes_and_hands_in_what_it_has_read(one):
    pages = CONTENTS.pages
    stem, name = one.bet.split(".")
    assert stem in one.after, "a bet is worth nothing once its page was read"
    assert question(pages[stem], name).endswith("?")
    stem, name = one.study.split(".")
    assert stem in (*one.read, *one.after)
    assert all(tried(pages[stem], name))
    assert {exercise(CONTENTS, key)[0].stem for key in one.hand_in} <= {*one.read, *one.after}
    assert one.hand_in
    assert one.sceptic in (*one.read, *one.after) or one.sceptic.endswith("?")
    assert doubted(CONTENTS, one)


def test_every_chapter_is_read_once_and_after_what_it_needs():
    order = [stem for one in WEEKS for stem in (*one.read, *one.after)]
    chapters = [page.stem for page in CONTENTS.chapters]
    assert sorted(stem for stem in order if stem in chapters) == sorted(chapters)
    late = {
        (stem, need)
        for stem in chapters
        for need in CONTENTS.needs(stem)
        if order.index(need) > order.index(stem)
    }
    assert not late


def test_a_sceptic_asks_for_sentences():
    wrong = Week(read=("one_belief",), sceptic="one_belief")
    with pytest.raises(ValueError, match="asks for no answer in sentences"):
        doubted(CONTENTS, wrong)
    assert "For the sceptic" in doubted(CONTENTS, Week(read=(), sceptic="monobot"))


def test_the_page_reports_no_classes_that_nobody_held():
    assert not re.search(
        r"\b(?:students|pairs|classes|most) (?:usually|tend|expect|will)\b", PAGE, re.I
    )
    assert not re.search(r"\bbet (?:usually|divides|often)\b", PAGE)


def test_the_last_weeks_are_a_project():
    assert all(not one.bet and not one.hand_in for one in WEEKS[-PROJECT:])
    assert "your_own_data" in WEEKS[-PROJECT].read


@pytest.mark.parametrize("number", range(1, 13))
def test_a_week_says_and_links_all_of_it(number):
    shown = week(number, CONTENTS).bundle["text/html"]
    one = WEEKS[number - 1]
    assert all(CONTENTS.pages[s].title.split("'")[0] in shown for s in (*one.read, *one.after))
    assert all(f"<code>{key}</code>" in shown for key in one.hand_in)


def test_the_table_has_a_line_for_each_week():
    assert repr(overview(CONTENTS)).count("\n") == 11


@pytest.mark.parametrize("path", ASKING, ids=lambda path: path.stem)
def test_copies_of_a_chapter(path):
    page = notebook(path)
    keys = [one.key for one in asked(page)]
    assert set(keys) == set(CONTENTS.pages[path.stem].exercises)
    for solutions in (False, True):
        cells = copied(page, path.stem, solutions=solutions)["cells"]
        ids = [cell["id"] for cell in cells]
        assert len(set(ids)) == len(ids)
        about = [c["metadata"]["nbgrader"] for c in cells if "nbgrader" in c["metadata"]]
        names = [found["grade_id"] for found in about]
        assert len(set(names)) == len(names)
        assert all(re.fullmatch(r"[a-zA-Z0-9_\-]+", name) for name in names)
        assert [n for n in names if n in keys] == keys
        assert {f"{key}-points" for key in keys} <= set(names)
        secrets = [cell["id"] for cell in cells if SECRET.search("".join(cell["source"]))]
        assert bool(secrets) == solutions
        if not solutions:
            assert not {name for name in answering(page) if f"def {name}(" in all_of(cells)}
        prose = sum(cell["source"].count("{dropdown} What a good answer") for cell in page.cells)
        assert sum("-prose-" in name for name in names) == prose

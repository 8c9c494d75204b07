"""Contents read from pages: titles, boxes of needs, and what follows from them."""

import json

import pytest

from robot_perception.teaching.contents import Contents, Page, read

BOX = ":::{{admonition}} Before you start\n:class: tip\n{}\n:::\n"


def page(stem, text="", code="", number=1, part="Part"):
    return Page(stem, number, part, (f"# {stem.title()}\n\n{text}", code))


def boxed(stem, words):
    return page(stem, BOX.format(words))


def test_needs_are_the_links_of_the_box():
    book = Contents(
        [page("walls"), page("belief"), boxed("slam", "You need [a](belief.ipynb#gauss)\nand [b]"
         "(walls.ipynb). Words stand in the [notation](notation.md).")]
    )  # fmt: skip
    assert book.needs("slam") == ("belief", "walls")


@pytest.mark.parametrize(
    "words",
    [
        "You need no earlier chapter; variances appear in [a](walls.ipynb).",
        "You need variances, and nothing about [a](walls.ipynb) yet.",
        "How it is found is the matter of [a](walls.ipynb); here it is given.",
        "Some of [a](walls.ipynb) helps.",
    ],
)
def test_asides_are_no_needs(words):
    assert Contents([page("walls"), boxed("slam", words)]).needs("slam") == ()


def test_what_a_chapter_needs_comes_before_it_in_the_order_of_the_book():
    book = Contents([
        page("c"), page("a"), boxed("b", "You need [x](a.ipynb)."),
        boxed("d", "You need [x](b.ipynb), [y](a.ipynb), [z](c.ipynb)."),
    ])  # fmt: skip
    assert book.before(["d"]) == ("c", "a", "b", "d")
    assert book.direct("d") == ("b", "c")  # b needs a already


def test_a_need_that_stands_later_is_refused():
    with pytest.raises(ValueError, match="walls needs slam, which does not stand before it"):
        Contents([boxed("walls", "You need [x](slam.ipynb)."), page("slam")])


def test_minutes_grow_with_words_explorers_and_exercises():
    text, code = "word " * 398, 'A = Exploration(\n)\nsheet.check("one-1", ...)'
    one = page("one", text, code)
    assert one.minutes() == pytest.approx(2 + 3 + 6)
    assert one.minutes(exercises=False) == pytest.approx(2 + 3)


def test_bets_studies_and_exercises_are_found():
    code = (
        'FIRST = Bet("Which?", {}, "a")\n'
        '@chapter.study(\n    film=range(3),\n    way=("a", "b"),\n)\ndef lost(film, way):\n'
        'SHEET.check("one-1", ...)\ncheck("one-1", 3)'
    )
    one = page("one", "", code)
    assert (one.bets, one.studies, one.exercises) == (("FIRST",), ("lost",), ("one-1",))


def test_the_first_question_is_no_heading_and_no_scrap():
    one = page(
        "one", "## Where am I then, please?\n\nWhy? It *is* so. Which [walls](a.md) are there?"
    )
    assert one.question == "Which walls are there?"


def test_contents_are_read_in_their_order_with_what_stands_below(tmp_path):
    (tmp_path / "_toc.yml").write_text(
        "root: intro\nparts:\n- caption: A\n  numbered: true\n  chapters:\n"
        "  - file: one\n    sections:\n    - file: more\n  - file: two\n"
    )
    (tmp_path / "intro.md").write_text("# Door\n")
    cells = [
        {"cell_type": "markdown", "source": ["# One\n"]},
        {"cell_type": "code", "source": "B = Bet(1)"},
    ]
    (tmp_path / "one.ipynb").write_text(json.dumps({"cells": cells}))
    for name in ("more", "two"):
        (tmp_path / f"{name}.md").write_text(f"# {name}\n")
    book = read(tmp_path)
    assert [(p.stem, p.number) for p in book.pages.values()] == [
        ("intro", None), ("one", 1), ("more", None), ("two", 2),
    ]  # fmt: skip
    assert [p.stem for p in book.chapters] == ["one", "two"]
    assert book.pages["one"].bets == ("B",)

"""Contents read from pages: titles, boxes of needs, and what follows from them."""

import json

import pytest

from robot_perception.teaching.pages import contents
from robot_perception.teaching.pages.contents import Contents, Page, read

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
        {"cell_type": "code", "source": "B = Bet(1)", "metadata": {}},
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


CODE = """
tell("two words {number}", number=1)
Bet("one question?", {"an answer": "its reply"}, "an answer", because=lambda: "no word")
draw.seen(2, caption="three more words")
print("nobody reads this")
"""


def test_words_of_the_code_are_sentences_captions_and_bets(monkeypatch, tmp_path):
    monkeypatch.setattr(contents, "FIGURES", tmp_path)
    assert contents.told("one", CODE) == 3 + 2 + 4 + 2 + 3
    (tmp_path / "one").mkdir()
    (tmp_path / "one/figures.py").write_text(
        '@drawn(caption="a caption")\ndef seen(ax): ...\n\n'
        '@drawn(caption="of what is not drawn")\ndef other(ax): ...'
    )
    assert contents.told("one", CODE) == 14 + 2


def test_minutes_are_of_words_lines_explorers_and_exercises():
    one = Page("one", 1, "Part", ("# One\n\n" + "word " * 198, "A = Exploration(1)"), 200, 24)
    assert one.minutes() == 2 + 2 + 3


def test_only_code_that_a_page_shows_is_read(tmp_path):
    cells = [
        {"cell_type": "code", "source": "a = 1\nb = 2", "metadata": {}},
        {"cell_type": "code", "source": "c = 3", "metadata": {"tags": ["hide-input", "study"]}},
    ]
    (tmp_path / "one.ipynb").write_text(json.dumps({"cells": cells}))
    (tmp_path / "_toc.yml").write_text("root: one\nparts: []\n")
    assert read(tmp_path).pages["one"].lines == 2

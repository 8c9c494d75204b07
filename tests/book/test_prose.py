"""The prose of the book as a proof-reader reads it, and planted errors for each check."""

import ast
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

import pytest
from nbformat.v4 import new_code_cell, new_notebook

from tests.book import pages, proofreading
from tests.book.computing import code_cells, is_study
from tests.book.pages import DRAWN, Passage

CHAPTERS = frozenset(claim["chapter"] for claim in pages.claims())
CLAIMS = {claim["id"]: claim for claim in pages.claims()}


def read(check: Callable[[str], list[str]], passages: Iterable[Passage]) -> str:
    """Return a line for each passage in which a check finds something."""
    return proofreading.report((p, check(p.text)) for p in passages)


@pytest.fixture(scope="module")
def site() -> dict[str, str]:
    """The pages of the built site, by name."""
    found = pages.site()
    if not found:
        pytest.skip("ROBOT_PERCEPTION_SITE names no built site")
    return found


def test_nothing_is_still_to_be_written():
    wrong = read(proofreading.placeholders, (*pages.prose(), *pages.words()))
    assert not wrong, wrong


def test_no_page_shows_a_placeholder(site):
    shown = {name: proofreading.visible(page) for name, page in site.items()}
    wrong = proofreading.report((n, proofreading.PLACEHOLDER.findall(t)) for n, t in shown.items())
    assert not wrong, wrong


@pytest.mark.parametrize("text", ["XX the particles", "See XXX.", "TODO: cite", "how many???"])
def test_what_is_to_be_written_is_found(text):
    assert proofreading.placeholders(text)


def test_roman_numbers_and_code_are_no_placeholders():
    assert not proofreading.placeholders("Part XIX. Is it? $XX^T$ `TODO`\n\n```\n# FIXME\n```\n")


def test_kept_outputs_have_numbers_where_numbers_should_be():
    wrong = read(proofreading.holes, pages.printed())
    assert not wrong, wrong


def test_no_page_shows_a_number_that_is_none_or_a_name_in_its_place(site):
    shown = {name: proofreading.visible(page) for name, page in site.items()}
    wrong = proofreading.report((n, proofreading.holes(t)) for n, t in shown.items())
    assert not wrong, wrong


def test_no_state_of_an_explorer_says_a_number_that_is_none(site):
    told = pages.states()
    assert told
    wrong = proofreading.report((n, proofreading.numberless(t)) for n, t in told.items())
    assert not wrong, wrong


@pytest.mark.parametrize(
    ("text", "hole"),
    [
        ("It is nan m.", "nan"),
        ("from -inf to 3", "-inf"),
        ("(NaN)", "NaN"),
        ("The gain is None.", "None"),
        ("It is {gain:.2f}.", "{gain:.2f}"),
        ("{a[0]}", "{a[0]}"),
    ],
)
def test_holes_are_found(text, hole):
    assert proofreading.holes(text) == [hole]
    assert proofreading.numberless(text) == [hole] * hole.lower().endswith(("nan", "inf"))


@pytest.mark.parametrize("text", ["Which one changes? None.", "None of them", "a nanometre, info"])
def test_words_are_no_holes(text):
    assert not proofreading.holes(text)


def test_numbered_lists_run_from_one():
    wrong = read(proofreading.broken_lists, pages.prose())
    assert not wrong, wrong


@pytest.mark.parametrize(
    ("text", "broken"),
    [
        ("It says:\n\n1. One.\n2. Two,\n   long.\n\nAnd:\n\n1. Again.", []),
        ("1. One.\n3. Three.", ["1, 3"]),
        ("2. Two.\n3. Three.", ["2, 3"]),
        ("1. One.\n\n1. One again.\n2. Two.", ["1, 1, 2"]),
    ],
)
def test_lists_that_do_not_run_from_one_are_found(text, broken):
    assert proofreading.broken_lists(text) == broken


LISTED = {
    p.page: listed for p in pages.prose() if (listed := proofreading.statements(p.text)) is not None
}
REFERENCES: MappingProxyType[tuple[str, str], str] = MappingProxyType({})
"""References to a statement that is none of the list."""


def test_every_chapter_lists_what_the_paper_says():
    assert LISTED.keys() == CHAPTERS
    assert min(LISTED.values()) > 1


def test_statements_are_referred_to_by_a_number_of_the_list():
    told = [p for p in (*pages.prose(), *pages.words()) if p.page in LISTED]
    found = {p: proofreading.misnumbered(p.text, LISTED[p.page]) for p in told}
    others = {p: [w for w in words if (p.page, w) not in REFERENCES] for p, words in found.items()}
    wrong = proofreading.report(others.items())
    assert not wrong, wrong
    gone = REFERENCES.keys() - {(p.page, w) for p, words in found.items() for w in words}
    assert not gone, "no longer in the prose"


def test_references_without_a_number_or_beyond_the_list_are_found():
    wrong = proofreading.misnumbered("The first claim fails, statement 2 holds, claim 6 too.", 5)
    assert wrong == ["first claim", "claim 6"]
    assert (
        proofreading.statements("# A\n\n## What the paper says\n\n1. A.\n2. B.\n\n## B\n3. C") == 2
    )
    assert proofreading.statements("# A\n\n1. A.") is None


COUNTS = MappingProxyType(
    {
        ("arm_likelihoods", "twelve people"): "of the films of that exercise",
        ("covariance_intersection", "a hundred pairs"): "on which that exercise is scored",
        ("covariance_intersection", "twenty thousand random pairs"): "the `pairs` of that study",
        ("monobot", "Forty thousand runs"): "the `runs` of that study",
        ("monobot", "two thousand runs"): "what a reader is told to try",
        ("one_world", "Eight drives"): "of that exercise",
        ("one_world", "Eight rough drives"): "of that exercise",
        ("people_fusion", "160 draws"): "to choose rules, before anything was scored",
        ("people_fusion", "eight other sessions"): "on which rules were chosen",
        ("tutor_face", "18 faces"): "that somebody has marked in the recording",
        ("tutor_face", "eight people"): "of the recording with light from the side",
        ("tutor_following", "25 pictures"): "given in that exercise",
        ("tutor_following", "seven pictures"): "the answer of that exercise",
        ("visual_slam", "26 stereo pairs"): "of the recording of a car",
    }
)
"""Counts in prose that no claim is recorded over."""


def words_of(claim: Mapping) -> Iterable[str]:
    """Yield what a record says in words of a claim and of the numbers in it."""
    yield from (claim["statement"], claim["method"], claim["paper_value"], claim["note"])
    yield from claim["conditions"]
    yield from (
        number["about"] for number in (claim["value"], *claim["evidence"].values()) if number
    )
    for table in claim["tables"].values():
        yield from (table["about"], *table["columns"], *table["columns"].values(), *table["rows"])


def test_counts_of_films_and_people_are_those_that_claims_are_recorded_over():
    known: dict[str, set[int]] = {}
    for claim in CLAIMS.values():
        numbers = map(proofreading.numbers_in, words_of(claim))
        known.setdefault(claim["chapter"], set()).update(*numbers)
    told = [p for p in pages.prose() if p.page in CHAPTERS]
    found = {p: proofreading.uncounted(p.text, known[p.page]) for p in told}
    others = {p: [w for w in words if (p.page, w) not in COUNTS] for p, words in found.items()}
    wrong = proofreading.report(others.items())
    assert not wrong, wrong
    gone = COUNTS.keys() - {(p.page, w) for p, words in found.items() for w in words}
    assert not gone, "no longer in the prose"


def test_counts_that_nobody_has_recorded_are_found():
    text = "A hundred and sixty films, forty rendered scenes, 24 people and two rooms."
    assert proofreading.uncounted(text, {160, 40, 24}) == []
    assert proofreading.uncounted(text, {24}) == [
        "A hundred and sixty films",
        "forty rendered scenes",
    ]
    assert proofreading.numbers_in("over 40 runs, twenty-five of them; 2.5 m") == {40, 25, 2}


def cell(claim: str, table: str, row: str, column: str) -> float:
    """Return the estimate in a cell of a recorded table."""
    recorded = CLAIMS[claim]["tables"][table]
    value = recorded["rows"][row][list(recorded["columns"]).index(column)]
    return value[0] if isinstance(value, list) else value


def constant(stem: str, name: str) -> float:
    """Return a number that a study cell binds to a name."""
    cells = (ast.parse(cell.source) for cell in code_cells(stem) if is_study(cell))
    for node in (node for cell in cells for node in cell.body if isinstance(node, ast.Assign)):
        if [getattr(target, "id", "") for target in node.targets] == [name]:
            return ast.literal_eval(node.value)
    raise LookupError(f"no study cell of {stem} binds {name} to a number")


LEVEL = constant("recordings_robots", "LEVEL")
SHARES = MappingProxyType(
    {
        ("colour_and_shape", "One card in forty"): cell(
            "four-experiments", "lost", "both", "rectangle"
        ),
        ("recordings_robots", "one chance in ten thousand"): 1 - LEVEL,
        ("your_own_data", "two in three"): cell(
            "eigenfaces", "lights", "from the side, too", "strangers"
        ),
    }
)
"""The recorded numbers that prose rounds to shares in words."""
WITHOUT = frozenset({"decisions"})
"""Pages whose shares are of the past, or of what is not recorded."""


def test_shares_in_words_are_the_recorded_numbers_rounded():
    found = {
        (p.page, words): share
        for p in pages.prose()
        if p.page not in WITHOUT
        for words, share in proofreading.shares(p.text).items()
    }
    assert not found.keys() ^ SHARES.keys(), "typed or left without a word of where it stands"
    for place, share in found.items():
        assert proofreading.is_rounded(share, SHARES[place]), (place, SHARES[place])


def test_shares_in_words_are_found_and_compared():
    text = "Four in ten pass, in three scenes of ten it fails; two pictures of one person."
    assert proofreading.shares(text) == {
        "Four in ten": (4, 10),
        "three scenes of ten": (3, 10),
    }
    assert proofreading.is_rounded((4, 10), 0.38)
    assert not proofreading.is_rounded((3, 10), 0.23)


def test_a_folded_output_is_named_by_what_it_holds():
    books = {path.name: pages.notebook(path) for path in pages.NOTEBOOKS}
    wrong = proofreading.report((n, proofreading.unnamed_folds(b)) for n, b in books.items())
    assert not wrong, wrong


def test_no_fold_of_a_page_says_code_and_holds_a_result(site):
    wrong = proofreading.report((n, proofreading.mislabelled_folds(p)) for n, p in site.items())
    assert not wrong, wrong
    assert any(proofreading.PROMPT in page for page in site.values())


def test_unnamed_folds_are_found():
    named = {"code_prompt_show": "Show all rows"}
    cells = [
        new_code_cell("table.show()", id="bare", metadata={"tags": ["hide-output"]}),
        new_code_cell("show_source(f)", id="code", metadata={"tags": ["hide-output"]}),
        new_code_cell(
            "table.show()", id="seen", metadata={"tags": ["hide-output"], "mystnb": named}
        ),
        new_code_cell(
            "table.show()",
            id="right",
            metadata={"tags": ["remove-input", "hide-output"], "mystnb": named},
        ),
        new_code_cell("table.show()", id="code-alone", metadata={"tags": ["hide-input"]}),
    ]
    assert proofreading.unnamed_folds(new_notebook(cells=cells)) == ["bare", "seen"]
    fold = '<details class="admonition hide"><p>Show the code</p>{}</details>'
    assert proofreading.mislabelled_folds(fold.format("<table></table>"))
    assert not proofreading.mislabelled_folds(fold.format("<pre>a = 1</pre>") + "<table></table>")


INK = MappingProxyType(
    {
        "black is what it does not see": "of a photograph, in both themes",
        "white lamp": "the colour of its light",
        "steady white light": "the same",
    }
)
"""What is black or white, whatever the theme."""


def colours(text: str) -> list[str]:
    """Return the colours of a caption that the theme changes."""
    for words in INK:
        text = text.replace(words, "")
    return proofreading.theme_colours(text)


def test_captions_name_no_colour_that_the_theme_changes():
    drawn = [p for p in pages.words() if p.place.endswith(DRAWN) or p.place.startswith("cell ")]
    wrong = read(colours, drawn)
    assert not wrong, wrong


def test_colours_that_the_theme_changes_are_found():
    assert colours("the mean of the white rectangle, the true path (Black)") == ["white", "Black"]
    assert not colours("a blackboard; {white[2]:.0f} % of the time; black is what it does not see")


def test_texts_are_what_is_said_and_not_what_is_documented():
    code = 'return g("said " "here", caption=f"and {x} too", k="no")'
    source = f'def f():\n    """Not this one."""\n    {code}'
    assert pages.said(source) == ["said here", "and ", " too"]


def test_a_page_shows_neither_code_nor_formulas():
    page = "<p>A <b>x</b><pre>{a}</pre> \\(\\frac{n}{m}\\)</p><svg>{b}</svg><td>{c}</td>&lt;"
    assert proofreading.visible(f"<article>{page}</article>") == "A x\n{c}\n<"

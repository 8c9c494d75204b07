"""What we say that a reader finds can be false, and each part of it says something.

Nothing is computed here: the findings are those that are recorded of all states. Of some disturbed
ones it is recorded whether they bear it out, so that another predicate is noticed.
"""

import ast
from typing import Any

import pytest

from explorables.snapshots import finding_of
from tests.book import predicates, states
from tests.book.computing import COMPUTING, module

RECORDED = [(stem, name) for stem in COMPUTING for name in states.recorded(stem)["explorers"]]
RECORD = "python -m tests.tools.snapshot {} --write"
EQUIVALENT = {
    "ci-weight": (
        "some are above and not all, so some are not above and not all",
        "printed > 1 + 1e-06 -> printed <= 1 + 1e-06",
    ),
    "guesses-weights": (
        "of the largest number of guesses, which the text names and the predicate does not ask",
        "width == WIDTHS[0] -> width != WIDTHS[0]",
        " for width, *_, count in found if width == WIDTHS[0] ->  for width, *_, count in found",
    ),
    "walls-replay": (
        "how many calls there are is no finding of a state",
        "len(calls) == CALLS == len(asked()) -> len(calls) == CALLS",
    ),
}
"""By explorer the reason why weakened predicates say the same of all findings, and which."""


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(("stem", "name"), RECORDED, ids=[f"{s}-{n}" for s, n in RECORDED])
def test_a_finding_can_be_false_and_each_of_its_parts_can_make_it_so(stem: str, name: str):
    said = states.recorded(stem)["explorers"][name]
    found = [finding_of(finding) for finding, *_ in said["states"]]
    written = predicates.source(module(stem), name)
    assert predicates.outcome(written.predicate(), found) is True
    judged = predicates.judged_of(module(stem), name, said)
    assert False in judged.verdicts.values()
    left = [words.partition(": ")[2] for words in judged.left]
    _, *equivalent = EQUIVALENT.get(name, [""])
    assert sorted(left) == sorted(equivalent), "\n".join(judged.left)
    assert predicates.plain(judged.verdicts) == said["finds"], RECORD.format(stem)


FOUND = [[away, error] for away in (0.5, 1, 3, 5, 6) for error in (3.0 + 4 * away,)]


def weak(text: str, stored: list[Any]) -> list[str]:
    """Return what is not noticed of a predicate that is written as a lambda."""
    expression = ast.parse(text, mode="eval").body
    source = predicates.Source(predicates, expression, {})
    judged = predicates.judged(source, predicates.Recorded(stored, [len(stored)]))
    return [*judged.left] if False in judged.verdicts.values() else ["never false"]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("lambda found: all(e > a for a, e in found) or True", "never false"),
        ("lambda found: all(e > a for a, e in found) and len(found) > 0", "-> all("),
        ("lambda found: all(e > 0 for a, e in found if a > 0 or a < 1)", "if a > 0 or a < 1 ->"),
    ],
)
def test_a_part_that_says_nothing_is_noticed(text: str, what: str):
    assert any(what in line for line in weak(text, FOUND)), weak(text, FOUND)


def test_each_part_of_a_good_predicate_is_noticed():
    text = (
        "lambda found: min(e for a, e in found if a >= 5) > 12"
        " and max(e for a, e in found if a <= 1) < 8"
    )
    assert not weak(text, FOUND)
    words = [words for words, _ in predicates.weakenings(ast.parse(text, mode="eval").body)]
    assert sum(" or " in line.partition(" -> ")[2] for line in words) == 1


def test_parts_that_decide_are_changed_one_at_a_time():
    text = "lambda f: not a and (b.any() | all(c)) and 1 < x <= y and {z for z in f if z in q}"
    words = [words for words, _ in predicates.weakenings(ast.parse(text, mode="eval").body)]
    changed = {line.partition(" -> ")[2] for line in words}
    wanted = {
        "a",
        "b.all()",
        "any(c)",
        "b.any() & all(c)",
        "1 >= x <= y",
        "1 < x > y",
        "x <= y",
        "1 < x",
        " for z in f",
        "z not in q",
    }
    assert wanted < changed
    assert len(words) == len(wanted) + 1 + 4  # the other operator, and each conjunct dropped

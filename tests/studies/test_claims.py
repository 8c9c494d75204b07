"""A claim is declared on a function of rows, and its verdict follows from what that gives."""

from types import ModuleType

import pytest

from studies.claims import Claim, Finding, claims_in
from studies.intervals import Interval, exact
from studies.says import When
from studies.tables import Table
from studies.verdicts import Accepted, Condition, Verdict
from tests.studies.entries import WORDS, study


def declare(compute, name="some-claim", module="elsewhere.walls", rows=1.5, **changes):
    compute.__module__ = module
    return study(rows).claim(name, **(WORDS | {"sabotage": {}} | changes))(compute)


def test_a_claim_keeps_every_word_of_its_declaration():
    words = WORDS | {"accepted": Accepted(3.0, 4.0, "why"), "paper_value": "three"}
    some = declare(lambda rows: None, **words)
    assert {name: getattr(some, name) for name in words} == words
    assert some.chapter == "walls"


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"basis": "hearsay"}, "hearsay"),
        ({"statement": " "}, "'some-claim' needs a statement"),
        ({"method": ""}, "needs a method"),
        ({"place": ""}, "needs a place"),
        ({"says": "it is so"}, r"must say \{value\} once"),
        ({"says": "{value} is {value}"}, r"must say \{value\} once"),
        ({"form": "guess"}, "guess"),
        ({"name": ""}, "needs a id"),
    ],
)
def test_a_declaration_that_says_too_little_is_refused(changes, match):
    with pytest.raises(ValueError, match=match):
        declare(lambda rows: None, **changes)


@pytest.mark.parametrize(
    ("basis", "value", "conditions", "verdict"),
    [
        ("mathematics", Interval(1.5, 1.2, 1.8), (), Verdict.REPRODUCED),
        ("substitute", Interval(1.5, 1.2, 1.8), (Condition("it rains", True),), "conditional"),
        ("paper", Interval(3.0, 2.5, 3.5), (), Verdict.REFUTED),
        ("substitute", Interval(3.0, 2.5, 3.5), (), Verdict.NOT_REPRODUCED),
        ("paper", Interval(1.5, 0.9, 1.8), (), Verdict.INCONCLUSIVE),
    ],
)
def test_the_verdict_follows_from_the_finding(basis, value, conditions, verdict):
    some = declare(lambda rows: Finding(value, conditions=conditions), basis=basis)
    assert some.verdict(some.find()) == verdict


def test_what_cannot_be_measured_must_say_why():
    with pytest.raises(ValueError, match="must say in its note why"):
        Finding(None)
    some = declare(lambda rows: Finding(None, note="Nobody has the recording."))
    assert some.verdict(some.find()) == Verdict.UNTESTABLE


def test_the_value_of_a_sabotage_is_read_of_its_rows_by_the_same_function():
    dry = (Condition("dry", True),)
    some = declare(lambda rows: Finding(exact(rows), {"twice": exact(2 * rows)}, conditions=dry),
                   sabotage={"a gain of three": study(3.0)})  # fmt: skip
    assert some.find() == Finding(exact(1.5), {"twice": exact(3.0)}, conditions=dry)
    (change,) = some.sabotages
    assert some.sabotaged(change) == Finding(exact(3.0))  # of the value, nothing else


def test_a_value_of_its_own_serves_where_a_sabotage_has_less_to_say():
    def more(rows, value):
        assert rows == 1.5, "of a sabotage the value alone is asked for"
        return Finding(value, {"twice": exact(2 * value.estimate)})

    some = declare(more, value=exact, sabotage={"a gain of three": study(3.0)})
    assert some.find() == Finding(exact(1.5), {"twice": exact(3.0)})
    assert some.sabotaged(some.sabotages[0]) == Finding(exact(3.0))


def plain(**fields):
    """Return a claim without a function of its own."""
    return study(1.5).claim("plain", **(WORDS | {"sabotage": {}, "value": exact} | fields))


def test_a_claim_without_a_function_is_found_by_its_fields():
    table = Table({"a": [1.0]}, {"b": ""})
    some = plain(
        evidence={"twice": lambda rows: exact(2 * rows)},
        tables={"one": lambda rows: table},
        conditions=(When("dry", outside=lambda rows: exact(2 * rows)),),
        note=lambda rows: f"Of {rows}.",
        sabotage={"a gain of three": study(3.0)},
    )
    dry = (Condition("dry", True),)
    assert some.find() == Finding(exact(1.5), {"twice": exact(3.0)}, {"one": table}, dry, "Of 1.5.")
    assert some.verdict(some.find()) == Verdict.CONDITIONAL
    assert some.sabotaged(some.sabotages[0]) == Finding(exact(3.0))
    assert plain(note="A note.").find() == Finding(exact(1.5), note="A note.")
    assert plain().module == "tests.studies.entries"


def test_a_claim_needs_a_value_or_a_function():
    with pytest.raises(ValueError, match="'plain' needs a value, or a function that finds it"):
        plain(value=None)


def test_claims_of_a_module_are_those_declared_in_it_in_their_order():
    module = ModuleType("elsewhere.walls")
    module.second = declare(lambda rows: None, "b")
    module.first = declare(lambda rows: None, "a")
    module.borrowed = declare(lambda rows: None, "c", "elsewhere.other")
    module.number = 3
    assert [c.id for c in claims_in(module)] == ["b", "a"]
    assert all(isinstance(c, Claim) for c in claims_in(module))


def test_a_sabotage_says_what_it_changes():
    with pytest.raises(ValueError, match="must say what it changes"):
        declare(lambda rows: None, sabotage={" ": study(3.0)})

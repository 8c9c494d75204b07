"""A claim is declared on its computation, and its verdict follows from what that gives."""

from types import ModuleType

import pytest

from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.teaching.claims import Finding, Size
from robot_perception.teaching.studies import Change, Claim, claims_in
from robot_perception.teaching.verdicts import Accepted, Condition, Verdict
from tests.teaching.entries import SIZES, WORDS


def declare(compute, name="some-claim", module="elsewhere.chapters.walls.growth", **changes):
    compute.__module__ = module
    return SIZES.claim(name, **(WORDS | changes))(compute)


def test_a_claim_keeps_every_word_of_its_declaration():
    words = WORDS | {"accepted": Accepted(3.0, 4.0, "why"), "paper_value": "three"}
    some = declare(lambda size: None, **words)
    assert {name: getattr(some, name) for name in words} == words


def test_the_chapter_is_the_package_of_the_function():
    assert declare(lambda size: None).chapter == "walls"
    assert declare(lambda size: None, module="elsewhere.chapters.b.c.d").chapter == "b"
    with pytest.raises(ValueError, match=r"outside the chapters: robot_perception\.walls"):
        declare(lambda size: None, module="robot_perception.walls")


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"basis": "hearsay"}, "hearsay"),
        ({"statement": " "}, "'some-claim' needs a statement"),
        ({"method": ""}, "needs a method"),
        ({"place": ""}, "needs a place"),
        ({"name": ""}, "needs a id"),
    ],
)
def test_a_declaration_that_says_too_little_is_refused(changes, match):
    with pytest.raises(ValueError, match=match):
        declare(lambda size: None, **changes)


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
    some = declare(lambda size: Finding(value, conditions=conditions), basis=basis)
    assert some.verdict(some.find()) == verdict


def test_what_cannot_be_measured_must_say_why():
    with pytest.raises(ValueError, match="must say in its note why"):
        Finding(None)
    some = declare(lambda size: Finding(None, note="Nobody has the recording."))
    assert some.verdict(some.find()) == Verdict.UNTESTABLE


def test_a_size_is_asked_for_by_name_and_another_is_refused():
    some = declare(lambda size: Finding(exact(1.0 + (size is Size.FULL))))
    assert some.find("full") == some.find(Size.FULL) != some.find()
    with pytest.raises(ValueError, match="'small'"):
        some.find("small")


def test_claims_of_a_module_are_those_declared_in_it_in_their_order():
    module = ModuleType("elsewhere.chapters.walls.growth")
    module.second = declare(lambda size: None, "b")
    module.first = declare(lambda size: None, "a")
    module.borrowed = declare(lambda size: None, "c", "elsewhere.chapters.walls.other")
    module.number = 3
    assert [c.id for c in claims_in(module)] == ["b", "a"]
    assert all(isinstance(c, Claim) for c in claims_in(module))


def test_a_sabotage_says_what_it_changes():
    with pytest.raises(ValueError, match="must say what it changes"):
        declare(lambda size: None, sabotage=Change(" "))

"""Badges, tables and the scorecard show what the ledger records, and escape it."""

import math

import pytest

from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.teaching import badges as module
from robot_perception.teaching.claims import Claim, Finding
from robot_perception.teaching.ledger import Ledger, entry
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Basis, Condition


def made(name, finding, **changes):
    fields = {
        "id": name,
        "chapter": "walls",
        "paper": "perception-issues",
        "place": "Fig. 1 & Table 2",
        "basis": Basis.SUBSTITUTE,
        "statement": "Distances are <squared>.",
        "method": "counted",
        "accepted": Accepted(1, math.inf, "a round number", "our choice"),
        "compute": lambda size, rng: finding,
    }
    claim = Claim(**(fields | changes))
    return entry(claim, finding)


@pytest.fixture
def ledger(monkeypatch):
    good = Finding(
        Interval(1.5, 1.4, 1.6, "m"),
        tables={"all of it": Table({"first": [2]}, {"x <m>": "a length"})},
        conditions=(Condition("the chain is simple", True),),
    )
    shown = Ledger(
        (
            made("good", good),
            made("bad", Finding(exact(0))),
            made("dark", Finding(None, note="Nobody has it.")),
        )
    )
    monkeypatch.setattr(module, "recorded", lambda: shown)
    return shown


def test_badge_names_verdict_claim_and_place_escaped(ledger):
    shown = module.badges("good", "bad", "dark")
    html = shown.bundle["text/html"]
    assert "rp-badge--conditional" in html
    assert "rp-badge--not-reproduced" in html
    assert "Fig. 1 &amp; Table 2" in html
    assert "<squared>" not in html
    assert repr(shown).splitlines() == [
        "good: conditional (Fig. 1 & Table 2; ours 1.5 [1.4, 1.6] m)",
        "bad: not reproduced (Fig. 1 & Table 2; ours 0)",
        "dark: untestable (Fig. 1 & Table 2; ours –)",
    ]


def test_badge_of_an_unknown_claim_is_an_error(ledger):
    with pytest.raises(KeyError, match="good, bad, dark"):
        module.badges("ugly")


def test_table_has_anchors_only_on_the_scorecard(ledger):
    html = module.claim_table().bundle["text/html"]
    assert 'id="good"' in html
    assert "<dt>Stands on</dt><dd>a substitute for the paper's world</dd>" in html.replace(
        "&#x27;", "'"
    )
    assert "<dt>Holds from 1</dt><dd>Our choice (another verdict with the lower end 0.4" in html
    assert "x &lt;m&gt;" in html
    assert 'id="good"' not in module.claim_table("walls").bundle["text/html"]
    with pytest.raises(ValueError, match="kitchen"):
        module.claim_table("kitchen")


def test_score_counts_every_entry(ledger):
    assert repr(module.score()) == "1 conditional, 1 not reproduced, 1 untestable"


def test_text_table_shows_conditions(ledger):
    line = module.as_text(ledger).splitlines()[2]
    assert line.endswith("the chain is simple")


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-math.inf, 2.0, "up to 2"),
        (1.0, math.inf, "from 1"),
        (1.0, 1.0, "at 1"),
        (1, 2, "from 1 to 2"),
    ],
)
def test_ranges_are_written_in_words(low, high, words):
    some = made("x", Finding(exact(1.0)), accepted=Accepted(low, high, "counted"))
    assert f"<dt>Holds {words}</dt><dd>Set by theory: counted</dd>" in module._details(some)


def test_every_verdict_and_basis_has_words():
    assert set(module.EXPLAINED) == set(module.Verdict)
    assert set(module.STANDS_ON) == set(Basis)

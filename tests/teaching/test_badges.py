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
    monkeypatch.setenv("ROBOT_PERCEPTION_PAGE", "1")  # links as a page has them
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


def test_rows_lead_to_the_chapter_and_back_and_say_on_what_a_claim_depends(ledger):
    everything, chapter = (module.claim_table(*c).bundle["text/html"] for c in ((), ("walls",)))
    assert 'href="walls.html">good</a>' in everything
    assert 'href="scorecard.html#good">good</a>' in chapter
    for html in (everything, chapter):
        assert html.count("<p>Only if the chain is simple.</p>") == 1


@pytest.mark.parametrize(
    ("accepted", "value", "words"),
    [
        (
            Accepted(1, 3, "why", "our choice"),
            Interval(1.5, 1.4, 1.6),
            "the lower end 0.4 further in",
        ),
        (Accepted(1, 3, "why", "our choice"), Interval(9, 8, 10), "the upper end 5 further out"),
        (Accepted(1, 3, "why", "our choice"), Interval(2, 0.5, 6), "both ends 3 further out"),
        (Accepted(1, 3, "why", "paper"), Interval(2, 2, 2), "Set by the paper: why"),
    ],
)
def test_who_set_a_range_and_where_the_verdict_turns(accepted, value, words):
    some = made("x", Finding(value), accepted=accepted, paper_value="a <half>")
    assert words in module._details(some)
    assert "<small>Paper: a &lt;half&gt;</small>" in module._row(some, anchor=False)


def test_columns_of_the_text_table_stand_below_their_names(ledger):
    head, line, first, *_ = module.as_text(ledger).splitlines()
    for name, value in (("verdict", "conditional"), ("paper", "–"), ("ours", "1.5 [")):
        assert head.index(name) == first.index(value)
        assert line[head.index(name) - 1 : head.index(name) + 1] == " -"


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

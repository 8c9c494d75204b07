"""Badges, tables and the scorecard show what the ledger records, and escape it."""

import math

import pytest

from robot_perception.teaching import badges as module
from robot_perception.teaching.claims import Accepted, Claim, Condition, Finding, Interval, Ledger


@pytest.fixture
def ledger(monkeypatch):
    def claim(name, value, **changes):
        fields = {
            "id": name,
            "chapter": "walls",
            "paper": "perception-issues",
            "place": "Fig. 1 & Table 2",
            "statement": "Distances are <squared>.",
            "paper_value": "",
            "method": "counted",
            "accepted": Accepted(1, math.inf, "theory"),
            "compute": lambda size, rng: value,
        }
        return Claim(**(fields | changes)).run()

    good = Finding(
        Interval(1.5, 1.4, 1.6, "m"), conditions=(Condition("the chain is simple", True),)
    )
    shown = Ledger((claim("good", good), claim("bad", Finding(Interval.exact(0)))))
    monkeypatch.setattr(module, "recorded", lambda: shown)
    return shown


def test_badge_names_verdict_claim_and_place_escaped(ledger):
    shown = module.badges("good", "bad")
    html = shown.bundle["text/html"]
    assert "rp-badge--conditional" in html
    assert "rp-badge--refuted" in html
    assert "Fig. 1 &amp; Table 2" in html
    assert "<squared>" not in html
    assert (
        repr(shown).splitlines()[0] == "good: conditional (Fig. 1 & Table 2; ours 1.5 [1.4, 1.6] m)"
    )


def test_badge_of_an_unknown_claim_is_an_error(ledger):
    with pytest.raises(KeyError, match="good, bad"):
        module.badges("ugly")


def test_table_has_anchors_only_on_the_scorecard(ledger):
    html = module.claim_table().bundle["text/html"]
    assert 'id="good"' in html
    assert "<dt>Holds from 1</dt><dd>theory</dd>" in html
    assert 'id="good"' not in module.claim_table("walls").bundle["text/html"]
    with pytest.raises(ValueError, match="kitchen"):
        module.claim_table("kitchen")


def test_score_counts_every_entry(ledger):
    assert repr(module.score()) == "1 conditional, 1 refuted"


def test_text_table_shows_conditions(ledger):
    line = module.as_text(ledger).splitlines()[2]
    assert line.endswith("the chain is simple")


def test_open_ranges_are_written_in_words():
    assert module._range([None, 2.0]) == "up to 2"
    assert module._range([1.0, None]) == "from 1"
    assert module._range([1.0, 1.0]) == "at 1"

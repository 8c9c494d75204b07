"""Badges and the claim table of a chapter show what the ledger records, and escape it."""

import pytest

from robot_perception.teaching.scores import badges as module
from studies.claims import Finding
from studies.intervals import Interval, exact
from studies.ledger import Ledger
from studies.verdicts import Basis, Condition
from tests.studies.entries import made

LENGTH = "The length is 1.50\N{NO-BREAK SPACE}m [1.40, 1.60]; at least 1\N{NO-BREAK SPACE}m wanted"


@pytest.fixture
def ledger(monkeypatch):
    good = Finding(
        Interval(1.5, 1.4, 1.6, "m", "of 3 < 4 runs"),
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
    monkeypatch.setenv("EXPLORABLES_PAGE", "1")  # links as a page has them
    return shown


def test_badge_names_verdict_claim_and_place_escaped(ledger):
    shown = module.badges("good", "bad", "dark")
    html = shown.bundle["text/html"]
    assert "rp-badge--conditional" in html
    assert "rp-badge--not-reproduced" in html
    assert "Fig. 1 &amp; Table 2" in html
    assert "<squared>" not in html
    assert repr(shown).splitlines() == [
        f"good (Fig. 1 & Table 2): {LENGTH}: conditional only if the chain is simple.",
        "bad (Fig. 1 & Table 2): The length is 0; at least 1 wanted: not reproduced.",
        "dark (Fig. 1 & Table 2): Nobody has it.",
    ]
    assert f'<span class="rp-badge-result">{LENGTH}.</span>' in html


def test_badge_is_where_the_scorecard_leads_and_leads_there(ledger):
    html = module.badges("good").bundle["text/html"]
    assert 'id="claim-good"' in html
    assert 'href="scorecard.html#good"' in html


def test_badge_of_an_unknown_claim_is_an_error(ledger):
    with pytest.raises(KeyError, match="good, bad, dark"):
        module.badges("ugly")


def test_table_of_a_chapter_leads_to_the_cards_and_says_on_what_a_claim_depends(ledger):
    html = module.claim_table("walls").bundle["text/html"]
    assert 'href="scorecard.html#good">good</a>' in html
    assert 'id="' not in html, "the badge has that name"
    assert html.count("Only if the chain is simple.") == 1
    assert html.count("<tr>") == 4
    assert "Andrade-Cetto 2004, Fig. 1 &amp; Table 2" in html
    assert f'<td class="rp-text">{LENGTH}.<br><small>of 3 &lt; 4 runs</small></td>' in html
    assert '<td class="rp-text">Nobody has it.<br><small></small></td>' in html


def test_table_of_an_unknown_chapter_is_an_error(ledger):
    with pytest.raises(ValueError, match="kitchen"):
        module.claim_table("kitchen")


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


def test_every_verdict_and_basis_has_words():
    assert set(module.EXPLAINED) == set(module.Verdict)
    assert set(module.STANDS_ON) == set(Basis)

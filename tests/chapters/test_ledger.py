"""The recorded ledger is what the library computes: same claims, same words, same verdicts."""

from dataclasses import asdict

import pytest

from robot_perception import chapters
from robot_perception.teaching.claims import Ledger, Verdict
from robot_perception.teaching.records import records

CLAIMS = chapters.claims()
RECORDED = Ledger.read(records() / "claims.json")
DECLARED = ("id", "chapter", "paper", "place", "statement", "paper_value", "method", "seed")


def test_ledger_holds_every_claim_once_in_the_order_of_the_book():
    assert [entry.id for entry in RECORDED.entries] == [claim.id for claim in CLAIMS]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_record_says_what_the_experiment_declares(claim):
    entry = asdict(RECORDED[claim.id])
    assert {key: entry[key] for key in DECLARED} == {key: getattr(claim, key) for key in DECLARED}
    assert entry["accepted"] == (claim.accepted and claim.accepted.ends())
    assert entry["size"] == "full", "record the ledger with `make reproduce`"


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_quick_verdict_is_the_recorded_one(claim):
    entry = claim.run("quick")
    assert entry.verdict == RECORDED[claim.id].verdict, f"{entry.interval}: {entry.note}"
    assert set(entry.evidence) <= set(RECORDED[claim.id].evidence), "full size shows all of quick"


@pytest.mark.slow
@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_full_run_is_the_record(claim):
    assert claim.run("full").verdict == RECORDED[claim.id].verdict


def test_same_seed_same_finding():
    claim = next(c for c in CLAIMS if c.id == "monte-carlo-unbiased")
    assert claim.run("quick") == claim.run("quick")


def test_every_verdict_is_a_known_one():
    assert {entry.verdict for entry in RECORDED.entries} <= set(Verdict)

"""The claims of the chapter: the record, and what their findings must say."""

import pytest

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "covariance_intersection"


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("covariance_intersection").entries} == {
        "ci-consistent": "reproduced",
        "kalman-overconfident": "reproduced",
        "ci-omega-least": "refuted",
        "ci-weight-reliable": "reproduced",
        "ci-reduces": "conditional",
        "erratum-eq3": "refuted",
    }


def test_the_worst_of_two_is_twice_and_no_more():
    found = quick("kalman-overconfident")
    assert found.evidence["largest"].estimate == pytest.approx(2, abs=1e-3)
    assert found.evidence["largest"].estimate <= 2 + 1e-12


def test_a_weight_at_an_end_makes_equation_4_worse_than_the_better_belief_alone():
    """Of the pairs with such a weight; of equal ones, which no draw gives, it is not so."""
    found = quick("ci-omega-least").evidence
    assert found["of these, worse than the better belief alone"].estimate > 0.99
    assert found["sonar with camera"].estimate > 1.5

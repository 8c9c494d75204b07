"""The claims of the chapter: the record, and what their findings must say."""

import numpy as np
import pytest

from robot_perception.chapters.covariance_intersection import weights
from robot_perception.chapters.covariance_intersection.consistency import pairs
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


def test_the_error_that_is_left_is_that_of_drawn_errors():
    """The closed form against a million draws of independent errors of one pair.

    It is one of which the two weights make something different.
    """
    rng = np.random.default_rng(3)
    a, b = pairs(1, rng=rng)
    found = weights.compare(a, b, weights.Config())
    drawn = [rng.multivariate_normal([0, 0], one.cov[0], 10**6) for one in (a, b)]
    left = []
    for omega in (found.printed, found.least):
        inverses = ((1 - omega) * np.linalg.inv(a.cov[0]), omega * np.linalg.inv(b.cov[0]))
        mean = sum(x @ inverse for x, inverse in zip(drawn, inverses, strict=True))
        mean = mean @ np.linalg.inv(sum(inverses))
        left.append(np.sqrt((mean**2).sum(axis=1).mean()))
    assert left[0] > 1.5 * left[1]
    assert weights._errors(found)[0] == pytest.approx(left[0] / left[1], rel=0.005)


def test_what_is_reduced_is_so_with_any_weight_but_by_another_share():
    found = quick("ci-reduces").evidence
    assert found["the same with the weights of eq. 4 exchanged"].estimate < 1
    gained = found["determinant over that with them exchanged"]
    assert gained.estimate < 0.5
    assert gained.high < 1

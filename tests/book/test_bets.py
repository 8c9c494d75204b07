"""The right answers of bets are what is computed."""

import pytest

from robot_perception.teaching.bets import Bet
from tests.book.computing import found

BETS = found(Bet)


@pytest.mark.parametrize(("stem", "bet"), BETS, ids=lambda v: getattr(v, "right", v))
def test_the_right_answer_is_what_is_computed(stem: str, bet: Bet):
    assert bet.right in bet.replies
    assert bet.because(), f"{stem}: {bet.question}"
    assert bet.question.split()[0] in bet._repr_mimebundle_()["text/html"]

"""The right answers of bets are what is computed."""

import pytest

from tests.book.registry import BET, Declared, every


@pytest.mark.parametrize("bet", every(BET), ids=lambda bet: bet.id)
def test_the_right_answer_is_what_is_computed(bet: Declared):
    bet = bet.value()
    assert bet.right in bet.replies
    assert bet.because(), bet.question
    assert bet.question.split()[0] in bet._repr_mimebundle_()["text/html"]

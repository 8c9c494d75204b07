"""The film of the page: its readings are those of the session, and it shows what the text tells."""

import numpy as np
import pytest

from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import KNOWN, NOW, RULES, page_session, scene
from robot_perception.chapters.people_fusion import clock
from robot_perception.people.aggregation import Aggregator


@pytest.fixture(scope="module")
def instants():
    return page.instants()


def test_it_runs_as_fast_as_the_session_went_by(instants):
    assert [one.time for one in instants] == clock.TIMES.tolist()
    np.testing.assert_allclose(np.diff(clock.TIMES), 1 / clock.FPS)


def test_signals_and_people_are_those_of_the_other_drawings(instants):
    """The sonars' round at a moment of the explorer is the last one at the next frame, too."""
    shown = min(instants, key=lambda one: abs(one.time - NOW))
    after = next(one for one in instants if one.time > NOW)
    np.testing.assert_array_equal(after.echoes, scene(NOW).echoes)
    assert np.abs(shown.people[:, :2] - scene(NOW).people).max() < 0.15  # of an eighth of a second


def test_the_committee_is_that_of_the_loop_on_the_page(instants):
    """The robot stands; each frame has what all readings until then have made."""
    known, aggregator, k = page_session(), Aggregator(RULES), 0
    hypotheses = aggregator.start()
    for one in instants:
        while known.times[k] <= one.time:
            hypotheses, _ = aggregator.step(hypotheses, known.found(k), np.zeros(3))
            k += 1
        for name in ("mean", "cov", "weight", "identity"):
            ours, theirs = getattr(one.hypotheses, name), getattr(hypotheses, name)
            np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_a_sonar_makes_a_place_of_a_direction(instants):
    assert clock.spread(instants, RULES, 0, 2.0) > 1.9
    assert clock.spread(instants, RULES, 0, 4.8) < 0.35
    breathing = [clock.spread(instants, RULES, 0, t) for t in np.arange(7.6, 10.3, 0.2)]
    assert min(breathing) < 0.6
    assert max(breathing) > KNOWN

"""What the chapter tells a reader to find, in every state of its explorers."""

from itertools import pairwise, product

import numpy as np
import pytest

from robot_perception.chapters.anchored_slam import gauge, invented, rails
from robot_perception.chapters.anchored_slam.explorers import (
    FIVE,
    MOVED,
    REFERENCES,
    ROBOT_2,
    TURNED,
    refer,
)
from robot_perception.chapters.anchored_slam.gauge import TURN, TURN_STEP
from robot_perception.chapters.anchored_slam.recordings import UTIAS
from tests.chapters.findings import ExplorerTests

DEVIATIONS, OFFSETS = (REFERENCES.controls[name].values for name in ("deviation", "offset"))
TIED = ("anchor", "external sensor")


class TestExplorers(ExplorerTests):
    explorers = (TURNED, MOVED, REFERENCES, ROBOT_2, FIVE)


# Worlds moved


def test_turned_by_whatever_nothing_differs():
    assert max(TURNED.found()) < 1e-12


def test_picture_and_words_say_what_was_computed():
    for state in MOVED.parameters(amount=2):
        world, said = MOVED.state(**state), MOVED.described(**state)
        texts = [text.get_text() for text in MOVED.drawn(**state).texts]
        (words,) = [text for text in texts if text.startswith("largest")]
        assert f"{world.metres:.2f} m" in words
        assert words.removeprefix("largest residual ") in said
        assert ("heading" in words) == (world.radians > 0)
        turned = state["direction"].startswith("turn")
        assert (f"by {np.degrees(2 * TURN_STEP):g}°." if turned else "by 2 m.") in said


# The references


def test_anchor_and_camera_have_one_band_and_not_one_error():
    for deviation in DEVIATIONS:
        one, other = (refer(kind, deviation, 0.1) for kind in TIED)
        np.testing.assert_allclose(one.deviations, other.deviations, rtol=1e-9)
        assert not np.allclose(one.last_errors, other.last_errors)


@pytest.mark.parametrize("kind", TIED)
def test_the_band_shrinks_and_more_slowly_with_a_worse_reference(kind):
    bands = [refer(kind, deviation, 0.1).deviations[:, 1] for deviation in DEVIATIONS]
    assert all((np.diff(one) < 0).all() for one in bands)
    assert all((a[1:] < b[1:]).all() for a, b in pairwise(bands))


def test_a_wrong_place_goes_into_the_map_and_no_innovation_complains():
    for kind, deviation, offset in product(TIED, DEVIATIONS, OFFSETS[1:]):
        result = refer(kind, deviation, offset)
        moved = result.last_errors - refer(kind, deviation, 0.0).last_errors
        assert (0.8 * offset <= moved).all()
        assert (moved < 1.05 * offset).all()
        filtered = result.filtered
        squared = filtered.innovations[..., 0] ** 2 / filtered.innovation_covs[..., 0, 0]
        assert 0.9 < squared[:, 10:].mean() < 1.1


def test_errors_and_gains_stay_in_the_picture():
    for setting in REFERENCES.parameters():
        result = REFERENCES.state(**setting)
        assert np.abs(result.landmark_errors).max() < 0.6
        assert -0.5 < result.gains.min() <= result.gains.max() < 1


def test_share_of_the_first_error_is_what_the_bet_says():
    tied, plain = (rails.remaining_shares(c)[-1] ** 0.5 for c in (rails.FIG5, rails.FIG4))
    assert 1 / 20 < tied < 1 / 10
    assert plain == pytest.approx(0.8, abs=0.01)


def test_set_up_says_what_is_run():
    rows = rails.setup_table().rows
    assert rows["measurements"][1] == str(rails.FIG4.steps)
    assert rows["noise of the camera"][1] == f"{100 * rails.FIG6.reference_deviation:g} cm"


# The invented information


def test_the_less_was_known_the_more_is_invented():
    table = invented.start_table((1, 3, 10))
    for column in table.columns:
        values = [table[row, column] for row in table.rows]
        assert values == sorted(values)
    assert table["±1°", "information"] <= 1 < table["±3°", "information"]


def test_the_turn_at_the_head_is_the_one_that_the_ranks_leave_unseen():
    assert gauge.ranks(moving=True)["one anchor", "true path"].unseen == (TURN,)


# Robot 2


def test_robot_2_by_the_number_of_anchors():
    errors = UTIAS.stored().result.errors["lasting"]
    ate, aligned = errors.ate[1], errors.ate_aligned[1]
    assert (np.diff(ate) < 0).all()
    assert (aligned[:2] < ate[:2] / 2).all()  # most of it is not the shape of the map
    assert ROBOT_2.found() == FIVE.found(robot=2) == ate.tolist()

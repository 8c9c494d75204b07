"""What is made of followed films, on results made by hand."""

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import cues, followed
from robot_perception.chapters.colour_and_shape.experiments import (
    CHOOSING,
    TRACKERS,
    TRAINING,
    WORLDS,
    Result,
)
from robot_perception.teaching.claims import Size


@pytest.fixture
def found():
    """Two films of each kind: edges lose the second card at its end, both cues the second snail."""
    overlap = {f"{w}, {t}": np.full((2, 3), 0.8) for w in WORLDS for t in TRACKERS}
    overlap["rectangle, shape"] = np.array([[0.8, 0.8, 0.8], [0.8, 0.4, 0.1]])
    overlap["snail, fused"] = np.array([[0.8, 0.8, 0.8], [0.8, 0.8, 0.1]])
    overlap["circles, colour, fixed"] = np.array([[0.1, 0.1, 0.9], [0.9, 0.9, 0.19]])
    return Result(overlap, {name: o < 0 for name, o in overlap.items()})


def test_films_come_kind_by_kind(found):
    expected = [0.8, 0.8, 0.8, 1.3 / 3, 0.8, 0.8, 0.8, 0.8]
    np.testing.assert_allclose(cues.overlaps(found, "shape"), expected)
    np.testing.assert_allclose(cues.overlaps(found, "shape", ["rectangle"]), expected[2:4])


def test_only_the_last_frame_says_whether_a_film_is_lost(found):
    np.testing.assert_array_equal(cues.losses(found, "shape"), [0, 0, 0, 1, 0, 0, 0, 0])
    np.testing.assert_array_equal(cues.losses(found, "colour, fixed"), [0, 1] + 6 * [0])
    np.testing.assert_array_equal(cues.losses(found), [0, 0, 0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(cues.losses(found, least=0.81), np.ones(8))


def test_differences_are_those_of_films(found):
    assert cues.further(found, "shape").estimate == pytest.approx(0.4 / 3 / 8)
    assert cues.more_often(found, "shape").estimate == 0
    assert cues.more_often(found, "shape", ["snail"]).estimate == pytest.approx(-1 / 2)
    assert cues.more_often(found, "shape", ["rectangle"]).estimate == pytest.approx(1 / 2)


def test_share_held(found):
    assert cues.held(cues.losses(found, "shape")).estimate == pytest.approx(7 / 8)


def test_tables_have_every_tracker_and_kind(found):
    overlap, lost = cues.overlap_table(found), cues.loss_table(found)
    assert overlap.about.endswith("95 % over films")
    assert lost.about.endswith("2 films of 40 frames each")
    for table in (overlap, lost):
        assert list(table.rows) == list(cues.NAMES.values())
        assert list(table.columns) == list(WORLDS)
        assert "2 films of 40 frames" in table.about
    assert overlap["edges alone", "rectangle"].estimate == pytest.approx((0.8 + 1.3 / 3) / 2)
    assert lost["edges alone", "rectangle"] == 0.5
    assert lost["both", "rectangle"] == 0


def test_every_tracker_has_a_name():
    assert set(cues.NAMES) == set(TRACKERS)


def test_scored_films_are_new():
    assert not set(followed.SEEDS) & {*CHOOSING, TRAINING, *range(1001, 1011)}
    assert followed.films(Size.QUICK) == followed.FEW < followed.SOME
    assert followed.films(Size.FULL) == len(followed.SEEDS) > followed.PRINTED


def test_changes_are_named():
    assert set(cues.SPACES) < set(followed.RULES)
    assert {change for change in cues.MANY.values() if change} < set(followed.RULES)


def test_spaces_are_compared_with_cells_of_one_number():
    assert {followed.RULES[space]["binning"].count for space in cues.SPACES} == {4096}
    for many, change in cues.MANY.items():
        assert followed.RULES.get(change, {}).get("samples", 50) == int(many)

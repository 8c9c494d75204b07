"""What is made of followed films, on results made by hand."""

import numpy as np
import pytest

from robot_perception.chapters.colour_and_shape import cues
from robot_perception.chapters.colour_and_shape.experiments import (
    CHANGES,
    CHOOSING,
    SEEDS,
    SPACES,
    TRACKERS,
    TRAINING,
    WORLDS,
    rules_of,
)


@pytest.fixture
def found():
    """Two films of each kind: edges lose the second card at its end, both cues the second snail."""
    overlap = {f"{w}, {t}": np.full((2, 3), 0.8) for w in WORLDS for t in TRACKERS}
    overlap["rectangle, shape"] = np.array([[0.8, 0.8, 0.8], [0.8, 0.4, 0.1]])
    overlap["snail, fused"] = np.array([[0.8, 0.8, 0.8], [0.8, 0.8, 0.1]])
    overlap["circles, colour, fixed"] = np.array([[0.1, 0.1, 0.9], [0.9, 0.9, 0.19]])
    return overlap


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
    trackers = {name: tracker for tracker, name in cues.NAMES.items()}
    overlap, lost = cues.overlap_table(found, trackers), cues.loss_table(found, trackers)
    assert overlap.about.endswith("2 films of 3 frames each, 95 % over films")
    assert lost.about.endswith("2 films of 3 frames each")
    for table in (overlap, lost):
        assert list(table.rows) == list(cues.NAMES.values())
        assert list(table.columns) == list(WORLDS)
    assert overlap["edges alone", "rectangle"].estimate == pytest.approx((0.8 + 1.3 / 3) / 2)
    assert lost["edges alone", "rectangle"] == 0.5
    assert lost["both", "rectangle"] == 0


def test_others_stand_in_by_tracker_and_by_kind(found):
    (edges,) = cues._standing_in(found, {"fused": "shape"})
    np.testing.assert_array_equal(cues.losses(edges), cues.losses(found, "shape"))
    (snails,) = cues._standing_in(found, dict.fromkeys(cues.EDGED, "snail"))
    assert cues.losses(snails, kinds=cues.EDGED).tolist() == [0, 1, 0, 1]
    assert cues.losses(snails, kinds=["circles"]).tolist() == [0, 0]


def test_every_tracker_has_a_name():
    assert set(cues.NAMES) == set(TRACKERS)


def test_scored_films_are_new_and_tables_are_of_the_first():
    assert not set(SEEDS) & {*CHOOSING, TRAINING, *range(1001, 1031), *range(2001, 2041)}
    for config in cues.films.full:
        assert config.films == SEEDS[: len(config.films)]
    assert {*cues.FEW.films, *cues.EDGES.films} < set(SEEDS)


def test_spaces_are_compared_with_cells_of_one_number():
    assert {rules_of("circles", space).binning.count for space in SPACES} == {4096}
    for many, tracker in cues.MANY.items():
        assert rules_of("snail", tracker).samples == int(many)
    assert {*cues.MANY.values(), *SPACES, *cues.SIGNS.values()} - {"fused"} < set(CHANGES)

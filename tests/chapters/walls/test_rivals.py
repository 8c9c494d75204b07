"""The two other methods that get the scans of the chapter, and the measure that all share."""

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.book.walls import (
    CHOSEN,
    METHODS,
    SETTINGS,
    TOLERANCE,
    by_chords,
    common,
    extracted,
    likeliest,
    missed,
    opposed,
    shared,
    tuned,
    voted,
)
from tests.unchecked import unchecked

ANGLES = np.linspace(-1.2, 1.2, 121)
FRONT = 2.0 / np.cos(ANGLES)
SIDE = 2.0 * np.tan(ANGLES[90]) / np.maximum(np.sin(ANGLES), 1e-9)
ROOM = walls.to_points(np.minimum(FRONT, SIDE), ANGLES)  # two walls that meet in a corner
CORNER = 90


def test_of_chords_the_shares_are_those_of_the_table_of_splitting():
    """Oracle: the measure by which the chapter's first table counts."""
    rng = np.random.default_rng(0)
    for _ in range(100):
        kept = np.unique(np.r_[0, 99, rng.integers(1, 99, rng.integers(0, 30))])
        cuts = np.unique(rng.integers(1, 99, rng.integers(1, 20)))
        parts = np.stack([np.r_[0, cuts], np.r_[cuts - 1, 99]], axis=-1)
        np.testing.assert_allclose(shared(parts, by_chords(kept, 100)), common(parts, kept))


def test_a_reading_on_no_piece_is_common_to_none():
    pieces = np.array([-1, -1, 0, 0, 0, 1, -1, 1, 1, 1])
    np.testing.assert_allclose(shared(np.array([[0, 4], [5, 9], [0, 1]]), pieces), [0.6, 0.8, 0])
    assert shared(np.array([[0, 9]]), np.full(10, -1)).tolist() == [0]


def test_beams_miss_a_chord_by_the_distance_along_them():
    """Oracle: where each beam meets the line, by two equations."""
    rng = np.random.default_rng(1)
    chain = walls.to_points(rng.uniform(1, 4, 12), np.linspace(-0.5, 0.9, 12))
    i, j = 2, 9
    off = []
    for point in chain[i + 1 : j]:
        beam = point / np.linalg.norm(point)
        far, _ = np.linalg.solve(np.stack([beam, chain[i] - chain[j]], axis=-1), chain[i])
        off.append(far - np.linalg.norm(point))
    assert missed(chain, i, j) == pytest.approx(np.sum(np.square(off)))
    assert missed(chain, 2, 3) == 0


def test_the_likeliest_polyline_of_two_walls_keeps_their_corner():
    kept = likeliest(ROOM, 1e-4)
    assert kept.tolist() == [0, CORNER, len(ROOM) - 1]
    assert likeliest(ROOM, np.inf).tolist() == [0, len(ROOM) - 1]
    assert likeliest(ROOM, -1.0).tolist() == list(range(len(ROOM)))
    assert likeliest(ROOM[:2], 1.0).tolist() == [0, 1]


def test_vertices_go_in_the_order_of_what_their_loss_costs():
    """Oracle: all costs anew before each removal."""
    rng = np.random.default_rng(2)
    chain = ROOM * (1 + rng.normal(0, 0.01, (len(ROOM), 1)))
    kept = list(range(len(chain)))
    while len(kept) > 2:
        costs = [
            missed(chain, i, j) - missed(chain, i, k) - missed(chain, k, j)
            for i, k, j in zip(kept, kept[1:], kept[2:], strict=False)
        ]
        if min(costs) >= 0.02:
            break
        del kept[1 + int(np.argmin(costs))]
    assert 2 < len(kept) < 20
    assert likeliest(chain, 0.02).tolist() == kept


def test_a_single_wide_reading_costs_the_likeliest_polyline_no_wall():
    chain = ROOM.copy()
    chain[20] *= 1.04  # on the front wall, 8 cm behind it or more
    kept = likeliest(chain, CHOSEN["likeliest polyline"])
    assert len(kept) == 3
    assert len(walls.simplify(chain, TOLERANCE)) > 3


def test_votes_find_both_walls_and_none_where_there_is_none():
    pieces = voted(ROOM, CHOSEN["Hough transform"])
    front, side = pieces[5 : CORNER - 5], pieces[CORNER + 5 : -5]
    assert len(set(front.tolist())) == len(set(side.tolist())) == 1
    assert front[0] != side[0]
    chain = ROOM.copy()
    chain[20] *= 0.6  # a lone reading in the room
    assert np.flatnonzero(voted(chain, CHOSEN["Hough transform"]) < 0).tolist() == [20]
    few = walls.to_points(np.array([1.0, 3.0, 1.0]), np.array([-1.0, 0.0, 1.0]))
    assert voted(few, CHOSEN["Hough transform"]).tolist() == [-1, -1, -1]


def test_the_scans_are_those_of_the_first_table():
    """Splitting extracts of each drive what it did there."""
    before = extracted.rows().where(readings="noisy", tolerance=TOLERANCE)
    again = opposed.rows().where(method="splitting")
    for share in ("half", "four fifths"):
        np.testing.assert_array_equal(again.of(share), before.of(share))
    with unchecked():
        words = {"readings": "noisy", "tolerances": (TOLERANCE,), "step": 16.0}
        first = extracted.but(**words).trial(drive=3, readings="noisy")
        found = opposed.but(step=16.0).trial(drive=3, method="splitting")
    assert found["half"] == first["half"].item()


def test_the_settings_are_the_best_of_drives_that_are_not_scored():
    rows, scored = tuned.rows(), set(opposed.replicates)
    assert not scored & set(tuned.replicates)
    for method, settings in SETTINGS.items():
        shares = [
            tuple(
                rows.of(name, method=method, setting=k).mean() for name in ("half", "four fifths")
            )
            for k in range(len(settings))
        ]
        assert settings[shares.index(max(shares))] == CHOSEN[method]
    assert set(METHODS) == set(CHOSEN) == {"splitting", *SETTINGS}

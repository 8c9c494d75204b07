"""Straight parts of scans, and which chords extract them."""

from itertools import pairwise

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.book.walls import WAYS, common, extracted, straight_parts
from tests.unchecked import unchecked

CORNER = np.array([[0.1 * k, 0.0] for k in range(10)] + [[0.9, 0.1 * k] for k in range(1, 10)])
FACES = np.repeat([3, 7], [10, 9])


def test_parts_are_the_runs_on_one_face_that_are_long_enough():
    np.testing.assert_array_equal(straight_parts(CORNER, FACES), [[0, 9], [10, 18]])
    mixed = FACES.copy()
    mixed[4] = -1  # leaves four readings, too few, and five
    np.testing.assert_array_equal(straight_parts(CORNER, mixed), [[10, 18]])
    mixed[:] = -1
    assert not len(straight_parts(CORNER, mixed))
    assert not len(straight_parts(0.4 * CORNER, FACES))  # 36 and 32 cm


@pytest.mark.parametrize(
    ("kept", "shares"),
    [
        ([0, 9, 18], [9 / 10, 9 / 10]),  # the corner belongs to the second chord
        ([0, 18], [10 / 19, 9 / 19]),
        ([0, 4, 9, 18], [5 / 10, 9 / 10]),
        (list(range(19)), [1 / 10, 2 / 9]),
    ],
)
def test_what_is_common_is_the_shared_readings_over_those_of_the_larger(kept, shares):
    """Oracle: sets of readings."""
    parts = np.array([[0, 9], [10, 18]])
    found = common(parts, np.array(kept))
    np.testing.assert_allclose(found, shares)
    sets = [set(range(a, b + 1)) for a, b in parts]
    chords = [set(range(a, b + (b == 18))) for a, b in pairwise(kept)]
    best = [max(len(s & c) / max(len(s), len(c)) for c in chords) for s in sets]
    np.testing.assert_allclose(found, best)


def test_above_one_half_a_part_has_one_chord_and_a_chord_one_part():
    rng = np.random.default_rng(0)
    for _ in range(200):
        kept = np.unique(np.r_[0, 99, rng.integers(1, 99, rng.integers(1, 30))])
        cuts = np.unique(rng.integers(1, 99, rng.integers(1, 20)))
        parts = np.stack([np.r_[0, cuts], np.r_[cuts - 1, 99]], axis=-1)
        chords = np.stack([kept[:-1], np.r_[kept[1:-1] - 1, 99]], axis=-1)
        shared = np.minimum(parts[:, None, 1], chords[:, 1])
        shared = shared - np.maximum(parts[:, None, 0], chords[:, 0]) + 1
        sizes = [pair[:, 1] - pair[:, 0] + 1 for pair in (parts, chords)]
        claims = shared > np.maximum(sizes[0][:, None], sizes[1]) / 2
        assert claims.sum(axis=0).max() <= 1
        assert claims.sum(axis=1).max() <= 1
        np.testing.assert_array_equal(common(parts, kept) > 0.5, claims.any(axis=1))


def test_a_room_without_noise_is_extracted_and_a_tolerance_of_its_size_extracts_nothing():
    with unchecked():  # its checks are those of the functions above, some ten thousand times
        rows = extracted.run(drive=0, readings="exact", tolerances=(1e-3, 0.08, 100.0), step=8.0)
    fine, ours, huge = rows.of("half")
    assert min(fine, ours) > 0.99  # without noise the tolerance does not matter, if it is small
    assert huge < 0.05
    shares = np.stack([rows.of(name) for name in ("half", "four fifths", "nine tenths")])
    assert (np.diff(shares, axis=0) <= 0).all()  # more asked for, fewer extracted


def test_what_is_extracted_does_not_depend_on_how_the_vertices_are_found(monkeypatch):
    words = {"drive": 1, "readings": "noisy", "tolerances": (0.03, 0.08), "step": 16.0}
    found = []
    for simplify in (walls.simplify, walls.simplify_recursive):
        monkeypatch.setitem(WAYS, "farthest", simplify)
        with unchecked():
            found.append(extracted.but(**words).trial(drive=1, readings="noisy"))
    np.testing.assert_array_equal(found[0]["half"], found[1]["half"])
    assert all(one["agree"] == one["scans"] for one in found)


def test_at_a_fraction_of_the_tolerance_its_own_reference_agrees():
    with unchecked():
        words = {"readings": "noisy", "tolerances": (0.08,), "step": 16.0, "times": 1 / 3}
        found = extracted.but(**words).trial(drive=0, readings="noisy")
    assert found["agree"] == found["scans"]
    assert found["half"].item() < 0.5

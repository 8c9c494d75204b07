"""What clouds and lattices look at, and a face that something covers."""

from itertools import islice, pairwise

import numpy as np
import pandas as pd
import pytest

from data_synth.people import readings
from data_synth.people.staging import Config, rig, staged
from robot_perception.book import people_sensors as page
from robot_perception.people.skin import SkinState
from studies.rows import Rows
from tests.unchecked import unchecked

ROWS, COLUMNS = page.PICTURE
SHORT = Config(8101, 1.0, sensors=("camera",))  # none of those that are used elsewhere


def followed(film):
    """Return a tracker that notes, after some pictures, with the last two states, and the film."""
    tracker, states = page.noting(100), [SkinState()]
    rng = np.random.default_rng(3)
    for picture in film:
        states.append(tracker.step(states[-1], picture, rng=rng)[0])
    return tracker, states


@pytest.fixture(scope="module")
def pictures():
    """The pictures of half a second."""
    film, rng = staged(SHORT)
    return [one.image for one in islice(readings(film, rig(("camera",)), rng=rng), 6)]


# What is looked at


def test_the_picture_and_the_window_are_the_trackers():
    tracker = page.skin_tracker()
    assert tracker.rules == page.RULES
    skin = tracker.skin(np.zeros((tracker.size[1], tracker.size[0], 3), np.uint8))
    assert skin.shape == page.PICTURE
    sides = np.array(tracker.rules.window)[::-1] / tracker.rules.step
    np.testing.assert_array_equal(page.WINDOW, 2 * (np.rint(sides) // 2) + 1)


def test_samples_of_a_window_count_once_round_the_back_and_not_beyond_the_edge():
    assert page.windows(40, 100) == 35
    assert page.windows(np.array([40, 40]), np.array([100, 102])) == 35 + 2 * 7
    assert page.windows(40, 0) == 35
    assert page.windows(0, 100) == 4 * 5
    assert page.windows(np.arange(3, 84, 7)[:, None], np.arange(2, COLUMNS, 5)) == 84 * COLUMNS
    assert page.windows(np.arange(ROWS)[:, None], np.arange(COLUMNS)) == ROWS * COLUMNS


def test_a_state_stands_in_the_middle_of_its_window():
    step, (low, high) = page.RULES.step, page.RULES.band
    states = np.array([[-np.pi, low], [np.pi - step / 2, high], [step / 2, low + 1.5 * step]])
    up, across = page.cells(states)
    assert up.tolist() == [0, ROWS - 1, 1]
    assert across.tolist() == [0, COLUMNS - 1, COLUMNS // 2]


def test_nothing_is_asked_for_but_what_is_noted(pictures, monkeypatch):
    """Without the samples that no window covers, every picture gives the same clouds."""
    tracker, states = followed(pictures)
    assert states[-1].clouds, "nothing would be shown by that"
    shown = iter([np.concatenate(asked) for asked in tracker.places])
    whole = page.Noting.skin

    def blinded(self, image):
        middles = np.zeros(page.PICTURE, dtype=bool)
        middles[page.cells(next(shown))] = True
        seen = page.maximum_filter(middles, page.WINDOW, mode=("constant", "wrap"))
        return np.where(seen, whole(self, image), 0.0)

    monkeypatch.setattr(page.Noting, "skin", blinded)
    _, again = followed(pictures)
    for one, other in zip(states[-1].clouds, again[-1].clouds, strict=True):
        np.testing.assert_allclose(one.particles.states, other.particles.states, atol=1e-9)


def test_clouds_without_their_seeds_look_at_less(pictures):
    tracker, states = followed(pictures)
    looked, _ = page.by_clouds(tracker, states[-1])
    assert 0 < page.by_old_clouds(tracker) < looked < ROWS * COLUMNS / 4
    tracker, _ = followed(pictures[:1])
    assert page.by_old_clouds(tracker) == 0  # there was no cloud yet


# Lattices


def test_a_search_takes_the_best_windows_that_are_far_from_better_ones():
    shares = np.zeros(page.PICTURE)
    apart = int(page.RULES.apart / page.RULES.step)
    peaks = (5, 1, 0.7), (9, -3, 0.9), (40, 300, 0.8), (40, 301 + apart, 0.6), (2, 500, 0.4)
    for row, column, share in peaks:
        shares[row, column] = share
    found, skin = page.best(shares)
    expected = 2 * np.pi * (np.array([COLUMNS - 3, 300, 301 + apart]) + 0.5) / COLUMNS - np.pi
    np.testing.assert_allclose(found, expected)
    np.testing.assert_allclose(skin, [0.9, 0.8, 0.6])


def searched(skin, names, seed=1):
    """Return what the searches by lattices look at, with the directions by each threshold."""
    every = list(page.by_lattices(skin, names, np.random.default_rng(seed)))
    each = [every[k : k + len(page.LEASTS)] for k in range(0, len(every), len(page.LEASTS))]
    assert all(len({looked for looked, _ in one}) == 1 for one in each)
    return np.array([one[0][0] for one in each]), [[found for _, found in one] for one in each]


def test_a_lattice_looks_at_its_samples_and_round_those_that_are_skin():
    skin, names = np.zeros(page.PICTURE), tuple(page.LATTICES)
    skin[30:50, 100:110] = skin[30:50, 400:410] = 1.0
    (costs, found), (plain, none) = (searched(one, names) for one in (skin, np.zeros(page.PICTURE)))
    parts = np.array(page.PICTURE) / np.array(list(page.LATTICES.values()))
    assert (np.floor(parts).prod(axis=1) <= plain).all()
    assert (plain <= np.ceil(parts).prod(axis=1)).all()
    assert plain[0] == costs[0] == ROWS * COLUMNS
    assert (costs[1:] > plain[1:]).all()
    assert (costs[1:] < plain[1:] + 2 * 26 * 14).all()  # two patches, a window wider
    centres = 2 * np.pi * np.array([105, 405]) / COLUMNS - np.pi
    for one in found:
        np.testing.assert_allclose(np.sort(one[0]), centres, atol=np.deg2rad(3))
    assert not any(one.size for lattice in none for one in lattice)


def test_a_higher_threshold_names_less():
    skin = np.random.default_rng(2).uniform(0.3, 1.0, page.PICTURE)
    for one in searched(skin, ("one of 4", "one of 35"))[1]:
        for more, less in pairwise(one):
            assert set(less) <= set(more)
        assert len(one[-1]) < len(one[0])


def test_a_lattice_sees_skin_only_where_it_looks():
    lone, missed = np.zeros(page.PICTURE), 0
    lone[40, 200] = 1.0
    for seed in range(50):
        (found,), (empty,) = (
            searched(skin, ("one of 35",), seed)[0] for skin in (lone, np.zeros(page.PICTURE))
        )
        assert found in (empty, empty + 34)  # the window around, less the sample in its middle
        missed += found == empty
    assert 40 < missed < 50


def test_what_is_found_is_counted(monkeypatch):
    known = {"polar": [[2, 0.0], [2, 1.0], [2, 2.0], [2, -2.0]], "gaze": [1, 1, -1, 1],
             "present": [True, True, True, False], "clear": [True] * 4}  # fmt: skip
    monkeypatch.setattr(page, "truths", lambda *_: {k: np.array([v]) for k, v in known.items()})
    people, faces = page.in_view(None, 1.0)
    assert (len(people), faces.tolist()) == (3, [True, True, False])
    found = np.array([0.05, 2.05, -2.0, 3.0])
    assert page.hits_of(people, faces, found) == (2, 1, 2)


def tallied(clouds, lattices, sessions=3):
    """Return rows that are the same in each session: (looked at, found, nobody) of each search."""
    others = [one for one in lattices for _ in page.LEASTS]
    found = [(looks, *one) for looks, curve in lattices.values() for one in curve]
    names = [*page.WHO, *others]
    table = pd.DataFrame(
        [clouds] * len(page.WHO) + found, columns=["samples", "found", "nobody"], dtype=float
    ).assign(search=names)
    table = pd.concat([table.assign(session=n) for n in range(sessions)], ignore_index=True)
    return Rows(table, "session", {}, "")


@pytest.mark.parametrize(
    ("finds", "times"), [(2, 1.0), (6, 1.0), (7, 2**0.5), (8, 2.0), (9, 4.0), (20, 4.0)]
)
def test_a_search_is_compared_at_as_many_faces_and_as_many_of_nobody(finds, times):
    """Each names ten of nobody at the middle of its thresholds, with 9, 8 and 6 faces there."""
    away = len(page.LEASTS) // 2 - np.arange(len(page.LEASTS))
    curves = {
        name: (looks, [(faces + k, 10 + 2 * k) for k in away])
        for name, looks, faces in (("a", 400, 9), ("b", 200, 8), ("c", 100, 6))
    }
    value = page.times_fewer(tallied((100, finds, 10), curves))
    assert value.estimate == pytest.approx(times)
    assert value.low == pytest.approx(value.high)  # all sessions are alike


# Faces that are covered


@pytest.fixture(scope="module")
def strollers():
    """Three people whom nobody scores."""
    with unchecked():
        return [page.stroll(np.random.default_rng(seed)) for seed in (8202, 8206, 8210)]


def test_people_walk_round_the_robot_on_free_floor(strollers):
    for walk in strollers:
        assert (walk.office.free(walk.path) > 0.25).all()
        away = np.hypot(*(walk.path - walk.robot[:2]).T)
        np.testing.assert_allclose(away, walk.away)
        speed = np.hypot(*np.diff(walk.path, axis=0).T) / np.diff(page.FILM)
        np.testing.assert_allclose(speed, 0.5, rtol=1e-2)


@pytest.mark.parametrize("cover", ["two fifths", "half", "the whole"])
def test_a_thing_covers_the_share_of_the_skin_in_all_pictures(strollers, cover):
    share = page.COVERS[cover]
    for walk in strollers:
        edge = page.edge_for(walk, share)
        for k in (15, 37):
            free, seen = (page.seen_through(walk, k, e).faces[0] for e in (None, edge))
            assert 1 - seen / free == pytest.approx(share, abs=0.03)


def test_a_face_that_is_hidden_is_lost_and_found_again_and_a_free_one_is_kept():
    with unchecked():
        free, lost = (page.hidden.one(8202, cover) for cover in ("nothing", "the whole"))
    assert free == {"known": True, "held": True, "last": True, "as_before": False, "within": True}
    assert lost == free | {"held": False}


def test_who_was_not_followed_before_is_not_asked_about():
    table = pd.DataFrame({"person": range(4), "known": [True, True, False, False],
                          "held": [True, False, False, True], "cover": "half"})  # fmt: skip
    held = page.held(Rows(table, "person", {}, ""), cover="half")
    assert (held.estimate, held.about) == (0.5, "95% of the rate over 2 trials")

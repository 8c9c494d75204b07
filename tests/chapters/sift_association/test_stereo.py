"""Matches of one pair against the renderer's truth, and the rules of matching."""

from itertools import pairwise

import numpy as np
import pytest

from data_synth import stereo as world
from data_synth.stereo import Rig
from data_synth.textured_building import drive, make_textured_building
from robot_perception.chapters.sift_association import stereo
from robot_perception.chapters.sift_association.stereo import RULES, Config, Sides
from robot_perception.landmarks import textbook
from tests.chapters.sift_association.worlds import features

RNG = np.random.default_rng
RIG = Rig()


@pytest.fixture(scope="module")
def seen():
    return stereo.pairs.__wrapped__(2, 5)


def test_the_right_column_is_where_the_right_eye_sees_the_point(seen):
    """The right eye is a left one a baseline farther to the right."""
    building_rng, path, _ = RNG(5).spawn(3)
    building = make_textured_building(rng=building_rng)
    pose = drive(building, rng=path)[0]
    right = pose + RIG.baseline * np.array([np.sin(pose[2]), -np.cos(pose[2]), 0.0])
    sides = seen[0]
    points = world.surface_points(building.scene, RIG, pose, sides.left.pixels).points
    assert sides.depths == pytest.approx(world.project(RIG, pose, points)[:, 2])
    assert sides.columns == pytest.approx(world.project(RIG, right, points)[:, 0])


def test_matches_are_judged_one_by_one(seen):
    for sides in seen:
        found = stereo.match(sides, RULES)
        rows = textbook.match_stereo(sides.left, sides.right, RULES)
        assert len(found) == len(rows) > 20
        for k, (i, j) in enumerate(rows):
            column = sides.right.pixels[j, 0]
            assert found["right"][k] == (abs(column - sides.columns[i]) <= stereo.RIGHT_PX)
            depth = RIG.focal_px * RIG.baseline / (sides.left.pixels[i, 0] - column)
            assert found["error"][k] == pytest.approx(depth - sides.depths[i])
            spread = np.sqrt(2) * 0.5 * depth**2 / (RIG.focal_px * RIG.baseline)
            assert found["stated"][k] == pytest.approx(spread)
        assert found["right"].mean() > 0.8
        near = found["right"] & (sides.depths[rows[:, 0]] < 4)
        assert np.median(np.abs(found["error"][near])) < 0.1


def test_a_match_is_right_up_to_the_limit_and_no_farther():
    shift = RIG.focal_px * RIG.baseline / 3.0
    columns, away = 200.0 + 20 * np.arange(4), np.array([0.0, 1.4, -1.4, 1.6])
    look = 100 * np.eye(4, 128)
    left = features(np.column_stack([columns, 50.0 + 30 * np.arange(4)]), descriptors=look)
    right = features(left.pixels - np.column_stack([shift + away, np.zeros(4)]), descriptors=look)
    found = stereo.match(Sides(left, right, columns - shift, np.full(4, 3.0)), RULES)
    assert found["right"].tolist() == [True, True, True, False]
    assert found["error"][0] == pytest.approx(0)
    assert found["error"][1] < 0 < found["error"][2]


def test_a_higher_threshold_never_makes_fewer_matches(monkeypatch, seen):
    monkeypatch.setattr(stereo, "pairs", lambda count, seed: seen)
    done = stereo.one_building(Config(pairs=2), rng=RNG(0))
    assert len(done) == len(stereo.ROWS) * len(stereo.THRESHOLDS)
    for rows in stereo.ROWS:
        counts = [sum(map(len, done[rows, limit])) for limit in stereo.THRESHOLDS]
        assert all(a <= b for a, b in pairwise(counts))
    most, fewest = (sum(map(len, done[key])) for key in ((240.0, 800.0), (2.0, 100.0)))
    assert most > 1.3 * fewest


def test_results_are_those_of_all_pairs_together(monkeypatch, seen):
    monkeypatch.setattr(stereo, "pairs", lambda count, seed: seen)
    result = stereo.one_building(Config(pairs=2, rows=(2.0,), thresholds=(200.0,)), rng=RNG(0))
    matches = np.concatenate([stereo.match(sides, RULES) for sides in seen])
    assert (np.concatenate(result[2.0, 200.0]) == matches).all()
    share = stereo.share([result] * 2).estimate
    assert share == pytest.approx(matches["right"].sum() / len(matches))


def test_a_knocked_camera_loses_its_matches(monkeypatch, seen):
    monkeypatch.setattr(stereo, "pairs", lambda count, seed: seen)
    whole, knocked = (
        np.concatenate(stereo.one_building(Config(pairs=2, knocked=off), rng=RNG(0))[2.0, 200.0])
        for off in (0.0, 5.0)
    )
    assert len(knocked) < len(whole) / 10
    assert knocked["right"].mean() < whole["right"].mean() - 0.2


def test_the_table_of_the_set_up_says_what_is_computed():
    table = stereo.setup_table()
    assert table["pictures", "ours"] == "320 × 240"
    assert table["rows", "ours"] == "±2 px"
    assert "280 px, 15 cm" in table["focal length, baseline", "ours"]

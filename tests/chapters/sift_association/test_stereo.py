"""Matches of one pair against the renderer's truth, and the rules of matching."""

from itertools import pairwise

import numpy as np
import pytest

from data_synth import stereo as world
from data_synth.stereo import Rig
from data_synth.textured_building import drive, make_textured_building
from robot_perception.book import sift_association as page
from robot_perception.book.sift_association import Sides
from robot_perception.landmarks import StereoRules, textbook
from tests.chapters.sift_association.worlds import features

RNG = np.random.default_rng
RIG = Rig()
RULES = StereoRules(2.0, 200.0)


@pytest.fixture(scope="module")
def seen():
    return page.pairs.__wrapped__(2, 5)


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
        right, errors, stated = page.match(sides, RULES)
        rows = textbook.match_stereo(sides.left, sides.right, RULES)
        assert len(right) == len(errors) == len(rows) > 20
        for k, (i, j) in enumerate(rows):
            column = sides.right.pixels[j, 0]
            assert right[k] == (abs(column - sides.columns[i]) <= page.RIGHT_PX)
            depth = RIG.focal_px * RIG.baseline / (sides.left.pixels[i, 0] - column)
            assert errors[k] == pytest.approx(depth - sides.depths[i])
            spread = np.sqrt(2) * 0.5 * depth**2 / (RIG.focal_px * RIG.baseline)
            assert stated[k] == pytest.approx(spread)
        assert right.mean() > 0.8
        near = right & (sides.depths[rows[:, 0]] < 4)
        assert np.median(np.abs(errors[near])) < 0.1


def test_a_match_is_right_up_to_the_limit_and_no_farther():
    shift = RIG.focal_px * RIG.baseline / 3.0
    columns, away = 200.0 + 20 * np.arange(4), np.array([0.0, 1.4, -1.4, 1.6])
    look = 100 * np.eye(4, 128)
    left = features(np.column_stack([columns, 50.0 + 30 * np.arange(4)]), descriptors=look)
    right = features(left.pixels - np.column_stack([shift + away, np.zeros(4)]), descriptors=look)
    good, errors, _ = page.match(Sides(left, right, columns - shift, np.full(4, 3.0)), RULES)
    assert good.tolist() == [True, True, True, False]
    assert errors[0] == pytest.approx(0)
    assert errors[1] < 0 < errors[2]


def counts(monkeypatch, seen, **where):
    """Return what a trial gives of these pairs."""
    monkeypatch.setattr(page, "pairs", lambda count, seed: seen)
    changes = {name: where.pop(name) for name in ("knocked",) if name in where}
    study = page.matched.but(**changes) if changes else page.matched
    return study.trial(building=0, **{"rows": 2.0, "threshold": 200.0} | where)


def test_a_higher_threshold_never_makes_fewer_matches(monkeypatch, seen):
    for rows in page.ROWS:
        found = [counts(monkeypatch, seen, rows=rows, threshold=t) for t in page.THRESHOLDS]
        assert all(a["matches"] <= b["matches"] for a, b in pairwise(found))
    most = counts(monkeypatch, seen, rows=240.0, threshold=800.0)["matches"]
    assert most > 1.3 * counts(monkeypatch, seen, threshold=100.0)["matches"]


def test_a_trial_counts_all_pairs_together(monkeypatch, seen):
    found = counts(monkeypatch, seen)
    right, errors, stated = map(
        np.concatenate, zip(*(page.match(sides, RULES) for sides in seen), strict=True)
    )
    assert (found["right"], found["matches"], found["pairs"]) == (right.sum(), len(right), 2)
    assert found["median"] == pytest.approx(np.median(np.abs(errors)))
    assert (np.abs(errors) > found["worst"]).mean() == pytest.approx(0.05, abs=0.01)
    quarters = np.quantile((errors / stated)[right], [0.25, 0.75])
    assert found["spread"] == pytest.approx(np.diff(quarters)[0] / 1.349, rel=1e-3)


def test_a_knocked_camera_loses_its_matches(monkeypatch, seen):
    whole, knocked = (counts(monkeypatch, seen, knocked=off) for off in (0.0, 5.0))
    assert knocked["matches"] < whole["matches"] / 10
    share = [one["right"] / one["matches"] for one in (whole, knocked)]
    assert share[1] < share[0] - 0.2


def test_a_camera_that_is_knocked_too_far_is_told(monkeypatch, seen):
    """By hand: four rows off and half a row allowed, no match is right."""
    with pytest.raises(ValueError, match=r"no match is right within 0.5 rows, the camera off by 4"):
        counts(monkeypatch, seen, rows=0.5, threshold=50.0, knocked=4.0)

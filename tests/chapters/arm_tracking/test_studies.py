"""The studies: runs of trackers and what they count, by law."""

import json
from dataclasses import replace

import numpy as np
import pytest

from robot_perception.arms.likelihoods import EdgeCue, PatchCue
from robot_perception.arms.tracker import BOUNDS, CUES
from robot_perception.book import arm_tracking as page
from robot_perception.chapters.arm_likelihoods.scene import CHOOSING
from robot_perception.chapters.arm_tracking import tracking, views
from robot_perception.chapters.arm_tracking.tracking import (
    FRAMES,
    HELD,
    SCENES,
    WAYS,
    Run,
    film,
    follow,
    started,
    tracked,
    tracker,
)


def run_of(wrists, angles=None):
    n = len(wrists)
    zeros = np.zeros((n, 8))
    return Run(zeros, zeros, zeros if angles is None else angles, wrists, wrists / 200,
               np.zeros(n), np.ones(n), np.zeros(n, bool), np.array(True))  # fmt: skip


def test_an_arm_is_held_if_its_wrist_is_near_in_the_last_second():
    wrists = np.full((40, 2), 50.0)
    wrists[-15:, 0] = HELD - 1
    wrists[-15:, 1] = [HELD - 1] * 14 + [HELD + 20]
    assert run_of(wrists).held.tolist() == [True, False]


def test_errors_are_told_once_the_first_second_is_over():
    angles = np.zeros((40, 8))
    angles[:15] = 9.0
    angles[15:, 2], angles[15:, 6] = np.radians(10), np.radians(30)
    run = run_of(np.r_[np.full((15, 2), 99.0), np.tile([2.0, 4.0], (25, 1))], angles)
    assert run.angle == pytest.approx(5.0)
    np.testing.assert_allclose(run.each, [0, 0, 20, 0])
    assert run.wrist == pytest.approx(3.0)


def test_each_way_is_the_papers_cues_but_for_what_its_name_says():
    shown = film(CHOOSING[6], "pointing, plain", 2)
    first = started(tracker(), shown, np.random.default_rng(0))[0].first
    made = {way: {name: make(first) for name, make in cues.items()}
            for way, (cues, _) in WAYS.items()}  # fmt: skip
    for way, cues in made.items():
        left_out = {"no contours": {"edges"}, "no colour": {"colour"}, "no texture": {"texture"},
                    "no stabiliser": {"stabiliser"}, "no patches": {"colour", "texture"},
                    "contours only": {"colour", "texture"},
                    "no picture": {"edges", "colour", "texture"}}.get(way, set())  # fmt: skip
        assert set(cues) == set(CUES) - left_out
    for way in ("contours only", "no motion"):
        assert made[way]["edges"].gain is None
        assert made[way]["edges"].toll is None
    assert made["all cues"]["edges"] == EdgeCue(gain=0.5, weight=made["all cues"]["edges"].weight)
    assert made["a toll in place of K"]["edges"].toll == 1.0
    even = made["patches trusted alike"]["colour"]
    assert isinstance(even, PatchCue)
    assert (even.weights == 1).all()
    assert set(WAYS["no collisions"][1]) == set(BOUNDS) - {"collisions"}
    assert all(bounds is BOUNDS for way, (_, bounds) in WAYS.items() if way != "no collisions")


def test_a_run_compares_with_what_is_true_in_the_film():
    shown = film(CHOOSING[6], "pointing, plain", 6)
    run = follow(tracker(particles=60), shown, CHOOSING[6])
    np.testing.assert_allclose(run.angles, np.abs(run.states - shown.angles))
    assert run.wrists.shape == run.hands.shape == (6, 2)
    assert (run.hands < 1.5).all()
    assert run.saved.max() <= 1
    assert bool(run.found)


def test_the_same_film_and_tracker_give_the_same_run():
    one, two = (
        follow(tracker(particles=40), film(CHOOSING[2], "gesturing, clutter", 5), 3)
        for _ in range(2)
    )
    np.testing.assert_array_equal(one.states, two.states)
    kept = tracked(CHOOSING[2], "gesturing, clutter", "all cues", "auxiliary", 40, 5)
    again = tracked(CHOOSING[2], "gesturing, clutter", "all cues", "auxiliary", 40, 5)
    np.testing.assert_array_equal(kept.states, again.states)


def test_a_face_that_is_not_found_is_told():
    shown = film(CHOOSING[6], "pointing, plain", 2)
    frames = shown.frames.copy()
    left, top, wide, high = np.rint(shown.face).astype(int)
    frames[:, top - 8 : top + high + 8, left - 8 : left + wide + 8] = 120
    state, found = started(tracker(particles=20), replace(shown, frames=frames),
                           np.random.default_rng(0))  # fmt: skip
    assert not found
    assert state.first.model.middle[2] == pytest.approx(1.9, abs=0.05)
    assert started(tracker(particles=20), shown, np.random.default_rng(0))[1]


def test_an_arm_points_where_it_is_raised_and_stands_still():
    joints = np.zeros((30, 2, 4, 3))
    joints[:, 0, 2] = [0.5, 0.2, 0.0]  # raised by more than 30°, and still
    joints[:, 1, 2] = [0.1, 0.5, 0.0]  # hangs
    joints[20:, 0, 2, 0] += 0.03 * np.arange(10)  # moves
    points = page.pointing_now(joints)
    assert points[5:20, 0].all()
    assert not points[21:, 0].any()
    assert not points[:5].any()
    assert not points[:, 1].any()


def test_directions_are_compared_in_space_and_in_the_picture():
    one, other = np.array([0.6, 0.0, -0.8]), np.array([0.6, 0.0, 0.8])
    assert page.degrees_between(one, other) == pytest.approx(2 * np.degrees(np.arctan(8 / 6)))
    assert page.degrees_between(one, other, True) == pytest.approx(0)
    up, down = np.array([0.1, -1.0, 0.0]), np.array([-0.1, -1.0, 0.0])
    assert page.degrees_between(up, down, True) == pytest.approx(2 * np.degrees(np.arctan(0.1)))


def test_the_floor_of_a_power_law_is_found():
    particles = (25, 100, 400, 1600)
    errors = 7 + 30 / np.sqrt(particles)
    for taken in (100, 10**6):
        floor, fit = page.floors(particles, np.stack([errors, 2 * errors]), taken)
        np.testing.assert_allclose(floor, [7, 14], rtol=1e-6)
        np.testing.assert_allclose(fit, floor + floor * 30 / 7 / np.sqrt(taken), rtol=1e-6)


def test_the_films_of_a_study_are_of_people_who_vary_and_nobody_else_is_changed():
    plain, varied = (film(CHOOSING[6], "pointing, plain", 2, by) for by in (0.0, 0.08))
    assert plain.person.build != varied.person.build
    np.testing.assert_array_equal(film(CHOOSING[6], "pointing, plain", 2).frames, plain.frames)


def test_times_are_those_of_the_benchmarks(tmp_path, monkeypatch):
    rows = [
        {"work": f"{views.WHOLE}, so many", "ours_s": 0.39, "peer_s": None},
        {"work": f"{views.SHAPES}, so many", "ours_s": 0.001, "peer_s": 2.0},
    ]
    (tmp_path / "performance.json").write_text(json.dumps({"rows": rows}))
    monkeypatch.setattr(views, "records", lambda: tmp_path)
    assert views.recorded_row(views.WHOLE)["ours_s"] == 0.39
    assert views.recorded_row(views.SHAPES)["peer_s"] == 2.0
    with pytest.raises(LookupError, match="no row 'legs'"):
        views.recorded_row("legs")


def test_scenes_are_those_of_the_names():
    for name, scene in SCENES.items():
        kind, behind = name.split(", ")
        assert scene.kind == kind
        assert (scene.clutter, scene.passers) == ((40, 2) if behind == "clutter" else (0, 0))
    assert FRAMES == tracking.FRAMES == 60

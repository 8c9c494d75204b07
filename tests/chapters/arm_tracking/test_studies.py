"""The studies: runs of trackers and what they count, by law."""

import json
from dataclasses import replace

import numpy as np
import pytest

from robot_perception.arms.likelihoods import EdgeCue, PatchCue
from robot_perception.arms.tracker import BOUNDS, CUES
from robot_perception.chapters.arm_likelihoods.scene import CHOOSING
from robot_perception.chapters.arm_tracking import ablating, bounding, counting, timing, tracking
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
                    "contours only": {"colour", "texture"}}.get(way, set())  # fmt: skip
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


def test_ratios_are_of_the_same_films():
    angle = np.array([[[20.0, 10.0]], [[40.0, 20.0]]])
    config = counting.Config((1, 2), counts=(50, 400), filters=("auxiliary",))
    result = counting.Result(config, angle, angle / 2, np.ones((2, 1, 2)))
    assert result.ratio("auxiliary", 400, 50).estimate == pytest.approx(0.5)
    assert result.table()["auxiliary", "400"].estimate == pytest.approx(7.5)


def test_gains_are_differences_on_the_same_films():
    held = np.array([[[1.0, 0.5]], [[1.0, 0.0]]])
    config = ablating.Config((1, 2), ("gesturing, clutter",), ("all cues", "contours only"))
    result = ablating.Result(
        config, held, held, held, np.zeros((2, 1, 4)), np.array([[1.0], [0.0]])
    )
    gain = result.gain("all cues", "contours only", "gesturing, clutter")
    assert gain.estimate == pytest.approx(0.75)


def test_what_is_saved_is_in_collision_and_within_the_limits():
    share = bounding.saved(CHOOSING[6], "gesturing, plain", 8)
    assert 0 <= share < 0.5
    far = bounding.saved(CHOOSING[6], "gesturing, plain", 8, 2.0)
    assert far > share, "with a wider trunk more poses collide"


def test_times_are_those_of_the_benchmarks(tmp_path, monkeypatch):
    rows = [
        {"work": f"{timing.WHOLE}, so many", "ours_s": 0.39, "peer_s": None},
        {"work": f"{timing.SHAPES}, so many", "ours_s": 0.001, "peer_s": 2.0},
    ]
    (tmp_path / "performance.json").write_text(json.dumps({"rows": rows}))
    monkeypatch.setattr(timing, "records", lambda: tmp_path)
    _, whole, shapes, written = timing.run(timing.Config(), rng=np.random.default_rng(0))
    assert whole == pytest.approx(0.01)
    assert (shapes, written) == (0.001, 2.0)
    with pytest.raises(LookupError, match="no row 'legs'"):
        timing.recorded_row("legs")


def test_scenes_are_those_of_the_names():
    for name, scene in SCENES.items():
        kind, behind = name.split(", ")
        assert scene.kind == kind
        assert (scene.clutter, scene.passers) == ((40, 2) if behind == "clutter" else (0, 0))
    assert FRAMES == tracking.FRAMES == 60

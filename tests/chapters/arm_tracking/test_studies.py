"""The studies: runs of trackers and what they count, by law."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from robot_perception.arms.body_model import REST, Measures
from robot_perception.arms.likelihoods import Bodies, EdgeCue, edge_weight, look
from robot_perception.arms.printed import SumCue
from robot_perception.arms.tracker import BOUNDS, CUES
from robot_perception.arms.watching import ArmWatch
from robot_perception.book import arm_tracking as page
from robot_perception.book.arm_tracking import (
    BEGIN,
    CLUTTER,
    FRAMES,
    HELD,
    LAST,
    SCENES,
    WAYS,
    Run,
    face_of,
    film_of,
    follow,
    tracker_of,
)
from robot_perception.chapters.arm_likelihoods.scene import CHOOSING
from studies.rows import Rows, framed


def run_of(wrists, angles=None):
    n = len(wrists)
    angles = np.zeros((n, 8)) if angles is None else angles
    return Run(np.zeros((n, 8)), angles, wrists, np.zeros(n), np.ones(n), np.zeros(n, bool))


def test_an_arm_is_held_if_its_wrist_is_near_in_the_last_second():
    wrists = np.full((48, 2), 50.0)
    wrists[-15:, 0] = HELD - 1
    wrists[-15:, 1] = [HELD - 1] * 14 + [HELD + 20]
    assert run_of(wrists).held == 1


def test_errors_are_told_once_the_first_second_is_over():
    angles = np.zeros((40, 8))
    angles[:15] = 9.0
    angles[15:, 2], angles[15:, 6] = np.radians(10), np.radians(30)
    assert run_of(np.zeros((40, 2)), angles).angle == pytest.approx(5.0)


def test_each_way_is_the_papers_cues_but_for_what_its_name_says():
    shown = film_of(CHOOSING[6], "pointing, plain", 2)
    start = tracker_of().start(shown.frames[0], rng=np.random.default_rng(0), face=shown.face)
    made = {way: {name: make(start.first) for name, make in cues.items()}
            for way, cues in WAYS.items()}  # fmt: skip
    for way, cues in made.items():
        left_out = {"no contours": {"edges"}, "no patches": {"colour", "texture"},
                    "contours only": {"colour", "texture"},
                    "no picture": {"edges", "colour", "texture"}}.get(way, set())  # fmt: skip
        assert set(cues) == set(CUES) - left_out
    for way in ("contours only", "no motion"):
        assert made[way]["edges"].gain is None
        assert made[way]["edges"].toll is None
    assert made["all cues"]["edges"] == EdgeCue(gain=0.5, weight=made["all cues"]["edges"].weight)
    assert all(dict(tracker_of(way).bounds) == dict(BOUNDS) for way in WAYS)


def test_a_run_compares_with_what_is_true_in_the_film():
    shown = film_of(CHOOSING[6], "pointing, plain", 6)
    run = follow(tracker_of(particles=60), shown, CHOOSING[6])
    np.testing.assert_allclose(run.angles, np.abs(run.states - shown.angles))
    assert run.wrists.shape == (6, 2)
    assert run.saved.max() <= 1


def test_the_same_film_and_tracker_give_the_same_run():
    one, two = (
        follow(tracker_of(particles=40), film_of(CHOOSING[2], "gesturing, clutter", 5), 3)
        for _ in range(2)
    )
    np.testing.assert_array_equal(one.states, two.states)


def test_where_no_face_is_found_the_true_one_is_taken():
    shown = film_of(CHOOSING[6], "pointing, plain", 2)
    frames = shown.frames.copy()
    left, top, wide, high = np.rint(shown.face).astype(int)
    frames[:, top - 8 : top + high + 8, left - 8 : left + wide + 8] = 120
    np.testing.assert_array_equal(face_of(replace(shown, frames=frames)), shown.face)
    assert 0 < np.abs(face_of(shown) - shown.face).max() < 8


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


def test_the_error_with_more_particles_is_told_over_that_with_few_over_all_films():
    """Two studies with two films each; other numbers of particles count for nothing."""

    def rows(first):
        return Rows(
            framed(
                {"film": first + k, "particles": m, "angles": first * error}
                for k in (0, 1)
                for m, error in ((25, 99.0), (400, 10.0), (1600, 8.0 + k))
            ),
            "film",
            {},
        )

    assert page.with_more(400, 1600, rows(1)).estimate == pytest.approx(0.85)
    both = page.with_more(400, 1600, rows(1), rows(3))
    assert both.estimate == pytest.approx(4 * 17 / (4 * 20))
    assert both.low < 0.85 < both.high
    few = rows(1).where(particles=400).table
    other = Rows(rows(1).table[rows(1).table["particles"] != 25], "film", {})
    assert len(few) == 2
    assert page.apf_400.value(other).estimate == pytest.approx(0.85)


def test_the_films_of_a_study_are_of_people_who_vary_and_nobody_else_is_changed():
    plain, varied = (film_of(CHOOSING[6], "pointing, plain", 2, varied=by) for by in (0.0, 0.08))
    assert plain.person.build != varied.person.build
    np.testing.assert_array_equal(film_of(CHOOSING[6], "pointing, plain", 2).frames, plain.frames)


def test_scenes_are_those_of_the_names():
    for name, scene in SCENES.items():
        kind, behind = name.split(", ")
        assert scene.kind == kind
        assert (scene.clutter, scene.passers) == ((40, 2) if behind == "clutter" else (0, 0))
    assert FRAMES == 60


# What a trial counts


def filmed(monkeypatch, runs, joints=None):
    """Let every film be one and a tracker make these runs of it, in turn; return what is asked."""
    films, tracked, turn = [], [], iter(runs)

    def of(seed, scene, frames=FRAMES, varied=0.0):
        films.append((seed, scene, frames, varied))
        return SimpleNamespace(joints=joints)

    def stub(tracker, shown, seed):
        tracked.append((tracker, seed))
        return next(turn)

    monkeypatch.setattr(page, "film_of", of)
    monkeypatch.setattr(page, "follow", stub)
    return films, tracked


def test_a_pointing_arm_is_counted_where_it_points_and_its_direction_in_both_ways(monkeypatch):
    """The left arm points sideways, and the estimate of it a little towards the camera."""
    true, states = np.zeros((30, 8)), np.zeros((30, 8))
    true[:, 0] = states[:, 0] = np.pi / 2
    states[:, 1] = 0.5
    wrists = np.full((30, 2), 1.0)
    wrists[:20, 0] = 50.0
    run = replace(run_of(wrists), states=states, effective=np.r_[99.0, np.full(29, 7.0)])
    films, tracked = filmed(monkeypatch, [run] * 2, page.BODY.joints(true))
    trial = page.pointed.trial(film=3, tracker="as in Fig. 13, arms apart")
    assert (trial["points"], trial["near"], trial["effective"]) == (25, 10, 7.0)
    assert trial["degrees"] == pytest.approx(25 * np.degrees(0.5))
    assert trial["flat"] == pytest.approx(0, abs=1e-6)
    assert films == [(3, page.PLAIN, FRAMES, page.VARIED)]
    made, seed = tracked[0]
    assert (made.rules.filter, made.rules.particles, seed) == ("apart", 400, 3)
    assert dict(made.cues) == dict(WAYS["no motion"])
    flat = page.pointed.but(flat=True).trial(film=3, tracker="as in Fig. 13")
    assert flat["degrees"] == flat["flat"]


def test_a_claim_on_pointing_is_a_share_of_pictures_whatever_the_film():
    films = [{"film": k, "tracker": t, "points": n, "near": near, "degrees": 9.0 * n, "flat": 1.0}
             for t, near in (("as in Fig. 13", 10), ("no picture", 0))
             for k, n in ((1, 10), (2, 30))]  # fmt: skip
    rows = Rows(framed(films), "film", {})
    assert page.pointing.value(rows).estimate == pytest.approx(20 / 40)
    assert page.pointing_where.value(rows).estimate == pytest.approx(9)


def test_an_arm_is_near_and_lost_once_a_second_is_over(monkeypatch):
    """Of ten pictures one arm is lost in four; the tracker notices two, and takes one for lost."""
    wrists = np.full((25, 2), 99.0)
    wrists[BEGIN:] = 1.0
    wrists[-4:, 1] = 2 * HELD + 1
    lost = np.zeros(25, dtype=bool)
    lost[:BEGIN] = lost[BEGIN] = lost[-2:] = True
    run = replace(run_of(wrists), lost=lost)
    films, tracked = filmed(monkeypatch, [run] * 4)
    trial = page.cluttered.trial(film=4, cues="no contours")
    assert trial["near"] == pytest.approx(16 / 20)
    assert (trial["noticed"], trial["lost"]) == (2, 4)
    assert films == [(4, CLUTTER, FRAMES, page.VARIED)]
    page.cluttered.trial(film=4, cues="all cues, arms apart")
    page.cluttered.but(whole="no motion").trial(film=4, cues="all cues")
    page.cluttered.but(whole="no motion").trial(film=4, cues="no patches")
    used = [(dict(one.cues), one.rules.filter) for one, _ in tracked]
    ways = ("no contours", "all cues", "no motion", "no patches")
    filters = ("auxiliary", "apart", "auxiliary", "auxiliary")
    assert used == [(dict(WAYS[w]), f) for w, f in zip(ways, filters, strict=True)]


def test_what_a_cue_is_worth_is_what_all_hold_less_what_the_others_do():
    held = {"all cues": 0.9, "no patches": 0.3, "no motion": 0.8}
    trials = [{"film": k, "cues": c, "near": v} for c, v in held.items() for k in (1, 2)]
    rows = Rows(framed(trials), "film", {})
    assert page.clutter.value(rows).estimate == pytest.approx(0.6)
    assert page.clutter_flow.value(rows).estimate == pytest.approx(0.1)


def test_errors_are_of_so_many_particles_and_of_draws_of_their_own(monkeypatch):
    near = np.full((20, 2), 99.0)
    near[BEGIN:, 0] = 1.0
    off = [run_of(near, np.full((20, 8), np.radians(k))) for k in (2, 4, 6)]
    films, tracked = filmed(monkeypatch, off)
    assert page.counted.trial(film=6, particles=25)["angles"] == pytest.approx(3)
    assert [one.rules.particles for one, _ in tracked] == [25, 25]
    assert len({seed for _, seed in tracked}) == 2
    trial = page.filtered.trial(film=6, filter="importance")
    assert trial["angles"] == pytest.approx(6)
    assert trial["near"] == pytest.approx(0.5)
    assert tracked[-1][0].rules.filter == "importance"
    assert films == [(6, "gesturing, plain", 40, page.VARIED)] * 2


def test_enough_tracks_with_the_number_it_is_told_once_and_by_the_cues_of_a_name(monkeypatch):
    off = [run_of(np.zeros((20, 2)), np.full((20, 8), np.radians(k))) for k in (2, 4)]
    films, tracked = filmed(monkeypatch, off)
    assert page.enough.trial(film=6, particles=1600)["angles"] == pytest.approx(2)
    assert page.unseen.trial(film=6, particles=400)["angles"] == pytest.approx(4)
    assert [one.rules.particles for one, _ in tracked] == [1600, 400]
    assert [dict(one.cues) for one, _ in tracked] == [dict(CUES), dict(WAYS["no picture"])]
    assert films == [(6, "gesturing, plain", 40, page.VARIED)] * 2


def test_a_watch_is_asked_about_the_pictures_after_the_first_second():
    """It tells of the tracker that a run tells of, and which arms are off, called and flagged."""
    shown, watch = film_of(CHOOSING[2], CLUTTER, 19), ArmWatch(tracker_of(particles=30), level=-9.0)
    wrists, called, flag = page.watch_over(watch, shown, 3)
    run = follow(tracker_of(particles=30), shown, 3)
    np.testing.assert_allclose(wrists, run.wrists[BEGIN:])
    np.testing.assert_array_equal(flag, run.lost[BEGIN:])
    assert called.shape == (4, 2)
    always, never = (
        page.watch_over(replace(watch, level=level), shown, 3)[1] for level in (0.0, -1e3)
    )
    assert always.all()
    assert not never.any()


def test_arms_that_are_called_lost_are_counted_where_they_are_lost_and_held(monkeypatch):
    """Two arms in thirty pictures: one is lost in six, held in twenty, neither in four."""
    wrists = np.full((30, 2), HELD - 1)
    wrists[:6, 1], wrists[6:10, 1] = 2 * HELD + 1, 2 * HELD - 1
    called, flag = np.zeros((30, 2), bool), np.zeros(30, bool)
    called[:3, 1] = called[8:12, 1] = called[19, 0] = True
    flag[5:8] = True
    asked = []

    def stub(watch, shown, seed):
        asked.append((watch, seed))
        return wrists, called, flag

    films, _ = filmed(monkeypatch, [])
    monkeypatch.setattr(page, "watch_over", stub)
    trial = page.watched.trial(film=7, filter="apart", lost_arms="start anew")
    counts = {"lost": 6, "held": 50, "noticed": 3, "wronged": 3, "flagged": 1, "called": 8}
    assert {name: trial[name] for name in counts} == counts
    assert trial["arms"] == 60
    assert trial["both"]
    wrists[-LAST:, 1] += np.r_[np.full(14, 0.0), 20.0 * LAST]
    assert not page.watched.trial(film=7, filter="auxiliary", lost_arms="stay")["both"]
    (one, seed), (other, _) = asked
    assert (one.tracker.rules.filter, other.tracker.rules.filter) == ("apart", "auxiliary")
    assert (one.anew, other.anew, seed) == (page.LOST_ARMS["start anew"], 0.0, 7)
    assert one.level == other.level == ArmWatch(tracker_of()).level, "the library's own"
    assert films == [(7, CLUTTER, FRAMES, page.VARIED)] * 2
    assert not set(page.chosen.axes["film"]) & set(page.FRESH)


def test_each_form_of_the_sum_is_tracked_with_all_else_as_in_the_paper_s_figure():
    shown = film_of(CHOOSING[6], "pointing, plain", 2)
    for scene, form, patches in page.TRIED.values():
        tracker = page.tracker_by(scene, form, patches)
        usual = WAYS["no motion"] if scene == page.PLAIN else CUES
        kept = {k: m for k, m in usual.items() if patches or k not in ("colour", "texture")}
        assert {k: m for k, m in tracker.cues.items() if k != "edges"} == {
            k: m for k, m in kept.items() if k != "edges"
        }
        assert dict(tracker.bounds) == dict(BOUNDS)
        cut = tracker.rules.edges.most
        if form is None:
            assert tracker.cues["edges"] is usual["edges"]
            assert cut == 5
            continue
        state = tracker.start(shown.frames[0], rng=np.random.default_rng(0), face=shown.face)
        cue = state.cues["edges"]
        gain = None if scene == page.PLAIN else 0.5
        weight = edge_weight(look(shown.frames[0]))
        assert cue == SumCue(page.SIGMAS[form], gain, weight, form)
        assert state.first.seen.static.max() > 5, "no distance is cut"


def test_arms_are_asked_about_while_they_point_or_once_a_second_is_over(monkeypatch):
    true = np.zeros((FRAMES, 8))
    true[:, 0] = np.pi / 2  # the left arm points all the time
    wrists = np.full((FRAMES, 2), HELD - 1)
    wrists[:25] = HELD + 1
    run = replace(run_of(wrists), effective=np.r_[99.0, np.full(FRAMES - 1, 7.0)])
    films, tracked = filmed(monkeypatch, [run] * 2, page.BODY.joints(true))
    point = page.printed.trial(film=8, tried="pointing, eq. (2)")
    assert (point["asked"], point["near"], point["effective"]) == (FRAMES - 5, FRAMES - 25, 7.0)
    both = page.printed.trial(film=8, tried="clutter, ours")
    assert (both["asked"], both["near"]) == (2 * (FRAMES - BEGIN), 2 * (FRAMES - 25))
    scenes = [(8, scene, FRAMES, page.VARIED) for scene in (page.PLAIN, CLUTTER)]
    assert films == scenes
    assert tracked[1][0].cues["edges"] is CUES["edges"]


def test_forms_are_compared_film_by_film():
    """Ours holds 6 of 10 and 4 of 8, eq. (2) 3 of 10 and 4 of 8: 0.15 of the time more."""
    near = {"clutter, ours": (6, 4), "clutter, eq. (2)": (3, 4), "pointing, ours": (0, 0)}
    rows = Rows(
        framed(
            {"film": k, "tried": tried, "near": found[k], "asked": (10, 8)[k]}
            for k in (0, 1)
            for tried, found in near.items()
        ),
        "film",
        {},
    )
    assert page.lost_by(rows, "clutter").estimate == pytest.approx(0.15)


def test_a_saved_state_is_in_collision_and_within_the_limits_of_the_joints(monkeypatch):
    """Five states, one kind twice: all are asked about, and two are saved by the test alone."""
    free, cross = REST, np.tile([0.3, 1.2, 2.9, 1.4], 2)
    beyond, both = free.copy(), cross.copy()
    beyond[3], both[2] = -0.01, 3.05
    states = np.array([free, cross, cross + 0.01, beyond, both])
    hit = [False, True, True, False, True]
    assert page.BODY.collides(states).tolist() == hit
    seen, sizes = look(np.zeros((240, 320, 3), np.uint8)), []

    def stub(tracker, shown, seed):
        sizes.append((tracker.measures.trunk, tracker.measures.head, set(tracker.bounds)))
        made = tracker.bounds["collisions"](None)
        assert (made(seen, Bodies(page.BODY, states)) < 0).tolist() == hit
        return replace(run_of(np.zeros((5, 2))), saved=np.array([9.0, 0.1, 0.2, 0.3, 0.4]))

    films, _ = filmed(monkeypatch, [])
    monkeypatch.setattr(page, "follow", stub)
    trial = page.saved.trial(film=5, kind="near")
    assert (trial["saved"], trial["unmeasured"]) == pytest.approx((0.4, 0.25))
    page.saved.but(slim=0.2).trial(film=5, kind="near")
    usual = Measures()
    assert sizes[0] == (usual.trunk, usual.head, set(BOUNDS))
    np.testing.assert_allclose(sizes[1][0], 0.2 * np.array(usual.trunk))
    assert sizes[1][1] == pytest.approx(0.2 * usual.head)
    assert films[0] == (5, "near, plain", FRAMES, page.VARIED)


def test_weighing_is_counted_by_its_stages_and_by_what_the_others_leave(monkeypatch):
    """Milliseconds, chosen so that both ways differ."""
    took = {page.WHOLE: 39 * 100, "arms scored by patches": 20, "arms scored by contours": 10,
            "arms looked at": 6, "arms tested for collisions": 4}  # fmt: skip
    record = SimpleNamespace(find=lambda work: SimpleNamespace(ours_s=took[work] / 1000))
    monkeypatch.setattr(page, "Record", SimpleNamespace(read=lambda: record))
    trial = page.timed.trial(machine="mine")
    assert trial["whole"] == pytest.approx(0.1)
    assert (trial["low"], trial["high"]) == pytest.approx((50 / 60, 90 / 100))
    few = page.timed.but(particles=40).trial(machine="mine")
    assert (few["low"], few["high"]) == pytest.approx((5 / 15, 9 / 19))
    share = page.observing.value(Rows(framed([trial]), "machine", {}))
    np.testing.assert_allclose(
        [share.low, share.estimate, share.high], [50 / 60, (50 / 60 + 0.9) / 2, 0.9]
    )

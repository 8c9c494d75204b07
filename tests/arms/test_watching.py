"""The watch over arms: the average by hand, who is called lost, and who is drawn anew."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from robot_perception.arms.body_model import REST
from robot_perception.arms.likelihoods import Bodies, apart, look
from robot_perception.arms.tracker import ArmRules, ArmTracker
from robot_perception.arms.watching import ArmWatch, WatchState, arm_logs
from robot_perception.beliefs import ParticleSet
from tests.arms.test_likelihoods import CAMERA
from tests.arms.test_tracker import FILM
from tests.unchecked import unchecked

FEW = ArmTracker(CAMERA, rules=ArmRules(particles=60))


def rng(seed=1):
    return np.random.default_rng(seed)


def begun(watch=None, pose=FILM.angles[0], source=None):
    watch = ArmWatch(FEW) if watch is None else watch
    return watch.start(FILM.frames[0], rng=source or rng(), face=FILM.face, pose=pose)


def test_a_watch_changes_nothing_of_the_tracker():
    """Bit for bit, although it calls arms lost."""
    watch, source, own = ArmWatch(FEW, level=0.0), rng(), rng()
    state = begun(watch, source=source)
    alone = FEW.start(FILM.frames[0], rng=own, face=FILM.face, pose=FILM.angles[0])
    for image in FILM.frames[1:7]:
        state, info = watch.step(state, image, rng=source)
        alone, other = FEW.step(alone, image, rng=own)
        np.testing.assert_array_equal(state.arms.particles.states, alone.particles.states)
        np.testing.assert_array_equal(info.arms.joints, other.joints)
        assert info.lost.all()
    assert state.lost.tolist() == [6, 6]


def test_the_level_is_the_average_of_what_the_cues_say_of_each_arm():
    """L_t = (1 - κ) L_{t-1} + κ l_t, with the flow from the picture before."""
    watch, source = ArmWatch(FEW, newest=0.3), rng()
    state = begun(watch, source=source)
    body = Bodies(state.arms.first.model, state.arms.mean[None])
    level = sum(apart(state.arms.cues, look(FILM.frames[0]), body).values())[0]
    np.testing.assert_allclose(state.level, level)
    for before, image in zip(FILM.frames[:5], FILM.frames[1:6], strict=True):
        state, info = watch.step(state, image, rng=source)
        seen = look(image, cv2.cvtColor(before, cv2.COLOR_RGB2GRAY), FEW.rules.edges)
        body = Bodies(state.arms.first.model, state.arms.mean[None])
        logs = sum(apart(state.arms.cues, seen, body).values())[0]
        np.testing.assert_allclose(arm_logs(state.arms, seen), logs)
        level = 0.7 * level + 0.3 * logs
        np.testing.assert_allclose(info.level, level)
        np.testing.assert_array_equal(info.level, state.level)
        assert info.level[0] != info.level[1]


def test_the_arm_that_hangs_beside_the_person_is_called_lost_and_the_other_is_not():
    """One arm is put where there is none; its likelihood is far below that of the other."""
    watch, source = ArmWatch(FEW, level=-25.0, newest=1.0), rng()
    state = begun(watch, source=source)
    astray = state.arms.particles.states.copy()
    astray[:, 4:] = [1.9, 0.0, 1.2, 0.2]
    still = replace(FEW.rules, noise=(1e-6,) * 4)
    watch = replace(watch, tracker=replace(FEW, rules=still))
    gone = replace(state, arms=replace(state.arms, particles=ParticleSet.uniform(astray)))
    kept, right = watch.step(state, FILM.frames[1], rng=source)
    after, info = watch.step(gone, FILM.frames[1], rng=source)
    assert right.lost.tolist() == [False, False]
    assert info.lost.tolist() == [False, True]
    assert (kept.lost.tolist(), after.lost.tolist()) == ([0, 0], [0, 1])
    twice, _ = watch.step(after, FILM.frames[2], rng=source)
    assert twice.lost.tolist() == [0, 2]


@pytest.mark.parametrize(("level", "lost"), [(0.0, False), (-1e6, True)])
def test_one_picture_does_not_outweigh_the_average(level, lost):
    """An arm that has been seen well is not lost by a bad picture, nor is a lost one found."""
    watch, source = ArmWatch(FEW, level=-500.0, newest=0.01), rng()
    state = replace(begun(watch, source=source), level=np.full(2, level))
    _, info = watch.step(state, FILM.frames[1], rng=source)
    assert (info.level < -500.0).tolist() == info.lost.tolist() == [lost, lost]


def test_a_share_of_a_lost_arm_is_drawn_over_all_that_its_joints_allow():
    watch = ArmWatch(FEW, anew=0.25)
    state = begun(watch).arms
    many = ParticleSet.uniform(REST + 0.01 * rng().standard_normal((4000, 8)))
    low, high = state.first.model.limits.T
    found = watch._anew(replace(state, particles=many), np.array([False, True]), rng())
    np.testing.assert_array_equal(np.exp(found.log_weights), 1 / 4000)
    moved = np.abs(found.states - REST) > 0.1
    assert not moved[:, :4].any()
    new = found.states[moved[:, 4:].any(axis=1), 4:]
    assert len(new) == 1000
    assert (new >= low).all()
    assert (new <= high).all()
    np.testing.assert_allclose(new.mean(axis=0), (low + high) / 2, atol=0.12)
    np.testing.assert_allclose(new.std(axis=0), (high - low) / 12**0.5, rtol=0.1)


def test_both_arms_of_a_particle_are_drawn_anew_by_chance_alone():
    many = ParticleSet.uniform(np.tile(REST, (4000, 1)))
    arms = replace(begun().arms, particles=many)
    found = ArmWatch(FEW, anew=0.25)._anew(arms, np.array([True, True]), rng())
    new = (found.states.reshape(4000, 2, 4) != REST.reshape(2, 4)).any(axis=2)
    assert new.sum(axis=0).tolist() == [1000, 1000]
    assert 200 < new.all(axis=1).sum() < 300


def test_what_is_not_drawn_anew_is_drawn_by_weight():
    weights = np.log(np.r_[np.full(50, 1e-9), np.full(50, 0.02)])
    states = np.vstack([REST + np.zeros((50, 8)), REST + np.full((50, 8), 0.2)])
    arms = replace(begun().arms, particles=ParticleSet(states, weights))
    found = ArmWatch(FEW, anew=0.1)._anew(arms, np.array([True, False]), rng())
    np.testing.assert_allclose(found.states[:, 4:], np.broadcast_to(REST[4:] + 0.2, (100, 4)))
    assert (np.abs(found.states[:, :4] - REST[:4] - 0.2) > 1e-9).any(axis=1).sum() == 10


def test_arms_are_drawn_anew_only_when_one_is_lost_and_it_is_asked(monkeypatch):
    asked = []
    monkeypatch.setattr(
        ArmWatch, "_anew", lambda self, arms, lost, rng: asked.append(lost) or arms.particles
    )
    state = begun()
    lost = WatchState(state.arms, state.level, np.array([0, 3]))
    for anew, known in ((0.0, lost), (0.2, state), (0.2, lost)):
        ArmWatch(FEW, anew=anew).step(known, FILM.frames[1], rng=rng())
    assert [one.tolist() for one in asked] == [[False, True]]
    found, info = ArmWatch(FEW, level=-1e3).step(lost, FILM.frames[1], rng=rng())
    assert found.lost.tolist() == [0, 0], "neither is lost any more"
    assert not info.lost.any()


def test_a_lost_arm_that_is_drawn_anew_is_found():
    """It was put where there is none; a few pictures of a still film are enough."""
    tracker = ArmTracker(CAMERA, rules=ArmRules(particles=400, filter="apart"))
    off = {}
    for anew in (0.0, 0.3):
        watch, source = ArmWatch(tracker, level=-8.7, newest=0.5, anew=anew), rng()
        state = begun(watch, source=source)
        astray = state.arms.particles.states.copy()
        astray[:, 4:] = [2.0, 0.0, 1.2, 0.1]
        state = replace(state, arms=replace(state.arms, particles=ParticleSet.uniform(astray)))
        for _ in range(10):
            state, _ = watch.step(state, FILM.frames[0], rng=source)
        model = state.arms.first.model
        wrist = model.pixels(model.joints(state.arms.mean[None]))[0, 1, 2]
        off[anew] = np.linalg.norm(wrist - FILM.stage.pixels(FILM.joints[0, :, 2])[1])
    assert off[0.3] < 12
    assert off[0.0] > off[0.3]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"newest": 1.5}, "newest must be"), ({"anew": -0.1}, "anew must be"),
     ({"level": np.nan}, "level must be finite")],
)  # fmt: skip
def test_what_is_no_share_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        ArmWatch(FEW, **wrong)


def test_a_tracker_s_state_is_no_state_of_a_watch():
    with unchecked(), pytest.raises(TypeError, match="state must be a WatchState"):
        ArmWatch(FEW).step(begun().arms, FILM.frames[1], rng=rng())

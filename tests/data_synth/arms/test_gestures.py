"""Films of gestures: smooth, within reach, without collisions, and what moves behind."""

import numpy as np
import pytest

from data_synth.arms import gestures
from data_synth.arms.bodies import SIDES, Build, Person, Stage, make_outfit
from data_synth.arms.gestures import REST, ArmScene, _hits, film_arms, make_motion
from data_synth.companion.faces import make_identity

WHO = make_identity(np.random.default_rng(0), tone=1)
PERSON = Person(Build(), make_outfit(np.random.default_rng(0), "plain"), WHO)


def motion(kind, seed=0, frames=90):
    return make_motion(np.random.default_rng(seed), frames, ArmScene(kind), PERSON)


@pytest.mark.parametrize("kind", ["pointing", "gesturing", "pausing"])
def test_motions_begin_at_rest_are_smooth_and_move_the_arms(kind):
    for seed in range(4):
        angles = motion(kind, seed)
        np.testing.assert_array_equal(angles[0], np.tile(REST, 2))
        assert np.abs(np.diff(angles, axis=0)).max() < 0.4
        assert np.ptp(angles, axis=0).max() > 0.8


def test_who_points_moves_one_arm_at_a_time():
    moves = np.abs(np.diff(motion("pointing", 3), axis=0)).reshape(-1, 2, 4).max(axis=2) > 1e-9
    assert moves.all(axis=1).sum() <= 3, "only where one stops and the other one begins"
    assert moves.any(axis=0).all()


def test_who_pauses_stands_still_for_a_third_of_the_film():
    steps = np.abs(np.diff(motion("pausing"), axis=0)).max(axis=1)
    assert (steps[31:59] == 0).all()
    assert (steps[:29] > 0).mean() > 0.9
    assert (steps[62:] > 0).mean() > 0.9


def test_who_stands_still_does_not_move():
    assert np.ptp(motion("still"), axis=0).max() == 0


def test_no_hand_goes_through_the_body_or_the_head():
    for seed in range(6):
        for pose in motion("gesturing", seed)[::5]:
            joints = PERSON.joints(pose, np.zeros(3))
            far = joints[:, 2:].reshape(-1, 3)
            trunk = (far[:, 0] / 0.2) ** 2 + (far[:, 2] / 0.13) ** 2
            assert ((trunk > 1) | (far[:, 1] < -0.05)).all()
            head = np.linalg.norm(far - [0, -PERSON.build.drop, 0], axis=1)
            assert (head > 0.13).all()


def test_a_film_says_what_is_true_in_it():
    film = film_arms(np.random.default_rng(2), 5, ArmScene("gesturing"), PERSON)
    assert film.frames.shape == (5, 240, 320, 3)
    assert film.frames.dtype == np.uint8
    for t in range(5):
        wanted = PERSON.joints(film.angles[t], film.stage.middle)
        np.testing.assert_allclose(film.joints[t], wanted)
    again = film_arms(np.random.default_rng(2), 5, ArmScene("gesturing"), PERSON)
    np.testing.assert_array_equal(film.frames, again.frames)


def test_people_behind_walk_and_the_wall_stands_still():
    still = np.tile(REST, (6, 2))
    quiet = film_arms(np.random.default_rng(3), 6, ArmScene("still"), PERSON, angles=still)
    walked = film_arms(
        np.random.default_rng(3), 6, ArmScene("still", passers=2), PERSON, angles=still
    )
    behind = (quiet.parts == 0).all(axis=0)
    change = [np.abs(f.frames[5].astype(int) - f.frames[0])[behind].mean()
              for f in (quiet, walked)]  # fmt: skip
    assert change[1] > 1.3 * change[0]
    for film in (quiet, walked):
        np.testing.assert_array_equal(film.parts[0], film.parts[5])


def test_a_walker_goes_at_his_speed_turns_and_comes_back(monkeypatch):
    laid, stage = [], Stage()
    monkeypatch.setattr(gestures, "lay", lambda canvas, sprite, at, tall: laid.append(at[0]))
    monkeypatch.setattr(gestures, "body_sprite", lambda *_, **__: np.zeros((2, 2, 4)))
    for seed in range(3):
        laid.clear()
        walker = gestures._Walker(np.random.default_rng(seed), stage)
        for t in range(300):
            walker.lay(np.zeros(0), t)
        scale, steps = stage.focal / walker.away, np.abs(np.diff(laid))
        usual = scale * abs(walker.speed) / 15
        assert np.median(steps) == pytest.approx(usual)
        assert steps.max() == pytest.approx(usual), "never farther, less where he turns"
        assert np.ptp(laid) == pytest.approx(4.8 * scale, abs=2 * usual)


def test_clutter_has_more_edges():
    def rough(clutter):
        film = film_arms(np.random.default_rng(4), 1, ArmScene("still", clutter), PERSON)
        return np.abs(np.diff(film.frames[0].astype(int), axis=1)).mean()

    assert rough(40) > 1.3 * rough(0)


def test_light_goes_to_and_fro():
    still = np.tile(REST, (31, 2))
    film = film_arms(np.random.default_rng(5), 31, ArmScene("still", light=0.6), PERSON,
                     angles=still)  # fmt: skip
    levels = film.frames.mean(axis=(1, 2, 3))
    assert np.ptp(levels) > 8


@pytest.mark.parametrize("side", SIDES)
def test_both_arms_gesture(side):
    angles = motion("gesturing", 1).reshape(-1, 2, 4)[:, (side + 1) // 2]
    assert np.ptp(angles, axis=0).min() > 0.1


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="kind"):
        ArmScene("dancing")
    with pytest.raises(ValueError, match="angles must be"):
        film_arms(np.random.default_rng(0), 2, angles=np.zeros((3, 8)))


def test_people_who_vary_have_builds_and_rests_of_their_own_and_the_same_clothes():
    plain, varied = (
        film_arms(np.random.default_rng(7), 2, ArmScene("pointing", varied=by)) for by in (0, 0.1)
    )
    assert plain.person.outfit.seed == varied.person.outfit.seed
    assert plain.person.build != varied.person.build
    np.testing.assert_array_equal(plain.angles[0], np.tile(REST, 2))
    assert np.abs(varied.angles[0] - np.tile(REST, 2)).max() > 0.05
    builds = [
        film_arms(np.random.default_rng(seed), 1, ArmScene("still", varied=0.2)).person.build
        for seed in range(30)
    ]
    assert 0.12 < np.std(np.log([build.upper for build in builds])) < 0.3


def test_hands_near_the_body_are_near_it_and_do_not_go_through_it():
    scene = ArmScene("near")
    person = film_arms(np.random.default_rng(3), 1).person
    for seed in range(4):
        motion = make_motion(np.random.default_rng(seed), 60, scene, person)
        assert not any(_hits(person, pose, -0.04) for pose in motion)
        assert np.mean([_hits(person, pose, 0.03) for pose in motion]) > 0.15
    free = make_motion(np.random.default_rng(0), 60, ArmScene("gesturing"), person)
    assert np.mean([_hits(person, pose, 0.05) for pose in free]) < 0.3


def test_a_trunk_that_sways_takes_the_joints_along_and_nothing_else():
    still, moving = (
        film_arms(np.random.default_rng(2), 40, ArmScene("pointing", sway=sway), PERSON)
        for sway in (0.0, 0.04)
    )
    np.testing.assert_array_equal(still.angles, moving.angles)
    off = moving.joints - still.joints
    np.testing.assert_allclose(off, np.broadcast_to(off[:, :1, :1], off.shape), atol=1e-12)
    aside = off[:, 0, 0, 0]
    np.testing.assert_array_equal(off[..., 1:], 0)
    assert 0.01 < np.abs(aside).max() <= 0.04
    assert np.abs(np.diff(aside)).max() < 0.01, "it sways, and does not jump"
    np.testing.assert_allclose(aside[0], moving.stage.aside)
    t = int(np.abs(aside).argmax())
    shift = float(moving.stage.focal * aside[t] / moving.stage.away)
    middles = [np.flatnonzero((film.parts[t] == 1).any(axis=0)).mean() for film in (still, moving)]
    assert middles[1] - middles[0] == pytest.approx(shift, abs=1.2)  # laid by whole px


def test_a_trunk_that_turns_turns_about_its_own_middle():
    film = film_arms(np.random.default_rng(2), 40, ArmScene("still", turn=0.3), PERSON)
    across = film.joints[:, 1, 0] - film.joints[:, 0, 0]
    turned = np.arctan2(-across[:, 2], across[:, 0])
    assert 0.1 < np.abs(turned).max() <= 0.3
    assert np.linalg.norm(across, axis=1) == pytest.approx(PERSON.build.apart)
    np.testing.assert_allclose(
        film.joints[:, :, 0].mean(axis=1), np.tile(film.stage.middle, (40, 1)), atol=1e-12
    )
    arm = film.joints[:, 0] - film.joints[:, 0, :1]
    np.testing.assert_allclose(arm[..., 1], np.tile(arm[0, :, 1], (40, 1)), atol=1e-12)
    t = int(turned.argmax())  # the shoulder on the right is nearer: that arm is drawn wider
    wide = [(np.isin(film.parts[t], names)).sum() for names in ((3, 4, 5), (6, 7, 8))]
    assert wide[1] > wide[0]

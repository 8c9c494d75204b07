"""The tracker of two arms: painted arms are followed, by three filters, and what is refused."""

from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from data_synth.arms.gestures import ArmScene, film_arms
from robot_perception.arms import tracker as tracker_module
from robot_perception.arms.body_model import REST, BodyModel
from robot_perception.arms.likelihoods import (
    COLOUR,
    TEXTURE,
    Bodies,
    EdgeCue,
    EdgeRules,
    PatchCue,
    StabiliserCue,
    look,
)
from robot_perception.arms.tracker import (
    BOUNDS,
    CUES,
    FILTERS,
    ArmRules,
    ArmTracker,
    Picture,
    _reached,
    _skin,
    find_face,
)
from robot_perception.beliefs import ParticleSet
from robot_perception.companion.boxes import overlap
from tests.arms.test_likelihoods import CAMERA, IMAGE, MODEL, painted
from tests.unchecked import unchecked

FACE = np.array([145.0, 42.0, 29.8, 29.8])
FILM = film_arms(np.random.default_rng(106), 16, ArmScene("pointing", pace=1.0))
FEW = ArmTracker(CAMERA, rules=ArmRules(particles=40, rounds=2))


def rng(seed=1):
    return np.random.default_rng(seed)


def followed(tracker, frames=FILM.frames, seed=1):
    source = rng(seed)
    state = tracker.start(frames[0], rng=source, face=FILM.face, pose=FILM.angles[0])
    infos = []
    for image in frames[1:]:
        state, info = tracker.step(state, image, rng=source)
        infos.append(info)
    return state, infos


def off(state):
    wrists = state.first.model.pixels(state.first.model.joints(state.mean[None]))[0, :, 2]
    return np.linalg.norm(wrists - FILM.stage.pixels(FILM.joints[-1, :, 2]), axis=1).max()


@pytest.mark.parametrize("name", FILTERS)
def test_pointing_arms_are_followed_by_each_filter(name):
    state, infos = followed(ArmTracker(CAMERA, rules=ArmRules(filter=name)))
    assert off(state) < 16
    moved = FILM.stage.pixels(FILM.joints[[0, -1], :, 2])
    assert np.linalg.norm(moved[1] - moved[0], axis=-1).max() > 40, "an arm did move"
    assert not infos[-1].lost
    assert all(1 <= info.effective <= 400 for info in infos)
    np.testing.assert_allclose(
        infos[-1].joints, state.first.model.joints(state.mean[None])[0], atol=1e-12
    )
    assert set(infos[-1].logs) == set(CUES)
    assert (state.spread > 0).all()


def test_the_same_seed_gives_the_same_arms():
    one, two, other = (followed(FEW, seed=seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.particles.states, two.particles.states)
    assert np.abs(one.particles.states - other.particles.states).max() > 1e-3


def test_a_step_changes_nothing_that_it_is_given():
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face)
    states, image = state.particles.states.copy(), FILM.frames[1].copy()
    FEW.step(state, FILM.frames[1], rng=rng())
    np.testing.assert_array_equal(states, state.particles.states)
    np.testing.assert_array_equal(image, FILM.frames[1])


def test_the_first_pose_is_found_near_the_one_at_rest():
    tracker = ArmTracker(CAMERA)
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face)
    wrists = state.first.model.pixels(state.first.model.joints(state.mean[None]))[0, :, 2]
    true = FILM.stage.pixels(FILM.joints[0, :, 2])
    assert np.linalg.norm(wrists - true, axis=1).max() < 16
    np.testing.assert_array_equal(state.first.state, state.first.state)
    assert state.first.reference.shape == (6, 4, 8)
    np.testing.assert_allclose(state.first.reference.sum(axis=-1), 1)


def test_the_search_for_the_first_pose_narrows_from_round_to_round(monkeypatch):
    widths = []

    def stub(particles, move, weigh, *, rng):
        widths.append(move(np.zeros((5000, 8)), rng).std(axis=0))
        return particles, None

    monkeypatch.setattr(tracker_module, "condensation", stub)
    rules = ArmRules(particles=40, rounds=4)
    ArmTracker(CAMERA, rules=rules).start(FILM.frames[0], rng=rng(), face=FILM.face)
    assert len(widths) == 4
    np.testing.assert_allclose(widths[0][:4], [0.25, 0.2, 0.4, 0.3], rtol=0.05)
    np.testing.assert_allclose(np.divide(widths[1:], widths[:-1]), 0.7, rtol=0.06)


def test_patches_are_placed_and_the_picture_is_seen_as_the_first_pose_and_the_rules_say():
    pose = REST + np.array([0.8, 0.3, 0.9, 0.6, 0, 0, 0, 0])
    rules = ArmRules(particles=20, edges=EdgeRules(most=3.0))
    first = ArmTracker(CAMERA, rules=rules).start(
        FILM.frames[0], rng=rng(), face=FILM.face, pose=pose
    ).first  # fmt: skip
    np.testing.assert_array_equal(first.patches.around, first.model.place(pose).around)
    assert np.abs(first.patches.around - first.model.place(REST).around).max() > 0.1
    assert first.seen.most == 3.0


def test_skin_is_what_the_middle_of_a_face_shows():
    """Hair, chin and the sides of the square are of other colours, and count for nothing."""
    image = np.full((240, 320, 3), 20, dtype=np.uint8)
    image[60:100, 100:140] = (10, 250, 90)
    image[74:94, 110:130] = (220, 170, 140)  # from 0.35 to 0.85 down, from 0.25 to 0.75 across
    found = _skin(look(image), np.array([100.0, 60.0, 40.0, 40.0]), 8)
    np.testing.assert_allclose(found[:3], np.eye(8)[[6, 5, 4]])
    np.testing.assert_allclose(found.sum(axis=1), 1)


@pytest.mark.parametrize(("pull", "reached"), [(4.0, True), (80.0, False)])
def test_a_hand_is_led_to_a_near_place_and_an_angle_by_three_deviations_at_most(pull, reached):
    model, noise = MODEL, np.tile([0.13, 0.13, 0.2, 0.2], 2)
    states = REST + 0.05 * rng().standard_normal((30, 8))

    def hands(states):
        joints = model.joints(states)
        return model.pixels((joints[:, :, 2] + joints[:, :, 3]) / 2)

    goals = hands(REST[None])[0] + [[-pull, 0], [pull, -pull]]
    found = _reached(model, states, goals, np.array([True, False]), noise)
    np.testing.assert_array_equal(found[:, 4:], states[:, 4:])
    moved = np.abs(found - states)[:, :4] / noise[:4]
    before, after = (np.linalg.norm(hands(s)[:, 0] - goals[0], axis=-1) for s in (states, found))
    assert (after < before).mean() > 0.9
    assert moved.max() <= 3 + 1e-12
    assert (np.median(after) < 3) == reached
    assert (moved.max() > 2.9) != reached


def test_the_evidence_of_arms_drawn_apart_is_that_of_both():
    """What a cue adds to the likelihood of each arm it adds twice to the evidence."""
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)

    def evidence(level):
        cue = Pulled(REST, [0.3, 0.3])
        picture = Picture(state, look(FILM.frames[1]), FEW.rules)
        picture.log_likelihoods = lambda states: level + cue.arms(None, Bodies(MODEL, states))
        return FILTERS["apart"](picture, rng())[1].log_evidence

    assert evidence(-700.0) == pytest.approx(evidence(0.0) - 1400, rel=1e-9)


def test_a_face_is_found_and_none_is_told():
    found = find_face(FILM.frames[0])
    assert overlap(found[None], FILM.face[None])[0, 0] > 0.6
    with pytest.raises(ValueError, match="image must show a face, found none"):
        find_face(IMAGE)
    with pytest.raises(ValueError, match="image must show a face"):
        FEW.start(IMAGE, rng=rng())


@pytest.mark.parametrize("left", [True, False])
def test_of_several_faces_the_largest_is_found(left):
    near = cv2.resize(FILM.frames[0], None, fx=1.3, fy=1.3)[:240]
    image = np.hstack([near, FILM.frames[0]] if left else [FILM.frames[0], near])
    wanted = 1.3 * FILM.face + (0 if left else [320, 0, 0, 0])
    assert overlap(find_face(image)[None], wanted[None])[0, 0] > 0.6


def test_a_step_tells_what_the_cues_say_of_the_two_pictures_at_the_estimate():
    """Each number of the info by its formula; the flow is that from the picture before."""
    tracker = ArmTracker(CAMERA, rules=ArmRules(particles=60))
    source = rng()
    state = tracker.start(FILM.frames[0], rng=source, face=FILM.face, pose=FILM.angles[0])
    hidden, moved = 0, 0
    for before, image in zip(FILM.frames[:6], FILM.frames[1:7], strict=True):
        state, info = tracker.step(state, image, rng=source)
        seen = look(image, cv2.cvtColor(before, cv2.COLOR_RGB2GRAY), tracker.rules.edges)
        body = Bodies(state.first.model, state.mean[None])
        assert info.logs == {name: cue(seen, body)[0] for name, cue in state.cues.items()}
        visible = body.contours.visible
        far = EdgeCue().distances(seen, body)[visible]
        np.testing.assert_allclose(info.contour, np.sqrt(np.mean(far**2)), rtol=1e-12)
        parts = PatchCue(state.first.patches, state.first.reference).squared(seen, body)
        np.testing.assert_allclose(info.patches, parts.mean() / len(COLOUR), rtol=1e-12)
        hidden, moved = hidden + (~visible).sum(), moved + seen.moves
    assert hidden
    assert moved == 6


def test_edges_that_move_draw_the_contours():
    """The same picture: where its edges are said to move, poses on them are likelier."""
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=FILM.angles[0])
    body = Bodies(state.first.model, FILM.angles[:1] + 0.05)
    still = look(FILM.frames[0])
    moves = replace(still, moving=np.zeros_like(still.moving))
    assert state.cues["edges"](moves, body)[0] > state.cues["edges"](still, body)[0]


@pytest.mark.parametrize(("name", "own"), [("colour", COLOUR), ("texture", TEXTURE)])
def test_colour_and_texture_are_trusted_by_their_own_channels(name, own):
    """A channel that is in one bin takes the patches' trust from the cue that compares it."""
    first = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=FILM.angles[0]).first
    weights = CUES[name](first).weights
    for channel in range(4):
        plain = first.reference.copy()
        plain[:, channel] = np.eye(8)[0]
        found = CUES[name](replace(first, reference=plain)).weights
        if channel in own:
            assert (found < weights).all()
        else:
            np.testing.assert_array_equal(found, weights)


@pytest.mark.parametrize("ahead", [("b",), ("a", "c"), ("unknown",)])
def test_the_filter_looks_ahead_with_the_cues_that_its_rules_name(ahead):
    values = {"a": 1.0, "b": 10.0, "c": 100.0}
    cues = {name: lambda first, v=v: lambda seen, bodies: np.full(len(bodies), v)
            for name, v in values.items()}  # fmt: skip
    tracker = ArmTracker(CAMERA, rules=ArmRules(particles=5, ahead=ahead), cues=cues)
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)
    picture = Picture(state, look(FILM.frames[1]), tracker.rules)
    wanted = sum(v for name, v in values.items() if name in ahead)
    np.testing.assert_array_equal(picture.ahead(state.particles.states), wanted)
    np.testing.assert_array_equal(picture.log_likelihood(np.tile(REST, (3, 1))), 111.0)


@pytest.mark.parametrize("name", FILTERS)
def test_where_no_cue_speaks_the_prediction_stays_as_it_is(name):
    """Mean and spread are those of the motion, wherever a filter draws its particles."""
    flat = {"flat": lambda first: lambda seen, bodies: np.zeros(len(bodies))}
    rules = ArmRules(filter=name, particles=20000)
    tracker = ArmTracker(CAMERA, rules=rules, cues=flat, bounds={})
    start = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=FILM.angles[0])
    after, _ = tracker.step(start, FILM.frames[-1], rng=rng(2))
    noise = np.tile(rules.noise, 2)
    np.testing.assert_array_less(np.abs(after.mean - start.mean) / noise, 0.05)
    np.testing.assert_allclose(after.spread, np.hypot(start.spread, noise), rtol=0.05)


def test_a_cue_of_ones_own_joins_and_others_leave():
    """A pull to another pose, alone: the arms go there whatever the picture shows."""
    goal = REST + 0.2
    mine = {"mine": lambda first: StabiliserCue(40.0, goal)}
    tracker = ArmTracker(CAMERA, cues=mine)
    state, infos = followed(tracker)
    assert np.abs(state.mean - goal).max() < 0.15
    assert set(infos[0].logs) == {"mine"}


def test_states_that_break_a_bound_are_not_measured_and_are_the_worst():
    measured = []

    def counted(first):
        def cue(seen, bodies):
            measured.append(len(bodies))
            return -((bodies.states - REST) ** 2).sum(axis=1)

        return cue

    tracker = ArmTracker(CAMERA, cues={"counted": counted})
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)
    measured.clear()
    picture = Picture(state, look(FILM.frames[1]), tracker.rules)
    cross = np.tile([0.3, 1.2, 2.9, 1.4], 2)
    beyond = REST - 4
    logs = picture.log_likelihood(np.array([REST, REST + 0.1, cross, beyond]))
    assert measured == [2]
    assert picture.share == 0.5
    np.testing.assert_allclose(logs[:2], [0, -0.08])
    np.testing.assert_allclose(logs[2:], -0.08 - np.array([30.0, 30.0]), atol=31)
    assert logs[2:].max() <= -30.08


def test_all_particles_in_collision_are_weighed_alike():
    cross = np.tile([0.3, 1.2, 2.9, 1.4], 2)
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face)
    state = replace(state, particles=ParticleSet.uniform(np.tile(cross, (40, 1))))
    picture = Picture(state, look(FILM.frames[1]), FEW.rules)
    logs = picture.log_likelihood(state.particles.states)
    assert np.ptp(logs) == 0
    assert picture.share == 1.0
    after, info = FEW.step(state, FILM.frames[1], rng=rng())
    assert np.isfinite(after.mean).all()
    assert info.saved > 0.3


def test_arms_that_are_gone_are_told_to_be_lost_and_found_again_are_not():
    wall = np.full((240, 320, 3), 120, dtype=np.uint8)
    state, _ = followed(ArmTracker(CAMERA))
    source = rng()
    tracker = ArmTracker(CAMERA)
    gone, info = tracker.step(state, wall, rng=source)
    assert info.lost
    assert gone.lost == 1
    gone, info = tracker.step(gone, wall, rng=source)
    assert gone.lost == 2
    assert info.contour == 5.0, "no edge anywhere"
    back, info = tracker.step(state, FILM.frames[-1], rng=source)
    assert not info.lost
    assert back.lost == 0


@pytest.mark.parametrize(
    ("edges", "patches", "lost"),
    [(1e-9, 1e-9, True), (1e-9, 1.0, False), (1e9, 1e-9, False), (1e9, 1.0, False)],
)
def test_arms_are_lost_where_contours_and_patches_are_off(edges, patches, lost):
    rules = ArmRules(particles=20, lost_edges=edges, lost_patches=patches)
    tracker = ArmTracker(CAMERA, rules=rules)
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=FILM.angles[0])
    assert tracker.step(state, FILM.frames[1], rng=rng())[1].lost == lost


def test_an_arm_out_of_the_picture_keeps_finite_states():
    shifted = np.roll(FILM.frames, -120, axis=2)
    source = rng()
    state = FEW.start(shifted[0], rng=source, face=FILM.face - [120, 0, 0, 0], pose=FILM.angles[0])
    for image in shifted[1:5]:
        state, _ = FEW.step(state, image, rng=source)
    assert np.isfinite(state.mean).all()


def test_clothes_of_one_colour_give_patches_that_hardly_count():
    """Painted sleeves and hands of one colour: the paper's confidence is near 0 for them."""
    state = FEW.start(painted(hand=(40, 60, 200)), rng=rng(), face=FACE, pose=REST)
    assert state.cues["colour"].weights.max() < 0.3
    seen = look(painted(hand=(40, 60, 200)))
    assert np.isfinite(state.cues["colour"](seen, Bodies(MODEL, REST[None]))).all()


def test_the_importance_filter_moves_half_of_the_particles_to_the_hands():
    """Where a hand's colour has moved by twenty pixels, the particles that are drawn follow it."""
    first = painted()
    moved = REST.copy()
    moved[0] += 0.25
    later = painted(moved)
    means = []
    for name in ("importance", "condensation"):
        rules = ArmRules(filter=name, noise=(0.05, 0.05, 0.1, 0.1))
        tracker = ArmTracker(CAMERA, rules=rules)
        state = tracker.start(first, rng=rng(), face=FACE, pose=REST)
        state, _ = tracker.step(state, later, rng=rng())
        means.append(abs(state.mean[0] - moved[0]))
    assert means[0] < means[1]


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: ArmRules(particles=1), "particles must be"),
        (lambda: ArmRules(noise=(0.1, 0.1, 0.1, 0.0)), "noise must be positive"),
        (lambda: ArmRules(filter="unscented"), "filter must be"),
        (lambda: ArmTracker(CAMERA, cues={}), "cues must be one at least"),
        (lambda: FEW.start(FILM.frames[0][:100], rng=rng(), face=FILM.face), "image must be"),
        (lambda: FEW.start(FILM.frames[0], rng=rng(), face=FACE * [1, 1, 4, 4]), "farther"),
        (
            lambda: FEW.start(FILM.frames[0], rng=rng(), face=np.array([900.0, 900, 20, 20])),
            "face must reach into the picture",
        ),
        (
            lambda: FEW.step(
                FEW.start(FILM.frames[0], rng=rng(), face=FILM.face),
                FILM.frames[1][:, :50],
                rng=rng(),
            ),
            "image must be",
        ),
        (
            lambda: FEW.step(
                replace(
                    FEW.start(FILM.frames[0], rng=rng(), face=FILM.face),
                    grey=np.zeros((4, 5), np.uint8),
                ),
                FILM.frames[1],
                rng=rng(),
            ),
            "state.grey must be",
        ),
    ],
)
def test_bad_input_is_named(make, problem):
    with unchecked(), pytest.raises(ValueError, match=problem):
        make()


def test_cues_must_be_callable_and_the_state_a_state():
    with unchecked(), pytest.raises(TypeError, match=r"bounds\['x'\] must be"):
        ArmTracker(CAMERA, bounds={"x": 3})
    with unchecked(), pytest.raises(TypeError, match="state must be"):
        FEW.step(SimpleNamespace(), FILM.frames[1], rng=rng())


def test_the_body_stands_where_the_face_says():
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face)
    wanted = BodyModel.from_face(FILM.face, CAMERA).middle
    np.testing.assert_array_equal(state.first.model.middle, wanted)
    assert set(state.bounds) == set(BOUNDS)


def test_the_shoulders_go_with_the_face_of_a_picture():
    state = FEW.start(FILM.frames[0], rng=rng(), face=FILM.face)
    moved = FILM.face + np.array([12.0, 0, 0, 0])
    after, info = FEW.step(state, FILM.frames[1], rng=rng(), face=moved)
    there = BodyModel.from_face(moved, CAMERA)
    np.testing.assert_array_equal(after.first.model.middle, there.middle)
    np.testing.assert_allclose(info.joints, there.joints(after.mean[None])[0])
    stays, _ = FEW.step(state, FILM.frames[1], rng=rng())
    np.testing.assert_array_equal(stays.first.model.middle, state.first.model.middle)
    same, _ = FEW.step(state, FILM.frames[1], rng=rng(), face=FILM.face)
    np.testing.assert_array_equal(same.particles.states, stays.particles.states)
    with pytest.raises(ValueError, match="face"):
        FEW.step(state, FILM.frames[1], rng=rng(), face=np.zeros(4))


class Pulled:
    """A normal likelihood of each angle about a goal, of its own width for each arm."""

    def __init__(self, goal, widths):
        self.goal, self.widths = goal, np.asarray(widths)

    def arms(self, seen, bodies):
        off = (bodies.states - self.goal).reshape(len(bodies), 2, 4)
        return -(off**2).sum(axis=2) / (2 * self.widths**2)

    def __call__(self, seen, bodies):
        return self.arms(seen, bodies).sum(axis=1)


def one_step(filter, cue, particles, seed=2):
    tracker = ArmTracker(
        CAMERA,
        rules=ArmRules(filter=filter, particles=particles),
        cues={"pull": lambda first: cue},
        bounds={},
    )
    start = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)
    return tracker.step(start, FILM.frames[1], rng=rng(seed))


def test_arms_drawn_apart_have_the_mean_and_spread_of_a_kalman_filter():
    goal, widths = REST + 0.15, np.array([0.2, 0.4])
    state, info = one_step("apart", Pulled(goal, widths), 40_000)
    noise = np.tile(ArmRules().noise, 2)
    prior = noise**2 * (1 + 0.3**2)
    own = np.repeat(widths, 4) ** 2
    np.testing.assert_allclose(state.mean, REST + 0.15 * prior / (prior + own), atol=0.01)
    np.testing.assert_allclose(state.spread**2, prior * own / (prior + own), rtol=0.06)
    left, right = state.particles.states[:, :4], state.particles.states[:, 4:]
    assert np.abs(np.corrcoef(left.T, right.T)[:4, 4:]).max() < 0.03, "arms are paired at random"
    assert np.ptp(state.particles.log_weights) == 0
    assert info.effective < 40_000


def test_arms_drawn_apart_are_paired_anew_where_a_particle_had_both_alike():
    """Left and right were raised alike in each particle; pairs of the next picture are not."""
    flat = {"flat": lambda first: lambda seen, bodies: np.zeros(len(bodies))}
    rules = ArmRules(filter="apart", particles=2000, noise=(1e-3,) * 4)
    tracker = ArmTracker(CAMERA, rules=rules, cues=flat, bounds={})
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)
    states = np.tile(REST, (2000, 1))
    states[:, [0, 4]] += np.linspace(0, 0.5, 2000)[:, None]
    state = replace(state, particles=ParticleSet.uniform(states))
    after = tracker.step(state, FILM.frames[1], rng=rng())[0].particles.states
    np.testing.assert_allclose(np.sort(after[:, 0]), np.sort(states[:, 0]), atol=0.02)
    assert abs(np.corrcoef(after[:, 0], after[:, 4])[0, 1]) < 0.1


def test_an_arm_that_fits_is_kept_whatever_the_other_one_does():
    """Of one draw of both arms few particles count; of each arm apart many more do."""
    cue = Pulled(REST + 0.1, [0.08, 0.08])
    both, alone = (one_step(name, cue, 400)[1].effective for name in ("condensation", "apart"))
    assert alone > 3 * both
    one = one_step("apart", Pulled(REST + 0.1, [0.08, 1e3]), 400)[1].effective
    assert one == pytest.approx(alone, rel=0.3), "the number is that of the arm that has fewer"


def test_an_arm_beyond_a_limit_does_not_cost_the_other_one():
    """A particle whose left arm cannot be passes its right arm on."""
    tracker = ArmTracker(CAMERA, rules=ArmRules(particles=20, filter="apart"),
                         cues={"pull": lambda first: Pulled(REST, [1.0, 1.0])})  # fmt: skip
    state = tracker.start(FILM.frames[0], rng=rng(), face=FILM.face, pose=REST)
    states = np.tile(REST, (4, 1))
    states[1, 3], states[2, [3, 7]], states[3, 4] = -1.0, -1.0, REST[4] + 0.2
    picture = Picture(state, look(FILM.frames[1]), tracker.rules)
    logs = picture.log_likelihoods(states)
    np.testing.assert_allclose(logs[:, 0], [0, -30, -30, 0], atol=1e-12)
    np.testing.assert_allclose(logs[:, 1], [0, 0, -30.02, -0.02], atol=1e-12)
    assert picture.share == 0.25, "where neither arm can be nothing is measured"

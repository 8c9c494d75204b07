"""Association inside the filter: against known identifiers, dense matrices and each other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from robot_perception.gating import gate, joint_compatibility
from robot_perception.slam.planar import (
    Association,
    CartesianSensor,
    MapBelief,
    Observations,
    RangeBearing,
    Settings,
    Step,
    run_filter,
    textbook,
    update,
)
from robot_perception.slam.planar.association import IGNORED, NEW, associate
from robot_perception.slam.planar.workspace import Workspace
from tests.slam.planar.drives import R_POLAR, R, belief_of, drive
from tests.unchecked import unchecked

CART = CartesianSensor(R)


@pytest.mark.parametrize(
    "association", [Association("gated"), Association("joint")], ids=["nearest", "joint"]
)
@pytest.mark.parametrize("polar", [False, True])
def test_without_names_the_run_finds_the_same_landmarks(association, polar):
    """Landmarks far apart, noise small: the same map as with names, up to the order of numbers."""
    sensor = RangeBearing(0.01 * R_POLAR) if polar else CartesianSensor(0.01 * R)
    world = drive(np.random.default_rng(3), noise=0.1, polar=polar)
    named = run_filter(world.start, world.steps, Settings(sensor))
    steps = [replace(s, observations=s.observations.anonymous()) for s in world.steps]
    blind = run_filter(world.start, steps, Settings(sensor, association=association))
    meant = {}
    for ours, step in zip(blind.used, world.steps, strict=True):
        for name, true in zip(ours.tolist(), step.observations.ids.tolist(), strict=True):
            if name != IGNORED:
                assert meant.setdefault(name, true) == true
    assert len(set(meant.values())) == len(meant) == named.belief.ids.size
    assert blind.counts.ignored <= 0.05 * blind.counts.observed  # 1 % of right pairs miss the gate
    np.testing.assert_allclose(blind.poses, named.poses, atol=0.02)


@given(st.integers(0, 10**6), st.booleans())
@settings(max_examples=40)
def test_pairs_are_chosen_by_the_textbooks_covariances(seed, jointly):
    rng = np.random.default_rng(seed)
    belief = belief_of(rng, 5, size=0.15)
    belief.mean[3:] *= 0.2  # close enough to be taken for each other
    anchors = {80: rng.uniform(-2, 2, 2)}
    names = [*belief.ids.tolist(), 80]
    places = np.vstack([belief.landmarks, anchors[80]])
    seen = rng.permutation(6)[:3]
    spread = rng.choice([0.3, 1.0])
    values = CART.expect(belief.pose, places[seen])[0] + spread * rng.standard_normal((3, 2))
    noises = rng.choice([1.0, 200.0], (3, 1, 1)) * R
    observed = Observations(np.full(3, -1), values, noises)
    chosen = Association("joint", 0.9, 0.95) if jointly else Association("gated", 0.9, 0.95)
    anchor_pairs = {80: tuple(anchors[80].tolist())}
    found = associate(Workspace(belief), observed, noises, CART, anchor_pairs, chosen)
    # the same with one update for each pair, and whole matrices for all of them
    distances = np.empty((3, 6))
    for i in range(3):
        for j, name in enumerate(names):
            one = observed[[i]].named(np.array([name]))
            distances[i, j] = update(belief, one, CART, anchors)[1].nis
    if jointly:
        pairs = np.argwhere(distances <= gate(0.9, 2))
        slots = [None if names[j] == 80 else belief.slot(names[j]) for j in pairs[:, 1]]
        H = textbook.measurement_matrix(belief.mean, slots, places[pairs[:, 1]], CART)
        S = H @ belief.cov @ H.T + block_diag(*noises[pairs[:, 0]])
        expected = values[pairs[:, 0]] - CART.expect(belief.pose, places[pairs[:, 1]])[0]
        limits = np.array([gate(0.9, 2 * k + 2) for k in range(len(pairs))])
        best = pairs[joint_compatibility(pairs, expected, S, limits)]
    else:
        best, left = [], distances.copy()
        while (left <= gate(0.9, 2)).any():
            i, j = np.unravel_index(np.argmin(left), left.shape)
            best.append((i, j))
            left[i], left[:, j] = np.inf, np.inf
    wanted = np.where((distances <= gate(0.95, 2)).any(axis=1), IGNORED, NEW)
    for i, j in best:
        wanted[i] = names[j]
    np.testing.assert_array_equal(found, wanted)


def two_posts():
    """Return a belief of a robot that may be 0.5 m off along x, between two posts 1 m apart."""
    cov = np.diag([0.25, 1e-4, 1e-6, 1e-4, 1e-4, 1e-4, 1e-4])
    return MapBelief(np.array([0, 0, 0, 3.0, 1.0, 4.0, 1.0]), cov, np.array([0, 1]))


def test_joint_compatibility_sees_the_common_error_that_the_nearest_misses():
    """The robot is 0.7 m ahead of where it believes: each post looks like the one before it."""
    belief = two_posts()
    values = np.array([[3.0 - 0.7, 1.0], [4.0 - 0.7, 1.0]])
    observed = Observations(np.array([-1, -1]), values)
    start = Step(None, observed)
    joint = run_filter(belief, [start], Settings(CART, association=Association("joint")))
    nearest = run_filter(belief, [start], Settings(CART, association=Association("gated")))
    assert joint.used[0].tolist() == [0, 1]
    assert nearest.used[0].tolist() != [0, 1]
    assert abs(joint.poses[0, 0] - 0.7) < 0.05


def test_between_the_gates_is_ignored_beyond_is_new():
    belief = two_posts()
    sigma = np.sqrt(0.25 + 1e-4 + R[0, 0])
    near, between, beyond = (
        Observations(np.array([-1]), np.array([[4.0 + shift * sigma, 1.0]]))
        for shift in (2.0, 3.8, 6.0)
    )
    for association in (Association("gated", 0.99, 0.9999), Association("joint", 0.99, 0.9999)):
        run = run_filter(
            belief,
            [Step(None, observed) for observed in (between, beyond)],
            Settings(CART, association=association),
        )
        assert [used.tolist() for used in run.used] == [[IGNORED], [2]]
        assert (run.counts.ignored, run.counts.new) == (1, 1)
        one = run_filter(belief, [Step(None, near)], Settings(CART, association=association))
        assert one.used[0].tolist() == [1]


@pytest.mark.parametrize("names", [[-1, 20, -1], [-1, -1, -1]])
def test_new_numbers_avoid_those_in_use(names):
    anchors = {12: np.array([100.0, 100.0])}
    observed = Observations(np.array(names), np.array([[50.0, 0], [60.0, 0], [70.0, 0]]))
    run = run_filter(
        two_posts(), [Step(None, observed)], Settings(CART, anchors, Association("gated"))
    )
    above = iter(range(max(12, *names) + 1, 100))
    given = [next(above) if name == -1 else name for name in names]
    assert run.used[0].tolist() == given
    np.testing.assert_array_equal(run.belief.ids, [0, 1, *given])


def test_anchors_are_found_too():
    anchors = {5: np.array([3.0, -2.0])}
    observed = Observations(np.array([-1]), np.array([[3.1, -2.0]]))
    for association in (Association("gated"), Association("joint")):
        run = run_filter(two_posts(), [Step(None, observed)], Settings(CART, anchors, association))
        assert run.used[0].tolist() == [5]
        assert run.counts.anchored == 1


def test_the_gate_of_known_names_has_its_level():
    """A named observation beyond its gate is rejected; what is rejected is not used."""
    belief = two_posts()
    limit = np.sqrt(gate(0.99, 2) * (0.25 + 1e-4 + R[0, 0] + 1e-6))
    for shift, used in ((0.999 * limit, 0), (1.002 * limit, IGNORED)):
        observed = Observations(np.array([0]), np.array([[3.0 + shift, 1.0]]))
        run = run_filter(
            belief, [Step(None, observed)], Settings(CART, association=Association("known", 0.99))
        )
        assert run.used[0].tolist() == [used]
        assert run.counts.rejected == (used == IGNORED)


def test_a_patient_gate_gives_in_after_so_many_rejections_in_a_row_of_one_landmark():
    def seen(*pairs):
        ids, shifts = zip(*pairs, strict=True)
        return Step(None, Observations(np.array(ids), two_posts().landmarks[list(ids)] + shifts))

    far, near = (np.array([4.0, 0.0]), np.zeros(2))
    steps = [
        seen((0, far)),
        seen((0, far), (1, far)),
        seen((1, near)),
        seen((1, far)),
        seen((0, far), (1, far)),
        seen((1, far)),
    ]
    for patience, used in (
        (None, [[-1], [-1, -1], [1], [-1], [-1, -1], [-1]]),
        (2, [[-1], [-1, -1], [1], [-1], [0, -1], [1]]),  # of landmark 1 the row was broken
        (3, [[-1], [-1, -1], [1], [-1], [-1, -1], [-1]]),
    ):
        association = Association("known", 0.99, patience=patience)
        run = run_filter(two_posts(), steps, Settings(CART, association=association))
        assert [names.tolist() for names in run.used] == used
        assert run.counts.rejected == sum(names.count(-1) for names in used)


def test_patience_needs_known_names_and_a_gate():
    for kind, level in (("gated", 0.99), ("known", 1.0)):
        with unchecked(), pytest.raises(ValueError, match="patience is for known names"):
            Association(kind, level, patience=3)
    with unchecked(), pytest.raises(ValueError, match="patience must be"):
        Association("known", 0.99, patience=0)


@pytest.mark.parametrize("association", [Association("gated"), Association("joint")])
def test_a_singular_covariance_is_no_reason_for_a_new_landmark(association):
    """Whether the observation is where it should be or not, for one of the landmarks or for all."""
    settings = Settings(CartesianSensor(0 * R), association=association)
    for cov in (np.zeros((7, 7)), np.diag([0.0, 0, 0, 0, 0, 1, 1])):
        exact = MapBelief(two_posts().mean, cov, np.array([0, 1]))
        for x in (3.0, 3.2):
            step = Step(None, Observations(np.array([-1]), np.array([[x, 1.0]])))
            with pytest.raises(ValueError, match="step 0: innovation covariance is singular"):
                run_filter(exact, [step], settings)


@pytest.mark.parametrize("kind", ["gated", "joint"])
def test_bad_levels_are_named(kind):
    for level, outer in ((0.99, 0.9), (0.0, 0.5), (0.5, 1.0)):
        with unchecked(), pytest.raises(ValueError, match=f"got {level}, {outer}"):
            Association(kind, level, outer)


def test_a_word_is_short_for_the_defaults():
    for word in ("known", "gated", "joint"):
        assert Settings(CART, association=word).association == Association(word)
    gated = Association("gated")
    assert (gated.limit, gated.outer_limit) == (gate(0.99, 2), gate(0.9999, 2))
    assert Association().limit == np.inf
    assert Association("known", 0.9).limit == gate(0.9, 2)


@pytest.mark.parametrize("word", ["nearest", None, 0, [], True, Association])
def test_unknown_words_are_told_what_is_allowed(word):
    message = "association must be one of 'known', 'gated', 'joint', got "
    with unchecked(), pytest.raises(ValueError, match=message):
        Settings(CART, association=word)


def test_known_names_have_one_gate():
    with pytest.raises(ValueError, match=r"no outer gate, got outer 0\.9"):
        Association("known", outer=0.9)
    with pytest.raises(ValueError, match=r"between 0 and 1, got 0\.0"):
        Association("known", 0.0)

"""Upper bodies: limbs where the joints are, what is nearer hides, light and clothes as told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_synth.arms.bodies import Build, Outfit, Person, Stage, make_outfit, make_person
from data_synth.companion.faces import make_identity

STAGE = Stage()
WHO = make_identity(np.random.default_rng(0), tone=1)
SHIRT = Outfit((0.05, 0.1, 0.5), (0.6, 0.5, 0.05))
PERSON = Person(Build(), SHIRT, WHO)
SIDE = np.tile([1.4, 0.0, 0.5, 0.3], 2)


def painted(angles=SIDE, person=PERSON, light=1.0, stage=STAGE):
    canvas = np.full((*stage.size, 3), 0.2, dtype=np.float32)
    return stage.paint(person, angles, canvas, light)


def test_limbs_are_painted_where_their_joints_are():
    rng = np.random.default_rng(1)
    for _ in range(10):
        angles = np.tile([rng.uniform(0.5, 1.6), 0.1, 0.3, rng.uniform(0.2, 1.2)], 2)
        _, parts = painted(angles)
        joints = STAGE.pixels(PERSON.joints(angles, STAGE.middle))
        for arm in range(2):
            for k in range(3):
                v, u = np.nonzero(parts == 3 + 3 * arm + k)
                middle = joints[arm, k : k + 2].mean(axis=0)
                assert np.linalg.norm([u.mean(), v.mean()] - middle) < 9


def test_a_raised_arm_is_turned_as_rotations_say():
    """The upper arm is a hanging one turned about z, and the forearm bends in its frame."""
    away, ahead, about, bend = 0.7, 0.4, 0.9, 1.1
    joints = PERSON.joints(np.array([0, 0, 0, 0, away, ahead, about, bend]), np.zeros(3))[1]
    turn = Rotation.from_rotvec([0, 0, -away]) * Rotation.from_rotvec([-ahead, 0, 0])
    upper = turn.apply([0, PERSON.build.upper, 0])
    np.testing.assert_allclose(joints[1] - joints[0], upper, atol=1e-12)
    turn = turn * Rotation.from_rotvec([0, about, 0]) * Rotation.from_rotvec([0, 0, -bend])
    np.testing.assert_allclose(joints[2] - joints[1], turn.apply([0, 0.25, 0]), atol=1e-12)


def test_what_is_nearer_hides_what_is_behind():
    across = np.array([0.3, 0.2, 1.4, 0.2, 0.25, 0.9, 2.6, 1.5])
    _, free = painted(np.tile([0.3, 0.2, 1.4, 0.2], 2))
    _, parts = painted(across)
    joints = STAGE.pixels(PERSON.joints(across, STAGE.middle))[1]
    u, v = np.rint(joints[2:].mean(axis=0)).astype(int)
    assert free[v, u] == 2, "the trunk is there"
    assert parts[v, u] == 8, "and the hand before it"


def test_the_head_is_below_nobody_and_the_face_is_marked_on_it():
    _, parts = painted()
    left, top, wide, high = STAGE.face(PERSON)
    v, u = np.nonzero(parts == 1)
    assert abs(u.mean() - left - wide / 2) < 2
    assert v.min() < top + 0.2 * high
    inside = parts[round(top) : round(top + high), round(left) : round(left + wide)]
    assert (inside == 1).mean() > 0.8


def test_twice_the_light_is_twice_as_bright_on_the_body_alone():
    dim, parts = painted(light=0.4)
    bright, _ = painted(light=0.8)
    body = np.isin(parts, (2, 4, 7))
    ratio = bright[body].sum() / dim[body].sum()
    assert ratio == pytest.approx(2.0, abs=0.02)
    np.testing.assert_allclose(dim[:20, :20], bright[:20, :20])


@pytest.mark.parametrize("pattern", ["plain", "stripes", "checks", "print"])
def test_clothes_show_their_colours(pattern):
    person = replace(PERSON, outfit=replace(SHIRT, pattern=pattern))
    canvas, parts = painted(person=person)
    sleeve = canvas[parts == 3]
    yellow = (sleeve[:, 0] > sleeve[:, 2]).mean()
    assert yellow == 0 if pattern == "plain" else 0.1 < yellow < 0.9


def test_short_sleeves_leave_the_forearm_bare():
    person = replace(PERSON, outfit=replace(SHIRT, short=True))
    canvas, parts = painted(person=person)
    fore, upper = (canvas[parts == k].mean(axis=0) for k in (4, 3))
    skin = np.array(WHO.skin)
    np.testing.assert_allclose(fore / fore.sum(), skin / skin.sum(), atol=0.03)
    assert upper[2] > upper[0]


def test_a_pattern_turns_with_the_sleeve():
    person = replace(PERSON, outfit=replace(SHIRT, pattern="print", loose=0.0, seed=3))
    turned = SIDE.copy()
    turned[2] += 1.0
    one, parts = painted(np.r_[SIDE[:3], 0.0, SIDE[4:]], person)
    other, _ = painted(np.r_[turned[:3], 0.0, turned[4:]], person)
    sleeve = parts == 3
    assert np.abs(one - other)[sleeve].mean() > 0.03


def test_people_are_within_some_percent_of_the_usual_one():
    builds = [make_person(np.random.default_rng(k), WHO).build for k in range(200)]
    for name, share in (("upper", 0.03), ("apart", 0.03), ("thick", 0.06)):
        logs = np.log([getattr(b, name) / getattr(Build(), name) for b in builds])
        assert abs(logs.mean()) < 4 * share / np.sqrt(200)
        assert 0.8 * share < logs.std() < 1.2 * share
    outfit = make_outfit(np.random.default_rng(0), "checks")
    assert make_person(np.random.default_rng(1), WHO, outfit).outfit is outfit
    assert outfit.pattern == "checks"


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: Build(upper=0.0), "upper must be"),
        (lambda: replace(SHIRT, pattern="plaid"), "pattern"),
        (lambda: replace(SHIRT, shirt=(1.2, 0, 0)), "shirt must be from 0 to 1"),
        (lambda: replace(SHIRT, loose=0.5), "loose must be"),
        (lambda: Stage(away=0.5), "away must be"),
        (lambda: PERSON.joints(np.zeros(7), np.zeros(3)), "angles must be"),
        (lambda: STAGE.paint(PERSON, SIDE, np.zeros((4, 4, 3), np.float32)), "canvas must be"),
    ],
)
def test_what_cannot_be_is_refused_by_name(make, problem):
    with pytest.raises(ValueError, match=problem):
        make()

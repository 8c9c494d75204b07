"""Two arms of cones: against OpenCV's projection, a depth buffer, the textbook and brute force."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.arms.bodies import Build, Person, Stage, make_outfit
from data_synth.companion.faces import make_identity
from robot_perception.arms.body_model import (
    LIMBS,
    REST,
    BodyModel,
    Measures,
    Patches,
    contours_textbook,
)
from robot_perception.cameras import Pinhole
from tests.unchecked import unchecked

CAMERA = Pinhole((320.0, 300.0), (159.5, 119.5), (320, 240))
MODEL = BodyModel(CAMERA, np.array([0.02, -0.12, 1.9]))
ANGLES = st.integers(0, 2**31)


def drawn(count, seed=0):
    """Return poses within the limits of the joints."""
    low, high = np.tile(MODEL.limits, (2, 1)).T
    return np.random.default_rng(seed).uniform(low, high, (count, 8))


def test_the_joints_are_those_of_the_world_that_is_drawn():
    """The world turns limbs by Euler angles, the model by vectors."""
    measures = Measures(lengths=(0.3, 0.26, 0.14), apart=0.4)
    model = replace(MODEL, measures=measures)
    rng = np.random.default_rng(0)
    person = Person(Build(0.3, 0.26, 0.14, 0.4), make_outfit(rng), make_identity(rng))
    for state in drawn(40):
        wanted = person.joints(state, model.middle)
        np.testing.assert_allclose(model.joints(state[None])[0], wanted, atol=1e-12)


def test_arms_that_hang_point_down_and_lift_sideways_ahead_and_bend():
    hang, away, ahead, bent, turned = np.zeros((5, 8))
    away[0], ahead[4 + 1] = np.pi / 2, np.pi / 2
    bent[4 + 3], turned[[4 + 2, 4 + 3]] = np.pi / 2, np.pi / 2
    joints = MODEL.joints(np.array([hang, away, ahead, bent, turned]))
    limb = joints[:, :, 1] - joints[:, :, 0]
    np.testing.assert_allclose(limb[0], [[0, 0.29, 0]] * 2, atol=1e-12)
    np.testing.assert_allclose(limb[1, 0], [-0.29, 0, 0], atol=1e-12)
    np.testing.assert_allclose(limb[2, 1], [0, 0, -0.29], atol=1e-12)
    fore = joints[:, 1, 2] - joints[:, 1, 1]
    np.testing.assert_allclose(fore[3], [0.25, 0, 0], atol=1e-12)
    np.testing.assert_allclose(fore[4], [0, 0, -0.25], atol=1e-12)
    np.testing.assert_allclose(joints[0, 1, 0] - joints[0, 0, 0], [0.37, 0, 0])


@given(ANGLES)
@settings(max_examples=30, deadline=None)
def test_limbs_keep_their_lengths_and_the_forearm_its_angle(seed):
    states = drawn(20, seed)
    joints = MODEL.joints(states)
    parts = np.diff(joints, axis=2)
    sizes = np.linalg.norm(parts, axis=-1)
    np.testing.assert_allclose(sizes, np.broadcast_to(MODEL.measures.lengths, sizes.shape))
    cos = (parts[:, :, 0] * parts[:, :, 1]).sum(axis=-1) / (sizes[..., 0] * sizes[..., 1])
    np.testing.assert_allclose(cos, np.cos(states[:, [3, 7]]), atol=1e-12)


def test_a_mirrored_pose_has_mirrored_joints():
    model = replace(MODEL, middle=np.array([0.0, -0.1, 1.9]))
    states = drawn(10)
    mirrored = np.roll(states, 4, axis=1)
    flip = model.joints(mirrored)[:, ::-1] * [-1, 1, 1]
    np.testing.assert_allclose(model.joints(states), flip, atol=1e-12)


def test_points_are_projected_as_opencv_does():
    points = MODEL.joints(drawn(20)).reshape(-1, 3)
    wanted, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), CAMERA.matrix, None)
    np.testing.assert_allclose(MODEL.pixels(points), wanted[:, 0], atol=1e-9)


def test_contours_are_those_of_the_textbook():
    states = np.vstack([drawn(40), REST])
    fast, plain = MODEL.contours(states), contours_textbook(MODEL, states)
    np.testing.assert_array_equal(fast.visible, plain.visible)
    there = np.isfinite(plain.points).all(axis=-1)
    np.testing.assert_allclose(fast.points[there], plain.points[there], atol=1e-9)
    assert fast.points.shape == (41, MODEL.points, 2)


def cone_points(c0, c1, r0, r1, along=160, around=160):
    """Return many points of a cone's surface, its end discs included."""
    a = (c1 - c0) / np.linalg.norm(c1 - c0)
    e1 = np.linalg.svd(a[None])[2][1]
    e2 = np.cross(a, e1)
    t, phi = (
        x.ravel() for x in np.meshgrid(np.linspace(0, 1, along), np.linspace(0, 2 * np.pi, around))
    )
    ring = np.cos(phi)[:, None] * e1 + np.sin(phi)[:, None] * e2
    side = c0 + t[:, None] * (c1 - c0) + ((1 - t) * r0 + t * r1)[:, None] * ring
    return np.vstack([side, c0 + (t * r0)[:, None] * ring, c1 + (t * r1)[:, None] * ring])


def limb_points(state):
    joints, radii = MODEL.joints(state[None])[0], MODEL.measures.radii
    return [cone_points(arm[k], arm[k + 1], radii[k], radii[k + 1])
            for arm in joints for k in range(3)]  # fmt: skip


def test_a_silhouette_is_the_outline_of_the_cone_that_is_drawn():
    """Its points lie on the convex hull of the projected surface."""
    model = replace(MODEL, counts=(5, 5, 5))
    for state in drawn(12, 3):
        contour = model.contours(state[None]).points[0].reshape(6, 10, 2)
        for limb, points in enumerate(limb_points(state)):
            if limb % 3 == 2:  # hands point at the camera at times: no silhouette along the side
                continue
            hull = cv2.convexHull(model.pixels(points).astype(np.float32))
            far = [abs(cv2.pointPolygonTest(hull, (float(u), float(v)), True))
                   for u, v in contour[limb]]  # fmt: skip
            assert max(far) < 0.15


def trunk_points():
    wide, deep = MODEL.measures.trunk
    y, phi = (
        x.ravel() for x in np.meshgrid(np.linspace(0, 0.8, 300), np.linspace(0, 2 * np.pi, 300))
    )
    side = np.stack([wide * np.cos(phi), y, deep * np.sin(phi)], axis=-1)
    lid = np.stack([y / 0.8 * wide * np.cos(phi), 0 * y, y / 0.8 * deep * np.sin(phi)], axis=-1)
    return MODEL.middle + np.vstack([side, lid])


def depth_of(points, fine=2.0):
    """Return a depth buffer, a pixel of it half a pixel of the camera."""
    depth = np.full((480, 640), np.inf)
    u, v = np.rint(fine * MODEL.pixels(points)).astype(int).T
    inside = (u >= 0) & (u < 640) & (v >= 0) & (v < 480)
    np.minimum.at(depth, (v[inside], u[inside]), points[inside, 2])
    return depth


def test_hidden_points_are_those_of_a_depth_buffer():
    """Points that a depth buffer of all other parts hides clearly, or leaves clearly free."""
    trunk, checked = depth_of(trunk_points()), np.zeros(2, dtype=int)
    for state in drawn(45, 5):
        surfaces = limb_points(state)
        depths = [depth_of(points) for points in surfaces]
        contours = MODEL.contours(state[None])
        own = np.repeat(np.arange(6), [2 * MODEL.counts[k % 3] for k in range(6)])
        joints, radii = MODEL.joints(state[None])[0], MODEL.measures.radii
        for limb in range(6):
            others = np.min([d for k, d in enumerate(depths) if k != limb] + [trunk], axis=0)
            low = cv2.erode(others, np.ones((5, 5)))
            high = cv2.dilate(np.where(np.isinf(others), 1e9, others), np.ones((5, 5)))
            arm, part = divmod(limb, 3)
            z = joints[arm, part : part + 2, 2]
            near, far = z.min() - radii[part], z.max() + radii[part]
            for k in np.flatnonzero(own == limb):
                u, v = np.rint(2 * contours.points[0, k]).astype(int)
                if not (0 <= u < 640 and 0 <= v < 480):
                    continue
                if low[v, u] > far:
                    assert contours.visible[0, k]
                    checked[0] += 1
                elif high[v, u] < near - 0.02:
                    assert not contours.visible[0, k]
                    checked[1] += 1
    assert checked.min() > 60, "both kinds were met"


def test_a_limb_that_points_at_the_camera_has_no_silhouette():
    model = replace(MODEL, middle=np.array([-0.185, 0.0, 1.9]))
    state = np.zeros(8)
    state[4 + 1] = np.pi / 2  # the arm on the right, whose shoulder the axis of the camera meets
    contours = model.contours(state[None])
    assert not contours.visible[0, model.points // 2 :].any()
    assert np.isfinite(contours.points).all()


def contacts(model, states, more, points=20):
    """Tell which limbs enter what they may not (m, 17), all parts thicker by so much (m).

    Nine pairs of limbs of both arms, then forearms and hands with the trunk, then with the head: by
    points along the axes.
    """
    share, measures = np.linspace(0, 1, points), model.measures
    joints = model.joints(states)
    axes = joints[:, :, :-1, None] + share[:, None] * np.diff(joints, axis=2)[:, :, :, None]
    radii = np.array([np.interp(share, [0, 1], measures.radii[k : k + 2]) for k in range(3)])
    gap = np.linalg.norm(axes[:, 0, :, None, :, None] - axes[:, 1, None, :, None, :], axis=-1)
    pairs = gap < radii[:, None, :, None] + radii[None, :, None, :] + more
    off = (axes - model.middle)[:, :, 1:]
    wide, deep = np.add(measures.trunk, more)
    trunk = (np.hypot(off[..., 0] / wide, off[..., 2] / deep) < 1) & (off[..., 1] > -more)
    head = (
        np.linalg.norm(off + np.array([0, measures.drop, 0]), axis=-1)
        < radii[1:] + measures.head + more
    )
    parts = (pairs.any(axis=(-2, -1)), trunk.any(axis=-1), head.any(axis=-1))
    return np.concatenate([part.reshape(len(states), -1) for part in parts], axis=1)


def test_a_body_collides_where_any_of_its_limbs_does():
    """Brute force; each pair of parts is met where it is the only one that collides."""
    shape = replace(MODEL.measures, apart=0.2, radii=(0.04,) * 4, trunk=(0.05, 0.03), head=0.05)
    slim = replace(MODEL, measures=shape)
    wild = np.random.default_rng(8).uniform(-np.pi, np.pi, (9000, 8))
    alone = np.zeros(17, dtype=int)
    for model, states in ((MODEL, drawn(300, 7)), (slim, wild)):
        hit, near = (contacts(model, states, more) for more in (-0.005, 0.005))
        clear = (hit == near).all(axis=1)
        np.testing.assert_array_equal(model.collides(states[clear]), hit[clear].any(axis=1))
        alone += hit[clear & (hit.sum(axis=1) == 1)].sum(axis=0)
    assert alone.min() > 0, "each decides alone somewhere"
    assert not MODEL.collides(REST[None])[0]


def test_limits_are_told_for_both_arms():
    state = REST.copy()
    assert MODEL.possible(state[None])[0]
    for k in range(8):
        for end, sign in ((0, -1), (1, 1)):
            out = state.copy()
            out[k] = MODEL.limits[k % 4, end] + sign * 1e-6
            assert not MODEL.possible(out[None])[0]
            out[k] -= sign * 1e-6
            assert MODEL.possible(out[None])[0]


def test_patches_lie_on_the_limb_and_face_the_camera():
    patches = MODEL.place(REST)
    surface = MODEL.surface(REST[None], patches)
    assert len(patches) == 6
    share = surface.visible.mean(axis=-1)[0]
    np.testing.assert_allclose(share, 0.475, atol=0.125, err_msg="half of a patch is seen")
    joints = MODEL.pixels(MODEL.joints(REST[None]))[0]
    for p, limb in enumerate(patches.limbs):
        arm, part = divmod(int(limb), 3)
        a, b = joints[arm, part], joints[arm, part + 1]
        middle = surface.points[0, p].mean(axis=0)
        along = (middle - a) @ (b - a) / ((b - a) @ (b - a))
        assert along == pytest.approx(patches.along[p].mean(), abs=0.03)


def test_points_of_a_patch_lie_where_cylinder_coordinates_have_them():
    """From the joints: along the axis, and around it from the side to which the elbow bends."""
    rng, shape = np.random.default_rng(4), MODEL.measures
    patches = Patches(
        np.arange(6),
        np.tile([0.2, 0.7], (6, 1)),
        np.column_stack([rng.uniform(-3, 3, 6), np.ones(6)]),
    )
    along = 0.2 + 0.5 * (np.arange(6) + 0.5) / 6
    around = patches.around[:, :1] + 2 * (np.arange(10) + 0.5) / 10 - 1
    states = drawn(20, 6)
    states[:, [3, 7]] = rng.uniform(0.3, 2.4, (20, 2))  # an elbow that bends tells its side
    found = MODEL.surface(states, patches).points.reshape(20, 6, 6, 10, 2)
    for state, joints, points in zip(states, MODEL.joints(states), found, strict=True):
        for limb in range(6):
            arm, part = divmod(limb, 3)
            axes = np.diff(joints[arm], axis=0) / np.array(shape.lengths)[:, None]
            upper, fore, bend = axes[0], axes[1], state[4 * arm + 3]
            side = fore - upper * np.cos(bend) if part == 0 else fore * np.cos(bend) - upper
            side /= np.sin(bend)
            turned = np.cross(axes[part], side)
            normals = np.cos(around[limb])[:, None] * side + np.sin(around[limb])[:, None] * turned
            r = np.interp(along, [0, 1], shape.radii[part : part + 2])[:, None, None]
            axis = joints[arm, part] + along[:, None] * shape.lengths[part] * axes[part]
            wanted = MODEL.pixels(axis[:, None] + r * normals)
            np.testing.assert_allclose(points[limb], wanted, atol=1e-6)


def test_a_narrow_patch_turns_away_with_the_upper_arm_and_one_right_round_does_not():
    state = np.tile([1.2, 0.2, 0.5, 0.0], 2)
    placed = MODEL.place(state)
    narrow = replace(placed, around=np.column_stack([placed.around[:, 0], np.full(6, 0.8)]))
    turned = state.copy()
    turned[2] += np.pi
    shown = [MODEL.surface(np.array([state, turned]), one).visible.mean(axis=-1)
             for one in (narrow, placed)]  # fmt: skip
    assert shown[0][0, 0] > 0.9
    assert shown[0][1, 0] < 0.1
    assert abs(shown[1][1, 0] - shown[1][0, 0]) < 0.15


def test_a_patch_behind_the_other_parts_is_hidden():
    behind = REST.copy()
    behind[4:] = [-0.2, -0.4, 2.6, 1.6]  # the forearm on the right goes behind the trunk
    patches = MODEL.place(REST)
    free, hidden = MODEL.surface(np.array([REST, behind]), patches).visible.mean(axis=-1)
    assert hidden[4] < 0.2 < free[4]


def test_the_face_tells_how_far_away_the_person_is_and_where():
    stage = Stage()
    rng = np.random.default_rng(0)
    person = Person(Build(), make_outfit(rng), make_identity(rng))
    camera = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
    model = BodyModel.from_face(stage.face(person), camera)
    np.testing.assert_allclose(model.middle, stage.middle, atol=0.02)
    half = BodyModel.from_face(stage.face(person) * [1, 1, 0.5, 0.5], camera)
    assert half.middle[2] == pytest.approx(2 * model.middle[2])


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: replace(MODEL, middle=np.array([0, 0, 0.5])), "farther away than an arm"),
        (lambda: replace(MODEL, limits=np.zeros((4, 2))), "limits must rise"),
        (lambda: replace(MODEL, counts=(0, 1, 1)), "counts"),
        (lambda: replace(MODEL, counts=(2000, 1, 1)), "counts must be at most 1000, got 2000"),
        (
            lambda: BodyModel(replace(CAMERA, distortion=(0.1, 0, 0, 0)), np.array([0, 0, 2.0])),
            "camera must have no distortion",
        ),
        (lambda: Measures(radii=(0.1, 0.1, 0.1, 0.0)), "radii must be positive"),
        (lambda: BodyModel.from_face(np.array([1.0, 1, 0, 5]), CAMERA), "face must have a width"),
        (lambda: BodyModel.from_face(np.array([1.0, 1, 90, 90]), CAMERA), "farther away"),
        (lambda: Patches([6], [[0, 1]], [[0, 1]]), "limbs must be one at least, each below 6"),
        (lambda: Patches([0], [[0.5, 0.5]], [[0, 1]]), "along must rise"),
        (lambda: Patches([0], [[0, 1]], [[0, 0]]), "around must have a positive half width"),
        (lambda: MODEL.contours(np.zeros((2, 7))), "states must be"),
        (lambda: MODEL.contours(np.full((1, 8), np.nan)), "states must be finite"),
    ],
)
def test_what_no_body_can_be_is_refused_by_name(make, problem):
    with unchecked(), pytest.raises(ValueError, match=problem):
        make()


def test_limbs_have_names_from_left_to_right():
    assert [name.split()[0] for name in LIMBS] == ["left"] * 3 + ["right"] * 3
    with unchecked(), pytest.raises(TypeError, match="camera must be a Pinhole"):
        BodyModel("camera", np.array([0, 0, 2.0]))

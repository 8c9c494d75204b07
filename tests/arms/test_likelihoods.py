"""Cues of two arms, one by one: against SciPy, the textbook and their own algebra."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import ndimage

from robot_perception.arms.body_model import REST, BodyModel, Contours, Patches
from robot_perception.arms.likelihoods import (
    COLOUR,
    TEXTURE,
    Bodies,
    CollisionCue,
    EdgeCue,
    EdgeRules,
    LimitCue,
    PatchCue,
    StabiliserCue,
    apart,
    confidences,
    edge_weight,
    look,
    mean_square,
    sampled,
    square_of_sum,
    sum_of_squares,
    summed,
)
from robot_perception.cameras import Pinhole
from robot_perception.companion.cues import (
    bhattacharyya,
    patch_histograms,
    patch_histograms_textbook,
)
from tests.unchecked import unchecked

CAMERA = Pinhole((320.0, 320.0), (159.5, 119.5), (320, 240))
MODEL = BodyModel(CAMERA, np.array([0.0, -0.12, 1.9]))


def painted(state=REST, shift=0, seed=0, sleeve=(40, 60, 200), hand=(220, 170, 140)):
    """Return a picture of arms of plain colours, painted by OpenCV, on a wall with some noise."""
    rng = np.random.default_rng(seed)
    image = np.full((240, 320, 3), 120, dtype=np.uint8)
    joints = MODEL.pixels(MODEL.joints(state[None]))[0]
    scale = 320 / 1.9
    for arm in joints:
        arm = np.rint(arm + np.array([shift, 0])).astype(int)
        for k, colour in ((2, hand), (1, sleeve), (0, sleeve)):
            wide = round(2 * scale * np.mean(MODEL.measures.radii[k : k + 2]))
            cv2.line(image, arm[k].tolist(), arm[k + 1].tolist(), colour, wide, cv2.LINE_AA)
    return np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)


IMAGE = painted()
SEEN = look(IMAGE)
STATES = REST + 0.3 * np.random.default_rng(0).standard_normal((30, 8))
PATCHES = MODEL.place(REST)


def covered(surface, bins=8):
    return patch_histograms(SEEN.channels, surface.points, surface.visible, bins=bins)


REFERENCE = covered(MODEL.surface(REST[None], PATCHES))[0][0]


def grey(image):
    return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def test_distances_are_those_of_scipy():
    wanted = ndimage.distance_transform_edt(~SEEN.edges).clip(max=5.0)
    np.testing.assert_allclose(SEEN.static, wanted, atol=1e-5)
    assert SEEN.edges.any()
    assert not SEEN.moves
    assert np.isinf(SEEN.moving).all()


def test_an_edge_moves_where_the_flow_is_long():
    moved = look(painted(shift=4), grey(IMAGE))
    assert moved.moves
    assert ((moved.moving == 0) <= moved.edges).all(), "an edge that moves is an edge"
    assert (moved.moving >= moved.static).all()
    assert not look(IMAGE, grey(IMAGE)).moves, "nothing moved"
    wild = look(painted(shift=4), grey(IMAGE), EdgeRules(moves=50.0))
    assert not wild.moves


def test_a_picture_without_edges_is_as_far_as_can_be():
    flat = np.full((240, 320, 3), 90, dtype=np.uint8)
    seen = look(flat)
    assert not seen.edges.any()
    assert (seen.static == 5.0).all()
    assert edge_weight(seen) == 1.0
    logs = EdgeCue()(seen, Bodies(MODEL, STATES))
    assert np.isfinite(logs).all()


def test_the_channels_are_red_green_blue_and_grey():
    channels = look(IMAGE, grey(IMAGE)).channels
    np.testing.assert_array_equal(channels[..., :3], IMAGE)
    np.testing.assert_array_equal(channels[..., 3], grey(IMAGE))
    assert (channels[..., 3] != channels[..., 0]).any()


def test_noise_of_a_few_grey_levels_is_no_edge():
    """Without the blur a third of this wall would be edges."""
    wall = np.full((240, 320, 1), 120) + np.random.default_rng(0).normal(0, 5, (240, 320, 1))
    noisy = np.repeat(np.rint(wall).astype(np.uint8), 3, axis=2)
    assert not look(noisy).edges.any()


def test_bodies_hold_the_points_of_each_set_of_patches():
    bodies, hands = Bodies(MODEL, STATES), MODEL.place(REST + 0.5)
    for patches in (PATCHES, hands, PATCHES):
        found, wanted = bodies.surface(patches), MODEL.surface(STATES, patches)
        np.testing.assert_array_equal(found.points, wanted.points)
        np.testing.assert_array_equal(found.visible, wanted.visible)


def test_a_denser_picture_gives_edges_less_weight():
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3)).astype(np.uint8)
    assert edge_weight(look(noise)) < 0.5 * edge_weight(SEEN) < 0.5
    assert edge_weight(SEEN) == pytest.approx(SEEN.static.mean() / 5.0)


def test_a_distance_is_that_of_the_nearest_pixel_and_the_most_outside():
    contours = Contours(np.array([[[3.4, 2.6], [319.4, 0.0], [319.6, 0.0], [-0.6, 5.0]]]),
                        np.ones((1, 4), bool))  # fmt: skip
    field = np.arange(240 * 320, dtype=float).reshape(240, 320)
    np.testing.assert_array_equal(sampled(field, contours, 7.0), [[field[3, 3], 319.0, 7.0, 7.0]])


def test_the_three_sums_are_their_formulas():
    rng = np.random.default_rng(0)
    far, visible = rng.uniform(0, 5, (6, 20)), rng.random((6, 20)) < 0.7
    for i in range(6):
        d = far[i, visible[i]]
        assert square_of_sum(far, visible, 2.0)[i] == pytest.approx(-(d.sum() ** 2) / 8)
        assert sum_of_squares(far, visible, 2.0)[i] == pytest.approx(-(d**2).sum() / 8)
        assert mean_square(far, visible, 2.0)[i] == pytest.approx(-(d**2).mean() / 8)
        paid = (d**2).sum() + 9.0 * (~visible[i]).sum()
        assert mean_square(far, visible, 2.0, 3.0)[i] == pytest.approx(-paid / 20 / 8)
    nothing = np.zeros((1, 20), bool)
    assert mean_square(far[:1], nothing, 1.0)[0] == 0.0
    assert mean_square(far[:1], nothing, 1.0, 2.0)[0] == -2.0


def test_from_a_gain_of_one_on_motion_changes_nothing():
    moved = look(painted(shift=4), grey(IMAGE))
    bodies = Bodies(MODEL, STATES)
    still = EdgeCue()(moved, bodies)
    for gain in (1.0, 3.0):
        np.testing.assert_array_equal(EdgeCue(gain=gain)(moved, bodies), still)
    half = EdgeCue(gain=0.5)(moved, bodies)
    assert (half >= still).all()
    assert (half > still).any()


def test_far_from_moving_edges_a_gain_changes_nothing():
    """K times the largest distance is no new largest distance."""
    moved = look(painted(shift=4), grey(IMAGE))
    contours = Bodies(MODEL, STATES).contours
    still, half = (EdgeCue(gain=gain).distances(moved, Bodies(MODEL, STATES))
                   for gain in (None, 0.5))  # fmt: skip
    far = sampled(moved.moving, contours, 1e9) >= 10
    assert far.any()
    np.testing.assert_array_equal(still[far], half[far])
    assert still.max() == 5.0


def test_with_a_toll_an_edge_that_stands_still_costs_it():
    one = np.hstack([IMAGE[:, :160], painted(shift=4)[:, 160:]])
    moved = look(one, grey(IMAGE))
    bodies = Bodies(MODEL, STATES)
    far = sampled(moved.moving, bodies.contours, 6.0)
    near = sampled(moved.static, bodies.contours, 5.0)
    np.testing.assert_allclose(
        EdgeCue(toll=1.0).distances(moved, bodies), np.minimum(far, near + 1.0)
    )
    on = (near == 0) & (far > 1)
    assert on.any()
    assert (EdgeCue(gain=0.1).distances(moved, bodies)[on] == 0).all()
    np.testing.assert_array_equal(EdgeCue(toll=1.0)(SEEN, bodies), EdgeCue()(SEEN, bodies))


def test_where_nothing_moves_a_gain_changes_nothing():
    bodies = Bodies(MODEL, STATES)
    np.testing.assert_array_equal(EdgeCue(gain=0.5)(SEEN, bodies), EdgeCue()(SEEN, bodies))


def test_the_edge_cue_is_the_mean_square_of_the_smaller_distance_times_its_weight():
    moved = look(painted(shift=4), grey(IMAGE))
    bodies = Bodies(MODEL, STATES)
    contours = bodies.contours
    near = np.minimum(
        sampled(moved.static, contours, 5.0), 0.5 * sampled(moved.moving, contours, 10.0)
    )
    wanted = 0.3 * mean_square(near, contours.visible, 0.8, 3.0)
    np.testing.assert_allclose(EdgeCue(0.8, 0.5, None, 3.0, 0.3)(moved, bodies), wanted)


def test_the_true_pose_is_better_than_others_by_edges_and_by_patches():
    states = np.vstack([REST, STATES])
    bodies = Bodies(MODEL, states)
    for cue in (EdgeCue(), PatchCue(PATCHES, REFERENCE), PatchCue(PATCHES, REFERENCE, TEXTURE)):
        logs = cue(SEEN, bodies)
        assert logs.argmax() == 0


def test_histograms_are_those_of_the_textbook():
    surface = MODEL.surface(np.vstack([STATES, REST + 3]), PATCHES)
    for bins in (2, 8, 13):
        plainly = patch_histograms_textbook(
            SEEN.channels, surface.points, surface.visible, bins=bins
        )
        for fast, plain in zip(covered(surface, bins=bins), plainly, strict=True):
            np.testing.assert_allclose(fast, plain, atol=1e-12)


def test_the_patch_cue_is_the_distance_of_bhattacharyya():
    bodies = Bodies(MODEL, STATES)
    found, share = covered(bodies.surface(PATCHES))
    for channels in (COLOUR, TEXTURE, (0, 3)):
        squared = bhattacharyya(found, REFERENCE)[..., list(channels)] ** 2
        wanted = np.where(share >= 0.15, squared.sum(axis=-1), 0.35 * len(channels))
        cue = PatchCue(PATCHES, REFERENCE, channels, weights=np.arange(6.0), sigma=0.4)
        np.testing.assert_allclose(cue.squared(SEEN, bodies), wanted, atol=1e-12)
        np.testing.assert_allclose(cue(SEEN, bodies), -(wanted @ np.arange(6.0)) / 0.32)


def test_a_patch_that_is_out_of_the_picture_costs_its_price():
    out = np.tile([1.5, 0.0, 0.0, 0.0], 2)
    near = replace(MODEL, middle=np.array([-0.6, -0.1, 1.9]))
    cue = PatchCue(PATCHES, REFERENCE, price=0.5)
    squared = cue.squared(SEEN, Bodies(near, out[None]))[0]
    assert squared[2] == 1.5, "the hand on the left has left the picture"
    assert squared[3] < 3.0


def test_confidence_is_small_for_one_colour_and_one_for_all():
    one, every = np.zeros((4, 8)), np.full((4, 8), 1 / 8)
    one[:, 3] = 1.0
    low, high = confidences(np.array([one, every]), COLOUR, 0.7)
    assert high == pytest.approx(1.0)
    assert low == pytest.approx(np.exp(-3 * (1 - np.sqrt(1 / 8)) / (2 * 0.49)))
    texture = confidences(np.array([one, every]), TEXTURE, 0.7)
    assert texture[0] == pytest.approx(low ** (1 / 3))


def test_the_pull_the_bounds_and_a_cue_of_ones_own():
    bodies = Bodies(MODEL, np.vstack([REST, REST + 0.1, REST - 4]))
    cross = np.tile([0.3, 1.2, 2.9, 1.4], 2)
    crossed = Bodies(MODEL, np.vstack([REST, cross]))
    assert MODEL.collides(cross[None])[0]
    cues = {"pull": StabiliserCue(2.0), "limits": LimitCue(7.0),
            "mine": lambda seen, bodies: bodies.states[:, 0]}  # fmt: skip
    logs = summed(cues, SEEN, bodies)
    np.testing.assert_allclose(logs["pull"], [0, -2 * 8 * 0.01, -2 * 8 * 16])
    np.testing.assert_array_equal(logs["limits"], [0, 0, -7])
    np.testing.assert_array_equal(logs["mine"], bodies.states[:, 0])
    np.testing.assert_array_equal(CollisionCue(5.0)(SEEN, crossed), [0, -5])


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: EdgeRules(thresholds=(50.0, 10.0)), "thresholds must rise"),
        (lambda: EdgeCue(gain=0.0), "gain must be"),
        (lambda: EdgeCue(gain=0.5, toll=1.0), "gain and toll must not both"),
        (lambda: look(np.zeros((4, 5), np.uint8)), "image must be"),
        (lambda: look(IMAGE, grey(IMAGE)[:-1]), "before must be"),
        (lambda: PatchCue(PATCHES, REFERENCE[:5]), "reference must be"),
        (lambda: PatchCue(PATCHES, -REFERENCE), "reference must not be negative"),
        (lambda: PatchCue(PATCHES, REFERENCE, (4,)), "channels must be from 0 to 3"),
        (lambda: PatchCue(PATCHES, REFERENCE, weights=-np.ones(6)), "weights must not be negative"),
        (
            lambda: summed({"bad": lambda seen, bodies: np.zeros(3)}, SEEN, Bodies(MODEL, STATES)),
            r"cues\['bad'\]",
        ),
        (
            lambda: summed(
                {"bad": lambda seen, bodies: np.full(30, np.nan)}, SEEN, Bodies(MODEL, STATES)
            ),
            r"cues\['bad'\]",
        ),
    ],
)
def test_bad_input_is_named(make, problem):
    with unchecked(), pytest.raises(ValueError, match=problem):
        make()


def test_the_picture_before_may_lie_anyhow_in_memory():
    before = grey(IMAGE)
    apart = np.repeat(before, 2, axis=1)[:, ::2]
    assert not apart.flags.contiguous
    np.testing.assert_array_equal(look(IMAGE, apart).moving, look(IMAGE, before).moving)


def test_a_surface_is_that_of_its_own_patches_when_others_have_gone():
    bodies = Bodies(MODEL, STATES)
    for count in (1, 2, 3, 1):  # patches that are let go, and others in their place in memory
        patches = Patches(
            *(part[:count] for part in (PATCHES.limbs, PATCHES.along, PATCHES.around))
        )
        assert bodies.surface(patches).visible.shape[1] == count
        del patches


def test_pictures_must_hold_bytes():
    with unchecked(), pytest.raises(TypeError, match="image must be a picture of bytes"):
        look(IMAGE.astype(float))
    with unchecked(), pytest.raises(TypeError, match="before must be an array of bytes"):
        look(IMAGE, grey(IMAGE).astype(float))


MOVING = look(painted(shift=4), grey(IMAGE))
BODIES = Bodies(MODEL, STATES)


@pytest.mark.parametrize(
    "cue",
    [
        EdgeCue(weight=0.7),
        EdgeCue(gain=0.5, price=None),
        PatchCue(PATCHES, REFERENCE, weights=np.arange(1.0, 7.0)),
        StabiliserCue(0.15),
    ],
)
def test_a_cue_is_the_sum_of_what_it_says_of_each_arm(cue):
    """A product over arms: another pose of one arm that hides nothing leaves the other factor."""
    arms = cue.arms(MOVING, BODIES)
    np.testing.assert_allclose(arms.sum(axis=1), cue(MOVING, BODIES), rtol=1e-10)
    states = np.tile(REST, (2, 1))
    states[1, 4] += 0.4  # the right arm, sideways
    left, right = cue.arms(MOVING, Bodies(MODEL, states)).T
    assert right[0] != right[1]
    if not (isinstance(cue, EdgeCue) and cue.price is None):  # whose points are counted together
        np.testing.assert_allclose(left[0], left[1], rtol=1e-12)


def test_a_cue_that_does_not_know_of_arms_is_about_both_and_limits_are_each_arms_own():
    beyond = np.tile(REST, (3, 1))
    beyond[1, 3], beyond[2, 7] = -1.0, -1.0  # elbows that bend backwards, left and right
    cross = np.tile([0.3, 1.2, 2.9, 1.4], 2)[None]
    cues = {"limits": LimitCue(7.0), "collisions": CollisionCue(3.0)}
    cues["one"] = lambda seen, bodies: bodies.states[:, 0]
    found = apart(cues, SEEN, Bodies(MODEL, np.r_[beyond, cross]))
    np.testing.assert_array_equal(found["limits"][:3], [[0, 0], [-7, 0], [0, -7]])
    np.testing.assert_array_equal(found["collisions"][[0, 3]], [[0, 0], [-3, -3]])
    np.testing.assert_array_equal(found["one"], np.tile([*REST[:1]] * 3 + [0.3], (2, 1)).T)
    with unchecked(), pytest.raises(ValueError, match="arms"):
        apart({"bad": Halved()}, SEEN, BODIES)


class Halved:
    """A cue whose arms are not two."""

    def __call__(self, seen, bodies):
        return np.zeros(len(bodies))

    def arms(self, seen, bodies):
        return np.zeros((len(bodies), 3))

"""The corrected picture: eq. (1) against projected points, maps against OpenCV's, no horizon."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robot_perception.ceiling.correction import Correction, correction
from tests.unchecked import unchecked

K = np.array([[300.0, 0, 160], [0, 305, 118], [0, 0, 1]])
TARGET = np.array([[250.0, 0, 150], [0, 250, 125], [0, 0, 1]])
SIZE = (320, 240)
SKEW = np.array([[0, 20.0, 0], [0, 0, 0], [0, 0, 0]])
DOWN = np.array([0.0, 0, -1])
STILL = np.zeros(3)


def mount(roll=8.0, pitch=-6.0, turn=25.0, shift=(0.1, -0.05, -0.2)):
    R = Rotation.from_euler("xyz", [roll, pitch, turn], degrees=True).as_matrix()
    return R, np.array(shift)


def slanted(angle=5.0):
    return Rotation.from_euler("y", angle, degrees=True).apply(DOWN)


def on_ceiling(normal, distance, count, rng):
    """Return points of the plane at which a robot below it looks."""
    rays = np.column_stack([rng.uniform(-0.4, 0.4, (count, 2)), np.ones(count)])
    return rays * (-distance / (rays @ normal))[:, None]


def seen_by(points, matrix, R=None, t=None, distortion=(0.0, 0.0)):
    """Return OpenCV's pixels of points."""
    vector = STILL if R is None else Rotation.from_matrix(R).as_rotvec()
    lens = np.array([*distortion, 0, 0])
    pixels, _ = cv2.projectPoints(points, vector, STILL if t is None else t, matrix, lens)
    return pixels[:, 0]


def smooth(seed=0, size=SIZE):
    noise = np.random.default_rng(seed).integers(0, 256, size[::-1]).astype(np.uint8)
    image = cv2.GaussianBlur(noise, (0, 0), 4)
    return cv2.normalize(image, None, 0, 255, cv2.NORM_MINMAX)


@given(
    st.tuples(*[st.floats(-15, 15)] * 2, st.floats(-180, 180)),
    st.tuples(*[st.floats(-0.3, 0.3)] * 3),
    st.floats(-10, 10),
    st.floats(1, 4),
)
@settings(max_examples=30)
def test_the_homography_is_that_of_projected_points(angles, shift, slant, distance):
    R, t = mount(*angles, shift)
    normal = slanted(slant)
    X = on_ceiling(normal, distance, 12, np.random.default_rng(0))
    ideal, camera = seen_by(X, TARGET), seen_by(X, K, R, t)
    H = correction(K, R, t, normal, distance, TARGET)
    expected, _ = cv2.findHomography(ideal, camera)  # to some six digits
    np.testing.assert_allclose(H / H[2, 2] / expected.max(), expected / expected.max(), atol=1e-4)
    rays = np.column_stack([ideal, np.ones(12)]) @ H.T
    np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], camera, atol=1e-8)


def test_its_third_coordinate_is_the_ratio_of_depths():
    R, t = mount()
    X = on_ceiling(DOWN, 2.1, 5, np.random.default_rng(1))
    images = np.column_stack([seen_by(X, K), np.ones(5)]) @ correction(K, R, t, DOWN, 2.1).T
    np.testing.assert_allclose(images[:, 2], (X @ R.T + t)[:, 2] / X[:, 2], rtol=1e-12)


def test_the_printed_sign_holds_for_the_normal_towards_the_robot():
    R, t = mount()
    X = on_ceiling(DOWN, 2.1, 20, np.random.default_rng(2))
    ideal, camera = seen_by(X, K), seen_by(X, K, R, t)

    def miss(H):
        return np.abs(cv2.perspectiveTransform(ideal[:, None], H)[:, 0] - camera).max()

    assert miss(correction(K, R, t, DOWN, 2.1)) < 1e-9
    upwards = correction(K, R, t, -DOWN, 2.1)
    assert miss(upwards) > 20
    np.testing.assert_allclose(upwards, correction(K, R, -t, DOWN, 2.1))


def test_a_camera_at_the_robot_corrects_nothing_and_a_higher_one_magnifies():
    eye = np.eye(3)
    np.testing.assert_allclose(correction(K, eye, STILL, DOWN, 2.0), eye, atol=1e-13)
    H = correction(K, eye, np.array([0, 0, -0.5]), DOWN, 2.0)  # half a metre nearer
    centre, right = np.array([160.0, 118, 1]), np.array([190.0, 118, 1])
    np.testing.assert_allclose((H @ centre)[:2] / (H @ centre)[2], centre[:2])
    np.testing.assert_allclose((H @ right)[:2] / (H @ right)[2], [200, 118])


@pytest.mark.parametrize("target", [None, TARGET])
def test_without_a_lens_the_picture_is_opencvs_warp(target):
    R, t = mount()
    fixed = Correction(K, R, t, DOWN, 2.1, SIZE, target=target)
    image = smooth()
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpPerspective(image, fixed.homography, SIZE, flags=flags)
    away = np.abs(fixed.apply(image).astype(int) - warped)[fixed.seen]
    assert away.max() <= 3
    np.testing.assert_allclose(fixed.homography, correction(K, R, t, DOWN, 2.1, target))


@pytest.mark.parametrize("distortion", [(0.0, 0.0), (-0.25, 0.06), (0.2, 0.0), (0.0, 0.3)])
def test_every_pixel_comes_from_where_the_camera_sees_it(distortion):
    R, t = mount()
    normal = slanted()
    fixed = Correction(K, R, t, normal, 2.1, SIZE, distortion, TARGET)
    u, v = np.meshgrid(np.arange(320.0), np.arange(240.0))
    rays = np.column_stack([u.ravel(), v.ravel(), np.ones(u.size)]) @ np.linalg.inv(TARGET).T
    X = rays * (-2.1 / (rays @ normal))[:, None]
    pixels = seen_by(X, K, R, t, distortion)
    inside = ((pixels >= 0) & (pixels <= [319, 239])).all(axis=1).reshape(240, 320)
    assert (inside == fixed.seen).mean() > 0.9999
    assert inside.mean() > 0.3
    for axis in range(2):
        ramp = np.indices((240, 320))[1 - axis].astype(np.uint8)
        ramp[:, 256:] = 255 if axis == 0 else ramp[:, 256:]
        found = fixed.apply(ramp)[inside]
        expected = np.minimum(pixels[:, axis].reshape(240, 320)[inside], 255)
        assert np.abs(found - expected).max() < 0.5 + 1 / 16
    white = fixed.apply(np.full((240, 320), 255, np.uint8))
    assert (white[fixed.seen] == 255).all()
    far = ((pixels < -1.1) | (pixels > [320.1, 240.1])).any(axis=1).reshape(240, 320)
    assert (white[far] == 0).all()


def test_points_come_to_where_the_ideal_camera_sees_them():
    R, t = mount()
    normal, lens = slanted(), (-0.25, 0.06)
    X = on_ceiling(normal, 2.1, 40, np.random.default_rng(3))
    X = X[np.linalg.norm(X[:, :2], axis=1) < 0.8]
    fixed = Correction(K, R, t, normal, 2.1, SIZE, lens, TARGET)
    camera = seen_by(X, K, R, t, lens)
    np.testing.assert_allclose(fixed.points(camera), seen_by(X, TARGET), atol=1e-8)
    batch = fixed.points(camera[:6].reshape(2, 3, 2))
    np.testing.assert_array_equal(batch.reshape(6, 2), fixed.points(camera[:6]))
    assert fixed.points(np.empty((0, 2))).shape == (0, 2)
    skewed = TARGET + SKEW
    fixed = Correction(K, R, t, normal, 2.1, SIZE, lens, skewed)
    rays = X / X[:, 2:]
    np.testing.assert_allclose(fixed.points(camera), (rays @ skewed.T)[:, :2], atol=1e-8)


def test_points_and_picture_agree():
    R, t = mount()
    fixed = Correction(K, R, t, DOWN, 2.1, SIZE, (-0.2, 0.0))
    u, v = np.meshgrid(np.arange(320), np.arange(240))
    spot = np.array([150.3, 100.6])
    image = np.round(250 * np.exp(-((u - spot[0]) ** 2 + (v - spot[1]) ** 2) / 18))
    found = fixed.apply(image.astype(np.uint8)).astype(float)
    middle = np.array([(found * u).sum(), (found * v).sum()]) / found.sum()
    np.testing.assert_allclose(middle, fixed.points(spot[None])[0], atol=0.1)


def test_colours_are_corrected_each_and_nothing_is_written_to():
    R, t = mount()
    fixed = Correction(K, R, t, DOWN, 2.1, SIZE, (-0.1, 0.0))
    image = np.stack([smooth(k) for k in range(3)], axis=-1)
    before = image.copy()
    found = fixed.apply(image)
    np.testing.assert_array_equal(image, before)
    for k in range(3):
        np.testing.assert_array_equal(found[..., k], fixed.apply(image[..., k]))
    np.testing.assert_array_equal(fixed.apply(image[..., :1])[..., 0], found[..., 0])
    t[:] = 1
    np.testing.assert_array_equal(fixed.translation, mount()[1])


def test_what_a_folding_lens_would_mirror_is_black():
    """Beyond a radius the polynomial of a barrel distortion leads back into the picture."""
    wide = np.array([[60.0, 0, 160], [0, 60, 120], [0, 0, 1]])
    fixed = Correction(K, np.eye(3), STILL, DOWN, 2.0, SIZE, (-0.3, 0.0), wide)
    u, v = np.meshgrid(np.arange(320), np.arange(240))
    radius = np.hypot(u - 160, v - 120) / 60
    fold = np.sqrt(1 / 0.9)  # where r - 0.3 r³ is steepest no more
    back = radius - 0.3 * radius**3
    mirrored = (radius > fold + 0.01) & (np.abs(back) < 0.2)
    assert mirrored.sum() > 500
    white = fixed.apply(np.full((240, 320), 255, np.uint8))
    assert not fixed.seen[radius > fold].any()
    assert not white[radius > fold].any()
    assert (white[radius < 0.3] == 255).all()


R, T = mount()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"normal": -DOWN}, "normal must point from the ceiling to the robot"),
        ({"normal": 1.001 * DOWN}, "normal must be of length 1"),
        ({"normal": slanted(65)}, "horizon of the ceiling outside"),
        ({"rotation": mount(70)[0]}, "horizon inside the picture"),
        ({"rotation": -np.eye(3)}, "rotation must hold rotations"),
        ({"rotation": 1.1 * np.eye(3)}, "rotation must hold rotations"),
        ({"distance": 0.0}, "distance must be positive"),
        ({"distance": -2.0}, "distance must be positive"),
        ({"rotation": np.eye(3), "translation": np.array([0, 0, -2.1])}, "below the ceiling"),
        ({"rotation": np.eye(3), "translation": np.array([0, 0, -3.0])}, "below the ceiling"),
        ({"K": np.diag([300.0, 0, 1])}, "K must be upper triangular"),
        ({"K": K.T}, "K must be upper triangular"),
        ({"K": 2 * K}, "last entry of 1"),
        ({"K": K + SKEW}, "K must have no skew"),
        ({"target": np.zeros((3, 3))}, "target must be upper triangular"),
        ({"size": (0, 240)}, "size must be at least 1"),
        ({"size": (40000, 2)}, "size must be that of a picture"),
        ({"distortion": (np.nan, 0.0)}, "distortion must be finite"),
    ],
)
def test_wrong_arguments(wrong, said):
    plain = {"K": K, "rotation": R, "translation": T, "normal": DOWN, "distance": 2.1}
    right = {**plain, "target": TARGET, "size": SIZE, "distortion": (0.0, 0.0)}
    Correction(**right)
    with pytest.raises(ValueError, match=said), unchecked():
        Correction(**(right | wrong))
    if wrong.keys() <= {"rotation", "distance", "translation"} and "horizon" not in said:
        with pytest.raises(ValueError, match=said):
            correction(**(plain | wrong))


def test_a_camera_far_below_is_fine_and_one_just_below_the_ceiling_too():
    for height in (-2.0, 1.0):
        t = np.array([0, 0, height])
        assert Correction(K, np.eye(3), t, DOWN, 2.1, SIZE).seen.any()


def test_a_tilted_camera_above_the_ceiling_is_refused():
    R = mount(0, 30, 0)[0]
    correction(K, R, -R @ [0.8, 0, 2.0], DOWN, 2.1)
    with pytest.raises(ValueError, match=r"below the ceiling, got it -0\.1 m below"):
        correction(K, R, -R @ [0.8, 0, 2.2], DOWN, 2.1)


def test_wrong_pictures_and_points():
    fixed = Correction(K, R, T, DOWN, 2.1, SIZE, (-0.3, 0.0))
    with pytest.raises(ValueError, match="image must be bytes"), unchecked():
        fixed.apply(np.zeros((240, 320)))
    with pytest.raises(ValueError, match=r"image must be \(240, 320\) pixels"):
        fixed.apply(np.zeros((320, 240), np.uint8))
    with pytest.raises(ValueError, match="pixels must be where the distortion can be undone"):
        fixed.points(np.array([[5000.0, 100]]))
    tilted = Correction(K, mount(0, 30)[0], T, DOWN, 2.1, SIZE)
    tilted.points(np.array([[319.0, 100], [0, 100]]))
    with pytest.raises(ValueError, match="pixels must look at the ceiling, got 1 of 2"):
        tilted.points(np.array([[160 - 300 * 2.0, 118], [160, 118]]))

"""Cameras against gtsam and the formulas of a lens; triangulation against differences, chance."""

import gtsam
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.cameras import Pinhole, StereoRig, level_mount
from robot_perception.geometry import se3
from tests.unchecked import unchecked

FOCAL, CENTRE, SIZE = (300.0, 310.0), (155.0, 118.0), (320, 240)
LENSES = [(), (-0.3, 0.1, 1e-3, -2e-3), (-0.3, 0.1, 1e-3, -2e-3, 0.02)]
LENSES += [(0.1, 0.05, 1e-3, -2e-3, 0.02, 0.3, 0.01, 0.02)]
RIG = StereoRig(Pinhole(FOCAL, CENTRE, SIZE), 0.12)
SEEDS = st.integers(0, 2**31)


def points_ahead(rng, count=20):
    """Return points in the image, 1 m to 8 m away."""
    z = rng.uniform(1, 8, count)
    return np.column_stack([rng.uniform(-0.45, 0.45, (count, 2)) * [1, 0.7] * z[:, None], z])


def lens(point, coefficients):
    """Return a pixel by the formulas of Brown and Conrady, with the rational radial term."""
    k1, k2, p1, p2, k3, k4, k5, k6 = np.pad(coefficients, (0, 8 - len(coefficients)))
    x, y = point[:2] / point[2]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    radial /= 1 + k4 * r2 + k5 * r2**2 + k6 * r2**3
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return FOCAL[0] * u + CENTRE[0], FOCAL[1] * v + CENTRE[1]


@pytest.mark.parametrize("coefficients", LENSES)
def test_pixels_are_those_of_the_lens_and_rays_lead_back(coefficients):
    camera, points = (
        Pinhole(FOCAL, CENTRE, SIZE, coefficients),
        points_ahead(np.random.default_rng(0)),
    )
    pixels = camera.project(points)
    np.testing.assert_allclose(pixels, [lens(p, coefficients) for p in points], rtol=0, atol=1e-9)
    np.testing.assert_allclose(camera.rays(pixels), points / points[:, 2:], rtol=0, atol=1e-9)
    assert camera.sees(points).all()
    batch = camera.project(points.reshape(4, 5, 3))
    np.testing.assert_array_equal(batch.reshape(20, 2), pixels)
    assert camera.rays(batch).shape == (4, 5, 3)
    assert camera.project(points[:0]).shape == (0, 2)
    assert camera.rays(pixels[:0]).shape == (0, 3)


def test_pixels_are_gtsams():
    points, coefficients = points_ahead(np.random.default_rng(1)), LENSES[1]
    lens = gtsam.Cal3DS2(*FOCAL, 0.0, *CENTRE, *coefficients)
    theirs = gtsam.PinholeCameraCal3DS2(gtsam.Pose3(), lens)
    ours = Pinhole(FOCAL, CENTRE, SIZE, coefficients).project(points)
    np.testing.assert_allclose(ours, [theirs.project(p) for p in points], rtol=0, atol=1e-9)


def test_a_plain_camera_is_its_matrix():
    camera, points = Pinhole(FOCAL, CENTRE, SIZE), points_ahead(np.random.default_rng(2))
    homogeneous = points @ camera.matrix.T
    pixels = homogeneous[:, :2] / homogeneous[:, 2:]
    np.testing.assert_allclose(camera.project(points), pixels, rtol=0, atol=1e-10)


def test_what_is_behind_or_outside_is_not_seen():
    camera = Pinhole((100.0, 100.0), (10.0, 5.0), (20, 10))
    edges = [(-0.5, -0.5), (19.4, 9.4), (-0.6, 5), (19.6, 5), (10, -0.6), (10, 9.6)]
    points = 2 * camera.rays(np.array(edges))
    assert camera.sees(points).tolist() == [True, True, False, False, False, False]
    assert not camera.sees(-points).any()
    assert not camera.sees(np.zeros((2, 3))).any()


def test_a_direction_that_the_lens_folds_back_into_the_image_is_not_seen():
    """The radial polynomial 1 - 0.4 r² turns back at r = 0.91: r = 1.5 lands where 0.16 does."""
    camera = Pinhole(FOCAL, CENTRE, SIZE, (-0.4, 0.0, 0.0, 0.0))
    points = np.array([[1.5, 0, 1], [-1.4, 0, 1], [0.16, 0, 1], [0.3, 0.2, 1]])
    pixels = camera.project(points)
    assert ((pixels >= 0) & (pixels < SIZE)).all()
    assert camera.sees(points).tolist() == [False, False, True, True]
    with pytest.raises(ValueError, match="where the distortion can be undone, got 1 of 2 elsew"):
        camera.rays(np.array([[155.0, 118.0], [900.0, 118.0]]))


@given(SEEDS)
def test_a_rig_is_two_cameras_and_gtsams(seed):
    points = points_ahead(np.random.default_rng(seed), 5)
    left = RIG.camera.project(points)
    right = RIG.camera.project(points - [RIG.baseline, 0, 0])
    np.testing.assert_allclose(left[:, 1], right[:, 1], rtol=0, atol=1e-10)
    measured = RIG.project(points)
    np.testing.assert_allclose(measured, np.column_stack([left, right[:, 0]]), rtol=0, atol=1e-9)
    stereo = gtsam.Cal3_S2Stereo(*FOCAL, 0.0, *CENTRE, RIG.baseline)
    theirs = [gtsam.StereoCamera(gtsam.Pose3(), stereo).project(p) for p in points]
    theirs = [(p.uL(), p.v(), p.uR()) for p in theirs]
    np.testing.assert_allclose(measured, theirs, rtol=0, atol=1e-9)


@given(SEEDS)
def test_triangulation_undoes_projection_with_the_covariance_of_differences(seed):
    rng = np.random.default_rng(seed)
    points, sigma = points_ahead(rng, 4), rng.uniform(0.1, 1, (4, 3))
    measured = RIG.project(points)
    found = RIG.triangulate(measured, sigma)
    np.testing.assert_allclose(found.mean, points, rtol=1e-9, atol=1e-9)
    h = 1e-4
    columns = [
        (RIG.triangulate(measured + h * e, 0).mean - RIG.triangulate(measured - h * e, 0).mean)
        / (2 * h)
        for e in np.eye(3)
    ]
    J = np.stack(columns, axis=-1)
    cov = J @ (sigma[..., None] ** 2 * J.mT)
    np.testing.assert_allclose(found.cov, cov, rtol=1e-5, atol=1e-6 * cov.max())
    np.testing.assert_allclose(RIG.triangulate(measured, sigma[0]).cov[0], found.cov[0])
    np.testing.assert_allclose(RIG.triangulate(measured, 0.5).cov, 4 * _quarter(measured))


def _quarter(measured):
    return RIG.triangulate(measured, np.full(3, 0.25)).cov


@pytest.mark.parametrize(("sigma", "digits"), [(0.25, 0.02), (0.5, 0.05)])
def test_noise_scatters_as_told_and_pushes_points_away(sigma, digits):
    """Disparity of 12 px; the mean lies farther by the share 2 σ²/d², the rest is of order four."""
    point = np.array([[0.4, -0.3, 3.0]])
    measured = RIG.project(point)
    d = measured[0, 0] - measured[0, 2]
    assert d == pytest.approx(12)
    rng, count = np.random.default_rng(0), 200_000
    noisy = RIG.triangulate(measured + sigma * rng.standard_normal((count, 3)), sigma)
    cov = RIG.triangulate(measured, sigma).cov[0]
    scatter = np.cov(noisy.mean.T)
    np.testing.assert_allclose(scatter, cov, rtol=0, atol=digits * np.abs(cov).max())
    bias = noisy.mean.mean(axis=0)[2] / 3 - 1
    chance = np.sqrt(cov[2, 2] / count) / 3
    assert abs(bias - 2 * sigma**2 / d**2) < 4 * chance + 12 * (2 * sigma**2 / d**2) ** 2
    assert bias > 4 * chance


def test_a_level_camera_looks_where_the_robot_goes():
    T_robot_camera = level_mount(np.array([0.1, 0.05, 1.2]))
    seen = se3.act(se3.inverse(T_robot_camera), np.array([[5.1, 0.05, 1.2], [5.1, 1.05, 1.7]]))
    np.testing.assert_allclose(seen, [[0, 0, 5], [-1, -0.5, 5]], atol=1e-12)


def test_cameras_of_equal_numbers_are_equal():
    with unchecked():
        camera = Pinhole([300, 310], np.array([155, 118]), np.array([320, 240]), [])
    assert camera == RIG.camera
    assert hash(StereoRig(camera, 0.12)) == hash(RIG)


GOOD = np.array([[100.0, 20.0, 90.0], [150.0, 130.0, 149.0]])
LENS = Pinhole(FOCAL, CENTRE, SIZE, LENSES[1])


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Pinhole((0.0, 1.0), CENTRE, SIZE), r"focal must be positive, got \(0.0, 1.0\)"),
        (lambda: Pinhole(FOCAL, CENTRE, (0, 5)), "size must be at least 1, got 0"),
        (lambda: Pinhole(FOCAL, CENTRE, (3.5, 5)), "size must be integers"),
        (lambda: Pinhole(FOCAL, (0.0, np.nan), SIZE), "centre must be finite"),
        (lambda: Pinhole(FOCAL, CENTRE, SIZE, (0.1, 0.2)), r"14\) coefficients, got 2"),
        (lambda: RIG.camera.project(np.zeros((2, 3))), "in front of the camera, got 2 of 2 that"),
        (lambda: LENS.project(np.array([[0, 0, -1.0]])), "in front of the camera, got 1 of 1 that"),
        (lambda: RIG.project(np.array([[0, 0, -1.0]])), "in front of the camera, got 1 of 1 that"),
        (lambda: RIG.camera.rays(np.ones(2)), r"pixels must be \(…, n, 2\), got \(2,\)"),
        (lambda: StereoRig(LENS, 0.1), "camera of a rectified rig must have no distortion"),
        (lambda: StereoRig(RIG.camera, 0.0), "baseline must be positive and finite, got 0.0"),
        (lambda: RIG.triangulate(GOOD, -0.5), "sigma_px must not be negative, got -0.5"),
        (lambda: RIG.triangulate(GOOD, np.ones(2)), r"sigma_px must broadcast against measure"),
        (lambda: RIG.triangulate(GOOD[:, ::-1], 0.5), "a positive disparity, got 2 of 2 that have"),
        (lambda: RIG.triangulate(GOOD[:, [0, 1, 0]], 0.5), "positive disparity, got 2 of 2"),
        (lambda: RIG.triangulate(GOOD[:, :2], 0.5), r"measurements must be \(…, n, 3\)"),
    ],
)
def test_bad_input_is_named(build, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        build()

"""What a camera below a ceiling sees, against OpenCV's projection, centroids and closed forms."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from data_synth.ceiling.camera import (
    BEYOND,
    LENS,
    CeilingCamera,
    Exposure,
    Mount,
    Occluder,
)
from data_synth.ceiling.plane import Ceiling

RNG = np.random.default_rng(3)
BLANK = Ceiling(np.full((600, 600), 120, dtype=np.uint8), (), "plain")
TILTED = {
    "roll": -0.08,
    "pitch": 0.15,
    "yaw": 0.7,
    "x": 0.12,
    "y": -0.2,
    "centre": (150.0, 127.0),
    "distortion": (-0.15, 0.03),
}
ANGLES = st.floats(-0.4, 0.4)


def spotted(places, *, deviation=0.03, resolution=0.01, n=800):
    """Return a ceiling of grey 60 with soft bright dots at places (n, 2), m."""
    at = (np.arange(n) - (n - 1) / 2) * resolution
    greys = np.full((n, n), 60.0)
    for x, y in places:
        away = (at - x) ** 2 + (at[:, None] - y) ** 2
        greys += 180 * np.exp(-away / (2 * deviation**2))
    return Ceiling(np.rint(greys).astype(np.uint8), (), "plain", resolution)


def centroid(image, near, ground, reach=14):
    """Return the middle of what differs from the ground near a pixel."""
    u, v = np.rint(near).astype(int)
    part = image[v - reach : v + reach + 1, u - reach : u + reach + 1].astype(float) - ground
    rows, columns = np.mgrid[v - reach : v + reach + 1, u - reach : u + reach + 1]
    return np.array([(part * columns).sum(), (part * rows).sum()]) / part.sum()


def world_to_pixels(mount, pose, points):
    """Return what OpenCV says, from the mount's own calibration."""
    spun = Rotation.from_euler("z", -pose[2])
    flat = np.column_stack([points - pose[:2], np.zeros(len(points))])
    robot = spun.apply(flat) + np.array([0, 0, mount.height])
    lens = np.array([*mount.distortion, 0.0, 0.0])
    way = Rotation.from_matrix(mount.rotation).as_rotvec()  # cv2 takes 1e-5 rad for no rotation
    pixels, _ = cv2.projectPoints(robot, way, mount.translation, mount.K, lens)
    return pixels[:, 0]


@given(ANGLES, ANGLES, st.floats(-3, 3), st.floats(-0.1, 0.2), st.integers(0, 10**6))
@settings(deadline=None)
def test_points_are_seen_where_opencv_projects_them(roll, pitch, yaw, first, seed):
    rng = np.random.default_rng(seed)
    mount = Mount(
        *(rng.uniform(1.5, 4), rng.uniform(150, 300), (64, 48), (30.0, 25.0)),
        *(roll, pitch, yaw, *rng.uniform(-0.3, 0.3, 2), (first, 0.01)),
    )
    pose = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    points = pose[:2] + rng.uniform(-0.8, 0.8, (9, 2))
    seen = CeilingCamera(BLANK, mount).points_seen(pose, points)
    np.testing.assert_allclose(seen, world_to_pixels(mount, pose, points), atol=1e-4)


@given(ANGLES, ANGLES, st.floats(-3, 3))
def test_the_rotation_is_yaw_then_pitch_then_roll_about_the_cameras_own_axes(roll, pitch, yaw):
    mount = Mount(roll=roll, pitch=pitch, yaw=yaw, x=0.3, y=-0.2)
    axes = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    np.testing.assert_allclose(mount.rotation, axes.T, atol=1e-12)
    np.testing.assert_allclose(mount.rotation @ [0.3, -0.2, 0] + mount.translation, 0, atol=1e-12)


@pytest.mark.parametrize(
    ("fault", "way"),
    [
        ({"pitch": 0.1}, (-1, 0)),  # looks ahead: what is above falls back
        ({"roll": 0.1}, (0, 1)),  # looks to the right: what is above is on the left
        ({"x": 0.2}, (-1, 0)),
        ({"y": 0.2}, (0, -1)),
    ],
)
def test_where_a_fault_of_the_mount_shows_what_is_straight_above(fault, way):
    (seen,) = CeilingCamera(BLANK, Mount(**fault)).points_seen(np.zeros(3), np.zeros((1, 2)))
    off = seen - [159.5, 119.5]
    size = 200 * np.tan(0.1) if {"pitch", "roll"} & set(fault) else 200 * 0.2 / 2.5
    np.testing.assert_allclose(off, np.array(way) * size, atol=1e-9)


def test_a_camera_turned_to_the_left_sees_what_is_ahead_on_its_right():
    camera = CeilingCamera(BLANK, Mount(yaw=0.3))
    (seen,) = camera.points_seen(np.zeros(3), np.array([[1.0, 0]]))
    np.testing.assert_allclose(seen - [159.5, 119.5], 80 * np.array([np.cos(0.3), -np.sin(0.3)]))


def test_an_upright_camera_sees_ahead_along_the_columns_and_left_along_the_rows():
    camera = CeilingCamera(BLANK, Mount())
    seen = camera.points_seen(np.array([1.0, 2, np.pi / 2]), np.array([[1.0, 2.5], [0.5, 2]]))
    np.testing.assert_allclose(seen, [[159.5 + 40, 119.5], [159.5, 119.5 + 40]])
    assert Mount().K[0, 0] == 200


@pytest.mark.parametrize("mount", [Mount(), Mount(**TILTED)], ids=["upright", "tilted"])
def test_dots_are_rendered_where_their_points_are_seen(mount):
    pose = np.array([0.3, -0.4, 0.8])
    places = pose[:2] + np.array([[0, 0], [0.5, 0.2], [-0.6, 0.3], [0.2, -0.5]])
    camera = CeilingCamera(spotted(places), mount)
    image = camera.image(pose)
    for seen in camera.points_seen(pose, places):
        assert centroid(image, seen, 60) == pytest.approx(seen, abs=0.05)


@pytest.mark.parametrize(("height", "focal"), [(2.5, 200.0), (1.5, 200.0), (2.5, 320.0)])
def test_the_lens_smears_a_point_by_half_a_pixel(height, focal):
    texture = np.zeros((901, 901), dtype=np.uint8)
    texture[450, 450] = 255
    mount = Mount(size=(17, 17), height=height, focal=focal)
    camera = CeilingCamera(Ceiling(texture, (), "plain", 0.0025), mount)  # three a pixel at least
    rows, columns = np.mgrid[:17, :17] - 8.0
    for axis, way in ((columns, (1, 0)), (rows, (0, 1))):
        moments = np.zeros(2)
        for part in np.arange(4) / 4:  # of a pixel
            pose = np.array([*np.array(way) * part * height / focal, 0.0])
            image = camera.image(pose, exposure=Exposure(gain=12.0)).astype(float)
            moments += image.sum(), (image * (axis + part) ** 2).sum()
        assert np.sqrt(moments[1] / moments[0]) == pytest.approx(LENS, rel=0.05)


@given(st.floats(0, 2.2), st.floats(-60, 60))
def test_gain_and_offset_are_exact(gain, offset):
    image = CeilingCamera(BLANK, Mount(size=(5, 4))).image(
        np.zeros(3), exposure=Exposure(gain=gain, offset=offset)
    )
    assert image.shape == (4, 5)
    assert (image == np.clip(np.floor(gain * 120 + offset + 0.5), 0, 255)).all()


def test_vignetting_takes_its_share_half_a_diagonal_from_the_optical_axis():
    exposure = Exposure(vignetting=0.4)
    image = CeilingCamera(BLANK, Mount(focal=400.0)).image(np.zeros(3), exposure=exposure)
    rows, columns = np.mgrid[:240, :320]
    far = ((columns - 159.5) ** 2 + (rows - 119.5) ** 2) / (160**2 + 120**2)
    np.testing.assert_allclose(image, 120 * (1 - 0.4 * far), atol=0.501)
    moved = CeilingCamera(BLANK, Mount(focal=400.0, centre=(100.0, 80.0))).image(
        np.zeros(3), exposure=exposure
    )
    assert np.unravel_index(moved.argmax(), moved.shape)[0] <= 80
    assert moved[80, 100] == 120
    assert moved[80, 180] == moved[80, 20] == moved[160, 100]


def test_noise_has_its_deviation_and_comes_from_its_source():
    camera = CeilingCamera(BLANK, Mount())
    one, same, other = (
        camera.image(np.zeros(3), rng=np.random.default_rng(k), exposure=Exposure(noise=5.0))
        for k in (1, 1, 2)
    )
    assert (one == same).all()
    assert one.std() == pytest.approx(np.sqrt(25 + 1 / 12), rel=0.02)
    assert one.mean() == pytest.approx(120, abs=0.1)
    both = np.corrcoef(one.ravel(), other.ravel())[0, 1]
    beside = np.corrcoef(one[:, 1:].ravel(), one[:, :-1].ravel())[0, 1]
    assert max(abs(both), abs(beside)) < 0.02
    with pytest.raises(ValueError, match="rng must be given"):
        camera.image(np.zeros(3), exposure=Exposure(noise=5.0))


def test_beyond_the_ceiling_all_is_one_grey():
    camera = CeilingCamera(BLANK, Mount())
    assert (camera.image(np.array([50.0, 0, 0])) == BEYOND).all()
    # the ceiling ends 3 m out, half a texel beyond the middle of its last
    edge = camera.image(np.array([3.0, 0, 0]))
    assert (edge[:, :160] == 120).all()
    assert (edge[:, 160:] == BEYOND).all()
    assert camera.image(np.array([3.003, 0, 0]))[0, 159] == 120  # sees 3 mm less than 3 m
    assert (camera.image(np.array([0, -3.0, 0]))[:120] == BEYOND).all()
    assert (camera.image(np.array([0, -3.0, 0]))[120:] == 120).all()


def test_rays_that_go_down_see_no_ceiling():
    mount = Mount(focal=60.0, pitch=1.2)
    camera = CeilingCamera(Ceiling(np.full((4000, 4000), 120, np.uint8), (), "plain"), mount)
    image = camera.image(np.zeros(3), occluders=[Occluder(0, 0, 3.0, 1.0, 10)])
    rows, columns = np.mgrid[:240, :320]
    up = ((columns - 159.5) * mount.rotation[0, 2] + (rows - 119.5) * mount.rotation[1, 2]) / 60
    assert (image[up + mount.rotation[2, 2] <= 0] == BEYOND).all()
    behind = camera.points_seen(np.zeros(3), np.array([[-8.0, 0.0], [8.0, 0.0]]))
    assert np.isposinf(behind[0]).all()
    assert np.isfinite(behind[1]).all()


@pytest.mark.parametrize("fault", [{}, TILTED], ids=["upright", "tilted"])
@pytest.mark.parametrize("height", [0.6, 1.4])
def test_an_occluder_is_seen_as_a_ceiling_at_its_height_would_be(fault, height):
    pose = np.array([0.4, 0.1, -0.6])
    disc = Occluder(0.45, 0.05, 0.06, height, 20.0)
    camera = CeilingCamera(BLANK, Mount(**fault))
    dark = (camera.image(pose) - camera.image(pose, occluders=[disc]).astype(float)) / 100
    turn = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    rim = np.array([0.45, 0.05]) + 0.06 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    outline = CeilingCamera(BLANK, Mount(height=height, **fault)).points_seen(pose, rim)
    shape = cv2.moments(outline.astype(np.float32))
    rows, columns = np.mgrid[:240, :320]
    middle = np.array([(dark * columns).sum(), (dark * rows).sum()]) / dark.sum()
    wanted = np.array([shape["m10"], shape["m01"]]) / shape["m00"]
    assert middle == pytest.approx(wanted, abs=0.06)
    assert dark.sum() == pytest.approx(shape["m00"], rel=0.01)


def test_an_occluder_moves_faster_than_the_ceiling():
    camera = CeilingCamera(BLANK, Mount())
    disc = Occluder(0.0, 0.0, 0.1, 1.0, 20.0)
    images = [camera.image(np.array([x, 0, 0]), occluders=[disc]) for x in (0.0, 0.1)]
    middles = [centroid(image, (159.5 - k * 20, 119.5), 120, 30) for k, image in enumerate(images)]
    assert middles[0] - middles[1] == pytest.approx([200 * 0.1 / 1.0, 0], abs=0.05)


@pytest.mark.parametrize("height", [0.8, 2.0])
def test_the_edge_of_an_occluder_is_a_pixel_wide(height):
    disc = Occluder(0.0, 0.0, 0.15, height, 20.0)
    image = CeilingCamera(BLANK, Mount()).image(np.zeros(3), occluders=[disc])
    rows, columns = np.mgrid[:240, :320]
    out = np.hypot(columns - 159.5, rows - 119.5) - 0.15 * 200 / height
    np.testing.assert_allclose(image, 70 + 100 * np.clip(out, -0.5, 0.5), atol=0.51)


def test_the_nearer_occluder_hides_the_farther_in_whatever_order():
    camera = CeilingCamera(BLANK, Mount())
    discs = [Occluder(0, 0, 0.2, 1.0, 30), Occluder(0, 0, 0.2, 2.0, 200)]
    images = [camera.image(np.zeros(3), occluders=order) for order in (discs, discs[::-1])]
    assert (images[0] == images[1]).all()
    assert images[0][119, 159] == 30
    with pytest.raises(ValueError, match="occluders must be below the ceiling"):
        camera.image(np.zeros(3), occluders=[Occluder(0, 0, 1, 2.5, 0)])


def test_a_lens_that_folds_the_image_is_refused_and_none_other():
    with pytest.raises(ValueError, match="distortion must not fold"):
        Mount(distortion=(-0.5, 0.0))
    # r (1 - 0.2 r²) grows up to r = 1.29, where 0.86 is seen; the corner is at 1
    with pytest.raises(ValueError, match="distortion must not fold"):
        Mount(distortion=(-0.2, 0.0))
    Mount(distortion=(-0.1, 0.0))
    Mount(distortion=(0.5, 0.0))
    Mount(distortion=(-0.2, 0.1))
    far = CeilingCamera(BLANK, Mount(distortion=(-0.1, 0.0)))
    seen = far.points_seen(np.zeros(3), np.array([[4.5, 0.0], [4.6, 0]]))  # the fold is at 4.564 m
    assert np.isfinite(seen[0]).all()
    assert np.isposinf(seen[1]).all()


@pytest.mark.parametrize("lens", [(-0.3, 0.01), (-0.2, -0.05), (0.1, -0.2), (-0.4, 0.07)])
def test_points_beyond_the_fold_of_a_lens_are_not_seen(lens):
    camera = CeilingCamera(BLANK, Mount(size=(9, 9), distortion=lens, height=1.0))
    radii = np.linspace(0, 3, 3001)
    points = np.stack([radii, np.zeros(3001)], axis=1)
    seen = camera.points_seen(np.zeros(3), points)[:, 0]
    shown = radii + lens[0] * radii**3 + lens[1] * radii**5
    grows = np.flatnonzero(np.diff(shown) < 0)
    assert np.isfinite(seen).sum() == pytest.approx(grows[0] + 1 if len(grows) else 3001, abs=1)


def test_a_mount_is_compared_by_what_it_is():
    assert Mount(pitch=0.1) == Mount(pitch=0.1)
    assert Mount(size=(5, 3)).middle == (2.0, 1.0)
    assert Mount(centre=(7.0, 8.0)).middle == (7.0, 8.0)

"""Images of flat surfaces: where their points come to lie, what hides what, light and noise."""

import tracemalloc
from dataclasses import replace
from itertools import islice

import cv2
import numpy as np
import pytest
from scipy.special import ndtr

from data_synth.stereo import (
    Rig,
    Scene,
    Surface,
    frames,
    ideal_image,
    left_frames,
    make_scene,
    project,
    render,
    render_left,
    surface_points,
    visible,
)
from data_synth.textured_building import drive, make_textured_building
from data_synth.textures import make_atlas, paint

QUIET = Rig(blur_px=0.0, vignetting=0.0, read_noise=0.0, photon_noise=0.0, imbalance=0.0)
START = np.zeros(3)
SQUARES, TEXELS = 4, 64  # of the board, and texels along each square
BUILDING = make_textured_building(rng=np.random.default_rng(0))
DRIVE = drive(BUILDING, rng=np.random.default_rng(0))


def upright(centre, size, turn=0.0, picture=0, **words) -> Surface:
    """Return a card that faces the start at heading 0, turned about its upright middle line."""
    right = size[0] * np.array([-np.sin(turn), -np.cos(turn), 0.0])
    down = np.array([0.0, 0.0, -size[1]])
    return Surface(np.asarray(centre) - right / 2 - down / 2, right, down, picture, **words)


def flat(*greys: float) -> list[np.ndarray]:
    return [np.full((2, 2), grey) for grey in greys]


def board() -> np.ndarray:
    """Return a chessboard."""
    rows, columns = np.indices((SQUARES * TEXELS,) * 2) // TEXELS
    return 40.0 + 170.0 * ((rows + columns) % 2)


def corners(surface: Surface) -> np.ndarray:
    """Return the inner corners of the board on a surface."""
    a, b = np.meshgrid(*2 * [np.arange(1, SQUARES) / SQUARES])
    return surface.corner + a.reshape(-1, 1) * surface.right + b.reshape(-1, 1) * surface.down


def measured(image: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return where OpenCV finds the corners."""
    start = near.astype(np.float32).reshape(-1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    return cv2.cornerSubPix(np.rint(image).astype(np.uint8), start, (3, 3), (-1, -1), stop)[:, 0]


@pytest.mark.parametrize(
    ("distance", "side", "turn"),
    [(0.8, 0.0, 0.0), (2.0, 0.1, 0.3), (2.0, -0.4, -0.9), (3.0, 0.5, 0.7), (4.0, 1.0, -0.4)],
)
def test_corners_lie_where_the_pinhole_puts_them_in_both_eyes(distance, side, turn):
    card = upright((distance, side, 1.0), (0.3 * distance, 0.35 * distance), turn)
    scene, rig = make_scene([card], [board()]), replace(QUIET, blur_px=1.0)
    pair = render(scene, rig, START, rng=np.random.default_rng(0))
    points = corners(card)
    depth, left, up = points[:, 0], points[:, 1], points[:, 2] - rig.height
    wanted = np.stack([159.5 - 280 * left / depth, 119.5 - 280 * up / depth], axis=-1)
    np.testing.assert_allclose(project(rig, START, points), np.c_[wanted, depth], atol=1e-9)
    found = measured(pair.left, wanted)
    assert np.abs(found - wanted).max() < 0.1
    disparity = np.stack([280 * 0.15 / depth, np.zeros(len(depth))], axis=-1)
    assert np.abs(measured(pair.right, wanted - disparity) - (wanted - disparity)).max() < 0.1


def test_floor_and_ceiling_lie_where_the_pinhole_puts_them():
    rig = replace(QUIET, height=2.0, blur_px=1.0)
    floor = Surface([9.0, 1.2, 0.0], [0.0, -2.4, 0.0], [-4.0, 0.0, 0.0], 0)  # its far edge is above
    ceiling = Surface([5.0, 1.2, 4.0], [0.0, -2.4, 0.0], [4.0, 0.0, 0.0], 0)
    for surface in (floor, ceiling):
        pair = render(make_scene([surface], [board()]), rig, START, rng=np.random.default_rng(0))
        wanted = project(rig, START, corners(surface))[:, :2]
        assert np.abs(measured(pair.left, wanted) - wanted).max() < 0.1


def test_a_pose_moves_the_world_the_other_way():
    card = upright((3.0, 0.2, 1.0), (0.9, 0.9), 0.2)
    pose = np.array([1.5, -2.0, 0.7])
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    moved = Surface(
        turn @ card.corner + [*pose[:2], 0.0], turn @ card.right, turn @ card.down, card.picture
    )
    images = [
        ideal_image(make_scene([surface], [board()]), QUIET, at)
        for surface, at in ((card, START), (moved, pose))
    ]
    np.testing.assert_allclose(*images, atol=1e-3)
    rotation = QUIET.T_robot_camera[:3, :3]
    points = corners(card)
    at = (points - QUIET.T_robot_camera[:3, 3]) @ rotation  # in the camera
    np.testing.assert_allclose(project(QUIET, START, points)[:, 2], at[:, 2])
    np.testing.assert_allclose(
        project(QUIET, START, points)[:, 0], 159.5 + 280 * at[:, 0] / at[:, 2]
    )
    assert np.linalg.det(rotation) == pytest.approx(1)


@pytest.mark.parametrize("order", [1, -1])
def test_the_nearer_surface_hides_the_other_whatever_their_order(order):
    far, near = (
        upright((4.0, 0.0, 1.1), (2.0, 2.0), picture=0),
        upright((2.0, 0, 1.1), (0.4, 0.4), picture=1),
    )
    image = ideal_image(make_scene([far, near][::order], flat(50, 200)), QUIET, START)
    rows, columns = np.indices(image.shape)
    off = np.maximum(np.abs(rows - 119.5), np.abs(columns - 159.5))  # half sides: 28 and 70 pixels
    assert (image[off < 27.5] == 200).all()
    assert (image[(off > 28.5) & (off < 69.5)] == 50).all()
    assert (image[off > 70.5] == 0).all()


def test_surfaces_that_cross_hide_each_other_by_halves():
    cards = [upright((2.0, 0, 1.1), (1.0, 1.0), turn, p) for p, turn in enumerate((0.6, -0.6))]
    image = ideal_image(make_scene(cards, flat(50, 200)), QUIET, START)
    assert (image[119, 120:159] == 200).all()
    assert (image[119, 161:200] == 50).all()


def test_a_surface_is_seen_from_one_side():
    card = upright((2.0, 0, 1.1), (1.0, 1.0))
    scene = make_scene([card], flat(100))
    assert ideal_image(scene, QUIET, START).max() == 100
    assert ideal_image(scene, QUIET, np.array([4.0, 0.0, np.pi])).max() == 0


def test_edges_are_shaded_by_the_share_of_the_pixel_they_cover():
    edge = 12.4  # pixels right of the middle of the image: a little less than half a pixel more
    wide = 2 * (edge / 280) * 2.0
    image = ideal_image(make_scene([upright((2.0, 0, 1.1), (wide, 1.0))], flat(100)), QUIET, START)
    assert image[119, 171] == 100
    assert image[119, 172] == 50
    assert image[119, 173] == 0


def test_far_texture_fades_to_its_mean_instead_of_flickering():
    fine = 100 + 100.0 * (np.indices((256, 256)).sum(axis=0) % 2)
    wall = upright((6.0, 0, 1.1), (2.0, 2.0))
    image = ideal_image(make_scene([replace(wall, tiles=(4.0, 4.0))], [fine]), QUIET, START)
    assert np.abs(image[90:150, 130:190] - 150).max() < 1


def test_tiles_repeat_and_a_single_picture_does_not_wrap():
    half = np.repeat([[0.0, 200.0]], 2, axis=0)
    card = upright((2.0, 0, 1.1), (1.0, 1.0))
    once = ideal_image(make_scene([card], [half]), QUIET, START)[119, 91:228]
    assert once[:30].max() == 0  # a wrap would bleed the right edge into the left
    assert once[-30:].min() == 200
    twice = ideal_image(make_scene([replace(card, tiles=(2.0, 1.0))], [half]), QUIET, START)
    row = twice[119, 90:230]
    np.testing.assert_allclose(row[5:65], row[75:135], atol=1e-3)
    assert np.ptp(row) == 200


def test_gain_is_light():
    scenes = [make_scene([upright((2.0, 0, 1.1), (1, 1), gain=g)], flat(100)) for g in (1.0, 0.6)]
    bright, dim = (ideal_image(scene, QUIET, START)[119, 159] for scene in scenes)
    assert dim == pytest.approx(0.6 * bright)


def named(scene: Scene) -> Scene:
    """Return a scene whose surfaces have a grey value each, as far as there are."""
    greys = make_atlas(flat(*range(1, 252)))
    count = len(scene.frames)
    return replace(
        scene,
        pictures=np.arange(count) % 251,
        tiles=np.ones((count, 2)),
        gains=np.ones(count),
        atlas=greys,
    )


def off_the_mean(scene: Scene, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return an image less the mean of one four times finer, and that mean."""
    finer = Rig(focal_px=4 * QUIET.focal_px, size=(4 * 320, 4 * 240))
    wanted = ideal_image(scene, finer, pose).reshape(240, 4, 320, 4).mean(axis=(1, 3))
    return ideal_image(scene, QUIET, pose) - wanted, wanted


@pytest.mark.parametrize("k", [90, 240])
def test_images_are_means_of_finer_images(k):
    off, wanted = off_the_mean(BUILDING.scene, DRIVE[k])
    assert np.abs(off.mean()) < 0.3
    assert np.abs(off).mean() < 1.5
    assert wanted.std() > 30


FLOOR = Surface([8.0, 3, 0], [0.0, -6, 0], [-6.0, 0, 0], 0, tiles=(6.0, 12.0))
WALL = Surface([1.0, 1, 2.5], [5.0, 0, 0], [0.0, 0, -2.5], 0, tiles=(5.0, 5.0))
BEFORE = Surface([2.0, 1, 1.6], [0.0, -2, 0], [0.0, 0, -1], 0, tiles=(2.0, 2.0))


@pytest.mark.parametrize(("surface", "most"), [(FLOOR, 2.0), (WALL, 5.0), (BEFORE, 1.0)])
def test_slanting_bricks_are_means_of_finer_images(surface, most):
    scene = make_scene([surface], [paint("brick", rng=np.random.default_rng(0))])
    off, wanted = off_the_mean(scene, START)
    assert np.abs(off[wanted > 0]).mean() < most
    assert wanted[wanted > 0].std() > 10


@pytest.mark.parametrize("k", [0, 70, 230, 300, 420])
def test_images_show_the_surfaces_that_rays_meet(k):
    image = ideal_image(named(BUILDING.scene), QUIET, DRIVE[k])
    rows, columns = np.mgrid[2:240:5, 1:320:5]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=-1)
    found = surface_points(BUILDING.scene, QUIET, DRIVE[k], pixels)
    around = [
        surface_points(BUILDING.scene, QUIET, DRIVE[k], pixels + 0.25 * np.array([i, j])).surfaces
        for i in (-1, 1)
        for j in (-1, 1)
    ]
    plain = (np.array(around) == found.surfaces).all(axis=0)
    assert plain.mean() > 0.9
    shown = image[pixels[:, 1], pixels[:, 0]]
    np.testing.assert_allclose(shown[plain], found.surfaces[plain] % 251 + 1, atol=1e-3)


def test_points_of_surfaces_project_onto_their_pixels_and_are_visible():
    rng = np.random.default_rng(4)
    for k in (10, 150, 350):
        pixels = rng.uniform([-0.5, -0.5], [319.5, 239.5], (200, 2))
        found = surface_points(BUILDING.scene, Rig(), DRIVE[k], pixels)
        assert (found.surfaces >= 0).all()
        np.testing.assert_allclose(project(Rig(), DRIVE[k], found.points)[:, :2], pixels, atol=1e-8)
        frame = BUILDING.scene.frames[found.surfaces]
        share = np.linalg.solve(
            np.concatenate(
                [frame[:, :, :2], np.cross(frame[:, :, 0], frame[:, :, 1])[..., None]], axis=-1
            ),
            (found.points - frame[:, :, 2])[..., None],
        )[..., 0]
        assert (np.abs(share[:, :2] - 0.5) < 0.5 + 1e-6).all()
        np.testing.assert_allclose(share[:, 2], 0, atol=1e-6)
        assert visible(BUILDING.scene, Rig(), DRIVE[k], found.points).all()
        eye = np.array([*DRIVE[k, :2], Rig().height])
        behind = eye + 1.01 * (found.points - eye)
        assert not visible(BUILDING.scene, Rig(), DRIVE[k], behind).any()
        before = eye + 0.5 * (found.points - eye)
        assert visible(BUILDING.scene, Rig(), DRIVE[k], before).all()
        assert not visible(BUILDING.scene, Rig(), DRIVE[k], 2 * eye - found.points).any()


def test_points_beside_the_image_are_not_visible():
    scene = make_scene([upright((2.0, 0, 1.1), (9.0, 9.0))], flat(100))
    u, v = np.array([-0.6, -0.4, 159, 319.4, 319.6, 159, 159]), np.full(7, 119.5)
    v[-2:] = -0.6, 239.4
    points = surface_points(scene, Rig(), START, np.stack([u, v], axis=-1)).points
    seen = visible(scene, Rig(), START, points)
    np.testing.assert_array_equal(seen, [False, True, True, True, False, False, True])


def test_nothing_is_said_to_be_nothing():
    scene = make_scene([upright((2.0, 0, 1.1), (0.2, 0.2))], flat(100))
    found = surface_points(scene, Rig(), START, np.array([[159.5, 119.5], [10.0, 10.0]]))
    np.testing.assert_array_equal(found.surfaces, [0, -1])
    np.testing.assert_array_equal(found.carriers, [0, -1])
    assert np.isnan(found.points[1]).all()
    np.testing.assert_allclose(found.points[0], [2.0, 0, 1.1])
    assert visible(scene, Rig(), START, np.array([[3.0, 1.5, 1.1], [3.0, 0, 1.1]])).tolist() == [
        True,
        False,
    ]
    assert surface_points(scene, Rig(), START, np.empty((0, 2))).points.shape == (0, 3)


def test_a_hanging_has_the_name_of_its_wall():
    wall, card = upright((2.0, 0, 1.1), (2, 2)), upright((1.99, 0, 1.1), (0.2, 0.2), carrier=0)
    found = surface_points(
        make_scene([wall, card], flat(9)), Rig(), START, np.array([[159.5, 119.5], [190.0, 119.5]])
    )
    np.testing.assert_array_equal(found.surfaces, [1, 0])
    np.testing.assert_array_equal(found.carriers, [0, 0])


def test_a_point_beside_the_eye_has_no_image():
    with pytest.raises(ValueError, match="1 do"):
        project(Rig(), START, np.array([[0.0, 1, 1], [1, 0, 0]]))


WHITE = make_scene([upright((1.0, 0, 1.1), (9.0, 9.0))], flat(120))


def test_corners_are_darker_by_the_fourth_power_of_the_cosine():
    rig = replace(QUIET, vignetting=1.0)
    image = render(WHITE, rig, START, rng=np.random.default_rng(0)).left
    for column, row in ((0, 0), (319, 239), (0, 120), (160, 120)):
        away = np.arctan(np.hypot(column - 159.5, row - 119.5) / 280)
        assert image[row, column] == pytest.approx(120 * np.cos(away) ** 4, abs=0.51)
    half = render(WHITE, replace(rig, vignetting=0.5), START, rng=np.random.default_rng(0)).left
    assert half[0, 0] == pytest.approx(60 + image[0, 0] / 2, abs=1)


def test_exposure_multiplies_and_ends_at_white():
    for exposure, wanted in ((0.5, 60), (1.0, 120), (2.0, 240), (3.0, 255), (0.0, 0)):
        pair = render(WHITE, QUIET, START, exposure=exposure, rng=np.random.default_rng(0))
        assert (pair.left == wanted).all()
        assert (pair.right == wanted).all()


def test_noise_has_the_variance_of_photons_and_of_reading():
    rig = replace(QUIET, read_noise=2.0, photon_noise=0.05)
    for exposure in (0.4, 1.0, 1.6):
        pair = render(WHITE, rig, START, exposure=exposure, rng=np.random.default_rng(1))
        variance = 4 + 0.05 * 120 * exposure + 1 / 12  # the last from rounding
        for image in (pair.left, pair.right):
            assert image.mean() == pytest.approx(120 * exposure, abs=0.05)
            assert image.astype(float).var() == pytest.approx(variance, rel=0.03)
        left, right = (image.ravel().astype(float) for image in (pair.left, pair.right))
        assert abs(np.corrcoef(left, right)[0, 1]) < 0.02


def test_a_blurred_edge_is_the_integral_of_a_gaussian():
    step = np.repeat([[40.0, 200.0]], 2, axis=0).repeat(1024, axis=1)
    scene = make_scene([upright((1.0, 0, 1.1), (2.0, 2.0))], [step])
    image = render(scene, replace(QUIET, blur_px=2.0), START, rng=np.random.default_rng(0)).left
    columns = np.arange(150, 170)
    wanted = 40 + 160 * ndtr((columns - 159.5) / np.hypot(2.0, 0.35))  # pixels have a width as well
    np.testing.assert_allclose(image[119, columns], wanted, atol=1.5)


def test_eyes_differ_in_exposure():
    rig = replace(QUIET, imbalance=0.1)
    ratio = [
        np.log(pair.right.mean() / pair.left.mean())
        for pair in (
            render(WHITE, replace(rig, size=(8, 6)), START, rng=np.random.default_rng(s))
            for s in range(200)
        )
    ]
    assert np.std(ratio) == pytest.approx(0.1, rel=0.2)


def test_the_exposure_wanders_along_a_drive():
    rig = replace(QUIET, flicker=0.2, size=(8, 6))
    stream = frames(WHITE, rig, np.zeros((1000, 3)), rng=np.random.default_rng(5))
    light = np.log([pair.left.mean() / 120 for pair in stream])
    assert light.std() == pytest.approx(0.2, rel=0.4)
    assert np.diff(light).std() == pytest.approx(0.2 * np.sqrt(2 - 2 * 0.95), rel=0.1)
    assert np.abs(light.mean()) < 0.15


def test_frames_are_the_same_for_the_same_seed_and_however_many_follow():
    def first_two(count: int, seed: int) -> list[np.ndarray]:
        stream = frames(BUILDING.scene, Rig(), DRIVE[:count], rng=np.random.default_rng(seed))
        return [image for pair in islice(stream, 2) for image in (pair.left, pair.right)]

    for one, other in zip(first_two(2, 1), first_two(3, 1), strict=True):
        np.testing.assert_array_equal(one, other)
    assert (first_two(2, 1)[0] != first_two(2, 2)[0]).mean() > 0.3
    again = make_textured_building(rng=np.random.default_rng(0)).scene
    np.testing.assert_array_equal(again.atlas.texels, BUILDING.scene.atlas.texels)
    np.testing.assert_array_equal(again.frames, BUILDING.scene.frames)


def test_the_left_eye_sees_the_same_alone():
    for k, pair in enumerate(
        frames(BUILDING.scene, Rig(), DRIVE[:2], rng=np.random.default_rng(1))
    ):
        alone = left_frames(BUILDING.scene, Rig(), DRIVE[:2], rng=np.random.default_rng(1))
        np.testing.assert_array_equal(next(islice(alone, k, None)), pair.left)
    both = render(BUILDING.scene, Rig(), DRIVE[9], exposure=0.8, rng=np.random.default_rng(2))
    one = render_left(BUILDING.scene, Rig(), DRIVE[9], exposure=0.8, rng=np.random.default_rng(2))
    np.testing.assert_array_equal(one, both.left)


def test_frames_are_not_kept():
    def peak(count: int) -> int:
        tracemalloc.start()
        for _ in frames(WHITE, Rig(), np.zeros((count, 3)), rng=np.random.default_rng(0)):
            pass
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    assert peak(30) < peak(5) + 10 * 2 * 320 * 240


@pytest.mark.parametrize(
    ("surfaces", "said"),
    [
        ([upright((2, 0, 1), (1, 1), picture=1)], "picture 1 and carrier -1 of 1 pictures"),
        ([upright((2, 0, 1), (1, 1), carrier=1)], "picture 0 and carrier 1 of 1 pictures"),
    ],
)
def test_surfaces_that_name_what_there_is_not_are_refused(surfaces, said):
    with pytest.raises(ValueError, match=said):
        make_scene(surfaces, flat(100))


def test_a_surface_without_area_is_refused():
    with pytest.raises(ValueError, match="must span a surface"):
        Surface([0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], 0)

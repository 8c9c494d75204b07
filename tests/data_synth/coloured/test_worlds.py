"""Coloured things: the truth fits the pixels, switches do what they say, light obeys its law."""

from functools import cache

import cv2
import numpy as np
import pytest
import shapely

from data_synth.coloured import (
    Camera,
    HeadScene,
    beetle,
    circles,
    head,
    lamp,
    rectangle,
    snail,
)
from data_synth.coloured.sequences import HEIGHT, WIDTH

WORLDS = (circles, rectangle, beetle, snail, head)
QUIET = Camera(0.0, 0.0, 0.0, 1, 0.0)
COUNT = 12
IMAGE = shapely.box(-0.5, -0.5, WIDTH - 0.5, HEIGHT - 0.5)


@cache
def film(world, seed=1, frames=COUNT, camera=QUIET, **switches):
    return world(rng=np.random.default_rng(seed), frames=frames, camera=camera, **switches)


def filled(outline):
    """Pixels inside an outline by OpenCV, from eight times finer ones."""
    fine = np.zeros((HEIGHT * 8, WIDTH * 8), dtype=np.uint8)
    cv2.fillPoly(fine, [np.rint((outline + 0.5) * 128 - 8).astype(np.int32)], 255, shift=4)
    return cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA) > 127


def affine_rest(outline, of):
    """Largest distance of an outline from the best affine image of another."""
    design = np.column_stack([of, np.ones(len(of))])
    return np.abs(design @ np.linalg.lstsq(design, outline, rcond=None)[0] - outline).max()


def shown(light):
    return 255 * np.clip(light, 0, 1) ** (1 / 2.2)


@pytest.mark.parametrize("world", WORLDS)
def test_a_sequence_has_its_shapes_and_finite_truth(world):
    s = film(world)
    assert s.frames.shape == (COUNT, HEIGHT, WIDTH, 3)
    assert s.frames.dtype == np.uint8
    for masks in (s.masks, s.extra):
        assert masks.shape == (COUNT, HEIGHT, WIDTH)
        assert masks.dtype == bool
    assert s.outlines.shape[::2] == (COUNT, 2)
    assert s.light.shape == (COUNT, 3)
    assert (s.light > 0).all()
    assert np.isfinite(s.outlines).all()
    assert np.isfinite(s.light).all()
    assert not (s.masks & s.extra).any()


@pytest.mark.parametrize("world", WORLDS)
def test_same_seed_same_pixels_and_another_seed_another_scene(world):
    again = world(rng=np.random.default_rng(1), frames=COUNT, camera=QUIET)
    np.testing.assert_array_equal(again.frames, film(world).frames)
    np.testing.assert_array_equal(again.masks, film(world).masks)
    assert np.abs(film(world, seed=2).outlines[0] - again.outlines[0]).max() > 3


@pytest.mark.parametrize("world", WORLDS)
def test_outlines_are_simple_and_visible_pixels_lie_inside_them(world):
    s = film(world)
    for mask, outline in zip(s.masks, s.outlines, strict=True):
        shape = shapely.Polygon(outline)
        assert shape.is_valid
        assert shape.area > 400
        near = cv2.dilate(filled(outline).astype(np.uint8), np.ones((3, 3))) > 0
        assert not (mask & ~near).any()
    assert s.masks.any(axis=(1, 2)).mean() > 0.5


@pytest.mark.parametrize(
    ("world", "switches"),
    [
        (circles, {"others": 0}),
        (beetle, {}),
        (snail, {"clutter": False}),
        (head, {"scene": HeadScene(others=0)}),
    ],
)
def test_masks_of_what_nothing_hides_are_the_filled_outlines(world, switches):
    s = film(world, **switches)
    for mask, outline in zip(s.masks, s.outlines, strict=True):
        pixels = filled(outline)
        assert (mask & pixels).sum() / (mask | pixels).sum() > 0.975
        area = shapely.Polygon(outline).intersection(IMAGE).area
        assert mask.sum() == pytest.approx(area, rel=0.02)


@pytest.mark.parametrize("world", WORLDS)
def test_noise_and_blur_leave_scene_and_truth_alone(world):
    rough, sharp = film(world, frames=3, camera=Camera()), film(world, frames=3)
    np.testing.assert_array_equal(rough.masks, sharp.masks)
    np.testing.assert_array_equal(rough.outlines, sharp.outlines)
    off = np.abs(rough.frames.astype(int) - sharp.frames)
    assert 0.2 < off.mean() < 8


@pytest.mark.parametrize("world", WORLDS)
def test_a_moving_target_is_blurred_by_an_open_shutter(world):
    closed = film(world, frames=3, camera=Camera(0.0, 0.0, 0.0, 8, 0.0))
    open_ = film(world, frames=3, camera=Camera(0.0, 0.0, 1.0, 8, 0.0))
    steps = [
        np.abs(np.diff(s.frames.astype(int), axis=2)).max(axis=2).mean() for s in (closed, open_)
    ]
    assert steps[1] < steps[0]


def test_a_circle_shows_its_colour_and_walks_by_no_more_than_its_step():
    s = film(circles, others=0, frames=40)
    for image, mask, light in zip(s.frames, s.masks, s.light, strict=True):
        assert np.abs(image[mask].mean(axis=0) - shown(light)).max() < 3
    steps = np.linalg.norm(np.diff(s.light ** (1 / 2.2), axis=0), axis=1)
    assert steps.max() <= 0.03 + 1e-6
    assert steps.mean() > 0.01
    assert np.ptp(film(circles, others=0, colour_step=0.0).light, axis=0).max() == 0


def test_colours_of_circles_turn_back_at_the_ends_of_their_range():
    shades = film(circles, seed=2, frames=80, others=0, colour_step=0.3).light ** (1 / 2.2)
    assert 0.12 - 1e-6 <= shades.min() < 0.2
    assert 0.85 < shades.max() <= 0.95 + 1e-6


def test_circles_bounce_within_the_image_and_keep_their_radius():
    s = film(circles, frames=250, others=0)
    assert s.outlines.min() >= 0
    assert s.outlines[..., 0].max() <= WIDTH - 1
    assert s.outlines[..., 1].max() <= HEIGHT - 1
    radii = np.linalg.norm(s.outlines - s.outlines.mean(axis=1, keepdims=True), axis=2)
    assert np.ptp(radii) < 1e-9
    moves = np.linalg.norm(np.diff(s.outlines.mean(axis=1), axis=0), axis=1)
    assert moves.max() <= 3.5 + 1e-9
    assert np.median(moves) > 1.5


def test_circles_pass_before_and_behind_the_target():
    kinds = set()
    for seed in range(3):
        s = film(circles, seed=seed, frames=60, others=6)
        alone = film(circles, seed=seed, frames=60, others=6, colour_step=0.0)
        np.testing.assert_array_equal(s.masks, alone.masks)
        share = s.masks.sum(axis=(1, 2)) / np.array([shapely.Polygon(o).area for o in s.outlines])
        kinds |= {bool(x) for x in share < 0.9}
        assert share.max() == pytest.approx(1, abs=0.02)
    assert kinds == {True, False}


def test_the_light_on_the_rectangle_obeys_inverse_square_and_cosine():
    s = film(rectangle, frames=60)
    for image, mask, light, (a, b, c, d) in zip(s.frames, s.masks, s.light, s.corners, strict=True):
        normal = np.cross(d - a, b - a)
        normal *= -np.sign(normal @ a) / np.linalg.norm(normal)  # towards the camera

        def came(place, normal=normal):
            way = s.lamp - place
            cosine = max(normal @ way, 0) / np.linalg.norm(way)
            return lamp.LAMP_LIGHT * cosine / (way @ way) + lamp.AMBIENT

        centre = (a + b + c + d) / 4
        np.testing.assert_allclose(light, came(centre), rtol=1e-9)
        column, row = np.rint(300 * centre[:2] / centre[2] + (159.5, 119.5)).astype(int)
        ray = np.array([(column - 159.5) / 300, (row - 119.5) / 300, 1])
        met = ray * (normal @ a) / (normal @ ray)
        if mask[row, column]:
            assert np.abs(image[row, column] - shown(lamp.CARD * came(met))).max() <= 1.5
    assert s.masks[:, 1:].any(axis=(1, 2)).all()
    assert s.light[:, 0].max() > 3 * s.light[:, 0].min()


def test_the_rectangle_is_one_seen_through_a_pinhole():
    s = film(rectangle, frames=60)
    sides = np.linalg.norm(np.roll(s.corners, -1, axis=1) - s.corners, axis=2)
    np.testing.assert_allclose(sides, np.tile([0.40, 0.28], (60, 2)))
    np.testing.assert_allclose(
        np.linalg.norm(s.corners[:, 2] - s.corners[:, 0], axis=1), np.hypot(0.40, 0.28)
    )
    seen = 300 * s.corners[..., :2] / s.corners[..., 2:] + (159.5, 119.5)
    for outline, corners in zip(s.outlines, seen, strict=True):
        shape = shapely.Polygon(corners)
        assert shapely.Polygon(outline).symmetric_difference(shape).area < 1e-6 * shape.area


def test_the_rectangle_casts_its_shadow_away_from_the_lamp():
    s = film(rectangle, frames=60)
    foot = 300 * s.lamp[:2] / s.lamp[2] + (159.5, 119.5)
    still = np.median(s.frames, axis=0)
    for image, mask, outline in zip(s.frames[::6], s.masks[::6], s.outlines[::6], strict=True):
        dark = (still - image).max(axis=2) > 25
        rows, columns = np.nonzero(dark & ~(cv2.dilate(mask.astype(np.uint8), np.ones((3, 3))) > 0))
        if len(rows) > 200:
            out = outline.mean(axis=0) - foot
            assert (np.stack([columns, rows], axis=1).mean(axis=0) - outline.mean(axis=0)) @ out > 0


@pytest.mark.parametrize("world", [rectangle, beetle, snail])
def test_steady_light_changes_the_light_and_nothing_else(world):
    steady, changing = film(world, light="steady"), film(world)
    assert np.ptp(steady.light, axis=0).max() < 1e-9
    assert np.ptp(changing.light, axis=0).max() > 0.02
    np.testing.assert_array_equal(steady.outlines, changing.outlines)
    np.testing.assert_array_equal(steady.masks, changing.masks)


def test_the_beetles_body_keeps_its_shape_and_its_legs_step():
    s = film(beetle, frames=30)
    for outline in s.outlines[1:]:
        assert affine_rest(outline, s.outlines[0]) < 1e-9
        spread = [np.linalg.svd(o - o.mean(axis=0))[1] for o in (outline, s.outlines[0])]
        assert spread[0][0] / spread[0][1] == pytest.approx(spread[1][0] / spread[1][1])
    heads = s.outlines[:, 44] - s.outlines.mean(axis=1)
    moves = np.diff(s.outlines.mean(axis=1), axis=0)
    ahead = (heads[1:] * moves).sum(axis=1) / np.linalg.norm(heads[1:], axis=1)
    assert (ahead > 0.9 * np.linalg.norm(moves, axis=1)).all()  # it walks ahead
    assert s.extra.any(axis=(1, 2)).all()


def test_switches_of_the_animals_take_away_what_they_name():
    for world, part, count in ((beetle, "legs", 4), (snail, "neck", 4)):
        bare, whole = film(world, frames=count, **{part: False}), film(world, frames=count)
        assert not bare.extra.any()
        assert whole.extra.any()
        np.testing.assert_array_equal(bare.masks, whole.masks)
        np.testing.assert_array_equal(bare.outlines, whole.outlines)
        off = (bare.frames != whole.frames).any(axis=3)
        assert off[whole.extra].mean() > 0.8
        inner = [cv2.erode(m.astype(np.uint8), np.ones((5, 5))) > 0 for m in whole.masks]
        assert not off[np.array(inner)].any()
        clean = film(world, frames=count, clutter=False)
        np.testing.assert_array_equal(clean.outlines, whole.outlines)
        assert (clean.frames != whole.frames).any()


def test_the_sun_shines_back_from_the_beetle():
    s = film(beetle, light="steady", frames=4)
    for image, mask in zip(s.frames, s.masks, strict=True):
        values = image[cv2.erode(mask.astype(np.uint8), np.ones((5, 5))) > 0].astype(float)
        bright = values[values.sum(axis=1) > np.quantile(values.sum(axis=1), 0.995)].mean(axis=0)
        body = np.median(values, axis=0)
        assert bright.sum() > 1.6 * body.sum()
        assert bright[0] / bright[2] < 0.7 * body[0] / body[2]  # the sun's colour, not the body's


def test_the_shell_deforms_by_affine_maps_only():
    s = film(snail, frames=40)
    assert max(affine_rest(outline, s.outlines[0]) for outline in s.outlines) < 1e-9
    areas = np.array([shapely.Polygon(o).area for o in s.outlines])
    ratios = []
    for outline in s.outlines:
        long, short = np.linalg.svd(outline - outline.mean(axis=0))[1]
        ratios.append(long / short)
    assert np.ptp(areas) > 0.03 * areas.mean()
    assert np.ptp(ratios) > 0.03


def test_the_neck_stretches_and_contracts_in_the_colours_of_the_shell():
    s = film(snail, frames=60, clutter=False, light="steady")
    reaches = []
    for extra, mask, outline in zip(s.extra, s.masks, s.outlines, strict=True):
        away = np.argwhere(extra)[:, ::-1] - outline.mean(axis=0)
        reaches.append(np.linalg.norm(away, axis=1).max() / np.sqrt(mask.sum()))
    assert max(reaches) > 1.25 * min(reaches)
    found = [np.unique(s.frames[0][m] // 32, axis=0) for m in (s.masks[0], s.extra[0])]
    shell = {tuple(colour) for colour in found[0]}
    assert np.mean([tuple(colour) in shell for colour in s.frames[0][s.extra[0]] // 32]) > 0.5


def test_leaves_lie_over_the_path_of_the_snail():
    shares = []
    for seed in range(4):
        s = film(snail, seed=seed, frames=2)
        shares += [
            m.sum() / shapely.Polygon(o).area for m, o in zip(s.masks, s.outlines, strict=True)
        ]
    assert min(shares) < 0.97
    assert min(shares) > 0.4


@cache
def turning():
    return film(head, frames=60, scene=HeadScene(others=0, light="steady"))


def test_the_heads_ellipse_bounds_its_mask_and_its_outline():
    s = turning()
    for mask, outline, (u, v, a, b) in zip(s.masks, s.outlines, s.ellipses, strict=True):
        rows, columns = np.nonzero(mask)
        assert [columns.min(), columns.max()] == pytest.approx([u - a, u + a], abs=1.5)
        assert [rows.min(), rows.max()] == pytest.approx([v - b, v + b], abs=1.5)
        assert np.abs(outline - (u, v)).max(axis=0) == pytest.approx([a, b], rel=0.005)


def test_the_heads_size_follows_its_depth():
    s = turning()
    upright = np.abs(s.tilt) < 0.1
    assert upright.sum() > 5
    np.testing.assert_allclose(s.ellipses[upright, 3], 300 * 0.118 / s.depth[upright], rtol=0.02)
    front = upright & (np.abs(s.yaw) < 0.3)
    np.testing.assert_allclose(s.ellipses[front, 2], 300 * 0.076 / s.depth[front], rtol=0.05)


def test_a_tilted_head_leans_its_outline():
    s = turning()
    k = int(np.argmax(np.abs(s.tilt)))
    offsets = s.outlines[k] - s.ellipses[k, :2]
    _, axes = np.linalg.eigh(offsets.T @ offsets)
    long = axes[:, 1] * -np.sign(axes[1, 1])  # upwards in the image
    assert np.arctan2(long[0], -long[1]) == pytest.approx(s.tilt[k], abs=0.06)


def test_a_tilted_head_leans_away_from_its_neck():
    s = turning()
    k = int(np.argmax(np.abs(s.tilt)))
    u, v, _, b = s.ellipses[k]
    rows, columns = np.nonzero(s.extra[k])
    below = (rows > v + 0.95 * b) & (rows < v + 1.2 * b)
    assert (columns[below].mean() - u) * np.sign(s.tilt[k]) < -3


def test_from_behind_a_head_is_hair():
    s = turning()
    behind, front = int(np.argmax(np.abs(s.yaw))), int(np.argmin(np.abs(s.yaw)))
    assert abs(s.yaw[behind]) > 2.8
    assert abs(s.yaw[front]) < 0.2
    colours = [np.median(s.frames[k][s.masks[k]], axis=0) for k in (behind, front)]
    assert colours[0].sum() < 0.6 * colours[1].sum()


def test_switches_of_the_head():
    still = film(head, scene=HeadScene(turns=False, tilts=False, moves=False, others=0))
    assert np.ptp(still.depth) == 0
    assert np.ptp(still.ellipses[:, :2], axis=0).max() < 0.3  # it looks about
    assert not still.tilt.any()
    assert np.abs(still.yaw).max() <= 0.6
    steady = film(head, scene=HeadScene(light="steady"))
    assert np.ptp(steady.light, axis=0).max() == 0
    np.testing.assert_array_equal(steady.masks, film(head).masks)
    assert np.ptp(film(head).light, axis=0).max() > 0.02
    dark = film(head, scene=HeadScene(light="steady", lamp=0.0))
    np.testing.assert_allclose(dark.light, 0.8, rtol=1e-6)


def test_the_lamp_lights_the_head_from_its_side():
    scene = HeadScene("steady", 0, False, False, False, 0.8)
    s = film(head, frames=1, scene=scene)
    left = s.masks[0] & (np.arange(WIDTH) < s.ellipses[0, 0])
    grey = s.frames[0].sum(axis=2)
    assert grey[left].mean() > 1.15 * grey[s.masks[0] & ~left].mean()


def test_a_white_lamp_lights_as_the_other_one_and_has_no_colour():
    white, warm = (film(head, scene=HeadScene(light=name)) for name in ("white", "steady"))
    assert np.ptp(white.light, axis=0).max() == 0
    assert np.ptp(white.light[0]) == 0
    assert white.light[0, 0] == warm.light[0, 0]
    assert np.ptp(warm.light[0]) > 0.1


def test_who_sweats_shines_more_and_more_and_nobody_and_nothing_else_does():
    dry, wet = (
        film(head, frames=30, scene=HeadScene("white", 1, True, True, True, 0.55, sweats))
        for sweats in (0.0, 300.0)
    )
    np.testing.assert_array_equal(wet.frames[0], dry.frames[0])
    np.testing.assert_array_equal(wet.masks, dry.masks)
    more = wet.frames.astype(int) - dry.frames
    assert more.min() >= 0
    skin = wet.masks | wet.extra
    assert (more.any(axis=3) <= skin).all()
    shining = [np.sort(one[mask].mean(axis=1))[-20:].mean() for one, mask in zip(
        more[[9, 19, 29]], wet.masks[[9, 19, 29]], strict=True)]  # fmt: skip
    assert shining == sorted(shining)
    assert shining[0] > 10
    light = [255 * (one[29] / 255.0) ** 2.2 for one in (dry.frames, wet.frames)]
    added = (light[1] - light[0])[more[29].sum(axis=2) > 90]
    whole = added[(wet.frames[29][more[29].sum(axis=2) > 90] < 250).all(axis=1)]
    assert np.ptp(whole.mean(axis=0)) < 0.2 * whole.mean()  # a white lamp adds white


def test_one_passes_before_the_head_and_the_next_behind_it():
    alone = film(head, frames=60, scene=HeadScene(others=0))
    passed = film(head, frames=60, scene=HeadScene(others=1))
    np.testing.assert_allclose(alone.visible, 1, atol=0.03)
    assert passed.visible.min() < 0.5
    assert passed.visible.max() > 0.95
    np.testing.assert_array_equal(passed.outlines, alone.outlines)
    assert not (passed.masks & ~alone.masks).any()
    both = film(head, frames=60, scene=HeadScene(others=2))
    changed = (both.frames != film(head, frames=60, scene=HeadScene(others=0)).frames).any(axis=3)
    assert changed[30:].any(axis=(1, 2)).sum() > 10  # the second comes in the second half

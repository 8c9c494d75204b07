"""Snakes: exact affine motions, least squares, the line-by-line version, shapes that are found."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.appearance import affine_snake as snakes
from robot_perception.appearance.segmentation import boundary, dilate, filled
from tests.appearance.shapes import MIDDLE, SHAPE, edges_of, overlap, pear, turned
from tests.unchecked import unchecked

seeds = st.integers(0, 10**6)


def starts(seed, count=12):
    """Yield starts of a pear that are off by 8 px, 15 % and 15 degrees in all directions."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        matrix = turned(rng.choice([-15, 15]), rng.choice([0.85, 1.15]))
        toward = rng.uniform(0, 2 * np.pi)
        off = 8 * np.array([np.cos(toward), np.sin(toward)])
        yield matrix, pear() @ matrix.T + MIDDLE + off


def hidden(toward, width):
    """Return what lies in a sector round the middle of the image."""
    v, u = np.indices(SHAPE)
    away = np.arctan2(v - MIDDLE[1], u - MIDDLE[0]) - toward
    return np.abs((away + np.pi) % (2 * np.pi) - np.pi) < width / 2


@settings(deadline=None)
@given(seeds)
def test_affine_part_finds_a_known_map(seed):
    rng = np.random.default_rng(seed)
    start = pear() + MIDDLE
    matrix, shift = np.eye(2) + rng.uniform(-0.5, 0.5, (2, 2)), rng.uniform(-50, 50, 2)
    outline = (start - start.mean(axis=0)) @ matrix.T + start.mean(axis=0) + shift
    found, nearest = snakes.affine_part(start, outline)
    np.testing.assert_allclose(found.matrix, matrix, atol=1e-9)
    np.testing.assert_allclose(found.shift, shift, atol=1e-9)
    np.testing.assert_allclose(nearest, outline, atol=1e-9)
    np.testing.assert_allclose(found.apply(start), nearest, atol=1e-9)


@settings(deadline=None)
@given(seeds)
def test_affine_part_is_that_of_numpys_least_squares(seed):
    rng = np.random.default_rng(seed)
    start, outline = np.add(rng.normal(0, 20, (2, 30, 2)), [[[1e4, 50.0]], [[40.0, 1e4]]])
    _, nearest = snakes.affine_part(start, outline)
    basis = np.hstack([np.ones((30, 1)), start - start.mean(axis=0)])
    expected = basis @ np.linalg.lstsq(basis, outline, rcond=None)[0]
    np.testing.assert_allclose(nearest, expected, atol=1e-7)


def test_area_is_that_of_closed_forms_whichever_way_round():
    t = 2 * np.pi * np.arange(1000) / 1000
    ellipse = np.stack([30 * np.cos(t) + 500, 20 * np.sin(t) - 80], axis=-1)
    assert snakes.area(ellipse) == pytest.approx(np.pi * 600, rel=1e-4)
    assert snakes.area(ellipse[::-1]) == pytest.approx(snakes.area(ellipse))
    assert snakes.area(np.array([[0.0, 0], [4, 0], [0, 3]])) == pytest.approx(6)


def test_area_is_the_number_of_pixels_inside():
    outline = pear() + MIDDLE
    assert snakes.area(outline) == pytest.approx(filled(outline, SHAPE).sum(), rel=0.01)


def test_resampled_points_are_evenly_spaced_on_the_outline():
    square = np.array([[0.0, 0], [8, 0], [8, 8], [0, 8]])
    expected = [[0, 0], [4, 0], [8, 0], [8, 4], [8, 8], [4, 8], [0, 8], [0, 4]]
    np.testing.assert_allclose(snakes.resample(square, 8), expected, atol=1e-12)
    with pytest.raises(ValueError, match="outline must not lie on a line"):
        snakes.resample(np.array([[0.0, 0], [1, 1], [2, 2]]))


@pytest.mark.parametrize("affine", [True, False])
def test_compiled_and_line_by_line_take_the_same_steps(affine):
    rng = np.random.default_rng(3)
    fit = snakes.affine_snake if affine else snakes.free_snake
    clear = edges_of(pear() + MIDDLE)
    noisy = clear | (rng.random(SHAPE) < 0.002)  # where rounding grows with each step
    few = snakes.SnakeRules(2.0, 5.0, 1.5, (12.0, 12.0), 5)
    for _, start in starts(3, 4):
        for edges, rules in ((clear, snakes.SnakeRules()), (noisy, few)):
            for begin in (start, np.add(start, [0, 100])):  # beyond the frame, too
                slow = snakes.step_by_step(begin, edges, rules, affine=affine)
                quick = fit(begin, edges, rules)
                assert quick.iterates.shape == (rules.steps + 1, 80, 2)
                np.testing.assert_allclose(quick.iterates, slow.iterates, atol=1e-7)
                np.testing.assert_allclose(quick.affine.matrix, slow.affine.matrix, atol=1e-8)
                assert quick.residual == pytest.approx(slow.residual, abs=1e-7)


@settings(deadline=None)
@given(st.integers(0, 39), st.integers(0, 59), st.floats(1.5, 12.0), seeds)
def test_edges_pull_as_far_as_they_reach_wherever_they_are(v, u, reach, seed):
    edges = np.zeros((40, 60), dtype=bool)
    edges[v : v + 3, u : u + 2] = True
    rules = snakes.SnakeRules(0.0, 0.0, 1.0, (reach, reach), 1)
    # points all about the reach away, so that some are pulled and some are not
    start = np.add(np.random.default_rng(seed).uniform(-reach - 3, reach + 3, (40, 2)), [u, v])
    slow = snakes.step_by_step(start, edges, rules, affine=False).outline
    quick = snakes.free_snake(start, edges, rules).outline
    np.testing.assert_allclose(quick, slow, atol=1e-9)


@pytest.mark.parametrize("rule", [snakes.affine_snake, snakes.free_snake])
def test_a_shape_is_found_from_starts_that_are_off(rule):
    there = pear() + MIDDLE
    for _, start in starts(5):
        found = rule(start, edges_of(there))
        assert overlap(start, there) < 0.9
        assert overlap(found.outline, there) > 0.97
        assert snakes.area(found.outline) == pytest.approx(snakes.area(there), rel=0.02)


def test_the_affine_parameters_are_those_of_the_motion():
    for matrix, start in starts(6):
        found = snakes.affine_snake(start, edges_of(pear() + MIDDLE), snakes.SnakeRules(steps=200))
        np.testing.assert_allclose(found.affine.matrix, np.linalg.inv(matrix), atol=0.03)
        np.testing.assert_allclose(found.affine.shift, MIDDLE - start.mean(axis=0), atol=0.7)


def test_an_affine_snake_stays_in_the_family_and_a_free_one_leaves_it():
    bumpy = edges_of(pear() + MIDDLE) | boundary(filled(pear(lobes=0) * 0.4 + [210, 120], SHAPE))
    for _, start in starts(7, 5):
        kept = snakes.affine_snake(start, bumpy)
        for outline in kept.iterates[[1, 10, -1]]:
            _, nearest = snakes.affine_part(start, outline)
            np.testing.assert_allclose(outline, nearest, atol=1e-8)
        assert kept.residual < 1e-8
        assert snakes.free_snake(start, bumpy).residual > 0.5


def test_a_hidden_quarter_of_the_edge_leaves_the_affine_snake_in_place():
    there = pear() + MIDDLE
    for k, (_, start) in enumerate(starts(8)):
        part = edges_of(there) & ~hidden(2 * np.pi * k / 12, np.pi / 2)
        assert overlap(snakes.affine_snake(start, part).outline, there) > 0.85


def test_a_snake_at_rest_stays():
    there = pear() + MIDDLE
    loose = snakes.SnakeRules(elasticity=0, rigidity=0)
    for rule in (snakes.affine_snake, snakes.free_snake):
        found = rule(there, edges_of(there), loose)
        assert np.abs(found.outline - there).max() < 0.7


def test_edges_beyond_reach_pull_nothing():
    far = np.zeros(SHAPE, dtype=bool)
    far[:, 5] = True
    start = pear() * 0.5 + MIDDLE
    still = snakes.SnakeRules(elasticity=0, rigidity=0)
    for rule in (snakes.affine_snake, snakes.free_snake):
        np.testing.assert_allclose(rule(start, far, still).outline, start, atol=1e-8)


def test_on_the_edges_of_one_pixel_a_snake_shrinks_to_something_finite():
    pixel = np.zeros(SHAPE, dtype=bool)
    pixel[125, 165] = True
    for rule in (snakes.affine_snake, snakes.free_snake):
        found = rule(pear() + MIDDLE, boundary(pixel), snakes.SnakeRules(reach=(60.0, 60.0)))
        assert np.isfinite(found.iterates).all()
        assert snakes.area(found.outline) < 0.3 * snakes.area(pear())


def test_elasticity_alone_shrinks_a_circle_by_its_first_eigenvalue():
    t = 2 * np.pi * np.arange(60) / 60
    circle = np.stack([30 * np.cos(t), 30 * np.sin(t)], axis=-1) + MIDDLE
    far = np.zeros(SHAPE, dtype=bool)
    far[0, 0] = True
    rules = snakes.SnakeRules(elasticity=8.0, rigidity=3.0, damping=1.2, steps=5)
    wave = 2 - 2 * np.cos(2 * np.pi / 60)
    factor = (1.2 / (1.2 + 8 * wave + 3 * wave**2)) ** 5
    for rule in (snakes.affine_snake, snakes.free_snake):
        shrunk = rule(circle, far, rules).outline
        np.testing.assert_allclose(shrunk - MIDDLE, factor * (circle - MIDDLE), atol=1e-9)


def test_stiff_snakes_of_other_scale_and_place_move_alike():
    start, there = next(starts(9))[1], pear() + MIDDLE
    once = snakes.affine_snake(start, edges_of(there)).outline
    by = np.array([7, -5])
    moved = snakes.affine_snake(start + by, edges_of(there + by)).outline
    np.testing.assert_allclose(moved, once + by, atol=1e-3)


def test_image_edges_are_ridges_of_the_gradient_in_the_mask_alone():
    inside = filled(pear() + MIDDLE, SHAPE)
    image = np.where(inside[..., None], [180, 90, 40], [60, 90, 140]).astype(np.uint8)
    image[:, 20] = 255  # a brighter line elsewhere
    band = dilate(boundary(inside), 3)
    found = snakes.image_edges(image, band, 0.3)
    assert found.sum() > 150
    assert snakes.image_edges(image, band, 0.8).sum() > 100  # of what is in the mask
    assert not (found & ~band).any()
    assert not (found & ~boundary(inside, 2)).any()  # the rim of the mask makes no edges
    grey = snakes.image_edges(image[..., 0].copy(), band, 0.3)
    assert (grey & ~boundary(inside, 2)).sum() == 0 < grey.sum()
    assert not snakes.image_edges(np.full_like(image, 9), band, 0.3).any()


def test_weak_edges_are_left_out_by_their_share_of_the_strongest():
    image = np.zeros((40, 60), dtype=np.uint8)
    image[:, 20:] = 40
    image[:, 40:] = 240
    everywhere = np.ones(image.shape, dtype=bool)
    strong, both = (snakes.image_edges(image, everywhere, share) for share in (0.5, 0.1))
    assert not strong[:, :30].any()
    assert strong[5:-5, 38:42].any(axis=1).all()
    assert both[5:-5, 18:22].any(axis=1).all()


def test_an_image_edge_leads_the_snake_to_the_outline():
    there = pear() + MIDDLE
    inside = filled(there, SHAPE)
    image = np.where(inside[..., None], [180, 90, 40], [60, 90, 140]).astype(np.uint8)
    ridges = snakes.image_edges(image, dilate(boundary(inside), 4), 0.3)
    for _, start in starts(11, 5):
        assert overlap(snakes.affine_snake(start, ridges).outline, there) > 0.96


def test_bad_input_is_named():
    start, edges = pear() + MIDDLE, edges_of(pear() + MIDDLE)
    with unchecked():
        for rule in (snakes.affine_snake, snakes.free_snake, snakes.step_by_step):
            with pytest.raises(ValueError, match="edges must hold an edge, got none"):
                rule(start, np.zeros(SHAPE, dtype=bool))
            with pytest.raises(ValueError, match="start must not lie on a line"):
                rule(np.stack([np.arange(9.0), 2 * np.arange(9.0)], axis=-1), edges)
            with pytest.raises(ValueError, match="start must be finite"):
                rule(np.where(start > 200, np.nan, start), edges)
            with pytest.raises(TypeError, match="edges must be an array of True and False"):
                rule(start, edges.astype(float))
        with pytest.raises(ValueError, match=r"reach must fall.*got \(3.0, 9.0\)"):
            snakes.SnakeRules(reach=(3.0, 9.0))
        with pytest.raises(ValueError, match=r"damping must be from 0\.55"):
            snakes.SnakeRules(damping=0.5)
        with pytest.raises(TypeError, match="image must hold bytes"):
            snakes.image_edges(np.zeros(SHAPE), edges, 0.3)
        with pytest.raises(ValueError, match="image must be as large as within"):
            snakes.image_edges(np.zeros((9, 9), dtype=np.uint8), edges, 0.3)

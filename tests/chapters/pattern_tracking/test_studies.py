"""The studies: worlds, rivals, and what they count, by law."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.ceiling.patterns import deviations
from robot_perception.ceiling.tracker import Layers, log_likelihoods
from robot_perception.chapters.pattern_tracking import (
    displacement,
    hidden,
    light,
    scales,
    slopes,
    sweeps,
)
from robot_perception.chapters.pattern_tracking.rivals import METHODS, Task
from robot_perception.chapters.pattern_tracking.scene import (
    RULES,
    SCORED,
    SIGMAS,
    START,
    errors,
    moved,
    path,
    scene,
    seen,
)

RNG = np.random.default_rng


def test_errors_are_in_sigmas_and_angles_go_round():
    off = errors(np.array([5.0, 0.0, 2 * np.pi, 1.2]), np.array([0.0, 10.0, 0.0, 1.0]))
    np.testing.assert_allclose(off, [1, -2, 0, 2], atol=1e-9)


def test_a_patch_moves_by_so_many_sigmas():
    for k, name in enumerate(("x", "y", "θ", "s")):
        away = (moved(name, 2.0) - START) / SIGMAS
        np.testing.assert_allclose(away, 2.0 * (np.arange(4) == k))


def test_paths_begin_at_the_start_and_step_by_half_a_sigma():
    steps = [np.diff(path(400, RNG(k)), axis=0) / SIGMAS for k in range(20)]
    assert all((path(10, RNG(k))[0] == START).all() for k in range(3))
    rms = np.sqrt(np.mean(np.square(steps), axis=(0, 1)))
    np.testing.assert_allclose(rms, [0.5, 0.5, 0.5, 0.25], rtol=0.05)
    assert np.abs(steps).max() < 0.8


@pytest.mark.parametrize("name", METHODS)
def test_everybody_finds_a_patch_that_has_hardly_moved(name):
    one = scene(SCORED[0])
    truth = START + SIGMAS * [0.3, -0.2, 0.1, 0.1]
    given = Task(
        one.pattern(),
        seen(one.picture(START), RNG(1)),
        tuple(seen(one.picture(truth), RNG(k)) for k in (2, 3, 4)),
    )
    assert np.abs(errors(METHODS[name](given, RNG(0)), truth)).mean() < 0.5


def test_windows_are_turned_and_scaled_as_the_patch_is():
    """In steps of 0.7 σ: this one is on the raster."""
    one, truth = scene(SCORED[2]), START + SIGMAS * [0, 0, 2.1, 1.4]
    given = Task(one.pattern(), one.picture(START), (one.picture(truth),))
    off = errors(METHODS["template matching"](given, RNG(0)), truth)
    np.testing.assert_allclose(off, 0, atol=0.11)  # half a pixel


def test_nearest_draw_is_that_of_the_normal_distribution():
    config = displacement.Config(tuple(range(40)), (0.0, 3.0), ("one picture",))
    found = displacement.nearest(config, rng=RNG(0))
    assert found.typical("one picture", 0.0).estimate < 0.4
    assert 0.5 < found.typical("one picture", 3.0).estimate < 1.0


def test_a_cover_hides_its_share_of_the_window_from_its_side():
    image, other = np.zeros((240, 320), np.uint8), np.full((240, 320), 255, np.uint8)
    for side, (u, v) in enumerate(((186, 120), (160, 146), (134, 120), (160, 94))):
        for share in (0.3, 0.6):
            covered = hidden.cover(image, other, START, share, side)
            window = covered[88:152, 128:192]
            assert (window > 0).mean() == pytest.approx(share, abs=0.03)
            assert covered[v, u] == 255
    np.testing.assert_array_equal(hidden.cover(image, other, START, 0.0, 0), image)


def test_a_turned_pattern_is_covered_along_its_own_side():
    image, other = np.zeros((240, 320), np.uint8), np.full((240, 320), 255, np.uint8)
    turned = START + np.array([0, 0, np.pi / 2, 0])
    covered = hidden.cover(image, other, turned, 0.5, 0)
    np.testing.assert_array_equal(covered[150, 150:170], 255)  # its right is below now
    np.testing.assert_array_equal(covered[95, 150:170], 0)


def test_modes_are_peaks_above_half_the_height():
    surface = np.zeros((40, 40))
    for v, u, height in ((5, 5, 1.0), (20, 30, 0.6), (20, 31, 0.55), (30, 8, 0.4)):
        surface[v, u] = height
    assert sweeps.modes(surface) == 2


def test_a_plain_ground_has_nothing_but_the_patch():
    config = sweeps.Config(cluttered=False)
    assert np.ptp(sweeps.ground(SCORED[0], config).ground) == 0
    assert np.ptp(sweeps.ground(SCORED[0], sweeps.Config()).ground) > 100


def test_the_likelihoods_are_highest_at_the_true_place():
    for surface in sweeps.surfaces(SCORED[5], sweeps.Config(), RNG(0)):
        v, u = np.unravel_index(surface.argmax(), surface.shape)
        assert np.abs(np.array([u, v]) - 30).max() <= 2


def test_with_all_slopes_scaled_one_for_all_is_their_mean_times_that():
    one, own = (slopes.KINDS[name] for name in ("one for all", "each its own"))
    shared, each = slopes.kind_of(SCORED[0], one, 3.0), slopes.kind_of(SCORED[0], own, 3.0)
    np.testing.assert_array_equal(shared.places, each.places)
    np.testing.assert_allclose(shared.decay.rate, 3 * each.decay.rate.mean())


def test_a_sharp_model_stands_in_for_the_smoothed_one():
    config = replace(scales.growing.quick, seeds=SCORED[:2], scales=(1.5,))
    found = scales.sharp(config, rng=RNG(0))
    np.testing.assert_array_equal(found.unlike[3:], found.unlike[:2])


def test_shared_names_hold_what_is_bare():
    config = hidden.Config(SCORED[:2], (0.0, 0.45), 100, 1)
    found = hidden.bare(config, rng=RNG(0))
    np.testing.assert_array_equal(found.off[..., 0], found.off[..., 1])
    assert found.off.shape == (3, 2, 1, 2)


def test_the_first_vectors_are_those_of_a_product_up_to_there():
    pattern, rules = scene(SCORED[0]).pattern(), replace(RULES, tolerated=0.0)
    layers = Layers(scene(SCORED[0]).picture(moved("x", 1.0)))
    part = light.first(pattern, 60)
    found = log_likelihoods(layers.correlations(part, START[None], "none"), part.decay, rules)
    lost = deviations(layers.correlations(pattern, START[None], "none")[0], pattern.decay)
    assert found[0] == pytest.approx(-(lost[:60] ** 2).sum() / (2 * rules.deviation**2))
    np.testing.assert_array_equal(light.first(pattern, 10**4).places, pattern.places)


def test_where_the_products_are_one_their_errors_are_too():
    few = len(scene(SCORED[0]).pattern().places)
    printed, right = light.track(SCORED[0], few, RNG(0))
    assert printed == right < 0.5

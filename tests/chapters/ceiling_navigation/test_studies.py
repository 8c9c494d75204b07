"""Studies of the chapter: laws of what is measured, and of what is measured with."""

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest

from data_synth.ceiling import Mount, taught_path
from robot_perception.ceiling.mosaic import Links, Mosaic
from robot_perception.chapters.ceiling_navigation import (
    chaining,
    correcting,
    key_images,
    mapping_run,
    posing,
    replaying,
    replays,
    runs,
    scene,
    upto_scale,
    world,
)
from robot_perception.geometry import se2, wrap_angle

# Exact sightings ---------------------------------------------------------------------------------


def test_a_sighting_is_where_the_pattern_is_in_the_robots_frame():
    pose, there = np.array([0.4, -0.2, 0.7]), {"a": np.array([1.0, 0.3, -0.5])}
    found = world.seen(world.looking(), pose, there)["a"]
    way = se2.between(pose, there["a"])
    np.testing.assert_allclose(found[:2], way[:2] * 80 + [159.5, 119.5], atol=1e-9)
    assert found[2] == pytest.approx(way[2])
    assert found[3] == pytest.approx(1)


def test_patterns_near_the_border_and_beyond_it_are_not_seen():
    there = {str(k): np.array([x, 0.0, 0.0]) for k, x in enumerate((0.0, 1.6, 1.63, 3.0))}
    view = world.seen(world.looking(), np.zeros(3), there, border=30.0)
    assert set(view) == {"0", "1"}  # (320 / 2 - 0.5 - 30) px are 1.61875 m
    assert set(world.seen(world.looking(), np.zeros(3), there)) == {"0", "1", "2", "3"}
    assert world.seen(world.looking(), np.zeros(3), {}) == {}


def test_what_a_camera_sees_of_the_ceiling_is_half_its_picture_wide():
    np.testing.assert_allclose(world.HALF, [159.5 / 80, 119.5 / 80])


# Eq. (1) -----------------------------------------------------------------------------------------


def test_corrected_pixels_are_those_of_a_camera_in_the_robots_frame():
    mount, pose = Mount(roll=0.1, pitch=-0.05, yaw=0.3, x=0.2, y=-0.1), np.array([0.5, 0.1, 1.0])
    points = pose[:2] + np.random.default_rng(0).uniform(-1, 1, (5, 2))
    seen = world.looking(roll=0.1, pitch=-0.05, yaw=0.3, x=0.2, y=-0.1).points_seen(pose, points)
    ideal = world.looking().points_seen(pose, points)
    down = correcting.corrected(seen, mount, correcting.TO_ROBOT)
    np.testing.assert_allclose(down, ideal, atol=1e-9)
    assert np.abs(correcting.corrected(seen, mount, correcting.UPWARDS) - ideal).max() > 5


def test_the_wrong_normal_corrects_for_the_opposite_displacement():
    """Without a tilt each moves all points alike, twice the displacement apart."""
    mount = Mount(x=0.25)
    image = np.array([[100.0, 80.0], [200.0, 150.0]])
    down, up = (
        correcting.corrected(image, mount, n) for n in (correcting.TO_ROBOT, correcting.UPWARDS)
    )
    np.testing.assert_allclose(down - up, [[2 * 0.25 * 80, 0.0]] * 2, atol=1e-9)


def test_the_picture_of_the_page_is_right_after_its_correction():
    found = correcting.pictures()
    assert found.off(found.ideal) == 0
    assert found.off(found.corrected) < 5 < found.off(found.raw)
    assert 0.5 < found.seen.mean() < 1


# Eq. (2) -----------------------------------------------------------------------------------------


def test_noise_follows_its_law_near_and_far():
    found = posing.run(posing.Config(poses=1500), rng=np.random.default_rng(1))
    for distance, errors in ((posing.NEAR, found.near), (posing.FAR, found.far)):
        rms = np.sqrt((errors**2).sum(axis=1).mean())
        assert rms == pytest.approx(posing.expected(distance), rel=0.08)
    assert posing.expected(0.0) == pytest.approx(np.sqrt(2) * 0.0125)


# The quotient ------------------------------------------------------------------------------------


def test_readings_are_the_four_products_of_matrices():
    def matrix(pose):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0, 0, 1]])

    A, B = np.array([3.0, 1.0, 0.4, 1.0]), np.array([-2.0, 5.0, -1.1, 1.0])
    a, b = matrix(A), matrix(B)
    inverse = np.linalg.inv
    products = {
        chaining.PRINTED: a @ inverse(b),
        chaining.UNDER: inverse(b) @ a,
        chaining.OVER: b @ inverse(a),
        chaining.RIGHT: inverse(a) @ b,
    }
    for name, product in products.items():
        np.testing.assert_allclose(matrix(chaining.READINGS[name](A, B)), product, atol=1e-12)


def test_a_new_pattern_is_placed_where_it_is():
    robot = np.array([0.3, 0.2, 1.0])
    np.testing.assert_allclose(
        chaining.placed(robot, scene.PAIR, chaining.RIGHT), scene.PAIR[1], atol=1e-12
    )


# Up to scale -------------------------------------------------------------------------------------


def test_one_direction_is_unknown_without_the_scale_and_none_with_it():
    for poses, patterns in ((3, 2), (6, 4)):
        assert upto_scale.unknown(known=False, poses=poses, patterns=patterns) == 1
        assert upto_scale.unknown(known=True, poses=poses, patterns=patterns) == 0


def test_arrived_is_near_and_turned_little():
    ends = np.array([[0.04, 0.0, 0.2], [0.0, 0.06, 0.0], [0.0, 0.0, -0.3], [0.01, 0.01, -0.1]])
    assert upto_scale.arrived(ends) == 0.5
    assert upto_scale.arrived(ends + np.array([0, 0, 2 * np.pi])) == 0.5


def test_a_robot_does_not_depend_on_the_scale_where_it_ends():
    start = np.array([-1.2, 0.2, -0.1])
    for factor in (0.5, 1.0, 1.5):
        end = upto_scale.approach(start, factor, upto_scale.Config())[-1]
        assert np.hypot(*end[:2]) <= upto_scale.STOP + 1e-9


def test_headings_fall_as_the_law_says():
    """With a small angle, from 1 m on: the smaller root of the linear law, as a power of ρ."""
    rules = replace(upto_scale.SERVO, gain_distance=0.3, gain_bearing=1.5, gain_heading=-0.7)
    assert upto_scale.heading_exponent(rules) == pytest.approx(0.71, abs=0.01)
    config = upto_scale.Config(step=0.02)
    path = upto_scale.approach(np.array([-1.5, 0.0, 0.05]), 1.0, config, rules)
    rho, heading = np.hypot(*path[:, :2].T), np.abs(path[:, 2])
    k = [int(np.argmax(rho < d)) for d in (0.05, 0.005)]
    slope = np.log(heading[k[0]] / heading[k[1]]) / np.log(rho[k[0]] / rho[k[1]])
    assert slope == pytest.approx(0.71, abs=0.05)


def test_a_changed_tilt_moves_the_end_by_z_times_its_tangent():
    config = upto_scale.Config(tilt=upto_scale.EPSILON)
    end = upto_scale.approach(np.array([-1.5, 0.0, 0.0]), 1.0, config)[-1]
    assert np.hypot(*end[:2]) == pytest.approx(2.5 * np.tan(np.deg2rad(2)), rel=0.1)
    steady = replace(config, tilt=0.0, always=upto_scale.EPSILON)
    end = upto_scale.approach(np.array([-1.5, 0.0, 0.0]), 1.0, steady)[-1]
    assert np.hypot(*end[:2]) < 0.01


# Key images --------------------------------------------------------------------------------------


def test_the_circle_is_a_circle_between_straight_pieces():
    path = key_images.taught("circle")
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert steps.max() < 0.0501
    assert steps.sum() == pytest.approx(3 + 1.5 * np.pi, abs=0.05)
    assert path[:, 1].max() == pytest.approx(1.5, abs=0.01)
    assert path[-1, 1] == pytest.approx(0, abs=0.1)


def test_broken_conditions_are_broken_and_kept_ones_kept():
    images = [
        world.seen(world.looking(), pose, scene.THERE, world.BORDER)
        for pose in key_images.taught("slalom")
    ]
    turn = np.deg2rad(15)
    for way in key_images.WAYS:
        picked = key_images.chosen(images, way, turn)
        assert picked[0] == 0
        assert picked[-1] == len(images) - 1
        shared = [images[a].keys() & images[b].keys() for a, b in pairwise(picked)]
        least = min(len(names) for names in shared)
        if way == key_images.NO_COMMON:
            assert {len(names) for names in shared[:-1]} == {0}
        else:
            assert least >= (2 if way == key_images.TWO else 1)
            turned = max(
                abs(wrap_angle(images[a][n][2] - images[b][n][2]))
                for (a, b), names in zip(pairwise(picked), shared, strict=True)
                for n in names
            )
            assert (turned >= turn) == (way == key_images.NO_TURN)


def test_two_patterns_in_common_are_asked_for_where_one_would_reach_farther():
    images = [dict.fromkeys(names, np.array([0.0, 0.0, 0.0, 1.0])) for names in ("ab", "abc", "bc")]
    assert key_images.chosen(images, key_images.BOTH, 0.26) == (0, 2)
    assert key_images.chosen(images, key_images.TWO, 0.26) == (0, 1, 2)


def test_there_is_a_pattern_in_each_cell_of_the_grid():
    there = np.array([*key_images.patterns(1.0, rng=np.random.default_rng(3)).values()])
    assert len(there) == 144
    assert len(np.unique(np.round(there[:, :2]), axis=0)) > 100
    cells = np.floor(there[:, :2] + 0.5)
    assert len(np.unique(cells, axis=0)) == 144


def test_distance_of_paths_is_from_either_to_the_other():
    one = np.column_stack([np.linspace(0, 4, 41), np.zeros((41, 2))])
    assert key_images.far(one, one) == 0
    assert key_images.far(one, one + np.array([0, 0.2, 0])) == pytest.approx(0.2)
    assert key_images.far(one, one[:31]) == pytest.approx(1.0)  # one that stops early
    assert key_images.far(one[:31], one) == pytest.approx(1.0)
    beside = one.copy()
    beside[:5, 1] = 0.5  # at the start it may be
    assert key_images.far(one, beside) == 0


def test_steering_by_the_mosaic_needs_no_common_pattern():
    images = [
        world.seen(world.looking(), pose, scene.THERE, world.BORDER)
        for pose in key_images.taught("corner")
    ]
    route = [
        key_images.KeyImage(images[k])
        for k in key_images.chosen(images, key_images.NO_COMMON, 0.26)
    ]
    start = key_images.taught("corner")[0]
    assert key_images.replayed(scene.THERE, route, start)[1] == "lost"
    driven, end = key_images.replayed(scene.THERE, route, start, by_mosaic=True)
    assert end == "arrived"
    assert np.hypot(*(driven[-1] - key_images.taught("corner")[-1])[:2]) < 0.06


def test_conditions_are_needed_where_both_reproduce_and_one_alone_does_not():
    ways = len(key_images.WAYS)
    far = np.full((ways, 4), 0.1)
    came = np.ones((ways, 4), dtype=bool)
    far[0, 3] = 0.5  # not reproduced by both: does not count
    came[2, :2] = False
    far[3, 0] = 0.4
    found = key_images.Result(far, np.ones((ways, 4)), came, np.array(["a", "a", "b", "b"]))
    assert found.needed(key_images.NO_COMMON).estimate == pytest.approx(2 / 3)
    assert found.needed(key_images.NO_TURN).estimate == pytest.approx(1 / 3)
    assert found.needed(key_images.NO_COMMON, "b").estimate == 0
    assert key_images.least(found).estimate == pytest.approx(1 / 3)


# Runs --------------------------------------------------------------------------------------------


def drawn_run(bend: float = 0.0):
    """Return a run of four poses and two patterns, whose mosaic bends by so much a step."""
    true = np.column_stack([np.linspace(1, 4, 4), np.full(4, 2.0), np.zeros(4)])
    born = {"0": np.array([1.5, 2.5, 0.0]), "1": np.array([3.5, 1.5, 0.0])}
    frame = born["0"]
    poses = se2.between(frame, true)
    poses[:, 1] += bend * np.arange(4)
    there = {n: se2.between(frame, pose) for n, pose in born.items()}
    mosaic = Mosaic(there, world.SCALE, np.array(world.CENTRE))
    sightings = [{n: mosaic.expected(pose, n) for n in there} for pose in poses]
    closed = np.zeros(4, dtype=bool)
    return runs.Run(mosaic, {}, sightings, poses, closed, Links(), true, born)


def test_a_mosaic_without_error_has_none_below_the_ceiling():
    run = drawn_run()
    np.testing.assert_allclose(run.below(run.poses), run.true, atol=1e-12)
    np.testing.assert_allclose(run.located(run.mosaic), run.true, atol=1e-9)
    assert run.patterns_off(run.mosaic).max() < 1e-12
    assert run.way == pytest.approx(3)


def test_errors_are_distances_from_the_truth():
    run = drawn_run(bend=0.1)
    np.testing.assert_allclose(run.off(run.below(run.poses)), [0, 0.1, 0.2, 0.3], atol=1e-12)
    turned = run.below(run.poses) + np.array([0, 0, 2 * np.pi - 0.2])
    np.testing.assert_allclose(run.turned(turned), 0.2, atol=1e-9)
    moved = run.mosaic.with_pattern("1", run.mosaic.poses["1"] + [0.0, 0.3, 0.0])
    np.testing.assert_allclose(run.patterns_off(moved), [0, 0.3], atol=1e-12)


def test_a_loop_is_closed_if_its_first_patterns_are_seen_at_its_end():
    run = drawn_run()
    run.sightings[:] = [{"a": 0}, {"b": 0}, {"c": 0}, {"a": 0}]
    assert mapping_run.closes(run)
    run.sightings[:] = [{"a": 0}, {"b": 0}, {"a": 0}, {"d": 0}]
    assert not mapping_run.closes(run)


def test_the_path_is_the_middle_of_what_was_taught_below_the_middle_of_the_ceiling():
    whole = taught_path("corner", step=0.05)
    path = runs.path("corner", 0.05, most=4.0)
    assert len(path) == 81
    np.testing.assert_allclose(np.diff(path, axis=0), np.diff(whole[44:125], axis=0), atol=1e-12)
    assert path[:, :2].min(axis=0) == pytest.approx(-path[:, :2].max(axis=0))
    assert (runs.path("loop", 0.1, seed=1) != runs.path("loop", 0.1, seed=2)).any()


def test_wheels_alone_are_right_at_first_and_wrong_at_last():
    true = runs.path("loop", 0.2)
    told = mapping_run.wheels(true, rng=np.random.default_rng(2))
    np.testing.assert_array_equal(told[0], true[0])
    off = np.hypot(*(told - true)[:, :2].T)
    assert off[1] < 0.02 < off[-1]
    assert off.max() < 2


def test_ceilings_on_which_numbers_were_chosen_are_not_scored():
    assert not set(runs.CHOOSING) & set(runs.SCORING)


# Replays -----------------------------------------------------------------------------------------


def test_a_replay_is_reproduced_if_it_arrives_near_path_and_end():
    path = np.column_stack([np.linspace(0, 2, 21), np.zeros((21, 2))])

    def replay(driven, status="arrived"):
        return replays.Replay(path, driven, driven, [], np.zeros(1), (0,), status)

    assert replay(path).reproduced
    assert not replay(path, "lost").reproduced
    assert replay(path + np.array([0, 0.05, 0])).off == pytest.approx(0.05)
    assert not replay(path + np.array([0, 0.11, 0])).reproduced
    short = path[:19]
    assert replay(short).end == pytest.approx(0.2)
    assert not replay(short).reproduced
    around = np.vstack([path, path[:1] + np.array([0, 5.0, 0]), path[-1:]])
    assert replay(around).off == 0  # how far the path is from what was driven


def test_heads_are_near_the_path_and_below_the_ceiling():
    path = runs.path("corner", 0.05, most=4.0)
    heads = replays.in_the_way(path, 30, rng=np.random.default_rng(0))
    assert len(heads) == 30
    for head in heads:
        gaps = np.hypot(*(path[:, :2] - [head.x, head.y]).T)
        assert gaps.min() <= np.hypot(0.8, 0.8)
        assert 0 < head.height < world.MOUNT.height


def test_shares_are_those_of_the_first_variant():
    off = {"a": np.array([0.05, 0.2, 0.3]), "b": np.array([0.1])}
    flags = {"a": np.array([True, False, True]), "b": np.array([False])}
    found = replaying.Result(off, off, flags, flags)
    assert found.claimed == "a"
    assert replaying.share(found).estimate == pytest.approx(2 / 3)
    table = replaying.table(found)
    assert table["a", "drives"] == 3
    assert table["a", "off (m)"].estimate == pytest.approx(0.175)
    assert table["b", "off (m)"] == ""


def test_variants_change_one_thing_each():
    for learned, driven in replaying.CHANGES.values():
        assert len(learned) + len(driven) <= 1


# What the page shows -----------------------------------------------------------------------------


def looked_up(plan, points):
    """Return what a plan shows at points below the ceiling, and which of them it has."""
    left, right, bottom, top = plan.extent
    rows, columns = plan.image.shape
    x, y = ((points - [left, top]) / [right - left, bottom - top] * [columns, rows]).T.astype(int)
    inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
    return plan.image[y[inside], x[inside]].astype(float), inside


def true_greys(side, points):
    """Return the ceiling of the page at points, a little smoothed."""
    above = runs.ceiling(scene.SHOWN, side=side)
    texels = np.round(above.texels(points)).astype(int)
    return cv2.blur(above.texture, (3, 3))[texels[:, 1], texels[:, 0]].astype(float)


def test_a_plan_shows_the_ceiling_where_it_is():
    middle = scene.comeback().taught[:, :2].mean(axis=0)
    points = middle + np.random.default_rng(4).uniform(-2, 2, (2000, 2))
    shown, inside = looked_up(scene.plan(), points)
    assert inside.all()
    assert np.corrcoef(true_greys(runs.ROOM, points), shown)[0, 1] > 0.8


def test_the_composed_picture_is_the_ceiling_where_the_robot_was_right():
    """At the beginning of the loop it was."""
    start = scene.loop().true[0]
    points = start[:2] + np.random.default_rng(5).uniform(-0.8, 0.8, (2000, 2))
    shown, inside = looked_up(scene.composed(), points)
    assert inside.all()
    assert np.corrcoef(true_greys(runs.SIDE, points), shown)[0, 1] > 0.5
    assert (scene.composed().image == 255).any()

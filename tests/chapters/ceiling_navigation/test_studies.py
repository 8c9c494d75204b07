"""The studies: what exact sightings are, what is measured, and with what, by law."""

from dataclasses import replace
from functools import reduce
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from data_synth.ceiling import Mount, taught_path
from robot_perception.book import ceiling_navigation as page
from robot_perception.ceiling.mosaic import Links, Mosaic
from robot_perception.ceiling.visual_memory import Follower, KeyImage
from robot_perception.chapters.ceiling_navigation.scene import BORDER, CENTRE, HALF, MOUNT, SCALE
from robot_perception.geometry import se2, wrap_angle
from studies.rows import Rows, framed

RNG = np.random.default_rng

# Exact sightings


def test_a_sighting_is_where_the_pattern_is_in_the_robots_frame():
    pose, there = np.array([0.4, -0.2, 0.7]), {"a": np.array([1.0, 0.3, -0.5])}
    found = page.seen(page.looking(), pose, there)["a"]
    way = se2.between(pose, there["a"])
    np.testing.assert_allclose(found[:2], way[:2] * 80 + [159.5, 119.5], atol=1e-9)
    assert found[2] == pytest.approx(way[2])
    assert found[3] == pytest.approx(1)


def test_a_correction_is_exact_for_the_mount_and_the_ceiling_that_it_was_made_for():
    """Tilted since, or below a lower ceiling, the camera sees corrected points elsewhere."""
    few = page.corrected.but(mounts=20)
    assert few.trial(draw=71)["down"].max() < 1e-6
    for change in ({"since": np.deg2rad(2)}, {"below": 0.3}):
        assert np.median(few.but(**change).trial(draw=71)["down"]) > 1.0


def test_three_noisy_patterns_are_nearer_in_the_mean_than_one():
    off = page.posed.but(poses=300).trial(draw=72)
    for axis in "xy":
        assert np.std(off[f"mean {axis}"]) < 0.8 * np.std(off[f"one {axis}"])


@pytest.mark.parametrize(("way", "common"), [("two in common", 2), ("three in common", 3)])
def test_neighbouring_key_images_have_the_patterns_in_common_that_are_asked_for(way, common):
    """In a row of pictures each loses one pattern of five and meets a new one."""
    images = [
        {f"{k}": np.array([40.0 * (k - i), 0.0, 0.0, 1.0]) for k in range(i, i + 5)}
        for i in range(12)
    ]
    kept = page.chosen(images, way)
    shared = [len(images[a].keys() & images[b].keys()) for a, b in pairwise(kept)]
    assert min(shared) == common


def test_patterns_near_the_border_and_beyond_it_are_not_seen():
    there = {str(k): np.array([x, 0.0, 0.0]) for k, x in enumerate((0.0, 1.6, 1.63, 3.0))}
    view = page.seen(page.looking(), np.zeros(3), there, border=30.0)
    assert set(view) == {"0", "1"}  # (320 / 2 - 0.5 - 30) px are 1.61875 m
    corner = {"a": np.array([0.0, 1.3, 0.0])}  # inside along one axis alone
    assert not page.seen(page.looking(), np.zeros(3), corner, border=30.0)
    assert set(page.seen(page.looking(), np.zeros(3), there)) == {"0", "1", "2", "3"}
    assert page.seen(page.looking(), np.zeros(3), {}) == {}


def test_what_a_camera_sees_of_the_ceiling_is_half_its_picture_wide():
    np.testing.assert_allclose(HALF, [159.5 / 80, 119.5 / 80])


# What the paper leaves open


def test_choices_leave_everything_else_as_printed():
    assert page.printed_with(*page.CHOICES[page.FEWER]) == page.PRINTED
    two = page.printed_with(*page.CHOICES[page.TWICE])
    assert two.tracker == replace(page.PRINTED.tracker, passes=1)
    more = page.printed_with(*page.CHOICES[page.MORE])
    assert more.tracker == replace(page.PRINTED.tracker, particles=1000)
    assert replace(more, tracker=page.PRINTED.tracker) == page.PRINTED


def test_what_is_astray_is_counted_over_the_first_metres():
    """Off by nothing for a metre, then by 5 cm (3 along, 4 across), along steps of half a metre."""
    true = np.column_stack([0.5 * np.arange(5), np.zeros(5), np.zeros(5)])
    told = true + np.outer(true[:, 0] > 1.0, [0.03, 0.04, 0.5])
    run = SimpleNamespace(true=true, told=told)
    assert page.astray(run, 1.0) == 0
    assert page.astray(run, 1.5) == pytest.approx(0.05 * np.sqrt(1 / 4))
    assert page.astray(run) == pytest.approx(0.05 * np.sqrt(2 / 5))


def test_a_grey_picture_is_asked_of_patterns_of_the_picture_before():
    """By the printed measure they are seen in it, and by the one without means they are not."""
    printed, ours = (page.greyed.trial(ceiling=120, rules=name) for name in page.RULES)
    assert printed["patterns"] > 0
    assert printed["seen"] == printed["patterns"]
    assert ours["patterns"] > 0
    assert ours["seen"] == 0


# Eqs (1) and (2)


def test_corrected_pixels_are_those_of_a_camera_in_the_robots_frame():
    turned = {"roll": 0.1, "pitch": -0.05, "yaw": 0.3, "x": 0.2, "y": -0.1}
    pose = np.array([0.5, 0.1, 1.0])
    points = pose[:2] + RNG(0).uniform(-1, 1, (5, 2))
    image = page.looking(**turned).points_seen(pose, points)
    ideal = page.looking().points_seen(pose, points)
    for n, low, high in ((page.DOWN, 0.0, 1e-9), (page.UP, 5.0, 1e3)):
        rays = np.linalg.solve(page.eq1(Mount(**turned), n), np.column_stack([image, np.ones(5)]).T)
        assert low <= np.abs((rays[:2] / rays[2]).T - ideal).max() <= high


def test_the_robots_own_picture_has_no_blank_and_is_the_ideal_one():
    assert page.corrections(page.WIDE).seen[60:-60, 80:-80].all()
    found = page.pictures()
    ceiling = page.make_ceiling("varied", rng=RNG(page.SHOWN), side=8.0)
    own = page.eye(ceiling)(np.array([0.3, 0.2, 0.4]))
    assert own.shape == (MOUNT.size[1], MOUNT.size[0])
    off = [np.abs(one.astype(float) - found.ideal).mean() for one in (own, found.raw)]
    assert off[0] < 2 < 5 < off[1]


def test_noise_follows_its_law_near_and_far():
    rows = Rows(framed([page.posed.but(poses=1500).trial(draw=1)]), "draw", {})
    for distance, name in zip(page.RINGS, ("near", "far"), strict=True):
        rms = np.sqrt((page.errors(rows, name) ** 2).sum(axis=1).mean())
        law = np.sqrt(2 * SCALE**2 + (0.02 * distance) ** 2)
        assert rms == pytest.approx(law, rel=0.08)
    assert page.off(rows, "fitted").estimate < 0.7 * page.off(rows, "mean").estimate


# The quotient, and the chain


def matrix(pose):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0, 0, 1]])


def test_readings_are_the_four_products_of_matrices():
    A, B = np.array([3.0, 1.0, 0.4, 1.0]), np.array([-2.0, 5.0, -1.1, 1.0])
    a, b, inverse = matrix(A), matrix(B), np.linalg.inv
    products = {
        "A B⁻¹": a @ inverse(b),
        "B⁻¹ A": inverse(b) @ a,
        "B A⁻¹": b @ inverse(a),
        "A⁻¹ B": inverse(a) @ b,
    }
    for name, product in products.items():
        np.testing.assert_allclose(matrix(page.READINGS[name](A, B)), product, atol=1e-12)


def test_a_new_pattern_is_placed_where_it_is():
    np.testing.assert_allclose(page.placed(0.2, 0.4, 45.0).right, page.PAIR[1], atol=1e-12)


def test_a_chain_of_exact_sightings_is_exact_and_a_scale_makes_it_larger():
    path, there = page.taught("loop", 0.5), page.patterns(RNG(1))
    found = page.chained(path, there)
    frame, names = there[next(iter(found))], [*found]
    true = np.array([se2.between(frame, there[name])[:2] for name in names])
    np.testing.assert_allclose([found[name][:2] for name in names], true, atol=1e-9)
    larger = page.chained(path, there, scale=1.1 * SCALE)
    np.testing.assert_allclose([larger[name][:2] for name in names], 1.1 * true, atol=1e-9)


# Up to scale


def test_one_direction_is_unknown_without_the_scale_and_none_with_it():
    for poses, patterns in ((3, 2), (6, 4)):
        some = page.ranked.but(poses=poses, patterns=patterns)
        assert [some.trial(known=known)["open"] for known in (False, True)] == [1, 0]


def test_where_a_robot_ends_does_not_depend_on_the_scale():
    for factor in (0.5, 1.0, 1.5):
        end = page.approach(np.array([-1.2, 0.2, -0.1]), factor)[-1]
        assert np.hypot(*end[:2]) <= page.STOP + 1e-9


def test_headings_fall_as_the_law_says():
    """With a small angle, from 1 m on: the smaller root of the linear law, as a power of ρ."""
    rules = page.replace(page.SERVO, gain_distance=0.3, gain_bearing=1.5, gain_heading=-0.7)
    root = np.roots([1.0, 1.5 - 0.3, 0.3 * 0.7]).real.max()
    path = page.approach(np.array([-1.5, 0.0, 0.05]), rules=rules, step=0.02)
    rho, heading = np.hypot(*path[:, :2].T), np.abs(path[:, 2])
    k = [int(np.argmax(rho < d)) for d in (0.05, 0.005)]
    slope = np.log(heading[k[0]] / heading[k[1]]) / np.log(rho[k[0]] / rho[k[1]])
    assert slope == pytest.approx(-root / 0.3, abs=0.05)


def test_a_changed_tilt_moves_the_end_by_z_times_its_tangent():
    start, tilt = np.array([-1.5, 0.0, 0.0]), np.deg2rad(2.0)
    moved = np.hypot(*page.approach(start, tilt=tilt)[-1][:2])
    assert moved == pytest.approx(2.5 * np.tan(tilt), rel=0.1)
    assert np.hypot(*page.approach(start, always=tilt)[-1][:2]) < 0.01


# Key images


def test_the_circle_is_a_circle_between_straight_pieces():
    path = page.taught("circle")
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert steps.max() < 0.0501
    assert steps.sum() == pytest.approx(3 + 1.5 * np.pi, abs=0.05)
    assert path[:, 1].max() == pytest.approx(1.5, abs=0.01)


def test_broken_conditions_are_broken_and_kept_ones_kept():
    path = page.taught("slalom", most=7.0)
    images = [page.seen(page.looking(), pose, page.above(), BORDER) for pose in path]
    numbers = dict(zip(page.WAYS, (1, 2, 3, 0, 1), strict=True))
    for way, common in numbers.items():
        picked = page.chosen(images, way)
        assert picked[0] == 0
        assert picked[-1] == len(images) - 1
        shared = [images[a].keys() & images[b].keys() for a, b in pairwise(picked)]
        if way == "none in common":
            assert {len(names) for names in shared[:-1]} == {0}
            continue
        assert min(len(names) for names in shared) >= common
        turned = max(
            abs(wrap_angle(images[a][n][2] - images[b][n][2]))
            for (a, b), names in zip(pairwise(picked), shared, strict=True)
            for n in names
        )
        assert (turned >= page.TURN) == (way == "turned at will")


def test_there_is_a_pattern_in_each_cell_of_the_grid():
    there = np.array([*page.patterns(RNG(3)).values()])
    assert len(there) == 144
    assert len(np.unique(np.floor(there[:, :2] + 0.5), axis=0)) == 144


def test_a_path_is_reproduced_if_the_robot_arrives_at_its_end_and_was_near_it():
    one = np.column_stack([np.linspace(0, 4, 41), np.zeros((41, 2))])
    assert page.came_of(one, one, "arrived")["fits"]
    assert not page.came_of(one, one, "lost")["fits"]
    beside = one + np.array([0, 0.2, 0])
    found = page.came_of(one, beside, "arrived")
    assert (found["off"], found["far"], found["end"]) == pytest.approx((0.2, 0.2, 0.2))
    assert not found["comes"]
    for short, whole in ((one[:31], one), (one, one[:31])):
        assert page.came_of(whole, short, "arrived")["far"] == pytest.approx(1.0)
    start = one.copy()
    start[:5, 1] = 0.5  # at the start it may be
    assert page.came_of(one, start, "arrived")["far"] == 0
    bend = one.copy()
    bend[20, 1] = 0.35
    found = page.came_of(one, bend, "arrived")
    assert (found["comes"], found["fits"]) == (True, False)


def test_the_loop_of_the_page_is_the_librarys():
    start = se2.compose(page.taught("slalom", most=7.0)[0], np.array([0.0, 0.3, 0.0]))
    path, status = page.follow(page.above(), page.route(), start)
    robot, poses, rng = Follower(page.route(), MOUNT.middle, SCALE, page.SERVO), [start], RNG(0)

    def look():
        return page.seen(page.looking(), poses[-1], page.above(), BORDER)

    def move(speed, turn):
        poses.append(page.drive(poses[-1], speed, turn, 0.1, page.NO_SLIP, rng=rng))

    *_, last = robot.drive(look, move)
    assert (last.status, status) == ("arrived", "arrived")
    np.testing.assert_allclose(poses, path, atol=1e-12)


def test_steering_by_the_mosaic_needs_no_common_pattern():
    true, there = page.taught("corner", most=7.0), page.above()
    images = [page.seen(page.looking(), pose, there, BORDER) for pose in true]
    keys = [KeyImage(images[k]) for k in page.chosen(images, "none in common")]
    assert page.follow(there, keys, true[0])[1] == "lost"
    path, status = page.follow(there, keys, true[0], page.by_mosaic(there))
    assert status == "arrived"
    assert np.hypot(*(path[-1] - true[-1])[:2]) < 0.06


def test_from_a_key_image_without_a_common_pattern_no_direction_leads_on():
    alone, common = (
        page.stranded.but(way=way).trial(ceiling=900, path="corner")
        for way in ("none in common", "both conditions")
    )
    assert alone["stuck"] == alone["pairs"] > 0
    assert common["stuck"] == 0
    assert common["pairs"] > alone["pairs"]


def test_a_condition_is_needed_where_both_reproduce_and_one_alone_does_not():
    """Of four drives the last is not reproduced by both, and does not count."""
    fits = {"both conditions": [1, 1, 1, 0], "turned at will": [0, 0, 1, 0]}
    table = framed(
        {"ceiling": k, "path": "corner", "way": way, "fits": bool(fits[way][k])}
        for way in fits
        for k in range(4)
    )
    rows = Rows(table, "ceiling", {})
    assert page.needed(rows, "turned at will").estimate == pytest.approx(2 / 3)


# Pictures


def drawn_run(bend=0.0):
    """Return a run of four poses and two patterns, whose mosaic bends by so much a step."""
    true = np.column_stack([np.linspace(1, 4, 4), np.full(4, 2.0), np.zeros(4)])
    born = {"0": np.array([1.5, 2.5, 0.0]), "1": np.array([3.5, 1.5, 0.0])}
    frame = born["0"]
    poses = se2.between(frame, true)
    poses[:, 1] += bend * np.arange(4)
    mosaic = Mosaic({n: se2.between(frame, pose) for n, pose in born.items()}, SCALE, CENTRE)
    seen = [{n: mosaic.expected(pose, n) for n in born} for pose in poses]
    return SimpleNamespace(
        true=true, born=born, frame=frame, mosaic=mosaic, seen=seen, links=Links()
    )


def test_a_mosaic_without_error_has_none_below_the_ceiling():
    run = drawn_run()
    np.testing.assert_allclose(page.located(run, run.mosaic), run.true, atol=1e-9)
    assert page.patterns_off(run, run.mosaic) < 1e-12
    moved = run.mosaic.with_pattern("1", run.mosaic.poses["1"] + [0.0, 0.3, 0.0])
    assert page.patterns_off(run, moved) == pytest.approx(0.3 / np.sqrt(2))


def test_a_loop_is_closed_if_its_first_patterns_are_seen_at_its_end():
    run = drawn_run()
    run.seen[:] = [{"a": 0}, {"b": 0}, {"c": 0}, {"a": 0}]
    assert page.closes(run)
    run.seen[:] = [{"a": 0}, {"b": 0}, {"a": 0}, {"d": 0}]
    assert not page.closes(run)


def test_the_path_is_the_middle_of_what_was_taught_below_the_middle_of_the_ceiling():
    whole, path = taught_path("corner", step=0.05), page.taught("corner", 0.05, most=4.0)
    assert len(path) == 81
    np.testing.assert_allclose(np.diff(path, axis=0), np.diff(whole[44:125], axis=0), atol=1e-12)
    assert path[:, :2].min(axis=0) == pytest.approx(-path[:, :2].max(axis=0))


def test_wheels_alone_are_right_at_first_and_wrong_at_last():
    true = page.taught("loop", 0.2)
    told = page.wheels(true, RNG(2))
    off = np.hypot(*(told - true)[:, :2].T)
    assert off[0] == 0
    assert off[1] < 0.02 < off[-1]
    assert off.max() < 2


@pytest.mark.slow
def test_a_robot_learns_where_it_is_and_where_its_patterns_are():
    """On a piece of a corner, by our rules, below a ceiling that nobody scores."""
    run = page.lesson(101, "ours", most=1.0)
    assert np.hypot(*(run.told - run.true)[:, :2].T).max() < 0.04
    assert page.patterns_off(run, run.mosaic) < 0.05
    assert len(run.seen) == len(run.true) == 21


def test_all_rules_exchanged_make_the_other_set():
    """But for the closing of loops, of which a corner has none."""
    printed, ours = page.PRINTED, page.OURS
    for rules, other in ((ours, printed), (printed, ours)):
        taken = reduce(lambda rules, take: take(rules, other), page.TAKEN.values(), rules)
        assert replace(taken, closing=other.closing) == other


def test_each_rule_is_exchanged_alone():
    for name, take in page.TAKEN.items():
        there = take(page.OURS, page.PRINTED)
        assert there not in (page.OURS, page.PRINTED), name
        assert take(there, page.OURS) == page.OURS, name
        assert page.ONE_OTHER["ours", name] == there, name
        assert page.ONE_OTHER["as printed", name] == take(page.PRINTED, page.OURS), name


def test_heads_are_near_the_path_and_below_the_ceiling():
    path = page.taught("corner", 0.05, most=4.0)
    heads = page.heads_near(path, 30, RNG(0))
    assert len(heads) == 30
    for head in heads:
        assert np.hypot(*(path[:, :2] - [head.x, head.y]).T).min() <= np.hypot(0.8, 0.8)
        assert 0 < head.height < MOUNT.height


def test_what_is_other_is_one_thing_each():
    assert [len(changes) for changes in page.OTHER.values()] == [0, 1, 1, 1, 1]
    assert [len(changes) for changes in page.CHANGES.values()] == [1] * len(page.CHANGES)


def test_ceilings_on_which_numbers_were_chosen_are_not_scored():
    for study in (page.mapped, page.kept, page.drives, page.exchanged, page.disturbed):
        assert not {*page.CHOOSING, page.SHOWN} & {*study.replicates}

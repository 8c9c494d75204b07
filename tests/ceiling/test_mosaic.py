"""The mosaic: eqs (2) and (3), chains, alignment, links, and loops that an adjustment closes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling
from robot_perception.ceiling import mosaic as module
from robot_perception.ceiling.mosaic import (
    Links,
    Mosaic,
    NoCommonPattern,
    adjust,
    align,
    between_patterns,
    camera_pose,
    in_camera,
    paint,
    pieces,
    place,
)
from robot_perception.geometry import se2
from tests.unchecked import unchecked

CENTRE = np.array([159.5, 119.5])
SCALE = 0.007
POSES = arrays(float, 3, elements=st.floats(-4, 4))
SIGHTINGS = arrays(float, 4, elements=st.floats(-3, 3)).map(lambda s: s * [100, 100, 1, 1])


def matrix(pose, unit=1.0):
    """Return a pose as a homogeneous matrix, its position times a unit."""
    x, y, angle = pose[:3]
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, unit * x], [sin, cos, unit * y], [0, 0, 1]])


def near(pose, T, atol=1e-9):
    np.testing.assert_allclose(matrix(pose), T, atol=atol)
    assert -np.pi <= pose[2] < np.pi


def seen(pose, pattern, scale=SCALE, centre=CENTRE):
    """Return the sighting of a pattern from a pose by the camera's equation."""
    (c, s), away = (math.cos(pose[2]), math.sin(pose[2])), np.subtract(pattern, pose)
    ahead, left = c * away[0] + s * away[1], c * away[1] - s * away[0]
    return np.array([centre[0] + ahead / scale, centre[1] + left / scale, away[2], 1.3])


def ring(count, radius=4.0, seed=0):
    """Return patterns around a loop by their names; the first is the reference at the origin."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(count) / count
    poses = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), angles])
    poses[1:] += rng.normal(0, 0.2, (count - 1, 3))
    return {str(k): pose for k, pose in enumerate(se2.between(poses[0], poses))}


def drive(patterns, rng=None, sigma=1.0, sigma_heading=0.02, pairs=None, repeat=3):
    """Return sightings of neighbours, noisy if there is randomness."""
    count = len(patterns)
    for first, second in pairs or [(k, (k + 1) % count) for k in range(count)]:
        for turn in np.linspace(-3, 3, repeat):
            pose = patterns[str(first)] + np.array([0.2, -0.1, turn])
            image = {str(k): seen(pose, patterns[str(k)]) for k in (first, second)}
            for sighting in image.values():
                if rng is not None:
                    noise = rng.normal(size=3) * [sigma, sigma, sigma_heading]
                    sighting[:3] += noise
            yield image


def build(images, start=(0.0, 0.0, 0.0), scale=SCALE):
    """Chain a mosaic as the paper does, and gather links."""
    mosaic, links = Mosaic({"0": np.array(start)}, scale, CENTRE), Links()
    for image in images:
        links = links.add(image, CENTRE, scale)
        known = next(name for name in image if name in mosaic.poses)
        for name in image:
            if name not in mosaic.poses:
                pose = mosaic.poses[known]
                pose = place(pose, image[known], image[name], centre=CENTRE, scale=scale)
                mosaic = mosaic.with_pattern(name, pose)
    return mosaic, links


def errors(mosaic, patterns):
    return max(np.abs(matrix(mosaic.poses[k]) - matrix(p)).max() for k, p in patterns.items())


@given(SIGHTINGS)
def test_a_sighting_in_the_cameras_frame(sighting):
    pose = in_camera(sighting, centre=CENTRE, scale=SCALE)
    T = matrix([*(sighting[:2] - CENTRE), sighting[2]], SCALE)
    near(pose, T)
    batch = in_camera(np.stack([sighting, sighting + 1])[None], centre=CENTRE, scale=SCALE)
    assert batch.shape == (1, 2, 3)
    np.testing.assert_array_equal(batch[0, 0], pose)


@given(POSES, POSES)
def test_equation_2(pattern, pose):
    in_frame = in_camera(seen(pose, pattern), centre=CENTRE, scale=SCALE)
    near(camera_pose(pattern, in_frame), matrix(pose))
    near(camera_pose(pattern, in_frame), matrix(pattern) @ np.linalg.inv(matrix(in_frame)))
    batch = camera_pose(np.stack([pattern, pattern]), in_frame)
    np.testing.assert_allclose(batch[1], camera_pose(pattern, in_frame))


@given(POSES, POSES)
def test_without_a_scale_the_pose_is_right_up_to_one(pattern, pose):
    in_frame = in_camera(seen(pose, pattern), centre=CENTRE, scale=1.0)
    near(camera_pose(pattern / [SCALE, SCALE, 1], in_frame) * [SCALE, SCALE, 1], matrix(pose))


@given(SIGHTINGS, SIGHTINGS, SIGHTINGS)
def test_the_two_readings_of_the_quotient(known, new, motion):
    K, N = matrix(known), matrix(new)
    right, wrong = between_patterns(known, new), between_patterns(known, new, "inverse last")
    near(right, np.linalg.inv(K) @ N, 1e-8)
    near(wrong, N @ np.linalg.inv(K), 1e-8)
    moved = [np.append(se2.compose(motion[:3], s[:3]), 1.0) for s in (known, new)]
    near(between_patterns(*moved), matrix(right), 1e-7)
    g = matrix(motion)
    near(between_patterns(*moved, "inverse last"), g @ matrix(wrong) @ np.linalg.inv(g), 1e-6)


@given(POSES, POSES, POSES)
def test_equation_3_places_a_pattern_wherever_the_robot_is(known, new, pose):
    found = place(known, seen(pose, known), seen(pose, new), centre=CENTRE, scale=SCALE)
    near(found, matrix(new), 1e-8)
    elsewhere = place(known, seen(pose, known), seen(pose, new), centre=CENTRE * 0, scale=SCALE)
    near(elsewhere, matrix(new), 1e-8)
    one = place(np.zeros(3), seen(pose, known), seen(pose, new), centre=CENTRE, scale=1.0)
    step = between_patterns(seen(pose, known), seen(pose, new))
    np.testing.assert_allclose(one, step, atol=1e-9)


def test_the_wrong_order_places_it_elsewhere_from_everywhere():
    known, new = np.array([0.5, 0.2, 0.4]), np.array([1.0, -0.3, -1.0])
    places = []
    for turn in (0.0, 1.0, 2.0):
        both = [seen(np.array([0.3, 0.1, turn]), p) for p in (known, new)]
        how = {"centre": CENTRE, "scale": SCALE, "order": "inverse last"}
        found = place(known, *both, **how)
        C = [matrix(in_camera(s, centre=CENTRE, scale=SCALE)) for s in both]
        near(found, matrix(known) @ C[1] @ np.linalg.inv(C[0]))
        places.append(found)
    assert np.ptp(places, axis=0)[:2].max() > 0.3
    batch = place(known, np.stack([both[0]] * 2), both[1], centre=CENTRE, scale=SCALE)
    near(batch[1], matrix(new))


def test_a_chain_of_fifty_patterns_is_exact_without_noise():
    patterns = ring(50)
    mosaic, links = build(drive(patterns))
    assert errors(mosaic, patterns) < 1e-9
    assert list(mosaic.poses) == [str(k) for k in range(50)]
    adjusted, info = adjust(mosaic, links, fixed="0")
    assert errors(adjusted, patterns) < 1e-9
    assert info.links == 50
    assert info.cost_before < 1e-18


CLOUDS = arrays(float, (5, 3), elements=st.floats(-3, 3))
WEIGHTS = arrays(float, 5, elements=st.floats(0.1, 10))


@given(CLOUDS, CLOUDS, WEIGHTS, WEIGHTS)
@settings(max_examples=20)
def test_alignment_is_the_least_squares(known, noise, a, b):
    pose = np.array([1.0, -2.0, 2.5])
    there = se2.between(pose, known) + 0.1 * noise

    def cost(x):
        miss = known[:, :2] - se2.act(x, there[:, :2])
        turn = known[:, 2] - there[:, 2] - x[2]
        return a @ (miss**2).sum(axis=1) + 2 * b @ (1 - np.cos(turn))

    found = align(known, there, a, b)
    best = min(
        (minimize(cost, [*pose[:2], start], tol=1e-12) for start in (-2.0, 0.0, 2.0)),
        key=lambda r: r.fun,
    )
    assert cost(found) <= best.fun + 1e-7
    assert -np.pi <= found[2] < np.pi


@given(CLOUDS, POSES, WEIGHTS, WEIGHTS)
def test_alignment_is_exact_without_noise_whatever_the_weights(known, pose, a, b):
    near(align(known, se2.between(pose, known), a, b), matrix(pose), 1e-7)


@given(POSES, POSES)
def test_one_pattern_gives_exactly_equation_2(pattern, pose):
    mosaic = Mosaic({"a": pattern}, SCALE, CENTRE)
    sighting = seen(pose, pattern)
    found, residuals = mosaic.locate({"a": sighting, "unknown": sighting}, {"a": 0.3})
    expected = camera_pose(pattern, in_camera(sighting, centre=CENTRE, scale=SCALE))
    near(found, matrix(expected), 1e-12)
    assert residuals.keys() == {"a"}
    np.testing.assert_allclose(residuals["a"], 0, atol=1e-12)


@given(POSES, POSES)
def test_expected_is_what_is_seen(pattern, pose):
    mosaic = Mosaic({"a": pattern}, SCALE, CENTRE)
    found = mosaic.expected(pose, "a")
    near(found[:3], matrix(seen(pose, pattern)), 1e-7)
    assert found[3] == 1
    near(mosaic.locate({"a": found})[0], matrix(pose))
    assert mosaic.expected(np.zeros((4, 2, 3)), "a").shape == (4, 2, 4)


def scatter(rng, patterns, pose, sigma=1.0, sigma_heading=0.02):
    noise = [sigma, sigma, sigma_heading, 0.0]
    return {k: seen(pose, p) + rng.normal(size=4) * noise for k, p in patterns.items()}


def test_many_patterns_locate_better_than_the_mean_of_equation_2():
    rng = np.random.default_rng(0)
    patterns = {str(k): np.array([*rng.uniform(-0.8, 0.8, 2), k]) for k in range(4)}
    mosaic = Mosaic(patterns, SCALE, CENTRE)
    pose = np.array([0.2, 0.1, 1.0])
    away, mean = [], []
    for _ in range(400):
        image = scatter(rng, patterns, pose)
        away.append(mosaic.locate(image)[0] - pose)
        alone = [mosaic.locate({k: s})[0] - pose for k, s in image.items()]
        mean.append(np.mean(alone, axis=0))
    together, each = np.std(away, axis=0), np.std(mean, axis=0)
    assert (together < 0.95 * each).all()
    assert together[2] < 0.7 * each[2]
    assert np.abs(np.mean(away, axis=0)).max() < 4 * together.max() / 20


def test_the_default_weights_are_those_of_the_noise():
    """The best ratio of sigmas is the true one, and the scale takes px to m."""
    rng = np.random.default_rng(1)
    patterns = {str(k): np.array([*rng.uniform(-0.15, 0.15, 2), k]) for k in range(3)}
    mosaic, pose = Mosaic(patterns, SCALE, CENTRE), np.array([0.2, 0.1, 1.0])
    images = [scatter(rng, patterns, pose) for _ in range(400)]
    spread = {}
    for sigma in (0.02, 0.0004, 1.0):
        found = [mosaic.locate(image, sigma_heading=sigma)[0] for image in images]
        spread[sigma] = np.std(found, axis=0)[2]
    assert spread[0.02] == min(spread.values())
    assert spread[0.02] < 0.97 * min(spread[0.0004], spread[1.0])


def test_weights_count_as_repetitions():
    rng = np.random.default_rng(2)
    patterns = {str(k): np.array([*rng.uniform(-1, 1, 2), k]) for k in range(3)}
    mosaic = Mosaic(patterns, SCALE, CENTRE)
    image = scatter(rng, patterns, np.array([0.2, 0.1, 1.0]))
    weighted, _ = mosaic.locate(image, {"0": 3.0})
    thrice = patterns | {"x": patterns["0"], "y": patterns["0"]}
    repeated = image | {"x": image["0"], "y": image["0"]}
    near(Mosaic(thrice, SCALE, CENTRE).locate(repeated)[0], matrix(weighted))
    without, residuals = mosaic.locate(image, {"0": 0.0})
    near(mosaic.locate({k: image[k] for k in "12"})[0], matrix(without))
    there = in_camera(image["0"], centre=CENTRE, scale=SCALE)
    miss = there - in_camera(mosaic.expected(without, "0"), centre=CENTRE, scale=SCALE)
    np.testing.assert_allclose(residuals["0"], miss, atol=1e-9)


def test_residuals_of_headings_are_wrapped():
    mosaic = Mosaic({"a": np.array([0, 0, 3.0]), "b": np.array([1, 0, 3.0])}, SCALE, CENTRE)
    image = {k: seen(np.array([0.3, 0.1, 0.0]), p) for k, p in mosaic.poses.items()}
    image["b"][2] += 0.3  # beyond π
    assert abs(mosaic.locate(image)[1]["b"][2]) < 0.4


def test_links_are_means_over_the_images():
    patterns = ring(6)
    rng = np.random.default_rng(3)
    links, ways = Links(), []
    for _ in range(50):
        pose = np.array([0.1, 0.2, rng.uniform(-9, 9)])
        image = scatter(rng, {k: patterns[k] for k in ("3", "1", "2")}, pose)
        before = links.means()
        new = links.add(image, CENTRE, SCALE)
        for pair, link in links.means().items():  # what was there stays as it was
            np.testing.assert_array_equal(link.pose, before[pair].pose)
        links = new
        one, two = (in_camera(image[k], centre=CENTRE, scale=SCALE) for k in ("1", "3"))
        ways.append(se2.between(one, two))
    means = links.means()
    assert set(means) == {("1", "2"), ("1", "3"), ("2", "3")}
    link, ways = means["1", "3"], np.array(ways)
    assert link.count == 50
    np.testing.assert_allclose(link.pose[:2], ways[:, :2].mean(axis=0))
    turns = np.exp(1j * ways[:, 2])
    assert np.isclose(np.exp(1j * link.pose[2]), turns.mean() / abs(turns.mean()))
    assert Links().add({"a": np.ones(4)}, CENTRE, SCALE).means() == {}
    assert Links().add({}, CENTRE, SCALE).means() == {}


@given(st.lists(st.lists(st.sampled_from("abcdefg"), max_size=3, unique=True), max_size=6))
def test_groups_are_what_chains_of_images_join(images):
    """By powers of the matrix that tells who was seen together."""
    names, links, together = [*"gfedcba"], Links(), np.eye(7, dtype=int)
    for some in images:
        links = links.add({name: np.ones(4) for name in some}, CENTRE, SCALE)
        rows = [names.index(name) for name in some]
        together[np.ix_(rows, rows)] = 1
    reached = np.linalg.matrix_power(together, 7) > 0
    own = [
        tuple(name for name, joined in zip(names, row, strict=True) if joined) for row in reached
    ]
    assert links.groups(names) == tuple(dict.fromkeys(own))
    assert Links().groups(()) == ()


def test_pieces_are_rigid_and_each_in_the_frame_of_its_first_pattern():
    poses = {name: np.array([k, -k, 0.3 * k]) for k, name in enumerate("abcd", 1)}
    links = Links().add({"a": np.ones(4), "c": np.ones(4)}, CENTRE, SCALE)
    links = links.add({"b": np.ones(4), "d": np.ones(4)}, CENTRE, SCALE)
    whole = Mosaic(poses, SCALE, CENTRE)
    found = pieces(whole, links)
    assert [[*part.poses] for part in found] == [["a", "c"], ["b", "d"]]
    for part, (first, second) in zip(found, ("ac", "bd"), strict=True):
        assert not part.poses[first].any()
        near(se2.compose(poses[first], part.poses[second]), matrix(poses[second]))
        assert part.scale == SCALE
    (one,) = pieces(whole, links.add({name: np.ones(4) for name in "ab"}, CENTRE, SCALE))
    assert [*one.poses] == [*"abcd"]


def test_the_jacobian_is_that_of_finite_differences():
    rng = np.random.default_rng(4)
    poses = rng.uniform(-2, 2, (5, 3))
    ends = np.array([[0, 1], [1, 2], [3, 2], [4, 0], [1, 4], [3, 0]])
    ways = rng.uniform(-2, 2, (6, 3))
    white = module._whitening(ways, np.arange(1.0, 7), 0.01, 0.03)
    J = module._jacobian(poses, ends, white).toarray()
    step = 1e-6
    for k in range(12):
        moved = [poses.copy(), poses.copy()]
        for sign, p in zip((1, -1), moved, strict=True):
            p[1 + k // 3, k % 3] += sign * step
        ahead, back = (module._residuals(p, ends, ways, white) for p in moved)
        np.testing.assert_allclose(J[:, k], (ahead - back) / (2 * step), rtol=1e-6, atol=1e-4)


def test_weights_of_a_link_are_those_of_its_noise():
    """Whitened, the ways of many noisy images have unit covariance; so has their mean."""
    rng = np.random.default_rng(5)
    patterns = {"a": np.zeros(3), "b": np.array([0.9, -0.5, 2.0])}
    true = patterns["b"]
    white = module._whitening(true[None], np.array([1.0]), 1.0 * SCALE, 0.02)[0]
    found = []
    for _ in range(4000):
        image = scatter(rng, patterns, np.array([0.3, 0.1, 1.0]))
        a, b = (in_camera(image[k], centre=CENTRE, scale=SCALE) for k in "ab")
        found.append(white @ (se2.between(a, b) - true))
    np.testing.assert_allclose(np.cov(np.array(found).T), np.eye(3), atol=0.1)
    np.testing.assert_allclose(
        module._whitening(true[None], np.array([9.0]), SCALE, 0.02), 3 * white[None]
    )


def test_an_adjusted_loop_is_the_dense_gauss_newton():
    patterns = ring(12)
    rng = np.random.default_rng(6)
    mosaic, links = build(drive(patterns, rng))
    adjusted, info = adjust(mosaic, links, fixed="0")
    means = links.means()
    poses = {k: p.copy() for k, p in mosaic.poses.items()}
    names = [k for k in poses if k != "0"]
    for _ in range(30):
        A, g = np.zeros((33, 33)), np.zeros(33)
        cost = 0.0
        for (i, j), link in means.items():
            z = link.pose
            across = np.array([-z[1], z[0], 1.0])
            C = 0.02**2 * np.outer(across, across)
            C += np.diag([2 * SCALE**2, 2 * SCALE**2, 0.02**2])
            inside = np.linalg.inv(matrix(poses[i])) @ matrix(poses[j])
            turn = poses[j][2] - poses[i][2] - z[2]
            r = np.array([*(inside[:2, 2] - z[:2]), math.remainder(turn, 2 * np.pi)])
            blocks = {}
            for name in {i, j} - {"0"}:
                columns = []
                for axis in range(3):
                    e = poses | {name: poses[name] + 1e-7 * np.eye(3)[axis]}
                    d = np.linalg.inv(matrix(e[i])) @ matrix(e[j]) - inside
                    spin = 1e-7 * (axis == 2) * (1 if name == j else -1)
                    columns.append(np.array([*d[:2, 2], spin]) / 1e-7)
                blocks[name] = np.array(columns).T
            W = link.count * np.linalg.inv(C)
            cost += r @ W @ r / 2
            for one, J in blocks.items():
                rows = slice(3 * names.index(one), 3 * names.index(one) + 3)
                g[rows] += J.T @ W @ r
                for two, L in blocks.items():
                    columns = slice(3 * names.index(two), 3 * names.index(two) + 3)
                    A[rows, columns] += J.T @ W @ L
        step = -np.linalg.solve(A, g).reshape(-1, 3)
        poses |= {name: poses[name] + step[k] for k, name in enumerate(names)}
    assert np.isclose(info.cost_after, cost, rtol=1e-6)
    for name, pose in poses.items():
        near(adjusted.poses[name], matrix(pose), 1e-6)
    np.testing.assert_array_equal(adjusted.poses["0"], mosaic.poses["0"])
    way = se2.between(adjusted.poses["4"], adjusted.poses["5"])
    np.testing.assert_allclose(info.residuals["4", "5"], means["4", "5"].pose - way, atol=1e-12)


def test_closing_the_loop_takes_the_drift_away():
    """What is left is noise: three numbers too many, so χ² of three degrees of freedom."""
    before, after, squares = [], [], []
    for seed in range(30):
        patterns = ring(12, seed=seed)
        mosaic, links = build(drive(patterns, np.random.default_rng(seed), repeat=1))
        adjusted, info = adjust(mosaic, links, fixed="0")
        squares.append(2 * info.cost_after)
        assert info.cost_after < info.cost_before
        before.append(errors(mosaic, patterns))
        after.append(errors(adjusted, patterns))
    assert np.median(after) < 0.5 * np.median(before)
    assert abs(np.mean(squares) - 3) < 4 * np.sqrt(6 / 30)


def test_a_chain_without_a_loop_is_its_own_adjustment():
    patterns = ring(10)
    pairs = [(k, k + 1) for k in range(9)]
    images = list(drive(patterns, np.random.default_rng(7), pairs=pairs, repeat=1))
    mosaic, links = build(images)
    adjusted, info = adjust(mosaic, links, fixed="0")
    assert errors(adjusted, mosaic.poses) < 1e-9
    assert info.cost_after < 1e-15


@given(POSES)
@settings(max_examples=5)
def test_moving_the_reference_moves_everything(start):
    patterns = ring(5)
    images = list(drive(patterns, np.random.default_rng(8)))
    one, _ = adjust(*build(images), fixed="0")
    other, _ = adjust(*build(images, start), fixed="0")
    for name, pose in one.poses.items():
        near(other.poses[name], matrix(start) @ matrix(pose), 1e-6)


def test_names_and_order_do_not_matter_to_first_order():
    patterns = ring(8)
    images = list(drive(patterns, np.random.default_rng(9), 0.05, 0.001))
    adjusted, _ = adjust(*build(images), fixed="0")
    new = {str(k): f"{'z' if k % 2 else 'a'}{9 - k}" for k in range(1, 8)} | {"0": "0"}
    renamed = [{new[k]: s for k, s in image.items()} for image in images]
    other, _ = adjust(*build(renamed), fixed="0")
    for name, pose in adjusted.poses.items():
        near(other.poses[new[name]], matrix(pose), 1e-5)


def test_what_was_seen_more_often_weighs_more():
    mosaic = Mosaic({"0": np.zeros(3), "1": np.array([0.5, 0, 0]), "2": np.ones(3)}, SCALE, CENTRE)
    links = Links()
    for shift, count in ((0.0, 30), (0.06, 1)):
        for _ in range(count):
            ends = {"0": np.zeros(3), "1": np.array([1 + shift, 0.0, 0.0])}
            image = {k: seen(np.zeros(3), p) for k, p in ends.items()}
            image["2"] = seen(np.zeros(3), [1.0, 1.0, 0.0])
            links = links.add(image, CENTRE, SCALE)
    adjusted, info = adjust(mosaic, links, fixed="0")
    assert np.isclose(adjusted.poses["1"][0], 1 + 0.06 / 31, atol=2e-4)
    assert info.links == 3


def test_a_robust_loss_outvotes_a_wrong_link():
    patterns = ring(8)
    both = [(k, (k + 2) % 8) for k in range(8)] + [(k, (k + 1) % 8) for k in range(8)]
    images = list(drive(patterns, np.random.default_rng(10), pairs=both))
    for image in images[24:27]:
        image["1"][:2] += 60
    first = [image for image in images if "0" in image]
    mosaic, links = build(first + images[:24] + images[24:])
    plain, _ = adjust(mosaic, links, fixed="0")
    robust, info = adjust(mosaic, links, fixed="0", loss="cauchy")
    assert errors(robust, patterns) < 0.3 * errors(plain, patterns)
    worst = max(info.residuals, key=lambda pair: np.linalg.norm(info.residuals[pair][:2]))
    assert worst == ("0", "1")


def test_what_hangs_on_nothing_is_named():
    patterns = ring(6)
    mosaic, links = build(drive(patterns))
    lonely = mosaic.with_pattern("lost", np.ones(3)).with_pattern("gone", np.ones(3))
    pair = {"lost": np.ones(4), "gone": np.zeros(4)}
    with pytest.raises(
        ValueError, match="links must lead from '0' to every pattern, not to 'lost', 'gone'"
    ):
        adjust(lonely, links.add(pair, CENTRE, SCALE), fixed="0")
    adjusted, info = adjust(mosaic, links.add(pair, CENTRE, SCALE), fixed="0")
    assert info.left_out == 1
    assert info.links == 6
    assert adjusted.poses.keys() == mosaic.poses.keys()
    with pytest.raises(ValueError, match="fixed must be the name of a pattern"):
        adjust(mosaic, links, fixed="x")
    single = Mosaic({"a": np.ones(3)}, SCALE, CENTRE)
    alone, info = adjust(single, Links(), fixed="a")
    assert info.iterations == 0
    np.testing.assert_array_equal(alone.poses["a"], np.ones(3))


def test_wrong_arguments():
    mosaic = Mosaic({"a": np.zeros(3), "b": np.array([0, 0, np.pi])}, SCALE, CENTRE)
    with pytest.raises(NoCommonPattern, match="sightings must have a pattern of the mosaic"):
        mosaic.locate({"c": np.zeros(4)})
    with pytest.raises(NoCommonPattern):
        mosaic.locate({})
    same = {"a": np.array([*CENTRE, 0, 1]), "b": np.array([*CENTRE, 0, 1])}
    with pytest.raises(ValueError, match="agree on a heading"):
        mosaic.locate(same)
    for weights in ({"a": -1.0}, {"a": 0.0, "b": 0.0}):
        with pytest.raises(ValueError, match="weights must be positive"):
            mosaic.locate(same, weights)
    with pytest.raises(ValueError, match="name must be that of a pattern of the mosaic, got 'c'"):
        mosaic.expected(np.zeros(3), "c")
    with pytest.raises(ValueError, match="order must be one of"):
        between_patterns(np.zeros(4), np.zeros(4), "last")
    with pytest.raises(ValueError, match=r"poses\['a'\] must be \(3,\)"), unchecked():
        Mosaic({"a": np.zeros(2)}, SCALE, CENTRE)
    with pytest.raises(ValueError, match="scale must be positive"):
        Mosaic({}, 0.0, CENTRE)


def test_a_mosaic_keeps_copies():
    pose = np.zeros(3)
    poses = {"a": pose}
    mosaic = Mosaic(poses, SCALE, CENTRE)
    more = mosaic.with_pattern("b", np.ones(3))
    pose[:] = 7
    poses["c"] = pose
    assert list(mosaic.poses) == ["a"]
    assert list(more.poses) == ["a", "b"]
    np.testing.assert_array_equal(mosaic.poses["a"], 0)
    moved = more.with_pattern("a", np.ones(3))
    np.testing.assert_array_equal(moved.poses["a"], 1)
    np.testing.assert_array_equal(more.poses["a"], 0)


# Paintings ----------------------------------------------------------------------------------------

SMALL = np.array([19.5, 14.5])  # the middle of a picture of 40 by 30


def noisy(seed=0, shape=(30, 40)):
    return np.random.default_rng(seed).integers(0, 256, shape, np.uint8)


def painted(images, poses, centre=SMALL, scale=0.5):
    return paint(images, np.array(poses, dtype=float).reshape(-1, 3), centre=centre, scale=scale)


def test_one_picture_is_its_own_painting():
    image = noisy()
    greys, seen_there, corner = painted([image], [(0, 0, 0)], SMALL + 3.5)
    np.testing.assert_array_equal(greys, image)
    assert seen_there.all()
    np.testing.assert_allclose(corner, -0.5 * (SMALL + 3.5))


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_turned_picture_is_turned(quarters):
    """By a quarter from x to y: what was to the right is below."""
    image = noisy()
    greys, seen_there, corner = painted([image], [(3, -2, quarters * math.pi / 2)])
    np.testing.assert_array_equal(greys, np.rot90(image, -quarters))
    assert seen_there.all()
    half = SMALL if quarters == 2 else SMALL[::-1]
    np.testing.assert_allclose(corner, [3, -2] - 0.5 * half, atol=1e-9)


def test_where_pictures_overlap_is_their_mean_and_where_none_is_nothing():
    images = [noisy(0), noisy(1), noisy(2)]
    greys, seen_there, corner = painted(iter(images), [(0, 0, 0), (5, 2, 0), (5, 2, 0)])
    assert greys.shape == (34, 50)
    expected, count = np.zeros((2, 34, 50))
    for image, (u, v) in zip(images, [(0, 0), (10, 4), (10, 4)], strict=True):
        expected[v : v + 30, u : u + 40] += image
        count[v : v + 30, u : u + 40] += 1
    np.testing.assert_array_equal(seen_there, count > 0)
    np.testing.assert_array_equal(greys[count == 0], 0)
    away = np.abs(greys - expected / np.maximum(count, 1))
    assert away.max() <= 0.5 + 1e-4
    np.testing.assert_allclose(corner, -0.5 * SMALL)


def test_the_painting_is_what_a_wider_camera_sees():
    """Eight pictures, turned and moved, against a single one."""
    ceiling = make_ceiling("varied", rng=np.random.default_rng(3), side=8.0)
    rng, poses = np.random.default_rng(0), []
    camera, scale = CeilingCamera(ceiling, Mount()), 2.5 / 200
    for k in range(8):
        poses.append(np.array([0.1 * k, 0.03 * k, 0.1 * k]) + rng.normal(0, 0.02, 3))
    greys, seen_there, corner = painted(map(camera.image, poses), poses, CENTRE, scale)
    wide = CeilingCamera(ceiling, Mount(size=greys.shape[::-1], centre=tuple(-corner / scale)))
    away = np.abs(greys.astype(float) - wide.image(np.zeros(3)))[seen_there]
    assert away.mean() < 2.0
    assert np.quantile(away, 0.99) < 12
    assert 0.5 < seen_there.mean() < 0.8
    for pose in poses:  # the pixel below each camera is seen
        u, v = np.rint((pose[:2] - corner) / scale).astype(int)
        assert seen_there[v, u]


@pytest.mark.parametrize(
    ("images", "poses", "said"),
    [
        ([], [], "images must be as many as poses, 0, got 0"),
        ([noisy()], [], "images must be as many as poses, 0, got more"),
        ([noisy()], [(0, 0, 0)] * 2, "images must be as many as poses, 2, got 1"),
        ([noisy()] * 3, [(0, 0, 0)] * 2, "images must be as many as poses, 2, got more"),
        ([noisy(), noisy(0, (3, 4))], [(0, 0, 0)] * 2, r"of one size, \(30, 40\), got \(3, 4\)"),
        ([noisy()] * 2, [(0, 0, 0), (9e3, 9e3, 0)], "poses must lie closer, got a painting of 180"),
    ],
)
def test_paintings_that_are_none(images, poses, said):
    with pytest.raises(ValueError, match=said), unchecked():
        painted(images, poses)

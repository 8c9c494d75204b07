"""Gates, fusion and maps against least squares, Monte Carlo and plans known exactly."""

import numpy as np
import pytest
from scipy import stats

from data_synth.laser import Scanner, scan
from robot_perception.evaluation.consistency import average_bounds, normalised_squared
from robot_perception.geometry import act, wrap_angle
from robot_perception.walls import (
    Extraction,
    Gate,
    RangeNoise,
    Segments,
    WallMap,
    build_map,
    distance_to_segments,
    explained,
    extract_segments,
    fit_line,
    merge,
    sample_faces,
    score_map,
    search,
    seen_from,
    to_world,
)

ROOM = np.array([[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]], dtype=float)
FACES = np.stack([ROOM[:-1], ROOM[1:]], axis=1)  # free space to the left
POSES = np.array([[1.5, 1.2, 0.2], [3, 2, 1.8], [4.5, 2.5, -2.5], [2, 2.8, -1.2], [3, 2, 3.0]])
FLAT = Scanner(resolution=0.0, spot=0.0, dropout=0.0, range_sigma=0.015)
CAREFUL = Extraction(RangeNoise(0.015))
EXACT = Gate(roughness=0.0, roughness_angle=0.0, probability=1 - 1e-9)


def wall(rho, theta, ends, sigma=(0.01, 0.01)):
    return Segments(
        np.array([[rho, theta]]),
        np.diag(np.square(sigma))[None],
        np.array([ends], dtype=float),
        np.array([[0, 9]]),
    )


def test_world_frame_of_line_and_ends_agree():
    segment = wall(2.0, 0.3, [[2, 0], [1, 1]])
    segment.ends[0] = [
        [2 * np.cos(0.3), 2 * np.sin(0.3)],
        [2 * np.cos(0.3) - np.sin(0.3), 2 * np.sin(0.3) + np.cos(0.3)],
    ]
    moved = to_world(segment, np.array([5.0, -3.0, 2.0]))
    rho, theta = moved.lines[0]
    np.testing.assert_allclose(moved.ends[0] @ [np.cos(theta), np.sin(theta)], [rho, rho])


def test_directions_in_the_world_stay_within_half_a_turn():
    moved = to_world(wall(2.0, 3.0, [[2, 0], [1, 1]]), np.array([5.0, -3.0, 2.0]))
    assert moved.lines[0, 1] == pytest.approx(5.0 - 2 * np.pi)


def test_uncertain_poses_make_an_uncertain_map():
    scans = scan(FACES, POSES[:1], FLAT, rng=np.random.default_rng(0))
    arguments = scans.ranges, FLAT.angles, POSES[:1], CAREFUL, Gate()
    pose_cov = np.diag([0.1, 0.2, 0.05]) ** 2
    segments, _ = extract_segments(scans.ranges[0], FLAT.angles, CAREFUL)
    for cov in (None, pose_cov):
        found, _ = build_map(*arguments, pose_cov=cov)
        np.testing.assert_allclose(found.covs, to_world(segments, POSES[0], cov).covs, rtol=1e-6)


def test_covariance_in_the_world_is_the_jacobian_by_finite_differences():
    line, pose = np.array([2.0, 0.3]), np.array([5.0, -3.0, 2.0])
    cov = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
    pose_cov = np.diag([1e-4, 4e-4, 1e-3])
    J = np.zeros((2, 5))
    for k in range(5):
        h = np.zeros(5)
        h[k] = 1e-6
        both = []
        for s in (1, -1):
            one = Segments(
                (line + s * h[:2])[None], cov[None], np.zeros((1, 2, 2)), np.eye(1, 2, dtype=int)
            )
            both.append(to_world(one, pose + s * h[2:]).lines[0])
        J[:, k] = (both[0] - both[1]) / 2e-6
    one = Segments(line[None], cov[None], np.zeros((1, 2, 2)), np.eye(1, 2, dtype=int))
    expected = J[:, :2] @ cov @ J[:, :2].T + J[:, 2:] @ pose_cov @ J[:, 2:].T
    np.testing.assert_allclose(to_world(one, pose, pose_cov).covs[0], expected, rtol=1e-6)


def test_moving_the_origin_there_and_back_changes_nothing():
    rng = np.random.default_rng(0)
    lines, covs = rng.normal(size=(3, 2)), np.broadcast_to(np.diag([0.1, 0.2]), (3, 2, 2))
    point = np.array([3.0, -7.0])
    back = seen_from(*seen_from(lines, covs, point), -point)
    np.testing.assert_allclose(back[0], lines, atol=1e-12)
    np.testing.assert_allclose(back[1], covs, atol=1e-12)


def test_gate_lets_its_probability_through():
    """Two looks at one wall: the share accepted is the χ² probability, without roughness."""
    rng, runs = np.random.default_rng(1), 3000
    angles = np.linspace(-0.5, 0.6, 50)
    noise = RangeNoise(0.02)
    ranges = 2.0 / np.cos(angles) + rng.normal(0, 0.02, (2, runs, 50))
    fits = [fit_line(r, angles, noise) for r in ranges]
    gate = Gate(probability=0.9, roughness=0.0, roughness_angle=0.0)
    ends = np.array([[[2.0, -1.0], [2.0, 1.2]]])
    accepted = 0
    for k in range(runs):
        known = WallMap(fits[0].mean[k, None], fits[0].cov[k, None], ends, np.ones(1, int))
        look = Segments(fits[1].mean[k, None], fits[1].cov[k, None], ends, np.array([[0, 49]]))
        accepted += search(known, look, 0, gate)[0][0]
    interval = stats.binomtest(int(accepted), runs, 0.9).proportion_ci(0.999)
    assert interval.low < 0.9 < interval.high


def at_middle(line, point):
    """Distance of a point from a line, and the direction."""
    return np.array([line[0] - point @ [np.cos(line[1]), np.sin(line[1])], line[1]])


@pytest.mark.parametrize("seed", range(8))
def test_distance_of_the_gate_is_mahalanobis_with_both_lines_seen_from_the_middle(seed):
    """Covariances by finite differences, the direction the short way round."""
    rng = np.random.default_rng(seed)
    theta = np.array([3.1, -3.1])[:: 1 if seed % 2 else -1] if seed < 4 else rng.uniform(-1, 1, 2)
    ends, rho = rng.normal(0, 3, (2, 2, 2)), rng.uniform(1, 4, 2)
    root = rng.normal(0, 0.1, (2, 2, 2))
    lines, covs, middle = np.stack([rho, theta], axis=-1), root @ root.mT, ends[1].mean(axis=0)
    seen = np.empty((2, 2, 2))
    for one, (line, cov) in enumerate(zip(lines, covs, strict=True)):
        J = np.stack(
            [(at_middle(line + h, middle) - at_middle(line - h, middle)) / 2e-6
             for h in 1e-6 * np.eye(2)], axis=-1,
        )  # fmt: skip
        seen[one] = J @ cov @ J.T
    gate = Gate(roughness=0.07, roughness_angle=0.2)
    e = at_middle(lines[0], middle) - at_middle(lines[1], middle)
    e[1] = (e[1] + np.pi) % (2 * np.pi) - np.pi
    S = seen.sum(axis=0) + np.diag([0.07**2, 0.2**2])
    known = WallMap(lines[:1], covs[:1], ends[:1], np.ones(1, int))
    look = Segments(lines[1:], covs[1:], ends[1:], np.array([[0, 9]]))
    _, (squared,) = search(known, look, 0, gate)
    assert squared == pytest.approx(e @ np.linalg.inv(S) @ e, rel=1e-5)


def test_gate_wants_the_same_front_overlap_and_nearness():
    known = merge(WallMap.empty(), wall(2.0, 0.0, [[2, -1], [2, 1]]), Gate())
    gate = Gate(widest_gap=0.5)

    def accepts(*args):
        return bool(search(known, wall(*args), 0, gate)[0][0])

    assert accepts(2.01, 0.01, [[2, 0], [2, 2]])
    assert accepts(2.0, 0.0, [[2, 1.4], [2, 3]])  # a hole of 0.4 m
    assert not accepts(2.0, 0.0, [[2, 1.6], [2, 3]])  # a hole of 0.6 m
    assert not accepts(2.3, 0.0, [[2.3, 0], [2.3, 2]])
    assert not accepts(2.0, 0.3, [[2, -1], [2, 1]])
    assert not accepts(-2.0, np.pi, [[2, -1], [2, 1]])  # its back


def test_fusion_is_the_weighted_least_squares_solution():
    one = wall(2.0, 0.01, [[2, -1], [2, 1]], (0.02, 0.01))
    two = wall(2.01, -0.005, [[2, 0], [2, 2]], (0.01, 0.03))
    fused = merge(merge(WallMap.empty(), one, Gate()), two, Gate())
    assert len(fused) == 1
    A, b = np.vstack([np.eye(2), np.eye(2)]), np.r_[one.lines[0], two.lines[0]]
    W = np.diag(1 / np.r_[np.diag(one.covs[0]), np.diag(two.covs[0])])
    np.testing.assert_allclose(fused.lines[0], np.linalg.solve(A.T @ W @ A, A.T @ W @ b), atol=2e-4)
    np.testing.assert_allclose(fused.covs[0], np.linalg.inv(A.T @ W @ A), rtol=0.05, atol=2e-6)
    assert fused.lengths[0] == pytest.approx(3.0, abs=0.05)
    assert fused.scans.tolist() == [2]


def test_segment_across_two_walls_joins_them():
    parts = [wall(2.0, 0.0, [[2, 0], [2, 1]]), wall(2.0, 0.0, [[2, 2], [2, 3]])]
    known = merge(merge(WallMap.empty(), parts[0], Gate()), parts[1], Gate())
    assert len(known) == 2
    joined = merge(known, wall(2.0, 0.0, [[2, 0.5], [2, 2.5]]), Gate())
    assert len(joined) == 1
    assert joined.lengths[0] == pytest.approx(3.0, abs=1e-6)
    assert joined.scans.tolist() == [2]  # each part was seen in one scan, for all we know the same
    assert (len(joined.seen_in(2)), len(joined.seen_in(3))) == (1, 0)
    assert len(known) == 2  # the old map is left alone


def together(*segments):
    """Several segments of one scan."""
    names = "lines", "covs", "ends", "spans"
    return Segments(*(np.concatenate([getattr(s, name) for s in segments]) for name in names))


def test_a_scan_counts_once_for_a_wall_that_it_shows_in_parts():
    left, right = wall(2.0, 0.0, [[2, -2], [2, -0.2]]), wall(2.0, 0.0, [[2, 0.2], [2, 2]])
    far = wall(3.0, np.pi / 2, [[-1, 3], [1, 3]])
    known = WallMap.empty()
    for seen in range(1, 4):
        known = merge(known, together(left, far, right, left), Gate())
        assert known.scans.tolist() == [seen, seen]
    once = merge(known, right, Gate())
    assert sorted(once.scans.tolist()) == [3, 4]
    parts = wall(2.0, 0.0, [[2, 3], [2, 4]])  # a wall of its own, until the hole is seen to be none
    apart = merge(merge(once, parts, Gate()), parts, Gate())
    assert sorted(apart.scans.tolist()) == [2, 3, 4]
    joined = merge(apart, together(right, wall(2.0, 0.0, [[2, 2], [2, 3]])), Gate())
    assert sorted(joined.scans.tolist()) == [3, 5]


@pytest.mark.parametrize("seed", range(4))
def test_no_wall_is_seen_in_more_scans_than_there_are(seed):
    """Of a room with pillars, whose walls most scans show in parts."""
    pillars = np.random.default_rng(seed).uniform([0.5, 0.4], [5.5, 3.6], (6, 2))
    box = np.array([[-0.1, -0.1], [-0.1, 0.1], [0.1, 0.1], [0.1, -0.1], [-0.1, -0.1]])
    sides = np.stack([box[:-1], box[1:]], axis=1)
    faces = np.concatenate([FACES, (pillars[:, None, None] + sides).reshape(-1, 2, 2)])
    poses = POSES[np.hypot(*(POSES[:, None, :2] - pillars).T).min(axis=0) > 0.4]
    scans = scan(faces, poses, FLAT, rng=np.random.default_rng(seed))
    found, _ = build_map(scans.ranges, FLAT.angles, poses, CAREFUL, Gate())
    assert len(poses) > 1
    assert found.scans.max() <= len(poses)


def test_order_of_the_scans_hardly_matters():
    scans = scan(FACES, POSES, FLAT, rng=np.random.default_rng(0))
    maps = [
        build_map(scans.ranges[o], FLAT.angles, POSES[o], CAREFUL, Gate())[0]
        for o in (np.arange(5), np.arange(5)[::-1])
    ]
    assert [len(m) for m in maps] == [4, 4]
    orders = [np.argsort(m.lines[:, 1]) for m in maps]
    np.testing.assert_allclose(maps[0].lines[orders[0]], maps[1].lines[orders[1]], atol=1e-3)


def test_map_of_a_room_is_its_four_walls_and_knows_its_uncertainty():
    truth = np.array([[0.0, -np.pi / 2], [6.0, 0.0], [4.0, np.pi / 2], [0.0, -np.pi]])
    errors, covs = [], []
    for rng in np.random.default_rng(2).spawn(60):
        scans = scan(FACES, POSES, FLAT, rng=rng)
        walls, _ = build_map(scans.ranges, FLAT.angles, POSES, CAREFUL, EXACT)
        assert len(walls) == 4
        error = walls.lines[:, None] - truth
        error[..., 1] = wrap_angle(error[..., 1])
        best = np.abs(error[..., 1]).argmin(axis=1)
        errors.append(error[np.arange(4), best])
        covs.append(walls.covs)
    nees = normalised_squared(np.array(errors), np.array(covs))
    low, high = average_bounds(2, nees.size, 0.999)
    # readings lost to the corners are chosen by the data, so the upper bound gets 30 % of grace
    assert low / 1.3 < nees.mean() < high * 1.3


def test_score_of_the_plan_itself_is_perfect_and_of_its_mirror_is_not():
    along = FACES[:, 1] - FACES[:, 0]
    theta = np.arctan2(-along[:, 0], along[:, 1])
    rho = FACES[:, 0, 0] * np.cos(theta) + FACES[:, 0, 1] * np.sin(theta)
    lines = np.stack([rho, theta], axis=-1)
    plan = WallMap(lines, np.tile(np.eye(2), (4, 1, 1)), FACES, np.ones(4, int))
    score = score_map(plan, FACES)
    assert (score.precision, score.recall) == (1.0, 1.0)
    np.testing.assert_allclose(score.offsets, 0, atol=1e-12)
    np.testing.assert_allclose(score.angles, 0, atol=1e-12)
    half = WallMap(lines[:2], plan.covs[:2], FACES[:2], plan.scans[:2])
    assert score_map(half, FACES).recall == pytest.approx(0.5, abs=0.02)
    back = WallMap(
        np.stack([-rho, wrap_angle(theta + np.pi)], axis=-1), plan.covs, FACES, plan.scans
    )
    assert score_map(back, FACES).precision == 0.0
    shifted = WallMap(
        lines + np.array([0.03, 0.0]), plan.covs, FACES + 0.03 * _normals(theta), plan.scans
    )
    np.testing.assert_allclose(score_map(shifted, FACES).offsets, 0.03)


def test_only_what_faces_alike_and_was_seen_is_found():
    lines = np.array([[2.0, 0.0], [2.1, np.pi]])  # a wall, and close behind it the back of one
    ends = np.array([[[2.0, -1.0], [2.0, 1.0]], [[2.1, -1.0], [2.1, 1.0]]])
    found = WallMap(lines, np.tile(np.eye(2), (2, 1, 1)), ends, np.ones(2, int))
    front = np.array([[[2.1, -1.0], [2.1, 1.0]]])  # of the plan, nearer to the map's back
    far, near = score_map(found, front, reach=0.05), score_map(found, front, reach=0.15)
    assert (far.recall, near.recall) == (0.0, 1.0)
    np.testing.assert_allclose(near.offsets, [-0.1])
    np.testing.assert_allclose(near.angles, [0.0])
    plan = np.concatenate([front, front + np.array([5.0, 0.0])])
    samples, _ = sample_faces(plan)
    seen = samples[:, 0] < 3.0
    both = score_map(found, plan, seen, reach=0.15)
    assert both.recall == 1.0


def test_errors_of_a_map_keep_their_common_part():
    along = FACES[:, 1] - FACES[:, 0]
    theta = wrap_angle(np.arctan2(-along[:, 0], along[:, 1]) + 0.01)  # of which one is near π
    rho = FACES[:, 0, 0] * np.cos(theta) + FACES[:, 0, 1] * np.sin(theta)
    off = 0.03 * _normals(theta - 0.01)
    turned = WallMap(
        np.stack([rho, theta], axis=-1), np.tile(np.eye(2), (4, 1, 1)), FACES + off, np.ones(4, int)
    )
    for sign in (1, -1):
        lines = wrap_angle(theta + (sign - 1) * 0.01)
        found = WallMap(np.stack([rho, lines], axis=-1), turned.covs, turned.ends, turned.scans)
        score = score_map(found, FACES)
        np.testing.assert_allclose(score.angles, sign * 0.01)
        assert (score.rms_angle, score.rms_offset) == pytest.approx((0.01, 0.03))


@pytest.mark.parametrize(
    ("point", "distance"), [((0.5, 0.3), 0.3), ((-0.3, 0.4), 0.5), ((1.3, 0.4), 0.5)]
)
def test_distance_to_a_segment_is_to_its_ends_beyond_them(point, distance):
    segment = np.array([[[0.0, 0.0], [1.0, 0.0]]])
    assert distance_to_segments(np.array([point]), segment).item() == pytest.approx(distance)


def _normals(theta):
    return np.stack([np.cos(theta), np.sin(theta)], axis=-1)[:, None]


def test_samples_stand_in_the_middle_of_equal_steps():
    points, owner = sample_faces(np.array([[[0.0, 0.0], [0.2, 0.0]], [[0.0, 0.0], [0.0, 0.01]]]))
    np.testing.assert_allclose(points[:4, 0], [0.025, 0.075, 0.125, 0.175])
    assert owner.tolist() == [0, 0, 0, 0, 1]
    longer = np.array([[[0.0, 0.0], [0.24, 0.0]]])  # nearly five steps
    assert len(sample_faces(longer)[0]) == 5


def test_readings_near_a_wall_are_explained():
    scans = scan(FACES, POSES, FLAT, rng=np.random.default_rng(0))
    walls, report = build_map(scans.ranges, FLAT.angles, POSES, CAREFUL, Gate())
    points = act(
        POSES,
        np.stack([scans.ranges * np.cos(FLAT.angles), scans.ranges * np.sin(FLAT.angles)], -1),
    )
    assert explained(points.reshape(-1, 2), walls, 0.06).mean() > 0.99
    assert not explained(np.array([[3.0, 2.0]]), walls, 0.06).any()
    assert report.readings == scans.ranges.size


def test_bad_input_is_named():
    segments, _ = extract_segments(np.full(50, 2.0), np.linspace(-0.2, 0.2, 50), Extraction())
    with pytest.raises(ValueError, match="pose must be three finite numbers"):
        to_world(segments, np.array([0.0, np.nan, 0.0]))
    with pytest.raises(ValueError, match="pose for each scan, got 0 and 0"):
        build_map(np.empty((0, 5)), np.linspace(0, 1, 5), np.empty((0, 3)), Extraction(), Gate())
    seen, angles = np.full((1, 50), 2.0), np.linspace(-0.2, 0.2, 50)
    for cov, words in ((np.full((3, 3), np.nan), "finite"), (-np.eye(3), "positive semi-definite")):
        with pytest.raises(ValueError, match=f"pose_cov must be {words}"):
            build_map(seen, angles, np.zeros((1, 3)), Extraction(), Gate(), pose_cov=cov)
        with pytest.raises(ValueError, match=f"pose_cov must be {words}"):
            to_world(segments, np.zeros(3), cov)
    with pytest.raises(ValueError, match="nothing to compare"):
        score_map(WallMap.empty(), FACES)
    for bad in ({"probability": 1.0}, {"roughness": -1.0}, {"widest_gap": np.nan}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            Gate(**bad)

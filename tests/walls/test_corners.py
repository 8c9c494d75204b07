"""Corners and poles of a scan: exact cases, Monte Carlo, a rendered building, hostile input."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.optimize import least_squares

from data_synth.building import drive, make_building
from data_synth.laser import Scanner, cast, scan
from robot_perception.geometry import act
from robot_perception.walls.corners import LandmarkRules, find_landmarks, fit_pole
from robot_perception.walls.segments import Extraction, RangeNoise
from tests.unchecked import unchecked

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 361)
RULES = LandmarkRules(Extraction(RangeNoise(0.01), tolerance=0.04, least_length=0.25), edge=0.0)


def look(*chains):
    """Return the exact ranges of walls that run from point to point."""
    faces = np.concatenate([np.stack([c[:-1], c[1:]], axis=1) for c in map(np.array, chains)])
    return cast(np.zeros(2), ANGLES, faces.astype(float))[0]


JUTS = look([[3, -2], [2, 0.3], [4, 1.5]])
RECESS = look([[1, -2.5], [3, 0.3], [1, 2.5]])


def circle(centre, radius=0.15):
    turn = np.linspace(0, -2 * np.pi, 721)
    return np.array(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


POLE = look([[5, -6], [5, 6]], circle([2.0, 0.4]))


@pytest.mark.parametrize(
    ("ranges", "place", "kind"),
    [
        (JUTS, (2, 0.3), "convex"),
        (RECESS, (3, 0.3), "concave"),
        (POLE, (2, 0.4), "pole"),
    ],
    ids=["juts out", "recess", "pole"],
)
def test_exact_scans_give_exact_landmarks_with_the_spread_of_many_noisy_ones(ranges, place, kind):
    exact, report = find_landmarks(ranges, ANGLES, RULES)
    assert report.kinds == (kind,)
    np.testing.assert_allclose(exact.values[0], place, atol=2e-4)
    rng = np.random.default_rng(0)
    noisy = [find_landmarks(ranges + rng.normal(0, 0.01, 361), ANGLES, RULES) for _ in range(400)]
    found = np.concatenate([seen.values[np.isin(told.kinds, kind)] for seen, told in noisy])
    assert len(found) > 380  # noise splits a wall now and then
    error = found - place
    nees = (error * np.linalg.solve(exact.covs[0], error.T).T).sum(axis=1)
    # a reading or two beyond a corner get into the fits: the tail is a little long, not the bulk
    low, high = stats.beta.ppf([1e-4, 1 - 1e-4], len(nees) / 2, len(nees) / 2)
    assert stats.chi2.ppf(low, 2) < np.median(nees) < stats.chi2.ppf(high, 2)
    assert np.mean(nees > stats.chi2.ppf(0.99, 2)) < 0.05


def test_a_wall_that_ends_in_front_of_another_is_no_corner():
    ranges = look([[2, -2], [2, 0.5]], [[2.6, 3], [2.6, 0.5], [5, 0.5]], [[5, -4], [5, 4]])
    landmarks, report = find_landmarks(ranges, ANGLES, RULES)
    assert len(landmarks) == 0
    # the far wall runs into the line of the near one's side, but neither is seen up to there
    side = look([[1.0, -1.0], [3.0, -1.0]], [[3.6, -2.0], [3.6, 3.0]])
    landmarks, report = find_landmarks(side, ANGLES, RULES)
    assert len(landmarks) == 0
    assert report.apart == 1


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_both_walls_must_be_seen_up_to_the_corner(side):
    """The wall behind is seen almost to the corner, the one before it ends 30 cm away."""
    ranges = look([[1.0, -1.0], [3.0, -1.0]], [[3.3, -2.0], [3.3, 3.0]])
    landmarks, report = find_landmarks(ranges[:: int(side)], ANGLES, RULES)
    assert len(landmarks) == 0
    assert report.apart == 1


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("place", "scale"), [(0.27, 1), (0.3, 1), (0.31, 1), (0.3, 3)])
def test_each_wall_may_end_by_the_spacing_of_its_own_readings_from_the_corner(side, place, scale):
    """One wall is met squarely, by close readings, the other grazed, by distant ones."""
    ranges = scale * look(np.array([[2, -2], [2, place], [4, place + 0.9]]) * [1, side])
    landmarks, report = find_landmarks(ranges, ANGLES, replace(RULES, reach=1e-4))
    assert report.kinds == ("convex",)
    np.testing.assert_allclose(landmarks.values[0], (2 * scale, side * place * scale), atol=6e-4)


@pytest.mark.parametrize(("bend_deg", "kinds"), [(38, ()), (42, ("convex",))])
def test_the_least_angle_is_that_between_the_walls(bend_deg, kinds):
    away = 2 * np.tan(np.deg2rad(bend_deg) / 2)
    bent = look([[2 + away, -2], [2, 0], [2 + away, 2]])
    _, report = find_landmarks(bent, ANGLES, replace(RULES, least_angle=np.deg2rad(40)))
    assert (report.kinds, report.flat) == (kinds, 1 - len(kinds))


def test_a_board_as_wide_as_a_pole_is_no_pole():
    board = look([[5, -6], [5, 6]], [[2.0, 0.25], [2.0, 0.55]])
    landmarks, report = find_landmarks(board, ANGLES, RULES)
    assert len(landmarks) == 0
    assert report.not_round == 1
    wall = look([[5, -6], [5, 6]], [[2.0, 0.1], [2.0, 0.9]])
    landmarks, report = find_landmarks(wall, ANGLES, RULES)
    assert len(landmarks) == report.not_round == 0  # too wide to be asked whether it is round


@given(st.floats(-0.6, 0.6), st.floats(0.06, 0.2))
def test_thin_poles_of_any_place_and_size(bearing, radius):
    centre = 2.5 * np.array([np.cos(bearing), np.sin(bearing)])
    ranges = look([[5, -9], [5, 9]], circle(centre, radius))
    landmarks, report = find_landmarks(ranges, ANGLES, replace(RULES, pole_radius=radius))
    assert report.kinds == ("pole",)
    np.testing.assert_allclose(landmarks.values[0], centre, atol=1e-3)


@given(st.floats(-0.5, 0.5))
def test_turning_the_scanner_turns_the_landmarks(turn):
    cos, sin = np.cos(turn), np.sin(turn)
    R = np.array([[cos, -sin], [sin, cos]])
    turned, _ = find_landmarks(look(np.array([[3, -2], [2, 0.3], [4, 1.5]]) @ R.T), ANGLES, RULES)
    still, _ = find_landmarks(JUTS, ANGLES, RULES)
    np.testing.assert_allclose(turned.values, still.values @ R.T, atol=1e-9)
    # other beams meet the walls, so the spread is the same only nearly
    np.testing.assert_allclose(turned.covs[0], R @ still.covs[0] @ R.T, rtol=0.35, atol=3e-6)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.ones((5, 2)), "points must lie in different directions, got 5 in one"),
        (np.outer([1.0, 2.0, 3.0], [3.0, 1.0]), "points must lie in different directions"),
        (np.zeros((5, 2)), "points must lie on one side of the scanner"),
        (np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]]), "points must lie on one side"),
        (np.array([[1.0, 0], [1, 0.1]]), "points must be at least 3, got 2"),
        (np.array([[1.0, 0], [1, 0.1], [np.nan, 0]]), "points must be finite"),
    ],
)
def test_points_that_no_pole_gives_are_refused(points, message):
    with pytest.raises(ValueError, match=message):
        fit_pole(points, 0.15, 0.02)


def test_circle_fit_agrees_with_a_general_optimiser():
    rng = np.random.default_rng(2)
    bearing = np.linspace(2.2, 4.2, 12)
    points = [3.0, 1.0] + 0.2 * np.stack([np.cos(bearing), np.sin(bearing)], axis=-1)
    points = points + rng.normal(0, 0.01, points.shape)
    centre, _ = fit_pole(points, 0.2, 0.01)
    other = least_squares(lambda c: np.hypot(*(points - c).T) - 0.2, [3.1, 1.1])
    np.testing.assert_allclose(centre, other.x, atol=1e-6)
    # squares are χ² with two degrees of freedom fewer than points: one pole in 1000 is lost
    largest = np.sqrt((other.fun**2).sum() / stats.chi2.ppf(0.999, len(points) - 2))
    assert fit_pole(points, 0.2, 0.99 * largest) is None
    assert fit_pole(points, 0.2, 1.01 * largest) is not None


@pytest.fixture(scope="module")
def building():
    return make_building(rng=np.random.default_rng(1))


@pytest.fixture(scope="module")
def found(building):
    """Landmarks of a drive: kind, the nearest true one's kind, distance and squared error."""
    poses = drive(building)[::7]
    scanner = Scanner(max_range=8.0)
    ranges = scan(building.faces, poses, scanner, rng=np.random.default_rng(0)).ranges
    rows = []
    for pose, row in zip(poses, ranges, strict=True):
        landmarks, report = find_landmarks(row, scanner.angles, LandmarkRules())
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        for place, at, cov, kind in zip(
            act(pose, landmarks.values),
            landmarks.values,
            landmarks.covs,
            report.kinds,
            strict=True,
        ):
            gaps = building.landmarks - place
            nearest = np.hypot(*gaps.T).argmin()
            error = gaps[nearest] @ np.array([[cos, -sin], [sin, cos]])
            nees = error @ np.linalg.solve(cov, error)
            rows.append((kind, building.kinds[nearest], np.hypot(*error), nees, np.hypot(*at)))
    return rows


def test_landmarks_of_the_building_are_true_ones(found):
    assert len(found) > 80
    false = [row for row in found if row[2] > 0.2 or row[0] != row[1]]
    assert len(false) <= 0.02 * len(found)


def test_errors_in_the_building_are_as_large_as_stated(found):
    nees = np.array([row[3] for row in found if row[2] <= 0.2])
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], 2 * nees.size) / nees.size
    assert low < nees.mean() < high
    assert np.mean(nees > stats.chi2.ppf(0.99, 2)) < 0.04


@pytest.mark.parametrize(
    "ranges",
    [
        np.full(361, np.inf),
        np.full(361, np.nan),
        np.zeros(361),
        np.full(361, -1.0),
        np.where(np.arange(361) == 180, 2.0, np.inf),
        np.where(np.arange(361) % 2, 2.0, np.nan),
    ],
    ids=["nothing", "NaN", "zeros", "negative", "one reading", "every second"],
)
def test_scans_without_landmarks_give_none(ranges):
    landmarks, report = find_landmarks(ranges, ANGLES, LandmarkRules())
    assert len(landmarks) == len(report.kinds) == 0
    assert landmarks.values.shape == (0, 2)
    assert landmarks.covs.shape == (0, 2, 2)
    assert report.readings.readings == 361


def test_empty_scan_and_unfit_shapes():
    assert len(find_landmarks(np.empty(0), np.empty(0), LandmarkRules())[0]) == 0
    with unchecked(), pytest.raises(ValueError, match=r"\(3,\) and \(4,\)"):
        find_landmarks(np.ones(3), np.arange(4.0), LandmarkRules())


@given(st.lists(st.one_of(st.floats(0.05, 9), st.just(np.inf), st.just(np.nan)), max_size=200))
def test_any_scan_gives_finite_landmarks_with_proper_covariances(values):
    ranges = np.array(values)
    landmarks, _ = find_landmarks(ranges, np.linspace(-1.5, 1.5, ranges.size), LandmarkRules())
    assert np.isfinite(landmarks.values).all()
    assert (np.linalg.eigvalsh(landmarks.covs) > 0).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("least_angle", 0.0),
        ("least_angle", 2.0),
        ("reach", -1.0),
        ("pole_radius", np.inf),
        ("step", np.nan),
        ("edge", -0.1),
        ("least_on_pole", 2),
    ],
)
def test_bad_rules_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        LandmarkRules(**{name: value})

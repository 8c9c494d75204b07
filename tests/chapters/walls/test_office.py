"""The drive through an office, its map, its gates, its mistakes, and the search range of a wall."""

import numpy as np
import pytest
from scipy import stats

from data_synth.laser import scan
from robot_perception import walls
from robot_perception.book import walls as page
from robot_perception.chapters.walls.recordings import world_points
from tests.unchecked import unchecked


@pytest.fixture(scope="module")
def ride():
    with unchecked():
        return page.driven(np.random.default_rng(4), rooms=2, step=0.8)


@pytest.fixture(scope="module")
def found(ride):
    with unchecked():
        return page.to_map(ride)


def test_the_map_is_that_of_the_library(ride, found):
    with unchecked():
        again, _ = walls.build_map(
            ride.ranges, page.SCANNER.angles, ride.poses, page.RULES, page.GATE
        )
    np.testing.assert_array_equal(found.lines, again.lines)


def test_samples_are_seen_if_ten_beams_meet_their_face_within_ten_centimetres():
    rng = np.random.default_rng(4)
    office = page.floor.make_office(rng=rng, rooms=2)
    poses = page.floor.drive(office, step=0.8)
    scans = scan(office.faces, poses, page.SCANNER, rng=rng)
    reached = page.reached(office, poses, scans)
    samples, owner = walls.sample_faces(office.faces)
    valid = np.isfinite(scans.ranges)
    hits = world_points(np.where(valid, scans.true_ranges, np.inf), page.SCANNER.angles, poses)
    faces = scans.faces[valid]
    assert len(samples) == len(reached)
    assert 0.3 < reached.mean() < 1.0
    for k in range(0, len(samples), 50):
        near = np.linalg.norm(hits[faces == owner[k]] - samples[k], axis=-1) <= 0.1
        assert reached[k] == (near.sum() >= 10)


def test_mistakes_are_metres_that_are_not_real_and_metres_that_are_missing(ride, found):
    """Oracle: a wall in the middle of nowhere adds its length, a wall left out what it covers."""
    length = 0.05 * ride.seen.sum()
    unreal, missed = page.mistakes(found, ride)
    ghost = np.array([[[100.0, 0], [102.0, 0]]])
    more = walls.WallMap(
        np.r_[found.lines, [[0.0, np.pi / 2]]],
        np.r_[found.covs, 1e-6 * np.eye(2)[None]],
        np.r_[found.ends, ghost],
        np.r_[found.scans, 1],
    )
    assert page.mistakes(more, ride)[0] == pytest.approx(unreal + 2.0 / length, rel=0.02)
    assert page.mistakes(more, ride)[1] == pytest.approx(missed)
    assert page.mistakes(walls.WallMap.empty(), ride) == (0.0, 1.0)
    longest = found.lengths.argmax()
    left = page.chosen(found, np.arange(len(found)) != longest)
    assert page.mistakes(left, ride)[1] > missed + 0.5 * found.lengths[longest] / length


@pytest.mark.slow
def test_chance_and_length_leave_as_many_walls_as_validation():
    with unchecked():
        counts = [page.validated.but(by=by).trial(office=9100, wrong=0.02)["walls"]
                  for by in ("scans", "chance", "length")]  # fmt: skip
    np.testing.assert_array_equal(counts[0], counts[1])
    np.testing.assert_array_equal(counts[0], counts[2])
    assert (np.diff(counts[0]) <= 0).all()


@pytest.mark.slow
def test_without_patience_all_three_rules_believe_everything():
    with unchecked():
        firsts = {page.validated.but(by=by).trial(office=9100, wrong=0.02)["mistakes"][0]
                  for by in ("scans", "chance", "length")}  # fmt: skip
    assert len({round(one, 12) for one in firsts}) == 1


def test_search_range_widens_away_from_the_readings_and_with_noise_and_shrinks_with_readings():
    band = page.search_range()
    assert band.half_width.argmin() in range(25, 36)
    assert (page.search_range(sigma=0.05).half_width > band.half_width).all()
    assert (page.search_range(readings=60).half_width < band.half_width).all()


def test_search_range_is_the_central_interval_of_the_height_of_the_line():
    """Oracle: the variance of the distance of a point from the line, by finite differences."""
    band, rough = (page.search_range(probability=0.95, roughness=r) for r in (0.0, 0.03))
    z = stats.norm.ppf(0.975)
    np.testing.assert_allclose(rough.half_width**2 - band.half_width**2, (z * 0.03) ** 2)
    angles = np.deg2rad(0.5) * (np.arange(30) - 14.5) + np.pi / 2
    ranges = 2.0 / np.sin(angles) + 0.02 * np.random.default_rng(0).normal(size=30)
    line = walls.fit_line(ranges, angles, walls.RangeNoise(0.02))
    along = np.array([-np.sin(line.mean[1]), np.cos(line.mean[1])])
    middle = walls.to_points(ranges, angles).mean(axis=0)
    for s, half in zip(band.along, band.half_width, strict=True):
        point = middle + s * along

        def height(rho, theta, point=point):
            return point @ [np.cos(theta), np.sin(theta)] - rho

        steps = 1e-6 * np.eye(2)
        J = np.array([height(*(line.mean + h)) - height(*(line.mean - h)) for h in steps]) / 2e-6
        assert half == pytest.approx(z * np.sqrt(J @ line.cov @ J), rel=1e-6)


def test_readings_of_the_search_range_lie_along_its_wall():
    found = page.search_range(sigma=0.001).readings
    assert np.ptp(found[:, 0]) > 0.4
    assert np.abs(found[:, 1]).max() < 0.005


def test_line_covariance_is_consistent_and_half_the_noise_is_not():
    assert page.fitted.rows().of("nees").mean() == pytest.approx(2.0, abs=0.15)
    assert page.fitted.run(runs=500, stated=0.01).of("nees").mean() == pytest.approx(8.0, abs=1)


@pytest.mark.slow
def test_growing_map_ends_as_the_map_of_the_drive():
    with unchecked():
        frames, ride = page.growing_map(), page.chapter_drive()
        whole = page.to_map(ride)
    assert len(ride.poses) == page.SCANS
    assert list(frames) == page.FRAMES
    np.testing.assert_allclose(frames[page.SCANS].found.lines, whole.lines)
    assert all(len(frame.points) <= 3000 for frame in frames.values())

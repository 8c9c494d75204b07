"""The drive through an office, its map, its gates, and the search range of a wall."""

import numpy as np
import pytest
from scipy import stats

from robot_perception import walls
from robot_perception.chapters.walls import office
from robot_perception.teaching.badges import recorded
from tests.unchecked import unchecked

SMALL = office.Config(rooms=2, step=0.8)


@pytest.fixture(scope="module")
def result():
    return office.run(SMALL, rng=np.random.default_rng(4))


def test_same_seed_gives_the_same_map(result):
    with unchecked():
        one, two = result, office.run(SMALL, rng=np.random.default_rng(4))
    np.testing.assert_array_equal(one.found.lines, two.found.lines)
    assert one.score.precision == two.score.precision > 0.8


def test_samples_are_seen_if_ten_beams_meet_their_face_within_ten_centimetres(result):
    samples, owner = walls.sample_faces(result.office.faces)
    valid = np.isfinite(result.scans.ranges)
    hits = office.world_points(
        np.where(valid, result.scans.true_ranges, np.inf), SMALL.scanner.angles, result.poses
    )
    faces = result.scans.faces[valid]
    assert set(owner[result.seen]) <= set(np.unique(faces))
    assert len(samples) == len(result.seen)
    assert 0.3 < result.seen.mean() < 1.0
    for k in range(0, len(samples), 50):
        near = np.linalg.norm(hits[faces == owner[k]] - samples[k], axis=-1) <= 0.1
        assert result.seen[k] == (near.sum() >= 10)


def test_search_range_widens_away_from_the_readings_and_with_noise_and_shrinks_with_readings():
    band = office.search_range()
    assert band.half_width.argmin() in range(25, 36)
    assert (office.search_range(sigma=0.05).half_width > band.half_width).all()
    assert (office.search_range(readings=60).half_width < band.half_width).all()


def test_search_range_is_the_central_interval_of_the_height_of_the_line():
    """Oracle: the variance of the distance of a point from the line, by finite differences."""
    band, rough = (office.search_range(probability=0.95, roughness=r) for r in (0.0, 0.03))
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
    found = office.search_range(sigma=0.001).readings
    assert np.ptp(found[:, 0]) > 0.4
    assert np.abs(found[:, 1]).max() < 0.005


def test_line_covariance_is_consistent():
    nees = office.line_nees(4000, np.random.default_rng(0))
    assert nees.mean() == pytest.approx(2.0, abs=0.15)


def test_growing_map_ends_as_the_map_of_the_drive():
    with unchecked():
        frames, result = office.growing_map(), office.office_run()
    assert frames[-1].scans == len(result.poses)
    last = frames[-1].found.seen_in(result.config.least_scans)
    np.testing.assert_allclose(last.lines, result.found.lines)
    assert all(len(f.points) <= 3000 for f in frames)


def test_set_up_says_what_the_paper_leaves_out_and_what_we_take():
    table = office.setup()
    assert len(table.rows) <= 6
    assert table["tolerance ε", "the paper"] == "not given"
    assert table["tolerance ε", "ours"] == "8 cm, or 5σ"
    assert table["noise σ of a range", "ours"] == "1.5 cm, and steps of 1 cm"


def test_scores_stand_beside_those_of_the_ledger(result):
    claim = recorded()["walls-fig1"]
    table = office.scores(result, claim)
    assert table["this office", "walls"] == len(result.found)
    unreal = table["this office", "not real (%)"]
    assert unreal == pytest.approx(100 - 100 * result.score.precision)
    many = table["twenty offices", "not real (%)"]
    assert many.estimate == pytest.approx(100 - 100 * claim.value.estimate)
    assert 0 < many.low < many.estimate < many.high
    assert result.seconds > 0

"""The chapter "Walls from laser scans": its worlds, its figures' data, its exercises."""

import numpy as np
import pytest

from robot_perception.chapters import walls
from robot_perception.walls import (
    count_distances,
    find_split,
    is_simple,
    simplify,
    simplify_path_hull,
    simplify_recursive,
)


def test_worst_case_cuts_off_one_vertex_at_each_split_and_is_simple():
    chain = walls.worst_case(200)
    splits = [(s.i, s.f) for s in walls.recursion(chain, 0.1) if s.split]
    assert splits == [(i, i + 1) for i in range(198)]
    assert is_simple(chain)
    assert count_distances(chain, 0.1) == 199 * 198 // 2
    np.testing.assert_array_equal(simplify_path_hull(chain, 0.1), np.arange(200))


def test_steps_of_the_recursion_are_those_of_the_library():
    chain = walls.one_scan().points
    steps = walls.recursion(chain, 0.08)
    kept = sorted({0, len(chain) - 1, *(s.f for s in steps if s.split)})
    assert kept == simplify_recursive(chain, 0.08).tolist()
    assert sum(s.j - s.i - 1 for s in steps) == count_distances(chain, 0.08)


def test_exponent_of_an_exact_power_law_has_no_width():
    interval = walls.exponent((10, 20, 40, 80), 3.0 * np.array([10, 20, 40, 80.0]) ** 1.7)
    assert (interval.low, interval.high) == pytest.approx((1.7, 1.7))


def test_brute_force_reference_agrees_on_every_kind_of_simple_chain():
    for rng in np.random.default_rng(3).spawn(60):
        chain = walls.simple_chain(rng)
        assert is_simple(chain)
        assert simplify(chain, 0.3).tolist() == walls.reference_vertices(chain, 0.3)


def test_printed_measure_is_distance_over_length():
    rng = np.random.default_rng(0)
    for triple in rng.normal(size=(20, 3, 2)):
        length = np.linalg.norm(triple[2] - triple[0])
        expected = find_split(triple, 0, 2)[1] / length
        assert walls.printed_measure(triple, 0, 2)[0] == pytest.approx(expected)


def test_printed_rule_does_not_care_for_the_scale_and_the_right_rule_does():
    kept = walls.kept_by_scale()
    assert len(set(kept["printed"])) == 1
    assert (np.diff(kept["distance"]) >= 0).all()
    assert kept["distance"][0] < kept["distance"][-1]


def test_example_of_a_crossing_chain_goes_wrong_and_its_edges_are_named():
    example = walls.crossing_example()
    assert not np.array_equal(example.plain, example.hulls)
    assert len(example.edges) > 0


def test_same_seed_gives_the_same_map():
    config = walls.Config(rooms=2, step=0.8)
    one, two = (walls.run(config, rng=np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(one.walls.lines, two.walls.lines)
    assert one.score.precision == two.score.precision > 0.8


def test_every_face_reached_by_a_beam_is_seen_and_no_other():
    result = walls.run(walls.Config(rooms=2, step=0.8), rng=np.random.default_rng(4))
    samples, owner = walls.sample_faces(result.office.faces)
    hit = np.unique(result.scans.faces[np.isfinite(result.scans.ranges)])
    assert set(owner[result.seen]) <= set(hit)
    assert len(samples) == len(result.seen)
    assert 0.3 < result.seen.mean() < 1.0


def test_search_range_widens_away_from_the_readings_and_with_noise_and_shrinks_with_readings():
    band = walls.search_range()
    assert band.half_width.argmin() in range(25, 36)
    assert (walls.search_range(sigma=0.05).half_width > band.half_width).all()
    assert (walls.search_range(readings=60).half_width < band.half_width).all()


def test_line_covariance_is_consistent():
    nees = walls.line_consistency(4000, np.random.default_rng(0))
    assert nees.mean() == pytest.approx(2.0, abs=0.15)


def test_growing_map_ends_as_the_map_of_the_drive():
    frames = walls.growing_map()
    result = walls.office_run()
    assert frames[-1].scans == len(result.poses)
    last = frames[-1].walls.seen_in(result.config.least_scans)
    np.testing.assert_allclose(last.lines, result.walls.lines)
    assert all(len(f.points) <= 3000 for f in frames)


def test_the_scan_of_the_opening_has_361_readings_and_eight_walls():
    look = walls.one_scan()
    assert (look.ranges.size, len(look.segments)) == (361, 8)


def test_any_tolerance_from_three_sigma_to_the_size_of_things_finds_all_walls():
    study = walls.tolerance_study()
    assert study["good"] > 10
    assert study["right"] <= study["noisy"] / 2


def test_gate_without_roughness_founds_new_walls_and_a_wide_one_loses_them():
    study = walls.gate_study((0.0, 0.02, 0.6))
    assert study.walls[0] > 1.5 * study.walls[1] > 3 * study.walls[2]
    assert study.precision[1] > 0.9
    assert study.missed[1] < 0.1 < study.missed[2]
    assert study.believed < 0.005


def test_three_looks_weed_out_what_is_not_there():
    looks = walls.looks_study()
    assert looks["gone"] > 0
    assert looks["after"] > looks["before"]
    assert looks["cost"] < 0.02


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("walls-1", 999 * 998 // 2, 1000 * 999 // 2),
        ("walls-2", [[0, 0], [15, 0.1], [10, 0]], [[0, 0], [5, 0.1], [10, 0]]),
        ("walls-3", 0.5, 0.05),
        ("walls-4", "only if the pose stood still", "yes"),
    ],
)
def test_exercises_know_right_from_wrong(key, right, wrong):
    assert walls.EXERCISES[key].judge(right)[0] == "right"
    assert walls.EXERCISES[key].judge(wrong)[0] == "wrong"
    assert walls.EXERCISES[key].judge(...)[0] == "not yet"

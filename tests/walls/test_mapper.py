"""Scans to a map, one by one."""

import numpy as np
import pytest

from data_synth.laser import Scanner, scan
from robot_perception.walls import (
    Extraction,
    Gate,
    RangeNoise,
    ScanReport,
    WallMap,
    WallMapper,
    build_map,
    extract_segments,
    merge,
    to_world,
)
from tests.unchecked import unchecked

ROOM = np.array([[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]], dtype=float)
FACES = np.stack([ROOM[:-1], ROOM[1:]], axis=1)  # free space to the left
POSES = np.array([[1.5, 1.2, 0.2], [3, 2, 1.8], [4.5, 2.5, -2.5], [2, 2.8, -1.2], [3, 2, 3.0]])
SCANNER = Scanner()
RANGES = scan(FACES, POSES, SCANNER, rng=np.random.default_rng(0)).ranges
RULES, COV = Extraction(RangeNoise(0.0155)), 1e-5 * np.eye(3)
GATE = Gate(probability=0.3, roughness=0.0, roughness_angle=0.0)  # so narrow that walls are twins


def mapped(cov=COV):
    mapper = WallMapper(SCANNER.angles, RULES, GATE, cov)
    state, infos = mapper.start(), []
    for ranges, pose in zip(RANGES, POSES, strict=True):
        state, info = mapper.step(state, ranges, pose)
        infos.append(info)
    return state, infos


def test_step_by_step_the_map_is_the_one_that_its_three_parts_make():
    """Oracle: extract, move, merge, each by hand."""
    state, infos = mapped()
    expected = WallMapper(SCANNER.angles).start()
    for ranges, pose, info in zip(RANGES, POSES, infos, strict=True):
        segments, report = extract_segments(ranges, SCANNER.angles, RULES)
        segments = to_world(segments, pose, COV)
        np.testing.assert_array_equal(info.segments.lines, segments.lines)
        assert info.report == report
        expected = merge(expected, segments, GATE)
    for name in ("lines", "covs", "ends", "scans"):
        np.testing.assert_array_equal(getattr(state, name), getattr(expected, name))
    assert state.scans.max() > 1


def test_a_whole_drive_gives_the_map_of_its_last_step_and_the_sum_of_its_reports():
    state, infos = mapped()
    found, report = build_map(RANGES, SCANNER.angles, POSES, RULES, GATE, pose_cov=COV)
    np.testing.assert_array_equal(found.lines, state.lines)
    total = ScanReport(0, 0, 0, 0, 0, 0, 0)
    for info in infos:
        total += info.report
    assert report == total


def test_poses_that_may_be_wrong_leave_walls_that_are_less_sure():
    sure, unsure = (
        WallMapper(SCANNER.angles, RULES, Gate(), cov).step(WallMap.empty(), RANGES[0], POSES[0])[0]
        for cov in (None, 1e-4 * np.eye(3))
    )
    assert (unsure.covs[:, 0, 0] > sure.covs[:, 0, 0] + 0.9e-4).all()


def test_a_scan_of_another_scanner_is_refused():
    mapper = WallMapper(SCANNER.angles, RULES, GATE)
    with (
        unchecked(),
        pytest.raises(ValueError, match=r"one range per angle, got \(10,\) and \(361,\)"),
    ):
        mapper.step(mapper.start(), RANGES[0, :10], POSES[0])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"angles": SCANNER.angles[::-1]}, "strictly increasing"),
        ({"pose_cov": -np.eye(3)}, "pose_cov"),
        ({"pose_cov": np.eye(2)}, "pose_cov"),
    ],
)
def test_rules_are_checked_when_the_mapper_is_made(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        WallMapper(**{"angles": SCANNER.angles} | wrong)

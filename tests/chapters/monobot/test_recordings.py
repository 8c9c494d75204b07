"""A real corridor as a monobot, and one that is written here."""

import gzip

import numpy as np
import pytest

from robot_perception.chapters.monobot import recordings
from robot_perception.evaluation.consistency import average_bounds, normalised_squared


def write_log(folder, *, wall, turn):
    """Write a log of a robot that drives towards a wall, with its heading off by ``turn``."""
    directions = np.radians(np.arange(-90, 90))
    lines = []
    for k in range(90):
        x, heading = 0.5 * k, turn * (-1) ** k
        toward = np.cos(directions + heading)
        ranges = np.where(toward > 0.5, (wall - x) / np.maximum(toward, 0.5), 81.9)
        pose = f"{x * np.cos(0.3):.6f} {x * np.sin(0.3):.6f} {0.3 + heading:.6f}"
        wheels = f"{1.02 * x:.6f} 0 {heading:.6f}"
        readings = " ".join(f"{r:.4f}" for r in ranges)
        lines.append(f"FLASER 180 {readings} {pose} {wheels} {k} here {k}")
    with gzip.open(folder / recordings.LOG, "wt") as file:
        file.write("\n".join(lines) + "\n")


@pytest.mark.parametrize("turn", [0.0, np.radians(12)])
def test_corridor_reads_distances_and_moves_from_a_log(tmp_path, turn):
    write_log(tmp_path, wall=50.0, turn=turn)
    stretch = recordings.corridor(tmp_path)
    x = 0.5 * np.arange(90)[recordings.SCANS]
    np.testing.assert_allclose(stretch.measurements, 50.0 - x, atol=0.02)
    np.testing.assert_allclose(stretch.commands, 1.02 * 0.5, atol=1e-5)
    np.testing.assert_allclose(stretch.track, x - x[0], atol=1e-5)


def test_two_origins_give_one_map(tmp_path):
    write_log(tmp_path, wall=50.0, turn=0.0)
    stretch = recordings.corridor(tmp_path)
    here, there = (recordings.filter_corridor(stretch, origin=o) for o in (0.0, 100.0))
    np.testing.assert_allclose(there.means - here.means, 100.0, atol=1e-9)
    np.testing.assert_allclose(there.innovations, here.innovations, atol=1e-9)
    np.testing.assert_array_equal(there.covs, here.covs)


def test_real_corridor_is_a_monobot():
    stretch = recordings.CORRIDOR.read().result
    run = recordings.filter_corridor(stretch, origin=0.0)
    nis = normalised_squared(run.innovations[0], run.innovation_covs[0])
    low, high = average_bounds(1, nis.size, 0.99)
    assert low < nis.mean() < high
    wall = stretch.track + stretch.measurements
    assert abs(run.means[0, -1, 1] - np.median(wall)) < 0.1


def test_innovations_of_the_corridor_are_rather_small_and_not_too_small():
    stretch = recordings.CORRIDOR.read().result
    here, there = (recordings.filter_corridor(stretch, origin=origin) for origin in (0.0, 100.0))
    said = recordings.compared(here, there)
    assert said["shift"] == pytest.approx(100)
    assert np.ptp(there.means - here.means) < 1e-9
    assert said["start"] < said["wall"] < 1.1 * said["start"]
    assert said["share"] == pytest.approx(0.52, abs=0.01)
    assert said["count"] == 15
    assert 5 < said["percentile"] < 10

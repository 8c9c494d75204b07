"""The real recordings, where they are: counts, conventions, and agreement with verified relations.

Run with ROBOT_PERCEPTION_DATA naming the directory that holds them.
"""

import gzip

import numpy as np
import pytest

from robot_perception import datasets
from robot_perception.datasets import read_carmen_log, read_graph_log, read_relations
from robot_perception.geometry import wrap_angle
from robot_perception.geometry.se2 import between
from tests.datasets.here import recording

# Scans, beams, no-return threshold, lines of other kinds.
CARMEN = {
    ("carmen_intel", "intel_odom_and_corrected.log.gz"): (910, 180, 80.0, 0),
    ("carmen_corrected", "freiburg-079-corrected.log.gz"): (4791, 360, 80.0, 14705),
    ("carmen_corrected", "aces-corrected.log.gz"): (440, 180, 50.0, 8260),
    ("carmen_corrected", "orebro-corrected.log.gz"): (237, 181, 32.759, 492),
    ("carmen_corrected", "fhw-corrected.log.gz"): (488, 180, 50.0, 14428),
    ("carmen_corrected", "acapulco-corrected.log.gz"): (861, 181, 50.0, 13003),
    ("carmen_corrected", "intel-corrected.log.gz"): (910, 180, 80.0, 15455),
    ("malaga_sena", "sena_one_loop_odom.log.gz"): (225, 361, 80.0, 0),
}


@pytest.mark.parametrize(("place", "expected"), CARMEN.items(), ids=lambda value: str(value[-1]))
def test_carmen_logs_hold_what_is_known_of_them(place, expected):
    log = read_carmen_log(recording(*place), timed="orebro" not in place[1])
    scans, beams, threshold, others = expected
    assert log.ranges.shape == (scans, beams)
    assert log.max_range == threshold
    assert sum(log.report.others.values()) == others
    assert np.isinf(log.ranges).any()
    assert log.ranges[np.isfinite(log.ranges)].max() < threshold
    if place[0] == "carmen_corrected":  # both poses of these logs are the corrected one
        np.testing.assert_array_equal(log.poses, log.odometry)


@pytest.mark.parametrize(
    ("place", "scans", "beams", "edges"),
    [
        (("carmen_fr079", "fr079_graph.log.gz"), 1464, 360, 2307),
        (("carmen_intel", "intel_graph.log.gz"), 2672, 180, 3901),
    ],
)
def test_graph_logs_hold_what_is_known_of_them(place, scans, beams, edges):
    log = read_graph_log(recording(*place))
    assert log.ranges.shape == (scans, beams)
    assert log.vertices.shape == (scans, 3)
    assert log.edges.shape == (edges, 2)
    np.testing.assert_array_equal(log.scan_vertices, np.arange(scans))
    np.testing.assert_allclose(log.vertices[log.scan_vertices], log.odometry, atol=0.006)
    np.testing.assert_allclose(log.angles[0], -np.pi / 2, atol=1e-6)
    assert (np.linalg.eigvalsh(log.information) > 0).all()
    assert np.percentile(np.abs(between(*log.vertices[log.edges.T]) - log.motions), 50) < 0.05


def test_edges_of_freiburg_agree_with_the_vertices():
    """An edge is the second pose seen from the first: the other order would be metres off."""
    log = read_graph_log(recording("carmen_fr079", "fr079_graph.log.gz"))
    first, second = log.vertices[log.edges.T]
    error = np.abs(between(first, second)[:, :2] - log.motions[:, :2])
    other = np.abs(between(second, first)[:, :2] - log.motions[:, :2])
    assert np.median(error) < 0.02
    assert np.median(other) > 5 * np.median(error)


def test_laser_of_sena_is_ahead_of_the_wheels():
    log = read_carmen_log(recording("malaga_sena", "sena_one_loop_odom.log.gz"))
    ahead = np.stack([np.cos(log.odometry[:, 2]), np.sin(log.odometry[:, 2])], axis=1)
    np.testing.assert_allclose(log.poses[:, :2], log.odometry[:, :2] + 0.78 * ahead, atol=1e-3)


@pytest.mark.parametrize(
    ("place", "relations", "count", "matched", "metres", "degrees"),
    [
        (("carmen_intel", "intel_graph.log.gz"), "intel.relations.gz", 2984, 305, 0.03, 0.45),
        (
            ("carmen_intel", "intel_odom_and_corrected.log.gz"),
            "intel.relations.gz",
            2984,
            92,
            0.04,
            0.55,
        ),
        (("carmen_fr079", "fr079_graph.log.gz"), "fr079.relations.gz", 1685, 136, 0.045, 0.55),
    ],
)
def test_poses_agree_with_the_verified_relations(place, relations, count, matched, metres, degrees):
    """Mean error of relative poses; relations are between robot poses, not laser poses."""
    verified = read_relations(recording(place[0], relations))
    assert len(verified.times) == count
    path = recording(*place)
    if "graph" in place[1]:
        log = read_graph_log(path)
        poses = log.vertices[log.scan_vertices]
    else:
        log = read_carmen_log(path)
        poses = log.poses
    rows, scans = verified.match(log.times)
    assert len(rows) == matched
    error = between(*poses[scans.T]) - verified.planar[rows]
    assert np.hypot(error[:, 0], error[:, 1]).mean() < metres
    assert np.rad2deg(np.abs(wrap_angle(error[:, 2]))).mean() < degrees


@pytest.mark.parametrize("name", list(datasets.registry()))
def test_recordings_have_the_pinned_hashes(name):
    """Of files that are here; a recording of one's own under that name would differ."""
    states = datasets.status(name)
    if all(item.state == "missing" for item in states):
        pytest.skip(f"the recording {name} is not on this computer")
    assert [item.file.name for item in states if item.state == "differs"] == []


@pytest.mark.parametrize("name", list(datasets.registry()))
def test_recordings_have_the_registered_size(name):
    """The registered files' sizes; of a file that is only stored compressed, its content's."""
    states = datasets.status(name)
    if any(item.state != "present" for item in states):
        pytest.skip(f"the recording {name} is not on this computer as registered")
    size = 0
    for item in states:
        packed = item.path.suffix == ".gz" and not item.file.name.endswith(".gz")
        size += len(gzip.decompress(item.path.read_bytes())) if packed else item.path.stat().st_size
    assert datasets.dataset(name).bytes == size

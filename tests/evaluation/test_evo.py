"""Errors in space beside those of evo, which reads the same files."""

from pathlib import Path

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.core.trajectory import PosePath3D
from evo.core.units import Unit
from evo.tools import file_interface
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.datasets import read_space_track
from robot_perception.evaluation import spatial
from robot_perception.geometry import se3
from tests.datasets.space import path_in_space, write_path

READ = {
    "TUM": file_interface.read_tum_trajectory_file,
    "KITTI": file_interface.read_kitti_poses_file,
    "EuRoC": file_interface.read_euroc_csv_trajectory,
}
MOST = 0.02
STEPS = 3


def files(folder: Path, kind: str) -> tuple[Path, Path]:
    """Write an estimate of another scale in another frame, that lacks poses, and the truth."""
    rng = np.random.default_rng(8)
    times, truth = path_in_space(rng, 60)
    estimate = truth @ se3.exp(rng.normal(scale=0.05, size=(60, 6)))
    estimate[:, :3, 3] *= 2.5
    estimate = se3.exp(rng.uniform(-1, 1, 6)) @ estimate
    kept = np.ones(60, bool) if kind == "KITTI" else rng.uniform(size=60) > 0.2
    later = times + rng.uniform(-MOST, 1.5 * MOST, 60).round(6)
    return (
        write_path(folder / "estimate", kind, later[kept], estimate[kept]),
        write_path(folder / "truth", kind, times, truth),
    )


def theirs(kind: str, estimate: Path, truth: Path) -> tuple[PosePath3D, PosePath3D]:
    found, true = READ[kind](str(estimate)), READ[kind](str(truth))
    if kind != "KITTI":
        true, found = sync.associate_trajectories(true, found, max_diff=MOST)
    return found, true


def ours(estimate: Path, truth: Path) -> tuple[np.ndarray, np.ndarray]:
    found, true = read_space_track(estimate), read_space_track(truth)
    if found.times is None:
        return found.poses, true.poses
    pairs = spatial.associate(found.times, true.times, MOST)
    return found.poses[pairs[:, 0]], true.poses[pairs[:, 1]]


def evos(metric: metrics.PE, found: PosePath3D, true: PosePath3D) -> float:
    metric.process_data((true, found))
    return metric.get_statistic(metrics.StatisticsType.rmse)


@pytest.mark.parametrize("alignment", spatial.ALIGNMENTS)
@pytest.mark.parametrize("kind", READ)
def test_errors_are_evos_of_the_same_files(kind, alignment, tmp_path):
    paths = files(tmp_path, kind)
    (estimate, truth), (found, true) = ours(*paths), theirs(kind, *paths)
    assert len(estimate) == found.num_poses
    if kind != "KITTI":
        assert len(estimate) < len(read_space_track(paths[0]))  # some have no partner
    moved, similarity = spatial.align_poses(estimate, truth, alignment)
    if alignment != "none":
        _, _, scale = found.align(true, correct_scale=alignment == "sim3")
        assert similarity.scale == pytest.approx(scale)
    np.testing.assert_allclose(moved, np.array(found.poses_se3), atol=1e-8)
    ate = evos(metrics.APE(metrics.PoseRelation.translation_part), found, true)
    assert spatial.absolute_error(moved[:, :3, 3], truth[:, :3, 3]) == pytest.approx(ate)
    errors = spatial.relative_error(moved, truth, STEPS)
    for what, rms in (
        (metrics.PoseRelation.translation_part, errors.translation_rms),
        (metrics.PoseRelation.rotation_angle_rad, errors.rotation_rms),
    ):
        metric = metrics.RPE(what, STEPS, Unit.frames, all_pairs=True)
        assert rms == pytest.approx(evos(metric, found, true), rel=1e-6)


def test_errors_over_a_distance_are_evos_where_poses_are_equally_far_apart():
    rng = np.random.default_rng(9)
    truth = np.stack([np.eye(4)] * 21)
    truth[:, :3, :3] = se3.exp(rng.normal(size=(21, 6)))[:, :3, :3]
    truth[:, 2, 3] = np.arange(21) / 4  # steps and sums are exact
    estimate = truth @ se3.exp(rng.normal(scale=0.05, size=(21, 6)))
    metric = metrics.RPE(
        metrics.PoseRelation.translation_part, 1.0, Unit.meters, 0.01,
        all_pairs=True, pairs_from_reference=True,
    )  # fmt: skip
    paths = (PosePath3D(poses_se3=list(path)) for path in (estimate, truth))
    over = spatial.relative_error_over(estimate, truth, 1.0)
    assert len(over.translation) == 17
    assert over.translation_rms == pytest.approx(evos(metric, *paths))


@given(st.integers(0, 2**31), st.integers(1, 12), st.integers(1, 12))
@settings(max_examples=60)
def test_poses_belong_together_as_in_evo(seed, k, m):
    rng = np.random.default_rng(seed)
    estimate, truth = (np.sort(rng.permutation(40)[:n]) / 128 for n in (k, m))  # often half-way
    few, many = (truth, estimate) if k > m else (estimate, truth)
    rows = sync.matching_time_indices(few, many, MOST)
    expected = np.array(rows[::-1] if k > m else rows, dtype=int).reshape(2, -1).T
    assert spatial.associate(estimate, truth, MOST).tolist() == expected.tolist()

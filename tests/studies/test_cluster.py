"""A sweep on a cluster gives the numbers of one process, though a worker is killed midway."""

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from joblib import parallel_config

from robot_perception.cli.workers import working
from studies.sweep import sweep

pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
COUNT = 24


def walk(folder, *, rng):
    """A run of some length that says who worked on it."""
    (folder / f"{os.getpid()}").touch()
    time.sleep(0.1)
    return np.cumsum(rng.standard_normal(1000))[::100]


def walks(folder):
    return sweep(walk, [folder] * COUNT, rng=np.random.default_rng(3), desc="walks")


def kill_one(folder: Path, workers: set[int], killed: list[int]) -> None:
    """Wait until two workers have begun and kill one of them."""
    for _ in range(600):
        working = sorted({int(p.name) for p in folder.iterdir()} & workers)
        if len(working) == 2:
            os.kill(working[0], signal.SIGKILL)
            killed.append(working[0])
            return
        time.sleep(0.01)


def test_dask_gives_the_same_numbers_though_one_of_two_workers_is_killed(tmp_path):
    from distributed import Client, LocalCluster

    alone, together = tmp_path / "alone", tmp_path / "together"
    alone.mkdir()
    together.mkdir()
    expected = walks(alone)
    killed: list[int] = []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        workers = set(client.run(os.getpid).values())
        assert len(workers) == 2
        killer = threading.Thread(target=kill_one, args=(together, workers, killed))
        killer.start()
        with parallel_config("dask"):
            found = walks(together)
        killer.join()
    assert len(killed) == 1, "no worker was killed: the test showed nothing"
    np.testing.assert_array_equal(found, expected)
    print(f"killed {killed[0]} of {sorted(workers)}: {COUNT} items as in one process")


def test_the_command_line_works_on_a_cluster_that_is_named(tmp_path):
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        working(None, cluster.scheduler_address, None),
    ):
        found = walks(tmp_path)
    assert os.getpid() not in {int(p.name) for p in tmp_path.iterdir()}
    np.testing.assert_array_equal(found, walks(tmp_path))


@pytest.mark.slow
def test_ray_gives_the_same_numbers(tmp_path):
    ray = pytest.importorskip("ray", reason="the extra `cluster` is not installed")
    from ray.util.joblib import register_ray

    expected = walks(tmp_path)
    before = {int(p.name) for p in tmp_path.iterdir()}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        register_ray()
        with parallel_config("ray", n_jobs=2):
            found = walks(tmp_path)
    finally:
        ray.shutdown()
    np.testing.assert_array_equal(found, expected)
    assert {int(p.name) for p in tmp_path.iterdir()} > before, "other processes did the work"

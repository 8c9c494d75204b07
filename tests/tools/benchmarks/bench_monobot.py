"""Monobot filter against filterpy's KalmanFilter, 100 runs of 100 steps."""

import numpy as np

from robot_perception.beliefs import Gaussian
from robot_perception.slam.monobot import first_measurement, run_filter, sensor_matrix
from tests.tools.benchmarks.harness import Row

RUNS, STEPS = 100, 100


def filterpy_means(z: np.ndarray, commands: np.ndarray, V: np.ndarray, W: np.ndarray) -> np.ndarray:
    """Return the last estimates of filterpy, one filter per run."""
    from filterpy.kalman import KalmanFilter

    runs, _, n = z.shape
    start = Gaussian(np.array([-1.0]), np.eye(1))
    eye, last = np.eye(n + 1), np.empty((runs, n + 1))
    for run in range(runs):
        belief = first_measurement(start, z[run, 0], W[min(run, len(W) - 1), 0])
        peer = KalmanFilter(dim_x=n + 1, dim_z=n, dim_u=1)
        peer.x, peer.P = belief.mean[:, None].copy(), belief.cov.copy()
        peer.F, peer.B, peer.H = eye, eye[:, :1], sensor_matrix(n)
        for k in range(1, z.shape[1]):
            slip = V[min(run, len(V) - 1), k - 1]
            peer.predict(u=commands[k - 1], Q=slip * np.outer(eye[0], eye[0]))
            peer.update(z[run, k][:, None], R=np.diag(W[min(run, len(W) - 1), k]))
        last[run] = peer.x[:, 0]
    return last


def _row(n: int, per_run: bool, ratio: float) -> Row:
    rng = np.random.default_rng(0)
    z = 2 + rng.standard_normal((RUNS, STEPS + 1, n))
    commands = rng.standard_normal(STEPS)
    start = Gaussian(np.array([-1.0]), np.eye(1))
    batch = RUNS if per_run else 1
    V = rng.uniform(0.5, 2.0, (batch, STEPS))
    W = rng.uniform(0.5, 2.0, (batch, STEPS + 1, n))

    def ours() -> np.ndarray:
        # shared noise has no leading axis of runs
        noise = (V, W) if per_run else (V[0], W[0])
        run = run_filter(
            start, commands, z, motion_variance=noise[0], measurement_variance=noise[1]
        )
        return run.means[:, -1]

    def peer() -> np.ndarray:
        return filterpy_means(z, commands, V, W)

    def agree() -> None:
        np.testing.assert_allclose(ours(), peer(), rtol=0, atol=1e-9)

    kind = "covariance of its own for each run" if per_run else "one covariance for all runs"
    landmarks = "1 landmark" if n == 1 else f"{n} landmarks"
    return Row(
        work=f"monobot filter, {RUNS} runs × {STEPS} steps, {landmarks}, {kind}",
        ours=ours,
        peer=peer,
        peer_name="filterpy KalmanFilter",
        ratio=ratio,
        agree=agree,
        repeats=7,
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern the monobot."""
    return [_row(1, False, 80), _row(10, False, 80), _row(1, True, 30), _row(10, True, 5)]

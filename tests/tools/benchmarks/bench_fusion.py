"""Covariance intersection of many pairs."""

from collections.abc import Callable
from datetime import datetime

import numpy as np
from scipy.optimize import minimize_scalar
from stonesoup.types.detection import GaussianDetection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.prediction import GaussianStatePrediction
from stonesoup.updater.chernoff import ChernoffUpdater

from robot_perception.beliefs import Gaussian
from robot_perception.fusion import (
    covariance_intersection,
    omega_least_determinant,
    omega_least_trace,
)
from tests.tools.benchmarks.harness import Row

COUNT, SIZE = 10_000, 3
OMEGA = 0.3
NOW = datetime(2000, 1, 1)


def _beliefs(rng: np.random.Generator) -> Gaussian:
    root = rng.standard_normal((COUNT, SIZE, SIZE))
    return Gaussian(rng.standard_normal((COUNT, SIZE)), root @ root.mT + 0.1 * np.eye(SIZE))


A, B = (_beliefs(np.random.default_rng(seed)) for seed in range(2))


def _hypotheses() -> list[SingleHypothesis]:
    """Return the pairs as Stone Soup wants them: a as prediction, b as measurement."""
    pairs = []
    for k in range(COUNT):
        prediction = GaussianStatePrediction(state_vector=A.mean[k], covar=A.cov[k], timestamp=NOW)
        detection = GaussianDetection(state_vector=B.mean[k], covar=B.cov[k], timestamp=NOW)
        pairs.append(
            SingleHypothesis(
                prediction=prediction, measurement=detection, measurement_prediction=prediction
            )
        )
    return pairs


def _given() -> Row:
    pairs, updater = _hypotheses(), ChernoffUpdater(measurement_model=None, omega=OMEGA)

    def ours() -> Gaussian:
        return covariance_intersection(A, B, OMEGA)

    def peer() -> list[object]:
        return [updater.update(pair) for pair in pairs]  # its ω is the weight of the measurement

    def agree() -> None:
        found, expected = ours(), peer()
        means = [np.asarray(one.state_vector).ravel() for one in expected]
        np.testing.assert_allclose(found.mean, means, atol=1e-9)
        np.testing.assert_allclose(
            found.cov, [np.asarray(one.covar) for one in expected], atol=1e-9
        )

    return Row(
        work="covariance intersection, 10 000 pairs, d = 3, ω given",
        ours=ours,
        peer=peer,
        peer_name="Stone Soup",
        ratio=100,
        agree=agree,
        repeats=5,
    )


def _searched(
    name: str, weigh: Callable[[Gaussian, Gaussian], np.ndarray], size: Callable[..., float]
) -> Row:
    def ours() -> Gaussian:
        return covariance_intersection(A, B, weigh(A, B))

    def peer() -> np.ndarray:
        covs = np.empty((COUNT, SIZE, SIZE))
        means = np.empty((COUNT, SIZE))
        for k in range(COUNT):
            Y_a, Y_b = np.linalg.inv(A.cov[k]), np.linalg.inv(B.cov[k])
            w = minimize_scalar(
                lambda w, Y_a=Y_a, Y_b=Y_b: size((1 - w) * Y_a + w * Y_b),
                bounds=(0, 1),
                method="bounded",
            ).x
            covs[k] = np.linalg.inv((1 - w) * Y_a + w * Y_b)
            means[k] = covs[k] @ ((1 - w) * Y_a @ A.mean[k] + w * Y_b @ B.mean[k])
        return covs

    def agree() -> None:
        found, expected = (np.linalg.inv(covs) for covs in (ours().cov, peer()))
        costs = [np.array([size(Y) for Y in side]) for side in (found, expected)]
        assert (costs[0] <= costs[1] + 1e-9 * np.abs(costs[1])).all()
        np.testing.assert_allclose(*costs, rtol=1e-4)

    return Row(
        work=f"covariance intersection, 10 000 pairs, d = 3, least {name}",
        ours=ours,
        peer=peer,
        peer_name="SciPy search",
        ratio=40,
        agree=agree,
        repeats=3,
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern fusion."""
    return [
        _given(),
        _searched("determinant", omega_least_determinant, lambda Y: -np.linalg.det(Y)),
        _searched("trace", omega_least_trace, lambda Y: np.trace(np.linalg.inv(Y))),
    ]

"""Resampling of a million weights."""

from collections.abc import Callable
from unittest import mock

import filterpy.monte_carlo.resampling as filterpy
import numpy as np

from robot_perception.particles import Scheme, multinomial, residual, stratified, systematic
from tests.tools.benchmarks.harness import Row

COUNT = 10**6
WEIGHTS = np.random.default_rng(0).random(COUNT)
WEIGHTS /= WEIGHTS.sum()


def _row(scheme: Scheme, peer: Callable[[np.ndarray], np.ndarray]) -> Row:
    def agree() -> None:
        ours, theirs = (np.random.default_rng(1) for _ in range(2))
        drawn = scheme(WEIGHTS, COUNT, rng=ours)
        with mock.patch.object(filterpy, "random", theirs.random):
            expected = peer(WEIGHTS)
        differ = drawn != expected  # a tooth on an edge, to the last digit
        assert np.abs(drawn - expected).max() <= 1
        assert differ.mean() < 1e-5

    rng = np.random.default_rng(2)
    return Row(
        work=f"resampling 10⁶ weights, {scheme.__name__}",
        ours=lambda: scheme(WEIGHTS, COUNT, rng=rng),
        peer=lambda: peer(WEIGHTS),
        peer_name=f"filterpy {peer.__name__}",
        ratio=40,
        agree=agree,
        repeats=5,
    )


def _alone(scheme: Scheme) -> Row:
    rng = np.random.default_rng(2)
    return Row(
        work=f"resampling 10⁶ weights, {scheme.__name__}",
        ours=lambda: scheme(WEIGHTS, COUNT, rng=rng),
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern particles."""
    return [
        _row(systematic, filterpy.systematic_resample),
        _row(stratified, filterpy.stratified_resample),
        _alone(residual),
        _alone(multinomial),
    ]

"""Valid calls of `particles`."""

import numpy as np

from robot_perception import particles
from robot_perception.beliefs import ParticleSet
from tests.hostile.sweep import Call, call

PRIOR = ParticleSet.uniform(np.linspace(0, 1, 8).reshape(4, 2))


def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return states + rng.normal(size=states.shape)


def expect(states: np.ndarray) -> np.ndarray:
    return states


def log_likelihood(states: np.ndarray) -> np.ndarray:
    return -(states**2).sum(axis=1)


def log_ratio(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return (before - after).sum(axis=1)


def draw() -> Call:
    return call(np.array([0.5, 0.25, 0.0]), 5, rng=np.random.default_rng(0))


CALLS = {
    particles.effective_number: lambda: call(np.zeros(4)),
    particles.systematic: draw,
    particles.stratified: draw,
    particles.residual: draw,
    particles.multinomial: draw,
    particles.condensation: lambda: call(
        PRIOR, move, log_likelihood, rng=np.random.default_rng(0), scheme=particles.residual
    ),
    particles.importance: lambda: call(
        PRIOR,
        move,
        log_likelihood,
        rng=np.random.default_rng(0),
        share=1.0,
        log_ratio=log_ratio,
        scheme=particles.residual,
    ),
    particles.auxiliary: lambda: call(
        PRIOR, move, expect, log_likelihood, rng=np.random.default_rng(0), scheme=particles.residual
    ),
}

"""The filter broken on purpose, on the same worlds as the right one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from data_synth.monobot import RailRuns
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.monobot.rail import Config, simulate
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.kalman import Sensor, predict, update
from robot_perception.slam.monobot import first_measurement, motion, sensor_matrix
from robot_perception.teaching.tables import Table


@dataclass(frozen=True, eq=False, slots=True)
class Variant:
    """One way to run the filter, right or broken: landmark errors, and what it states, m."""

    name: str
    errors: Float[np.ndarray, "runs measurements"]
    deviations: Float[np.ndarray, "measurements"]

    @property
    def rms(self) -> Float[np.ndarray, "measurements"]:
        """Root mean square error over the runs at each step, m."""
        return np.sqrt((self.errors**2).mean(axis=0))

    @property
    def nees(self) -> Float[np.ndarray, "measurements"]:
        """Mean squared error over variance at each step; 1 for an honest filter."""
        value = normalised_squared(self.errors[..., None], self.deviations[:, None, None] ** 2)
        return value.mean(axis=0)


def run(config: Config, *, rng: np.random.Generator) -> tuple[Variant, ...]:
    """Run the filter rightly, and in four other ways, on the same worlds with one landmark."""
    config = replace(config, landmarks=1)
    world = simulate(config, rng=rng)
    posts = rng.standard_normal(world.positions.shape) * config.measurement_deviations[:, 0]
    posts -= world.positions  # distances to a post at the origin
    timid = replace(config, start_deviation=config.start_deviation / 10)
    return (
        _variant("as the paper says", config, world),
        _variant("P0 a hundredth of the truth", timid, world),
        _variant("update before predict", config, world, late=True),
        _variant("no cross-covariance", config, world, forget=True),
        _variant("one known landmark", config, world, posts=posts),
    )


def table(variants: Sequence[Variant]) -> Table:
    """Return the errors after the last measurement."""
    return Table(
        {v.name: [v.errors[:, -1].mean(), v.rms[-1], v.deviations[-1]] for v in variants},
        {"mean (m)": "", "rms (m)": "root mean square error", "states (m)": "σ of the filter"},
        f"landmark error after the last measurement, {len(variants[0].errors)} runs",
        "filter",
    )


def _variant(
    name: str,
    config: Config,
    world: RailRuns,
    *,
    late: bool = False,
    forget: bool = False,
    posts: np.ndarray | None = None,
) -> Variant:
    W = config.measurement_deviations**2
    belief = first_measurement(config.belief, world.measurements[:, 0], W[0])
    if forget:
        belief = Gaussian(belief.mean, belief.cov * np.eye(2))
    history = [belief]
    for k in range(1, config.steps + 1):
        move = motion(world.commands[k - 1], config.motion_deviations[k - 1] ** 2, 1)
        sensor, z = Sensor(sensor_matrix(1), W[k][None]), world.measurements[:, k]
        if posts is not None:
            sensor = Sensor(np.array([[-1.0, 0.0], [-1.0, 1.0]]), W[k] * np.eye(2))
            z = np.stack([posts[:, k], z[:, 0]], axis=-1)
        if late:
            belief = predict(update(belief, z, sensor)[0], move)
        else:
            belief = update(predict(belief, move), z, sensor)[0]
        history.append(belief)
    errors = np.stack([b.mean[:, 1] for b in history], axis=1) - config.landmarks_at
    return Variant(name, errors, np.sqrt([b.cov[1, 1] for b in history]))

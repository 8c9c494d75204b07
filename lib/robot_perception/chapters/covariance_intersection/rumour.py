r"""The same rumour heard twice: readings whose errors are partly one and the same.

Each reading errs by :math:`e_k = \sqrt s\, c + \sqrt{1 - s}\, n_k` standard deviations: a share s
of the variance is repeated every time, the rest is new.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks, fusion
from robot_perception.beliefs import Gaussian
from robot_perception.people.sonar import SonarRules
from robot_perception.teaching.tables import Table

RULES = ("Kalman", "intersection", "split intersection")


@dataclass(frozen=True, slots=True)
class Config:
    """All values are ours: the sonar's deviation of distance, m, and how often it is heard."""

    sigma: float = SonarRules().range_sigma
    readings: int = 20
    share: float = 1.0
    runs: int = 400


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors, stated and true deviations after each reading, m, by rule.

    The true ones are exact, from the weights that a rule gives to the readings.
    """

    config: Config
    errors: Mapping[str, Float[np.ndarray, "runs readings"]]
    stated: Mapping[str, Float[np.ndarray, " readings"]]
    true: Mapping[str, Float[np.ndarray, " readings"]]

    def ratio(self, rule: str) -> Float[np.ndarray, " readings"]:
        """Return the true over the stated variance after each reading."""
        return (self.true[rule] / self.stated[rule]) ** 2

    @property
    def typical(self) -> int:
        """The run whose last error, fused as if independent, is nearest to one true σ."""
        final, sigma = self.errors["Kalman"][:, -1], self.true["Kalman"][-1]
        return int(np.abs(final - sigma).argmin())


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Fuse one reading after the other by every rule."""
    share = checks.share("share", config.share)
    common = rng.standard_normal((config.runs, 1))
    own = rng.standard_normal((config.runs, config.readings))
    heard = config.sigma * (np.sqrt(share) * common + np.sqrt(1 - share) * own)
    errors, stated, true = {}, {}, {}
    for rule in RULES:
        errors[rule], stated[rule] = _fuse(rule, heard, config)
        weights, _ = _fuse(rule, np.eye(config.readings), config)
        repeated, fresh = weights.sum(axis=0) ** 2, (weights**2).sum(axis=0)
        true[rule] = config.sigma * np.sqrt(share * repeated + (1 - share) * fresh)
    return Result(config, errors, stated, true)


def _fuse(rule: str, heard: np.ndarray, config: Config) -> tuple[np.ndarray, np.ndarray]:
    cov = np.full((1, 1), config.sigma**2)
    own = (1 - config.share) * cov
    belief, fresh = Gaussian(heard[:, :1], cov), own
    errors, stated = [belief.mean[:, 0]], [config.sigma]
    for k in range(1, config.readings):
        reading = Gaussian(heard[:, k : k + 1], cov)
        if rule == "Kalman":
            belief = fusion.kalman_fusion(belief, reading)
        elif rule == "intersection":
            omega = fusion.omega_determinants(belief, reading)
            belief = fusion.covariance_intersection(belief, reading, omega)
        else:
            belief, fresh = fusion.split_covariance_intersection(
                belief, reading, fresh, own, 1 / (k + 1)
            )
        errors.append(belief.mean[:, 0])
        stated.append(float(np.sqrt(belief.cov.reshape(-1)[0])))
    return np.stack(errors, axis=1), np.array(stated)


def setup_table() -> Table:
    """Return what is heard."""
    config = Config()
    rows = {
        "deviation of a reading": ("“large”", f"{config.sigma:g} m", "no: only the scale"),
        "readings fused": ("–", f"{config.readings}", "yes"),
        "share that is repeated": ("unknown", "0 to 1", "most of all"),
    }
    return Table(rows, {"paper": "in its words", "ours": "1σ", "matters": ""})

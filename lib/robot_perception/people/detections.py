"""Detections of people by one sensor at one time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.geometry.angles import wrap_angle

__all__ = ["Detections", "polar"]


@dataclass(frozen=True, eq=False, slots=True)
class Detections:
    r"""People that one sensor takes itself to see at one time, n of them, or none.

    Parameters
    ----------
    time
        When, on the robot's clock, s.
    sensor
        Which one, by the name that the rules of the aggregation know it by: ``"laser"``, say.
    positions
        Distances and directions :math:`(r, \varphi)` about the robot as n normal distributions, m
        and rad; :math:`\varphi` counter-clockwise from ahead, from -π to π.

    Raises
    ------
    ValueError
        If the time is not finite, the sensor has no name, the positions are no batch of two
        numbers, a distance is negative or a direction outside its range.

    References
    ----------
    Schaffernicht, Martin, Scheidig and Gross, "A probabilistic multimodal sensor aggregation scheme
    applied for a mobile robot", KI 2005, section 3.1.
    """

    time: float
    sensor: str
    positions: Gaussian

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", checks.number("time", self.time))
        named("sensor", self.sensor)
        mean = checks.instance("positions", self.positions, Gaussian).mean
        checks.shaped("positions.mean", mean, ("n", 2))
        checks.shaped("positions.cov", self.positions.cov, (len(mean), 2, 2), f"mean {mean.shape}")
        r, phi = mean.T
        if (r < 0).any():
            raise ValueError(f"positions must not have a negative distance, got {r.min():g}")
        if (np.abs(phi) > np.pi).any():
            raise ValueError(f"positions must have φ from -π to π, got {phi[np.abs(phi).argmax()]}")

    def __len__(self) -> int:
        return len(self.positions.mean)


def named(name: str, value: object) -> str:
    """Return what a sensor is called, or raise."""
    if not (isinstance(value, str) and value):
        raise ValueError(f"{name} must be the name of a sensor, got {checks.shown(value)}")
    return value


def polar(
    r: Float[np.ndarray, " n"],
    phi: Float[np.ndarray, " n"],
    r_sigma: float | Float[np.ndarray, " n"],
    phi_sigma: float | Float[np.ndarray, " n"],
) -> Gaussian:
    r"""Return positions with independent errors of distance and direction, which is wrapped.

    .. math:: C = \operatorname{diag}(\sigma_r^2,\, \sigma_\varphi^2)

    Parameters
    ----------
    r, phi : (n,)
        Distances, m, and directions, rad.
    r_sigma, phi_sigma
        Standard deviations, m and rad: one for all, or one for each.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite, or a standard deviation is negative.
    """
    r = checks.array("r", r, ("n",))
    phi = checks.array("phi", phi, r.shape, f"r {r.shape}")
    cov = np.zeros((len(r), 2, 2))
    for axis, (name, sigma) in enumerate({"r_sigma": r_sigma, "phi_sigma": phi_sigma}.items()):
        sigma = checks.array(name, sigma)
        if sigma.ndim:
            checks.shaped(name, sigma, r.shape, f"r {r.shape}")
        if (sigma < 0).any():
            raise ValueError(f"{name} must not be negative, got {sigma.min():g}")
        cov[:, axis, axis] = sigma**2
    return Gaussian(np.stack([r, wrap_angle(phi)], axis=-1), cov)

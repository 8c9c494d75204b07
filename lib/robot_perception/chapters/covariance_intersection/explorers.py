"""The states of the explorers: two Gaussians, a rumour, sonar with camera."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float

from robot_perception import fusion
from robot_perception.beliefs import Gaussian
from robot_perception.chapters.covariance_intersection import consistency, rumour, weights
from robot_perception.teaching.explore import choice, slider

ELLIPSE_CONTROLS = {
    "rho": slider("Correlation", (-0.9, -0.5, 0.0, 0.5, 0.9, 1.0), 0.5),
    "omega": choice(
        "Fused by",
        {"Kalman": None} | {f"intersection, ω = {w}": w for w in (0.1, 0.3, 0.5, 0.7, 0.9)},
        None,
    ),
}
ELLIPSE_PRESETS = {
    "as the filter believes": {"rho": 0.0},
    "the same error twice": {"rho": 1.0},
    "intersection, the same error": {"rho": 1.0, "omega": 0.5},
}
RUMOUR_CONTROLS = {
    "share": slider("Repeated share of the variance", (0.0, 0.1, 0.25, 0.5, 0.75, 1.0), 1.0)
}
RUMOUR_PRESETS = {"a tenth repeated": {"share": 0.1}, "nothing repeated": {"share": 0.0}}
PAIR_CONTROLS = {
    "bearing": slider("Camera, direction", (1.0, weights.BEARING, 5.0, 10.0), weights.BEARING, "°"),
    "depth": slider("Camera, distance", (0.2, 0.5, 1.0, 2.0), 2.0, "m"),
}
PAIR_PRESETS = {
    "a sharp camera": {"bearing": 1.0},
    "a camera that knows no more": {"bearing": 10.0},
    "a camera with depth": {"depth": 0.2},
}

FIRST = Gaussian(np.zeros(2), np.array([[4.0, 0.6], [0.6, 0.5]]))
SECOND = Gaussian(np.zeros(2), np.array([[0.6, -0.4], [-0.4, 3.0]]))


@dataclass(frozen=True, eq=False, slots=True)
class Fused:
    """Stated and true covariance of the fused belief; true over stated in the worst direction."""

    rule: str
    stated: Float[np.ndarray, "2 2"]
    true: Float[np.ndarray, "2 2"]

    @property
    def ratio(self) -> float:
        """Greatest true over stated variance over all directions; honest up to 1."""
        half = np.linalg.inv(np.linalg.cholesky(self.stated))
        return float(np.linalg.eigvalsh(half @ self.true @ half.T)[-1])


def fused(rho: float, omega: float | None) -> Fused:
    """Return a state of the explorer of two Gaussians; without ω, of the Kalman filter's fusion."""
    rule = "Kalman" if omega is None else "intersection"
    chosen = fusion.kalman_fusion if omega is None else consistency.with_weight(omega)
    true = consistency.true_cov(chosen, FIRST, SECOND, rho * np.eye(2))
    return Fused(rule, chosen(FIRST, SECOND).cov, true)


def describe_ellipses(rho: float, omega: float | None) -> str:
    """Return what a state of the explorer of two Gaussians shows, in words."""
    state = fused(rho, omega)
    name = "the Kalman filter" if omega is None else f"covariance intersection with ω = {omega}"
    where = "inside" if state.ratio <= 1 + consistency.ROUNDING else "outside"
    return (
        f"Two beliefs with correlation {rho:g} fused by {name}: the true covariance reaches "
        f"{where} the stated one; the largest ratio of variances is {state.ratio:.2f}."
    )


@cache
def heard(share: float) -> rumour.Result:
    """Return a state of the explorer of the rumour."""
    return rumour.run(rumour.Config(share=share), rng=np.random.default_rng(4))


def typical(result: rumour.Result) -> int:
    """Return the run whose last error, fused as if independent, is nearest to one true σ."""
    final, sigma = result.errors["Kalman"][:, -1], result.true["Kalman"][-1]
    return int(np.abs(final - sigma).argmin())


def describe_rumour(share: float) -> str:
    """Return what a state of the explorer of the rumour shows, in words."""
    result = heard(share)
    parts = [
        f"{rule}: off by {100 * result.true[rule][-1]:.0f} cm, states "
        f"{100 * result.stated[rule][-1]:.0f} cm"
        for rule in rumour.RULES
    ]
    return f"After 20 readings, {share:.0%} of their variance repeated. " + "; ".join(parts) + "."


@dataclass(frozen=True, eq=False, slots=True)
class Weighed:
    """Sonar, camera, and area of the fused ellipse over that of the sonar, by weight."""

    sonar: Gaussian
    camera: Gaussian
    omegas: Float[np.ndarray, " k"]
    areas: Float[np.ndarray, " k"]
    printed: float
    least: float

    def area(self, omega: float) -> float:
        """Return the area at a weight over that of the sonar's ellipse."""
        found = fusion.covariance_intersection(self.sonar, self.camera, omega)
        return float(np.sqrt(np.linalg.det(found.cov) / np.linalg.det(self.sonar.cov)))


def weighed(bearing: float, depth: float) -> Weighed:
    """Return a state of the explorer of sonar and camera."""
    sonar, camera = weights.sonar_and_camera(bearing, depth)
    omegas = np.linspace(0, 1, 201)
    found = fusion.covariance_intersection(sonar, camera, omegas)
    areas = np.sqrt(np.linalg.det(found.cov) / np.linalg.det(sonar.cov))
    return Weighed(
        sonar,
        camera,
        omegas,
        areas,
        float(fusion.omega_determinants(sonar, camera)),
        float(fusion.omega_least_determinant(sonar, camera)),
    )


def describe_pair(bearing: float, depth: float) -> str:
    """Return what a state of the explorer of sonar and camera shows, in words."""
    state = weighed(bearing, depth)
    return (
        f"Area of the fused ellipse against the weight of the camera. Eq. 4 takes "
        f"{state.printed:.2f}, the least area is at {state.least:.2f}; the areas are "
        f"{state.area(state.printed):.2f} and {state.area(state.least):.2f} of the sonar's."
    )

r"""A pattern followed by the condensation algorithm: section 3.3 of the paper.

The state is the pattern's place (x, y, θ, s) in the picture, eq. (5). It moves by a random walk. A
particle's likelihood comes from each grey vector by three steps: its correlation with what the
picture shows there, the deviation that such a correlation stands for, and a Gaussian of it,

.. math::
    p(Z \mid S) = \prod_{j=1}^{N_m} \Omega_\sigma\big(\tilde C_j^{-1}(C_j)\big)
    \qquad \text{(eq. 6)}

The paper prints the product up to :math:`N_p`, the number of particles; it runs over the model's
points, of which there are :math:`N_m`.

Equation numbers are those of Ait Aider, Chateau and Lapresté, "Indoor autonomous navigation using
visual memory and pattern tracking".
"""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8

from robot_perception import checks
from robot_perception.beliefs import ParticleSet
from robot_perception.ceiling.contours import check_size, picture, picture_size
from robot_perception.ceiling.patterns import Decay, Pattern, correlations, deviations
from robot_perception.extras import needing
from robot_perception.fields import (
    Positive,
    Share,
    at_least,
    checked,
    from_to,
    numbers,
    one_of,
)
from robot_perception.geometry.angles import wrap_angle
from robot_perception.particles import condensation

with needing():
    import cv2

__all__ = [
    "Layers",
    "PatternInfo",
    "PatternState",
    "PatternTracker",
    "TrackerRules",
    "log_likelihoods",
    "smoothing",
]

FORBIDDEN = 1e6
"""Minus the logarithm of the likelihood of what is hardly in the picture; finite, as all may be."""
FARTHEST = 1e9
"""No place is farther from a picture, px, and no scale larger."""
SMALLEST = 0.05
"""No particle is smaller, as a share of the model."""


@dataclass(frozen=True, slots=True)
class TrackerRules:
    r"""Rules of tracking a pattern.

    Parameters
    ----------
    particles
        :math:`N_p`; the paper's 200.
    sigmas
        Of the random walk along x and y, px, of θ, rad, and of s; the paper's 5, 5, 3° and 0.1.
    deviation
        σ of eq. (6), samples; ours.
    worst
        A vector whose deviation is larger is a bad one, samples; ours.
    tolerated
        Share of the vectors that may be bad; ours.
    bad
        What a bad vector within the tolerance counts for. ``"left out"``: the paper's rule, it is
        not part of the product, which is as good as a perfect one. ``"at worst"``: as much as one
        at the threshold, our choice: else a particle is the likelier the more it leaves out.
    smoothing
        Of the picture for a particle of scale s. ``"none"``; ``"scale"``: the paper's, σ = s where
        s > 1; ``"difference"``: :math:`\sqrt{s^2 - 1}`, which takes the model's own blur of a pixel
        to s pixels and is 0 at s = 1.
    passes
        Further looks at the same picture, each with a random walk of a third of the last one's
        deviations; 0 in the paper.
    """

    particles: Annotated[int, from_to(1, 10**6)] = 200
    sigmas: Annotated[tuple[float, float, float, float], numbers(4, at_least(0))] = (
        5.0,
        5.0,
        np.deg2rad(3.0),
        0.1,
    )
    deviation: Positive = 4.0
    worst: Positive = 3.0
    tolerated: Share = 0.3
    bad: Annotated[str, one_of("left out", "at worst")] = "at worst"
    smoothing: Annotated[str, one_of("none", "scale", "difference")] = "difference"
    passes: Annotated[int, from_to(0, 10)] = 0
    __post_init__ = checked


def _scaled(name: str, particles: ParticleSet) -> ParticleSet:
    """Return samples of four numbers each whose scales are positive."""
    states = checks.instance(name, particles, ParticleSet).states
    checks.shaped(f"{name}.states", states, ("m", 4))
    if not (states[:, 3] > 0).all():
        raise ValueError(f"{name} must have a positive scale, got {states[:, 3].min():g}")
    return particles


@dataclass(frozen=True, eq=False, slots=True)
class PatternState:
    """State of the tracker of a pattern after a picture.

    Parameters
    ----------
    particles
        Samples of (x, y, θ, s), px, px, rad and 1.
    pose : (4,)
        Their mean; that of the angles is taken around the circle.
    lost
        In how many pictures in a row it was not seen.
    size : (height, width)
        Of the pictures, px; nothing before the first.

    Raises
    ------
    ValueError
        If the particles are not one set of four numbers each, or a scale is not positive.
    """

    particles: Annotated[ParticleSet, _scaled]
    pose: Float[np.ndarray, " 4"] = field(init=False)
    lost: Annotated[int, from_to(0)] = 0
    size: Annotated[tuple[int, int] | None, picture_size] = None

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "pose", _mean(self.particles))


@dataclass(frozen=True, eq=False, slots=True)
class PatternInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    pose : (4,)
        Estimate of (x, y, θ, s).
    cov : (4, 4)
        Covariance of the particles.
    correlation : (n,)
        Of each vector at the estimate; NaN beyond the picture.
    deviation : (n,)
        Of each vector there, samples.
    good : (n,)
        Which vectors are not bad; one without a positive correlation, as of a blank picture, is.
    lost
        Whether more of the vectors in the picture are bad than the rules tolerate, or less than
        half are in it: the pattern is not where it is said to be, or hardly to be seen.
    effective
        Number of particles.
    """

    pose: Float[np.ndarray, " 4"]
    cov: Float[np.ndarray, "4 4"]
    correlation: Float[np.ndarray, " n"]
    deviation: Float[np.ndarray, " n"]
    good: Bool[np.ndarray, " n"]
    lost: bool
    effective: float

    @property
    def match(self) -> float:
        """Mean correlation of all vectors; one beyond the picture counts as the opposite, -1.

        By it places of a pattern are compared, of which some reach beyond the picture.
        """
        return float(np.nan_to_num(self.correlation, nan=-1.0).mean())


def smoothing(scale: Float[np.ndarray, "..."], kind: str) -> Float[np.ndarray, "..."]:
    r"""Return how much a picture is smoothed for a scale: standard deviation, px.

    Parameters
    ----------
    scale
        s.
    kind
        ``"none"``; ``"scale"``: s where s > 1, else 0, as printed; ``"difference"``:
        :math:`\sqrt{s^2 - 1}` where s > 1, else 0.

    Raises
    ------
    ValueError
        If a scale is not finite or the kind is unknown.

    References
    ----------
    Section 3.3, "Handling occlusion and scale changing effects".
    """
    scale = checks.array("scale", scale)
    checks.one_of("kind", kind, ("none", "scale", "difference"))
    if kind == "none":
        return np.zeros_like(scale)
    above = np.maximum(scale, 1.0)
    return np.where(scale > 1, scale if kind == "scale" else np.sqrt(above**2 - 1), 0.0)


class Layers:
    """A picture, and copies of it that are smoothed more and more, made when they are asked for.

    Parameters
    ----------
    image : (height, width)
        Grey values.

    Raises
    ------
    TypeError
        If it does not hold bytes.
    ValueError
        If it is not (height, width).
    """

    STEP = 0.2
    """Standard deviations are rounded to multiples of it, px."""

    def __init__(self, image: UInt8[np.ndarray, "height width"]) -> None:
        self._sharp = picture("image", image).astype(np.float32)
        self._copies: dict[int, Float32[np.ndarray, "height width"]] = {0: self._sharp}
        self.shape = self._sharp.shape

    def correlations(
        self, pattern: Pattern, poses: Float[np.ndarray, "m 4"], kind: str
    ) -> Float32[np.ndarray, "m n"]:
        """Return what `.patterns.correlations` does, each pose in the copy that suits its scale.

        Errors are its own, and of places that no picture can show.
        """
        checks.instance("pattern", pattern, Pattern)
        poses = checks.moderate("poses", checks.array("poses", poses, ("m", 4)), FARTHEST)
        # a picture that is smoothed more than it is wide is of one grey
        sigmas = np.minimum(smoothing(poses[:, 3], kind), max(self._sharp.shape))
        wanted = np.rint(sigmas / self.STEP).astype(int)
        levels, chosen = np.unique(wanted, return_inverse=True)
        if len(levels) == 1:
            return correlations(self._copy(int(levels[0]))[None], pattern, poses)
        found = np.empty((len(poses), len(pattern.places)), np.float32)
        for k, level in enumerate(levels.tolist()):
            these = np.flatnonzero(chosen == k)
            found[these] = correlations(self._copy(level)[None], pattern, poses[these])
        return found

    def _copy(self, level: int) -> Float32[np.ndarray, "height width"]:
        if level not in self._copies:
            sigma = float(level * self.STEP)
            self._copies[level] = cv2.GaussianBlur(self._sharp, (0, 0), sigma)
        return self._copies[level]


@dataclass(frozen=True, eq=False, slots=True)
class PatternTracker:
    """Follows a pattern from picture to picture.

    Parameters
    ----------
    pattern
        What is followed.
    rules
        How.

    References
    ----------
    Section 3.3, eqs (5) and (6); Isard and Blake, "Condensation - conditional density propagation
    for visual tracking", International Journal of Computer Vision 29(1), 1998.
    """

    pattern: Pattern
    rules: TrackerRules = field(default_factory=TrackerRules)
    __post_init__ = checked

    def start(self, pose: Float[np.ndarray, " 4"]) -> PatternState:
        """Return the state of a pattern whose place is known.

        Parameters
        ----------
        pose : (4,)
            (x, y, θ, s), px, px, rad and 1.

        Raises
        ------
        ValueError
            If the pose is not four finite numbers with a positive scale.
        """
        pose = checks.array("pose", pose, (4,))
        if not pose[3] > 0:
            raise ValueError(f"pose must have a positive scale, got {pose[3]:g}")
        return PatternState(ParticleSet.uniform(np.tile(pose, (self.rules.particles, 1))))

    def step(
        self,
        state: PatternState,
        image: UInt8[np.ndarray, "height width"] | Layers,
        *,
        rng: np.random.Generator,
    ) -> tuple[PatternState, PatternInfo]:
        """Return the state after a picture: draw, move, weigh.

        Parameters
        ----------
        state
            Before the picture.
        image : (height, width)
            Grey values; or `Layers` of them, which several trackers can share.
        rng
            Source of randomness.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If the image is not (height, width), or not of the size of those before and of the one
            that the pattern was taken from.
        """
        checks.instance("state", state, PatternState)
        layers = image if isinstance(image, Layers) else Layers(image)
        check_size("image", layers.shape, state.size)
        check_size("image", layers.shape, self.pattern.picture, "that of the pattern")
        rules, particles = self.rules, state.particles
        for again in range(rules.passes + 1):
            spread = np.array(rules.sigmas) / 3**again

            def move(states: np.ndarray, rng: np.random.Generator, spread=spread) -> np.ndarray:
                moved = states + spread * rng.standard_normal(states.shape)
                moved[:, 3] = np.maximum(moved[:, 3], SMALLEST)
                return moved

            def weigh(states: np.ndarray) -> np.ndarray:
                return log_likelihoods(
                    layers.correlations(self.pattern, states, rules.smoothing),
                    self.pattern.decay,
                    rules,
                )

            particles, taken = condensation(particles, move, weigh, rng=rng)
        after = PatternState(particles, size=layers.shape)
        C = layers.correlations(self.pattern, after.pose[None], rules.smoothing)[0]
        away = deviations(C, self.pattern.decay)
        good = (away <= rules.worst) & (C > 0)  # where the fall is steep, no likeness is near, too
        seen = max(int((~np.isnan(C)).sum()), (len(C) + 1) // 2)
        lost = seen - int(good.sum()) > _tolerated(rules, seen)
        if lost:
            after = replace(after, lost=state.lost + 1)
        info = PatternInfo(after.pose, _cov(after), C, away, good, lost, taken.effective)
        return after, info


def log_likelihoods(
    correlation: Float[np.ndarray, "m n"], decay: Decay, rules: TrackerRules
) -> Float[np.ndarray, " m"]:
    r"""Return the logarithm of eq. (6) for each particle, but for a constant.

    .. math:: -\frac{1}{2\sigma^2} \sum_{j=1}^{N_m} \lambda_j^2

    Of the bad vectors, :math:`\lambda_j > \lambda_{\max}`, the worst up to the tolerated share are
    left out or count as :math:`\lambda_{\max}`; those beyond it count in full. A vector that leaves
    the picture says nothing and counts as much as the others do on average, as long as half of all
    are seen; a particle of which less is seen is impossible. Else the pattern would be held back at
    the border.

    Parameters
    ----------
    correlation : (m, n)
        Of each vector for each particle; NaN where it leaves the picture.
    decay
        How each falls.
    rules
        σ, threshold and tolerance.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the correlations are not of (m, n) for n points.

    References
    ----------
    Section 3.3, eq. (6), where the product is printed up to the number of particles.
    """
    checks.instance("decay", decay, Decay)
    checks.instance("rules", rules, TrackerRules)
    n = len(decay.rate)
    C = checks.array("correlation", correlation, ("m", n), beside="this decay", finite=False)
    unseen = np.isnan(C)
    squares = np.where(unseen, 0.0, deviations(C, decay)) ** 2
    most, limit = _tolerated(rules, n), rules.worst**2
    total = squares.sum(axis=1)
    if most:
        # the worst come last; of these, as many as are bad and may be
        worst = np.partition(squares, n - most, axis=1)[:, n - most :]
        bad = worst > limit
        total -= np.where(bad, worst, 0.0).sum(axis=1)
        if rules.bad == "at worst":
            total += limit * bad.sum(axis=1)
    seen = n - unseen.sum(axis=1)
    logs = -total * (n / np.maximum(seen, 1)) / (2 * rules.deviation**2)
    return np.where(2 * seen >= n, logs, -FORBIDDEN)


def _cov(state: PatternState) -> Float[np.ndarray, "4 4"]:
    """Return the covariance of places about their mean, angles taken around the circle."""
    away = state.particles.states - state.pose
    away[:, 2] = wrap_angle(away[:, 2])
    return away.T @ (state.particles.weights[:, None] * away)


def _tolerated(rules: TrackerRules, count: int) -> int:
    """Return how many of so many vectors may be bad."""
    return int(rules.tolerated * count + 1e-9)  # 0.29 of 100 is 28.999999999999996


def _mean(particles: ParticleSet) -> Float[np.ndarray, " 4"]:
    """Return the mean of places, with that of the angles taken around the circle."""
    weights, states = particles.weights, particles.states
    mean = weights @ states
    mean[2] = np.arctan2(weights @ np.sin(states[:, 2]), weights @ np.cos(states[:, 2]))
    return mean

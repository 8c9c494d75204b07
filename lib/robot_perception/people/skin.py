r"""Faces in the picture of a fisheye that looks straight up, followed by their colour.

The lens is equidistant: a ray at an angle :math:`\theta` from straight up meets the image at
:math:`f \theta` from its centre. The front of the robot is at the bottom of the image, its left at
the left: the direction :math:`\varphi` lies at :math:`(-\sin\varphi,\, \cos\varphi)` of the centre.

Clouds of particles settle on what has the colour of skin. The tracker of several people that the
paper cites is not at hand; how clouds begin, join and end is our choice. Each has its own particles
and is drawn anew by itself, so no face takes those of another; seeds strewn over the whole band at
every image find new faces. Wood and cork have the colour of skin too.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.extras import needing
from robot_perception.fields import checked, from_to
from robot_perception.geometry.angles import wrap_angle
from robot_perception.particles import condensation
from robot_perception.people._bearings import DISTANCE, RANGE_SIGMA, bearings

with needing():
    import cv2


@dataclass(frozen=True, eq=False, slots=True)
class SkinModel:
    r"""Likelihood ratio of each colour on skin and elsewhere, whatever its brightness.

    .. math:: \ell(r, g) = \log \frac{p(r, g \mid \text{skin})}{p(r, g \mid \text{other})}, \qquad
        (r, g) = \frac{(R, G)}{R + G + B}

    Parameters
    ----------
    log_ratios : (bins, bins)
        :math:`\ell`, by r and g.
    darkest
        Below this sum of blue, green and red a pixel has no colour, and its ratio is 0.

    Raises
    ------
    ValueError
        If the table is not square or not finite, or ``darkest`` is not positive.
    """

    log_ratios: Float[np.ndarray, "bins bins"]
    darkest: float = 45.0

    def __post_init__(self) -> None:
        table = checks.array("log_ratios", self.log_ratios, ("bins", "bins"))
        if not table.size:
            raise ValueError(f"log_ratios must hold one bin at least, got {table.shape}")
        object.__setattr__(self, "log_ratios", table)
        object.__setattr__(self, "darkest", checks.positive("darkest", self.darkest))

    @classmethod
    def fit(
        cls,
        skin: UInt8[np.ndarray, "n 3"],
        other: UInt8[np.ndarray, "m 3"],
        *,
        bins: int = 64,
        darkest: float = 45.0,
        floor: float = 1e-4,
    ) -> "SkinModel":
        """Return the model that samples of both kinds give: the ratio of two histograms.

        Parameters
        ----------
        skin, other : (n, 3), (m, 3)
            Pixels, blue, green, red. What light may come must be among them.
        bins
            Of the histograms, along each axis.
        darkest
            Darker pixels are left out; see `SkinModel`.
        floor
            Added to every bin of both histograms, whose sums are 1, so that a colour seen on
            neither has the ratio 0.

        Raises
        ------
        TypeError
            If the pixels do not hold bytes.
        ValueError
            If the shapes are others, or a kind has no pixel that is bright enough.
        """
        bins, darkest = checks.whole("bins", bins, 2, 256), checks.positive("darkest", darkest)
        floor = checks.positive("floor", floor)
        shares = []
        for name, pixels in {"skin": skin, "other": other}.items():
            _check_bytes(name, pixels, ("n", 3))
            rows, columns, bright = _binned(pixels, bins, darkest)
            if not bright.any():
                raise ValueError(f"{name} must hold a pixel as bright as darkest {darkest:g}")
            counts = np.bincount((rows * bins + columns)[bright], minlength=bins * bins)
            shares.append(counts.reshape(bins, bins) / bright.sum() + floor)
        return cls(np.log(shares[0] / shares[1]), darkest)

    def log_ratio(self, pixels: UInt8[np.ndarray, "... 3"]) -> Float[np.ndarray, "..."]:
        """Return how much likelier each pixel is on skin than elsewhere, as a logarithm.

        Parameters
        ----------
        pixels : (…, 3)
            Blue, green, red.

        Raises
        ------
        TypeError
            If the pixels do not hold bytes.
        ValueError
            If the last axis is not 3.
        """
        _check_bytes("pixels", pixels, (..., 3))
        rows, columns, bright = _binned(pixels, len(self.log_ratios), self.darkest)
        return np.where(bright, self.log_ratios[rows, columns], 0.0)


@dataclass(frozen=True, slots=True)
class SkinRules:
    r"""Rules by which clouds move, begin, join and end. All values are our choice.

    Parameters
    ----------
    particles
        Of each cloud.
    seeds
        Places tried for a new cloud in each image.
    band
        Elevations above the horizon where faces are looked for, rad.
    step
        Angle between the samples of the image, rad.
    window
        Width and height of the window around a particle that is looked at, rad.
    prior
        Share of skin expected among pixels that could be either.
    softness
        By so much more skin in its window a particle is e times as likely.
    least
        Share of skin in the window below which nothing is seen.
    drift
        Standard deviation of what a face moves in a second, in direction and elevation, rad.
    apart
        Clouds nearer to each other in direction are one, rad.
    confirm
        Images in which a cloud must have been seen before it counts.
    patience
        Images without skin after which it ends.
    distance, range_sigma
        Mean and standard deviation of the distance that is claimed of everybody, m.

    Raises
    ------
    ValueError
        If a number is out of its range, or the band is upside down or leaves no room for a step.

    References
    ----------
    Schaffernicht et al. 2005 (see `Detections`), sections 2.3 and 3.1.
    """

    particles: int = 50
    seeds: int = 400
    band: tuple[float, float] = (np.deg2rad(2.0), np.deg2rad(45.0))
    step: float = np.deg2rad(0.5)
    window: tuple[float, float] = (np.deg2rad(2.0), np.deg2rad(3.0))
    prior: float = 0.1
    softness: float = 0.1
    least: float = 0.5
    drift: tuple[float, float] = (np.deg2rad(9.0), np.deg2rad(3.0))
    apart: float = np.deg2rad(7.0)
    confirm: int = 3
    patience: int = 3
    distance: float = DISTANCE
    range_sigma: float = RANGE_SIGMA

    def __post_init__(self) -> None:
        for name in ("particles", "seeds", "confirm", "patience"):
            object.__setattr__(self, name, checks.whole(name, getattr(self, name), 1, 10**6))
        for name in ("step", "softness", "apart", "distance", "range_sigma"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        for name in ("prior", "least"):
            object.__setattr__(self, name, checks.level(name, getattr(self, name)))
        for name in ("band", "window", "drift"):
            pair = tuple(checks.vector(name, getattr(self, name), 2).tolist())
            if name != "band" and min(pair) <= 0:
                raise ValueError(f"{name} must be positive, got {pair}")
            object.__setattr__(self, name, pair)
        low, high = self.band
        if not -np.pi / 2 <= low < high <= np.pi / 2:
            raise ValueError(f"band must rise between -π/2 and π/2, got {self.band}")
        if not 1e-3 <= self.step <= high - low:
            raise ValueError(f"step must be from 0.001 to the band's {high - low:g} rad")


@dataclass(frozen=True, eq=False, slots=True)
class Cloud:
    r"""The particles on one face, or on what is taken for one.

    Parameters
    ----------
    particles
        States :math:`(\varphi, \epsilon)`, direction and elevation, rad.
    images
        In how many it was seen.
    missed
        For how many in a row it has not been seen.
    """

    particles: ParticleSet
    images: Annotated[int, from_to(0)] = 1
    missed: Annotated[int, from_to(0)] = 0
    __post_init__ = checked

    @property
    def direction(self) -> tuple[float, float]:
        r"""Mean of :math:`\varphi` round the circle, and its variance, rad and rad².

        .. math:: \bar\varphi = \arg \sum_i \omega_i e^{j \varphi_i}, \qquad
            \sum_i \omega_i \operatorname{wrap}^2(\varphi_i - \bar\varphi)
        """
        phi, weights = self.particles.states[:, 0], self.particles.weights
        mean = np.arctan2(weights @ np.sin(phi), weights @ np.cos(phi))
        return float(wrap_angle(mean)), float(weights @ wrap_angle(phi - mean) ** 2)


@dataclass(frozen=True, eq=False, slots=True)
class SkinState:
    """State of the tracker after an image; at first empty.

    Parameters
    ----------
    clouds
        The oldest first.
    """

    clouds: tuple[Cloud, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "clouds", checks.instances("clouds", self.clouds, Cloud))


@dataclass(frozen=True, slots=True)
class SkinInfo:
    """Diagnostics of one image.

    Parameters
    ----------
    begun
        How many clouds began with it; they are the last of the state.
    ended
        How many clouds ended: not seen for too long, or where an older one is.
    """

    begun: int
    ended: int


@dataclass(frozen=True, eq=False, slots=True)
class SkinTracker:
    """Follows what has the colour of skin round the robot.

    Parameters
    ----------
    centre
        Pixel (u, v) of what is straight above.
    focal_px
        Pixels for each radian away from it.
    size
        Width and height of the images, px.
    model
        What skin looks like.
    rules
        How clouds move, begin, join and end.

    Raises
    ------
    ValueError
        If a number is not finite or not positive.

    References
    ----------
    Isard and Blake, "Condensation - conditional density propagation for visual tracking",
    International Journal of Computer Vision 29(1), 1998. Schaffernicht et al. 2005 (see
    `Detections`), section 2.3.
    """

    centre: tuple[float, float]
    focal_px: float
    size: tuple[int, int]
    model: SkinModel
    rules: SkinRules = SkinRules()
    _pixels: tuple[Float[np.ndarray, "rows columns"], Float[np.ndarray, "rows columns"]] = field(
        init=False, repr=False
    )

    def __post_init__(self) -> None:
        centre = tuple(checks.vector("centre", self.centre, 2).tolist())
        focal = checks.positive("focal_px", self.focal_px)
        size = tuple(checks.integers("size", self.size, (2,), 1).tolist())
        checks.instance("model", self.model, SkinModel)
        rules = checks.instance("rules", self.rules, SkinRules)
        object.__setattr__(self, "centre", centre)
        object.__setattr__(self, "focal_px", focal)
        object.__setattr__(self, "size", size)
        rows, columns = self._shape
        phi = -np.pi + 2 * np.pi / columns * (np.arange(columns) + 0.5)
        elevation = rules.band[0] + rules.step * (np.arange(rows) + 0.5)
        radius = focal * (np.pi / 2 - elevation)[:, None]
        u, v = centre[0] - radius * np.sin(phi), centre[1] + radius * np.cos(phi)
        object.__setattr__(self, "_pixels", (u.astype(np.float32), v.astype(np.float32)))

    @property
    def _shape(self) -> tuple[int, int]:
        """Samples of the band in elevation and in direction."""
        low, high = self.rules.band
        return max(round((high - low) / self.rules.step), 1), round(2 * np.pi / self.rules.step)

    def skin(self, image: UInt8[np.ndarray, "height width 3"]) -> Float[np.ndarray, "rows columns"]:
        r"""Return how probably each sample of the band shows skin.

        .. math:: p = \frac{q e^{\ell}}{q e^{\ell} + 1 - q} \quad\text{for a prior } q

        Parameters
        ----------
        image : (height, width, 3)
            Blue, green, red.

        Returns
        -------
        (rows, columns)
            By elevation, the lowest first, and direction, from -π to π.

        Raises
        ------
        TypeError
            If the image is missing or does not hold bytes.
        ValueError
            If its size is another.
        """
        _check_bytes("image", image, (*self.size[::-1], 3))
        band = cv2.remap(image, *self._pixels, cv2.INTER_LINEAR)  # black outside the image
        odds = np.exp(self.model.log_ratio(band)) * self.rules.prior / (1 - self.rules.prior)
        return odds / (1 + odds)

    def start(self) -> SkinState:
        """Return what is known before the first image: nothing."""
        return SkinState()

    def step(
        self,
        state: SkinState,
        image: UInt8[np.ndarray, "height width 3"],
        *,
        rng: np.random.Generator,
        elapsed: float = 1 / 7.5,
        turned: float = 0.0,
    ) -> tuple[SkinState, SkinInfo]:
        r"""Return the state after an image: each cloud drawn, moved and weighed; some begin or end.

        .. math:: p(z \mid x) \propto \exp(s(x) / \sigma)

        where :math:`s(x)` is the share of skin in the window around a particle.

        Parameters
        ----------
        state
            Before the image.
        image : (height, width, 3)
            Blue, green, red.
        rng
            Source of randomness.
        elapsed
            Time since the image before, s.
        turned
            By how much the robot has turned in that time, rad.

        Raises
        ------
        TypeError
            If an argument is of another type, or the image is missing.
        ValueError
            If the image has another size, or a number is not finite or a time negative.
        """
        checks.instance("state", state, SkinState)
        checks.generator("rng", rng)
        spread = np.sqrt(checks.not_negative("elapsed", elapsed)) * np.array(self.rules.drift)
        turned = checks.number("turned", turned)
        share = self._shares(self.skin(image))

        def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
            moved = states - [turned, 0.0] + spread * rng.normal(size=states.shape)
            return self._inside(moved)

        def log_likelihood(states: np.ndarray) -> np.ndarray:
            return share(states) / self.rules.softness

        clouds: list[Cloud] = []
        taken: list[float] = []
        for cloud in state.clouds:
            particles, _ = condensation(cloud.particles, move, log_likelihood, rng=rng)
            seen = bool(particles.weights @ share(particles.states) >= self.rules.least)
            moved = Cloud(particles, cloud.images + seen, 0 if seen else cloud.missed + 1)
            phi = moved.direction[0]
            if moved.missed < self.rules.patience and self._free(phi, taken):
                clouds.append(moved)
                taken.append(phi)
        kept = len(clouds)
        low, high = self.rules.band
        seeds = rng.uniform([-np.pi, low], [np.pi, high], (self.rules.seeds, 2))
        shares = share(seeds)
        for k in np.argsort(-shares, kind="stable"):
            if shares[k] < self.rules.least:
                break
            if self._free(seeds[k, 0], taken):
                offsets = np.array(self.rules.window) / 4
                around = seeds[k] + offsets * rng.normal(size=(self.rules.particles, 2))
                clouds.append(Cloud(ParticleSet.uniform(self._inside(around))))
                taken.append(clouds[-1].direction[0])
        return SkinState(tuple(clouds)), SkinInfo(len(clouds) - kept, len(state.clouds) - kept)

    def detect(self, state: SkinState) -> Gaussian:
        r"""Return in which directions people seem to be.

        .. math:: C = \operatorname{diag}(\sigma_r^2,\, \operatorname{var}(\varphi))

        Parameters
        ----------
        state
            After an image.

        Returns
        -------
        Gaussian
            Positions :math:`(r, \varphi)` of the clouds that the last image shows and that have
            been seen often enough: a mean and a variance of the distance that say nothing, and
            the direction of the cloud with its variance.

        References
        ----------
        Schaffernicht et al. 2005 (see `Detections`), section 3.1.
        """
        rules = self.rules
        found = [
            cloud.direction
            for cloud in checks.instance("state", state, SkinState).clouds
            if cloud.images >= rules.confirm and not cloud.missed
        ]
        phi, variance = np.array(found).reshape(-1, 2).T
        return bearings(phi, np.sqrt(variance), rules.distance, rules.range_sigma)

    def _inside(self, states: np.ndarray) -> np.ndarray:
        """Return states with the direction wrapped and the elevation within the band."""
        return np.stack([wrap_angle(states[:, 0]), states[:, 1].clip(*self.rules.band)], axis=-1)

    def _free(self, phi: float, taken: list[float]) -> bool:
        """Tell whether a direction is far from those of all clouds."""
        gaps = (abs(math.remainder(phi - other, 2 * math.pi)) for other in taken)
        return all(gap >= self.rules.apart for gap in gaps)

    def _shares(self, skin: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """Return the function of states that gives the share of skin in their windows."""
        rows, columns = skin.shape
        sides = np.array(self.rules.window) / self.rules.step
        across, up = np.minimum(np.maximum(sides // 2, 0), [columns // 2, rows]).astype(int)
        sums = cv2.integral(np.pad(skin, [(0, 0), (across, across)], mode="wrap"))
        low = self.rules.band[0]

        def share(states: np.ndarray) -> np.ndarray:
            j = np.floor((states[:, 0] + np.pi) / (2 * np.pi) * columns).astype(int) % columns
            i = np.floor((states[:, 1] - low) / self.rules.step).astype(int).clip(0, rows - 1)
            left, right = j, j + 2 * across + 1
            bottom, top = np.maximum(i - up, 0), np.minimum(i + up + 1, rows)
            total = sums[top, right] - sums[top, left] - sums[bottom, right] + sums[bottom, left]
            return total / ((top - bottom) * (right - left))

        return share


def _check_bytes(name: str, pixels: np.ndarray, shape: tuple) -> None:
    """Raise an error unless pixels are bytes of a shape."""
    if not isinstance(pixels, np.ndarray) or pixels.dtype != np.uint8:
        kind = pixels.dtype if isinstance(pixels, np.ndarray) else checks.shown(pixels)
        raise TypeError(f"{name} must be an array of bytes (uint8), got {kind}")
    checks.shaped(name, pixels, shape)


def _binned(pixels: np.ndarray, bins: int, darkest: float) -> tuple[np.ndarray | np.generic, ...]:
    """Return the bins of pixels by r and by g, and which are bright enough for it."""
    total = pixels.sum(axis=-1, dtype=np.int32)
    scaled = pixels[..., 2:0:-1] * np.int32(bins) // np.maximum(total, 1)[..., None]
    rows, columns = np.moveaxis(np.minimum(scaled, bins - 1), -1, 0)
    return rows, columns, total >= darkest

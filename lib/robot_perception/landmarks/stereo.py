"""Points from two eyes: features matched along the rows of a rectified pair, and triangulated."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float, Int, UInt8

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.cameras import StereoRig
from robot_perception.fields import Positive, checked
from robot_perception.landmarks.features import SIFT, Features, Sift, check_grey, detect
from robot_perception.landmarks.matching import match_window
from robot_perception.observations import Observations, unnamed


def _rising(name: str, value: Any) -> tuple[float, float]:
    low, high = checks.array(name, value, (2,), finite=False).tolist()
    if not 0 < low < high:
        raise ValueError(f"{name} must be positive and rise, got {[low, high]}")
    return low, high


@dataclass(frozen=True, slots=True)
class StereoRules:
    """Rules by which features of the two pictures are taken for the same point.

    Parameters
    ----------
    rows
        Largest distance between their rows, px: 2 in the paper.
    threshold
        Largest Euclidean distance between their descriptors, whose length is 512. The paper found
        its own "experimentally"; ours is about where on a real pair a match is as often wrong as
        one in ten.
    disparities
        Least and largest disparity, px. Less than 1 px is farther than any point is of use.

    Raises
    ------
    ValueError
        If a number is not positive, or the disparities are not in order.
    """

    rows: Positive = 2.0
    threshold: Positive = 200.0
    disparities: Annotated[tuple[float, float], _rising] = (1.0, np.inf)
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class StereoPoints:
    r"""Observations of a stereo pair, :math:`z_{t,k} = (v_{t,k}, d_{t,k})`.

    Parameters
    ----------
    features
        Of the left picture, those that were matched: n of them.
    measurements : (n, 3)
        Column left, row (the mean of the two), column right, px.
    points
        Their places in the frame of the left camera, m, with covariance (n, 3, 3).
    found
        Features in the left and in the right picture, matched or not.
    """

    features: Features
    measurements: Float[np.ndarray, "n 3"]
    points: Gaussian
    found: tuple[int, int]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.features)

    @property
    def observations(self) -> Observations:
        """The points with their covariances, as a filter takes them; nobody knows their names."""
        return unnamed(self.points.mean, self.points.cov)

    @property
    def descriptors(self) -> Float[np.ndarray, "n d"]:
        """Descriptor of each, in double precision, as a filter takes it."""
        return self.features.descriptors.astype(float)


def match_stereo(
    left: Features, right: Features, rules: StereoRules = StereoRules()
) -> Int[np.ndarray, "pairs 2"]:
    """Return which features of a rectified pair are the same point.

    Of all features near its row and in the range of disparities, each is the one whose descriptor
    is nearest to the other's, and nearer than the threshold; so no feature is in two pairs.

    Parameters
    ----------
    left, right
        Features of the two pictures.
    rules
        Rows, threshold and disparities.

    Returns
    -------
    (pairs, 2)
        Rows of ``left``, rising, and of ``right``.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If the descriptors of ``right`` are not of the same length as those of ``left``.

    References
    ----------
    Gil et al. (2006), §3.1.
    """
    check_both(left=left, right=right)
    least, most = checks.instance("rules", rules, StereoRules).disparities
    return match_window(left, left.pixels, right, (-most, -least), rules.rows, rules.threshold)


def observe(
    left: UInt8[np.ndarray, "height width"],
    right: UInt8[np.ndarray, "height width"],
    rig: StereoRig,
    *,
    sift: Sift = SIFT,
    rules: StereoRules = StereoRules(),
    sigma_px: float = 0.5,
) -> StereoPoints:
    r"""Find the points that a stereo pair shows, with covariances.

    Noise of a feature's column and row is taken for independent in the two pictures; the mean of
    two rows then has :math:`\sigma / \sqrt 2`.

    Parameters
    ----------
    left, right : (height, width)
        Grey pictures of a rectified pair, of the size that the rig has.
    rig
        The cameras.
    sift, rules
        What counts as a feature, and as a match.
    sigma_px
        Standard deviation of a feature's column, and of its row, px.

    Raises
    ------
    TypeError
        If a picture does not hold bytes or another argument is of another type.
    ValueError
        If ``left`` or ``right`` is not grey or not of the size of the rig's pictures, or
        ``sigma_px`` is not positive.

    References
    ----------
    Gil et al. (2006), §3.1.
    """
    size = checks.instance("rig", rig, StereoRig).camera.size
    for name, image in {"left": left, "right": right}.items():
        if check_grey(name, image).shape != size[::-1]:
            wide, high = size
            raise ValueError(f"{name} must be ({high}, {wide}) for the rig, got {image.shape}")
    sigma = checks.positive("sigma_px", sigma_px)
    seen = detect(left, sift), detect(right, sift)
    first, second = match_stereo(*seen, rules).T
    features, others = seen[0][first], seen[1].pixels[second]
    measurements = np.stack(
        [features.pixels[:, 0], (features.pixels[:, 1] + others[:, 1]) / 2, others[:, 0]], axis=1
    )
    points = rig.triangulate(measurements, np.array([sigma, sigma / np.sqrt(2), sigma]))
    return StereoPoints(features, measurements, points, (len(seen[0]), len(seen[1])))


def require_rectified(
    left: Features, right: Features, rules: StereoRules = StereoRules(), *, least: int = 12
) -> None:
    """Raise unless matches by descriptor alone lie as those of a rectified pair do.

    More than half must lie on equal rows; and of those the right picture must not show more further
    to the right than further to the left, else the eyes are swapped. Without this check a pair that
    is not rectified, a rig that has been knocked, or the right picture in the place of the left one
    gives few matches and wrong ones, and no error.

    Parameters
    ----------
    left, right
        Features of the two pictures.
    rules
        Rows and threshold; a shift of less than the least disparity is of no side.
    least
        Fewest matches that can tell.

    Raises
    ------
    ValueError
        If ``left`` and ``right`` are not a rectified pair, are swapped, or have too few matches to
        tell.
    """
    check_both(left=left, right=right)
    checks.instance("rules", rules, StereoRules)
    checks.whole("least", least, 1)
    anywhere = (-np.inf, np.inf)
    pairs = match_window(left, left.pixels, right, anywhere, np.inf, rules.threshold)
    if len(pairs) < least:
        raise ValueError(
            f"left and right have {len(pairs)} matches by descriptor, at least {least} must tell "
            "whether the pair is rectified"
        )
    shifts, offsets = (right.pixels[pairs[:, 1]] - left.pixels[pairs[:, 0]]).T
    level = np.abs(offsets) <= rules.rows
    if 2 * np.count_nonzero(level) <= len(pairs):
        raise ValueError(
            f"left and right are not a rectified pair: of {len(pairs)} matches by descriptor "
            f"{np.count_nonzero(level)} lie within {rules.rows:g} rows, the median offset is "
            f"{np.median(offsets):.1f} rows"
        )
    aside = rules.disparities[0]
    wrong, good = (np.count_nonzero(side[level] >= aside) for side in (shifts, -shifts))
    if wrong > good:
        raise ValueError(
            f"left and right seem to be swapped: of {np.count_nonzero(level)} matches on equal "
            f"rows {wrong} lie further to the right in the right picture, {good} further to the "
            "left, as points before two eyes do"
        )


def check_both(**sets: Features) -> None:
    """Raise unless two arguments are features with descriptors of one length."""
    lengths = {
        name: checks.instance(name, found, Features).descriptors.shape[1]
        for name, found in sets.items()
    }
    (first, d), (second, other) = lengths.items()
    if d != other:
        raise ValueError(f"descriptors of {second} must have {d} numbers as {first}, got {other}")

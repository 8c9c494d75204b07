r"""The map of the ceiling: poses of patterns that were seen together, and the robot's pose in it.

A *sighting* is the pose of a pattern in an image, :math:`(x, y, \theta, s)` in px, px, rad and 1
(eq. 5), of the ideal picture (see `correction`); those of one image stand by the names of the
patterns. The scale Z/f, the height of the ceiling over the focal length, m per px, turns pixels
into metres; where it is not known, a scale of 1 gives every position in px.

Equation numbers are those of Ait Aider, Chateau and Lapresté, "Indoor autonomous navigation using
visual memory and pattern tracking", BMVC 2004.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, UInt8
from scipy.optimize import least_squares
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from robot_perception import checks
from robot_perception.ceiling import _sightings
from robot_perception.ceiling.contours import picture
from robot_perception.extras import needing
from robot_perception.fields import checked
from robot_perception.geometry import se2, wrap_angle

with needing():
    import cv2

__all__ = [
    "AdjustInfo",
    "Links",
    "MeanPose",
    "Mosaic",
    "NoCommonPattern",
    "adjust",
    "align",
    "between_patterns",
    "camera_pose",
    "in_camera",
    "paint",
    "pieces",
    "place",
]

ORDERS = ("inverse first", "inverse last")
LARGEST_PAINTING = 2**26
"""Most pixels of a painting."""


class NoCommonPattern(ValueError):  # noqa: N818 - it names what is missing
    """Error: no pattern that is seen is known, so that no pose follows."""


def in_camera(
    sighting: Float[np.ndarray, "... 4"], *, centre: Float[np.ndarray, "2"], scale: float
) -> Float[np.ndarray, "... 3"]:
    r"""Return the pose of a pattern in the camera's frame on the ceiling.

    .. math::
        {}^C T_i = \begin{bmatrix} {}^I r_i & \frac{Z}{f}\, {}^I p_i \\ 0 & 1 \end{bmatrix}

    Parameters
    ----------
    sighting : (…, 4)
        Pose :math:`(x, y, \theta, s)` in the image, px, rad; its size s does not matter.
    centre : (2,)
        Principal point, px.
    scale
        Z/f, m per px; 1 gives px.

    Returns
    -------
    (…, 3)
        Position and heading, m and rad.

    Raises
    ------
    ValueError
        If the shape is wrong, a number is not finite or the scale not positive.

    References
    ----------
    Section 2.2.
    """
    seen = _sightings.sighting("sighting", sighting)
    return _sightings.metric(seen, _sightings.centre(centre), _sightings.scale(scale))


def camera_pose(
    pattern_in_mosaic: Float[np.ndarray, "... 3"], pattern_in_camera: Float[np.ndarray, "... 3"]
) -> Float[np.ndarray, "... 3"]:
    r"""Return the pose of the camera in the mosaic, from one pattern.

    .. math:: {}^M T_C = {}^M T_i \left( {}^C T_i \right)^{-1} \qquad \text{(eq. 2)}

    Parameters
    ----------
    pattern_in_mosaic : (…, 3)
        :math:`{}^M T_i`, m and rad.
    pattern_in_camera : (…, 3)
        :math:`{}^C T_i`, see `in_camera`.

    Returns
    -------
    (…, 3)
        Position and heading, m and rad.

    Raises
    ------
    ValueError
        If a shape is wrong or a number is not finite.

    References
    ----------
    Section 2.2, eq. (2).
    """
    known = _sightings.pose("pattern_in_mosaic", pattern_in_mosaic)
    seen = _sightings.pose("pattern_in_camera", pattern_in_camera)
    checks.check_batches(pattern_in_mosaic=known.shape[:-1], pattern_in_camera=seen.shape[:-1])
    return se2.compose(known, se2.inverse(seen))  # eq. (2)


def between_patterns(
    known: Float[np.ndarray, "... 4"],
    new: Float[np.ndarray, "... 4"],
    order: str = "inverse first",
) -> Float[np.ndarray, "... 3"]:
    r"""Return the pose of one pattern from another that is seen in the same image, px and rad.

    Section 2.3 prints a quotient of two transformations, which can be read in two ways:

    .. math::
        {}^0 L_i = \left( {}^I L_0 \right)^{-1} {}^I L_i \qquad \text{or} \qquad
        {}^I L_i \left( {}^I L_0 \right)^{-1}

    The first is right. A motion g of the camera takes both sightings to :math:`g\,L`, and it
    cancels: :math:`(g L_0)^{-1} g L_i = L_0^{-1} L_i`. In the second it does not:
    :math:`g\, L_i L_0^{-1} g^{-1}` depends on where the robot is.

    Parameters
    ----------
    known : (…, 4)
        Sighting of the pattern in whose frame the answer is.
    new : (…, 4)
        Sighting of the other; sizes s do not matter.
    order
        ``"inverse first"`` or ``"inverse last"``, the wrong one, which is here to be compared.

    Returns
    -------
    (…, 3)
        Position, px, and heading, rad.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite or the order unknown.

    References
    ----------
    Section 2.3; erratum: the order of the quotient, and its first factor, printed
    :math:`{}^0 L_i` where :math:`{}^I L_0` is meant.
    """
    known, new = _sightings.sighting("known", known), _sightings.sighting("new", new)
    checks.check_batches(known=known.shape[:-1], new=new.shape[:-1])
    checks.one_of("order", order, ORDERS)
    if order == "inverse first":
        return se2.between(known[..., :3], new[..., :3])
    return se2.compose(new[..., :3], se2.inverse(known[..., :3]))


def place(
    pose_of_known: Float[np.ndarray, "... 3"],
    known: Float[np.ndarray, "... 4"],
    new: Float[np.ndarray, "... 4"],
    *,
    centre: Float[np.ndarray, "2"],
    scale: float,
    order: str = "inverse first",
) -> Float[np.ndarray, "... 3"]:
    r"""Return the pose in the mosaic of a new pattern, seen beside one that is in it.

    .. math::
        {}^M T_i = {}^M T_j\, {}^j T_i, \qquad
        {}^j T_i = \begin{bmatrix} {}^j r_i & \frac{Z}{f}\, {}^j p_i \\ 0 & 1 \end{bmatrix}
        \qquad \text{(eq. 3)}

    Parameters
    ----------
    pose_of_known : (…, 3)
        :math:`{}^M T_j`, m and rad; (0, 0, 0) for the pattern that serves as the reference.
    known, new : (…, 4)
        Sightings of the two in one image.
    centre : (2,)
        Principal point, px; in the right order it cancels.
    scale
        Z/f, m per px.
    order
        Of the quotient, see `between_patterns`.

    Returns
    -------
    (…, 3)
        Position and heading, m and rad.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite, the scale not positive or the order unknown.

    References
    ----------
    Section 2.3, eq. (3).
    """
    start = _sightings.pose("pose_of_known", pose_of_known)
    known, new = _sightings.sighting("known", known), _sightings.sighting("new", new)
    origin = np.append(_sightings.centre(centre), [0.0, 0.0])
    step = between_patterns(known - origin, new - origin, order)
    checks.check_batches(pose_of_known=start.shape[:-1], known_and_new=step.shape[:-1])
    step[..., :2] *= _sightings.scale(scale)
    return se2.compose(start, step)  # eq. (3)


def align(
    known: Float[np.ndarray, "n 3"],
    seen: Float[np.ndarray, "n 3"],
    position_weights: Float[np.ndarray, " n"],
    heading_weights: Float[np.ndarray, " n"],
) -> Float[np.ndarray, "3"]:
    r"""Return the motion that takes poses to poses best: the least squares of eq. (2).

    .. math::
        \min_{t, \varphi} \sum_i a_i \left\lVert P_i - t - R(\varphi)\, p_i \right\rVert^2
        + 2\, b_i \left( 1 - \cos(\Theta_i - \theta_i - \varphi) \right)

    The second term is the square of the difference of headings, wherever that is small, and lets
    the minimum be written down: with positions from their weighted means,

    .. math::
        \varphi = \operatorname{atan2}\left(
        \sum a_i\, p_i \times P_i + \sum b_i \sin(\Theta_i - \theta_i),\;
        \sum a_i\, p_i \cdot P_i + \sum b_i \cos(\Theta_i - \theta_i) \right), \qquad
        t = \bar P - R(\varphi)\, \bar p

    From one pair it is exactly :math:`T_i (\,{}^C T_i)^{-1}`. From several it is better than the
    mean of what eq. (2) gives for each: that a pattern far off has a heading wrong by 1° moves its
    eq. (2) far, here the places of two patterns tell the heading as well.

    Parameters
    ----------
    known : (n, 3)
        Poses :math:`(P_i, \Theta_i)` in the frame that is asked for, m and rad.
    seen : (n, 3)
        The same poses :math:`(p_i, \theta_i)` in the frame whose pose is sought.
    position_weights : (n,)
        :math:`a_i`, one over the variance of a coordinate, 1/m².
    heading_weights : (n,)
        :math:`b_i`, one over the variance of a heading, 1/rad².

    Returns
    -------
    (3,)
        :math:`(t, \varphi)`, m and rad.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite, weights are negative or none of them positive,
        or the poses say nothing of the heading.
    """
    known = checks.moderate("known", checks.array("known", known, ("n", 3)), _sightings.LARGEST)
    shape = (len(known), 3)
    seen = checks.moderate("seen", checks.array("seen", seen, shape, "known"), _sightings.LARGEST)
    a = _sightings.weights("position_weights", position_weights, len(known))
    b = _sightings.weights("heading_weights", heading_weights, len(known))
    if not a.sum() > 0:
        raise ValueError(f"position_weights must not all be 0, got {checks.shown(a)}")
    return _sightings.aligned(known, seen, a, b)


@dataclass(frozen=True, eq=False, slots=True)
class Mosaic:
    r"""The patterns of a ceiling and where they are: a map, and what is needed to use it.

    Parameters
    ----------
    poses
        :math:`{}^M T_i` of each pattern by its name, m and rad.
    scale
        Z/f, m per px; 1 where it is not known: the mosaic is in px then.
    centre : (2,)
        Principal point of the ideal picture, px.

    References
    ----------
    Section 2.2: :math:`\mathcal{M} = \{(m_i, {}^M T_i)\}`.
    """

    poses: Mapping[str, Annotated[Float[np.ndarray, "3"], _sightings.own]]
    scale: Annotated[float, _sightings.metres_per_px]
    centre: Annotated[Float[np.ndarray, "2"], _sightings.own]
    __post_init__ = checked

    def with_pattern(self, name: str, pose: Float[np.ndarray, "3"]) -> "Mosaic":
        """Return the mosaic with a pattern more, or with a pattern moved.

        Parameters
        ----------
        name
            Of the pattern.
        pose : (3,)
            :math:`{}^M T_i`, m and rad; see `place`.

        Raises
        ------
        ValueError
            If the pose is not three finite numbers.
        """
        name = checks.instance("name", name, str)
        return Mosaic(
            {**self.poses, name: _sightings.pose("pose", pose, (3,))}, self.scale, self.centre
        )

    def locate(
        self,
        sightings: Mapping[str, Float[np.ndarray, "4"]],
        weights: Mapping[str, float] | None = None,
        *,
        sigma_px: float = _sightings.SIGMA_PX,
        sigma_heading: float = _sightings.SIGMA_HEADING,
    ) -> tuple[Float[np.ndarray, "3"], dict[str, Float[np.ndarray, "3"]]]:
        r"""Return the pose of the camera from all patterns that it sees together.

        One pattern gives exactly eq. (2), several the least squares of `align`.

        Parameters
        ----------
        sightings
            Of one image, by names; patterns that the mosaic does not have are left out.
        weights
            How much each pattern counts, by its name; 1 where not given. An observation with the
            weight 4 is one of half the standard deviations.
        sigma_px, sigma_heading
            Standard deviations of a sighting, px and rad; only their ratio matters. Ours.

        Returns
        -------
        pose : (3,)
            :math:`{}^M T_C`, m and rad.
        residuals
            For each pattern that was used, by how much it is seen elsewhere than the pose says:
            position and heading in the camera's frame, m and rad.

        Raises
        ------
        NoCommonPattern
            If the mosaic has none of the patterns.
        ValueError
            If a sighting is wrong, a weight negative, all weights 0, or the headings contradict
            each other so that none is better than another.
        """
        sightings = _sightings.sightings("sightings", sightings)
        names = [name for name in sightings if name in self.poses]
        if not names:
            raise NoCommonPattern(
                f"sightings must have a pattern of the mosaic, got {checks.shown([*sightings])}"
            )
        counts = _sightings.counts(weights, names)
        known = np.array([self.poses[name] for name in names])
        seen = _sightings.metric(
            np.array([sightings[name] for name in names]), self.centre, self.scale
        )
        a, b = _sightings.shares(sigma_px, sigma_heading, self.scale)
        pose = _sightings.aligned(known, seen, a * counts, b * counts)
        misses = seen - se2.between(pose, known)
        misses[:, 2] = wrap_angle(misses[:, 2])
        return pose, dict(zip(names, misses, strict=True))

    def expected(self, pose: Float[np.ndarray, "... 3"], name: str) -> Float[np.ndarray, "... 4"]:
        """Return where a pattern is seen from a pose, whether or not that is in the picture.

        The inverse of eq. (2).

        Parameters
        ----------
        pose : (…, 3)
            Of the camera in the mosaic, m and rad.
        name
            Of a pattern of the mosaic.

        Returns
        -------
        (…, 4)
            A sighting: px, px, rad, and a size of 1.

        Raises
        ------
        ValueError
            If the mosaic has no such pattern, the shape is wrong or a number is not finite.
        """
        pose = _sightings.pose("pose", pose)
        if checks.instance("name", name, str) not in self.poses:
            raise ValueError(f"name must be that of a pattern of the mosaic, got {name!r}")
        seen = se2.between(pose, self.poses[name])
        return np.concatenate(
            [
                seen[..., :2] / self.scale + self.centre,
                seen[..., 2:],
                np.ones((*seen.shape[:-1], 1)),
            ],
            axis=-1,
        )


@dataclass(frozen=True, eq=False, slots=True)
class MeanPose:
    r"""Mean relative pose of two patterns over all images that show both.

    Parameters
    ----------
    pose : (3,)
        :math:`{}^j T_i` of the second in the frame of the first: mean position, m, and circular
        mean of the heading, rad.
    count
        The number of images.
    """

    pose: Float[np.ndarray, "3"]
    count: int


@dataclass(frozen=True, eq=False, slots=True)
class Links:
    """Pairs of patterns that were seen together, with their mean relative poses.

    It grows with the pairs, not with the images: each pair has a count and four sums. Starts empty;
    `add` returns new links and shares the sums of all other pairs with the old ones, so that an
    image costs its own pairs and the copy of a dictionary.
    """

    _sums: dict[tuple[str, str], Float[np.ndarray, "5"]] = field(
        init=False, default_factory=dict, repr=False
    )

    def add(
        self,
        sightings: Mapping[str, Float[np.ndarray, "4"]],
        centre: Float[np.ndarray, "2"],
        scale: float,
    ) -> "Links":
        """Return the links with those of one more image.

        Parameters
        ----------
        sightings
            Of one image, by names.
        centre : (2,)
            Principal point, px.
        scale
            Z/f, m per px.

        Raises
        ------
        ValueError
            If a sighting is wrong or the scale not positive.
        """
        sightings = _sightings.sightings("sightings", sightings)
        centre, scale = _sightings.centre(centre), _sightings.scale(scale)
        names = sorted(sightings)
        seen = np.array([sightings[name] for name in names]).reshape(-1, 4)
        poses = _sightings.metric(seen, centre, scale)
        first, second = np.triu_indices(len(names), 1)
        ways = se2.between(poses[first], poses[second])
        new = np.column_stack(
            [ways[:, :2], np.cos(ways[:, 2]), np.sin(ways[:, 2]), np.ones(len(ways))]
        )
        sums = dict(self._sums)
        for i, j, more in zip(first.tolist(), second.tolist(), new, strict=True):
            pair = names[i], names[j]
            before = sums.get(pair)
            sums[pair] = more if before is None else before + more
        links = Links()
        object.__setattr__(links, "_sums", sums)
        return links

    def means(self) -> dict[tuple[str, str], MeanPose]:
        """Return the mean way from the first to the second of each pair, in alphabetical order."""
        return {
            pair: MeanPose(
                np.array([x / count, y / count, wrap_angle(math.atan2(sin, cos))]), int(count)
            )
            for pair, (x, y, cos, sin, count) in self._sums.items()
        }

    def groups(self, names: Iterable[str]) -> tuple[tuple[str, ...], ...]:
        """Return patterns in groups that were seen together, directly or by a chain of images.

        Nothing that was seen tells where one group is from another.

        Parameters
        ----------
        names
            Of the patterns.

        Returns
        -------
        tuple
            Of each group its names, in their order; the groups in that of their first ones.
        """
        names = list(
            dict.fromkeys(checks.instances("names", tuple(checks.iterable("names", names)), str))
        )
        place_of = {name: k for k, name in enumerate(names)}
        pairs = [(a, b) for a, b in self._sums if a in place_of and b in place_of]
        ends = np.array([[place_of[name] for name in pair] for pair in pairs], dtype=np.int64)
        groups: dict[int, list[str]] = {}
        for name, part in zip(names, _parts(ends.reshape(-1, 2), len(names)), strict=True):
            groups.setdefault(part, []).append(name)
        return tuple(map(tuple, groups.values()))


@dataclass(frozen=True, eq=False, slots=True)
class AdjustInfo:
    """Diagnostics of an adjustment.

    Parameters
    ----------
    cost_before, cost_after
        Half the sum of the squares in standard deviations, or of what the robust loss makes of
        them.
    iterations
        How often the residuals were computed.
    links
        How many links were used.
    left_out
        How many were not, since the mosaic does not have their patterns.
    residuals
        Of each link that was used: measured minus adjusted way, m and rad.
    """

    cost_before: float
    cost_after: float
    iterations: int
    links: int
    left_out: int
    residuals: dict[tuple[str, str], Float[np.ndarray, "3"]]


def adjust(
    mosaic: Mosaic,
    links: Links,
    *,
    fixed: str,
    sigma_px: float = _sightings.SIGMA_PX,
    sigma_heading: float = _sightings.SIGMA_HEADING,
    loss: str = "linear",
) -> tuple[Mosaic, AdjustInfo]:
    r"""Return the mosaic that fits all links together best, as one would build it today.

    .. math::
        \min_{T} \sum_{(i, j)} n_{ij} \left\lVert \left( T_i^{-1} T_j \right) - {}^i \bar T_j
        \right\rVert^2_{C_{ij}^{-1}}

    The paper chains each new pattern to one that is known and never goes back, so that errors add
    up along the way; when the robot comes back to a pattern, the links close a loop, and the error
    is spread over it. The reference pattern stays where it is.

    A way is as exact as the two sightings it comes from. With the standard deviations
    :math:`\sigma_p` and :math:`\sigma_\theta` of each, a wrong heading of the first turns the whole
    way, so that to first order

    .. math::
        C = \begin{bmatrix} 2\sigma_p^2 I + \sigma_\theta^2\, z^\perp z^{\perp\top} &
        \sigma_\theta^2\, z^\perp \\ \sigma_\theta^2\, z^{\perp\top} & 2\sigma_\theta^2
        \end{bmatrix}, \qquad z^\perp = (-z_y, z_x)

    with z the position of the second in the frame of the first: its distance is known far better
    than its direction. Images count as independent of each other, and so do the links of one image;
    where they are not, the weights keep their proportions only roughly.

    Parameters
    ----------
    mosaic
        Where the search starts; its headings must be right to within a right angle or so.
    links
        Of a whole run.
    fixed
        The name of the reference pattern.
    sigma_px, sigma_heading
        Standard deviations of a sighting, px and rad; ours.
    loss
        ``"linear"`` for least squares, or a robust loss of `scipy.optimize.least_squares`,
        ``"huber"``, ``"soft_l1"`` or ``"cauchy"``, of each number in its standard deviations.

    Returns
    -------
    mosaic
        The same patterns in their new poses.
    info
        Cost, effort and residuals.

    Raises
    ------
    ValueError
        If the mosaic does not have the reference pattern, no chain of links leads from it to some
        patterns (the message names them), or a number is out of its range.
    """
    checks.instance("mosaic", mosaic, Mosaic)
    checks.instance("links", links, Links)
    checks.one_of("loss", loss, ("linear", "huber", "soft_l1", "cauchy"))
    if checks.instance("fixed", fixed, str) not in mosaic.poses:
        raise ValueError(f"fixed must be the name of a pattern of the mosaic, got {fixed!r}")
    names = [fixed, *(name for name in mosaic.poses if name != fixed)]
    place_of = {name: k for k, name in enumerate(names)}
    every = links.means()
    used = {pair: link for pair, link in every.items() if set(pair) <= set(place_of)}
    ends = np.array([[place_of[name] for name in pair] for pair in used], dtype=np.int64)
    ends = ends.reshape(-1, 2)
    _connected(ends, names)
    ways = np.array([link.pose for link in used.values()]).reshape(-1, 3)
    counts = np.array([link.count for link in used.values()], dtype=float)
    sigma_px = checks.positive("sigma_px", sigma_px)
    sigma_heading = checks.positive("sigma_heading", sigma_heading)
    with checks.computable("mosaic, links, sigma_px and sigma_heading"):
        white = _whitening(ways, counts, sigma_px * mosaic.scale, sigma_heading)
        start = np.array([mosaic.poses[name] for name in names])
        if not ways.size:
            return mosaic, AdjustInfo(0.0, 0.0, 0, 0, len(every), {})
        found, cost, effort = _solved(start, ends, ways, white, loss)
    found[:, 2] = wrap_angle(found[:, 2])
    misses = ways - se2.between(found[ends[:, 0]], found[ends[:, 1]])
    misses[:, 2] = wrap_angle(misses[:, 2])
    poses = {name: found[place_of[name]] for name in mosaic.poses}
    info = AdjustInfo(
        cost_before=cost[0],
        cost_after=cost[1],
        iterations=effort,
        links=len(used),
        left_out=len(every) - len(used),
        residuals=dict(zip(used, misses, strict=True)),
    )
    return Mosaic(poses, mosaic.scale, mosaic.centre), info


def pieces(mosaic: Mosaic, links: Links) -> tuple[Mosaic, ...]:
    """Return a mosaic in pieces, each in the frame of its first pattern.

    Nothing tells where one piece lies from another: no pattern of the one was seen together with
    one of the other, because the camera was blind on the way. Where the mosaic has them is a guess.

    Parameters
    ----------
    mosaic
        As it was built.
    links
        Of the whole run.

    Returns
    -------
    tuple
        Pieces in the order of their first patterns; one only where the camera was never lost.
    """
    checks.instance("mosaic", mosaic, Mosaic)
    checks.instance("links", links, Links)
    poses = mosaic.poses
    return tuple(
        replace(mosaic, poses={name: se2.between(poses[group[0]], poses[name]) for name in group})
        for group in links.groups(poses)
    )


def _solved(
    start: np.ndarray, ends: np.ndarray, ways: np.ndarray, white: np.ndarray, loss: str
) -> tuple[np.ndarray, tuple[float, float], int]:
    """Return the poses of the least cost, the cost before and after, and the evaluations."""

    def poses(free: np.ndarray) -> np.ndarray:
        return np.concatenate([start[:1], free.reshape(-1, 3)])

    def residuals(free: np.ndarray) -> np.ndarray:
        return _residuals(poses(free), ends, ways, white)

    def jacobian(free: np.ndarray) -> csr_array:
        return _jacobian(poses(free), ends, white)

    free = start[1:].ravel()
    tight = {"ftol": 1e-15, "xtol": 1e-15, "gtol": 1e-15}
    solver = {
        "tr_solver": "lsmr",
        "tr_options": {"atol": 1e-15, "btol": 1e-15, "regularize": False},
    }
    before = least_squares(residuals, free, jacobian, loss=loss, max_nfev=1, **solver).cost
    found = least_squares(residuals, free, jacobian, loss=loss, max_nfev=200, **tight, **solver)
    return poses(found.x), (float(before), float(found.cost)), int(found.nfev)


def _residuals(
    poses: np.ndarray, ends: np.ndarray, ways: np.ndarray, white: np.ndarray
) -> np.ndarray:
    """Return expected minus measured ways in standard deviations, (3 · links,)."""
    first, second = poses[ends[:, 0]], poses[ends[:, 1]]
    misses = se2.between(first, second) - ways
    misses[:, 2] = wrap_angle(misses[:, 2])
    return (white @ misses[..., None]).ravel()


def _jacobian(poses: np.ndarray, ends: np.ndarray, white: np.ndarray) -> csr_array:
    """Return the derivatives of `_residuals` by all poses but the first."""
    first, second = poses[ends[:, 0]], poses[ends[:, 1]]
    expected = se2.between(first, second)
    by_second = np.zeros((len(ends), 3, 3))
    by_second[:, :2, :2] = se2.rotation(first[:, 2]).mT
    by_second[:, 2, 2] = 1
    by_first = -by_second
    by_first[:, 0, 2], by_first[:, 1, 2] = expected[:, 1], -expected[:, 0]
    blocks = np.stack([white @ by_first, white @ by_second])
    columns = 3 * (ends.T - 1)[:, :, None, None] + np.arange(3)
    rows = (3 * np.arange(len(ends))[:, None] + np.arange(3))[None, :, :, None]
    columns, rows = np.broadcast_to(columns, blocks.shape), np.broadcast_to(rows, blocks.shape)
    free = columns >= 0
    shape = (3 * len(ends), 3 * (len(poses) - 1))
    return coo_array((blocks[free], (rows[free], columns[free])), shape=shape).tocsr()


def _whitening(
    ways: np.ndarray, counts: np.ndarray, sigma: float, sigma_heading: float
) -> np.ndarray:
    """Return for each link the matrix that makes its error one of unit covariance, (links, 3, 3).

    By Cholesky's factors of C, which are solved for the identity.
    """
    across = np.column_stack([-ways[:, 1], ways[:, 0], np.ones(len(ways))])
    C = sigma_heading**2 * across[:, :, None] * across[:, None, :]
    C[:, [0, 1], [0, 1]] += 2 * sigma**2
    C[:, 2, 2] += sigma_heading**2
    factor = np.linalg.cholesky(C)
    return np.sqrt(counts)[:, None, None] * np.linalg.solve(factor, np.eye(3))


def _parts(ends: np.ndarray, count: int) -> list[int]:
    """Return of which part each pattern is, by the links between them (links, 2)."""
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1].tolist()


def _connected(ends: np.ndarray, names: list[str]) -> None:
    """Raise ``ValueError`` unless links lead from the first pattern to all others."""
    parts = _parts(ends, len(names))
    lost = [name for name, part in zip(names, parts, strict=True) if part != parts[0]]
    if lost:
        words = ", ".join(map(repr, lost[:10])) + (" …" if len(lost) > 10 else "")
        raise ValueError(f"links must lead from {names[0]!r} to every pattern, not to {words}")


def paint(
    images: Iterable[UInt8[np.ndarray, "height width"]],
    poses: Float[np.ndarray, "n 3"],
    *,
    centre: Float[np.ndarray, "2"],
    scale: float,
) -> tuple[
    UInt8[np.ndarray, "rows columns"], Bool[np.ndarray, "rows columns"], Float[np.ndarray, "2"]
]:
    r"""Return the ceiling as one picture: the mean of pictures, each laid where it was taken.

    A pixel p of a picture from the pose :math:`(t, \theta)` lies at
    :math:`t + \tfrac{Z}{f} R(\theta)\, (p - c)`. A pixel of the painting is as wide as one of the
    pictures, its columns run along x and its rows along y: the ceiling as it is seen from below.

    Parameters
    ----------
    images : n of (height, width)
        Grey values, ideal pictures of one size; they are asked for one by one.
    poses : (n, 3)
        Of the camera in the mosaic, m and rad; see `Mosaic.locate`.
    centre : (2,)
        Principal point c, px.
    scale
        Z/f, m per px.

    Returns
    -------
    greys : (rows, columns)
        0 where no picture shows the ceiling.
    seen : (rows, columns)
        Where one does.
    corner : (2,)
        Where the middle of the first pixel is in the mosaic, m.

    Raises
    ------
    TypeError
        If an image does not hold bytes.
    ValueError
        If there is no image, there are not as many as poses, sizes differ, or the painting would
        have more than 2²⁶ pixels.
    """
    poses = _sightings.pose("poses", poses, ("n", 3))
    centre, scale = _sightings.centre(centre), _sightings.scale(scale)
    poses = np.column_stack([poses[:, :2] / scale, poses[:, 2]])
    done, shape = 0, ()
    for image in checks.iterable("images", images):
        own = picture("images", image).shape
        if done == len(poses):
            raise ValueError(f"images must be as many as poses, {len(poses)}, got more")
        if not done:
            shape, (corner, sums) = own, _canvas(poses, centre, own)
        if own != shape:
            raise ValueError(f"images must be of one size, {shape}, got {own}")
        _lay(sums, image, poses[done] - [*corner, 0], centre)
        done += 1
    if not done or done < len(poses):
        raise ValueError(f"images must be as many as poses, {len(poses)}, got {done}")
    total, share = sums
    seen = share > 0.5
    greys = np.where(seen, total / np.maximum(share, 0.5), 0.0)
    return np.rint(greys).astype(np.uint8), seen, corner * scale


def _corners(poses: np.ndarray, centre: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return where the corners of pictures lie, px (…, 4, 2)."""
    ends = np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) * np.subtract(shape[::-1], 1)
    return se2.act(poses, ends - centre)


def _canvas(
    poses: np.ndarray, centre: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the first pixel of a painting, and its sums of greys and shares, empty."""
    ends = _corners(poses, centre, shape).reshape(-1, 2)
    low = ends.min(axis=0)
    columns, rows = np.ceil(ends.max(axis=0) - low - 1e-6) + 1
    if rows * columns > LARGEST_PAINTING:
        raise ValueError(f"poses must lie closer, got a painting of {columns:g} × {rows:g} px")
    return low, np.zeros((2, int(rows), int(columns)), np.float32)


def _lay(sums: np.ndarray, image: np.ndarray, pose: np.ndarray, centre: np.ndarray) -> None:
    """Add a picture to a painting, between the pixels by their shares."""
    ends = _corners(pose, centre, image.shape)
    left, top = np.maximum(np.floor(ends.min(axis=0)), 0).astype(int)
    right, bottom = np.ceil(ends.max(axis=0)).astype(int) + 1
    part = sums[:, top:bottom, left:right]
    R = se2.rotation(pose[2])
    M = np.column_stack([R, pose[:2] - [left, top] - R @ centre])
    for layer, values in zip(part, (image.astype(np.float32), np.ones(image.shape, np.float32)),
                             strict=True):  # fmt: skip
        layer += cv2.warpAffine(values, M, layer.shape[::-1])

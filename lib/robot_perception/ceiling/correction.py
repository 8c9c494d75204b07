r"""Correction of a tilted, displaced camera: the picture that an ideal camera would have taken.

The *ideal* camera stands at the origin of the robot's frame and looks along its z axis. As the
ceiling is a plane, its picture in any other camera differs from the ideal one by a homography. That
holds for the ceiling alone; a wall or a hanging lamp is moved to a wrong place.

Equation numbers are those of Ait Aider, Chateau and Lapresté, "Indoor autonomous navigation using
visual memory and pattern tracking", BMVC 2004.
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int16, UInt8, UInt16

from robot_perception import checks
from robot_perception.cameras import Pinhole
from robot_perception.extras import needing
from robot_perception.fields import Positive, checked, numbers
from robot_perception.geometry import se3

with needing():
    import cv2

__all__ = ["Correction", "correction"]

TOLERANCE = 1e-5
"""Largest deviation of a normal's length from 1, as of a normal typed with six digits."""

PIXELS = 2**26
"""The most pixels of a picture."""

OUTSIDE = 16
"""Distance beyond a picture's edge, px, at which all farther points are looked up: it is black."""


def correction(
    K: Float[np.ndarray, "3 3"],
    rotation: Float[np.ndarray, "3 3"],
    translation: Float[np.ndarray, "3"],
    normal: Float[np.ndarray, "3"],
    distance: float,
    target: Float[np.ndarray, "3 3"] | None = None,
) -> Float[np.ndarray, "3 3"]:
    r"""Return the homography from the ideal picture of the ceiling to that of the camera.

    .. math::
        {}^C H_R = K \left( R - \frac{t\, n^\top}{d} \right) K_{target}^{-1} \qquad \text{(eq. 1)}

    A point X in the robot's frame is at :math:`R X + t` in the camera's. The paper does not say
    which way n points, and the sign of the second term depends on it. With the printed minus,
    eq. (1) holds for the normal that points from the ceiling *to the robot*: then
    :math:`n^\top X = -d` on the ceiling, and :math:`R X + t = (R - t\, n^\top / d)\, X`. With a
    normal that points up, the same formula would correct for :math:`-t`.

    Parameters
    ----------
    K : (3, 3)
        Intrinsic parameters of the camera, px.
    rotation : (3, 3)
        R, from the robot's frame to the camera's.
    translation : (3,)
        t, the origin of the robot's frame in the camera's frame, m.
    normal : (3,)
        n, the unit normal of the ceiling in the robot's frame, towards the robot: (0, 0, -1) for a
        level ceiling.
    distance
        d, from the origin of the robot's frame to the ceiling, m.
    target : (3, 3)
        Intrinsic parameters of the ideal picture, px; those of the camera if not given.

    Returns
    -------
    (3, 3)
        The homography from pixels of the ideal picture to pixels of the camera's. It is not
        rescaled: the third coordinate of :math:`{}^C H_R\,(u, v, 1)^\top` is the depth of the point
        in the camera divided by its depth in the ideal camera.

    Raises
    ------
    ValueError
        If K or the target is no matrix of intrinsic parameters, R is no rotation, the normal is not
        of length 1, the distance is not positive, or the camera is not below the ceiling (in the
        plane of the ceiling the homography is singular).

    References
    ----------
    Section 2.1, eq. (1).
    """
    K = _intrinsic("K", K)
    target = K if target is None else _intrinsic("target", target)
    A = _of_rays(rotation, translation, normal, distance)
    return np.linalg.solve(target.T, (K @ A).T).T  # eq. (1)


def _of_a_picture(name: str, value: tuple[int, int]) -> tuple[int, int]:
    """Return width and height, or raise ``ValueError`` if OpenCV's `remap` cannot take them."""
    width, height = checks.integers(name, value, (2,), 1).tolist()
    if width * height > PIXELS or max(width, height) >= 2**15 - 2 * OUTSIDE:
        raise ValueError(f"{name} must be that of a picture, got {(width, height)}")
    return width, height


@dataclass(frozen=True, eq=False, slots=True)
class Correction:
    r"""Correction of pictures, and of single points, from a mounted camera to the ideal one.

    For each pixel of the ideal picture the place in the camera's picture is computed once, to a
    32nd of a pixel: eq. (1) without the intrinsic parameters takes its ray to a ray
    :math:`(x', y', 1)` of the camera, the lens bends it,

    .. math:: (x'', y'') = (1 + k_1 r^2 + k_2 r^4)\,(x', y'), \qquad r^2 = x'^2 + y'^2,

    and K takes it to a pixel.

    Parameters
    ----------
    K : (3, 3)
        Intrinsic parameters of the camera, px, without skew.
    rotation : (3, 3)
        R, from the robot's frame to the camera's.
    translation : (3,)
        t, the origin of the robot's frame in the camera's frame, m.
    normal : (3,)
        n, the unit normal of the ceiling towards the robot (see `correction`).
    distance
        d, from the origin of the robot's frame to the ceiling, m.
    size
        Width and height of both pictures, px.
    distortion
        :math:`k_1, k_2`, radial distortion of the lens in OpenCV's (Brown's) model; the paper has
        none.
    target : (3, 3)
        Intrinsic parameters of the ideal picture, px; those of the camera if not given.

    Attributes
    ----------
    homography : (3, 3)
        The homography of eq. (1) without the lens (see `correction`).
    seen : (height, width)
        Whether the camera sees each pixel of the ideal picture; the others are black.

    Raises
    ------
    ValueError
        If an argument is wrong (see `correction`), the normal does not point to the robot, the
        ideal picture reaches the ceiling's horizon, or a part of it is not in front of the camera.

    References
    ----------
    Section 2.1, eq. (1).
    """

    K: Float[np.ndarray, "3 3"]
    rotation: Float[np.ndarray, "3 3"]
    translation: Float[np.ndarray, "3"]
    normal: Float[np.ndarray, "3"]
    distance: Positive
    size: Annotated[tuple[int, int], _of_a_picture]
    distortion: Annotated[tuple[float, float], numbers(2)] = (0.0, 0.0)
    target: Float[np.ndarray, "3 3"] | None = None
    homography: Float[np.ndarray, "3 3"] = field(init=False)
    seen: Bool[np.ndarray, "height width"] = field(init=False, repr=False)
    _camera: Pinhole = field(init=False, repr=False)
    _plane: Float[np.ndarray, "3 3"] = field(init=False, repr=False)
    _whole: Int16[np.ndarray, "height width 2"] = field(init=False, repr=False)
    _part: UInt16[np.ndarray, "height width"] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        K = _intrinsic("K", self.K, skew=False)
        target = K if self.target is None else _intrinsic("target", self.target)
        A = _of_rays(self.rotation, self.translation, self.normal, self.distance)
        for name in ("rotation", "translation", "normal"):
            object.__setattr__(self, name, np.array(getattr(self, name), dtype=float))
        object.__setattr__(self, "K", K)
        object.__setattr__(self, "target", target)
        object.__setattr__(self, "homography", np.linalg.solve(target.T, (K @ A).T).T)
        object.__setattr__(self, "_plane", A)
        lens = (*self.distortion, 0.0, 0.0) if any(self.distortion) else ()
        camera = Pinhole((K[0, 0], K[1, 1]), (K[0, 2], K[1, 2]), self.size, lens)
        object.__setattr__(self, "_camera", camera)
        self._look_up()

    def apply(
        self, image: UInt8[np.ndarray, "height width *channels"]
    ) -> UInt8[np.ndarray, "height width *channels"]:
        """Return the picture that the ideal camera would have taken.

        Parameters
        ----------
        image : (height, width) or (height, width, channels)
            Picture of the camera, bytes, of at most 4 channels.

        Returns
        -------
        (height, width) or (height, width, channels)
            The ideal picture, interpolated bilinearly; black where the camera sees nothing.

        Raises
        ------
        ValueError
            If the image does not hold bytes or has another size.
        """
        image = checks.instance("image", image, np.ndarray)
        if image.dtype != np.uint8 or image.ndim not in (2, 3) or image.shape[2:] > (4,):
            raise ValueError(f"image must be bytes, grey or coloured, got {checks.shown(image)}")
        if image.shape[:2] != self.size[::-1] or 0 in image.shape:
            raise ValueError(f"image must be {self.size[::-1]} pixels, got {image.shape}")
        fixed = cv2.remap(np.ascontiguousarray(image), self._whole, self._part, cv2.INTER_LINEAR)
        return fixed.reshape(image.shape)

    def points(self, pixels: Float[np.ndarray, "... n 2"]) -> Float[np.ndarray, "... n 2"]:
        """Return where points of the camera's picture are in the ideal picture.

        Parameters
        ----------
        pixels : (…, n, 2)
            Points of the ceiling in the camera's picture, px.

        Returns
        -------
        (…, n, 2)
            The same points in the ideal picture, px; some may lie beyond its border.

        Raises
        ------
        ValueError
            If a number is not finite, the distortion cannot be undone at a pixel, or a pixel shows
            no point of the ceiling in front of the ideal camera.
        """
        pixels = checks.array("pixels", pixels, (..., "n", 2))
        rays = np.linalg.solve(self._plane, self._camera.rays(pixels)[..., None])[..., 0]
        lost = np.count_nonzero((rays[..., 2] <= 0) | (rays @ self.normal >= 0))
        if lost:
            raise ValueError(
                f"pixels must look at the ceiling, got {lost} of {rays[..., 2].size} that do not"
            )
        # near the horizon a point is far away, and its coordinates may overflow
        with np.errstate(over="ignore"):
            images = rays[..., :2] / rays[..., 2:]
        images = checks.moderate("pixels on the ceiling", images)
        return images @ self.target[:2, :2].T + self.target[:2, 2]  # type: ignore[index]

    def _look_up(self) -> None:
        """Compute where in the picture of the camera each pixel of the ideal picture is."""
        width, height = self.size
        u, v = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
        rays = np.linalg.solve(self.target, np.stack([u.ravel(), v.ravel(), np.ones(u.size)]))
        if (self.normal @ rays[:, :1] >= 0).all() and self.normal[2] >= 0:
            raise ValueError(f"normal must point from the ceiling to the robot, got {self.normal}")
        if (self.normal @ rays >= 0).any():
            raise ValueError("normal must leave the horizon of the ceiling outside the picture")
        x, y, depth = self._plane @ rays
        if (depth <= 0).any():
            raise ValueError(
                "rotation and translation must leave what the corrected picture shows in front of "
                "the camera, got its horizon inside the picture"
            )
        x, y = x / depth, y / depth
        square = x**2 + y**2
        k1, k2 = self.distortion
        limit = _fold(k1, k2)  # farther rays would be folded back into the picture
        within = square < limit
        square = np.where(within, square, 0.0)
        bend = 1 + k1 * square + k2 * square**2
        at = np.stack([x * bend, y * bend]) * np.diag(self.K)[:2, None] + self.K[:2, 2:]
        edge = np.array([[width - 1], [height - 1]])
        seen = within & ((at >= 0) & (at <= edge)).all(axis=0)
        at = np.where(within, np.clip(at, -OUTSIDE, edge + OUTSIDE), -OUTSIDE).astype(np.float32)
        whole, part = cv2.convertMaps(
            at[0].reshape(u.shape), at[1].reshape(u.shape), cv2.CV_16SC2, nninterpolation=False
        )
        object.__setattr__(self, "seen", seen.reshape(u.shape))
        object.__setattr__(self, "_whole", whole)
        object.__setattr__(self, "_part", part)


def _intrinsic(name: str, value: np.ndarray, *, skew: bool = True) -> np.ndarray:
    """Return a matrix of intrinsic parameters, or raise ``ValueError`` if it is none."""
    K = checks.moderate(name, checks.array(name, value, (3, 3)).copy(), 1e9)
    below = K[1, 0], K[2, 0], K[2, 1]
    if any(below) or K[2, 2] != 1 or min(K[0, 0], K[1, 1]) < 1e-9:
        raise ValueError(
            f"{name} must be upper triangular with positive focal lengths and a last entry of 1, "
            f"not singular, got {K.tolist()}"
        )
    if K[0, 1] != 0 and not skew:
        raise ValueError(f"{name} must have no skew, got {K[0, 1]:g}")
    return K


def _of_rays(
    rotation: np.ndarray, translation: np.ndarray, normal: np.ndarray, distance: float
) -> np.ndarray:
    """Return R - t nᵀ/d, which takes rays of the ideal camera to rays of the mounted one."""
    T = np.eye(4)
    T[:3, :3] = checks.moderate("rotation", checks.array("rotation", rotation, (3, 3)), 2.0)
    se3.checked("rotation", T)
    t = checks.vector("translation", translation, 3)
    n = checks.moderate("normal", checks.vector("normal", normal, 3), 2.0)
    if abs(np.linalg.norm(n) - 1) > TOLERANCE:
        raise ValueError(f"normal must be of length 1, got {np.linalg.norm(n):g}")
    d = checks.positive("distance", distance)
    with np.errstate(over="ignore"):
        lift = t / d
    checks.moderate("translation / distance", lift, 1e9)
    A = T[:3, :3] - np.outer(lift, n)
    share = 1 - n @ T[:3, :3].T @ lift  # det A, the camera's distance to the ceiling over d
    if share < 1e-9:
        raise ValueError(
            f"translation must leave the camera below the ceiling, got it {share * d:g} m below"
        )
    return A


def _fold(k1: float, k2: float) -> float:
    r"""Return the r² up to which the distorted radius grows with r.

    That is the smallest positive zero of its derivative, :math:`1 + 3 k_1 r^2 + 5 k_2 r^4`.
    """
    roots = np.roots(np.trim_zeros([5 * k2, 3 * k1, 1.0], "f"))
    real = roots.real[(np.abs(roots.imag) == 0) & (roots.real > 0)]
    return float(real.min(initial=np.inf))

r"""Cameras: the pinhole with distortion, and the rectified stereo rig.

The frame of a camera has z ahead, x to the right and y down; a pixel (u, v) counts columns and
rows, and its centre has whole numbers, as in OpenCV. Distances are in the unit of the points, m.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.extras import needing

with needing():
    import cv2

COEFFICIENTS = (0, 4, 5, 8, 12, 14)
"""Numbers of coefficients of distortion that OpenCV takes; none is no distortion."""


def level_mount(position: Float[np.ndarray, "3"]) -> Float[np.ndarray, "4 4"]:
    """Return the pose ``T_robot_camera`` of a camera that looks straight ahead.

    The robot's frame has x ahead, y to the left and z up.

    Parameters
    ----------
    position : (3,)
        Where the camera sits in the frame of the robot, m.

    Raises
    ------
    ValueError
        If the position is not three finite numbers.
    """
    x, y, z = checks.vector("position", position, 3)
    return np.array([[0.0, 0, 1, x], [-1, 0, 0, y], [0, -1, 0, z], [0, 0, 0, 1]])


@dataclass(frozen=True, slots=True)
class Pinhole:
    r"""A pinhole camera with the distortion of its lens.

    .. math:: u = f_x\, x'' + c_x, \qquad v = f_y\, y'' + c_y

    where :math:`(x'', y'')` is :math:`(x/z,\, y/z)` moved by the distortion.

    Parameters
    ----------
    focal
        Focal lengths :math:`(f_x, f_y)`, px.
    centre
        Principal point :math:`(c_x, c_y)`, px.
    size
        Width and height of the image, px.
    distortion
        OpenCV's coefficients :math:`(k_1, k_2, p_1, p_2[, k_3[, k_4, k_5, k_6[, …]]])`; none for a
        lens without distortion.

    Raises
    ------
    ValueError
        If a focal length or a size is not positive, a number is not finite, or there is another
        number of coefficients than OpenCV knows.
    """

    focal: tuple[float, float]
    centre: tuple[float, float]
    size: tuple[int, int]
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        focal = tuple(checks.vector("focal", self.focal, 2).tolist())
        if min(focal) <= 0:
            raise ValueError(f"focal must be positive, got {focal}")
        size = tuple(checks.integers("size", self.size, (2,), 1).tolist())
        distortion = tuple(checks.array("distortion", self.distortion, ("n",)).tolist())
        if len(distortion) not in COEFFICIENTS:
            raise ValueError(
                f"distortion must be {COEFFICIENTS} coefficients, got {len(distortion)}"
            )
        object.__setattr__(self, "focal", focal)
        object.__setattr__(self, "centre", tuple(checks.vector("centre", self.centre, 2).tolist()))
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "distortion", distortion)

    @property
    def matrix(self) -> Float[np.ndarray, "3 3"]:
        """Calibration matrix K."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    def project(self, points: Float[np.ndarray, "... n 3"]) -> Float[np.ndarray, "... n 2"]:
        """Return the pixels of points, whether or not they lie within the image.

        Parameters
        ----------
        points : (…, n, 3)
            Points in the frame of the camera, all in front of it; `sees` tells which are.

        Returns
        -------
        (…, n, 2)
            u and v, px.

        Raises
        ------
        ValueError
            If a number is not finite or a point is not in front of the camera.
        """
        points = checks.array("points", points, (..., "n", 3))
        behind = np.count_nonzero(points[..., 2] <= 0)
        if behind:
            raise ValueError(
                f"points must be in front of the camera, got {behind} of {points[..., 2].size} "
                "that are not"
            )
        return self._pixels(points[..., :2] / points[..., 2:])

    def sees(self, points: Float[np.ndarray, "... n 3"]) -> Bool[np.ndarray, "... n"]:
        """Tell which points are in front of the camera and within its image.

        Nothing is known of what hides them. Far outside the image the polynomial of a distortion
        may lead back into it; such points are not seen.

        Parameters
        ----------
        points : (…, n, 3)
            Points in the frame of the camera.

        Raises
        ------
        ValueError
            If the last axis is not 3 or a number is not finite.
        """
        points = checks.array("points", points, (..., "n", 3))
        ahead = points[..., 2] > 0
        directions = points[..., :2] / np.where(ahead, points[..., 2], 1.0)[..., None]
        pixels = self._pixels(directions)
        within = ((pixels >= -0.5) & (pixels < np.array(self.size) - 0.5)).all(axis=-1)
        seen = ahead & within
        if self.distortion:
            back = self._directions(pixels[seen])
            seen[seen] = (np.abs(back - directions[seen]) <= 1e-6).all(axis=-1)
        return seen

    def rays(self, pixels: Float[np.ndarray, "... n 2"]) -> Float[np.ndarray, "... n 3"]:
        """Return the directions in which pixels look: the points (x, y, 1) at depth 1.

        Parameters
        ----------
        pixels : (…, n, 2)
            u and v, px.

        Raises
        ------
        ValueError
            If a number is not finite, or the distortion cannot be undone at a pixel.
        """
        pixels = checks.array("pixels", pixels, (..., "n", 2))
        directions = self._directions(pixels)
        if self.distortion:
            far = np.abs(self._pixels(directions) - pixels).max(axis=-1, initial=0.0)
            lost = np.count_nonzero(~(far <= 1e-3))
            if lost:
                raise ValueError(
                    "pixels must be where the distortion can be undone, "
                    f"got {lost} of {far.size} elsewhere"
                )
        return np.concatenate([directions, np.ones((*pixels.shape[:-1], 1))], axis=-1)

    def _pixels(self, directions: np.ndarray) -> np.ndarray:
        """Return the pixels of points (x, y) at depth 1."""
        if not self.distortion or not directions.size:
            return directions * self.focal + self.centre
        points = np.pad(directions.reshape(-1, 1, 2), [(0, 0), (0, 0), (0, 1)], constant_values=1)
        still = np.zeros(3)
        pixels, _ = cv2.projectPoints(points, still, still, self.matrix, np.array(self.distortion))
        return pixels.reshape(directions.shape)

    def _directions(self, pixels: np.ndarray) -> np.ndarray:
        """Return the points (x, y) at depth 1 of pixels."""
        if not self.distortion or not pixels.size:
            return (pixels - self.centre) / self.focal
        stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-12)
        found = cv2.undistortPointsIter(
            pixels.reshape(-1, 1, 2), self.matrix, np.array(self.distortion), None, None, stop
        )
        return found.reshape(pixels.shape)


@dataclass(frozen=True, slots=True)
class StereoRig:
    r"""Two equal cameras side by side that look the same way: a rectified rig.

    .. math:: u_R = u_L - f_x b / z

    Points are in the frame of the left camera, a measurement is :math:`(u_L, v, u_R)`: both
    cameras see a point in one row.

    Parameters
    ----------
    camera
        Each of the two; without distortion, since rectifying has taken it out.
    baseline
        Distance b of the right camera from the left, m.

    Raises
    ------
    ValueError
        If the camera has a distortion or the baseline is not positive.
    """

    camera: Pinhole
    baseline: float

    def __post_init__(self) -> None:
        if checks.instance("camera", self.camera, Pinhole).distortion:
            raise ValueError("camera of a rectified rig must have no distortion")
        object.__setattr__(self, "baseline", checks.positive("baseline", self.baseline))

    def project(self, points: Float[np.ndarray, "... n 3"]) -> Float[np.ndarray, "... n 3"]:
        """Return the measurements of points, whether or not they lie within the images.

        Parameters
        ----------
        points : (…, n, 3)
            Points in the frame of the left camera, all in front of it.

        Returns
        -------
        (…, n, 3)
            :math:`(u_L, v, u_R)`, px.

        Raises
        ------
        ValueError
            If a number is not finite or a point is not in front of the cameras.
        """
        pixels = self.camera.project(points)
        disparity = self.camera.focal[0] * self.baseline / np.asarray(points, float)[..., 2:]
        return np.concatenate([pixels, pixels[..., :1] - disparity], axis=-1)

    def triangulate(
        self,
        measurements: Float[np.ndarray, "... n 3"],
        sigma_px: float | Float[np.ndarray, "..."],
    ) -> Gaussian:
        r"""Return the points that were measured, with what pixel noise makes of their places.

        .. math::
            z = \frac{f_x b}{d}, \quad x = (u_L - c_x) \frac{b}{d}, \quad
            y = (v - c_y) \frac{f_x}{f_y} \frac{b}{d}, \quad d = u_L - u_R, \qquad
            P = J \operatorname{diag}(\sigma^2) J^\top

        The mean is that of the noiseless measurement. As depth goes with 1/d, the mean of noisy
        ones lies farther away, to second order by the share :math:`2\sigma^2 / d^2`: 2 % at a
        disparity of ten standard deviations; and the normal distribution cannot show their skew.

        Parameters
        ----------
        measurements : (…, n, 3)
            :math:`(u_L, v, u_R)`, px.
        sigma_px
            Standard deviations of the three, px: one number, or an array that broadcasts against
            the measurements.

        Returns
        -------
        Gaussian
            Means (…, n, 3), m, and covariances (…, n, 3, 3), m², in the frame of the left camera.

        Raises
        ------
        ValueError
            If a number is not finite, a standard deviation is negative or a disparity not positive.
        """
        measured = checks.array("measurements", measurements, (..., "n", 3))
        sigma = checks.array("sigma_px", sigma_px)
        if (sigma < 0).any():
            raise ValueError(f"sigma_px must not be negative, got {sigma.min()}")
        try:
            sigma = np.broadcast_to(sigma, measured.shape)
        except ValueError:
            raise ValueError(
                f"sigma_px must broadcast against measurements {measured.shape}, got {sigma.shape}"
            ) from None
        u, v, _ = np.moveaxis(measured, -1, 0)
        d = measured[..., 0] - measured[..., 2]
        if (d <= 0).any():
            raise ValueError(
                "measurements must have a positive disparity, "
                f"got {np.count_nonzero(d <= 0)} of {d.size} that have not"
            )
        (fx, fy), (cx, cy), b = self.camera.focal, self.camera.centre, self.baseline
        ray = np.stack([u - cx, (v - cy) * fx / fy, np.full(d.shape, fx)], axis=-1)
        point = ray * (b / d)[..., None]
        J = np.zeros((*point.shape, 3))
        J[..., 2] = point / d[..., None]  # by the right column, which shortens the disparity
        J[..., 0] = -J[..., 2]
        J[..., 0, 0] += b / d
        J[..., 1, 1] = b / d * fx / fy
        scaled = J * sigma[..., None, :]
        return Gaussian(point, scaled @ scaled.mT)

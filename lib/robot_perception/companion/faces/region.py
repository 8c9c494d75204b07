r"""A face followed by a Kalman filter, which says where to look for it.

The state is the middle of the face and its side with their velocities, moved by noise in the
acceleration; time is counted in pictures:

.. math::
    x = [u, v, s, \dot u, \dot v, \dot s]^\top, \qquad
    F = \begin{pmatrix} I & I \\ 0 & I \end{pmatrix}, \qquad
    Q = \begin{pmatrix} \tfrac14 & \tfrac12 \\ \tfrac12 & 1 \end{pmatrix} \otimes
        \operatorname{diag}(a^2, a^2, b^2)

The detector is asked for the window in which the face should be by the estimate and its covariance.
A face that is not detected is where the filter predicts it; the longer it is missed, the wider the
window, until it is the whole picture.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, Protocol, final, runtime_checkable

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.companion.boxes import check_box, check_boxes, grey_picture, within
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.extras import needing
from robot_perception.fields import Level, NotNegative, Positive, checked, from_to
from robot_perception.gating import gate

with needing():
    from filterpy.common import Q_discrete_white_noise
    from filterpy.kalman import predict, update

__all__ = ["Detector", "FaceTracker", "RegionInfo", "RegionRules", "RegionState"]

H = np.hstack([np.eye(3), np.zeros((3, 3))])


@runtime_checkable
class Detector(Protocol):
    """Whatever finds boxes in a picture, or in a window of it."""

    def find(self, image: Any, window: Any = None) -> np.ndarray:  # pragma: no cover - a protocol
        """Return boxes (n, 4)."""


@final
@dataclass(frozen=True, slots=True)
class RegionRules:
    """Noise, and when a face is believed and given up. The paper names no number: all are ours.

    Parameters
    ----------
    acceleration, growth
        Standard deviations a and b of the middle's and the side's acceleration, px a picture².
    place_sigma, side_sigma
        Of a detection's middle and side, as shares of its side.
    sigmas
        Standard deviations that the window reaches beyond the face.
    margin
        By which share of the side the window is wider than the face on each side: what the detector
        needs to see of its surroundings.
    level
        Of the gate: a detection that is less likely than this under the prediction is another's.
    patience
        Pictures without the face after which it is given up.
    """

    acceleration: Positive = 2.0
    growth: Positive = 0.5
    place_sigma: Positive = 0.05
    side_sigma: Positive = 0.08
    sigmas: Positive = 3.0
    margin: NotNegative = 0.3
    level: Level = 0.999
    patience: Annotated[int, from_to(0, 10**6)] = 20
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class RegionState:
    """State of the face tracker: a face, or none.

    Parameters
    ----------
    belief
        Middle, side and their velocities (6,): px, px a picture; ``None`` if no face is followed.
    missed
        For how many pictures it has not been seen.
    """

    belief: Gaussian | None = None
    missed: Annotated[int, from_to(0)] = 0

    def __post_init__(self) -> None:
        checked(self)
        if self.belief is not None:
            checks.vector("belief.mean", self.belief.mean, 6)

    @property
    def box(self) -> Float[np.ndarray, " 4"] | None:
        """The estimated box: left, top, width and height, px; ``None`` if no face is followed."""
        if self.belief is None:
            return None
        u, v, side = self.belief.mean[:3]
        side = max(side, 1.0)
        return np.array([u - side / 2, v - side / 2, side, side])


@final
@dataclass(frozen=True, eq=False, slots=True)
class RegionInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    window : (4,)
        Where the detector looked, px.
    whole
        Whether that was the whole picture.
    boxes : (n, 4)
        What it found.
    taken
        Which of them is the face, ``None`` if none is.
    searched
        Pixels that it looked through.
    """

    window: Float[np.ndarray, " 4"]
    whole: bool
    boxes: Float[np.ndarray, "n 4"]
    taken: int | None
    searched: int


def _followed(state: RegionState) -> Gaussian:
    """Return the belief of a face that is followed."""
    belief = checks.instance("state", state, RegionState).belief
    if belief is None:
        raise ValueError("state must be of a face that is followed, got none")
    return belief


def _largest(boxes: Float[np.ndarray, "n 4"]) -> int | None:
    return int(boxes[:, 2].argmax()) if len(boxes) else None


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceTracker:
    """Finds a face and follows it.

    Parameters
    ----------
    detector
        Of faces, or of whatever has a box: anything with a method ``find(image, window, sides)``.
    rules
        Noise and thresholds.
    choose
        Function of boxes (n, 4) that says which of them to follow, if any, where no face is
        followed; by default the largest.

    References
    ----------
    Section III, "Face tracking"; Menezes, Barreto and Dias, "Face tracking based on Haar-like
    features and eigenfaces", IAV 2004.
    """

    detector: Detector = field(default_factory=FaceDetector)
    rules: RegionRules = field(default_factory=RegionRules)
    choose: Callable[[np.ndarray], int | None] = _largest
    __post_init__ = checked

    def start(self, box: Float[np.ndarray, " 4"] | None = None) -> RegionState:
        """Return what is known of a face after a first detection: it may move either way.

        Without a box no face is followed yet.
        """
        if box is None:
            return RegionState()
        box = check_box("box", box)
        measured, noise = self._measured(box)
        spread = np.diag([4 * self.rules.acceleration**2] * 2 + [4 * self.rules.growth**2])
        cov = np.block([[noise, np.zeros((3, 3))], [np.zeros((3, 3)), spread]])
        return RegionState(Gaussian(np.concatenate([measured, np.zeros(3)]), cov))

    def predict(self, state: RegionState) -> RegionState:
        """Return what is expected of the next picture, before it is looked at."""
        rules, belief = self.rules, _followed(state)
        F = np.kron(np.array([[1, 1], [0, 1]]), np.eye(3))
        scales = np.diag([rules.acceleration**2, rules.acceleration**2, rules.growth**2])
        Q = np.kron(Q_discrete_white_noise(2, 1.0, 1.0), scales)
        mean, cov = predict(belief.mean, belief.cov, F, Q)
        return RegionState(Gaussian(mean, (cov + cov.T) / 2), state.missed)

    def window(self, state: RegionState) -> Float[np.ndarray, " 4"]:
        """Return the window in which a predicted face is looked for.

        It reaches beyond the estimated face by ``sigmas`` standard deviations of its middle and
        half its side together, and by the margin.
        """
        rules, belief = self.rules, _followed(state)
        u, v, side = belief.mean[:3]
        side = max(side, 1.0)
        spread = np.sqrt(np.diag(belief.cov)[:2] + belief.cov[2, 2] / 4)
        reach = side * (0.5 + rules.margin) + rules.sigmas * spread
        return np.array([u - reach[0], v - reach[1], *(2 * reach)])

    def sides(self, state: RegionState) -> tuple[float, float]:
        """Return the smallest and the largest side that a predicted face may have.

        They are ``sigmas`` standard deviations off the estimate, and by the margin more, as a
        detection is not exact.
        """
        rules, belief = self.rules, _followed(state)
        side, spread = max(belief.mean[2], 1.0), float(np.sqrt(belief.cov[2, 2]))
        reach = rules.sigmas * spread
        low = max(side - reach, 1.0) / (1 + rules.margin)
        return low, (side + reach) * (1 + rules.margin)

    def step(
        self,
        state: RegionState,
        image: UInt8[np.ndarray, "height width"],
    ) -> tuple[RegionState, RegionInfo]:
        """Return what is known after a picture.

        Where no face is followed the whole picture is searched for one; a face that is missed for
        too long is given up.

        Parameters
        ----------
        state
            Before it.
        image : (height, width)
            Grey values.

        Raises
        ------
        TypeError, ValueError
            As the detector; also if the choice is of no box.
        """
        checks.instance("state", state, RegionState)
        height, width = grey_picture("image", image).shape
        everything = np.array([0.0, 0.0, width, height])
        if state.belief is None:
            boxes = check_boxes("boxes", self.detector.find(image))
            taken = self.choose(boxes)
            if taken is not None:
                taken = checks.whole("choose(boxes)", taken, 0, len(boxes) - 1)
            info = RegionInfo(everything, True, boxes, taken, width * height)
            return self.start(None if taken is None else boxes[taken]), info
        expected = self.predict(state)
        window = self.window(expected)
        searched = within(image, window)[0].size
        whole = searched >= width * height
        look = everything if whole else window
        sides = None if whole else self.sides(expected)
        found = self.detector.find(image, None if whole else window, sides)
        boxes = check_boxes("boxes", found)
        taken = self._nearest(expected, boxes)
        info = RegionInfo(look, whole, boxes, taken, searched)
        if taken is not None:
            measured, noise = self._measured(boxes[taken])
            mean, cov = update(expected.belief.mean, expected.belief.cov, measured, noise, H)
            return RegionState(Gaussian(mean, (cov + cov.T) / 2)), info
        if state.missed >= self.rules.patience or searched == 0:
            return self.start(), info
        return RegionState(expected.belief, state.missed + 1), info

    def _measured(self, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return middle and side of a detection, and their covariance."""
        left, top, side, high = box
        rules = self.rules
        noise = side * np.array([rules.place_sigma, rules.place_sigma, rules.side_sigma])
        return np.array([left + side / 2, top + high / 2, side]), np.diag(noise**2)

    def _nearest(self, expected: RegionState, boxes: np.ndarray) -> int | None:
        """Return the detection that is nearest to the prediction, by Mahalanobis distance."""
        if not len(boxes):
            return None
        distances = []
        for box in boxes:
            measured, noise = self._measured(box)
            innovation = measured - expected.belief.mean[:3]
            S = expected.belief.cov[:3, :3] + noise
            distances.append(innovation @ np.linalg.solve(S, innovation))
        best = int(np.argmin(distances))
        return best if distances[best] <= gate(self.rules.level, 3) else None

"""Trackers by colour alone, or by edges alone: what `colour_shape` joins, each by itself.

Two share its rules: the tracker by colour its segmentation, the one by edges its affine snake. By
colour there is no snake, the outline is that of the piece; and all its pixels but those at the rim
are counted. The third is the everyday one by colour: a window that OpenCV's mean shift moves.
"""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.appearance._masks import Outline, check_outline
from robot_perception.appearance.affine_snake import affine_snake, image_edges, resample
from robot_perception.appearance.colour_histograms import adapt, histogram, shares
from robot_perception.appearance.colour_shape import SMALLEST, ColourShapeRules, inner, sound
from robot_perception.appearance.colour_spaces import Binning, picture
from robot_perception.appearance.segmentation import blob, clean, dilate, filled, segment
from robot_perception.extras import needing
from robot_perception.fields import Share, checked, from_to

with needing():
    import cv2

__all__ = ["ColourTracker", "CueInfo", "CueState", "EdgeTracker", "WindowTracker"]

Image = UInt8[np.ndarray, "height width 3"]
FURTHEST = 200
"""Greatest reach of the snake that follows edges, px."""


@dataclass(frozen=True, eq=False, slots=True)
class CueState:
    """State of a tracker by one cue after a frame; its ``start`` makes the first.

    Parameters
    ----------
    outline : (points, 2)
        Of the object, px.
    counts : (bins,)
        Histogram of its colours; empty where edges alone are followed.
    lost
        For how many frames in a row nothing has been found.
    shape
        Height and width of the images.
    window
        Of a `WindowTracker`: first column and row, width and height, px.
    """

    outline: Outline
    counts: Float[np.ndarray, " bins"]
    lost: Annotated[int, from_to(0)]
    shape: tuple[int, int]
    window: tuple[int, int, int, int] = (0, 0, 0, 0)
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class CueInfo:
    """Diagnostics of one step of a tracker by one cue.

    Parameters
    ----------
    found
        Whether the frame shows what is followed; if not, the outline is that of the frame before.
    """

    found: bool


@dataclass(frozen=True, eq=False, slots=True)
class ColourTracker:
    """Follows the piece of a frame that has the colours of the first outline.

    Parameters
    ----------
    rules
        Histogram, segmentation, points.
    adapt
        Whether the colours of the piece that was found replace those before, whatever it is.
    """

    rules: ColourShapeRules = field(default_factory=ColourShapeRules)
    adapt: bool = False
    __post_init__ = checked

    def start(self, image: Image, outline: Outline) -> CueState:
        """Return the state of an object whose outline is known.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        outline : (n, 2)
            Closed, points (u, v), px.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it has another shape, or the outline lies on a line or has no pixel in it.
        """
        image = picture("image", image)
        outline = resample(check_outline("outline", outline), self.rules.points)
        inside = filled(outline, image.shape[:2])
        if not inside.any():
            raise ValueError(f"outline must hold pixels of the image {image.shape[:2]}")
        return CueState(outline, self._counts(image, inside), 0, image.shape[:2])

    def step(self, state: CueState, image: Image) -> tuple[CueState, CueInfo]:
        """Return the state after a frame; where no piece is found the outline stays.

        Parameters
        ----------
        state
            Before the frame.
        image : (height, width, 3)
            Red, green, blue, of the size of the first.

        Raises
        ------
        TypeError
            If an argument is of another type, or the image does not hold bytes.
        ValueError
            If the image has another shape, or the histogram other bins.
        """
        rules = self.rules
        image = _frame(state, image, rules.binning)
        mask = clean(
            segment(rules.binning.index(image), state.counts), rules.opening, rules.closing
        )
        found = blob(mask, state.outline)
        if found is None or found.area < SMALLEST:
            return _missed(state)
        lines, _ = cv2.findContours(
            found.mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
        )
        outline = max(lines, key=len)[:, 0].astype(float)
        if not sound(outline):
            return _missed(state)
        counts = self._counts(image, found.mask) if self.adapt else state.counts
        state = CueState(resample(outline, rules.points), counts, 0, state.shape)
        return state, CueInfo(True)

    def _counts(self, image: Image, inside: np.ndarray) -> np.ndarray:
        binning, inside = self.rules.binning, inner(inside, self.rules.inset)
        return np.bincount(binning.of(image[inside]), minlength=binning.count).astype(float)


@dataclass(frozen=True, eq=False, slots=True)
class EdgeTracker:
    """Slides an affine snake along the edges of the image, of whatever they are.

    Parameters
    ----------
    rules
        Snake, points, strength of edges.

    Raises
    ------
    ValueError
        If the snake's reach is more than 200 px.
    """

    rules: ColourShapeRules = field(default_factory=ColourShapeRules)

    def __post_init__(self) -> None:
        checked(self)
        if self.rules.snake.reach[0] > FURTHEST:
            raise ValueError(
                f"reach must be at most {FURTHEST} px, got {self.rules.snake.reach[0]:g}"
            )

    def start(self, image: Image, outline: Outline) -> CueState:
        """Return the state of an object whose outline is known.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        outline : (n, 2)
            Closed, points (u, v), px.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it has another shape, or the outline lies on a line or has no pixel in it.
        """
        image = picture("image", image)
        outline = resample(check_outline("outline", outline), self.rules.points)
        if not filled(outline, image.shape[:2]).any():
            raise ValueError(f"outline must hold pixels of the image {image.shape[:2]}")
        return CueState(outline, np.zeros(0), 0, image.shape[:2])

    def step(self, state: CueState, image: Image) -> tuple[CueState, CueInfo]:
        """Return the state after a frame; where there is no edge the outline stays.

        Edges count within the snake's reach of the outline before: no colour tells which are the
        object's.

        Parameters
        ----------
        state
            Before the frame.
        image : (height, width, 3)
            Red, green, blue, of the size of the first.

        Raises
        ------
        TypeError
            If an argument is of another type, or the image does not hold bytes.
        ValueError
            If the image has another shape.
        """
        image, rules = _frame(state, image), self.rules
        inside = filled(state.outline, state.shape)
        reach = round(rules.snake.reach[0])
        near = dilate(inside, reach) & dilate(~inside, reach)
        ridges = image_edges(image, near, rules.strength)
        if ridges.any():
            outline = affine_snake(state.outline, ridges, rules.snake).outline
            middle = outline.mean(axis=0)
            if sound(outline) and ((middle >= 0) & (middle < state.shape[::-1])).all():
                return CueState(outline, state.counts, 0, state.shape), CueInfo(True)
        return _missed(state)


STOP = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1
"""Stopping rule of mean shift: ten steps, or one of less than a pixel, as in OpenCV's tutorial."""
MOST = 4.0
"""Times its share of the surroundings at which a colour counts fully."""
RING = np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 2 * np.pi, 40, endpoint=False)])


@dataclass(frozen=True, eq=False, slots=True)
class WindowTracker:
    """Moves a window to where the colours of the first outline are densest, by OpenCV.

    Parameters
    ----------
    binning
        The cells of the histogram.
    rigid
        Whether window and outline keep size and form, by mean shift; if not, CamShift fits them to
        what it finds.
    rate
        a of eq. (29): how fast the colours within the outline replace the model, unchecked.
    contrast
        Whether a colour counts by how much more of it the model has than what lies around, instead
        of by its share of the model.

    References
    ----------
    Comaniciu, Ramesh and Meer, "Kernel-based object tracking", PAMI 25(5), 2003, whose window has a
    kernel; Bradski, "Real time face and object tracking as a component of a perceptual user
    interface", 1998.
    """

    binning: Binning = field(default_factory=Binning)
    rigid: bool = False
    rate: Share = 0.0
    contrast: bool = False
    __post_init__ = checked

    def start(self, image: Image, outline: Outline) -> CueState:
        """Return the state of an object whose outline is known.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        outline : (n, 2)
            Closed, points (u, v), px.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it has another shape, or the outline lies on a line or has no pixel in it.
        """
        image, outline = picture("image", image), check_outline("outline", outline)
        inside = filled(outline, image.shape[:2])
        if not inside.any():
            raise ValueError(f"outline must hold pixels of the image {image.shape[:2]}")
        counts = histogram(self.binning.index(image), self.binning.count, inside)
        window = cv2.boundingRect(np.round(outline).astype(np.int32))
        return CueState(outline, shares(counts), 0, image.shape[:2], tuple(window))

    def step(self, state: CueState, image: Image) -> tuple[CueState, CueInfo]:
        """Return the state after a frame; where the window finds nothing it stays.

        Parameters
        ----------
        state
            Before the frame.
        image : (height, width, 3)
            Red, green, blue, of the size of the first.

        Raises
        ------
        TypeError
            If an argument is of another type, or the image does not hold bytes.
        ValueError
            If the image has another shape, the histogram other bins, or the state no window.
        """
        index = self.binning.index(_frame(state, image, self.binning))
        counts, (u, v, width, height) = shares(state.counts), state.window
        if min(width, height) < 1:
            raise ValueError(f"state must have a window, as start gives it, got {state.window}")
        weights = counts / counts.max()
        if self.contrast:
            part = index[max(v - height // 2, 0) : v + height + height // 2]
            part = part[:, max(u - width // 2, 0) : u + width + width // 2]
            around = np.bincount(part.ravel(), minlength=counts.size) / max(part.size, 1)
            weights = np.minimum(counts / np.maximum(around, 1e-9), MOST) / MOST
        likely = (255 * weights)[index].astype(np.uint8)
        if self.rigid:
            _, (column, row, *_) = cv2.meanShift(likely, state.window, STOP)
            window = column, row, width, height
            outline = np.add(state.outline, (column - u, row - v))
            lost = not likely[max(row, 0) : row + height, max(column, 0) : column + width].any()
        else:
            (centre, axes, angle), window = cv2.CamShift(likely, state.window, STOP)
            turn = np.deg2rad(angle)
            along = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            outline = RING * np.divide(axes, 2) @ along + centre
            lost = min(axes) < 2 or min(window[2:]) < 1
        if lost:
            return _missed(state)
        inside = filled(outline, state.shape)
        if self.rate and inside.any():
            counts = adapt(counts, shares(histogram(index, counts.size, inside)), self.rate)
        return CueState(outline, counts, 0, state.shape, tuple(window)), CueInfo(True)


def _missed(state: CueState) -> tuple[CueState, CueInfo]:
    return replace(state, lost=state.lost + 1), CueInfo(False)


def _frame(state: CueState, image: Image, binning: Binning | None = None) -> Image:
    """Return an image that fits a state, which has the bins of a histogram if there is one."""
    checks.instance("state", state, CueState)
    image = picture("image", image)
    if image.shape[:2] != state.shape:
        raise ValueError(f"image must be {state.shape} as the first, got {image.shape[:2]}")
    if binning is not None and state.counts.size != binning.count:
        raise ValueError(f"state must have {binning.count} counts, got {state.counts.size}")
    return image

"""Trackers by colour alone, or by edges alone: what `colour_shape` joins, each by itself.

They share its rules: the tracker by colour its segmentation, the one by edges its affine snake. By
colour there is no snake, the outline is that of the piece; and all its pixels but those at the rim
are counted.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.appearance._masks import Outline, check_outline
from robot_perception.appearance.affine_snake import affine_snake, image_edges, resample
from robot_perception.appearance.colour_shape import SMALLEST, ColourShapeRules, inner, sound
from robot_perception.appearance.colour_spaces import picture
from robot_perception.appearance.segmentation import blob, clean, dilate, filled, segment

__all__ = ["ColourTracker", "CueState", "EdgeTracker"]

Image = UInt8[np.ndarray, "height width 3"]
FURTHEST = 200
"""Greatest reach of the snake that follows edges, px."""


@dataclass(frozen=True, eq=False, slots=True)
class CueState:
    """What a tracker of one cue knows after a frame; its ``start`` makes the first.

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
    """

    outline: Outline
    counts: Float[np.ndarray, " bins"]
    lost: int
    shape: tuple[int, int]


@dataclass(frozen=True, eq=False, slots=True)
class ColourTracker:
    """Follows the piece of a frame that has the colours of the first outline.

    Parameters
    ----------
    rules
        Histogram, segmentation, points.
    adapt
        Whether the colours of the piece that was found replace those before, whatever it is.

    Raises
    ------
    TypeError
        If an argument is of another type.
    """

    rules: ColourShapeRules = field(default_factory=ColourShapeRules)
    adapt: bool = False

    def __post_init__(self) -> None:
        checks.instance("rules", self.rules, ColourShapeRules)
        object.__setattr__(self, "adapt", checks.flag("adapt", self.adapt))

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

    def step(self, state: CueState, image: Image) -> CueState:
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
        image, rules = _frame(state, image), self.rules
        if state.counts.size != rules.binning.count:
            raise ValueError(
                f"state must have {rules.binning.count} counts, got {state.counts.size}"
            )
        mask = clean(
            segment(rules.binning.index(image), state.counts), rules.opening, rules.closing
        )
        found = blob(mask, state.outline)
        if found is None or found.area < SMALLEST:
            return CueState(state.outline, state.counts, state.lost + 1, state.shape)
        lines, _ = cv2.findContours(
            found.mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
        )
        outline = max(lines, key=len)[:, 0].astype(float)
        if not sound(outline):
            return CueState(state.outline, state.counts, state.lost + 1, state.shape)
        counts = self._counts(image, found.mask) if self.adapt else state.counts
        return CueState(resample(outline, rules.points), counts, 0, state.shape)

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
    TypeError
        If the rules are of another type.
    ValueError
        If the snake's reach is more than 200 px.
    """

    rules: ColourShapeRules = field(default_factory=ColourShapeRules)

    def __post_init__(self) -> None:
        checks.instance("rules", self.rules, ColourShapeRules)
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

    def step(self, state: CueState, image: Image) -> CueState:
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
                return CueState(outline, state.counts, 0, state.shape)
        return CueState(state.outline, state.counts, state.lost + 1, state.shape)


def _frame(state: CueState, image: Image) -> Image:
    """Return an image that fits a state."""
    checks.instance("state", state, CueState)
    image = picture("image", image)
    if image.shape[:2] != state.shape:
        raise ValueError(f"image must be {state.shape} as the first, got {image.shape[:2]}")
    return image

r"""A head followed by its colours: an upright ellipse, searched where it was before.

Every ellipse around the predicted place is scored by how much its colours have in common with the
model. Adjacent ellipses share most of their pixels: the histogram of the next follows from that of
the last when the few pixels that leave it are subtracted and those that enter it are added.

Birchfield's tracker also follows the gradients along the outline; that part is left out, as the
paper's section 3.2 speaks of colour alone. Equation numbers are those of Andrade-Cetto, "Perception
Issues in Mobile Robotics", section 3.2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Bool, Float, Int, Int64, UInt8

from robot_perception import checks
from robot_perception.appearance.colour_histograms import adapt, shares
from robot_perception.appearance.colour_spaces import Binning, picture
from robot_perception.fields import Share, checked, from_to, one_of, wholes
from robot_perception.kernels import kernel

__all__ = [
    "Ellipse",
    "HeadInfo",
    "HeadRules",
    "HeadState",
    "HeadTracker",
    "candidate_scores",
]

UNIT = 2**16
"""Scores count pixels in this part of one: whole numbers, whose sums do not depend on the order."""

WIDEST = 200
"""The largest half width of an ellipse, px."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    r"""An upright ellipse of pixels.

    .. math:: \left(\frac{u - u_0}{w}\right)^2 + \left(\frac{v - v_0}{1.2\,w}\right)^2 \le 1

    Parameters
    ----------
    u, v
        Column and row of its centre, px.
    half_width
        w, px, up to 200.

    References
    ----------
    Birchfield, "Elliptical head tracking using intensity gradients and color histograms", CVPR
    1998: a vertical ellipse with the fixed aspect ratio of 1.2.
    """

    u: Annotated[int, from_to(-(10**6), 10**6)]
    v: Annotated[int, from_to(-(10**6), 10**6)]
    half_width: Annotated[int, from_to(1, WIDEST)]
    __post_init__ = checked

    @property
    def half_height(self) -> float:
        """Half the ellipse's height, px."""
        return 1.2 * self.half_width

    @property
    def pixels(self) -> int:
        """Number of its pixels, those outside an image included."""
        return _pixels(self.half_width)

    def mask(self, size: tuple[int, int]) -> Bool[np.ndarray, "height width"]:
        """Return which pixels of an image lie in the ellipse.

        Parameters
        ----------
        size
            Width and height of the image, px.

        Raises
        ------
        ValueError
            If the size is not two whole numbers from 1.
        """
        width, height = checks.integers("size", size, (2,), 1).tolist()
        dv, du = np.ogrid[-self.v : height - self.v, -self.u : width - self.u]
        return 36 * du**2 + 25 * dv**2 <= 36 * self.half_width**2


@dataclass(frozen=True, slots=True)
class HeadRules:
    r"""Rules of the search for the head, of the adaptation of its model, and of its loss.

    Parameters
    ----------
    radius
        Columns and rows to each side of the predicted place that are searched, px; Birchfield's 8.
    growth
        By how much the half width may change from image to image, px; Birchfield's 1.
    measure
        ``"printed"``: eq. (28), numbers of pixels. ``"shares"``: `intersection_of_shares`, where
        another sensor gives the size; searched by shares it grows or shrinks without limit.
    size
        Which candidate is the best where sizes differ. ``"score"``: that of the highest score
        :math:`\phi`, as printed. ``"excess"``: that with most
        :math:`(\phi - \text{floor}) \cdot \text{pixels}`, our choice: as printed, a small ellipse
        inside the head scores as high as the head.
    rate
        a of eq. (29); our choice.
    gate
        The score from which the model is adapted; our choice.
    floor
        The score that counts for nothing where the size is searched by ``"excess"``; our choice.
    gives_up
        The score below which the head counts as lost: 0 for never, as in the paper; the rule is
        ours.
    again
        The score from which a lost head counts as found; our choice.
    widest
        The radius doubles with every image in which the head is lost, up to this; our choice.
    least, most
        Half widths between which the size is searched, px; our choice.

    Raises
    ------
    ValueError
        If ``widest`` is below the radius, or ``most`` below ``least``.
    """

    radius: Annotated[int, from_to(0, 512)] = 8
    growth: Annotated[int, from_to(0, 32)] = 1
    measure: Annotated[str, one_of("printed", "shares")] = "printed"
    size: Annotated[str, one_of("excess", "score")] = "excess"
    rate: Share = 0.02
    gate: Share = 0.6
    floor: Share = 0.45
    gives_up: Share = 0.0
    again: Share = 0.6
    widest: Annotated[int, from_to(0, 512)] = 64
    least: Annotated[int, from_to(1, WIDEST)] = 5
    most: Annotated[int, from_to(1, WIDEST)] = 100

    def __post_init__(self) -> None:
        checked(self)
        checks.whole("widest", self.widest, self.radius, 512)
        checks.whole("most", self.most, self.least, WIDEST)


def _histogram(name: str, model: Float[np.ndarray, " bins"]) -> Float[np.ndarray, " bins"]:
    """Return a histogram that is not empty."""
    model = checks.array(name, model, ("bins",))
    if not (model >= 0).all():
        raise ValueError(f"{name} must not be negative, got {model.min():g}")
    if not model.any():
        raise ValueError(f"{name} must hold a pixel, got an empty histogram")
    return model


def _velocity(name: str, value: tuple[int, int]) -> tuple[int, int]:
    """Return by how much a head may move from image to image, px."""
    velocity = checks.integers(name, value, (2,))
    if np.abs(velocity).max() > 10**6:
        raise ValueError(f"{name} must be of pixels in an image, got {tuple(velocity)}")
    u, v = velocity.tolist()
    return u, v


@dataclass(frozen=True, eq=False, slots=True)
class HeadState:
    """State of the head tracker after an image.

    Parameters
    ----------
    ellipse
        Where it is, or was when it was last seen.
    model : (bins,)
        Its colours: shares, or numbers of pixels for the printed measure.
    velocity
        By how much it moved last, columns and rows, px; nothing once it is lost.
    lost
        For how many images in a row it has not been seen.
    size
        Width and height of the images; those of the first image if not given.

    Raises
    ------
    ValueError
        If the model is negative somewhere or empty.
    """

    ellipse: Ellipse
    model: Annotated[Float[np.ndarray, " bins"], _histogram]
    velocity: Annotated[tuple[int, int], _velocity] = (0, 0)
    lost: Annotated[int, from_to(0)] = 0
    size: Annotated[tuple[int, int], wholes(2, 1)] | None = None
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class HeadInfo:
    """Diagnostics of one step of the search.

    Parameters
    ----------
    score
        Of the best candidate, from 0 to 1.
    best
        It; where the head is lost it is not believed.
    lost
        Whether it is given up: the score is below ``gives_up``, or where it was lost before below
        ``again``.
    adapted
        Whether the model was adapted.
    candidates : (sizes, rows, columns)
        All scores.
    centre
        Column and row of the middle candidate: the predicted place, px.
    half_widths : (sizes,)
        Of the candidates, px.
    """

    score: float
    best: Ellipse
    lost: bool
    adapted: bool
    candidates: Float[np.ndarray, "sizes rows columns"]
    centre: tuple[int, int]
    half_widths: tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class HeadTracker:
    r"""Follows a head by its colours.

    Parameters
    ----------
    binning
        The cells of the histograms.
    rules
        Search, adaptation and loss.

    References
    ----------
    Section 3.2 with eqs (28), (29); Birchfield 1998 (see `Ellipse`).
    """

    binning: Binning = field(default_factory=Binning)
    rules: HeadRules = field(default_factory=HeadRules)
    __post_init__ = checked

    def colours(
        self, image: UInt8[np.ndarray, "height width 3"], ellipse: Ellipse
    ) -> Float[np.ndarray, " bins"]:
        """Return the histogram of an ellipse, in the unit of the measure.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        ellipse
            Pixels of it that lie outside the image are left out.

        Raises
        ------
        TypeError
            If the image does not hold bytes or the ellipse is none.
        ValueError
            If no pixel of the ellipse lies in the image.
        """
        image = picture("image", image)
        inside = checks.instance("ellipse", ellipse, Ellipse).mask(image.shape[1::-1])
        if not inside.any():
            raise ValueError(f"ellipse must reach into the image, got {ellipse}")
        numbers = self.binning.of(image[inside])
        counts = np.bincount(numbers, minlength=self.binning.count).astype(float)
        return shares(counts) if self.rules.measure == "shares" else counts

    def start(self, image: UInt8[np.ndarray, "height width 3"], ellipse: Ellipse) -> HeadState:
        """Return the state after the first image, in which the head is told: it has its colours.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        ellipse
            The head.

        Raises
        ------
        TypeError, ValueError
            As `colours`.
        """
        return HeadState(ellipse, self.colours(image, ellipse), size=image.shape[1::-1])

    def step(
        self,
        state: HeadState,
        image: UInt8[np.ndarray, "height width 3"],
        *,
        half_width: float | None = None,
    ) -> tuple[HeadState, HeadInfo]:
        r"""Return the state after an image: the best of all candidates, or the head reported lost.

        The search is centred where the head would be if it went on as it moved last. Of candidates
        that are equally good the one nearest to the middle is taken. Pixels outside the image match
        nothing. A lost head stays where it was last seen, its model as it is.

        Parameters
        ----------
        state
            Before the image.
        image : (height, width, 3)
            Red, green, blue.
        half_width
            Of the head, where the distance is known from another sensor, px; it is rounded. If not
            given, the size is searched.

        Raises
        ------
        TypeError
            If the image does not hold bytes, or an argument is of another type.
        ValueError
            If the image is not of the size of those before, the model is of other bins, or the half
            width is not from 1 to 200.
        """
        image = picture("image", image)
        rules, size = self.rules, image.shape[1::-1]
        if checks.instance("state", state, HeadState).size not in (None, size):
            raise ValueError(f"image must be {state.size} px as those before, got {size}")
        checks.shaped("state.model", state.model, (self.binning.count,), beside="this binning")
        widths = self._half_widths(state, half_width)
        radius = min(rules.radius * 2 ** min(state.lost, 9), rules.widest)
        centre = _clipped(np.add([state.ellipse.u, state.ellipse.v], state.velocity), size)
        window, corner = _window(image, centre, radius + math.ceil(1.2 * widths[-1]) + 1)
        index = self.binning.index(window)
        by_share = rules.measure == "shares"
        local = (centre[0] - corner[0], centre[1] - corner[1])
        scores = _scores(index, local, radius, widths, state.model, by_share, _slide)
        merit = scores
        if rules.size == "excess":
            pixels = np.array([_pixels(width) for width in widths])
            merit = (scores - rules.floor) * pixels[:, None, None]
        k, row, column = _best(merit, widths, state.ellipse.half_width)
        best = Ellipse(centre[0] + column - radius, centre[1] + row - radius, widths[k])
        score = float(scores[k, row, column])
        lost = score < (rules.again if state.lost else rules.gives_up)
        adapted = not lost and rules.rate > 0 and score >= rules.gate
        info = HeadInfo(score, best, lost, adapted, scores, centre, tuple(widths))
        if lost:
            return replace(state, velocity=(0, 0), lost=state.lost + 1, size=size), info
        model = state.model
        if adapted:
            model = adapt(model, self.colours(image, best), rules.rate)
        moved = (best.u - state.ellipse.u, best.v - state.ellipse.v)
        velocity = (0, 0) if state.lost else moved
        return HeadState(best, model, velocity, 0, size), info

    def _half_widths(self, state: HeadState, half_width: float | None) -> list[int]:
        """Return the sizes that are tried."""
        if half_width is not None:
            rounded = round(checks.number("half_width", half_width))
            return [checks.whole("half_width", rounded, 1, WIDEST)]
        rules, before = self.rules, state.ellipse.half_width
        sizes = range(before - rules.growth, before + rules.growth + 1)
        return [size for size in sizes if rules.least <= size <= rules.most] or [
            min(max(before, rules.least), rules.most)
        ]


def candidate_scores(
    index: Int[np.ndarray, "height width"],
    centre: tuple[int, int],
    model: Float[np.ndarray, " bins"],
    *,
    half_widths: Sequence[int],
    radius: int = 8,
    measure: str = "shares",
    incremental: bool = True,
) -> Float[np.ndarray, "sizes rows columns"]:
    """Return the scores of all ellipses around a place.

    Numbers of pixels are compared in parts of 1/65536 of one, so that the scores of both ways to
    count are exactly the same.

    Parameters
    ----------
    index : (height, width)
        The bin of each pixel; pixels outside match nothing.
    centre
        Column and row of the middle candidate, within the image.
    model : (bins,)
        Shares, or numbers of pixels for the printed measure.
    half_widths : (sizes,)
        Of the candidates, px.
    radius
        Columns and rows searched to each side, px.
    measure
        ``"printed"`` or ``"shares"``; see `HeadRules`.
    incremental
        Whether each histogram follows from that of the adjacent ellipse, or is counted anew.

    Raises
    ------
    TypeError
        If the bins are no whole numbers.
    ValueError
        If a bin is not of the model, the centre lies outside the image, or a number is out of its
        range.
    """
    if not isinstance(index, np.ndarray) or index.dtype.kind not in "iu":
        raise TypeError(f"index must be an array of integers, got {checks.shown(index)}")
    checks.shaped("index", index, ("height", "width"))
    model = _histogram("model", model)
    if index.size and not (index.min() >= 0 and index.max() < len(model)):
        raise ValueError(f"index must be of {len(model)} bins, got {index.min()} to {index.max()}")
    centre = tuple(checks.integers("centre", centre, (2,)).tolist())
    if not (0 <= centre[0] < index.shape[1] and 0 <= centre[1] < index.shape[0]):
        raise ValueError(f"centre must lie in {index.shape[::-1]} px, got {centre}")
    widths = checks.integers("half_widths", half_widths, ("sizes",), 1).tolist()
    if not widths or max(widths) > WIDEST:
        raise ValueError(f"half_widths must be from 1 to {WIDEST}, got {checks.shown(widths)}")
    radius = checks.whole("radius", radius, 0, 512)
    by_share = checks.one_of("measure", measure, ("printed", "shares")) == "shares"
    count = _slide if checks.flag("incremental", incremental) else _count_each
    return _scores(index, centre, radius, widths, model, by_share, count)


def _scores(index, centre, radius, widths, model, by_share, count) -> np.ndarray:
    """Return the scores of all candidates; outside the image are pixels that match nothing."""
    bins = len(model)
    reach = radius + math.ceil(1.2 * max(widths)) + 1
    u, v = centre
    window = index[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
    padded = np.full((2 * reach + 1, 2 * reach + 1), bins, dtype=np.int32)
    above, left = max(reach - v, 0), max(reach - u, 0)
    padded[above : above + window.shape[0], left : left + window.shape[1]] = window
    side = 2 * radius + 1
    scores = np.empty((len(widths), side, side))
    common = np.empty((side, side), dtype=np.int64)
    most = np.zeros(bins + 1, dtype=np.int64)  # nothing outside the image
    for k, half_width in enumerate(widths):
        across, down = _reaches(half_width)
        pixels = _pixels(half_width)
        scale = UNIT * pixels if by_share else UNIT
        most[:bins] = np.rint(np.minimum(scale * model, UNIT * pixels))
        count(padded, reach - radius, reach - radius, across, down, most, common)
        scores[k] = common / (UNIT * pixels)
    return scores


def _reaches(half_width: int) -> tuple[Int64[np.ndarray, " rows"], Int64[np.ndarray, " columns"]]:
    """Return how far an ellipse reaches sideways in each row, and up and down in each column."""
    half_height = 6 * half_width // 5
    dv, du = np.arange(-half_height, half_height + 1), np.arange(-half_width, half_width + 1)
    inside = 36 * du**2 + 25 * dv[:, None] ** 2 <= 36 * half_width**2
    return inside.sum(axis=1) // 2, inside.sum(axis=0) // 2


def _pixels(half_width: int) -> int:
    """Return how many pixels an ellipse has."""
    return int((2 * _reaches(half_width)[0] + 1).sum())


def _clipped(place: np.ndarray, size: tuple[int, int]) -> tuple[int, int]:
    """Return the pixel of an image that is nearest to a place."""
    u, v = np.clip(place, 0, np.subtract(size, 1)).tolist()
    return u, v


def _window(
    image: np.ndarray, centre: tuple[int, int], reach: int
) -> tuple[np.ndarray, tuple[int, int]]:
    """Return the part of an image around a pixel, and its first column and row."""
    left, top = max(centre[0] - reach, 0), max(centre[1] - reach, 0)
    return image[top : centre[1] + reach + 1, left : centre[0] + reach + 1], (left, top)


def _best(merit: np.ndarray, widths: list[int], before: int) -> tuple[int, int, int]:
    """Return which candidate is the best, the one nearest to the middle if several are."""
    ties = np.argwhere(merit == merit.max())
    radius = merit.shape[1] // 2
    away = ((ties[:, 1:] - radius) ** 2).sum(axis=1) + (np.array(widths)[ties[:, 0]] - before) ** 2
    k, row, column = ties[int(np.argmin(away))].tolist()
    return k, row, column


@no_type_check
@kernel()
def _count_each(index, left, top, across, down, most, common):
    """Count each candidate's pixels anew, and add up what they have in common with the model."""
    high = len(across) // 2
    counts = np.empty(len(most), np.int64)
    for row in range(common.shape[0]):
        for column in range(common.shape[1]):
            counts[:] = 0
            for k in range(len(across)):
                v, u = top + row + k - high, left + column
                for pixel in index[v, u - across[k] : u + across[k] + 1]:
                    counts[pixel] += 1
            total = 0
            for i in range(len(most)):
                total += min(counts[i] * UNIT, most[i])
            common[row, column] = total


@no_type_check
@kernel()
def _slide(index, left, top, across, down, most, common):
    """Go through the rows to and fro; each candidate follows from the one before."""
    high, wide = len(across) // 2, len(down) // 2
    rows, columns = common.shape
    room = most.copy()  # what the model has of each colour beyond the candidate's pixels
    total = 0
    u, v = left, top
    for k in range(len(across)):
        for pixel in index[v + k - high, u - across[k] : u + across[k] + 1]:
            total += _enter(room, pixel)
    for row in range(rows):
        step = 1 - 2 * (row % 2)
        for column in range(columns):
            common[row, u - left] = total
            if column < columns - 1:
                for k in range(len(across)):
                    line = index[v + k - high]
                    total -= _leave(room, line[u - step * across[k]])
                    total += _enter(room, line[u + step * (across[k] + 1)])
                u += step
        if row < rows - 1:
            for k in range(len(down)):
                total -= _leave(room, index[v - down[k], u + k - wide])
                total += _enter(room, index[v + down[k] + 1, u + k - wide])
            v += 1


@no_type_check
@kernel(inline="always")
def _enter(room, pixel):
    """Add a pixel; return by how much more the histogram has in common with the model."""
    before = room[pixel]
    room[pixel] = before - UNIT
    return min(max(before, 0), UNIT)


@no_type_check
@kernel(inline="always")
def _leave(room, pixel):
    """Take a pixel away; return by how much less the histogram has in common with the model."""
    after = room[pixel] + UNIT
    room[pixel] = after
    return min(max(after, 0), UNIT)

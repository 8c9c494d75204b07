r"""Colour histograms: counted, compared, adapted.

A histogram has a number a bin; `Binning.index` gives the bin of each pixel. Equation numbers are
those of Andrade-Cetto, "Perception Issues in Mobile Robotics", section 3.2.
"""

from typing import no_type_check

import numpy as np
from jaxtyping import Bool, Float, Int, Int32

from robot_perception import checks
from robot_perception.kernels import kernel

__all__ = [
    "adapt",
    "box_histograms",
    "histogram",
    "intersection",
    "intersection_of_shares",
    "shares",
    "two_views",
]

Counts = Float[np.ndarray, " bins"]


def histogram(
    index: Int[np.ndarray, "height width"],
    count: int,
    mask: Bool[np.ndarray, "height width"] | None = None,
) -> Counts:
    """Return how many pixels fall into each bin.

    Parameters
    ----------
    index : (height, width)
        The bin of each pixel.
    count
        How many bins there are.
    mask : (height, width), optional
        Which pixels count; all if not given.

    Returns
    -------
    (count,)
        Numbers of pixels; all 0 if the mask is empty.

    Raises
    ------
    TypeError
        If the bins are not integers, or the mask is not of booleans.
    ValueError
        If there is no such bin, or the mask has another shape.
    """
    index, count = _index("index", index, count)
    if mask is not None:
        if not isinstance(mask, np.ndarray) or mask.dtype != bool:
            raise TypeError(f"mask must be an array of booleans, got {checks.shown(mask)}")
        checks.shaped("mask", mask, index.shape, beside="this index")
        index = index[mask]
    return np.bincount(index.ravel(), minlength=count).astype(float)


def box_histograms(
    index: Int[np.ndarray, "height width"], boxes: Int[np.ndarray, "n 4"], count: int
) -> Int32[np.ndarray, "n bins"]:
    """Return the histograms of many upright boxes.

    Parameters
    ----------
    index : (height, width)
        The bin of each pixel.
    boxes : (n, 4)
        Column and row of the first pixel, width and height, px.
    count
        How many bins there are.

    Raises
    ------
    ValueError
        If there is no such bin, or a box is empty or not within the image.
    """
    index, count = _index("index", index, count)
    boxes = checks.integers("boxes", boxes, ("n", 4))
    height, width = index.shape
    if boxes.size:
        inside = (boxes[:, :2] >= 0).all(axis=1) & (boxes[:, 2:] >= 1).all(axis=1)
        inside &= (boxes[:, :2] <= np.array([width, height]) - boxes[:, 2:]).all(axis=1)
        if not inside.all():
            wrong = boxes[int(np.argmin(inside))].tolist()
            raise ValueError(f"boxes must lie within {width} x {height} px, got {wrong}")
    found = np.zeros((len(boxes), count), dtype=np.int32)
    _count_boxes(index, boxes, found)
    return found


def shares(counts: Counts) -> Counts:
    """Return a histogram divided by its sum.

    Raises
    ------
    ValueError
        If a number is negative or not finite, or the histogram is empty.
    """
    counts = _histogram("counts", counts)
    return counts / _total("counts", counts)[..., None]


def intersection(
    candidate: Float[np.ndarray, "... bins"], model: Float[np.ndarray, "... bins"]
) -> Float[np.ndarray, "..."] | float:
    r"""Return which part of the candidate's pixels the model has too, as printed.

    .. math:: \phi(C) = \frac{\sum_i \min(C(i), M(i))}{\sum_i C(i)}

    It compares numbers of pixels: of candidates of many sizes it prefers small ones, since a few
    pixels inside the target all find theirs in the model.

    Parameters
    ----------
    candidate, model : (…, bins)
        C and M, numbers of pixels; leading axes broadcast.

    Returns
    -------
    (…)
        From 0 to 1.

    Raises
    ------
    ValueError
        If the bins differ, a number is negative or not finite, or a candidate is empty.

    References
    ----------
    Eq. (28). Swain and Ballard, "Color indexing", International Journal of Computer Vision 7(1),
    1991, divide by the sum of the model.
    """
    candidate, model = _pair(candidate, model)
    common = np.minimum(candidate, model).sum(axis=-1)
    return (common / _total("candidate", candidate))[()]


def intersection_of_shares(
    candidate: Float[np.ndarray, "... bins"], model: Float[np.ndarray, "... bins"]
) -> Float[np.ndarray, "..."] | float:
    r"""Return which part of the candidate the model has too, whatever the candidate's size.

    .. math:: \sum_i \min\left(\frac{C(i)}{\sum_j C(j)},\, M(i)\right)

    Parameters
    ----------
    candidate : (…, bins)
        Numbers of pixels, or shares.
    model : (…, bins)
        Shares: of one view they sum to 1, of two to 2.

    Returns
    -------
    (…)
        From 0 to 1.

    Raises
    ------
    ValueError
        If the bins differ, a number is negative or not finite, or a candidate is empty.

    References
    ----------
    Our choice where another sensor gives the size of the candidate.
    """
    candidate, model = _pair(candidate, model)
    candidate = candidate / _total("candidate", candidate)[..., None]
    return np.minimum(candidate, model).sum(axis=-1)[()]


def adapt(model: Counts, candidate: Counts, rate: float) -> Counts:
    r"""Return the model moved towards what was found.

    .. math:: M_k(i) = (1 - a) M_{k-1}(i) + a\, C_k(i)

    Parameters
    ----------
    model, candidate : (bins,)
        :math:`M_{k-1}` and :math:`C_k`, in the same unit.
    rate
        a, from 0 to 1.

    Raises
    ------
    ValueError
        If the bins differ, a number is negative or not finite, or the rate is out of range.

    References
    ----------
    Eq. (29).
    """
    candidate, model = _pair(candidate, model)
    rate = checks.share("rate", rate)
    return (1 - rate) * model + rate * candidate


def two_views(front: Counts, back: Counts) -> Counts:
    """Return a model of a head that may turn round: the sum of its histograms from both sides.

    Skin from the front and hair from behind: the paper's "bimodal histogram", in our reading.

    Parameters
    ----------
    front, back : (bins,)
        In the same unit, numbers of pixels or shares.

    Raises
    ------
    ValueError
        If the bins differ, or a number is negative or not finite.
    """
    front, back = _pair(front, back, ("front", "back"))
    return front + back


def _pair(
    one: np.ndarray, other: np.ndarray, names: tuple[str, str] = ("candidate", "model")
) -> tuple[np.ndarray, np.ndarray]:
    """Return two histograms of the same bins."""
    one, other = _histogram(names[0], one), _histogram(names[1], other)
    if one.shape[-1] != other.shape[-1]:
        raise ValueError(
            f"{names[0]} and {names[1]} must have the same bins,"
            f" got {one.shape[-1]} and {other.shape[-1]}"
        )
    checks.check_batches(**{names[0]: one.shape[:-1], names[1]: other.shape[:-1]})
    return one, other


def _histogram(name: str, counts: np.ndarray) -> np.ndarray:
    """Return a histogram, or a batch of them."""
    counts = checks.array(name, counts, (..., "bins"))
    if counts.size and counts.min() < 0:
        raise ValueError(f"{name} must not be negative, got {counts.min():g}")
    return counts


def _total(name: str, counts: np.ndarray) -> np.ndarray:
    """Return the sums of histograms that are not empty."""
    total = np.asarray(counts.sum(axis=-1))
    if not (total > 0).all():
        raise ValueError(f"{name} must hold a pixel, got an empty histogram")
    return total


def _index(name: str, index: np.ndarray, count: int) -> tuple[np.ndarray, int]:
    """Return an image of bins and how many there are."""
    count = checks.whole("count", count, 1, 2**24)
    if not isinstance(index, np.ndarray) or index.dtype.kind not in "iu":
        kind = index.dtype if isinstance(index, np.ndarray) else checks.shown(index)
        raise TypeError(f"{name} must be an array of integers, got {kind}")
    checks.shaped(name, index, ("height", "width"))
    if index.size and not (index.min() >= 0 and index.max() < count):
        raise ValueError(f"{name} must be below {count}, got {index.min()} to {index.max()}")
    return np.ascontiguousarray(index, dtype=np.int32), count


@no_type_check
@kernel()
def _count_boxes(index, boxes, found):
    """Count into two histograms in turn, so that no count waits for the one before it."""
    bins = found.shape[1]
    even, odd = np.empty(bins, np.int32), np.empty(bins, np.int32)
    for k in range(len(boxes)):
        even[:] = 0
        odd[:] = 0
        left, top, width, height = boxes[k]
        for v in range(top, top + height):
            for u in range(left, left + width - 1, 2):
                even[index[v, u]] += 1
                odd[index[v, u + 1]] += 1
            if width % 2:
                even[index[v, left + width - 1]] += 1
        for i in range(bins):
            found[k, i] = even[i] + odd[i]

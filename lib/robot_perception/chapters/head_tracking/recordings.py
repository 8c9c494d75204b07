"""Result of a recording of a real head that turns; the notebook follows it."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int64, UInt8

from studies.tables import Table

OFF = 0.2
"""An overlap below that is none; ours."""
LONG = 120
"""Pictures that are followed from each of many starts."""
APART = 10
"""Pictures from one of these starts to the next."""


@dataclass(frozen=True, eq=False, slots=True)
class Girl:
    """Result of each tracker in each picture, told of the first.

    Parameters
    ----------
    variants
        Names of the trackers.
    iou : (variants, n)
        Area that tracked ellipse and that of the marked box share, of the area of both.
    ellipses : (variants, n, 4)
        Centre (column, row), half width and half height, px.
    marked : (n, 4)
        The same of the marked boxes.
    frames : (k, height, width, 3)
        The pictures ``shown``, red, green and blue.
    shown : (k,)
        Which they are.
    starts : (s,)
        Pictures from which the trackers start anew, for ``LONG`` pictures each.
    missed : (variants, s)
        Share of these pictures in which the overlap is below ``OFF``.
    """

    variants: tuple[str, ...]
    iou: Float[np.ndarray, "variants n"]
    ellipses: Float[np.ndarray, "variants n 4"]
    marked: Float[np.ndarray, "n 4"]
    frames: UInt8[np.ndarray, "k height width 3"] = field(repr=False)
    shown: Int64[np.ndarray, " k"]
    starts: Int64[np.ndarray, " s"]
    missed: Float[np.ndarray, "variants s"]

    def table(self) -> Table:
        """Return losses by tracker, over the whole recording and over many starts."""
        rows = {
            name: [float(x) for x in ((iou < OFF).mean(), some.mean(), some.min(), some.max())]
            for name, iou, some in zip(self.variants, self.iou, self.missed, strict=True)
            if name != "adapted, gives up"
        }
        columns = {
            "missed": f"share of all pictures in which the overlap is below {OFF:g}",
            "over the starts": "the same share, mean over the starts",
            "least": "at the best start",
            "most": "at the worst start",
        }
        about = f"{self.iou.shape[1]} pictures of one recording, and {len(self.starts)} starts of "
        return Table(rows, columns, f"{about}{LONG} pictures each, {APART} apart", "tracker")

"""Matches of the features of two pictures: nearest both ways, within a window."""

from typing import no_type_check

import numpy as np
from jaxtyping import Int

from robot_perception.kernels import kernel
from robot_perception.landmarks.features import Features


def match_window(
    first: Features,
    expected: np.ndarray,
    second: Features,
    across: tuple[float, float],
    down: float,
    threshold: float,
) -> Int[np.ndarray, "pairs 2"]:
    """Return the pairs of features that are each other's nearest by descriptor in a window.

    Parameters
    ----------
    first, second
        Features of two pictures.
    expected : (n, 2)
        Where those of the first would lie in the second, px; infinite where nowhere.
    across
        Least and largest u of the second beyond the expected one, px.
    down
        Largest distance in v, px.
    threshold
        Largest distance between two descriptors.

    Returns
    -------
    (pairs, 2)
        Rows of the first, rising, and of the second.
    """
    order = np.argsort(second.pixels[:, 1], kind="stable")
    nearest, back = _nearest_in_window(
        np.ascontiguousarray(first.descriptors),
        np.ascontiguousarray(expected),
        second.descriptors[order],
        second.pixels[order],
        across[0],
        across[1],
        down,
        threshold**2,
    )
    rows = np.flatnonzero(nearest >= 0)
    rows = rows[back[nearest[rows]] == rows]
    return np.stack([rows, order[nearest[rows]]], axis=1)


@kernel()
@no_type_check
def _nearest_in_window(
    first, expected, second, pixels, least, most, down, limit
):  # pragma: no cover - compiled
    """Return the nearest in the second of each of the first, and the other way round, or -1.

    The second are sorted by v. A sum of squares ends where it can be nearest of neither.
    """
    n, m, d = len(first), len(second), first.shape[1]
    nearest, back = np.full(n, -1), np.full(m, -1)
    best_back = np.full(m, limit)
    rows = np.ascontiguousarray(pixels[:, 1])
    for i in range(n):
        u, v = expected[i]
        best = limit
        for j in range(np.searchsorted(rows, v - down), m):
            if rows[j] > v + down:
                break
            shift = pixels[j, 0] - u
            if not least <= shift <= most:
                continue
            bound = max(best, best_back[j])
            total = np.float32(0.0)
            for k in range(0, d, 16):
                for q in range(k, min(k + 16, d)):
                    step = first[i, q] - second[j, q]
                    total += step * step
                if total > bound:
                    break
            if total < best or (total == best and nearest[i] < 0):
                best, nearest[i] = total, j
            if total < best_back[j] or (total == best_back[j] and back[j] < 0):
                best_back[j], back[j] = total, i
    return nearest, back

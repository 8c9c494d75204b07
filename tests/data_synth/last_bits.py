"""NumPy's functions with other last bits, as another processor or library has them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Literal
from unittest.mock import patch

import numpy as np

Way = Literal["up", "down", "at random"]
WAYS: tuple[Way, ...] = ("up", "down", "at random")
FUNCTIONS = ("sin", "cos", "tan", "sinc", "arctan2", "arccos", "hypot", "exp", "log", "log1p")


def _moved(function: Callable[..., np.ndarray], way: Way) -> Callable[..., np.ndarray]:
    """Return a function whose results are the next ones; zero has no last place.

    What is moved at random moves the same way on each call, as on another processor.
    """

    def moved(*args, **options):
        found = np.asarray(function(*args, **options), dtype=float)
        steps = np.full(found.shape, {"up": 1, "down": -1}.get(way, 0))
        if way == "at random":
            mixed = found.view(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
            steps = (mixed >> np.uint64(40)).astype(np.int64) % 3 - 1
        still = (steps == 0) | (found == 0)
        return np.nextafter(found, np.where(still, found, steps * 9e99))[()]

    return moved


@contextmanager
def last_bits(way: Way) -> Iterator[None]:
    """Let NumPy's functions give other last bits, as a module that calls ``np.sin`` sees them."""
    with patch.multiple(np, **{name: _moved(getattr(np, name), way) for name in FUNCTIONS}):
        yield

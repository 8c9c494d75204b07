"""Checks of arguments, by name and value; worlds may not import the library's own."""

import math
from numbers import Integral, Real
from typing import Any

import numpy as np

__all__: tuple[str, ...] = ()  # for the worlds alone

LARGEST = 1e15
"""No world is larger, m; what is computed from it in floating point stays a number."""


def instance(name: str, value: Any, kind: type) -> Any:
    """Return a value of a type."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} must be a {kind.__name__}, got {_shown(value)}")
    return value


def generator(rng: Any) -> np.random.Generator:
    """Return a source of randomness."""
    return instance("rng", rng, np.random.Generator)


def number(
    name: str,
    value: Any,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    above: float = -math.inf,
    finite: bool = True,
) -> float:
    """Return a number from ``low`` to ``high``, both included, and greater than ``above``."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {_shown(value)}")
    if (finite and not math.isfinite(value)) or not low <= value <= high or not value > above:
        ends = f"from {low:g} to {high:g}" + (f", above {above:g}" if above > low else "")
        raise ValueError(f"{name} must be {'finite and ' * finite}{ends}, got {_shown(value)}")
    return float(value)


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Return a whole number in a range."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {_shown(value)}")
    if not isinstance(value, Integral) or not least <= value <= most:
        raise ValueError(f"{name} must be at least {least} and at most {most}, got {_shown(value)}")
    return int(value)


def reals(name: str, value: Any) -> np.ndarray:
    """Return real numbers as an array, finite or not."""
    try:
        found = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must be an array, got {_shown(value)}") from None
    if found.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be real numbers, got {_shown(value)}")
    return found.astype(float)


def array(
    name: str, value: Any, shape: tuple[int | None, ...], most: float = LARGEST
) -> np.ndarray:
    """Return numbers within ``most`` as an array; ``None`` in its shape is any length."""
    found = reals(name, value)
    _shaped(name, found, shape)
    if not np.isfinite(found).all():
        raise ValueError(f"{name} must be finite, {(~np.isfinite(found)).sum()} entries are not")
    if (farthest := np.abs(found).max(initial=0.0)) > most:
        raise ValueError(f"{name} must be within {most:g}, got {farthest:g}")
    return found


def wholes(
    name: str, value: Any, shape: tuple[int | None, ...], least: int, most: int
) -> np.ndarray:
    """Return whole numbers from ``least`` to ``most`` as they are; ``None`` is any length."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "iu":
        raise TypeError(f"{name} must be an array of whole numbers, got {_shown(value)}")
    _shaped(name, value, shape)
    if value.size and not (least <= value.min() and value.max() <= most):
        raise ValueError(
            f"{name} must be from {least} to {most}, got {value.min()} to {value.max()}"
        )
    return value


def flags(name: str, value: Any, size: int) -> np.ndarray:
    """Return an array of truth values (size,)."""
    if not isinstance(value, np.ndarray) or value.dtype != bool:
        raise TypeError(f"{name} must be an array of truth values, got {_shown(value)}")
    if value.shape != (size,):
        raise ValueError(f"{name} must be ({size},), got {value.shape}")
    return value


def deviations(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return standard deviations, one or as many as the shape has, in that shape."""
    found = reals(name, value)
    try:
        found = np.broadcast_to(found, shape)
    except ValueError:
        raise ValueError(f"{name} must be one number or {shape}, got {found.shape}") from None
    if not (found.min() >= 0 and np.isfinite(found).all()):
        raise ValueError(f"{name} must be finite and >= 0, got {found.min()}")
    return found


def _shaped(name: str, found: np.ndarray, shape: tuple[int | None, ...]) -> None:
    """Raise ``ValueError`` unless an array is of a shape."""
    if found.ndim != len(shape) or any(
        wanted not in (None, size) for size, wanted in zip(found.shape, shape, strict=True)
    ):
        words = ", ".join("n" if size is None else str(size) for size in shape)
        raise ValueError(f"{name} must be ({words}), got {found.shape}")


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."

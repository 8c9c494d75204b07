"""Checks of arguments: one text for one error, which names the parameter and the value.

A value of a wrong type is a ``TypeError``, one of the right type that is out of range a
``ValueError``. Finite is what is within `LARGEST`, so that products of three are no infinity.
"""

import reprlib
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

LARGEST = 1e100
COUNTED = 2**53
"""Number at which floating point can no longer count."""
SHORT = reprlib.Repr()
SHORT.maxother = SHORT.maxstring = 60


def shown(value: object) -> str:
    """Return a value in one short line, as messages show it."""
    if isinstance(value, np.generic):
        value = value.item()
    return " ".join(SHORT.repr(value).split())


def instance(name: str, value: Any, *kinds: type) -> Any:
    """Return a value of one of some types; a class is no instance, even where it looks like one."""
    if isinstance(value, type) or not isinstance(value, kinds):
        words = " or ".join(
            f"{'an' if kind.__name__[0].lower() in 'aeio' else 'a'} {kind.__name__}"
            for kind in kinds
        )
        raise TypeError(f"{name} must be {words}, got {shown(value)}")
    return value


def instances(name: str, values: Any, *kinds: type) -> tuple[Any, ...]:
    """Return the values of a sequence or iterator as a tuple, each of one of some types."""
    values = iterable(name, values)
    return tuple(instance(f"{name}[{i}]", value, *kinds) for i, value in enumerate(values))


def iterable(name: str, values: Any) -> Iterable[Any]:
    """Return what can be gone through, a sequence or an iterator."""
    try:
        iter(values)
    except TypeError:
        raise TypeError(f"{name} must be a sequence, got {shown(values)}") from None
    return values


def one_of(name: str, value: Any, allowed: Iterable[str]) -> Any:
    """Return one of some words."""
    allowed = tuple(allowed)
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(map(repr, allowed))
        raise ValueError(f"{name} must be one of {words}, got {shown(value)}")
    return value


def flag(name: str, value: Any) -> bool:
    """Return a boolean; numbers and texts are none."""
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {shown(value)}")
    return bool(value)


def whole(name: str, value: Any, least: int = -COUNTED, most: int | None = None) -> int:
    """Return a whole number in a range; one with a point, such as 2.0, is none."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {shown(value)}")
    if not isinstance(value, Integral):
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    if most is None and value < least:
        raise ValueError(f"{name} must be at least {least}, got {shown(value)}")
    if not least <= value <= (COUNTED if most is None else most):
        raise ValueError(f"{name} must be from {least} to {most or COUNTED}, got {shown(value)}")
    return int(value)


def number(name: str, value: Any) -> float:
    """Return a finite number."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {shown(value)}")
    if not abs(value) < np.inf:  # neither is NaN
        raise ValueError(f"{name} must be finite, got {shown(value)}")
    if abs(value) > LARGEST:
        raise ValueError(f"{name} must be within {LARGEST:g}, got {shown(value)}")
    return float(value)


def level(name: str, value: Any) -> float:
    """Return a number between 0 and 1, both excluded."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {shown(value)}")
    if not 0 < value < 1:
        raise ValueError(f"{name} must be between 0 and 1, got {shown(value)}")
    return float(value)


def reals(name: str, value: Any) -> np.ndarray:
    """Return real numbers as an array, each within `LARGEST`."""
    try:
        found = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must be an array, got unequal rows, {shown(value)}") from None
    boxed = found.dtype.kind == "O" and all(
        isinstance(one, Real) and not isinstance(one, bool) for one in found.flat
    )
    if not (found.dtype.kind in "iuf" or boxed):
        raise TypeError(f"{name} must be real numbers, got {shown(value)}")
    try:
        found = found.astype(float)
    except OverflowError:
        raise ValueError(f"{name} must be finite, got {shown(value)}") from None
    bad = np.count_nonzero(~np.isfinite(found))
    if bad:
        raise ValueError(f"{name} must be finite, got {bad} of {found.size} entries that are not")
    farthest = np.abs(found).max(initial=0.0)
    if farthest > LARGEST:
        raise ValueError(f"{name} must be within {LARGEST:g}, got {farthest:g}")
    return found

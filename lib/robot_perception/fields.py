"""Fields of dataclasses: what their types say is checked where an object is made.

A field says its shape, its kind and its range once, where it is declared::

    @dataclass(frozen=True, eq=False, slots=True)
    class DescriptorClasses:
        means: Float[np.ndarray, "n d"]
        squares: Annotated[Float[np.ndarray, "n d"], at_least(0)]
        counts: Annotated[Int[np.ndarray, " n"], at_least(1)]
        __post_init__ = checked

Axes of one name are of one length in all fields. What the checks return is kept: a list becomes an
array, a fraction a float. Numbers are finite unless a field is `OPEN`.
"""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from robot_perception import checks

__all__ = [
    "OPEN",
    "Level",
    "NotNegative",
    "Positive",
    "Share",
    "above",
    "above_zero",
    "any_of",
    "at_least",
    "checked",
    "copied",
    "covariance",
    "double",
    "from_to",
    "not_empty",
    "numbers",
    "odd",
    "one_of",
    "up_to",
    "wholes",
    "within",
]

OPEN = "open"
"""Marks an array that may hold infinities and NaN."""
Positive = Annotated[float, checks.positive]
NotNegative = Annotated[float, checks.not_negative]
Level = Annotated[float, checks.level]
Share = Annotated[float, checks.share]

Sizes = dict[str, tuple[int, str]]
Check = Callable[[str, Any, Sizes], Any]


def at_least(least: int) -> Callable[[str, np.ndarray], np.ndarray]:
    """Return the check of an array whose entries are that much or more."""

    def check(name: str, value: np.ndarray) -> np.ndarray:
        if value.size and not value.min() >= least:
            kind = f"be at least {least}" if least else "not be negative"
            raise ValueError(f"{name} must {kind}, got {value.min()}")
        return value

    return check


def above_zero(name: str, value: np.ndarray) -> np.ndarray:
    """Return an array whose entries are all positive."""
    if value.size and not value.min() > 0:
        raise ValueError(f"{name} must be positive, got {value.min():g}")
    return value


def one_of(*words: str) -> Callable[[str, Any], str]:
    """Return the check of a text that is one of some."""
    return lambda name, value: checks.one_of(name, value, words)


def from_to(least: int, most: int | None = None) -> Callable[[str, Any], int]:
    """Return the check of a whole number in a range."""
    return lambda name, value: checks.whole(name, value, least, most)


def covariance(name: str, value: np.ndarray) -> np.ndarray:
    """Return an array of one covariance, or of a batch of them."""
    checks.check_covariance(name, value)
    return value


def double(name: str, value: np.ndarray) -> np.ndarray:
    """Return an array in double precision, which what is computed with it needs."""
    return value.astype(float, copy=False)


def checked(self: Any) -> None:
    """Check the fields of a frozen dataclass by their types, as its ``__post_init__``.

    Raises
    ------
    TypeError
        If a field is of another type.
    ValueError
        If an array is of another shape than its type says and the fields before it leave open, or a
        number is out of its range.
    """
    sizes: Sizes = {}
    for name, check in _plan(type(self)):
        object.__setattr__(self, name, check(name, getattr(self, name), sizes))


@cache
def _plan(kind: type) -> tuple[tuple[str, Check], ...]:
    hints = get_type_hints(kind, include_extras=True)
    return tuple((field.name, _check(hints[field.name])) for field in fields(kind) if field.init)


def _check(hint: Any) -> Check:
    """Return the check that a type asks for."""
    hint, *more = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    ranges = [check for check in more if check is not OPEN]
    if hasattr(hint, "dim_str"):
        return _array(hint, OPEN in more, ranges)
    if ranges:
        return lambda name, value, _: ranges[0](name, value)
    if get_origin(hint) in (Union, UnionType) and NoneType in get_args(hint):
        (inner,) = (_check(arg) for arg in get_args(hint) if arg is not NoneType)
        return lambda name, value, sizes: None if value is None else inner(name, value, sizes)
    plain = {float: checks.number, int: checks.whole, bool: checks.flag}.get(hint)
    if plain:
        return lambda name, value, _: plain(name, value)
    if get_origin(hint) is tuple:
        return _tuple(get_args(hint))
    if get_origin(hint) in (dict, Mapping):
        return _mapping(get_origin(hint), *get_args(hint))
    return lambda name, value, _: checks.instance(name, value, get_origin(hint) or hint)


def _tuple(kinds: tuple) -> Check:
    inner = [_check(kind) for kind in kinds if kind is not ...]

    def check(name: str, value: Any, sizes: Sizes) -> tuple:
        items = tuple(checks.iterable(name, value))
        each = inner * len(items) if kinds[-1] is ... else inner
        if len(items) != len(each):
            raise ValueError(f"{name} must be {len(each)}, got {checks.shown(value)}")
        return tuple(one(f"{name}[{i}]", item, sizes)
                     for i, (one, item) in enumerate(zip(each, items, strict=True)))  # fmt: skip

    return check


def _mapping(kind: type, key: Any, inner: Any) -> Check:
    keys, values = _check(key), _check(inner)

    def check(name: str, value: Any, sizes: Sizes) -> Any:
        found = checks.instance(name, value, kind).items()
        return {keys(f"a key of {name}", k, sizes): values(f"{name}[{k!r}]", v, sizes)
                for k, v in found}  # fmt: skip

    return check


def _array(hint: Any, is_open: bool, ranges: list[Callable]) -> Check:
    axes = [... if axis[0] in ".*" else int(axis) if axis.isdigit() else axis
            for axis in hint.dim_str.split()]  # fmt: skip

    def check(name: str, value: Any, sizes: Sizes) -> np.ndarray:
        found = _of_kind(name, value, hint.dtypes, is_open)
        bound = [sizes[axis] for axis in axes if axis in sizes]
        shape = tuple(sizes[axis][0] if axis in sizes else axis for axis in axes)
        checks.shaped(name, found, shape, bound[0][1] if bound else "")
        for axis, size in zip(axes[::-1], found.shape[::-1], strict=False):
            if isinstance(axis, str):
                sizes.setdefault(axis, (size, f"{name} {found.shape}"))
        for one in ranges:
            found = one(name, found)
        return found

    return check


def _of_kind(name: str, value: Any, kinds: tuple[str, ...], is_open: bool) -> np.ndarray:
    """Return an array of floats, whole numbers, bytes or truth values."""
    if "float64" in kinds:
        single = isinstance(value, np.ndarray) and value.dtype == np.float32
        found = checks.array(name, value, finite=not is_open)
        return value if single else found
    if "int64" in kinds:
        return checks.integers(name, value)
    if not isinstance(value, np.ndarray) or value.dtype.name not in kinds:
        word = {"bool": "truth values", "uint8": "bytes"}[kinds[0]]
        raise TypeError(f"{name} must be an array of {word}, got {checks.shown(value)}")
    return value


def not_empty(name: str, value: np.ndarray) -> np.ndarray:
    """Return an array that has an entry."""
    if not value.size:
        raise ValueError(f"{name} must not be empty, got {value.shape}")
    return value


def copied(name: str, value: np.ndarray) -> np.ndarray:
    """Return a copy of an array, which changes no more where the caller's does."""
    return value.copy()


def above(low: float, most: float) -> Callable[[str, Any], float]:
    """Return the check of a number above one and at most another."""

    def check(name: str, value: Any) -> float:
        found = checks.number(name, value)
        if not low < found <= most:
            raise ValueError(
                f"{name} must be above {low:g} and at most {most:g}, got {checks.shown(value)}"
            )
        return found

    return check


def any_of(*kinds: type) -> Callable[[str, Any], Any]:
    """Return the check of an object of one of some types."""
    return lambda name, value: checks.instance(name, value, *kinds)


def numbers(
    count: int, *more: Callable[[str, np.ndarray], np.ndarray]
) -> Callable[[str, Any], tuple[float, ...]]:
    """Return the check of so many numbers, kept as a tuple; ``more`` are checks of an array."""

    def check(name: str, value: Any) -> tuple[float, ...]:
        found = checks.array(name, value, (count,))
        for one in more:
            found = one(name, found)
        return tuple(found.tolist())

    return check


def wholes(count: int, least: int | None = None) -> Callable[[str, Any], tuple[int, ...]]:
    """Return the check of so many whole numbers, each that much or more, kept as a tuple."""
    return lambda name, value: tuple(checks.integers(name, value, (count,), least).tolist())


def odd(least: int, most: int) -> Callable[[str, Any], int]:
    """Return the check of an odd number in a range."""

    def check(name: str, value: Any) -> int:
        found = checks.whole(name, value, least, most)
        if found % 2 == 0:
            raise ValueError(f"{name} must be odd, got {found}")
        return found

    return check


def up_to(most: float) -> Callable[[str, Any], float]:
    """Return the check of a positive number that is that much or less."""

    def check(name: str, value: Any) -> float:
        found = checks.positive(name, value)
        if found > most:
            raise ValueError(f"{name} must be at most {most:g}, got {found:g}")
        return found

    return check


def within(least: float, most: float) -> Callable[[str, Any], float]:
    """Return the check of a number from one to another, both included."""

    def check(name: str, value: Any) -> float:
        found = checks.number(name, value)
        if not least <= found <= most:
            raise ValueError(f"{name} must be from {least:g} to {most:g}, got {found:g}")
        return found

    return check

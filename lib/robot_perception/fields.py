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

__all__ = ["OPEN", "Level", "NotNegative", "Positive", "at_least", "checked", "from_to"]

OPEN = "open"
"""Marks an array that may hold infinities and NaN."""
Positive = Annotated[float, checks.positive]
NotNegative = Annotated[float, checks.not_negative]
Level = Annotated[float, checks.level]

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


def from_to(least: int, most: int | None = None) -> Callable[[str, Any], int]:
    """Return the check of a whole number in a range."""
    return lambda name, value: checks.whole(name, value, least, most)


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

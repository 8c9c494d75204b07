"""Checks of arguments: one text for one error, which names the parameter and the value.

A value of a wrong type is a ``TypeError``; one of the right type that is out of range, or an array
of another shape, a ``ValueError``. A boolean is no number. Whatever NumPy makes an array of real
numbers may stand for one. The checks return the value as the caller goes on to use it. Finite is
what is within `LARGEST`, so that squares and products of three are no infinity and no NaN.

A shape is a tuple of lengths, of names for lengths that are free (the same name twice: the same
length) and, in front, of ``...`` for any leading axes: ``(..., "n", 2)``.
"""

import reprlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import is_dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np

COUNTED = 2**53
LARGEST = 1e100
"""Within it the products of three numbers are finite."""
WHOLE = np.iinfo(np.int64)
KINDS = {np.bool_: "truth values", np.uint8: "bytes", np.floating: "floating-point numbers"}
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
        words = " or ".join(_with_article(kind.__name__) for kind in kinds)
        raise TypeError(f"{name} must be {words}, got {shown(value)}")
    return value


def instances(name: str, values: Any, *kinds: type) -> tuple[Any, ...]:
    """Return the values of a sequence or iterator as a tuple, each of one of some types."""
    values = iterable(name, values)
    return tuple(instance(f"{name}[{i}]", value, *kinds) for i, value in enumerate(values))


def dataclass_type(name: str, kind: Any) -> type:
    """Return a type of dataclasses."""
    if not isinstance(kind, type) or not is_dataclass(kind):
        raise TypeError(f"{name} must be a dataclass, got {shown(kind)}")
    return kind


def entries(name: str, values: Any, *kinds: type) -> Mapping[str, Any]:
    """Return a mapping from texts to values that are each of one of some types."""
    for key, value in instance(name, values, Mapping).items():
        instance(f"a name in {name}", key, str)
        instance(f"{name}[{key!r}]", value, *kinds)
    return values


def iterable(name: str, values: Any) -> Iterable[Any]:
    """Return what can be gone through, a sequence or an iterator."""
    try:
        iter(values)
    except TypeError:
        raise TypeError(f"{name} must be a sequence, got {shown(values)}") from None
    return values


def one_of(name: str, value: Any, allowed: Iterable[str], more: str = "") -> Any:
    """Return one of some words; ``more`` says what else would do."""
    allowed = tuple(allowed)
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(map(repr, allowed))
        raise ValueError(f"{name} must be one of {words}{more}, got {shown(value)}")
    return value


def flag(name: str, value: Any) -> bool:
    """Return a boolean; numbers and texts are none."""
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {shown(value)}")
    return bool(value)


def generator(name: str, value: Any) -> np.random.Generator:
    """Return a source of randomness."""
    return instance(name, value, np.random.Generator)


def whole(name: str, value: Any, least: int | None = None, most: int | None = None) -> int:
    """Return a whole number in a range; one with a point, such as 2.0, is none.

    Where no range is given it ends where floating point can no longer count.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {shown(value)}")
    if not isinstance(value, Integral):
        raise ValueError(f"{name} must be a whole number, got {shown(value)}")
    if most is None and least is not None and value < least:
        raise ValueError(f"{name} must be at least {least}, got {shown(value)}")
    low, high = -COUNTED if least is None else least, COUNTED if most is None else most
    if not low <= value <= high:
        raise ValueError(f"{name} must be from {low} to {high}, got {shown(value)}")
    return int(value)


def number(name: str, value: Any, *, finite: bool = True) -> float:
    """Return a real number, within `LARGEST` unless all are allowed; NaN is never a number."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {shown(value)}")
    try:
        result = float(value)
    except OverflowError:
        result = np.inf
    if np.isnan(result) or (finite and np.isinf(result)):
        raise ValueError(f"{name} must be {'finite' if finite else 'a number'}, got {shown(value)}")
    return moderate(name, result) if finite and abs(result) > LARGEST else result


def positive(name: str, value: Any) -> float:
    """Return a finite number above 0: from 1 / `LARGEST` on, so that its square is no 0."""
    result = np.nan
    with suppress(ValueError):  # NaN is not positive either
        result = number(name, value, finite=False)
    if not 0 < result < np.inf:
        raise ValueError(f"{name} must be positive and finite, got {shown(value)}")
    if result < 1 / LARGEST:
        raise ValueError(f"{name} must be at least {1 / LARGEST:g}, got {shown(value)}")
    return number(name, result)


def not_negative(name: str, value: Any) -> float:
    """Return a finite number of at least 0."""
    result = number(name, value)
    if result < 0:
        raise ValueError(f"{name} must not be negative, got {shown(value)}")
    return result


def share(name: str, value: Any) -> float:
    """Return a number from 0 to 1, both included."""
    result = number(name, value, finite=False)
    if not 0 <= result <= 1:
        raise ValueError(f"{name} must be from 0 to 1, got {shown(value)}")
    return result


def level(name: str, value: Any) -> float:
    """Return a number between 0 and 1, both excluded."""
    result = number(name, value, finite=False)
    if not 0 < result < 1:
        raise ValueError(f"{name} must be between 0 and 1, got {shown(value)}")
    return result


def array(
    name: str, value: Any, shape: tuple = (...,), beside: str = "", *, finite: bool = True
) -> np.ndarray:
    """Return real numbers as an array of a shape; within `LARGEST` unless other ones are allowed.

    Where the shape follows from another argument, ``beside`` says so in the message.
    """
    result = reals(name, value)
    shaped(name, result, shape, beside)
    if finite and not (np.abs(result) <= LARGEST).all():
        check_finite(name, result)
        moderate(name, result)
    return result


def moderate(name: str, value: Any, most: float = LARGEST) -> Any:
    """Return a number or an array with no entry beyond a bound."""
    farthest = np.abs(value).max(initial=0.0)
    if farthest > most:
        raise ValueError(f"{name} must be within {most:g}, got {farthest:g}")
    return value


@contextmanager
def computable(what: str, *more: type[Exception]) -> Iterator[None]:
    """Raise ``ValueError`` where arithmetic gives up: numbers too large, small or far apart.

    It gives up where NumPy would warn of an infinity or of a NaN.
    """
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            yield
    except (np.linalg.LinAlgError, ArithmeticError, *more) as error:
        reason = f"numbers too large, too small or too far apart to compute with ({error})"
        raise ValueError(f"{what} must not have {reason}") from error


def vector(name: str, value: Any, size: int) -> np.ndarray:
    """Return so many finite numbers as a new array."""
    return array(name, value, (size,)).copy()


def reals(name: str, value: Any) -> np.ndarray:
    """Return real numbers as an array, whatever its shape; infinite ones and NaN may be there."""
    found = _array(name, value)
    if found.dtype == float:
        return found
    real = found.dtype.kind in "iuf" or (
        found.dtype.kind == "O"
        and all(isinstance(v, Real) and not isinstance(v, bool) for v in found.flat)
    )
    if not real:
        raise TypeError(f"{name} must be real numbers, got {shown(value)}")
    try:
        return found.astype(float)
    except OverflowError:
        raise ValueError(f"{name} must be finite, got {shown(value)}") from None


def integers(
    name: str, value: Any, shape: tuple = (...,), least: int | None = None, beside: str = ""
) -> np.ndarray:
    """Return whole numbers as a new array of a shape."""
    found = _array(name, value)
    if found.size and found.dtype.kind not in "iu":
        error = ValueError if found.dtype.kind in "fO" else TypeError
        raise error(f"{name} must be integers, got {shown(value)}")
    shaped(name, found, shape, beside)
    if least is not None and found.size and found.min() < least:
        raise ValueError(f"{name} must be at least {least}, got {found.min()}")
    if found.size and found.max() > WHOLE.max:  # of 64 bits without a sign
        raise ValueError(f"{name} must be at most {WHOLE.max}, got {found.max()}")
    return found.astype(np.int64)


def typed(
    name: str, value: Any, kind: type[np.generic], shape: tuple = (...,), beside: str = ""
) -> np.ndarray:
    """Return an array of one of `KINDS`, as it is: what a kernel reads is of this type and shape.

    Its entries are not looked at.
    """
    if not isinstance(value, np.ndarray) or not np.issubdtype(value.dtype, kind):
        raise TypeError(f"{name} must be an array of {KINDS[kind]}, got {shown(value)}")
    shaped(name, value, shape, beside)
    return value


def shaped(name: str, found: np.ndarray, shape: tuple, beside: str = "") -> None:
    """Raise ``ValueError`` unless an array is of a shape."""
    if found.shape == shape:
        return
    sizes, axes = found.shape, shape
    if shape[:1] == (...,):
        axes = shape[1:]
        sizes = sizes[max(len(sizes) - len(axes), 0) :]
    free: dict[str, int] = {}
    if len(sizes) != len(axes) or any(
        size != (free.setdefault(axis, size) if isinstance(axis, str) else axis)
        for size, axis in zip(sizes, axes, strict=True)
    ):
        words = ", ".join("…" if axis is ... else str(axis) for axis in shape)
        comma = "," if len(shape) == 1 else ""
        wanted = f"({words}{comma})" if shape else "one number"
        reason = f" for {beside}" if beside else ""
        raise ValueError(f"{name} must be {wanted}{reason}, got {found.shape}")


def check_batches(**shapes: tuple[int, ...]) -> None:
    """Raise ``ValueError`` unless the leading axes of arguments broadcast."""
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        words = " and ".join(f"{shape} of {name}" for name, shape in shapes.items())
        raise ValueError(f"leading axes must broadcast, got {words}") from None


def check_finite(name: str, value: np.ndarray) -> None:
    """Raise ``ValueError`` naming ``name`` if an entry of ``value`` is NaN or infinite."""
    bad = np.count_nonzero(~np.isfinite(value))
    if bad:
        raise ValueError(
            f"{name} must be finite, got {bad} of {np.size(value)} entries that are not"
        )


def check_covariance(name: str, cov: np.ndarray, *, tolerance: float = 1e-9) -> None:
    """Raise ``ValueError`` unless every ``(…, n, n)`` matrix is symmetric positive semi-definite.

    The tolerance is relative to the largest entry of each matrix.
    """
    if cov.ndim < 2 or cov.shape[-1] != cov.shape[-2]:
        raise ValueError(f"{name} must be (…, n, n), got {cov.shape}")
    check_finite(name, cov)
    if cov.shape[-1] == 0:
        return
    scale = np.maximum(np.abs(cov).max(axis=(-2, -1)), np.finfo(float).tiny)
    asymmetry = (np.abs(cov - cov.mT).max(axis=(-2, -1)) / scale).max(initial=0.0)
    if asymmetry > tolerance:
        raise ValueError(f"{name} must be symmetric, relative asymmetry is {asymmetry:.3g}")
    with suppress(np.linalg.LinAlgError):
        np.linalg.cholesky(cov)  # a tenth of the time of eigenvalues, and enough where it exists
        return
    lowest = (np.linalg.eigvalsh(cov)[..., 0] / scale).min(initial=0.0)
    if lowest < -tolerance:
        raise ValueError(
            f"{name} must be positive semi-definite, smallest relative eigenvalue is {lowest:.3g}"
        )


def covariance(
    name: str, value: Any, shape: tuple = (..., "n", "n"), beside: str = ""
) -> np.ndarray:
    """Return one covariance, or a batch of them, as an array of a shape."""
    cov = array(name, value, shape, beside)
    check_covariance(name, cov)
    return cov


def _array(name: str, value: Any) -> np.ndarray:
    """Return what NumPy makes of a value, of whatever type its entries are."""
    try:
        return np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must be an array, got unequal rows, {shown(value)}") from None


def _with_article(noun: str) -> str:
    return f"{'an' if noun[0].lower() in 'aeio' else 'a'} {noun}"

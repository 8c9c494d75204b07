"""The sweep: a valid call, and the same with one argument after the other made wrong."""

import inspect
import re
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from beartype import BeartypeConf
from beartype.door import is_bearable

SECONDS = 20  # a call that takes longer runs away
MEMORY = 4 * 2**30  # and so does one that asks for more bytes than this
FLAT = BeartypeConf(is_pep484_tower=True)

Call = tuple[tuple, dict[str, Any]]


def call(*args: Any, **kwargs: Any) -> Call:
    """Return the arguments of a call."""
    return args, kwargs


class Wrong:
    """A class where an object is wanted; it can be called, as any class."""

    def __init__(self, *args: object, **kwargs: object) -> None:
        """Take everything."""


class Ran(Exception):  # noqa: N818 - an event, and no ValueError that a check could swallow
    """A call ran away."""


def wrong_values(valid: Any) -> Iterator[tuple[str, Any]]:
    """Yield wrong values with their names; wrong arrays are made from the valid one, if it is."""
    array = np.ones(2)
    if isinstance(valid, np.ndarray | list | tuple):
        with suppress(ValueError):  # of unequal rows
            array = np.asarray(valid)
    if array.dtype.kind not in "iuf":
        array = np.ones(2)
    broken = np.array(array, dtype=float)
    if broken.size:
        broken.flat[-1] = np.nan
    yield "None", None
    yield "True", True
    yield "'abc'", "abc"
    yield "nan", float("nan")
    yield "inf", float("inf")
    yield "-1", -1
    yield "1.5", 1.5
    yield "10**30", 10**30
    yield "Fraction", Fraction(1, 2)
    yield "[]", []
    yield "a list", array.tolist()
    yield "array of one axis more", array[..., None]
    yield "array of no axis", np.array(1.0)
    yield "empty array", np.empty((0,) * max(array.ndim, 1))
    yield "array with a NaN", broken
    yield "array of -1", -np.ones_like(array)
    yield "complex array", array + 1j
    yield "array of texts", array.astype(str)
    yield "object()", object()
    yield "a class", Wrong
    yield "a dict", {"wrong": 0.5}


STRANGE = {"Fraction", "a list", "complex array", "array of texts", "object()", "a class", "a dict"}
"""What a stranger may hand over and no chapter does."""


def wrong_numbers(valid: Any) -> Iterator[tuple[str, Any]]:
    """Yield the wrong values that a chapter may hand to a world: numbers, shapes, words."""
    yield from ((label, value) for label, value in wrong_values(valid) if label not in STRANGE)


def huge_values(valid: Any) -> Iterator[tuple[str, Any]]:
    """Yield numbers, arrays and objects at the ends of floating point, and what is read-only."""
    for value in (1e200, 1e308, 1e-320, 10**12):
        yield f"{value:g}", value
    is_array = isinstance(valid, np.ndarray | list | tuple)
    array = np.asarray(valid) if is_array else np.ones(2)
    array = array.astype(float) if array.dtype.kind in "iuf" else np.ones(2)
    wild = np.random.default_rng(7)
    yield "array of 1e308", np.full_like(array, 1e308)
    yield "array times 1e200", array * 1e200
    yield (
        "wild array",
        wild.choice([-1, 1], array.shape) * 10 ** wild.uniform(-320, 308, array.shape),
    )
    last = array.copy()
    last.flat[-1:] = 1e200
    yield "last 1e200", last
    fixed = valid.copy() if isinstance(valid, np.ndarray) else array
    fixed.flags.writeable = False
    yield "read-only array", fixed
    for scale in (1e-200, 1e100, 1e200):
        try:
            yield f"all times {scale:g}", _scaled(valid, scale)
        except (ValueError, TypeError):  # the object itself refuses them
            yield f"all times {scale:g}", valid


def _scaled(value: Any, scale: float) -> Any:
    """Return an object with all its numbers times a factor."""
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        return value * scale
    if is_dataclass(value) and not isinstance(value, type):
        parts = (f.name for f in fields(value) if f.init)
        return replace(value, **{name: _scaled(getattr(value, name), scale) for name in parts})
    if type(value) in (list, tuple):
        return type(value)(_scaled(item, scale) for item in value)
    return value


def sweep_huge(calls: Mapping[Callable, Callable[[], Call]], names: Mapping[Callable, str]) -> list:
    """Return a line for each call that ends in somebody else's error, in a NaN, or not at all.

    What comes of numbers that nobody has may be infinite; what an array that is not to be written
    to leads to may not be an error.
    """
    failures = []
    with _limited():
        for function, name in names.items():
            sound = _sound(function, *calls[function]())
            for parameter, label, call, _ in _calls(function, calls[function], huge_values):
                try:
                    if _nans(_run(function, *call)) and sound:
                        failures.append(f"{name}({parameter}={label}): a NaN in silence")
                except Exception as error:
                    own = type(error).__module__.startswith(("robot_perception", "data_synth"))
                    ours = own or type(error) in (ValueError, TypeError)
                    if not ours or "read-only" in str(error):
                        failures.append(f"{name}({parameter}={label}): {_said(error)}")
    return failures


def sweep(
    calls: Mapping[Callable, Callable[[], Call]],
    names: Mapping[Callable, str],
    values: Callable[[Any], Iterator] = wrong_values,
) -> list[str]:
    """Return a line for each failure: ``function(parameter=value): what happened``."""
    failures = []
    with _limited():
        for function, name in names.items():
            try:
                sound = _sound(function, *calls[function]())
            except Exception as error:
                failures.append(f"{name}: the valid call fails: {_said(error)}")
                continue
            failures += [
                f"{name}({parameter}={value}): {problem}"
                for parameter, value, problem in _problems(function, calls[function], sound, values)
            ]
    return failures


def _sound(function: Callable, args: tuple, kwargs: Mapping[str, Any]) -> bool:
    """Tell whether a valid call gives no NaN; it may compile, which no clock may end."""
    return not _nans(function(*args, **kwargs))


def _problems(
    function: Callable, valid: Callable[[], Call], sound: bool, values: Callable[[Any], Iterator]
) -> Iterator[tuple[str, str, str]]:
    """Yield parameter, wrong value and what was wrong with the answer."""
    annotations = inspect.signature(function).parameters
    for parameter, label, call, value in _calls(function, valid, values):
        annotation = annotations[parameter].annotation
        try:
            result = _run(function, *call)
        except Exception as error:
            if not _answers(error, parameter, function):
                yield parameter, label, _said(error)
        else:
            if sound and _nans(result):
                yield parameter, label, "a NaN in silence"
            elif not _may_pass(value, annotation):
                yield parameter, label, f"accepted, not {annotation}"
            elif isinstance(value, list) and _kept(result, parameter, annotation):
                yield parameter, label, "kept as a list"


def _calls(
    function: Callable, valid: Callable[[], Call], values: Callable[[Any], Iterator]
) -> Iterator[tuple[str, str, Call, Any]]:
    """Yield parameter, name of a value, the valid call with this value in its place, and it."""
    signature = inspect.signature(function)
    for parameter in signature.parameters.values():
        if parameter.name == "self" or parameter.kind is parameter.VAR_KEYWORD:
            continue
        for label, _ in values(None):
            args, kwargs = valid()
            bound = signature.bind(*args, **kwargs)
            before = bound.arguments.get(parameter.name, parameter.default)
            value = dict(values(before))[label]
            if value is before:  # an object without numbers, times a factor: the valid call again
                continue
            several = parameter.kind is parameter.VAR_POSITIONAL
            bound.arguments[parameter.name] = (value,) if several else value
            ordered = {p: bound.arguments[p] for p in signature.parameters if p in bound.arguments}
            bound.arguments = ordered
            yield parameter.name, label, (bound.args, bound.kwargs), value


def _answers(error: Exception, parameter: str, function: Callable) -> bool:
    """Tell whether an exception is an answer to the caller, not somebody else's accident."""
    kind = type(error)
    own = kind.__module__.startswith(("robot_perception", "data_synth"))
    if isinstance(error, OSError | LookupError):
        doc = inspect.getdoc(function) or ""
        documented = any(k.__name__ in doc for k in kind.__mro__ if k is not Exception)
        return documented and (own or isinstance(error, OSError))
    if not isinstance(error, ValueError | TypeError) or not (
        own or kind in (ValueError, TypeError)
    ):
        return False
    return re.search(rf"(?<!\w){re.escape(parameter)}(?!\w)", str(error)) is not None


def _may_pass(value: Any, annotation: Any) -> bool:
    """Tell whether a value may be right: numbers may (a list stands for an array, 1 for 1.0);
    what is no number only where the signature says so.
    """
    if isinstance(value, Real | list) and not isinstance(value, bool):
        return True
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        return True
    if isinstance(value, np.ndarray) and "ndarray" in str(annotation):
        return False  # complex, or texts
    return is_bearable(value, annotation, conf=FLAT)


def _kept(result: Any, parameter: str, annotation: Any) -> bool:
    """Tell whether an object has a list where its type says that an array is."""
    return "ndarray" in str(annotation) and isinstance(getattr(result, parameter, None), list)


def _nans(value: Any, depth: int = 6) -> bool:
    """Tell whether a NaN is somewhere in a result."""
    if isinstance(value, float | complex | np.inexact):
        return bool(np.isnan(value))
    if isinstance(value, np.ndarray):
        if value.dtype == object:
            return depth > 0 and any(_nans(v, depth - 1) for v in value.flat)
        return value.dtype.kind in "fc" and bool(np.isnan(value).any())
    if depth == 0:
        return False
    if isinstance(value, Mapping):
        return any(_nans(v, depth - 1) for v in value.values())
    if isinstance(value, tuple | list | set | frozenset):
        return any(_nans(v, depth - 1) for v in value)
    if is_dataclass(value) and not isinstance(value, type):
        return any(_nans(getattr(value, f.name), depth - 1) for f in fields(value))
    return False


def _run(function: Callable, args: tuple, kwargs: Mapping[str, Any]) -> Any:
    """Call, and stop a call that runs away."""
    with _alarm():
        return function(*args, **kwargs)


@contextmanager
def _alarm() -> Iterator[None]:
    def ring(*_: object) -> None:
        raise Ran(f"ran for {SECONDS} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def _limited() -> Iterator[None]:
    """Let a call that asks for too much memory end in a ``MemoryError``, where the system can."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with suppress(ValueError, OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        used = pages * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())[:160]}"

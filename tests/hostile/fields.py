"""Handed objects: a valid call, and the same with one field of an argument replaced.

``python -m tests.hostile.fields ROOM`` prints a line for each call, of this sweep and of those that
replace arguments, by which a kernel would read or write outside of an array. Numba tells where
``NUMBA_BOUNDSCHECK=1`` is set before it compiles.
"""

import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import chdir, contextmanager, suppress
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from typing import Any

import numba
import numpy as np

from tests.hostile.surface import calls, public
from tests.hostile.sweep import Call, _limited, _run, _said, sweep, sweep_huge, wrong_values
from tests.unchecked import unchecked

OUTSIDE = "index is out of bounds"
"""Numba's words; NumPy, which does not read there, has more of them."""
DEEP = 3
"""Objects inside of each other."""


def wrong_fields(value: Any, deep: int = DEEP) -> Iterator[tuple[str, Any]]:
    """Yield an object with one field made wrong, and its name; of a sequence the first object is.

    What an object refuses to be made of is no object, and left out.
    """
    if isinstance(value, list | tuple) and value and is_dataclass(value[0]):
        for name, first in wrong_fields(value[0], deep):
            yield f"[0]{name}", type(value)([first, *value[1:]])
    if not is_dataclass(value) or isinstance(value, type) or not deep:
        return
    for field in fields(value):
        if not field.init:
            continue
        inside = getattr(value, field.name)
        wrong = [(f"={name}", other) for name, other in (*wrong_values(inside), *misfits(inside))]
        for name, other in (*wrong, *wrong_fields(inside, deep - 1)):
            made = []
            with suppress(Exception):
                made.append(replace(value, **{field.name: other}))
            yield from ((f".{field.name}{name}", thing) for thing in made)


def misfits(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield arrays that fit others of their object no longer: other lengths, indices far away."""
    if not isinstance(value, np.ndarray) or not value.size:
        return
    for axis in range(value.ndim):
        yield f"shorter along axis {axis}", np.delete(value, -1, axis)
        yield f"longer along axis {axis}", np.concatenate([value, value], axis)
    yield "transposed", value.T
    if value.dtype.kind in "iu":
        ends = np.iinfo(value.dtype)
        for far in (ends.min, ends.max, min(ends.max, 1000)):
            last = value.copy()
            last.flat[-1] = far
            yield f"last {far}", last
    if value.dtype.kind == "f":
        for far in (np.nan, np.inf, 1e18):
            yield f"all {far:g}", np.full_like(value, far)


def replaced(valid: Call) -> Iterator[tuple[str, Call]]:
    """Yield calls with one field of one argument made wrong, and what was done."""
    args, kwargs = valid
    for i, value in enumerate(args):
        for name, wrong in wrong_fields(value):
            yield f"argument {i}{name}", ((*args[:i], wrong, *args[i + 1 :]), kwargs)
    for key, value in kwargs.items():
        for name, wrong in wrong_fields(value):
            yield f"{key}{name}", (args, kwargs | {key: wrong})


@contextmanager
def quiet() -> Iterator[None]:
    """Let nothing be said of numbers that are none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def leaves(error: Exception) -> bool:
    """Tell whether an error is numba's of a kernel that leaves an array."""
    return type(error) is IndexError and str(error) == OUTSIDE


def sweep_fields(
    calls: Mapping[Callable, Callable[[], Call]], names: Mapping[Callable, str]
) -> list[str]:
    """Return a line for each call by which a kernel leaves an array; other errors are no matter."""
    found = []
    with _limited():
        for function, name in names.items():
            for what, (args, kwargs) in replaced(calls[function]()):
                try:
                    result = _run(function, args, kwargs)
                    if isinstance(result, Iterator):
                        next(result, None)
                except Exception as error:
                    if leaves(error):
                        found.append(f"{name}({what}): {_said(error)}")
    return found


def main(room: str) -> None:
    """Print which calls of a room leave an array."""
    if not numba.config.BOUNDSCHECK:
        raise SystemExit("NUMBA_BOUNDSCHECK=1 must be set")
    table, names = import_module(f"tests.hostile.calls.{room}"), public(room)
    os.environ.update(getattr(table, "ENVIRONMENT", {}))
    valid = calls(room)
    swept = {thing: names[thing] for thing in valid}
    with tempfile.TemporaryDirectory() as folder, chdir(folder), unchecked(), quiet():
        found = sweep_fields(valid, swept)
        others = sweep(valid, swept) + sweep_huge(valid, swept)
    print(*found, *(line for line in others if line.endswith(OUTSIDE)), sep="\n", end="")


if __name__ == "__main__":
    main(sys.argv[1])

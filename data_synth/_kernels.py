"""Kernels of the worlds: functions that numba compiles, and keeps compiled where it can.

Worlds may not import the library's own decorator, which says more.
"""

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

__all__: tuple[str, ...] = ()  # for the worlds alone

_ADVICE = "what numba compiles is lost with the process: let NUMBA_CACHE_DIR name a folder for it"


class _Kept(FunctionCache):
    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn(f"{error.strerror}: {_ADVICE}")


def kernel(**options: Any) -> Callable[[Callable], Callable]:
    """Return a decorator with options of ``numba.njit``; where nothing can be kept it warns."""

    def decorated(function: Callable) -> Callable:
        made = njit(**options)(function)
        try:
            made._cache = _Kept(function)  # as `cache=True` does with numba's own class
        except RuntimeError:  # there is no place
            _warn(f"no folder can be written: {_ADVICE}")
        return made

    return decorated


@cache
def _warn(text: str) -> None:
    warnings.warn(text, RuntimeWarning, stacklevel=1)

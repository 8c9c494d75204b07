"""Kernels: functions that numba compiles, and keeps compiled where it finds a place for that."""

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

ADVICE = "what numba compiles is lost with the process: let NUMBA_CACHE_DIR name a folder for it"


class Kept(FunctionCache):
    """Compiled code on the disk; a disk that takes no more of it is no error."""

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write what was compiled for some types of arguments."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn(f"{error.strerror}: {ADVICE}")


def kernel(**options: Any) -> Callable[[Callable], Callable]:
    """Return a decorator that compiles a function when it is called, and keeps what was compiled.

    Numba keeps it in ``NUMBA_CACHE_DIR``, beside the module or in the user's own cache. Where none
    of these can be written, in a read-only installation without a home, each process compiles
    anew, and a warning says so.

    Parameters
    ----------
    options
        As of ``numba.njit``.
    """

    def decorated(function: Callable) -> Callable:
        made = njit(**options)(function)
        try:
            made._cache = Kept(function)  # as `cache=True` does with numba's own class
        except RuntimeError:  # there is no place
            _warn(f"no folder can be written: {ADVICE}")
        return made

    return decorated


@cache
def _warn(text: str) -> None:
    """Warn, once in a process."""
    warnings.warn(text, RuntimeWarning, stacklevel=1)

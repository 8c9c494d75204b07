"""Many independent runs: one generator each, on whatever workers the caller provides."""

import os
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from explorables.progress import progress
from studies import checks

try:
    from joblib import Parallel, delayed
    from joblib.parallel import BACKENDS, DEFAULT_BACKEND, get_active_backend
except ModuleNotFoundError as error:
    text = f"This needs {error.name}: pip install 'robot-perception[book]'"
    raise ModuleNotFoundError(text, name=error.name) from error

WORKERS = "STUDIES_WORKERS"
"""Environment variable: number of processes for a caller that has chosen no backend."""


def sweep(
    task: Callable[..., Any], items: Iterable[Any], *, rng: np.random.Generator, desc: str = ""
) -> list[Any]:
    """Return ``[task(item, rng=own) for item in items]``, each item with a generator of its own.

    The generators are spawned by item, not by worker, so that the result does not depend on how
    many processes there are. Where the work is done is the caller's choice, by joblib's
    ``parallel_config``: processes of this machine, Dask (``backend="dask"``) or Ray
    (``backend="ray"``). Without one, the environment variable ``STUDIES_WORKERS`` gives
    the number of local processes, and without that there is one.

    Parameters
    ----------
    task
        Function of an item and ``rng``. For other processes it must be importable, and so must be
        what it returns.
    items
        The items, in order.
    rng
        Source of the items' generators.
    desc
        What is shown beside the progress.

    Raises
    ------
    ValueError
        If ``STUDIES_WORKERS`` is no whole number other than 0.
    """
    if not callable(task):
        raise TypeError(f"task must be callable, got {checks.shown(task)}")
    items = list(checks.iterable("items", items))
    checks.instance("rng", rng, np.random.Generator)
    checks.instance("desc", desc, str)
    work = zip(items, rng.spawn(len(items)), strict=True)
    # the bar counts items that are handed out: not every backend can report those that are done
    bar = progress(work, desc, len(items))
    return Parallel(n_jobs=_workers())(delayed(task)(item, rng=own) for item, own in bar)


def _workers() -> int | None:
    """Return the number of processes if the caller chose no backend, else ``None``."""
    said = os.environ.get(WORKERS, "").strip()
    backend, n_jobs = get_active_backend()
    chosen = (
        n_jobs is not None
        or backend.nesting_level
        or type(backend) is not BACKENDS[DEFAULT_BACKEND]
    )
    if not said or chosen:
        return None
    if not said.lstrip("-").isdigit() or int(said) == 0:
        raise ValueError(f"{WORKERS} must be a whole number other than 0, got {said!r}")
    return int(said)

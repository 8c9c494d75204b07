"""Workers of a sweep: processes of this machine, Dask or Ray."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

SAFE_PATH = "PYTHONSAFEPATH"
_OPTIONS = (
    click.option("--workers", type=int, metavar="N", help="Work in N processes (-1: every core)."),
    click.option("--dask", metavar="ADDRESS", help="Work on the Dask cluster of this scheduler."),
    click.option(
        "--ray", metavar="ADDRESS", help="Work on this Ray cluster ('local' starts one here)."
    ),
)


def with_workers(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that say where the work is done; see :func:`working`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@contextmanager
def working(workers: int | None, dask: str | None, ray: str | None) -> Iterator[None]:
    """Let every sweep inside work on so many processes, on a Dask cluster or on Ray.

    What lies in the current folder is no module of the processes that start here.

    Raises
    ------
    click.UsageError
        If more than one of Dask and Ray is named, the number is 0, or the cluster's package is not
        installed.
    """
    from joblib import parallel_config

    if workers == 0:
        raise click.UsageError("--workers must not be 0")
    if dask and ray:
        raise click.UsageError("--dask and --ray exclude each other")
    if dask:
        with _needed():
            from dask.distributed import Client
        with Client(dask), parallel_config("dask", n_jobs=workers or -1):
            yield
    elif ray:
        with _needed():
            from ray import init, shutdown
            from ray.util.joblib import register_ray
        init(address=ray, log_to_driver=False)
        register_ray()
        try:
            with parallel_config("ray", n_jobs=workers or -1):
                yield
        finally:
            shutdown()
    elif workers:
        with _safe_path(), parallel_config("loky", n_jobs=workers):
            yield
    else:
        with _safe_path():
            yield


@contextmanager
def _safe_path() -> Iterator[None]:
    """Keep the current folder out of the path of the processes that start inside."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        del os.environ[SAFE_PATH]
        if before is not None:
            os.environ[SAFE_PATH] = before


@contextmanager
def _needed() -> Iterator[None]:
    """Name the extra if an import inside fails; errors of the work itself are none of this."""
    try:
        yield
    except ImportError as error:
        raise click.UsageError(
            f"{error.name} is not installed: pip install 'robot-perception[cluster]'"
        ) from error

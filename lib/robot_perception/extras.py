"""Hints on what to install where a package is missing that the base does without."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, requires
from importlib.util import find_spec

NAMES = {"cv2": "opencv-python-headless", "PIL": "pillow", "yaml": "pyyaml"}
"""Name to install, where it differs from the name to import."""


def extra_of(package: str) -> str:
    """Return the extra that brings a package; the book's holds the others and what is in none."""
    try:
        lines = requires("robot-perception") or ()
    except PackageNotFoundError:  # run from its folder
        lines = ()
    name = re.escape(NAMES.get(package, package))
    found = (re.match(rf"{name}\W.*extra == .(\w+)", line) for line in lines)
    return min({match[1] for match in found if match} - {"book"}, default="book")


def advice(missing: str | None) -> str | None:
    """Return what to install for a module that cannot be found; nothing for one of our own."""
    package = str(missing).partition(".")[0]
    if package in ("robot_perception", "explorables", "studies", "data_synth"):
        return None
    return f"This needs {package}: pip install 'robot-perception[{extra_of(package)}]'"


def need(*packages: str) -> None:
    """Raise ``ModuleNotFoundError``, naming the extra, unless all packages are there.

    It looks for them without importing them, which would take long.
    """
    for package in packages:
        if find_spec(package) is None:
            raise ModuleNotFoundError(advice(package), name=package)


@contextmanager
def needing() -> Iterator[None]:
    """Name the extra if an import inside finds no package.

    Raises
    ------
    ModuleNotFoundError
        In place of the one inside; the message says what to install.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        text = advice(error.name)
        if text is None:
            raise
        raise ModuleNotFoundError(text, name=error.name, path=error.path) from error

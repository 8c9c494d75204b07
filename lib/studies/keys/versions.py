"""Versions of the packages that compute, recorded beside what they gave.

They are no part of a key: a reader has others, and so has another Python of our own constraints.
What is stored is shown all the same and says what it was computed with; ``store --keys`` computes
some of it anew where the packages are others.
"""

from functools import cache
from importlib.metadata import PackageNotFoundError, version

from studies.project import project


@cache
def _version(library: str) -> str | None:
    try:
        return version(library)
    except PackageNotFoundError:  # one may have another build of it
        return None


def installed() -> dict[str, str]:
    """Return the versions of these packages that are installed here, by name."""
    found = {library: _version(library) for library in project().libraries}
    return {library: number for library, number in found.items() if number is not None}


def here() -> str:
    """Return the versions of these packages that are installed here as they are recorded."""
    return ", ".join(f"{library} {number}" for library, number in installed().items())


def differing(recorded: str) -> str:
    """Return in words which packages are others here than those recorded; empty if none is.

    Examples
    --------
    >>> differing(here())
    ''
    """
    known = dict(part.split() for part in recorded.split(", ") if part)
    return ", ".join(
        f"{library} {known.get(library, 'of an unknown version')} (here {number})"
        for library, number in installed().items()
        if known.get(library) != number
    )

"""The project that studies belong to: where its pages and records lie, and whose code counts.

A book says it once, where its package is imported::

    import studies

    studies.use(studies.Project(packages=("mine",), notebooks=lambda: Path("book")))

Without a project a study can be run and its rows are recorded below the current folder; what they
depend on is then the module that declares it alone.
"""

import os
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol


class Data(Protocol):
    """Data sets of real recordings, found by name."""

    def names(self) -> Collection[str]:
        """Return the names of all data sets."""

    def find(self, name: str) -> Path | None:
        """Return the folder of a data set, ``None`` if it is not on this computer."""

    def path(self, name: str) -> Path:
        """Return the folder of a data set, or raise an error that says how to get it."""

    def digest(self, name: str) -> str | None:
        """Return a hash of a data set; ``None`` if it is not the known one, whole."""


class NoData:
    """The data sets of a project that has none."""

    def names(self) -> Collection[str]:
        """Return no name."""
        return ()

    def find(self, name: str) -> Path | None:
        """Find nothing."""
        return None

    def path(self, name: str) -> Path:
        """Raise ``FileNotFoundError``."""
        raise FileNotFoundError(f"no data set {name!r}: the project has none")

    def digest(self, name: str) -> str | None:
        """Know nothing."""
        return None


def _cache() -> Path:
    return Path(os.environ.get("STUDIES_CACHE") or Path.home() / ".cache" / "studies")


@dataclass(frozen=True, slots=True)
class Project:
    """Description of the project that studies belong to.

    Parameters
    ----------
    packages
        Those whose code results depend on, and pages.
    showing
        Of these, what shows what others compute: no result depends on it.
    worlds
        Packages that say what is tried: a registration of a claim holds their text.
    notebooks
        Returns the folder of the notebooks.
    modules
        Above the modules that are the study cells of notebooks, with a dot at the end.
    records
        Returns the folder of what is recorded.
    cache
        Returns the folder of what this computer has computed before.
    reading_notebooks, reading_pages
        Modules whose importers read all notebooks, or all pages; empty for none.
    data
        Data sets of real recordings.
    command
        The command line by which results are stored anew; empty if there is none.
    libraries
        Distributions of others on whose code results depend.
    """

    packages: tuple[str, ...] = ()
    showing: tuple[str, ...] = ()
    worlds: tuple[str, ...] = ()
    notebooks: Callable[[], Path] = Path.cwd
    modules: str = "notebooks."
    records: Callable[[], Path] = lambda: Path.cwd() / "_data"
    cache: Callable[[], Path] = _cache
    reading_notebooks: str = ""
    reading_pages: str = ""
    data: Data = field(default_factory=NoData)
    command: str = ""
    libraries: tuple[str, ...] = ("numpy", "scipy")

    def storing(self, *what: str) -> str:
        """Return in words what stores a result anew."""
        if not self.command:
            return "storing it again"
        return f"`{' '.join((self.command, 'store', *what))}`"


_used = [Project()]


def use(given: Project) -> None:
    """Let all studies of this process belong to a project."""
    _used[0] = given


def project() -> Project:
    """Return the project that studies of this process belong to."""
    return _used[0]

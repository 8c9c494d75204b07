"""Description of this book for `studies`: folders of its pages and records, and its packages."""

import hashlib
from collections.abc import Collection
from pathlib import Path

import studies

BOOK = "robot_perception.book."
"""Above the modules that are the study cells of notebooks."""
CHAPTERS = "robot_perception.chapters"
CONTENTS = "robot_perception.teaching.pages.contents"
PACKAGE = Path(__file__).parent
ROOT = PACKAGE.parents[1]
"""The checkout: whatever book is built, its code and records are these."""


class Datasets:
    """The registered data sets, which are imported when one is asked for."""

    def names(self) -> Collection[str]:
        """Return the names of all registered data sets."""
        from robot_perception import datasets

        return datasets.registry()

    def find(self, name: str) -> Path | None:
        """Return the folder of a data set, ``None`` if it is not on this computer."""
        from robot_perception import datasets

        return datasets.find(name)

    def path(self, name: str) -> Path:
        """Return the folder of a data set.

        Raises
        ------
        robot_perception.datasets.DatasetMissing
            If it is not on this computer.
        """
        from robot_perception import datasets

        return datasets.path(name)

    def digest(self, name: str) -> str | None:
        """Return a digest of the registered hashes; ``None`` if the files have others."""
        from robot_perception import datasets

        if name not in datasets.registry():
            return None
        files = datasets.status(name)
        if any(item.state != "present" for item in files):
            return None
        named = "\n".join(f"{item.file.name} {item.file.sha256}" for item in files)
        return hashlib.sha256(named.encode()).hexdigest()[:16]


def notebooks() -> Path:
    """Return the folder of the notebooks: of the checkout, or shipped inside the package.

    Raises
    ------
    FileNotFoundError
        If neither exists.
    """
    for place in (ROOT / "book", PACKAGE / "_book"):
        if (place / "intro.md").exists() or (place.name == "_book" and place.is_dir()):
            return place
    raise FileNotFoundError("the notebooks are missing: they lie beside `lib`, or in the package")


def records() -> Path:
    """Return the folder of recorded results: of the checkout, or shipped inside the package.

    Raises
    ------
    FileNotFoundError
        If neither exists.
    """
    for folder in (ROOT / "book" / "_data", PACKAGE / "_data"):
        if folder.is_dir():
            return folder
    raise FileNotFoundError("the recorded results are missing; write them with `make reproduce`")


def cache() -> Path:
    """Return the folder of downloads, in which what was computed is kept, too."""
    from robot_perception.datasets.store import cache_directory

    return cache_directory()


studies.use(
    studies.Project(
        packages=("robot_perception", "data_synth"),
        showing=("robot_perception.teaching",),
        worlds=("data_synth", CHAPTERS),
        notebooks=notebooks,
        modules=BOOK,
        records=records,
        cache=cache,
        reading_notebooks=CHAPTERS,
        reading_pages=CONTENTS,
        data=Datasets(),
        command="robot-perception",
        libraries=("numpy", "numba", "scipy", "opencv-python-headless"),
    )
)

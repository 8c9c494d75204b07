"""Notebooks as modules: a package whose modules are the study cells of notebooks.

What ``from book.walls import corners`` gives a worker, a test, the command line or another notebook
is what a reader of ``walls.ipynb`` reads and edits. The cells that count are those with the tag
``study``: imports, constants and definitions, without output, and nothing that takes time. The
``__init__.py`` of the package ends with ``install(__name__)``.
"""

import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

from studies.keys.cells import folder, run, study_cells


class Notebooks(MetaPathFinder, Loader):
    """Finds and runs the study cells of notebooks.

    Parameters
    ----------
    package
        Name of the package whose modules they are.
    """

    def __init__(self, package: str) -> None:
        self._package = package

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where a module of the package comes from, if there is such a notebook."""
        package, _, stem = fullname.rpartition(".")
        if package != self._package:
            return None
        page = folder() / f"{stem}.ipynb"
        return ModuleSpec(fullname, self, origin=str(page)) if page.exists() else None

    def exec_module(self, module: ModuleType) -> None:
        """Run the cells in a module.

        Raises
        ------
        ImportError
            If the notebook has none.
        """
        page = folder() / f"{module.__name__.rpartition('.')[2]}.ipynb"
        cells = study_cells(page)
        if not cells:
            raise ImportError(f"{page.name} has no study cells", name=module.__name__)
        module.__file__ = str(page)
        run(cells, module.__dict__)


def install(package: str) -> None:
    """Let the modules of a package be notebooks of the project."""
    sys.meta_path.append(Notebooks(package))

"""The notebooks as modules: ``robot_perception.book.<stem>`` is the study cells of a chapter.

``from robot_perception.book.tutor_face import bridged`` gives a worker, a test, the command line or
another notebook what a reader of ``book/tutor_face.ipynb`` reads and edits. The cells that count
are those with the tag ``study``: imports, constants and definitions, without output, and nothing
that takes time.
"""

import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

from studies.keys.cells import folder, run, study_cells


class _Cells(MetaPathFinder, Loader):
    """Finds and runs the study cells of a notebook."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where a module of this package comes from, if there is such a notebook."""
        package, _, stem = fullname.rpartition(".")
        if package != __name__:
            return None
        page = folder() / f"{stem}.ipynb"
        return ModuleSpec(fullname, self, origin=str(page)) if page.exists() else None

    def exec_module(self, module: ModuleType) -> None:
        """Run the cells in a module.

        Raises
        ------
        ImportError
            If the notebook has none: a chapter in the form of a package.
        """
        page = folder() / f"{module.__name__.rpartition('.')[2]}.ipynb"
        cells = study_cells(page)
        if not cells:
            raise ImportError(f"{page.name} has no study cells", name=module.__name__)
        module.__file__ = str(page)
        run(cells, module.__dict__)


sys.meta_path.append(_Cells())

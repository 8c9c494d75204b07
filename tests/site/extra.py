"""Pages that are not in the book, built as the book is: pictures and films, words and bets."""

import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SHARED = ("_static", "_templates", "references.bib")


def build(name: str, folder: Path) -> Path:
    """Build a book of one page in a folder, with the book's own configuration.

    Parameters
    ----------
    name
        The notebook in this folder.
    folder
        An empty folder.

    Returns
    -------
    Path
        The page.
    """
    book = folder / "book"
    book.mkdir()
    for shared in SHARED:
        source = ROOT / "book" / shared
        (shutil.copytree if source.is_dir() else shutil.copy)(source, book / shared)
    shutil.copy(HERE / f"{name}.ipynb", book)
    (book / "_toc.yml").write_text(f"format: jb-book\nroot: {name}\n")
    options = ["--config", ROOT / "_config.yml", "--path-output", folder, "-W", "--keep-going"]
    jupyter_book = Path(sys.executable).with_name("jupyter-book")
    subprocess.run([jupyter_book, "build", book, *options], cwd=ROOT, check=True)
    return folder / "_build" / "html" / f"{name}.html"

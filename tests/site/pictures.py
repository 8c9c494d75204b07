"""A page that is not in the book: photographs, label images and films, built as the book is."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
NOTEBOOK = Path(__file__).with_suffix(".ipynb")
SHARED = ("_static", "_templates", "references.bib")


def build(folder: Path) -> Path:
    """Build a book of one page in a folder, with the book's own configuration.

    Parameters
    ----------
    folder
        An empty folder.

    Returns
    -------
    Path
        The page.
    """
    book = folder / "book"
    book.mkdir()
    for name in SHARED:
        source = ROOT / "book" / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, book / name)
    shutil.copy(NOTEBOOK, book)
    (book / "_toc.yml").write_text(f"format: jb-book\nroot: {NOTEBOOK.stem}\n")
    options = ["--config", ROOT / "_config.yml", "--path-output", folder, "-W", "--keep-going"]
    jupyter_book = Path(sys.executable).with_name("jupyter-book")
    subprocess.run([jupyter_book, "build", book, *options], cwd=ROOT, check=True)
    return folder / "_build" / "html" / f"{NOTEBOOK.stem}.html"

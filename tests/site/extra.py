"""Pages that are not in the book, built as the book is: pictures and films, words and bets."""

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext

from tests.site.browser import PATIENCE_MS, WINDOW
from tests.site.conftest import Visit

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


@contextmanager
def visits(browser: Browser, page: Path) -> Iterator[Callable[..., Visit]]:
    """Yield what opens a page from disk; keyword arguments go to the browser context."""
    contexts: list[BrowserContext] = []

    def make(**options: object) -> Visit:
        context = browser.new_context(**({"viewport": WINDOW} | options))
        context.set_default_navigation_timeout(PATIENCE_MS)
        contexts.append(context)
        visit = Visit(context.new_page(), (page.parent.as_uri(),))
        visit.page.goto(page.as_uri())
        visit.page.wait_for_load_state()
        return visit

    yield make
    for context in contexts:
        context.close()

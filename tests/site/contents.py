"""What the site must hold, read from the book's table of contents."""

from pathlib import Path

import yaml

BOOK = Path(__file__).parents[2] / "book"


def _listed() -> list[str]:
    contents = yaml.safe_load((BOOK / "_toc.yml").read_text())
    chapters = [chapter for part in contents["parts"] for chapter in part["chapters"]]
    parts = (
        page["file"] for chapter in chapters for page in (chapter, *chapter.get("sections", ()))
    )
    return [contents["root"], *parts]


PAGES = _listed()
"""Every page of the table of contents, without suffix."""

NOTEBOOKS = [name for name in PAGES if (BOOK / f"{name}.ipynb").exists()]
"""Those of them that are notebooks."""

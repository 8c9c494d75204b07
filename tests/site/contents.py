"""What the site must hold, read from the book's table of contents."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

BOOK = Path(__file__).parents[2] / "book"


def _listed() -> list[str]:
    contents = yaml.safe_load((BOOK / "_toc.yml").read_text())
    return [contents["root"], *(page for part in contents["parts"] for page in _below(part))]


def _below(entry: dict[str, Any]) -> Iterator[str]:
    for page in (*entry.get("chapters", ()), *entry.get("sections", ())):
        yield page["file"]
        yield from _below(page)


PAGES = _listed()
"""Every page of the table of contents, without suffix."""

NOTEBOOKS = [name for name in PAGES if (BOOK / f"{name}.ipynb").exists()]
"""Those of them that are notebooks."""

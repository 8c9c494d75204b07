"""Lists every word that a built site explains on pointing at it, with the words around it.

``python -m tests.tools.hovers build/_build/html`` prints word, page and sentence, to be read. A
word that means something else there gets ``pages`` or ``unlike`` in ``terms.toml``, and a line of
``tests/book/meanings.tsv``.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from bs4 import BeautifulSoup

AROUND = 100


def hovers(html: str) -> Iterator[tuple[str, str]]:
    """Yield the name of each word that a page marks, and its sentence with the word in brackets."""
    for word in BeautifulSoup(html, "html.parser").select("a.rp-term"):
        before = " ".join("".join(map(_text, [*word.previous_siblings][::-1])).split())
        after = " ".join("".join(map(_text, word.next_siblings)).split())
        place = word["href"].partition("#word-")[2]
        yield place, f"{before[-AROUND:]} [{word.get_text()}] {after[:AROUND]}"


def _text(node: object) -> str:
    return node.get_text() if hasattr(node, "get_text") else str(node)


if __name__ == "__main__":
    for page in sorted(Path(sys.argv[1]).glob("*.html")):
        for name, sentence in hovers(page.read_text("utf-8")):
            print(name, page.stem, sentence, sep="\t")

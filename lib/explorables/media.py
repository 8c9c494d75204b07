"""Objects that a notebook shows: one plain value with its representations."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

_MATHEMATICS = re.compile(r"(?<!\\)\$([^$]+)\$")


@dataclass(frozen=True, slots=True)
class Shown:
    """Something to show in a notebook, by media type.

    Parameters
    ----------
    bundle
        Representations by media type; ``text/plain`` is what a terminal prints and what a test
        compares.
    """

    bundle: Mapping[str, str]

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        return dict(self.bundle)

    def __repr__(self) -> str:
        return self.bundle.get("text/plain", "")


def with_mathematics(text: str) -> str:
    """Return a text as HTML; MathJax sets what stands between dollars."""
    return _MATHEMATICS.sub(r'<span class="math">\\(\1\\)</span>', escape(text, quote=False))


def data_element(kind: str, text: str) -> str:
    """Write JSON for a script of the page; a text in it can neither end nor nest the element."""
    text = text.replace("<", r"\u003c")
    return f'<script type="application/json" class="{kind}">{text}</script>'


def html_table(label: str, kind: str, head: str, rows: str) -> str:
    """Write a table that can be scrolled where it is wider than the page."""
    return (
        f'<div class="rp-table" role="region" tabindex="0" aria-label="{escape(label)}">'
        f'<table class="{kind}"><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )

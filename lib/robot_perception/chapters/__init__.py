"""The chapters: studies, figures, claims, exercises."""

from collections.abc import Iterator
from importlib import import_module
from types import ModuleType

from robot_perception.teaching.claims import Claim, unique

CHAPTERS = ("walls", "monobot", "anchored_slam")
"""Stems of the chapters, in the order of the book."""


def chapter(stem: str) -> ModuleType:
    """Return the package of a chapter.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    if stem not in CHAPTERS:
        raise ValueError(f"no chapter {stem!r}; the book has {', '.join(CHAPTERS)}")
    return import_module(f"{__name__}.{stem}")


def claims(chapters: Iterator[str] | tuple[str, ...] = CHAPTERS) -> tuple[Claim, ...]:
    """Return the claims of the chapters in the order of the book, each identifier once."""
    return unique(claim for stem in chapters for claim in chapter(stem).CLAIMS)

"""Drawings with their words: what is drawn on axes, and what it is called, in one place."""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from typing import Any

from explorables.figures.output import show
from explorables.figures.style import figure
from explorables.media import Shown

Words = str | Callable[..., str]


class Drawn:
    """A drawing that makes its own axes and says what it shows; use `drawn` to make one.

    Called with what it draws it returns notebook output; :meth:`on` draws on axes that are there.
    """

    def __init__(
        self,
        draw: Callable[..., Any],
        alt: Words,
        caption: Words | None,
        name: str | None,
        axes: Callable[..., tuple[Any, Any]],
    ) -> None:
        self.on = draw
        self._alt, self._caption, self._name, self._axes = alt, caption, name, axes
        update_wrapper(self, draw)

    def __call__(self, *args: Any, **kwargs: Any) -> Shown:
        """Draw on new axes and return the figure with its words."""
        fig, axes = self._axes(*args, **kwargs)
        self.on(axes, *args, **kwargs)

        def said(words: Words | None) -> str | None:
            return words(*args, **kwargs) if callable(words) else words

        return show(fig, alt=said(self._alt), caption=said(self._caption), name=self._name)


def drawn(
    *,
    alt: Words,
    caption: Words | None = None,
    name: str | None = None,
    axes: Callable[..., tuple[Any, Any]] | None = None,
    **size: Any,
) -> Callable[[Callable[..., Any]], Drawn]:
    """Give a function ``draw(axes, …)`` its words and its axes.

    Parameters
    ----------
    alt, caption, name
        As for `show`; the first two may be functions of what is drawn.
    axes
        Makes figure and axes of what is drawn, where those of `figure` do not serve.
    **size
        As for `figure`: numbers of rows and columns, width, height, …

    Examples
    --------
    >>> @drawn(alt="A line whose slope is the gain.", caption="One gain.", height=3.0)
    ... def line(ax, gain):
    ...     ax.plot([0, 1], [0, gain])
    >>> line(2.0)
    A line whose slope is the gain.
    """
    made = axes or (lambda *args, **kwargs: figure(**size))
    return lambda draw: Drawn(draw, alt, caption, name, made)

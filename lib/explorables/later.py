"""Places on a page for what a cell further down makes.

A chapter opens with its result; what computes it stands where it is explained. So the opening keeps
a place, ``later("turned-world")``, and after the definitions ``now("turned-world", TURNED)`` shows
there what they make. Whoever edits a definition and runs the cells again sees it in the opening.
"""

from typing import Any

from IPython.display import display, publish_display_data
from IPython.utils.capture import capture_output

from explorables.figures.output import on_page

OUTPUTS = 2
"""An explorer has two in a notebook: a picture, and the view that takes its place."""
EMPTY = "*A cell further down shows something here: run them all.*"


def later(name: str) -> None:
    """Keep a place for what `now` shows under this name."""
    first = {"text/markdown": EMPTY, "text/plain": EMPTY}
    for data, place in zip((first, {"text/plain": ""}), _places(name), strict=False):
        publish_display_data(data, transient={"display_id": place})


def now(name: str, shown: Any) -> None:
    """Show something in the place that `later` has kept, not here.

    Raises
    ------
    ValueError
        If it has more outputs than the place.
    """
    with capture_output(stdout=False, stderr=False) as seen:
        display(shown)
    places = _places(name)
    if len(seen.outputs) > len(places):
        raise ValueError(f"{name} has {len(seen.outputs)} outputs, its place takes {len(places)}")
    for output, place in zip(seen.outputs, places, strict=False):
        words = {"transient": {"display_id": place}, "update": True}
        publish_display_data(output.data, output.metadata, **words)


def _places(name: str) -> list[str]:
    """Return the identifiers of the outputs of a place: a page of the book has no views."""
    return [f"{name}-{k}" for k in range(1 if on_page() else OUTPUTS)]

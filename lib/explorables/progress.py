"""Progress of long work: a bar with the time that is left, on a terminal and in a notebook."""

import os
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

from tqdm import tqdm

Item = TypeVar("Item")
PAGE_VARIABLE = "EXPLORABLES_PAGE"
"""Environment variable that is 1 while the book is built: no kernel stands behind the output."""


def progress(items: Iterable[Item], desc: str = "", total: int | None = None) -> Iterator[Item]:
    """Return the items one by one, with a bar of those that were taken while they last.

    On a terminal it is a line, in a notebook a widget; elsewhere, on a page of the book and under
    test there is none. When the items end it is gone.

    Parameters
    ----------
    items
        What is worked on.
    desc
        What is shown beside the bar.
    total
        How many items there are, if they do not say so.
    """
    bar: Any = tqdm
    if _in_notebook():
        from tqdm.notebook import tqdm as bar
    return iter(bar(items, desc=desc, total=total, disable=None, leave=False))


def _in_notebook() -> bool:
    """Tell whether somebody sits in front of this kernel, with widgets."""
    if os.environ.get(PAGE_VARIABLE) == "1" or "PYTEST_VERSION" in os.environ:
        return False
    try:
        import ipywidgets  # noqa: F401
        from IPython import get_ipython
    except ModuleNotFoundError:
        return False
    return hasattr(get_ipython(), "kernel")

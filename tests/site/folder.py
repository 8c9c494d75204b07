"""What holds on a page that is opened from disk."""

from collections.abc import Iterable
from typing import Any

from tests.site import scorecard
from tests.site.browser import WINDOW
from tests.site.contents import NOTEBOOKS, PAGES
from tests.site.driver import PICTURE
from tests.site.served import download, not_the_notebook
from tests.site.visits import Check, Stage, Standing

FOLDER = Stage("from a folder", WINDOW)


def moved(at: Standing) -> list[dict[str, Any]]:
    """Move each explorer by a preset, or by a slider, and return what it showed."""
    return [_moved(at, root) for root in at.page.query_selector_all("div.explorer")]


def _moved(at: Standing, root: Any) -> dict[str, Any]:
    before = at.page.evaluate(PICTURE, root)["picture"]
    preset = root.query_selector(".rp-preset[aria-pressed=false]")
    control = root.query_selector("input[type=range]")
    if preset:
        preset.click()
    elif control:
        control.focus()
        at_end = control.input_value() == control.get_attribute("max")
        at.page.keyboard.press("Home" if at_end else "End")
    seen = at.page.evaluate(PICTURE, root)
    still = bool(preset or control) and seen["picture"] == before
    return {"name": root.get_attribute("id"), "complaint": seen["complaint"], "still": still}


def unmoved(explorers: Iterable[dict[str, Any]]) -> list[str]:
    """Say which explorers complain or do not move."""
    return [
        f"{found['name']}: {found['complaint'] or 'nothing moves the picture'}"
        for found in explorers
        if found["complaint"] or found["still"]
    ]


VISITED = [name for name in PAGES if name in {*NOTEBOOKS, PAGES[0]}]
CHECKS = (
    Check("claim that is linked to", (FOLDER,), scorecard.linked, pages=scorecard.PAGES),
    Check("explorers", (FOLDER,), moved, unmoved),
    Check("console", (FOLDER,), lambda at: at.visit.errors),
    Check("other hosts", (FOLDER,), lambda at: at.visit.strangers),
    Check("download", (FOLDER,), download, not_the_notebook, NOTEBOOKS),
)

"""What holds on a page in a browser that runs no scripts."""

from collections.abc import Mapping
from typing import Any

from explorables.sphinx_extension import SCRIPTED as CONTROLS
from robot_perception.teaching.sphinx_extension import SCRIPTED
from tests.site import scorecard
from tests.site.browser import WINDOW
from tests.site.contents import NOTEBOOKS, PAGES
from tests.site.measures import EQUATIONS, SOURCE, UNSET
from tests.site.served import needs_scripts
from tests.site.visits import Check, Stage, Standing, unless

UNSCRIPTED = Stage("without scripts", WINDOW)
WITH_FORMULAS = ("monobot", "anchored_slam", "notation", "references", "library/slam")


def pictures(at: Standing) -> dict[str, Any]:
    """Return how many explorers there should be, and what is seen of each."""
    found = [_picture(root) for root in at.page.query_selector_all("div.explorer")]
    return {"expected": at.html.count('<div class="explorer"'), "found": found}


def _picture(root: Any) -> dict[str, Any]:
    picture = root.query_selector(".rp-canvas > *")
    return {
        "name": root.get_attribute("id"),
        "visible": picture.is_visible(),
        "alt": picture.get_attribute("aria-label") or picture.get_attribute("alt") or "",
        "inputs": len(root.query_selector_all("input")),
    }


def not_the_default(fact: Mapping[str, Any]) -> list[str]:
    """Say which explorers have no picture with its words, or controls that do nothing."""
    wrong = unless(len(fact["found"]) == fact["expected"], f"not {fact['expected']} explorers")
    for found in fact["found"]:
        sound = {
            "no picture": found["visible"],
            f"alternative text {found['alt']!r}": len(found["alt"]) >= 20,
            "controls": not found["inputs"],
        }
        wrong += [f"{found['name']}: {words}" for words, holds in sound.items() if not holds]
    return wrong


def says_so(at: Standing) -> list[str]:
    """Say if a page with controls does not say why they are missing."""
    controls = any(word in at.html for word in (*CONTROLS, SCRIPTED))
    return unless(bool(needs_scripts(at)) == controls, "a reader is not told why, or without need")


def formulas(at: Standing) -> list[str]:
    """Return formulas without a size or a place, and texts with LaTeX."""
    none = unless(at.page.locator(".math").count() > 0, "no formula")
    return [
        *none,
        *(words for each in (UNSET, SOURCE, EQUATIONS) for words in at.page.evaluate(each)),
    ]


VISITED = [name for name in PAGES if name in {*NOTEBOOKS, *WITH_FORMULAS}]
CHECKS = (
    Check("explorers", (UNSCRIPTED,), pictures, not_the_default, NOTEBOOKS),
    Check("words to who has no scripts", (UNSCRIPTED,), says_so),
    Check("formulas", (UNSCRIPTED,), formulas, pages=WITH_FORMULAS),
    Check("cards", (UNSCRIPTED,), scorecard.unscripted, pages=scorecard.PAGES),
)

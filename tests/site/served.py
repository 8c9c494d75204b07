"""What holds on a page that is served: in both themes, in a window, on a telephone, on paper."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from robot_perception.chapters import CHAPTERS
from tests.site import scorecard
from tests.site.accessibility import serious, violations
from tests.site.browser import TELEPHONE, WINDOW
from tests.site.contents import BOOK, NOTEBOOKS, PAGES
from tests.site.driver import Driver, drivers
from tests.site.measures import (
    ALIGNED,
    COLUMNS,
    EQUATIONS,
    LETTERS_IN_PRESETS,
    ROWS,
    SIDEWAYS,
    SMALLEST_PX,
    TOGETHER,
    TOPS,
    WIDE_ELEMENTS,
)
from tests.site.visits import Check, Stage, Standing, script, unless

DARK = Stage("dark", WINDOW, "dark")
LIGHT = Stage("window", WINDOW)
PHONE = Stage("telephone", TELEPHONE)
DARK_PHONE = Stage("dark telephone", TELEPHONE, "dark")
PAPER = Stage("paper", WINDOW, "dark", "print")
A4 = Stage("A4", {"width": 718, "height": 1000}, "dark", "print")
END = Stage("end", WINDOW, "dark")
STAGES = (DARK, LIGHT, PHONE, DARK_PHONE, PAPER, A4, END)
"""A page is opened in the dark: what is dark from the start is not what is made dark later."""

SILENCE_MS = 1100
MOST_ROWS = 7
MOST_FOLDS = 8
WHOLE = ".bd-article :is(.rp-table, div.math, mjx-container[display='true'])"
CODE = ".bd-article div.highlight pre"


def theme(at: Standing) -> list[str]:
    """Return the theme that a page should have, and the one it has."""
    return [at.stage.shown, at.page.evaluate("document.documentElement.dataset.theme")]


def other_theme(themes: Iterable[str]) -> list[str]:
    """Say if two themes differ."""
    asked, found = themes
    return unless(asked == found, f"{found} in place of {asked}")


def sideways(at: Standing) -> list[str]:
    """Say which tables and formulas are not whole; in a window which code, too."""
    if at.stage == PHONE:
        return at.page.evaluate(SIDEWAYS, WHOLE)
    switches = at.page.locator(".rp-all-code").all()
    for switch in switches:
        switch.click()
    wide = at.page.evaluate(SIDEWAYS, f"{WHOLE}, {CODE}")
    for switch in switches:
        switch.click()
    return wide


def too_long(rows: Iterable[int]) -> list[str]:
    """Say which tables cannot be taken in at a glance."""
    return [f"{count} rows outside of a fold" for count in rows if count > MOST_ROWS]


def letters(at: Standing) -> list[str]:
    """Return what is wrong with letters; cards beside each other are thumbnails."""
    found = at.page.evaluate(LETTERS_IN_PRESETS, SMALLEST_PX)
    thumbnails = at.name == PAGES[0] and at.stage == LIGHT
    return [words for words in found if not (thumbnails and words.endswith("px"))]


def not_in_a_line(rows: Iterable[list[int]]) -> list[str]:
    """Say which drawings of a row do not stand beside each other."""
    return [f"a row of drawings begins at {tops}" for tops in rows if len(set(tops)) != 1]


def not_one_under_the_other(rows: Iterable[list[int]]) -> list[str]:
    """Say which drawings of a row do not stand in a column, in their order."""
    wrong = (tops for tops in rows if len(set(tops)) == 1 or tops != sorted(tops))
    return [f"drawings stand at {tops}" for tops in wrong]


def too_high(explorers: Iterable[Mapping[str, Any]]) -> list[str]:
    """Say which explorers are not seen together with their controls."""
    return [
        f"{found['name']} is {found['height']:.0f} px high"
        for found in explorers
        if found["height"] > WINDOW["height"]
    ]


def driven(at: Standing) -> dict[str, Any]:
    """Drive every explorer of a page: how many there should be, and what each was like."""
    found = drivers(at.page)
    for driver in found:
        driver.drive_all()
        driver.drive(driver.controls[0])
    at.page.wait_for_timeout(SILENCE_MS)
    for driver in found:
        silent = [told for told in driver.settings() if told not in driver.status()]
        driver.demand(not silent, f"a move is not announced: {', '.join(silent)}")
    return {"expected": at.html.count('<div class="explorer"'), "driven": list(map(_facts, found))}


def badly_driven(fact: Mapping[str, Any]) -> list[str]:
    """Say what was wrong with explorers, and if some are missing."""
    expected, found = fact["expected"], fact["driven"]
    missing = unless(len(found) == expected, f"{len(found)} of {expected} explorers")
    return [*missing, *badly_moved(found)]


def badly_moved(explorers: Iterable[Mapping[str, Any]]) -> list[str]:
    """Say what was wrong with explorers."""
    return [f"{found['name']}: {words}" for found in explorers for words in found["wrong"]]


def _facts(driver: Driver) -> dict[str, Any]:
    return {
        "name": driver.name,
        "controls": len(driver.controls),
        "states": driver.states,
        "wrong": driver.wrong,
    }


def dragged(at: Standing) -> dict[str, Any]:
    """Drag every point: how many there should be, and what each was like."""
    found = [driver for driver in drivers(at.page) if driver.grip]
    for driver in found:
        driver.drag()
    return {"expected": at.html.count('"drag": {'), "driven": list(map(_facts, found))}


def played(at: Standing) -> list[dict[str, Any]]:
    """Play every timeline."""
    at.page.emulate_media(reduced_motion="no-preference")
    found = drivers(at.page)
    for driver in found:
        for control in driver.root.query_selector_all(".rp-timeline"):
            driver.play(control)
    return list(map(_facts, found))


def posters(at: Standing) -> list[dict[str, bool]]:
    """Return which posters of films hold drawings, and which are dark as far as they do."""
    return at.page.eval_on_selector_all(
        ".rp-film .rp-key:not([hidden]) img",
        """images => images.map(img => ({
          drawn: !!img.closest(".rp-drawing, .rp-shaded"),
          dark: /invert|url/.test(getComputedStyle(img).filter),
        }))""",
    )


def of_another_theme(posters: Iterable[Mapping[str, bool]]) -> list[str]:
    """Say which posters are not dark though they are drawings, or photographs and dark."""
    words = {True: "a drawing is not dark", False: "a photograph is dark"}
    return [words[found["drawn"]] for found in posters if found["drawn"] != found["dark"]]


def on_paper(at: Standing) -> dict[str, Any]:
    """Return what is seen of a page on paper."""
    roots = at.page.query_selector_all("div.explorer")
    for root in roots:  # it may be drawn anew
        root.wait_for_selector(".rp-canvas > *", state="visible")
    return {
        "buttons of the header": at.page.locator(".article-header-buttons:visible").count(),
        "controls": at.page.locator("div.explorer .rp-controls:visible").count(),
        "titles": at.page.locator("h1:visible").count(),
    }


def unlike_paper(seen: Mapping[str, int]) -> list[str]:
    """Say what is on paper that should not be, and if there is not one title."""
    wanted = {"buttons of the header": 0, "controls": 0, "titles": 1}
    return [f"{seen[name]} {name}" for name, count in wanted.items() if seen[name] != count]


def folds(at: Standing) -> list[str]:
    """Return the words of buttons that unfold, as far as they can be seen."""
    return at.page.locator("details.hide > summary:visible").all_inner_texts()


def all_code(at: Standing) -> list[str]:
    """Press the switch that shows all code, twice; say what it does not do."""
    switch, wrong = at.page.locator(".rp-all-code"), []
    held = at.page.locator("div.cell.tag_hide-input:not(.tag_fold) > details.hide")
    few = len(folds(at))
    wrong += unless(few <= MOST_FOLDS, f"{few} folds to a reader who asked for none")
    if held.count() == 0:
        return wrong + unless(switch.count() == 0, "a switch without code")
    wrong += unless(held.locator("visible=true").count() == 0, "code is seen unasked")
    for pressed in ("true", "false"):
        switch.click()
        shown = at.page.locator("div.cell.tag_hide-input:not(.tag_fold) > details[open]:visible")
        wanted = held.count() if pressed == "true" else 0
        wrong += unless(shown.count() == wanted, f"{shown.count()} of {wanted} cells are open")
        told = switch.get_attribute("aria-pressed")
        wrong += unless(told == pressed, f"the switch says {told}")
    return wrong


def needs_scripts(at: Standing) -> list[str]:
    """Return what a page says of scripts that do not run."""
    found = at.page.get_by_text("controls need scripts").all()
    return [words.inner_text() for words in found if words.is_visible()]


def bibliography(at: Standing) -> list[str]:
    """Say which mathematics of the bibliography is not set."""
    text = at.page.locator(".bd-article").inner_text()
    count = at.page.locator(".citation mjx-container").count()
    return [*unless(count > 0, "no formula"), *unless("$" not in text, "a dollar")]


def errata(at: Standing) -> list[str]:
    """Say what has to be moved sideways, and which erratum names no claim."""
    held = """() => [...document.querySelectorAll(".bd-article *")].filter(
      (box) => box.clientWidth && box.scrollWidth > box.clientWidth + 1
        && getComputedStyle(box).overflowX !== "visible" && !box.closest(".math")
    ).map((box) => box.outerHTML)"""
    unclaimed = """() => [
      ...document.querySelectorAll(".bd-article section section:has(> h2)")
    ].filter(
      (erratum) => !erratum.querySelector("a[href^='scorecard.html#']")
    ).map((erratum) => `${erratum.id} names no claim`)"""
    some = unless(at.page.locator(".bd-article section section > h2").count() > 0, "no erratum")
    return at.page.evaluate(held) + at.page.evaluate(unclaimed) + some


def download(at: Standing) -> list[bool]:
    """Return whether the download button hands over the notebook: its name, and its content."""
    at.page.click(".dropdown-download-buttons button")
    with at.page.expect_download() as download:
        at.page.click(".dropdown-download-buttons a[href$='.ipynb']")
    name = f"{at.name}.ipynb"
    found = Path(download.value.path()).read_bytes()
    return [download.value.suggested_filename == name, found == (BOOK / name).read_bytes()]


def not_the_notebook(same: Iterable[bool]) -> Iterator[str]:
    """Say what of a download differs."""
    for part, holds in zip(("name", "content"), same, strict=True):
        yield from unless(holds, f"another {part}")


def explained(at: Standing) -> list[str]:
    """Say what is wrong with the first word that is explained: on focus, on pointing, on a tap."""
    word, note = at.page.locator("a.rp-term").first, at.page.locator("#rp-says")
    wrong = []
    word.scroll_into_view_if_needed()
    word.focus()
    wrong += unless(note.is_visible(), "no note on focus")
    wrong += unless(bool(note.inner_text().strip()), "the note is empty")
    named = word.get_attribute("aria-describedby") == "rp-says"
    wrong += unless(named, "the word does not name its note")
    box = note.bounding_box() or {"x": -1, "width": 0}
    inside = box["x"] >= 0 and box["x"] + box["width"] <= at.stage.window["width"]
    wrong += unless(inside, "the note is not whole in the window")
    at.page.keyboard.press("Escape")
    wrong += unless(not note.is_visible(), "a note after Escape")
    word.evaluate("word => word.blur()")
    word.hover()
    note.wait_for(state="visible", timeout=2000)
    at.page.mouse.move(0, 0)
    note.wait_for(state="hidden", timeout=2000)
    word.dispatch_event("pointerdown", {"pointerType": "touch"})
    before = at.page.url
    word.evaluate("word => word.click()")
    wrong += unless(note.is_visible(), "no note on a tap")
    wrong += unless(at.page.url == before, "the first tap leaves the page")
    at.page.keyboard.press("Escape")
    return wrong


def axe(at: Standing) -> list[dict[str, Any]]:
    """Return what axe finds in the theme of the stage."""
    return violations(at.page, at.stage.theme)


CHECKS = (
    Check("theme", (DARK, LIGHT, PHONE, DARK_PHONE, PAPER, END), theme, other_theme),
    Check("axe", (DARK, LIGHT), axe, serious),
    Check("posters", (DARK,), posters, of_another_theme, [*NOTEBOOKS, PAGES[0]]),
    Check("all code", (LIGHT, PHONE), all_code, pages=NOTEBOOKS),
    Check("words to who has no scripts", (LIGHT,), needs_scripts),
    Check("equations in the middle", (LIGHT, PHONE), script(EQUATIONS)),
    Check("words of tables at the left", (LIGHT,), script(ALIGNED)),
    Check("nothing moved sideways", (LIGHT, PHONE), sideways, pages=NOTEBOOKS),
    Check("rows of tables", (LIGHT,), script(ROWS), too_long, NOTEBOOKS),
    Check("drawings in a line", (LIGHT,), script(TOPS), not_in_a_line, NOTEBOOKS),
    Check("drawings in a column", (PHONE,), script(TOPS), not_one_under_the_other, NOTEBOOKS),
    Check("picture and controls together", (LIGHT,), script(TOGETHER), too_high, NOTEBOOKS),
    Check("fits the window", (PHONE, DARK_PHONE), script(WIDE_ELEMENTS)),
    Check("letters", (LIGHT, PHONE), letters, pages=[*NOTEBOOKS, PAGES[0]], moves=True),
    Check("explorers", (LIGHT,), driven, badly_driven, NOTEBOOKS, moves=True),
    Check("points", (LIGHT, PHONE), dragged, badly_driven, NOTEBOOKS, moves=True),
    Check("timelines", (LIGHT,), played, badly_moved, NOTEBOOKS, moves=True),
    Check("words", (LIGHT, PHONE), explained, pages=CHAPTERS, moves=True),
    Check("bibliography", (LIGHT,), bibliography, pages=("references",)),
    Check("errata", (PHONE,), errata, pages=("errata",)),
    *scorecard.served(LIGHT, PHONE),
    Check("paper", (PAPER,), on_paper, unlike_paper),
    Check("columns on paper", (A4,), script(COLUMNS), pages=NOTEBOOKS),
    Check("buttons on paper", (A4,), folds, pages=NOTEBOOKS),
    Check("console", (END,), lambda at: at.visit.errors),
    Check("other hosts", (END,), lambda at: at.visit.strangers),
    Check("download", (END,), download, not_the_notebook, NOTEBOOKS),
)
"""In the order in which they are made in a stage; a download looks to the browser like an error."""

PLAIN = tuple(c for c in CHECKS if c.name in ("theme", "axe", "console", "other hosts"))
"""What holds on pages, too, that are no page of the book."""
